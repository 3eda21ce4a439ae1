//! The report of `landfall render`: everything but the picture, as text and JSON.

mod json;

use std::fmt::Write as _;
use std::time::Duration;

use serde::Serialize;
use serde_json::Value;

use super::brief::{LINES, cut};
use super::compare;
use landfall_exec::backend::Device;
use landfall_exec::harness::fragments::FragmentCause;
use landfall_exec::harness::origins::comes_from;
use landfall_exec::report::device::about;
use landfall_interp::Counts;
use landfall_ir::analysis::hazard::Hazard;
use landfall_layout::format::columns::{WIDTH, wrapped};
pub use landfall_layout::format::paint::{CAUTION, FAINT, HEADING, PLAIN, Paint, STRONG};
use landfall_layout::format::phrases;
use landfall_layout::layout::targets;
use landfall_layout::source::Target;
use landfall_light::bind::BindingMap;
use landfall_light::culling::Plan;
use landfall_light::picture::Comparison;
use landfall_light::reference::Model;
use landfall_light::render::causes::{NonFinitePixels, PixelsByCause, UndefinedPixels};
use landfall_light::render::tally::Tally;
use landfall_light::render::truth::Truth;

pub use crate::report::schema::RENDER_SCHEMA;
pub use json::json;
#[cfg(feature = "schema")]
pub use json::schema;

/// The facts about a rendered picture.
#[derive(Clone, Debug, Default)]
pub struct RenderReport {
    /// The name of the scene.
    pub scene: String,
    /// The path of the shader; `None` for the reference.
    pub shader: Option<String>,
    /// The API assumed for a shader that names none, if its blocks depend on it.
    pub assumed_target: Option<Target>,
    /// The device that rendered it; `None` for the reference.
    pub device: Option<Device>,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Pixels covered by an object.
    pub fragments: u64,
    /// Pixels with a NaN or infinite channel.
    pub non_finite: u64,
    /// Why they are, where a shader rendered them.
    pub causes: NonFinitePixels,
    /// By undefined operation of the tally: the pixels that meet it.
    pub undefined: Vec<UndefinedPixels>,
    /// Fragments the shader discarded.
    pub discarded: u64,
    /// The number of directional, point and spot lights.
    pub lights: [usize; 3],
    /// Light evaluations over all fragments; `None` for the reference.
    pub evaluations: Option<u64>,
    /// Slots without a light that are evaluated anyway.
    pub idle: u64,
    /// Bytes of blocks uploaded.
    pub uploaded: u64,
    /// The time the backend took.
    pub time: Duration,
    /// The counts of the interpreter, where it ran.
    pub tally: Option<Tally>,
    /// The sources of the shader's members.
    pub map: Option<BindingMap>,
    /// The reference's model if a reference was requested, and whether the caller chose it.
    pub model: Option<(Model, bool)>,
    /// The plan of skipped lights.
    pub plan: Option<Plan>,
    /// Whether an option that was demanded was not applied, since its error was too large.
    pub unmet: bool,
    /// The comparisons with other pictures.
    pub compared: Vec<Compared>,
    /// The files written.
    pub written: Vec<String>,
    /// Notes for the user.
    pub notes: Vec<String>,
}

// A comparison of the picture with another one.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(rename = "JsonCompared"))]
pub struct Compared {
    /// The other picture: reference, cpu, gl, gpu, or a file.
    pub with: String,
    // The comparison.
    #[serde(flatten)]
    pub comparison: Comparison,
    // What the comparison leaves out.
    pub hazards: Vec<LeftOut>,
    /// Other causes of the difference than arithmetic.
    pub notes: Vec<String>,
}

// Fragments left out of a comparison because of a hazard.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(rename = "JsonHazard"))]
pub struct LeftOut {
    // The hazard's code.
    pub id: String,
    pub what: String,
    pub fragments: u64,
}

impl Compared {
    /// Returns the fragments that a reference leaves out, by hazard.
    pub fn hazards(truth: &Truth) -> Vec<LeftOut> {
        let left_out = |hazard: Hazard, what: &str, fragments: u64| LeftOut {
            id: hazard.code().to_string(),
            what: what.to_string(),
            fragments,
        };
        let undefined = truth.undefined.iter().map(|(undef, count)| {
            let line = undef.to_string();
            left_out(undef.hazard(), line.split_once(": ").map_or(&*line, |(_, line)| line), *count)
        });
        // Pixels at a hard edge are no fault of either picture, and are counted apart.
        let edge = "within rounding of a cone's edge";
        let edges = (truth.at_edges > 0).then(|| left_out(Hazard::ConeEdge, edge, truth.at_edges));
        undefined.chain(edges).collect()
    }
}

