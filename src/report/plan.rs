//! The report of a plan of lighting: what it skips, saves and risks, as text and JSON.
//!
//! Formats the data of [`culling`](landfall_light::culling).

use std::fmt::Write as _;

use serde::Serialize;

use landfall_layout::format::SCHEMA_VERSION;
use landfall_layout::format::json::{Tool, to_lines};
pub use landfall_layout::format::paint::{CAUTION, FAINT, HEADING, Paint, STRONG};
pub use landfall_layout::format::phrases::number;
use landfall_light::culling::{Choice, Claim, Measured, OptionEffect, Plan, Timed};

pub use crate::report::schema::PLAN_SCHEMA;

/// Returns the text: the totals, then a paragraph for each option.
pub fn text(plan: &Plan, paint: Paint) -> String {
    let savings = &plan.savings;
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{}  {} fragments, {} light evaluations instead of {}{}",
        paint.text(STRONG, "plan"),
        number(savings.fragments),
        number(savings.after),
        number(savings.before),
        times(savings.before, savings.after),
    );
    let draws = plan.draws.len() as u64;
    let grids = plan.grids.len() as u64;
    let _ = writeln!(
        text,
        "  {}",
        paint.text(
            FAINT,
            &match grids {
                0 => count(draws, "draw"),
                _ => format!("{}, {}", count(draws, "draw"), count(grids, "grid")),
            }
        )
    );
    if let Some(choice) = &savings.choice {
        measured_ways(&mut text, choice, paint);
    }
    for step in &savings.steps {
        let _ = writeln!(text, "  {}  {}", paint.text(HEADING, &step.option), step.did);
        if let Some([before, after]) = step.evaluations {
            let (a, b) = (number(after), number(before));
            let _ = writeln!(text, "    {a} evaluations instead of {b}{}", times(before, after));
        }
        if let Some((certain, line)) = claim(&step.error) {
            let line = if certain { line } else { paint.text(CAUTION, &line) };
            let _ = writeln!(text, "    {line}");
        }
        if step.tests > 0 {
            let tests = format!("{} tests of a light against a region", number(step.tests));
            let _ = writeln!(text, "    {}", paint.text(FAINT, &tests));
        }
    }
    if !savings.compiled.is_empty() {
        let line = savings.compiled.join(", ");
        let _ = writeln!(text, "  {}  {line}", paint.text(HEADING, "compiled with"));
    }
    if let Some(checked) = &savings.checked {
        let line = format!(
            "differs by at most {} of 1/255 from the picture with all lights, on {} fragments of this \
             backend",
            steps_of(checked.steps),
            number(checked.fragments)
        );
        let kept = plan.is_confirmed_by(checked);
        let line = if kept { line } else { paint.text(CAUTION, &line) };
        let _ = writeln!(text, "  {}  {line}", paint.text(HEADING, "checked"));
    }
    for note in &savings.notes {
        let _ = writeln!(text, "  {}", paint.text(CAUTION, note));
    }
    text
}

/// Appends the ways that were measured, the one picked marked.
fn measured_ways(text: &mut String, choice: &Choice, paint: Paint) {
    let measured = match choice.timed.iter().all(|timed| timed.seconds.is_empty()) {
        true => "nothing measured".to_string(),
        false => format!(
            "measured on {} of {} fragments, seconds for all of them",
            number(choice.fragments),
            number(choice.of)
        ),
    };
    let _ = writeln!(
        text,
        "  {}  {measured}; an error of {} of 1/255 is permitted",
        paint.text(HEADING, "auto"),
        steps_of(choice.permitted),
    );
    let name = |timed: &Timed| match timed.parts.is_empty() {
        true => "nothing skipped".to_string(),
        false => timed.parts.clone(),
    };
    let width = choice.timed.iter().map(|timed| name(timed).len()).max().unwrap_or(0);
    for (at, timed) in choice.timed.iter().enumerate() {
        let mut line = format!("{:width$}", name(timed));
        if !timed.seconds.is_empty() {
            let [fastest, slowest] = timed.range().map(seconds);
            let _ = write!(line, "  {} ({fastest} to {slowest})", seconds(timed.median()));
        }
        if !timed.note.is_empty() {
            let _ = write!(line, "  {}", timed.note);
        }
        if at == choice.picked {
            line.push_str("  picked");
        }
        let line = if at == choice.picked { line } else { paint.text(FAINT, &line) };
        let _ = writeln!(text, "    {line}");
    }
}

fn seconds(seconds: f64) -> String {
    match seconds {
        s if s >= 0.1 => format!("{s:.2}"),
        s => format!("{s:.2e}"),
    }
}

/// Returns the plan as a JSON document.
pub fn json(plan: &Plan) -> String {
    let document =
        Document { schema_version: SCHEMA_VERSION, tool: Tool::LANDFALL, plan: object(plan) };
    format!("{}\n", to_lines(&document, 0))
}

/// Returns the fields of a plan for a larger document.
pub(super) fn object(plan: &Plan) -> Body<'_> {
    let savings = &plan.savings;
    Body {
        fragments: savings.fragments,
        evaluations: Evaluations { before: savings.before, after: savings.after },
        draws: plan.draws.len(),
        grids: plan.grids.len(),
        compiled: CompiledObject {
            ambient: plan.compiled.ambient,
            directional: plan.compiled.directional,
            point: plan.compiled.point,
            spot: plan.compiled.spot,
        },
        constants: &savings.compiled,
        choice: savings.choice.as_ref().map(ChoiceObject::of),
        checked: savings.checked.as_ref().map(MeasuredObject::of),
        steps: savings.steps.iter().map(StepObject::of).collect(),
        notes: &savings.notes,
    }
}

