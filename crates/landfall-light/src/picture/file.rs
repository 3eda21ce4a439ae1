//! Which format a file name means, and its bytes; whoever has the bytes writes the file.

use super::code::{Transfer, codes};
use super::error::PictureError;
use super::{Picture, exr, pfm, png};

/// The formats of picture files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// 8 bits a channel, for people.
    Png,
    /// Floats with alpha.
    Exr,
    /// Floats without alpha, as plain as can be.
    Pfm,
}

impl Format {
    /// The format that the end of a file name tells.
    ///
    /// # Errors
    /// It ends in none that is known.
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

/// The bytes of a picture in a format; `transfer` is that of a PNG, floats are always linear.
///
/// # Errors
/// The picture is not [whole](Picture::checked).
pub fn write(
    picture: &Picture,
    format: Format,
    transfer: Transfer,
) -> Result<Vec<u8>, PictureError> {
    match format {
        Format::Png => png::write(&codes(picture.checked()?, transfer)),
        Format::Exr => exr::write(picture),
        Format::Pfm => pfm::write(picture),
    }
}

/// The picture of bytes in a format; `transfer` is that of a PNG which does not say.
///
/// # Errors
/// The bytes are not of the format, or of a sort that is not read.
pub fn read(bytes: &[u8], format: Format, transfer: Transfer) -> Result<Picture, PictureError> {
    match format {
        Format::Png => Ok(png::read(bytes)?.picture(transfer)),
        Format::Exr => exr::read(bytes),
        Format::Pfm => pfm::read(bytes),
    }
}
