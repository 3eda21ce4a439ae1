//! The JSON of lights, in the form of [`LIGHTS_SCHEMA`](super::LIGHTS_SCHEMA).

use serde::Serialize;

use super::SCHEMA_VERSION;
use crate::report::lights::cost::{Light, LightHazard, Report};
use landfall_ir::analysis::occurrence::IndexBound;
use landfall_ir::analysis::roles::Form;
use landfall_layout::ShaderLayout;
use landfall_layout::format::json::{Tool, to_lines};
use landfall_layout::source::{Language, Target};

/// Returns the document up to the first shader.
pub fn opening() -> String {
    let tool = to_lines(&Tool::LANDFALL, 0);
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
        language: shader.language.name(),
        stage: shader.stage.map(|stage| stage.name()),
        assumed_target: shader.assumed_target,
        lights: report.lights.iter().map(|light| LightObject::of(light, shader.language)).collect(),
        hazards: report.hazards.iter().map(HazardObject::of).collect(),
        unfollowed: report.unfollowed.iter().map(|found| found.message.as_str()).collect(),
        cut_short: report.cut_short,
    };
    format!("  {}", to_lines(&object, 0))
}

#[derive(Serialize)]
struct LightsShader<'a> {
    path: &'a str,
    language: &'static str,
    stage: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    assumed_target: Option<Target>,
    lights: Vec<LightObject<'a>>,
    hazards: Vec<HazardObject<'a>>,
    unfollowed: Vec<&'a str>,
    cut_short: bool,
}

#[derive(Serialize)]
struct LightObject<'a> {
    kind: &'static str,
    form: &'static str,
    structure: &'a str,
    block: &'a str,
    instance: Option<&'a str>,
    address_space: &'static str,
    rules: &'static str,
    path: &'a str,
    array: bool,
    slots: Option<u64>,
    bytes: Option<u64>,
    padding: Option<u64>,
    block_size: Option<u64>,
    members: Vec<MemberObject<'a>>,
    others: &'a [String],
    count: Option<CountObject<'a>>,
    bounds: Vec<BoundObject>,
    reorder: Option<ReorderObject<'a>>,
}

#[derive(Serialize)]
struct MemberObject<'a> {
    path: &'a str,
    role: &'static str,
    #[serde(rename = "type")]
    ty: String,
    offset: Option<u64>,
}

#[derive(Serialize)]
struct CountObject<'a> {
    name: &'a str,
    block: &'a str,
    offset: Option<u64>,
}

#[derive(Serialize)]
struct BoundObject {
    kind: &'static str,
    value: Option<u64>,
}

#[derive(Serialize)]
struct ReorderObject<'a> {
    order: Vec<&'a str>,
    bytes: u64,
}

#[derive(Serialize)]
struct HazardObject<'a> {
    id: &'static str,
    code: &'a str,
    certainty: &'static str,
    level: &'static str,
    message: &'a str,
    about: &'a str,
    path: &'a str,
    line: u32,
    column: u32,
    end_line: u32,
    end_column: u32,
    help: Option<&'a str>,
    notes: &'a [String],
}

impl LightObject<'_> {
    fn of(light: &Light, language: Language) -> LightObject<'_> {
        let members = light.parts.iter().map(|part| MemberObject {
            path: &part.path,
            role: part.role.name(),
            ty: part.ty.spelled(language).to_string(),
            offset: part.offset,
        });
        LightObject {
            kind: light.kind.name(),
            form: match light.form {
                Form::Structure => "structure",
                Form::Block => "block",
                Form::Members => "members",
            },
            structure: &light.structure,
            block: &light.block,
            instance: light.instance.as_deref(),
            address_space: light.space.name(),
            rules: light.rules.name(),
            path: &light.path,
            array: light.is_array,
            slots: light.slots,
            bytes: light.bytes,
            padding: light.padding,
            block_size: light.block_size,
            members: members.collect(),
            others: &light.others,
            count: light.count.as_ref().map(|count| CountObject {
                name: &count.name,
                block: &count.block,
                offset: count.offset,
            }),
            bounds: light.bounds.iter().map(|bound| BoundObject::of(*bound)).collect(),
            reorder: light.reorder.as_ref().map(|better| ReorderObject {
                order: better.order.iter().map(|name| &**name).collect(),
                bytes: better.bytes,
            }),
        }
    }
}

impl BoundObject {
    fn of(bound: IndexBound) -> BoundObject {
        let (kind, value) = match bound {
            IndexBound::Fixed(index) => ("fixed", Some(index)),
            IndexBound::Constant(n) => ("constant", Some(n)),
            IndexBound::ClampedCount => ("clamped_count", None),
            IndexBound::Count => ("count", None),
            IndexBound::Length => ("length", None),
            IndexBound::Unknown => ("unknown", None),
        };
        BoundObject { kind, value }
    }
}

impl HazardObject<'_> {
    fn of(found: &LightHazard) -> HazardObject<'_> {
        let finding = &found.finding;
        HazardObject {
            id: found.hazard.code(),
            code: &finding.code,
            certainty: found.certainty.name(),
            level: found.level.name(),
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
