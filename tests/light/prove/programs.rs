//! Programs of FPBench (<https://fpbench.org>) that a shader can express, with their ranges; each as
//! GLSL and once more in numbers of 86 digits.

// The ranges are those that were published.
#![allow(clippy::approx_constant)]

use std::cell::RefCell;
use std::ops::{Add, Div, Mul, Neg, Sub};

use astro_float_num::{BigFloat, Consts, RoundingMode, Sign};

/// A program.
pub struct Program {
    pub name: &'static str,
    /// The least and greatest value of each input.
    pub domain: &'static [(&'static str, f64, f64)],
    /// The function `f`.
    pub code: &'static str,
    /// The bound that FPTaylor's authors report for `f64` (Solovyev et al., FM 2015), where known.
    pub published: Option<f64>,
    /// The same formula in 86 digits, with the constants of an `f32`.
    pub exact: fn(&[Digits]) -> Digits,
}

/// A number of 86 digits.
#[derive(Clone, Debug)]
pub struct Digits(BigFloat);

const BITS: usize = 288;
const ROUND: RoundingMode = RoundingMode::ToEven;

thread_local! {
    static CONSTANTS: RefCell<Consts> = RefCell::new(Consts::new().expect("there is memory"));
}

/// A constant of a shader.
pub fn c(x: f32) -> Digits {
    Digits::of(f64::from(x))
}

impl Digits {
    pub fn of(x: f64) -> Digits {
        Digits(BigFloat::from_f64(x, BITS))
    }

    fn map(&self, f: impl Fn(&BigFloat, &mut Consts) -> BigFloat) -> Digits {
        CONSTANTS.with(|constants| Digits(f(&self.0, &mut constants.borrow_mut())))
    }

    fn sin(&self) -> Digits {
        self.map(|x, constants| x.sin(BITS, ROUND, constants))
    }

    fn cos(&self) -> Digits {
        self.map(|x, constants| x.cos(BITS, ROUND, constants))
    }

    fn atan(&self) -> Digits {
        self.map(|x, constants| x.atan(BITS, ROUND, constants))
    }

    /// The nearest `f64` or one beside it.
    pub fn near(&self) -> f64 {
        let Some((words, _, sign, exponent, _)) = self.0.as_raw_parts() else { return f64::NAN };
        if self.0.is_zero() {
            return 0.0;
        }
        let top = words[words.len() - 1] as f64 / 2f64.powi(64);
        let size = top * 2f64.powi(exponent.clamp(-1070, 1020));
        if sign == Sign::Neg { -size } else { size }
    }
}

macro_rules! operator {
    ($($name:ident $call:ident $by:ident),*) => {$(
        impl $name for &Digits {
            type Output = Digits;
            fn $call(self, other: &Digits) -> Digits {
                Digits(self.0.$by(&other.0, BITS, ROUND))
            }
        }
        impl $name for Digits {
            type Output = Digits;
            fn $call(self, other: Digits) -> Digits {
                Digits(self.0.$by(&other.0, BITS, ROUND))
            }
        }
    )*};
}

operator!(Add add add, Sub sub sub, Mul mul mul, Div div div);

impl Neg for Digits {
    type Output = Digits;
    fn neg(self) -> Digits {
        Digits(self.0.neg())
    }
}

const RIGID: &[(&str, f64, f64)] = &[("x", -15.0, 15.0), ("y", -15.0, 15.0), ("z", -15.0, 15.0)];
const TURBINE: &[(&str, f64, f64)] = &[("v", -4.5, -0.3), ("w", 0.4, 0.9), ("r", 3.8, 7.8)];
const DOPPLER: &str = "float f(float u, float v, float t) {
    float t1 = 331.4 + 0.6 * t;
    return (-t1 * v) / ((t1 + u) * (t1 + u));
}";

fn doppler(x: &[Digits]) -> Digits {
    let t1 = c(331.4) + c(0.6) * x[2].clone();
    let sum = &t1 + &x[0];
    -(t1 * x[1].clone()) / (&sum * &sum)
}

/// The powers of a number from the first on, as products from the left.
fn powers(x: &Digits, count: usize) -> Vec<Digits> {
    let mut all = vec![x.clone()];
    while all.len() < count {
        all.push(&all[all.len() - 1] * x);
    }
    all
}

