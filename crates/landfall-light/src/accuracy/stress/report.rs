//! What stressing a function found: plain data, as `landfall schema stress` describes it.
//!
//! Made by [`stress`](super::stress()), printed by the report of `landfall stress`.

use super::Request;
use super::case::{Case, Writing, case, command, fixed};
use super::classify::{Performed, examine};
use super::condition::{Condition, condition};
use super::domain::Domain;
use super::drivers::Drivers;
use super::find::Raw;
use super::generate::Family;
use super::input::{Input, Sample};
use super::measure::{Off, Outcome, floats, outcome};
use super::permitted::{PermittedAt, permitted};
use super::readers::{ReaderReport, ask, on_a_driver, reports};
use super::rewrite::{Gain, gain};
use super::sample::{Plan, Tally, columns, settings};
use landfall_exec::backend::BackendKind;
use landfall_exec::harness::call::pure::{Pure, PureRequest};
use landfall_exec::interp::{Floats, Place, UndefinedKind};
use landfall_ir::analysis::hazard::Hazard;
use landfall_layout::Options;
use landfall_layout::finding::{Finding, Level, Place as LintPlace, Related};
use landfall_layout::source::{Files, Source};

/// What stressing a function found.
#[derive(Debug)]
pub struct Report {
    /// The path of the shader as messages print it.
    pub path: String,
    /// The function with the types of its parameters.
    pub function: String,
    /// `single`, `half` where all floats are rounded to it, or `mediump`.
    pub precision: &'static str,
    /// What random numbers started from.
    pub seed: u64,
    /// Samples a second, while sampling.
    pub rate: f64,
    /// Threads that sampled.
    pub threads: usize,
    /// Seconds it all took.
    pub seconds: f64,
    /// Whether it was stopped before all samples had run.
    pub stopped: bool,
    /// How many inputs there are, where every one of them ran.
    pub every: Option<u64>,
    /// What the function reads, and what each may be.
    pub inputs: Vec<(Input, String)>,
    /// By family of samples: how they came out.
    pub families: Vec<(Family, Tally)>,
    /// All families together, but those whose inputs were not finite.
    pub total: Tally,
    /// The sample of the largest error in units of the last place, and that in steps.
    pub worst: Vec<Worst>,
    /// The drivers that were asked for, those that are missing too.
    pub readers: Vec<ReaderReport>,
    /// What breaks, the worst first.
    pub findings: Vec<Found>,
    /// What was taken for what was not given.
    pub notes: Vec<String>,
    /// The files the shader is made of.
    pub files: Files,
}

/// A sample with a large error.
#[derive(Clone, Debug)]
pub struct Worst {
    /// Its error.
    pub off: Off,
    /// What its inputs' own rounding does.
    pub condition: Option<Condition>,
    /// Its inputs.
    pub sample: Case,
}

/// A finding.
#[derive(Clone, Debug)]
pub struct Found {
    /// What it is.
    pub hazard: Hazard,
    /// How much it matters here.
    pub level: Level,
    /// Where.
    pub place: Place,
    /// The driver it is about, where it is about one alone.
    pub reader: Option<BackendKind>,
    /// The operation that did it.
    pub operation: Option<Performed>,
    /// What is undefined about it; none of a loss of accuracy or a breach of a rule.
    pub kind: Option<UndefinedKind>,
    /// Paths of the inputs that play a part.
    pub about: Vec<String>,
    /// What the simplest such sample comes to.
    pub outcome: Outcome,
    /// Of a rule about the result: by how many steps it is broken.
    pub breach: Option<f64>,
    /// The simplest sample that breaks.
    pub case: Case,
    /// What its inputs' own rounding does.
    pub condition: Option<Condition>,
    /// What the robust form would make of it.
    pub gain: Option<Gain>,
    /// How far conformant devices may be apart there; none where that is not known.
    pub permitted: Option<PermittedAt>,
    /// What the function it is held against gives for the same input.
    pub against: Option<Against>,
    /// What drivers give for it.
    pub readers: Vec<Asked>,
    /// Samples that were looked at and meet it.
    pub seen: usize,
    /// Whether the inputs are numbers as scenes have them.
    pub plausible: bool,
}

