//! Ranks variants: one is better if it is not worse in any column beyond the spread, and better in
//! one.
//!
//! Only variants of one runner are compared; a variant without any finite result is worse than one
//! with some, however fast. The columns are time per light and per fragment or call; the maximum
//! and 99.9 % quantile of the error, in steps and in units of the last place; the same two of the
//! error permitted on a conformant device, and its unsure samples; flips, differing integers,
//! non-finite fragments; the largest errors and the non-finite results at ends of the inputs'
//! ranges; light evaluations, slots and bytes uploaded. Operations and powers are left out, since
//! they show in the time.
//!
//! A variant whose quartiles of a time all lie above those of another is not better than it.
//!
//! Times are compared round by round, since load affects both times of a round alike. They differ
//! if three conditions hold: enough rounds agree on which is faster that chance would do so in less
//! than one of a hundred comparisons (a two-sided sign test, which takes at least eight rounds);
//! the median difference exceeds the interquartile range of the differences, and so their noise;
//! and it exceeds [`PLACED`] of the time before subtraction, the effect of the placement of code
//! and data in memory.

use super::clock::Clock;
use super::errors::Errors;
use super::report::{Bench, BenchRow, Permitted, Work};
use super::spread::Spread;

/// The share of a time by which the placement of code and data in memory may change it in all
/// rounds alike: for a function against itself, medians of 15 rounds differed by up to half of
/// that.
pub const PLACED: f64 = 0.05;

/// The probability of agreement by chance below which two times differ.
const CHANCE: f64 = 0.01;

/// The comparison of one column of two variants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Better beyond the spread.
    Better,
    /// Not distinguishable, or one variant has no such number.
    Same,
    /// Worse beyond the spread.
    Worse,
}

impl Bench {
    /// Fills in which rows are better than each row.
    pub fn ranked(mut self) -> Bench {
        let better = dominated(&self.rows);
        let names: Vec<String> = self.rows.iter().map(|row| row.variant.clone()).collect();
        for (row, better) in self.rows.iter_mut().zip(better) {
            row.dominated_by = better.into_iter().map(|i| names[i].clone()).collect();
        }
        self
    }
}

/// Whether `a` is better than `b`: on the same runner, not worse in any column and better in one. A
/// variant without any finite result is worse than all others.
pub fn better(a: &BenchRow, b: &BenchRow) -> bool {
    // A partial order: two variants may each be better in some column, and then neither dominates.
    let verdicts = columns(a, b);
    // Where placement may explain a time, the quartiles that are printed still count.
    let is_above = |(a, b): (Spread, Spread)| a.lower > b.upper;
    let is_slower =
        is_above((a.fragment, b.fragment)) || a.light.zip(b.light).is_some_and(is_above);
    let no_worse = verdicts.iter().all(|verdict| *verdict != Verdict::Worse) && !is_slower;
    a.runner == b.runner
        && match (a.errors.is_no_number(), b.errors.is_no_number()) {
            (false, true) => true,
            (true, false) => false,
            (false, false) | (true, true) => no_worse && verdicts.contains(&Verdict::Better),
        }
}

/// Compares the time of `a` per fragment or call with that of `b`.
pub fn time_of(a: &BenchRow, b: &BenchRow) -> Verdict {
    times(Some(Timed::fragment(a)), Some(Timed::fragment(b)))
}

/// Returns for each row the indices of the rows that are better.
pub fn dominated(rows: &[BenchRow]) -> Vec<Vec<usize>> {
    rows.iter()
        .map(|row| (0..rows.len()).filter(|&other| better(&rows[other], row)).collect())
        .collect()
}

/// Compares each column of `a` with `b`.
pub fn columns(a: &BenchRow, b: &BenchRow) -> [Verdict; 18] {
    let (ea, eb) = (&a.errors, &b.errors);
    let whole = |n: Option<u64>| n.map(|n| n as f64);
    let at_ends = |of: fn(&Errors) -> Option<f64>| {
        numbers(a.ends.as_ref().and_then(of), b.ends.as_ref().and_then(of))
    };
    let permitted = |of: fn(&Permitted) -> Option<f64>| {
        // An unbounded error on both sides is no difference.
        // An unbounded error is larger than any number.
        let steps = |row: &BenchRow| row.permitted.map(|p| of(&p).unwrap_or(f64::INFINITY));
        numbers(steps(a), steps(b))
    };
    [
        times(Timed::light(a), Timed::light(b)),
        time_of(a, b),
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
        at_ends(|errors| errors.max_steps),
        at_ends(|errors| errors.max_ulp),
        at_ends(|errors| Some(errors.non_finite as f64)),
        evaluations(&a.work, &b.work),
        numbers(a.work.slots, b.work.slots),
        numbers(whole(a.work.bytes), whole(b.work.bytes)),
    ]
}

