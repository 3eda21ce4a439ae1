//! The report of each driver: its statistics and worst samples.
//!
//! Built from the records of [`drivers`](super::drivers); part of the [`Report`](super::Report).

use super::case::{Case, CaseWriter};
use super::condition::{Condition, condition};
use super::drivers::Drivers;
use super::found::{BackendResult, StressFinding};
use super::input::Sample;
use super::kept::Tally;
use super::measure::{Outcome, SampleError, floats};
use super::permitted::{PermittedAt, Verdict, permitted, verdict};
use super::plan::{SampleSearch, columns, settings};
use super::verdict::{Answered, DriverKeepReason, DriverOutcome, DriverRecord, driver_outcome};
use landfall_exec::backend::BackendKind;
use landfall_exec::backend::{Device, Failure};
use landfall_exec::harness::call::pure::PureFunction;
use landfall_ir::analysis::hazard::Hazard;
use landfall_layout::finding::Level;

/// The results of a driver, compared with the interpreter's.
#[derive(Clone, Debug)]
pub struct BackendReport {
    /// `gl` or `gpu`.
    pub backend: BackendKind,
    /// The device; `None` if missing.
    pub device: Option<Device>,
    /// The statistics of the samples with finite inputs, against the interpreter's `f64`.
    pub tally: Tally,
    /// Samples per second of driver time.
    pub rate: f64,
    /// The samples with the largest error in units of the last place, and in steps.
    pub worst: Vec<DriverCase>,
    /// Samples not finite on the driver but finite on the interpreter.
    pub not_finite: Disagreement,
    /// Samples finite on the driver but not on the interpreter.
    pub hidden: Disagreement,
    /// Samples beyond the error limit on the driver but not on the interpreter.
    pub apart: Disagreement,
    /// Samples discarded by either the driver or the interpreter, not both.
    pub parted: u64,
    /// The reason it did not run, or stopped.
    pub failure: Option<String>,
}

/// Samples in which a driver and the interpreter disagree.
#[derive(Clone, Debug, Default)]
pub struct Disagreement {
    pub count: u64,
    /// The worst of them.
    pub cases: Vec<DriverCase>,
}

#[derive(Clone, Debug)]
pub struct DriverCase {
    pub outcome: DriverOutcome,
    /// The floats of the results, in order.
    pub results: Vec<f32>,
    /// Whether a conformant device may return these; `None` where unknown, as for `f16`.
    pub verdict: Option<Verdict>,
    /// The effect of the inputs' own rounding.
    pub condition: Option<Condition>,
    /// Whether the inputs are values that occur in scenes.
    pub plausible: bool,
    /// The sample, and the command to reproduce it on the driver.
    pub case: Case,
}

impl DriverCase {
    /// Returns the error, if finite.
    pub fn off(&self) -> Option<SampleError> {
        match self.outcome {
            DriverOutcome::Finite(off) => off,
            DriverOutcome::NotANumber | DriverOutcome::Infinite => None,
        }
    }
}

impl BackendReport {
    pub fn missing(backend: BackendKind, failure: &Failure) -> BackendReport {
        BackendReport {
            backend,
            device: None,
            tally: Tally::default(),
            rate: 0.0,
            worst: Vec::new(),
            not_finite: Disagreement::default(),
            hidden: Disagreement::default(),
            apart: Disagreement::default(),
            parted: 0,
            failure: Some(failure.message.clone()),
        }
    }

    /// Whether it ran any sample.
    pub fn ran(&self) -> bool {
        self.tally.samples > 0
    }

    /// Returns the findings on this driver alone: the worst sample of each kind.
    pub(super) fn driver_findings(&self) -> impl Iterator<Item = (Hazard, &DriverCase, u64)> {
        let kinds: [(Hazard, &Disagreement); 2] =
            [(Hazard::DriverNotFinite, &self.not_finite), (Hazard::DriverApart, &self.apart)];
        kinds.into_iter().filter_map(|(hazard, odd)| {
            let case = odd.cases.first()?;
            Some((hazard, case, odd.count))
        })
    }
}

