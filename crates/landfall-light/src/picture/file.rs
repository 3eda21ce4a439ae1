//! Picture files by format; the caller reads and writes the bytes.

use super::code::Transfer;
use super::error::PictureError;
use super::{Picture, exr, pfm, png};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// 8 bits per channel, for viewing.
    Png,
    /// Floats with alpha.
    Exr,
    /// Floats without alpha, in a minimal format.
    Pfm,
}

impl PictureFormat {
    /// Returns the format of a file name's extension.
    ///
    /// # Errors
    /// An unknown extension.
    pub fn from_path(path: &str) -> Result<PictureFormat, PictureError> {
        let end = path.rsplit_once('.').map(|(_, end)| end.to_ascii_lowercase());
        match end.as_deref() {
            Some("png") => Ok(PictureFormat::Png),
            Some("exr") => Ok(PictureFormat::Exr),
            Some("pfm") => Ok(PictureFormat::Pfm),
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
    format: PictureFormat,
    transfer: Transfer,
) -> Result<Vec<u8>, PictureError> {
    match format {
        PictureFormat::Png => png::write(picture, transfer),
        PictureFormat::Exr => exr::write(picture),
        PictureFormat::Pfm => pfm::write(picture),
    }
}

/// Parses a picture in a format; `transfer` applies to PNGs without one.
///
/// # Errors
/// Bytes that are not of the format, or use an unsupported feature.
pub fn read(
    bytes: &[u8],
    format: PictureFormat,
    transfer: Transfer,
) -> Result<Picture, PictureError> {
    match format {
        PictureFormat::Png => Ok(png::read(bytes)?.picture(transfer)),
        PictureFormat::Exr => exr::read(bytes),
        PictureFormat::Pfm => pfm::read(bytes),
    }
}
