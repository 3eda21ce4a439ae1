//! The sizes that mirrors and headers give to buffers with a runtime-sized tail: the drivers count
//! as many elements in them as were asked for.
//!
//! Needs drivers, a C compiler and rustc; a missing one fails.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use landfall_codegen::c::{COptions, c};
use landfall_codegen::rust::{RustOptions, rust};
use landfall_exec::backend::gl::Gl;
use landfall_exec::backend::wgpu::{AdapterChoice, Gpu};
use landfall_exec::backend::{Backend, Grid, StageCode};
use landfall_ir::Module;
use landfall_layout::{Options, Source, Stage, layout};

use crate::support::jobs::{glsl, job, module, output, storage, words};
use crate::support::rustc::{Math, crates, run, scratch};

/// The greatest number of elements that is tried.
const LIMIT: usize = 9;

/// What `size_for` and `SIZE_FOR` give for 0 to [`LIMIT`] elements, from the compiled code.
fn sizes(file: &str, text: &str) -> Vec<usize> {
    let shader = layout(&Source::new(file, text), &Options::default());
    assert!(!shader.has_errors(), "{:?}", shader.diagnostics);
    let directory = scratch(&format!("tail-{}", file.replace('.', "-")));
    let mirrors = rust(&[&shader], &RustOptions::default()).text;
    fs::write(directory.join("mirrors.rs"), mirrors).expect("scratch can be written to");
    let main = directory.join("main.rs");
    let program = format!(
        "mod mirrors {{ include!(\"mirrors.rs\"); }}
use std::io::Write;
fn main() {{
    for n in 0..={LIMIT} {{
        let size = mirrors::PHeader::size_for(n) as u64;
        let head: mirrors::PHeader = bytemuck::Zeroable::zeroed();
        let all: Vec<mirrors::PElement> = vec![bytemuck::Zeroable::zeroed(); n];
        let mut bytes = vec![255; 3];
        head.write_into(&all, &mut bytes);
        assert_eq!((bytes.len() as u64, head.to_bytes(&all)), (size, bytes));
        std::io::stdout().write_all(&size.to_le_bytes()).unwrap();
    }}
}}
"
    );
    fs::write(&main, program).expect("scratch can be written to");
    let of_rust = run(crates(Math::Simd), &main, "2021");
    let of_rust: Vec<usize> = of_rust
        .chunks_exact(8)
        .map(|bytes| u64::from_le_bytes(bytes.try_into().expect("eight bytes")) as usize)
        .collect();

    let header = c(&[&shader], &COptions::default()).text;
    fs::write(directory.join("p.h"), header).expect("scratch can be written to");
    let program = format!(
        "#include \"p.h\"\n#include <stdio.h>\nint main(void) {{\n    \
         for (unsigned n = 0; n <= {LIMIT}; n++) printf(\"%zu\\n\", P_SIZE_FOR(n));\n    return 0;\n}}\n"
    );
    fs::write(directory.join("main.c"), program).expect("scratch can be written to");
    let in_directory = |program: &Path| {
        let mut command = Command::new(program);
        command.current_dir(&directory);
        command
    };
    let built = in_directory(Path::new("gcc"))
        .args(["-std=c11", "-Wall", "-Wextra", "-Werror", "main.c", "-o", "main"])
        .output()
        .expect("gcc is installed");
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    let out = in_directory(&directory.join("main")).output().expect("it was built");
    let text = String::from_utf8(out.stdout).expect("digits");
    let of_c: Vec<usize> = text.lines().map(|line| line.parse().expect("a size")).collect();
    assert_eq!(of_rust, of_c, "{file}");
    of_rust
}

/// How many elements a shader counts in a buffer of so many bytes.
fn counted(backend: &mut dyn Backend, stage: &StageCode, bytes: usize) -> u32 {
    assert!(bytes.is_multiple_of(4), "{bytes} bytes");
    let resources = vec![storage("P", 0, &vec![0; bytes / 4]), output("Output", 1, 1)];
    let job = job(vec![stage.clone()], resources, Grid::Groups([1, 1, 1]));
    let answer = backend.run(&job).unwrap_or_else(|failure| panic!("{failure}"));
    words(answer.buffers[1].as_ref().expect("it comes back"))[0]
}

#[test]
fn opengl_counts_the_elements_that_a_glsl_buffer_is_made_for() {
    let mut gl = Gl::open().unwrap_or_else(|failure| panic!("{failure}"));
    for (name, members) in [
        ("float.comp", "vec4 head; float data[];"),
        ("vec3.comp", "uint head; vec3 data[];"),
        ("vec2.comp", "float head; vec2 data[];"),
    ] {
        let text = format!(
            "#version 430\nlayout(local_size_x = 1) in;\n\
             layout(std430, binding = 0) readonly buffer P {{ {members} }} p;\n\
             layout(std430, binding = 1) buffer Output {{ uint count; }} o;\n\
             void main() {{ o.count = uint(p.data.length()); }}\n"
        );
        let stage = glsl(Stage::Compute, &text);
        for (n, bytes) in sizes(name, &text).into_iter().enumerate().skip(1) {
            assert_eq!(counted(&mut gl, &stage, bytes), n as u32, "{name}: {bytes} bytes");
        }
    }
}

#[test]
fn vulkan_counts_the_elements_that_a_wgsl_buffer_is_made_for() {
    let mut gpu =
        Gpu::open(&AdapterChoice::default()).unwrap_or_else(|failure| panic!("{failure}"));
    // The second number: how many elements fit into the least size, the structure's with one
    // element, rounded up to its alignment.
    for (name, members, least) in [
        ("scalars.wgsl", "head: vec4f, data: array<f32>", 4),
        ("vectors.wgsl", "head: u32, data: array<vec3f>", 1),
        ("pairs.wgsl", "head: f32, data: array<vec2f>", 1),
    ] {
        let text = format!(
            "struct P {{ {members} }}\n\
             @group(0) @binding(0) var<storage, read_write> p: P;\n\
             @group(0) @binding(1) var<storage, read_write> count: u32;\n\
             @compute @workgroup_size(1) fn main() {{ count = arrayLength(&p.data); }}\n"
        );
        let found = Module::by_naga(&Source::new(name, text.as_str()), &Options::default());
        let found = Arc::new(found.unwrap_or_else(|found| panic!("{found:?}")));
        let stage = module(Stage::Compute, "main", &found);
        for (n, bytes) in sizes(name, &text).into_iter().enumerate() {
            let expected = n.max(least) as u32;
            assert_eq!(counted(&mut gpu, &stage, bytes), expected, "{name}: {bytes} bytes");
        }
    }
}
