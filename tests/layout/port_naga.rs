//! Old GLSL ported on to naga's GLSL and to WGSL: naga takes it, glslang takes
//! what is still GLSL, every member stays where it was, and what cannot be had
//! is refused with a member's name.

use std::path::{Path, PathBuf};

use landfall_layout::{BlockLayout, Language, Options, Source, layout};
use landfall_port::{Dialect, PortOptions, port};

fn shaders(folders: &[&str]) -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let entries = folders.iter().flat_map(|folder| {
        std::fs::read_dir(root.join(folder))
            .expect("a folder of shaders")
            .map(|e| e.expect("an entry"))
    });
    let old = |path: &PathBuf| {
        let name = path.display().to_string();
        name.contains("_330.") || name.contains("es.") || name.ends_with("mobile.frag")
    };
    let mut all: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(old).collect();
    all.sort();
    all
}

fn ported(source: &Source, dialect: Dialect) -> Result<Source, String> {
    let mut options = PortOptions::default();
    options.dialect = dialect;
    port(source, &options).map(|p| p.source).map_err(|mut e| e.swap_remove(0).message)
}

fn from(text: &str, dialect: Dialect) -> Result<Source, String> {
    ported(&Source::new("test.frag", text), dialect)
}

/// A row a block: its binding, and where each leaf is.
fn places(blocks: &[BlockLayout]) -> Vec<String> {
    let block = |b: &BlockLayout| {
        let leaves: Vec<_> = b.leaves.iter().map(|l| (l.offset, &l.strides)).collect();
        format!("{:?} {leaves:?}", b.binding)
    };
    let mut all: Vec<String> = blocks.iter().map(block).collect();
    all.sort();
    all
}

#[test]
fn what_naga_takes_has_every_member_where_it_was() {
    let mut taken = 0;
    for path in shaders(&[
        "shaders/six_lights",
        "shaders/casters",
        "shaders/view_space",
        "shaders/light_arrays",
        "tests/port",
    ]) {
        let source = Source::read(&path).expect("a shader");
        let Ok(glsl) = ported(&source, Dialect::Naga) else { continue };
        let wgsl =
            ported(&source, Dialect::Wgsl).unwrap_or_else(|e| panic!("{}: {e}", source.path));
        assert_eq!(wgsl.language, Language::Wgsl);
        assert!(naga::front::wgsl::parse_str(&wgsl.text).is_ok(), "{}", wgsl.text);
        let plain = ported(&source, Dialect::Vulkan).expect("naga's is made of it");
        let read = |source: &Source| places(&layout(source, &Options::default()).blocks);
        assert_eq!(read(&glsl), read(&plain), "{}", source.path);
        assert_eq!(read(&wgsl), read(&plain), "{}", source.path);
        taken += 1;
    }
    assert!(taken >= 15, "{taken}");
}

#[test]
fn textures_and_samplers_are_taken_apart() {
    let text = "#version 330\nuniform sampler2D a;\nuniform samplerCube sky;\nuniform bool on;\n\
                in vec2 uv;\nout vec4 color;\nvec4 read(sampler2D t, vec2 at) { return texture(t, at); }\n\
                void main() {\n    color = read(a, uv) + texture(sky, vec3(uv, 1.0));\n    \
                if (on) color += textureLod(a, uv, 0.0);\n}\n";
    let glsl = from(text, Dialect::Naga).expect("naga takes it");
    for line in [
        "layout(set = 0, binding = 1) uniform texture2D a; layout(set = 0, binding = 3) uniform sampler a_sampler;",
        "    uint on;",
        "vec4 read(texture2D t, sampler t_sampler, vec2 at) { return texture(sampler2D(t, t_sampler), at); }",
        "    color = read(a, a_sampler, uv) + texture(samplerCube(sky, sky_sampler), vec3(uv, 1.0));",
        "    if ((on != 0u)) color += textureLod(sampler2D(a, a_sampler), uv, 0.0);",
    ] {
        assert!(glsl.text.lines().any(|new| new == line), "{line}\nis not in\n{}", glsl.text);
    }
}

#[test]
fn what_would_move_is_refused_by_name() {
    let refused = |text: &str, dialect| from(text, dialect).expect_err("refused");
    let small = "#version 330\nstruct M { float shine; };\nuniform vec3 eye;\nuniform M m;\n\
                 out vec4 color;\nvoid main() { color = vec4(eye, m.shine); }";
    assert_eq!(refused(small, Dialect::Naga), "`m.shine` is at offset 16, but naga reads it at 12");
    let array = "#version 330\nuniform float w[4];\nout vec4 color;\n\
                 void main() { color = vec4(w[1]); }";
    assert!(from(array, Dialect::Naga).is_ok());
    assert_eq!(
        refused(array, Dialect::Wgsl),
        "the array stride of `w[]` is 16 bytes, but 4 in WGSL"
    );
    let swapped = "#version 430\nuniform vec4 w[4][2];\nlayout(location = 0) out vec4 color;\n\
                   void main() { color = w[1][0]; }";
    assert_eq!(refused(swapped, Dialect::Naga), "naga swaps the dimensions of `w`");
    let before = "#version 330\nfloat f();\nfloat g();\nout vec4 color;\n\
                  void main() { color = vec4(f()); }\nfloat f() { return g(); }\n\
                  float g() { return 1.0; }";
    assert_eq!(
        refused(before, Dialect::Naga),
        "naga rejects the ported shader: a function is called before its body; \
         move it above its callers"
    );
}
