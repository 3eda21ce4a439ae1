//! What stressing a function found: a table and findings for people, JSON for programs, SARIF.
//!
//! Reads the plain data of [`accuracy::stress`](crate::accuracy::stress).

use std::fmt::Write as _;
use std::sync::Arc;

use serde::Serialize;
use serde_json::Value;

use super::SCHEMA_VERSION;
use super::device::JsonAsked;
use super::findings::{ReportFormat, ReportOptions, report};
use super::json::{Tool, to_lines};
use super::paint::{CAUTION, FAINT, PLAIN, Paint, STRONG};
use super::words;
use crate::accuracy::stress::words::{figure, name, number};
use crate::accuracy::stress::{
    Came, Case, Condition, DriverCase, Family, Found, Odd, Off, Outcome, ReaderReport, Report,
    Spread, Tally, Verdict, command,
};

/// The JSON Schema of [`json`].
pub const STRESS_SCHEMA: &str = include_str!("schema/stress.json");

/// The share of samples the second figure of each error leaves out.
const SHARE: f64 = 0.999;

/// A table of the samples, then the findings with their lines.
pub fn text(stressed: &Report, paint: Paint) -> String {
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{}  {}",
        paint.text(STRONG, &stressed.function),
        paint.text(FAINT, &stressed.path)
    );
    let threads = match stressed.threads {
        1 => "1 thread".to_string(),
        threads => format!("{threads} threads"),
    };
    let ran = match stressed.every {
        Some(1) => "the only input".to_string(),
        Some(all) => format!("all {} inputs", words::number(all)),
        None => format!("{} samples", words::number(stressed.total.samples)),
    };
    let _ = writeln!(
        text,
        "  {ran} in {:.1} s, {} a second on {threads}, seed {}{}",
        stressed.seconds,
        words::number(stressed.rate as u64),
        stressed.seed,
        if stressed.stopped { ", stopped before the end" } else { "" }
    );
    table(stressed, paint, &mut text);
    let worst = ["largest in ULP", "largest in steps"].into_iter().zip(&stressed.worst);
    for (what, worst) in worst.filter(|(_, worst)| worst.off.ulp > 0.0) {
        let _ = writeln!(
            text,
            "  {what}: {} ULP, {} steps with {}",
            figure(worst.off.ulp),
            figure(worst.off.steps),
            cut(&worst.sample.shown())
        );
        if let Some(condition) = worst.condition.as_ref().filter(|c| c.steps > 0.0) {
            let line = format!(
                "    one ULP of `{}` moves the result by {} steps; condition {}",
                condition.path,
                figure(condition.steps),
                figure(condition.number)
            );
            let _ = writeln!(text, "{}", paint.text(FAINT, &line));
        }
    }
    stressed.readers.iter().for_each(|reader| driver(reader, paint, &mut text));
    for note in &stressed.notes {
        let _ = writeln!(text, "  {}", paint.text(FAINT, note));
    }
    text.push('\n');
    text.push_str(&rendered(stressed, ReportFormat::Human, paint));
    text
}

/// Characters of a command that people are shown.
const LONG: usize = 600;

