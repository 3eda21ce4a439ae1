//! SPIR-V modules in the commands, beside the texts that glslang compiled them from.

use crate::schema::{holds, validator};
use crate::support::command::Place;
use crate::support::glslang::Client;
use crate::support::glslang_server::compiled;
use crate::support::rustc::{Math, crates, run, scratch};

/// Lights in an array, a matrix by rows, a push constant with a gap, a runtime tail.
const SHADER: &str = "#version 450
struct Light { vec3 position; float range; vec4 color; };
layout(std140, set = 1, binding = 2) uniform Lights { Light lights[4]; mat4 view; uint count; } u;
layout(std430, set = 0, binding = 1) buffer Tail { vec2 scale; vec3 points[]; };
layout(push_constant) uniform Push { layout(offset = 16) vec4 tint; float power; } push;
layout(location = 0) out vec4 color;
void main() { color = u.lights[0].color * scale.x + push.tint; }
";

fn module(text: &str) -> Vec<u32> {
    compiled(text, "frag", Client::Vulkan).unwrap_or_else(|log| panic!("{log}\n{text}"))
}

fn bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

/// A folder with the shader and its module.
fn place(name: &str) -> Place {
    let place = Place::new(name);
    place.write("a.frag", SHADER).write("a.frag.spv", bytes(&module(SHADER)));
    place
}

/// A module whose members at an offset are at another.
fn moved(mut words: Vec<u32>, from: u32, to: u32) -> Vec<u32> {
    // OpMemberDecorate, Offset
    let is_offset = |part: &[u32]| part[0] == 5 << 16 | 72 && part[3] == 35 && part[4] == from;
    let at: Vec<usize> =
        (5..words.len() - 4).filter(|at| is_offset(&words[*at..*at + 5])).collect();
    assert!(!at.is_empty(), "no member is at {from}");
    at.into_iter().for_each(|at| words[at + 4] = to);
    words
}

#[test]
fn a_module_is_shown_as_its_text() {
    let place = place("spirv-shown");
    let text = place.run(&["layout", "a.frag"]);
    let binary = place.run(&["layout", "a.frag.spv"]);
    assert_eq!((binary.code, binary.err.as_str()), (0, ""));
    // In the order of its variables.
    let mut blocks: Vec<&str> = text.out.trim_end().split("\n\n").skip(1).collect();
    let mut of_binary: Vec<&str> = binary.out.trim_end().split("\n\n").skip(1).collect();
    blocks.sort_unstable();
    of_binary.sort_unstable();
    assert_eq!(of_binary, blocks);
    assert!(binary.out.starts_with("a.frag.spv (fragment)\n"), "{}", binary.out);
    let stdin = place.run_with_stdin(&["layout", "-"], place.bytes("a.frag.spv"));
    assert_eq!(stdin.out.replace("<stdin>", "a.frag.spv"), binary.out, "{}", stdin.err);
    let explained = |file: &str| place.run(&["explain", file, "u.lights[2].color.y"]);
    assert_eq!(
        explained("a.frag.spv").out,
        explained("a.frag").out.replace("a.frag", "a.frag.spv")
    );
    let report = place.run(&["report", "a.frag.spv"]);
    assert!(report.code == 0 && report.out.contains("Lights"), "{}", report.err);
}

#[test]
fn a_bool_that_a_compiler_writes_as_a_uint_is_no_difference() {
    let place = Place::new("spirv-bool");
    let text = "#version 450\nstruct Light { bvec2 on; float range; };\n\
        layout(std140, binding = 0) uniform U { bool lit; Light lights[2]; int count; };\n\
        layout(location = 0) out vec4 color;\n\
        void main() { color = vec4(lit ? lights[1].range : float(count)); }\n";
    place.write("a.frag", text).write("a.frag.spv", bytes(&module(text)));
    for sides in [["a.frag", "a.frag.spv"], ["a.frag.spv", "a.frag"]] {
        let ran = place.run(&["diff", sides[0], sides[1]]);
        assert_eq!(ran.code, 0, "{sides:?}: {}{}", ran.out, ran.err);
    }
    place.write("b.frag", text.replace("bool lit", "int lit").replace("lit ?", "lit != 0 ?"));
    for sides in [["b.frag", "a.frag.spv"], ["a.frag", "b.frag"]] {
        let ran = place.run(&["diff", sides[0], sides[1]]);
        assert!(ran.code == 1 && ran.out.contains("`lit` changed from"), "{}{}", ran.out, ran.err);
    }
}

