//! The lighting models in compiled `f32` Rust, as in a CPU renderer.
//!
//! Reads an [`Upload`](super::Upload) and the fragments of a [`Frame`](super::Frame); executes the
//! plans of [`culling`](super::culling). [`seed`] is the arithmetic of the published shaders,
//! [`robust`] the same model in more accurate and faster forms; both add the lights in the order of
//! their indices, so that dropping a light with a contribution of exactly zero changes no bit. `wide`
//! is `robust` for several fragments at once, bit for bit.

mod execute;
mod lights;
mod model;
pub mod robust;
pub mod seed;
mod surface;
mod wide;
mod work;

pub use execute::{Form, Shaded, execute, shade_all};
pub use lights::{Directional, Lights, Point, Spot, TermColors};
pub use model::{ConeTerm, Model, Terms};
pub use robust::Gates;
pub use surface::{Power, Surface, surface, surfaces};
pub use work::{Tally, Work};
