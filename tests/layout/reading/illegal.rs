//! Declarations that no compiler takes, each beside a twin that compilers take: glslang refuses the
//! one for OpenGL and for Vulkan, and takes the other for one of them at least.

use super::{Client, Severity, compiled, read, severities};
use crate::support::glslang;

pub(super) fn is_taken(text: &str) -> bool {
    glslang::accepts(text, "frag") || compiled(text, Client::Vulkan).is_ok()
}

/// A shader with these declarations; without a version of its own it is 4.50.
pub(super) fn shader(declarations: &str) -> String {
    let version = if declarations.starts_with("#version") { "" } else { "#version 450\n" };
    format!("{version}{declarations}\nvoid main() {{}}\n")
}

pub(super) fn hold(
    code: &str,
    severity: Severity,
    illegal: &[impl AsRef<str>],
    legal: &[impl AsRef<str>],
) {
    for declarations in illegal {
        let text = shader(declarations.as_ref());
        assert!(!is_taken(&text), "glslang takes {text}");
        assert!(severities(&text, code).contains(&severity), "{text}: {:?}", read(&text, None));
    }
    for declarations in legal {
        let text = shader(declarations.as_ref());
        assert!(is_taken(&text), "glslang refuses {text}");
        assert_eq!(severities(&text, code), [], "{text}: {:?}", read(&text, None));
    }
}

/// A block of one member with those qualifiers.
fn member(qualifiers: &str) -> String {
    format!("layout(std140, binding = 0) uniform U {{ {qualifiers} vec4 a; }} u;")
}

fn block(qualifiers: &str, ids: &str) -> String {
    format!("layout(std140, binding = 0{ids}) {qualifiers} uniform U {{ vec4 a; }} u;")
}

#[test]
fn qualifiers_that_members_of_blocks_may_not_have_are_errors() {
    let layout = [
        "std140",
        "std430",
        "shared",
        "packed",
        "binding = 1",
        "location = 1",
        "component = 1",
        "index = 1",
        "constant_id = 1",
        "push_constant",
        "rgba8",
        "r32ui",
    ];
    let words = [
        "flat",
        "smooth",
        "noperspective",
        "centroid",
        "sample",
        "invariant",
        "const",
        "in",
        "out",
        "buffer",
    ];
    let illegal = layout.map(|id| member(&format!("layout({id})")));
    let illegal: Vec<String> = illegal.into_iter().chain(words.map(member)).collect();
    let legal = ["layout(offset = 16)", "layout(align = 32)", "uniform", "precise", "highp", ""];
    let matrix = "layout(std140, binding = 0) uniform U { layout(row_major) mat4 a; } u;";
    let legal: Vec<String> = legal.map(member).into_iter().chain([matrix.to_string()]).collect();
    hold("layout-qualifier", Severity::Error, &illegal, &legal);
}

#[test]
fn qualifiers_that_blocks_may_not_have_are_errors() {
    let illegal = [
        block("", ", location = 1"),
        block("", ", component = 1"),
        block("", ", index = 1"),
        block("", ", offset = 16"),
        block("", ", constant_id = 1"),
        block("", ", rgba8"),
        block("flat", ""),
        block("centroid", ""),
        block("sample", ""),
        block("invariant", ""),
        block("const", ""),
        block("in", ""),
    ];
    let legal =
        [block("", ""), block("", ", align = 16"), block("highp", ""), block("precise", "")];
    hold("layout-qualifier", Severity::Error, &illegal, &legal);
}

#[test]
fn offsets_in_a_block_that_the_driver_lays_out_are_errors() {
    let of = |version: &str, ids: &str, member: &str| {
        format!("#version {version}\nlayout({ids}) uniform U {{ layout({member}) vec4 a; }} u;")
    };
    let illegal = [
        of("450", "shared, binding = 0", "offset = 16"),
        of("450", "packed, binding = 0", "align = 16"),
        of("450", "shared, binding = 0, align = 16", "row_major"),
        of("440", "shared", "offset = 16"),
    ];
    let legal = [
        of("450", "std140, binding = 0", "offset = 16"),
        of("450", "std140, binding = 0, align = 16", "row_major"),
        // Vulkan has std140 where none is named.
        of("450", "set = 0, binding = 0", "offset = 16"),
        of("450", "binding = 0", "offset = 16"),
    ];
    hold("layout-qualifier", Severity::Error, &illegal, &legal);
}

#[test]
fn initialisers_of_members_are_errors() {
    let illegal = "layout(std140, binding = 0) uniform U { vec4 a = vec4(1.0); } u;";
    hold("syntax", Severity::Error, &[illegal], &[&member("")]);
}

