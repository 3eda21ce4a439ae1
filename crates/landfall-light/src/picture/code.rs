//! Pictures of 8 bits per channel.
//!
//! Written and read by [`png`](super::png), compared by [`compare`](mod@super::compare).

use std::sync::atomic::{AtomicU64, Ordering};

use serde::{Deserialize, Serialize};

use super::{PIXELS, Picture};
use landfall_ir::threads;

/// The transfer function between linear values and codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Transfer {
    /// IEC 61966-2-1: `*_SRGB` targets and untagged PNGs.
    #[default]
    Srgb,
    /// The identity: `*_UNORM` targets.
    Linear,
}

impl Transfer {
    /// Returns `srgb` or `linear`.
    pub fn name(self) -> &'static str {
        match self {
            Transfer::Srgb => "srgb",
            Transfer::Linear => "linear",
        }
    }

    /// Encodes a linear value, clamped first, to 0 to 1; NaN becomes 0.
    pub fn encode(self, linear: f64) -> f64 {
        let linear = if linear.is_nan() { 0.0 } else { linear.clamp(0.0, 1.0) };
        match self {
            Transfer::Srgb if linear <= 0.003_130_8 => 12.92 * linear,
            Transfer::Srgb => 1.055 * linear.powf(1.0 / 2.4) - 0.055,
            Transfer::Linear => linear,
        }
    }

    /// Decodes a stored value from 0 to 1.
    pub fn decode(self, stored: f64) -> f64 {
        match self {
            Transfer::Srgb if stored <= 0.040_45 => stored / 12.92,
            Transfer::Srgb => ((stored + 0.055) / 1.055).powf(2.4),
            Transfer::Linear => stored,
        }
    }
}

/// A picture of 8 bits per channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Codes {
    /// The width in pixels.
    pub width: u32,
    /// The height in pixels.
    pub height: u32,
    /// Red, green, blue and alpha, from the top.
    pub pixels: Vec<[u8; 4]>,
    /// The transfer function, if the file has it.
    pub transfer: Option<Transfer>,
    /// The NaN or infinite channels that were clamped to a code.
    pub non_finite: u64,
}

impl Codes {
    /// Decodes to a linear picture, with `otherwise` for codes without a transfer function.
    pub fn picture(&self, otherwise: Transfer) -> Picture {
        let transfer = self.transfer.unwrap_or(otherwise);
        // Only 256 values occur, so the powers are taken once for each.
        let linear: Vec<f32> =
            (0..=255u8).map(|code| transfer.decode(f64::from(code) / 255.0) as f32).collect();
        let pixels = self
            .pixels
            .iter()
            .map(|&[r, g, b, a]| {
                let [r, g, b] = [r, g, b].map(|code| linear[usize::from(code)]);
                [r, g, b, f32::from(a) / 255.0]
            })
            .collect();
        Picture { width: self.width, height: self.height, pixels }
    }
}

/// Encodes a picture.
///
/// A value is clamped to 0 to 1, encoded, multiplied by 255 and rounded to the nearest code, halves
/// upwards: Direct3D's rule; Vulkan and OpenGL do not specify halves. NaN and −∞ become 0 and +∞
/// 255, and are counted. Alpha is always linear.
pub fn codes(picture: &Picture, transfer: Transfer) -> Codes {
    let mut pixels: Vec<[u8; 4]> = bytemuck::zeroed_vec(picture.pixels.len());
    let non_finite = AtomicU64::new(0);
    let parts = picture.pixels.chunks(PIXELS).zip(pixels.chunks_mut(PIXELS));
    threads::each(parts, |(linear, encoded)| {
        let mut count = 0;
        for (linear, encoded) in linear.iter().zip(encoded) {
            *encoded = pixel(linear, transfer);
            count += linear.iter().filter(|value| !value.is_finite()).count() as u64;
        }
        non_finite.fetch_add(count, Ordering::Relaxed);
    });
    let non_finite = non_finite.into_inner();
    let Picture { width, height, .. } = *picture;
    Codes { width, height, pixels, transfer: Some(transfer), non_finite }
}

/// Returns the codes of one pixel, by the rule of [`codes`].
pub(super) fn pixel(&[r, g, b, a]: &[f32; 4], transfer: Transfer) -> [u8; 4] {
    let code_of = |value| code(value, transfer);
    [code_of(r), code_of(g), code_of(b), code(a, Transfer::Linear)]
}

/// Returns the code of one value, by the rule of [`codes`].
pub fn code(value: f32, transfer: Transfer) -> u8 {
    // 255 times an f32 is exact in f64: a tie is a tie. The conversion rounds down.
    (255.0 * transfer.encode(f64::from(value)) + 0.5) as u8
}
