//! The report of `landfall bench`: time against error, as a table, CSV and JSON.
//!
//! Formats the data of [`accuracy::bench`](landfall_accuracy::bench).

mod summary;

use std::fmt::Write as _;

use serde::Serialize;
use unicode_width::UnicodeWidthStr;

use landfall_accuracy::bench::{
    Bench, BenchRow, DistributedInput, ErrorMeasure, Machine, Permitted, Runner, SampleSet,
    SampledInputs, Spread, Unit, WorstCall,
};
use landfall_exec::backend::BackendKind;
use landfall_layout::format::SCHEMA_VERSION;
use landfall_layout::format::columns::{GAP, WIDTH, wrapped};
pub use landfall_layout::format::csv::quoted;
use landfall_layout::format::json::{Tool, to_lines};
pub use landfall_layout::format::paint::{CAUTION, FAINT, HEADING, PLAIN, Paint, STRONG};
pub use landfall_layout::format::phrases;
use landfall_layout::layout::targets;

pub use crate::report::schema::BENCH_SCHEMA;

/// The header line of [`csv`].
pub const HEADER: &str = "variant,backend,device,clock,\
ns_per_light,ns_per_light_lower,ns_per_light_upper,ns_per_light_min,\
ns_per_fragment,ns_per_fragment_lower,ns_per_fragment_upper,ns_per_fragment_min,rounds,\
err_max_steps,err_p999_steps,err_median_steps,err_max_ulp,err_p999_ulp,err_median_ulp,\
ends_max_steps,ends_max_ulp,ends_non_finite,\
permitted_max_steps,permitted_p999_steps,permitted_unsure,permitted_samples,\
flips,channels,err_max_code,differing,non_finite,undefined,\
evaluations,evaluations_error,slots,powers,operations,bytes,dominated_by,assumed_target\n";

/// Returns which variants are the fastest and the most accurate, and a table for each runner: of
/// its first columns, or of all with `details` and what the figures rest on.
pub fn text(bench: &Bench, details: bool, paint: Paint) -> String {
    let mut text = String::new();
    let Bench { subject, truth, unit, fragments, lights, inputs, machine, rows, failed } = bench;
    let (subject, number) = (paint.text(STRONG, subject), phrases::number(*fragments));
    let _ = write!(text, "{subject}  {number} {}s", unit.name());
    if *lights > 0 {
        let _ = write!(text, ", {}", phrases::counted(*lights as usize, "light"));
    }
    text.push('\n');
    for line in summary::lines(bench) {
        let _ = writeln!(text, "{}", paint.text(STRONG, &line));
    }
    if details {
        let against = wrapped(&format!("errors against {truth}"), WIDTH);
        against.iter().for_each(|line| _ = writeln!(text, "{line}"));
        for line in inputs.iter().flat_map(|inputs| wrapped(&sampled(inputs), WIDTH)) {
            let _ = writeln!(text, "{line}");
        }
        let rounds = rows.iter().map(|row| row.fragment.rounds).max();
        for line in wrapped(&about(machine, rounds), WIDTH) {
            let _ = writeln!(text, "{}", paint.text(FAINT, &line));
        }
    } else if !machine.optimised {
        for line in wrapped(UNOPTIMISED, WIDTH) {
            let _ = writeln!(text, "{}", paint.text(CAUTION, &line));
        }
    }
    // Variants may be of different shaders, and only some of them test `VULKAN`.
    let mut assumed: Vec<String> = Vec::new();
    for row in rows {
        let note = targets::note(row.assumed_target);
        assumed.extend(note.map(|note| format!("{}: {note}", row.variant)));
    }
    assumed.dedup();
    for line in assumed.iter().flat_map(|line| wrapped(line, WIDTH)) {
        let _ = writeln!(text, "{}", paint.text(CAUTION, &line));
    }
    // A table for each runner, since times on different clocks cannot be compared.
    let mut runners: Vec<&Runner> = Vec::new();
    for row in rows {
        if !runners.contains(&&row.runner) {
            runners.push(&row.runner);
        }
    }
    for runner in runners {
        let _ = writeln!(
            text,
            "\n{}  {}",
            paint.text(HEADING, &runner.backend),
            paint.text(PLAIN, &format!("{}; {} time", device(runner), runner.clock.name()))
        );
        let rows: Vec<&BenchRow> = rows.iter().filter(|row| row.runner == *runner).collect();
        table(&rows, *unit, details, paint, &mut text);
        if details {
            rows.iter().flat_map(|row| worst(row)).for_each(|line| _ = writeln!(text, "{line}"));
        }
    }
    for line in legend(rows, details).iter().flat_map(|line| wrapped(line, WIDTH)) {
        let _ = writeln!(text, "{}", paint.text(FAINT, &line));
    }
    for failed in failed {
        let line = format!("{} on {}: {}", failed.variant, failed.backend, failed.reason);
        let _ = writeln!(text, "\n{}", paint.text(CAUTION, &line));
    }
    text
}

