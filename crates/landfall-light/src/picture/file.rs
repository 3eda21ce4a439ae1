//! Picture files by format; the caller reads and writes the bytes.

use super::code::Transfer;
use super::error::PictureError;
use super::{Picture, exr, pfm, png};

/// The formats of picture files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// 8 bits per channel, for viewing.
    Png,
    /// Floats with alpha.
    Exr,
    /// Floats without alpha, in a minimal format.
    Pfm,
}

impl Format {
    /// Returns the format of a file name's extension.
    ///
    /// # Errors
    /// An unknown extension.
    pub fn of(path: &str) -> Result<Format, PictureError> {
        let end = path.rsplit_once('.').map(|(_, end)| end.to_ascii_lowercase());
        match end.as_deref() {
            Some("png") => Ok(Format::Png),
            Some("exr") => Ok(Format::Exr),
            Some("pfm") => Ok(Format::Pfm),
            _ => Err(PictureError::UnknownFormat { path: path.to_string() }),
        }
    }
}

/// Returns the bytes of a picture in a format; `transfer` applies to PNG, floats are linear.
///
/// # Errors
/// An [incomplete](Picture::checked) picture.
pub fn write(
    picture: &Picture,
    format: Format,
    transfer: Transfer,
) -> Result<Vec<u8>, PictureError> {
    match format {
        Format::Png => png::write(picture, transfer),
        Format::Exr => exr::write(picture),
        Format::Pfm => pfm::write(picture),
    }
}

/// Parses a picture in a format; `transfer` applies to PNGs without one.
///
/// # Errors
/// Bytes that are not of the format, or use an unsupported feature.
pub fn read(bytes: &[u8], format: Format, transfer: Transfer) -> Result<Picture, PictureError> {
    match format {
        Format::Png => Ok(png::read(bytes)?.picture(transfer)),
        Format::Exr => exr::read(bytes),
        Format::Pfm => pfm::read(bytes),
    }
}
