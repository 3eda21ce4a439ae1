//! Float operations on each lane, in the precision of the run.

use super::super::code::{
    Cmp, DerivativeAxis, LANES, Op, RealBinary, RealTernary, RealUnary, Test,
};
use super::super::lanes::{Lanes, lanes_of};
use super::super::real::Real;
use super::kernel::{groups1, groups2, groups3, map1, map2, map3, map4, map6};
use super::{Machine, apart, column, column_mut};
use landfall_layout::buffer::float::round_to_odd;

/// Returns `pow` as devices define it: NaN for a negative base, whatever the exponent.
fn pow(x: f64, y: f64) -> f64 {
    if x < 0.0 { f64::NAN } else { x.powf(y) }
}

/// Returns a function of one operand that has no processor instruction.
fn transcendental(f: RealUnary, x: f64) -> f64 {
    match f {
        RealUnary::Sin => x.sin(),
        RealUnary::Cos => x.cos(),
        RealUnary::Tan => x.tan(),
        RealUnary::Sinh => x.sinh(),
        RealUnary::Cosh => x.cosh(),
        RealUnary::Tanh => x.tanh(),
        RealUnary::Asin => x.asin(),
        RealUnary::Acos => x.acos(),
        RealUnary::Atan => x.atan(),
        RealUnary::Asinh => x.asinh(),
        RealUnary::Acosh => acosh(x),
        RealUnary::Atanh => atanh(x),
        RealUnary::Exp => x.exp(),
        RealUnary::Exp2 => x.exp2(),
        RealUnary::Log => x.ln(),
        RealUnary::Log2 => x.log2(),
        RealUnary::Radians => x * (std::f64::consts::PI / 180.0),
        RealUnary::Degrees => x * (180.0 / std::f64::consts::PI),
        RealUnary::InverseSqrt => 1.0 / x.sqrt(),
        RealUnary::FrexpFract => frexp(x).0,
        // Rounded to odd first, so that rounding twice gives the nearest `f16`.
        RealUnary::Quantize => half::f16::from_f32(round_to_odd(x)).to_f64(),
        RealUnary::Neg
        | RealUnary::Abs
        | RealUnary::Sign
        | RealUnary::Floor
        | RealUnary::Ceil
        | RealUnary::Round
        | RealUnary::Trunc
        | RealUnary::Fract
        | RealUnary::Saturate
        | RealUnary::Sqrt => f64::NAN,
    }
}

/// Uses `x - 1`: the standard library's form (Rust 1.95) loses all digits near 1.
fn acosh(x: f64) -> f64 {
    let past = x - 1.0;
    (past + past.sqrt() * (past + 2.0).sqrt()).ln_1p()
}

/// Uses the absolute value: the standard library's form (Rust 1.95) loses digits near -1.
fn atanh(x: f64) -> f64 {
    let size = x.abs();
    (0.5 * (2.0 * size / (1.0 - size)).ln_1p()).copysign(x)
}

/// Returns the fraction, from 0.5 to 1, and the exponent.
pub(crate) fn frexp(x: f64) -> (f64, i32) {
    if x == 0.0 || !x.is_finite() {
        return (x, 0);
    }
    // A subnormal number is scaled until its exponent field is its exponent.
    let scaled = x.abs() < f64::MIN_POSITIVE;
    let y = if scaled { x * 2f64.powi(64) } else { x };
    // The bias is 1023; the exponent is one more as the fraction is below 1.
    let exponent = (y.to_bits() >> 52 & 0x7ff) as i32 - 1022;
    let fraction = f64::from_bits(y.to_bits() & !(0x7ff << 52) | 1022 << 52);
    (fraction, if scaled { exponent - 64 } else { exponent })
}

/// Returns `x * 2^e` without intermediate overflow.
pub(super) fn ldexp(x: f64, e: i32) -> f64 {
    // Beyond 2^2098 in size every result is zero or infinite, and a third of 2200 is within the
    // exponents of a double.
    let e = e.clamp(-2200, 2200);
    let third = e / 3;
    x * 2f64.powi(third) * 2f64.powi(third) * 2f64.powi(e - 2 * third)
}

