//! Checks each operation for hazards under the conditions that hold there.
//!
//! Called by [`expression`](super::expression) and [`walk`](super::walk). A guard that
//! [`abstract_domain`](super::abstract_domain) recognises prevents a report; where it cannot
//! decide, the report is *possible* only.

use super::graph::{GraphOp, Id, Leaf, Origin};
use super::memory::Value;
use super::walk::{Walk, WalkFrame};
use super::{Certainty, Hazard, Occurrence};
use crate::analysis::hazard::threshold::COSINE;
use crate::analysis::identifier;
use crate::analysis::roles::Role;
use crate::analysis::undefined::UndefinedKind;
use landfall_layout::source::{Language, Span};
use naga::{BinaryOperator as B, MathFunction as M};

/// A hazard that an enclosing selection may still rule out.
#[derive(Clone, Debug)]
pub struct Candidate {
    pub hazard: Occurrence,
    /// The operation that is undefined, and why, unless a selection excludes its operands.
    pub undefined: Option<(Id, UndefinedKind)>,
}

/// The number of latest hazards that a selection may rule out.
/// Enough for the operands of one `?:` or `select`; it keeps the work of each selection constant.
const MAX_RECONSIDERED: usize = 64;

impl<'m> Walk<'m> {
    pub fn report(
        &mut self,
        hazard: Hazard,
        certainty: Certainty,
        span: Span,
        about: String,
    ) -> &mut Candidate {
        let hazard = Occurrence::new(hazard, certainty, span, about);
        self.candidates.push(Candidate { hazard, undefined: None });
        self.candidates.last_mut().expect("just pushed")
    }

    /// Removes the hazards that cannot occur where the value is selected.
    pub fn reconsider(&mut self, chosen: Id) {
        // `d > 0.0 ? 1.0 / d : 0.0` evaluates `1 / d` as an operand before the selection is known:
        // under the condition of its side the candidate is examined again and withdrawn. In GLSL
        // `?:` and in WGSL `select` the other operand has no effect on the result.
        let mut met = Vec::new();
        let latest = self.candidates.len().saturating_sub(MAX_RECONSIDERED);
        for (index, candidate) in self.candidates.iter().enumerate().skip(latest) {
            let Some((node, kind)) = candidate.undefined else { continue };
            let is_chosen = self.graph.contains(chosen, &mut |id| id == node);
            // Still undefined for the same reason under the condition: it stays.
            if is_chosen && self.undefined(node) != Some(kind) {
                met.push(index);
            }
        }
        for index in met.into_iter().rev() {
            self.candidates.remove(index);
        }
    }

    pub fn look_at_math(&mut self, fun: M, args: &[Id], id: Id, span: Span, wide: bool) {
        match (fun, args) {
            (M::Normalize, &[v]) => {
                if wide && self.is_wide_normal(v) {
                    let about = String::new();
                    self.report(Hazard::Vec4Normalise, Certainty::Likely, span, about);
                }
                self.check_direction(v, id, span);
            }
            // `v * inversesqrt(dot(v, v))` is a `normalize` written out.
            (M::InverseSqrt, &[square]) => match self.square_of(square) {
                Some(v) => self.check_direction(v, id, span),
                None => self.look_at_operand(fun, args, id, span),
            },
            (M::Pow, &[base, exponent]) => self.look_at_power(base, exponent, id, span),
            // `reflect` assumes a unit normal: the highlight takes its length squared (GLSL 4.60
            // §8.5).
            (M::Reflect, &[_, normal]) => self.check_normal(normal, Certainty::Likely, span),
            // A diffuse term is only darker for it.
            (M::Dot, &[a, b]) if a != b => {
                self.check_normal(a, Certainty::Possible, span);
                self.check_normal(b, Certainty::Possible, span);
            }
            (M::SmoothStep, &[low, high, x]) => {
                // `smoothstep(outer, inner, theta)` is undefined for equal edges (GLSL 4.60 §8.3).
                let cones = [low, high].map(|edge| self.cone(edge));
                if let [Some(about), Some(_)] = cones {
                    let sure = Certainty::Possible;
                    self.report(Hazard::EqualCutOffs, sure, span, about.clone());
                    if self.is_cosine(x) {
                        self.report(Hazard::NarrowCone, sure, span, about);
                    }
                } else {
                    self.look_at_comparison(x, low, span);
                    self.look_at_operand(fun, args, id, span);
                }
            }
            // `step(edge, x)` is the hard cone of `theta > cutoff`.
            (M::Step, &[edge, x]) => self.look_at_comparison(x, edge, span),
            _ => self.look_at_operand(fun, args, id, span),
        }
    }

