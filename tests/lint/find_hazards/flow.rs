//! Values followed through functions, conditions, loops and structures.

use crate::find_hazards::{changed, found, has};
use landfall_exec::processor::Stopwatch;

const POINT: &str = "\
#version 330 core
struct PointLight { vec3 pos; vec3 color; };
layout(std140) uniform Lights { PointLight data[16]; int count; } lights;
in vec3 at;
out vec4 color;
vec3 towards(vec3 p) {
    return normalize(p - at);
}
void main() {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < min(lights.count, 16); i++) {
        PointLight light = lights.data[i];
        sum += light.color * towards(light.pos).z;
    }
    color = vec4(sum, 1.0);
}
";

#[test]
fn a_value_is_followed_into_a_function() {
    assert_eq!(found("a.frag", POINT), ["7 unguarded-normalize"]);
}

/// The half vector of two directions is zero where they are opposite; a sum of which one is no unit
/// vector, or that is guarded, is none.
#[test]
fn a_half_vector_of_opposite_directions_is_found() {
    let half = |code: &str| {
        let with = format!(
            "vec3 l = normalize(at * 3.0); vec3 v = normalize(at.zxy);\n    return {code};"
        );
        changed(POINT, "    return normalize(p - at);", &with)
    };
    let count = |text: &str| {
        found("a.frag", text).iter().filter(|line| line.ends_with("unguarded-normalize")).count()
    };
    assert_eq!(count(&half("normalize(l + v)")), 1);
    assert_eq!(count(&half("(l + v) / length(l + v)")), 1);
    assert_eq!(count(&half("(l + v) / sqrt(dot(l + v, l + v))")), 1);
    let guarded = "(l + v) * inversesqrt(max(dot(l + v, l + v), 1.0e-30))";
    for none in [guarded, "normalize(l + vec3(0.0, 3.0, 0.0))", "normalize(l + at)", "l + v"] {
        assert_eq!(count(&half(none)), 0, "{none}");
    }
    // The length as a root of a square is one, too.
    let root = "vec3 d = p - at; float d2 = dot(d, d);\n    return d / sqrt(d2);";
    assert_eq!(count(&changed(POINT, "    return normalize(p - at);", root)), 1);
}

#[test]
fn a_guard_holds_wherever_it_stands() {
    for (from, to) in [
        // In the function, as an early return.
        (
            "    return normalize(p - at);",
            "    if (length(p - at) < 1e-9) { return vec3(0.0); }\n    return normalize(p - at);",
        ),
        (
            "    return normalize(p - at);",
            "    if (p == at) return vec3(0.0);\n    return normalize(p - at);",
        ),
        (
            "    return normalize(p - at);",
            "    if (distance(p, at) > 0.0) { return normalize(p - at); }\n    return vec3(0.0);",
        ),
        (
            "    return normalize(p - at);",
            "    vec3 v = p - at; float d2 = dot(v, v);\n    return d2 > 0.0 ? v * inversesqrt(d2) : vec3(0.0);",
        ),
        // In the loop of the caller.
        (
            "        sum +=",
            "        if (distance(light.pos, at) < 1e-6) { continue; }\n        sum +=",
        ),
        (
            "        sum +=",
            "        vec3 v = light.pos - at; if (!(dot(v, v) > 1e-12 && light.color.r > 0.0)) continue;\n        sum +=",
        ),
    ] {
        let text = changed(POINT, from, to);
        assert!(!has("unguarded-normalize", "a.frag", &text), "{to}");
    }
    // A condition about something else guards nothing, nor does one that ends before.
    for (from, to) in [
        ("        sum +=", "        if (light.color.r > 0.0)\n        sum +="),
        (
            "        sum +=",
            "        if (distance(light.pos, at) > 1e-6) { sum.x = 1.0; }\n        sum +=",
        ),
        ("        sum +=", "        if (distance(light.pos, at) >= 0.0)\n        sum +="),
    ] {
        let text = changed(POINT, from, to);
        assert!(has("unguarded-normalize", "a.frag", &text), "{to}");
    }
}

#[test]
fn what_bounds_a_loop_is_told() {
    let bounded = |to: &str| found("a.frag", &changed(POINT, "i < min(lights.count, 16)", to));
    let only = |line: &str| vec!["7 unguarded-normalize".to_string(), line.to_string()];
    let none = vec!["7 unguarded-normalize".to_string()];
    assert_eq!(bounded("i < lights.count"), only("12 unclamped-count"));
    assert_eq!(bounded("i < 16"), only("12 loop-past-count"));
    assert_eq!(bounded("i < 16 && i < lights.count"), none);
    assert_eq!(bounded("i < clamp(lights.count, 0, 16)"), none);
    let breaks = changed(POINT, "i < min(lights.count, 16)", "i < 16");
    let breaks = changed(
        &breaks,
        "        PointLight",
        "        if (i >= lights.count) break;\n        PointLight",
    );
    assert_eq!(found("a.frag", &breaks), none);
    // An array without a count has nothing to be held against.
    let uncounted = changed(POINT, "; int count; }", "; }");
    let uncounted = changed(&uncounted, "i < min(lights.count, 16)", "i < 16");
    assert_eq!(found("a.frag", &uncounted), none);
}

