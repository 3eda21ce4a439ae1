//! Compares two pictures: in floats without clamping, in codes, and by visibility.
//!
//! Reads two [`Picture`]s; the command prints a [`Comparison`] and tests its numbers against
//! limits. A *step* is 1/255, for any transfer function.

use serde::Serialize;

use super::Picture;
use super::code::{Codes, Transfer, codes};
use super::error::PictureError;
use super::flip;
use super::flip::FlipMap;

/// The options of a comparison.
#[derive(Clone, Copy, Debug, Default)]
pub struct Compare<'a> {
    /// The transfer function of the codes.
    pub transfer: Transfer,
    /// A mark for each pixel to leave out: fragments whose lighting is undefined.
    pub leave_out: Option<&'a [bool]>,
}

/// The difference of two pictures. Alpha has a number of its own; all others are of red, green and
/// blue of the compared pixels.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Comparison {
    /// The width in pixels.
    pub width: u32,
    /// The height in pixels.
    pub height: u32,
    /// The pixels compared.
    pub pixels: u64,
    /// The pixels left out.
    pub left_out: u64,
    /// The NaN or infinite values, which only FLIP below includes.
    pub non_finite: NonFinite,
    /// The difference of linear values, neither clamped nor rounded.
    pub linear: Linear,
    /// The difference of 8-bit codes.
    pub codes: CodeSteps,
    /// The peak signal-to-noise ratio of the codes.
    pub psnr: Psnr,
    /// The visibility of the difference.
    pub flip: Visible,
}

/// The numbers of NaN or infinite channels of red, green and blue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct NonFinite {
    /// In the first picture.
    pub a: u64,
    /// In the second picture.
    pub b: u64,
    /// In either; these channels are not compared.
    pub either: u64,
    /// Pixels with such a channel, or such an alpha, in either.
    pub pixels: u64,
}

/// Absolute differences in steps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Linear {
    /// The maximum.
    pub max: f64,
    /// The 99.9 % quantile of the channels.
    pub p999: f64,
    /// The mean; where small, close to the share of codes that flip.
    pub mean: f64,
    /// The column and row of the maximum.
    pub at: Option<[u32; 2]>,
    /// The maximum of alpha.
    pub alpha_max: f64,
}

/// Differences of codes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CodeSteps {
    /// The transfer function of the codes.
    pub transfer: Transfer,
    /// The channels compared.
    pub channels: u64,
    /// The maximum difference.
    pub max: u8,
    /// The channels that differ by 0, 1, 2, and 3 or more.
    pub counts: [u64; 4],
    /// The share of channels that differ at all: the *flips*.
    pub flips: f64,
}

/// The peak signal-to-noise ratio.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Psnr {
    /// No code differs: the ratio is infinite.
    Identical,
    /// The ratio in decibels.
    Db(f64),
    /// Nothing was compared.
    Nothing,
}

/// FLIP of the compared pixels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Visible {
    /// The mean, 0 to 1.
    pub mean: f64,
    /// The maximum.
    pub max: f64,
}

/// Compares two pictures.
///
/// # Errors
/// Different sizes, an [incomplete](Picture::checked) picture, or missing marks.
pub fn compare(
    a: &Picture,
    b: &Picture,
    options: &Compare<'_>,
) -> Result<Comparison, PictureError> {
    compare_and_map(a, b, options).map(|(comparison, _)| comparison)
}

/// Compares two pictures and returns the map of visible differences too.
///
/// # Errors
/// Those of [`compare`].
pub fn compare_and_map(
    a: &Picture,
    b: &Picture,
    options: &Compare<'_>,
) -> Result<(Comparison, FlipMap), PictureError> {
    let (a, b) = (a.checked()?, b.checked()?);
    let sizes = [[a.width, a.height], [b.width, b.height]];
    if sizes[0] != sizes[1] {
        return Err(PictureError::SizesDiffer { a: sizes[0], b: sizes[1] });
    }
    let pixels = a.pixels.len() as u64;
    if let Some(marks) = options.leave_out.map(|marks| marks.len() as u64) {
        if marks != pixels {
            return Err(PictureError::WrongMask { pixels, marks });
        }
    }
    let out = |pixel: usize| options.leave_out.is_some_and(|marks| marks[pixel]);
    let (codes_a, mut codes_b) = (codes(a, options.transfer), codes(b, options.transfer));
    // Pixels left out must not affect their neighbours either.
    for (pixel, code) in codes_b.pixels.iter_mut().enumerate() {
        if out(pixel) {
            *code = codes_a.pixels[pixel];
        }
    }
    let kept: Vec<usize> = (0..a.pixels.len()).filter(|pixel| !out(*pixel)).collect();
    // FLIP needs whole pictures: it blurs across pixels, so those left out were made equal above.
    let map = flip::flip(&codes_a, &codes_b, flip::PIXELS_PER_DEGREE)?;
    let (non_finite, linear) = linear(a, b, &kept);
    let (steps, psnr) = steps(a, b, [&codes_a, &codes_b], &kept, options.transfer);
    let comparison = Comparison {
        width: a.width,
        height: a.height,
        pixels: kept.len() as u64,
        left_out: pixels - kept.len() as u64,
        non_finite,
        linear,
        codes: steps,
        psnr,
        flip: visible(&map, &kept),
    };
    Ok((comparison, map))
}

