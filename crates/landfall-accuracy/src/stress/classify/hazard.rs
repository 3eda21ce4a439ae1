//! The hazard of an operation, by its kind and the roles of its inputs.
//!
//! Used by [`classify`](super) for operations without a defined value and for losses.

use super::{HazardCandidate, Performed};
use crate::stress::blame::Graph;
use crate::stress::input::{Sample, float};
use crate::stress::role::InputRole;
use landfall_exec::harness::call::pure::PureCallResult;
use landfall_interp::{Number, Operand, Operation, Source, TracedOperation, UndefinedKind};
use landfall_ir::analysis::hazard::Hazard;
use landfall_ir::analysis::hazard::threshold::{
    ABOVE_ONE, COORDINATE, EXPONENT, LENGTH, NARROW, ORIGIN,
};

/// A hazard, the inputs involved, and what happens where that says more than the hazard.
type Class = (Hazard, Vec<usize>, Option<&'static str>);

/// A sample with the graph of its operations.
pub(super) struct TracedSample<'a> {
    pub graph: Graph<'a>,
    pub sample: &'a Sample,
}

impl TracedSample<'_> {
    fn candidate(
        &self,
        step: &TracedOperation,
        (hazard, about, what): Class,
        kind: Option<UndefinedKind>,
    ) -> HazardCandidate {
        let worst =
            step.results.iter().max_by(|a, b| absolute_error(a).total_cmp(&absolute_error(b)));
        let operation = Performed {
            operation: step.operation,
            operands: step.operands.iter().map(|o| o.number).collect(),
            result: worst.copied().unwrap_or_default(),
            sources: step.operands.iter().map(|o| o.source).collect(),
            scale: step.operands.first().map_or(0.0, |first| {
                self.graph.step(first.source).map_or(first.number.double.abs(), |s| largest(s.0))
            }),
        };
        let place = self.graph.pure.place_of(step);
        let members = match kind {
            Some(_) => self.graph.pure.members_read(self.graph.trace, step),
            None => Vec::new(),
        };
        HazardCandidate { hazard, place, operation: Some(operation), about, members, kind, what }
    }

    /// Returns the role of an input. The letter of a parameter has none: `c` and `d` are anything.
    fn role(&self, at: usize) -> InputRole {
        let input = &self.graph.inputs[at];
        let is_letter = input.len == 1 && input.path.chars().count() == 1;
        if is_letter { InputRole::Other } else { input.role }
    }

    fn any_role(&self, inputs: &[usize], is: impl Fn(InputRole) -> bool) -> bool {
        inputs.iter().any(|&at| is(self.role(at)))
    }

    /// Whether inputs are a light's or the eye's position and the place that it is seen from.
    fn are_positions(&self, inputs: &[usize]) -> bool {
        // Several positions, one of a light or the eye: their difference is a path.
        let positions = inputs.iter().filter(|&&at| self.role(at).is_position()).count();
        let lit = |role| matches!(role, InputRole::LightPosition | InputRole::ViewPosition);
        positions > 1 && self.any_role(inputs, lit)
    }

    /// Returns the values of an input.
    fn values(&self, at: usize) -> Vec<f32> {
        self.graph.inputs[at].range().map(|i| float(self.sample, i)).collect()
    }

    fn sources(step: &TracedOperation) -> Vec<Source> {
        step.operands.iter().map(|o| o.source).collect()
    }

    fn behind(&self, step: &TracedOperation) -> Vec<usize> {
        self.graph.inputs_of(Self::sources(step))
    }

    pub fn undefined(&self, step: &TracedOperation, kind: UndefinedKind) -> HazardCandidate {
        // What is undefined, then by which inputs: lighting hazards are arithmetic ones with a
        // known origin.
        use UndefinedKind as U;
        let plain = || (kind.hazard(), self.behind(step), None);
        let class = match kind {
            U::NormalizeOfZero => self.zero_vector(&Self::sources(step)),
            // Of a square that underflows, not of a difference that cancels.
            U::DivisionByZero if underflows(&step.operands[1].number) => {
                (Hazard::Underflow, self.graph.inputs_of([step.operands[1].source]), None)
            }
            U::DivisionByZero => self.division(step),
            U::SmoothStepEdges => {
                let edges = [0, 1].map(|i| step.operands[i]);
                let behind = self.graph.inputs_of(edges.map(|edge| edge.source));
                let are_equal = edges[0].number.double == edges[1].number.double;
                match (self.any_role(&behind, InputRole::is_cone), are_equal) {
                    (true, true) => (Hazard::EqualCutOffs, behind, None),
                    (true, false) => (Hazard::SwappedCutOffs, behind, None),
                    (false, _) => plain(),
                }
            }
            U::RootOfNegative if step.operation == Operation::InverseRoot => {
                // `inversesqrt(dot(v, v))` is a `normalize`.
                match self.squared(step.operands[0].source) {
                    Some(vector) if step.operands[0].number.double == 0.0 => {
                        self.zero_vector(&vector)
                    }
                    _ => plain(),
                }
            }
            U::SquaresTooLarge => (Hazard::Overflow, self.behind(step), None),
            U::BornInfinite | U::BornNan => self.overflow(step),
            U::IndexOutOfBounds => self.index(step),
            _ => plain(),
        };
        self.candidate(step, class, Some(kind))
    }

    /// Returns the vector whose squared length, or length, a number is.
    fn squared(&self, source: Source) -> Option<Vec<Source>> {
        let (step, _) = self.graph.step(source)?;
        match step.operation {
            Operation::Length => Some(Self::sources(step)),
            Operation::Distance => Some(Self::sources(step)),
            // `max(dot(v, v), 0)` is still the square.
            Operation::Root | Operation::Max => self.squared(step.operands[0].source),
            Operation::Dot => {
                let all = Self::sources(step);
                let (a, b) = all.split_at(all.len() / 2);
                (a == b).then(|| a.to_vec())
            }
            _ => None,
        }
    }

    /// Returns why a vector is zero, by the operations that its components are results of.
    fn zero_vector(&self, components: &[Source]) -> Class {
        let behind = self.graph.inputs_of(components.iter().copied());
        // Zero because of what its components are computed from: a cross product, a vector without
        // its part along another, a sum of opposites, a difference of equal points, or an input
        // that is zero.
        let steps: Option<Vec<&TracedOperation>> =
            components.iter().map(|source| self.graph.step(*source).map(|found| found.0)).collect();
        let steps = steps.unwrap_or_default();
        let is = |operation: Operation| {
            !steps.is_empty() && steps.iter().all(|step| step.operation == operation)
        };
        if is(Operation::Cross) {
            return (Hazard::ParallelVectors, behind, None);
        }
        if is(Operation::Add) || is(Operation::Fma) || is(Operation::Sub) {
            // `t - n * dot(n, t)` takes a multiple of a vector out of another.
            let is_product = |o: &Operand| {
                self.graph.step(o.source).is_some_and(|(step, _)| {
                    let scales = step.operation == Operation::Mul;
                    scales && step.operands.iter().any(|o| self.is_dot(o.source))
                })
            };
            let takes_out = |step: &&TracedOperation| match step.operation {
                Operation::Fma => step.operands.iter().any(|o| self.is_dot(o.source)),
                _ => step.operands.iter().any(is_product),
            };
            if steps.iter().all(takes_out) {
                return (Hazard::ParallelVectors, behind, None);
            }
        }
        let is_zero = |o: &Operand| o.number.single == 0.0;
        let are_zero = steps.iter().all(|step| step.operands.iter().all(is_zero));
        if is(Operation::Add) && !are_zero {
            return (Hazard::OppositeVectors, behind, None);
        }
        if is(Operation::Sub) {
            if !self.are_positions(&behind) {
                return (
                    Hazard::ZeroVector,
                    behind,
                    Some("two equal vectors are subtracted, and the difference is normalised"),
                );
            }
            let is_view = self.any_role(&behind, |role| role == InputRole::ViewPosition);
            let hazard = if is_view { Hazard::CameraAtFragment } else { Hazard::LightAtFragment };
            return (hazard, behind, None);
        }
        // An input itself: a light's axis, a position in view space, or any vector.
        let zero = |&&at: &&usize| {
            self.graph.inputs[at].is_vector() && self.values(at).iter().all(|x| *x == 0.0)
        };
        match behind.iter().find(zero) {
            Some(&at) if self.role(at) == InputRole::Axis => {
                (Hazard::ZeroDirection, vec![at], None)
            }
            // In view space the eye is the origin.
            Some(&at) if self.role(at) == InputRole::FragmentPosition => {
                (Hazard::CameraAtFragment, vec![at], None)
            }
            Some(&at) => (Hazard::ZeroVector, vec![at], None),
            None => (Hazard::ZeroVector, behind, None),
        }
    }

    fn is_dot(&self, source: Source) -> bool {
        self.graph.step(source).is_some_and(|(step, _)| step.operation == Operation::Dot)
    }

    fn division(&self, step: &TracedOperation) -> Class {
        let by = step.operands[1].source;
        let behind = self.graph.inputs_of([by]);
        if let Some(vector) = self.squared(by) {
            // `v / length(v)`, not `1 / length(v)`.
            if vector.contains(&step.operands[0].source) {
                return self.zero_vector(&vector);
            }
            if !self.any_role(&behind, InputRole::is_attenuation) && !self.are_positions(&behind) {
                let what =
                    "a division by the length, or the square of the length, of a zero vector";
                return (Hazard::DivisionByZero, behind, Some(what));
            }
        }
        // `inner - outer` and `1 - cutoff`, directly of inputs.
        if let Some((sub, _)) = self.graph.step(by).filter(|(s, _)| s.operation == Operation::Sub) {
            let ends = [0, 1].map(|i| self.graph.input(sub.operands[i].source));
            let is_cone = |at: usize| self.role(at).is_cone();
            match ends {
                [Some(a), Some(b)] if is_cone(a) || is_cone(b) => {
                    return (Hazard::EqualCutOffs, vec![a, b], None);
                }
                [None, Some(b)] if sub.operands[0].number.double == 1.0 && is_cone(b) => {
                    return (Hazard::ZeroWidthCone, vec![b], None);
                }
                _ => {}
            }
            // Cut-offs that are angles have their cosines computed here.
            let cones: Vec<usize> = behind.iter().copied().filter(|&at| is_cone(at)).collect();
            match cones.len() {
                0 => {}
                1 => return (Hazard::ZeroWidthCone, cones, None),
                _ => return (Hazard::EqualCutOffs, cones, None),
            }
        }
        let coefficients: Vec<usize> =
            behind.iter().copied().filter(|&at| self.role(at).is_attenuation()).collect();
        // An attenuation is zero because of its coefficients, or because of the distance.
        if !coefficients.is_empty() {
            let values: Vec<f32> = coefficients.iter().flat_map(|&at| self.values(at)).collect();
            if values.iter().any(|x| *x < 0.0) {
                return (Hazard::NegativeAttenuation, coefficients, None);
            }
            if values.iter().all(|x| *x == 0.0) {
                return (Hazard::AttenuationUnset, coefficients, None);
            }
            return (Hazard::AttenuationAtLight, behind, None);
        }
        // A distance that is zero, not a depth or a radius.
        let is_at = |at: &usize| {
            self.role(*at) == InputRole::Distance && self.values(*at).iter().all(|x| *x == 0.0)
        };
        if behind.iter().all(is_at) && !behind.is_empty() || self.are_positions(&behind) {
            return (Hazard::AttenuationAtLight, behind, None);
        }
        (Hazard::DivisionByZero, behind, None)
    }

    /// Returns why an index is not in its array.
    fn index(&self, step: &TracedOperation) -> Class {
        let behind = self.behind(step);
        let index = step.operands[0];
        // The counter of a loop depends on its bound by a comparison alone.
        let all: Vec<usize> = (0..self.graph.inputs.len()).collect();
        let bounds = if behind.is_empty() { &all } else { &behind };
        let counts = bounds.iter().copied().filter(|&at| self.role(at) == InputRole::Count);
        let counts: Vec<usize> = counts.collect();
        if !counts.is_empty() {
            return (Hazard::CountPastArray, counts, None);
        }
        if index.number.double < 0.0 && self.is_remainder(index.source, 0) {
            let what = "an index is negative: the remainder of a negative integer has its sign";
            return (Hazard::NegativeRemainder, behind, Some(what));
        }
        // Exact arithmetic would have been inside of the array: `int(x * 8.0)` with x rounded up
        // to 1.
        let exact = self.graph.step(index.source).filter(|(from, _)| {
            let whole = |x: f64| (0.0..step.operands[1].number.double).contains(&x.floor());
            from.operation == Operation::Convert && whole(from.operands[0].number.double)
        });
        let what = exact.map(|_| "rounding takes an index past the end of its array");
        (Hazard::IndexOutOfBounds, behind, what)
    }

    /// Whether an integer is a remainder, or a multiple or sum of one.
    fn is_remainder(&self, source: Source, depth: u32) -> bool {
        let Some((step, _)) = self.graph.step(source).filter(|_| depth < 8) else { return false };
        match step.operation {
            Operation::Rem => true,
            Operation::Integer | Operation::Convert => {
                step.operands.iter().any(|o| self.is_remainder(o.source, depth + 1))
            }
            _ => false,
        }
    }

    fn overflow(&self, step: &TracedOperation) -> Class {
        let largest = largest(step);
        let x = |i: usize| step.operands[i].number;
        let single_zero = || x(1).single == 0.0 && x(1).double != 0.0;
        let behind = self.behind(step);
        match step.operation {
            Operation::Convert if self.graph.input(step.operands[0].source).is_some() => {
                (Hazard::LargeValues, behind, Some("the float type cannot hold an input"))
            }
            // With half precision, the result of an operation is rounded by the next.
            Operation::Convert => match self.graph.step(step.operands[0].source) {
                Some((from, _)) if from.operation != Operation::Convert => self.overflow(from),
                _ => (Hazard::LargeValues, behind, None),
            },
            // A cosine a little above 1 is no large base, but rounding.
            Operation::Pow if x(0).single > 1.0 => {
                let near = x(0).double < 1.0 + ABOVE_ONE.value;
                (if near { Hazard::BaseAboveOne } else { Hazard::LargeValues }, behind, None)
            }
            Operation::Exp => {
                (Hazard::LargeValues, behind, Some("the exponential of a large number overflows"))
            }
            Operation::Div if single_zero() || x(1).double.abs() < LENGTH.value * LENGTH.value => {
                let behind = self.graph.inputs_of([step.operands[1].source]);
                let negative = behind.iter().any(|&at| {
                    self.role(at).is_attenuation() && self.values(at).iter().any(|v| *v < 0.0)
                });
                let hazard = if negative { Hazard::NegativeAttenuation } else { Hazard::Underflow };
                (hazard, behind, None)
            }
            Operation::InverseRoot => (Hazard::Underflow, behind, None),
            Operation::Dot | Operation::Length | Operation::Distance | Operation::Normalize
                if largest > COORDINATE.value =>
            {
                (Hazard::Overflow, behind, None)
            }
            Operation::Mul if step.operands[0].source == step.operands[1].source => {
                (Hazard::Overflow, behind, None)
            }
            // A term of an attenuation has squares of the distance.
            Operation::Mul | Operation::Add | Operation::Fma
                if self.are_positions(&behind)
                    || self.any_role(&behind, |role| role == InputRole::Distance) =>
            {
                (Hazard::Overflow, behind, None)
            }
            _ => (Hazard::LargeValues, behind, None),
        }
    }

    /// Returns the first comparison that `f32` and `f64` decide differently.
    pub fn diverged(&self) -> Option<HazardCandidate> {
        let decides = |step: &&TracedOperation| {
            matches!(step.operation, Operation::Compare(_))
                && step.results.iter().any(|n| f64::from(n.single) != n.double)
        };
        let step = self.graph.trace.steps.iter().find(decides)?;
        let about = self.graph.inputs_of(Self::sources(step));
        Some(self.candidate(step, (Hazard::BranchDivergence, about, None), None))
    }

    /// Returns the operation that introduced the error of the worst component.
    pub fn inaccurate(
        &self,
        floats: &[(usize, usize)],
        called: &PureCallResult,
    ) -> Option<HazardCandidate> {
        // The component of the results with the largest error, and where its number comes from.
        let sources = self.graph.pure.sources(self.graph.trace);
        let mut flat = 0;
        let mut worst: Option<(f64, Source)> = None;
        for (nth, result) in self.graph.pure.results.iter().enumerate() {
            for at in 0..result.ty.scalars().len() {
                let source = sources.get(flat).copied();
                flat += 1;
                if !floats.contains(&(nth, at)) {
                    continue;
                }
                let single = f64::from(f32::from_bits(called.results[nth].words[at][0] as u32));
                let error = (single - called.results[nth].doubles[at][0]).abs();
                if let Some(source) = source.filter(|_| worst.is_none_or(|(most, _)| error > most))
                {
                    worst = Some((error, source));
                }
            }
        }
        let guilty = self.graph.error_source(worst?.1)?;
        let step = &self.graph.trace.steps[guilty];
        // An undefined value is a finding of its own.
        if step.fault().is_some() {
            return None;
        }
        Some(self.candidate(step, self.loss(step), None))
    }

    /// Returns the kind of loss of an operation with accurate operands and a wrong result.
    fn loss(&self, step: &TracedOperation) -> Class {
        // The operation has accurate operands: which of its properties lost the digits follows
        // from their sizes.
        let behind = self.behind(step);
        let largest = largest(step);
        let result = step.results.first().copied().unwrap_or_default();
        match step.operation {
            Operation::Pow => {
                let [base, exponent] = [step.operands[0].number, step.operands[1].number];
                if base.single > 1.0 && base.double <= 1.0 + ABOVE_ONE.value {
                    (Hazard::BaseAboveOne, behind, None)
                } else if exponent.double.abs() >= EXPONENT.value {
                    (Hazard::LargeExponent, behind, None)
                } else {
                    (Hazard::AccumulatedError, behind, None)
                }
            }
            Operation::Convert if self.graph.input(step.operands[0].source).is_some() => {
                let what = "the float type rounds an input, before any operation";
                (Hazard::AccumulatedError, behind, Some(what))
            }
            Operation::Exp => {
                let what = "the rounding of a large exponent is a relative error of the power";
                (Hazard::AccumulatedError, behind, Some(what))
            }
            Operation::Length
            | Operation::Distance
            | Operation::Normalize
            | Operation::Dot
            | Operation::InverseRoot
            | Operation::Root
            | Operation::Mul
            | Operation::Div
            | Operation::Cross
            | Operation::Fma
                if largest > COORDINATE.value =>
            {
                (Hazard::Overflow, behind, None)
            }
            Operation::Length
            | Operation::Distance
            | Operation::Normalize
            | Operation::InverseRoot
            | Operation::Root
            | Operation::Mul
            | Operation::Div
                // Small ones vanish or lose digits below the normal numbers.
                if smallest(step) < LENGTH.value || result.double.abs() < 1.0e-37 =>
            {
                (Hazard::Underflow, behind, None)
            }
            Operation::Add
            | Operation::Sub
            | Operation::Fma
            | Operation::Dot
            | Operation::Mix
            | Operation::Cross => {
                let cone = self.any_role(&behind, InputRole::is_cone);
                let far = largest > ORIGIN.value && self.any_role(&behind, InputRole::is_position);
                if cone && (NARROW.value..4.0).contains(&largest) {
                    (Hazard::NarrowCone, behind, None)
                } else if far {
                    (Hazard::FarFromOrigin, behind, None)
                } else {
                    (Hazard::Cancellation, behind, None)
                }
            }
            Operation::SmoothStep => {
                let cone = self.any_role(&behind, InputRole::is_cone);
                match (cone, largest >= NARROW.value) {
                    (true, true) => (Hazard::NarrowCone, behind, None),
                    (true, false) => (Hazard::Cancellation, behind, None),
                    (false, _) => (Hazard::AccumulatedError, behind, None),
                }
            }
            _ => (Hazard::AccumulatedError, behind, None),
        }
    }
}

/// Whether a number is zero only because it is too small for an `f32`.
fn underflows(number: &Number) -> bool {
    let size = number.double.abs();
    number.single == 0.0 && size > 0.0 && size < f64::from(f32::MIN_POSITIVE)
}

fn largest(step: &TracedOperation) -> f64 {
    step.operands.iter().map(|o| o.number.double.abs()).fold(0.0, f64::max)
}

fn smallest(step: &TracedOperation) -> f64 {
    let magnitudes = step.operands.iter().map(|o| o.number.double.abs());
    magnitudes.filter(|x| *x > 0.0).fold(f64::INFINITY, f64::min)
}

fn absolute_error(number: &Number) -> f64 {
    match (f64::from(number.single) - number.double).abs() {
        nan if nan.is_nan() => f64::INFINITY,
        off => off,
    }
}
