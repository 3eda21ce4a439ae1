//! Bounds of errors in `f64` against published ones and against 86 digits: a bound is at most four
//! times the published one, and not below the largest error seen.

use std::time::Duration;

use landfall_accuracy::demand::{Demand, DemandVerdict, ProveRequest, prove};
use landfall_exec::harness::call::pure::{PureFunction, PureRequest};
use landfall_interp::graph::{Arithmetic, Bounds, Range, Rounding};
use landfall_interp::{Precision, Settings};
use landfall_layout::Options;

use super::fragment;
use super::programs::{Digits, PROGRAMS, Program};

/// The bound of the error in `f64`.
fn bound_of(program: &Program) -> f64 {
    let range = |&(name, low, high): &(&str, f64, f64)| (name.to_string(), [low, high].into());
    let domain: serde_json::Map<String, serde_json::Value> =
        program.domain.iter().map(range).collect();
    let request = ProveRequest {
        pure: PureRequest { function: "f".to_string(), ..PureRequest::default() },
        domain: Some(domain.into()),
        rounding: Rounding::Double,
        time: Duration::from_secs(600),
        parts: 1 << 14,
        ..ProveRequest::default()
    };
    let report = prove(&fragment(program.code), &Options::default(), &request)
        .unwrap_or_else(|refusal| panic!("{}: {:?}", program.name, refusal.found));
    report.error.expect("it was asked for").absolute
}

/// The largest error in `f64` at random inputs and at corners, against 86 digits.
fn largest_error(program: &Program, count: usize) -> f64 {
    let request = PureRequest { function: "f".to_string(), ..PureRequest::default() };
    let pure = PureFunction::new(&fragment(program.code), &Options::default(), &request)
        .unwrap_or_else(|refusal| panic!("{}: {:?}", program.name, refusal.found));
    let mut random = fastrand::Rng::with_seed(17);
    let mut number = |&(_, low, high): &(&str, f64, f64)| {
        let share = [0.0, 1.0, random.f64(), random.f64(), random.f64()][random.usize(..5)];
        let single = (low + (high - low) * share) as f32;
        // The nearest `f32` of an end may lie outside.
        let single = if f64::from(single) > high { single.next_down() } else { single };
        if f64::from(single) < low { single.next_up() } else { single }
    };
    let points: Vec<Vec<f32>> =
        (0..count).map(|_| program.domain.iter().map(&mut number).collect()).collect();
    let columns: Vec<Vec<u64>> = (0..program.domain.len())
        .map(|at| points.iter().map(|point| u64::from(point[at].to_bits())).collect())
        .collect();
    let settings = Settings { precision: Precision::Double, ..Settings::default() };
    let called = pure.call(&columns, count, &settings).expect("it runs");
    let error = |(point, double): (&Vec<f32>, &f64)| {
        let digits: Vec<Digits> = point.iter().map(|x| Digits::of(f64::from(*x))).collect();
        ((program.exact)(&digits) - Digits::of(*double)).near().abs()
    };
    points.iter().zip(&called.results[0].doubles[0]).map(error).fold(0.0, f64::max)
}

