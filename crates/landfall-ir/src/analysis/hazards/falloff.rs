//! Whether the light of an array of lights ends where a scene says: by intervals over the symbolic
//! values of the entry point.
//!
//! An element of the array must reach the outputs only as a term that loops add up, and that term
//! must be exactly zero, in every `f32` evaluation, for a light of given numbers at given
//! distances. Code that is not understood makes the result unknown, and nothing is proved.

mod dependence;

use naga::{BinaryOperator as B, MathFunction as M};
use rustc_hash::{FxHashMap, FxHashSet};

pub use dependence::LightArray;

use super::graph::{Graph, GraphOp, Id};
use super::walk::{ControlRecord, Walk};
use super::{HazardSetting, Source};
use crate::Module;
use crate::analysis::roles::{LightBinding, Role};
use dependence::Dependence;
use landfall_layout::{Diagnostic, Options};

/// An interval of the values of all components.
type Span = [f64; 2];

const ANY: Span = [f64::NEG_INFINITY, f64::INFINITY];
const ZERO: Span = [0.0, 0.0];

/// The relative error of any operation here in `f32`. A quotient is widened twice, as a product
/// with a reciprocal, which covers its 2.5 ULP.
const ROUNDING: f64 = 1.0 / (1 << 22) as f64;

/// A light that is left out: its numbers and its distance.
#[derive(Clone, Copy)]
pub struct FalloffNumbers<'a> {
    /// The least and greatest component of a member by its role; `None` if it is unknown.
    pub of: &'a dyn Fn(Role) -> Option<[f64; 2]>,
    /// The least and greatest distance from the fragment.
    pub distance: [f64; 2],
}

/// The terms by which an array of lights reaches the outputs of a fragment stage.
#[derive(Debug)]
pub struct FalloffTerms {
    graph: Graph,
    outputs: Vec<Id>,
    control: ControlRecord,
    /// The name of the input with the fragment's position.
    position: String,
    cut_short: bool,
}

/// Follows the values of a fragment stage with these lights; `position` is the input that holds the
/// fragment's position.
///
/// # Errors
/// The errors in the shader, or the constructs that are not supported.
pub fn terms(
    source: &Source,
    options: &Options,
    lights: &[LightBinding<'_>],
    position: &str,
) -> Result<FalloffTerms, Vec<Diagnostic>> {
    let module = Module::new(source, options)?;
    let setting = HazardSetting { language: source.language, fragment: true, precise: false };
    let position = position.to_string();
    crate::stack::over_shader(|| {
        let mut walk = Walk::new(&module, lights, setting);
        let mut outputs = Vec::new();
        for entry in &module.ir.entry_points {
            if entry.stage == naga::ShaderStage::Fragment {
                outputs.extend(walk.root(&entry.function, true));
            }
        }
        let cut_short = walk.is_cut_short() || walk.control.too_deep;
        Ok(FalloffTerms { graph: walk.graph, outputs, control: walk.control, position, cut_short })
    })
}

impl FalloffTerms {
    pub fn of_array<'t>(&'t self, array: LightArray<'t>) -> ArrayTerms<'t> {
        ArrayTerms { terms: self, dependence: Dependence::new(self, array) }
    }
}

/// The terms of the lights of one array.
#[derive(Debug)]
pub struct ArrayTerms<'t> {
    terms: &'t FalloffTerms,
    dependence: Dependence<'t>,
}

impl ArrayTerms<'_> {
    /// Whether a light of the array adds exactly zero to every output if it has those numbers.
    pub fn adds_zero(&mut self, numbers: &FalloffNumbers<'_>) -> bool {
        let ArrayTerms { terms, dependence } = self;
        // A walk that ended early has not seen every use of the light.
        if terms.cut_short || terms.outputs.is_empty() {
            return false;
        }
        let control = &terms.control;
        let mut proof = LightProof {
            terms,
            on: dependence,
            numbers,
            spans: FxHashMap::default(),
            seen: FxHashSet::default(),
        };
        // Three ways in which a light acts: through the outputs' values, through whether the
        // fragment is written at all, and through how often a loop runs.
        terms.outputs.iter().all(|output| proof.unaffected(*output))
            && !control.exits.iter().any(|exit| proof.on.touches(*exit))
            && control.breaks.iter().all(|condition| proof.on.ends_a_loop(*condition))
    }
}

