//! The hazard of an operation, by what the operation is and the roles of the inputs behind it.
//!
//! Asked by [`classify`](super) for operations without a defined value and for losses.

use super::{Candidate, Performed, undefined};
use crate::accuracy::stress::blame::Graph;
use crate::accuracy::stress::hazard as h;
use crate::accuracy::stress::hazard::Hazard;
use crate::accuracy::stress::input::{Sample, float};
use crate::accuracy::stress::role::Role;
use landfall_exec::harness::call::pure::PureCalled;
use landfall_exec::interp::{Number, Operation, Source, Step, UndefinedKind};

/// One sample with the graph of its operations.
pub(super) struct Look<'a> {
    pub graph: Graph<'a>,
    pub sample: &'a Sample,
}

/// The cosine of the half angle, 2.6 degrees, of what is called a narrow cone: of a wider one the
/// chord is hardly better than the cosine.
const NARROW: f64 = 0.999;

impl Look<'_> {
    fn candidate(
        &self,
        step: &Step,
        hazard: &'static Hazard,
        about: Vec<usize>,
        kind: Option<UndefinedKind>,
    ) -> Candidate {
        let worst = step.results.iter().max_by(|a, b| apart(a).total_cmp(&apart(b)));
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

    /// The values of an input.
    fn values(&self, at: usize) -> Vec<f32> {
        self.graph.inputs[at].range().map(|i| float(self.sample, i)).collect()
    }

    fn sources(step: &Step) -> Vec<Source> {
        step.operands.iter().map(|o| o.source).collect()
    }

    pub fn undefined(&self, step: &Step, kind: UndefinedKind) -> Candidate {
        use UndefinedKind as U;
        let (hazard, about) = match kind {
            U::NormalizeOfZero => self.zero_vector(&Self::sources(step)),
            U::DivisionByZero => self.division(step),
            U::PowOfZero => (&h::POWER_OF_ZERO, Vec::new()),
            U::PowOfNegative => (&h::POWER_OF_NEGATIVE, Vec::new()),
            U::SmoothStepEdges => {
                let (a, b) = (step.operands[0].number.double, step.operands[1].number.double);
                let hazard = if a == b { &h::EQUAL_CUT_OFFS } else { &h::SWAPPED_CUT_OFFS };
                (hazard, Vec::new())
            }
            U::RootOfNegative if step.operation == Operation::InverseRoot => {
                match self.squared(step.operands[0].source) {
                    Some(vector) if step.operands[0].number.double == 0.0 => {
                        self.zero_vector(&vector)
                    }
                    _ => (&h::UNDEFINED_OPERATION, Vec::new()),
                }
            }
            U::SquaresTooLarge => (&h::OVERFLOW, self.graph.inputs_of(Self::sources(step))),
            U::SquaresTooSmall => (&h::UNDERFLOW, self.graph.inputs_of(Self::sources(step))),
            U::BornInfinite | U::BornNan => self.overflow(step),
            U::ZeroTimesInfinity
            | U::RootOfNegative
            | U::LogOfNonPositive
            | U::ArcOutOfRange
            | U::AtanOfZeros
            | U::ClampBounds
            | U::Uninitialised
            | U::NanFromBuffer
            | U::IntegerDivisionByZero
            | U::IntegerOverflow
            | U::ShiftTooFar
            | U::BitsOutOfRange
            | U::ConversionOutOfRange
            | U::IndexOutOfBounds
            | U::PastEndOfBuffer => (&h::UNDEFINED_OPERATION, Vec::new()),
        };
        self.candidate(step, hazard, about, Some(kind))
    }

    /// The vector whose square, or the root of it, a number is.
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

    /// Why a vector is zero.
    fn zero_vector(&self, components: &[Source]) -> (&'static Hazard, Vec<usize>) {
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
                    let hazard = if view { &h::CAMERA_AT_FRAGMENT } else { &h::LIGHT_AT_FRAGMENT };
                    return (hazard, vec![b, a]);
                }
                if opposite {
                    return (&h::OPPOSITE_VECTORS, vec![b, a]);
                }
            }
        }
        let zero = |&&at: &&usize| self.values(at).iter().all(|x| *x == 0.0);
        match vectors.iter().find(zero) {
            Some(&at) if self.role(at) == Role::Axis => (&h::ZERO_DIRECTION, vec![at]),
            // In view space the eye is the origin.
            Some(&at) if self.role(at) == Role::FragmentPosition => {
                (&h::CAMERA_AT_FRAGMENT, vec![at])
            }
            Some(&at) => (&h::ZERO_VECTOR, vec![at]),
            None => (&h::ZERO_VECTOR, vectors),
        }
    }

    fn is_difference(&self, components: &[Source]) -> bool {
        components.iter().any(|source| {
            self.graph.step(*source).is_some_and(|(step, _)| step.operation == Operation::Sub)
        })
    }

    fn division(&self, step: &Step) -> (&'static Hazard, Vec<usize>) {
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
                        return (&h::EQUAL_CUT_OFFS, vec![a, b]);
                    }
                }
                [None, Some(b)] if sub.operands[0].number.double == 1.0 => {
                    return (&h::ZERO_WIDTH_CONE, vec![b]);
                }
                _ => {}
            }
            // Of angles, the cosines are computed here.
            let cones: Vec<usize> =
                behind.iter().copied().filter(|&at| self.role(at).is_cone()).collect();
            match cones.len() {
                0 => {}
                1 => return (&h::ZERO_WIDTH_CONE, cones),
                _ => return (&h::EQUAL_CUT_OFFS, cones),
            }
        }
        let coefficients: Vec<usize> =
            behind.iter().copied().filter(|&at| self.role(at).is_attenuation()).collect();
        if !coefficients.is_empty() {
            let values: Vec<f32> = coefficients.iter().flat_map(|&at| self.values(at)).collect();
            if values.iter().any(|x| *x < 0.0) {
                return (&h::NEGATIVE_ATTENUATION, coefficients);
            }
            if values.iter().all(|x| *x == 0.0) {
                return (&h::ATTENUATION_UNSET, coefficients);
            }
            return (&h::ATTENUATION_AT_LIGHT, behind);
        }
        let at_light = behind.iter().any(|&at| self.role(at) == Role::Distance)
            || behind.iter().filter(|&&at| self.role(at).is_position()).count() > 1;
        if at_light {
            return (&h::ATTENUATION_AT_LIGHT, behind);
        }
        (&h::DIVISION_BY_ZERO, behind)
    }

    /// Whether the numerator is a difference too: the ramp of a cone.
    fn clamped(&self, step: &Step) -> bool {
        let numerator = self.graph.step(step.operands[0].source);
        numerator.is_some_and(|(step, _)| step.operation == Operation::Sub)
    }

    fn overflow(&self, step: &Step) -> (&'static Hazard, Vec<usize>) {
        let largest = largest(step);
        let x = |i: usize| step.operands[i].number;
        let single_zero = || x(1).single == 0.0 && x(1).double != 0.0;
        match step.operation {
            Operation::Pow if step.operands[0].number.single > 1.0 => {
                let near = step.operands[0].number.double < 1.0 + 1.0e-5;
                (if near { &h::BASE_ABOVE_ONE } else { &h::LARGE_VALUES }, Vec::new())
            }
            Operation::Div if single_zero() || x(1).double.abs() < 1.0e-30 => {
                let behind = self.graph.inputs_of([step.operands[1].source]);
                let negative = behind.iter().any(|&at| {
                    self.role(at).is_attenuation() && self.values(at).iter().any(|v| *v < 0.0)
                });
                let hazard = if negative { &h::NEGATIVE_ATTENUATION } else { &h::UNDERFLOW };
                (hazard, behind)
            }
            Operation::InverseRoot => (&h::UNDERFLOW, Vec::new()),
            Operation::Dot | Operation::Length | Operation::Distance | Operation::Normalize
                if largest > 1.0e15 =>
            {
                (&h::OVERFLOW, self.graph.inputs_of(Self::sources(step)))
            }
            Operation::Mul if self.is_square(step) => {
                (&h::OVERFLOW, self.graph.inputs_of(Self::sources(step)))
            }
            _ => {
                let behind = self.graph.inputs_of(Self::sources(step));
                let positions =
                    behind.iter().filter(|&&at| self.role(at).is_position()).count() > 1;
                let distance = behind.iter().any(|&at| self.role(at) == Role::Distance);
                let hazard = if positions || distance { &h::OVERFLOW } else { &h::LARGE_VALUES };
                (hazard, behind)
            }
        }
    }

    fn is_square(&self, step: &Step) -> bool {
        step.operands[0].source == step.operands[1].source
    }

    /// The operation that spoilt the worst component.
    pub fn inaccurate(&self, floats: &[(usize, usize)], called: &PureCalled) -> Option<Candidate> {
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
        let guilty = self.graph.guilty(worst?.1)?;
        let step = &self.graph.trace.steps[guilty];
        // What has no defined value is a finding of its own.
        if undefined(step).is_some() {
            return None;
        }
        let (hazard, about) = self.loss(step);
        Some(self.candidate(step, hazard, about, None))
    }

    /// What kind of loss an operation is that had right operands and gave a wrong result.
    fn loss(&self, step: &Step) -> (&'static Hazard, Vec<usize>) {
        let behind = || self.graph.inputs_of(Self::sources(step));
        let largest = largest(step);
        let result = step.results.first().copied().unwrap_or_default();
        match step.operation {
            Operation::Pow => {
                let [base, exponent] = [step.operands[0].number, step.operands[1].number];
                if base.single > 1.0 && base.double <= 1.0 + 1.0e-5 {
                    (&h::BASE_ABOVE_ONE, behind())
                } else if exponent.double.abs() >= 16.0 {
                    (&h::LARGE_EXPONENT, behind())
                } else {
                    (&h::ACCUMULATED_ERROR, behind())
                }
            }
            Operation::Exp => (&h::LARGE_EXPONENT, behind()),
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
                if largest > 1.0e15 =>
            {
                (&h::OVERFLOW, behind())
            }
            Operation::Length
            | Operation::Distance
            | Operation::Normalize
            | Operation::InverseRoot
            | Operation::Root
            | Operation::Mul
            | Operation::Div
                if smallest(step) < 1.0e-15 || result.double.abs() < 1.0e-37 =>
            {
                (&h::UNDERFLOW, behind())
            }
            Operation::Add
            | Operation::Sub
            | Operation::Fma
            | Operation::Dot
            | Operation::Mix
            | Operation::Cross => {
                let behind = behind();
                let cone = behind.iter().any(|&at| self.role(at).is_cone());
                let far = largest > 1.0e3
                    && behind.iter().filter(|&&at| self.role(at).is_position()).count() > 0;
                if cone && (NARROW..4.0).contains(&largest) {
                    (&h::NARROW_CONE, behind)
                } else if far {
                    (&h::FAR_FROM_ORIGIN, behind)
                } else {
                    (&h::CANCELLATION, behind)
                }
            }
            Operation::SmoothStep => {
                let behind = behind();
                let cone = behind.iter().any(|&at| self.role(at).is_cone());
                match (cone, largest >= NARROW) {
                    (true, true) => (&h::NARROW_CONE, behind),
                    (true, false) => (&h::CANCELLATION, behind),
                    (false, _) => (&h::ACCUMULATED_ERROR, behind),
                }
            }
            _ => (&h::ACCUMULATED_ERROR, behind()),
        }
    }
}

fn largest(step: &Step) -> f64 {
    step.operands.iter().map(|o| o.number.double.abs()).fold(0.0, f64::max)
}

fn smallest(step: &Step) -> f64 {
    let magnitudes = step.operands.iter().map(|o| o.number.double.abs());
    magnitudes.filter(|x| *x > 0.0).fold(f64::INFINITY, f64::min)
}

fn apart(number: &Number) -> f64 {
    match (f64::from(number.single) - number.double).abs() {
        nan if nan.is_nan() => f64::INFINITY,
        off => off,
    }
}
