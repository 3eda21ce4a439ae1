//! Bounds of the errors of results from all roundings.
//!
//! A result computed with roundings is the exact function of its inputs and of the error of each
//! operation. By the mean value theorem it is off by at most the sum, over all operations, of the
//! largest error of the operation times the largest derivative of the result with respect to it,
//! over enclosures of all values with and without errors. Derivatives are found from the results
//! back to the inputs. Exact and rounded values are compared along the same branches.

use super::super::code::{Cast, Class, RealBinary, RealTernary, RealUnary};
use super::super::interval::Interval;
use super::Graph;
use super::bounds::Bounds;
use super::exact::{self, between, contains, intersection, is_empty, point, size};
use super::node::{Node, NodeId, NodeOp};
use super::value::Arithmetic;

/// The roundings whose errors are bounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounding {
    /// The roundings of `f32` that conformant devices may have.
    Permitted,
    /// To the nearest `f64`; functions within a unit of the last place.
    Double,
}

impl Rounding {
    /// Returns the arithmetic whose enclosures hold both the exact and the rounded values.
    pub fn arithmetic(self) -> Arithmetic {
        match self {
            Rounding::Permitted => Arithmetic::Permitted,
            Rounding::Double => Arithmetic::Exact,
        }
    }

    /// Returns the distance of neighbouring numbers below a size.
    fn unit(self, size: f64) -> f64 {
        let exponent = (size.abs().to_bits() >> 52) as i32 - 1023;
        match self {
            Rounding::Permitted => 2f64.powi((exponent - 23).max(-149)).max(FLUSHED),
            Rounding::Double => 2f64.powi((exponent - 52).max(-1074)),
        }
    }

    /// Returns the largest error of a sum, product or quotient of a size.
    fn rounded(self, size: f64) -> f64 {
        match self {
            // Either neighbour is permitted.
            Rounding::Permitted => self.unit(size),
            Rounding::Double => self.unit(size) / 2.0,
        }
    }
}

/// A subnormal number may be flushed to zero.
const FLUSHED: f64 = f32::MIN_POSITIVE as f64;

/// Any derivative.
const ANY: Interval = exact::ALL;

impl Graph {
    /// Returns a bound of the absolute error of each result, in the box that was evaluated with the
    /// arithmetic of the rounding; infinite where none is known.
    pub fn errors(&self, bounds: &Bounds, rounding: Rounding) -> Vec<f64> {
        if !bounds.is_complete(self) {
            return vec![f64::INFINITY; self.results.len()];
        }
        let locals: Vec<f64> =
            (0..self.nodes.len() as NodeId).map(|id| self.local(bounds, rounding, id)).collect();
        let of = |&result: &NodeId| {
            // The chain rule backwards from the result, over intervals: when a node is reached, all
            // that use it have added their part to its slope.
            let mut slopes = vec![point(0.0); self.nodes.len()];
            slopes[result as usize] = point(1.0);
            let mut sum = 0.0f64;
            for id in (0..=result).rev() {
                let slope = slopes[id as usize];
                if slope == point(0.0) || is_empty(bounds.values[id as usize]) {
                    continue;
                }
                let local = locals[id as usize];
                if local > 0.0 {
                    sum = (sum + size(slope) * local).next_up();
                }
                self.pass_on(bounds, id, slope, &mut slopes);
            }
            // The sums were rounded up; the factor is for the products.
            if sum.is_nan() { f64::INFINITY } else { sum * (1.0 + 1e-12) }
        };
        self.results.iter().map(of).collect()
    }

    /// Returns the least and greatest value of each result without errors, and how far apart
    /// neighbouring `f32` are at the least size.
    pub fn exact_results(&self, inputs: &[Interval], into: &mut Bounds) -> Vec<Interval> {
        self.bounds(inputs, Arithmetic::Exact, into);
        into.results(self).collect()
    }

    /// Adds what each operand of a node contributes to the derivatives.
    fn pass_on(&self, bounds: &Bounds, id: NodeId, slope: Interval, slopes: &mut [Interval]) {
        let node = &self.nodes[id as usize];
        let ids = self.operands(node);
        for (nth, &operand) in ids.iter().enumerate() {
            if self.nodes[operand as usize].class != Class::Real {
                continue;
            }
            let partial = self.partial(bounds, node, ids, id, nth);
            if partial != point(0.0) {
                let more = exact::mul(slope, partial);
                let sum = exact::add(slopes[operand as usize], more);
                slopes[operand as usize] =
                    if sum.low.is_nan() || sum.high.is_nan() { ANY } else { sum };
            }
        }
    }