/// What a brief report leaves out first where it would be longer than [`LINES`].
const SPARE: [&str; 5] = ["lights", "evaluated", "time", "model", "picture"];

/// Returns the report as text; of `details`, the counts of what was executed.
pub fn text(report: &RenderReport, details: bool, paint: Paint) -> String {
    let mut rows = facts(report, details, paint);
    rows.extend(comparisons(report, details, paint));
    let written = report.written.iter();
    rows.extend(
        written.map(|file| ("wrote", format!("{} {file}\n", paint.text(HEADING, "wrote")))),
    );
    let whole =
        |rows: &[(&str, String)]| rows.iter().map(|(_, row)| row.as_str()).collect::<String>();
    if details {
        return whole(&rows);
    }
    for name in SPARE {
        if whole(&rows).lines().count() > LINES {
            rows.retain(|(of, _)| *of != name);
        }
    }
    cut(whole(&rows), paint)
}

/// Returns the rows of the picture, each with its name.
fn facts(report: &RenderReport, details: bool, paint: Paint) -> Vec<(&'static str, String)> {
    let [width, height] = report.size;
    let by = report.shader.as_deref().unwrap_or("the reference");
    let title = format!("{}  {}\n", paint.text(STRONG, &report.scene), paint.text(FAINT, by));
    let mut rows = vec![("", title)];
    if let Some(note) = targets::note(report.assumed_target) {
        rows.push(("", format!("  {}\n", paint.text(CAUTION, &note))));
    }
    let mut row = |name: &'static str, line: &str| {
        let line = match name {
            "" => line.to_string(),
            _ => wrapped(line, WIDTH - ROWS).join(&format!("\n{:ROWS$}", "")),
        };
        rows.push((name, format!("  {} {line}\n", paint.text(HEADING, &format!("{name:<11}")))));
    };
    if let Some(device) = &report.device {
        row(device.backend.name(), &paint.text(PLAIN, &about(device)));
    }
    let fragments = |n: u64| phrases::numbered(n, "fragment");
    let be = |n: u64| if n == 1 { "is" } else { "are" };
    row("picture", &format!("{width} by {height}, {}", fragments(report.fragments)));
    let [directional, point, spot] = report.lights;
    let [directional, point, spot] = [directional, point, spot].map(|n| phrases::number(n as u64));
    let has_all = details || report.compared.is_empty();
    if has_all {
        row("lights", &format!("{directional} directional, {point} point, {spot} spot"));
    }
    if let Some(evaluations) = report.evaluations.filter(|_| has_all) {
        let each = evaluations as f64 / report.fragments.max(1) as f64;
        let evaluations = phrases::numbered(evaluations, "light evaluation");
        row("evaluated", &format!("{evaluations}, {each:.2} per fragment"));
    }
    if report.idle > 0 {
        let slots = phrases::numbered(report.idle, "slot");
        let line = format!("{slots} without a light {} evaluated as zeros", be(report.idle));
        row("idle", &paint.text(CAUTION, &line));
    }
    if report.uploaded > 0 && details {
        let bytes = phrases::numbered(report.uploaded, "byte");
        row("uploaded", &format!("{bytes} of blocks"));
    }
    row("time", &format!("{:.2} s", report.time.as_secs_f64()));
    if let Some(plan) = &report.plan {
        row("skipped", &super::plan::line(plan));
    }
    if report.discarded > 0 {
        row("discarded", &fragments(report.discarded));
    }
    if report.non_finite > 0 {
        let pixels = phrases::numbered(report.non_finite, "pixel");
        let mut line = format!("{pixels} {} NaN or infinite", be(report.non_finite));
        let examined = report.causes.examined as u64;
        if (1..report.non_finite).contains(&examined) {
            let examined = phrases::number(examined);
            let _ = write!(line, ", of which {examined} were run again");
        }
        row("non-finite", &paint.text(CAUTION, &line));
        for line in causes(&report.causes) {
            row("", &line);
        }
    }
    if let Some(tally) = &report.tally {
        if details {
            operations(&tally.counts).into_iter().for_each(|(name, line)| row(name, &line));
        }
        // The NaN or infinity of an operation that is listed as undefined is not listed again.
        let each = tally.undefined.iter().enumerate();
        for (nth, found) in each.filter(|(_, found)| !found.follows(tally.undefined.iter())) {
            let times = phrases::numbered(found.count, "time");
            let line = format!("{times} {}, {}", found.kind, found.place.shown);
            row("undefined", &paint.text(CAUTION, &line));
            let pixels = report.undefined.get(nth).map(undefined_pixels);
            pixels.into_iter().flatten().for_each(|line| row("", &line));
        }
    }
    if let Some((model, chosen)) = &report.model {
        let origin = if *chosen { "" } else { "; the best match for the shader" };
        row("model", &format!("{}{origin}", model_text(model)));
    }
    rows
}