/// Returns what columns mean that are easily misread, where they are there.
fn legend(rows: &[BenchRow], details: bool) -> Vec<&'static str> {
    // A line of the legend is printed only where what it explains is there.
    let is = |of: &dyn Fn(&BenchRow) -> bool| rows.iter().any(of);
    let above_one = |row: &BenchRow| row.errors.max_steps.is_some_and(|steps| steps > 1.0);
    let lines = [
        (is(&is_marked), "* no other variant is better than it in one column and worse in none"),
        (
            is(&|row| row.subtracted && row.fragment.lower <= 0.0),
            "a net time of 0 or less: no longer than that of an empty shader or function",
        ),
        (
            is(&above_one),
            "a step is 1/255 of full scale: from 1 on, an error shows in 8-bit colours",
        ),
        (
            details && is(&|row| row.permitted.is_some()),
            "permitted: the error in steps that WGSL and Vulkan allow a device; unsure: samples in \
             which a device may take another branch",
        ),
        (
            details && is(&|row| !row.dominated_by.is_empty()),
            "dominated by: a variant that is better in a column, worse in none, and whose quartiles \
             of time do not lie above",
        ),
    ];
    let shown = lines.into_iter().filter(|(is, _)| *is).map(|(_, line)| line).collect::<Vec<_>>();
    if shown.is_empty() { shown } else { [&[""][..], &shown].concat() }
}

/// Returns the samples whose errors are measured, and how their inputs are distributed.
fn sampled(inputs: &SampledInputs) -> String {
    let SampledInputs { distributions, drawn, ends } = inputs;
    let mut line = format!("errors of {}", phrases::numbered(*drawn, "sample"));
    if *ends > 0 {
        let _ = write!(line, ", and apart of {} at ends of ranges", phrases::number(*ends));
    }
    if !distributions.is_empty() {
        let _ = write!(line, "; inputs: {}", distributed(distributions));
    }
    line
}

/// Returns the distribution of each input, those of one distribution together.
pub(super) fn distributed(distributions: &[DistributedInput]) -> String {
    let mut alike: Vec<(&str, Vec<&str>)> = Vec::new();
    for DistributedInput { path, distribution } in distributions {
        match alike.iter_mut().find(|(known, _)| known == distribution) {
            Some((_, paths)) => paths.push(path),
            None => alike.push((distribution, vec![path])),
        }
    }
    let each =
        alike.iter().map(|(distribution, paths)| format!("{} {distribution}", paths.join(", ")));
    each.collect::<Vec<String>>().join("; ")
}

/// The longest list of inputs; JSON has all.
const INPUTS: usize = 2 * WIDTH;

