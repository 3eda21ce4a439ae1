//! The report of `landfall prove`: a verdict on each operation and on each demand.
//!
//! Formats the data of [`accuracy::demand`](landfall_accuracy::demand); the report of
//! `landfall stress` ends with the same counts.

mod json;

use std::fmt::Write as _;

#[cfg(feature = "schema")]
pub use self::json::schema;
pub use self::json::{InputObject, OperationObject, case_inputs, inputs, json, operations};
pub use super::schema::PROVE_SCHEMA;
use landfall_accuracy::demand::{DemandVerdict, ProveReport};
use landfall_accuracy::prove::Class;
use landfall_accuracy::stress::messages::{figure, number};
use landfall_accuracy::stress::{Operation, OperationVerdict, count_lines};
use landfall_interp::graph::Rounding;
use landfall_layout::format::columns::{WIDTH, wrapped};
use landfall_layout::format::paint::{CAUTION, FAINT, Paint, STRONG};
use landfall_layout::format::phrases;
use landfall_layout::layout::targets;
use landfall_layout::source::Files;
use landfall_layout::text::escape;

/// The operations to list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Listed {
    /// Operations that have, or may have, an undefined result.
    Few,
    /// Every operation.
    All,
}

/// Returns the text: the operations, the counts, the demands.
pub fn text(proved: &ProveReport, listed: Listed, paint: Paint) -> String {
    let mut text = String::new();
    let path = paint.text(FAINT, &escape::name(&proved.path));
    let _ = writeln!(text, "{}  {path}", paint.text(STRONG, &proved.function));
    if let Some(note) = targets::note(proved.assumed_target) {
        let _ = writeln!(text, "  {}", paint.text(CAUTION, &note));
    }
    if proved.too_large {
        let _ = writeln!(text, "  {}", paint.text(CAUTION, "the code is too large to analyse"));
    }
    let shown = proved.operations.iter().filter(|operation| match listed {
        Listed::All => true,
        Listed::Few => {
            // Losses of accuracy are summed up in the bound of the error.
            operation.class() == Class::Undefined
                && !matches!(operation.known, OperationVerdict::Absent)
        }
    });
    for operation in shown {
        let _ = writeln!(text, "  {}", line(operation, &proved.files, paint));
    }
    for count in count_lines(&proved.operations) {
        let _ = writeln!(text, "  {}", wrapped(&count, WIDTH - 4).join("\n    "));
    }
    if proved.is_without_demand() {
        let _ = writeln!(text, "  {}", wrapped(&results(proved), WIDTH - 4).join("\n    "));
    }
    for line in error_lines(proved) {
        let _ = writeln!(text, "  {line}");
    }
    for (demand, shown) in &proved.demands {
        let name = demand.label();
        let _ = match shown {
            DemandVerdict::Shown => writeln!(text, "  {name}: proved{}", on_what(proved)),
            DemandVerdict::Open => {
                writeln!(text, "  {}", paint.text(CAUTION, &format!("{name}: not proved")))
            }
            DemandVerdict::Broken(case) => {
                let line = format!("{name}: broken with {}", case.shown());
                let line = wrapped(&line, WIDTH - 4).join("\n    ");
                writeln!(text, "  {}", paint.text(CAUTION, &line))
            }
        };
    }
    for note in &proved.notes {
        let note = wrapped(note, WIDTH - 4).join("\n    ");
        let _ = writeln!(text, "  {}", paint.text(FAINT, &note));
    }
    text
}

/// Returns what a demand is proved for: errors of `f64` are those of one kind of machine.
fn on_what(proved: &ProveReport) -> &'static str {
    match proved.rounding {
        Rounding::Double => "",
        Rounding::Permitted => " for every conformant device",
    }
}

/// Returns what is known of the results: whether they may be NaN or infinite, and their range.
fn results(proved: &ProveReport) -> String {
    let verdict = |verdict: &DemandVerdict| match verdict {
        DemandVerdict::Shown => "proved absent".to_string(),
        DemandVerdict::Broken(case) => format!("found with {}", case.shown()),
        DemandVerdict::Open => "open".to_string(),
    };
    let [nan, infinite] = &proved.non_finite;
    let mut line = format!("results: NaN {}; infinity {}", verdict(nan), verdict(infinite));
    if let Some([low, high]) = proved.error.map(|bound| bound.results) {
        if low.is_finite() && high.is_finite() && low <= high {
            let _ = write!(line, "; from {} to {}", figure(low), figure(high));
        }
    }
    line
}

/// The ULP that are half of an `f32`: from there on no digit is left.
const NO_DIGITS: f64 = 4_194_304.0;

/// How many times the worst sample a bound is before it is called loose.
const LOOSE: f64 = 1000.0;

/// Returns the lines of the bound of the error, beside the largest error of samples.
fn error_lines(proved: &ProveReport) -> Vec<String> {
    let Some(bound) = &proved.error else { return Vec::new() };
    if proved.rounding == Rounding::Double {
        return vec![format!("error in f64: at most {}", figure(bound.absolute))];
    }
    let known = |x: f64, unit: &str| x.is_finite().then(|| format!("{}{unit}", figure(x)));
    // A bound so wide says nothing: no digit of the result would be right.
    let ulp = known(bound.ulp, " ULP").filter(|_| bound.ulp < NO_DIGITS);
    let is_near_zero = ulp.is_none() && bound.steps.is_finite();
    let each = [known(bound.absolute, " absolute"), ulp, known(bound.steps, " steps")];
    let each: Vec<String> = each.into_iter().flatten().collect();
    if each.is_empty() {
        return vec!["error: no bound found in the time".to_string()];
    }
    let mut lines = vec![format!("error: at most {}", each.join(", "))];
    if is_near_zero {
        lines.push("  no bound in ULP: the result may be near 0".to_string());
    }
    if proved.is_cut_short() {
        lines.push("  the search ended where the demand was met: it may be lower".to_string());
    }
    if let [Some(ulp), Some(steps)] = proved.worst {
        let worst = format!("{} ULP, {} steps", figure(ulp), figure(steps));
        lines.push(format!("  the worst of the samples: {worst}"));
        // A bound far above the worst sample is called loose, lest it be taken for the error.
        let times = bound.steps / steps;
        if times > LOOSE && times.is_finite() && !proved.is_cut_short() {
            let times = phrases::number(times as u64);
            lines.push(format!("  the bound is loose: {times} times the steps of that sample"));
        }
    }
    lines
}

/// Returns one operation with its input or the box that is left.
fn line(operation: &Operation, files: &Files, paint: Paint) -> String {
    let excerpt = files.text(operation.place.span).lines().next().unwrap_or_default().trim();
    let head = format!("{:6}  {}: {}", operation.verdict(), operation.place.shown, operation.fault);
    let excerpt = escape::name(excerpt);
    let rest = match &operation.known {
        OperationVerdict::Found(case) => format!(" in `{excerpt}` with {}", case.shown()),
        OperationVerdict::Absent => format!(" in `{excerpt}`"),
        OperationVerdict::Open(ranges) => {
            let each = ranges.iter().map(|(path, [low, high])| {
                format!("{path} from {} to {}", number(*low), number(*high))
            });
            let each: Vec<String> = each.collect();
            match each.is_empty() {
                true => format!(" in `{excerpt}`"),
                false => format!(" in `{excerpt}` where {}", each.join(", ")),
            }
        }
    };
    match operation.known {
        OperationVerdict::Absent => paint.text(FAINT, &(head + &rest)),
        OperationVerdict::Found(_) | OperationVerdict::Open(_) => head + &rest,
    }
}
