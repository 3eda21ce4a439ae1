//! The true values, in f64 to some 1e-14: series of our own, so that they share no code with
//! the evaluator, which asks the library of the platform. Feeds the permitted intervals.

use std::f64::consts::{FRAC_PI_2, LN_2, PI};

/// Terms of a series in `x` whose first is `first`, each the last times `ratio(n)`.
fn series(first: f64, ratio: impl Fn(f64) -> f64) -> f64 {
    let (mut term, mut sum, mut n) = (first, 0.0, 1.0);
    while term != 0.0 && term.abs() > sum * 1e-19_f64.copysign(sum) {
        sum += term;
        term *= ratio(n);
        n += 1.0;
    }
    sum
}

pub fn exp(x: f64) -> f64 {
    if x.abs() > 700.0 {
        return if x > 0.0 { f64::INFINITY } else { 0.0 };
    }
    let whole = (x / LN_2).round();
    // The first part of ln 2 has 32 bits, so that its multiples are exact.
    let high = f64::from_bits(LN_2.to_bits() & !0x1f_ffff);
    // What ln 2 has beyond f64 is 2.3190468138462996e-17.
    let rest = (x - whole * high) - whole * ((LN_2 - high) + 2.319_046_813_846_299_6e-17);
    series(1.0, |n| rest / n) * 2f64.powi(whole as i32)
}

pub fn exp2(x: f64) -> f64 {
    let whole = x.round();
    if whole.abs() > 1000.0 {
        return if x > 0.0 { f64::INFINITY } else { 0.0 };
    }
    series(1.0, |n| (x - whole) * LN_2 / n) * 2f64.powi(whole as i32)
}

/// `ln((1 + s) / (1 - s))`, for small `s`.
fn ln_of_quotient(s: f64) -> f64 {
    let mut sum = 0.0;
    for k in (0..24).rev() {
        sum = sum * s * s + 1.0 / f64::from(2 * k + 1);
    }
    2.0 * s * sum
}

/// Logarithm of the fraction, which is near 1, and the exponent.
fn parts(x: f64) -> (f64, f64) {
    let mut exponent = f64::from((x.to_bits() >> 52) as u32) - 1023.0;
    let mut fraction = f64::from_bits(x.to_bits() & (u64::MAX >> 12) | 1023 << 52);
    if fraction > std::f64::consts::SQRT_2 {
        fraction /= 2.0;
        exponent += 1.0;
    }
    (ln_of_quotient((fraction - 1.0) / (fraction + 1.0)), exponent)
}

pub fn ln(x: f64) -> f64 {
    let (near, exponent) = parts(x);
    near + exponent * LN_2
}

pub fn log2(x: f64) -> f64 {
    let (near, exponent) = parts(x);
    near / LN_2 + exponent
}

fn ln_1p(y: f64) -> f64 {
    if y.abs() < 0.4 { ln_of_quotient(y / (2.0 + y)) } else { ln(1.0 + y) }
}

/// What is left by a quarter turn, and which quarter.
fn quarter(x: f64) -> (f64, i64) {
    let quarters = (x / FRAC_PI_2).round();
    let high = f64::from_bits(FRAC_PI_2.to_bits() & !0x3ff_ffff);
    // What half of pi has beyond f64 is 6.123233995736766e-17.
    let low = (FRAC_PI_2 - high) + 6.123_233_995_736_766e-17;
    ((x - quarters * high) - quarters * low, quarters as i64)
}

fn sin_series(r: f64) -> f64 {
    series(r, |n| -r * r / ((2.0 * n) * (2.0 * n + 1.0)))
}

fn cos_series(r: f64) -> f64 {
    series(1.0, |n| -r * r / ((2.0 * n - 1.0) * (2.0 * n)))
}

pub fn sin(x: f64) -> f64 {
    let (rest, quarters) = quarter(x);
    match quarters.rem_euclid(4) {
        0 => sin_series(rest),
        1 => cos_series(rest),
        2 => -sin_series(rest),
        _ => -cos_series(rest),
    }
}

pub fn cos(x: f64) -> f64 {
    let (rest, quarters) = quarter(x);
    match quarters.rem_euclid(4) {
        0 => cos_series(rest),
        1 => -sin_series(rest),
        2 => -cos_series(rest),
        _ => sin_series(rest),
    }
}

pub fn tan(x: f64) -> f64 {
    sin(x) / cos(x)
}