/// Computes a function of one operand.
#[inline(always)]
pub(super) fn apply1<R: Real>(f: RealUnary, x: R) -> R {
    match f {
        RealUnary::Neg => x.neg(),
        RealUnary::Abs => x.abs(),
        RealUnary::Sign if R::PERMITTED => x.function1(f, sign),
        RealUnary::Sign => {
            let one = R::narrow(1.0);
            let s = x.double();
            if s > 0.0 {
                one
            } else if s < 0.0 {
                one.neg()
            } else {
                // Zero keeps its sign, and NaN is none.
                x
            }
        }
        RealUnary::Floor => x.floor(),
        RealUnary::Ceil => x.ceil(),
        RealUnary::Round => x.round(),
        RealUnary::Trunc => x.trunc(),
        RealUnary::Fract => x.sub(x.floor()),
        RealUnary::Saturate => x.max(R::narrow(0.0)).min(R::narrow(1.0)),
        RealUnary::Sqrt => x.sqrt(),
        RealUnary::InverseSqrt => x.function1(f, |x| 1.0 / x.sqrt()),
        _ => x.function1(f, |x| transcendental(f, x)),
    }
}

/// Computes a function of two operands.
#[inline(always)]
pub(super) fn apply2<R: Real>(f: RealBinary, a: R, b: R) -> R {
    match f {
        RealBinary::Add => a.add(b),
        RealBinary::Sub => a.sub(b),
        RealBinary::Mul => a.mul(b),
        RealBinary::Div => a.div(b),
        RealBinary::Rem => a.rem(b),
        RealBinary::Min => a.min(b),
        RealBinary::Max => a.max(b),
        RealBinary::Step => step(a, b),
        RealBinary::Pow => a.function2(f, b, pow),
        RealBinary::Atan2 => a.function2(f, b, f64::atan2),
    }
}

fn sign(x: f64) -> f64 {
    if x == 0.0 { x } else { x.signum() }
}

fn step<R: Real>(edge: R, x: R) -> R {
    // Each part of a shadow is selected separately.
    x.function2(RealBinary::Step, edge, |x, edge| f64::from(u8::from(edge <= x)))
}

#[inline(always)]
pub(super) fn mix<R: Real>(x: R, y: R, a: R) -> R {
    // e1 * (1 - e3) + e2 * e3: GLSL 4.60 §8.3.
    x.mul(R::narrow(1.0).sub(a)).add(y.mul(a))
}

#[inline(always)]
pub(super) fn smoothstep<R: Real>(low: R, high: R, x: R) -> R {
    // GLSL 4.60 §8.3.
    let t = x.sub(low).div(high.sub(low)).max(R::narrow(0.0)).min(R::narrow(1.0));
    t.mul(t).mul(R::narrow(3.0).sub(R::narrow(2.0).mul(t)))
}

impl<R: Real> Machine<'_, '_, R> {
    #[inline(always)]
    fn each1(&mut self, operands: &[u32], f: impl Fn(R) -> R) {
        groups1::<R>(&mut self.reals, operands, f);
    }

    #[inline(always)]
    fn each2(&mut self, operands: &[u32], f: impl Fn(R, R) -> R) {
        groups2::<R>(&mut self.reals, operands, f);
    }

    #[inline(always)]
    fn each3(&mut self, operands: &[u32], f: impl Fn(R, R, R) -> R) {
        groups3::<R>(&mut self.reals, operands, f);
    }

    #[inline(always)]
    pub(super) fn f1(&mut self, f: RealUnary, operands: &[u32]) {
        // A loop for each frequent function lets it be vectorised.
        macro_rules! loops {
            ($($frequent:ident)*) => {
                match f {
                    $(RealUnary::$frequent => {
                        self.each1(operands, |x| apply1(RealUnary::$frequent, x));
                    })*
                    _ => self.transcendental1(f, operands),
                }
            };
        }
        loops! {
            Neg Abs Sign Floor Ceil Round Trunc Fract Saturate Sqrt InverseSqrt Radians Degrees
        }
    }

