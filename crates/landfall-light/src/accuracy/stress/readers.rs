//! What each driver made of the samples, readable and repeatable.
//!
//! Made of what [`drivers`](super::drivers) kept; part of the [`Report`](super::Report).

use super::case::{Case, Writing, case};
use super::condition::{Condition, condition};
use super::drivers::Drivers;
use super::input::Sample;
use super::judge::{Answered, Came, Seen, Why, came};
use super::measure::{Off, Outcome, floats};
use super::permitted::{PermittedAt, Verdict, permitted, verdict};
use super::report::{Asked, Found};
use super::sample::{Plan, Tally, columns, settings};
use super::shrink::plausible;
use landfall_exec::backend::BackendKind;
use landfall_exec::backend::{Device, Failure};
use landfall_exec::harness::call::pure::Pure;
use landfall_exec::interp::Floats;
use landfall_ir::analysis::hazard::Hazard;
use landfall_layout::finding::Level;

/// A driver beside the evaluator.
#[derive(Clone, Debug)]
pub struct ReaderReport {
    /// `gl` or `gpu`.
    pub reader: BackendKind,
    /// Who it is; none of one that is not here.
    pub device: Option<Device>,
    /// The samples of finite inputs it ran, and how they came out against the evaluator's `f64`.
    pub tally: Tally,
    /// Samples a second while it ran.
    pub rate: f64,
    /// The sample of the largest error in units of the last place, and that in steps.
    pub worst: Vec<DriverCase>,
    /// Not finite here, finite on the evaluator.
    pub not_finite: Odd,
    /// Finite here, not on the evaluator: what it hides.
    pub hidden: Odd,
    /// Off here by more than was asked for, and not on the evaluator.
    pub apart: Odd,
    /// Samples that one of the two discards and the other does not.
    pub parted: u64,
    /// Why it did not run, or ran no further.
    pub failure: Option<String>,
}

/// Samples in which a driver and the evaluator part.
#[derive(Clone, Debug, Default)]
pub struct Odd {
    /// How many.
    pub count: u64,
    /// The worst of them.
    pub cases: Vec<DriverCase>,
}

/// A sample on a driver.
#[derive(Clone, Debug)]
pub struct DriverCase {
    /// What it came to there.
    pub outcome: Came,
    /// The floats it gives, in the order of the results.
    pub results: Vec<f32>,
    /// Whether a conformant device may give these; none where that is not known, as of `f16`.
    pub verdict: Option<Verdict>,
    /// What the inputs' own rounding does.
    pub condition: Option<Condition>,
    /// Whether the inputs are numbers as scenes have them.
    pub plausible: bool,
    /// The sample, and how to repeat it there.
    pub case: Case,
}

impl DriverCase {
    /// Its error, where it has one.
    pub fn off(&self) -> Option<Off> {
        match self.outcome {
            Came::Finite(off) => off,
            Came::NotANumber | Came::Infinite => None,
        }
    }
}

impl ReaderReport {
    /// One that is not here.
    pub fn missing(reader: BackendKind, failure: &Failure) -> ReaderReport {
        ReaderReport {
            reader,
            device: None,
            tally: Tally::default(),
            rate: 0.0,
            worst: Vec::new(),
            not_finite: Odd::default(),
            hidden: Odd::default(),
            apart: Odd::default(),
            parted: 0,
            failure: Some(failure.message.clone()),
        }
    }

    /// Whether it ran anything.
    pub fn ran(&self) -> bool {
        self.tally.samples > 0
    }

    /// What of it is a finding: the worst sample of each kind that the evaluator alone does not
    /// show.
    pub(super) fn odd(&self) -> impl Iterator<Item = (Hazard, &DriverCase, u64)> {
        let kinds: [(Hazard, &Odd); 2] =
            [(Hazard::DriverNotFinite, &self.not_finite), (Hazard::DriverApart, &self.apart)];
        kinds.into_iter().filter_map(|(hazard, odd)| {
            let case = odd.cases.first()?;
            Some((hazard, case, odd.count))
        })
    }
}

/// The reports of all drivers.
pub(super) fn reports(drivers: &Drivers<'_>, writing: &Writing<'_>) -> Vec<ReaderReport> {
    let mut reports = Vec::new();
    for seen in drivers.seen() {
        let case = |kept: &Answered| {
            let (sample, results) = &kept.sample;
            written(writing, &seen.device, sample, results)
        };
        let odd = |why: Why| {
            let nth = why as usize;
            Odd { count: seen.counts[nth], cases: seen.tops[nth].iter().map(case).collect() }
        };
        let [ulp, steps, apart, not_finite, hidden] = Why::ALL.map(odd);
        let worst = [ulp, steps].into_iter().filter_map(|odd| odd.cases.into_iter().next());
        let ran_all = seen.ran.max(seen.tally.samples);
        reports.push(ReaderReport {
            reader: seen.device.reader,
            rate: ran_all as f64 / seen.busy.as_secs_f64().max(1.0e-9),
            worst: worst.collect(),
            not_finite,
            hidden,
            apart,
            parted: seen.parted,
            failure: failure(&seen),
            tally: seen.tally,
            device: Some(seen.device),
        });
    }
    reports
}