/// What another function gives for the input of a finding.
#[derive(Clone, Debug, PartialEq)]
pub struct Against {
    /// The function.
    pub function: String,
    /// How it comes out, compared with its own `f64`.
    pub outcome: Outcome,
}

/// What a driver gives for the input of a finding.
#[derive(Clone, Debug, PartialEq)]
pub struct Asked {
    /// The driver.
    pub reader: BackendKind,
    /// The floats it gives, in the order of the results.
    pub results: Vec<f32>,
    /// Why it gives none.
    pub failure: Option<String>,
}

pub(super) struct Made<'a> {
    pub source: &'a Source,
    pub options: &'a Options,
    pub request: &'a Request,
    pub pure: &'a Pure,
    pub inputs: &'a [Input],
    pub domain: &'a Domain,
    pub plan: &'a Plan,
    /// The function findings are held against, and what its scalars are given of a sample.
    pub against: Option<(&'a Pure, Vec<Option<usize>>)>,
    pub families: Vec<(Family, Tally)>,
    pub raws: Vec<Raw>,
    pub worst: Vec<(Sample, Off)>,
    pub drivers: Drivers<'a>,
    pub endless: Vec<Sample>,
    pub every: Option<u64>,
    pub stopped: bool,
    pub rate: f64,
    pub threads: usize,
    pub seconds: f64,
}

/// Findings of one code that are written up, of a known hazard and of plain arithmetic; the
/// others are only counted.
const EACH: [usize; 2] = [12, 3];

