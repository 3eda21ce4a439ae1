//! Finds the cause of a wrong result: goes back through its operands to the first operation with
//! accurate operands.
//!
//! Reads a [`Trace`]; used by [`classify`](super::classify).

use super::input::Input;
use landfall_exec::harness::call::pure::PureFunction;
use landfall_interp::{Number, Operand, Operation, Source, Trace, TracedOperation};

/// The relative error up to which an operand is accurate: 32 units of the last place.
/// Above the rounding of a few operations, below a loss that shows.
const RIGHT: f64 = 1.0 / 262_144.0;

/// A trace with named inputs.
pub(super) struct Graph<'a> {
    pub pure: &'a PureFunction,
    pub trace: &'a Trace,
    pub inputs: &'a [Input],
}

impl<'a> Graph<'a> {
    /// Returns the step that produced a number.
    pub fn step(&self, source: Source) -> Option<(&'a TracedOperation, usize)> {
        self.trace.step(source)
    }

    /// Returns the input that a number equals, possibly negated.
    pub fn input(&self, source: Source) -> Option<usize> {
        match source {
            Source::Input { parameter, scalar } => {
                let scalar = self.pure.scalar_of(parameter, scalar)?;
                self.inputs.iter().position(|input| input.range().contains(&scalar))
            }
            Source::Step { .. } => {
                let (step, _) = self.step(source)?;
                (step.operation == Operation::Neg).then(|| self.input(step.operands[0].source))?
            }
            Source::Constant | Source::Buffer { .. } | Source::Unknown => None,
        }
    }

