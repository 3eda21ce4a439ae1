//! Time against error: a table for people, CSV and JSON for programs.
//!
//! Reads the plain data of [`accuracy::bench`](crate::accuracy::bench).

use std::fmt::Write as _;

use serde::Serialize;
use unicode_width::UnicodeWidthStr;

use super::SCHEMA_VERSION;
use super::json::{Tool, to_lines};
use super::paint::{CAUTION, FAINT, HEADING, PLAIN, Paint, STRONG};
use super::words;
use crate::accuracy::bench::{Bench, BenchRow, Machine, Runner, Spread};

/// The JSON Schema of [`json`].
pub const BENCH_SCHEMA: &str = include_str!("schema/bench.json");

/// What heads the lines of [`csv`].
pub const HEADER: &str = "variant,reader,device,clock,\
ns_per_light,ns_per_light_lower,ns_per_light_upper,ns_per_light_min,\
ns_per_fragment,ns_per_fragment_lower,ns_per_fragment_upper,ns_per_fragment_min,rounds,\
err_max_steps,err_p999_steps,flips,channels,err_max_code,non_finite,undefined,\
evaluations,powers,operations,bytes,dominated_by\n";

/// A table for each runner.
pub fn text(bench: &Bench, paint: Paint) -> String {
    let mut text = String::new();
    let Bench { subject, truth, fragments, lights, machine, rows, failed } = bench;
    let _ =
        write!(text, "{}  {} fragments", paint.text(STRONG, subject), words::number(*fragments));
    if *lights > 0 {
        let _ = write!(text, ", {lights} lights");
    }
    let _ = writeln!(text, "; errors against {truth}");
    let rounds = rows.iter().map(|row| row.fragment.rounds).max().unwrap_or(0);
    let _ = writeln!(text, "{}", paint.text(FAINT, &about(machine, rounds)));
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
            paint.text(HEADING, &runner.reader),
            paint.text(PLAIN, &format!("{}; {} time", runner.device, runner.clock.name()))
        );
        let rows: Vec<&BenchRow> = rows.iter().filter(|row| row.runner == *runner).collect();
        table(&rows, paint, &mut text);
    }
    for failed in failed {
        let said = format!("{} on {}: {}", failed.variant, failed.reader, failed.reason);
        let _ = writeln!(text, "\n{}", paint.text(CAUTION, &said));
    }
    text
}

fn about(machine: &Machine, rounds: u32) -> String {
    let Machine { processor, threads, system, load, optimised } = machine;
    let mut said = format!("{system}, {threads} threads");
    if let Some(processor) = processor {
        let _ = write!(said, ", {processor}");
    }
    if let Some([before, after]) = load {
        let _ = write!(said, "; load {before} before, {after} after");
    }
    let _ = write!(said, "; {rounds} rounds in turns; medians and quartiles");
    if !optimised {
        said.push_str("; built without optimisation: Rust's own times say little");
    }
    said
}

/// A column of a table: its heading and its cells.
struct Column {
    heading: &'static str,
    cells: Vec<String>,
}

