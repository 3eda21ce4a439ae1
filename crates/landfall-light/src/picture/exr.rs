//! OpenEXR: linear floats with alpha, bit for bit, for measurements.
//!
//! Written as four channels of 32 bits; read from the first layer with red, green and blue of any
//! width. EXR is linear by definition.

use std::io::Cursor;

use ::exr::block::writer::ChunksWriter;
use ::exr::block::{self, UncompressedBlock};
use ::exr::image::write::layers::{LayersWriter, WritableLayers};
use ::exr::meta::MetaData;
use ::exr::prelude::{Image, ReadChannels, ReadLayers, SpecificChannels, Vec2};

use super::error::PictureError;
use super::{Picture, size};
use landfall_ir::threads;

const FORMAT: &str = "EXR";

/// Returns the file of a picture.
///
/// # Errors
/// An [incomplete](Picture::checked) picture.
pub fn write(picture: &Picture) -> Result<Vec<u8>, PictureError> {
    let Picture { width, height, pixels } = picture.checked()?;
    let width = *width as usize;
    let channels = SpecificChannels::rgba(|Vec2(x, y)| {
        let [r, g, b, a] = pixels[y * width + x];
        (r, g, b, a)
    });
    let image = Image::from_channels((width, *height as usize), channels);
    let mut bytes = Cursor::new(Vec::new());
    let headers = image.layer_data.infer_headers(&image.attributes);
    let writer = image.layer_data.create_writer(&headers);
    // Blocks are compressed on all threads and written in order, so that the file is always the
    // same.
    block::write(&mut bytes, headers, true, |meta, chunks| {
        let blocks: Vec<_> = meta.enumerate_ordered_header_block_indices().collect();
        let compressed = |(): &mut (), (nth, index)| {
            let data = writer.extract_uncompressed_block(&meta.headers, index);
            let bytes = data.len();
            (bytes, (nth, UncompressedBlock { index, data }.compress_to_chunk(&meta.headers)))
        };
        let states = (|| Ok(()), || Some(()));
        threads::ordered_with(blocks.into_iter(), None, states, compressed, |(_, (nth, chunk))| {
            chunks.write_chunk(nth, chunk?)
        })
    })
    .map_err(broken)?;
    Ok(bytes.into_inner())
}

/// Parses a picture from a file.
///
/// # Errors
/// An invalid EXR, one without red, green and blue, or one of too many pixels.
pub fn read(bytes: &[u8]) -> Result<Picture, PictureError> {
    // Check the size before allocating.
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(broken)?;
    for header in &meta.headers {
        let [width, height] = [header.layer_size.0, header.layer_size.1]
            .map(|side| u32::try_from(side).unwrap_or(u32::MAX));
        size(width, height)?;
    }
    let image = ::exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            |size, _| (size.0, vec![[0f32; 4]; size.0 * size.1]),
            |(width, pixels): &mut (usize, Vec<[f32; 4]>), Vec2(x, y), (r, g, b, a)| {
                pixels[y * *width + x] = [r, g, b, a];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(broken)?;
    let layer = image.layer_data;
    let Vec2(width, height) = layer.size;
    let (_, pixels) = layer.channel_data.pixels;
    Ok(Picture { width: width as u32, height: height as u32, pixels })
}

fn broken(cause: ::exr::error::Error) -> PictureError {
    PictureError::Broken { format: FORMAT, cause: cause.to_string().to_lowercase() }
}
