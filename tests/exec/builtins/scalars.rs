//! Cases of one to three floats: operators, rounding, quotients, roots and powers. Fed by the
//! intervals, feeds the families.

use super::case::{Allowed, Case};
use super::draw::Draw;
use super::interval::Interval;
use super::truth;

pub const MAX: f32 = f32::MAX;
const CORRECT: &str = "correctly rounded";

pub fn floats(words: &[u32]) -> Vec<f32> {
    words.iter().map(|w| f32::from_bits(*w)).collect()
}

/// One float of a range in, one out.
pub fn one(
    name: &'static str,
    permitted: &'static str,
    result: &'static [&'static str],
    (low, high): (f32, f32),
    judge: impl Fn(f32) -> Allowed + 'static,
) -> Case {
    let draw = move |d: &mut Draw| vec![d.float(low, high).to_bits()];
    Case::new(name, permitted, "f", result, draw, move |w| vec![judge(f32::from_bits(w[0]))])
}

/// As many floats as ranges in, one out.
pub fn more<const N: usize>(
    name: &'static str,
    permitted: &'static str,
    result: &'static [&'static str],
    ranges: [(f32, f32); N],
    judge: impl Fn([f32; N]) -> Allowed + 'static,
) -> Case {
    let draw = move |d: &mut Draw| ranges.iter().map(|(l, h)| d.float(*l, *h).to_bits()).collect();
    let operands = ["f", "f f", "f f f"][N - 1];
    Case::new(name, permitted, operands, result, draw, move |w| {
        vec![judge(std::array::from_fn(|i| f32::from_bits(w[i])))]
    })
}

fn correct(f: impl Fn(f64) -> f64) -> impl Fn(f32) -> Allowed {
    move |x| Allowed::Correct(f(f64::from(x)))
}

pub fn within(
    truth: impl Fn(f64) -> f64,
    interval: impl Fn(Interval) -> Interval,
) -> impl Fn(f32) -> Allowed {
    move |x| Allowed::Within(truth(f64::from(x)), interval(Interval::of(x)))
}

pub fn wide<const N: usize>(values: [f32; N]) -> [f64; N] {
    values.map(f64::from)
}

fn rounds_to_even(x: f64) -> f64 {
    x.round_ties_even()
}

/// Rounding, signs and operators: nothing is left to the device.
pub fn exact() -> Vec<Case> {
    let all = (-MAX, MAX);
    // So that neither sums nor products overflow, where anything may come out.
    let half = (-MAX / 2.0, MAX / 2.0);
    let root = (-1.8e19, 1.8e19);
    let sign = |x: f64| if x == 0.0 { x } else { 1f64.copysign(x) };
    vec![
        more("a + b", CORRECT, &["f a + b"], [half; 2], |v| {
            let [a, b] = wide(v);
            Allowed::Correct(a + b)
        }),
        more("a - b", CORRECT, &["f a - b"], [half; 2], |v| {
            let [a, b] = wide(v);
            Allowed::Correct(a - b)
        }),
        more("a * b", CORRECT, &["f a * b"], [root; 2], |v| {
            let [a, b] = wide(v);
            Allowed::Correct(a * b)
        }),
        one("-a", CORRECT, &["f -a"], all, correct(|x| -x)),
        one("abs", CORRECT, &["f abs(a)"], all, correct(f64::abs)),
        one("sign", CORRECT, &["f sign(a)"], all, correct(sign)),
        one("floor", CORRECT, &["f floor(a)"], all, correct(f64::floor)),
        one("ceil", CORRECT, &["f ceil(a)"], all, correct(f64::ceil)),
        one("trunc", CORRECT, &["f trunc(a)"], all, correct(f64::trunc)),
        // In GLSL `round` may go either way from a half; we say roundEven.
        one("round", CORRECT, &["f roundEven(a)"], all, correct(rounds_to_even)),
        one("fract", CORRECT, &["f fract(a)"], all, correct(|x| x - x.floor())),
        more("min", CORRECT, &["f min(a, b)"], [all; 2], |[a, b]| {
            Allowed::Correct(f64::from(if b < a { b } else { a }))
        }),
        more("max", CORRECT, &["f max(a, b)"], [all; 2], |[a, b]| {
            Allowed::Correct(f64::from(if a < b { b } else { a }))
        }),
        clamp(),
        more("step", CORRECT, &["f step(a, b)"], [all; 2], |[edge, x]| {
            Allowed::Correct(f64::from(u8::from(edge <= x)))
        }),
        more(
            "comparisons",
            CORRECT,
            &[
                "u uint(a < b) | uint(a <= b) << 1 | uint(a > b) << 2 | uint(a >= b) << 3 | uint(a == b) << 4 | uint(a != b) << 5",
            ],
            [(-2.0, 2.0); 2],
            |[a, b]| {
                let all = [a < b, a <= b, a > b, a >= b, a == b, a != b];
                Allowed::Word(all.iter().enumerate().map(|(i, yes)| u32::from(*yes) << i).sum())
            },
        ),
        modf(),
        frexp(),
        ldexp(),
    ]
}

