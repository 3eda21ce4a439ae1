//! Errors of colours and results against the reference, as variants are ranked by.

use serde::{Deserialize, Serialize};

use crate::measure::off;
use landfall_light::picture::Transfer;
use landfall_light::picture::code::code;

/// The errors of fragments' colours or of calls' results against the truth. A step is 1/255 of full
/// scale.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Errors {
    /// The largest difference of linear values in steps, not clamped; `None` where nothing was
    /// compared. For results larger than 1, the full scale is the largest of one call.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub max_steps: Option<f64>,
    /// The 99.9 % quantile of the channels' differences, in steps.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub p999_steps: Option<f64>,
    /// The median of the channels' differences, in steps.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub median_steps: Option<f64>,
    /// The largest difference of results, in units of the last place of an `f32`.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub max_ulp: Option<f64>,
    /// The 99.9 % quantile of the results' differences, in units of the last place.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub p999_ulp: Option<f64>,
    /// The median of the results' differences, in units of the last place.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub median_ulp: Option<f64>,
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
    pub fn new(colors: &[[f32; 3]], truth: &[Option<[f64; 3]>]) -> Errors {
        let mut errors = Errors::default();
        let mut steps = Vec::new();
        let (mut flips, mut max_code) = (0, 0);
        for (ours, truth) in colors.iter().zip(truth) {
            let Some(truth) = truth else {
                errors.undefined += 1;
                continue;
            };
            // A NaN or infinity has no distance; counted apart, it does not hide the errors of the
            // others.
            if ours.iter().any(|channel| !channel.is_finite()) {
                errors.non_finite += 1;
                continue;
            }
            for (ours, exact) in ours.iter().zip(truth) {
                steps.push(255.0 * (f64::from(*ours) - exact).abs());
                // Flips are those of what a picture stores: 8 bits, encoded as sRGB.
                let codes = [code(*ours, Transfer::Srgb), code(*exact as f32, Transfer::Srgb)];
                let apart = codes[0].abs_diff(codes[1]);
                flips += u64::from(apart > 0);
                max_code = max_code.max(apart);
            }
        }
        errors.channels = steps.len() as u64;
        if !steps.is_empty() {
            (errors.flips, errors.max_code) = (Some(flips), Some(max_code));
        }
        errors.set_steps(&mut steps);
        errors
    }

    fn set_steps(&mut self, steps: &mut [f64]) {
        let all = Quantiles::new(steps);
        self.max_steps = all.map(|all| all.max);
        self.p999_steps = all.map(|all| all.p999);
        self.median_steps = all.map(|all| all.median);
    }

    /// Compares results of calls with the truth's; returns also the numbers of the calls with the
    /// largest error in units of the last place and in steps.
    pub fn of_calls<'t>(
        all: impl Iterator<Item = (Results, Option<&'t Results>)>,
    ) -> (Errors, [Option<usize>; 2]) {
        let mut errors = Errors::default();
        let (mut steps, mut ulps) = (Vec::new(), Vec::new());
        let mut differing = None;
        let mut worst: [Option<(usize, f64)>; 2] = [None; 2];
        for (call, (ours, truth)) in all.enumerate() {
            let Some(truth) = truth else {
                errors.undefined += 1;
                continue;
            };
            if ours.missing || ours.floats.iter().any(|x| !x.is_finite()) {
                errors.non_finite += 1;
                continue;
            }
            // Colours of 1 and less are measured against 1; larger results against the largest of
            // the call.
            let scale = truth.floats.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
            for (ours, exact) in ours.floats.iter().zip(&truth.floats) {
                let off = off(*ours as f32, *exact, scale);
                steps.push(off.steps);
                ulps.push(off.ulp);
                for (worst, off) in worst.iter_mut().zip([off.ulp, off.steps]) {
                    // The first of equal errors, in the order of calls.
                    if off > worst.map_or(0.0, |(_, most)| most) {
                        *worst = Some((call, off));
                    }
                }
            }
            if !truth.wholes.is_empty() {
                let differs = ours.wholes != truth.wholes;
                // One call counts once, however many integers differ in it.
                differing = Some(differing.unwrap_or(0) + u64::from(differs));
            }
        }
        errors.channels = steps.len() as u64;
        errors.differing = differing;
        errors.set_steps(&mut steps);
        let all = Quantiles::new(&mut ulps);
        errors.max_ulp = all.map(|all| all.max);
        errors.p999_ulp = all.map(|all| all.p999);
        errors.median_ulp = all.map(|all| all.median);
        (errors, worst.map(|worst| worst.map(|(call, _)| call)))
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

/// The maximum and two quantiles of numbers, by nearest rank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Quantiles {
    pub max: f64,
    pub p999: f64,
    pub median: f64,
}

impl Quantiles {
    /// Returns those of numbers, whose order changes; `None` if there are none.
    pub(super) fn new(all: &mut [f64]) -> Option<Quantiles> {
        let max = all.iter().copied().reduce(f64::max)?;
        // In integers: at least 999 of 1000 are not above it.
        let rank = (all.len() * 999).div_ceil(1000) - 1;
        // `select_nth` is linear, where sorting 2^20 numbers three times would take longer than
        // the calls.
        let (_, &mut p999, _) = all.select_nth_unstable_by(rank, f64::total_cmp);
        let middle = all.len().div_ceil(2) - 1;
        let (_, &mut median, _) = all.select_nth_unstable_by(middle, f64::total_cmp);
        Some(Quantiles { max, p999, median })
    }
}