fn linear(a: &Picture, b: &Picture, kept: &[usize]) -> (NonFinite, Linear) {
    let mut non_finite = NonFinite { a: 0, b: 0, either: 0, pixels: 0 };
    let mut linear = Linear { max: 0.0, p999: 0.0, mean: 0.0, at: None, alpha_max: 0.0 };
    let mut errors = Vec::with_capacity(3 * kept.len());
    for &pixel in kept {
        let (a_pixel, b_pixel) = (a.pixels[pixel], b.pixels[pixel]);
        let mut finite = true;
        for channel in 0..4 {
            let (va, vb) = (a_pixel[channel], b_pixel[channel]);
            let both = va.is_finite() && vb.is_finite();
            finite &= both;
            let error = 255.0 * (f64::from(va) - f64::from(vb)).abs();
            match (channel, both) {
                (3, true) => linear.alpha_max = linear.alpha_max.max(error),
                (3, false) => {}
                (_, true) => {
                    if error > linear.max {
                        linear.max = error;
                        let pixel = pixel as u32;
                        linear.at = Some([pixel % a.width, pixel / a.width]);
                    }
                    errors.push(error);
                }
                (_, false) => {
                    non_finite.a += u64::from(!va.is_finite());
                    non_finite.b += u64::from(!vb.is_finite());
                    non_finite.either += 1;
                }
            }
        }
        non_finite.pixels += u64::from(!finite);
    }
    if !errors.is_empty() {
        linear.mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let (_, p999, _) = {
            // Nearest rank in integers: at least 999 of 1000 are not above it.
            let rank = (errors.len() * 999).div_ceil(1000);
            errors.select_nth_unstable_by(rank - 1, f64::total_cmp)
        };
        linear.p999 = *p999;
    }
    (non_finite, linear)
}

fn steps(
    a: &Picture,
    b: &Picture,
    codes: [&Codes; 2],
    kept: &[usize],
    transfer: Transfer,
) -> (CodeSteps, Psnr) {
    let mut steps = CodeSteps { transfer, channels: 0, max: 0, counts: [0; 4], flips: 0.0 };
    let mut squares = 0u64;
    for &pixel in kept {
        for channel in 0..3 {
            if !a.pixels[pixel][channel].is_finite() || !b.pixels[pixel][channel].is_finite() {
                continue;
            }
            let [a, b] = codes.map(|codes| codes.pixels[pixel][channel]);
            let difference = a.abs_diff(b);
            steps.channels += 1;
            steps.max = steps.max.max(difference);
            steps.counts[usize::from(difference).min(3)] += 1;
            squares += u64::from(difference).pow(2);
        }
    }
    let channels = steps.channels as f64;
    let psnr = match (steps.channels, squares) {
        (0, _) => Psnr::Nothing,
        (_, 0) => Psnr::Identical,
        _ => Psnr::Db(10.0 * (255.0 * 255.0 * channels / squares as f64).log10()),
    };
    if steps.channels > 0 {
        steps.flips = (steps.channels - steps.counts[0]) as f64 / channels;
    }
    (steps, psnr)
}

fn visible(map: &FlipMap, kept: &[usize]) -> Visible {
    let errors = kept.iter().map(|pixel| f64::from(map.errors[*pixel]));
    let sum: f64 = errors.clone().sum();
    Visible { mean: sum / kept.len().max(1) as f64, max: errors.fold(0.0, f64::max) }
}