/// Returns the comparisons with other pictures.
fn comparisons(
    report: &RenderReport,
    details: bool,
    paint: Paint,
) -> impl Iterator<Item = (&'static str, String)> + use<'_> {
    report.compared.iter().map(move |compared| {
        let mut text = format!("{} {}\n", paint.text(HEADING, "against"), compared.with);
        let lines = match details {
            true => compare::human(&compared.comparison),
            false => compare::brief(&compared.comparison),
        };
        for line in lines.lines() {
            let _ = writeln!(text, "  {line}");
        }
        for LeftOut { id, what, fragments } in &compared.hazards {
            let count = phrases::numbered(*fragments, "fragment");
            let _ = writeln!(text, "  {id:<12} {count}: {what}");
        }
        for note in &compared.notes {
            let note = wrapped(note, WIDTH - ROWS - 1).join(&format!("\n{:1$}", "", ROWS + 1));
            let _ = writeln!(text, "  {:<12} {}", "note", paint.text(CAUTION, &note));
        }
        ("against", text)
    })
}

/// Returns the rows of the counts of the interpreter.
fn operations(counts: &Counts) -> Vec<(&'static str, String)> {
    let [all, arithmetic, transcendental, loads, textures] = [
        counts.operations(),
        counts.arithmetic,
        counts.transcendental,
        counts.loads,
        counts.textures,
    ]
    .map(phrases::number);
    let line = format!(
        "{all}: {arithmetic} arithmetic, {transcendental} transcendental, {loads} loads, {textures} texels"
    );
    let calls = counts
        .calls
        .iter()
        .map(|(name, count)| ("called", format!("`{name}` {}", phrases::numbered(*count, "time"))));
    std::iter::once(("operations", line)).chain(calls).collect()
}

/// Returns the lines of why pixels are NaN or infinite: share, operation, members, first pixel.
fn causes(pixels: &NonFinitePixels) -> Vec<String> {
    let mut text = Vec::new();
    for PixelsByCause { cause, pixels: count, first: [column, row] } in &pixels.causes {
        let share = phrases::figure(100.0 * *count as f64 / pixels.examined.max(1) as f64);
        let why = match cause {
            None => "finite on cpu with all lights".to_string(),
            Some(FragmentCause { is_nan, cause }) => {
                let what = if *is_nan { "NaN" } else { "infinite" };
                match &cause.operation {
                    Some((kind, _)) => format!("{what}, by {kind}"),
                    None => format!("{what} when it was read"),
                }
            }
        };
        text.extend(wrapped(&format!("{share} %: {why}"), WIDTH - ROWS));
        let from = cause.as_ref().and_then(|found| comes_from(&found.cause.from));
        let first = format!("first at pixel ({column}, {row})");
        let operation = cause.as_ref().and_then(|found| found.cause.operation.as_ref());
        let place = operation.map(|(_, place)| format!("at {}", place.shown));
        let more = place.into_iter().chain(from).chain([first]);
        let more = more.flat_map(|line| wrapped(&line, WIDTH - ROWS - 2));
        text.extend(more.map(|line| format!("  {line}")));
    }
    text
}

/// Returns the lines of the pixels that meet an undefined operation: share, first pixel, members.
fn undefined_pixels(pixels: &UndefinedPixels) -> Vec<String> {
    let share = phrases::figure(100.0 * pixels.share());
    let first = pixels.first.map(|[column, row]| {
        format!("in {share} % of the pixels, first at pixel ({column}, {row})")
    });
    let lines = first.into_iter().chain(comes_from(&pixels.from));
    let lines = lines.flat_map(|line| wrapped(&line, WIDTH - ROWS - 2));
    lines.map(|line| format!("  {line}")).collect()
}

/// The width of the names of rows.
const ROWS: usize = 14;

/// Returns a model in the notation of a scene: its family and what differs from it.
fn model_text(model: &Model) -> String {
    let whole = |model: &Model| serde_json::to_value(model).unwrap_or(Value::Null);
    let (own, family) = (whole(model), whole(&Model::new(model.family)));
    let (Some(own), Some(family)) = (own.as_object(), family.as_object()) else {
        return String::new();
    };
    let text = |value: &Value| value.as_str().unwrap_or_default().to_string();
    // Only what differs from the family is written, as in a scene.
    let differs = own.iter().filter(|(key, value)| family.get(*key) != Some(value));
    let mut parts = vec![text(&own["family"])];
    parts.extend(differs.map(|(key, value)| format!("{key} {}", text(value))));
    parts.join(", ")
}
