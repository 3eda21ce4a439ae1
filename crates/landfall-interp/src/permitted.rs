//! A number with the interval of values that any conformant device may have in its place.
//!
//! One of the [`Real`]s of the machine: the `f32` is the value that
//! [`Single`](super::Precision::Single) computes, and branches follow it; around it lies the
//! [`Interval`] of the expression as written. A device that reorders the expression may leave it.

use super::code::{Cmp, LANES, RealBinary, RealUnary};
use super::interval::{Interval, sum_in_any_order};
use super::machine::frexp;
use super::real::Real;
use landfall_layout::source::Language;

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Permitted {
    pub single: f32,
    pub span: Interval,
}

macro_rules! exactly {
    ($($name:ident)*) => {$(
        fn $name(self) -> Permitted {
            let exact = |x: f64| Real::$name(x);
            Permitted { single: Real::$name(self.single), span: self.span.monotone(exact) }
        }
    )*};
}

macro_rules! by_rule {
    ($($name:ident($($b:ident)?);)*) => {$(
        fn $name(self $(, $b: Permitted)?) -> Permitted {
            Permitted {
                single: Real::$name(self.single $(, $b.single)?),
                span: self.span.$name($($b.span)?),
            }
        }
    )*};
}

impl Permitted {
    fn new(single: f32) -> Permitted {
        Permitted { single, span: Interval::new(single) }
    }

    fn converted(single: f32, exact: f64) -> Permitted {
        Permitted { single, span: Interval::near(exact) }
    }
}

impl Real for Permitted {
    const PERMITTED: bool = true;
    type Lanes = [Permitted; LANES];

