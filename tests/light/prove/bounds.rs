//! Bounds of errors against published ones: programs of FPBench (<https://fpbench.org>) with their
//! ranges, and the bounds that FPTaylor's authors report for `f64` (Solovyev et al., FM 2015, table
//! 1). A bound is at most four times the published one, and not below the largest error seen
//! against exact arithmetic.

use std::time::Duration;

use landfall_exec::harness::call::pure::PureRequest;
use landfall_exec::interp::graph::Rounding;
use landfall_layout::Options;
use landfall_light::accuracy::demand::{Demand, ProveRequest, Shown, prove};

use super::fragment;

/// A program: its text, its ranges, FPTaylor's bound.
struct Program {
    name: &'static str,
    domain: &'static str,
    code: &'static str,
    published: f64,
}

const PROGRAMS: &[Program] = &[
    Program {
        name: "doppler1",
        domain: r#"{"u": [-100, 100], "v": [20, 20000], "t": [-30, 50]}"#,
        code: "float f(float u, float v, float t) {
    float t1 = 331.4 + 0.6 * t;
    return (-t1 * v) / ((t1 + u) * (t1 + u));
}",
        published: 1.59e-13,
    },
    Program {
        name: "rigidBody1",
        domain: r#"{"x": [-15, 15], "y": [-15, 15], "z": [-15, 15]}"#,
        code: "float f(float x, float y, float z) {
    return -(x * y) - 2.0 * y * z - x - z;
}",
        published: 3.87e-13,
    },
    Program {
        name: "sphere",
        domain: r#"{"x": [-10, 10], "r": [0, 10], "lat": [-1.570796, 1.570796],
            "lon": [-3.14159265, 3.14159265]}"#,
        code: "float f(float x, float r, float lat, float lon) {
    return x + r * sin(lat) * cos(lon);
}",
        published: 1.01e-14,
    },
    Program {
        name: "verhulst",
        domain: r#"{"x": [0.1, 0.3]}"#,
        code: "float f(float x) {
    return (4.0 * x) / (1.0 + x / 1.11);
}",
        published: 3.24e-16,
    },
    Program {
        name: "predatorPrey",
        domain: r#"{"x": [0.1, 0.3]}"#,
        code: "float f(float x) {
    return (4.0 * x * x) / (1.0 + (x / 1.11) * (x / 1.11));
}",
        published: 1.84e-16,
    },
    Program {
        name: "sine",
        domain: r#"{"x": [-1.57079632679, 1.57079632679]}"#,
        code: "float f(float x) {
    return x - (x * x * x) / 6.0 + (x * x * x * x * x) / 120.0
        - (x * x * x * x * x * x * x) / 5040.0;
}",
        published: 6.03e-16,
    },
    Program {
        name: "sqroot",
        domain: r#"{"x": [0, 1]}"#,
        code: "float f(float x) {
    return 1.0 + 0.5 * x - 0.125 * x * x + 0.0625 * x * x * x - 0.0390625 * x * x * x * x;
}",
        published: 5.35e-16,
    },
    Program {
        name: "turbine1",
        domain: r#"{"v": [-4.5, -0.3], "w": [0.4, 0.9], "r": [3.8, 7.8]}"#,
        code: "float f(float v, float w, float r) {
    return 3.0 + 2.0 / (r * r) - 0.125 * (3.0 - 2.0 * v) * (w * w * r * r) / (1.0 - v) - 4.5;
}",
        published: 2.2e-14,
    },
];

/// The bound of the error in `f64`.
fn bound_of(program: &Program) -> f64 {
    let request = ProveRequest {
        pure: PureRequest { function: "f".to_string(), ..PureRequest::default() },
        domain: Some(serde_json::from_str(program.domain).expect("the test's domain is JSON")),
        rounding: Rounding::Double,
        time: Duration::from_secs(600),
        parts: 1 << 14,
        ..ProveRequest::default()
    };
    let report = prove(&fragment(program.code), &Options::default(), &request)
        .unwrap_or_else(|refusal| panic!("{}: {:?}", program.name, refusal.found));
    report.error.expect("it was asked for").absolute
}

#[test]
fn bounds_in_f64_are_close_to_published_ones() {
    for program @ Program { name, published, .. } in PROGRAMS {
        let bound = bound_of(program);
        println!("{name}: {bound:e}, published {published:e}, {:.2} times", bound / published);
        assert!(bound <= 4.0 * published, "{name}: {bound:e} is above {published:e}");
    }
}

