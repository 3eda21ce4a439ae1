//! Pictures in floats: written, read, compared and drawn.
//!
//! [`code`] rounds a picture to 8 bits, [`compare`](mod@compare) measures how far two are apart,
//! [`flip`] how visible that is, [`difference`] draws it; the file formats are [`png`], [`exr`] and
//! [`pfm`], from and to bytes.

pub mod code;
pub mod color_map;
pub mod compare;
pub mod difference;
pub mod error;
pub mod exr;
pub mod file;
pub mod flip;
pub mod pfm;
pub mod png;

pub use code::{Codes, Transfer};
pub use compare::{Comparison, compare};
pub use error::PictureError;

use landfall_ir::threads;

/// The pixels that a thread works on at a time.
const PIXELS: usize = 1 << 14;

/// The most pixels of a file: 1 GiB of floats.
pub const MAX_PIXELS: u64 = 1 << 26;

/// A picture of four floats per pixel.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Picture {
    /// The width in pixels.
    pub width: u32,
    /// The height in pixels.
    pub height: u32,
    /// Linear red, green, blue and alpha, from the top; `width * height` of them.
    pub pixels: Vec<[f32; 4]>,
}

impl Picture {
    pub fn filled(width: u32, height: u32, pixel: [f32; 4]) -> Picture {
        let mut pixels = bytemuck::zeroed_vec(width as usize * height as usize);
        threads::each(pixels.chunks_mut(PIXELS), |part| part.fill(pixel));
        Picture { width, height, pixels }
    }

    /// Returns the number of pixels with a NaN or infinite channel.
    pub fn non_finite(&self) -> u64 {
        let parts: Vec<&[[f32; 4]]> = self.pixels.chunks(PIXELS).collect();
        let count = |part: &&[[f32; 4]]| {
            part.iter().filter(|pixel| pixel.iter().any(|c| !c.is_finite())).count() as u64
        };
        threads::map(&parts, 1, count).sum()
    }

    /// Checks that the picture has pixels, as many as its size.
    ///
    /// # Errors
    /// No pixels, or more or fewer than `width * height`.
    pub fn checked(&self) -> Result<&Picture, PictureError> {
        size(self.width, self.height)?;
        let wanted = u64::from(self.width) * u64::from(self.height);
        match self.pixels.len() as u64 {
            given if given == wanted => Ok(self),
            given => Err(PictureError::WrongCount { wanted, given }),
        }
    }
}

/// Returns the number of pixels of a size.
///
/// # Errors
/// None, or more than [`MAX_PIXELS`].
fn size(width: u32, height: u32) -> Result<usize, PictureError> {
    let pixels = u64::from(width) * u64::from(height);
    match pixels {
        0 => Err(PictureError::Empty { width, height }),
        1..=MAX_PIXELS => Ok(pixels as usize),
        _ => Err(PictureError::TooLarge { width, height }),
    }
}
