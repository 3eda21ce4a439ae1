//! Scenes of lights, and everything that lights them.
//!
//! A [`Scene`] is read from JSON (`scene`) and converted in double precision to the [`Frame`], the
//! fragments of its picture, and the [`Upload`], its lights and materials in `f32`, as a shader
//! gets them. A shader lights the fragments on some backend; the `reference` lights them in `f64`
//! from the same bits.
//!
//! Public signatures name vectors and matrices of glam (`DVec2`, `DVec3`, `DMat3`, `DMat4`,
//! `Vec3`), and `serde::Serialize`, `serde_json::Value` and `serde_json::Map` for what is read and
//! written as JSON.

// The parts of a program; what others call is a `Scene`, its parts, and a `Renderer`.
#![allow(missing_docs)]

pub mod bind;
pub mod culling;
pub mod frame;
pub mod listed;
pub mod picture;
pub mod plan;
pub mod reference;
pub mod render;
pub mod sample;
pub mod scene;
pub mod shading_f32;
pub mod splitmix64;
pub mod upload;

pub use frame::{Chosen, Fragment, Frame, FrameOptions, VertexNormals};
pub use scene::Scene;
pub use upload::Upload;