    pub fn look_at_binary(&mut self, op: B, a: Id, b: Id, id: Id, span: Span) {
        match op {
            B::Divide => self.look_at_division(a, b, id, span),
            // Either side may be the cosine: `theta > cutOff`, `cutOff < theta`.
            B::Less | B::LessEqual | B::Greater | B::GreaterEqual => {
                self.look_at_comparison(a, b, span);
                self.look_at_comparison(b, a, span);
            }
            B::Subtract => {
                // `theta - outerCutOff`: near the axis both are 1 less a few digits.
                if let (true, Some(about)) = (self.is_cosine(a), self.cone(b)) {
                    self.report_cone(about, span);
                }
                if self.is_compensation(a, b) && !self.setting.precise {
                    let (hazard, sure) = (Hazard::KahanWithoutPrecise, Certainty::Certain);
                    self.report(hazard, sure, span, String::new());
                }
            }
            _ => {}
        }
    }

    /// Reports a sum whose variable is not initialised. `span` is the sum.
    pub fn check_store(
        &mut self,
        frame: &WalkFrame<'m>,
        to: &Value,
        value: Id,
        span: Option<Span>,
    ) {
        // Variables of WGSL start as zero (WGSL §7.3); those of GLSL are undefined (GLSL 4.60
        // §4.3).
        let (Language::Glsl, Some(span)) = (self.setting.language, span) else { return };
        let Value::At(cell, _) = to else { return };
        let before = self.load(to, None);
        let undefined = |id: Id| matches!(self.graph.op(id), GraphOp::Undefined(_));
        // In a loop the variable is undefined if it was so before the first iteration.
        let nothing = match self.graph.op(before) {
            GraphOp::Undefined(_) => true,
            GraphOp::Looping(_) => undefined(self.graph.args(before)[0]),
            _ => false,
        };
        // Only `x = x + ...`, to which the old value belongs; a plain store overwrites it.
        if !nothing || !self.is_summand(before, value, 0) {
            return;
        }
        let local = cell.checked_sub(frame.locals);
        let mut locals = frame.function.local_variables.iter();
        let name = local.and_then(|local| locals.nth(local)).and_then(|(_, v)| v.name.clone());
        let about = name.unwrap_or_default();
        self.report(Hazard::Uninitialised, Certainty::Certain, span, about);
    }

    fn is_summand(&self, of: Id, sum: Id, depth: u32) -> bool {
        let Some((a, b)) = self.graph.binary(sum, B::Add) else { return false };
        depth < 16 && [a, b].into_iter().any(|id| id == of || self.is_summand(of, id, depth + 1))
    }

    /// Reports a normalised vector that may be zero.
    fn check_direction(&mut self, v: Id, id: Id, span: Span) {
        let Some(undefined) = self.undefined(id) else { return };
        if let Some((hazard, about)) = self.difference(v).or_else(|| self.half_vector(v)) {
            let candidate = self.report(hazard, Certainty::Possible, span, about);
            candidate.undefined = Some((id, undefined));
        } else if self.is_sum(v) {
            let kind = UndefinedKind::NormalizeOfZero;
            self.report_undefined(id, kind, Certainty::Possible, span);
        }
    }

