//! What rendering a scene gave besides its picture: lines for people, JSON for programs.

use std::fmt::Write as _;
use std::time::Duration;

use serde::Serialize;
use serde_json::Value;

use super::compare;
use super::device::JsonDevice;
use super::verify::about;
use landfall_exec::backend::Device;
use landfall_ir::analysis::hazard::Hazard;
use landfall_layout::format::SCHEMA_VERSION;
use landfall_layout::format::json::{Tool, to_lines};
pub use landfall_layout::format::paint::{CAUTION, FAINT, HEADING, PLAIN, Paint, STRONG};
use landfall_light::bind::BindingMap;
use landfall_light::picture::Comparison;
use landfall_light::reference::Model;
use landfall_light::render::tally::Tally;
use landfall_light::render::truth::Truth;
use landfall_light::skip::Plan;

pub use crate::report::schema::RENDER_SCHEMA;

/// What there is to say of a picture.
#[derive(Clone, Debug)]
pub struct RenderReport {
    /// The scene's name.
    pub scene: String,
    /// The shader; none where the reference made the picture.
    pub shader: Option<String>,
    /// Who ran it.
    pub device: Option<Device>,
    /// Pixels in a row, and rows.
    pub size: [u32; 2],
    /// Pixels that see something.
    pub fragments: u64,
    /// Pixels of which a channel is NaN or infinite.
    pub non_finite: u64,
    /// Fragments the shader discarded.
    pub discarded: u64,
    /// Lights of each kind: directional, point, spot.
    pub lights: [usize; 3],
    /// How often a light was evaluated at a fragment; none of the reference.
    pub evaluations: Option<u64>,
    /// Slots without a light that are evaluated all the same.
    pub idle: u64,
    /// Bytes of blocks that were uploaded.
    pub uploaded: u64,
    /// How long the reader took.
    pub time: Duration,
    /// What the evaluator counted, where it ran.
    pub tally: Option<Tally>,
    /// What its members were given.
    pub map: Option<BindingMap>,
    /// The model of the reference, where that was asked, and whether the model was said.
    pub model: Option<(Model, bool)>,
    /// What was skipped.
    pub plan: Option<Plan>,
    /// What the picture was compared with.
    pub compared: Vec<Compared>,
    /// Files that were written.
    pub written: Vec<String>,
    /// What is worth knowing.
    pub notes: Vec<String>,
}

/// A comparison of the picture with another.
#[derive(Clone, Debug)]
pub struct Compared {
    /// With what: `reference`, a reader, a file.
    pub with: String,
    /// How far they are apart.
    pub comparison: Comparison,
    /// Fragments without a value, by hazard and what it is, and those at an edge.
    pub left_out: Vec<(String, String, u64)>,
}

impl Compared {
    /// Fragments that a reference leaves out, by hazard.
    pub fn hazards(truth: &Truth) -> Vec<(String, String, u64)> {
        let undefined = truth.undefined.iter().map(|(undef, count)| {
            let said = undef.to_string();
            let said = said.split_once(": ").map_or(said.clone(), |(_, said)| said.to_string());
            (undef.hazard().code().to_string(), said, *count)
        });
        let edge = "within rounding of a cone's edge".to_string();
        let edges = (truth.at_edges > 0)
            .then(|| (Hazard::ConeEdge.code().to_string(), edge, truth.at_edges));
        undefined.chain(edges).collect()
    }
}

/// The report for people.
pub fn text(report: &RenderReport, paint: Paint) -> String {
    let mut text = String::new();
    let [width, height] = report.size;
    let by = report.shader.as_deref().unwrap_or("the reference");
    let _ = writeln!(text, "{}  {}", paint.text(STRONG, &report.scene), paint.text(FAINT, by));
    let mut row = |name: &str, said: &str| {
        let _ = writeln!(text, "  {} {said}", paint.text(HEADING, &format!("{name:<11}")));
    };
    if let Some(device) = &report.device {
        row(device.reader.name(), &paint.text(PLAIN, &about(device)));
    }
    row("picture", &format!("{width} by {height}, {} fragments", report.fragments));
    let [directional, point, spot] = report.lights;
    row("lights", &format!("{directional} directional, {point} point, {spot} spot"));
    if let Some(evaluations) = report.evaluations {
        let each = evaluations as f64 / report.fragments.max(1) as f64;
        row("evaluated", &format!("{evaluations} lights at fragments, {each:.2} at each"));
    }
    if report.idle > 0 {
        let said = format!("{} slots hold no light and are evaluated, as zeros", report.idle);
        row("idle", &paint.text(CAUTION, &said));
    }
    if report.uploaded > 0 {
        row("uploaded", &format!("{} bytes of blocks", report.uploaded));
    }
    row("time", &format!("{:.2} s", report.time.as_secs_f64()));
    if report.discarded > 0 {
        row("discarded", &format!("{} fragments", report.discarded));
    }
    if report.non_finite > 0 {
        let said = format!("{} pixels are NaN or infinite", report.non_finite);
        row("non-finite", &paint.text(CAUTION, &said));
    }
    if let Some(tally) = &report.tally {
        let counts = &tally.counts;
        row(
            "operations",
            &format!(
                "{}: {} arithmetic, {} transcendental, {} loads, {} texels",
                counts.operations(),
                counts.arithmetic,
                counts.transcendental,
                counts.loads,
                counts.textures
            ),
        );
        for (name, count) in &counts.calls {
            row("called", &format!("{count} times `{name}`"));
        }
        for found in &tally.undefined {
            let said = format!("{} times {}, {}", found.count, found.kind, found.place.shown);
            row("undefined", &paint.text(CAUTION, &said));
        }
    }
    if let Some((model, said)) = &report.model {
        let origin = if *said { "" } else { "; the nearest of those the shader may be" };
        row("model", &format!("{}{origin}", model_text(model)));
    }
    for compared in &report.compared {
        let _ = writeln!(text, "{} {}", paint.text(HEADING, "against"), compared.with);
        for line in compare::human(&compared.comparison).lines() {
            let _ = writeln!(text, "  {line}");
        }
        for (hazard, said, count) in &compared.left_out {
            let _ = writeln!(text, "  {:<12} {count} fragments: {said}", hazard);
        }
    }
    for file in &report.written {
        let _ = writeln!(text, "{} {file}", paint.text(HEADING, "wrote"));
    }
    text
}

