//! Measuring for all benches: two things interleaved in one run, their ratio
//! with its spread. A time of its own says little on a shared machine.

#![allow(dead_code, reason = "each bench uses its own part")]

use std::time::Instant;

/// Ratios of one measurement, sorted.
pub struct Ratios(Vec<f64>);

impl Ratios {
    /// Of pairs measured otherwise.
    pub fn new(mut ratios: Vec<f64>) -> Ratios {
        ratios.sort_by(f64::total_cmp);
        Ratios(ratios)
    }

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
    turns(pairs, [1, 1], &mut fast, &mut slow).ratios
}

/// Two things measured in turns.
pub struct Contest {
    /// Seconds of one call of the first, the median.
    pub first: f64,
    /// Seconds of one call of the second, the median.
    pub second: f64,
    /// How many times longer the second takes.
    pub ratios: Ratios,
}

/// The same for what takes less than the clock's steps: each side of a pair is repeated until it
/// has taken about a tenth of a millisecond.
pub fn contest(pairs: usize, mut first: impl FnMut(), mut second: impl FnMut()) -> Contest {
    fn repeat(work: &mut dyn FnMut()) -> usize {
        let once = seconds(&mut || (0..20).for_each(|_| work())) / 20.0;
        ((1e-4 / once.max(1e-9)) as usize).max(1)
    }
    let repeats = [repeat(&mut first), repeat(&mut second)];
    turns(pairs, repeats, &mut first, &mut second)
}

fn turns(
    pairs: usize,
    repeats: [usize; 2],
    first: &mut impl FnMut(),
    second: &mut impl FnMut(),
) -> Contest {
    let [mut a, mut b] = [Vec::with_capacity(pairs), Vec::with_capacity(pairs)];
    for pair in 0..pairs {
        if pair % 2 == 0 {
            a.push(repeated(repeats[0], first));
            b.push(repeated(repeats[1], second));
        } else {
            b.push(repeated(repeats[1], second));
            a.push(repeated(repeats[0], first));
        }
    }
    let ratios = Ratios::new(a.iter().zip(&b).map(|(a, b)| b / a).collect());
    Contest { first: median(a), second: median(b), ratios }
}

/// Seconds of one of so many calls.
fn repeated(times: usize, work: &mut impl FnMut()) -> f64 {
    seconds(&mut || (0..times).for_each(|_| work())) / times as f64
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
