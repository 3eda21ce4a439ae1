//! Errors that are known by analysis: what is measured lies within the bound and above half of it.

use landfall_accuracy::stress::Report;
use landfall_interp::{Call, Program, Settings};
use landfall_ir::Module;
use landfall_layout::{Options, Source};
use snapbox::str;

use super::{domain, request, run};
use crate::support::command::golden;

/// The largest error in units of the last place, over the samples of a function in a domain.
fn measured(text: &str, function: &str, json: &str) -> Report {
    let source = Source::new("figures.frag", format!("#version 450\n{text}\nvoid main() {{}}\n"));
    let mut request = request(function);
    request.domain = domain(json);
    run(&source, &request)
}

#[test]
fn a_difference_of_squares_loses_what_cancels() {
    // From 1 + 2^-12 on, x * x - 1 is at least 2^-11 and its last place 2^-34. Rounding x * x,
    // which is from 1 to 4, is off by half of its own last place: 2^-24 up to sqrt(2). The
    // difference itself is exact up to x * x = 2. So 2^-24 / 2^-34 at the most.
    let report = measured(
        "float f(float x) { return x * x - 1.0; }",
        "f",
        r#"{"x": [1.000244140625, 1.25]}"#,
    );
    let most = report.total.ulp.max;
    assert!((512.0..=1024.5).contains(&most), "{most} ULP");
}

#[test]
fn one_minus_a_cosine_loses_what_cancels() {
    // From 0.016 on, 1 - cos(x) is at least 2^-13 and its last place 2^-36. The cosine, from a
    // half to 1, is rounded by at most 2^-25; the difference is exact. So 2^-25 / 2^-36.
    let report =
        measured("float f(float x) { return 1.0 - cos(x); }", "f", r#"{"x": [0.016, 0.25]}"#);
    let most = report.total.ulp.max;
    assert!((1024.0..=2048.5).contains(&most), "{most} ULP");
}

#[test]
fn a_sum_is_as_far_off_as_its_additions_allow() {
    // Eight terms from 1 to 2: seven additions. The partial sums are below 4, 6, 8, 10, 12, 14,
    // 16, so half of their last places are 2^-23 once, 2^-22 up to 8 twice, 2^-21 four times:
    // 2^-23 + 2 * 2^-22 + 4 * 2^-21 at the most. The sum is at least 8, its last place 2^-20.
    let text = "float f(vec4 a, vec4 b) {
        return a.x + a.y + a.z + a.w + b.x + b.y + b.z + b.w;
    }";
    let report = measured(text, "f", r#"{"a": [1, 2], "b": [1, 2]}"#);
    let bound = (1.0 + 2.0 * 2.0 + 4.0 * 4.0) / 8.0;
    let most = report.total.ulp.max;
    assert!((bound / 2.0..=bound).contains(&most), "{most} of {bound} ULP");
}

#[test]
#[ignore = "tries millions of inputs: ./tests/run light"]
fn a_power_is_sampled_as_wrong_as_it_is() {
    // Five squarings of all 2^23 numbers from a half to 1, here in f32 against f64.
    let mut worst = 0.0f64;
    for bits in 0x3f00_0000u32..0x3f80_0000 {
        let x = f32::from_bits(bits);
        let (mut single, mut double) = (x, f64::from(x));
        for _ in 0..5 {
            single *= single;
            double *= double;
        }
        worst = worst.max((f64::from(single) - double).abs() / last_place(double));
    }
    let text = "float f(float x) {
        float x2 = x * x; float x4 = x2 * x2; float x8 = x4 * x4; float x16 = x8 * x8;
        return x16 * x16;
    }";
    assert_eq!(worst_of_all(text), worst, "the evaluator squares in f32 too");
    let report = measured(text, "f", HALF_TO_ONE);
    let most = report.total.ulp.max;
    assert_eq!(report.every, None);
    assert!(most <= worst && most >= 0.85 * worst, "sampled {most}, all {worst} ULP");
    let all = whole(text);
    assert_eq!(all.total.ulp.max, worst, "it is in the one input that has it");
    assert_eq!(all.worst[0].off.ulp, worst);
}

/// Every number from a half to 1 - 2^-24, the last below one.
const HALF_TO_ONE: &str = r#"{"x": [0.5, 0.9999999404]}"#;

/// The report of `f` over all 2^23 of them.
fn whole(text: &str) -> Report {
    let source = Source::new("figures.frag", format!("#version 450\n{text}\nvoid main() {{}}\n"));
    let mut request = request("f");
    (request.domain, request.samples, request.time) = (domain(HALF_TO_ONE), 1 << 23, None);
    let report = run(&source, &request);
    assert_eq!((report.every, report.total.samples), (Some(1 << 23), 1 << 23));
    assert_eq!(report.total.ulp.count, 1 << 23, "each is finite");
    report
}

