//! Bad and good twins, and the shaders of the repository.

use crate::find_hazards::{changed, findings, found, has};
use landfall_layout::finding::Level;

/// Every lint of hazards.
pub const CODES: [&str; 17] = [
    "ambient-per-light",
    "attenuation-division",
    "cone-division",
    "cosine-cone",
    "degrees-for-cosine",
    "kahan-without-precise",
    "loop-past-count",
    "mediump-position",
    "pow-of-negative",
    "pow-of-zero",
    "unclamped-count",
    "ungated-specular",
    "unguarded-normalize",
    "unguarded-operation",
    "uninitialised-accumulator",
    "unnormalised-normal",
    "vec4-normalise",
];

/// A spotlight with everything that may go wrong, one a line.
const SPOT: &str = "\
#version 330 core
struct SpotLight {
    vec3 position;
    vec3 direction;
    vec3 color;
    float cutOff;
    float outerCutOff;
    float constant;
    float linear;
    float quadratic;
};
uniform SpotLight light;
uniform vec3 eye;
uniform float shininess;
in vec3 at;
in vec3 normal;
out vec4 color;
void main() {
    vec3 n = normalize(normal);
    vec3 path = light.position - at;
    vec3 l = normalize(path);
    vec3 v = normalize(eye - at);
    float theta = dot(l, normalize(-light.direction));
    float width = light.cutOff - light.outerCutOff;
    float inside = clamp((theta - light.outerCutOff) / width, 0.0, 1.0);
    float d = length(path);
    float weak = 1.0 / (light.constant + light.linear * d + light.quadratic * d * d);
    float x = max(dot(v, reflect(-l, n)), 0.0);
    float shine = pow(x, shininess);
    color = vec4(light.color * (max(dot(n, l), 0.0) + shine) * inside * weak, 1.0);
}
";

#[test]
fn the_published_form_of_a_spotlight_is_found_line_by_line() {
    assert_eq!(
        found("a.frag", SPOT),
        [
            "21 unguarded-normalize",
            "22 unguarded-normalize",
            "25 cosine-cone",
            "25 cone-division",
            "27 attenuation-division",
            "29 pow-of-zero",
            "29 ungated-specular",
        ]
    );
    // None of it is sure to happen: a check that nobody asked for more says nothing.
    assert_eq!(findings("a.frag", SPOT, Level::Allow), []);
}

#[test]
fn each_guard_takes_back_its_own_finding_and_no_other() {
    let all = found("a.frag", SPOT);
    for (gone, from, to) in [
        (
            "21 unguarded-normalize",
            "normalize(path)",
            "path * inversesqrt(max(dot(path, path), 1e-30))",
        ),
        ("21 unguarded-normalize", "normalize(path)", "path / max(length(path), 1e-15)"),
        ("22 unguarded-normalize", "normalize(eye - at)", "normalize(eye - vec3(0.0))"),
        ("25 cone-division", "/ width", "/ max(width, 1e-6)"),
        ("27 attenuation-division", "(light.constant +", "(1.0 +"),
        ("27 attenuation-division", "light.constant", "max(light.constant, 1e-6)"),
        ("29 pow-of-zero", "pow(x, shininess)", "pow(x, max(shininess, 1.0))"),
        ("29 pow-of-zero", "pow(x, shininess)", "pow(x, 32.0)"),
        ("29 pow-of-zero", "pow(x, shininess)", "(x > 0.0 ? pow(x, shininess) : 0.0)"),
        ("29 ungated-specular", "+ shine)", "* (1.0 + shine))"),
    ] {
        let mut left = all.clone();
        left.retain(|line| line != gone);
        assert_eq!(found("a.frag", &changed(SPOT, from, to)), left, "{to}");
    }
}

#[test]
fn a_highlight_on_the_lit_side_only_is_gated() {
    let shine = "float shine = pow(x, shininess);";
    for to in [
        "float shine = dot(n, l) > 0.0 ? pow(x, shininess) : 0.0;",
        "float shine = 0.0; if (max(dot(n, l), 0.0) > 0.0) { shine = pow(x, shininess); }",
        "float shine = pow(x, shininess) * step(0.0, dot(n, l));",
        "float side = max(dot(n, l), 0.0); float shine = side * pow(x, shininess);",
    ] {
        assert!(!has("ungated-specular", "a.frag", &changed(SPOT, shine, to)), "{to}");
    }
    // Fresnel's term is no highlight.
    let fresnel = "float shine = pow(1.0 - max(dot(normalize(l + v), v), 0.0), 5.0);";
    assert!(!has("ungated-specular", "a.frag", &changed(SPOT, shine, fresnel)));
    let half = "float shine = pow(max(dot(normalize(l + v), n), 0.0), 5.0);";
    assert!(has("ungated-specular", "a.frag", &changed(SPOT, shine, half)));
    // A cosine of something else gates nothing.
    let cone = "float shine = pow(x, shininess) * step(0.0, theta);";
    assert!(has("ungated-specular", "a.frag", &changed(SPOT, shine, cone)));
}