#[test]
fn global_names_of_blocks_are_declared_once() {
    let u = "layout(std140, binding = 0) uniform U { vec4 a; } u;";
    let open = "layout(std140, binding = 0) uniform U { vec4 a; };";
    let w = |declaration: &str| format!("layout(std140, binding = 1) uniform {declaration};");
    let illegal = [
        format!("{u}\nvec4 U;"),
        format!("vec4 U;\n{u}"),
        format!("struct U {{ vec4 a; }};\n{u}"),
        format!("{u}\nstruct U {{ vec4 a; }};"),
        format!("{u}\nvec4 U() {{ return vec4(0.0); }}"),
        format!("vec4 U() {{ return vec4(0.0); }}\n{u}"),
        format!("{u}\nstruct u {{ vec4 a; }};"),
        format!("{u}\nfloat u() {{ return 1.0; }}"),
        format!("{u}\n{}", w("W { vec4 a; } u")),
        format!("{u}\n{}", w("U { vec4 a; } w")),
        format!("{open}\n{}", w("W { vec4 a; }")),
        format!("{open}\nvec4 a;"),
        format!("const int a = 3;\n{open}"),
        format!("layout(binding = 2) uniform sampler2D a;\n{open}"),
        format!("{open}\nfloat a() {{ return 1.0; }}"),
        w("W { vec4 a; } W"),
        w("W { vec4 W; }"),
    ];
    let reference = "#version 450\n#extension GL_EXT_buffer_reference : require\n";
    let legal = [
        format!("{u}\n{}", w("W { vec4 a; } w")),
        format!("{u}\nvec4 a;"),
        format!("{u}\nlayout(std430, binding = 1) buffer U {{ vec4 a; }} w;"),
        format!("layout(location = 0) in U {{ vec4 a; }} v;\n{u}"),
        format!("float a() {{ return 1.0; }}\n{open}"),
        format!("float f(float a) {{ vec4 U = vec4(a); return U.x; }}\n{open}"),
        format!(
            "{reference}layout(buffer_reference) buffer P {{ uint a; }};\n\
             layout(buffer_reference) buffer Q {{ uint a; }};\n{u}"
        ),
    ];
    hold("duplicate-name", Severity::Error, &illegal, &legal);
}

#[test]
fn arrays_of_blocks_have_a_size_in_es() {
    let of = |version: &str, dims: &str| {
        format!(
            "#version {version}\nprecision mediump float;\n\
             layout(std140) uniform U {{ vec4 a; }} u{dims};"
        )
    };
    hold(
        "array-size",
        Severity::Error,
        &[&of("300 es", "[]"), &of("310 es", "[]")],
        &[&of("300 es", "[2]"), &of("450", "[]")],
    );
}

/// Drivers may take them all the same: a warning.
#[test]
fn blocks_and_rules_that_the_version_does_not_have_are_warnings() {
    let uniform = |version: &str| {
        format!("#version {version}\nprecision mediump float;\nuniform U {{ vec4 a; }};")
    };
    let buffer = |version: &str| {
        format!("#version {version}\nprecision mediump float;\nbuffer U {{ vec4 a; }};")
    };
    let desktop = |text: String| text.replace("precision mediump float;\n", "");
    let std430 = "layout(std430, binding = 0) uniform U { vec4 a; } u;";
    let illegal = [
        desktop(uniform("120")),
        desktop(uniform("130")),
        uniform("100"),
        desktop(buffer("420")),
        buffer("300 es"),
        std430.to_string(),
    ];
    let legal = [
        desktop(uniform("130\n#extension GL_ARB_uniform_buffer_object : enable")),
        desktop(uniform("140")),
        uniform("300 es"),
        desktop(buffer("420\n#extension GL_ARB_shader_storage_buffer_object : enable")),
        desktop(buffer("430")),
        buffer("310 es"),
        format!("#version 450\n#extension GL_EXT_scalar_block_layout : require\n{std430}"),
    ];
    hold("version", Severity::Warning, &illegal, &legal);
}