/// A model as a scene writes it, only what differs from its family.
fn model_text(model: &Model) -> String {
    let whole = |model: &Model| serde_json::to_value(model).unwrap_or(Value::Null);
    let (own, family) = (whole(model), whole(&Model::of(model.family)));
    let (Some(own), Some(family)) = (own.as_object(), family.as_object()) else {
        return String::new();
    };
    let text = |value: &Value| value.as_str().unwrap_or_default().to_string();
    let differs = own.iter().filter(|(key, value)| family.get(*key) != Some(value));
    let mut words = vec![text(&own["family"])];
    words.extend(differs.map(|(key, value)| format!("{key} {}", text(value))));
    words.join(", ")
}

#[derive(Serialize)]
struct Document<'a> {
    schema_version: u32,
    tool: Tool,
    scene: &'a str,
    shader: Option<&'a str>,
    device: Option<JsonDevice<'a>>,
    size: [u32; 2],
    fragments: u64,
    non_finite: u64,
    discarded: u64,
    lights: JsonLights,
    evaluations: Option<u64>,
    idle_slots: u64,
    uploaded_bytes: u64,
    seconds: f64,
    operations: Option<JsonOperations<'a>>,
    model: Option<Model>,
    bind: Option<Value>,
    #[serde(skip_serializing_if = "Option::is_none")]
    plan: Option<super::plan::Body<'a>>,
    compared: Vec<JsonCompared<'a>>,
    written: &'a [String],
    notes: &'a [String],
}

#[derive(Serialize)]
struct JsonLights {
    directional: usize,
    point: usize,
    spot: usize,
}

#[derive(Serialize)]
struct JsonOperations<'a> {
    arithmetic: u64,
    transcendental: u64,
    loads: u64,
    textures: u64,
    calls: Vec<JsonCall<'a>>,
    undefined: Vec<JsonUndefined<'a>>,
}

#[derive(Serialize)]
struct JsonCall<'a> {
    function: &'a str,
    count: u64,
}

#[derive(Serialize)]
struct JsonUndefined<'a> {
    what: &'a str,
    place: &'a str,
    count: u64,
}

#[derive(Serialize)]
struct JsonCompared<'a> {
    with: &'a str,
    #[serde(flatten)]
    comparison: &'a Comparison,
    hazards: Vec<JsonHazard<'a>>,
}

#[derive(Serialize)]
struct JsonHazard<'a> {
    id: &'a str,
    what: &'a str,
    fragments: u64,
}

/// The report as [`RENDER_SCHEMA`] describes it.
pub fn json(report: &RenderReport) -> String {
    let [directional, point, spot] = report.lights;
    let operations = report.tally.as_ref().map(|tally| JsonOperations {
        arithmetic: tally.counts.arithmetic,
        transcendental: tally.counts.transcendental,
        loads: tally.counts.loads,
        textures: tally.counts.textures,
        calls: tally
            .counts
            .calls
            .iter()
            .map(|(function, count)| JsonCall { function, count: *count })
            .collect(),
        undefined: tally
            .undefined
            .iter()
            .map(|found| JsonUndefined {
                what: found.kind.text(),
                place: &found.place.shown,
                count: found.count,
            })
            .collect(),
    });
    let compared = report.compared.iter().map(|compared| JsonCompared {
        with: &compared.with,
        comparison: &compared.comparison,
        hazards: compared
            .left_out
            .iter()
            .map(|(id, what, fragments)| JsonHazard { id, what, fragments: *fragments })
            .collect(),
    });
    let document = Document {
        schema_version: SCHEMA_VERSION,
        tool: Tool::LANDFALL,
        scene: &report.scene,
        shader: report.shader.as_deref(),
        device: report.device.as_ref().map(JsonDevice::from),
        size: report.size,
        fragments: report.fragments,
        non_finite: report.non_finite,
        discarded: report.discarded,
        lights: JsonLights { directional, point, spot },
        evaluations: report.evaluations,
        idle_slots: report.idle,
        uploaded_bytes: report.uploaded,
        seconds: report.time.as_secs_f64(),
        operations,
        model: report.model.map(|(model, _)| model),
        plan: report.plan.as_ref().map(super::plan::object),
        bind: report.map.as_ref().map(super::bind::json),
        compared: compared.collect(),
        written: &report.written,
        notes: &report.notes,
    };
    let mut text = to_lines(&document, 0);
    text.push('\n');
    text
}
