//! `not-proved`: demands of `[[prove]]` in `landfall.toml` that are not proved.
//!
//! The command runs the proofs and gives their results to [`finding`].

use super::definition::{Check, Lint};
use landfall_layout::diagnostic::Label;
use landfall_layout::finding::{Finding, Level, Place};

pub const LINT: Lint = Lint {
    code: "not-proved",
    // The configuration demands the proof.
    level: Level::Deny,
    what: "a demand on a function, listed in `landfall.toml`, that is not proved",
    why: "A result that is NaN or infinite spreads over everything that is computed from it, and an \
          error past the demanded limit is visible. The proof covers every input in the ranges on \
          every conformant device; the finding names an input that violates the demand, or says \
          that neither a proof nor such an input was found.",
    example: "\
#version 450
// [[prove]] with function = \"falloff\", no-nan = true, domain = { d = [0, 100] }
float falloff(float d) {
    return d / d; // NaN at d = 0
}
void main() {}
",
    fix: "Guard the operation that the finding names, or narrow `domain` to the values that the \
          function is called with; `landfall prove` prints every operation.",
    check: Check::Elsewhere,
};

/// The finding that a demand on a function is not proved: at an operation, or at the row of the
/// configuration.
pub fn finding(function: &str, at: Option<Place>, row: &Place, message: String) -> Finding {
    let place = at.clone().unwrap_or_else(|| row.clone());
    let mut finding = Finding::at(LINT.code, function, place, message);
    if at.is_some() {
        finding.labels.push(Label { at: row.clone(), text: "demanded here".to_string() });
    }
    finding
}
