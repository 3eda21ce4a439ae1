//! `landfall prove` as a process.

use snapbox::str;

use crate::support::command::{self, Place};

const AXIS: &str = "#version 450
float f(vec3 d) {
    return 1.0 / d.x;
}
float g(vec3 d) {
    return 1.0 / (abs(d.x) + 0.001);
}
void main() {}
";

#[test]
fn a_demand_that_is_broken_exits_with_1() {
    let place = Place::new("prove-broken");
    place.write("axis.frag", AXIS);
    let domain = "{\"d\": \"unit\"}";
    place
        .run(&["prove", "axis.frag", "--fn", "f", "--domain", domain, "--no-inf"])
        .code(1)
        .stdout_eq(str![[r#"
f(vec3)  axis.frag
  found   axis.frag:3:12: division by zero in `1.0 / d.x` with d = (0, 0, 1)
  undefined results: 1 found, 0 proved absent, 0 open, in 1 operation
  no-inf: broken with d = (0, 0, 1)

"#]])
        .stderr_eq("");
}

#[test]
fn a_demand_that_is_shown_exits_with_0() {
    let place = Place::new("prove-shown");
    place.write("axis.frag", AXIS);
    let domain = "{\"d\": \"unit\"}";
    place
        .run(&["prove", "axis.frag", "--fn", "g", "--domain", domain, "--no-inf", "--no-nan"])
        .code(0)
        .stdout_eq(str![[r#"
g(vec3)  axis.frag
  undefined results: 0 found, 1 proved absent, 0 open, in 1 operation
  no-nan: proved for every conformant device
  no-inf: proved for every conformant device

"#]])
        .stderr_eq("");
}

/// Without a demand a report says what is known of the results and of their errors; a difference of
/// inputs may be near 0, where no number of units of the last place bounds its error.
#[test]
fn what_is_known_without_a_demand_is_said() {
    let place = Place::new("prove-known");
    let text = "float apart(float x, float y) {\n    return (x + 1.0) - y;\n}\n\
                float sum(float x, float y) {\n    return x + y;\n}\nvoid main() {}\n";
    place.write("known.frag", format!("#version 450\n{text}"));
    let run = |function: &str, more: &[&str]| {
        let domain = r#"{"x": [1, 2], "y": [1, 2]}"#;
        let prove = ["prove", "known.frag", "--fn", function, "--domain", domain];
        let ran = place.run(&[&prove[..], more].concat());
        assert_eq!(ran.code, 0, "{}{}", ran.out, ran.err);
        assert!(ran.out.lines().all(|line| line.len() <= 80), "{}", ran.out);
        ran.out
    };
    let known = run("sum", &[]);
    // Devices may round to either neighbour, which are 2^-22 apart from 2 to 4: 255 / 2 of that.
    let results = "results: NaN proved absent; infinity proved absent; from 2 to 4\n";
    assert!(known.contains(results), "{known}");
    assert!(known.contains("error: at most 2.4e-7 absolute, 1 ULP, 3.0e-5 steps\n"), "{known}");
    assert!(known.contains("  the worst of the samples: 0.5 ULP, 1.5e-5 steps\n"), "{known}");
    // What is found is told with its input.
    place.write("axis.frag", AXIS);
    let domain = r#"{"d": "unit"}"#;
    let broken = place.run(&["prove", "axis.frag", "--fn", "f", "--domain", domain]);
    let told = "  results: NaN open; infinity found with d = (0, 0, 1)\n";
    let told_absent = told.replace("open", "proved absent");
    assert!([told, &told_absent].iter().any(|told| broken.out.contains(*told)), "{}", broken.out);
    let near = run("apart", &[]);
    assert!(near.contains("no bound in ULP: the result may be near 0"), "{near}");
    assert!(near.contains("error: at most ") && !near.contains("e38"), "{near}");
    let demanded = run("sum", &["--max-ulp", "100"]);
    assert!(demanded.contains("where the demand was met: it may be lower"), "{demanded}");
    assert_eq!(demanded.matches("error: at most").count(), 1, "{demanded}");
    let double = run("sum", &["--f64"]);
    assert!(double.contains("error in f64: at most ") && !double.contains("device"), "{double}");
}

/// WGSL 15.7.4 and Vulkan allow sine an absolute error of 2^-11 within pi. The interpreter is off by
/// half a unit in the last place, which is 2^-25 below 1: the bound is 2^14 times that.
#[test]
fn a_bound_of_more_than_a_thousand_times_the_worst_sample_is_called_loose() {
    let place = Place::new("prove-loose");
    let text = "float turned(float x) {\n    return sin(x);\n}\n\
                float moved(float x) {\n    return x * 0.5 + 1.0;\n}\nvoid main() {}\n";
    place.write("loose.frag", format!("#version 450\n{text}"));
    let run = |function: &str, more: &[&str]| {
        let domain = r#"{"x": [0.5, 1.5]}"#;
        let prove = ["prove", "loose.frag", "--fn", function, "--domain", domain, "--time", "1"];
        place.run(&[&prove[..], more].concat()).code(0).out.clone()
    };
    let loose = run("turned", &[]);
    let line = loose.lines().find_map(|line| line.trim().strip_prefix("the bound is loose: "));
    let times = line.and_then(|line| line.strip_suffix(" times the steps of that sample"));
    let times: u32 = times.expect(&loose).replace(',', "").parse().expect(&loose);
    // Rounding of the result itself adds half a unit to the bound.
    assert!((16_384..16_400).contains(&times), "{loose}");
    assert!(!run("moved", &[]).contains("bound is loose"), "three operations of half a unit");
    // A bound that was not looked for any longer may well be lower.
    assert!(!run("turned", &["--max-step", "1"]).contains("bound is loose"), "the demand was met");
}

/// Integers past 2^24 are rounded where they become `f32`: Rust's conversion is within what devices
/// may do, so a bound is not below its error.
#[test]
fn integers_that_no_f32_holds_have_an_error() {
    let place = Place::new("prove-integers");
    let text = "float step(int n) {\n    return float(n) - float(n - 1);\n}\nvoid main() {}\n";
    place.write("step.frag", format!("#version 450\n{text}"));
    let bound = |low: i32, high: i32| -> f64 {
        let domain = format!("{{\"n\": [{low}, {high}]}}");
        let ran = place.run(&["prove", "step.frag", "--fn", "step", "--domain", &domain]);
        let out = &ran.code(0).out;
        let rest = out.split("error: at most ").nth(1).expect(out);
        rest.split(' ').next().and_then(|number| number.parse().ok()).expect(out)
    };
    let seen = |n: i32| f64::from((n as f32 - (n - 1) as f32 - 1.0).abs());
    for (low, high) in [(1 << 24, (1 << 24) + 100), (2_000_000_000, 2_000_001_000)] {
        let worst = (low..=high).map(seen).fold(0.0, f64::max);
        assert!(worst > 0.0 && bound(low, high) >= worst, "{worst} from {low} to {high}");
    }
    assert_eq!((2..=1000).map(seen).fold(0.0, f64::max), 0.0);
    assert!(bound(2, 1000) < 1e-3, "exact integers");
}

#[test]
fn a_function_that_is_missing_exits_with_2() {
    let place = Place::new("prove-missing");
    place.write("axis.frag", AXIS);
    place.run(&["prove", "axis.frag", "--fn", "h"]).code(2).stdout_eq("").stderr_eq(str![[r#"
error[unknown-function]: the shader has no function `h`
 --> axis.frag
  |
  = help: its functions are `f(vec3)`, `g(vec3)`


"#]]);
}

/// An array of lights has a thousand numbers and half a million pairs of them.
#[test]
fn many_inputs_are_searched_within_bounds_of_memory() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/hazards/loop_to_max.wgsl");
    let prove = ["prove", file, "--fn", "lit", "--time", "0.2", "--max-memory", "1024"];
    let ran = command::run(&prove);
    assert_eq!(ran.code, 1, "{}", ran.err);
}