#[test]
fn a_limit_of_the_error_is_shown_or_not() {
    let run = |demand: Demand| {
        let request = ProveRequest {
            pure: PureRequest { function: "f".to_string(), ..PureRequest::default() },
            domain: Some(serde_json::json!({"x": [1, 2], "y": [1, 2]})),
            demands: vec![demand],
            time: Duration::from_secs(600),
            parts: 1 << 12,
            ..ProveRequest::default()
        };
        let code = "float f(float x, float y) {\n    return x * y + x;\n}";
        let report = prove(&fragment(code), &Options::default(), &request).expect("it is read");
        report.demands.into_iter().map(|(_, shown)| shown).collect::<Vec<_>>()
    };
    // A product and a sum, each within a unit; around a power of two, one is two of the smaller.
    assert!(matches!(run(Demand::MaxUlp(3.5))[..], [Shown::Shown]));
    assert!(matches!(run(Demand::MaxUlp(0.1))[..], [Shown::Broken(_)]));
    assert!(matches!(run(Demand::MaxStep(0.01))[..], [Shown::Shown]));
}

/// A number of 106 bits: the sum of two that do not overlap (Dekker 1971).
#[derive(Clone, Copy)]
struct Pair(f64, f64);

impl Pair {
    fn sum(a: f64, b: f64) -> Pair {
        let sum = a + b;
        let part = sum - a;
        Pair(sum, (a - (sum - part)) + (b - part))
    }

    fn add(self, other: Pair) -> Pair {
        let Pair(high, low) = Pair::sum(self.0, other.0);
        Pair::sum(high, low + self.1 + other.1)
    }

    fn mul(self, other: Pair) -> Pair {
        let high = self.0 * other.0;
        let low = self.0.mul_add(other.0, -high);
        Pair::sum(high, low + self.0 * other.1 + self.1 * other.0)
    }

    fn over(self, other: Pair) -> Pair {
        let first = self.0 / other.0;
        let rest = self.add(other.mul(Pair(-first, 0.0)));
        Pair::sum(first, rest.0 / other.0)
    }
}

/// The arithmetic in which a program is run.
trait Number: Copy {
    fn of(x: f32) -> Self;
    fn plus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
    fn by(self, other: Self) -> Self;
    fn minus(self, other: Self) -> Self {
        self.plus(other.times(Self::of(-1.0)))
    }
}

impl Number for f64 {
    fn of(x: f32) -> f64 {
        f64::from(x)
    }
    fn plus(self, other: f64) -> f64 {
        self + other
    }
    fn times(self, other: f64) -> f64 {
        self * other
    }
    fn by(self, other: f64) -> f64 {
        self / other
    }
}

impl Number for Pair {
    fn of(x: f32) -> Pair {
        Pair(f64::from(x), 0.0)
    }
    fn plus(self, other: Pair) -> Pair {
        self.add(other)
    }
    fn times(self, other: Pair) -> Pair {
        self.mul(other)
    }
    fn by(self, other: Pair) -> Pair {
        self.over(other)
    }
}

fn doppler<N: Number>([u, v, t]: [N; 3]) -> N {
    let t1 = N::of(331.4).plus(N::of(0.6).times(t));
    let sum = t1.plus(u);
    t1.times(N::of(-1.0)).times(v).by(sum.times(sum))
}

fn rigid_body<N: Number>([x, y, z]: [N; 3]) -> N {
    let first = x.times(y).times(N::of(-1.0));
    first.minus(N::of(2.0).times(y).times(z)).minus(x).minus(z)
}

fn verhulst<N: Number>([x, _, _]: [N; 3]) -> N {
    N::of(4.0).times(x).by(N::of(1.0).plus(x.by(N::of(1.11))))
}

/// Compares a program's errors at random points with its bound.
fn no_error_is_above(
    name: &str,
    double: fn([f64; 3]) -> f64,
    pair: fn([Pair; 3]) -> Pair,
    ranges: [[f32; 2]; 3],
) {
    let program = PROGRAMS.iter().find(|p| p.name == name).expect("it is listed");
    let bound = bound_of(program);
    let mut state = 1u64;
    let mut most = 0.0f64;
    for _ in 0..200_000 {
        let point = ranges.map(|[low, high]| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let share = (state >> 11) as f64 / (1u64 << 53) as f64;
            let [low, high] = [low, high].map(f64::from);
            (low + (high - low) * share).clamp(low, high)
        });
        let exact = pair(point.map(|x| Pair(x, 0.0)));
        most = most.max((Pair(double(point), 0.0).add(Pair(-exact.0, -exact.1)).0).abs());
    }
    assert!(most > 0.0 && most <= bound, "{name}: {most:e} was seen, the bound is {bound:e}");
}

#[test]
fn no_error_seen_is_above_its_bound() {
    let ranges = [[-100.0, 100.0], [20.0, 20000.0], [-30.0, 50.0]];
    no_error_is_above("doppler1", doppler, doppler, ranges);
    no_error_is_above("rigidBody1", rigid_body, rigid_body, [[-15.0, 15.0]; 3]);
    no_error_is_above("verhulst", verhulst, verhulst, [[0.1, 0.3]; 3]);
}
