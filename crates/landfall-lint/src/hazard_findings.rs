//! Hazards of lighting code as findings.
//!
//! `analysis` finds the hazards of a shader once for all lints; each lint writes its messages.
//! `landfall lights` prints the same messages beside the cost of the lights.

#[cfg(feature = "analysis")]
mod analysis;
#[cfg(feature = "analysis")]
mod mediump;

#[cfg(feature = "analysis")]
pub(super) use analysis::findings;
#[cfg(feature = "analysis")]
pub use analysis::{Analysis, analyse};

use super::definition::{Check, Lint};
use super::hazard_text::{HazardSite, HazardText};
use super::registry::LINTS;
use landfall_ir::analysis::occurrence::{Kind, Occurrence};
use landfall_layout::finding::{Finding, Place};
use landfall_layout::source::{Files, Language};

/// Returns the lint that reports a kind of hazard.
pub fn lint_of(kind: Kind) -> &'static Lint {
    entry_of(kind).0
}

fn entry_of(kind: Kind) -> (&'static Lint, HazardText) {
    let mut entries = LINTS.iter().filter_map(|lint| match lint.check {
        Check::Hazard(own, text) if own == kind => Some((*lint, text)),
        _ => None,
    });
    entries.next().expect("every kind has a lint")
}

/// Returns a hazard as a finding at the level of its lint.
pub fn finding(hazard: &Occurrence, files: &Files, language: Language) -> Finding {
    let (lint, text) = entry_of(hazard.kind);
    let message = text(&HazardSite { occurrence: hazard, language });
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
