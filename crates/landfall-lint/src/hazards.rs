//! Hazards of lighting code as findings: one file per lint, and their shared code.
//!
//! `analysis` finds the hazards of a shader once for all lints; this module writes their messages.
//! `landfall lights` prints the same messages beside the cost of the lights.

pub(super) mod ambient_per_light;
#[cfg(feature = "analysis")]
mod analysis;
pub(super) mod attenuation_division;
pub(super) mod cone_division;
pub(super) mod cosine_cone;
pub(super) mod degrees_for_cosine;
pub(super) mod kahan_without_precise;
pub(super) mod loop_past_count;
#[cfg(feature = "analysis")]
mod mediump;
pub(super) mod mediump_position;
mod messages;
pub(super) mod pow_of_negative;
pub(super) mod pow_of_zero;
#[cfg(feature = "analysis")]
mod prefilter;
pub(super) mod unclamped_count;
pub(super) mod ungated_specular;
pub(super) mod unguarded_normalize;
pub(super) mod unguarded_operation;
pub(super) mod uninitialised_accumulator;
pub(super) mod unnormalised_normal;
pub(super) mod vec4_normalise;

#[cfg(feature = "analysis")]
pub(super) use analysis::findings;
#[cfg(feature = "analysis")]
pub use analysis::{Analysis, analyse};
use messages::{HazardMessage, HazardSite};

use super::definition::{Check, Lint};
use landfall_ir::analysis::occurrence::{Kind, Occurrence};
use landfall_layout::finding::{Finding, Level, Place};
use landfall_layout::source::{Files, Language};

/// Writes the text of a lint's finding.
type Write = fn(&HazardSite<'_>) -> HazardMessage;

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
    (&unguarded_operation::LINT, unguarded_operation::message),
    (&uninitialised_accumulator::LINT, uninitialised_accumulator::message),
    (&unnormalised_normal::LINT, unnormalised_normal::message),
    (&vec4_normalise::LINT, vec4_normalise::message),
];

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
    let message = write(&HazardSite::new(hazard, language));
    // Where the operand has no name, the hazard is the subject.
    let about = if hazard.about.is_empty() { hazard.hazard.code() } else { &hazard.about };
    let place = Place::new(files, hazard.span);
    let mut finding = Finding::at(lint.code, about, place, message.message)
        .with_text(message.label)
        .with_help(message.help);
    finding.severity = lint.level.severity().unwrap_or(finding.severity);
    for note in message.notes {
        finding = finding.with_note(note);
    }
    finding
}
