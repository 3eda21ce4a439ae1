//! The text of a finding: message, label and notes.
//!
//! Used by the findings as lints and by the report of `landfall stress`.

use super::advice::Advice;
use super::case::Case;
use super::classify::Performed;
use super::found::StressFinding;
use super::measure::Outcome;
pub use landfall_exec::harness::origins::number;
use landfall_exec::harness::origins::{ReadValue, comes_from};
use landfall_interp::{Cmp, Comparison, Number, Operation, Source, Test};
use landfall_ir::analysis::hazard::Hazard;
use landfall_layout::format::phrases;

impl StressFinding {
    /// Returns the message: the hazard and its effect on the result.
    pub fn message(&self) -> String {
        let outcome = match (self.breach, self.outcome) {
            (Some(steps), _) => format!(": {} steps", figure(steps)),
            (None, Outcome::NotANumber) => ": the result is NaN".to_string(),
            (None, Outcome::Infinite) => ": the result is infinite".to_string(),
            (None, Outcome::Finite(off, _)) if off.steps >= 0.05 => {
                format!(": {} steps off, {} ULP", figure(off.steps), figure(off.ulp))
            }
            (None, Outcome::Finite(off, _)) if self.kind.is_none() => {
                format!(": {} ULP off", figure(off.ulp))
            }
            (None, Outcome::Finite(..)) => ": no error in the interpreter's result".to_string(),
            (None, Outcome::Discarded) => String::new(),
        };
        let what = match (self.backend, self.what, self.kind) {
            (Some(backend), ..) => self.hazard.info().what.replacen("a driver", backend.name(), 1),
            (None, Some(what), _) => what.to_string(),
            (None, None, Some(kind)) if self.hazard == Hazard::UndefinedOperation => {
                kind.name().to_string()
            }
            (None, None, _) => self.hazard.info().what.to_string(),
        };
        format!("{what}{outcome}")
    }

    /// Returns the members and parameters whose values led to an undefined operation, if those are
    /// not all inputs.
    fn origin(&self) -> Option<String> {
        let is_about = |path: &&(String, Vec<f64>)| self.about.contains(&path.0);
        let flat = self.case.flat.iter().filter(is_about);
        let each =
            flat.map(|(path, values)| ReadValue { path: path.clone(), values: values.clone() });
        let mut each: Vec<ReadValue> = each.collect();
        let is_part = each.len() < self.case.flat.len() || !self.members.is_empty();
        each.extend(self.members.iter().cloned());
        comes_from(&each).filter(|_| self.kind.is_some() && is_part)
    }

    /// Whether it is the rounding of an input to its type, which no formula avoids.
    fn is_of_input(&self) -> bool {
        self.operation.as_ref().is_some_and(|performed| {
            performed.operation == Operation::Convert && performed.is_of_given()
        })
    }