    /// Returns the derivative of a node with respect to an operand.
    fn partial(
        &self,
        bounds: &Bounds,
        node: &Node,
        ids: &[NodeId],
        id: NodeId,
        nth: usize,
    ) -> Interval {
        let of = |nth: usize| bounds.enclosure_under(self, node.guard, ids[nth]);
        let value = bounds.values[id as usize];
        match node.act {
            NodeOp::RealUnary(f) => slope_of(f, of(0), value),
            NodeOp::RealBinary(f) => slope_of_two(f, [of(0), of(1)], value, nth),
            NodeOp::RealTernary(RealTernary::Fma) => match nth {
                0 => of(1),
                1 => of(0),
                _ => point(1.0),
            },
            NodeOp::RealTernary(RealTernary::Mix) => match nth {
                0 => exact::sub(point(1.0), of(2)),
                1 => of(2),
                _ => exact::sub(of(1), of(0)),
            },
            NodeOp::RealTernary(RealTernary::Clamp) => between(0.0, 1.0),
            NodeOp::RealTernary(RealTernary::SmoothStep) => {
                let width = exact::sub(of(1), of(0));
                if width.low <= 0.0 {
                    return ANY;
                }
                // The slope of the curve, 6 * t * (1 - t), is at most 1.5.
                let steep = exact::div(between(0.0, 1.5), width);
                if nth == 2 { steep } else { exact::neg(steep) }
            }
            NodeOp::Dot => {
                let half = ids.len() / 2;
                of(if nth < half { nth + half } else { nth - half })
            }
            NodeOp::Length => unit_slope(of(nth), value),
            NodeOp::Distance => {
                let half = ids.len() / 2;
                let apart = exact::sub(of(nth % half), of(nth % half + half));
                let slope = unit_slope(apart, value);
                if nth < half { slope } else { exact::neg(slope) }
            }
            NodeOp::Normalize(own) => {
                let squares = (0..ids.len()).map(|i| exact::squared(of(i)));
                let length = exact::sqrt(squares.reduce(exact::add).unwrap_or_default());
                if length.low <= 0.0 {
                    return ANY;
                }
                // (1 - u * u) / length, or -u * v / length.
                let most =
                    if usize::from(own) == nth { between(0.0, 1.0) } else { between(-0.5, 0.5) };
                exact::div(most, length)
            }
            NodeOp::Cross(own) => {
                let (j, k) = ((usize::from(own) + 1) % 3, (usize::from(own) + 2) % 3);
                match nth {
                    n if n == j => of(k + 3),
                    n if n == k + 3 => of(j),
                    n if n == k => exact::neg(of(j + 3)),
                    n if n == j + 3 => exact::neg(of(k)),
                    _ => point(0.0),
                }
            }
            NodeOp::Select => match bounds.enclosure_under(self, node.guard, ids[0]) {
                x if x == point(0.0) => point(f64::from(u8::from(nth == 2))),
                x if x.low >= 1.0 => point(f64::from(u8::from(nth == 1))),
                _ => between(0.0, 1.0),
            },
            NodeOp::Cast(Cast::RoundHalf) => point(1.0),
            // Integers, bools and bits of a number that is off may be any others.
            _ if value.low == value.high => point(0.0),
            _ => ANY,
        }
    }

