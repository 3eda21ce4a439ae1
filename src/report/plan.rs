//! The report of a plan of lighting: what it skips, saves and risks, as text and JSON.
//!
//! Formats the data of [`culling`](landfall_light::culling).

use std::fmt::Write as _;
use std::time::Duration;

use serde::Serialize;

use landfall_layout::format::SCHEMA_VERSION;
use landfall_layout::format::json::{Tool, to_lines};
pub use landfall_layout::format::paint::{CAUTION, FAINT, HEADING, Paint, STRONG};
use landfall_layout::format::phrases::{counted, number};
use landfall_light::culling::{Claim, Measured, OptionEffect, Plan, Times, Whole};

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
    let draws = counted(plan.draws.len(), "draw");
    let _ = writeln!(text, "  {}", paint.text(FAINT, &draws));
    for step in &savings.steps {
        let _ = writeln!(text, "  {}  {}", paint.text(HEADING, &step.option), step.did);
        if let Some([before, after]) = step.evaluations {
            let (a, b) = (number(after), number(before));
            let _ = writeln!(text, "    {a} evaluations instead of {b}{}", times(before, after));
        }
        // A bound that was only measured is marked, since other pictures may exceed it.
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
            "differs by up to {} of 1/255 from the picture with all lights, at all {} fragments of \
             this backend",
            steps_of(checked.steps),
            number(checked.fragments)
        );
        let _ = writeln!(text, "  {}  {line}", paint.text(HEADING, "checked"));
    }
    if let Some(times) = &savings.times {
        for (nth, line) in time_lines(times).iter().enumerate() {
            let name = if nth == 0 { "time" } else { "    " };
            let _ = writeln!(text, "  {}  {line}", paint.text(HEADING, name));
        }
    }
    for note in &savings.notes {
        let _ = writeln!(text, "  {}", paint.text(CAUTION, note));
    }
    text
}

/// Returns what a plan skips in a line.
pub(super) fn line(plan: &Plan) -> String {
    let savings = &plan.savings;
    let applied = savings.steps.iter().filter(|step| step.evaluations.is_some());
    let parts: Vec<&str> = applied.map(|step| step.option.as_str()).collect();
    if parts.is_empty() {
        let why = savings.steps.iter().find_map(|step| step.did.strip_prefix("not applied: "));
        return format!("nothing{}", why.map(|why| format!(": {why}")).unwrap_or_default());
    }
    // Nothing is said of a plan that skips no light.
    let fewer = match times(savings.before, savings.after) {
        none if none.is_empty() => none,
        fewer => format!("{fewer} light evaluations"),
    };
    let part = savings.times.and_then(|times| times.ratio());
    let part = part.map(|ratio| format!(", {ratio:.2} of the time")).unwrap_or_default();
    format!("{}{fewer}{part}", parts.join(", "))
}

/// Returns the lines about the time of a plan.
fn time_lines(times: &Times) -> Vec<String> {
    let Times { planning, lighting, checking, whole } = times;
    let mut lines = vec![format!(
        "{} from the start of planning to the picture: {} planning, {} lighting",
        seconds(times.total()),
        seconds(*planning),
        seconds(*lighting),
    )];
    if let (Some(Whole { time, fragments, measured }), Some(ratio)) = (whole, times.ratio()) {
        let origin = match measured {
            true => "measured".to_string(),
            false => format!("estimated from {} fragments", number(*fragments)),
        };
        lines.push(format!("{ratio:.2} of the {} without skipping, {origin}", seconds(*time)));
    }
    if !checking.is_zero() {
        let checking = seconds(*checking);
        lines.push(format!("measuring the error at every fragment took another {checking}"));
    }
    lines
}

fn seconds(time: Duration) -> String {
    match time.as_secs_f64() {
        s if s >= 1.0 => format!("{s:.2} s"),
        s => format!("{:.1} ms", s * 1e3),
    }
}

/// The schema of [`PLAN_SCHEMA`].
#[cfg(feature = "schema")]
#[doc(hidden)]
pub fn schema() -> String {
    landfall_layout::schema::text::<Document<'_>>(
        "the plan of landfall render --skip PARTS --format json",
    )
}

/// Returns the plan as a JSON document.
pub fn json(plan: &Plan) -> String {
    let document =
        Document { schema_version: SCHEMA_VERSION, tool: Tool::LANDFALL, plan: object(plan) };
    format!("{}\n", to_lines(&document))
}

