//! The JSON report of a stressed function.

mod case;

use serde::Serialize;

use super::SHARE;
use crate::report::prove::{InputObject, OperationObject, inputs, operations};
use case::{CaseObject, ConditionObject, JsonNumber, OffObject};
use case::{case, condition, json_number, off, single};
use landfall_accuracy::stress::messages::name;
use landfall_accuracy::stress::{
    BackendReport, Disagreement, DistributedInput, DriverCase, DriverOutcome, Family, Outcome,
    Report, Spread, StressFinding, Tally, Verdict,
};
use landfall_exec::backend::BackendKind;
use landfall_exec::report::device::JsonBackend;
use landfall_layout::format::SCHEMA_VERSION;
use landfall_layout::format::json::{Tool, to_lines};
use landfall_layout::source::Target;

pub use crate::report::schema::STRESS_SCHEMA;

/// The inputs at which a shader's function breaks, and its errors.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct StressObject<'a> {
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA_VERSION)))]
    schema_version: u32,
    tool: Tool,
    path: &'a str,
    /// The API assumed for a shader that tests `VULKAN` without declaring its API, if its blocks
    /// depend on it.
    #[serde(skip_serializing_if = "Option::is_none")]
    assumed_target: Option<Target>,
    /// The function with its parameter types: phong(vec3, Light).
    function: &'a str,
    /// The precision of the function, compared with f64.
    #[cfg_attr(feature = "schema", schemars(extend("enum" = ["single", "half", "mediump"])))]
    precision: &'static str,
    seed: u64,
    threads: usize,
    seconds: f64,
    samples_per_second: f64,
    /// Whether time ran out or a stop was requested before all samples had run.
    stopped: bool,
    /// The number of inputs of the domain, each run once; null if there are more than the samples
    /// requested, or if it stopped early.
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    all_inputs: Option<u64>,
    inputs: Vec<InputObject<'a>>,
    /// How each input is distributed in the samples that are drawn.
    distributions: &'a [DistributedInput],
    families: Vec<FamilyObject>,
    /// The samples of all sources but `special`, whose inputs are not finite.
    total: TallyObject,
    worst: Vec<WorstObject<'a>>,
    /// The requested drivers, each with every sample of finite inputs compared with the
    /// interpreter's f64 of the same bits.
    backends: Vec<StressBackendObject<'a>>,
    findings: Vec<FoundObject<'a>>,
    /// The verdict on each operation that can have an undefined or inaccurate result; empty if the
    /// code is too large to analyse.
    operations: Vec<OperationObject>,
    notes: &'a [String],
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct FamilyObject {
    /// The source of the samples. coincidences: inputs equal, opposite, zero or at a limit; scenes:
    /// values as in scenes; drawn: as the domain distributes the inputs; bits: random finite
    /// floats; mixed: scenes with one input of random bits; special: infinity and NaN; climbed:
    /// found from the worst of the others; every: all inputs of a small domain.
    #[cfg_attr(feature = "schema", schemars(extend("enum" = Family::ALL.map(Family::name))))]
    family: &'static str,
    #[serde(flatten)]
    tally: TallyObject,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct TallyObject {
    samples: u64,
    /// The samples that executed `discard`.
    discarded: u64,
    nan: u64,
    infinite: u64,
    /// The samples that did not end within the limit of iterations.
    endless: u64,
    /// The operations with an undefined result; counted in all samples of `coincidences` and
    /// `scenes`, or of `every`, and in no others.
    undefined_operations: u64,
    ulp: SpreadObject,
    relative: SpreadObject,
    steps: SpreadObject,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct StressBackendObject<'a> {
    #[serde(flatten)]
    asked: JsonBackend<'a>,
    /// The reason it did not run, or stopped.
    failure: Option<&'a str>,
    samples: u64,
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    samples_per_second: f64,
    /// The samples that executed `discard`.
    discarded: u64,
    /// The samples discarded by either the driver or the interpreter, not both.
    discards_otherwise: u64,
    nan: u64,
    infinite: u64,
    ulp: SpreadObject,
    relative: SpreadObject,
    steps: SpreadObject,
    worst: Vec<DriverCaseObject<'a>>,
    /// Not finite on the driver, finite on the interpreter.
    not_finite_here: OddObject<'a>,
    /// Finite on the driver, not on the interpreter.
    finite_here: OddObject<'a>,
    /// Beyond the error limit on the driver, but not on the interpreter.
    apart: OddObject<'a>,
}

/// The samples in which a driver and the interpreter disagree: their number, and the worst.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct OddObject<'a> {
    samples: u64,
    cases: Vec<DriverCaseObject<'a>>,
}