    /// Returns what the catalogue says against it; `None` where that depends on the formula.
    pub fn remedy(&self) -> Option<&'static str> {
        let remedy = match (self.hazard, self.kind) {
            (Hazard::Cancellation | Hazard::AccumulatedError, _) => "",
            (hazard, Some(kind)) if hazard == kind.hazard() => kind.remedy(),
            (hazard, _) => hazard.info().robust,
        };
        (!remedy.is_empty()).then_some(remedy)
    }

    /// Returns the label of the place: the operation with its operands.
    pub fn label(&self) -> String {
        let Some(operation) = &self.operation else {
            return self.kind.map_or(String::new(), |kind| kind.name().to_string());
        };
        let single = |n: &Number| number(f64::from(n.single));
        let operands: Vec<String> = operation.operands.iter().map(single).collect();
        if let Operation::Compare(comparison) = operation.operation {
            let is = operation.result.single != 0.0;
            let in_f32 = format!("{} is {is}", compared(comparison, &operands));
            if self.hazard != Hazard::BranchDivergence {
                return in_f32;
            }
            // All digits, because the shortest text of an f32 hides which side it is on.
            let double = |n: &Number| format!("{:?}", n.double);
            let exact: Vec<String> = operation.operands.iter().map(double).collect();
            return format!(
                "{in_f32} in f32, but {} is {} in f64",
                compared(comparison, &exact),
                !is
            );
        }
        if let (Operation::Index, [index, len]) = (operation.operation, &operands[..]) {
            return format!("index {index} of {len} elements");
        }
        let (f32, f64) = (single(&operation.result), number(operation.result.double));
        let name = match (operation.is_to_half(), operation.is_of_given()) {
            (true, true) => "f16 of the input ",
            (true, false) => "f16 of the result ",
            (false, _) => name(operation.operation),
        };
        let result = match f32 == f64 || self.breach.is_some() {
            true => format!("= {f32}"),
            false => format!("= {f32}, should be {f64}"),
        };
        match operation.is_to_half() {
            true => format!("{name}{} {result}", operands.join(", ")),
            false => format!("{name}({}) {result}", operands.join(", ")),
        }
    }

    /// Returns the notes: the input, its condition, the gain of the robust form.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        notes.push(format!("with {}", self.case.shown()));
        notes.extend(self.origin());
        if let (Some(operation), None) = (&self.operation, self.kind) {
            let error = |n: &Number| (f64::from(n.single) - n.double).abs() / n.double.abs();
            let before = operation.operands.iter().map(error).filter(|x| x.is_finite());
            let before = before.fold(0.0, f64::max);
            let after = error(&operation.result);
            if self.breach.is_none() && after.is_finite() {
                notes.push(format!(
                    "relative error of the operands {}, of the result {}",
                    figure(before),
                    figure(after)
                ));
            }
        }
        if let (Some(condition), None, Outcome::Finite(off, _)) =
            (&self.condition, self.breach, self.outcome)
        {
            if condition.steps > 0.0 && !self.is_of_input() {
                let gains = |advice: &Advice| advice.ulp_before.is_some() && !advice.is_fused;
                let gains = self.advice.as_ref().is_some_and(gains);
                let verdict = match off.steps > 8.0 * condition.steps {
                    true => "the formula is unstable",
                    false if gains => "another form is accurate here",
                    false => "the problem is ill-conditioned here",
                };
                notes.push(format!(
                    "changing `{}` by one ULP changes the result by {} steps: {verdict}",
                    condition.path,
                    figure(condition.steps)
                ));
            }
        }
        if let Some(edge) = &self.edge {
            let share = 100.0 * edge.flipped as f64 / edge.near.max(1) as f64;
            notes.push(format!(
                "{} of {} samples around where the sides of the comparison meet take the wrong one: {} %",
                edge.flipped,
                edge.near,
                figure(share)
            ));
        }
        if let Some(gain) = &self.gain {
            notes.push(format!(
                "{}: {} instead of {}",
                gain.form,
                figure(gain.after),
                figure(gain.before)
            ));
        }
        if let (Some(permitted), Outcome::Finite(off, _), None) =
            (&self.permitted, self.outcome, self.breach)
        {
            if off.steps >= 0.05 {
                notes.push(match permitted.any {
                    true => {
                        format!("the specification permits up to {} steps", figure(permitted.steps))
                    }
                    false => format!(
                        "more than the {} steps that the specification permits",
                        figure(permitted.steps)
                    ),
                });
            }
        }
        if let (Some(permitted), Some(_), Outcome::NotANumber | Outcome::Infinite) =
            (&self.permitted, self.backend, self.outcome)
        {
            notes.push(match permitted.any {
                true => "the specification permits this result".to_string(),
                false => "the specification does not permit this result: the driver is faulty"
                    .to_string(),
            });
        }
        if let Some(against) = &self.against {
            let function = &against.function;
            notes.push(match against.outcome {
                Outcome::NotANumber => format!("`{function}` returns NaN here"),
                Outcome::Infinite => format!("`{function}` returns infinity here"),
                Outcome::Discarded => format!("`{function}` discards here"),
                Outcome::Finite(off, _) => {
                    format!("`{function}` is {} steps off here", figure(off.steps))
                }
            });
        }
        for asked in &self.backends {
            let results: Vec<String> =
                asked.results.iter().map(|x| number(f64::from(*x))).collect();
            notes.push(match &asked.failure {
                None => format!("{} returns {}", asked.backend, results.join(", ")),
                Some(why) => format!("{} failed: {why}", asked.backend),
            });
        }
        if !self.plausible {
            notes.push("only with values that do not occur in scenes".to_string());
        }
        notes
    }
}

impl Performed {
    /// Whether its operands are inputs.
    fn is_of_given(&self) -> bool {
        self.sources.iter().all(|source| matches!(source, Source::Input { .. }))
    }