struct LightProof<'p, 't> {
    terms: &'t FalloffTerms,
    on: &'p mut Dependence<'t>,
    numbers: &'p FalloffNumbers<'p>,
    spans: FxHashMap<Id, Span>,
    /// The values known to be unaffected.
    seen: FxHashSet<Id>,
}

impl<'t> LightProof<'_, 't> {
    fn op(&self, id: Id) -> GraphOp {
        self.terms.graph.op(id)
    }

    fn args(&self, id: Id) -> &'t [Id] {
        self.terms.graph.args(id)
    }

    /// Whether a value is the same without the light.
    fn unaffected(&mut self, id: Id) -> bool {
        // Compared without the light's own terms: `sum + term` is `sum`.
        let id = self.base(id);
        if self.seen.contains(&id) {
            return true;
        }
        // A variable of a loop is unaffected by induction over its iterations.
        self.seen.insert(id);
        let args = self.args(id);
        let same = match (self.op(id), args) {
            (GraphOp::Leaf(_), _) => !self.on.is_of_light(id) && !self.on.is_count(id),
            // Without the light, the loop has one iteration less, which must have changed nothing.
            (GraphOp::Looping(_), &[first]) if self.on.is_counted(id) => {
                let next_values =
                    self.terms.control.next_values.get(&id).cloned().unwrap_or_default();
                self.unaffected(first) && next_values.iter().all(|turn| self.base(*turn) == id)
            }
            (GraphOp::Joined(_), args) => {
                let guards = self.terms.control.guards.get(&id);
                let chosen =
                    guards.is_some_and(|all| all.iter().any(|guard| self.on.touches(*guard)));
                // Which of them it is may depend on the light only if they differ by terms alone.
                let base = args.first().map(|arg| self.base(*arg));
                (!chosen || args.iter().all(|arg| Some(self.base(*arg)) == base))
                    && args.iter().all(|arg| self.unaffected(*arg))
            }
            (op, args) => {
                let control = &self.terms.control;
                let also = match op {
                    GraphOp::Looping(_) => control.next_values.get(&id),
                    _ => control.hidden.get(&id),
                };
                let also = also.cloned().unwrap_or_default();
                args.iter().chain(&also).all(|arg| self.unaffected(*arg))
            }
        };
        // A failed induction must not be remembered as a success by other values.
        if !same {
            self.seen.remove(&id);
        }
        same
    }

    /// Returns a value without the terms of the light that are added to it, on conditions of its
    /// own.
    fn base(&mut self, mut id: Id) -> Id {
        loop {
            // `a + b`: the term may stand on either side.
            let next = if let Some((a, b)) = self.terms.graph.binary(id, B::Add) {
                match (self.is_term(b), self.is_term(a)) {
                    (true, _) => a,
                    (false, true) => b,
                    (false, false) => return id,
                }
            } else if let (GraphOp::Chosen, &[condition, yes, no]) = (self.op(id), self.args(id)) {
                let yes = self.base(yes);
                // A choice of which the condition is this light's own, such as `if (d < range) sum
                // += term`: both sides have the same base. A condition on the counter or on other
                // iterations selects other lights.
                let own = !self.on.loops(condition) && !self.on.is_below_count(condition);
                if yes != self.base(no) || !own {
                    return id;
                }
                yes
            } else {
                return id;
            };
            id = next;
        }
    }

    /// Whether a value depends on the light, is zero for it, and depends on no other iteration of a
    /// loop, so that the terms of the other lights are the same without it.
    fn is_term(&mut self, id: Id) -> bool {
        // A term must not read what loops carry: `t * sum` would change later terms as well.
        self.on.reaches(id) && !self.on.loops(id) && self.span(id) == ZERO
    }

    fn span(&mut self, id: Id) -> Span {
        if let Some(known) = self.spans.get(&id) {
            return *known;
        }
        let span = self.compute(id);
        // inf - inf, 0 * inf: nothing is known.
        let span = if span[0].is_nan() || span[1].is_nan() { ANY } else { span };
        self.spans.insert(id, span);
        span
    }

    fn compute(&mut self, id: Id) -> Span {
        let args = self.args(id);
        match (self.op(id), args) {
            // Interval arithmetic, each operation widened by its rounding: the interval contains
            // every `f32` result, whatever the order of evaluation.
            (GraphOp::Number(bits), _) => [f64::from_bits(bits); 2],
            (GraphOp::Leaf(_), _) => self.of_leaf(id),
            (GraphOp::Joined(_) | GraphOp::Compose, args) if !args.is_empty() => {
                let spans: Vec<Span> = args.iter().map(|arg| self.span(*arg)).collect();
                spans.into_iter().reduce(hull).unwrap_or(ANY)
            }
            // Where the condition is decided for all such lights, only one side is evaluated.
            (GraphOp::Chosen, &[condition, yes, no]) => match self.truth(condition) {
                Some(true) => self.span(yes),
                Some(false) => self.span(no),
                None => hull(self.span(yes), self.span(no)),
            },
            (GraphOp::Part(_) | GraphOp::Swizzle(_), &[of]) => self.span(of),
            (GraphOp::Insert(_), &[whole, part]) => hull(self.span(whole), self.span(part)),
            (GraphOp::Negate, &[of]) => {
                let [low, high] = self.span(of);
                [-high, -low]
            }
            (GraphOp::Binary(op), &[a, b]) => {
                let (x, y) = (self.span(a), self.span(b));
                match op {
                    B::Add => rounded([x[0] + y[0], x[1] + y[1]]),
                    B::Subtract => rounded([x[0] - y[1], x[1] - y[0]]),
                    B::Multiply if a == b => squared(x),
                    B::Multiply => product(x, y),
                    B::Divide => quotient(x, y),
                    _ => ANY,
                }
            }
            (GraphOp::Math(fun), args) => self.math(fun, args),
            _ => ANY,
        }
    }

    fn of_leaf(&self, id: Id) -> Span {
        let role = self.terms.graph.as_leaf(id).and_then(|leaf| leaf.role);
        match role.filter(|_| self.on.is_of_light(id)) {
            // Members of the light have the numbers of the scene; every other input may have any.
            Some(role) => (self.numbers.of)(role).unwrap_or(ANY),
            None => ANY,
        }
    }

    fn math(&mut self, fun: M, args: &[Id]) -> Span {
        let [near, far] = self.numbers.distance;
        match (fun, args) {
            // The path between light and fragment: its length is what the caller knows, the
            // distance.
            (M::Dot, &[a, b]) if a == b && self.on.is_path(a) => squared([near, far]),
            // A square root of a sum of squares: twice the error of one operation.
            (M::Length, &[a]) if self.on.is_path(a) => rounded(rounded([near, far])),
            (M::Dot, &[a, b]) => {
                // 0 times anything, as in `product`.
                let zero = self.span(a) == ZERO || self.span(b) == ZERO;
                let low = if a == b { 0.0 } else { f64::NEG_INFINITY };
                if zero { ZERO } else { [low, f64::INFINITY] }
            }
            (M::Length, _) => [0.0, f64::INFINITY],
            (M::Max | M::Min | M::Clamp | M::Pow | M::SmoothStep, args) => {
                let spans: Vec<Span> = args.iter().map(|arg| self.span(*arg)).collect();
                several(fun, &spans)
            }
            (_, &[a]) => {
                let [low, high] = self.span(a);
                match fun {
                    M::Saturate => [low.clamp(0.0, 1.0), high.clamp(0.0, 1.0)],
                    M::Abs if low >= 0.0 => [low, high],
                    M::Abs if high <= 0.0 => [-high, -low],
                    M::Abs => [0.0, high.max(-low)],
                    M::Sqrt if low >= 0.0 => rounded([low.sqrt(), high.sqrt()]),
                    M::InverseSqrt if low > 0.0 => rounded([1.0 / high.sqrt(), 1.0 / low.sqrt()]),
                    // Not below zero, and underflow may make it zero.
                    M::Exp | M::Exp2 => [0.0, f64::INFINITY],
                    _ => ANY,
                }
            }
            _ => ANY,
        }
    }

    fn truth(&mut self, id: Id) -> Option<bool> {
        let args = self.args(id);
        match (self.op(id), args) {
            (GraphOp::Not, &[of]) => self.truth(of).map(|yes| !yes),
            (GraphOp::Binary(op), &[a, b]) => {
                let ([a, b], [c, d]) = (self.span(a), self.span(b));
                match op {
                    // Decided only where all pairs agree.
                    B::Less => decided(b < c, a >= d),
                    B::LessEqual => decided(b <= c, a > d),
                    B::Greater => decided(a > d, b <= c),
                    B::GreaterEqual => decided(a >= d, b < c),
                    _ => None,
                }
            }
            _ => None,
        }
    }
}

