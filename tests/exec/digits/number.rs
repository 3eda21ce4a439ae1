//! Numbers of 86 digits, each with a bound of how far an evaluation in `f64` may be from it.
//!
//! The bound is carried through every operation: what its operands were off by, times how much
//! the operation makes of that, and the operation's own rounding. Where no bound can be given
//! (a jump within it, a pole too near, no value at all) there is no number.

use astro_float_num::{BigFloat, Consts, RoundingMode, Sign};

/// 86 digits.
const BITS: usize = 288;
const ROUND: RoundingMode = RoundingMode::ToEven;
/// Half a unit in the last place, relative.
const HALF_ULP: f64 = f64::EPSILON / 2.0;
/// Quadratic terms of errors that small, relative to the scale of a function, are below 1 %.
const SMALL: f64 = 1e-3;
const MARGIN: f64 = 1.02;

#[derive(Clone, Debug)]
pub struct Number {
    pub value: BigFloat,
    /// How far `f64` may be from it.
    pub off: f64,
}

/// What is computed with.
pub struct Digits {
    constants: Consts,
}

/// A function of one operand: its value; and of its value and the operand the slope, a bound of
/// the bend, and the distance to where both change; and its own error in half ULPs.
pub struct Smooth {
    pub value: fn(&BigFloat, &mut Consts) -> BigFloat,
    pub slope: fn(f64, f64) -> f64,
    pub bend: fn(f64, f64) -> f64,
    pub scale: fn(f64) -> f64,
    pub halves: f64,
}

/// The nearest `f64` or one beside it.
pub fn approximate(x: &BigFloat) -> f64 {
    let Some((words, _, sign, exponent, _)) = x.as_raw_parts() else { return f64::NAN };
    if x.is_zero() {
        return 0.0;
    }
    let top = words[words.len() - 1] as f64 / 2f64.powi(64);
    let size = top * 2f64.powi(exponent.clamp(-1070, 1020));
    if sign == Sign::Neg { -size } else { size }
}

pub fn big(x: f64) -> BigFloat {
    BigFloat::from_f64(x, BITS)
}

macro_rules! function {
    ($x:ident, $constants:ident => $e:expr) => {
        |$x: &BigFloat, $constants: &mut Consts| $e
    };
}

macro_rules! named {
    ($($name:ident)*) => {$(
        pub fn $name(x: &BigFloat, constants: &mut Consts) -> BigFloat {
            x.$name(BITS, ROUND, constants)
        }
    )*};
}

/// The functions by their names.
pub mod of {
    use super::*;
    named! { sin cos tan sinh cosh tanh asin acos atan asinh acosh atanh exp ln log2 }
    pub fn exp2(x: &BigFloat, constants: &mut Consts) -> BigFloat {
        big(2.0).pow(x, BITS, ROUND, constants)
    }
    pub fn sqrt(x: &BigFloat, _: &mut Consts) -> BigFloat {
        x.sqrt(BITS, ROUND)
    }
}

impl Number {
    pub fn exact(x: f64) -> Number {
        Number { value: big(x), off: 0.0 }
    }

    pub fn near(&self) -> f64 {
        approximate(&self.value)
    }

    fn size(&self) -> f64 {
        self.near().abs()
    }

    /// Whether it is known to be on one side of another.
    pub fn apart(&self, other: &Number) -> bool {
        let between = approximate(&self.value.sub(&other.value, BITS, ROUND)).abs();
        between > (self.off + other.off) * MARGIN || self.off == 0.0 && other.off == 0.0
    }

    pub fn less(&self, other: &Number) -> Option<bool> {
        self.apart(other).then(|| self.value.cmp(&other.value).is_some_and(|order| order < 0))
    }
}

/// A value with what it inherited and what its own operation added.
fn made(value: BigFloat, inherited: f64, halves: f64) -> Option<Number> {
    let size = approximate(&value).abs();
    // Not near where `f64` overflows, or loses digits as a subnormal.
    let fits = size < 1e100 && (size > 1e-100 || value.is_zero());
    let off = inherited * MARGIN + halves * HALF_ULP * size * MARGIN;
    (fits && off.is_finite()).then_some(Number { value, off })
}

impl Digits {
    pub fn new() -> Digits {
        Digits { constants: Consts::new().expect("there is memory") }
    }

    pub fn add(&self, a: &Number, b: &Number) -> Option<Number> {
        made(a.value.add(&b.value, BITS, ROUND), a.off + b.off, 1.0)
    }

    pub fn sub(&self, a: &Number, b: &Number) -> Option<Number> {
        self.add(a, &self.neg(b))
    }

    pub fn neg(&self, a: &Number) -> Number {
        Number { value: a.value.neg(), off: a.off }
    }

    /// Without the rounding of an `f64`, for what rounds once in the end.
    pub fn product(&self, a: &Number, b: &Number, halves: f64) -> Option<Number> {
        let inherited = a.size() * b.off + b.size() * a.off + a.off * b.off;
        made(a.value.mul(&b.value, BITS, ROUND), inherited, halves)
    }