fn table(rows: &[&BenchRow], paint: Paint, text: &mut String) {
    let column = |heading, of: &dyn Fn(&BenchRow) -> String| Column {
        heading,
        cells: rows.iter().map(|row| of(row)).collect(),
    };
    let optional = |value: Option<f64>| value.map(words::figure).unwrap_or_default();
    let subtracted = rows.iter().any(|row| row.subtracted);
    let columns = [
        column("variant", &|row| row.variant.clone()),
        column("ns/light", &|row| row.light.as_ref().map(spread).unwrap_or_default()),
        column(if subtracted { "ns/fragment net" } else { "ns/fragment" }, &|row| {
            spread(&row.fragment)
        }),
        column("max step", &|row| words::figure(row.errors.max_steps)),
        column("99.9 %", &|row| words::figure(row.errors.p999_steps)),
        column("flips", &|row| format!("{} %", words::figure(100.0 * row.errors.flip_share()))),
        column("no number", &|row| words::number(row.errors.non_finite)),
        column("undefined", &|row| words::number(row.errors.undefined)),
        column("lights", &|row| optional(row.work.evaluations)),
        column("powers", &|row| optional(row.work.powers)),
        column("operations", &|row| optional(row.work.operations)),
        column("bytes", &|row| row.work.bytes.map(words::number).unwrap_or_default()),
        column("better are", &|row| row.dominated_by.join(", ")),
    ];
    // A column without anything says nothing.
    let columns: Vec<&Column> =
        columns.iter().filter(|column| column.cells.iter().any(|cell| !cell.is_empty())).collect();
    let widths: Vec<usize> = columns
        .iter()
        .map(|column| {
            let cells = column.cells.iter().map(|cell| cell.width());
            cells.max().unwrap_or(0).max(column.heading.width())
        })
        .collect();
    let line = |cells: Vec<&str>| -> String {
        let mut line = String::new();
        for ((cell, width), column) in cells.iter().zip(&widths).zip(&columns) {
            let pad = " ".repeat(width - cell.width());
            // Words are read from the left, numbers from the right.
            match column.heading {
                "variant" | "better are" => line += &format!("  {cell}{pad}"),
                _ => line += &format!("  {pad}{cell}"),
            }
        }
        line.trim_end().to_string()
    };
    let headings = line(columns.iter().map(|column| column.heading).collect());
    let _ = writeln!(text, " {}", paint.text(FAINT, &headings));
    for (i, row) in rows.iter().enumerate() {
        let cells = line(columns.iter().map(|column| column.cells[i].as_str()).collect());
        let (mark, style) = match row.dominated_by.is_empty() {
            true => ("*", PLAIN),
            false => (" ", FAINT),
        };
        let _ = writeln!(text, "{mark}{}", paint.text(style, &cells));
    }
}

fn spread(spread: &Spread) -> String {
    let Spread { median, lower, upper, .. } = spread;
    format!("{} ({} to {})", words::figure(*median), words::figure(*lower), words::figure(*upper))
}

/// A line a variant, numbers in full.
pub fn csv(bench: &Bench) -> String {
    let mut text = HEADER.to_string();
    for row in &bench.rows {
        let BenchRow { variant, runner, light, fragment, errors, work, dominated_by, .. } = row;
        let four = |spread: Option<&Spread>| -> [String; 4] {
            spread.map_or_else(Default::default, |s| {
                [s.median, s.lower, s.upper, s.min].map(|number| number.to_string())
            })
        };
        let optional = |number: Option<f64>| number.map_or(String::new(), |n| n.to_string());
        let mut cells = vec![
            variant.clone(),
            runner.reader.clone(),
            runner.device.clone(),
            runner.clock.name().to_string(),
        ];
        cells.extend(four(light.as_ref()));
        cells.extend(four(Some(fragment)));
        cells.extend([
            fragment.rounds.to_string(),
            errors.max_steps.to_string(),
            errors.p999_steps.to_string(),
            errors.flips.to_string(),
            errors.channels.to_string(),
            errors.max_code.to_string(),
            errors.non_finite.to_string(),
            errors.undefined.to_string(),
            optional(work.evaluations),
            optional(work.powers),
            optional(work.operations),
            work.bytes.map_or(String::new(), |n| n.to_string()),
            dominated_by.join(" "),
        ]);
        let cells: Vec<String> = cells.iter().map(|cell| quoted(cell)).collect();
        let _ = writeln!(text, "{}", cells.join(","));
    }
    text
}

/// A cell as RFC 4180 has it.
fn quoted(cell: &str) -> String {
    match cell.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", cell.replace('"', "\"\"")),
        false => cell.to_string(),
    }
}

#[derive(Serialize)]
struct Object<'a> {
    schema_version: u32,
    tool: Tool,
    #[serde(flatten)]
    bench: &'a Bench,
}

/// A bench as JSON, as `landfall schema bench` describes it.
pub fn json(bench: &Bench) -> String {
    let object = Object { schema_version: SCHEMA_VERSION, tool: Tool::LANDFALL, bench };
    format!("{}\n", to_lines(&object, 0))
}