fn decided(yes: bool, no: bool) -> Option<bool> {
    if yes { Some(true) } else { no.then_some(false) }
}

fn hull(a: Span, b: Span) -> Span {
    [a[0].min(b[0]), a[1].max(b[1])]
}

/// Widens an interval by the rounding error of one operation; zero is exact.
fn rounded([low, high]: Span) -> Span {
    [low - low.abs() * ROUNDING, high + high.abs() * ROUNDING]
}

fn product(x: Span, y: Span) -> Span {
    // Zero times any number; what is not a number is so without the light, too.
    if x == ZERO || y == ZERO {
        return ZERO;
    }
    // inf * 0 at a corner.
    let ends = [x[0] * y[0], x[0] * y[1], x[1] * y[0], x[1] * y[1]];
    if ends.iter().any(|end| end.is_nan()) {
        return ANY;
    }
    let low = ends.iter().copied().fold(f64::INFINITY, f64::min);
    rounded([low, ends.iter().copied().fold(f64::NEG_INFINITY, f64::max)])
}

fn squared([low, high]: Span) -> Span {
    let ends = [low * low, high * high];
    let least = if low <= 0.0 && high >= 0.0 { 0.0 } else { ends[0].min(ends[1]) };
    rounded([least, ends[0].max(ends[1])])
}

