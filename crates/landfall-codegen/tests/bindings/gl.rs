//! Bindings for OpenGL: `check` is compiled, and held to what the driver reports of programs that are
//! as the constants say, and of others that drifted from them.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use landfall_codegen::rust::Api;
use landfall_layout::shape::AddressSpace;
use landfall_layout::{Options, Source, layout};

use crate::{TESTS, assert_formatted, generated, scratch};

/// Blocks of each form; every member of `Loose` but the first may be left out by the driver.
const BLOCKS: &str = "#version 450
struct Light { vec3 color; float intensity; mat3 basis; float weights[3]; };
layout(std140, binding = 0) uniform Lights {
    vec4 ambient; Light lights[4]; mat2x3 turn; int count; bool on;
} lights;
layout(std430, binding = 1) buffer Grid { uvec4 cells; float bins[2][3]; Light all[]; };
layout(std140, binding = 2) uniform Slot { mat4 view; vec2 size; vec2 tail[2]; } slots[2];
layout(packed) uniform Loose { vec4 used; float unused; };
layout(location = 0) out vec4 color;
void main() {
    Light light = lights.lights[lights.count];
    color = lights.ambient + used.x + vec4(light.basis * light.color.xyz, light.weights[1]);
    color += slots[0].view * vec4(slots[1].size, slots[1].tail[1]);
    color.xyz += lights.turn * vec2(lights.on ? 1.0 : 2.0);
    bins[1][cells.x] = all[cells.y].intensity;
}
";

/// What is another in the program, and lines that must be among those of the error. The bytes are those
/// of the rules of OpenGL 4.6, section 7.6.2.2.
const DRIFTS: &[(&str, &str, &[&str])] = &[
    (
        "vec3 color; float",
        "vec4 color; float",
        &[
            "Lights.lights[0].color: a vec3 at byte 16 in the constants, a type 0x8b52 in the program",
            "Lights.lights[0].intensity: byte 28 in the constants, 32 in the program",
            "Lights.count: byte 496 in the constants, 560 in the program",
            "Grid.all[0].basis: byte 64 in the constants, 80 in the program",
            "Lights: 512 bytes in the constants, 576 in the program",
        ],
    ),
    (
        "float intensity;",
        "int intensity;",
        &[
            "Lights.lights[0].intensity: a float at byte 28 in the constants, a type 0x1404 in the program",
        ],
    ),
    (
        "Light lights[4]",
        "Light lights[5]",
        &[
            "Lights.lights[].color: 4 elements in the constants, 5 in the program",
            "Lights.turn: byte 464 in the constants, 576 in the program",
        ],
    ),
    (
        "mat2x3 turn",
        "layout(row_major) mat2x3 turn",
        &[
            "Lights.turn: column-major, 16 bytes apart in the constants, row-major, 16 in the program",
        ],
    ),
    (
        "weights[3]",
        "weights[2]",
        &[
            "Lights.lights[].weights[]: 3 elements in the constants, 2 in the program",
            "Lights.lights[1].color: byte 128 in the constants, 112 in the program",
        ],
    ),
    (
        "bins[2][3]",
        "bins[3][3]",
        &[
            "Grid.bins[][]: 2 elements in the constants, 3 in the program",
            "Grid.all[0].color: byte 48 in the constants, 64 in the program",
        ],
    ),
    (
        "std430",
        "std140",
        &[
            "Grid.bins[][]: elements 12 bytes apart in the constants, 48 in the program",
            "Grid.all[].weights[]: elements 80 bytes apart in the constants, 112 in the program",
        ],
    ),
    (
        "mat4 view; vec2 size;",
        "layout(offset = 16) vec2 size; mat4 view;",
        &[
            "Slot.view: byte 0 in the constants, 32 in the program",
            "Slot.size: byte 64 in the constants, 16 in the program",
        ],
    ),
    (
        "count",
        "number",
        &[
            "Lights.number: byte 496 in the program, not in the constants",
            "Lights.count: byte 496 in the constants, not in the program",
        ],
    ),
    (
        "bool on;",
        "bool on; float more;",
        &["Lights.more: byte 504 in the program, not in the constants"],
    ),
    ("uniform Slot", "uniform Slots", &["Slot: the program has no such block"]),
    (
        "vec2 tail[2]",
        "vec2 tail[3]",
        &[
            "Slot.tail[]: 2 elements in the constants, 3 in the program",
            "Slot: 112 bytes in the constants, 128 in the program",
        ],
    ),
    (
        "{ vec4 used;",
        "{ vec3 used;",
        &["Loose.used: a vec4 at byte 0 in the constants, a type 0x8b51 in the program"],
    ),
];

/// The rows of the list that the compiled program walks, and the texts of the bindings.
#[derive(Default)]
struct Programs {
    text: String,
    rows: String,
    files: Vec<PathBuf>,
    /// Whether the last bindings are of a program with blocks.
    has_check: bool,
}

impl Programs {
    /// Adds the bindings of a shader; their module.
    fn bindings(&mut self, name: &str, extension: &str, shader: &str) -> String {
        let folder = scratch("gl");
        let path = folder.join(format!("{name}.{extension}"));
        fs::write(&path, shader).expect("scratch can be written to");
        let bindings = generated(&[path.display().to_string()], Api::OpenGl);
        self.has_check = bindings.contains("unsafe fn check(");
        let alone = folder.join(format!("{name}.rs"));
        fs::write(&alone, &bindings).expect("scratch can be written to");
        self.files.push(alone);
        let _ = write!(self.text, "pub mod {name} {{\n{bindings}}}\n\n");
        format!("{name}::gl_bindings::{name}")
    }

