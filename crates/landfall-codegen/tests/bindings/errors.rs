//! What an API cannot bind is named, and what the options set is in the text.

use landfall_codegen::rust::{Api, RustOptions, rust};
use landfall_layout::{Options, Source, layout};

/// The messages about shaders, each a path and a text, and the generated text.
fn bindings(shaders: &[(&str, &str)], options: &RustOptions) -> (Vec<String>, String) {
    let read = |(path, text): &(&str, &str)| {
        let shader = layout(&Source::new(*path, *text), &Options::default().with_interface(true));
        assert!(!shader.has_errors(), "{path}: {:#?}", shader.diagnostics);
        shader
    };
    let shaders: Vec<_> = shaders.iter().map(read).collect();
    let output = rust(&shaders.iter().collect::<Vec<_>>(), options);
    let of_bindings = |code: &str| matches!(code, "no-binding" | "bad-name" | "numbered-name");
    let found = output.diagnostics.into_iter().filter(|one| of_bindings(one.code.name()));
    (found.map(|one| one.message).collect(), output.text)
}

fn for_api(api: Api) -> RustOptions {
    let mut options = RustOptions::default();
    options.bindings.apis = vec![api];
    options
}

#[test]
fn what_an_api_cannot_bind_is_named() {
    let uses = |declared: &str, used: &str| {
        format!(
            "#version 450\n{declared}\nlayout(location = 0) out vec4 color;\nvoid main() {{ color = \
             {used}; }}\n"
        )
    };
    for (api, path, text, expected) in [
        (Api::Wgpu, "a.frag", uses("layout(std140) uniform U { vec4 x; };", "x"),
         "`U` has no binding, which wgpu needs"),
        (Api::Ash, "a.frag", uses("layout(std140) uniform U { vec4 x; };", "x"),
         "`U` has no binding, which Vulkan needs"),
        (Api::Wgpu, "a.frag",
         uses("layout(binding = 0) uniform sampler2D t;", "texture(t, vec2(0))"),
         "wgpu has no texture with a sampler of its own, such as `t`"),
        (Api::Wgpu, "a.frag",
         uses("layout(binding = 0) uniform writeonly image2D t;",
              "vec4(0); imageStore(t, ivec2(0), color)"),
         "wgpu needs the format of image `t`"),
        (Api::Wgpu, "a.frag",
         uses("layout(binding = 0) uniform samplerBuffer t;", "texelFetch(t, 0)"),
         "wgpu has no texel buffers, such as `t`"),
        (Api::Ash, "a.frag",
         uses("layout(binding = 0) uniform sampler2DRect t;", "texture(t, vec2(0))"),
         "Vulkan has no rectangle textures, such as `t`"),
        (Api::Wgpu, "a.glsl", uses("", "vec4(0)"), "the stage of a.glsl is not known"),
        (Api::Wgpu, "a.geom", "#version 450\nvoid main() {}\n".to_string(),
         "wgpu has no geometry stage"),
        (Api::Wgpu, "a.vert",
         "#version 450\nin vec3 at;\nvoid main() { gl_Position = vec4(at, 1.0); }\n".to_string(),
         "input `at` has no location"),
        (Api::Wgpu, "a.wgsl",
         "enable f16;\n@vertex fn v(@location(0) at: vec3h) -> @builtin(position) vec4f { return \
          vec4f(vec3f(at), 1.0); }\n".to_string(),
         "no vertex format fits input `at`"),
        (Api::Wgpu, "a.wgsl",
         "@group(0) @binding(0) var<uniform> a: vec4f;\n@group(0) @binding(0) var<uniform> b: \
          vec4f;\n@fragment fn f() -> @location(0) vec4f { return a + b; }\n".to_string(),
         "`a` and `b` of one program have the same binding"),
    ] {
        let (found, _) = bindings(&[(path, &text)], &for_api(api));
        assert_eq!(found, [expected], "{text}");
    }
}