/// What a driver made of the samples, below the table.
fn driver(reader: &ReaderReport, paint: Paint, text: &mut String) {
    let name = reader.reader;
    if let Some(device) = &reader.device {
        let version = format!("{} {}", device.driver, device.version);
        let rate = match reader.ran() {
            true => format!(", {} samples a second", words::number(reader.rate as u64)),
            false => String::new(),
        };
        let _ = writeln!(text, "  {name}: {}, {}{rate}", device.adapter, version.trim());
    }
    if let Some(failure) = &reader.failure {
        let what = if reader.ran() { "stopped" } else { "did not run" };
        let line = format!("{name} {what}: {failure}");
        let _ = writeln!(text, "  {}", paint.text(CAUTION, &line));
    }
    let same = |pair: &[_]| matches!(pair, [a, b] if a == b);
    let arguments: Vec<_> = reader.worst.iter().map(|worst| &worst.case.arguments).collect();
    let names: &[&str] = match same(&arguments) {
        true => &["largest in ULP and in steps"],
        false => &["largest in ULP", "largest in steps"],
    };
    for (what, case) in names.iter().zip(&reader.worst) {
        let verdict = match case.verdict {
            Some(Verdict::Permitted) => ", as any conformant adapter may be",
            Some(Verdict::Wrong) => ", wrong on this adapter",
            None => "",
        };
        let off = case.off().unwrap_or_default();
        let (ulp, steps, inputs) = (figure(off.ulp), figure(off.steps), cut(&case.case.shown()));
        let _ =
            writeln!(text, "  {name}: {what}: {ulp} ULP, {steps} steps{verdict}, with {inputs}");
        let given = case.results.iter().zip(&case.case.results);
        let given: Vec<String> = given
            .map(|(single, truth)| {
                let (single, double) = (number(f64::from(*single)), number(truth.double));
                format!("{} is {single}, should be {double}", truth.path)
            })
            .collect();
        let again = match command(&case.case.arguments) {
            long if long.len() > LONG => "`--format json` has the command that repeats it".into(),
            short => short,
        };
        for line in [cut(&given.join("; ")), again] {
            let _ = writeln!(text, "{}", paint.text(FAINT, &format!("    {line}")));
        }
    }
    let parted = Odd { count: reader.parted, cases: Vec::new() };
    let odd = [
        (&reader.not_finite, "not finite where the evaluator is"),
        (&reader.hidden, "finite where the evaluator is not"),
        (&reader.apart, "off by more than is asked for where the evaluator is not"),
        (&parted, "discarded by one of the two"),
    ];
    for (odd, what) in odd.iter().filter(|(odd, _)| odd.count > 0) {
        let _ = writeln!(text, "  {name}: {} {what}", times(odd.count));
    }
}

fn times(count: u64) -> String {
    match count {
        1 => "1 sample".to_string(),
        count => format!("{count} samples"),
    }
}

/// A page with the map of errors and the findings below it.
pub fn page(stressed: &Report, svg: &str) -> String {
    let escaped = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    let title = escaped(&stressed.function);
    let findings = escaped(&text(stressed, Paint::Plain));
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{title}</title>\n\
         <body>\n{svg}\n<pre>{findings}</pre>\n</body>\n</html>\n"
    )
}

/// Longest line of values that is printed.
const LINE: usize = 400;

fn cut(values: &str) -> String {
    match values.char_indices().nth(LINE) {
        Some((at, _)) => format!("{}…", &values[..at]),
        None => values.to_string(),
    }
}

/// The findings in a format of `check`.
pub fn rendered(stressed: &Report, format: ReportFormat, paint: Paint) -> String {
    let lints = stressed.lints();
    let text = |path: &str| -> Option<Arc<str>> {
        stressed.files.iter().find(|file| file.path == path).map(|file| file.text.clone())
    };
    report(&lints, format, &ReportOptions { paint, text: &text, shaders: 1 })
}

/// The findings as SARIF.
pub fn sarif(stressed: &Report) -> String {
    rendered(stressed, ReportFormat::Sarif, Paint::Plain)
}

fn table(stressed: &Report, paint: Paint, text: &mut String) {
    let head =
        ["", "samples", "NaN", "inf", "max ULP", "p99.9", "max rel", "p99.9", "max steps", "p99.9"];
    let mut rows: Vec<Vec<String>> = vec![head.map(str::to_string).to_vec()];
    let mut row = |name: &str, tally: &Tally| {
        let mut row = vec![name.to_string(), tally.samples.to_string()];
        row.extend([tally.nan.to_string(), tally.infinite.to_string()]);
        for spread in [&tally.ulp, &tally.relative, &tally.steps] {
            row.extend([figure(spread.max), figure(spread.quantile(SHARE))]);
        }
        rows.push(row);
    };
    for (family, tally) in &stressed.families {
        if tally.samples > 0 {
            row(family.name(), tally);
        }
    }
    row("all finite inputs", &stressed.total);
    for reader in stressed.readers.iter().filter(|reader| reader.ran()) {
        row(&format!("the same on {}", reader.reader), &reader.tally);
    }
    let widths: Vec<usize> = (0..head.len())
        .map(|column| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0))
        .collect();
    for (nth, row) in rows.iter().enumerate() {
        let mut line = String::from("  ");
        for (column, (cell, &width)) in row.iter().zip(&widths).enumerate() {
            let pad = " ".repeat(width - cell.chars().count());
            match column {
                0 => line.push_str(&format!("{cell}{pad}")),
                _ => line.push_str(&format!("  {pad}{cell}")),
            }
        }
        let odd = nth > 0 && (row[2] != "0" || row[3] != "0") && row[0] != "special";
        let style = if nth == 0 {
            FAINT
        } else if odd {
            CAUTION
        } else {
            PLAIN
        };
        let _ = writeln!(text, "{}", paint.text(style, line.trim_end()));
    }
}