    /// Returns the largest error of a node's own operation.
    pub(super) fn local(&self, bounds: &Bounds, rounding: Rounding, id: NodeId) -> f64 {
        let node = &self.nodes[id as usize];
        let value = bounds.values[id as usize];
        // Integers past 2^24 and doubles fall between numbers of `f32`.
        let is_rounded = rounding == Rounding::Permitted
            && match node.act {
                NodeOp::Cast(Cast::SintToReal | Cast::UintToReal) => size(value) > 16_777_216.0,
                NodeOp::Cast(Cast::DoubleToReal | Cast::Sint64ToReal | Cast::Uint64ToReal) => true,
                _ => false,
            };
        let is_exact = node.act.keeps_exact() && !is_rounded;
        if node.class != Class::Real || is_empty(value) || is_exact {
            return 0.0;
        }
        let ids = self.operands(node);
        let of = |nth: usize| bounds.enclosure_under(self, node.guard, ids[nth]);
        let whole = rounding.rounded(size(value));
        let product = |a: Interval, b: Interval| size(exact::mul(a, b));
        match node.act {
            NodeOp::RealBinary(RealBinary::Add | RealBinary::Sub | RealBinary::Mul) => whole,
            NodeOp::RealTernary(RealTernary::Fma) => {
                whole + rounding.rounded(product(of(0), of(1)))
            }
            NodeOp::RealTernary(RealTernary::Mix) => {
                let rest = exact::sub(point(1.0), of(2));
                let terms = rounding.rounded(product(of(0), rest))
                    + rounding.rounded(product(of(1), of(2)));
                size(of(0)) * rounding.rounded(size(rest)) + terms + whole
            }
            NodeOp::RealTernary(RealTernary::SmoothStep) => {
                let (past, width) = (exact::sub(of(2), of(0)), exact::sub(of(1), of(0)));
                if width.low <= 0.0 {
                    return f64::INFINITY;
                }
                // The errors of both differences, in terms of the width, of the quotient and of the
                // clamp; the curve passes them on by its slope and adds its own.
                let t = rounding.rounded(size(past).min(size(width))) / width.low
                    + rounding.rounded(size(width)) / width.low
                    + 3.0 * rounding.unit(1.0);
                1.5 * t + 8.0 * rounding.unit(1.0)
            }
            NodeOp::Dot => {
                let half = ids.len() / 2;
                let terms: Vec<f64> = (0..half).map(|i| product(of(i), of(i + half))).collect();
                sum_error(rounding, &terms)
            }
            NodeOp::Cross(own) => {
                let (j, k) = ((usize::from(own) + 1) % 3, (usize::from(own) + 2) % 3);
                sum_error(rounding, &[product(of(j), of(k + 3)), product(of(k), of(j + 3))])
            }
            NodeOp::Length | NodeOp::Distance => {
                let half = ids.len() / 2;
                let terms: Vec<f64> = match node.act {
                    NodeOp::Length => (0..ids.len()).map(|i| size(of(i)).powi(2)).collect(),
                    _ => (0..half).map(|i| size(exact::sub(of(i), of(i + half))).powi(2)).collect(),
                };
                if value.low <= 0.0 {
                    return f64::INFINITY;
                }
                // Differences, squares and their sum, then the root within 5 units.
                let apart = if let NodeOp::Distance = node.act {
                    2.0 * rounding.unit(size(value))
                } else {
                    0.0
                };
                sum_error(rounding, &terms) / (2.0 * value.low)
                    + apart
                    + 5.0 * rounding.unit(size(value))
            }
            // Its formula has an error of at most 8 units.
            NodeOp::Normalize(_) => 8.0 * rounding.unit(1.0),
            NodeOp::Ldexp => 0.0,
            NodeOp::RealUnary(RealUnary::Fract) if rounding == Rounding::Double => whole,
            NodeOp::RealUnary(RealUnary::Sqrt) | NodeOp::RealBinary(RealBinary::Div)
                if rounding == Rounding::Double =>
            {
                whole
            }
            NodeOp::RealUnary(_) | NodeOp::RealBinary(_) if rounding == Rounding::Double => {
                rounding.unit(size(value))
            }
            NodeOp::RealUnary(_) | NodeOp::RealBinary(_) => self.excess(bounds, node) + whole,
            // A unit in the last place of an `f16`, or of its subnormal numbers.
            NodeOp::Cast(Cast::RoundHalf) => size(value) / 1024.0 + 6e-8,
            NodeOp::Cast(_) => whole,
            _ => f64::INFINITY,
        }
    }

    /// Returns how far the permitted values lie outside of the exact ones.
    fn excess(&self, bounds: &Bounds, node: &Node) -> f64 {
        let ids = self.operands(node);
        let of = |nth: usize| bounds.enclosure_under(self, node.guard, ids[nth]);
        let over = |how: Arithmetic| match node.act {
            NodeOp::RealUnary(f) => super::arithmetic::f1(how, f, of(0)).value,
            NodeOp::RealBinary(f) => {
                let same = ids[0] == ids[1];
                super::arithmetic::f2(how, f, of(0), of(1), same, [false; 2]).value
            }
            _ => ANY,
        };
        let (exact, permitted) = (over(Arithmetic::Exact), over(Arithmetic::Permitted));
        if permitted == ANY {
            return f64::INFINITY;
        }
        let off = (exact.low - permitted.low).max(permitted.high - exact.high);
        if off.is_nan() { f64::INFINITY } else { off.max(0.0) }
    }
}

/// Returns the largest error of a sum of products in any order.
fn sum_error(rounding: Rounding, terms: &[f64]) -> f64 {
    let sum: f64 = terms.iter().sum();
    let products: f64 = terms.iter().map(|term| rounding.rounded(*term)).sum();
    // No partial sum exceeds the sum of all terms, which are not negative.
    products + (terms.len() as f64 - 1.0) * rounding.rounded(sum)
}

/// Returns a component over the length of its vector.
fn unit_slope(x: Interval, length: Interval) -> Interval {
    match length.low > 0.0 {
        true => intersection(exact::div(x, length), between(-1.0, 1.0)),
        false => between(-1.0, 1.0),
    }
}

/// Returns the derivative of a function that is constant but for steps.
fn steps(value: Interval) -> Interval {
    if value.low == value.high { point(0.0) } else { ANY }
}