#[test]
fn a_chord_is_no_cosine() {
    let chord = changed(
        SPOT,
        "(theta - light.outerCutOff) / width",
        "(1.0 - light.outerCutOff - 0.5 * dot(l - light.direction, l - light.direction)) / width",
    );
    assert!(!has("cosine-cone", "a.frag", &chord));
    assert!(has("cone-division", "a.frag", &chord));
}

#[test]
fn degrees_are_known_by_number_name_or_comment() {
    let compared = |to: &str| changed(SPOT, "float d =", &format!("if ({to}) discard; float d ="));
    let is = |to: &str| has("degrees-for-cosine", "a.frag", &compared(to));
    assert!(is("theta < 12.5"));
    assert!(is("theta < cos(12.5)"));
    assert!(!is("theta < 0.976"));
    assert!(!is("theta < cos(radians(12.5))"));
    assert!(!is("theta < light.outerCutOff"));
    let commented = changed(&compared("theta < light.cutOff"), "cutOff;", "cutOff; // in degrees");
    assert!(has("degrees-for-cosine", "a.frag", &commented));
    let cosine = changed(&commented, "in degrees", "cosine of 12.5 degrees");
    assert!(!has("degrees-for-cosine", "a.frag", &cosine));
    // It never lights anything: said without being asked for.
    let default = findings("a.frag", &compared("theta < 12.5"), Level::Allow);
    assert_eq!(default.len(), 1, "{default:#?}");
}

#[test]
fn a_power_of_a_bare_dot_product_is_a_warning_and_of_one_past_rounding_is_not() {
    let bare = changed(SPOT, "max(dot(v, reflect(-l, n)), 0.0)", "dot(v, reflect(-l, n))");
    let default = findings("a.frag", &bare, Level::Allow);
    assert_eq!(default.len(), 1, "{default:#?}");
    assert_eq!((default[0].code.as_str(), default[0].place().line), ("pow-of-negative", 29));
    // 1 - dot may be -1.2e-7, which `check` keeps to itself: it is no certainty.
    let fresnel = changed(SPOT, "pow(x, shininess)", "pow(1.0 - dot(n, v), 5.0)");
    assert!(!has("pow-of-negative", "a.frag", &fresnel));
    let clamped = changed(SPOT, "pow(x, shininess)", "pow(clamp(dot(n, v), 0.0, 1.0), 5.0)");
    assert!(!has("pow-of-negative", "a.frag", &clamped));
}

#[test]
fn a_sum_without_a_first_value_is_found_where_it_is_added_to() {
    let text = |declared: &str, sum: &str| {
        format!(
            "#version 330 core\nstruct Light {{ vec3 pos; vec3 color; }};\nuniform Light lights[4];\n\
             out vec4 color;\nvoid main() {{\n    {declared}\n    for (int i = 0; i < 4; i++) {{\n        \
             {sum}\n    }}\n    color = vec4(total, 1.0);\n}}\n"
        )
    };
    let bad = text("vec3 total;", "total += lights[i].color;");
    assert_eq!(found("a.frag", &bad), ["8 uninitialised-accumulator"]);
    let spelled = text("vec3 total;", "total = lights[i].color + total;");
    assert_eq!(found("a.frag", &spelled), ["8 uninitialised-accumulator"]);
    let good = text("vec3 total = vec3(0.0);", "total += lights[i].color;");
    assert_eq!(found("a.frag", &good), [""; 0]);
    let set = text("vec3 total; total = vec3(0.1);", "total += lights[i].color;");
    assert_eq!(found("a.frag", &set), [""; 0]);
    let inner = text("vec3 total = vec3(0.0);", "vec3 one; one = lights[i].color; total += one;");
    assert_eq!(found("a.frag", &inner), [""; 0]);
    let output = text("vec3 total = vec3(0.0);", "color += vec4(lights[i].color, 1.0);");
    assert_eq!(found("a.frag", &output), ["8 uninitialised-accumulator"]);
    // Variables of WGSL begin with zero.
    let wgsl = "struct Light { pos: vec3f, color: vec3f }\n\
                @group(0) @binding(0) var<uniform> lights: array<Light, 4>;\n\
                @fragment fn main() -> @location(0) vec4f {\n    var total: vec3f;\n    \
                for (var i = 0; i < 4; i++) { total += lights[i].color; }\n    \
                return vec4f(total, 1.0);\n}\n";
    assert_eq!(found("a.wgsl", wgsl), [""; 0]);
}

