//! The layout and what backends run are the same text with the same macros: comments, conditions,
//! macros named like members, and initialisers of global variables.

use crate::support::backends::with_readers;
use landfall_exec::harness::verify::{Outcome, ShaderReport, Subject, VerifyOptions, verify};
use landfall_layout::Source;
use landfall_layout::source::Target;

fn verified(name: &str, text: &str, options: &VerifyOptions) -> ShaderReport {
    let source = Source::new(name, text);
    let subject = Subject::new(&source, options)
        .unwrap_or_else(|(_, found)| panic!("{name}: {found:?}\n{text}"));
    with_readers(|backends| verify(&subject, options, backends))
}

/// Checks that every backend reads every block of a text where it is laid out, but for those named.
fn confirmed(name: &str, text: &str, options: &VerifyOptions, but: &[&str]) {
    let report = verified(name, text, options);
    assert!(!report.blocks.is_empty(), "{text}");
    for block in &report.blocks {
        for backend in &block.backends {
            let expected = match but.contains(&backend.backend.name()) {
                true => Outcome::Skipped,
                false => Outcome::Confirmed,
            };
            let which = (&block.name, backend.backend.name());
            assert_eq!(
                backend.outcome, expected,
                "{which:?}: {:?}\n{}\n{:#?}\n{text}",
                backend.reason, backend.log, backend.reads
            );
        }
    }
}

fn given(defines: &[(&str, &str)], target: Option<Target>) -> VerifyOptions {
    let mut options = VerifyOptions::default();
    for (name, value) in defines {
        options.layout.read.defines.push((name.to_string(), value.to_string()));
    }
    options.layout.read.target = target;
    options
}

#[test]
fn a_macro_named_like_a_member_is_not_expanded_in_the_probe() {
    let texts = [
        "#version 330\nlayout(std140) uniform Fog { vec4 tint; float depth; };\n\
         float thin() { return tint.a > 0.5 ? depth : 0.0; }\n#define depth (2.0 * thin())\n\
         out vec4 c;\nvoid main() { c = tint * depth; }\n",
        "#version 450\nstruct Lamp { vec3 at; float reach; };\n\
         layout(std140, binding = 0) uniform Lamps { Lamp lamps[2]; } room;\n\
         #define Lamp int\n#define lamps room.lamps[0]\n#define reach(x) (x)\n#define uint float\n\
         #define floatBitsToUint(x) 1u\nlayout(location = 0) out vec4 c;\n\
         void main() { c = vec4(lamps.at, 1.0); }\n",
        // The port for OpenGL keeps the block of loose uniforms in front of the macro.
        "#version 330\nuniform float depth;\nuniform vec4 tint;\n\
         float thin = tint.a > 0.5 ? depth : 1.0;\n#define depth thin\n\
         out vec4 c;\nvoid main() { c = tint * depth; }\n",
    ];
    for text in texts {
        confirmed("a.frag", text, &VerifyOptions::default(), &[]);
    }
}

/// Members in the order that Vulkan reads, and in another for OpenGL.
const BRANCHES: &str = "#ifdef VULKAN\nlayout(std140, set = 0, binding = 0) uniform Wash { vec4 tint; \
    float k; };\n#else\nlayout(std140) uniform Wash { float k; vec4 tint; };\n#endif\n\
    OUT vec4 c;\nvoid main() { c = tint * k; }\n";

#[test]
fn every_backend_takes_the_branch_that_is_laid_out() {
    let out = "layout(location = 0) out";
    for target in [None, Some(Target::OpenGl), Some(Target::Vulkan)] {
        for version in ["#version 330\n", "#version 450\n", ""] {
            let text = format!("{version}{}", BRANCHES.replace("OUT", out));
            confirmed("a.frag", &text, &given(&[], target), &[]);
        }
    }
    let loose =
        "#ifndef VULKAN\nuniform vec4 tint;\n#endif\nvoid main() { gl_FragColor = tint; }\n";
    confirmed("a.frag", loose, &VerifyOptions::default(), &[]);
    // What drivers say of themselves, and what only the caller knows.
    for condition in [
        "__VERSION__ < 400",
        "__VERSION__ >= 130",
        "defined(GL_EXT_scalar_block_layout)",
        "defined(GL_NV_made_up)",
    ] {
        for version in ["#version 330\n", "#version 450\n", ""] {
            let text = format!(
                "{version}#if {condition}\nlayout(std140) uniform U {{ float a; vec4 b; }};\n#else\n\
                 layout(std140) uniform U {{ vec4 b; float a; }};\n#endif\n{out} vec4 c;\n\
                 void main() {{ c = b * a; }}\n"
            );
            confirmed("a.frag", &text, &VerifyOptions::default(), &[]);
        }
    }
    let text = "#version 450\n#if SHADOWS > 1\nlayout(std140) uniform U { float a[COUNT]; vec4 b; };\n\
                #else\nlayout(std140) uniform U { vec4 b; };\n#endif\n\
                layout(location = 0) out vec4 c;\nvoid main() { c = b; }\n";
    confirmed("a.frag", text, &given(&[("SHADOWS", "2"), ("COUNT", "3")], None), &[]);
}

#[test]
fn comments_are_no_code() {
    let rows = ["-".repeat(77), "*".repeat(100), "(".repeat(100), "=".repeat(300)];
    for row in rows {
        let wgsl = format!(
            "//{row}\n/*{row}\n {row}*/\nstruct A {{ x: vec4f, y: f32 }}\n\
             @group(0) @binding(0) var<uniform> a: A;\n\
             @fragment fn main() -> @location(0) vec4f {{ return a.x; }}\n"
        );
        confirmed("a.wgsl", &wgsl, &VerifyOptions::default(), &["gl"]);
    }
    let texts = [
        "/*\n#version 300 es\n*/\n#version 450\n// layout(local_size_x = 4) in;\n\
         layout(std430, binding = 0) buffer B { float a; vec4 b; };\nvoid main() { b = vec4(a); }\n",
        "/* one */ #version 450 // #version 330\nlayout(std430, binding = 0) buffer B { vec3 a; };\n\
         /* local_size_x */ void main() { a = vec3(0.0); }\n",
    ];
    for text in texts {
        confirmed("a.comp", text, &VerifyOptions::default(), &[]);
    }
}

#[test]
fn an_initialiser_of_a_global_may_read_textures_and_other_blocks() {
    let text = "#version 130\nuniform sampler2D albedo;\nuniform float gain;\nin vec2 uv;\n\
                vec4 edge = texture2D(albedo, vec2(0.25));\nfloat half_gain = gain * 0.5;\n\
                void main() { gl_FragColor = texture2D(albedo, uv) * gain + edge * half_gain; }\n";
    confirmed("a.frag", text, &VerifyOptions::default(), &[]);
    let text = "#version 450\nlayout(std140, binding = 0) uniform A { float a; vec4 b; };\n\
                layout(std140, binding = 1) uniform B { vec4 d; };\n\
                float first = a + d.y;\nlayout(location = 0) out vec4 c;\n\
                void main() { c = b * first; }\n";
    confirmed("a.frag", text, &VerifyOptions::default(), &[]);
}