/// A sample on a driver.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct DriverCaseObject<'a> {
    /// The measure of error by which it is the worst.
    #[cfg_attr(feature = "schema", schemars(extend("enum" = ["ulp", "steps"])))]
    by: Option<&'static str>,
    #[cfg_attr(feature = "schema", schemars(extend("enum" = ["finite", "nan", "infinite"])))]
    outcome: &'static str,
    error: Option<OffObject>,
    /// The floats of the results, in order.
    results: Vec<JsonNumber>,
    /// Whether a conformant device may return these results; null where unknown.
    permitted: Option<bool>,
    condition: Option<ConditionObject<'a>>,
    case: CaseObject<'a>,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct SpreadObject {
    max: JsonNumber,
    /// The 99.9 % quantile, accurate to one part in twelve.
    p999: JsonNumber,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct WorstObject<'a> {
    #[cfg_attr(feature = "schema", schemars(extend("enum" = ["ulp", "steps"])))]
    by: &'static str,
    error: OffObject,
    condition: Option<ConditionObject<'a>>,
    case: CaseObject<'a>,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct FoundObject<'a> {
    /// The hazard's code, as in `code`; null for plain arithmetic.
    hazard: Option<&'static str>,
    code: &'static str,
    #[cfg_attr(feature = "schema", schemars(extend("enum" = ["warn", "deny"])))]
    level: &'static str,
    message: String,
    function: &'a str,
    path: Option<String>,
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    line: Option<u32>,
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    column: Option<u32>,
    /// The operation in the source.
    excerpt: &'a str,
    /// The driver, for a finding on that driver alone.
    #[cfg_attr(feature = "schema", schemars(extend("enum" = ["gl", "gpu"])))]
    backend: Option<&'static str>,
    /// The undefined operation, such as `division by zero`; null for a loss of accuracy.
    undefined: Option<&'static str>,
    operation: Option<PerformedObject>,
    /// The inputs involved.
    about: &'a [String],
    /// The result for the simplest input.
    #[cfg_attr(
        feature = "schema",
        schemars(extend("enum" = ["finite", "nan", "infinite", "discarded"]))
    )]
    outcome: &'static str,
    error: Option<OffObject>,
    /// For a property that the result should have, such as that light from behind adds nothing, the
    /// steps by which it is violated.
    breach_steps: Option<JsonNumber>,
    /// The largest error of a conformant device at this input; null if unknown.
    permitted: Option<PermittedObject>,
    condition: Option<ConditionObject<'a>>,
    /// What the catalogue has against the hazard, not tried here; `advice` is.
    rewrite: &'static str,
    /// The error of that form for the same operands; null if not computed.
    gain: Option<GainObject>,
    /// Another form of the expression that was measured to be better; null if none of the catalogue
    /// is.
    advice: Option<AdviceObject<'a>>,
    /// The result of the function of --against for the same input; null without one.
    against: Option<AgainstObject<'a>>,
    /// The results of the drivers for the same input.
    backends: Vec<AskedObject<'a>>,
    seen: usize,
    /// Whether the inputs are values that occur in scenes.
    plausible: bool,
    case: CaseObject<'a>,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct AdviceObject<'a> {
    /// The name of the rewrite.
    rewrite: &'a str,
    /// The expression as it is.
    before: &'a str,
    /// The form to write in its place.
    code: &'a str,
    /// The largest error at the samples as it is; null where the result is not defined.
    ulp_before: Option<JsonNumber>,
    ulp_after: JsonNumber,
    /// The samples that rounding sends into another branch, as it is and with the form; null
    /// without a branch.
    flipped: Option<[usize; 2]>,
    /// The samples measured.
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    samples: usize,
    /// A proved bound of the function with that form over the domain, on any conformant device;
    /// null without one.
    proved_ulp: Option<JsonNumber>,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct PermittedObject {
    steps: JsonNumber,
    /// Whether the interpreter's error is within that of a conformant device.
    any_adapter: bool,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct AgainstObject<'a> {
    function: &'a str,
    outcome: &'static str,
    steps: Option<JsonNumber>,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct AskedObject<'a> {
    backend: &'a str,
    results: Vec<JsonNumber>,
    failure: Option<&'a str>,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct PerformedObject {
    name: &'static str,
    operands: Vec<PairObject>,
    result: PairObject,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct PairObject {
    f32: JsonNumber,
    f64: JsonNumber,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct GainObject {
    form: &'static str,
    before: JsonNumber,
    after: JsonNumber,
}

/// The schema of [`STRESS_SCHEMA`].
#[cfg(feature = "schema")]
#[doc(hidden)]
pub fn schema() -> String {
    landfall_layout::schema::text::<StressObject<'_>>("landfall stress --format json")
}

/// Returns the report as JSON, in the form of `landfall schema stress`.
pub fn json(stressed: &Report) -> String {
    let object = StressObject {
        schema_version: SCHEMA_VERSION,
        tool: Tool::LANDFALL,
        path: &stressed.path,
        assumed_target: stressed.assumed_target,
        function: &stressed.function,
        precision: stressed.precision,
        seed: stressed.seed,
        threads: stressed.threads,
        seconds: stressed.seconds,
        samples_per_second: stressed.rate,
        stopped: stressed.stopped,
        all_inputs: stressed.every,
        inputs: inputs(&stressed.inputs),
        distributions: &stressed.distributions,
        families: stressed
            .families
            .iter()
            .map(|(family, tally): &(Family, Tally)| FamilyObject {
                family: family.name(),
                tally: tally_object(tally),
            })
            .collect(),
        total: tally_object(&stressed.total),
        worst: ["ulp", "steps"]
            .into_iter()
            .zip(&stressed.worst)
            .map(|(by, worst)| WorstObject {
                by,
                error: off(&worst.off),
                condition: worst.condition.as_ref().map(condition),
                case: case(&worst.sample),
            })
            .collect(),
        backends: stressed.backends.iter().map(backend_object).collect(),
        findings: stressed.findings.iter().map(|found| finding(stressed, found)).collect(),
        operations: operations(&stressed.operations, &stressed.files),
        notes: &stressed.notes,
    };
    format!("{}\n", to_lines(&object))
}

fn spread(spread: &Spread) -> SpreadObject {
    SpreadObject { max: json_number(spread.max), p999: json_number(spread.quantile(SHARE)) }
}

fn backend_object(backend: &BackendReport) -> StressBackendObject<'_> {
    let tally = &backend.tally;
    let worst = ["ulp", "steps"].into_iter().zip(&backend.worst);
    StressBackendObject {
        asked: JsonBackend::new(backend.backend, backend.device.as_ref()),
        failure: backend.failure.as_deref(),
        samples: tally.samples,
        samples_per_second: backend.rate,
        discarded: tally.discarded,
        discards_otherwise: backend.parted,
        nan: tally.nan,
        infinite: tally.infinite,
        ulp: spread(&tally.ulp),
        relative: spread(&tally.relative),
        steps: spread(&tally.steps),
        worst: worst.map(|(by, found)| driver_case(Some(by), found)).collect(),
        not_finite_here: odd_object(&backend.not_finite),
        finite_here: odd_object(&backend.hidden),
        apart: odd_object(&backend.apart),
    }
}

fn odd_object(odd: &Disagreement) -> OddObject<'_> {
    let cases = odd.cases.iter().map(|found| driver_case(None, found)).collect();
    OddObject { samples: odd.count, cases }
}

fn driver_case<'a>(by: Option<&'static str>, found: &'a DriverCase) -> DriverCaseObject<'a> {
    DriverCaseObject {
        by,
        outcome: match found.outcome {
            DriverOutcome::NotANumber => "nan",
            DriverOutcome::Infinite => "infinite",
            DriverOutcome::Finite(_) => "finite",
        },
        error: found.off().as_ref().map(off),
        results: found.results.iter().map(|x| single(*x)).collect(),
        permitted: found.verdict.map(|verdict| verdict == Verdict::Permitted),
        condition: found.condition.as_ref().map(condition),
        case: case(&found.case),
    }
}

fn tally_object(tally: &Tally) -> TallyObject {
    TallyObject {
        samples: tally.samples,
        discarded: tally.discarded,
        nan: tally.nan,
        infinite: tally.infinite,
        endless: tally.endless,
        undefined_operations: tally.undefined,
        ulp: spread(&tally.ulp),
        relative: spread(&tally.relative),
        steps: spread(&tally.steps),
    }
}

fn came_to(outcome: &Outcome) -> &'static str {
    match outcome {
        Outcome::Discarded => "discarded",
        Outcome::NotANumber => "nan",
        Outcome::Infinite => "infinite",
        Outcome::Finite(..) => "finite",
    }
}

