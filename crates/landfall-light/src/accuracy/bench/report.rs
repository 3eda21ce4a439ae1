//! What a bench found: plain data, as `landfall schema bench` describes it.
//!
//! Made of [`Samples`] and [`Errors`]; printed by the report of `landfall bench`.

use serde::{Deserialize, Serialize};

use super::clock::Clock;
use super::errors::{Errors, largest};
use super::machine::Machine;
use super::rank;
use super::rounds::Samples;
use super::spread::Spread;
use crate::accuracy::plot::{Mark, Scatter};
use landfall_exec::backend::Device;

/// A bench: variants of one subject.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bench {
    /// What was lit or called.
    pub subject: String,
    /// What errors are measured against.
    pub truth: String,
    /// What is lit or called how often.
    pub unit: Unit,
    /// Fragments, or calls, of one run.
    pub fragments: u64,
    /// Lights that a fragment is lit by; 0 where the subject has none.
    pub lights: u32,
    /// Where, and how busy it was.
    pub machine: Machine,
    /// The variants, in the order they were given.
    pub rows: Vec<BenchRow>,
    /// Variants that did not run, and why.
    pub failed: Vec<Failed>,
}

/// What time and work are given for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Unit {
    /// A fragment of a scene.
    #[default]
    Fragment,
    /// A call of a function.
    Call,
}

impl Unit {
    /// As it is written in tables.
    pub fn name(self) -> &'static str {
        match self {
            Unit::Fragment => "fragment",
            Unit::Call => "call",
        }
    }
}

/// A variant that did not run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failed {
    /// Its name.
    pub variant: String,
    /// `rust`, `cpu`, `gl` or `gpu`.
    pub reader: String,
    /// Why.
    pub reason: String,
}

/// Who ran a variant.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Runner {
    /// `rust`, `cpu`, `gl` or `gpu`.
    pub reader: String,
    /// The adapter, its driver and its version.
    pub device: String,
    /// What measured its time.
    pub clock: Clock,
}

impl Runner {
    /// A reader's device.
    pub fn of(device: &Device, clock: Clock) -> Runner {
        let Device { reader, adapter, driver, version, .. } = device;
        let device = format!("{adapter}, {driver} {version}");
        Runner { reader: (*reader).to_string(), device, clock }
    }
}

/// Work of one run, the same on every machine.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Work {
    /// Lights evaluated for a fragment: a slot that is skipped is none.
    pub evaluations: Option<f64>,
    /// The standard error of that, where only some fragments and slots were looked at; 0 where
    /// all were.
    pub evaluations_error: Option<f64>,
    /// Slots for lights that its loops are given for a fragment, skipped or not.
    pub slots: Option<f64>,
    /// Powers taken for a fragment.
    pub powers: Option<f64>,
    /// Scalar operations of the evaluator for a fragment, or a call.
    pub operations: Option<f64>,
    /// Bytes uploaded for a frame: of blocks, or of what is called with.
    pub bytes: Option<u64>,
}

/// How far from the truth any conformant device may be, by the bounds WGSL and Vulkan set to each
/// operation of the code as it is written.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Permitted {
    /// In steps, at the worst sample; none where a device may give anything.
    pub max_steps: Option<f64>,
    /// What 99.9 % of the samples do not exceed.
    pub p999_steps: Option<f64>,
    /// Samples at which a branch may go the other way on another device, and so lead anywhere;
    /// distances are those of the way it goes.
    pub unsure: u64,
    /// Samples that were looked at.
    pub samples: u64,
}

impl Permitted {
    /// Of the steps of each sample, infinite where a device may give anything.
    pub(super) fn of(steps: &mut [f64], unsure: u64) -> Permitted {
        let samples = steps.len() as u64;
        let some = |x: f64| x.is_finite().then_some(x);
        let largest = largest(steps).map(|(max, p999)| (some(max), some(p999)));
        let (max_steps, p999_steps) = largest.unwrap_or_default();
        Permitted { max_steps, p999_steps, unsure, samples }
    }
}

