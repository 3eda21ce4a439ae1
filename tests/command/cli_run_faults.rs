//! Faults of `run` and `stress`: the operands they name, and calls as deep as a text may nest them.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::support::command;

fn written(name: &str, text: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli_run_faults");
    std::fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join(name);
    std::fs::write(&path, text).expect("it is written");
    path
}

/// The `f64` that is computed beside has other operands, where both have the same fault.
#[test]
fn a_fault_of_f32_names_the_operands_of_f32() {
    let text = "#version 330\nfloat h(float x, float cut) { return (x * x - 1.0) / (1.0 - cut); }\n\
                out vec4 c;\nvoid main() { c = vec4(h(1.0, 2.0)); }\n";
    let path = written("operands.frag", text);
    let path = path.to_str().expect("it is text");
    let ran = command::run(&["run", path, "--fn", "h", "--args", "[1.0000001, 1.0]"]);
    let x = 1.000_000_1_f32;
    let (single, double) = (f64::from(x * x - 1.0), f64::from(x) * f64::from(x) - 1.0);
    let told = ran.err;
    assert!(told.contains(&format!("division by zero: {single:?}, 0.0")), "{told}");
    assert!(!told.contains(&format!("{double:?}")), "{told}");
    // The infinity that it gives is no finding of its own, and is listed in JSON.
    assert!(!told.contains("infinity from"), "{told}");
    let arguments = ["--args", "[1.0000001, 1.0]", "--format", "json"];
    let ran = command::run(&[&["run", path, "--fn", "h"][..], &arguments].concat()).json();
    let undefined = ran["undefined"].as_array().expect("a list");
    let born = undefined.iter().find(|one| one["what"] == "infinity from finite operands");
    assert_eq!(born.expect("it is listed")["operands"], serde_json::json!([single, 0.0]));
}

const LIGHTS: &str = "#version 450
struct Light { vec3 position; float range; vec3 color; float intensity; };
layout(std140, binding = 0) uniform Lights { Light lights[4]; int count; } u;
layout(location = 0) out vec4 color;
vec3 shade(vec3 p) {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < u.count; i++) {
        float x = length(u.lights[i].position - p) / u.lights[i].range;
        float window = clamp(1.0 - x * x, 0.0, 1.0);
        sum += u.lights[i].color * (u.lights[i].intensity * window + 0.0 * x);
    }
    return sum;
}
void main() { color = vec4(shade(vec3(0.0)), 1.0); }
";

/// Lights of which one has an odd number in one member.
fn lights_with(odd: usize, member: &str, value: &Value) -> String {
    let light = |nth: usize| {
        let mut light =
            json!({"position": [1, 2, 3], "range": 10, "color": [1, 1, 1], "intensity": 2});
        if nth == odd {
            light[member] = value.clone();
        }
        light
    };
    let lights: Vec<Value> = (0..4).map(light).collect();
    json!({"Lights": {"lights": lights, "count": 4}}).to_string()
}

/// The only member that is zero, or NaN, is the one that is named, wherever it is.
#[test]
fn the_element_whose_value_led_to_nan_is_named() {
    let path = written("members.frag", LIGHTS);
    let path = path.to_str().expect("it is text");
    for nth in 0..4 {
        for function in [&["--fn", "shade", "--args", "[[0, 0, 0]]"][..], &["--fn", "main"]] {
            let data = lights_with(nth, "range", &json!(0));
            let ran = command::run(&[&["run", path][..], function, &["--data", &data]].concat());
            let named = format!("comes from u.lights[{nth}].range = 0\n");
            assert!(ran.out.contains(&format!(":8:19\n    {named}")), "{}", ran.out);
            assert!(ran.err.contains(&named), "{}", ran.err);
            let data = lights_with(nth, "color", &json!([1, "nan", 1]));
            let ran = command::run(&[&["run", path][..], function, &["--data", &data]].concat());
            let named = format!(" is NaN\n    comes from u.lights[{nth}].color.y = NaN\n");
            assert!(ran.out.contains(&named), "{}", ran.out);
            assert!(!ran.out.contains(" by "), "{}", ran.out);
        }
    }
}

/// A list of indices leads to the element that is divided by; what the call stored leads further.
#[test]
fn elements_are_named_through_indices_and_stores() {
    let text = "struct Light { position: vec3f, range: f32 }
@group(0) @binding(0) var<storage> lights: array<Light>;
@group(0) @binding(1) var<storage> order: array<u32>;
@group(0) @binding(2) var<storage, read_write> scratch: array<f32>;
fn fade(i: u32, p: vec3f) -> f32 {
    let light = lights[order[i]];
    scratch[1] = light.range * dot(p, p);
    return 1.0 / scratch[1];
}
";
    let path = written("indices.wgsl", text);
    let path = path.to_str().expect("it is text");
    let lights = json!([{"position": [1, 1, 1], "range": 3}, {"position": [1, 1, 1], "range": 0}]);
    let data = json!({"lights": {"lights": lights}, "order": {"order": [1, 0]},
        "scratch": {"scratch": [1, 1]}})
    .to_string();
    let call = |arguments: &str| {
        let call = ["run", path, "--fn", "fade", "--args", arguments, "--data", &data];
        command::run(&[&call[..], &["--format", "json"]].concat()).json()
    };
    let zero = call("[0, [1, 2, 3]]");
    let cause = &zero["causes"][0];
    assert_eq!(cause["results"], json!(["result"]));
    assert_eq!((&cause["value"], &cause["line"]), (&json!("inf"), &json!(8)));
    assert_eq!(cause["from"], json!([{"path": "lights[1].range", "values": [0.0]}]));
    // Of the other light it is the vector that is zero.
    let cause = &call("[1, [0, 0, 0]]")["causes"][0];
    assert_eq!(cause["from"], json!([{"path": "p", "values": [0.0, 0.0, 0.0]}]));
    assert_eq!(call("[1, [1, 2, 3]]")["causes"], json!([]));
}

