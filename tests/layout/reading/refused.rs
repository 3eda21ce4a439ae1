//! What compilers refuse or warn of, said with the rule.

use super::{Client, Severity, compiled, read, severities};

/// Whether glslang takes a fragment shader.
fn is_taken(text: &str, client: Client) -> bool {
    compiled(text, client).is_ok()
}

#[test]
fn a_misspelt_layout_qualifier_is_an_error() {
    let of = |id: &str| {
        format!(
            "#version 450\nlayout({id}, binding = 0) uniform U {{ vec4 a; }};\nvoid main() {{}}\n"
        )
    };
    for (wrong, meant) in [
        ("sdt140", "std140"),
        ("std431", "std430"),
        ("row_mayor", "row_major"),
        ("pakced", "packed"),
    ] {
        let text = of(wrong);
        assert!(!is_taken(&text, Client::OpenGl), "{wrong}");
        let shader = read(&text, None);
        let found = &shader.diagnostics[0];
        assert_eq!(
            (found.code.name(), found.severity),
            ("layout-qualifier", Severity::Error),
            "{wrong}"
        );
        assert_eq!(found.help, Some(format!("did you mean `{meant}`?")));
    }
    // An extension's that is not known here.
    assert_eq!(severities(&of("holographic_fringes"), "layout-qualifier"), [Severity::Warning]);
    // glslang makes SPIR-V, which has no `shared`.
    assert_eq!(severities(&of("shared"), "layout-qualifier"), []);
    for right in ["std140", "STD140", "row_major", "std140, column_major"] {
        assert!(is_taken(&of(right), Client::OpenGl), "{right}");
        assert_eq!(severities(&of(right), "layout-qualifier"), [], "{right}");
    }
}

/// GLSL ES 3.20 §3.4; on desktops the name is 0.
#[test]
fn a_name_that_is_no_macro_is_an_error_in_a_condition_of_es_alone() {
    let of = |version: &str, condition: &str| {
        let out = if version.ends_with("es") { "precision mediump float;\n" } else { "" };
        format!("#version {version}\n#if {condition}\n#endif\n{out}void main() {{}}\n")
    };
    for (condition, undefined) in [
        ("LIGHTS", true),
        ("LIGHTS > 3", true),
        ("1 && LIGHTS", true),
        ("0 || LIGHTS", true),
        ("(0 && LIGHTS) || OTHER", true),
        ("defined(LIGHTS)", false),
        ("defined(LIGHTS) && LIGHTS > 3", false),
        ("!defined LIGHTS || LIGHTS > 3", false),
        ("0 && LIGHTS", false),
        ("__VERSION__ > 100", false),
    ] {
        let es = of("310 es", condition);
        assert_eq!(is_taken(&es, Client::OpenGl), !undefined, "{condition}");
        let error = if undefined { vec![Severity::Error] } else { vec![] };
        assert_eq!(severities(&es, "undefined-macro"), error, "{condition}");
        let desktop = of("450", condition);
        assert!(is_taken(&desktop, Client::OpenGl), "{condition}");
        let warning = if undefined { vec![Severity::Warning] } else { vec![] };
        assert_eq!(severities(&desktop, "undefined-macro"), warning, "{condition}");
    }
}

#[test]
fn texts_of_other_languages_are_named_and_refused() {
    for (language, text) in [
        (
            "HLSL",
            "cbuffer U : register(b0) { float4 a; };\nfloat4 main() : SV_Target { return a; }",
        ),
        ("HLSL", "ConstantBuffer<Light> light : register(b0);"),
        ("HLSL", "float4x4 world;"),
        ("HLSL", "// a picture\nTexture2D picture;\nSamplerState s;"),
        ("Slang", "import lighting;\nstruct A { float a; };"),
        ("Metal", "#include <metal_stdlib>\nusing namespace metal;\nstruct A { float a; };"),
        ("Metal", "#include <metal_stdlib>\nstruct A { float a; };"),
        ("HLSL", "struct Vertex { float3 at : POSITION; };\n"),
        ("WGSL", "struct A { a: f32 }\n"),
        ("WGSL", "struct Vertex {\n    @location(0) at: vec3f,\n}\n"),
        ("WGSL", "const N: u32 = 4;\n"),
        ("WGSL", "alias Vector = vec3<f32>;\n"),
        ("WGSL", "diagnostic(off, derivative_uniformity);\n"),
        ("WGSL", "@group(0) @binding(0) var<uniform> a: vec4f;"),
        ("ShaderLab", "Shader \"x\" { }"),
    ] {
        let shader = read(text, None);
        let named = shader
            .diagnostics
            .iter()
            .any(|found| found.code.name() == "other-language" && found.message.contains(language));
        assert!(shader.has_errors() && named, "{text}: {shader:?}");
        assert!(shader.blocks.is_empty());
    }
    // GLSL in which those words are names, types of its own, or macros.
    for text in [
        "#define float4 vec4\nuniform float4 a;\nfloat4 f() { return a; }",
        "struct float4 { float x; };\nfloat4 f() { return float4(1.0); }",
        "vec4 import = vec4(1.0);\nfloat kernel[9];\nfloat vertex(float x) { return x; }",
        "layout(std140) uniform cbuffer { vec4 a; };",
        "struct alias { float x; };\nalias a;\nconst float b = true ? 1.0 : 2.0;",
        "#ifdef HLSL\ncbuffer U { float4 a; };\n#endif\n// cbuffer B\nuniform vec4 a;",
    ] {
        assert!(!read(text, None).has_errors(), "{text}: {:?}", read(text, None).diagnostics);
    }
}