/// Why a driver did not run, or ran no further.
fn failure(seen: &Seen) -> Option<String> {
    let ran = seen.tally.samples;
    let Some(failure) = &seen.failure else {
        return (seen.cut && ran == 0).then(|| "the time was up before it was done".to_string());
    };
    let mut lines = failure.log.lines().filter(|line| !line.trim().is_empty());
    let first = lines.clone().next();
    let log = lines.find(|line| line.contains("error")).or(first);
    Some(match (ran, log) {
        (0, Some(log)) => format!("{}: {}", failure.message, log.trim()),
        (0, None) => failure.message.clone(),
        (ran, _) => format!("after {ran} samples: {}", failure.message),
    })
}

/// Whether the bounds of a driver are known: OpenGL's compiler has its own ways to invert a matrix,
/// for which no specification has a formula; wgpu is given ours.
fn known(pure: &Pure, device: &Device) -> bool {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let inverts = |text: &str| {
        text.split(|c| !is_word(c)).any(|word| matches!(word, "inverse" | "determinant"))
    };
    device.reader != BackendKind::Gl || !pure.files.iter().any(|file| inverts(&file.text))
}

/// A sample with what a driver gives for it.
fn written(writing: &Writing<'_>, device: &Device, sample: &Sample, results: &[f32]) -> DriverCase {
    let Writing { pure, inputs, plan, .. } = writing;
    let truth = pure.call(&columns(std::slice::from_ref(sample)), 1, &settings(plan, false));
    let floats = floats(pure);
    let double = |nth: usize| {
        let (result, at) = floats[nth];
        truth.as_ref().map_or(f64::NAN, |truth| truth.results[result].doubles[at][0])
    };
    let outcome = came(floats.len(), |nth| (results[nth], double(nth)));
    let mut case = case(&Writing { floats: Floats::AsWritten, ..*writing }, sample);
    case.arguments.extend(["--reader".to_string(), device.reader.to_string()]);
    DriverCase {
        outcome,
        results: results.to_vec(),
        verdict: verdict(pure, sample, plan, results).filter(|_| known(pure, device)),
        condition: condition(pure, inputs, sample, plan),
        plausible: plausible(inputs, sample),
        case,
    }
}

/// What is wrong on a driver alone: where in the function is not known.
pub(super) fn on_a_driver(
    pure: &Pure,
    plan: &Plan,
    reader: BackendKind,
    (hazard, found, seen): (Hazard, &DriverCase, u64),
) -> Found {
    let wrong = found.verdict == Some(Verdict::Wrong);
    let sample = &found.case.words;
    Found {
        hazard,
        level: match (wrong, found.plausible) {
            (true, true) => Level::Deny,
            (false, true) => hazard.info().level,
            (_, false) => Level::Warn,
        },
        place: pure.place(),
        reader: Some(reader),
        operation: None,
        kind: None,
        about: Vec::new(),
        outcome: match found.outcome {
            Came::NotANumber => Outcome::NotANumber,
            Came::Infinite => Outcome::Infinite,
            Came::Finite(off) => Outcome::Off(off.unwrap_or_default(), false),
        },
        breach: None,
        case: found.case.clone(),
        condition: found.condition.clone(),
        gain: None,
        // By what the driver gives, not the evaluator.
        permitted: permitted(pure, sample, plan).map(|p| PermittedAt { any: !wrong, ..p }),
        against: None,
        readers: Vec::new(),
        seen: usize::try_from(seen).unwrap_or(usize::MAX),
        plausible: found.plausible,
    }
}

/// Has the drivers call the function with the input of each finding.
pub(super) fn ask(drivers: &mut Drivers<'_>, findings: &mut [Found]) {
    let samples: Vec<Sample> = findings.iter().map(|found| found.case.words.clone()).collect();
    for (reader, given) in drivers.ask(&samples) {
        for (nth, found) in findings.iter_mut().enumerate() {
            found.readers.push(match &given {
                Ok(given) => Asked { reader, results: given[nth].clone(), failure: None },
                Err(why) => Asked { reader, results: Vec::new(), failure: Some(why.clone()) },
            });
        }
    }
}