    #[inline(always)]
    pub(super) fn f2(&mut self, f: RealBinary, operands: &[u32]) {
        match f {
            RealBinary::Add => self.each2(operands, |a, b| a.add(b)),
            RealBinary::Sub => self.each2(operands, |a, b| a.sub(b)),
            RealBinary::Mul if R::PERMITTED => {
                // The square of an interval around zero is not negative; the product of two such
                // intervals may be.
                for group in operands.chunks_exact(3) {
                    match group[1] == group[2] {
                        true => self.each1(&group[..2], R::squared),
                        false => self.each2(group, R::mul),
                    }
                }
            }
            RealBinary::Mul => self.each2(operands, |a, b| a.mul(b)),
            RealBinary::Div => self.each2(operands, |a, b| a.div(b)),
            RealBinary::Min => self.each2(operands, |a, b| a.min(b)),
            RealBinary::Max => self.each2(operands, |a, b| a.max(b)),
            RealBinary::Step => self.each2(operands, step),
            RealBinary::Rem | RealBinary::Pow | RealBinary::Atan2 => {
                self.transcendental2(f, operands)
            }
        }
    }

    /// Adds products to other numbers or subtracts one from the other, by two fused instructions.
    #[inline(always)]
    pub(super) fn multiply_and(&mut self, then: Op, products: &[u32], sums: &[u32]) {
        let on_the_left = products[0] == sums[1];
        match (then, on_the_left) {
            (Op::RealBinary(RealBinary::Add), true) => {
                self.each_sum(products, sums, 2, |ab, c| ab.add(c))
            }
            (Op::RealBinary(RealBinary::Add), false) => {
                self.each_sum(products, sums, 1, |ab, c| c.add(ab))
            }
            (_, true) => self.each_sum(products, sums, 2, |ab, c| ab.sub(c)),
            (_, false) => self.each_sum(products, sums, 1, |ab, c| c.sub(ab)),
        }
    }

    /// Computes a function of each product and another operand of its sum.
    #[inline(always)]
    fn each_sum(&mut self, products: &[u32], sums: &[u32], other: usize, f: impl Fn(R, R) -> R) {
        // Not zipped, as that is a call.
        let mut sums = sums.chunks_exact(3);
        for product in products.chunks_exact(3) {
            let Some(sum) = sums.next() else { return };
            let (to, others) = apart(&mut self.reals, sum[0]);
            let (a, b) = (others.column(product[1]), others.column(product[2]));
            map3(to, a, b, others.column(sum[other]), |a, b, c| f(a.mul(b), c));
        }
    }

    #[inline(always)]
    pub(super) fn f3(&mut self, f: RealTernary, operands: &[u32]) {
        match f {
            RealTernary::Fma => self.each3(operands, |a, b, c| a.fma(b, c)),
            RealTernary::Mix => self.each3(operands, mix),
            RealTernary::Clamp => self.each3(operands, |x, low, high| x.max(low).min(high)),
            RealTernary::SmoothStep => self.each3(operands, smoothstep),
        }
    }

    #[inline(always)]
    pub(super) fn compare_reals(&mut self, cmp: Cmp, operands: &[u32]) {
        macro_rules! each {
            ($cmp:expr, $op:tt) => {
                for group in operands.chunks_exact(3) {
                    let (a, b) = (column(&self.reals, group[1]), column(&self.reals, group[2]));
                    let to = column_mut(&mut self.words, group[0]);
                    map2(to, a, b, |a, b| u32::from(R::by(a) $op R::by(b)));
                    // Of several values in a lane, some may compare in another way.
                    if R::MANY {
                        let mut unsure = [0; LANES];
                        map2(&mut unsure, a, b, |a, b| u32::from(R::unsure(a, $cmp, b)));
                        self.unsure |= lanes_of(&unsure) & self.active;
                    }
                }
            };
        }
        match cmp {
            Cmp::Eq => each!(Cmp::Eq, ==),
            Cmp::Ne => each!(Cmp::Ne, !=),
            Cmp::Lt => each!(Cmp::Lt, <),
            Cmp::Le => each!(Cmp::Le, <=),
            Cmp::Gt => each!(Cmp::Gt, >),
            Cmp::Ge => each!(Cmp::Ge, >=),
        }
    }

