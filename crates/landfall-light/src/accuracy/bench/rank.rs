//! Who is better: not worse in any column beyond the spread, and better in one.
//!
//! Only variants of one runner are compared, and only those that give any number at all: who gives
//! none is worse than who does, however fast. Columns are time for a light and for a fragment or
//! call; the largest error and that of 99.9 %, in steps and in units of the last place; what a
//! conformant device may do, the same two; flips, whole numbers that are others, fragments that
//! are no number; light evaluations, slots and bytes uploaded. Operations and powers are none, as
//! they are why the time is what it is.
//!
//! Times are compared round by round, as what two took beside each other. They are apart if three
//! things hold: so many rounds agree on who is faster that chance would do so less than once in a
//! hundred comparisons (a sign test of two sides, which takes eight rounds at least); the median
//! difference is more than the quartiles of the differences are apart, and so more than their
//! noise; and it is more than [`PLACED`] of the time before anything was subtracted, which where
//! code and data happen to lie in memory makes of the same work.

use super::clock::Clock;
use super::report::{BenchRow, Permitted, Work};
use super::spread::Spread;

/// Part of a time by which the same work may differ in all rounds alike, by where its code and
/// data lie in memory: of a function against itself, medians of 15 rounds were apart by up to half
/// of that.
pub const PLACED: f64 = 0.05;

/// How seldom chance alone makes so many rounds agree, of those that tell two times apart.
const CHANCE: f64 = 0.01;

/// What one column says of two variants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Beyond the spread.
    Better,
    /// Not told apart, or one of them has no such number.
    Same,
    /// Beyond the spread.
    Worse,
}

/// Whether `a` is better than `b`: of one runner, not worse in any column, better in one. Who
/// gives no number is worse than all who do.
pub fn better(a: &BenchRow, b: &BenchRow) -> bool {
    let verdicts = columns(a, b);
    let no_worse = verdicts.iter().all(|verdict| *verdict != Verdict::Worse);
    a.runner == b.runner
        && match (a.errors.is_no_number(), b.errors.is_no_number()) {
            (false, true) => true,
            (true, false) => false,
            (false, false) | (true, true) => no_worse && verdicts.contains(&Verdict::Better),
        }
}

/// For each row the numbers of those that are better.
pub fn dominated(rows: &[BenchRow]) -> Vec<Vec<usize>> {
    rows.iter()
        .map(|row| (0..rows.len()).filter(|&other| better(&rows[other], row)).collect())
        .collect()
}

/// Each column of `a` against `b`.
pub fn columns(a: &BenchRow, b: &BenchRow) -> [Verdict; 15] {
    let (ea, eb) = (&a.errors, &b.errors);
    let whole = |n: Option<u64>| n.map(|n| n as f64);
    let permitted = |of: fn(&Permitted) -> Option<f64>| {
        // More than any number is what may be anything.
        let steps = |row: &BenchRow| row.permitted.map(|p| of(&p).unwrap_or(f64::INFINITY));
        numbers(steps(a), steps(b))
    };
    [
        times(Timed::light(a), Timed::light(b)),
        times(Some(Timed::fragment(a)), Some(Timed::fragment(b))),
        numbers(ea.max_steps, eb.max_steps),
        numbers(ea.p999_steps, eb.p999_steps),
        numbers(ea.max_ulp, eb.max_ulp),
        numbers(ea.p999_ulp, eb.p999_ulp),
        permitted(|permitted| permitted.max_steps),
        permitted(|permitted| permitted.p999_steps),
        counts(a.permitted.map(|p| p.unsure), b.permitted.map(|p| p.unsure)),
        counts(ea.flips, eb.flips),
        numbers(whole(ea.differing), whole(eb.differing)),
        numbers(Some(ea.non_finite as f64), Some(eb.non_finite as f64)),
        evaluations(&a.work, &b.work),
        numbers(a.work.slots, b.work.slots),
        numbers(whole(a.work.bytes), whole(b.work.bytes)),
    ]
}

/// Times of one row.
#[derive(Clone, Copy)]
struct Timed<'a> {
    rounds: &'a [f64],
    /// What memory may make longer or shorter, beside the work alone.
    gross: f64,
}