#[test]
fn entry_points_of_one_module_may_be_two_programs() {
    let text = "@group(0) @binding(0) var<uniform> a: vec4f;\n@group(0) @binding(0) var<uniform> b: \
                vec2f;\n@fragment fn f() -> @location(0) vec4f { return a; }\n@fragment fn g() -> \
                @location(0) vec4f { return b.xyxy; }\n";
    let mut options = for_api(Api::Wgpu);
    options.bindings.programs = vec![
        ("one".to_string(), vec!["a.wgsl:f".to_string()]),
        ("two".to_string(), vec!["a.wgsl:g".to_string()]),
    ];
    let (found, text) = bindings(&[("a.wgsl", text)], &options);
    assert_eq!(found, [""; 0]);
    let (one, two) = text.split_once("pub mod two").expect("two programs");
    assert!(one.contains("pub a: wgpu::BufferBinding<'a>") && one.contains("new(16)"), "{one}");
    assert!(two.contains("pub b: wgpu::BufferBinding<'a>") && two.contains("new(8)"), "{two}");
}

#[test]
fn a_module_that_uses_a_binding_twice_is_a_program_for_each_entry_point() {
    let text = "@group(0) @binding(0) var<uniform> a: vec4f;\n@group(0) @binding(0) var<storage> b: \
                vec2f;\n@group(0) @binding(1) var<uniform> c: vec4f;\n@group(0) @binding(1) \
                var<uniform> d: vec3f;\n@vertex fn v() -> @builtin(position) vec4f { return c; }\n\
                @vertex fn w() -> @builtin(position) vec4f { return a; }\n@vertex fn x() -> \
                @builtin(position) vec4f { return vec4f(b, d.xy); }\n@fragment fn f() -> @location(0) \
                vec4f { return a; }\n@fragment fn g() -> @location(0) vec4f { return b.xyxy; }\n\
                @compute @workgroup_size(1) fn k() { _ = d; }\n";
    let (found, text) = bindings(&[("m.wgsl", text)], &for_api(Api::Wgpu));
    assert_eq!(found, [""; 0]);
    let programs: Vec<&str> = text.split("        pub mod ").skip(1).collect();
    let entries = |program: &str| {
        let names = program.match_indices("_ENTRY: &str = \"");
        let name = |at: usize| program[at..].split('"').nth(1).expect("a name").to_string();
        let names: Vec<String> = names.map(|(at, _)| name(at)).collect();
        (program.split(' ').next().expect("a name").to_string(), names.join(" "))
    };
    // `x` fits neither `f`, of `a`, nor `v`, of `c`, which fits `g` as well.
    let expected = [("m_f", "v w f"), ("m_g", "v g"), ("m_k", "k"), ("m_x", "x")];
    let expected = expected.map(|(name, entries)| (name.to_string(), entries.to_string()));
    assert_eq!(programs.iter().copied().map(entries).collect::<Vec<_>>(), expected, "{text}");
}

#[test]
fn options_change_what_they_name() {
    let text = "@group(0) @binding(0) var<uniform> scene: vec4f;\n@group(0) @binding(1) var t: \
                texture_2d<f32>;\n@group(0) @binding(2) var s: sampler;\n@fragment fn f() -> \
                @location(0) vec4f { return scene * textureSample(t, s, scene.xy); }\n";
    let (_, text_without) = bindings(&[("a.wgsl", text)], &for_api(Api::Wgpu));
    let mut options = for_api(Api::Wgpu);
    options.bindings.dynamic_offsets = vec!["scene".to_string()];
    options.bindings.unfilterable = vec!["t".to_string(), "s".to_string()];
    let (found, text_with) = bindings(&[("a.wgsl", text)], &options);
    assert_eq!(found, [""; 0]);
    for (without, with) in [
        ("has_dynamic_offset: false", "has_dynamic_offset: true"),
        ("Float { filterable: true }", "Float { filterable: false }"),
        ("SamplerBindingType::Filtering", "SamplerBindingType::NonFiltering"),
    ] {
        assert!(text_without.contains(without) && !text_without.contains(with), "{without}");
        assert!(text_with.contains(with) && !text_with.contains(without), "{with}");
    }
}

#[test]
fn programs_of_two_folders_have_names_of_their_own() {
    let text = "#version 450\nlayout(location = 0) out vec4 color;\nlayout(binding = 0, std140) \
                uniform U { vec4 x; };\nvoid main() { color = x; }\n";
    let (found, text) =
        bindings(&[("sky/lit.frag", text), ("ground/lit.frag", text)], &for_api(Api::Wgpu));
    let named = "the program of `ground/lit.frag` is named `ground_lit`: another is `lit`";
    assert!(found.contains(&named.to_string()), "{found:?}");
    assert!(text.contains("pub mod lit {") && text.contains("pub mod ground_lit {"), "{text}");
}