    /// Returns all inputs that some numbers depend on.
    pub fn inputs_of(&self, sources: impl IntoIterator<Item = Source>) -> Vec<usize> {
        let operand = |source| Operand { number: Number::default(), source };
        let operands: Vec<Operand> = sources.into_iter().map(operand).collect();
        let origins = self.trace.origins(&operands);
        let mut found: Vec<usize> = origins.iter().filter_map(|o| self.input(o.source)).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Returns the step that introduced a result's error; `None` if an input did.
    pub fn error_source(&self, result: Source) -> Option<usize> {
        let mut at = result;
        // Along the operand with the largest share of the error, from the result to where the
        // operands are accurate: that operation made the error.
        let mut guilty = None;
        // The graph has no cycles; the bound guards against a broken one.
        for _ in 0..=self.trace.steps.len() {
            let Source::Step { step: number, part } = at else { break };
            let Some(step) = self.trace.steps.get(number as usize) else { break };
            guilty = Some(number as usize);
            match self.spoilt(step, part as usize) {
                Some(operand) => at = operand.source,
                None => break,
            }
        }
        guilty
    }

    /// Returns the operand that caused most of a result's error, if it was inaccurate.
    fn spoilt(&self, step: &TracedOperation, part: usize) -> Option<Operand> {
        let result = step.results.get(part).copied().unwrap_or_default();
        // NaN and infinity propagate from the operand that has them.
        // The first NaN or infinity among the operands, or none: then it was made here.
        let odd = step.non_finite_operand();
        if !result.is_finite() || odd.is_some() {
            return odd.copied();
        }
        let shares = shares(step, part);
        let mut worst: Option<(f64, Operand)> = None;
        for (operand, share) in step.operands.iter().zip(shares) {
            if wrong(operand.number) && worst.is_none_or(|(most, _)| share > most) {
                worst = Some((share, *operand));
            }
        }
        let (share, operand) = worst?;
        // The step's own rounding or cancellation may be the larger share.
        let error = (f64::from(result.single) - result.double).abs();
        // A quarter: the operand explains a good part of the error, else the operation itself is
        // at fault.
        (share >= 0.25 * error).then_some(operand)
    }
}

/// Whether `f32` and `f64` differ by more than a few roundings.
fn wrong(number: Number) -> bool {
    let (single, double) = (f64::from(number.single), number.double);
    (single - double).abs() > RIGHT * double.abs()
}

/// Returns, for each operand, the share of the result's error it causes, to first order.
fn shares(step: &TracedOperation, part: usize) -> Vec<f64> {
    // The derivative of the operation by each operand times the operand's error.
    let d = |o: &Operand| (f64::from(o.number.single) - o.number.double).abs();
    // Where `f32` and `f64` are far apart, the larger one.
    let x = |i: usize| {
        let n = step.operands[i].number;
        n.double.abs().max(f64::from(n.single).abs())
    };
    let o = &step.operands;
    let result = step.results.get(part).map_or(0.0, |r| r.double);
    let plain = || o.iter().map(&d).collect::<Vec<f64>>();
    match step.operation {
        Operation::Mul => vec![d(&o[0]) * x(1).abs(), d(&o[1]) * x(0).abs()],
        Operation::Div => {
            // The smaller of both divisors, since near zero the quotient is far from linear.
            let n = step.operands[1].number;
            let by = n.double.abs().min(f64::from(n.single).abs()).max(f64::MIN_POSITIVE);
            let given = step.results.get(part).map_or(0.0, |r| f64::from(r.single).abs());
            vec![d(&o[0]) / by, d(&o[1]) * result.abs().max(given) / by]
        }
        Operation::Fma => vec![d(&o[0]) * x(1).abs(), d(&o[1]) * x(0).abs(), d(&o[2])],
        Operation::Dot => {
            // Operands are the components of the first vector, then those of the second.
            let half = o.len() / 2;
            let other = |i: usize| x(if i < half { i + half } else { i - half }).abs();
            o.iter().enumerate().map(|(i, operand)| d(operand) * other(i)).collect()
        }
        Operation::Pow => {
            let base = x(0).abs().max(f64::MIN_POSITIVE);
            // d(x^y) = y x^(y-1) dx + x^y ln x dy.
            let by_base = d(&o[0]) / base * x(1).abs();
            vec![by_base * result.abs(), d(&o[1]) * base.ln().abs() * result.abs()]
        }
        Operation::Exp => vec![d(&o[0]) * result.abs()],
        Operation::Log => vec![d(&o[0]) / x(0).abs().max(f64::MIN_POSITIVE)],
        // d(sqrt x) = dx / (2 sqrt x).
        Operation::Root => vec![d(&o[0]) * 0.5 / result.abs().max(f64::MIN_POSITIVE)],
        // d(1 / sqrt x) = -dx / 2 * x^(-3/2).
        Operation::InverseRoot => vec![d(&o[0]) * 0.5 * result.abs().powi(3)],
        Operation::Normalize => {
            let length = o.iter().map(|o| o.number.double.powi(2)).sum::<f64>().sqrt();
            o.iter().map(|o| d(o) / length.max(f64::MIN_POSITIVE)).collect()
        }
        Operation::Mix => {
            vec![d(&o[0]) * x(2).max(1.0), d(&o[1]) * x(2).abs(), d(&o[2]) * x(1).max(x(0))]
        }
        Operation::SmoothStep => {
            let edge = |i: usize| step.operands[i].number.double;
            let width = (edge(1) - edge(0)).abs().max(f64::MIN_POSITIVE);
            // The steepest slope of 3 t^2 - 2 t^3 is 1.5.
            o.iter().map(|o| 1.5 * d(o) / width).collect()
        }
        Operation::Cross => {
            // Each component reads two products of two operands.
            let (j, k) = ((part + 1) % 3, (part + 2) % 3);
            let mut all = vec![0.0; o.len()];
            for (i, by) in [(j, 3 + k), (k, 3 + j), (3 + k, j), (3 + j, k)] {
                all[i] = d(&o[i]) * x(by).abs();
            }
            all
        }
        Operation::Add
        | Operation::Sub
        | Operation::Neg
        | Operation::Abs
        | Operation::Min
        | Operation::Max
        | Operation::Clamp
        | Operation::Length
        | Operation::Distance
        | Operation::Rem
        | Operation::Edge
        | Operation::Trigonometric
        | Operation::Compare(_)
        | Operation::Convert
        | Operation::Integer
        | Operation::Index
        | Operation::Texture
        | Operation::Function(_)
        | Operation::Other => plain(),
    }
}
