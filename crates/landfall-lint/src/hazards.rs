//! Hazards of lighting code as findings: one file per lint, and their shared code.
//!
//! [`hazards`](landfall_ir::analysis::hazards) follows a shader's values once for all lints; this
//! module writes the messages of its hazards and adds those that only the text shows. `landfall
//! lights` prints the same messages beside the cost of the lights.

pub(super) mod ambient_per_light;
pub(super) mod attenuation_division;
pub(super) mod cone_division;
pub(super) mod cosine_cone;
pub(super) mod degrees_for_cosine;
pub(super) mod kahan_without_precise;
pub(super) mod loop_past_count;
mod mediump;
pub(super) mod mediump_position;
mod messages;
pub(super) mod pow_of_negative;
pub(super) mod pow_of_zero;
mod prefilter;
pub(super) mod unclamped_count;
pub(super) mod ungated_specular;
pub(super) mod unguarded_normalize;
pub(super) mod uninitialised_accumulator;
pub(super) mod unnormalised_normal;
pub(super) mod vec4_normalise;

use messages::{Message, Site};

use super::definition::{Check, Lint, Subject};
use landfall_ir::analysis::hazards::{Certainty, HazardReport, Kind, Occurrence, find};
use landfall_ir::analysis::identifier::words as words_of;
use landfall_ir::analysis::roles::{LightBinding, held};
use landfall_layout::finding::{Finding, Level, Place};
use landfall_layout::layout::MemberLayout;
use landfall_layout::source::{Files, Language};
use landfall_layout::{Diagnostic, Options, ShaderLayout, Source};

