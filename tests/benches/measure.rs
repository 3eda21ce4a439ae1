//! Measuring for all benches: two things interleaved in one run, their ratio
//! with its spread. A time of its own says little on a shared machine.

#![allow(dead_code, reason = "each bench uses its own part")]

use std::time::Instant;

/// Ratios of one measurement, sorted.
pub struct Ratios(Vec<f64>);

impl Ratios {
    /// The ratio that half of the pairs stay below.
    pub fn median(&self) -> f64 {
        self.quantile(0.5)
    }

    /// The ratio that this part of the pairs stays below.
    pub fn quantile(&self, part: f64) -> f64 {
        let last = self.0.len() - 1;
        self.0[(part * last as f64).round() as usize]
    }
}

impl std::fmt::Display for Ratios {
    /// Median and the range that 8 of 10 pairs lie in.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (low, high) = (self.quantile(0.1), self.quantile(0.9));
        write!(f, "{:>7} ({} to {})", round(self.median()), round(low), round(high))
    }
}

/// A ratio with the digits that mean something.
pub fn round(ratio: f64) -> String {
    match ratio {
        r if r >= 100.0 => format!("{r:.0}"),
        r if r >= 10.0 => format!("{r:.1}"),
        r => format!("{r:.2}"),
    }
}

/// How many times longer `slow` takes than `fast`: measured in pairs, in turns A B, B A.
pub fn interleaved(pairs: usize, mut fast: impl FnMut(), mut slow: impl FnMut()) -> Ratios {
    fast();
    slow();
    let mut ratios: Vec<f64> = (0..pairs)
        .map(|pair| {
            if pair % 2 == 0 {
                let a = seconds(&mut fast);
                seconds(&mut slow) / a
            } else {
                let b = seconds(&mut slow);
                b / seconds(&mut fast)
            }
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    Ratios(ratios)
}

/// Seconds one call takes.
pub fn seconds(work: &mut impl FnMut()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}

/// The value that half of them stay below.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// The geometric mean of ratios.
pub fn geometric_mean(ratios: &[f64]) -> f64 {
    (ratios.iter().map(|r| r.ln()).sum::<f64>() / ratios.len() as f64).exp()
}
