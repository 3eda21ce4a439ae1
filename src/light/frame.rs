//! The fragments of a scene's picture: what a rasteriser hands to a fragment shader.
//!
//! Made in `f64` from a [`Scene`](super::Scene) and rounded once, so that every reader and the
//! reference start from the same bits and every picture has the same edges.

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