#[test]
fn stress_calls_as_deep_as_the_text_nests() {
    let mut text = "#version 450\nlayout(location = 0) out vec4 c;\n\
                    float f0(float x) { return x; }\n"
        .to_string();
    let deepest = 6_000;
    for nth in 1..=deepest {
        let last = nth - 1;
        text += &format!("float f{nth}(float x) {{ if (x > 0.0) return f{last}(x); return x; }}\n");
    }
    text += &format!("void main() {{ c = vec4(f{deepest}(1.0)); }}\n");
    let path = written("deep.frag", &text);
    let function = format!("f{deepest}");
    let few = ["--samples", "64", "--time", "2"];
    let named = ["stress", path.to_str().expect("it is text"), "--fn", &function];
    let ran = command::run(&[&named[..], &few].concat());
    assert!(matches!(ran.code, 0 | 1), "{}: {}", ran.code, ran.err);
}

/// What no compiler takes in one function is said when another one is called, as `check` says it.
#[test]
fn an_undeclared_name_in_another_function_is_told() {
    let text = "#version 450\nlayout(location = 0) out vec4 c;\n\
                float good(float x) { return x + 1.0; }\n\
                float bad(float x) { return x * undeclared; }\n\
                void main() { c = vec4(good(2.0)); }\n";
    let path = written("undeclared.frag", text);
    let path = path.to_str().expect("it is text");
    let told = "[invalid-shader]: `undeclared` is not declared\n";
    let checked = command::run(&["check", path]);
    assert!(checked.out.contains(&format!("error{told}")), "{}", checked.out);
    let calls: [&[&str]; 4] = [
        &["run", path, "--fn", "good", "--args", "[1]"],
        &["prove", path, "--fn", "good"],
        &["stress", path, "--fn", "good", "--samples", "64", "--time", "1"],
        &["bench", path, "--fn", "good", "--backend", "cpu", "--rounds", "3", "--samples", "64"],
    ];
    for call in calls {
        let ran = command::run(call);
        assert_eq!(ran.err.matches(&format!("warning{told}")).count(), 1, "{call:?}: {}", ran.err);
        assert!(ran.code < 2 && !ran.out.is_empty(), "{call:?}: {}", ran.out);
    }
    // Without a main, a name may be that of who includes it.
    let (_, declared) = text.split_once("layout").expect("a line");
    let alone = declared
        .split("void main")
        .next()
        .expect("the rest")
        .replace("(location = 0) out vec4 c;", "");
    let path = written("included.glsl", &alone);
    let ran =
        command::run(&["run", path.to_str().expect("it is text"), "--fn", "good", "--args", "[1]"]);
    assert!(!ran.err.contains("undeclared"), "{}", ran.err);
}

/// Between 256 and 512, neighbouring f16 are 0.25 apart, and from 4 to 8 they are 2^-8: 300.1 is not
/// one of them, and 33 is, but a seventh of it is not.
#[test]
fn what_f16_rounded_is_told() {
    let text = "#version 450\nfloat input_rounded(float x) { return x - 300.0; }\n\
                float result_rounded(float x) { return x / 7.0 - 4.714; }\nvoid main() {}\n";
    let path = written("rounded.frag", text);
    let path = path.to_str().expect("it is text");
    let told = |function: &str, domain: &str| {
        let few = [
            "stress",
            path,
            "--fn",
            function,
            "--half",
            "--samples",
            "500",
            "--max-step",
            "0.01",
            "--details",
        ];
        command::run(&[&few[..], &["--max-ulp", "10", "--domain", domain]].concat()).out
    };
    let input = told("input_rounded", r#"{"x": [300.05, 300.12]}"#);
    assert!(input.contains("f16 of the input 300.") && input.contains(" = 300, "), "{input}");
    let result = told("result_rounded", r#"{"x": [33, 33]}"#);
    assert!(result.contains("f16 of the result 4.71"), "{result}");
    // 70000 is beyond 65504, the largest f16: no formula is at fault.
    let beyond = told("input_rounded", r#"{"x": [70000, 70000]}"#);
    assert!(beyond.contains("the float type cannot hold an input"), "{beyond}");
    let run = |function: &str, x: &str| {
        command::run(&["run", path, "--fn", function, "--args", x, "--half"]).code(0).out.clone()
    };
    let input = run("input_rounded", "[300.1]");
    assert!(input.contains("f16 rounds the input x = 300.1 to 300\n"), "{input}");
    assert!(!input.contains("results of operations"), "{input}");
    let result = run("result_rounded", "[33]");
    assert!(result.contains("results of operations that f16 rounds: 1\n"), "{result}");
    assert!(!result.contains("the input"), "{result}");
    let beyond = run("input_rounded", "[70000]");
    assert!(beyond.contains("f16 cannot hold the input x = 70000: its largest"), "{beyond}");
}
