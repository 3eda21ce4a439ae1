//! Mutants of this repository's shaders that keep their blocks: other ends of lines, lines joined
//! by a backslash, comments, conditions and macros. What glslang takes is laid out as it says.
//!
//! Those with versions and extensions of OpenGL are held against Mesa's driver in the same way.
//!
//! At length, over all shaders of the repository with glslang:
//! `cargo test --features full --test layout -- --ignored --nocapture many_mutants`;
//! `LANDFALL_TEXT_MUTANTS` is the number of mutants.

use std::fs;
use std::path::Path;

use super::{codes, compiled, drawn, leaves, open, sorted, theirs};
use crate::support::driver::Driver;
use crate::support::glslang;
use crate::support::leaf::OracleBlock;
use crate::support::sample::sample;
use ::landfall::{Options, Source, Target, layout};

/// Mutants of a test run.
const MUTANTS: u64 = 150;

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
    let kind = random.u8(0..10);
    let inserted: &[&str] = match kind {
        0 => return *text = text.replace('\n', "\r\n"),
        1 => return *text = text.replace('\n', "\r"),
        2 | 3 => &["\\\n", "\\\r\n", "\\\r"],
        4 => &["/* x */", "/* { \n } */", "/*\\\n*/", "/**/"],
        5 => &["// x\n", "// \\\n float y;\n", "// { \r", "//\r\n"],
        6 => &[
            "#if 0\nfloat gone;\n#endif\n",
            "#ifdef NO\n}\n#endif\n",
            "#if 1\n#endif\n",
            "/* c */ #if 0\n'\n /* c */ #endif\n",
        ],
        7 => &["#define UNUSED(a, b) a ## b \\\n {\n", "#define W(x) x\n", "#undef W\n"],
        8 => {
            // A type through a macro.
            let at = text.find(['\n', '\r']).map_or(0, |at| at + 1);
            *text = text.replacen("vec3", "VECTOR", 1);
            return text.insert_str(at, "#define VECTOR ve\\\nc3\n");
        }
        _ => &["\u{b}", "\u{c}", "\t", "\n\r", " \n"],
    };
    let at = match kind {
        2..=4 => place(text, random),
        _ => line(text, random),
    };
    text.insert_str(at, inserted[random.usize(0..inserted.len())]);
}

/// Mutates a text a few times, its declared version and extensions among others.
fn vary(text: &mut String, random: &mut fastrand::Rng) {
    for _ in 0..random.usize(1..5) {
        match random.u8(0..6) {
            0 => declare(text, random),
            _ => mutate(text, random),
        }
    }
}

/// Another version or an extension, which compilers may refuse.
fn declare(text: &mut String, random: &mut fastrand::Rng) {
    const VERSIONS: &[&str] = &[
        "140", "150", "330", "400", "420 core", "430", "450", "460", "300 es", "310 es", "320 es",
    ];
    const EXTENSIONS: &[&str] = &[
        "GL_EXT_scalar_block_layout : enable",
        "GL_ARB_shading_language_420pack : enable",
        "GL_ARB_separate_shader_objects : require",
        "GL_EXT_of_nobody : warn",
        "all : warn",
    ];
    let Some(begin) = text.find("#version") else { return };
    let end = text[begin..].find(['\n', '\r']).map_or(text.len(), |at| begin + at);
    match random.bool() {
        true => {
            let version = VERSIONS[random.usize(0..VERSIONS.len())];
            text.replace_range(begin..end, &format!("#version {version}"));
        }
        false => {
            let extension = EXTENSIONS[random.usize(0..EXTENSIONS.len())];
            text.insert_str(end, &format!("\n#extension {extension}"));
        }
    }
}

/// Compares the blocks of a text that a compiler takes with its list.
fn compare(name: &str, text: &str, target: Target, listed: &[OracleBlock], seed: u64) {
    let mut options = Options::default();
    options.read.target = Some(target);
    let shader = layout(&Source::new(name, text), &options);
    // Before GLSL 4.20 glslang ends a `//` comment at a backslash, Mesa does not: it is reported.
    if codes(&shader).contains(&"line-continuation") {
        return;
    }
    let failed = format!("seed {seed} of {name}\n{text:?}\n{:#?}", shader.diagnostics);
    assert!(!shader.has_errors(), "{failed}");
    // Compilers list blocks in orders of their own.
    assert_eq!(sorted(leaves(&shader)), sorted(theirs(listed)), "{failed}");
}

#[test]
fn mutants_that_glslang_takes_have_its_blocks() {
    let options = glslang::Options::unlisted();
    let mut taken = 0;
    let seeds: Vec<u64> = sample(0..MUTANTS, 4).collect();
    for &seed in &seeds {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut text = SHADERS[random.usize(0..SHADERS.len())].to_string();
        for _ in 0..random.usize(1..5) {
            mutate(&mut text, &mut random);
        }
        let Ok(listed) = glslang::blocks(&text, "frag", &options) else { continue };
        taken += 1;
        compare("a.frag", &text, Target::Vulkan, &listed, seed);
    }
    assert!(taken * 2 > seeds.len(), "only {taken} were taken");
}