impl<'a> Timed<'a> {
    fn light(row: &'a BenchRow) -> Option<Timed<'a>> {
        let gross = row.light_gross?;
        row.light_rounds.as_deref().map(|rounds| Timed { rounds, gross }.on(row.runner.clock))
    }

    fn fragment(row: &'a BenchRow) -> Timed<'a> {
        let rounds = &row.fragment_rounds;
        Timed { rounds, gross: row.fragment_gross }.on(row.runner.clock)
    }

    /// A device's timestamps hold the way there and back besides, which is the same memory for all.
    fn on(self, clock: Clock) -> Timed<'a> {
        match clock {
            Clock::Processor | Clock::Elapsed => self,
            Clock::Device => Timed { gross: self.net(), ..self },
        }
    }

    fn net(&self) -> f64 {
        Spread::of(self.rounds).map_or(0.0, |spread| spread.median.abs())
    }
}

/// Times of the same rounds.
fn times(a: Option<Timed<'_>>, b: Option<Timed<'_>>) -> Verdict {
    let (Some(a), Some(b)) = (a, b) else { return Verdict::Same };
    // Of nothing, nothing is a part.
    let placed = PLACED * ((a.gross + b.gross) / (a.net() + b.net())).max(1.0);
    // Of their mean: what else a machine does slows both of a round alike. What is left after a
    // subtraction may be nothing or less.
    let apart = |(a, b): (&f64, &f64)| match a.abs() + b.abs() {
        0.0 => 0.0,
        both => 2.0 * (a - b) / both,
    };
    let apart: Vec<f64> = a.rounds.iter().zip(b.rounds).map(apart).collect();
    let Some(Spread { median, lower, upper, .. }) = Spread::of(&apart) else {
        return Verdict::Same;
    };
    let agree = apart.iter().filter(|apart| **apart * median > 0.0).count();
    let noise = upper - lower;
    match median.abs() > noise.max(placed) && by_chance(agree, apart.len()) < CHANCE {
        false => Verdict::Same,
        true if median < 0.0 => Verdict::Better,
        true => Verdict::Worse,
    }
}

/// How often so many of `all` coins, or more, lie on the same side.
fn by_chance(agree: usize, all: usize) -> f64 {
    // In logarithms: half to the power of ten thousand rounds is no `f64`.
    let half = all as f64 * 0.5f64.ln();
    let mut ways = 0.0;
    let mut tail = 0.0;
    for apart in 0..=all - agree.min(all) {
        if apart > 0 {
            ways += ((all - apart + 1) as f64 / apart as f64).ln();
        }
        tail += f64::exp(ways + half);
    }
    (2.0 * tail).min(1.0)
}

/// Numbers that are the same each time.
fn numbers(a: Option<f64>, b: Option<f64>) -> Verdict {
    match (a, b) {
        (Some(a), Some(b)) if a < b => Verdict::Better,
        (Some(a), Some(b)) if a > b => Verdict::Worse,
        _ => Verdict::Same,
    }
}

/// Those of a shader are a sample: apart are what their standard errors do not explain, twice.
fn evaluations(a: &Work, b: &Work) -> Verdict {
    let error = |work: &Work| work.evaluations_error.unwrap_or(0.0);
    let spread = 2.0 * error(a).hypot(error(b));
    let apart = a.evaluations.zip(b.evaluations).map(|(a, b)| a - b);
    match apart {
        Some(apart) if apart < -spread => Verdict::Better,
        Some(apart) if apart > spread => Verdict::Worse,
        Some(_) | None => Verdict::Same,
    }
}

/// How many of a sample: so many of other fragments would differ by the root of their number, and
/// apart are what twice that does not explain.
fn counts(a: Option<u64>, b: Option<u64>) -> Verdict {
    let (Some(a), Some(b)) = (a, b) else { return Verdict::Same };
    let spread = 2.0 * ((a + b) as f64).sqrt();
    match a as f64 - b as f64 {
        apart if apart < -spread => Verdict::Better,
        apart if apart > spread => Verdict::Worse,
        _ => Verdict::Same,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coins_agree_as_often_as_binomials_say() {
        // Of eight, all: 2 of 256. Of 15, two others at most: 2 * (1 + 15 + 105) of 32,768.
        assert!((by_chance(8, 8) - 2.0 / 256.0).abs() < 1e-12);
        assert!((by_chance(13, 15) - 242.0 / 32768.0).abs() < 1e-12);
        assert!((by_chance(4, 8) - 1.0).abs() < 1e-12);
        assert!(by_chance(10_000, 10_000) < 1e-300 && by_chance(5000, 10_000) > 0.99);
    }
}