/// A variant on a runner.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BenchRow {
    /// The variant's name.
    pub variant: String,
    /// Who ran it.
    pub runner: Runner,
    /// Nanoseconds a fragment and light: the slope from no light to all; none where the subject
    /// has no lights to leave out.
    #[serde(rename = "ns_per_light")]
    pub light: Option<Spread>,
    /// Nanoseconds a fragment, less a kernel that does nothing where there is one.
    #[serde(rename = "ns_per_fragment")]
    pub fragment: Spread,
    /// The same, round by round.
    #[serde(rename = "ns_per_light_rounds")]
    pub light_rounds: Option<Vec<f64>>,
    /// The same, round by round.
    #[serde(rename = "ns_per_fragment_rounds")]
    pub fragment_rounds: Vec<f64>,
    /// Nanoseconds a fragment and light with all that is subtracted: the median.
    #[serde(rename = "ns_per_light_gross")]
    pub light_gross: Option<f64>,
    /// Nanoseconds a fragment with what is subtracted: the median.
    #[serde(rename = "ns_per_fragment_gross")]
    pub fragment_gross: f64,
    /// Whether a kernel that does nothing was subtracted.
    pub subtracted: bool,
    /// How far it is from the truth.
    pub errors: Errors,
    /// How far any conformant device may be from it, where that is known.
    pub permitted: Option<Permitted>,
    /// What it did.
    pub work: Work,
    /// Names of the variants of its runner that are better.
    pub dominated_by: Vec<String>,
}

/// How many fragments and lights a sample's time is divided by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Fragments of one run.
    pub fragments: u64,
    /// Lights of one run.
    pub lights: u32,
}

impl BenchRow {
    /// A row of samples; none of no rounds.
    pub fn new(
        variant: impl Into<String>,
        runner: Runner,
        samples: &Samples,
        size: Size,
        errors: Errors,
        work: Work,
    ) -> Option<BenchRow> {
        let fragments = size.fragments.max(1) as f64;
        let nanoseconds = |whole: &[f64], less: Option<&[f64]>, by: f64| -> Vec<f64> {
            let less = less.unwrap_or(&[]).iter().copied().chain(std::iter::repeat(0.0));
            whole.iter().zip(less).map(|(all, less)| 1e9 * (all - less) / by).collect()
        };
        let fragment_rounds = nanoseconds(&samples.whole, samples.trivial.as_deref(), fragments);
        let light_rounds = samples.unlit.as_deref().filter(|_| size.lights > 0).map(|unlit| {
            nanoseconds(&samples.whole, Some(unlit), fragments * f64::from(size.lights))
        });
        let gross = Spread::of(&nanoseconds(&samples.whole, None, fragments))?.median;
        Some(BenchRow {
            variant: variant.into(),
            runner: Runner { clock: samples.clock, ..runner },
            light: light_rounds.as_deref().and_then(Spread::of),
            fragment: Spread::of(&fragment_rounds)?,
            light_gross: light_rounds.as_ref().map(|_| gross / f64::from(size.lights)),
            fragment_gross: gross,
            light_rounds,
            fragment_rounds,
            subtracted: samples.trivial.is_some(),
            errors,
            permitted: None,
            work,
            dominated_by: Vec::new(),
        })
    }
}

impl Bench {
    /// The same with each row told which rows are better.
    pub fn ranked(mut self) -> Bench {
        let better = rank::dominated(&self.rows);
        let names: Vec<String> = self.rows.iter().map(|row| row.variant.clone()).collect();
        for (row, better) in self.rows.iter_mut().zip(better) {
            row.dominated_by = better.into_iter().map(|i| names[i].clone()).collect();
        }
        self
    }
}

/// A bench as a drawing: by the time of a light where every row has one, else of a fragment.
pub fn drawing(bench: &Bench) -> Scatter {
    let by_light = !bench.rows.is_empty() && bench.rows.iter().all(|row| row.light.is_some());
    let marks = bench.rows.iter().map(|row| {
        let time = row.light.filter(|_| by_light).unwrap_or(row.fragment);
        let error = match row.errors {
            Errors { non_finite: 0, max_steps, .. } => max_steps.unwrap_or(0.0),
            Errors { .. } => f64::INFINITY,
        };
        Mark {
            label: row.variant.clone(),
            series: row.runner.reader.clone(),
            time: [time.lower, time.median, time.upper],
            error,
            dominated: !row.dominated_by.is_empty(),
        }
    });
    Scatter {
        title: bench.subject.clone(),
        time: match by_light {
            true => "time for a fragment and light, ns".to_string(),
            false => format!("time for a {}, ns", bench.unit.name()),
        },
        error: "largest error, steps of 1/255".to_string(),
        marks: marks.collect(),
    }
}