/// Returns whether the claim is certain, and its text; `None` for an option that was not applied.
fn claim(error: &Claim) -> Option<(bool, String)> {
    match error {
        Claim::Exact(why) => Some((true, format!("exact: {why}"))),
        Claim::Proven { steps, by } => Some((
            true,
            format!("too dark by at most {} of 1/255, proven by {by}", steps_of(*steps)),
        )),
        Claim::Measured(Measured { steps, codes, of, fragments, every }) => {
            let part = 100.0 * *codes as f64 / (*of).max(1) as f64;
            let sample = match every {
                0 => ", including those nearest to each light in regions without it".to_string(),
                1 => String::new(),
                n => format!(", every {n}th of them"),
            };
            Some((
                false,
                format!(
                    "measured, not proven: up to {} of 1/255, {part:.2} % of the 8-bit values differ, on \
                     {} fragments{sample}",
                    steps_of(*steps),
                    number(*fragments),
                ),
            ))
        }
        Claim::Unmeasured => Some((false, "its error is not bounded".to_string())),
        Claim::Unused => None,
    }
}

fn steps_of(steps: f64) -> String {
    match steps {
        s if s >= 10.0 => format!("{s:.0} steps"),
        s if s >= 0.01 || s == 0.0 => format!("{s:.2} steps"),
        s => format!("{s:.1e} steps"),
    }
}

fn times(before: u64, after: u64) -> String {
    if after == 0 || before == after {
        return String::new();
    }
    let ratio = before as f64 / after as f64;
    if ratio >= 10.0 {
        format!(", {ratio:.1} times fewer")
    } else {
        format!(", {ratio:.2} times fewer")
    }
}

fn count(n: u64, what: &str) -> String {
    if n == 1 { format!("1 {what}") } else { format!("{} {what}s", number(n)) }
}

#[derive(Serialize)]
struct Document<'a> {
    schema_version: u32,
    tool: Tool,
    #[serde(flatten)]
    plan: Body<'a>,
}

#[derive(Serialize)]
pub(super) struct Body<'a> {
    fragments: u64,
    evaluations: Evaluations,
    draws: usize,
    grids: usize,
    compiled: CompiledObject,
    constants: &'a [String],
    #[serde(skip_serializing_if = "Option::is_none")]
    choice: Option<ChoiceObject<'a>>,
    checked: Option<MeasuredObject>,
    steps: Vec<StepObject<'a>>,
    notes: &'a [String],
}

#[derive(Serialize)]
struct Evaluations {
    before: u64,
    after: u64,
}

#[derive(Serialize)]
struct CompiledObject {
    ambient: bool,
    directional: u32,
    point: u32,
    spot: u32,
}

#[derive(Serialize)]
struct ChoiceObject<'a> {
    permitted: f64,
    fragments: u64,
    of: u64,
    ways: Vec<WayObject<'a>>,
}

#[derive(Serialize)]
struct WayObject<'a> {
    parts: &'a str,
    picked: bool,
    seconds: &'a [f64],
    error: Option<f64>,
    seen: Option<f64>,
    note: &'a str,
}

impl<'a> ChoiceObject<'a> {
    fn of(choice: &'a Choice) -> ChoiceObject<'a> {
        let finite = |number: f64| Some(number).filter(|number| number.is_finite());
        let ways = choice.timed.iter().enumerate().map(|(at, timed)| WayObject {
            parts: &timed.parts,
            picked: at == choice.picked,
            seconds: &timed.seconds,
            error: timed.error.and_then(finite),
            seen: finite(timed.seen),
            note: &timed.note,
        });
        let Choice { permitted, fragments, of, .. } = *choice;
        ChoiceObject { permitted, fragments, of, ways: ways.collect() }
    }
}

#[derive(Serialize)]
struct StepObject<'a> {
    option: &'a str,
    did: &'a str,
    evaluations: Option<Evaluations>,
    error: ErrorObject<'a>,
    tests: u64,
}

#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum ErrorObject<'a> {
    Exact { why: &'a str },
    Proven { steps: f64, by: &'a str },
    Measured(MeasuredObject),
    Unmeasured,
    Unused,
}

#[derive(Serialize)]
struct MeasuredObject {
    steps: Option<f64>,
    codes: u64,
    of: u64,
    fragments: u64,
    every: u64,
}

impl MeasuredObject {
    fn of(measured: &Measured) -> MeasuredObject {
        let Measured { steps, codes, of, fragments, every } = *measured;
        // JSON has no infinity, which a pixel that is finite in only one picture gives.
        let steps = Some(steps).filter(|steps| steps.is_finite());
        MeasuredObject { steps, codes, of, fragments, every }
    }
}

impl<'a> StepObject<'a> {
    fn of(step: &'a OptionEffect) -> StepObject<'a> {
        let error = match &step.error {
            Claim::Exact(why) => ErrorObject::Exact { why },
            Claim::Proven { steps, by } => ErrorObject::Proven { steps: *steps, by },
            Claim::Measured(measured) => ErrorObject::Measured(MeasuredObject::of(measured)),
            Claim::Unmeasured => ErrorObject::Unmeasured,
            Claim::Unused => ErrorObject::Unused,
        };
        StepObject {
            option: &step.option,
            did: &step.did,
            evaluations: step.evaluations.map(|[before, after]| Evaluations { before, after }),
            error,
            tests: step.tests,
        }
    }
}
