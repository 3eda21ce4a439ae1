//! The JSON of lights, in the form of [`LIGHTS_SCHEMA`](super::LIGHTS_SCHEMA).

use serde::Serialize;

use super::SCHEMA_VERSION;
use crate::report::lights::cost::{Light, LightHazard, Report};
use landfall_layout::ShaderLayout;
use landfall_layout::finding::Level;
use landfall_layout::format::json::{Tool, to_lines};
use landfall_layout::source::{Language, Target};

/// The cost of the lights of shaders, and the numerical hazards of their code. Sizes and offsets are
/// in bytes.
#[cfg(feature = "schema")]
#[derive(schemars::JsonSchema)]
#[expect(dead_code, reason = "never more than a shader is in memory")]
struct LightsDocument<'a> {
    #[schemars(extend("const" = SCHEMA_VERSION))]
    schema_version: u32,
    tool: Tool,
    shaders: Vec<LightsShader<'a>>,
}

/// The schema of [`LIGHTS_SCHEMA`](super::LIGHTS_SCHEMA).
#[cfg(feature = "schema")]
#[doc(hidden)]
pub fn schema() -> String {
    landfall_layout::schema::text::<LightsDocument<'_>>("landfall lights --format json")
}

/// Returns the document up to the first shader.
pub fn opening() -> String {
    let tool = to_lines(&Tool::LANDFALL);
    format!("{{\"schema_version\":{SCHEMA_VERSION},\"tool\":{tool},\"shaders\":[\n")
}

/// Returns the end of the document, given the number of shaders.
pub fn closing(shaders: usize) -> &'static str {
    if shaders == 0 { "]}\n" } else { "\n]}\n" }
}

/// Returns one shader, without a newline at the end.
pub fn shader(shader: &ShaderLayout, report: &Report) -> String {
    let object = LightsShader {
        path: &shader.path,
        language: shader.language,
        stage: shader.stage.map(|stage| stage.name()),
        assumed_target: shader.assumed_target,
        lights: &report.lights,
        hazards: report.hazards.iter().map(HazardObject::new).collect(),
        unfollowed: report.unfollowed.iter().map(|found| found.message.as_str()).collect(),
        cut_short: report.cut_short,
    };
    format!("  {}", to_lines(&object))
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct LightsShader<'a> {
    path: &'a str,
    language: Language,
    stage: Option<&'static str>,
    /// The API assumed for a shader that tests `VULKAN` without declaring its API, if its blocks
    /// depend on it.
    #[serde(skip_serializing_if = "Option::is_none")]
    assumed_target: Option<Target>,
    /// The lights in the order of the blocks.
    lights: &'a [Light],
    /// The hazards in source order.
    hazards: Vec<HazardObject<'a>>,
    /// Why the functions could not be analysed: then there are no loop bounds, and only hazards of
    /// declarations.
    unfollowed: Vec<&'a str>,
    /// Whether the analysis stopped early because the functions are too long.
    cut_short: bool,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct HazardObject<'a> {
    /// The hazard's code, which `landfall rule` explains.
    id: &'static str,
    /// The lint of the hazard.
    code: &'a str,
    #[cfg_attr(feature = "schema", schemars(extend("enum" = ["possible", "likely", "certain"])))]
    certainty: &'static str,
    /// The default level of the lint.
    level: Level,
    message: &'a str,
    about: &'a str,
    path: &'a str,
    line: u32,
    column: u32,
    end_line: u32,
    end_column: u32,
    /// The form without the hazard.
    help: Option<&'a str>,
    notes: &'a [String],
}

impl HazardObject<'_> {
    fn new(found: &LightHazard) -> HazardObject<'_> {
        let finding = &found.finding;
        HazardObject {
            id: found.hazard.code(),
            code: &finding.code,
            certainty: found.certainty.name(),
            level: found.level,
            message: &finding.message,
            about: &finding.about,
            path: &finding.place().path,
            line: finding.place().line,
            column: finding.place().column,
            end_line: finding.place().end_line,
            end_column: finding.place().end_column,
            help: finding.help.as_deref(),
            notes: &finding.notes,
        }
    }
}