#[test]
fn texts_of_other_languages_are_named_in_wgsl_files_too() {
    let read = |text: &str| {
        ::landfall::layout(&::landfall::Source::new("a.wgsl", text), &Default::default())
    };
    for (language, text) in [
        ("HLSL", "cbuffer U : register(b0) { float4 a; };"),
        ("HLSL", "Texture2D<float4> picture : register(t0);"),
        ("Slang", "ParameterBlock<Scene> scene;"),
        ("Metal", "using namespace metal;\nstruct A { float a; };"),
        ("GLSL", "#version 450\nlayout(std140) uniform U { vec4 a; };"),
        ("GLSL", "layout(std140) uniform U { vec4 a; };"),
        ("GLSL", "uniform vec4 a;"),
    ] {
        let shader = read(text);
        let named = |found: &&::landfall::Diagnostic| {
            found.code.name() == "other-language" && found.message.contains(language)
        };
        assert!(shader.diagnostics.iter().any(|found| named(&found)), "{text}: {shader:?}");
        assert!(shader.has_errors() && shader.blocks.is_empty());
    }
    // WGSL in which those words are names.
    let text = "struct vertex { kernel: vec4f }\nfn uniform(constant: f32) -> f32 { return constant; }\n\
                var<private> fragment: vertex;";
    assert!(!read(text).has_errors(), "{:?}", read(text).diagnostics);
}

/// Neither GLSL nor WGSL has that character; glslang refuses it.
#[test]
fn a_byte_order_mark_is_a_warning() {
    let plain =
        "#version 450\nlayout(std140, binding = 0) uniform U { vec4 a; };\nvoid main() {}\n";
    let marked = format!("\u{feff}{plain}");
    for (text, taken) in [(plain, true), (&*marked, false)] {
        assert_eq!(is_taken(text, Client::OpenGl), taken);
        let warnings = if taken { vec![] } else { vec![Severity::Warning] };
        assert_eq!(severities(text, "byte-order-mark"), warnings);
        assert!(!read(text, None).has_errors());
    }
    let wgsl = "\u{feff}@group(0) @binding(0) var<storage> g: vec4f;";
    let shader = ::landfall::layout(&::landfall::Source::new("a.wgsl", wgsl), &Default::default());
    assert_eq!(super::codes(&shader), ["byte-order-mark"]);
}

/// One error for one mistake, and the blocks after it.
#[test]
fn a_mistake_in_a_list_of_members_leaves_the_rest_of_the_text() {
    let later = "layout(std140) uniform C { vec4 c; };\nvoid main() {}\n";
    for (members, found) in [
        ("vec4 a; float b", "expected `;`, found `}`"),
        ("vec4 a, ;", "unexpected `;` in a declaration"),
        ("vec4 a; float 3b;", "unexpected `3b` in a declaration"),
    ] {
        for text in [
            format!("#version 450\nlayout(std140) uniform B {{ {members} }};\n{later}"),
            format!("#version 450\nstruct S {{ {members} }};\n{later}"),
        ] {
            assert!(!is_taken(&text, Client::OpenGl), "{text}");
            let shader = read(&text, None);
            let said: Vec<&str> = shader.diagnostics.iter().map(|d| &*d.message).collect();
            assert_eq!(said, [found], "{text}");
            assert!(shader.blocks.iter().any(|block| &*block.name == "C"), "{text}");
        }
    }
}

#[test]
fn directives_that_compilers_refuse_are_errors() {
    for (text, code) in [
        ("#version 450\n#if 1\n#else\n#else\n#endif\nvoid main() {}\n", "unmatched-directive"),
        ("#version 450\n#if 0\n#else\n#else\n#endif\nvoid main() {}\n", "unmatched-directive"),
        ("#version 450\n#if 1\n#else\n#elif 1\n#endif\nvoid main() {}\n", "unmatched-directive"),
        ("#version 450\n#version 330\nvoid main() {}\n", "version"),
        ("#version 450\n#define defined 1\nvoid main() {}\n", "macro-call"),
        ("#version 450\n#define F(a, a) a\nvoid main() {}\n", "macro-call"),
        ("#version 450\n#define F(\nvoid main() {}\n", "macro-call"),
        ("#version 450\n#define F(a, b\nvoid main() {}\n", "macro-call"),
        ("#version 450\n#if 1.5 > 1\n#endif\nvoid main() {}\n", "condition"),
    ] {
        assert!(!is_taken(text, Client::OpenGl), "{text}");
        assert_eq!(severities(text, code), [Severity::Error], "{text}");
    }
}
