//! Scenes of lights, and everything that lights them.
//!
//! A [`Scene`] is read from JSON (`scene`) and converted in double precision to the [`Frame`], the
//! fragments of its picture, and the [`Upload`], its lights and materials in `f32`, as a shader
//! gets them. A shader lights the fragments on some backend; the `reference` lights them in `f64`
//! from the same bits.

pub mod accuracy;
pub mod bind;
pub mod culling;
pub mod frame;
pub mod picture;
pub mod plan;
pub mod reference;
pub mod render;
pub mod sample;
pub mod scene;
pub mod shading_f32;
mod splitmix64;
pub mod upload;

pub use frame::{Fragment, Frame, FrameOptions, VertexNormals};
pub use scene::Scene;
pub use upload::Upload;
