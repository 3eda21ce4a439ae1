//! Mutants of this repository's shaders that keep their blocks: other ends of lines, lines joined
//! by a backslash, comments, conditions and macros. What glslang takes is laid out as it says.
//!
//! `LANDFALL_TEXT_MUTANTS=200000` runs it at length.

use super::{leaves, read, theirs};
use crate::support::glslang;
use ::landfall::Target;

/// Mutants of a test run.
const MUTANTS: usize = 150;

const SHADERS: &[&str] = &[
    include_str!("../../../shaders/light_arrays/point_lights_450.frag"),
    "#version 450\nstruct L { vec3 p; float i; };\nlayout(std140, binding = 0) uniform U {\n    \
     L l[4]; // lights\n    mat3 m;\n    float w[3]; /* weights */\n} u;\n\
     layout(std430, binding = 1) buffer B { int n; vec2 t[]; } b;\n\
     layout(location = 0) out vec4 o;\nvoid main() { o = vec4(u.l[1].p, u.w[2]); }\n",
];

/// Places where a character begins.
fn place(text: &str, random: &mut fastrand::Rng) -> usize {
    let mut at = random.usize(0..=text.len());
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

/// Where a line begins that is no directive and follows `#version`.
fn line(text: &str, random: &mut fastrand::Rng) -> usize {
    let ends = text.match_indices(['\n', '\r']).map(|(at, _)| at + 1);
    let starts: Vec<usize> = ends.filter(|&at| !text[at..].starts_with('\n')).collect();
    starts[random.usize(0..starts.len())]
}

fn mutate(text: &mut String, random: &mut fastrand::Rng) {
    match random.u8(0..10) {
        0 => *text = text.replace('\n', "\r\n"),
        1 => *text = text.replace('\n', "\r"),
        2 | 3 => {
            let at = place(text, random);
            text.insert_str(at, ["\\\n", "\\\r\n", "\\\r"][random.usize(0..3)]);
        }
        4 => {
            let at = place(text, random);
            text.insert_str(
                at,
                ["/* x */", "/* { \n } */", "/*\\\n*/", "/**/"][random.usize(0..4)],
            );
        }
        5 => {
            let at = line(text, random);
            text.insert_str(
                at,
                ["// x\n", "// \\\n float y;\n", "// { \r", "//\r\n"][random.usize(0..4)],
            );
        }
        6 => {
            let at = line(text, random);
            text.insert_str(
                at,
                [
                    "#if 0\nfloat gone;\n#endif\n",
                    "#ifdef NO\n}\n#endif\n",
                    "#if 1\n#endif\n",
                    "/* c */ #if 0\n'\n /* c */ #endif\n",
                ][random.usize(0..4)],
            );
        }
        7 => {
            let at = line(text, random);
            text.insert_str(
                at,
                ["#define UNUSED(a, b) a ## b \\\n {\n", "#define W(x) x\n", "#undef W\n"]
                    [random.usize(0..3)],
            );
        }
        8 => {
            // A type through a macro.
            let at = text.find(['\n', '\r']).map_or(0, |at| at + 1);
            *text = text.replacen("vec3", "VECTOR", 1);
            text.insert_str(at, "#define VECTOR ve\\\nc3\n");
        }
        _ => {
            let at = line(text, random);
            text.insert_str(at, ["\u{b}", "\u{c}", "\t", "\n\r", " \n"][random.usize(0..5)]);
        }
    }
}

#[test]
fn mutants_that_glslang_takes_have_its_blocks() {
    let count = std::env::var("LANDFALL_TEXT_MUTANTS").ok().and_then(|n| n.parse().ok());
    let options = glslang::Options { reflect: false, ..glslang::Options::default() };
    let mut taken = 0;
    for seed in 0..count.unwrap_or(MUTANTS) {
        let mut random = fastrand::Rng::with_seed(seed as u64);
        let mut text = SHADERS[random.usize(0..SHADERS.len())].to_string();
        for _ in 0..random.usize(1..5) {
            mutate(&mut text, &mut random);
        }
        let Ok(listed) = glslang::blocks(&text, "frag", &options) else { continue };
        taken += 1;
        // glslang lists a block where it is used first.
        let mut ours = leaves(&read(&text, Some(Target::Vulkan)));
        let mut listed = theirs(&listed);
        ours.sort();
        listed.sort();
        assert_eq!(ours, listed, "seed {seed}\n{text:?}");
    }
    assert!(taken * 2 > count.unwrap_or(MUTANTS), "only {taken} were taken");
}
