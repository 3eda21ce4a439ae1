//! A scene's numbers as a shader gets them: in the space of its lighting, rounded to `f32`.
//!
//! Made from a [`Scene`](super::Scene); the binding map writes it to blocks and the reference
//! computes from it, so that rounding an upload is charged to neither.

use glam::DVec3;

use super::scene::{Lights, Material, Space};

/// Lights and materials as uploaded: every number is an `f32`, widened.
#[derive(Clone, Debug, PartialEq)]
pub struct Upload {
    /// The space its positions and directions are in.
    pub space: Space,
    /// Where the camera is in that space.
    pub camera: DVec3,
    /// The lights in that space.
    pub lights: Lights,
    /// The materials.
    pub materials: Vec<Material>,
}
