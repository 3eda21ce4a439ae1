//! A rounding of the interval arithmetic in the wrong direction puts samples outside of their bounds.

use landfall_interp::graph::{Arithmetic, Bounds, Given, GraphInputs, Range};
use landfall_interp::internals::{Outward, with_reversed};

use super::support::program;
use landfall_interp::{Call, Precision, Program, Settings};

/// A random expression of `a`, `b` and `c`.
fn expression(rng: &mut fastrand::Rng, depth: u32) -> String {
    if depth == 0 {
        return ["a", "b", "c", "0.7", "-1.5"][rng.usize(..5)].to_string();
    }
    let (x, y) = (expression(rng, depth - 1), expression(rng, depth - 1));
    match rng.u32(..12) {
        0..=2 => format!("({x} + {y})"),
        3..=5 => format!("({x} - {y})"),
        6..=8 => format!("({x} * {y})"),
        9 => format!("({x} / {y})"),
        10 => format!("exp({x})"),
        _ => format!("sqrt(abs({x}) + 1.0)"),
    }
}

/// A program with its inputs, their box and the permitted values of the results there.
struct Drawn {
    program: Program,
    part: Vec<Range>,
    spans: Vec<[f64; 2]>,
}

fn draw(rng: &mut fastrand::Rng) -> Drawn {
    let text = expression(rng, 3);
    let program = program(&format!("fn f(a: f32, b: f32, c: f32) -> f32 {{ return {text}; }}"));
    let width = [0.0, 1e-4, 0.5][rng.usize(..3)];
    let part: Vec<Range> = (0..3)
        .map(|_| {
            let low = f64::from(rng.f32() * 8.0 - 4.0);
            Range { low, high: f64::from((low + width) as f32) }
        })
        .collect();
    let columns: Vec<Vec<u64>> = part
        .iter()
        .map(|range| {
            let within = |share: f64| {
                let x = (range.low + (range.high - range.low) * share) as f32;
                u64::from(x.clamp(range.low as f32, range.high as f32).to_bits())
            };
            let ends = [within(0.0), within(1.0)];
            (0..16).map(|n| ends.get(n).copied().unwrap_or_else(|| within(rng.f64()))).collect()
        })
        .collect();
    let arguments = columns.into_iter().map(|column| vec![column]).collect();
    let call = Call { function: "f", lanes: 16, arguments, resources: &[] };
    let settings = Settings { precision: Precision::Permitted, threads: 1, ..Settings::default() };
    let called = program.call(&call, &settings).expect("it runs");
    let spans = called.result.permitted.expect("it was asked for")[0].clone();
    let spans = spans.into_iter().filter(|[low, high]| low.is_finite() && high.is_finite());
    Drawn { part, spans: spans.collect(), program }
}

/// Whether a sample's permitted values lie outside of the bounds.
fn is_outside(drawn: &Drawn) -> bool {
    let arguments: Vec<Vec<Given>> = (0..3).map(|n| vec![Given::Input(n)]).collect();
    let inputs = GraphInputs {
        function: "f",
        arguments: &arguments,
        ranges: &drawn.part,
        units: &[],
        results: &[None],
    };
    let graph = drawn.program.graph(&inputs, &[]).expect("it is small");
    let mut bounds = Bounds::default();
    graph.bounds(&drawn.part, Arithmetic::Permitted, &mut bounds);
    let range = bounds.results(&graph).next().expect("it has a result");
    drawn.spans.iter().any(|[low, high]| *low < range.low || *high > range.high)
}

#[test]
fn a_permitted_rounding_in_the_wrong_direction_is_caught() {
    let mut rng = fastrand::Rng::with_seed(5);
    let all: Vec<Drawn> = (0..200).map(|_| draw(&mut rng)).collect();
    assert_eq!(all.iter().filter(|drawn| is_outside(drawn)).count(), 0);
    let reversed = [Outward::SingleLow, Outward::SingleHigh, Outward::PermittedLow, Outward::Rest];
    for which in reversed {
        let caught = || all.iter().filter(|drawn| is_outside(drawn)).count();
        let caught = with_reversed(which, caught);
        println!("{which:?}: outside in {caught} of {}", all.len());
        assert!(caught >= 5, "{which:?} is caught {caught} times");
    }
}

/// Sums, products and quotients against their exact residuals.
#[test]
fn a_rounding_of_exact_arithmetic_in_the_wrong_direction_is_caught() {
    let text = "fn add(a: f32, b: f32) -> f32 { return (a + 0.1) + b * 1e-9; }
fn mul(a: f32, b: f32) -> f32 { return (a * 1.1) * (b * 0.9); }
fn div(a: f32, b: f32) -> f32 { return a / b; }";
    let program = program(text);
    let mut rng = fastrand::Rng::with_seed(6);
    let mut outside = |function: &str| {
        let mut count = 0;
        for _ in 0..200 {
            let [a, b] = [0; 2].map(|_| f64::from(rng.f32() * 3.0 + 0.5));
            let arguments = [vec![Given::Input(0)], vec![Given::Input(1)]];
            let ranges = [a, b].map(|x| Range { low: x, high: x });
            let inputs = GraphInputs {
                function,
                arguments: &arguments,
                ranges: &ranges,
                units: &[],
                results: &[None],
            };
            let graph = program.graph(&inputs, &[]).expect("it is small");
            let mut bounds = Bounds::default();
            graph.bounds(&ranges, Arithmetic::Exact, &mut bounds);
            let Range { low, high } = bounds.results(&graph).next().expect("it has a result");
            let exact = match function {
                "add" => beside(f64::from(0.1f32) + a, f64::from(1e-9f32), b),
                // Each factor is exact: 24 by 24 bits.
                "mul" => beside(0.0, a * f64::from(1.1f32), b * f64::from(0.9f32)),
                _ => {
                    // Within the bounds if the products with the divisor are about the dividend.
                    let above = |bound: f64| bound.mul_add(b, -a);
                    count += usize::from(above(low) > 0.0 || above(high) < 0.0);
                    continue;
                }
            };
            count += usize::from(exact(low) < 0.0 || exact(high) > 0.0);
        }
        count
    };
    let cases = [("add", Outward::Sum), ("mul", Outward::Product), ("div", Outward::Quotient)];
    for (function, which) in cases {
        assert_eq!(outside(function), 0, "{function}");
        let caught = with_reversed(which, || outside(function));
        assert!(caught > 20, "{which:?} is caught {caught} times");
    }
}

/// Returns the sign of `start + x * y - bound`, for a bound near it, without rounding.
fn beside(start: f64, x: f64, y: f64) -> impl Fn(f64) -> f64 {
    move |bound| {
        let product = x * y;
        let lost = x.mul_add(y, -product);
        let sum = start + product;
        let part = sum - start;
        let more = (start - (sum - part)) + (product - part);
        // The bound is within a few units of the sum: the difference is exact.
        (sum - bound) + (more + lost)
    }
}
