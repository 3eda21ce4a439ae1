//! Permitted results: the rules computed by hand, intervals that hold the exact result, and their
//! width for six lights.

use super::lighting::{fragments, module as six_lights, shade};
use super::support::{program, run, single};
use landfall_interp::backend::FailureKind;
use landfall_interp::{Called, Floats, Precision, Program, Settings};

fn permitted(program: &Program, arguments: &[&[f32]]) -> Called {
    let settings = Settings { precision: Precision::Permitted, ..single() };
    run(program, "f", arguments, &settings).unwrap_or_else(|failure| panic!("{failure:?}"))
}

fn spans(called: &Called) -> &[[f64; 2]] {
    &called.result.permitted.as_ref().expect("it was asked for")[0]
}

/// The interval of one expression of `a` and `b`.
fn span(text: &str, a: f32, b: f32) -> [f64; 2] {
    let p = program(&format!("fn f(a: f32, b: f32) -> f32 {{ return {text}; }}"));
    spans(&permitted(&p, &[&[a], &[b]]))[0]
}

const ANY: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

#[test]
fn widths_are_those_of_the_specifications() {
    let two = |n: i32| 2f64.powi(n);
    // Exact, correctly rounded either way, 2.5 ULP of 2^-25 about a third.
    assert_eq!(span("a + b", 1.0, 2.0), [3.0, 3.0]);
    assert_eq!(span("a + b", 1.0, two(-30) as f32), [1.0, 1.0 + two(-23)]);
    assert_eq!(span("a - b", 1.0, two(-60) as f32), [1.0 - two(-24), 1.0]);
    let third = 1.0 / 3.0;
    assert_eq!(span("a / b", 1.0, 3.0), [third - 2.5 * two(-25), third + 2.5 * two(-25)]);
    // 2 ULP; 3 + 2|x| ULP; 2^-21 from 0.5 to 2, else 3 ULP; 2^-11.
    assert_eq!(span("inverseSqrt(a)", 4.0, 0.0), [0.5 - two(-23), 0.5 + two(-23)]);
    assert_eq!(span("exp2(a)", 2.0, 0.0), [4.0 - 7.0 * two(-21), 4.0 + 7.0 * two(-21)]);
    assert_eq!(span("log2(a)", 1.0, 0.0), [-two(-21), two(-21)]);
    assert_eq!(span("log2(a)", 8.0, 0.0), [3.0 - 3.0 * two(-22), 3.0 + 3.0 * two(-22)]);
    assert_eq!(span("cos(a)", 0.0, 0.0), [1.0 - two(-11), 1.0 + two(-11)]);
    // A built-in function's sum has no order; what is written has one.
    let large = (1u32 << 24) as f32;
    let dot = span("dot(vec3<f32>(a, b, -a), vec3<f32>(1.0))", large, 1.0);
    assert_eq!(dot, [0.0, 2.0]);
    assert_eq!(span("(a + -a) + b", large, 1.0), [1.0, 1.0]);
    // Subnormals may be flushed.
    let small = f32::MIN_POSITIVE / 2.0;
    assert_eq!(span("a + b", small, 0.0), [0.0, f64::from(small)]);
    // One value times itself is not negative, whatever it is.
    let [low, high] = span("(a - b) * (a - b)", 1.0, 1.0);
    assert_eq!([low, high], [0.0, 0.0]);
    let p = program("fn f(a: f32) -> f32 { let x = a / 3.0 - a / 3.0; return x * x; }");
    let called = permitted(&p, &[&[1.0]]);
    let [low, high] = spans(&called)[0];
    assert!(low == 0.0 && high > 0.0 && high < two(-44), "{low} {high}");
}