#[test]
fn what_a_compiler_moved_is_a_difference() {
    let place = place("spirv-moved");
    let same = place.run(&["diff", "a.frag", "a.frag.spv"]);
    assert_eq!(same.code, 0, "{}{}", same.out, same.err);
    // `power`, behind the `vec4` at 16.
    let words = moved(module(SHADER), 32, 36);
    place.write("moved.spv", bytes(&words));
    let found = place.run(&["diff", "a.frag", "moved.spv"]);
    assert_eq!(found.code, 1, "{}{}", found.out, found.err);
    assert!(found.out.contains("`power` moved from 32 to 36"), "{}", found.out);
    let listed = place.run(&["layout", "moved.spv", "--format", "json"]).json();
    assert_eq!(listed["shaders"][0]["language"], "spirv");
}

#[test]
fn a_module_is_locked_and_guarded() {
    let place = place("spirv-locked");
    let locked = place.run(&["lock", "a.frag.spv"]);
    assert_eq!(locked.code, 0, "{}", locked.err);
    let check = || place.run(&["check", "a.frag.spv"]);
    assert_eq!(check().code, 0, "{}{}", check().out, check().err);
    let drifted =
        SHADER.replace("float range;", "").replace("vec4 color; };", "vec4 color; float range; };");
    place.write("a.frag.spv", bytes(&module(&drifted)));
    let found = check();
    assert!(found.code == 1 && found.out.contains("layout-drift"), "{}{}", found.out, found.err);
    // Offsets that follow no rules are kept in a lock as well.
    place.write("a.frag.spv", bytes(&moved(module(SHADER), 192, 194)));
    let odd = place.run(&["lock", "a.frag.spv"]);
    assert_eq!(odd.code, 0, "{}", odd.err);
    let lock: serde_json::Value =
        serde_json::from_str(&place.read("layouts/a.frag.spv.json")).expect("a lock");
    let rules: Vec<&str> = lock["blocks"]
        .as_array()
        .expect("blocks")
        .iter()
        .filter_map(|b| b["rules"].as_str())
        .collect();
    assert!(rules.contains(&"explicit"), "{rules:?}");
    assert_eq!(check().code, 0, "{}{}", check().out, check().err);
}

/// A line without the number behind `mark`.
fn without_line(line: &str, mark: &str) -> String {
    match line.split_once(mark) {
        Some((before, after)) => {
            format!("{before}{}", after.trim_start_matches(|c: char| c.is_ascii_digit()))
        }
        None => line.to_string(),
    }
}

#[test]
fn mirrors_of_a_module_are_those_of_its_text() {
    let place = Place::new("spirv-mirrors");
    // A module is told by its bytes, so that both have one name; the folders are of one length.
    place.write("texts/a.frag", SHADER).write("spirv/a.frag", bytes(&module(SHADER)));
    let emitted = |folder: &str, language: &str| {
        let found = place.run(&["emit", &format!("{folder}/a.frag"), "--lang", language]);
        assert_eq!(found.code, 0, "{}", found.err);
        let text = found.out.replace("spirv/", "texts/");
        // Lines of a text, which a module does not have, and the order of its variables.
        let mut lines: Vec<String> =
            text.lines().map(|line| without_line(line, "a.frag:")).collect();
        lines.sort_unstable();
        lines
    };
    for language in ["rust", "c", "zig", "csharp", "python", "typescript"] {
        assert_eq!(emitted("spirv", language), emitted("texts", language), "{language}");
    }
}