fn quotient(x: Span, y: Span) -> Span {
    match y {
        // A divisor that may be zero gives no interval.
        [low, high] if low > 0.0 || high < 0.0 => product(x, rounded([1.0 / high, 1.0 / low])),
        _ => ANY,
    }
}

/// Returns the interval of a function of several numbers.
fn several(fun: M, spans: &[Span]) -> Span {
    match (fun, spans) {
        (M::Max, [a, b]) => [a[0].max(b[0]), a[1].max(b[1])],
        (M::Min, [a, b]) => [a[0].min(b[0]), a[1].min(b[1])],
        (M::Clamp, [x, low, high]) => {
            [x[0].max(low[0]).min(high[0]), x[1].max(low[1]).min(high[1])]
        }
        // Zero to a positive power.
        (M::Pow, [x, n]) if *x == ZERO && n[0] > 0.0 => ZERO,
        // Exactly 0 below the first edge: `smoothstep` clamps before it is squared (GLSL 4.60
        // §8.3).
        (M::SmoothStep, [from, to, x]) if from[1] < to[0] => match x {
            [_, high] if *high <= from[0] => ZERO,
            [low, _] if *low >= to[1] => [1.0, 1.0],
            _ => [0.0, 1.0],
        },
        _ => ANY,
    }
}
