//! The hazard of an operation, by its kind and the roles of its inputs.
//!
//! Used by [`classify`](super) for operations without a defined value and for losses.

use super::{Candidate, Performed, undefined};
use crate::accuracy::stress::blame::Graph;
use crate::accuracy::stress::input::{Sample, float};
use crate::accuracy::stress::role::Role;
use landfall_exec::harness::call::pure::PureCallResult;
use landfall_exec::interp::{Number, Operation, Source, TracedOperation, UndefinedKind};
use landfall_ir::analysis::hazard::Hazard;
use landfall_ir::analysis::hazard::threshold::{
    ABOVE_ONE, COORDINATE, EXPONENT, LENGTH, NARROW, ORIGIN,
};

/// A sample with the graph of its operations.
pub(super) struct TracedSample<'a> {
    pub graph: Graph<'a>,
    pub sample: &'a Sample,
}

impl TracedSample<'_> {
    fn candidate(
        &self,
        step: &TracedOperation,
        hazard: Hazard,
        about: Vec<usize>,
        kind: Option<UndefinedKind>,
    ) -> Candidate {
        let worst =
            step.results.iter().max_by(|a, b| absolute_error(a).total_cmp(&absolute_error(b)));
        let operation = Performed {
            operation: step.operation,
            operands: step.operands.iter().map(|o| o.number).collect(),
            result: worst.copied().unwrap_or_default(),
            sources: step.operands.iter().map(|o| o.source).collect(),
        };
        let place = self.graph.pure.place_of(step);
        Candidate { hazard, place, operation: Some(operation), about, kind }
    }

    fn role(&self, at: usize) -> Role {
        self.graph.inputs[at].role
    }

    /// Returns the values of an input.
    fn values(&self, at: usize) -> Vec<f32> {
        self.graph.inputs[at].range().map(|i| float(self.sample, i)).collect()
    }

    fn sources(step: &TracedOperation) -> Vec<Source> {
        step.operands.iter().map(|o| o.source).collect()
    }

    pub fn undefined(&self, step: &TracedOperation, kind: UndefinedKind) -> Candidate {
        use UndefinedKind as U;
        let (hazard, about) = match kind {
            U::NormalizeOfZero => self.zero_vector(&Self::sources(step)),
            // Of a square that underflows, not of a difference that cancels.
            U::DivisionByZero if underflows(&step.operands[1].number) => {
                (Hazard::Underflow, self.graph.inputs_of([step.operands[1].source]))
            }
            U::DivisionByZero => self.division(step),
            U::RootOfNegative | U::LogOfNonPositive | U::PowOfNegative
                if step.operands[0].number.double > 0.0 =>
            {
                (Hazard::Cancellation, self.graph.inputs_of(Self::sources(step)))
            }
            U::PowOfZero => (Hazard::PowOfZero, Vec::new()),
            U::PowOfNegative => (Hazard::PowOfNegative, Vec::new()),
            U::SmoothStepEdges => {
                let (a, b) = (step.operands[0].number.double, step.operands[1].number.double);
                let hazard = if a == b { Hazard::EqualCutOffs } else { Hazard::SwappedCutOffs };
                (hazard, Vec::new())
            }
            U::RootOfNegative if step.operation == Operation::InverseRoot => {
                match self.squared(step.operands[0].source) {
                    Some(vector) if step.operands[0].number.double == 0.0 => {
                        self.zero_vector(&vector)
                    }
                    _ => (Hazard::UndefinedOperation, Vec::new()),
                }
            }
            U::SquaresTooLarge => (Hazard::Overflow, self.graph.inputs_of(Self::sources(step))),
            U::SquaresTooSmall => (Hazard::Underflow, self.graph.inputs_of(Self::sources(step))),
            U::BornInfinite | U::BornNan => self.overflow(step),
            U::ZeroTimesInfinity
            | U::RootOfNegative
            | U::LogOfNonPositive
            | U::ArcOutOfRange
            | U::AtanOfZeros
            | U::ClampBounds
            | U::Uninitialised
            | U::NanFromBuffer
            | U::NanCompared
            | U::IntegerDivisionByZero
            | U::IntegerOverflow
            | U::RemainderOfNegative
            | U::ShiftTooFar
            | U::BitsOutOfRange
            | U::ConversionOutOfRange
            | U::IndexOutOfBounds
            | U::PastEndOfBuffer => (Hazard::UndefinedOperation, Vec::new()),
        };
        self.candidate(step, hazard, about, Some(kind))
    }

    /// Returns the vector whose squared length, or length, a number is.
    fn squared(&self, source: Source) -> Option<Vec<Source>> {
        let (step, _) = self.graph.step(source)?;
        match step.operation {
            Operation::Length => Some(Self::sources(step)),
            Operation::Distance => Some(Self::sources(step)),
            Operation::Root | Operation::Max => self.squared(step.operands[0].source),
            Operation::Dot => {
                let all = Self::sources(step);
                let (a, b) = all.split_at(all.len() / 2);
                (a == b).then(|| a.to_vec())
            }
            _ => None,
        }
    }

    /// Returns why a vector is zero.
    fn zero_vector(&self, components: &[Source]) -> (Hazard, Vec<usize>) {
        let behind = self.graph.inputs_of(components.iter().copied());
        let vectors: Vec<usize> =
            behind.iter().copied().filter(|&at| self.graph.inputs[at].is_vector()).collect();
        for (n, &a) in vectors.iter().enumerate() {
            for &b in &vectors[..n] {
                let (v, w) = (self.values(a), self.values(b));
                let same = v.iter().zip(&w).take(3).all(|(x, y)| x == y);
                let opposite = v.iter().zip(&w).take(3).all(|(x, y)| *x == -*y);
                let zero = v.iter().take(3).all(|x| *x == 0.0);
                if same && !(zero && opposite && !self.is_difference(components)) {
                    let view = [a, b].iter().any(|&at| self.role(at) == Role::ViewPosition);
                    let hazard =
                        if view { Hazard::CameraAtFragment } else { Hazard::LightAtFragment };
                    return (hazard, vec![b, a]);
                }
                if opposite {
                    return (Hazard::OppositeVectors, vec![b, a]);
                }
            }
        }
        let zero = |&&at: &&usize| self.values(at).iter().all(|x| *x == 0.0);
        match vectors.iter().find(zero) {
            Some(&at) if self.role(at) == Role::Axis => (Hazard::ZeroDirection, vec![at]),
            // In view space the eye is the origin.
            Some(&at) if self.role(at) == Role::FragmentPosition => {
                (Hazard::CameraAtFragment, vec![at])
            }
            Some(&at) => (Hazard::ZeroVector, vec![at]),
            None => (Hazard::ZeroVector, vectors),
        }
    }

    fn is_difference(&self, components: &[Source]) -> bool {
        components.iter().any(|source| {
            self.graph.step(*source).is_some_and(|(step, _)| step.operation == Operation::Sub)
        })
    }

    fn division(&self, step: &TracedOperation) -> (Hazard, Vec<usize>) {
        let by = step.operands[1].source;
        if let Some(vector) = self.squared(by) {
            let numerator = self.graph.inputs_of([step.operands[0].source]);
            // `v / length(v)`, not `1 / length(v)`.
            if step.operands[0].number.double == 0.0 && !numerator.is_empty() {
                return self.zero_vector(&vector);
            }
        }
        let behind = self.graph.inputs_of([by]);
        if let Some((sub, _)) = self.graph.step(by).filter(|(s, _)| s.operation == Operation::Sub) {
            let ends = [0, 1].map(|i| self.graph.input(sub.operands[i].source));
            match ends {
                [Some(a), Some(b)] => {
                    let cone = self.role(a).is_cone() || self.role(b).is_cone();
                    if cone || self.values(a) == self.values(b) && self.clamped(step) {
                        return (Hazard::EqualCutOffs, vec![a, b]);
                    }
                }
                [None, Some(b)] if sub.operands[0].number.double == 1.0 => {
                    return (Hazard::ZeroWidthCone, vec![b]);
                }
                _ => {}
            }
            // Cut-offs that are angles have their cosines computed here.
            let cones: Vec<usize> =
                behind.iter().copied().filter(|&at| self.role(at).is_cone()).collect();
            match cones.len() {
                0 => {}
                1 => return (Hazard::ZeroWidthCone, cones),
                _ => return (Hazard::EqualCutOffs, cones),
            }
        }
        let coefficients: Vec<usize> =
            behind.iter().copied().filter(|&at| self.role(at).is_attenuation()).collect();
        if !coefficients.is_empty() {
            let values: Vec<f32> = coefficients.iter().flat_map(|&at| self.values(at)).collect();
            if values.iter().any(|x| *x < 0.0) {
                return (Hazard::NegativeAttenuation, coefficients);
            }
            if values.iter().all(|x| *x == 0.0) {
                return (Hazard::AttenuationUnset, coefficients);
            }
            return (Hazard::AttenuationAtLight, behind);
        }
        let at_light = behind.iter().any(|&at| self.role(at) == Role::Distance)
            || behind.iter().filter(|&&at| self.role(at).is_position()).count() > 1;
        if at_light {
            return (Hazard::AttenuationAtLight, behind);
        }
        (Hazard::DivisionByZero, behind)
    }

    /// Whether the numerator is a difference too: the ramp of a cone.
    fn clamped(&self, step: &TracedOperation) -> bool {
        let numerator = self.graph.step(step.operands[0].source);
        numerator.is_some_and(|(step, _)| step.operation == Operation::Sub)
    }

    fn overflow(&self, step: &TracedOperation) -> (Hazard, Vec<usize>) {
        let largest = largest(step);
        let x = |i: usize| step.operands[i].number;
        let single_zero = || x(1).single == 0.0 && x(1).double != 0.0;
        match step.operation {
            Operation::Pow if step.operands[0].number.single > 1.0 => {
                let near = step.operands[0].number.double < 1.0 + ABOVE_ONE.value;
                (if near { Hazard::BaseAboveOne } else { Hazard::LargeValues }, Vec::new())
            }
            Operation::Div if single_zero() || x(1).double.abs() < LENGTH.value * LENGTH.value => {
                let behind = self.graph.inputs_of([step.operands[1].source]);
                let negative = behind.iter().any(|&at| {
                    self.role(at).is_attenuation() && self.values(at).iter().any(|v| *v < 0.0)
                });
                let hazard = if negative { Hazard::NegativeAttenuation } else { Hazard::Underflow };
                (hazard, behind)
            }
            Operation::InverseRoot => (Hazard::Underflow, Vec::new()),
            Operation::Dot | Operation::Length | Operation::Distance | Operation::Normalize
                if largest > COORDINATE.value =>
            {
                (Hazard::Overflow, self.graph.inputs_of(Self::sources(step)))
            }
            Operation::Mul if self.is_square(step) => {
                (Hazard::Overflow, self.graph.inputs_of(Self::sources(step)))
            }
            _ => {
                let behind = self.graph.inputs_of(Self::sources(step));
                let positions =
                    behind.iter().filter(|&&at| self.role(at).is_position()).count() > 1;
                let distance = behind.iter().any(|&at| self.role(at) == Role::Distance);
                let hazard =
                    if positions || distance { Hazard::Overflow } else { Hazard::LargeValues };
                (hazard, behind)
            }
        }
    }

    fn is_square(&self, step: &TracedOperation) -> bool {
        step.operands[0].source == step.operands[1].source
    }

    /// Returns the first comparison that `f32` and `f64` decide differently.
    pub fn diverged(&self) -> Option<Candidate> {
        let decides = |step: &&TracedOperation| {
            matches!(step.operation, Operation::Compare(_))
                && step.results.iter().any(|n| f64::from(n.single) != n.double)
        };
        let step = self.graph.trace.steps.iter().find(decides)?;
        let about = self.graph.inputs_of(Self::sources(step));
        Some(self.candidate(step, Hazard::BranchDivergence, about, None))
    }

    /// Returns the operation that introduced the error of the worst component.
    pub fn inaccurate(
        &self,
        floats: &[(usize, usize)],
        called: &PureCallResult,
    ) -> Option<Candidate> {
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
        if undefined(step).is_some() {
            return None;
        }
        let (hazard, about) = self.loss(step);
        Some(self.candidate(step, hazard, about, None))
    }

    /// Returns the kind of loss of an operation with accurate operands and a wrong result.
    fn loss(&self, step: &TracedOperation) -> (Hazard, Vec<usize>) {
        let behind = || self.graph.inputs_of(Self::sources(step));
        let largest = largest(step);
        let result = step.results.first().copied().unwrap_or_default();
        match step.operation {
            Operation::Pow => {
                let [base, exponent] = [step.operands[0].number, step.operands[1].number];
                if base.single > 1.0 && base.double <= 1.0 + ABOVE_ONE.value {
                    (Hazard::BaseAboveOne, behind())
                } else if exponent.double.abs() >= EXPONENT.value {
                    (Hazard::LargeExponent, behind())
                } else {
                    (Hazard::AccumulatedError, behind())
                }
            }
            Operation::Exp => (Hazard::LargeExponent, behind()),
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
                (Hazard::Overflow, behind())
            }
            Operation::Length
            | Operation::Distance
            | Operation::Normalize
            | Operation::InverseRoot
            | Operation::Root
            | Operation::Mul
            | Operation::Div
                if smallest(step) < LENGTH.value || result.double.abs() < 1.0e-37 =>
            {
                (Hazard::Underflow, behind())
            }
            Operation::Add
            | Operation::Sub
            | Operation::Fma
            | Operation::Dot
            | Operation::Mix
            | Operation::Cross => {
                let behind = behind();
                let cone = behind.iter().any(|&at| self.role(at).is_cone());
                let far = largest > ORIGIN.value
                    && behind.iter().filter(|&&at| self.role(at).is_position()).count() > 0;
                if cone && (NARROW.value..4.0).contains(&largest) {
                    (Hazard::NarrowCone, behind)
                } else if far {
                    (Hazard::FarFromOrigin, behind)
                } else {
                    (Hazard::Cancellation, behind)
                }
            }
            Operation::SmoothStep => {
                let behind = behind();
                let cone = behind.iter().any(|&at| self.role(at).is_cone());
                match (cone, largest >= NARROW.value) {
                    (true, true) => (Hazard::NarrowCone, behind),
                    (true, false) => (Hazard::Cancellation, behind),
                    (false, _) => (Hazard::AccumulatedError, behind),
                }
            }
            _ => (Hazard::AccumulatedError, behind()),
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
