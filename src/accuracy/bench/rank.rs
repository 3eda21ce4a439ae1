//! Who is better: not worse in any column beyond the spread, and better in one.
//!
//! Only variants of one runner are compared. Columns are time for a light and for a fragment or
//! call; the largest error and that of 99.9 %, in steps and in units of the last place; what a
//! conformant device may do, the same two; flips, whole numbers that are others, fragments that
//! are no number; light evaluations, slots and bytes uploaded. Operations and powers are none, as
//! they are why the time is what it is.

use super::report::{BenchRow, Permitted, Work};

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

/// Whether `a` is better than `b`: of one runner, not worse in any column, better in one.
pub fn better(a: &BenchRow, b: &BenchRow) -> bool {
    let verdicts = columns(a, b);
    a.runner == b.runner
        && verdicts.iter().all(|verdict| *verdict != Verdict::Worse)
        && verdicts.contains(&Verdict::Better)
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
        times(a.light_rounds.as_deref(), b.light_rounds.as_deref()),
        times(Some(&a.fragment_rounds), Some(&b.fragment_rounds)),
        numbers(Some(ea.max_steps), Some(eb.max_steps)),
        numbers(Some(ea.p999_steps), Some(eb.p999_steps)),
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

/// Times of the same rounds: `a` is faster if it was in three of four rounds.
fn times(a: Option<&[f64]>, b: Option<&[f64]>) -> Verdict {
    let (Some(a), Some(b)) = (a, b) else { return Verdict::Same };
    let rounds = a.len().min(b.len());
    let faster = a.iter().zip(b).filter(|(a, b)| a < b).count();
    let slower = a.iter().zip(b).filter(|(a, b)| a > b).count();
    match 4 {
        _ if rounds == 0 => Verdict::Same,
        quarters if quarters * faster >= 3 * rounds => Verdict::Better,
        quarters if quarters * slower >= 3 * rounds => Verdict::Worse,
        _ => Verdict::Same,
    }
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
