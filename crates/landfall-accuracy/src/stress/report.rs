//! The results of stressing a function, in the form of `landfall schema stress`.
//!
//! Built by [`stress`](super::stress()), printed by the report of `landfall stress`.

use super::Request;
use super::advice::Advised;
use super::backends::{BackendReport, on_a_driver, reports, run_findings_on_drivers};
use super::branches::FlippedBranch;
use super::case::{CaseWriter, command};
use super::classify::{HazardCandidate, examine};
use super::condition::condition;
use super::drivers::Drivers;
use super::find::UnreportedFinding;
use super::found::{OtherFunction, StressFinding, Worst};
use super::generate::Family;
use super::input::{Input, Sample};
use super::kept::Tally;
use super::measure::{Outcome, SampleError, floats, outcome};
use super::operation::{Operation, operations};
use super::permitted::permitted;
use super::plan::{Plan, SampleSearch, columns, settings};
use super::rewrite::gain;
use crate::inputs::{DistributedInput, distributions};
use crate::prove::ProvedFunction;
use landfall_exec::harness::call::pure::PureFunction;
use landfall_interp::Floats;
use landfall_ir::analysis::hazard::Hazard;
use landfall_layout::Options;
use landfall_layout::finding::{Finding, Level, Place as LintPlace};
use landfall_layout::source::{Files, Source, Target};

#[derive(Debug)]
pub struct Report {
    /// The path of the shader, as messages print it.
    pub path: String,
    /// The API assumed for a shader that names none, if its blocks depend on it.
    pub assumed_target: Option<Target>,
    /// The function with its parameter types.
    pub function: String,
    /// `single`, `half` where all floats are rounded to it, or `mediump`.
    pub precision: &'static str,
    pub seed: u64,
    /// Samples per second during sampling.
    pub rate: f64,
    pub threads: usize,
    /// The total time in seconds.
    pub seconds: f64,
    /// Whether it was stopped before all samples had run.
    pub stopped: bool,
    /// The number of inputs, if every one was run.
    pub every: Option<u64>,
    /// The inputs of the function, with their ranges.
    pub inputs: Vec<(Input, String)>,
    /// How each input is drawn in the samples `drawn`.
    pub distributions: Vec<DistributedInput>,
    pub families: Vec<(Family, Tally)>,
    /// The statistics of all families with finite inputs.
    pub total: Tally,
    /// The samples with the largest error in units of the last place, and in steps.
    pub worst: Vec<Worst>,
    /// The requested drivers, including missing ones.
    pub backends: Vec<BackendReport>,
    /// The findings, the worst first.
    pub findings: Vec<StressFinding>,
    /// The verdict on each operation that can break, in the order of the text; empty if the code
    /// is too large to follow.
    pub operations: Vec<Operation>,
    /// The assumptions made for values not given.
    pub notes: Vec<String>,
    pub files: Files,
}

pub(super) struct ReportParts<'a> {
    pub source: &'a Source,
    pub options: &'a Options,
    pub request: &'a Request,
    pub search: SampleSearch<'a>,
    /// The function to compare findings with, and the stressed function's scalar for each of its
    /// own.
    pub against: Option<(&'a PureFunction, Vec<Option<usize>>)>,
    pub families: Vec<(Family, Tally)>,
    pub raws: Vec<UnreportedFinding>,
    pub edges: Vec<FlippedBranch>,
    pub proof: ProvedFunction,
    pub worst: Vec<(Sample, SampleError)>,
    pub drivers: Drivers<'a>,
    pub endless: Vec<Sample>,
    pub every: Option<u64>,
    pub stopped: bool,
    pub rate: f64,
    pub threads: usize,
    pub seconds: f64,
}

/// The most findings reported per code, for a known hazard and for plain arithmetic; others are
/// only counted.
const EACH: [usize; 2] = [12, 3];

