//! Texts are read as compilers read them: which API they are for, where lines end, what bytes
//! comments may hold. The oracles are glslangValidator and the OpenGL driver.

mod bounds;
mod by_use;
mod campaign;
mod conditions;
mod illegal;
mod illegal_names;
mod lines;
mod refused;
mod specialised;
mod target;
mod wgsl;

use ::landfall::{Options, ShaderLayout, Source, Target, layout};
use landfall_layout::Severity;

use crate::support::driver::{Api, Driver, Stage};
use crate::support::glslang::{self, Client};
use crate::support::leaf::OracleBlock;

/// A fragment shader laid out for an API, or as its text says.
fn read(text: &str, target: Option<Target>) -> ShaderLayout {
    let mut options = Options::default();
    options.read.target = target;
    layout(&Source::new("a.frag", text), &options)
}

/// `U.a 16`: every leaf with its offset.
fn leaves(shader: &ShaderLayout) -> Vec<String> {
    assert!(!shader.has_errors(), "{:#?}", shader.diagnostics);
    let blocks = shader.blocks.iter().filter(|block| block.size.is_some());
    let all = blocks.flat_map(|block| {
        block
            .leaves
            .iter()
            .filter_map(move |leaf| Some(format!("{}.{} {}", block.name, leaf.path, leaf.offset?)))
    });
    all.collect()
}

/// The same of an oracle.
fn theirs(blocks: &[OracleBlock]) -> Vec<String> {
    let all = blocks.iter().flat_map(|block| {
        block.leaves.iter().map(move |leaf| format!("{}.{} {}", block.name, leaf.path, leaf.offset))
    });
    all.collect()
}

/// The blocks of a fragment shader by a driver, with a vertex shader of its version of ES.
fn drawn(driver: &Driver, text: &str) -> Result<Vec<OracleBlock>, String> {
    let version = ["300 es", "310 es", "320 es"].into_iter().find(|es| text.contains(es));
    let version = version.unwrap_or("330");
    let vertex = format!("#version {version}\nvoid main() {{ gl_Position = vec4(0.0); }}\n");
    driver.blocks(&[(Stage::Vertex, &vertex), (Stage::Fragment, text)])
}

fn of_driver(driver: &Driver, text: &str) -> Vec<String> {
    theirs(&drawn(driver, text).unwrap_or_else(|log| panic!("{log}\n{text}")))
}

/// The blocks of a fragment shader by glslang.
fn compiled(text: &str, client: Client) -> Result<Vec<OracleBlock>, String> {
    let options = glslang::Options { client, ..glslang::Options::unlisted() };
    glslang::blocks(text, "frag", &options)
}

fn of_glslang(text: &str, client: Client) -> Vec<String> {
    theirs(&compiled(text, client).unwrap_or_else(|log| panic!("{log}\n{text}")))
}

/// Leaves in the order of their names: compilers list them in orders of their own.
fn sorted(mut leaves: Vec<String>) -> Vec<String> {
    leaves.sort();
    leaves
}

fn open() -> Driver {
    Driver::open(Api::Gl)
}

/// The codes of warnings and errors, in order.
fn codes(shader: &ShaderLayout) -> Vec<&'static str> {
    shader.diagnostics.iter().map(|found| found.code.name()).collect()
}

/// The severities of what is found with a code.
fn severities(text: &str, code: &str) -> Vec<Severity> {
    let shader = read(text, None);
    shader.diagnostics.iter().filter(|found| found.code == code).map(|d| d.severity).collect()
}

#[test]
fn bytes_of_latin_1_in_comments_leave_places_right() {
    let text = "#version 450\n// gr\u{f6}\u{df}e\nlayout(std140, binding = 0) uniform U { // \u{e9}\n\
                    float a; /* \u{fc} */ vec3 b;\n};\nlayout(location = 0) out vec4 o;\n\
                    void main() { o = vec4(b, a); }\n";
    let latin: Vec<u8> = text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("latin.frag");
    std::fs::write(&path, &latin).unwrap();
    let glslang = std::process::Command::new("glslangValidator").arg(&path).output().unwrap();
    assert!(glslang.status.success(), "glslang takes it: {glslang:?}");

    let source = Source::read(&path).unwrap();
    let shader = layout(&source, &Options::default());
    assert_eq!(leaves(&shader), of_glslang(text, Client::Vulkan));
    assert_eq!(codes(&shader), ["not-utf8"], "once");
    let places: Vec<_> =
        shader.blocks[0].members.iter().map(|m| shader.files.locate(m.span)).collect();
    assert_eq!((places[0].line, places[0].column), (4, 7));
    assert_eq!((places[1].line, places[1].column), (4, 23));

    // Outside comments such a byte is no GLSL, and a WGSL text of them is none at all.
    let outside: Vec<u8> = latin.iter().map(|b| if *b == b'a' { 0xe9 } else { *b }).collect();
    let shader = layout(&Source::from_bytes("a.frag", outside).unwrap(), &Options::default());
    assert!(shader.has_errors());
    let wgsl = Source::from_bytes("a.wgsl", b"// \xe9\nvar<private> a: f32;".to_vec()).unwrap();
    assert!(layout(&wgsl, &Options::default()).has_errors());
    assert!(Source::from_bytes("a.frag", b"a\0\xe9".to_vec()).is_err());
    assert!(Source::from_bytes("a.frag", b"\xff\xfea\0".to_vec()).is_err());
}

#[test]
fn an_include_in_latin_1_is_read_and_noted_at_its_own_place() {
    let dir = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("latin_include");
    std::fs::create_dir_all(&dir).unwrap();
    std::fs::write(dir.join("b.glsl"), b"// \xfc\rlayout(std140) uniform U { vec4 a; };\n")
        .unwrap();
    std::fs::write(dir.join("a.frag"), "#version 450\n#include \"b.glsl\"\n").unwrap();
    let shader = layout(&Source::read(dir.join("a.frag")).unwrap(), &Options::default());
    assert_eq!(leaves(&shader), ["U.a 0"]);
    let note = shader.diagnostics.iter().find(|found| found.code == "not-utf8").unwrap();
    assert_eq!(note.severity, Severity::Warning);
    let place = shader.files.locate(note.labels[0].at);
    assert!(place.path.ends_with("b.glsl") && (place.line, place.column) == (1, 4), "{place:?}");
    assert_eq!(shader.files.locate(shader.blocks[0].span).line, 2);
}

/// GLSL_EXT_shader_explicit_arithmetic_types, whose integers wrap as those of C do.
#[test]
fn integer_constants_of_8_and_16_bits_wrap() {
    let text = "#version 450
#extension GL_EXT_shader_explicit_arithmetic_types : require
const int8_t n = int8_t(300);
const uint16_t m = uint16_t(65537);
const int16_t k = int16_t(-3);
layout(std140, binding = 0) uniform U {
    float a[int(n)]; float b[int(m)]; float c[-int(k)]; float d[int(uint8_t(257))]; vec4 h;
} u;
layout(location = 0) out vec4 o;
void main() { o = u.h + u.a[0] + u.b[0] + u.c[0] + u.d[0]; }
";
    let theirs = of_glslang(text, Client::Vulkan);
    assert!(theirs.iter().any(|leaf| leaf.ends_with("h 784")), "{theirs:?}");
    let shader = read(text, None);
    assert!(leaves(&shader).iter().any(|leaf| leaf.ends_with("h 784")), "{:?}", leaves(&shader));
}
