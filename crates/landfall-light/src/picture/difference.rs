//! Pictures of the difference between two pictures.
//!
//! Draws the differences of [`compare`](mod@super::compare) and the map of [`flip`](super::flip).

use super::Picture;
use super::code::Transfer;
use super::color_map;
use super::error::PictureError;
use super::flip::FlipMap;

/// The colour of pixels that are NaN or infinite: magenta, linear.
pub const NON_FINITE: [f32; 4] = [1.0, 0.0, 1.0, 1.0];

/// Returns the absolute difference of each channel times `amplify`, opaque.
///
/// # Errors
/// Different sizes, or an [incomplete](Picture::checked) picture.
pub fn difference(a: &Picture, b: &Picture, amplify: f32) -> Result<Picture, PictureError> {
    let (a, b) = (a.checked()?, b.checked()?);
    let sizes = [[a.width, a.height], [b.width, b.height]];
    if sizes[0] != sizes[1] {
        return Err(PictureError::SizesDiffer { a: sizes[0], b: sizes[1] });
    }
    let pixels = a
        .pixels
        .iter()
        .zip(&b.pixels)
        .map(|(a, b)| {
            if a.iter().chain(b).any(|value| !value.is_finite()) {
                return NON_FINITE;
            }
            let [r, g, b] = [0, 1, 2].map(|i| (a[i] - b[i]).abs() * amplify);
            [r, g, b, 1.0]
        })
        .collect();
    Ok(Picture { width: a.width, height: a.height, pixels })
}

/// Returns the power of ten that brings a maximum difference, in steps, near full scale.
pub fn amplification(max_steps: f64) -> f32 {
    match max_steps > 0.0 && max_steps < 255.0 {
        // A power of ten, so that the factor is easily undone by eye; rounded down, so that nothing
        // is clipped.
        true => 10f64.powf((255.0 / max_steps).log10().floor()) as f32,
        false => 1.0,
    }
}

/// Returns a FLIP map in the colours of [`color_map`], dark where nothing is visible.
pub fn flip_picture(map: &FlipMap) -> Picture {
    let pixels = map
        .errors
        .iter()
        .map(|error| {
            let [r, g, b] = color_map::color(f64::from(*error))
                .map(|code| Transfer::Srgb.decode(f64::from(code) / 255.0) as f32);
            [r, g, b, 1.0]
        })
        .collect();
    Picture { width: map.width, height: map.height, pixels }
}