/// The repository's shaders that glslang takes for Vulkan and that have a block.
fn corpus() -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders")];
    while let Some(folder) = folders.pop() {
        let entries = fs::read_dir(&folder).expect("a folder of shaders");
        for path in entries.map(|entry| entry.expect("it is listed").path()) {
            let name = path.file_name().unwrap_or_default().to_string_lossy().to_string();
            if path.is_dir() {
                folders.push(path);
            } else if name.ends_with(".vert") || name.ends_with(".frag") || name.ends_with(".comp")
            {
                let text = fs::read_to_string(&path).expect("a shader");
                let blocks =
                    glslang::blocks(&text, &name[name.len() - 4..], &glslang::Options::unlisted());
                if blocks.is_ok_and(|blocks| !blocks.is_empty()) {
                    found.push((name, text));
                }
            }
        }
    }
    found.sort();
    found.extend(SHADERS.iter().map(|text| ("a.frag".to_string(), (*text).to_string())));
    found
}

#[test]
#[ignore = "a campaign at length, with glslang in one process"]
fn many_mutants_that_glslang_takes_have_its_blocks() {
    let count = std::env::var("LANDFALL_TEXT_MUTANTS").ok().and_then(|n| n.parse().ok());
    let count: u64 = count.unwrap_or(200_000);
    let taken: u64 = std::thread::scope(|scope| {
        let run = |first: u64| {
            let corpus = corpus();
            assert!(corpus.len() > 30, "{}", corpus.len());
            let mut taken = 0;
            for seed in (first..count).step_by(2) {
                let mut random = fastrand::Rng::with_seed(seed);
                let (name, text) = &corpus[random.usize(0..corpus.len())];
                let mut text = text.clone();
                vary(&mut text, &mut random);
                let stage = &name[name.len() - 4..];
                let Ok(listed) = glslang::blocks(&text, stage, &glslang::Options::unlisted())
                else {
                    continue;
                };
                taken += 1;
                compare(name, &text, Target::Vulkan, &listed, seed);
            }
            taken
        };
        let halves = [0, 1].map(|first| scope.spawn(move || run(first)));
        halves.into_iter().map(|half| half.join().expect("no difference")).sum()
    });
    println!("{taken} of {count} mutants were taken by glslang, and laid out as it says");
    assert!(taken * 2 > count, "only {taken} were taken");
}

/// Mutants for OpenGL, and of what only OpenGL has.
const OPENGL_SHADERS: &[&str] = &[
    SHADERS[1],
    "#version 330\nstruct L { vec3 p; float i; };\nlayout(std140, row_major) uniform;\n\
     layout(std140) uniform U {\n    L l[3]; // lights\n    mat3x2 m;\n    bool b; float w[2];\n};\n\
     uniform sampler2D s;\nuniform float loose[2];\nout vec4 o;\n\
     void main() { o = vec4(l[1].p, w[1]) + texture(s, vec2(loose[0])); }\n",
    "#version 310 es\nprecision highp float;\nprecision highp int;\n\
     layout(std140, binding = 0) uniform U { vec3 a; mat2 m[2]; float b; } u;\n\
     layout(std430, binding = 1) buffer B { int n; vec3 t[]; } b;\nout vec4 o;\n\
     void main() { o = vec4(u.a, u.b) + vec4(b.t[0], float(b.n)); }\n",
];

/// The blocks of a fragment shader that Mesa's driver takes.
fn of_mesa(driver: &Driver, text: &str) -> Option<Vec<OracleBlock>> {
    let mut blocks = drawn(driver, text).ok()?;
    blocks.retain(|block| !block.leaves.is_empty());
    Some(blocks)
}

/// Whether a skipped group ends with a directive that is not first on its line (GLSL 4.60 §3.3),
/// as Mesa lets it; glslang does not.
fn ends_a_group_late(text: &str) -> bool {
    let mut options = Options::default();
    options.read.target = Some(Target::OpenGl);
    codes(&layout(&Source::new("a.frag", text), &options)).contains(&"unmatched-directive")
}

#[test]
fn mesa_ends_a_skipped_group_at_a_directive_behind_other_tokens() {
    let text = "#version 330\n#if 0\nx #endif\n\
                layout(std140) uniform U { vec4 a; } u;\nout vec4 o;\nvoid main() { o = u.a; }\n";
    assert!(of_mesa(&open(), text).is_some());
    assert!(ends_a_group_late(text));
    compiled(text, glslang::Client::OpenGl).expect_err("no `#endif`");
}

/// Holds mutants against Mesa; returns how many it takes.
fn against_mesa(count: u64) -> u64 {
    let driver = open();
    let mut taken = 0;
    for seed in 0..count {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut text = OPENGL_SHADERS[random.usize(0..OPENGL_SHADERS.len())].to_string();
        vary(&mut text, &mut random);
        let Some(listed) = of_mesa(&driver, &text) else { continue };
        if ends_a_group_late(&text) {
            continue;
        }
        taken += 1;
        compare("a.frag", &text, Target::OpenGl, &listed, seed);
    }
    taken
}

#[test]
fn mutants_that_mesa_takes_have_its_blocks() {
    let taken = against_mesa(400);
    assert!(taken > 200, "only {taken} were taken");
}

#[test]
#[ignore = "a campaign at length, with Mesa's driver"]
fn many_mutants_that_mesa_takes_have_its_blocks() {
    let taken = against_mesa(20_000);
    println!("{taken} of 20,000 mutants were taken by Mesa, and laid out as it says");
    assert!(taken > 10_000, "only {taken} were taken");
}