fn clamp() -> Case {
    let draw = |d: &mut Draw| {
        let (x, y) = (d.float(-MAX, MAX), d.float(-MAX, MAX));
        [d.float(-MAX, MAX), x.min(y), x.max(y)].map(f32::to_bits).to_vec()
    };
    Case::new("clamp", CORRECT, "f f f", &["f clamp(a, b, c)"], draw, |w| {
        let [x, low, high] = [w[0], w[1], w[2]].map(f32::from_bits);
        let above = if x < low { low } else { x };
        vec![Allowed::Correct(f64::from(if high < above { high } else { above }))]
    })
}

fn modf() -> Case {
    let draw = |d: &mut Draw| vec![d.float(-MAX, MAX).to_bits()];
    let case = Case::new("modf", CORRECT, "f", &["f part", "f whole"], draw, |w| {
        let x = f64::from(f32::from_bits(w[0]));
        vec![Allowed::Correct(x - x.trunc()), Allowed::Correct(x.trunc())]
    });
    case.before("    float whole;\n    float part = modf(a, whole);\n")
}

fn frexp() -> Case {
    // What becomes of subnormals is left open where they may be flushed.
    let draw = |d: &mut Draw| {
        let x = d.float(-MAX, MAX);
        vec![if x.is_subnormal() { 0 } else { x.to_bits() }]
    };
    let case = Case::new("frexp", CORRECT, "f", &["f part", "i exponent"], draw, |w| {
        let x = f32::from_bits(w[0]);
        if x == 0.0 {
            return vec![Allowed::Correct(f64::from(x)), Allowed::Word(0)];
        }
        // A fraction of 0.5 up to 1: the exponent is one more than that of 1 to 2.
        let exponent = (w[0] >> 23 & 0xff) as i32 - 126;
        let part = f64::from(x) / 2f64.powi(exponent);
        vec![Allowed::Correct(part), Allowed::Word(exponent as u32)]
    });
    case.before("    int exponent;\n    float part = frexp(a, exponent);\n")
}

fn ldexp() -> Case {
    let draw = |d: &mut Draw| {
        let x = d.float(-MAX, MAX);
        let own = (x.to_bits() >> 23 & 0xff) as i32 - 127;
        // Results are normal, and the exponent of the spec's range.
        let to = d.0.i32(-126..=126);
        let e = (to - own).clamp(-126, 128);
        if x.is_subnormal() || !(-126..=126).contains(&(own + e)) {
            return vec![1f32.to_bits(), to as u32];
        }
        vec![x.to_bits(), e as u32]
    };
    Case::new("ldexp", CORRECT, "f i", &["f ldexp(a, b)"], draw, |w| {
        vec![Allowed::Correct(f64::from(f32::from_bits(w[0])) * 2f64.powi(w[1] as i32))]
    })
}

