//! The results of a bench, in the form of `landfall schema bench`.
//!
//! Built from [`Samples`] and [`Errors`]; printed by the report of `landfall bench`.

use crate::inputs::DistributedInput;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::clock::Clock;
use super::errors::{Errors, Quantiles};
use super::machine::Machine;
use super::rounds::Samples;
use super::spread::Spread;
use crate::plot::{Mark, Scatter};
use landfall_exec::backend::Device;
use landfall_layout::source::Target;

/// The result of `landfall bench`: variants on backends, time against error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Bench {
    /// The scene or function.
    pub subject: String,
    /// The truth that errors are measured against.
    pub truth: String,
    /// The unit that times and work are per.
    pub unit: Unit,
    /// The fragments or calls of one run.
    pub fragments: u64,
    /// The lights per fragment; 0 for a subject without lights.
    pub lights: u32,
    /// The inputs of a function; `None` for a scene.
    pub inputs: Option<SampledInputs>,
    /// The machine and its load.
    pub machine: Machine,
    /// The variants, in the order requested.
    pub rows: Vec<BenchRow>,
    /// The variants that did not run, with the reason.
    pub failed: Vec<Failed>,
}

/// The samples of a function's inputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SampledInputs {
    /// How each input is distributed.
    pub distributions: Vec<DistributedInput>,
    /// The samples so distributed, whose errors are measured.
    pub drawn: u64,
    /// The samples with inputs at an end of their range or another special value.
    pub ends: u64,
}

/// The call with the largest error of a variant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WorstCall {
    /// The samples that it is the worst of.
    pub of: SampleSet,
    /// The measure of the error.
    pub measure: ErrorMeasure,
    /// The error.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub error: f64,
    /// The inputs by path: a number, or the numbers of a vector.
    pub inputs: Map<String, Value>,
}

/// The samples of a bench of a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum SampleSet {
    /// As the inputs are distributed.
    Drawn,
    /// With inputs at ends of their ranges and special values.
    Ends,
}

/// The measure of an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum ErrorMeasure {
    /// Units of the last place of an `f32`.
    Ulp,
    /// Steps of 1/255 of full scale.
    Steps,
}

/// The unit of times and work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Unit {
    /// A fragment of a scene.
    #[default]
    Fragment,
    /// A call of a function.
    Call,
}

impl Unit {
    /// The name in tables and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Unit::Fragment => "fragment",
            Unit::Call => "call",
        }
    }
}

/// A variant that did not run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Failed {
    /// The name of the variant.
    pub variant: String,
    /// `rust`, `cpu`, `gl` or `gpu`.
    pub backend: String,
    /// The reason.
    pub reason: String,
}

/// The backend, device and clock of a variant.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Runner {
    /// `rust`, `cpu`, `gl` or `gpu`.
    #[cfg_attr(feature = "schema", schemars(extend("enum" = ["rust", "cpu", "gl", "gpu"])))]
    pub backend: String,
    /// The adapter, its driver and its version.
    pub device: String,
    /// The clock of its times.
    pub clock: Clock,
}

impl Runner {
    /// Returns the runner for a backend's device.
    pub fn new(device: &Device, clock: Clock) -> Runner {
        let Device { backend, adapter, driver, version, .. } = device;
        let device = format!("{adapter}, {driver} {version}");
        Runner { backend: (*backend).to_string(), device, clock }
    }
}

/// The work of one run, the same on every machine.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Work {
    /// The lights evaluated per fragment; skipped slots do not count.
    pub evaluations: Option<f64>,
    /// The standard error of the evaluations, where fragments and slots were sampled; 0 where all
    /// were counted.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub evaluations_error: Option<f64>,
    /// The slots that its loops visit per fragment, skipped or not.
    pub slots: Option<f64>,
    /// The `pow` operations per fragment.
    pub powers: Option<f64>,
    /// The interpreter's scalar operations per fragment or call.
    pub operations: Option<f64>,
    /// The bytes uploaded per frame: blocks, or arguments of calls.
    pub bytes: Option<u64>,
}

/// The largest error of any conformant device, by the bounds that WGSL and Vulkan set for each
/// operation of the code as written.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Permitted {
    /// The largest error of all samples in steps; `None` where results are unbounded.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub max_steps: Option<f64>,
    /// The 99.9 % quantile of the samples' errors, in steps.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub p999_steps: Option<f64>,
    /// The samples in which a branch may go the other way on another device, with unbounded effect;
    /// the errors above assume that it does not.
    pub unsure: u64,
    /// The samples examined.
    pub samples: u64,
}

