//! What `port` reads as `layout` does: texts without `#version`, includes, and blocks that only name
//! again what is predeclared.

use std::path::Path;

use landfall_layout::{Language, Options, Source, layout};
use landfall_port::{Dialect, PortOptions, port};

use crate::support::glslang;

fn ported(source: &Source, dialect: Dialect) -> Source {
    let mut options = PortOptions::default();
    options.dialect = dialect;
    match port(source, &options) {
        Ok(ported) => ported.source,
        Err(found) => panic!("{}: {found:?}\n{}", source.path, source.text),
    }
}

/// Ports a text to each dialect; checks that its compilers take the result, and that every member is
/// where it was.
fn ports(source: &Source) {
    let offsets = |source: &Source| -> Vec<(String, Option<u64>)> {
        let found = layout(source, &Options::default());
        assert!(!found.has_errors(), "{:?}\n{}", found.diagnostics, source.text);
        // Loose uniforms, which have no offsets, go into a block of the port.
        let blocks = found.blocks.iter().filter(|block| &*block.name != "DefaultBlock");
        let leaves = blocks.flat_map(|block| &block.leaves).filter(|leaf| leaf.offset.is_some());
        leaves.map(|leaf| (leaf.path.clone(), leaf.offset)).collect()
    };
    let before = offsets(source);
    let stage = source.stage.expect("a stage").name();
    for dialect in [Dialect::Vulkan, Dialect::Naga, Dialect::Wgsl] {
        let after = ported(source, dialect);
        let numbers =
            |all: &[(String, Option<u64>)]| all.iter().map(|leaf| leaf.1).collect::<Vec<_>>();
        assert_eq!(numbers(&offsets(&after)), numbers(&before), "{}", after.text);
        match after.language {
            Language::Glsl if dialect == Dialect::Vulkan && source.text.contains("#include") => {}
            Language::Glsl => {
                let options = glslang::Options { auto_map: false, ..Default::default() };
                let found = glslang::blocks(&after.text, short(stage), &options);
                assert!(found.is_ok(), "{found:?}\n{}", after.text);
            }
            Language::SpirV => panic!("a port is a text"),
            Language::Wgsl => {
                assert!(naga::front::wgsl::parse_str(&after.text).is_ok(), "{}", after.text);
            }
        }
    }
}

fn short(stage: &str) -> &'static str {
    match stage {
        "vertex" => "vert",
        "compute" => "comp",
        _ => "frag",
    }
}

#[test]
fn layout_qualifiers_without_a_version_are_kept() {
    for (name, text) in [
        (
            "a.frag",
            "layout(std140) uniform Fog { vec4 tint; float depth; };\nout vec4 c;\nvoid main() { c = tint * depth; }\n",
        ),
        (
            "a.frag",
            "layout(std140, binding = 1) uniform Fog { vec4 tint; };\nuniform float gain;\nlayout(location = 0) out vec4 c;\nvoid main() { c = tint * gain; }\n",
        ),
        (
            "a.comp",
            "layout(binding = 1, std430) buffer Sums { uint total; uint sums[]; };\nlayout(local_size_x = 8) in;\nvoid main() { sums[0] = total; }\n",
        ),
        (
            "a.vert",
            "layout(location = 0) in vec3 at;\nlayout(std140) uniform View { mat4 clip; };\nvoid main() { gl_Position = clip * vec4(at, 1.0); }\n",
        ),
    ] {
        ports(&Source::new(name, text));
    }
    // GLSL 1.10 has no `layout(…)`: there the word is a name like others.
    let old = Source::new(
        "a.frag",
        "uniform float layout;\nvoid main() { gl_FragColor = vec4(layout); }\n",
    );
    ports(&old);
}

#[test]
fn a_block_of_predeclared_outputs_is_dropped_for_naga() {
    for block in [
        "out gl_PerVertex { vec4 gl_Position; };",
        "out gl_PerVertex\n{\n    vec4 gl_Position;\n    float gl_PointSize;\n} ;",
    ] {
        let text = format!(
            "#version 450\nlayout(push_constant) uniform Push {{ mat4 clip; }} pc;\n\
             layout(location = 0) in vec3 at;\nlayout(location = 0) out vec3 shade;\n{block}\n\
             void main() {{ gl_Position = pc.clip * vec4(at, 1.0); shade = at; }}\n"
        );
        let source = Source::new("a.vert", text.as_str());
        ports(&source);
        assert!(!ported(&source, Dialect::Naga).text.contains("gl_PerVertex"));
    }
}

#[test]
fn includes_are_inlined_for_naga() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("port_includes");
    std::fs::create_dir_all(folder.join("parts")).expect("a folder");
    let write = |name: &str, text: &str| {
        std::fs::write(folder.join(name), text).expect("it is written");
        folder.join(name)
    };
    write(
        "parts/half.glsl",
        "#pragma once\n#include \"scale.glsl\"\nfloat half_of(float v) { return v * SCALE; }\n",
    );
    write("parts/scale.glsl", "#define SCALE 0.5\n");
    let path = write(
        "main.frag",
        "#version 450\n#extension GL_GOOGLE_include_directive : require\n#include \"parts/half.glsl\"\n\
         layout(set = 0, binding = 0, std140) uniform A { vec4 x; };\nlayout(location = 0) out vec4 c;\n\
         void main() { c = x * half_of(2.0); }\n",
    );
    ports(&Source::read(&path).expect("it is read"));
    let path = write("lost.frag", "#version 450\n#include \"parts/none.glsl\"\nvoid main() {}\n");
    let mut options = PortOptions::default();
    options.dialect = Dialect::Naga;
    let found =
        port(&Source::read(&path).expect("it is read"), &options).expect_err("no such file");
    assert!(found[0].message.contains("parts/none.glsl"), "{found:?}");
}
