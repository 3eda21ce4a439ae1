//! PNG: 8 bits per channel, tagged with the transfer function.
//!
//! Writes pictures in the codes of [`code`](mod@super::code), and reads [`Codes`]. sRGB codes get
//! the chunk `sRGB`, linear ones `gAMA` 1; for a file with neither the caller decides.

use std::io::{Cursor, Write};

use ::png::{
    BitDepth, ColorType, Compression, Decoder, Encoder, Limits, ScaledFloat, SrgbRenderingIntent,
};
use ::png::{Info, Transformations};

use super::code::{self, Codes, Transfer};
use super::error::PictureError;
use super::{MAX_PIXELS, PIXELS, Picture, size};
use landfall_ir::threads;

const FORMAT: &str = "PNG";
/// The gamma that stands for sRGB in older files: 1 / 2.2.
const OLD_SRGB: u32 = 45_455;
/// The keyword of the text that names the program.
const SOFTWARE: &str = "Software";
const LINEAR: u32 = 100_000;
const CHUNK: usize = 1 << 20;

/// Returns the file of a picture, rounded as by [`codes`](super::code::codes).
///
/// # Errors
/// An [incomplete](Picture::checked) picture.
pub fn write(picture: &Picture, transfer: Transfer) -> Result<Vec<u8>, PictureError> {
    let pixels = picture.checked()?.pixels.len();
    let of = |channels, compression| file(picture, transfer, channels, compression);
    // Most pictures are opaque.
    let (channels, bytes) = match of(3, Compression::Fast)? {
        Some(bytes) => (3, bytes),
        None => (4, of(4, Compression::Fast)?.unwrap_or_default()),
    };
    // Noise may take more bytes compressed so fast than not at all.
    let stored = match bytes.len() > channels * pixels {
        true => of(channels, Compression::NoCompression)?,
        false => None,
    };
    Ok(stored.filter(|stored| stored.len() < bytes.len()).unwrap_or(bytes))
}

/// Returns the file of three or four channels; `None` if three would lose an alpha.
fn file(
    picture: &Picture,
    transfer: Transfer,
    channels: usize,
    compression: Compression,
) -> Result<Option<Vec<u8>>, PictureError> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, picture.width, picture.height);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(compression);
    encoder.set_color(if channels == 3 { ColorType::Rgb } else { ColorType::Rgba });
    match transfer {
        Transfer::Srgb => encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric),
        Transfer::Linear => encoder.set_source_gamma(ScaledFloat::from_scaled(LINEAR)),
    }
    encoder.add_text_chunk(SOFTWARE.to_string(), "landfall".to_string()).map_err(broken)?;
    let mut writer = encoder.write_header().map_err(broken)?;
    let mut data = writer.stream_writer_with_size(CHUNK).map_err(broken)?;
    let written = threads::ordered_with(
        picture.pixels.chunks(PIXELS),
        None,
        (|| Ok(()), || Some(())),
        |(), part| (channels * part.len(), strip(part, transfer, channels)),
        |(_, codes)| match codes {
            Some(codes) => data.write_all(&codes).map_err(|error| Some(broken(error))),
            None => Err(None),
        },
    );
    if let Err(error) = written {
        return error.map_or(Ok(None), Err);
    }
    data.finish().map_err(broken)?;
    writer.finish().map_err(broken)?;
    Ok(Some(bytes))
}

/// Returns the codes of three or four channels of pixels; `None` if three would lose an alpha.
fn strip(pixels: &[[f32; 4]], transfer: Transfer, channels: usize) -> Option<Vec<u8>> {
    let mut codes = vec![0; channels * pixels.len()];
    let mut alphas = u8::MAX;
    for (pixel, to) in pixels.iter().zip(codes.chunks_exact_mut(channels)) {
        let code = code::pixel(pixel, transfer);
        // All bits stay set only if every alpha is 255.
        alphas &= code[3];
        to.copy_from_slice(&code[..channels]);
    }
    (channels == 4 || alphas == u8::MAX).then_some(codes)
}

/// Whether a file was written by [`write()`].
pub fn is_landfalls(bytes: &[u8]) -> bool {
    // The text chunk comes before the pixels, so the mark is near the start.
    let head = bytes.get(..bytes.len().min(256)).unwrap_or_default();
    let mark = format!("tEXt{SOFTWARE}\0landfall");
    head.starts_with(b"\x89PNG") && head.windows(mark.len()).any(|part| part == mark.as_bytes())
}

/// Parses codes from a file: grey, indexed or true colour, with alpha or without.
///
/// # Errors
/// An invalid PNG, or one of 16 bits per channel, of too many pixels, or of a gamma that is neither
/// linear nor that of sRGB.
pub fn read(bytes: &[u8]) -> Result<Codes, PictureError> {
    let limits = Limits { bytes: MAX_PIXELS as usize * 4 };
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_transformations(Transformations::EXPAND);
    // Check the size before allocating.
    let header = decoder.read_header_info().map_err(broken)?;
    let (width, height) = (header.width, header.height);
    size(width, height)?;
    let mut backend = decoder.read_info().map_err(broken)?;
    let info = backend.info();
    let transfer = transfer(info)?;
    if info.bit_depth == BitDepth::Sixteen {
        let what = "16 bits a channel".to_string();
        let instead = "save it with 8, or as EXR";
        return Err(PictureError::Unsupported { format: FORMAT, what, instead });
    }
    let len = backend.output_buffer_size().ok_or(PictureError::TooLarge { width, height })?;
    let mut data = vec![0; len];
    let frame = backend.next_frame(&mut data).map_err(broken)?;
    let rgba: fn(&[u8]) -> [u8; 4] = match frame.color_type {
        ColorType::Grayscale => |p| [p[0], p[0], p[0], 255],
        ColorType::GrayscaleAlpha => |p| [p[0], p[0], p[0], p[1]],
        ColorType::Rgb => |p| [p[0], p[1], p[2], 255],
        ColorType::Rgba => |p| [p[0], p[1], p[2], p[3]],
        ColorType::Indexed => unreachable!("expanding makes indices colours"),
    };
    let channels = frame.color_type.samples();
    let pixels = data[..frame.buffer_size()].chunks_exact(channels).map(rgba).collect();
    Ok(Codes { width, height, pixels, transfer, non_finite: 0 })
}

fn transfer(info: &Info<'_>) -> Result<Option<Transfer>, PictureError> {
    match (info.srgb, info.gama_chunk.map(ScaledFloat::into_scaled)) {
        (Some(_), _) | (None, Some(OLD_SRGB)) => Ok(Some(Transfer::Srgb)),
        (None, Some(LINEAR)) => Ok(Some(Transfer::Linear)),
        (None, None) => Ok(None),
        (None, Some(gamma)) => Err(PictureError::Unsupported {
            format: FORMAT,
            what: format!("gamma {}", f64::from(gamma) / 1e5),
            instead: "save it as sRGB, or linear with gamma 1",
        }),
    }
}

fn broken(cause: impl std::fmt::Display) -> PictureError {
    PictureError::Broken { format: FORMAT, cause: cause.to_string() }
}