pub(super) fn report(mut made: ReportParts<'_>) -> Report {
    let ReportParts { search, source, options, .. } = made;
    let (SampleSearch { pure, plan, .. }, inputs) = (search, search.inputs());
    let request = &made.request.pure;
    let writer = CaseWriter::new(source, options, request, pure, inputs, plan.budget);
    let advised = Advised { source, options, request, search };
    let backends = reports(&made.drivers, search, &writer);
    let mut total = Tally::default();
    // Infinities among the inputs say nothing about the function's own errors.
    for (family, tally) in &made.families {
        if *family != Family::Special {
            total.merge(tally);
        }
    }
    let mut findings: Vec<StressFinding> = Vec::new();
    let mut notes = pure.notes.clone();
    notes.extend(request.floats.note().map(str::to_string));
    let mut more: Vec<(&'static str, usize)> = Vec::new();
    for raw in made.raws {
        let code = raw.candidate.hazard.code();
        let most = EACH[usize::from(raw.candidate.hazard.is_arithmetic())];
        // The worst come first, so the first of each code are kept.
        if findings.iter().filter(|f| f.hazard.code() == code).count() >= most {
            match more.iter_mut().find(|(known, _)| *known == code) {
                Some((_, count)) => *count += 1,
                None => more.push((code, 1)),
            }
            continue;
        }
        let other = made.against.as_ref();
        let other = other.map(|(other, order)| against(other, order, plan, &raw.sample));
        let advice = advised.advice(&raw.candidate, &raw.sample);
        let found = finding(search, &writer, raw);
        let is_it = |edge: &&FlippedBranch| {
            found.hazard == Hazard::BranchDivergence && edge.span == found.place.span
        };
        let edge = made.edges.iter().find(is_it).copied();
        findings.push(StressFinding { against: other, advice, edge, ..found });
    }
    for (code, count) in more {
        notes.push(format!("{code} also occurs in {count} further lines"));
    }
    for backend in &backends {
        let odd = backend.driver_findings();
        // A driver's findings have no place in the text, hence no advice.
        findings.extend(odd.map(|odd| on_a_driver(search, backend.backend, odd)));
    }
    run_findings_on_drivers(&mut made.drivers, &mut findings);
    // Drivers do not run inputs that may not terminate.
    findings.extend(made.endless.first().map(|sample| endless(search, &writer, sample)));
    if request.floats != Floats::AsWritten && !backends.is_empty() {
        notes.push("drivers run the code as written, not rounded to f16".to_string());
    }
    let worst = made.worst.into_iter().map(|(sample, off)| Worst {
        off,
        condition: condition(search, &sample),
        sample: writer.case(&sample),
    });
    let within = inputs.iter().enumerate().map(|(at, input)| search.domain().text(at, input));
    Report {
        path: source.path.clone(),
        assumed_target: landfall_layout::layout(source, options).assumed_target,
        function: pure.shown.clone(),
        precision: match request.floats {
            Floats::AsWritten => "single",
            Floats::Half => "half",
            Floats::Mediump => "mediump",
        },
        seed: made.request.seed,
        rate: made.rate,
        threads: made.threads,
        seconds: made.seconds,
        stopped: made.stopped,
        every: made.every,
        inputs: inputs.iter().cloned().zip(within).collect(),
        distributions: distributions(inputs, search.domain()),
        families: made.families,
        total,
        worst: worst.collect(),
        backends,
        findings,
        operations: operations(&made.proof.goals, inputs, &writer),
        notes,
        files: pure.files.clone(),
    }
}

fn finding(
    search: SampleSearch<'_>,
    writer: &CaseWriter<'_>,
    raw: UnreportedFinding,
) -> StressFinding {
    let UnreportedFinding { candidate, outcome, sample, severity, seen, plausible } = raw;
    // Once more, since simplification may have changed what the sample meets.
    let examined = examine(search, &sample).ok();
    let gain = examined.as_ref().and_then(|examined| gain(search, examined, &candidate));
    let HazardCandidate { hazard, place, operation, about, members, kind, what } = candidate;
    let semantic = [
        Hazard::HighlightFromBehind,
        Hazard::UnnormalisedNormal,
        Hazard::ConeOutOfRange,
        Hazard::BranchDivergence,
    ];
    let is_rule = semantic.contains(&hazard);
    let outcome = examined.map_or(outcome, |examined| examined.outcome);
    StressFinding {
        level: if plausible { hazard.info().level } else { Level::Warn },
        operation,
        kind,
        what,
        about: about.iter().map(|&at| search.inputs()[at].path.clone()).collect(),
        members,
        breach: is_rule.then_some(severity),
        // The condition explains errors of finite results.
        condition: condition(search, &sample).filter(|_| kind.is_none()),
        gain,
        permitted: permitted(search, &sample),
        seen,
        plausible,
        ..StressFinding::bare(hazard, place, outcome, writer.case(&sample))
    }
}

fn endless(search: SampleSearch<'_>, writer: &CaseWriter<'_>, sample: &Sample) -> StressFinding {
    let (place, case) = (search.pure.place(), writer.case(sample));
    StressFinding {
        level: Level::Deny,
        ..StressFinding::bare(Hazard::EndlessLoop, place, Outcome::Discarded, case)
    }
}

/// Runs another function on a sample; its scalars without a match are zero.
fn against(
    other: &PureFunction,
    order: &[Option<usize>],
    plan: &Plan,
    sample: &Sample,
) -> OtherFunction {
    let words: Sample = order.iter().map(|at| at.map_or(0, |at| sample[at])).collect();
    let called = other.call(&columns(&[words]), 1, &settings(plan, false));
    let outcome = match called {
        // A function that does not end there has no result to compare.
        Ok(called) => outcome(&called, &floats(other), 0),
        Err(_) => Outcome::Discarded,
    };
    OtherFunction { function: other.shown.clone(), outcome }
}

impl Report {
    /// Whether a sample with finite inputs has a non-finite result on any backend.
    pub fn has_non_finite(&self) -> bool {
        self.tallies().any(|tally| tally.nan + tally.infinite > 0)
    }

    /// Returns the largest error on any backend, in units of the last place.
    pub fn max_ulp(&self) -> f64 {
        self.tallies().map(|tally| tally.ulp.max).fold(0.0, f64::max)
    }

    /// Returns the largest error on any backend, in steps.
    pub fn max_steps(&self) -> f64 {
        self.tallies().map(|tally| tally.steps.max).fold(0.0, f64::max)
    }

    fn tallies(&self) -> impl Iterator<Item = &Tally> {
        std::iter::once(&self.total).chain(self.backends.iter().map(|backend| &backend.tally))
    }

    /// Returns the findings in the form of lint findings.
    pub fn lints(&self) -> Vec<Finding> {
        self.findings.iter().map(|found| self.lint(found)).collect()
    }

    /// Returns one of the findings in the form of a lint finding.
    pub fn lint(&self, found: &StressFinding) -> Finding {
        found.lint(self)
    }
}

impl StressFinding {
    fn lint(&self, report: &Report) -> Finding {
        let mut notes = self.notes();
        notes.push(format!("to reproduce: {}", command(&self.case.arguments)));
        let place = LintPlace::new(&report.files, self.place.span);
        let mut finding =
            Finding::at(self.hazard.code(), report.function.clone(), place, self.message())
                .with_text(self.label());
        if let Some(advice) = &self.advice {
            finding = finding.with_help(advice.text());
        } else if let Some(remedy) = self.remedy() {
            notes.push(format!("usual remedy, not tried here: {remedy}"));
        }
        finding.severity = self.level.severity().unwrap_or(finding.severity);
        finding.notes = notes;
        finding
    }
}