/// Returns the derivative over an interval of operands; `value` encloses the results.
pub(super) fn slope_of(f: RealUnary, x: Interval, value: Interval) -> Interval {
    let one = point(1.0);
    // A pole within the interval allows any slope.
    let over = |x: Interval| if contains(x, 0.0) { ANY } else { exact::div(one, x) };
    match f {
        RealUnary::Neg => point(-1.0),
        RealUnary::Abs => match (x.low >= 0.0, x.high <= 0.0) {
            (true, _) => one,
            (_, true) => point(-1.0),
            _ => between(-1.0, 1.0),
        },
        RealUnary::Sign
        | RealUnary::Floor
        | RealUnary::Ceil
        | RealUnary::Round
        | RealUnary::Trunc
        | RealUnary::FrexpFract => steps(value),
        // The slope is 1 between two steps.
        RealUnary::Fract => match x.low.floor() == x.high.floor() {
            true => one,
            false => ANY,
        },
        RealUnary::Saturate => between(0.0, 1.0),
        RealUnary::Radians => exact::widened(point(1f64.to_radians())),
        RealUnary::Degrees => exact::widened(point(1f64.to_degrees())),
        RealUnary::Sqrt => exact::mul(point(0.5), over(exact::sqrt(x))),
        RealUnary::InverseSqrt => {
            // x^(-3/2), from the root's inverse.
            let root = over(exact::sqrt(x));
            exact::mul(point(-0.5), exact::mul(root, exact::squared(root)))
        }
        RealUnary::Sin => exact::cos(x),
        RealUnary::Cos => exact::neg(exact::sin(x)),
        RealUnary::Tan => exact::add(one, exact::squared(value)),
        // 1 / sqrt(1 - x²), of the operands for which it is defined.
        RealUnary::Asin | RealUnary::Acos => {
            let root =
                exact::sqrt(exact::sub(one, exact::squared(intersection(x, between(-1.0, 1.0)))));
            let slope = over(root);
            if f == RealUnary::Asin { slope } else { exact::neg(slope) }
        }
        RealUnary::Atan => over(exact::add(one, exact::squared(x))),
        // cosh is even and rises from 0 on.
        RealUnary::Sinh => exact::rising(exact::abs(x), f64::cosh),
        RealUnary::Cosh => exact::rising(x, f64::sinh),
        RealUnary::Tanh => between(0.0, 1.0),
        RealUnary::Asinh => over(exact::sqrt(exact::add(one, exact::squared(x)))),
        RealUnary::Acosh => over(exact::sqrt(exact::sub(exact::squared(x), one))),
        RealUnary::Atanh => over(exact::sub(one, exact::squared(x))),
        RealUnary::Exp => exact::rising(x, f64::exp),
        RealUnary::Exp2 => {
            exact::mul(exact::rising(x, f64::exp2), exact::widened(point(2f64.ln())))
        }
        RealUnary::Log => over(x),
        RealUnary::Log2 => exact::mul(over(x), exact::widened(point(1.0 / 2f64.ln()))),
        RealUnary::Quantize => one,
    }
}

/// The same by the operand with a number.
fn slope_of_two(f: RealBinary, [a, b]: [Interval; 2], value: Interval, nth: usize) -> Interval {
    let one = point(1.0);
    let pick = |first: Interval, second: Interval| if nth == 0 { first } else { second };
    match f {
        RealBinary::Add => one,
        RealBinary::Sub => pick(one, point(-1.0)),
        RealBinary::Mul => pick(b, a),
        RealBinary::Div if contains(b, 0.0) => ANY,
        // By the second: -(a / b) / b, with the quotient that is enclosed already.
        RealBinary::Div => pick(exact::div(one, b), exact::neg(exact::div(value, b))),
        RealBinary::Rem => ANY,
        RealBinary::Min | RealBinary::Max => {
            let first = if f == RealBinary::Min { a.high < b.low } else { a.low > b.high };
            let second = if f == RealBinary::Min { b.high < a.low } else { b.low > a.high };
            match (first, second) {
                (true, _) => pick(one, point(0.0)),
                (_, true) => pick(point(0.0), one),
                _ => between(0.0, 1.0),
            }
        }
        RealBinary::Step => steps(value),
        // The slope by the exponent has the logarithm of the base.
        RealBinary::Pow if a.low <= 0.0 => ANY,
        RealBinary::Pow => {
            pick(exact::div(exact::mul(b, value), a), exact::mul(value, exact::rising(a, f64::ln)))
        }
        RealBinary::Atan2 => {
            let squares = exact::add(exact::squared(a), exact::squared(b));
            if squares.low <= 0.0 {
                return ANY;
            }
            // For atan2(y, x): x / (x² + y²) and -y / (x² + y²).
            pick(exact::div(b, squares), exact::neg(exact::div(a, squares)))
        }
    }
}