pub(super) fn report(mut made: Made<'_>) -> Report {
    let Made { pure, inputs, plan, source, .. } = made;
    let PureRequest { textures, floats, .. } = &made.request.pure;
    let fixed = fixed(source, made.options, textures);
    let writing = Writing { pure, inputs, plan, source, fixed: &fixed, floats: *floats };
    let readers = reports(&made.drivers, &writing);
    let mut total = Tally::default();
    for (family, tally) in &made.families {
        if *family != Family::Special {
            total.merge(tally);
        }
    }
    let mut findings: Vec<Found> = Vec::new();
    let mut notes = pure.notes.clone();
    let mut more: Vec<(&'static str, usize)> = Vec::new();
    for raw in made.raws {
        let code = raw.candidate.hazard.code();
        let most = EACH[usize::from(raw.candidate.hazard.is_arithmetic())];
        if findings.iter().filter(|f| f.hazard.code() == code).count() >= most {
            match more.iter_mut().find(|(known, _)| *known == code) {
                Some((_, count)) => *count += 1,
                None => more.push((code, 1)),
            }
            continue;
        }
        let other = made.against.as_ref();
        let other = other.map(|(other, order)| against(other, order, plan, &raw.sample));
        findings.push(Found { against: other, ..found(&writing, raw) });
    }
    for (code, count) in more {
        notes.push(format!("{code} is found in {count} further lines"));
    }
    for reader in &readers {
        let odd = reader.odd();
        findings.extend(odd.map(|odd| on_a_driver(pure, plan, reader.reader, odd)));
    }
    ask(&mut made.drivers, &mut findings);
    // No driver is asked for what may never end.
    findings.extend(made.endless.first().map(|sample| endless(&writing, sample)));
    if made.request.pure.floats != Floats::AsWritten && !readers.is_empty() {
        notes.push("drivers run it as it is written, not rounded to f16".to_string());
    }
    let worst = made.worst.into_iter().map(|(sample, off)| Worst {
        off,
        condition: condition(pure, inputs, &sample, plan),
        sample: case(&writing, &sample),
    });
    let within = made.domain.within.iter().map(|within| within.text());
    Report {
        path: made.source.path.clone(),
        function: pure.shown.clone(),
        precision: match made.request.pure.floats {
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
        families: made.families,
        total,
        worst: worst.collect(),
        readers,
        findings,
        notes,
        files: pure.files.clone(),
    }
}

fn found(writing: &Writing<'_>, raw: Raw) -> Found {
    let Writing { pure, inputs, plan, .. } = writing;
    let hazard = raw.candidate.hazard;
    let semantic =
        [Hazard::HighlightFromBehind, Hazard::UnnormalisedNormal, Hazard::ConeOutOfRange];
    let is_rule = semantic.contains(&hazard);
    let level = if raw.plausible { hazard.info().level } else { Level::Warn };
    let examined = examine(pure, inputs, &raw.sample, plan).ok();
    let gain = examined.as_ref().and_then(|examined| gain(pure, inputs, examined, &raw.candidate));
    Found {
        hazard,
        level,
        place: raw.candidate.place.clone(),
        reader: None,
        operation: raw.candidate.operation,
        kind: raw.candidate.kind,
        about: raw.candidate.about.iter().map(|&at| inputs[at].path.clone()).collect(),
        outcome: examined.map_or(raw.outcome, |examined| examined.outcome),
        breach: is_rule.then_some(raw.severity),
        condition: condition(pure, inputs, &raw.sample, plan)
            .filter(|_| raw.candidate.kind.is_none()),
        case: case(writing, &raw.sample),
        gain,
        permitted: permitted(pure, &raw.sample, plan),
        against: None,
        readers: Vec::new(),
        seen: raw.seen,
        plausible: raw.plausible,
    }
}

fn endless(writing: &Writing<'_>, sample: &Sample) -> Found {
    Found {
        hazard: Hazard::EndlessLoop,
        level: Level::Deny,
        place: writing.pure.place(),
        reader: None,
        operation: None,
        kind: None,
        about: Vec::new(),
        outcome: Outcome::Discarded,
        breach: None,
        case: case(writing, sample),
        condition: None,
        gain: None,
        permitted: None,
        against: None,
        readers: Vec::new(),
        seen: 1,
        plausible: false,
    }
}

/// What another function gives for a sample, each of its scalars one of those or nothing it reads.
fn against(other: &Pure, order: &[Option<usize>], plan: &Plan, sample: &Sample) -> Against {
    let words: Sample = order.iter().map(|at| at.map_or(0, |at| sample[at])).collect();
    let called = other.call(&columns(&[words]), 1, &settings(plan, false));
    let outcome = match called {
        Ok(called) => outcome(&called, &floats(other), 0),
        Err(_) => Outcome::Discarded,
    };
    Against { function: other.shown.clone(), outcome }
}

impl Report {
    /// Whether some sample with finite inputs gave a result that is not, on any reader.
    pub fn has_non_finite(&self) -> bool {
        self.tallies().any(|tally| tally.nan + tally.infinite > 0)
    }

    /// The largest error on any reader, in units of the last place.
    pub fn max_ulp(&self) -> f64 {
        self.tallies().map(|tally| tally.ulp.max).fold(0.0, f64::max)
    }

    /// The largest error on any reader, in steps.
    pub fn max_steps(&self) -> f64 {
        self.tallies().map(|tally| tally.steps.max).fold(0.0, f64::max)
    }

    fn tallies(&self) -> impl Iterator<Item = &Tally> {
        std::iter::once(&self.total).chain(self.readers.iter().map(|reader| &reader.tally))
    }

    /// The findings as lints have them.
    pub fn lints(&self) -> Vec<Finding> {
        self.findings.iter().map(|found| found.lint(self)).collect()
    }
}

impl Found {
    fn lint(&self, report: &Report) -> Finding {
        let mut notes = self.notes();
        notes.push(format!("to repeat it: {}", command(&self.case.arguments)));
        Finding {
            code: self.hazard.code().to_string(),
            level: self.level,
            message: self.message(),
            about: report.function.clone(),
            place: LintPlace::of(&report.files, self.place.span),
            text: self.label(),
            related: Vec::<Related>::new(),
            notes,
            listing: None,
            help: Some(self.hazard.info().robust.to_string()),
            fix: Vec::new(),
        }
    }
}