/// Returns the inputs of a row's largest errors in units of the last place.
fn worst(row: &BenchRow) -> Vec<String> {
    let of = |worst: &WorstCall| {
        // Calls at the ends of ranges are measured apart from those drawn.
        let place = match worst.of {
            SampleSet::Drawn => "max ulp",
            SampleSet::Ends => "ends ulp",
        };
        let inputs = worst.inputs.iter().map(|(path, value)| format!("{path} = {value}"));
        let inputs = inputs.collect::<Vec<String>>().join(", ");
        // At a character, as names may not be ASCII.
        let cut = match inputs.char_indices().nth(INPUTS) {
            Some((at, _)) => format!("{}…", &inputs[..at]),
            None => inputs,
        };
        wrapped(&format!("{} {place}: {cut}", row.variant), WIDTH - 4)
    };
    let of_ulp = row.worst.iter().filter(|worst| worst.measure == ErrorMeasure::Ulp);
    let lines = of_ulp.flat_map(of);
    lines.map(|line| format!("    {line}")).collect()
}

/// The device of a runner; the interpreter by the name that all reports for people use.
fn device(runner: &Runner) -> String {
    match runner.device.split_once(", ") {
        Some((_, driver)) if runner.backend == BackendKind::Cpu.name() => {
            format!("interpreter, {driver}")
        }
        _ => runner.device.clone(),
    }
}

/// What a build without optimisation means.
const UNOPTIMISED: &str =
    "built without optimisation: times of Rust variants are not representative";

/// Returns the machine it was measured on and the number of rounds, if rows have rounds.
fn about(machine: &Machine, rounds: Option<u32>) -> String {
    let Machine { processor, threads, system, load, optimised } = machine;
    let mut line = format!("{system}, {threads} threads");
    if let Some(processor) = processor {
        let _ = write!(line, ", {processor}");
    }
    if let Some([before, after]) = load {
        let _ = write!(line, "; load {before} before, {after} after");
    }
    if let Some(rounds) = rounds {
        let _ = write!(line, "; {rounds} interleaved rounds; medians and quartiles");
    }
    if !optimised {
        line.push_str("; ");
        line.push_str(UNOPTIMISED);
    }
    line
}

/// The error cell of a variant without comparable results.
const NOTHING: &str = "-";

/// A column of a table: its heading and its cells.
struct Column {
    heading: &'static str,
    cells: Vec<String>,
}

/// Whether no other variant is better than it.
fn is_marked(row: &BenchRow) -> bool {
    row.dominated_by.is_empty() && !row.errors.is_no_number()
}