    pub fn mul(&self, a: &Number, b: &Number) -> Option<Number> {
        self.product(a, b, 1.0)
    }

    pub fn div(&self, a: &Number, b: &Number) -> Option<Number> {
        if b.value.is_zero() || b.off > SMALL * b.size() {
            return None;
        }
        let value = a.value.div(&b.value, BITS, ROUND);
        let inherited = (a.off + approximate(&value).abs() * b.off) / b.size();
        made(value, inherited, 1.0)
    }

    /// `a - b trunc(a / b)`, which an `f64` has without rounding.
    pub fn rem(&self, a: &Number, b: &Number) -> Option<Number> {
        let quotient = self.div(a, b)?;
        let whole = self.trunc(&Number { off: (a.off + b.off).min(quotient.off), ..quotient })?;
        if whole.size() > 1e9 {
            return None;
        }
        let value = a.value.sub(&b.value.mul(&whole.value, BITS, ROUND), BITS, ROUND);
        made(value, a.off + whole.size() * b.off, 0.0)
    }

    /// A function with a jump at each whole number, or half, that `at` shifts onto them.
    fn jumping(&self, x: &Number, at: f64, f: fn(&BigFloat) -> BigFloat) -> Option<Number> {
        let shifted = x.value.add(&big(at), BITS, ROUND);
        let nearest = |of: BigFloat| approximate(&shifted.sub(&of, BITS, ROUND)).abs();
        let jump = nearest(shifted.floor()).min(nearest(shifted.ceil()));
        let sure = x.off == 0.0 || jump > x.off * MARGIN;
        sure.then(|| Number { value: f(&x.value), off: 0.0 })
    }

    pub fn floor(&self, x: &Number) -> Option<Number> {
        self.jumping(x, 0.0, BigFloat::floor)
    }

    pub fn ceil(&self, x: &Number) -> Option<Number> {
        self.jumping(x, 0.0, BigFloat::ceil)
    }

    pub fn trunc(&self, x: &Number) -> Option<Number> {
        self.jumping(x, 0.0, |x| if x.is_negative() { x.ceil() } else { x.floor() })
    }

    /// The nearest whole number, the even one of two.
    pub fn round(&self, x: &Number) -> Option<Number> {
        self.jumping(x, 0.5, |x| {
            let (low, high) = (x.floor(), x.ceil());
            let below = x.sub(&low, BITS, ROUND);
            match below.cmp(&big(0.5)) {
                Some(order) if order < 0 => low,
                Some(0) if low.div(&big(2.0), BITS, ROUND).is_int() => low,
                _ => high,
            }
        })
    }

    pub fn smooth(&mut self, x: &Number, f: &Smooth) -> Option<Number> {
        let value = (f.value)(&x.value, &mut self.constants);
        if value.is_nan() || value.is_inf() || x.off > SMALL * (f.scale)(x.near()) {
            return None;
        }
        let (near, out) = (x.near(), approximate(&value));
        let inherited = match x.off {
            0.0 => 0.0,
            off => (f.slope)(near, out).abs() * off + (f.bend)(near, out).abs() * off * off,
        };
        made(value, inherited, f.halves)
    }

    /// Of a base above zero.
    pub fn pow(&mut self, x: &Number, y: &Number) -> Option<Number> {
        let (base, log) = (x.near(), x.near().abs().ln());
        let steep = 1.0 + y.size();
        if base <= 0.0 || x.off * steep > SMALL * base || y.off * log.abs() > SMALL {
            return None;
        }
        let value = x.value.pow(&y.value, BITS, ROUND, &mut self.constants);
        let size = approximate(&value).abs();
        made(value, size * (y.size() * x.off / base + log.abs() * y.off), 2.0)
    }

    pub fn atan2(&mut self, y: &Number, x: &Number) -> Option<Number> {
        let zero = Number::exact(0.0);
        let square = x.near() * x.near() + y.near() * y.near();
        let far = x.off + y.off <= SMALL * square.sqrt();
        if square == 0.0 || !far || y.value.is_zero() || x.value.is_zero() || !y.apart(&zero) {
            return None;
        }
        let atan = of::atan(&y.value.div(&x.value, BITS, ROUND), &mut self.constants);
        let pi = self.constants.pi(BITS, ROUND);
        let value = match (x.value.is_negative(), y.value.is_negative()) {
            (false, _) => atan,
            (true, false) => atan.add(&pi, BITS, ROUND),
            (true, true) => atan.sub(&pi, BITS, ROUND),
        };
        made(value, (x.size() * y.off + y.size() * x.off) / square, 2.0)
    }

    pub fn min(&self, a: &Number, b: &Number) -> Number {
        Number { value: a.value.min(&b.value), off: a.off.max(b.off) }
    }

