//! The fragments of a scene's picture, as a rasteriser passes them to a fragment shader.
//!
//! Computed in `f64` from a [`Scene`] and rounded once, so that every backend and the reference
//! start from the same bits and every picture has the same edges. `vertices` transforms corners to
//! view and lighting space, `raster` finds the triangle at each pixel.

mod raster;
mod vertices;

use super::Scene;
use vertices::Corners;

/// The fragments of a picture.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Frame {
    /// The width in pixels.
    pub width: u32,
    /// The height in pixels.
    pub height: u32,
    /// The fragments, in pixel order from the top; other pixels show the background.
    pub fragments: Vec<Fragment>,
}

/// The surface point at one pixel, in lighting space.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Zeroable)]
pub struct Fragment {
    /// The pixel: `row * width + column`.
    pub pixel: u32,
    /// The index of the material.
    pub material: u32,
    /// The index of the object.
    pub object: u32,
    /// The position.
    pub position: [f32; 3],
    /// The interpolated normal, of any length.
    pub normal: [f32; 3],
    /// The texture coordinates.
    pub uv: [f32; 2],
}

/// The options of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct FrameOptions {
    /// The treatment of normals by the vertex shader.
    pub normals: VertexNormals,
}

/// The treatment of a mesh's normals by a vertex shader, before interpolation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum VertexNormals {
    /// Times the inverse transpose of the upper 3 by 3 of the transform: correct, of any length.
    #[default]
    Transformed,
    /// The same, then normalised.
    Unit,
    /// `normalize(transpose(inverse(m)) * vec4(normal, 0)).xyz`: a published bug. The fourth
    /// component is meaningless but counts in the length, so corners get different weights and the
    /// interpolated normal bends.
    UnitOfFour,
}

impl Frame {
    /// Returns the indices of all fragments.
    pub fn numbers(&self) -> Vec<u32> {
        (0..self.fragments.len() as u32).collect()
    }

    /// Rasterises a scene.
    ///
    /// A pixel shows the nearest triangle at its centre, front or back, between the near and the
    /// far plane; the first drawn of two equally near; of two triangles sharing an edge, the one to
    /// its right or below it has the centres on it. Attributes are interpolated with perspective.
    /// All of it is in `f64` and the same on any number of threads.
    pub fn new(scene: &Scene, options: &FrameOptions) -> Frame {
        let [width, height] = scene.size;
        let corners = Corners::new(scene, options.normals);
        let fragments = raster::fragments(scene, &corners);
        Frame { width, height, fragments }
    }
}