impl Permitted {
    /// Summarises the steps of each sample, infinite where results are unbounded.
    pub(super) fn new(steps: &mut [f64], unsure: u64) -> Permitted {
        let samples = steps.len() as u64;
        let some = |x: f64| x.is_finite().then_some(x);
        let largest = Quantiles::new(steps).map(|all| (some(all.max), some(all.p999)));
        let (max_steps, p999_steps) = largest.unwrap_or_default();
        Permitted { max_steps, p999_steps, unsure, samples }
    }
}

/// A variant on a runner.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BenchRow {
    /// The name of the variant.
    pub variant: String,
    /// The API assumed for a shader that names none, if its blocks depend on it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub assumed_target: Option<Target>,
    /// The runner.
    pub runner: Runner,
    /// Nanoseconds per fragment and light: the slope from no light to all; `None` where the subject
    /// has no lights to leave out.
    #[serde(rename = "ns_per_light")]
    pub light: Option<Spread>,
    /// Nanoseconds per fragment, less those of an empty kernel where there is one.
    #[serde(rename = "ns_per_fragment")]
    pub fragment: Spread,
    /// The values of `light`, round by round.
    #[serde(rename = "ns_per_light_rounds")]
    pub light_rounds: Option<Vec<f64>>,
    /// The values of `fragment`, round by round.
    #[serde(rename = "ns_per_fragment_rounds")]
    pub fragment_rounds: Vec<f64>,
    /// The median nanoseconds per fragment and light before subtraction.
    #[serde(rename = "ns_per_light_gross")]
    pub light_gross: Option<f64>,
    /// The median nanoseconds per fragment before subtraction.
    #[serde(rename = "ns_per_fragment_gross")]
    pub fragment_gross: f64,
    /// Whether the time of an empty kernel was subtracted.
    pub subtracted: bool,
    /// The errors against the truth: of a function, those of inputs as they are distributed.
    pub errors: Errors,
    /// The errors of a function with inputs at ends of their ranges and special values.
    pub ends: Option<Errors>,
    /// The calls of a function with the largest errors.
    pub worst: Vec<WorstCall>,
    /// The largest error of any conformant device, where known.
    pub permitted: Option<Permitted>,
    /// The work of one run.
    pub work: Work,
    /// The names of the better variants on the same runner.
    pub dominated_by: Vec<String>,
}

/// The numbers of fragments and lights that a time is divided by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// The fragments of one run.
    pub fragments: u64,
    /// The lights of one run.
    pub lights: u32,
}

impl BenchRow {
    /// Builds a row from samples; `None` if there are no rounds.
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
            // Round by round: what is subtracted was measured in the same round, under the same
            // load.
            let less = less.unwrap_or(&[]).iter().copied().chain(std::iter::repeat(0.0));
            whole.iter().zip(less).map(|(all, less)| 1e9 * (all - less) / by).collect()
        };
        let fragment_rounds = nanoseconds(&samples.whole, samples.trivial.as_deref(), fragments);
        let light_rounds = samples.unlit.as_deref().filter(|_| size.lights > 0).map(|unlit| {
            nanoseconds(&samples.whole, Some(unlit), fragments * f64::from(size.lights))
        });
        let gross = Spread::from_numbers(&nanoseconds(&samples.whole, None, fragments))?.median;
        Some(BenchRow {
            variant: variant.into(),
            assumed_target: None,
            runner: Runner { clock: samples.clock, ..runner },
            light: light_rounds.as_deref().and_then(Spread::from_numbers),
            fragment: Spread::from_numbers(&fragment_rounds)?,
            light_gross: light_rounds.as_ref().map(|_| gross / f64::from(size.lights)),
            fragment_gross: gross,
            light_rounds,
            fragment_rounds,
            subtracted: samples.trivial.is_some(),
            errors,
            ends: None,
            worst: Vec::new(),
            permitted: None,
            work,
            dominated_by: Vec::new(),
        })
    }
}

/// Returns a scatter plot of the bench: by time per light if every row has one, else per fragment.
pub fn drawing(bench: &Bench) -> Scatter {
    let by_light = !bench.rows.is_empty() && bench.rows.iter().all(|row| row.light.is_some());
    let marks = bench.rows.iter().map(|row| {
        let time = row.light.filter(|_| by_light).unwrap_or(row.fragment);
        let error = match row.errors {
            // A NaN is worse than any error: it goes to the end of the axis.
            Errors { non_finite: 0, max_steps, .. } => max_steps.unwrap_or(0.0),
            Errors { .. } => f64::INFINITY,
        };
        Mark {
            label: row.variant.clone(),
            series: row.runner.backend.clone(),
            time: [time.lower, time.median, time.upper],
            error,
            dominated: !row.dominated_by.is_empty(),
        }
    });
    Scatter {
        title: bench.subject.clone(),
        time: match by_light {
            true => "time per fragment and light, ns".to_string(),
            false => format!("time per {}, ns", bench.unit.name()),
        },
        error: "largest error, steps of 1/255".to_string(),
        marks: marks.collect(),
    }
}