/// The largest error of `f` on the evaluator, over all 2^23 numbers from a half to 1, against
/// five squarings in `f64`.
fn worst_of_all(text: &str) -> f64 {
    let text = format!("#version 450\n{text}\nvoid main() {{}}\n");
    let module = Module::new(&Source::new("figures.frag", text), &Options::default());
    let program = Program::new(&module.unwrap_or_else(|found| panic!("{found:?}")), &[]);
    let mut worst = 0.0f64;
    for chunk in (0x3f00_0000u32..0x3f80_0000).step_by(1 << 18) {
        let words: Vec<u64> = (chunk..chunk + (1 << 18)).map(u64::from).collect();
        let arguments = vec![vec![words.clone()]];
        let call = Call { function: "f", lanes: words.len(), arguments, resources: &[] };
        let called = program.call(&call, &Settings::default());
        let called = called.unwrap_or_else(|failure| panic!("{failure}"));
        for (x, got) in words.iter().zip(&called.result.words[0]) {
            let single = |bits: u64| f64::from(f32::from_bits(bits as u32));
            let mut double = single(*x);
            for _ in 0..5 {
                double *= double;
            }
            worst = worst.max((single(*got) - double).abs() / last_place(double));
        }
    }
    worst
}

/// A unit in the last place of an `f32` near that number.
fn last_place(x: f64) -> f64 {
    f64::powi(2.0, (x.to_bits() >> 52) as i32 - 1023 - 23)
}

#[test]
#[ignore = "tries millions of inputs: ./tests/run light"]
fn the_built_in_power_of_all_inputs_is_as_sampled() {
    // The evaluator rounds a power of doubles once: half a unit at the most, which some input of
    // so many comes close to.
    let text = "float f(float x) { return pow(x, 32.0); }";
    let worst = worst_of_all(text);
    assert!((0.4999..=0.5001).contains(&worst), "{worst} ULP");
    let most = measured(text, "f", HALF_TO_ONE).total.ulp.max;
    // Their `f64`s are off by a few 2^-53, which is 2^-30 of a unit.
    assert!(most <= worst + 1e-6 && most >= 0.99 * worst, "sampled {most}, all {worst} ULP");
    let all = whole(text).total.ulp.max;
    assert!((all - worst).abs() <= 1e-6, "{all}, by itself {worst} ULP");
}

#[test]
fn few_inputs_are_each_run_once() {
    // Two truths, five whole numbers, and the 9 floats from 1 to 1 + 8 * 2^-23.
    let text = "float f(bool b, int n, float x) {
        return b && n == -2 ? sqrt(-x) : x == 1.0 ? 1.0 / float(n - 2) : x;
    }";
    let report = measured(text, "f", r#"{"n": [-2, 2], "x": [1, 1.00000096]}"#);
    assert_eq!((report.every, report.total.samples), (Some(90), 90));
    // A root of each of the nine; at the first of them a division by zero with either truth.
    assert_eq!((report.total.nan, report.total.infinite), (9, 2));
    let text = landfall::report::stress::text(
        &report,
        landfall::report::prove::Listed::All,
        landfall_layout::format::Paint::Plain,
    );
    let counted = text.lines().find(|line| line.contains(" inputs in ")).unwrap_or(&text);
    golden()
        .eq(counted.split(" in ").next().expect("split yields something"), str!["  all 90 inputs"]);
    let json = landfall::report::stress::json(&report);
    let json: serde_json::Value = serde_json::from_str(&json).expect("it is JSON");
    assert_eq!(json["all_inputs"], 90);
    assert!(json["families"].as_array().is_some_and(|all| {
        all.iter().all(|one| one["family"] == "every" || one["samples"] == 0)
    }));
}

#[test]
fn all_inputs_are_only_said_of_a_run_that_came_to_its_end() {
    let source =
        Source::new("f.frag", "#version 450\nfloat f(float x) { return x; }\nvoid main() {}");
    let mut request = request("f");
    (request.domain, request.samples) = (domain(r#"{"x": [0.5, 4]}"#), 1 << 25);
    request.time = Some(std::time::Duration::from_millis(20));
    let report = run(&source, &request);
    assert!(report.stopped && report.every.is_none() && report.total.samples < 1 << 24);
}

#[test]
fn a_hard_problem_is_told_from_a_bad_formula() {
    // tan near its pole is ill-conditioned, x * x - 1 near 1 is not once it is (x - 1) * (x + 1).
    let hard = measured("float f(float x) { return tan(x); }", "f", r#"{"x": [1.57, 1.5707]}"#);
    let condition = hard.worst[0].condition.as_ref().expect("its result is finite").number;
    assert!(condition > 100.0, "{condition}");
    let good = measured(
        "float f(float x) { return (x - 1.0) * (x + 1.0); }",
        "f",
        r#"{"x": [1.000244140625, 1.25]}"#,
    );
    assert!(good.total.ulp.max < 3.0, "{}", good.total.ulp.max);
}