pub(super) fn reports(
    drivers: &Drivers<'_>,
    search: SampleSearch<'_>,
    writer: &CaseWriter<'_>,
) -> Vec<BackendReport> {
    let writer = writer.clone().for_drivers();
    let mut reports = Vec::new();
    for seen in drivers.records() {
        let case = |kept: &Answered| {
            let (sample, results) = &kept.sample;
            driver_case(search, &writer, &seen.device, sample, results)
        };
        let odd = |why: DriverKeepReason| {
            let nth = why as usize;
            Disagreement {
                count: seen.counts[nth],
                cases: seen.tops[nth].iter().map(case).collect(),
            }
        };
        let [ulp, steps, apart, not_finite, hidden] = DriverKeepReason::ALL.map(odd);
        let worst = [ulp, steps].into_iter().filter_map(|odd| odd.cases.into_iter().next());
        let ran_all = seen.ran.max(seen.tally.samples);
        reports.push(BackendReport {
            backend: seen.device.backend,
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

/// Returns the reason a driver did not run, or stopped.
fn failure(seen: &DriverRecord) -> Option<String> {
    let ran = seen.tally.samples;
    let Some(failure) = &seen.failure else {
        // Compilation errors are in the log: the first line that says `error`, else the first.
        return (seen.cut && ran == 0).then(|| "time ran out before it finished".to_string());
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

/// Whether the error bounds of a driver are known: OpenGL compilers invert matrices by their own
/// methods, which no specification bounds; on wgpu the inverse is Landfall's.
fn has_known_bounds(pure: &PureFunction, device: &Device) -> bool {
    // By words of the text: `inverse(m)` and `determinant(m)` of GLSL.
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let inverts = |text: &str| {
        text.split(|c| !is_word(c)).any(|word| matches!(word, "inverse" | "determinant"))
    };
    device.backend != BackendKind::Gl || !pure.files.iter().any(|file| inverts(&file.text))
}

/// Returns a sample with a driver's results.
fn driver_case(
    search: SampleSearch<'_>,
    writer: &CaseWriter<'_>,
    device: &Device,
    sample: &Sample,
    results: &[f32],
) -> DriverCase {
    let SampleSearch { pure, plan, .. } = search;
    let truth = pure.call(&columns(std::slice::from_ref(sample)), 1, &settings(plan, false));
    let floats = floats(pure);
    let double = |nth: usize| {
        let (result, at) = floats[nth];
        truth.as_ref().map_or(f64::NAN, |truth| truth.results[result].doubles[at][0])
    };
    let outcome = driver_outcome(&floats, |nth| (results[nth], double(nth)));
    let mut case = writer.case(sample);
    case.arguments.extend(["--backend".to_string(), device.backend.to_string()]);
    // The truth of a driver is the interpreter's `f64` for the same words.
    DriverCase {
        outcome,
        results: results.to_vec(),
        verdict: verdict(search, sample, results).filter(|_| has_known_bounds(pure, device)),
        condition: condition(search, sample),
        plausible: search.is_plausible(sample),
        case,
    }
}

/// Returns a finding for one driver; the place in the function is unknown.
pub(super) fn on_a_driver(
    search: SampleSearch<'_>,
    backend: BackendKind,
    (hazard, found, seen): (Hazard, &DriverCase, u64),
) -> StressFinding {
    let wrong = found.verdict == Some(Verdict::Wrong);
    // A result outside of what the specification permits is an error of the driver, whatever the
    // hazard's usual level; inputs that occur nowhere only warn.
    let level = match (wrong, found.plausible) {
        (true, true) => Level::Deny,
        (false, true) => hazard.info().level,
        (_, false) => Level::Warn,
    };
    let outcome = match found.outcome {
        DriverOutcome::NotANumber => Outcome::NotANumber,
        DriverOutcome::Infinite => Outcome::Infinite,
        DriverOutcome::Finite(off) => Outcome::Finite(off.unwrap_or_default(), false),
    };
    // Whether it is permitted depends on the driver's result, not the interpreter's.
    let permitted = permitted(search, &found.case.words);
    StressFinding {
        level,
        backend: Some(backend),
        condition: found.condition.clone(),
        permitted: permitted.map(|p| PermittedAt { any: !wrong, ..p }),
        seen: usize::try_from(seen).unwrap_or(usize::MAX),
        plausible: found.plausible,
        ..StressFinding::bare(hazard, search.pure.place(), outcome, found.case.clone())
    }
}

pub(super) fn run_findings_on_drivers(drivers: &mut Drivers<'_>, findings: &mut [StressFinding]) {
    let samples: Vec<Sample> = findings.iter().map(|found| found.case.words.clone()).collect();
    for (backend, given) in drivers.run_samples(&samples) {
        for (nth, found) in findings.iter_mut().enumerate() {
            found.backends.push(match &given {
                Ok(given) => BackendResult { backend, results: given[nth].clone(), failure: None },
                Err(why) => {
                    BackendResult { backend, results: Vec::new(), failure: Some(why.clone()) }
                }
            });
        }
    }
}
