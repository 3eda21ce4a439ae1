//! Numbers of many rounds, as the few that say how they spread.

use serde::{Deserialize, Serialize};

/// The middle of many numbers and how far they spread.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Half are not above it.
    pub median: f64,
    /// A quarter is not above it.
    pub lower: f64,
    /// Three quarters are not above it.
    pub upper: f64,
    /// The least.
    pub min: f64,
    /// How many there are.
    pub rounds: u32,
}

impl Spread {
    /// Of numbers; none of none.
    ///
    /// Quartiles lie between numbers in proportion (Hyndman and Fan's type 7).
    pub fn of(numbers: &[f64]) -> Option<Spread> {
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
