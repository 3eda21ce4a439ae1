//! A picture in floats: what a reader or the reference gave, to be written, compared, drawn.
//!
//! [`light`](crate) makes it. [`code`] rounds it to what a screen is given, [`compare`](mod@compare)
//! says how far two are apart, [`flip`] how visible that is, [`difference`] draws it; the files
//! are [`png`], [`exr`] and [`pfm`], bytes in and bytes out.

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

/// Most pixels a file may have: 1 GiB of floats.
pub const MOST_PIXELS: u64 = 1 << 26;

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

impl Picture {
    /// A picture of one colour.
    pub fn filled(width: u32, height: u32, pixel: [f32; 4]) -> Picture {
        Picture { width, height, pixels: vec![pixel; width as usize * height as usize] }
    }

    /// Pixels of which a channel is NaN or infinite.
    pub fn non_finite(&self) -> u64 {
        self.pixels.iter().filter(|pixel| pixel.iter().any(|c| !c.is_finite())).count() as u64
    }

    /// That there is a pixel, one for each place.
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

/// Pixels of a picture of this size.
///
/// # Errors
/// There are none, or more than [`MOST_PIXELS`].
fn size(width: u32, height: u32) -> Result<usize, PictureError> {
    let pixels = u64::from(width) * u64::from(height);
    match pixels {
        0 => Err(PictureError::Empty { width, height }),
        1..=MOST_PIXELS => Ok(pixels as usize),
        _ => Err(PictureError::TooLarge { width, height }),
    }
}