#[test]
fn an_interpolated_normal_matters_where_it_is_raised_to_a_power() {
    let warned = |from: &str, to: &str| {
        let findings = findings("a.frag", &changed(SPOT, from, to), Level::Allow);
        findings.iter().any(|finding| finding.code == "unnormalised-normal")
    };
    assert!(warned("reflect(-l, n)", "reflect(-l, normal)"));
    assert!(warned("dot(v, reflect(-l, n))", "dot(normal, normalize(l + v))"));
    // A diffuse term is only a little darker.
    assert!(!warned("dot(n, l)", "dot(normal, l)"));
    assert!(!warned("reflect(-l, n)", "reflect(-l, normalize(normal))"));
    let flat = changed(SPOT, "in vec3 normal;", "flat in vec3 normal;");
    let flat = changed(&flat, "reflect(-l, n)", "reflect(-l, normal)");
    assert!(!has("unnormalised-normal", "a.frag", &flat));
}

#[test]
fn a_normal_transformed_in_four_components_is_found_without_any_light() {
    let text = "#version 330 core\nuniform mat4 view;\nin vec3 n;\nout vec3 o;\nvoid main() {\n    \
                o = normalize(transpose(inverse(view)) * vec4(n, 0.0)).xyz;\n    gl_Position = view[0];\n}\n";
    assert_eq!(found("a.vert", text), ["6 vec4-normalise"]);
    let first = changed(
        text,
        "normalize(transpose(inverse(view)) * vec4(n, 0.0)).xyz",
        "normalize((transpose(inverse(view)) * vec4(n, 0.0)).xyz)",
    );
    assert_eq!(found("a.vert", &first), [""; 0]);
    let three = changed(
        text,
        "normalize(transpose(inverse(view)) * vec4(n, 0.0)).xyz",
        "normalize(mat3(transpose(inverse(view))) * n)",
    );
    assert_eq!(found("a.vert", &three), [""; 0]);
}

const KAHAN: &str = "\
struct Light { position: vec3f, intensity: f32 }
@group(0) @binding(0) var<uniform> lights: array<Light, 64>;
@fragment fn main() -> @location(0) vec4f {
    var sum = 0.0;
    var lost = 0.0;
    for (var i = 0; i < 64; i++) {
        let y = lights[i].intensity - lost;
        let t = sum + y;
        lost = (t - sum) - y;
        sum = t;
    }
    return vec4f(sum);
}
";

#[test]
fn a_compensated_sum_holds_only_where_it_is_precise() {
    assert_eq!(found("a.wgsl", KAHAN), ["9 kahan-without-precise"]);
    let plain = changed(KAHAN, "lost = (t - sum) - y;", "lost = (t - sum) * 0.0;");
    assert_eq!(found("a.wgsl", &plain), [""; 0]);
    let lint = landfall_lint::lint("kahan-without-precise").unwrap();
    assert!(has("kahan-without-precise", "a.frag", lint.example));
    let precise = changed(lint.example, "float sum", "precise float sum");
    assert!(!has("kahan-without-precise", "a.frag", &precise));
}

#[test]
fn the_shaders_of_the_repository_are_silent_unless_asked() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    let mut todo = vec![root];
    let mut seen = 0;
    while let Some(path) = todo.pop() {
        if path.is_dir() {
            // Seeds are the published forms, hazards and all.
            if path.ends_with("seed") || path.ends_with("hazards") {
                continue;
            }
            todo.extend(std::fs::read_dir(&path).unwrap().map(|entry| entry.unwrap().path()));
            continue;
        }
        let Ok(source) = Source::read(&path) else { continue };
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        if !["frag", "vert", "comp", "wgsl"].contains(&extension) {
            continue;
        }
        seen += 1;
        assert_eq!(findings(&source.path, &source.text, Level::Allow), [], "{}", source.path);
        // The lighting functions keep their values wherever the light, the camera and the cone are.
        let robust = ["casters", "light_arrays", "six_lights", "view_space"];
        if robust.iter().any(|folder| path.components().any(|c| c.as_os_str() == *folder)) {
            for code in [
                "unguarded-normalize",
                "attenuation-division",
                "cone-division",
                "cosine-cone",
                "pow-of-zero",
                "unclamped-count",
                "loop-past-count",
            ] {
                assert!(!has(code, &source.path, &source.text), "{} {code}", source.path);
            }
        }
    }
    assert!(seen > 50, "{seen}");
}

use landfall_layout::Source;
