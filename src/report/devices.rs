//! The report of `landfall devices`: the available backends and devices, as a table or as JSON.
//!
//! Formats the data of [`backend::devices`](landfall_exec::backend::devices).

use anstyle::Style;
use serde::Serialize;
use unicode_width::UnicodeWidthStr as _;

use landfall_exec::backend::devices::{BackendEntry, Limits};
use landfall_exec::backend::{BackendKind, Device};
use landfall_layout::format::columns::{GAP, WIDTH, wrapped};
use landfall_layout::format::json::{Tool, to_lines};
pub use landfall_layout::format::paint::{CAUTION, FAINT, PLAIN, STRONG};
use landfall_layout::format::{Paint, SCHEMA_VERSION, phrases};

use landfall_exec::report::device::adapter;

/// The headings; what is known of a device is below the last one, on lines of its own.
const TITLES: [&str; 3] = ["backend", "kind", "adapter"];

/// Returns a table with a row for each device: its adapter, its driver and its limits below each
/// other.
pub fn table(found: &[BackendEntry], paint: Paint) -> String {
    let kind =
        |found: &BackendEntry| if found.kind.is_empty() { "-" } else { &found.kind }.to_string();
    let starts: Vec<[String; 2]> =
        found.iter().map(|found| [found.backend.to_string(), kind(found)]).collect();
    let mut widths = [TITLES[0].width(), TITLES[1].width()];
    for start in &starts {
        for (width, cell) in widths.iter_mut().zip(start) {
            *width = (*width).max(cell.width());
        }
    }
    let indent: usize = widths.iter().map(|width| width + GAP.len()).sum();
    let row = |start: [&str; 2], lines: &[(Style, String)]| {
        let mut text = String::new();
        for (cell, width) in start.iter().zip(widths) {
            text.push_str(&format!("{cell}{}{GAP}", " ".repeat(width - cell.width())));
        }
        let wrapped = lines.iter().flat_map(|(style, line)| {
            let parts = wrapped(line, WIDTH.saturating_sub(indent));
            parts.into_iter().map(|part| paint.text(*style, &part))
        });
        let wrapped: Vec<String> = wrapped.collect();
        text + &wrapped.join(&format!("\n{}", " ".repeat(indent))) + "\n"
    };
    let mut text = row([TITLES[0], TITLES[1]], &[(PLAIN, TITLES[2].to_string())]);
    text = format!("{}\n", paint.text(FAINT, text.trim_end()));
    for (found, [backend, kind]) in found.iter().zip(&starts) {
        text.push_str(&row([backend, kind], &described(found)));
    }
    text
}

/// The lines about a device, or the reason it is missing, each with its style.
fn described(found: &BackendEntry) -> Vec<(Style, String)> {
    let (device, limits) = match &found.outcome {
        Ok(there) => there,
        Err(failure) => {
            // The whole log, which may name a missing library.
            let log = failure.log.lines().filter(|line| !line.trim().is_empty());
            let log = log.map(|line| (FAINT, line.to_string()));
            return std::iter::once((CAUTION, format!("missing: {}", failure.message)))
                .chain(log)
                .collect();
        }
    };
    let sizes = [
        ("uniform block", limits.uniform_block_size, "bytes"),
        ("storage block", limits.storage_block_size, "bytes"),
        ("push constants", limits.push_constant_size, "bytes"),
        ("image side", limits.image_side, "pixels"),
    ];
    // A limit that a backend does not report is left out.
    let sizes = sizes.iter().filter_map(|(what, most, unit)| {
        most.map(|most| format!("{what} {} {unit}", phrases::number(most)))
    });
    let sizes: Vec<String> = sizes.collect();
    let driver = [&device.driver, &device.version].map(|part| part.trim());
    let driver = driver.into_iter().filter(|part| !part.is_empty());
    let mut about: Vec<String> = driver.map(str::to_string).collect();
    about.insert(0, "driver".to_string());
    let about = format!("{}, on {}", about.join(" "), runs_on(device));
    let mut lines = vec![(STRONG, adapter(device).to_string()), (PLAIN, about)];
    if !sizes.is_empty() {
        lines.push((FAINT, format!("limits: {}", sizes.join(", "))));
    }
    lines
}

