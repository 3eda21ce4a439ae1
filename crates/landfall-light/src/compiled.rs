//! The lighting models in `f32` Rust, as a renderer on the CPU would compile them.
//!
//! Reads an [`Upload`](super::Upload) and the fragments of a [`Frame`](super::Frame); executes
//! the plans of [`skip`](super::skip), which it is measured with. [`seed`] is the arithmetic of
//! the published shaders, [`robust`] the same model in forms that err less and cost less; both
//! add the lights in the order of their numbers, so that a light that gives exactly zero may be
//! left out without changing a bit.

mod execute;
mod lights;
mod model;
pub mod robust;
pub mod seed;
mod surface;
mod work;

pub use execute::{Form, Shaded, execute, shade_all};
pub use lights::{Directional, Emission, Lights, Point, Spot};
pub use model::{AmbientTerm, ConeTerm, Model, ReflectanceTerm, SpecularTerm, Terms};
pub use robust::Gates;
pub use surface::{Power, Surface, surface, surfaces};
pub use work::{Tally, Work};
