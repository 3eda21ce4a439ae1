//! The fragments of a scene's picture: what a rasteriser hands to a fragment shader.
//!
//! Made in `f64` from a [`Scene`] and rounded once, so that every reader and the reference start
//! from the same bits and every picture has the same edges. `vertices` moves corners to where
//! they are seen and lit, `raster` finds what covers each pixel.

mod raster;
mod vertices;

use super::Scene;
use vertices::Corners;

/// The fragments of a picture.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Frame {
    /// Pixels in a row.
    pub width: u32,
    /// Rows, from the top.
    pub height: u32,
    /// What is seen, in the order of the pixels; a pixel without fragment shows the background.
    pub fragments: Vec<Fragment>,
}

/// What one pixel sees, in the space of the lighting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fragment {
    /// Its pixel: `row * width + column`.
    pub pixel: u32,
    /// Number of the material.
    pub material: u32,
    /// Number of the object.
    pub object: u32,
    /// Where the surface is.
    pub position: [f32; 3],
    /// The interpolated normal, of any length.
    pub normal: [f32; 3],
    /// Texture coordinates.
    pub uv: [f32; 2],
}

/// How a frame is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct FrameOptions {
    /// What the vertex shader does to normals.
    pub normals: VertexNormals,
}

/// What a vertex shader does to a mesh's normals before they are interpolated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum VertexNormals {
    /// Times the inverse transpose of the upper 3 by 3 of the transform: right, of any length.
    #[default]
    Transformed,
    /// The same, then each of unit length.
    Unit,
    /// `normalize(transpose(inverse(m)) * vec4(normal, 0)).xyz`: a bug that is published. The
    /// fourth component is of no meaning but takes part in the length, so corners are weighted
    /// differently and what is interpolated from them bends.
    UnitOfFour,
}

impl Frame {
    /// What each pixel of a scene sees.
    ///
    /// A pixel is covered where its centre is, by the nearest triangle of either side between
    /// the near and the far plane, the first drawn where two are as near; of two triangles that
    /// share an edge, the one to its right or below it has the centres on it. Attributes are
    /// interpolated with perspective. All of it is in `f64` and the same on any number of
    /// threads.
    pub fn new(scene: &Scene, options: &FrameOptions) -> Frame {
        let [width, height] = scene.size;
        let corners = Corners::new(scene, options.normals);
        let fragments = raster::fragments(scene, &corners);
        Frame { width, height, fragments }
    }
}
