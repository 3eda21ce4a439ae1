//! The report of `landfall devices`: the available backends and devices, as a table or as JSON.
//!
//! Formats the data of [`backend::devices`](landfall_exec::backend::devices).

use serde::Serialize;
use unicode_width::UnicodeWidthStr as _;

use landfall_exec::backend::devices::{Found, Limits};
use landfall_exec::backend::{Device, Failure};
pub use landfall_layout::format::columns;
pub use landfall_layout::format::columns::GAP;
use landfall_layout::format::json::{Tool, to_lines};
pub use landfall_layout::format::paint::{CAUTION, FAINT, PLAIN, STRONG};
use landfall_layout::format::{Paint, SCHEMA_VERSION};

const COLUMNS: usize = 10;
const TITLES: [&str; COLUMNS] = [
    "backend",
    "kind",
    "adapter",
    "driver",
    "version",
    "runs on",
    "uniform block",
    "storage block",
    "push constants",
    "image side",
];
/// The first column of numbers, which are aligned to the right.
const NUMBERS: usize = 6;
/// The column in which the failure of a missing device starts.
const ADAPTER: usize = 2;

/// Returns a table with a row for each device; sizes are in bytes.
pub fn table(found: &[Found], paint: Paint) -> String {
    let rows: Vec<Row<'_>> = found.iter().map(Row::of).collect();
    let mut widths = TITLES.map(str::width);
    for row in &rows {
        if let Row::There(cells) = row {
            for (width, cell) in widths.iter_mut().zip(cells) {
                *width = (*width).max(cell.width());
            }
        }
    }
    for (found, width) in found.iter().flat_map(|f| [(f.backend.name(), 0), (f.kind.as_str(), 1)]) {
        widths[width] = widths[width].max(found.width());
    }
    let mut text = columns::row(&TITLES.map(String::from), &widths, NUMBERS, |_, cell| {
        paint.text(FAINT, cell)
    });
    for (row, found) in rows.iter().zip(found) {
        match row {
            Row::There(cells) => {
                text.push_str(&columns::row(cells, &widths, NUMBERS, |_, cell| {
                    paint.text(PLAIN, cell)
                }));
            }
            Row::Missing(failure) => {
                let start = [found.backend.name(), found.kind.as_str()].map(String::from);
                let mut start =
                    columns::row(&start, &widths, NUMBERS, |_, cell| paint.text(PLAIN, cell));
                start.truncate(start.trim_end().len());
                let indent = widths[..ADAPTER].iter().map(|w| w + GAP.len()).sum();
                text.push_str(&start);
                text.push_str(&" ".repeat(usize::saturating_sub(indent, start.width())));
                text.push_str(&paint.text(CAUTION, "missing: "));
                text.push_str(&paint.text(STRONG, &failure.message));
                text.push('\n');
                for log in failure.log.lines().filter(|line| !line.trim().is_empty()) {
                    text.push_str(&" ".repeat(indent));
                    text.push_str(&paint.text(FAINT, log));
                    text.push('\n');
                }
            }
        }
    }
    text
}

/// Returns the JSON document, one device a line.
pub fn json(found: &[Found]) -> String {
    let document = Document {
        schema_version: SCHEMA_VERSION,
        tool: Tool::LANDFALL,
        devices: found.iter().map(Entry::of).collect(),
    };
    let mut text = to_lines(&document, 0);
    text.push('\n');
    text
}

enum Row<'a> {
    There(Vec<String>),
    Missing(&'a Failure),
}

impl Row<'_> {
    /// A row with one cell per column.
    fn of(found: &Found) -> Row<'_> {
        let (device, limits) = match &found.outcome {
            Ok(there) => there,
            Err(failure) => return Row::Missing(failure),
        };
        let number = |limit: Option<u64>| limit.map_or("-".to_string(), |limit| limit.to_string());
        Row::There(vec![
            found.backend.to_string(),
            if found.kind.is_empty() { "-".to_string() } else { found.kind.clone() },
            device.adapter.clone(),
            device.driver.clone(),
            device.version.clone(),
            runs_on(device).to_string(),
            number(limits.uniform_block_size),
            number(limits.storage_block_size),
            number(limits.push_constant_size),
            number(limits.image_side),
        ])
    }
}

fn runs_on(device: &Device) -> &'static str {
    if device.software { "processor" } else { "hardware" }
}

#[derive(Serialize)]
struct Document<'a> {
    schema_version: u32,
    tool: Tool,
    devices: Vec<Entry<'a>>,
}

#[derive(Serialize)]
struct Entry<'a> {
    #[serde(rename = "reader")]
    backend: &'a str,
    kind: Option<&'a str>,
    available: bool,
    #[serde(flatten)]
    outcome: Outcome<'a>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Outcome<'a> {
    There {
        adapter: &'a str,
        driver: &'a str,
        version: &'a str,
        software: bool,
        limits: &'a Limits,
    },
    Missing {
        message: &'a str,
        log: &'a str,
    },
}

impl Entry<'_> {
    fn of(found: &Found) -> Entry<'_> {
        let outcome = match &found.outcome {
            Ok((device, limits)) => Outcome::There {
                adapter: &device.adapter,
                driver: &device.driver,
                version: &device.version,
                software: device.software,
                limits,
            },
            Err(failure) => Outcome::Missing { message: &failure.message, log: &failure.log },
        };
        let kind = Some(found.kind.as_str()).filter(|kind| !kind.is_empty());
        Entry { backend: found.backend.name(), kind, available: found.outcome.is_ok(), outcome }
    }
}

#[cfg(test)]
mod tests {
    use landfall_exec::backend::BackendKind;

    use super::*;
    use landfall_exec::backend::devices::cpu;

    #[test]
    fn columns_line_up_and_what_is_missing_says_why() {
        let missing = |kind: &str| Found {
            backend: BackendKind::Gpu,
            kind: kind.to_string(),
            outcome: Err(Failure::missing("no Vulkan adapter", "loader: nothing\n")),
        };
        let mut gl = cpu();
        (gl.backend, gl.kind) = (BackendKind::Gl, "compat 4.5".to_string());
        if let Ok((_, limits)) = &mut gl.outcome {
            limits.uniform_block_size = Some(65536);
        }
        let text = table(&[cpu(), gl, missing("vulkan"), missing("")], Paint::Plain);
        let version = env!("CARGO_PKG_VERSION");
        let expected = format!(
            "\
backend  kind        adapter    driver    version  runs on    uniform block  storage block  push constants  image side
cpu      -           evaluator  landfall  {version}    processor              -              -               -           -
gl       compat 4.5  evaluator  landfall  {version}    processor          65536              -               -           -
gpu      vulkan      missing: no Vulkan adapter
                     loader: nothing
gpu                  missing: no Vulkan adapter
                     loader: nothing
"
        );
        assert_eq!(text, expected);
    }
}