    /// Whether it is the rounding of a float to `f16`, which the `f64` beside it does not follow.
    fn is_to_half(&self) -> bool {
        let [of] = self.operands[..] else { return false };
        let is_kept = of.double == self.result.double && of.single != self.result.single;
        self.operation == Operation::Convert && is_kept
    }
}

impl Advice {
    /// Returns the help of a finding.
    pub fn text(&self) -> String {
        let code = format!("write `{}` instead of `{}`", self.code, self.before);
        let gain = match (self.ulp_before, self.flipped) {
            (None, Some([before, after])) => format!(
                "{}: rounding decides in {after} instead of {before} of {} samples around here",
                self.name, self.samples
            ),
            (Some(before), _) => format!(
                "{}: {} ULP instead of {} in {} samples around here",
                self.name,
                figure(self.ulp_after),
                figure(before),
                self.samples
            ),
            (None, None) => {
                let others = match self.is_moved {
                    true => "others change as by a rounding of the inputs",
                    false => "no other result changes",
                };
                format!("{}: defined in all of {} samples, and {others}", self.name, self.samples)
            }
        };
        match self.proved {
            Some(ulp) => format!("{code} ({gain}, proved at most {} on the domain)", figure(ulp)),
            None => format!("{code} ({gain})"),
        }
    }
}

impl Case {
    /// Returns the inputs that are not zero, and a note if others are zero.
    pub fn shown(&self) -> String {
        let set = self.flat.iter().filter(|(_, values)| values.iter().any(|x| *x != 0.0));
        let mut all: Vec<String> = set.map(|(path, values)| shown(path, values)).collect();
        match (all.len(), self.flat.len() - all.len()) {
            (_, 0) => {}
            (0, _) => all.push("all inputs zero".to_string()),
            (_, _) => all.push("all others zero".to_string()),
        }
        all.join(", ")
    }
}

/// Returns an input with its value.
fn shown(path: &str, values: &[f64]) -> String {
    ReadValue { path: path.to_string(), values: values.to_vec() }.to_string()
}

/// Returns a comparison as shaders spell it.
fn compared(comparison: Comparison, operands: &[String]) -> String {
    let operator = match comparison {
        Comparison::Numbers(Cmp::Eq) => " == ",
        Comparison::Numbers(Cmp::Ne) => " != ",
        Comparison::Numbers(Cmp::Lt) => " < ",
        Comparison::Numbers(Cmp::Le) => " <= ",
        Comparison::Numbers(Cmp::Gt) => " > ",
        Comparison::Numbers(Cmp::Ge) => " >= ",
        Comparison::Test(Test::IsNan) => return format!("isnan({})", operands.join(", ")),
        Comparison::Test(Test::IsInf) => return format!("isinf({})", operands.join(", ")),
    };
    operands.join(operator)
}

pub fn name(operation: Operation) -> &'static str {
    match operation {
        Operation::Add => "add",
        Operation::Sub => "subtract",
        Operation::Mul => "multiply",
        Operation::Div => "divide",
        Operation::Rem => "remainder",
        Operation::Neg => "negate",
        Operation::Abs => "abs",
        Operation::Min => "min",
        Operation::Max => "max",
        Operation::Edge => "step",
        Operation::Clamp => "clamp",
        Operation::Mix => "mix",
        Operation::SmoothStep => "smoothstep",
        Operation::Fma => "fma",
        Operation::Root => "sqrt",
        Operation::InverseRoot => "inversesqrt",
        Operation::Pow => "pow",
        Operation::Exp => "exp",
        Operation::Log => "log",
        Operation::Trigonometric => "angle",
        Operation::Dot => "dot",
        Operation::Length => "length",
        Operation::Distance => "distance",
        Operation::Normalize => "normalize",
        Operation::Cross => "cross",
        Operation::Compare(_) => "compare",
        Operation::Convert => "convert",
        Operation::Integer => "integer",
        Operation::Index => "index",
        Operation::Texture => "texture",
        Operation::Function(name) => name,
        Operation::Other => "compute",
    }
}

/// Formats a number with three significant digits, without trailing zeros.
pub fn figure(x: f64) -> String {
    let text = phrases::figure(x);
    match text.contains('.') && !text.contains('e') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_string(),
        false => text,
    }
}