pub fn atan(x: f64) -> f64 {
    if x.abs() > 1.0 {
        return FRAC_PI_2.copysign(x) - atan(1.0 / x);
    }
    let half = |x: f64| x / (1.0 + (1.0 + x * x).sqrt());
    let eighth = half(half(half(x)));
    let mut sum = 0.0;
    for k in (0..16).rev() {
        sum = 1.0 / f64::from(2 * k + 1) - sum * eighth * eighth;
    }
    8.0 * eighth * sum
}

pub fn atan2(y: f64, x: f64) -> f64 {
    match (x > 0.0, y == 0.0) {
        (true, _) => atan(y / x),
        (false, true) if x == 0.0 && x.is_sign_positive() => y,
        (false, true) => PI.copysign(y),
        (false, false) if x == 0.0 => FRAC_PI_2.copysign(y),
        (false, false) => PI.copysign(y) + atan(y / x),
    }
}

pub fn asin(x: f64) -> f64 {
    atan2(x, ((1.0 - x) * (1.0 + x)).sqrt())
}

pub fn acos(x: f64) -> f64 {
    2.0 * atan2((1.0 - x).sqrt(), (1.0 + x).sqrt())
}

pub fn sinh(x: f64) -> f64 {
    if x.abs() < 1.0 {
        return series(x, |n| x * x / ((2.0 * n) * (2.0 * n + 1.0)));
    }
    (exp(x) - exp(-x)) / 2.0
}

pub fn cosh(x: f64) -> f64 {
    (exp(x) + exp(-x)) / 2.0
}

pub fn tanh(x: f64) -> f64 {
    if x.abs() > 30.0 { 1f64.copysign(x) } else { sinh(x) / cosh(x) }
}

pub fn asinh(x: f64) -> f64 {
    let a = x.abs();
    ln_1p(a + a * a / (1.0 + (1.0 + a * a).sqrt())).copysign(x)
}

pub fn acosh(x: f64) -> f64 {
    let t = x - 1.0;
    ln_1p(t + (t * (t + 2.0)).sqrt())
}

pub fn atanh(x: f64) -> f64 {
    ln_1p(2.0 * x / (1.0 - x)) / 2.0
}

pub fn pow(x: f64, y: f64) -> f64 {
    exp2(y * log2(x))
}

/// Another implementation says the same, so a slip in a series does not go unseen.
#[test]
fn the_truth_agrees_with_the_library_of_the_platform() {
    type Pair = (&'static str, fn(f64) -> f64, fn(f64) -> f64, f64, f64);
    let pairs: [Pair; 17] = [
        ("exp", exp, f64::exp, -90.0, 89.0),
        ("exp2", exp2, f64::exp2, -127.0, 128.0),
        ("ln", ln, f64::ln, 1e-6, 1e9),
        ("log2", log2, f64::log2, 1e-6, 1e9),
        ("sin", sin, f64::sin, -PI, PI),
        ("cos", cos, f64::cos, -PI, PI),
        ("tan", tan, f64::tan, -PI, PI),
        ("atan", atan, f64::atan, -50.0, 50.0),
        ("asin", asin, f64::asin, -1.0, 1.0),
        ("acos", acos, f64::acos, -1.0, 1.0),
        ("sinh", sinh, f64::sinh, -80.0, 80.0),
        ("cosh", cosh, f64::cosh, -80.0, 80.0),
        ("tanh", tanh, f64::tanh, -40.0, 40.0),
        ("asinh", asinh, f64::asinh, -1e6, 1e6),
        ("acosh", acosh, f64::acosh, 1.0, 1e6),
        ("atanh", atanh, f64::atanh, -0.9999, 0.9999),
        ("log2 near 1", log2, f64::log2, 0.999, 1.001),
    ];
    let mut random = fastrand::Rng::with_seed(1);
    for (name, ours, theirs, low, high) in pairs {
        for _ in 0..2000 {
            let x = f64::from((low + random.f64() * (high - low)) as f32).clamp(low, high);
            let (a, b) = (ours(x), theirs(x));
            assert!((a - b).abs() <= 2e-14 * b.abs() + 1e-16, "{name} of {x}: {a}, not {b}");
        }
    }
    for (y, x) in [(1.0, 2.0), (1.0, -2.0), (-1.0, -2.0), (-3.0, 0.5), (0.0, -1.0), (2.0, 0.0)] {
        assert!((atan2(y, x) - f64::atan2(y, x)).abs() < 1e-15, "atan2 of {y}, {x}");
    }
}
