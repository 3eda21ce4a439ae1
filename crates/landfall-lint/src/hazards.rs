//! Hazards of lighting code as findings: one file a lint, and what they share.
//!
//! [`run::hazards`](landfall_ir::analysis::hazards) follows a shader's values once for all of them; here its
//! hazards get words, and those that only the text shows are added. `landfall lights` prints the
//! same words beside what the lights cost.

pub(super) mod ambient_per_light;
pub(super) mod attenuation_division;
pub(super) mod cone_division;
pub(super) mod cosine_cone;
pub(super) mod degrees_for_cosine;
mod glance;
pub(super) mod kahan_without_precise;
pub(super) mod loop_past_count;
mod mediump;
pub(super) mod mediump_position;
pub(super) mod pow_of_negative;
pub(super) mod pow_of_zero;
pub(super) mod unclamped_count;
pub(super) mod ungated_specular;
pub(super) mod unguarded_normalize;
pub(super) mod uninitialised_accumulator;
pub(super) mod unnormalised_normal;
pub(super) mod vec4_normalise;
mod words;

use glance::Glance;

use super::definition::{Check, Lint, Subject};
use landfall_ir::analysis::hazards::{Certainty, Found, Kind, Occurrence, find};
use landfall_ir::analysis::roles::{Held, held};
use landfall_ir::analysis::words::words as words_of;
use landfall_layout::finding::{Finding, Level, Place};
use landfall_layout::layout::MemberLayout;
use landfall_layout::source::{Files, Language};
use landfall_layout::{Diagnostic, Options, ShaderLayout, Source};

/// The lints whose findings are hazards.
const HAZARD_LINTS: &[&Lint] = &[
    &ambient_per_light::LINT,
    &attenuation_division::LINT,
    &cone_division::LINT,
    &cosine_cone::LINT,
    &degrees_for_cosine::LINT,
    &kahan_without_precise::LINT,
    &loop_past_count::LINT,
    &mediump_position::LINT,
    &pow_of_negative::LINT,
    &pow_of_zero::LINT,
    &unclamped_count::LINT,
    &ungated_specular::LINT,
    &unguarded_normalize::LINT,
    &uninitialised_accumulator::LINT,
    &unnormalised_normal::LINT,
    &vec4_normalise::LINT,
];

/// What is known of a shader's lights besides their layout.
#[derive(Debug, Default)]
pub struct Analysis {
    /// What was found, in the order of the text.
    pub found: Found,
    /// Why the shader's functions could not be followed, if they could not.
    pub unfollowed: Vec<Diagnostic>,
}

/// Follows a shader whose lights are those.
pub fn analyse(
    source: &Source,
    options: &Options,
    shader: &ShaderLayout,
    lights: &[Held<'_>],
) -> Analysis {
    let (mut found, unfollowed) = match find(source, options, lights) {
        Ok(found) => (found, Vec::new()),
        Err(why) => (Found::default(), why),
    };
    found.hazards.retain_mut(|hazard| weigh(hazard, shader, lights));
    found.hazards.extend(mediump::hazards(shader, lights));
    found.hazards.sort_by_key(|h| (h.span.file, h.span.start, h.span.end, h.kind));
    Analysis { found, unfollowed }
}

/// The lint of a kind of hazard.
pub fn lint_of(kind: Kind) -> &'static Lint {
    let is = |lint: &&&Lint| matches!(lint.check, Check::Hazard(own) if own == kind);
    HAZARD_LINTS.iter().find(is).expect("every kind is a lint's")
}

/// A hazard as a finding; its level is that of its lint.
pub fn finding(hazard: &Occurrence, files: &Files, language: Language) -> Finding {
    let lint = lint_of(hazard.kind);
    let words = words::of(hazard, language);
    let about = if hazard.about.is_empty() { hazard.hazard.code() } else { &hazard.about };
    let place = Place::of(files, hazard.span);
    let mut finding = Finding::new(lint.code, about, place, words.message)
        .with_text(words.text)
        .with_help(words.help);
    finding.level = lint.level;
    for note in words.notes {
        finding = finding.with_note(note);
    }
    finding
}

/// The findings of those lints in one shader.
pub(super) fn findings(subject: &Subject<'_>, kinds: &[Kind]) -> Vec<Finding> {
    if kinds.is_empty() {
        return Vec::new();
    }
    let shader = subject.shader;
    let lights = held(&shader.blocks);
    // Normals are transformed where there is no light yet.
    let dark = [Kind::Vec4Normalise];
    let asked = if lights.is_empty() { &dark[..] } else { kinds };
    let mut asked: Vec<Kind> = asked.iter().copied().filter(|kind| kinds.contains(kind)).collect();
    if asked.is_empty() || (lights.is_empty() && !subject.source.text.contains("transpose")) {
        return Vec::new();
    }
    let glance = Glance::new(shader);
    asked.retain(|kind| glance.may_have(*kind, &lights));
    if asked.is_empty() {
        return Vec::new();
    }
    let analysis = analyse(subject.source, subject.options, shader, &lights);
    let said = analysis.found.hazards.iter().filter(|hazard| {
        // A warning is for what is there, not for what might be.
        let least = match lint_of(hazard.kind).level {
            Level::Allow => Certainty::Possible,
            Level::Warn | Level::Deny => Certainty::Likely,
        };
        asked.contains(&hazard.kind) && hazard.certainty >= least
    });
    said.map(|hazard| finding(hazard, &shader.files, shader.language)).collect()
}

/// Whether a hazard stands once names and comments are looked at.
fn weigh(hazard: &mut Occurrence, shader: &ShaderLayout, lights: &[Held<'_>]) -> bool {
    if hazard.kind != Kind::DegreesForCosine || hazard.number.is_some() {
        return true;
    }
    let said = words_of(hazard.about.rsplit('.').next().unwrap_or_default());
    let says = |any: &[&str]| said.iter().any(|word| any.contains(&word.as_str()));
    if says(&["cos", "cosine"]) {
        return false;
    }
    let comment = comment_of(&hazard.about, shader, lights).to_lowercase();
    let cosine = ["cos", "余弦"].iter().any(|word| comment.contains(word));
    let degrees =
        ["degree", "radian", "°", "角度", "弧度"].iter().any(|word| comment.contains(word));
    if says(&["degrees", "degree", "deg", "radians", "rad"]) || (degrees && !cosine) {
        hazard.certainty = Certainty::Likely;
        return true;
    }
    says(&["angle"]) && !cosine
}

/// The comments of the member at that path of a light.
fn comment_of(path: &str, shader: &ShaderLayout, lights: &[Held<'_>]) -> String {
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