fn table(rows: &[&BenchRow], unit: Unit, details: bool, paint: Paint, text: &mut String) {
    let column = |heading, of: &dyn Fn(&BenchRow) -> String| Column {
        heading,
        cells: rows.iter().map(|row| of(row)).collect(),
    };
    let optional = |value: Option<f64>| value.map(phrases::figure).unwrap_or_default();
    // Nothing to compare is not an error of 0.
    let steps =
        |value: Option<f64>| value.map(phrases::figure).unwrap_or_else(|| NOTHING.to_string());
    let subtracted = rows.iter().any(|row| row.subtracted);
    let time = match (unit, subtracted) {
        (Unit::Fragment, true) => "ns/fragment net",
        (Unit::Fragment, false) => "ns/fragment",
        (Unit::Call, true) => "ns/call net",
        (Unit::Call, false) => "ns/call",
    };
    let permitted = |row: &BenchRow, of: fn(&Permitted) -> Option<f64>| {
        row.permitted.map_or_else(String::new, |permitted| {
            of(&permitted).map_or_else(|| "any".to_string(), phrases::figure)
        })
    };
    let unsure = |permitted: Permitted| match permitted.unsure {
        0 => "0 %".to_string(),
        n => format!("{} %", phrases::figure(100.0 * n as f64 / permitted.samples.max(1) as f64)),
    };
    let columns = [
        column("variant", &|row| row.variant.clone()),
        column("ns/light", &|row| row.light.as_ref().map(spread).unwrap_or_default()),
        column(time, &|row| spread(&row.fragment)),
        column("median ulp", &|row| optional(row.errors.median_ulp)),
        column("max ulp", &|row| optional(row.errors.max_ulp)),
        column("99.9 % ulp", &|row| optional(row.errors.p999_ulp)),
        column("max step", &|row| steps(row.errors.max_steps)),
        column("99.9 % step", &|row| steps(row.errors.p999_steps)),
        column("permitted", &|row| permitted(row, |permitted| permitted.max_steps)),
        column("permitted 99.9 %", &|row| permitted(row, |permitted| permitted.p999_steps)),
        column("unsure", &|row| row.permitted.map(unsure).unwrap_or_default()),
        column("flips", &|row| {
            let share = row.errors.flip_share();
            share.map_or_else(String::new, |share| format!("{} %", phrases::figure(100.0 * share)))
        }),
        column("differing", &|row| row.errors.differing.map(phrases::number).unwrap_or_default()),
        column("non-finite", &|row| phrases::number(row.errors.non_finite)),
        column("undefined", &|row| phrases::number(row.errors.undefined)),
        column("ends ulp", &|row| optional(row.ends.and_then(|ends| ends.max_ulp))),
        column("ends step", &|row| optional(row.ends.and_then(|ends| ends.max_steps))),
        column("ends non-finite", &|row| {
            row.ends.map(|ends| phrases::number(ends.non_finite)).unwrap_or_default()
        }),
        column("lights", &|row| optional(row.work.evaluations)),
        column("slots", &|row| optional(row.work.slots)),
        column("powers", &|row| optional(row.work.powers)),
        column("operations", &|row| optional(row.work.operations)),
        column("bytes", &|row| row.work.bytes.map(phrases::number).unwrap_or_default()),
        column("dominated by", &dominated_by),
    ];
    // Empty columns are left out.
    let columns: Vec<&Column> =
        columns.iter().filter(|column| column.cells.iter().any(|cell| !cell.is_empty())).collect();
    let widths: Vec<usize> = columns
        .iter()
        .map(|column| {
            let cells = column.cells.iter().map(|cell| cell.width());
            cells.max().unwrap_or(0).max(column.heading.width())
        })
        .collect();
    let line = |shown: &[usize], cell: &dyn Fn(&Column) -> String| -> String {
        let mut line = String::new();
        for &at in shown {
            let (cell, column) = (cell(columns[at]), columns[at]);
            let pad = " ".repeat(widths[at] - cell.width());
            // Text is aligned to the left, numbers to the right.
            match column.heading {
                "variant" | "dominated by" => line += &format!("{GAP}{cell}{pad}"),
                _ => line += &format!("{GAP}{pad}{cell}"),
            }
        }
        line.trim_end().to_string()
    };
    // Without details, only the first part of the columns is printed.
    let most = if details { usize::MAX } else { 1 };
    for shown in parts(&widths).into_iter().take(most) {
        let headings = line(&shown, &|column| column.heading.to_string());
        let _ = writeln!(text, " {}", paint.text(FAINT, &headings));
        for (i, row) in rows.iter().enumerate() {
            let cells = line(&shown, &|column| column.cells[i].clone());
            let (mark, style) = match is_marked(row) {
                true => ("*", PLAIN),
                false => (" ", FAINT),
            };
            let _ = writeln!(text, "{mark}{}", paint.text(style, &cells));
        }
    }
}

/// Splits the columns of a table into parts that fit the line, each with the first column.
fn parts(widths: &[usize]) -> Vec<Vec<usize>> {
    let taken = |width: &usize| GAP.len() + width;
    let first = 1 + widths.first().map_or(0, taken);
    let mut parts = vec![vec![0]];
    let mut end = first;
    for (column, width) in widths.iter().enumerate().skip(1) {
        let part = parts.last_mut().expect("never empty");
        if part.len() > 1 && end + taken(width) > WIDTH {
            parts.push(vec![0, column]);
            end = first + taken(width);
        } else {
            part.push(column);
            end += taken(width);
        }
    }
    parts
}