/// Returns the fields of a plan for a larger document.
pub(super) fn object(plan: &Plan) -> Body<'_> {
    let savings = &plan.savings;
    Body {
        fragments: savings.fragments,
        evaluations: Evaluations { before: savings.before, after: savings.after },
        draws: plan.draws.len(),
        compiled: CompiledObject {
            ambient: plan.compiled.ambient,
            directional: plan.compiled.directional,
            point: plan.compiled.point,
            spot: plan.compiled.spot,
        },
        constants: &savings.compiled,
        checked: savings.checked.as_ref().map(MeasuredObject::new),
        time: savings.times.as_ref().map(TimesObject::new),
        steps: savings.steps.iter().map(PlanStepObject::new).collect(),
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
            // The largest difference says little alone, so the share of the codes that change is
            // told too.
            let part = 100.0 * *codes as f64 / (*of).max(1) as f64;
            let (steps, fragments) = (steps_of(*steps), number(*fragments));
            let found = match every {
                1 => format!("up to {steps} of 1/255 at all {fragments} fragments"),
                n => format!(
                    "{steps} of 1/255 at {fragments} fragments, every {n}th; others may differ more"
                ),
            };
            let line =
                format!("measured, not proven: {found}; {part:.2} % of their 8-bit values differ");
            Some((false, line))
        }
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

/// A plan of lighting: what it skips, saves and risks. A step is 1/255 of linear light.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct Document<'a> {
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA_VERSION)))]
    schema_version: u32,
    tool: Tool,
    #[serde(flatten)]
    plan: Body<'a>,
}

/// A plan of lighting: what it skips, saves and risks. A step is 1/255 of linear light.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct Body<'a> {
    fragments: u64,
    /// The light evaluations of the shader's loop over every slot, and of the plan.
    evaluations: Evaluations,
    /// The sets of fragments lit by the same lights.
    draws: usize,
    /// The numbers of lights that a shader must hold if each draw uploads its own; kinds with 0
    /// lights can be left out.
    compiled: CompiledObject,
    /// The constants the shader was compiled with, as NAME=VALUE.
    constants: &'a [String],
    /// The difference from the picture with all lights at every fragment, on the same backend, if
    /// it was measured.
    checked: Option<MeasuredObject>,
    /// Seconds of the processor, and of a driver. Absent for a plan that was not executed.
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<TimesObject>,
    /// The effect of each option, in the order applied.
    steps: Vec<PlanStepObject<'a>>,
    /// Warnings: lights without a bound, which are never dropped, and lights without a slot.
    notes: &'a [String],
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct Evaluations {
    before: u64,
    after: u64,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct CompiledObject {
    ambient: bool,
    directional: u32,
    point: u32,
    spot: u32,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct TimesObject {
    /// Analysis and compilation of the shader, the trial on a sample, and the lists.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    planning: f64,
    /// Lighting the picture.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    lighting: f64,
    /// Lighting all fragments with all lights to measure the error; 0 for a plan that was shown to
    /// be exact.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    checking: f64,
    /// From the start of planning to the picture: planning and lighting.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    total: f64,
    /// Lighting the picture with all lights: `measured`, or estimated from that many fragments.
    whole: Option<WholeObject>,
    /// `total` in relation to `whole`.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    ratio: Option<f64>,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct WholeObject {
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    seconds: f64,
    fragments: u64,
    measured: bool,
}

impl TimesObject {
    fn new(times: &Times) -> TimesObject {
        let whole = times.whole.map(|Whole { time, fragments, measured }| WholeObject {
            seconds: time.as_secs_f64(),
            fragments,
            measured,
        });
        TimesObject {
            planning: times.planning.as_secs_f64(),
            lighting: times.lighting.as_secs_f64(),
            checking: times.checking.as_secs_f64(),
            total: times.total().as_secs_f64(),
            whole,
            ratio: times.ratio(),
        }
    }
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct PlanStepObject<'a> {
    option: &'a str,
    did: &'a str,
    evaluations: Option<Evaluations>,
    error: PlanErrorObject<'a>,
    /// The tests of a light against a region.
    tests: u64,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "snake_case")]
enum PlanErrorObject<'a> {
    Exact {
        why: &'a str,
    },
    /// The most steps by which a channel of any fragment is too dark, by the bounds of the lighting
    /// model.
    Proven {
        #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
        steps: f64,
        by: &'a str,
    },
    Measured {
        #[serde(flatten)]
        measured: MeasuredObject,
    },
    Unused,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct MeasuredObject {
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    steps: Option<f64>,
    codes: u64,
    of: u64,
    fragments: u64,
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    every: u64,
}

impl MeasuredObject {
    fn new(measured: &Measured) -> MeasuredObject {
        let Measured { steps, codes, of, fragments, every } = *measured;
        // JSON has no infinity, which a pixel that is finite in only one picture gives.
        let steps = Some(steps).filter(|steps| steps.is_finite());
        MeasuredObject { steps, codes, of, fragments, every }
    }
}

impl<'a> PlanStepObject<'a> {
    fn new(step: &'a OptionEffect) -> PlanStepObject<'a> {
        let error = match &step.error {
            Claim::Exact(why) => PlanErrorObject::Exact { why },
            Claim::Proven { steps, by } => PlanErrorObject::Proven { steps: *steps, by },
            Claim::Measured(measured) => {
                PlanErrorObject::Measured { measured: MeasuredObject::new(measured) }
            }
            Claim::Unused => PlanErrorObject::Unused,
        };
        PlanStepObject {
            option: &step.option,
            did: &step.did,
            evaluations: step.evaluations.map(|[before, after]| Evaluations { before, after }),
            error,
            tests: step.tests,
        }
    }
}
