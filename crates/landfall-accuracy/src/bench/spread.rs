//! Summaries of the numbers of many rounds.

use serde::{Deserialize, Serialize};

/// The quartiles, minimum and count of a set of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Spread {
    /// The median.
    pub median: f64,
    /// The lower quartile.
    pub lower: f64,
    /// The upper quartile.
    pub upper: f64,
    /// The minimum.
    pub min: f64,
    /// The number of rounds.
    pub rounds: u32,
}

impl Spread {
    /// Summarises numbers; `None` if empty.
    ///
    /// Quartiles are interpolated (Hyndman and Fan's type 7).
    pub fn from_numbers(numbers: &[f64]) -> Option<Spread> {
        let mut sorted = numbers.to_vec();
        sorted.sort_by(f64::total_cmp);
        let (min, last) = (*sorted.first()?, sorted.len() - 1);
        let at = |part: f64| {
            let place = part * last as f64;
            let (below, above) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
            below + place.fract() * (above - below)
        };
        Some(Spread {
            median: at(0.5),
            lower: at(0.25),
            upper: at(0.75),
            min,
            rounds: sorted.len() as u32,
        })
    }
}
