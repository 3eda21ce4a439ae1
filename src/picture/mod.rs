//! A picture in floats: what a reader or the reference gave, to be written, compared, drawn.

pub mod color_map;

/// Pixels of four floats.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Picture {
    /// Pixels in a row.
    pub width: u32,
    /// Rows, from the top.
    pub height: u32,
    /// Red, green, blue, alpha, linear; `width * height` of them.
    pub pixels: Vec<[f32; 4]>,
}