    fn narrow(x: f32) -> Permitted {
        Permitted::new(x)
    }
    fn wide(x: f64) -> Permitted {
        Permitted::converted(x as f32, x)
    }
    fn sint(x: i64) -> Permitted {
        Permitted::converted(x as f32, x as f64)
    }
    fn uint(x: u64) -> Permitted {
        Permitted::converted(x as f32, x as f64)
    }
    fn single(self) -> f32 {
        self.single
    }
    fn double(self) -> f64 {
        f64::from(self.single)
    }
    /// Applies an increasing function that is correctly rounded.
    fn lift1(self, f: impl Fn(f64) -> f64) -> Permitted {
        Permitted { single: self.single.lift1(&f), span: self.span.monotone(&f).rounded() }
    }
    fn lift2(self, b: Permitted, f: impl Fn(f64, f64) -> f64) -> Permitted {
        // No error bound is known: the exact value, without an interval.
        Permitted::new(self.single.lift2(b.single, &f))
    }
    fn function1(self, f: RealUnary, exact: impl Fn(f64) -> f64) -> Permitted {
        let x = self.span;
        let span = match f {
            RealUnary::Sin => x.sin(),
            RealUnary::Cos => x.cos(),
            RealUnary::Tan => x.sin().div(x.cos()),
            RealUnary::Sinh => x.sinh(),
            RealUnary::Cosh => x.cosh(),
            RealUnary::Tanh => x.tanh(),
            RealUnary::Asin => x.asin(),
            RealUnary::Acos => x.acos(),
            RealUnary::Atan => x.atan(),
            RealUnary::Asinh => x.asinh(),
            RealUnary::Acosh => x.acosh(),
            RealUnary::Atanh => x.atanh(),
            RealUnary::Exp => x.exp(),
            RealUnary::Exp2 => x.exp2(),
            RealUnary::Log => x.ln(),
            RealUnary::Log2 => x.log2(),
            RealUnary::InverseSqrt => x.inverse_sqrt(),
            RealUnary::Radians => x.mul(Interval::near(std::f64::consts::PI / 180.0)),
            RealUnary::Degrees => x.mul(Interval::near(180.0 / std::f64::consts::PI)),
            RealUnary::FrexpFract => x.fraction(&exact, |x| frexp(x).1),
            RealUnary::Sign => x.sign(),
            RealUnary::Quantize => self.half().span,
            RealUnary::Neg
            | RealUnary::Abs
            | RealUnary::Floor
            | RealUnary::Ceil
            | RealUnary::Round
            | RealUnary::Trunc
            | RealUnary::Fract
            | RealUnary::Saturate
            | RealUnary::Sqrt => x.monotone(&exact).rounded(),
        };
        Permitted { single: self.single.lift1(exact), span }
    }
    fn function2(self, f: RealBinary, b: Permitted, exact: impl Fn(f64, f64) -> f64) -> Permitted {
        let span = match f {
            RealBinary::Pow => self.span.pow(b.span),
            RealBinary::Atan2 => self.span.atan2(b.span),
            RealBinary::Step => self.span.step(b.span),
            RealBinary::Add => self.span.add(b.span),
            RealBinary::Sub => self.span.sub(b.span),
            RealBinary::Mul => self.span.mul(b.span),
            RealBinary::Div => self.span.div(b.span),
            RealBinary::Rem => self.span.rem(b.span),
            RealBinary::Min => self.span.min(b.span),
            RealBinary::Max => self.span.max(b.span),
        };
        Permitted { single: self.single.lift2(b.single, exact), span }
    }
    by_rule! {
        add(b); sub(b); mul(b); div(b); rem(b); min(b); max(b); neg(); abs(); sqrt();
    }
    exactly! { floor ceil trunc round }
    fn fma(self, b: Permitted, c: Permitted) -> Permitted {
        // Rounded once or twice: the interval of two roundings contains both.
        let single = Real::fma(self.single, b.single, c.single);
        Permitted { single, span: self.span.mul(b.span).add(c.span) }
    }
    fn squared(self) -> Permitted {
        Permitted { single: self.single * self.single, span: self.span.squared() }
    }
    fn total(terms: &[Permitted]) -> Permitted {
        // The number is summed in order; a device may sum in any.
        let mut single = terms[0].single;
        terms[1..].iter().for_each(|term| single += term.single);
        let mut spans = [Interval::default(); 4];
        spans.iter_mut().zip(terms).for_each(|(span, term)| *span = term.span);
        Permitted { single, span: sum_in_any_order(&spans[..terms.len()]) }
    }
    /// Returns `x * inverseSqrt(squares)` for Vulkan, to which WGSL may be compiled, and `x /
    /// length` by WGSL §17.5.
    fn over_length(self, length: Permitted, squares: Permitted, of: Language) -> Permitted {
        let single = self.single / length.single;
        let product = self.span.mul(squares.span.inverse_sqrt());
        let span = match of {
            Language::Glsl | Language::SpirV => product,
            Language::Wgsl => product.or(self.span.div(length.span)),
        };
        Permitted { single, span }
    }
    fn whole(self) -> f64 {
        f64::from(self.single)
    }
    type By = f32;
    fn by(self) -> f32 {
        self.single
    }
    fn is_infinite(self) -> bool {
        self.single.is_infinite()
    }
    fn same(self, b: Permitted) -> bool {
        self.single.same(b.single) && self.span == b.span
    }
    fn half(self) -> Permitted {
        // Rounded to odd before, so that rounding twice gives what rounding once does.
        let nearest =
            |x: f64| half::f16::from_f32(landfall_layout::buffer::float::round_to_odd(x)).to_f64();
        Permitted { single: self.single.half(), span: self.span.monotone(nearest) }
    }
    fn span(self) -> Option<[f64; 2]> {
        Some([self.span.low, self.span.high])
    }
    fn unsure(self, cmp: Cmp, b: Permitted) -> bool {
        let (x, y) = (self.span, b.span);
        if x.is_any() || y.is_any() {
            return true;
        }
        match cmp {
            Cmp::Eq | Cmp::Ne => {
                let one = x.low == x.high && y.low == y.high;
                // Equal for sure only if both are the same single number.
                x.low <= y.high && y.low <= x.high && !(one && x.low == y.low)
            }
            Cmp::Lt | Cmp::Ge => x.low < y.high && x.high >= y.low,
            Cmp::Gt | Cmp::Le => y.low < x.high && y.high >= x.low,
        }
    }
    fn unsure_whole(self) -> bool {
        // Truncated, as conversions are.
        self.span.is_any() || self.span.low.trunc() != self.span.high.trunc()
    }
}
