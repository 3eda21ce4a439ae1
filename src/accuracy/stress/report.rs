//! What stressing a function found: plain data, as `landfall schema stress` describes it.
//!
//! Made by [`stress`](super::stress()), printed by [`emit::stress`](crate::emit::stress).

use serde_json::Value;

use super::classify::{Performed, examine};
use super::condition::{Condition, condition};
use super::domain::Domain;
use super::drivers::Drivers;
use super::find::Raw;
use super::generate::Family;
use super::hazard::{self, Hazard};
use super::input::{Input, Sample};
use super::measure::{Off, Outcome, outcome};
use super::permitted::{Permitted, permitted};
use super::readers::{ReaderReport, Writing, ask, on_a_driver, reports};
use super::rewrite::{Gain, gain};
use super::sample::{Plan, Tally, columns, settings};
use super::{Request, measure};
use crate::lint::{Finding, Level, Place as LintPlace, Related};
use crate::run::bound::Data;
use crate::run::call::pure::Pure;
use crate::run::eval::{Floats, Place, UndefinedKind};
use crate::source::{Files, Source};

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

/// One sample, readable and repeatable.
#[derive(Clone, Debug)]
pub struct Case {
    /// The inputs by path, in JSON.
    pub inputs: Vec<(String, String)>,
    /// The same flat: vectors and scalars, integers as numbers.
    pub flat: Vec<(String, Vec<f64>)>,
    /// Its results.
    pub results: Vec<ResultScalar>,
    /// The arguments of `landfall run` that repeat it.
    pub arguments: Vec<String>,
    /// The same as values: arguments, block contents, inputs.
    pub values: (Vec<Value>, Data, Vec<(String, Value)>),
    pub(super) words: Sample,
}

/// A scalar of a result.
#[derive(Clone, Debug, PartialEq)]
pub struct ResultScalar {
    /// The way to it: `result.x`.
    pub path: String,
    /// In `f32`.
    pub single: f32,
    /// In `f64`.
    pub double: f64,
}

/// A finding.
#[derive(Clone, Debug)]
pub struct Found {
    /// What it is.
    pub hazard: &'static Hazard,
    /// How much it matters here.
    pub level: Level,
    /// Where.
    pub place: Place,
    /// The driver it is about, where it is about one alone.
    pub reader: Option<&'static str>,
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
    pub permitted: Option<Permitted>,
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
    /// `gl` or `gpu`.
    pub reader: &'static str,
    /// The floats it gives, in the order of the results.
    pub results: Vec<f32>,
    /// Why it gives none.
    pub failure: Option<String>,
}

