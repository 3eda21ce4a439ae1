//! The verdicts on operations that can break, with inputs by path.
//!
//! Made from the goals of [`prove`](mod@crate::prove); listed by the reports of
//! `landfall stress` and `landfall prove`.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::case::{Case, CaseWriter};
use super::deadline::Deadline;
use super::shrink::shrink;
use crate::inputs::domain::Domain;
use crate::inputs::{Input, Sample};
use crate::prove::{Class, Goal, Verdict, class};
use landfall_interp::graph::Fault;
use landfall_interp::{SourceLocation, UndefinedKind};
use landfall_layout::format::phrases;

#[derive(Clone, Debug)]
pub struct Operation {
    /// The way in which it can break.
    pub fault: Fault,
    /// The operation.
    pub place: SourceLocation,
    pub known: OperationVerdict,
}

/// The verdict on an operation, with inputs by path.
#[derive(Clone, Debug)]
pub enum OperationVerdict {
    /// It breaks at this input.
    Found(Box<Case>),
    /// It breaks nowhere in the domain.
    Absent,
    /// It may break where the inputs are from the least to the greatest of these values.
    Open(Vec<(String, [f64; 2])>),
}

impl Operation {
    /// Returns the effect on the result if it breaks.
    pub fn class(&self) -> Class {
        class(self.fault)
    }

    /// Returns the verdict's name in messages and JSON.
    pub fn verdict(&self) -> &'static str {
        match self.known {
            OperationVerdict::Found(_) => "found",
            OperationVerdict::Absent => "absent",
            OperationVerdict::Open(_) => "open",
        }
    }
}

/// Returns the number of operations of a class found to break, shown not to, and open.
pub fn counts(operations: &[Operation], class: Class) -> [usize; 3] {
    let mut counts = [0; 3];
    for operation in operations.iter().filter(|operation| operation.class() == class) {
        match operation.known {
            OperationVerdict::Found(_) => counts[0] += 1,
            OperationVerdict::Absent => counts[1] += 1,
            OperationVerdict::Open(_) => counts[2] += 1,
        }
    }
    counts
}

/// Returns one line for each class with operations: how many were found to break, shown not to
/// break, and left open.
pub fn count_lines(operations: &[Operation]) -> Vec<String> {
    let line = |class: Class, noun: &str, fault: &str| {
        let [found, absent, open] = counts(operations, class);
        let all = phrases::counted(found + absent + open, noun);
        format!("{fault}: {found} found, {absent} proved absent, {open} open, in {all}")
    };
    let mut lines = vec![line(Class::Undefined, "operation", "undefined results")];
    if counts(operations, Class::Accuracy) != [0; 3] {
        lines.push(line(Class::Accuracy, "subtraction", "cancelled digits"));
    }
    let [found, _, open] = counts(operations, Class::Magnitude);
    if found + open > 0 {
        lines.push(line(Class::Magnitude, "operation", "results beyond the range of f32"));
    }
    lines
}

/// Returns the operations of a proof in the order of the text.
pub(crate) fn operations(
    goals: &[Goal],
    inputs: &[Input],
    writer: &CaseWriter<'_>,
) -> Vec<Operation> {
    let open = |ranges: &Vec<[f64; 2]>, goal: &Goal| -> Vec<(String, [f64; 2])> {
        let mine = goal.inputs.iter().filter_map(|&at| {
            let input = inputs.iter().find(|input| input.range().contains(&at))?;
            let path = writer.path(at).unwrap_or_else(|| input.path.clone());
            Some((path, ranges[at]))
        });
        mine.collect()
    };
    // One division is one entry: as by zero if that is possible, else as an overflow.
    // A division by zero is infinite, too.
    let is_counted = |goal: &&Goal| {
        let divides = |other: &Goal| {
            other.fault == Fault::Undefined(UndefinedKind::DivisionByZero)
                && other.place.span == goal.place.span
                && other.verdict != Verdict::Absent
        };
        goal.fault != Fault::Undefined(UndefinedKind::BornInfinite) || !goals.iter().any(divides)
    };
    let mut all: Vec<Operation> = goals
        .iter()
        .filter(is_counted)
        .map(|goal| Operation {
            fault: goal.fault,
            place: goal.place.clone(),
            known: match &goal.verdict {
                Verdict::Found(sample) => OperationVerdict::Found(Box::new(writer.case(sample))),
                Verdict::Absent => OperationVerdict::Absent,
                Verdict::Open(ranges) => OperationVerdict::Open(open(ranges, goal)),
            },
        })
        .collect();
    all.sort_by_key(|operation| {
        let span = operation.place.span;
        (span.file, span.start, span.end, operation.fault)
    });
    all
}

/// Returns the simplest sample of the domain that still breaks, or the simplest until stopped.
pub(crate) fn simplest(
    sample: &Sample,
    inputs: &[Input],
    domain: &Domain,
    stop: &Arc<AtomicBool>,
    breaks: impl FnMut(&Sample) -> bool,
) -> Sample {
    shrink(sample, inputs, domain, &Deadline::after(None, stop), breaks)
}