#[test]
fn bounds_in_f64_are_close_to_published_ones_and_above_every_error() {
    for program @ Program { name, published, .. } in PROGRAMS {
        let bound = bound_of(program);
        let seen = largest_error(program, 2_000);
        let share = published.map(|published| bound / published);
        println!("{name}: {bound:e}, seen {seen:e}, of the published bound {share:?}");
        assert!(share.is_none_or(|share| share <= 4.0), "{name}: {bound:e} is above {published:?}");
        assert!(seen > 0.0 && seen <= bound, "{name}: {seen:e} was seen, the bound is {bound:e}");
        // A formula that differs from the program's would be off by far more.
        assert!(bound < 1e3 * seen, "{name}: {seen:e} was seen, the bound is {bound:e}");
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
    assert!(matches!(run(Demand::MaxUlp(3.5))[..], [DemandVerdict::Shown]));
    assert!(matches!(run(Demand::MaxUlp(0.1))[..], [DemandVerdict::Broken(_)]));
    assert!(matches!(run(Demand::MaxStep(0.01))[..], [DemandVerdict::Shown]));
}

/// Without a demand, the bound of the error is above every error in `f32` and close to the largest,
/// and the range of the results is that by hand.
#[test]
fn the_bound_without_a_demand_is_near_the_largest_error() {
    let request = ProveRequest {
        pure: PureRequest { function: "f".to_string(), ..PureRequest::default() },
        domain: Some(serde_json::json!({"x": [1, 2], "y": [1, 2]})),
        time: Duration::from_secs(600),
        parts: 1 << 12,
        ..ProveRequest::default()
    };
    let proved = |code: &str| {
        let report = prove(&fragment(code), &Options::default(), &request).expect("it is read");
        assert!(report.non_finite.iter().all(|v| matches!(v, DemandVerdict::Shown)), "{code}");
        (report.error.expect("it is finite"), report.worst)
    };
    let (bound, worst) = proved("float f(float x, float y) {\n    return x * y + x;\n}");
    let mut random = fastrand::Rng::with_seed(23);
    let error = |_: i32| {
        let [x, y] = [0; 2].map(|_| 1.0 + random.f32());
        (f64::from(x * y + x) - (f64::from(x) * f64::from(y) + f64::from(x))).abs()
    };
    let seen = (0..100_000).map(error).fold(0.0, f64::max);
    assert!(seen <= bound.absolute && bound.absolute < 4.0 * seen, "{seen:e}: {bound:?}");
    let [low, high] = bound.results;
    assert!((1.999..=2.0).contains(&low) && (6.0..6.001).contains(&high), "{bound:?}");
    assert!(worst[0].is_some_and(|ulp| ulp > 0.0 && ulp <= bound.ulp), "{worst:?}: {bound:?}");
    // Numbers from 0 to 1 are at most 1 apart, however much is lost before.
    let (bound, _) =
        proved("float f(float x, float y) {\n    return clamp((x - y) * 1.0e9, 0.0, 1.0);\n}");
    assert!(bound.absolute <= 1.0 + 1e-6 && bound.steps <= 255.001, "{bound:?}");
    assert_eq!(bound.results, [0.0, 1.0]);
}

/// The difference of values that share inputs.
struct Shared {
    code: &'static str,
    x: [f64; 2],
    y: [f64; 2],
    /// Its range, by hand.
    exact: [f64; 2],
    /// Its range by intervals, which take each operand as independent.
    independent: [f64; 2],
}

const SHARED: [Shared; 5] = [
    Shared {
        code: "(x + y) - x",
        x: [0.0, 16.0],
        y: [1.0, 2.0],
        exact: [1.0, 2.0],
        independent: [-15.0, 18.0],
    },
    Shared {
        code: "x - 0.5 * (x + y)",
        x: [0.0, 1.0],
        y: [0.0, 1.0],
        exact: [-0.5, 0.5],
        independent: [-1.0, 1.0],
    },
    Shared {
        code: "x * (10.0 - x) + y",
        x: [4.0, 6.0],
        y: [0.0, 0.0],
        exact: [24.0, 25.0],
        independent: [16.0, 36.0],
    },
    Shared {
        code: "x * x - 2.0 * x + y",
        x: [0.9, 1.1],
        y: [0.0, 0.0],
        exact: [-1.0, -0.99],
        independent: [-1.39, -0.59],
    },
    Shared {
        code: "(x + y) * (x - y) - x * x",
        x: [3.0, 3.5],
        y: [0.0, 0.5],
        exact: [-0.25, 0.0],
        independent: [-4.75, 5.0],
    },
];

#[test]
fn affine_forms_are_tighter_than_intervals_where_operands_share_inputs() {
    for Shared { code, x, y, exact: [low, high], independent } in SHARED {
        let request = PureRequest { function: "f".to_string(), ..PureRequest::default() };
        let text = format!("float f(float x, float y) {{ return {code}; }}");
        let pure = PureFunction::new(&fragment(&text), &Options::default(), &request)
            .unwrap_or_else(|refusal| panic!("{code}: {:?}", refusal.found));
        let whole = [x, y].map(|ends| {
            let [low, high] = ends.map(|end| f64::from(end as f32));
            Range { low, high }
        });
        let graph = pure.graph(&whole, &[]).expect("it is a graph");
        let mut bounds = Bounds::default();
        graph.bounds(&whole, Arithmetic::Permitted, &mut bounds);
        let range = bounds.results(&graph).next().expect("it returns a value");
        println!("{code}: [{}, {}], by hand [{low}, {high}]", range.low, range.high);
        assert!(range.low <= low + 1e-5 && high - 1e-5 <= range.high, "{code}: {range:?}");
        let width = range.high - range.low;
        assert!(width <= 0.55 * (independent[1] - independent[0]), "{code}: {range:?}");
    }
}

/// Zero to a power above zero is 0 (GLSL 4.60, 8.2), also where other powers of the range are not
/// above zero, which leaves the result undefined for those alone.
#[test]
fn a_base_of_zero_is_among_the_values_of_a_power() {
    let request = PureRequest { function: "f".to_string(), ..PureRequest::default() };
    let text = "float f(float x, float y) { return pow(max(x, 0.0), y); }";
    let pure = PureFunction::new(&fragment(text), &Options::default(), &request)
        .unwrap_or_else(|refusal| panic!("{:?}", refusal.found));
    for low in [-0.125, 0.0, 0.0625] {
        let whole = [[-1.0, 1.0], [low, 0.125]].map(|[low, high]| Range { low, high });
        let graph = pure.graph(&whole, &[]).expect("it is a graph");
        let mut bounds = Bounds::default();
        for arithmetic in [Arithmetic::Permitted, Arithmetic::Exact] {
            graph.bounds(&whole, arithmetic, &mut bounds);
            let range = bounds.results(&graph).next().expect("it returns a value");
            assert!(range.low <= 0.0 && range.high >= 1.0, "from {low}: {range:?}");
        }
    }
}

#[test]
fn a_loop_that_is_not_followed_bounds_neither_its_result_nor_its_error() {
    let code = "float f(float x) {
    float sum = 0.0;
    for (int i = 0; i < 1024; i++) sum += x;
    return sum;
}";
    let request = ProveRequest {
        pure: PureRequest { function: "f".to_string(), ..PureRequest::default() },
        domain: Some(serde_json::json!({"x": [1, 2]})),
        demands: vec![Demand::MaxUlp(1e6)],
        time: Duration::from_secs(600),
        parts: 1 << 8,
        ..ProveRequest::default()
    };
    let report = prove(&fragment(code), &Options::default(), &request).expect("it is read");
    assert!(report.error.is_none() && matches!(report.demands[0].1, DemandVerdict::Open));
    let pure = PureFunction::new(&fragment(code), &Options::default(), &request.pure);
    let whole = [Range { low: 1.0, high: 2.0 }];
    let graph = pure.expect("it is read").graph(&whole, &[]).expect("it is a graph");
    let mut bounds = Bounds::default();
    graph.bounds(&whole, Arithmetic::Permitted, &mut bounds);
    let range = bounds.results(&graph).next().expect("it returns a value");
    assert!(range.low <= 1024.0 && 2048.0 <= range.high, "{range:?}");
}