#[test]
fn bytes_are_encoded_and_decoded_by_a_module() {
    let place = place("spirv-bytes");
    let values =
        "{\"lights\":[{\"position\":[1,2,3],\"range\":4,\"color\":[5,6,7,8]}],\"count\":9}";
    place.write("values.json", values);
    let encoded = |file: &str, out: &str| {
        let arguments = ["encode", file, "values.json", "--block", "Lights", "--out", out];
        let found = place.run(&arguments);
        assert_eq!(found.code, 0, "{}", found.err);
        place.bytes(out)
    };
    assert_eq!(encoded("a.frag.spv", "b.bin"), encoded("a.frag", "a.bin"));
    let decoded = |file: &str| place.run(&["decode", file, "a.bin", "--block", "Lights"]).out;
    assert_eq!(decoded("a.frag.spv"), decoded("a.frag"));
    assert!(decoded("a.frag.spv").contains('9'));
}

#[test]
fn what_needs_the_text_refuses_a_module() {
    let place = place("spirv-refused");
    place.write("scene.json", "{}");
    for arguments in [
        &["verify", "a.frag.spv"] as &[&str],
        &["run", "a.frag.spv", "--fn", "main"],
        &["port", "a.frag.spv", "--to", "wgsl"],
        &["lights", "a.frag.spv"],
        &["stress", "a.frag.spv", "--fn", "main"],
        &["prove", "a.frag.spv", "--fn", "main"],
        &["bench", "a.frag.spv", "--fn", "main"],
        &["emit", "a.frag.spv", "--lang", "rust", "--bindings", "wgpu"],
    ] {
        let found = place.run(arguments);
        assert_eq!(found.code, 2, "{arguments:?}: {}{}", found.out, found.err);
        let message = "`a.frag.spv` is SPIR-V, but what is asked for needs the text of a shader";
        assert_eq!(found.err.matches("error").count(), 1, "{arguments:?}: {}", found.err);
        assert!(found.err.contains(message), "{arguments:?}: {}", found.err);
    }
}

#[test]
fn a_search_passes_over_modules_that_are_not_named() {
    let place = place("spirv-searched");
    let files = |arguments: &[&str]| -> Vec<String> {
        let found = place.run(&[&["layout", "--format", "json"], arguments].concat()).json();
        let shaders = found["shaders"].as_array().expect("shaders").clone();
        shaders.iter().map(|s| s["path"].as_str().expect("a path").to_string()).collect()
    };
    assert_eq!(files(&["."]), ["a.frag"]);
    assert_eq!(files(&["*.spv"]), ["a.frag.spv"]);
    assert_eq!(files(&["*"]), ["a.frag"]);
    let found = place.run(&["check", "."]);
    assert!(found.err.contains("checked 1 shader"), "{}", found.err);
}

#[test]
fn a_file_that_is_no_module_is_one_error() {
    let place = place("spirv-wrong");
    place.write("text.spv", SHADER).write("cut.spv", &place.bytes("a.frag.spv")[..202]);
    for (file, message) in [
        ("text.spv", "`text.spv` is not SPIR-V: it begins with the bytes 23 76 65 72"),
        ("cut.spv", "`cut.spv` is not a whole SPIR-V module: 202 bytes are no words"),
    ] {
        let found = place.run(&["layout", file]);
        assert_eq!((found.code, found.err.matches("error").count()), (2, 1), "{}", found.err);
        assert!(found.err.contains(message), "{}", found.err);
    }
    let language = place.run(&["layout", "a.frag.spv", "--language", "glsl"]);
    assert_eq!(language.code, 2);
    assert!(language.err.contains("is SPIR-V, but `--language glsl` is given"), "{}", language.err);
}

#[test]
fn json_of_modules_keeps_to_the_schemas() {
    let place = place("spirv-schemas");
    place.write("odd.spv", bytes(&moved(module(SHADER), 192, 194)));
    for file in ["a.frag.spv", "odd.spv"] {
        let listed = place.run(&["layout", file, "--format", "json"]);
        holds(&validator("layout"), &listed.out, file);
        let explained = place.run(&["explain", file, "u.lights[2].range", "--format", "json"]);
        holds(&validator("explain"), &explained.out, file);
        assert_eq!(place.run(&["lock", file]).code, 0);
        holds(&validator("lock"), &place.read(&format!("layouts/{file}.json")), file);
    }
}

