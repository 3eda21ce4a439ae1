//! Names, places and types that no compiler takes, each beside a twin that compilers take.

use super::Severity;
use super::illegal::hold;

const U: &str = "layout(std140, binding = 0) uniform";

#[test]
fn keywords_and_names_of_the_language_are_no_names_of_blocks() {
    let keywords = ["if", "discard", "struct", "float", "vec4", "true", "switch", "sampler2D"];
    let mut illegal: Vec<String> =
        keywords.iter().map(|word| format!("{U} U {{ float {word}; }} u;")).collect();
    illegal.extend([
        format!("{U} U {{ float a, while; }} u;"),
        format!("{U} float {{ vec4 a; }} u;"),
        format!("{U} if {{ vec4 a; }} u;"),
        format!("{U} U {{ vec4 a; }} else;"),
        format!("{U} gl_U {{ vec4 a; }} u;"),
        format!("{U} U {{ vec4 gl_a; }} u;"),
        format!("{U} U {{ vec4 a; }} gl_u;"),
        "struct S { float if; };".to_string(),
        "struct vec2 { float a; };".to_string(),
        "uniform float return;".to_string(),
        "uniform buffer U { vec4 a; } u;".to_string(),
        "buffer uniform U { vec4 a; } u;".to_string(),
    ]);
    let legal = [
        format!("{U} U {{ float iff, _if, glow; }} u;"),
        format!("{U} floats {{ vec4 a; }} u;"),
        // glslang takes it, other than a member of a block.
        format!("struct S {{ vec4 gl_a; }};\n{U} U {{ S a; }} u;"),
        "#version 120\n#extension GL_ARB_uniform_buffer_object : enable\nuniform U { float lowp; };"
            .to_string(),
        format!("#define if iff\n{U} U {{ float if; }} u;"),
        "layout(binding = 0) buffer U { vec4 a; } u;".to_string(),
    ];
    for illegal in &illegal {
        let shader = super::read(&super::illegal::shader(illegal), None);
        assert!(shader.has_errors(), "{illegal}: {:?}", shader.diagnostics);
        assert!(!super::illegal::is_taken(&super::illegal::shader(illegal)), "{illegal}");
    }
    hold("syntax", Severity::Error, &[""; 0], &legal);
    hold("layout-qualifier", Severity::Error, &illegal[illegal.len() - 2..], &legal);
}

#[test]
fn structures_are_not_declared_inside_structures_or_blocks() {
    let illegal = [
        format!("{U} U {{ struct S {{ float x; }} a; }} u;"),
        format!("{U} U {{ struct {{ float x; }} a; }} u;"),
        format!("struct T {{ struct S {{ float x; }} a; }};\n{U} U {{ T a; }} u;"),
    ];
    let legal = [format!("struct S {{ float x; }};\n{U} U {{ S a; }} u;")];
    hold("syntax", Severity::Error, &illegal, &legal);
}

#[test]
fn blocks_are_not_declared_inside_functions() {
    let illegal = [
        format!("void f() {{ {U} U {{ vec4 a; }} u; }}"),
        "void f() { if (true) { buffer  U\n{ vec4 a; } u; } }".to_string(),
        format!("#define V 1\nvoid f() {{\n#if V\n{U} U {{ vec4 a; }} u;\n#endif\n}}"),
    ];
    let legal = [
        format!("void f() {{\n#if 0\n{U} U {{ vec4 a; }} u;\n#endif\n}}"),
        format!("void f() {{ /* {U} U {{ vec4 a; }} u; */ }}"),
        "void f() { float my_uniform = 1.0; if (my_uniform > 0.0) {} }".to_string(),
    ];
    hold("syntax", Severity::Error, &illegal, &legal);
}

#[test]
fn push_constants_have_no_descriptor_and_are_one_uniform_block() {
    let of = |ids: &str, rest: &str| format!("layout(push_constant{ids}) {rest}");
    let illegal = [
        of(", binding = 0", "uniform U { vec4 a; } u;"),
        of(", set = 0", "uniform U { vec4 a; } u;"),
        of("", "buffer U { vec4 a; } u;"),
        of("", "uniform U { vec4 a; } u[2];"),
    ];
    let legal = [
        of("", "uniform U { vec4 a; } u;"),
        of(", std140", "uniform U { vec4 a; } u;"),
        format!("#version 330\n{}", of("", "uniform U { vec4 a; } u;")),
    ];
    hold("layout-qualifier", Severity::Error, &illegal, &legal);
}

#[test]
fn blocks_of_inputs_have_no_rules() {
    let of = |ids: &str| format!("layout(location = 0{ids}) in U {{ vec4 a; }} u;");
    let ids = ["std140", "std430", "shared", "packed", "row_major", "column_major", "binding = 0"];
    let illegal = ids.map(|id| of(&format!(", {id}")));
    hold("layout-qualifier", Severity::Error, &illegal, &[&of("")]);
}

/// Drivers may take them all the same: a warning.
#[test]
fn types_and_bindings_that_the_version_does_not_have_are_warnings() {
    let of = |head: &str, ty: &str| format!("{head}layout(std140) uniform U {{ {ty} a; }} u;");
    let new = |extension: &str, ty: &str| {
        let head = format!("#version 450\n#extension {extension} : require\n");
        format!("{head}{U} U {{ {ty} a; }} u;")
    };
    let es = "#version 310 es\nprecision mediump float;\n";
    let plain = ["f16vec2", "float16_t", "int64_t", "u64vec3", "int8_t", "u16vec2", "f32vec4"];
    let mut illegal: Vec<String> = plain.iter().map(|ty| of("#version 450\n", ty)).collect();
    illegal.extend([
        of("#version 330\n", "double"),
        of(es, "double"),
        format!("#version 330\n{U} U {{ vec4 a; }};"),
        format!("#version 300 es\nprecision mediump float;\n{U} U {{ vec4 a; }};"),
    ]);
    let pack = "#extension GL_ARB_shading_language_420pack : enable";
    let legal = [
        new("GL_EXT_shader_16bit_storage", "f16vec2"),
        new("GL_EXT_shader_8bit_storage", "int8_t"),
        new("GL_EXT_shader_16bit_storage", "u16vec2"),
        new("GL_ARB_gpu_shader_int64", "int64_t"),
        new("GL_EXT_shader_explicit_arithmetic_types", "f32vec4"),
        new("GL_EXT_shader_explicit_arithmetic_types_int64", "u64vec3"),
        new("GL_AMD_gpu_shader_half_float", "float16_t"),
        of("#version 400\n", "double"),
        of("#version 330\n#extension GL_ARB_gpu_shader_fp64 : enable\n", "double"),
        format!("#version 330\n{pack}\n{U} U {{ vec4 a; }};"),
        format!("#version 420\n{U} U {{ vec4 a; }};"),
        format!("{es}{U} U {{ vec4 a; }};"),
    ];
    hold("version", Severity::Warning, &illegal, &legal);
}