    #[inline(always)]
    pub(super) fn test_reals(&mut self, test: Test, operands: &[u32]) {
        for group in operands.chunks_exact(2) {
            let a = column(&self.reals, group[1]);
            let to = column_mut(&mut self.words, group[0]);
            match test {
                Test::IsNan => map1(to, a, |x| u32::from(R::by(x) != R::by(x))),
                Test::IsInf => map1(to, a, |x| u32::from(x.is_infinite())),
            }
        }
    }

    #[inline(always)]
    pub(super) fn ldexp(&mut self, operands: &[u32]) {
        for group in operands.chunks_exact(3) {
            let (to, others) = apart(&mut self.reals, group[0]);
            let (a, e) = (others.column(group[1]), column(&self.words, group[2]));
            map2(to, a, e, |a, e| a.lift1(|x| ldexp(x, e as i32)));
        }
    }

    #[inline(always)]
    pub(super) fn dot(&mut self, n: usize, operands: &[u32]) {
        for group in operands.chunks_exact(1 + 2 * n) {
            let (to, others) = apart(&mut self.reals, group[0]);
            let (a, b) = group[1..].split_at(n);
            let of = |reg: u32| others.column(reg);
            match (a, b) {
                _ if R::PERMITTED => {
                    products_in_any_order(
                        to,
                        |i, lane| (of(a[i]).lane(lane), of(b[i]).lane(lane)),
                        n,
                        a == b,
                    );
                }
                // From left to right, as GLSL and WGSL write the sum; neither fixes the order.
                (&[x], &[u]) => map2(to, of(x), of(u), R::mul),
                (&[x, y], &[u, v]) => map4(to, of(x), of(u), of(y), of(v), dot2),
                (&[x, y, z, ..], &[u, v, w, ..]) => {
                    map6(to, of(x), of(u), of(y), of(v), of(z), of(w), dot3);
                    if let ([_, _, _, a], [_, _, _, b]) = (a, b) {
                        let three = *to;
                        let sum = |three: R, a: R, b: R| three.add(a.mul(b));
                        map3(to, &three, of(*a), of(*b), sum);
                    }
                }
                _ => unreachable!("a vector has one to four components"),
            }
        }
    }

    #[inline(always)]
    pub(super) fn length(&mut self, n: usize, operands: &[u32]) {
        for group in operands.chunks_exact(1 + n) {
            let (to, others) = apart(&mut self.reals, group[0]);
            match group[1..] {
                [x, y, z] if !R::PERMITTED => {
                    let [x, y, z] = [others.column(x), others.column(y), others.column(z)];
                    map3(to, x, y, z, |x, y, z| squares3(x, y, z).sqrt());
                }
                _ => {
                    let mut squares = R::Lanes::filled(R::default());
                    squares_of::<R>(&group[1..], |reg| others.column(reg), &mut squares);
                    map1(to, &squares, R::sqrt);
                }
            }
        }
    }

    #[inline(always)]
    pub(super) fn distance(&mut self, n: usize, operands: &[u32]) {
        for group in operands.chunks_exact(1 + 2 * n) {
            let (to, others) = apart(&mut self.reals, group[0]);
            let (a, b) = group[1..].split_at(n);
            let of = |reg: u32| others.column(reg);
            if n == 1 {
                map2(to, of(a[0]), of(b[0]), |a, b| a.sub(b).abs());
            } else if R::PERMITTED {
                // A device may add the squares in any order.
                let between = |i: usize, lane: usize| of(a[i]).lane(lane).sub(of(b[i]).lane(lane));
                products_in_any_order(to, |i, lane| [between(i, lane); 2].into(), n, true);
                let squares = *to;
                to.set(|lane| squares.lane(lane).sqrt());
            } else {
                for (i, (a, b)) in a.iter().zip(b).enumerate() {
                    let before = *to;
                    map3(to, &before, of(*a), of(*b), |sum, a, b| {
                        let square = a.sub(b).mul(a.sub(b));
                        if i == 0 { square } else { sum.add(square) }
                    });
                }
                let squares = *to;
                map1(to, &squares, R::sqrt);
            }
        }
    }