    /// Returns the hazard and the path of a point if a vector is the difference of two points of
    /// which one is a light or the camera.
    fn difference(&self, v: Id) -> Option<(Hazard, String)> {
        let (a, b) = self.graph.binary(self.graph.underlying_value(v), B::Subtract)?;
        // `light.position - p` and `eye - p`, either way round. The other operand must vary: the
        // difference of two uniforms is a matter of the host.
        let position = |leaf: &Leaf| leaf.role == Some(Role::Position);
        let camera = |leaf: &Leaf| {
            let said = identifier::identifier_words(&leaf.name);
            let says = |any: &[&str]| said.iter().any(|word| any.contains(&word.as_str()));
            leaf.origin != Origin::Interpolated && says(&["view", "camera", "cam", "eye"])
        };
        let find = |wanted: &dyn Fn(&Leaf) -> bool| {
            let one_of = |one, other| {
                let leaf = self.graph.leaf_below(one, wanted)?;
                self.varies(other).then(|| leaf.path.clone())
            };
            one_of(a, b).or_else(|| one_of(b, a))
        };
        find(&position)
            .map(|path| (Hazard::LightAtFragment, path))
            .or_else(|| find(&camera).map(|path| (Hazard::CameraAtFragment, path)))
    }

    /// Returns the hazard if a vector is the sum of two directions, which may be opposite.
    fn half_vector(&self, v: Id) -> Option<(Hazard, String)> {
        // The sum of two unit vectors is zero where they are opposite. Of other sums nothing of
        // the kind is known.
        let (a, b) = self.graph.binary(self.graph.underlying_value(v), B::Add)?;
        let are_directions = self.facts(a).unit && self.facts(b).unit;
        are_directions.then(|| (Hazard::OppositeVectors, String::new()))
    }

    /// Returns the vector whose squared length, or length, a value is.
    fn square_of(&self, id: Id) -> Option<Id> {
        // d^2 as `dot(d, d)`, |d|, and powers and roots of these: any of them divides by zero
        // where d is zero.
        match (self.graph.op(id), self.graph.args(id)) {
            (GraphOp::Math(M::Dot), &[a, b]) if a == b => Some(a),
            (GraphOp::Math(M::Length), &[v]) => Some(v),
            (GraphOp::Math(M::Pow), &[x, _]) | (GraphOp::Math(M::Sqrt), &[x]) => self.square_of(x),
            (GraphOp::Binary(B::Multiply), &[a, b]) if a == b => self.square_of(a),
            _ => None,
        }
    }

    fn look_at_division(&mut self, above: Id, below: Id, id: Id, span: Span) {
        let Some(undefined) = self.undefined(id) else { return };
        let weakens = |leaf: &Leaf| leaf.role.is_some_and(Role::is_attenuation);
        let cone = |leaf: &Leaf| leaf.role.is_some_and(Role::is_cone);
        // `1 / (4 pi d^2)`: constant factors do not make it zero.
        let square = self.without_factors(below);
        let (hazard, about) = if let Some(v) = self.square_of(square) {
            // A vector over its own length is a normalisation; another numerator over it is a
            // falloff.
            let of_vector = (v == above).then(|| self.half_vector(v)).flatten();
            match (self.difference(v).or(of_vector), v == above) {
                (Some(found), true) => found,
                (Some((Hazard::LightAtFragment, about)), false) => {
                    (Hazard::AttenuationAtLight, about)
                }
                _ => return self.report_undefined(id, undefined, Certainty::Possible, span),
            }
        } else if let Some(leaf) = {
            // The constant term decides whether it is zero at the light; any other coefficient
            // says that it is an attenuation.
            let first = |leaf: &Leaf| leaf.role == Some(Role::Constant);
            let first = self.graph.leaf_below(below, &first);
            first.or_else(|| self.graph.leaf_below(below, &weakens))
        } {
            (Hazard::AttenuationUnset, leaf.path.clone())
        } else if let Some(leaf) = self.graph.leaf_below(below, &cone) {
            // `inner - outer`, or `1 - cutoff`.
            let Some((a, b)) = self.graph.binary(below, B::Subtract) else { return };
            let both = [a, b].iter().all(|&id| self.graph.leaf_below(id, &cone).is_some());
            (if both { Hazard::EqualCutOffs } else { Hazard::ZeroWidthCone }, leaf.path.clone())
        } else if self.is_square(square) {
            // Of other quotients only those by a square are told: that is where zero is likely,
            // and the rest would be noise.
            return self.report_undefined(id, undefined, Certainty::Possible, span);
        } else {
            return;
        };
        let candidate = self.report(hazard, Certainty::Possible, span, about);
        candidate.undefined = Some((id, undefined));
    }