pub(super) struct Made<'a> {
    pub source: &'a Source,
    pub request: &'a Request,
    pub pure: &'a Pure,
    pub inputs: &'a [Input],
    pub domain: &'a Domain,
    pub plan: &'a Plan,
    pub against: Option<&'a Pure>,
    pub families: Vec<(Family, Tally)>,
    pub raws: Vec<Raw>,
    pub worst: Vec<(Sample, Off)>,
    pub drivers: Drivers<'a>,
    pub endless: Vec<Sample>,
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
    let writing = Writing { pure, inputs, plan, source };
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
        let code = raw.candidate.hazard.code;
        let most = EACH[usize::from(raw.candidate.hazard.id.is_empty())];
        if findings.iter().filter(|f| f.hazard.code == code).count() >= most {
            match more.iter_mut().find(|(known, _)| *known == code) {
                Some((_, count)) => *count += 1,
                None => more.push((code, 1)),
            }
            continue;
        }
        let other = made.against.map(|other| against(pure, other, plan, &raw.sample));
        findings.push(Found { against: other, ..found(pure, inputs, plan, made.source, raw) });
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
    findings.extend(made.endless.first().map(|sample| endless(pure, plan, made.source, sample)));
    if !readers.is_empty() && made.request.pure.floats != Floats::AsWritten {
        notes.push("drivers run it as it is written, not rounded to f16".to_string());
    }
    let worst = made.worst.into_iter().map(|(sample, off)| Worst {
        off,
        condition: condition(pure, inputs, &sample, plan),
        sample: case(pure, plan, made.source, &sample),
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

fn found(pure: &Pure, inputs: &[Input], plan: &Plan, source: &Source, raw: Raw) -> Found {
    let hazard = raw.candidate.hazard;
    let semantic = [
        &hazard::HIGHLIGHT_FROM_BEHIND,
        &hazard::NORMAL_NOT_NORMALISED,
        &hazard::CONE_OUT_OF_RANGE,
    ];
    let is_rule = semantic.contains(&hazard);
    let level = if raw.plausible { hazard.level } else { Level::Warn };
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
        case: case(pure, plan, source, &raw.sample),
        gain,
        permitted: permitted(pure, &raw.sample, plan),
        against: None,
        readers: Vec::new(),
        seen: raw.seen,
        plausible: raw.plausible,
    }
}

fn endless(pure: &Pure, plan: &Plan, source: &Source, sample: &Sample) -> Found {
    Found {
        hazard: &hazard::ENDLESS_LOOP,
        level: Level::Deny,
        place: place_of_name(pure),
        reader: None,
        operation: None,
        kind: None,
        about: Vec::new(),
        outcome: Outcome::Discarded,
        breach: None,
        case: case(pure, plan, source, sample),
        condition: None,
        gain: None,
        permitted: None,
        against: None,
        readers: Vec::new(),
        seen: 1,
        plausible: false,
    }
}

/// The place of the function's name.
pub(super) fn place_of_name(pure: &Pure) -> Place {
    let span = pure.name_span.unwrap_or_default();
    let at = pure.files.locate(span);
    let shown = format!("{}:{}:{}", at.path, at.line, at.column);
    let function = pure.shown.split('(').next().unwrap_or_default().to_string();
    Place { function, span, shown }
}

/// What another function gives for a sample: inputs of one path are the same.
fn against(pure: &Pure, other: &Pure, plan: &Plan, sample: &Sample) -> Against {
    let paths = |pure: &Pure| -> Vec<String> {
        pure.parameters.iter().flat_map(|parameter| parameter.scalars.clone()).collect()
    };
    let own = paths(pure);
    let word = |path: &String| own.iter().position(|known| known == path).map(|at| sample[at]);
    let words: Sample = paths(other).iter().map(|path| word(path).unwrap_or(0)).collect();
    let called = other.call(&columns(&[words]), 1, &settings(plan, false));
    let outcome = match called {
        Ok(called) => outcome(&called, &measure::floats(other), 0),
        Err(_) => Outcome::Discarded,
    };
    Against { function: other.shown.clone(), outcome }
}

/// A value without the members that are zero; none where nothing is left.
fn some(value: &serde_json::Value) -> Option<serde_json::Value> {
    use serde_json::Value;
    let kept = match value {
        Value::Object(members) => {
            let members =
                members.iter().filter_map(|(key, value)| Some((key.clone(), some(value)?)));
            let members: serde_json::Map<String, Value> = members.collect();
            return (!members.is_empty()).then_some(Value::Object(members));
        }
        Value::Array(items) => items.iter().any(|item| some(item).is_some()),
        // The zero below zero is another number.
        Value::Number(number) => number.as_f64().is_none_or(|x| x.to_bits() != 0),
        Value::Bool(set) => *set,
        Value::Null => false,
        Value::String(_) => true,
    };
    kept.then(|| value.clone())
}

/// A sample as people read it.
pub(super) fn case(pure: &Pure, plan: &Plan, source: &Source, sample: &Sample) -> Case {
    let (arguments, data, given) = pure.json(sample);
    let values = (arguments.clone(), data.clone(), given.clone());
    let mut inputs = Vec::new();
    let mut words = arguments.iter();
    let mut named = given.iter();
    for parameter in &pure.parameters {
        use crate::run::call::pure::Origin;
        let value = match &parameter.origin {
            Origin::Argument(_) => words.next().cloned(),
            Origin::Input => named.next().map(|(_, value)| value.clone()),
            Origin::Block(block, member) => {
                data.get(block).and_then(|block| block.get(member)).cloned()
            }
        };
        inputs.push((parameter.path.clone(), value.unwrap_or_default().to_string()));
    }
    let mut line = vec!["run".to_string(), source.path.clone()];
    line.extend(["--fn".to_string(), pure.shown.clone()]);
    if !arguments.is_empty() {
        line.extend(["--args".to_string(), serde_json::Value::from(arguments).to_string()]);
    }
    // What is not given is zero.
    let data = serde_json::Value::from(data);
    if let Some(data) = some(&data) {
        line.extend(["--data".to_string(), data.to_string()]);
    }
    for (name, value) in given.into_iter().filter(|(_, value)| some(value).is_some()) {
        line.extend(["--input".to_string(), format!("{name}={value}")]);
    }
    let settings = settings(plan, false);
    let called = pure.call(&columns(std::slice::from_ref(sample)), 1, &settings);
    let mut results = Vec::new();
    if let Ok(called) = &called {
        for (nth, at) in measure::floats(pure) {
            let result = &pure.results[nth];
            results.push(ResultScalar {
                path: format!("{}{}", result.name, pure.result_path(nth, at)),
                single: f32::from_bits(called.results[nth].words[at][0] as u32),
                double: called.results[nth].doubles[at][0],
            });
        }
    }
    let flat = super::input::inputs(pure)
        .iter()
        .map(|input| {
            (input.path.clone(), input.range().map(|at| input.number(sample[at])).collect())
        })
        .collect();
    Case { inputs, flat, results, arguments: line, values, words: sample.clone() }
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
            code: self.hazard.code.to_string(),
            level: self.level,
            message: self.message(),
            about: report.function.clone(),
            place: LintPlace::of(&report.files, self.place.span),
            text: self.label(),
            related: Vec::<Related>::new(),
            notes,
            listing: None,
            help: Some(self.hazard.rewrite.to_string()),
            fix: Vec::new(),
        }
    }
}

/// A command line for a shell.
pub fn command(arguments: &[String]) -> String {
    let quoted = arguments.iter().map(|argument| {
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=".contains(c);
        match argument.chars().all(plain) && !argument.is_empty() {
            true => argument.clone(),
            false => format!("'{}'", argument.replace('\'', "'\\''")),
        }
    });
    format!("landfall {}", quoted.collect::<Vec<_>>().join(" "))
}