/// Quotients, roots, powers, and formulas of them.
pub fn inexact() -> Vec<Case> {
    let two_126 = 2f32.powi(126);
    let unit = (0.0, 1.0);
    let normal = (f32::MIN_POSITIVE, MAX);
    vec![
        more("a / b", "2.5 ULP", &["f a / b"], [(-1e18, 1e18), (1e-18, two_126)], |[a, b]| {
            let within = Interval::of(a).div(Interval::of(b));
            Allowed::Within(f64::from(a) / f64::from(b), within)
        }),
        more(
            "mod",
            "from `a - b * floor(a / b)`",
            &["f mod(a, b)"],
            [(-1e4, 1e4), (0.1, 1e3)],
            |[a, b]| {
                let [x, y] = wide([a, b]);
                let quotient = Interval::of(a).div(Interval::of(b)).whole(f64::floor);
                let product = quotient.mul(Interval::of(b));
                Allowed::Within(x - y * (x / y).floor(), Interval::of(a).sub(product))
            },
        ),
        one(
            "sqrt",
            "from `1 / inverseSqrt(a)`",
            &["f sqrt(a)"],
            normal,
            within(f64::sqrt, Interval::sqrt),
        ),
        one(
            "inverseSqrt",
            "2 ULP",
            &["f inversesqrt(a)"],
            normal,
            within(|x| 1.0 / x.sqrt(), Interval::inverse_sqrt),
        ),
        one(
            "exp",
            "3 + 2\\|a\\| ULP",
            &["f exp(a)"],
            (-87.0, 88.7),
            within(truth::exp, Interval::exp),
        ),
        one(
            "exp2",
            "3 + 2\\|a\\| ULP",
            &["f exp2(a)"],
            (-126.0, 127.9),
            within(truth::exp2, Interval::exp2),
        ),
        one(
            "log",
            "3 ULP; 2^-21 from 0.5 to 2",
            &["f log(a)"],
            normal,
            within(truth::ln, Interval::ln),
        ),
        one(
            "log near 1",
            "3 ULP; 2^-21 from 0.5 to 2",
            &["f log(a)"],
            (0.4, 2.5),
            within(truth::ln, Interval::ln),
        ),
        one(
            "log2",
            "3 ULP; 2^-21 from 0.5 to 2",
            &["f log2(a)"],
            normal,
            within(truth::log2, Interval::log2),
        ),
        one(
            "log2 near 1",
            "3 ULP; 2^-21 from 0.5 to 2",
            &["f log2(a)"],
            (0.4, 2.5),
            within(truth::log2, Interval::log2),
        ),
        pow(),
        more(
            "pow of 0 to 1, to 1000",
            "from `exp2(b * log2(a))`",
            &["f pow(a, b)"],
            [(0.9, 1.0), (1.0, 1000.0)],
            judge_pow,
        ),
        more("fma", "from `a * b + c`", &["f fma(a, b, c)"], [(-1e9, 1e9); 3], |v| {
            let [a, b, c] = wide(v);
            let [x, y, z] = v.map(Interval::of);
            Allowed::Within(a * b + c, x.mul(y).add(z))
        }),
        more(
            "mix",
            "from `a * (1 - c) + b * c`",
            &["f mix(a, b, c)"],
            [(-1e9, 1e9), (-1e9, 1e9), unit],
            |v| {
                let [a, b, c] = wide(v);
                let [x, y, t] = v.map(Interval::of);
                let one = Interval::of(1.0);
                Allowed::Within(a * (1.0 - c) + b * c, x.mul(one.sub(t)).add(y.mul(t)))
            },
        ),
        more(
            "smoothstep",
            "from `t * t * (3 - 2 * t)`",
            &["f smoothstep(a, b, c)"],
            [(-10.0, -0.1), (0.1, 10.0), (-12.0, 12.0)],
            |v| {
                let [low, high, x] = v.map(Interval::of);
                let (zero, one) = (Interval::of(0.0), Interval::of(1.0));
                let t = x.sub(low).div(high.sub(low)).max(zero).min(one);
                let within = t.mul(t).mul(Interval::of(3.0).sub(Interval::of(2.0).mul(t)));
                let [low, high, x] = wide(v);
                let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
                Allowed::Within(t * t * (3.0 - 2.0 * t), within)
            },
        ),
        one(
            "degrees",
            "from `a * 57.29…`",
            &["f degrees(a)"],
            (-5e36, 5e36),
            within(f64::to_degrees, |x| x.mul(Interval::constant(57.295_779_513_082_32))),
        ),
        one(
            "radians",
            "from `a * 0.0174…`",
            &["f radians(a)"],
            (-MAX, MAX),
            within(f64::to_radians, |x| x.mul(Interval::constant(0.017_453_292_519_943_295))),
        ),
    ]
}

fn judge_pow([x, y]: [f32; 2]) -> Allowed {
    let within = Interval::of(y).mul(Interval::of(x).log2()).exp2();
    Allowed::Within(truth::pow(f64::from(x), f64::from(y)), within)
}

fn pow() -> Case {
    let draw = |d: &mut Draw| {
        let x = d.float(f32::MIN_POSITIVE, MAX);
        let y = d.float(-125.0, 125.0) / x.log2().abs().max(1e-3);
        [x, y].map(f32::to_bits).to_vec()
    };
    Case::new("pow", "from `exp2(b * log2(a))`", "f f", &["f pow(a, b)"], draw, |w| {
        vec![judge_pow([f32::from_bits(w[0]), f32::from_bits(w[1])])]
    })
}