    fn look_at_comparison(&mut self, a: Id, b: Id, span: Span) {
        if !self.is_cosine(a) {
            return;
        }
        if let Some(about) = self.cone(b) {
            self.report_cone(about, span);
            return;
        }
        // A literal beyond any cosine but within a turn is an angle in degrees; `cos(12.5)` takes
        // degrees for radians.
        let degrees = match (self.graph.op(b), self.graph.args(b)) {
            (GraphOp::Number(_), _) => {
                self.graph.value(b).filter(|number| (COSINE.value..=360.0).contains(&number.abs()))
            }
            // No cone is wider than pi radians.
            (GraphOp::Math(M::Cos), &[angle]) => {
                self.graph.value(angle).filter(|number| number.abs() > std::f64::consts::PI)
            }
            _ => None,
        };
        if degrees.is_some() {
            let (hazard, sure) = (Hazard::ConeOutOfRange, Certainty::Certain);
            self.report(hazard, sure, span, String::new()).hazard.number = degrees;
        }
    }

    /// Reports a cosine that is compared with, or subtracted from, what a light's cone is given by.
    fn report_cone(&mut self, about: String, span: Span) {
        self.report(Hazard::NarrowCone, Certainty::Possible, span, about.clone());
        // Its name or comment may show that it is in degrees.
        self.report(Hazard::ConeOutOfRange, Certainty::Possible, span, about);
    }

    /// Returns whether a value is the cosine of two directions.
    fn is_cosine(&self, id: Id) -> bool {
        // A clamped or negated cosine is a cosine.
        let id = match (self.graph.op(id), self.graph.args(id)) {
            (GraphOp::Math(M::Max | M::Clamp | M::Saturate), &[of, ..]) => of,
            (GraphOp::Negate, &[of]) => of,
            _ => id,
        };
        match (self.graph.op(id), self.graph.args(id)) {
            (GraphOp::Math(M::Dot), &[a, b]) => {
                // Without knowing that both are unit vectors: one of them with the direction of a
                // light is what cones are written with.
                let directed =
                    || self.graph.leaf_below(id, &|l| l.role == Some(Role::Direction)).is_some();
                let units = u32::from(self.facts(a).unit) + u32::from(self.facts(b).unit);
                a != b && (units == 2 || units == 1 && directed())
            }
            _ => false,
        }
    }

    /// Returns the path of a cone's angle, or its cosine, if the value is nothing else.
    fn cone(&self, id: Id) -> Option<String> {
        let leaf = self.graph.bare_leaf(id)?;
        leaf.role.is_some_and(Role::is_cone).then(|| leaf.path.clone())
    }