#[derive(Serialize)]
struct Object<'a> {
    schema_version: u32,
    tool: Tool,
    path: &'a str,
    function: &'a str,
    precision: &'static str,
    seed: u64,
    threads: usize,
    seconds: f64,
    samples_per_second: f64,
    stopped: bool,
    all_inputs: Option<u64>,
    inputs: Vec<InputObject<'a>>,
    families: Vec<FamilyObject>,
    total: TallyObject,
    worst: Vec<WorstObject<'a>>,
    readers: Vec<ReaderObject<'a>>,
    findings: Vec<FoundObject<'a>>,
    notes: &'a [String],
}

#[derive(Serialize)]
struct InputObject<'a> {
    path: &'a str,
    domain: &'a str,
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
struct ReaderObject<'a> {
    #[serde(flatten)]
    asked: JsonAsked<'a>,
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
    inputs: serde_json::Map<String, Value>,
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
    reader: Option<&'static str>,
    undefined: Option<&'static str>,
    operation: Option<OperationObject>,
    about: &'a [String],
    outcome: &'static str,
    error: Option<OffObject>,
    breach_steps: Option<Value>,
    permitted: Option<PermittedObject>,
    condition: Option<ConditionObject<'a>>,
    rewrite: &'static str,
    gain: Option<GainObject>,
    against: Option<AgainstObject<'a>>,
    readers: Vec<AskedObject<'a>>,
    seen: usize,
    plausible: bool,
    case: CaseObject<'a>,
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
    reader: &'a str,
    results: Vec<Value>,
    failure: Option<&'a str>,
}

#[derive(Serialize)]
struct OperationObject {
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

/// The report as JSON, as `landfall schema stress` describes it.
pub fn json(stressed: &Report) -> String {
    let object = Object {
        schema_version: SCHEMA_VERSION,
        tool: Tool::LANDFALL,
        path: &stressed.path,
        function: &stressed.function,
        precision: stressed.precision,
        seed: stressed.seed,
        threads: stressed.threads,
        seconds: stressed.seconds,
        samples_per_second: stressed.rate,
        stopped: stressed.stopped,
        all_inputs: stressed.every,
        inputs: stressed
            .inputs
            .iter()
            .map(|(input, domain)| InputObject { path: &input.path, domain })
            .collect(),
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
        readers: stressed.readers.iter().map(reader_object).collect(),
        findings: stressed.findings.iter().map(|found| finding(stressed, found)).collect(),
        notes: &stressed.notes,
    };
    format!("{}\n", to_lines(&object, 0))
}

fn spread(spread: &Spread) -> SpreadObject {
    SpreadObject { max: plain(spread.max), p999: plain(spread.quantile(SHARE)) }
}

fn reader_object(reader: &ReaderReport) -> ReaderObject<'_> {
    let tally = &reader.tally;
    let worst = ["ulp", "steps"].into_iter().zip(&reader.worst);
    ReaderObject {
        asked: JsonAsked::new(reader.reader, reader.device.as_ref()),
        failure: reader.failure.as_deref(),
        samples: tally.samples,
        samples_per_second: reader.rate,
        discarded: tally.discarded,
        discards_otherwise: reader.parted,
        nan: tally.nan,
        infinite: tally.infinite,
        ulp: spread(&tally.ulp),
        relative: spread(&tally.relative),
        steps: spread(&tally.steps),
        worst: worst.map(|(by, found)| driver_case(Some(by), found)).collect(),
        not_finite_here: odd_object(&reader.not_finite),
        finite_here: odd_object(&reader.hidden),
        apart: odd_object(&reader.apart),
    }
}

fn odd_object(odd: &Odd) -> OddObject<'_> {
    let cases = odd.cases.iter().map(|found| driver_case(None, found)).collect();
    OddObject { samples: odd.count, cases }
}