fn runs_on(device: &Device) -> &'static str {
    if device.software { "the processor" } else { "hardware" }
}

/// The schema of [`DEVICES_SCHEMA`](super::schema::DEVICES_SCHEMA).
#[cfg(feature = "schema")]
#[doc(hidden)]
pub fn schema() -> String {
    landfall_layout::schema::text::<DevicesDocument<'_>>("landfall devices --format json")
}

/// Returns the JSON document, one device a line.
pub fn json(found: &[BackendEntry]) -> String {
    let document = DevicesDocument {
        schema_version: SCHEMA_VERSION,
        tool: Tool::LANDFALL,
        devices: found.iter().map(DeviceEntry::new).collect(),
    };
    let mut text = to_lines(&document);
    text.push('\n');
    text
}

/// The backends and devices of this machine, and the missing ones with the reason. Sizes are in
/// bytes.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct DevicesDocument<'a> {
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA_VERSION)))]
    schema_version: u32,
    tool: Tool,
    /// The interpreter first, then the kinds of OpenGL context, then the adapters of each backend
    /// of wgpu.
    devices: Vec<DeviceEntry<'a>>,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct DeviceEntry<'a> {
    backend: BackendKind,
    kind: Option<&'a str>,
    #[serde(flatten)]
    outcome: OpenOutcome<'a>,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
enum OpenOutcome<'a> {
    There {
        #[cfg_attr(feature = "schema", schemars(extend("const" = true)))]
        available: bool,
        /// The adapter's name; `landfall evaluator` is the interpreter of landfall.
        adapter: &'a str,
        driver: &'a str,
        /// The driver's version, in its own notation.
        version: &'a str,
        /// Whether it computes on the processor.
        software: bool,
        limits: &'a Limits,
    },
    Missing {
        #[cfg_attr(feature = "schema", schemars(extend("const" = false)))]
        available: bool,
        /// The reason it is missing.
        message: &'a str,
        /// The messages of the driver or its loader; may be empty.
        log: &'a str,
    },
}

impl DeviceEntry<'_> {
    fn new(found: &BackendEntry) -> DeviceEntry<'_> {
        let outcome = match &found.outcome {
            Ok((device, limits)) => OpenOutcome::There {
                available: true,
                adapter: &device.adapter,
                driver: &device.driver,
                version: &device.version,
                software: device.software,
                limits,
            },
            Err(failure) => OpenOutcome::Missing {
                available: false,
                message: &failure.message,
                log: &failure.log,
            },
        };
        let kind = Some(found.kind.as_str()).filter(|kind| !kind.is_empty());
        DeviceEntry { backend: found.backend, kind, outcome }
    }
}

#[cfg(test)]
mod tests {
    use landfall_exec::backend::Failure;

    use super::*;
    use landfall_exec::backend::devices::cpu;

    #[test]
    fn rows_fit_80_columns_and_what_is_missing_says_why() {
        let missing = |kind: &str| BackendEntry {
            backend: BackendKind::Gpu,
            kind: kind.to_string(),
            outcome: Err(Failure::missing("no Vulkan adapter", "loader: nothing\n")),
        };
        let mut gl = cpu();
        (gl.backend, gl.kind) = (BackendKind::Gl, "compat 4.5".to_string());
        if let Ok((device, limits)) = &mut gl.outcome {
            device.backend = BackendKind::Gl;
            device.adapter = "llvmpipe (LLVM 15.0.6, 256 bits)".to_string();
            limits.uniform_block_size = Some(65536);
            limits.storage_block_size = Some(134_217_728);
        }
        let text = table(&[cpu(), gl, missing("vulkan"), missing("")], Paint::Plain);
        let version = env!("CARGO_PKG_VERSION");
        let expected = format!(
            "\
backend  kind        adapter
cpu      -           interpreter
                     driver landfall {version}, on the processor
gl       compat 4.5  llvmpipe (LLVM 15.0.6, 256 bits)
                     driver landfall {version}, on the processor
                     limits: uniform block 65,536 bytes, storage block
                     134,217,728 bytes
gpu      vulkan      missing: no Vulkan adapter
                     loader: nothing
gpu      -           missing: no Vulkan adapter
                     loader: nothing
"
        );
        assert_eq!(text, expected);
    }
}