    /// Adds a program of one stage that is held to bindings.
    fn program(&mut self, name: &str, extension: &str, shader: &str, bindings: &str) {
        let stage = match extension {
            "vert" => "glow::VERTEX_SHADER",
            "comp" => "glow::COMPUTE_SHADER",
            _ => "glow::FRAGMENT_SHADER",
        };
        let _ = writeln!(
            self.rows,
            "        Program {{ name: {name:?}, stages: vec![({stage}, {shader:?})], check: |program, \
             load| unsafe {{ {bindings}::check(program, load) }} }},"
        );
    }
}

/// The GLSL shaders of the repository with a block that is used, each with its text and stage.
fn with_blocks() -> Vec<(String, String, String)> {
    let mut all = Vec::new();
    let root = Path::new(TESTS).join("../../shaders");
    for folder in fs::read_dir(root).expect("folders of shaders").flatten() {
        for file in fs::read_dir(folder.path()).into_iter().flatten().flatten() {
            let path = file.path();
            let extension = path.extension().and_then(|text| text.to_str()).unwrap_or("");
            if !["vert", "frag", "comp"].contains(&extension) {
                continue;
            }
            let text = fs::read_to_string(&path).expect("a shader");
            // OpenGL has no sets.
            let text = text.replace("set = 0, ", "").replace("set = 1, ", "");
            let source = Source::new(path.display().to_string(), text.clone());
            let shader = layout(&source, &Options::default());
            let is_of_gl = |space| matches!(space, AddressSpace::Uniform | AddressSpace::Storage);
            let has_block = shader.blocks.iter().any(|block| is_of_gl(block.space));
            // Of others, the bytes are the driver's choice, and may be reported.
            let declared = shader.blocks.iter().all(|block| block.rules_declared);
            if has_block && declared && !shader.has_errors() && !text.contains("#include") {
                let stem = path.file_stem().expect("a name").to_string_lossy();
                all.push((stem.into_owned(), extension.to_string(), text));
            }
        }
    }
    all.sort();
    all.dedup_by(|a, b| a.0 == b.0);
    all
}

/// The text with a member more at the start of its first block.
fn drifted(text: &str) -> Option<String> {
    let block = text.match_indices(['{']).map(|(at, _)| at).find(|at| {
        let head = text[..*at].rsplit(['}', ';', '\n']).next().unwrap_or("");
        ["uniform ", "buffer "].iter().any(|word| head.contains(word))
    })?;
    Some(format!("{} float landfall_drift;{}", &text[..=block], &text[block + 1..]))
}

#[test]
fn check_reports_each_drift_of_a_linked_program_and_nothing_else() {
    let mut all = Programs::default();
    let bindings = all.bindings("blocks", "frag", BLOCKS);
    all.program("blocks", "frag", BLOCKS, &bindings);
    for (at, (from, to, _)) in DRIFTS.iter().enumerate() {
        assert!(BLOCKS.contains(from), "{from}");
        all.program(&format!("drift{at}"), "frag", &BLOCKS.replace(from, to), &bindings);
    }
    let mut repository = Vec::new();
    for (name, extension, text) in with_blocks() {
        let bindings = all.bindings(&name, &extension, &text);
        // A block that no function uses is none of the program's.
        if !all.has_check {
            continue;
        }
        all.program(&name, &extension, &text, &bindings);
        if let Some(other) = drifted(&text) {
            all.program(&format!("{name} drifted"), &extension, &other, &bindings);
        }
        repository.push(name);
    }
    let folder = scratch("gl");
    assert_formatted(&folder, &all.files);
    let Programs { mut text, rows, .. } = all;
    let _ = write!(text, "pub fn programs() -> Vec<Program> {{\n    vec![\n{rows}    ]\n}}\n");
    let file = folder.join("generated.rs");
    fs::write(&file, text).expect("scratch can be written to");
    let (ran, said, errors) = super::run("gl", &file);
    assert!(ran, "{said}\n{errors}");
    println!("{said}");
    let said = format!("\n{said}");
    let said: BTreeMap<&str, &str> =
        said.split("\nprogram ").filter_map(|part| part.split_once('\n')).collect();
    const RIGHT: &str = "as the constants say";
    assert_eq!(said["blocks"], RIGHT);
    for (at, (_, _, lines)) in DRIFTS.iter().enumerate() {
        let differences = said[&*format!("drift{at}")];
        for line in *lines {
            assert!(differences.lines().any(|said| said.trim() == *line), "{line}:\n{differences}");
        }
    }
    assert!(
        said["unlinked"].ends_with(" is not a program that is linked\")"),
        "{}",
        said["unlinked"]
    );
    assert_eq!(said["unloaded"], "Err(\"the driver has no glGetProgramiv\")\n");
    let mut held = 0;
    for name in repository {
        let right = said[&*name];
        // Those of Vulkan.
        if right.starts_with("not linked") {
            continue;
        }
        assert_eq!(right, RIGHT, "{name}");
        if let Some(differences) = said.get(&*format!("{name} drifted")) {
            assert!(
                differences.contains(".landfall_drift: byte 0 in the program"),
                "{differences}"
            );
            held += 1;
        }
    }
    println!("{held} shaders of the repository, each right and drifted");
    assert!(held >= 30, "{held}");
}