fn driver_case<'a>(by: Option<&'static str>, found: &'a DriverCase) -> DriverCaseObject<'a> {
    DriverCaseObject {
        by,
        outcome: match found.outcome {
            Came::NotANumber => "nan",
            Came::Infinite => "infinite",
            Came::Finite(_) => "finite",
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

/// A number, or the name of what JSON has none for.
fn plain(x: f64) -> Value {
    match x.is_finite() {
        true => Value::from(x),
        false => Value::from(number(x).to_lowercase()),
    }
}

fn single(x: f32) -> Value {
    match x.is_finite() {
        // The shortest digits that are this f32.
        true => format!("{x:?}").parse::<f64>().map_or(Value::Null, Value::from),
        false => Value::from(number(f64::from(x)).to_lowercase()),
    }
}

fn off(off: &Off) -> OffObject {
    OffObject { ulp: plain(off.ulp), relative: plain(off.relative), steps: plain(off.steps) }
}

fn condition(condition: &Condition) -> ConditionObject<'_> {
    ConditionObject {
        path: &condition.path,
        steps: plain(condition.steps),
        number: plain(condition.number),
    }
}

fn case(case: &Case) -> CaseObject<'_> {
    let inputs = case
        .inputs
        .iter()
        .map(|(path, text)| (path.clone(), serde_json::from_str(text).unwrap_or(Value::Null)));
    CaseObject {
        inputs: inputs.collect(),
        results: case
            .results
            .iter()
            .map(|r| ResultObject { path: &r.path, f32: single(r.single), f64: plain(r.double) })
            .collect(),
        command: command(&case.arguments),
    }
}

fn came_to(outcome: &Outcome) -> &'static str {
    match outcome {
        Outcome::Discarded => "discarded",
        Outcome::NotANumber => "nan",
        Outcome::Infinite => "infinite",
        Outcome::Off(..) => "finite",
    }
}

fn finding<'a>(stressed: &'a Report, found: &'a Found) -> FoundObject<'a> {
    let known = !found.place.shown.is_empty();
    let place = known.then(|| stressed.files.locate(found.place.span));
    let pair =
        |n: &crate::run::eval::Number| PairObject { f32: single(n.single), f64: plain(n.double) };
    FoundObject {
        hazard: (!found.hazard.id.is_empty()).then_some(found.hazard.id),
        code: found.hazard.code,
        level: found.level.name(),
        message: found.message(),
        function: &found.place.function,
        line: place.as_ref().map(|place| place.line),
        column: place.as_ref().map(|place| place.column),
        path: place.map(|place| place.path),
        excerpt: stressed.files.text(found.place.span),
        reader: found.reader,
        undefined: found.kind.map(crate::run::eval::UndefinedKind::text),
        operation: found.operation.as_ref().map(|operation| OperationObject {
            name: name(operation.operation),
            operands: operation.operands.iter().map(pair).collect(),
            result: pair(&operation.result),
        }),
        about: &found.about,
        outcome: came_to(&found.outcome),
        error: match &found.outcome {
            Outcome::Off(error, _) => Some(off(error)),
            Outcome::Discarded | Outcome::NotANumber | Outcome::Infinite => None,
        },
        breach_steps: found.breach.map(plain),
        permitted: found
            .permitted
            .as_ref()
            .map(|p| PermittedObject { steps: plain(p.steps), any_adapter: p.any }),
        condition: found.condition.as_ref().map(condition),
        rewrite: found.hazard.rewrite,
        gain: found.gain.as_ref().map(|gain| GainObject {
            form: gain.form,
            before: plain(gain.before),
            after: plain(gain.after),
        }),
        against: found.against.as_ref().map(|against| AgainstObject {
            function: &against.function,
            outcome: came_to(&against.outcome),
            steps: match &against.outcome {
                Outcome::Off(off, _) => Some(plain(off.steps)),
                Outcome::Discarded | Outcome::NotANumber | Outcome::Infinite => None,
            },
        }),
        readers: found
            .readers
            .iter()
            .map(|asked| AskedObject {
                reader: asked.reader,
                results: asked.results.iter().map(|x| single(*x)).collect(),
                failure: asked.failure.as_deref(),
            })
            .collect(),
        seen: found.seen,
        plausible: found.plausible,
        case: case(&found.case),
    }
}
