//! The report of `landfall render` as JSON.

use serde::Serialize;
use serde_json::Value;

use super::RenderReport;
use landfall_exec::backend::Device;
use landfall_exec::report::run::FromObject;
use landfall_layout::format::SCHEMA_VERSION;
use landfall_layout::format::json::{Tool, to_lines};
use landfall_layout::source::Target;
use landfall_light::picture::Comparison;
use landfall_light::reference::Model;
use landfall_light::render::causes::{NonFinitePixels, PixelsByCause, UndefinedPixels};

/// The report of rendering a scene.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct RenderDocument<'a> {
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA_VERSION)))]
    schema_version: u32,
    tool: Tool,
    /// The name of the scene.
    scene: &'a str,
    /// The path of the shader; null for the reference.
    shader: Option<&'a str>,
    /// The API assumed for a shader that tests `VULKAN` without declaring its API, if its blocks
    /// depend on it.
    #[serde(skip_serializing_if = "Option::is_none")]
    assumed_target: Option<Target>,
    device: Option<&'a Device>,
    size: [u32; 2],
    /// Pixels covered by an object.
    fragments: u64,
    /// Pixels with a NaN or infinite channel.
    non_finite: u64,
    /// Why pixels are NaN or infinite: at most 256 of them, run again on the interpreter.
    causes: Vec<JsonCause<'a>>,
    /// Pixels whose fragment executed `discard`.
    discarded: u64,
    lights: JsonLights,
    /// Light evaluations over all fragments; null for the reference.
    evaluations: Option<u64>,
    /// Slots without a light that are evaluated anyway.
    idle_slots: u64,
    uploaded_bytes: u64,
    seconds: f64,
    operations: Option<JsonOperations<'a>>,
    /// The model of the reference, in the notation of a scene.
    #[cfg_attr(feature = "schema", schemars(with = "Option<serde_json::Map<String, Value>>"))]
    model: Option<Model>,
    /// The source of each member, texture and input, as --bind accepts it.
    #[cfg_attr(feature = "schema", schemars(with = "Option<serde_json::Map<String, Value>>"))]
    bind: Option<Value>,
    /// The plan of skipped lights, with --skip: the form of `landfall schema plan`, without
    /// schema_version and tool.
    #[serde(skip_serializing_if = "Option::is_none")]
    plan: Option<crate::report::plan::Body<'a>>,
    compared: Vec<JsonCompared<'a>>,
    written: &'a [String],
    notes: &'a [String],
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct JsonCause<'a> {
    /// Of the pixels run again.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = 1.0)))]
    share: f64,
    /// Column and row of the first such pixel, from the top left.
    first: [u32; 2],
    /// Null if the interpreter finds the pixels finite.
    #[cfg_attr(feature = "schema", schemars(extend("enum" = ["nan", "inf"])))]
    value: Option<&'static str>,
    /// The operation; null if the value was read so.
    what: Option<&'static str>,
    place: Option<&'a str>,
    /// The members of blocks whose values led to it, with those values.
    from: Vec<FromObject<'a>>,
}

fn json_cause<'a>(known: &'a PixelsByCause, all: &NonFinitePixels) -> JsonCause<'a> {
    let cause = known.cause.as_ref();
    let operation = cause.and_then(|found| found.cause.operation.as_ref());
    JsonCause {
        share: known.pixels as f64 / all.examined.max(1) as f64,
        first: known.first,
        value: cause.map(|found| if found.is_nan { "nan" } else { "inf" }),
        what: operation.map(|(kind, _)| kind.name()),
        place: operation.map(|(_, place)| place.shown.as_str()),
        from: cause.map_or_else(Vec::new, |c| c.cause.from.iter().map(FromObject::new).collect()),
    }
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct JsonLights {
    directional: usize,
    point: usize,
    spot: usize,
}

/// The counts of the interpreter, where it ran.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct JsonOperations<'a> {
    arithmetic: u64,
    transcendental: u64,
    loads: u64,
    textures: u64,
    calls: Vec<JsonCall<'a>>,
    undefined: Vec<JsonUndefined<'a>>,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct JsonCall<'a> {
    function: &'a str,
    count: u64,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct JsonUndefined<'a> {
    what: &'a str,
    place: &'a str,
    count: u64,
    /// The share of the pixels that meet it, of at most 256 spread evenly over the picture; null
    /// without a shader.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = 1.0)))]
    share: Option<f64>,
    /// Column and row of the first of these pixels, from the top left; null if none was found.
    first: Option<[u32; 2]>,
    /// The members of blocks whose values led to it in the first of these pixels, with those
    /// values.
    from: Vec<FromObject<'a>>,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct JsonCompared<'a> {
    /// The other picture: reference, cpu, gl, gpu, or a file.
    with: &'a str,
    #[serde(flatten)]
    comparison: &'a Comparison,
    hazards: Vec<JsonHazard<'a>>,
    /// Other causes of the difference than arithmetic.
    notes: &'a [String],
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct JsonHazard<'a> {
    id: &'a str,
    what: &'a str,
    fragments: u64,
}

/// The schema of [`RENDER_SCHEMA`](super::RENDER_SCHEMA).
#[cfg(feature = "schema")]
#[doc(hidden)]
pub fn schema() -> String {
    landfall_layout::schema::text::<RenderDocument<'_>>("landfall render --format json")
}

/// Returns the report as JSON, in the form of [`RENDER_SCHEMA`](super::RENDER_SCHEMA).
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
            .enumerate()
            .map(|(nth, found)| JsonUndefined {
                what: found.kind.name(),
                place: &found.place.shown,
                count: found.count,
                share: report.undefined.get(nth).map(UndefinedPixels::share),
                first: report.undefined.get(nth).and_then(|pixels| pixels.first),
                from: report.undefined.get(nth).map_or_else(Vec::new, |pixels| {
                    pixels.from.iter().map(FromObject::new).collect()
                }),
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
        notes: &compared.notes,
    });
    let document = RenderDocument {
        schema_version: SCHEMA_VERSION,
        tool: Tool::LANDFALL,
        scene: &report.scene,
        shader: report.shader.as_deref(),
        assumed_target: report.assumed_target,
        device: report.device.as_ref(),
        size: report.size,
        fragments: report.fragments,
        non_finite: report.non_finite,
        causes: report
            .causes
            .causes
            .iter()
            .map(|known| json_cause(known, &report.causes))
            .collect(),
        discarded: report.discarded,
        lights: JsonLights { directional, point, spot },
        evaluations: report.evaluations,
        idle_slots: report.idle,
        uploaded_bytes: report.uploaded,
        seconds: report.time.as_secs_f64(),
        operations,
        model: report.model.map(|(model, _)| model),
        plan: report.plan.as_ref().map(crate::report::plan::object),
        bind: report.map.as_ref().map(crate::report::bind::json),
        compared: compared.collect(),
        written: &report.written,
        notes: &report.notes,
    };
    let mut text = to_lines(&document);
    text.push('\n');
    text
}
