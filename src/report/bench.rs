//! The report of `landfall bench`: time against error, as a table, CSV and JSON.
//!
//! Formats the data of [`accuracy::bench`](landfall_accuracy::bench).

mod csv;
mod summary;

use std::fmt::Write as _;

use serde::Serialize;
use unicode_width::UnicodeWidthStr;

use super::brief::{LINES, cut};
use landfall_accuracy::bench::{
    Bench, BenchRow, DistributedInput, ErrorMeasure, Machine, Permitted, Runner, SampleSet,
    SampledInputs, Spread, Unit, WorstCall,
};
use landfall_exec::backend::BackendKind;
use landfall_layout::format::SCHEMA_VERSION;
use landfall_layout::format::columns::{GAP, WIDTH, wrapped};
use landfall_layout::format::json::{Tool, to_lines};
pub use landfall_layout::format::paint::{CAUTION, FAINT, HEADING, PLAIN, Paint, STRONG};
pub use landfall_layout::format::phrases;
use landfall_layout::layout::targets;

pub use crate::report::schema::BENCH_SCHEMA;
pub use csv::{HEADER, csv};

/// Returns which variant wins on each backend, and what fits ten lines of a table; with `details` all
/// columns, a table for each runner, and what the figures rest on.
pub fn text(bench: &Bench, details: bool, paint: Paint) -> String {
    let mut text = String::new();
    let Bench { subject, unit, fragments, lights, rows, failed, .. } = bench;
    let (subject, number) = (paint.text(STRONG, subject), phrases::number(*fragments));
    let _ = write!(text, "{subject}  {number} {}s", unit.name());
    if *lights > 0 {
        let _ = write!(text, ", {}", phrases::counted(*lights as usize, "light"));
    }
    text.push('\n');
    for line in summary::lines(bench) {
        let _ = writeln!(text, "{}", paint.text(STRONG, &line));
    }
    let failures = failed.iter().map(|failed| {
        let line = format!("{} on {}: {}", failed.variant, failed.backend, failed.reason);
        paint.text(CAUTION, &wrapped(&line, WIDTH - 2).join("\n  "))
    });
    if !details {
        failures.for_each(|line| _ = writeln!(text, "{line}"));
        brief(bench, paint, &mut text);
        return cut(text, paint);
    }
    conditions(bench, paint, &mut text);
    for runner in runners(rows) {
        let _ = writeln!(
            text,
            "\n{}  {}",
            paint.text(HEADING, &runner.backend),
            paint.text(PLAIN, &format!("{}; {} time", device(runner), runner.clock.name()))
        );
        let rows: Vec<&BenchRow> = rows.iter().filter(|row| row.runner == *runner).collect();
        table(&columns(&rows, *unit), &rows, paint, &mut text);
        rows.iter().flat_map(|row| worst(row)).for_each(|line| _ = writeln!(text, "{line}"));
    }
    for line in legend(rows).iter().flat_map(|line| wrapped(line, WIDTH)) {
        let _ = writeln!(text, "{}", paint.text(FAINT, &line));
    }
    failures.for_each(|line| _ = writeln!(text, "\n{line}"));
    text
}

fn runners(rows: &[BenchRow]) -> Vec<&Runner> {
    let mut runners: Vec<&Runner> = Vec::new();
    for row in rows {
        if !runners.contains(&&row.runner) {
            runners.push(&row.runner);
        }
    }
    runners
}

/// Appends what the figures rest on: the truth, the inputs, the machine, and assumed APIs.
fn conditions(bench: &Bench, paint: Paint, text: &mut String) {
    let Bench { truth, inputs, machine, rows, .. } = bench;
    let against = wrapped(&format!("errors against {truth}"), WIDTH);
    against.iter().for_each(|line| _ = writeln!(text, "{line}"));
    for line in inputs.iter().flat_map(|inputs| wrapped(&sampled(inputs), WIDTH)) {
        let _ = writeln!(text, "{line}");
    }
    let rounds = rows.iter().map(|row| row.fragment.rounds).max();
    for line in wrapped(&about(machine, rounds), WIDTH) {
        let _ = writeln!(text, "{}", paint.text(FAINT, &line));
    }
    for line in assumed(rows).iter().flat_map(|line| wrapped(line, WIDTH)) {
        let _ = writeln!(text, "{}", paint.text(CAUTION, &line));
    }
}

/// Returns the APIs that are assumed of shaders that name none.
fn assumed(rows: &[BenchRow]) -> Vec<String> {
    let of = |row: &BenchRow| {
        targets::note(row.assumed_target).map(|note| format!("{}: {note}", row.variant))
    };
    let mut assumed: Vec<String> = rows.iter().filter_map(of).collect();
    assumed.dedup();
    assumed
}