/// glslang refuses them for OpenGL and for Vulkan; some drivers of OpenGL take offsets early.
#[test]
fn rules_and_offsets_without_their_extension_or_version_are_warned_of() {
    let of = |version: &str, extension: &str, rest: &str| {
        let extension = match extension {
            "" => String::new(),
            name => format!("#extension {name} : require\n"),
        };
        format!("#version {version}\n{extension}{rest}")
    };
    let scalar = "layout(scalar, binding = 0) uniform U { vec3 a; float b; } u;";
    let by_default = "layout(scalar) uniform;\nlayout(binding = 0) uniform U { vec4 a; } u;";
    let reference = "layout(buffer_reference, std430) buffer R { vec4 a; };";
    let offset = "layout(std140) uniform U { layout(offset = 16) vec4 a; } u;";
    let align = "layout(std140) uniform U { layout(align = 32) vec4 a; } u;";
    let illegal = [
        of("450", "", scalar),
        of("310 es", "", &scalar.replace("vec3 a; float b;", "highp vec3 a;")),
        of("450", "", by_default),
        of("450", "", reference),
    ];
    let legal = [
        of("450", "GL_EXT_scalar_block_layout", scalar),
        of("450", "GL_EXT_scalar_block_layout", by_default),
        of("450", "GL_EXT_buffer_reference", reference),
        of("450", "GL_EXT_buffer_reference2", reference),
        of("450", "GL_EXT_buffer_reference_uvec2", reference),
        of("440", "", offset),
        of("330", "GL_ARB_enhanced_layouts", offset),
        of("330", "GL_ARB_enhanced_layouts", align),
    ];
    hold("version", Severity::Warning, &illegal, &legal);
    // For Vulkan glslang takes them in any version.
    for text in [offset, align] {
        for version in ["140", "330", "420", "430"] {
            let text = shader(&of(version, "", text));
            assert!(!glslang::accepts(&text, "frag"), "{text}");
            assert_eq!(severities(&text, "version"), [Severity::Warning], "{text}");
            let vulkan = read(&text, Some(::landfall::Target::Vulkan));
            assert!(!super::codes(&vulkan).contains(&"version"), "{text}");
        }
    }
}

#[test]
fn a_stage_has_one_block_of_push_constants() {
    let of = |name: &str| format!("layout(push_constant) uniform {name} {{ vec4 {name}_a; }};\n");
    let two = format!("{}{}", of("P"), of("Q"));
    let one = format!("{}layout(set = 0, binding = 0) uniform Q {{ vec4 b; }};", of("P"));
    hold("layout-qualifier", Severity::Error, &[two.as_str()], &[one.as_str()]);
    // glslang 12 knows ray tracing for SPIR-V 1.4 alone.
    let of =
        |name: &str| format!("layout(shaderRecordEXT) buffer {name} {{ vec4 a; }} {name}_i;\n");
    let text = format!(
        "#version 460\n#extension GL_EXT_ray_tracing : require\n{}{}void main() {{}}\n",
        of("P"),
        of("Q")
    );
    let options =
        glslang::Options { target_env: Some("vulkan1.2"), ..glslang::Options::unlisted() };
    glslang::blocks(&text, "rchit", &options).expect_err("two records");
    assert_eq!(severities(&text, "layout-qualifier"), [Severity::Error]);
}

#[test]
fn no_driver_chooses_a_layout_in_vulkan() {
    for text in [
        "layout(shared, set = 0, binding = 0) uniform U { vec4 a; } u;",
        "layout(packed, set = 1, binding = 0) buffer U { vec4 a; } u;",
        "layout(shared) uniform;\nlayout(set = 0, binding = 0) uniform U { vec4 a; } u;",
        "layout(shared, push_constant) uniform U { vec4 a; } u;",
    ] {
        let text = shader(text);
        assert!(compiled(&text, Client::Vulkan).is_err(), "{text}");
        assert_eq!(severities(&text, "layout-qualifier"), [Severity::Error], "{text}");
    }
    for text in [
        "layout(shared, binding = 0) uniform U { vec4 a; } u;",
        "layout(std140, set = 0, binding = 0) uniform U { vec4 a; } u;",
    ] {
        let text = shader(text);
        assert!(is_taken(&text), "{text}");
        assert_eq!(severities(&text, "layout-qualifier"), [], "{text}");
    }
}

#[test]
fn the_entry_point_has_neither_result_nor_parameters() {
    for head in ["int main()", "vec4 main(void)", "void main(int a)"] {
        let text = format!("#version 450\n{head} {{ }}\n");
        assert!(!is_taken(&text), "glslang takes {text}");
        assert_eq!(severities(&text, "syntax"), [Severity::Error], "{text}");
    }
    for text in [
        "#version 450\nvoid main() { }\n",
        "#version 450\nvoid main(void) { }\n",
        "#version 450\n#define main f\nint main(int a) { return a; }\n#undef main\nvoid main() { }\n",
    ] {
        assert!(is_taken(text), "glslang refuses {text}");
        assert_eq!(severities(text, "syntax"), [], "{text}");
    }
}

#[test]
fn a_layout_qualifier_has_identifiers() {
    let of = |ids: &str| format!("layout({ids}) uniform U {{ vec4 a; }} u;");
    let illegal = ["", "std140,", "binding = 1,"].map(of);
    let legal = [of("std140"), of("std140, binding = 1")];
    hold("syntax", Severity::Error, &illegal, &legal);
}