#[derive(Clone, Copy)]
struct Timed<'a> {
    rounds: &'a [f64],
    /// The time before subtraction, on which placement in memory acts.
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

    /// Device timestamps also include transfers, which placement does not affect.
    fn on(self, clock: Clock) -> Timed<'a> {
        // Placement acts on code that the processor runs, so it is measured against all of its
        // time, also what was subtracted later.
        match clock {
            Clock::Processor | Clock::Elapsed => self,
            Clock::Device => Timed { gross: self.net(), ..self },
        }
    }

    fn net(&self) -> f64 {
        Spread::from_numbers(self.rounds).map_or(0.0, |spread| spread.median.abs())
    }
}

/// Compares times of the same rounds.
fn times(a: Option<Timed<'_>>, b: Option<Timed<'_>>) -> Verdict {
    let (Some(a), Some(b)) = (a, b) else { return Verdict::Same };
    // A net time of zero does not limit the ratio.
    // 5 % of the gross time is a larger share of the net time.
    let placed = PLACED * ((a.gross + b.gross) / (a.net() + b.net())).max(1.0);
    // Relative to the mean of both, since load slows both times of a round alike. A net time may be
    // zero or negative.
    let apart = |(a, b): (&f64, &f64)| match a.abs() + b.abs() {
        0.0 => 0.0,
        both => 2.0 * (a - b) / both,
    };
    let apart: Vec<f64> = a.rounds.iter().zip(b.rounds).map(apart).collect();
    let Some(Spread { median, lower, upper, .. }) = Spread::from_numbers(&apart) else {
        return Verdict::Same;
    };
    // Rounds that agree with the median's sign; exact ties agree with neither.
    let agree = apart.iter().filter(|apart| **apart * median > 0.0).count();
    let noise = upper - lower;
    // A positive `apart` is the time of `a` above that of `b`.
    match median.abs() > noise.max(placed) && by_chance(agree, apart.len()) < CHANCE {
        false => Verdict::Same,
        true if median < 0.0 => Verdict::Better,
        true => Verdict::Worse,
    }
}

/// Returns the probability that at least `agree` of `all` fair coins show the same side.
fn by_chance(agree: usize, all: usize) -> f64 {
    // In logarithms: half to the power of ten thousand rounds underflows an `f64`.
    let half = all as f64 * 0.5f64.ln();
    let mut ways = 0.0;
    let mut tail = 0.0;
    // C(all, k) by its recurrence, summed over the smaller tail; twice for a two-sided test.
    for apart in 0..=all - agree.min(all) {
        if apart > 0 {
            ways += ((all - apart + 1) as f64 / apart as f64).ln();
        }
        tail += f64::exp(ways + half);
    }
    (2.0 * tail).min(1.0)
}

/// Compares numbers without noise.
fn numbers(a: Option<f64>, b: Option<f64>) -> Verdict {
    match (a, b) {
        (Some(a), Some(b)) if a < b => Verdict::Better,
        (Some(a), Some(b)) if a > b => Verdict::Worse,
        _ => Verdict::Same,
    }
}

/// Compares light evaluations: sampled ones differ if by more than two standard errors.
fn evaluations(a: &Work, b: &Work) -> Verdict {
    // The standard error of a difference of two independent means is the root of the sum of
    // squares.
    let error = |work: &Work| work.evaluations_error.unwrap_or(0.0);
    let spread = 2.0 * error(a).hypot(error(b));
    let apart = a.evaluations.zip(b.evaluations).map(|(a, b)| a - b);
    match apart {
        Some(apart) if apart < -spread => Verdict::Better,
        Some(apart) if apart > spread => Verdict::Worse,
        Some(_) | None => Verdict::Same,
    }
}

/// Compares counts of sampled events: they differ if by more than two standard errors, by the
/// square root of the count.
fn counts(a: Option<u64>, b: Option<u64>) -> Verdict {
    let (Some(a), Some(b)) = (a, b) else { return Verdict::Same };
    // Counts of rare events have a variance equal to their mean (Poisson).
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
