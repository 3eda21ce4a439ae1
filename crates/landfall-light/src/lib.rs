//! Scenes of lights: what a shader's buffers are for.
//!
//! A [`Scene`] is read from JSON (`scene`) and made two things in double precision: the
//! [`Frame`], the fragments of its picture, and the [`Upload`], its lights and materials as a
//! shader gets them, in `f32`. A shader lights the fragments on some reader; the `reference`
//! does it in `f64` from the same bits.

pub mod accuracy;
pub mod bind;
pub mod compiled;
pub mod frame;
pub mod picture;
pub mod plan;
pub mod reference;
pub mod render;
pub mod sample;
pub mod scene;
pub mod skip;
mod splitmix64;
pub mod upload;

pub use frame::{Fragment, Frame, FrameOptions, VertexNormals};
pub use scene::Scene;
pub use upload::Upload;