#[test]
fn where_the_specifications_give_no_value_any_is_permitted() {
    for (text, a, b) in [
        ("a / b", 1.0, 0.0),
        ("a / b", 1.0, 1e38),
        ("normalize(vec3<f32>(a, b, a)).x", 0.0, 0.0),
        ("pow(a, b)", -1.0, 2.0),
        ("pow(a, b)", 0.0, 0.0),
        ("log2(a)", 0.0, 0.0),
        ("sin(a)", 4.0, 0.0),
        ("a * b", 1e30, 1e30),
        ("sqrt(a)", -1.0, 0.0),
        ("clamp(a / b, 0.0, 1.0)", 0.0, 0.0),
    ] {
        assert_eq!(span(text, a, b), ANY, "{text}");
    }
    // Zero to a positive power is zero, and so is the root of zero.
    assert_eq!(span("pow(a, b)", 0.0, 32.0), [0.0, 0.0]);
    assert_eq!(span("length(vec2<f32>(a, b))", 0.0, 0.0), [0.0, 0.0]);
}

/// `exp2(y * log2(x))` may be that far off by the specifications: a figure derived elsewhere.
#[test]
fn a_power_near_one_may_be_off_by_its_exponent() {
    let [low, high] = span("pow(a, b)", 1.0, 32.0);
    let ulp = 2f64.powi(-23);
    let ulps = (high - 1.0) / ulp;
    assert!(low < 1.0 && (80.0..150.0).contains(&ulps), "{ulps} ULP");
    let [low, _] = span("pow(a, b)", 1.0, 12_000.0);
    assert!((0.9..1.1).contains(&((1.0 - low) * 255.0)), "a step of 8 bits: {low}");
}

#[test]
fn comparisons_that_others_may_decide_differently_are_told() {
    let p = program(
        "fn f(a: f32, b: f32) -> f32 { if a / b < 0.5 { return 1.0; } return f32(i32(a / b)); }",
    );
    let (a, b) = ([1.0, 1.0, 6.0, 7.0, 5.0], [2.0, 3.0, 3.0, 3.0, 0.0]);
    let called = permitted(&p, &[&a, &b]);
    assert_eq!(called.unsure, [true, false, true, false, true]);
    assert_eq!(called.discarded, [false; 5]);
    // Not where an invocation does not come.
    let p = program(
        "fn f(a: f32) -> f32 {
            if a > 2.0 { if a / 3.0 < 1.0 { return 1.0; } }
            return a;
        }",
    );
    assert_eq!(permitted(&p, &[&[1.0, 3.0]]).unsure, [false, true]);
}

#[test]
fn halves_are_refused_by_name() {
    let p = program("enable f16; fn f(a: f16) -> f16 { return a * a; }");
    let settings = Settings { precision: Precision::Permitted, ..single() };
    let failure = run(&p, "f", &[&[0.0]], &settings).expect_err("no accuracy is known");
    assert_eq!(failure.kind, FailureKind::Refused);
    assert!(failure.message.contains("`f16`"), "{}", failure.message);
}

/// A study found at most 0.048 steps of 255 for the seed form of this scene.
#[test]
fn six_lights_may_differ_by_a_small_part_of_a_step() {
    let fragments = fragments(4000);
    for name in ["seed/six_lights_450.frag", "six_lights/phong_450.frag"] {
        let module = six_lights(name, &[]);
        let run = |precision| {
            let settings = Settings { precision, ..single() };
            shade(&module, &fragments, &settings, Floats::AsWritten)
        };
        let (outputs, truth, single) =
            (run(Precision::Permitted), run(Precision::Double), run(Precision::Single));
        let numbers = &outputs.ports[0].1;
        let spans = &numbers.permitted.as_ref().expect("it was asked for")[0];
        let (mut widest, mut unsure) = (0.0f64, 0);
        for (i, [low, high]) in spans.iter().enumerate() {
            let single = f64::from(f32::from_bits(single.ports[0].1.words[0][i] as u32));
            let truth = truth.ports[0].1.doubles[0][i];
            assert_eq!(numbers.doubles[0][i], single, "it is the f32 that runs");
            if outputs.unsure[i] {
                unsure += 1;
                continue;
            }
            for x in [single, truth] {
                assert!(*low <= x && x <= *high, "{x} is outside {low} to {high}");
            }
            widest = widest.max(255.0 * (high - low));
        }
        println!("{name}: at most {widest:.4} of a step wide, {unsure} of 4000 unsure");
        assert!(widest <= 0.048 && unsure == 0, "{name}: {widest} {unsure}");
    }
}