    pub fn max(&self, a: &Number, b: &Number) -> Number {
        Number { value: a.value.max(&b.value), off: a.off.max(b.off) }
    }

    pub fn abs(&self, x: &Number) -> Number {
        Number { value: x.value.abs(), off: x.off }
    }

    pub fn pi_over(&mut self, n: f64) -> BigFloat {
        self.constants.pi(BITS, ROUND).div(&big(n), BITS, ROUND)
    }

    /// Times a constant that `f64` has rounded.
    pub fn scaled(&mut self, x: &Number, by: BigFloat) -> Option<Number> {
        made(x.value.mul(&by, BITS, ROUND), approximate(&by).abs() * x.off, 2.0)
    }

    /// The fraction of `frexp`, from 0.5 to 1.
    pub fn fraction(&self, x: &Number) -> Option<Number> {
        let exponent = x.value.exponent().filter(|_| !x.value.is_zero())?;
        let half = 2f64.powi(exponent - 1);
        // On either side of a power of two it is another.
        let sure = x.size() - half > x.off * MARGIN && 2.0 * half - x.size() > x.off * MARGIN;
        if !sure && x.off > 0.0 {
            return None;
        }
        let mut value = x.value.clone();
        value.set_exponent(0);
        made(value, x.off / (2.0 * half), 0.0)
    }
}

/// By name: each as accurate as the library of the platform says it is, in ULP 0.5 to 2.2.
pub fn smooth(name: &str) -> Option<Smooth> {
    let one = |_: f64| 1.0;
    let whole = |value, slope, bend| Smooth { value, slope, bend, scale: one, halves: 2.0 };
    Some(match name {
        "sqrt" => Smooth {
            value: of::sqrt,
            slope: |_, y| 0.5 / y,
            bend: |x, y| 0.25 / (x * y),
            scale: |x| x,
            halves: 1.0,
        },
        "inverseSqrt" => Smooth {
            value: function!(x, _c => big(1.0).div(&x.sqrt(BITS, ROUND), BITS, ROUND)),
            slope: |x, y| 0.5 * y / x,
            bend: |x, y| y / (x * x),
            scale: |x| x,
            halves: 2.0,
        },
        "exp" => whole(of::exp, |_, y| y, |_, y| y),
        "exp2" => whole(of::exp2, |_, y| y, |_, y| y),
        "log" => Smooth { scale: |x| x, ..whole(of::ln, |x, _| 1.0 / x, |x, _| 1.0 / (x * x)) },
        "log2" => Smooth { scale: |x| x, ..whole(of::log2, |x, _| 1.5 / x, |x, _| 1.0 / (x * x)) },
        "sin" => whole(of::sin, |x, _| x.cos(), |_, _| 1.0),
        "cos" => whole(of::cos, |x, _| x.sin(), |_, _| 1.0),
        "tan" => Smooth {
            scale: |x| x.cos().abs(),
            ..whole(of::tan, |_, y| 1.0 + y * y, |_, y| (1.0 + y * y) * (1.0 + 2.0 * y.abs()))
        },
        "sinh" => Smooth { halves: 5.0, ..whole(of::sinh, |x, _| x.cosh(), |x, _| x.cosh()) },
        "cosh" => Smooth { halves: 5.0, ..whole(of::cosh, |x, _| x.sinh(), |x, _| x.cosh()) },
        "tanh" => Smooth { halves: 5.0, ..whole(of::tanh, |_, y| 1.0 - y * y, |_, _| 1.0) },
        "asin" | "acos" => Smooth {
            value: if name == "asin" { of::asin } else { of::acos },
            slope: |x, _| 1.0 / ((1.0 - x) * (1.0 + x)).sqrt(),
            bend: |x, _| 1.0 / ((1.0 - x) * (1.0 + x)).powf(1.5),
            scale: |x| 1.0 - x.abs(),
            halves: 2.0,
        },
        "atan" => whole(of::atan, |x, _| 1.0 / (1.0 + x * x), |_, _| 1.0),
        "asinh" => Smooth {
            halves: 8.0,
            ..whole(of::asinh, |x, _| 1.0 / (1.0 + x * x).sqrt(), |_, _| 1.0)
        },
        "acosh" => Smooth {
            value: of::acosh,
            slope: |x, _| 1.0 / ((x - 1.0) * (x + 1.0)).sqrt(),
            bend: |x, _| x / ((x - 1.0) * (x + 1.0)).powf(1.5),
            scale: |x| x - 1.0,
            halves: 8.0,
        },
        "atanh" => Smooth {
            value: of::atanh,
            slope: |x, _| 1.0 / ((1.0 - x) * (1.0 + x)),
            bend: |x, _| 2.0 / ((1.0 - x) * (1.0 + x)).powi(2),
            scale: |x| 1.0 - x.abs(),
            halves: 8.0,
        },
        _ => return None,
    })
}