    /// Divides each component by the length: WGSL §17.5.
    #[inline(always)]
    pub(super) fn normalize(&mut self, n: usize, operands: &[u32]) {
        for group in operands.chunks_exact(2 * n) {
            let (to, from) = group.split_at(n);
            let language = self.program.language;
            let mut squares = R::Lanes::filled(R::default());
            squares_of::<R>(from, |reg| column(&self.reals, reg), &mut squares);
            let mut length = R::Lanes::filled(R::default());
            map1(&mut length, &squares, R::sqrt);
            for (to, from) in to.iter().zip(from) {
                let (quotient, others) = apart(&mut self.reals, *to);
                let from = others.column(*from);
                map3(quotient, from, &length, &squares, |a, b, c| a.over_length(b, c, language));
            }
        }
    }

    #[inline(always)]
    pub(super) fn cross(&mut self, operands: &[u32]) {
        for group in operands.chunks_exact(9) {
            let (to, from) = group.split_at(3);
            let (a, b) = from.split_at(3);
            for (i, &to) in to.iter().enumerate() {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                let (product, others) = apart(&mut self.reals, to);
                let of = |reg: u32| others.column(reg);
                let (aj, bk, ak, bj) = (of(a[j]), of(b[k]), of(a[k]), of(b[j]));
                map4(product, aj, bk, ak, bj, |aj, bk, ak, bj| aj.mul(bk).sub(ak.mul(bj)));
            }
        }
    }

    /// Computes differences within quads of lanes: the second lane is right of the first, the third
    /// below. A lane that was not started has its neighbour's value: a single call has no
    /// neighbours.
    pub(super) fn derivative(&mut self, axis: DerivativeAxis, fine: bool, operands: &[u32]) {
        for group in operands.chunks_exact(2) {
            let (to, others) = apart(&mut self.reals, group[0]);
            let a = others.column(group[1]);
            let started = self.started;
            for lane in 0..LANES {
                // Coarse: the first lane of the quad stands for all four.
                let from = if fine { lane } else { lane & !3 };
                let at =
                    |other: usize| a.lane(if started >> other & 1 == 1 { other } else { lane });
                let x = || at(from | 1).sub(at(from & !1));
                let y = || at(from | 2).sub(at(from & !2));
                let difference = match axis {
                    DerivativeAxis::X => x(),
                    DerivativeAxis::Y => y(),
                    DerivativeAxis::Width => x().abs().add(y().abs()),
                };
                to.put(lane, difference);
            }
        }
    }
}

/// Computes the sum of the squares of a vector's components.
#[inline(always)]
fn squares_of<'f, R: Real>(v: &[u32], of: impl Fn(u32) -> &'f R::Lanes, to: &mut R::Lanes) {
    match *v {
        _ if R::PERMITTED => {
            products_in_any_order(to, |i, lane| [of(v[i]).lane(lane); 2].into(), v.len(), true);
        }
        [x] => map1(to, of(x), |x| x.mul(x)),
        [x, y] => map2(to, of(x), of(y), |x, y| dot2(x, x, y, y)),
        [x, y, z] => map3(to, of(x), of(y), of(z), squares3),
        [x, y, z, w] => {
            let sum = |x: R, y: R, z: R, w: R| squares3(x, y, z).add(w.mul(w));
            map4(to, of(x), of(y), of(z), of(w), sum);
        }
        _ => unreachable!("a vector has one to four components"),
    }
}

/// Computes sums of products in any order of summation.
fn products_in_any_order<R: Real>(
    to: &mut R::Lanes,
    factors: impl Fn(usize, usize) -> (R, R),
    n: usize,
    squares: bool,
) {
    for lane in 0..LANES {
        let mut products = [R::default(); 4];
        for (i, product) in products[..n].iter_mut().enumerate() {
            let (a, b) = factors(i, lane);
            *product = if squares { a.squared() } else { a.mul(b) };
        }
        to.put(lane, R::total(&products[..n]));
    }
}

#[inline(always)]
fn dot2<R: Real>(a: R, b: R, c: R, d: R) -> R {
    a.mul(b).add(c.mul(d))
}

#[inline(always)]
fn dot3<R: Real>(a: R, b: R, c: R, d: R, e: R, f: R) -> R {
    dot2(a, b, c, d).add(e.mul(f))
}

#[inline(always)]
fn squares3<R: Real>(x: R, y: R, z: R) -> R {
    dot3(x, x, y, y, z, z)
}
