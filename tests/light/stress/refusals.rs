//! Functions and domains that cannot be stressed are refused by name.

use landfall_layout::Source;
use snapbox::str;

use super::{domain, request, run, try_run};
use crate::support::command::golden;

const SHADER: &str = "#version 450
layout(std140, binding = 0) uniform Material { vec3 tint; float shininess; } material;
layout(std430, binding = 1) buffer Sums { float total; } sums;
layout(binding = 2) uniform sampler2D tex;
layout(location = 0) in vec3 v_normal;
layout(location = 0) out vec4 color;
struct Light { vec3 position; float power[2]; };
float scale(float x) { return x * material.shininess; }
float of_arrays(Light light, float weights[3]) { return light.power[1] * weights[2]; }
void adds(float x) { sums.total += x; }
void nothing(float x) { float y = x; }
void writes(float x, out float y) { y = x / 3.0; }
float endless(int n) { float s = 0.0; for (int i = 0; i != n; i++) { s += 1.0; } return s; }
float slopes(float x) { return dFdx(x); }
float looks(sampler2D t, vec2 uv) { return texture(t, uv).x; }
vec3 samples(vec2 uv) { return texture(tex, uv).rgb * v_normal; }
void main() {
    float y;
    writes(1.0, y);
    adds(y);
    nothing(y);
    color = vec4(samples(vec2(0)) * scale(y) + endless(2) + slopes(y) + looks(tex, vec2(0)), 1.0)
        + of_arrays(Light(vec3(0), float[2](1.0, 2.0)), float[3](1.0, 2.0, 3.0));
}
";

fn source() -> Source {
    Source::new("refusals.frag", SHADER)
}

fn refused(function: &str, json: Option<&str>) -> String {
    let mut request = request(function);
    request.samples = 1000;
    request.domain = json.and_then(domain);
    let refusal = try_run(&source(), &request).expect_err("it is refused");
    let found = &refusal.found[0];
    format!("{}; {}", found.message, found.help.clone().unwrap_or_default())
}

#[test]
fn a_function_that_is_not_there_has_a_nearest_name() {
    let said = refused("scal", None);
    golden().eq(&said, str!["the shader has no function `scal`; did you mean `scale`?"]);
}

#[test]
fn what_cannot_be_called_by_itself_is_refused_by_name() {
    for (function, said) in [
        (
            "adds",
            str![
                "`adds(float)` cannot be sampled: it writes the buffer `sums`; name a function that returns the value instead"
            ],
        ),
        (
            "nothing",
            str![
                "`nothing(float)` cannot be sampled: it returns nothing; name a function that returns something, has an `out` parameter or writes a global"
            ],
        ),
        (
            "slopes",
            str![
                "`slopes(float)` cannot be sampled: it takes derivatives, but each sample is a single call without neighbours; name the function whose arguments they depend on"
            ],
        ),
        (
            "looks",
            str![
                "`looks(sampler2D, vec2)` cannot be sampled: `t` is a `sampler2D`, but arguments can only be numbers, vectors, matrices, and arrays or structures of them; name the function that calls it"
            ],
        ),
    ] {
        golden().eq(refused(function, None), said);
    }
}

#[test]
fn domains_that_hold_nothing_are_refused_by_path() {
    for (json, said) in [
        (r#"{"x": [2, 1]}"#, str!["`x`: the range from 2 to 1 is inverted; write `[1, 2]`"]),
        (
            r#"{"x": [1e-60, 2e-60]}"#,
            str!["`x`: the range is empty: no `f32` is from 1e-60 to 2e-60; widen it"],
        ),
        (
            r#"{"x": "unit"}"#,
            str!["`x` is not a vector and cannot be `unit`; write a range: `[-1, 1]`"],
        ),
        (
            r#"{"x": "far"}"#,
            str![[
                r#"`x`: unknown domain "far"; write `[lo, hi]`, "unit", "position", "color" or "cos""#
            ]],
        ),
        (
            r#"{"y": [0, 1]}"#,
            str!["the function has no input `y`; its inputs are `x`, `material.shininess`"],
        ),
        (
            r#"{"no_coincidence": ["x", "z"]}"#,
            str!["the function has no input `z`; its inputs are `x`, `material.shininess`"],
        ),
        (
            "[1]",
            str![[
                r#"the domain is not an object of inputs by path; write `{"normal": "unit", "shininess": [1, 256]}`"#
            ]],
        ),
    ] {
        golden().eq(refused("scale", Some(json)), said);
    }
}

#[test]
fn structures_arrays_blocks_inputs_textures_and_out_parameters_are_inputs_and_results() {
    for (function, paths) in [
        ("scale", &["x", "material.shininess"][..]),
        ("of_arrays", &["light.position", "light.power[0]", "light.power[1]", "weights[2]"]),
        ("writes", &["x"]),
        ("samples", &["uv", "v_normal"]),
    ] {
        let mut request = request(function);
        request.samples = 2000;
        let report = run(&source(), &request);
        for path in paths {
            let known = report.inputs.iter().any(|(input, _)| input.path == *path);
            assert!(known, "{function} reads no {path}: {:?}", report.inputs);
        }
        assert!(report.total.samples >= 2000, "{function}");
    }
}

#[test]
fn a_loop_without_end_is_a_finding_and_no_end() {
    let mut request = request("endless");
    request.samples = 3000;
    let report = run(&source(), &request);
    let found = report.findings.iter().find(|found| found.hazard.code() == "endless-loop");
    assert!(found.is_some(), "{:?}", report.findings.len());
    assert!(report.total.endless > 0 && report.total.samples > report.total.endless);
}