/// Writes the text of a lint's finding.
type Write = fn(&Site<'_>) -> Message;

/// The lints whose findings are hazards, each with the function that writes its findings.
const HAZARD_LINTS: &[(&Lint, Write)] = &[
    (&ambient_per_light::LINT, ambient_per_light::message),
    (&attenuation_division::LINT, attenuation_division::message),
    (&cone_division::LINT, cone_division::message),
    (&cosine_cone::LINT, cosine_cone::message),
    (&degrees_for_cosine::LINT, degrees_for_cosine::message),
    (&kahan_without_precise::LINT, kahan_without_precise::message),
    (&loop_past_count::LINT, loop_past_count::message),
    (&mediump_position::LINT, mediump_position::message),
    (&pow_of_negative::LINT, pow_of_negative::message),
    (&pow_of_zero::LINT, pow_of_zero::message),
    (&unclamped_count::LINT, unclamped_count::message),
    (&ungated_specular::LINT, ungated_specular::message),
    (&unguarded_normalize::LINT, unguarded_normalize::message),
    (&uninitialised_accumulator::LINT, uninitialised_accumulator::message),
    (&unnormalised_normal::LINT, unnormalised_normal::message),
    (&vec4_normalise::LINT, vec4_normalise::message),
];

/// The hazards of a shader's lights.
#[derive(Debug, Default)]
pub struct Analysis {
    /// The hazards and accesses found, in the order of the text.
    pub found: HazardReport,
    /// The errors that prevented following the shader's functions; empty if they were followed.
    pub unfollowed: Vec<Diagnostic>,
}

/// Follows the values of a shader with these lights.
pub fn analyse(
    source: &Source,
    options: &Options,
    shader: &ShaderLayout,
    lights: &[LightBinding<'_>],
) -> Analysis {
    let (mut found, unfollowed) = match find(source, options, lights) {
        Ok(found) => (found, Vec::new()),
        Err(why) => (HazardReport::default(), why),
    };
    found.hazards.retain_mut(|hazard| weigh(hazard, shader, lights));
    found.hazards.extend(mediump::hazards(shader, lights));
    found.hazards.sort_by_key(|h| (h.span.file, h.span.start, h.span.end, h.kind));
    Analysis { found, unfollowed }
}

/// Returns the lint that reports a kind of hazard.
pub fn lint_of(kind: Kind) -> &'static Lint {
    entry_of(kind).0
}

fn entry_of(kind: Kind) -> (&'static Lint, Write) {
    let is = |(lint, _): &&(&Lint, Write)| matches!(lint.check, Check::Hazard(own) if own == kind);
    *HAZARD_LINTS.iter().find(is).expect("every kind has a lint")
}

/// Returns a hazard as a finding at the level of its lint.
pub fn finding(hazard: &Occurrence, files: &Files, language: Language) -> Finding {
    let (lint, write) = entry_of(hazard.kind);
    let message = write(&Site::new(hazard, language));
    let about = if hazard.about.is_empty() { hazard.hazard.code() } else { &hazard.about };
    let place = Place::of(files, hazard.span);
    let mut finding = Finding::of(lint.code, about, place, message.message)
        .with_text(message.label)
        .with_help(message.help);
    finding.severity = lint.level.severity().unwrap_or(finding.severity);
    for note in message.notes {
        finding = finding.with_note(note);
    }
    finding
}

/// Returns the findings of those lints in one shader.
pub(super) fn findings(subject: &Subject<'_>, kinds: &[Kind]) -> Vec<Finding> {
    if kinds.is_empty() {
        return Vec::new();
    }
    let shader = subject.shader;
    let lights = held(&shader.blocks);
    // Vertex shaders transform normals without declaring lights.
    let dark = [Kind::Vec4Normalise];
    let candidates = if lights.is_empty() { &dark[..] } else { kinds };
    let candidates: Vec<Kind> =
        candidates.iter().copied().filter(|kind| kinds.contains(kind)).collect();
    if candidates.is_empty() || (lights.is_empty() && !subject.source.text.contains("transpose")) {
        return Vec::new();
    }
    let candidates = prefilter::possible(shader, &candidates, &lights);
    if candidates.is_empty() {
        return Vec::new();
    }
    let analysis = analyse(subject.source, subject.options, shader, &lights);
    let reported = analysis.found.hazards.iter().filter(|hazard| {
        // A warning needs a likely hazard, not a possible one.
        let least = match lint_of(hazard.kind).level {
            Level::Allow => Certainty::Possible,
            Level::Warn | Level::Deny => Certainty::Likely,
        };
        candidates.contains(&hazard.kind) && hazard.certainty >= least
    });
    reported.map(|hazard| finding(hazard, &shader.files, shader.language)).collect()
}

/// Returns whether names and comments confirm a hazard, and adjusts its certainty.
fn weigh(hazard: &mut Occurrence, shader: &ShaderLayout, lights: &[LightBinding<'_>]) -> bool {
    if hazard.kind != Kind::DegreesForCosine || hazard.number.is_some() {
        return true;
    }
    let words = words_of(hazard.about.rsplit('.').next().unwrap_or_default());
    let has = |any: &[&str]| words.iter().any(|word| any.contains(&word.as_str()));
    if has(&["cos", "cosine"]) {
        return false;
    }
    let comment = comment_of(&hazard.about, shader, lights).to_lowercase();
    let cosine = ["cos", "余弦"].iter().any(|word| comment.contains(word));
    let degrees =
        ["degree", "radian", "°", "角度", "弧度"].iter().any(|word| comment.contains(word));
    if has(&["degrees", "degree", "deg", "radians", "rad"]) || (degrees && !cosine) {
        hazard.certainty = Certainty::Likely;
        return true;
    }
    has(&["angle"]) && !cosine
}

/// Returns the comments of the member at that path of a light.
fn comment_of(path: &str, shader: &ShaderLayout, lights: &[LightBinding<'_>]) -> String {
    let mut text = String::new();
    for light in lights {
        let Some(part) = light.roles.parts.iter().find(|part| light.full_path(part) == path) else {
            continue;
        };
        let Some(member) = member_at(&light.block.members, part.span) else { continue };
        for span in &member.comment {
            let Some(file) = shader.files.get(span.file) else { continue };
            text.push_str(file.text.get(span.start as usize..span.end as usize).unwrap_or(""));
        }
    }
    text
}

fn member_at(members: &[MemberLayout], span: landfall_layout::Span) -> Option<&MemberLayout> {
    members.iter().find_map(|member| match member.span == span {
        true => Some(member),
        false => member_at(&member.members, span),
    })
}