    fn look_at_power(&mut self, base: Id, exponent: Id, id: Id, span: Span) {
        let Some(dot) = self.dot_in(base, 0) else { return };
        // Without a clamp around it the dot product itself is the base, and may be negative.
        let bare = dot == base;
        if let &[a, b] = self.graph.args(dot) {
            self.check_normal(a, Certainty::Likely, span);
            self.check_normal(b, Certainty::Likely, span);
        }
        self.note_power(base, id, span);
        // The exponent's name, as in `material.shininess`, tells a reader which input to look at.
        let about = self.graph.leaf_below(exponent, &|_| true).map(|leaf| leaf.path.clone());
        let about = about.unwrap_or_default();
        let Some(undefined) = self.undefined(id) else { return };
        let is_likely = match undefined {
            UndefinedKind::PowOfNegative => bare,
            // An exponent of which a bound is known may be zero in practice; one of which nothing
            // is known is the host's.
            _ => self.facts(exponent).low.is_finite(),
        };
        let sure = if is_likely { Certainty::Likely } else { Certainty::Possible };
        self.report(undefined.hazard(), sure, span, about).undefined = Some((id, undefined));
    }

    /// Returns the dot product that a value is, possibly clamped or shifted.
    fn dot_in(&self, id: Id, depth: u32) -> Option<Id> {
        // Generated code nests deeper than any highlight.
        if depth > 8 {
            return None;
        }
        let constant = |id: Id| self.graph.value(id).is_some();
        match (self.graph.op(id), self.graph.args(id)) {
            (GraphOp::Math(M::Dot), &[a, b]) => (a != b).then_some(id),
            (GraphOp::Math(M::Max | M::Min | M::Clamp | M::Saturate | M::Abs), args) => {
                args.iter().find_map(|&arg| self.dot_in(arg, depth + 1))
            }
            (GraphOp::Convert | GraphOp::Negate, &[of]) => self.dot_in(of, depth + 1),
            (GraphOp::Chosen, &[_, a, b]) => {
                self.dot_in(a, depth + 1).or_else(|| self.dot_in(b, depth + 1))
            }
            // `0.5 * dot(n, l) + 0.5`, the wrapped diffuse term, and scaled products.
            (GraphOp::Binary(B::Add | B::Subtract | B::Multiply), &[a, b]) if constant(a) => {
                self.dot_in(b, depth + 1)
            }
            (GraphOp::Binary(B::Add | B::Subtract | B::Multiply), &[a, b]) if constant(b) => {
                self.dot_in(a, depth + 1)
            }
            _ => None,
        }
    }

    /// Reports an interpolated normal that was not normalised.
    fn check_normal(&mut self, id: Id, sure: Certainty, span: Span) {
        let Some(leaf) = self.graph.bare_leaf(id) else { return };
        if leaf.origin != Origin::Interpolated {
            return;
        }
        let said = identifier::identifier_words(&leaf.name);
        // Interpolation shortens a normal (the chord of an arc); the name is the only evidence of
        // it being one.
        if said.iter().any(|word| ["normal", "normals", "norm", "nrm"].contains(&word.as_str())) {
            let about = leaf.path.clone();
            self.report(Hazard::UnnormalisedNormal, sure, span, about);
        }
    }

    /// Returns whether a vector is a direction times a transposed matrix of four columns, including
    /// its fourth component.
    fn is_wide_normal(&self, v: Id) -> bool {
        // `transpose(inverse(m)) * vec4(n, 0.0)`, normalised as a `vec4`.
        let Some((matrix, vector)) = self.graph.binary(v, B::Multiply) else { return false };
        let last = match self.graph.op(vector) {
            GraphOp::Compose => self.graph.args(vector).last().copied(),
            _ => None,
        };
        let is_direction = last.and_then(|w| self.graph.value(w)) == Some(0.0);
        is_direction && self.graph.contains(matrix, &mut |id| self.graph.is_math(id, M::Transpose))
    }

    /// Returns whether a value is `(t - s) - y` where `t` is `s + y`.
    fn is_compensation(&self, a: Id, y: Id) -> bool {
        // c = (t - s) - y in Kahan's sum, which is 0 in real numbers, so that a compiler may drop
        // it.
        let Some((t, s)) = self.graph.binary(a, B::Subtract) else { return false };
        let Some((p, q)) = self.graph.binary(t, B::Add) else { return false };
        (p == s && q == y) || (p == y && q == s)
    }
}
