//! Cases of circular and hyperbolic functions, which inherit from `exp`, `log` and `atan2`. Fed
//! by the intervals, feeds the families.

use std::f32::consts::PI;

use super::case::{Allowed, Case};
use super::interval::{ANY, Interval};
use super::scalars::{MAX, more, one, within};
use super::truth;

pub fn all() -> Vec<Case> {
    let one_ = || Interval::of(1.0);
    let half = || Interval::of(0.5);
    let sine = |x: f64| Interval::constant(truth::sin(x)).absolute(2f64.powi(-11));
    let cosine = |x: f64| Interval::constant(truth::cos(x)).absolute(2f64.powi(-11));
    let sinh = move |x: Interval| x.exp().sub(x.neg().exp()).mul(half());
    let cosh = move |x: Interval| x.exp().add(x.neg().exp()).mul(half());
    let circle = (-PI, PI);
    vec![
        one("sin", "2^-11 from -π to π", &["f sin(a)"], circle, move |x| {
            Allowed::Within(truth::sin(f64::from(x)), sine(f64::from(x)))
        }),
        one("cos", "2^-11 from -π to π", &["f cos(a)"], circle, move |x| {
            Allowed::Within(truth::cos(f64::from(x)), cosine(f64::from(x)))
        }),
        one("tan", "from `sin(a) / cos(a)`", &["f tan(a)"], (-1.57, 1.57), move |x| {
            let x = f64::from(x);
            Allowed::Within(truth::tan(x), sine(x).div(cosine(x)))
        }),
        one(
            "asin",
            "6.81e-5, or from `atan2(a, sqrt(1 - a * a))`",
            &["f asin(a)"],
            (-1.0, 1.0),
            move |x| {
                let i = Interval::of(x);
                let truth = truth::asin(f64::from(x));
                let inherited = i.atan2(one_().sub(i.mul(i)).sqrt());
                Allowed::Within(truth, Interval::constant(truth).absolute(6.81e-5).or(inherited))
            },
        ),
        one(
            "acos",
            "6.77e-5, or from `atan2(sqrt(1 - a * a), a)`",
            &["f acos(a)"],
            (-1.0, 1.0),
            move |x| {
                let i = Interval::of(x);
                let truth = truth::acos(f64::from(x));
                let inherited = one_().sub(i.mul(i)).sqrt().atan2(i);
                Allowed::Within(truth, Interval::constant(truth).absolute(6.77e-5).or(inherited))
            },
        ),
        one("atan", "4096 ULP", &["f atan(a)"], (-MAX, MAX), |x| {
            let truth = truth::atan(f64::from(x));
            Allowed::Within(
                truth,
                Interval { low: truth, high: truth }.ulps(4096.0).or(if x.is_subnormal() {
                    Interval::of(x)
                } else {
                    Interval { low: truth, high: truth }
                }),
            )
        }),
        more("atan2", "4096 ULP", &["f atan(a, b)"], [(-1e18, 1e18); 2], |[y, x]| {
            let truth = truth::atan2(f64::from(y), f64::from(x));
            // Undefined for both zero in GLSL; in Vulkan for what is not normal.
            if !x.is_normal() || !y.is_normal() || !(y / x).is_normal() {
                return Allowed::Within(truth, ANY);
            }
            Allowed::Within(truth, Interval::of(y).atan2(Interval::of(x)))
        }),
        one(
            "sinh",
            "from `(exp(a) - exp(-a)) * 0.5`",
            &["f sinh(a)"],
            (-87.0, 87.0),
            within(truth::sinh, sinh),
        ),
        one(
            "cosh",
            "from `(exp(a) + exp(-a)) * 0.5`",
            &["f cosh(a)"],
            (-87.0, 87.0),
            within(truth::cosh, cosh),
        ),
        one("tanh", "1e-5, or from `sinh(a) / cosh(a)`", &["f tanh(a)"], (-87.0, 87.0), move |x| {
            let i = Interval::of(x);
            let truth = truth::tanh(f64::from(x));
            let near = Interval::constant(truth).absolute(1e-5);
            Allowed::Within(truth, near.or(sinh(i).div(cosh(i))))
        }),
        one(
            "asinh",
            "from `log(a + sqrt(a * a + 1))`",
            &["f asinh(a)"],
            (-1e4, 1e9),
            within(truth::asinh, move |x| x.add(x.mul(x).add(one_()).sqrt()).ln()),
        ),
        one(
            "acosh",
            "from `log(a + sqrt(a * a - 1))`",
            &["f acosh(a)"],
            (1.0, 1e18),
            within(truth::acosh, move |x| {
                // The root of what may be zero is zero or more.
                let square = x.mul(x).sub(one_());
                let top =
                    Interval { low: square.high.max(1e-37), high: square.high.max(1e-37) }.sqrt();
                let root = if square.low <= 0.0 {
                    Interval { low: 0.0, high: top.high }
                } else {
                    square.sqrt()
                };
                x.add(root).ln()
            }),
        ),
        one(
            "atanh",
            "from `log((1 + a) / (1 - a)) * 0.5`",
            &["f atanh(a)"],
            (-0.999_99, 0.999_99),
            within(truth::atanh, move |x| one_().add(x).div(one_().sub(x)).ln().mul(half())),
        ),
    ]
}
