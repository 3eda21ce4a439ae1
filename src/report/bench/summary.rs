//! The first lines of a bench: which variant is faster, which is more accurate, and whether one is
//! both.

use landfall_accuracy::bench::rank::{Verdict, time_of};
use landfall_accuracy::bench::{Bench, BenchRow, Runner, Spread, Unit};
use landfall_layout::format::columns::{WIDTH, wrapped};
use landfall_layout::format::phrases::{counted, figure};

/// Returns the lines for each runner with several variants.
pub fn lines(bench: &Bench) -> Vec<String> {
    let mut runners: Vec<&Runner> = Vec::new();
    for row in &bench.rows {
        if !runners.contains(&&row.runner) {
            runners.push(&row.runner);
        }
    }
    let mut text = Vec::new();
    for runner in runners {
        let rows: Vec<&BenchRow> = bench.rows.iter().filter(|row| row.runner == *runner).collect();
        for line in of_runner(&rows, bench.unit) {
            let line = format!("{}: {line}", runner.backend);
            for (nth, line) in wrapped(&line, WIDTH - 2).into_iter().enumerate() {
                text.push(if nth == 0 { line } else { format!("  {line}") });
            }
        }
    }
    text
}

fn of_runner(rows: &[&BenchRow], unit: Unit) -> Vec<String> {
    let Some((first, others)) = rows.split_first().filter(|(_, others)| !others.is_empty()) else {
        return Vec::new();
    };
    let mut lines = vec![fastest(rows, first, unit)];
    lines.extend(most_accurate(rows, first));
    let is_best = |row: &&&BenchRow| {
        rows.iter().all(|other| {
            std::ptr::eq(*other, **row)
                || time_of(row, other) == Verdict::Better && is_more_accurate(row, other)
        })
    };
    lines.push(match rows.iter().find(is_best) {
        Some(row) if others.len() == 1 => format!("`{}` is better in both", row.variant),
        Some(row) => format!("`{}` is better in both than every other", row.variant),
        None => "no variant is better in both".to_string(),
    });
    lines
}

/// Returns which variant is the fastest, beside the first, or beside the next where that is it.
fn fastest(rows: &[&BenchRow], first: &BenchRow, unit: Unit) -> String {
    let mut by_time = rows.to_vec();
    by_time.sort_by(|a, b| a.fragment.median.total_cmp(&b.fragment.median));
    let best = by_time[0];
    let other = if std::ptr::eq(best, first) { by_time[1] } else { first };
    let is_none = |row: &BenchRow| row.fragment_rounds.iter().any(|time| *time <= 0.0);
    if rows.iter().all(|row| row.fragment.median <= 0.0) {
        return format!("no {} takes longer than an empty one, within the noise", unit.name());
    }
    // The ratio is taken in each round, so that what slows the machine in one round slows both.
    let ratios = best.fragment_rounds.iter().zip(&other.fragment_rounds).map(|(a, b)| a / b);
    let ratio = Spread::of(&ratios.collect::<Vec<f64>>());
    let quartiles = match ratio {
        Some(Spread { median, lower, upper, .. }) if !is_none(best) && !is_none(other) => {
            let [median, lower, upper] = [median, lower, upper].map(figure);
            format!("{median} (quartiles {lower} to {upper}) of the time of `{}`", other.variant)
        }
        // A net time of nothing has no ratio.
        _ => {
            let [a, b] = [best, other].map(|row| figure(row.fragment.median));
            format!("{a} ns, where `{}` takes {b}; the ratio is within the noise", other.variant)
        }
    };
    match time_of(best, other) {
        Verdict::Better => format!("`{}` is the fastest: {quartiles}", best.variant),
        Verdict::Same | Verdict::Worse => {
            let rounds = counted(best.fragment.rounds as usize, "round");
            format!(
                "no variant is shown to be the fastest in {rounds}: `{}` takes {quartiles}",
                best.variant
            )
        }
    }
}

/// The error that variants are ordered by: results that are no number, then the largest error, in
/// units of the last place where results have some.
fn error(row: &BenchRow) -> (u64, f64) {
    let errors = &row.errors;
    let largest = errors.max_ulp.or(errors.max_steps).unwrap_or(f64::INFINITY);
    (if errors.is_no_number() { u64::MAX } else { errors.non_finite }, largest)
}

fn is_more_accurate(a: &BenchRow, b: &BenchRow) -> bool {
    error(a) < error(b)
}

fn most_accurate(rows: &[&BenchRow], first: &BenchRow) -> Option<String> {
    let mut by_error = rows.to_vec();
    by_error.sort_by(|a, b| error(a).0.cmp(&error(b).0).then(error(a).1.total_cmp(&error(b).1)));
    let best = by_error[0];
    let other = if std::ptr::eq(best, first) { by_error[1] } else { first };
    let ((few, least), (many, most)) = (error(best), error(other));
    let name = &other.variant;
    if few == u64::MAX {
        return Some("no variant has a result that is a number".to_string());
    }
    if (few, least) == (many, most) {
        return Some(format!("`{}` and `{name}` are equally accurate", best.variant));
    }
    let unit = if best.errors.max_ulp.is_some() { "ULP" } else { "steps" };
    let mut text =
        format!("`{}` is the most accurate: off by at most {} {unit}", best.variant, figure(least));
    // A variant whose results are no numbers has no error to compare.
    if many == u64::MAX {
        text += &format!(", where `{name}` has no result that is a number");
    } else {
        text += &format!(", where `{name}` is by {}", figure(most));
        if many > few {
            text +=
                &format!(" and has {} that are NaN or infinite", counted(many as usize, "result"));
        }
    }
    Some(text)
}
