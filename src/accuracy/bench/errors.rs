//! How far colours are from the reference, in the numbers a variant is ranked by.

use serde::{Deserialize, Serialize};

use crate::picture::Transfer;
use crate::picture::code::code;

/// How far the colours of fragments are from the reference. A step is 1/255.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Errors {
    /// The largest difference of linear values in steps, not clamped; of no colours it is 0.
    pub max_steps: f64,
    /// What 99.9 % of the channels do not exceed.
    pub p999_steps: f64,
    /// Channels compared.
    pub channels: u64,
    /// Channels whose 8-bit sRGB code is another.
    pub flips: u64,
    /// The largest difference of codes.
    pub max_code: u8,
    /// Fragments with a channel that is NaN or infinite where the reference is not.
    pub non_finite: u64,
    /// Fragments left out because the reference is undefined there.
    pub undefined: u64,
}

impl Errors {
    /// Of colours against the reference's, which are `None` where undefined.
    pub fn of(colors: &[[f32; 3]], truth: &[Option<[f64; 3]>]) -> Errors {
        let truth = truth.iter().map(|truth| truth.as_ref().map(|truth| &truth[..]));
        Errors::each(colors.iter().map(|color| &color[..]).zip(truth))
    }

    /// The same of any numbers; a truth is as long as what it is the truth of.
    pub fn each<'a>(all: impl Iterator<Item = (&'a [f32], Option<&'a [f64]>)>) -> Errors {
        let mut errors = Errors::default();
        let mut steps = Vec::new();
        for (ours, truth) in all {
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
                errors.flips += u64::from(apart > 0);
                errors.max_code = errors.max_code.max(apart);
            }
        }
        errors.channels = steps.len() as u64;
        if !steps.is_empty() {
            errors.max_steps = steps.iter().copied().fold(0.0, f64::max);
            // Nearest rank, in whole numbers: at least 999 of 1000 are not above it.
            let rank = (steps.len() * 999).div_ceil(1000);
            let (_, p999, _) = steps.select_nth_unstable_by(rank - 1, f64::total_cmp);
            errors.p999_steps = *p999;
        }
        errors
    }

    /// Part of the channels whose code is another.
    pub fn flip_share(&self) -> f64 {
        self.flips as f64 / self.channels.max(1) as f64
    }
}
