//! Errors of colours and results against the reference, as variants are ranked by.

use serde::{Deserialize, Serialize};

use crate::accuracy::measure::off;
use crate::picture::Transfer;
use crate::picture::code::code;

/// The errors of fragments' colours or of calls' results against the truth. A step is 1/255 of full
/// scale.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Errors {
    /// The largest difference of linear values in steps, not clamped; `None` where nothing was
    /// compared. For results larger than 1, the full scale is the largest of one call.
    pub max_steps: Option<f64>,
    /// The 99.9 % quantile of the channels' differences, in steps.
    pub p999_steps: Option<f64>,
    /// The largest difference of results, in units of the last place of an `f32`.
    pub max_ulp: Option<f64>,
    /// The 99.9 % quantile of the results' differences, in units of the last place.
    pub p999_ulp: Option<f64>,
    /// The channels, or floats of results, compared.
    pub channels: u64,
    /// The channels of colours whose 8-bit sRGB code differs.
    pub flips: Option<u64>,
    /// The largest difference of 8-bit codes of colours.
    pub max_code: Option<u8>,
    /// The calls of which an integer or boolean result differs.
    pub differing: Option<u64>,
    /// The fragments or calls with a NaN or infinite channel where the reference is finite.
    pub non_finite: u64,
    /// The fragments or calls left out because the reference is undefined there.
    pub undefined: u64,
}

impl Errors {
    /// Compares colours with the reference's, which are `None` where undefined.
    pub fn of(colors: &[[f32; 3]], truth: &[Option<[f64; 3]>]) -> Errors {
        let mut errors = Errors::default();
        let mut steps = Vec::new();
        let (mut flips, mut max_code) = (0, 0);
        for (ours, truth) in colors.iter().zip(truth) {
            let Some(truth) = truth else {
                errors.undefined += 1;
                continue;
            };
            if ours.iter().any(|channel| !channel.is_finite()) {
                errors.non_finite += 1;
                continue;
            }
            for (ours, exact) in ours.iter().zip(truth) {
                steps.push(255.0 * (f64::from(*ours) - exact).abs());
                let codes = [code(*ours, Transfer::Srgb), code(*exact as f32, Transfer::Srgb)];
                let apart = codes[0].abs_diff(codes[1]);
                flips += u64::from(apart > 0);
                max_code = max_code.max(apart);
            }
        }
        errors.channels = steps.len() as u64;
        if let Some((max, p999)) = largest(&mut steps) {
            (errors.max_steps, errors.p999_steps) = (Some(max), Some(p999));
            (errors.flips, errors.max_code) = (Some(flips), Some(max_code));
        }
        errors
    }

    /// Compares results of calls with the truth's.
    pub fn of_calls(all: impl Iterator<Item = (Results, Option<Results>)>) -> Errors {
        let mut errors = Errors::default();
        let (mut steps, mut ulps) = (Vec::new(), Vec::new());
        let mut differing = None;
        for (ours, truth) in all {
            let Some(truth) = truth else {
                errors.undefined += 1;
                continue;
            };
            if ours.missing || ours.floats.iter().any(|x| !x.is_finite()) {
                errors.non_finite += 1;
                continue;
            }
            let scale = truth.floats.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
            for (ours, exact) in ours.floats.iter().zip(&truth.floats) {
                let off = off(*ours as f32, *exact, scale);
                steps.push(off.steps);
                ulps.push(off.ulp);
            }
            if !truth.wholes.is_empty() {
                let differs = ours.wholes != truth.wholes;
                differing = Some(differing.unwrap_or(0) + u64::from(differs));
            }
        }
        errors.channels = steps.len() as u64;
        errors.differing = differing;
        if let Some((max, p999)) = largest(&mut steps) {
            (errors.max_steps, errors.p999_steps) = (Some(max), Some(p999));
        }
        if let Some((max, p999)) = largest(&mut ulps) {
            (errors.max_ulp, errors.p999_ulp) = (Some(max), Some(p999));
        }
        errors
    }

    /// Whether every result is NaN or infinite although some should be finite.
    pub fn is_no_number(&self) -> bool {
        self.non_finite > 0 && self.channels == 0 && self.differing.is_none()
    }

    /// Returns the share of channels whose 8-bit code differs.
    pub fn flip_share(&self) -> Option<f64> {
        self.flips.map(|flips| flips as f64 / self.channels.max(1) as f64)
    }
}

/// The results of a call.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Results {
    /// The float results.
    pub floats: Vec<f64>,
    /// The integer and boolean results.
    pub wholes: Vec<u64>,
    /// Whether there are none because the call executed `discard`.
    pub missing: bool,
}

/// Returns the maximum and the 99.9 % quantile; `None` if empty.
pub(super) fn largest(all: &mut [f64]) -> Option<(f64, f64)> {
    let max = all.iter().copied().reduce(f64::max)?;
    // Nearest rank in integers: at least 999 of 1000 are not above it.
    let rank = (all.len() * 999).div_ceil(1000);
    let (_, p999, _) = all.select_nth_unstable_by(rank - 1, f64::total_cmp);
    Some((max, *p999))
}