#[test]
fn a_difference_of_two_uploads_is_the_programs_own_affair() {
    let text = changed(POINT, "normalize(p - at)", "normalize(p - lights.data[0].pos)");
    assert!(!has("unguarded-normalize", "a.frag", &text));
}

#[test]
fn light_positions_are_known_behind_swizzles_matrices_and_arrays_of_members() {
    let four = changed(POINT, "struct PointLight { vec3 pos;", "struct PointLight { vec4 pos;");
    let four = changed(&four, "towards(light.pos)", "towards(light.pos.xyz)");
    assert!(has("unguarded-normalize", "a.frag", &four));
    let moved = changed(&four, "light.pos.xyz", "(mat4(2.0) * light.pos).xyz");
    assert!(has("unguarded-normalize", "a.frag", &moved));
    let arrays = "#version 330 core\nuniform vec3 lightPositions[4];\nuniform vec3 lightColors[4];\n\
                  in vec3 at;\nout vec4 color;\nvoid main() {\n    vec3 sum = vec3(0.0);\n    \
                  for (int i = 0; i < 4; i++) {\n        vec3 l = normalize(lightPositions[i] - at);\n        \
                  float d = length(lightPositions[i] - at);\n        sum += lightColors[i] * l.z / (d * d);\n    }\n    \
                  color = vec4(sum, 1.0);\n}\n";
    assert_eq!(found("a.frag", arrays), ["9 unguarded-normalize", "11 attenuation-division"]);
}

#[test]
fn wgsl_is_followed_too() {
    let text = "\
struct Light { position: vec3f, color: vec3f, constant: f32, linear: f32, quadratic: f32 }
struct Lights { data: array<Light, 8>, count: u32 }
struct In { @location(0) at: vec3f, @location(1) normal: vec3f }
@group(0) @binding(0) var<uniform> lights: Lights;
@fragment fn main(in: In) -> @location(0) vec4f {
    var sum = vec3f();
    for (var i = 0u; i < lights.count; i++) {
        let light = lights.data[i];
        let l = normalize(light.position - in.at);
        let d = distance(light.position, in.at);
        let r = reflect(-l, in.normal);
        sum += light.color * pow(r.z, 2.0) / (light.constant + light.linear * d);
    }
    return vec4f(sum, 1.0);
}
";
    let expected = [
        "8 unclamped-count",
        "9 unguarded-normalize",
        "11 unnormalised-normal",
        "12 attenuation-division",
    ];
    assert_eq!(found("a.wgsl", text), expected);
}

#[test]
fn a_text_made_to_take_long_does_not() {
    let loops: String =
        (0..24).map(|i| format!("for (int i{i} = 0; i{i} < 4; i{i}++) {{\n")).collect();
    let text = format!(
        "#version 330 core\nuniform vec3 lightPos;\nuniform vec3 lightColor;\nin vec3 at;\nout vec4 color;\n\
         void main() {{ vec3 sum = vec3(0.0);\n{loops} sum += lightColor * normalize(lightPos - at);\n{}\n\
         color = vec4(sum, 1.0); }}\n",
        "}".repeat(24)
    );
    let start = Stopwatch::start();
    let _ = found("a.frag", &text);
    // Functions that each call the one before twice: 2^40 calls.
    let calls: String = (1..40)
        .map(|i| format!("vec3 f{i}(vec3 p) {{ return f{}(p) + f{}(p + 1.0); }}\n", i - 1, i - 1))
        .collect();
    let text = format!(
        "#version 330 core\nuniform vec3 lightPos;\nuniform vec3 lightColor;\nin vec3 at;\nout vec4 color;\n\
         vec3 f0(vec3 p) {{ return normalize(lightPos - p); }}\n{calls}\
         void main() {{ color = vec4(f39(at) * lightColor, 1.0); }}\n"
    );
    let _ = found("a.frag", &text);
    // Squares of squares: each is twice the one before.
    let squares = "x = x * x;\n".repeat(2000);
    let text = format!(
        "#version 330 core\nuniform vec3 lightPos;\nuniform vec3 lightColor;\nin vec3 at;\nout vec4 color;\n\
         void main() {{ float x = dot(normalize(lightPos - at), at);\n{squares}\
         color = vec4(lightColor * pow(x, 2.0), 1.0); }}\n"
    );
    let _ = found("a.frag", &text);
    assert!(start.elapsed().as_secs() < 60, "{:?}", start.elapsed());
}