/// Appends the rows of all runners that fit the brief report, as many of their columns as fit the line,
/// and the way to the rest.
fn brief(bench: &Bench, paint: Paint, text: &mut String) {
    let mut notes = assumed(&bench.rows);
    if !bench.machine.optimised {
        notes.push(UNOPTIMISED.to_string());
    }
    for line in notes.iter().flat_map(|line| wrapped(line, WIDTH)) {
        let _ = writeln!(text, "{}", paint.text(CAUTION, &line));
    }
    let legend = "* no other variant is better than it in one column and worse in none; ";
    // The legend takes two lines, the headings one.
    let room = LINES.saturating_sub(text.lines().count() + 3);
    let mut rows: Vec<&BenchRow> = bench.rows.iter().collect();
    if rows.len() > room {
        rows.sort_by_key(|row| !is_marked(row));
        rows.truncate(room);
    }
    if !rows.is_empty() {
        let mut all = columns(&rows, bench.unit);
        let backend = rows.iter().map(|row| row.runner.backend.clone()).collect();
        all.insert(1, Column { heading: "backend", cells: backend });
        let all: Vec<Column> = all.into_iter().filter(|column| column.has_some()).collect();
        let widths: Vec<usize> = all.iter().map(Column::width).collect();
        let most = parts(&widths).first().map_or(0, Vec::len);
        table(&all[..most], &rows, paint, text);
    }
    let legend = if rows.iter().any(|row| is_marked(row)) { legend } else { "" };
    let is_number = |row: &&BenchRow| row.errors.max_steps.is_some();
    let none = if rows.iter().all(is_number) { "" } else { NO_NUMBER };
    let what = match (bench.rows.len() - rows.len(), rows.is_empty()) {
        (0, true) => return,
        (0, false) => "all columns".to_string(),
        (left, true) => phrases::counted(left, "row"),
        (left, false) => format!("{} and all columns", phrases::counted(left, "further row")),
    };
    for line in wrapped(&format!("{legend}{none}--details prints {what}"), WIDTH) {
        let _ = writeln!(text, "{}", paint.text(FAINT, &line));
    }
}

/// Returns what columns mean that are easily misread, where they are there.
fn legend(rows: &[BenchRow]) -> Vec<&'static str> {
    let is = |of: &dyn Fn(&BenchRow) -> bool| rows.iter().any(of);
    let above_one = |row: &BenchRow| row.errors.max_steps.is_some_and(|steps| steps > 1.0);
    let lines = [
        (is(&is_marked), "* no other variant is better than it in one column and worse in none"),
        (
            is(&|row| row.subtracted && row.fragment.lower <= 0.0),
            "a net time of 0 or less: no longer than that of an empty shader or function",
        ),
        (is(&|row| row.errors.max_steps.is_none()), NO_NUMBER.trim_end_matches("; ")),
        (
            is(&above_one),
            "a step is 1/255 of full scale: from 1 on, an error shows in 8-bit colours",
        ),
        (
            is(&|row| row.permitted.is_some()),
            "permitted: the error in steps that WGSL and Vulkan allow a device; unsure: samples in \
             which a device may take another branch",
        ),
        (
            is(&|row| !row.dominated_by.is_empty()),
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

/// What that cell means.
const NO_NUMBER: &str = "- no result is a number; ";

/// A column of a table: its heading and its cells.
struct Column {
    heading: &'static str,
    cells: Vec<String>,
}

/// Whether no other variant is better than it.
fn is_marked(row: &BenchRow) -> bool {
    row.dominated_by.is_empty() && !row.errors.is_no_number()
}

impl Column {
    fn has_some(&self) -> bool {
        self.cells.iter().any(|cell| !cell.is_empty())
    }

    fn width(&self) -> usize {
        let cells = self.cells.iter().map(|cell| cell.width());
        cells.max().unwrap_or(0).max(self.heading.width())
    }
}

fn columns(rows: &[&BenchRow], unit: Unit) -> Vec<Column> {
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
    vec![
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
    ]
}

/// Appends the columns that have cells, in lines that fit the width.
fn table(columns: &[Column], rows: &[&BenchRow], paint: Paint, text: &mut String) {
    let columns: Vec<&Column> = columns.iter().filter(|column| column.has_some()).collect();
    let widths: Vec<usize> = columns.iter().map(|column| column.width()).collect();
    let line = |shown: &[usize], cell: &dyn Fn(&Column) -> String| -> String {
        let mut line = String::new();
        for &at in shown {
            let (cell, column) = (cell(columns[at]), columns[at]);
            let pad = " ".repeat(widths[at] - cell.width());
            // Text is aligned to the left, numbers to the right.
            match column.heading {
                "variant" | "backend" | "dominated by" => line += &format!("{GAP}{cell}{pad}"),
                _ => line += &format!("{GAP}{pad}{cell}"),
            }
        }
        line.trim_end().to_string()
    };
    for shown in parts(&widths) {
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
    format!("{}\n", to_lines(&object))
}
