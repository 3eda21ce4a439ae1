//! Portable float maps: pictures as plain floats, in a minimal format.
//!
//! `PF`, width and height, `-1.0`, each on a line of its own, then three little-endian `f32` per
//! pixel, the bottom row first. A positive third number means big-endian; `Pf` means one grey float
//! per pixel. Alpha is not stored: it is 1 when read. Bits are kept, those of NaN too.

use super::error::PictureError;
use super::{Picture, size};

const FORMAT: &str = "PFM";

/// Returns the file of a picture, without its alpha.
///
/// # Errors
/// An [incomplete](Picture::checked) picture.
pub fn write(picture: &Picture) -> Result<Vec<u8>, PictureError> {
    let Picture { width, height, pixels } = picture.checked()?;
    let mut bytes = format!("PF\n{width} {height}\n-1.0\n").into_bytes();
    bytes.reserve(pixels.len() * 12);
    // The bottom row is the first.
    for row in pixels.chunks(*width as usize).rev() {
        for channel in row.iter().flat_map(|pixel| &pixel[..3]) {
            bytes.extend_from_slice(&channel.to_le_bytes());
        }
    }
    Ok(bytes)
}

/// Parses a picture from a file.
///
/// # Errors
/// An invalid float map, or one of too many pixels.
pub fn read(bytes: &[u8]) -> Result<Picture, PictureError> {
    let broken = |cause: &str| PictureError::Broken { format: FORMAT, cause: cause.to_string() };
    let mut rest = bytes;
    let mut word = || {
        let start = rest.iter().position(|b| !b.is_ascii_whitespace())?;
        let end = start + rest[start..].iter().position(|b| b.is_ascii_whitespace())?;
        let word = str::from_utf8(&rest[start..end]).ok()?;
        // One white byte ends a word; after the last one the floats begin.
        rest = &rest[end + 1..];
        Some(word)
    };
    let channels = match word() {
        Some("PF") => 3,
        Some("Pf") => 1,
        _ => return Err(broken("it does not begin with `PF` or `Pf`")),
    };
    let mut number = || word().and_then(|word| word.parse::<u32>().ok());
    let (Some(width), Some(height)) = (number(), number()) else {
        return Err(broken("its size is not two numbers"));
    };
    let scale = word().and_then(|word| word.parse::<f32>().ok());
    let Some(scale) = scale.filter(|scale| scale.is_finite() && *scale != 0.0) else {
        return Err(broken(
            "its third value, the scale whose sign gives the byte order, is not a number",
        ));
    };
    let wanted = size(width, height)? * channels * 4;
    if rest.len() != wanted {
        let cause = format!("its size needs {wanted} bytes of floats, {} follow", rest.len());
        return Err(broken(&cause));
    }
    let float = |bytes: &[u8]| {
        let bytes = bytes.try_into().expect("chunks are of four bytes");
        if scale < 0.0 { f32::from_le_bytes(bytes) } else { f32::from_be_bytes(bytes) }
    };
    let pixels = rest
        .chunks(wanted / height as usize)
        .rev()
        .flat_map(|row| row.chunks(4 * channels))
        .map(|pixel| {
            let mut floats = pixel.chunks(4).map(float);
            let red = floats.next().expect("a pixel has a float");
            [red, floats.next().unwrap_or(red), floats.next().unwrap_or(red), 1.0]
        })
        .collect();
    Ok(Picture { width, height, pixels })
}
