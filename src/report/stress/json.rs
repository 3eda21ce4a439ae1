//! The JSON report of a stressed function.

use serde::Serialize;
use serde_json::Value;

use super::SHARE;
use crate::report::device::JsonBackend;
use crate::report::prove::{InputObject, OperationObject, case_inputs, inputs, operations};
use landfall_accuracy::stress::messages::{name, number};
use landfall_accuracy::stress::{
    BackendReport, Case, Condition, Disagreement, DistributedInput, DriverCase, DriverOutcome,
    Family, Outcome, Report, SampleError, Spread, StressFinding, Tally, Verdict, command,
};
use landfall_exec::backend::BackendKind;
use landfall_layout::format::SCHEMA_VERSION;
use landfall_layout::format::json::{Tool, to_lines};
use landfall_layout::source::Target;

pub use crate::report::schema::STRESS_SCHEMA;

#[derive(Serialize)]
struct StressObject<'a> {
    schema_version: u32,
    tool: Tool,
    path: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    assumed_target: Option<Target>,
    function: &'a str,
    precision: &'static str,
    seed: u64,
    threads: usize,
    seconds: f64,
    samples_per_second: f64,
    stopped: bool,
    all_inputs: Option<u64>,
    inputs: Vec<InputObject<'a>>,
    distributions: &'a [DistributedInput],
    families: Vec<FamilyObject>,
    total: TallyObject,
    worst: Vec<WorstObject<'a>>,
    backends: Vec<StressBackendObject<'a>>,
    findings: Vec<FoundObject<'a>>,
    operations: Vec<OperationObject>,
    notes: &'a [String],
}

#[derive(Serialize)]
struct FamilyObject {
    family: &'static str,
    #[serde(flatten)]
    tally: TallyObject,
}

#[derive(Serialize)]
struct TallyObject {
    samples: u64,
    discarded: u64,
    nan: u64,
    infinite: u64,
    endless: u64,
    undefined_operations: u64,
    ulp: SpreadObject,
    relative: SpreadObject,
    steps: SpreadObject,
}

#[derive(Serialize)]
struct StressBackendObject<'a> {
    #[serde(flatten)]
    asked: JsonBackend<'a>,
    failure: Option<&'a str>,
    samples: u64,
    samples_per_second: f64,
    discarded: u64,
    discards_otherwise: u64,
    nan: u64,
    infinite: u64,
    ulp: SpreadObject,
    relative: SpreadObject,
    steps: SpreadObject,
    worst: Vec<DriverCaseObject<'a>>,
    not_finite_here: OddObject<'a>,
    finite_here: OddObject<'a>,
    apart: OddObject<'a>,
}

#[derive(Serialize)]
struct OddObject<'a> {
    samples: u64,
    cases: Vec<DriverCaseObject<'a>>,
}

#[derive(Serialize)]
struct DriverCaseObject<'a> {
    by: Option<&'static str>,
    outcome: &'static str,
    error: Option<OffObject>,
    results: Vec<Value>,
    permitted: Option<bool>,
    condition: Option<ConditionObject<'a>>,
    case: CaseObject<'a>,
}

#[derive(Serialize)]
struct SpreadObject {
    max: Value,
    p999: Value,
}

#[derive(Serialize)]
struct WorstObject<'a> {
    by: &'static str,
    error: OffObject,
    condition: Option<ConditionObject<'a>>,
    case: CaseObject<'a>,
}

#[derive(Serialize)]
struct OffObject {
    ulp: Value,
    relative: Value,
    steps: Value,
}

#[derive(Serialize)]
struct ConditionObject<'a> {
    path: &'a str,
    steps: Value,
    number: Value,
}

#[derive(Serialize)]
struct CaseObject<'a> {
    inputs: Value,
    results: Vec<ResultObject<'a>>,
    command: String,
}

#[derive(Serialize)]
struct ResultObject<'a> {
    path: &'a str,
    f32: Value,
    f64: Value,
}