fn finding<'a>(stressed: &'a Report, found: &'a StressFinding) -> FoundObject<'a> {
    // A finding about the whole function has no place.
    let known = !found.place.shown.is_empty();
    let place = known.then(|| stressed.files.locate(found.place.span));
    let pair = |n: &landfall_interp::Number| PairObject {
        f32: single(n.single),
        f64: json_number(n.double),
    };
    FoundObject {
        hazard: (!found.hazard.is_arithmetic()).then_some(found.hazard.code()),
        code: found.hazard.code(),
        level: found.level.name(),
        message: found.message(),
        function: &found.place.function,
        line: place.as_ref().map(|place| place.line),
        column: place.as_ref().map(|place| place.column),
        path: place.map(|place| place.path),
        excerpt: stressed.files.text(found.place.span),
        backend: found.backend.map(BackendKind::name),
        undefined: found.kind.map(landfall_interp::UndefinedKind::name),
        operation: found.operation.as_ref().map(|operation| PerformedObject {
            name: name(operation.operation),
            operands: operation.operands.iter().map(pair).collect(),
            result: pair(&operation.result),
        }),
        about: &found.about,
        outcome: came_to(&found.outcome),
        error: match &found.outcome {
            Outcome::Finite(error, _) => Some(off(error)),
            Outcome::Discarded | Outcome::NotANumber | Outcome::Infinite => None,
        },
        breach_steps: found.breach.map(json_number),
        permitted: found
            .permitted
            .as_ref()
            .map(|p| PermittedObject { steps: json_number(p.steps), any_adapter: p.any }),
        condition: found.condition.as_ref().map(condition),
        rewrite: found.hazard.info().robust,
        gain: found.gain.as_ref().map(|gain| GainObject {
            form: gain.form,
            before: json_number(gain.before),
            after: json_number(gain.after),
        }),
        advice: found.advice.as_ref().map(|advice| AdviceObject {
            rewrite: advice.name,
            before: &advice.before,
            code: &advice.code,
            ulp_before: advice.ulp_before.map(json_number),
            ulp_after: json_number(advice.ulp_after),
            flipped: advice.flipped,
            samples: advice.samples,
            proved_ulp: advice.proved.map(json_number),
        }),
        against: found.against.as_ref().map(|against| AgainstObject {
            function: &against.function,
            outcome: came_to(&against.outcome),
            steps: match &against.outcome {
                Outcome::Finite(off, _) => Some(json_number(off.steps)),
                Outcome::Discarded | Outcome::NotANumber | Outcome::Infinite => None,
            },
        }),
        backends: found
            .backends
            .iter()
            .map(|asked| AskedObject {
                backend: asked.backend.name(),
                results: asked.results.iter().map(|x| single(*x)).collect(),
                failure: asked.failure.as_deref(),
            })
            .collect(),
        seen: found.seen,
        plausible: found.plausible,
        case: case(&found.case),
    }
}