pub const PROGRAMS: &[Program] = &[
    Program {
        name: "doppler1",
        domain: &[("u", -100.0, 100.0), ("v", 20.0, 20000.0), ("t", -30.0, 50.0)],
        code: DOPPLER,
        published: Some(1.59e-13),
        exact: doppler,
    },
    Program {
        name: "doppler2",
        domain: &[("u", -125.0, 125.0), ("v", 15.0, 25000.0), ("t", -40.0, 60.0)],
        code: DOPPLER,
        published: None,
        exact: doppler,
    },
    Program {
        name: "doppler3",
        domain: &[("u", -30.0, 120.0), ("v", 320.0, 20300.0), ("t", -50.0, 30.0)],
        code: DOPPLER,
        published: None,
        exact: doppler,
    },
    Program {
        name: "rigidBody1",
        domain: RIGID,
        code: "float f(float x, float y, float z) {
    return -(x * y) - 2.0 * y * z - x - z;
}",
        published: Some(3.87e-13),
        exact: |x| {
            let [x, y, z] = [&x[0], &x[1], &x[2]];
            -(x * y) - c(2.0) * (y * z) - x.clone() - z.clone()
        },
    },
    Program {
        name: "rigidBody2",
        domain: RIGID,
        code: "float f(float x, float y, float z) {
    return 2.0 * (x * y * z) + 3.0 * z * z - y * (x * y * z) + 3.0 * z * z - y;
}",
        published: None,
        exact: |x| {
            let [x, y, z] = [&x[0], &x[1], &x[2]];
            let xyz = &(x * y) * z;
            let zz = c(3.0) * (z * z);
            c(2.0) * xyz.clone() + zz.clone() - y * &xyz + zz - y.clone()
        },
    },
    Program {
        name: "sphere",
        domain: &[
            ("x", -10.0, 10.0),
            ("r", 0.0, 10.0),
            ("lat", -1.570796, 1.570796),
            ("lon", -3.14159265, 3.14159265),
        ],
        code: "float f(float x, float r, float lat, float lon) {
    return x + r * sin(lat) * cos(lon);
}",
        published: Some(1.01e-14),
        exact: |x| x[0].clone() + x[1].clone() * x[2].sin() * x[3].cos(),
    },
    Program {
        name: "azimuth",
        domain: &[
            ("lat1", 0.0, 0.4),
            ("lat2", 0.5, 1.0),
            ("lon1", 0.0, 3.14159265),
            ("lon2", -3.14159265, -0.5),
        ],
        code: "float f(float lat1, float lat2, float lon1, float lon2) {
    float d = lon2 - lon1;
    return atan((cos(lat2) * sin(d))
        / (cos(lat1) * sin(lat2) - sin(lat1) * cos(lat2) * cos(d)));
}",
        published: Some(1.17e-14),
        exact: |x| {
            let d = &x[3] - &x[2];
            let north = x[0].cos() * x[1].sin() - x[0].sin() * x[1].cos() * d.cos();
            (x[1].cos() * d.sin() / north).atan()
        },
    },
    Program {
        name: "turbine1",
        domain: TURBINE,
        code: "float f(float v, float w, float r) {
    return 3.0 + 2.0 / (r * r) - 0.125 * (3.0 - 2.0 * v) * (w * w * r * r) / (1.0 - v) - 4.5;
}",
        published: Some(2.2e-14),
        exact: |x| {
            let [v, w, r] = [&x[0], &x[1], &x[2]];
            let area = c(0.125) * (c(3.0) - c(2.0) * v.clone()) * (w * w) * (r * r);
            c(3.0) + c(2.0) / (r * r) - area / (c(1.0) - v.clone()) - c(4.5)
        },
    },
    Program {
        name: "turbine2",
        domain: TURBINE,
        code: "float f(float v, float w, float r) {
    return 6.0 * v - 0.5 * v * (w * w * r * r) / (1.0 - v) - 2.5;
}",
        published: None,
        exact: |x| {
            let [v, w, r] = [&x[0], &x[1], &x[2]];
            let area = c(0.5) * v.clone() * (w * w) * (r * r);
            c(6.0) * v.clone() - area / (c(1.0) - v.clone()) - c(2.5)
        },
    },
    Program {
        name: "turbine3",
        domain: TURBINE,
        code: "float f(float v, float w, float r) {
    return 3.0 - 2.0 / (r * r) - 0.125 * (1.0 + 2.0 * v) * (w * w * r * r) / (1.0 - v) - 0.5;
}",
        published: None,
        exact: |x| {
            let [v, w, r] = [&x[0], &x[1], &x[2]];
            let area = c(0.125) * (c(1.0) + c(2.0) * v.clone()) * (w * w) * (r * r);
            c(3.0) - c(2.0) / (r * r) - area / (c(1.0) - v.clone()) - c(0.5)
        },
    },
    Program {
        name: "jetEngine",
        domain: &[("x", -5.0, 5.0), ("y", -20.0, 5.0)],
        code: "float f(float x, float y) {
    float t = 3.0 * x * x + 2.0 * y - x;
    float d = x * x + 1.0;
    float s = t / d;
    return x + ((2.0 * x * s * (s - 3.0) + x * x * (4.0 * s - 6.0)) * d
        + 3.0 * x * x * s + x * x * x + x + 3.0 * s);
}",
        published: None,
        exact: |x| {
            let [x, y] = [&x[0], &x[1]];
            let square = x * x;
            let t = c(3.0) * square.clone() + c(2.0) * y.clone() - x.clone();
            let d = square.clone() + c(1.0);
            let s = &t / &d;
            let first = c(2.0) * x.clone() * s.clone() * (s.clone() - c(3.0));
            let second = square.clone() * (c(4.0) * s.clone() - c(6.0));
            let cube = &square * x;
            let rest = c(3.0) * (&square * &s) + cube + x.clone() + c(3.0) * s;
            x.clone() + ((first + second) * d + rest)
        },
    },
    Program {
        name: "verhulst",
        domain: &[("x", 0.1, 0.3)],
        code: "float f(float x) {
    return (4.0 * x) / (1.0 + x / 1.11);
}",
        published: Some(3.24e-16),
        exact: |x| c(4.0) * x[0].clone() / (c(1.0) + x[0].clone() / c(1.11)),
    },
    Program {
        name: "predatorPrey",
        domain: &[("x", 0.1, 0.3)],
        code: "float f(float x) {
    return (4.0 * x * x) / (1.0 + (x / 1.11) * (x / 1.11));
}",
        published: Some(1.84e-16),
        exact: |x| {
            let share = x[0].clone() / c(1.11);
            c(4.0) * (&x[0] * &x[0]) / (c(1.0) + &share * &share)
        },
    },
    Program {
        name: "carbonGas",
        domain: &[("v", 0.1, 0.5)],
        code: "float f(float v) {
    return (3.5e7 + 0.401 * (1000.0 / v) * (1000.0 / v)) * (v - 1000.0 * 42.7e-6)
        - 1.3806503e-23 * 1000.0 * 300.0;
}",
        published: None,
        exact: |x| {
            let n = c(1000.0) / x[0].clone();
            let pressure = c(3.5e7) + c(0.401) * (&n * &n);
            let volume = x[0].clone() - c(1000.0) * c(42.7e-6);
            pressure * volume - c(1.3806503e-23) * c(1000.0) * c(300.0)
        },
    },
    Program {
        name: "sine",
        domain: &[("x", -1.57079632679, 1.57079632679)],
        code: "float f(float x) {
    return x - (x * x * x) / 6.0 + (x * x * x * x * x) / 120.0
        - (x * x * x * x * x * x * x) / 5040.0;
}",
        published: Some(6.03e-16),
        exact: |x| {
            let p = powers(&x[0], 7);
            let [a, b, d, e] = [0, 2, 4, 6].map(|nth| p[nth].clone());
            a - b / c(6.0) + d / c(120.0) - e / c(5040.0)
        },
    },
    Program {
        name: "sineOrder3",
        domain: &[("x", -2.0, 2.0)],
        code: "float f(float x) {
    return 0.954929658551372 * x - 0.12900613773279798 * (x * x * x);
}",
        published: None,
        exact: |x| {
            let cube = &(&x[0] * &x[0]) * &x[0];
            c(0.954_929_66) * x[0].clone() - c(0.129_006_13) * cube
        },
    },
    Program {
        name: "sqroot",
        domain: &[("x", 0.0, 1.0)],
        code: "float f(float x) {
    return 1.0 + 0.5 * x - 0.125 * x * x + 0.0625 * x * x * x - 0.0390625 * x * x * x * x;
}",
        published: Some(5.35e-16),
        exact: |x| {
            let p = powers(&x[0], 4);
            let [a, b, d, e] = [0, 1, 2, 3].map(|nth| p[nth].clone());
            c(1.0) + c(0.5) * a - c(0.125) * b + c(0.0625) * d - c(0.039_062_5) * e
        },
    },
];
