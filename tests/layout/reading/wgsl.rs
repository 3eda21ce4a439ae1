//! What WGSL says of buffers and the features that lift its constraints.

use ::landfall::{Options, Source, layout};

use super::codes;

fn read(text: &str) -> ::landfall::ShaderLayout {
    layout(&Source::new("a.wgsl", text), &Options::default())
}

/// WGSL §14.4.1, table of SizeOf: a buffer that is no structure has the size of its type.
#[test]
fn a_variable_that_is_no_structure_has_the_size_of_its_type() {
    for (ty, size) in [
        ("vec3<f32>", 12),
        ("vec3<f16>", 6),
        ("vec2f", 8),
        ("vec4u", 16),
        ("mat3x3f", 48),
        ("mat2x3<f16>", 16),
        ("array<vec3f, 2>", 32),
        ("f32", 4),
    ] {
        let text = format!("enable f16; @group(0) @binding(0) var<storage> g: {ty};");
        let shader = read(&text);
        assert!(!shader.has_errors(), "{:?}", shader.diagnostics);
        assert_eq!(shader.blocks[0].size, Some(size), "{ty}");
    }
    let shader = read("struct U { a: vec3f } @group(0) @binding(0) var<uniform> u: U;");
    assert_eq!(shader.blocks[0].size, Some(16), "a structure is padded to its alignment");
}

/// WGSL §14.4.5 and its language feature.
#[test]
fn a_text_that_requires_standard_layouts_has_no_uniform_constraints() {
    let body = "struct U { a: f32, b: array<f32, 3>, c: f32 }\n\
                @group(0) @binding(0) var<uniform> u: U;\n";
    let constrained = ["uniform-constraints"; 1];
    assert_eq!(codes(&read(body)), constrained);
    for head in [
        "requires uniform_buffer_standard_layout;",
        "requires readonly_and_readwrite_storage_textures,\n\tuniform_buffer_standard_layout;",
        "requires/* x */uniform_buffer_standard_layout\t;",
    ] {
        assert_eq!(codes(&read(&format!("{head}\n{body}"))), [""; 0], "{head}");
    }
    for head in [
        "// requires uniform_buffer_standard_layout;",
        "requires /* uniform_buffer_standard_layout */ pointer_composite_access;",
    ] {
        assert_eq!(codes(&read(&format!("{head}\n{body}"))), constrained, "{head}");
    }
    for (head, told) in
        [("enable\tf16\t;", 0), ("enable/**/f16;", 0), ("enable /* f16 */ subgroups;", 1)]
    {
        let text = format!("{head} @group(0) @binding(0) var<storage> h: vec4<f16>;");
        let found = codes(&read(&text)).iter().filter(|c| **c == "f16-not-enabled").count();
        assert_eq!(found, told, "{head}");
    }
}

/// WGSL §4.1.2: a feature that a compiler does not know is an error in it; ours may be the older.
#[test]
fn unknown_language_features_and_address_spaces_of_naga_are_warnings() {
    let variable = "@group(0) @binding(0) var<storage> g: vec4f;";
    for (text, code) in [
        (format!("requires nonsense;\n{variable}"), vec!["unknown-name"]),
        (format!("requires pointer_composite_access, nonsense;\n{variable}"), vec!["unknown-name"]),
        (format!("requires pointer_composite_access, subgroup_id,;\n{variable}"), vec![]),
        ("var<push_constant> p: vec4f;".to_string(), vec!["unknown-address-space"]),
        ("var<immediate> p: vec4f;".to_string(), vec![]),
    ] {
        let shader = read(&text);
        assert!(!shader.has_errors() && shader.blocks.len() == 1, "{:?}", shader.diagnostics);
        assert_eq!(codes(&shader), code, "{text}");
    }
}
