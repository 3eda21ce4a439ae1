//! The known facts about a value: its range, whether it can be zero, whether it is a unit vector.
//!
//! Computed from the [`graph`](super::graph) under the conditions that hold at a point.

use naga::{BinaryOperator as B, MathFunction as M};
use rustc_hash::FxHashMap;

use super::graph::{Graph, GraphOp, Id};
use crate::analysis::roles::Role;

/// The excess above 1 that rounding causes in the dot product of two unit vectors.
const ROUNDING: f64 = 4.0e-7;

/// The facts about a number, or about every component of a vector.
/// An interval with two flags, which is all that the guards of lighting code show: `max(x, c)`,
/// `clamp`, a test against zero, `normalize`. Infinite ends mean that nothing is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facts {
    pub low: f64,
    pub high: f64,
    /// Never zero; for a vector, never of length zero.
    pub nonzero: bool,
    /// A vector of length 1, or 0.
    pub unit: bool,
}

impl Facts {
    pub const NOTHING: Facts =
        Facts { low: f64::NEG_INFINITY, high: f64::INFINITY, nonzero: false, unit: false };

    pub fn between(low: f64, high: f64) -> Facts {
        Facts { low, high, nonzero: low > 0.0 || high < 0.0, unit: false }
    }

    pub fn at_least(low: f64) -> Facts {
        Facts::between(low, f64::INFINITY)
    }

    pub fn number(value: f64) -> Facts {
        Facts::between(value, value)
    }

    /// Returns the facts that hold for either of two values.
    pub fn or(self, other: Facts) -> Facts {
        // The join of a lattice: what both branches guarantee.
        Facts {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            nonzero: self.nonzero && other.nonzero,
            unit: self.unit && other.unit,
        }
    }

    /// Returns the facts that hold if both do.
    pub fn and(self, other: Facts) -> Facts {
        // The meet: facts from a value and from a condition on it hold together.
        Facts {
            low: self.low.max(other.low),
            high: self.high.min(other.high),
            nonzero: self.nonzero || other.nonzero,
            unit: self.unit || other.unit,
        }
        .settled()
    }

    /// Above zero.
    fn is_positive(self) -> bool {
        self.nonzero && self.low >= 0.0
    }

    fn nonzero_if(mut self, so: bool) -> Facts {
        self.nonzero |= so;
        self
    }

    fn settled(mut self) -> Facts {
        self.nonzero |= self.low > 0.0 || self.high < 0.0;
        self
    }
}

/// A query: the graph, the assumed conditions, and the facts already known.
pub struct Query<'g> {
    pub graph: &'g Graph,
    pub assumed: &'g [(Id, Facts)],
    pub settled: &'g FxHashMap<Id, Facts>,
    memo: FxHashMap<Id, Facts>,
    left: u32,
}