/// The first variant that is better, and the number of others; JSON and CSV name all.
fn dominated_by(row: &BenchRow) -> String {
    match row.dominated_by.as_slice() {
        [] => String::new(),
        [one] => one.clone(),
        [first, others @ ..] => format!("{first} and {} more", others.len()),
    }
}

fn spread(spread: &Spread) -> String {
    let Spread { median, lower, upper, .. } = spread;
    format!(
        "{} ({} to {})",
        phrases::figure(*median),
        phrases::figure(*lower),
        phrases::figure(*upper)
    )
}

/// Returns a bench as CSV: a line for each variant, numbers in full.
pub fn csv(bench: &Bench) -> String {
    let mut text = HEADER.to_string();
    for row in &bench.rows {
        let BenchRow { variant, runner, light, fragment, .. } = row;
        let BenchRow { errors, ends, permitted, work, dominated_by, .. } = row;
        let four = |spread: Option<&Spread>| -> [String; 4] {
            spread.map_or_else(Default::default, |s| {
                [s.median, s.lower, s.upper, s.min].map(|number| number.to_string())
            })
        };
        let optional = |number: Option<f64>| number.map_or(String::new(), |n| n.to_string());
        let whole = |number: Option<u64>| number.map_or(String::new(), |n| n.to_string());
        // An unbounded error is written so that every CSV parser reads it as a number.
        let steps = |of: fn(&Permitted) -> Option<f64>| {
            optional(permitted.map(|permitted| of(&permitted).unwrap_or(f64::INFINITY)))
        };
        let mut cells = vec![
            variant.clone(),
            runner.backend.clone(),
            runner.device.clone(),
            runner.clock.name().to_string(),
        ];
        cells.extend(four(light.as_ref()));
        cells.extend(four(Some(fragment)));
        cells.extend([
            fragment.rounds.to_string(),
            optional(errors.max_steps),
            optional(errors.p999_steps),
            optional(errors.median_steps),
            optional(errors.max_ulp),
            optional(errors.p999_ulp),
            optional(errors.median_ulp),
            optional(ends.and_then(|ends| ends.max_steps)),
            optional(ends.and_then(|ends| ends.max_ulp)),
            whole(ends.map(|ends| ends.non_finite)),
            steps(|permitted| permitted.max_steps),
            steps(|permitted| permitted.p999_steps),
            whole(permitted.map(|permitted| permitted.unsure)),
            whole(permitted.map(|permitted| permitted.samples)),
            whole(errors.flips),
            errors.channels.to_string(),
            whole(errors.max_code.map(u64::from)),
            whole(errors.differing),
            errors.non_finite.to_string(),
            errors.undefined.to_string(),
            optional(work.evaluations),
            optional(work.evaluations_error),
            optional(work.slots),
            optional(work.powers),
            optional(work.operations),
            whole(work.bytes),
            dominated_by.join(" "),
            row.assumed_target.map(targets::key).unwrap_or_default().to_string(),
        ]);
        let cells: Vec<String> = cells.into_iter().map(quoted).collect();
        let _ = writeln!(text, "{}", cells.join(","));
    }
    text
}

/// The result of `landfall bench`: variants on backends, time against error.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct Object<'a> {
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA_VERSION)))]
    schema_version: u32,
    tool: Tool,
    #[serde(flatten)]
    bench: &'a Bench,
}

/// The schema of [`BENCH_SCHEMA`].
#[cfg(feature = "schema")]
#[doc(hidden)]
pub fn schema() -> String {
    landfall_layout::schema::text::<Object<'_>>("landfall bench --format json")
}

/// Returns a bench as JSON, in the form of `landfall schema bench`.
pub fn json(bench: &Bench) -> String {
    let object = Object { schema_version: SCHEMA_VERSION, tool: Tool::LANDFALL, bench };
    format!("{}\n", to_lines(&object, 0))
}