#[test]
fn a_configured_module_is_compared_with_its_text() {
    let place = place("spirv-compiled");
    place.write("landfall.toml", "[[compiled]]\nsource = \"a.frag\"\nspirv = \"a.frag.spv\"\n");
    let check = || place.run(&["check", "."]);
    assert_eq!(check().code, 0, "{}{}", check().out, check().err);
    // `power`, behind the `vec4` at 16.
    place.write("a.frag.spv", bytes(&moved(module(SHADER), 32, 36)));
    let found = check();
    assert_eq!(found.code, 1, "{}{}", found.out, found.err);
    let message = "error[compiled-differs]: in `a.frag.spv`, `power` moved from 32 to 36";
    assert!(found.out.contains(message), "{}", found.out);
    assert!(found.out.contains("a.frag:5:"), "{}", found.out);
    place.write("a.frag.spv", "no module");
    let broken = check();
    assert!(
        broken.code == 1 && broken.out.contains("`a.frag.spv` cannot be compared"),
        "{}",
        broken.out
    );
}

/// Without a set in the text, the compiler writes 0; which is no change of the layout.
#[test]
fn a_set_that_the_compiler_adds_is_no_difference() {
    let place = Place::new("spirv-set");
    let text = SHADER.replace("set = 1, ", "").replace("set = 0, ", "");
    place.write("a.frag", &text).write("a.frag.spv", bytes(&module(&text)));
    for sides in [["a.frag.spv", "a.frag"], ["a.frag", "a.frag.spv"]] {
        let ran = place.run(&[&["diff"], &sides[..]].concat());
        assert_eq!((ran.code, ran.out.as_str()), (0, "no layout changed\n"), "{}", ran.err);
    }
    // A set that differs is told.
    place.write("a.frag", text.replace("binding = 2", "set = 3, binding = 2"));
    let ran = place.run(&["diff", "a.frag", "a.frag.spv"]);
    assert!(ran.code == 1 && ran.out.contains("set changed from 3 to 0"), "{}", ran.out);
}

#[test]
fn a_build_script_takes_a_module() {
    let place = place("spirv-build");
    let mirrors = |file: &str| {
        let build = landfall::Build::new().shader(place.path(file));
        let text = build.generate_string().expect("it is laid out");
        text.replace("a.frag.spv", "a.frag").replace("a_frag_spv", "a_frag")
    };
    let (of_module, of_text) = (mirrors("a.frag.spv"), mirrors("a.frag"));
    for size in ["pub struct Lights", "pub struct Push", "pub struct Light "] {
        assert!(of_module.contains(size) && of_text.contains(size), "{of_module}");
    }
}

/// Behind the last element of an array, in its register, begins another member.
#[test]
fn mirrors_of_direct3d_s_packing_have_its_offsets() {
    let place = Place::new("spirv-d3d");
    let text = "#version 450
        layout(std140, binding = 0) uniform Packed { float weights[2]; float last; };
        layout(location = 0) out vec4 color;
        void main() { color = vec4(weights[0] + last); }";
    place.write("d3d.spv", bytes(&moved(module(text), 32, 20)));
    let shown = place.run(&["layout", "d3d.spv"]);
    assert!(
        shown.out.contains("uniform Packed · d3d · set 0, binding 0 · 32 bytes"),
        "{}{}",
        shown.out,
        shown.err
    );
    let emitted = place.run(&["emit", "d3d.spv", "--lang", "rust"]);
    assert_eq!(emitted.code, 0, "{}", emitted.err);
    let program = format!(
        "#[allow(dead_code)] mod mirror {{\n{}\n}}\nfn main() {{\n\
         let at = std::mem::offset_of!(mirror::Packed, last);\n\
         assert_eq!((at, std::mem::size_of::<mirror::Packed>()), (20, 32));\n}}\n",
        emitted.out
    );
    let root = scratch("spirv-d3d");
    std::fs::write(root.join("main.rs"), program).expect("it is written");
    run(crates(Math::Scalar), &root.join("main.rs"), "2024");
    // In C the elements of an array are whole.
    let header = place.run(&["emit", "d3d.spv", "--lang", "c"]);
    assert!(header.code == 2 && header.err.contains("`last`"), "{}{}", header.out, header.err);
}