impl<'g> Query<'g> {
    pub fn new(
        graph: &'g Graph,
        assumed: &'g [(Id, Facts)],
        settled: &'g FxHashMap<Id, Facts>,
    ) -> Query<'g> {
        // A query visits 400 nodes, then knows nothing more: expressions of generated shaders
        // share nodes in depth, and a fact that needs more is no guard that a person wrote.
        Query { graph, assumed, settled, memo: FxHashMap::default(), left: 400 }
    }

    pub fn facts_of(&mut self, id: Id) -> Facts {
        if let Some(known) = self.memo.get(&id) {
            return *known;
        }
        if self.left == 0 {
            return Facts::NOTHING;
        }
        self.left -= 1;
        // A joined value's facts were computed with the conditions of its branches, which no
        // longer hold here.
        let own = match self.settled.get(&id) {
            Some(settled) => *settled,
            None => self.computed(id),
        };
        // Assumptions accumulate: an inner condition adds to that of an outer one.
        let assumed = self.assumed.iter().filter(|(on, _)| *on == id);
        let facts = assumed.fold(own, |facts, (_, more)| facts.and(*more)).settled();
        self.memo.insert(id, facts);
        facts
    }

    fn computed(&mut self, id: Id) -> Facts {
        let args = self.graph.args(id);
        match (self.graph.op(id), args) {
            (GraphOp::Number(bits), _) => Facts::number(f64::from_bits(bits)),
            (GraphOp::Leaf(_), _) => match self.graph.as_leaf(id).and_then(|leaf| leaf.role) {
                // What a host uploads is taken for sensible there, or every attenuation would be
                // reported. A light that strengthens with distance is the program's fault.
                Some(role) if role.is_attenuation() || role == Role::Range => Facts::at_least(0.0),
                _ => Facts::NOTHING,
            },
            (GraphOp::Joined(_), args) if !args.is_empty() => {
                let all: Vec<Facts> = args.iter().map(|&arg| self.facts_of(arg)).collect();
                all.into_iter().reduce(Facts::or).unwrap_or(Facts::NOTHING)
            }
            (GraphOp::Chosen, &[_, accept, reject]) => {
                self.facts_of(accept).or(self.facts_of(reject))
            }
            (GraphOp::Part(_) | GraphOp::Swizzle(_) | GraphOp::Element, &[of, ..]) => {
                let of = self.facts_of(of);
                // Components of a vector that is not zero may be zero themselves. Equal
                // components, as in `vec3(0.5)`, are one number.
                let constant = of.low == of.high;
                Facts { nonzero: constant && of.nonzero, unit: false, ..of }.settled()
            }
            (GraphOp::Compose, args) if !args.is_empty() => {
                let all: Vec<Facts> = args.iter().map(|&arg| self.facts_of(arg)).collect();
                // For a vector `nonzero` means its length: one component that is not zero is
                // enough.
                let nonzero = all.iter().any(|facts| facts.nonzero);
                let whole = all.into_iter().reduce(Facts::or).unwrap_or(Facts::NOTHING);
                Facts { nonzero, unit: false, ..whole }
            }
            (GraphOp::Convert, &[of]) => self.facts_of(of),
            (GraphOp::Negate, &[of]) => {
                let of = self.facts_of(of);
                Facts { low: -of.high, high: -of.low, ..of }
            }
            (GraphOp::Binary(op), &[a, b]) => self.binary(op, a, b),
            (GraphOp::Math(fun), args) => self.math(fun, args),
            _ => Facts::NOTHING,
        }
    }

    fn binary(&mut self, op: B, a: Id, b: Id) -> Facts {
        let (x, y) = (self.facts_of(a), self.facts_of(b));
        match op {
            B::Add => {
                // A sum is above zero where both are not negative and one is not zero.
                let positive = x.low >= 0.0 && y.low >= 0.0 && (x.nonzero || y.nonzero);
                Facts::between(x.low + y.low, x.high + y.high).nonzero_if(positive)
            }
            B::Subtract if a == b => Facts::number(0.0),
            B::Subtract => Facts::between(x.low - y.high, x.high - y.low),
            B::Multiply if a == b => {
                // A square by its own rule: the product of [-1, 1] with itself would be [-1, 1].
                let most = times(x.low, x.low).max(times(x.high, x.high));
                let least = if x.low <= 0.0 && x.high >= 0.0 {
                    0.0
                } else {
                    times(x.low, x.low).min(times(x.high, x.high))
                };
                Facts { nonzero: x.nonzero, ..Facts::between(least, most) }
            }
            B::Multiply => {
                let corners = [
                    times(x.low, y.low),
                    times(x.low, y.high),
                    times(x.high, y.low),
                    times(x.high, y.high),
                ];
                let low = corners.into_iter().fold(f64::INFINITY, f64::min);
                let high = corners.into_iter().fold(f64::NEG_INFINITY, f64::max);
                let unit = self.scaled_to_unit(a, b) || self.scaled_to_unit(b, a);
                Facts { nonzero: x.nonzero && y.nonzero, unit, low, high }
            }
            B::Divide => {
                let unit = self.is_length(b, a);
                // The sign is all that is kept: a divisor near zero leaves no bound.
                let sign = if x.low >= 0.0 && y.low >= 0.0 {
                    Facts::at_least(0.0)
                } else {
                    Facts::NOTHING
                };
                // Zero over anything is zero; the converse holds up to underflow.
                Facts { nonzero: x.nonzero, unit, ..sign }
            }
            _ => Facts::NOTHING,
        }
    }

    /// Whether a value is the length of a vector.
    fn is_length(&self, id: Id, v: Id) -> bool {
        // `v / length(v)` and `v / sqrt(dot(v, v))` are the definition of `normalize`.
        match (self.graph.op(id), self.graph.args(id)) {
            (GraphOp::Math(M::Length), &[of]) => of == v,
            (GraphOp::Math(M::Sqrt), &[square]) => {
                self.graph.is_math(square, M::Dot) && self.graph.args(square) == [v, v]
            }
            _ => false,
        }
    }

    /// Recognises `v * inversesqrt(dot(v, v))`, with or without a guard of the square.
    fn scaled_to_unit(&self, v: Id, scale: Id) -> bool {
        if !self.graph.is_math(scale, M::InverseSqrt) {
            return false;
        }
        let square = self.graph.args(scale)[0];
        let is_square = |id: Id| self.graph.is_math(id, M::Dot) && self.graph.args(id) == [v, v];
        is_square(square)
            || (self.graph.is_math(square, M::Max)
                && self.graph.args(square).iter().any(|&arg| is_square(arg)))
    }

    fn math(&mut self, fun: M, args: &[Id]) -> Facts {
        match (fun, args) {
            (M::Abs, &[x]) => {
                let x = self.facts_of(x);
                // [-x.high, -x.low] where the interval is negative, from 0 where it has both
                // signs.
                let low = if x.low > 0.0 { x.low } else { (-x.high).max(0.0) };
                let most = x.low.abs().max(x.high.abs());
                Facts { nonzero: x.nonzero, ..Facts::between(low, most) }
            }
            (M::Max, &[a, b]) => {
                let (a, b) = (self.facts_of(a), self.facts_of(b));
                // `max(x, 1e-4)` is the usual guard: above zero if one of the two is.
                let whole = Facts::between(a.low.max(b.low), a.high.max(b.high));
                whole.nonzero_if(a.is_positive() || b.is_positive())
            }
            (M::Min, &[a, b]) => {
                let (a, b) = (self.facts_of(a), self.facts_of(b));
                let whole = Facts::between(a.low.min(b.low), a.high.min(b.high));
                whole.nonzero_if(a.is_positive() && b.is_positive())
            }
            (M::Clamp, &[x, low, high]) => {
                let (x, low, high) = (self.facts_of(x), self.facts_of(low), self.facts_of(high));
                // `clamp(x, 1e-4, 1)` guards like `max`, as long as the upper bound is above zero,
                // too.
                let positive = (x.is_positive() || low.is_positive()) && high.is_positive();
                let low = x.low.max(low.low).min(high.high);
                Facts::between(low, x.high.min(high.high).max(low)).nonzero_if(positive)
            }
            (M::Saturate, &[x]) => {
                let x = self.facts_of(x);
                let whole = Facts::between(x.low.clamp(0.0, 1.0), x.high.clamp(0.0, 1.0));
                whole.nonzero_if(x.is_positive())
            }
            (M::SmoothStep | M::Step, _) => Facts::between(0.0, 1.0),
            (M::Fract, _) => Facts::between(0.0, 1.0),
            (M::Sin | M::Cos, _) => Facts::between(-1.0, 1.0),
            // Above zero in real numbers; `exp(-104)` is 0 in `f32`, which is not followed.
            (M::Exp | M::Exp2, _) => Facts { nonzero: true, ..Facts::at_least(0.0) },
            (M::Sqrt, &[x]) => {
                let x = self.facts_of(x);
                let low = x.low.max(0.0).sqrt();
                Facts { nonzero: x.nonzero, ..Facts::between(low, x.high.max(0.0).sqrt()) }
            }
            (M::InverseSqrt, _) => Facts { nonzero: true, ..Facts::at_least(0.0) },
            (M::Length | M::Distance, args) => {
                let nonzero = fun == M::Length && self.facts_of(args[0]).nonzero;
                Facts { nonzero, ..Facts::at_least(0.0) }
            }
            (M::Dot, &[a, b]) if a == b => {
                let v = self.facts_of(a);
                // Squared unit length; the rounding of `normalize` may lift it above 1.
                let high = if v.unit { 1.0 + ROUNDING } else { f64::INFINITY };
                Facts { nonzero: v.nonzero, ..Facts::between(0.0, high) }
            }
            // A cosine.
            (M::Dot, &[a, b]) => match self.facts_of(a).unit && self.facts_of(b).unit {
                true => Facts::between(-1.0 - ROUNDING, 1.0 + ROUNDING),
                false => Facts::NOTHING,
            },
            (M::Normalize, _) => Facts { unit: true, nonzero: true, ..Facts::between(-1.0, 1.0) }
                .within_a_unit_vector(),
            (M::Reflect, &[i, n]) => {
                let unit = self.facts_of(i).unit && self.facts_of(n).unit;
                Facts { unit, ..Facts::NOTHING }
            }
            (M::FaceForward, &[n, ..]) => {
                let n = self.facts_of(n);
                Facts { unit: n.unit, nonzero: n.nonzero, ..Facts::NOTHING }
            }
            (M::Pow, &[x, _]) => {
                let x = self.facts_of(x);
                // `pow` of a negative base is undefined (GLSL 4.60 §8.2), so nothing follows from
                // it.
                let positive = Facts::at_least(0.0).nonzero_if(x.is_positive());
                if x.low >= 0.0 { positive } else { Facts::NOTHING }
            }
            (M::Mix, &[a, b, t]) => {
                let t = self.facts_of(t);
                // `mix` between the two only for a weight in [0, 1]; else it extrapolates.
                let inside = t.low >= 0.0 && t.high <= 1.0;
                let both = self.facts_of(a).or(self.facts_of(b));
                if inside {
                    Facts { unit: false, nonzero: false, ..both }.settled()
                } else {
                    Facts::NOTHING
                }
            }
            (M::Radians | M::Degrees, &[x]) => {
                let x = self.facts_of(x);
                let scale = if fun == M::Radians { 1f64.to_radians() } else { 1f64.to_degrees() };
                Facts { low: x.low * scale, high: x.high * scale, nonzero: x.nonzero, unit: false }
            }
            _ => Facts::NOTHING,
        }
    }
}

impl Facts {
    /// Components of a unit vector lie in [-1, 1], and zero is among them.
    fn within_a_unit_vector(self) -> Facts {
        Facts { low: -1.0 - ROUNDING, high: 1.0 + ROUNDING, ..self }
    }
}

/// 0 times anything is 0: infinity here means "as large as may be".
fn times(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 { 0.0 } else { a * b }
}
