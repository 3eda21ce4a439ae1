//! The first lines of a bench: which variant wins, by how much, at which error.

use landfall_accuracy::bench::rank::{Verdict, time_of};
use landfall_accuracy::bench::{Bench, BenchRow, Spread, Unit};
use landfall_layout::format::columns::{WIDTH, wrapped};
use landfall_layout::format::phrases::{counted, figure};

/// Returns the lines for each runner with several variants.
pub fn lines(bench: &Bench) -> Vec<String> {
    let mut text = Vec::new();
    for runner in super::runners(&bench.rows) {
        let rows: Vec<&BenchRow> = bench.rows.iter().filter(|row| row.runner == *runner).collect();
        let Some(line) = of_runner(&rows, bench.unit) else { continue };
        let line = format!("{}: {line}", runner.backend);
        text.push(wrapped(&line, WIDTH - 2).join("\n  "));
    }
    text
}

fn of_runner(rows: &[&BenchRow], unit: Unit) -> Option<String> {
    let (first, _) = rows.split_first().filter(|(_, others)| !others.is_empty())?;
    let (fastest, time) = fastest(rows, first, unit);
    let (most_accurate, error) = most_accurate(rows, first);
    let is_best = |row: &&&BenchRow| {
        rows.iter().all(|other| {
            std::ptr::eq(*other, **row)
                || time_of(row, other) == Verdict::Better && is_more_accurate(row, other)
        })
    };
    Some(match rows.iter().find(is_best) {
        Some(row) => format!("`{}` wins: {time}; {error}", row.variant),
        None => format!("no variant wins in both: {fastest}{time}; {most_accurate}{error}"),
    })
}

/// Returns which variant is the fastest, and by how much, beside the first, or beside the next where
/// that is it.
fn fastest(rows: &[&BenchRow], first: &BenchRow, unit: Unit) -> (String, String) {
    let mut by_time = rows.to_vec();
    by_time.sort_by(|a, b| a.fragment.median.total_cmp(&b.fragment.median));
    let best = by_time[0];
    let other = if std::ptr::eq(best, first) { by_time[1] } else { first };
    let is_none = |row: &BenchRow| row.fragment_rounds.iter().any(|time| *time <= 0.0);
    if rows.iter().all(|row| row.fragment.median <= 0.0) {
        let none = format!("no {} takes longer than an empty one, within the noise", unit.name());
        return (String::new(), none);
    }
    // The ratio is taken in each round, so that what slows the machine in one round slows both.
    let ratios = best.fragment_rounds.iter().zip(&other.fragment_rounds).map(|(a, b)| a / b);
    let ratio = Spread::from_numbers(&ratios.collect::<Vec<f64>>());
    let time = match ratio {
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
    let name = &best.variant;
    match time_of(best, other) {
        Verdict::Better => (format!("`{name}` is the fastest: "), time),
        Verdict::Same | Verdict::Worse => {
            let rounds = counted(best.fragment.rounds as usize, "round");
            (format!("none is shown to be the fastest in {rounds}: `{name}` takes "), time)
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

/// Returns which variant is the most accurate, and by how much.
fn most_accurate(rows: &[&BenchRow], first: &BenchRow) -> (String, String) {
    let mut by_error = rows.to_vec();
    by_error.sort_by(|a, b| error(a).0.cmp(&error(b).0).then(error(a).1.total_cmp(&error(b).1)));
    let best = by_error[0];
    let other = if std::ptr::eq(best, first) { by_error[1] } else { first };
    let ((few, least), (many, most)) = (error(best), error(other));
    let (name, best_name) = (&other.variant, &best.variant);
    if few == u64::MAX {
        return (String::new(), "no variant has a result that is a number".to_string());
    }
    let unit = if best.errors.max_ulp.is_some() { "ULP" } else { "steps" };
    let least_shown = figure(least);
    if (few, least) == (many, most) {
        let both = format!("`{best_name}` and `{name}` are equally accurate: ");
        return (both, format!("off by at most {least_shown} {unit}"));
    }
    let mut text = format!("off by at most {least_shown} {unit}");
    if many == u64::MAX {
        text += &format!(", where `{name}` has no result that is a number");
    } else {
        text += &format!(", where `{name}` is by {}", figure(most));
        if many > few {
            let results = counted(many as usize, "result");
            text += &format!(" and has {results} that are NaN or infinite");
        }
    }
    (format!("`{best_name}` is the most accurate: "), text)
}