#[derive(Serialize)]
struct FoundObject<'a> {
    hazard: Option<&'static str>,
    code: &'static str,
    level: &'static str,
    message: String,
    function: &'a str,
    path: Option<String>,
    line: Option<u32>,
    column: Option<u32>,
    excerpt: &'a str,
    backend: Option<&'static str>,
    undefined: Option<&'static str>,
    operation: Option<PerformedObject>,
    about: &'a [String],
    outcome: &'static str,
    error: Option<OffObject>,
    breach_steps: Option<Value>,
    permitted: Option<PermittedObject>,
    condition: Option<ConditionObject<'a>>,
    rewrite: &'static str,
    gain: Option<GainObject>,
    advice: Option<AdviceObject<'a>>,
    against: Option<AgainstObject<'a>>,
    backends: Vec<AskedObject<'a>>,
    seen: usize,
    plausible: bool,
    case: CaseObject<'a>,
}

#[derive(Serialize)]
struct AdviceObject<'a> {
    rewrite: &'a str,
    before: &'a str,
    code: &'a str,
    ulp_before: Option<Value>,
    ulp_after: Value,
    flipped: Option<[usize; 2]>,
    samples: usize,
    proved_ulp: Option<Value>,
}

#[derive(Serialize)]
struct PermittedObject {
    steps: Value,
    any_adapter: bool,
}

#[derive(Serialize)]
struct AgainstObject<'a> {
    function: &'a str,
    outcome: &'static str,
    steps: Option<Value>,
}

#[derive(Serialize)]
struct AskedObject<'a> {
    backend: &'a str,
    results: Vec<Value>,
    failure: Option<&'a str>,
}

#[derive(Serialize)]
struct PerformedObject {
    name: &'static str,
    operands: Vec<PairObject>,
    result: PairObject,
}

#[derive(Serialize)]
struct PairObject {
    f32: Value,
    f64: Value,
}

#[derive(Serialize)]
struct GainObject {
    form: &'static str,
    before: Value,
    after: Value,
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
        backends: stressed.backends.iter().map(reader_object).collect(),
        findings: stressed.findings.iter().map(|found| finding(stressed, found)).collect(),
        operations: operations(&stressed.operations, &stressed.files),
        notes: &stressed.notes,
    };
    format!("{}\n", to_lines(&object, 0))
}

fn spread(spread: &Spread) -> SpreadObject {
    SpreadObject { max: json_number(spread.max), p999: json_number(spread.quantile(SHARE)) }
}

fn reader_object(backend: &BackendReport) -> StressBackendObject<'_> {
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

/// Returns a JSON number, or a string for NaN and infinities.
fn json_number(x: f64) -> Value {
    match x.is_finite() {
        true => Value::from(x),
        false => Value::from(number(x).to_lowercase()),
    }
}

fn single(x: f32) -> Value {
    match x.is_finite() {
        // The shortest digits that round to this f32.
        true => format!("{x:?}").parse::<f64>().map_or(Value::Null, Value::from),
        false => Value::from(number(f64::from(x)).to_lowercase()),
    }
}

fn off(off: &SampleError) -> OffObject {
    OffObject {
        ulp: json_number(off.ulp),
        relative: json_number(off.relative),
        steps: json_number(off.steps),
    }
}

fn condition(condition: &Condition) -> ConditionObject<'_> {
    ConditionObject {
        path: &condition.path,
        steps: json_number(condition.steps),
        number: json_number(condition.number),
    }
}

fn case(case: &Case) -> CaseObject<'_> {
    CaseObject {
        inputs: case_inputs(case),
        results: case
            .results
            .iter()
            .map(|r| ResultObject {
                path: &r.path,
                f32: single(r.single),
                f64: json_number(r.double),
            })
            .collect(),
        command: command(&case.arguments),
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
        undefined: found.kind.map(landfall_interp::UndefinedKind::text),
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
