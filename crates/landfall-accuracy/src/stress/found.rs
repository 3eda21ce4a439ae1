//! Findings: plain data.
//!
//! [`messages`](super::messages) gives them their text.

use super::advice::Advice;
use super::branches::FlippedBranch;
use super::case::Case;
use super::classify::Performed;
use super::condition::Condition;
use super::measure::{Outcome, SampleError};
use super::permitted::PermittedAt;
use super::rewrite::Gain;
use landfall_exec::backend::BackendKind;
use landfall_exec::harness::origins::ReadValue;
use landfall_interp::{SourceLocation, UndefinedKind};
use landfall_ir::analysis::hazard::Hazard;
use landfall_layout::finding::Level;

/// A sample with a large error.
#[derive(Clone, Debug)]
pub struct Worst {
    pub off: SampleError,
    /// The effect of the inputs' own rounding.
    pub condition: Option<Condition>,
    pub sample: Case,
}

#[derive(Clone, Debug)]
pub struct StressFinding {
    pub hazard: Hazard,
    pub level: Level,
    pub place: SourceLocation,
    /// The driver, for a finding on that driver alone.
    pub backend: Option<BackendKind>,
    /// The operation with its operands and result.
    pub operation: Option<Performed>,
    /// The kind of undefined value; `None` for a loss of accuracy or a broken rule.
    pub kind: Option<UndefinedKind>,
    /// What happens, where how the operands came about says more than the hazard.
    pub what: Option<&'static str>,
    /// The paths of the inputs involved.
    pub about: Vec<String>,
    /// The members of blocks with given contents that led to an undefined value.
    pub members: Vec<ReadValue>,
    pub outcome: Outcome,
    /// For a rule about the result, the steps by which it is broken.
    pub breach: Option<f64>,
    /// The simplest sample that fails.
    pub case: Case,
    /// The effect of the inputs' own rounding.
    pub condition: Option<Condition>,
    pub gain: Option<Gain>,
    /// A better form of the expression, as code; `None` if none of the catalogue is.
    pub advice: Option<Advice>,
    /// For a branch that rounding decides, the samples run around where its sides meet.
    pub edge: Option<FlippedBranch>,
    /// The error permitted on conformant devices; `None` where unknown.
    pub permitted: Option<PermittedAt>,
    /// The result of the compared function for the same input.
    pub against: Option<OtherFunction>,
    pub backends: Vec<BackendResult>,
    /// The number of examined samples that meet it.
    pub seen: usize,
    /// Whether the inputs are values that occur in scenes.
    pub plausible: bool,
}

impl StressFinding {
    /// A finding of which no more is known.
    pub(super) fn bare(
        hazard: Hazard,
        place: SourceLocation,
        outcome: Outcome,
        case: Case,
    ) -> StressFinding {
        StressFinding {
            hazard,
            level: hazard.info().level,
            place,
            backend: None,
            operation: None,
            kind: None,
            what: None,
            about: Vec::new(),
            members: Vec::new(),
            outcome,
            breach: None,
            case,
            condition: None,
            gain: None,
            advice: None,
            edge: None,
            permitted: None,
            against: None,
            backends: Vec::new(),
            seen: 1,
            plausible: false,
        }
    }
}

/// The result of another function for the input of a finding.
#[derive(Clone, Debug, PartialEq)]
pub struct OtherFunction {
    pub function: String,
    /// The outcome, compared with its own `f64`.
    pub outcome: Outcome,
}

/// The result of a driver for the input of a finding.
#[derive(Clone, Debug, PartialEq)]
pub struct BackendResult {
    pub backend: BackendKind,
    /// The floats of the results, in order.
    pub results: Vec<f32>,
    pub failure: Option<String>,
}
