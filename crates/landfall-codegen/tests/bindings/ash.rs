//! Bindings for Vulkan: compared with the SPIR-V that glslang makes of the shaders, and compiled with
//! ash, which makes layouts and a pipeline of them on the driver.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use landfall_codegen::rust::Api;

use crate::{COUNT, TESTS, assert_formatted, generated, scratch};

/// The programs of GLSL, each with the extensions of its stages.
const PROGRAMS: [(&str, &[&str]); 3] =
    [("surface", &["vert", "frag"]), ("sums", &["comp"]), ("many", &["comp"])];

#[test]
fn ash_bindings_are_those_of_the_spir_v_and_make_pipelines() {
    let folder = scratch("ash");
    let mut text = String::new();
    let mut programs = String::new();
    let mut expected = String::new();
    let mut files = Vec::new();
    for (name, stages) in PROGRAMS {
        let paths: Vec<_> =
            stages.iter().map(|stage| format!("{TESTS}/shaders/vulkan/{name}.{stage}")).collect();
        let bindings = generated(&paths, Api::Ash);
        let alone = folder.join(format!("{name}.rs"));
        fs::write(&alone, &bindings).expect("scratch can be written to");
        files.push(alone);
        let _ = write!(text, "pub mod {name} {{\n{bindings}}}\n\n");
        let mut spirv = Spirv::default();
        let mut codes = String::new();
        for (path, stage) in paths.iter().zip(stages) {
            let code = folder.join(format!("{name}.{stage}.spv"));
            spirv.read(path, &code, stage);
            let flag = flag(stage);
            let _ =
                write!(codes, "(vk::ShaderStageFlags::{flag}, &include_bytes!({code:?})[..]), ");
        }
        let _ = write!(expected, "program {name}\n{}", spirv.rows());
        programs.push_str(&row(name, &bindings, &codes));
    }
    // That it has a dynamic offset is the program's choice.
    let camera = "set 0 binding 0 UNIFORM_BUFFER";
    let expected = expected.replacen(camera, &format!("{camera}_DYNAMIC"), 1);
    assert_formatted(&folder, &files);
    let _ = write!(text, "pub fn programs() -> Vec<Program> {{\n    vec![\n{programs}    ]\n}}\n");
    let file = folder.join("generated.rs");
    fs::write(&file, &text).expect("scratch can be written to");
    let (ran, said) = run(&file);
    assert!(ran, "{said}");
    assert_eq!(said, expected);
    // A fault in the generated text is seen.
    for (from, to) in [
        (
            "binding: 1,\n                    descriptor_type",
            "binding: 5,\n                    descriptor_type",
        ),
        ("DescriptorType::SAMPLED_IMAGE", "DescriptorType::STORAGE_IMAGE"),
        ("Format::R32G32_UINT", "Format::R32G32_SINT"),
    ] {
        assert!(text.contains(from), "{from}");
        fs::write(&file, text.replace(from, to)).expect("scratch can be written to");
        assert_ne!(run(&file).1, expected, "{from}");
    }
}

/// Whether all pipelines were made, and what was printed.
fn run(file: &Path) -> (bool, String) {
    let (ran, said, errors) = super::run("ash", file);
    assert!(!said.is_empty(), "{errors}");
    (ran, said)
}

/// The row of a program in the list that the compiled program walks.
fn row(name: &str, generated: &str, codes: &str) -> String {
    let of = format!("{name}::ash_bindings::{name}");
    let sets = generated.match_indices("pub const SET_").map(|(at, found)| {
        let rest = &generated[at + found.len()..];
        rest[..rest.find(':').expect("a type")].to_string()
    });
    let sets: String = sets.map(|n| format!("({n}, {of}::SET_{n}.to_vec()), ")).collect();
    let push = match generated.contains("pub const PUSH_CONSTANTS") {
        true => format!("Some({of}::PUSH_CONSTANTS)"),
        false => "None".to_string(),
    };
    let vertex = match generated.contains("pub struct MainVertex") {
        true => format!(
            "Some(({of}::MainVertex::binding(vk::VertexInputRate::VERTEX), \
             {of}::MainVertex::ATTRIBUTES.to_vec()))"
        ),
        false => "None".to_string(),
    };
    format!(
        "        Program {{ name: {name:?}, sets: vec![{sets}], push: {push}, vertex: {vertex}, \
         stages: vec![{codes}] }},\n"
    )
}

fn flag(stage: &str) -> &'static str {
    match stage {
        "vert" => "VERTEX",
        "frag" => "FRAGMENT",
        _ => "COMPUTE",
    }
}

/// What the SPIR-V of a program binds.
#[derive(Default)]
struct Spirv {
    /// Type, number and stages by set and binding.
    descriptors: BTreeMap<(u32, u32), (String, u64, Vec<&'static str>)>,
    push: Option<(u64, Vec<&'static str>)>,
    attributes: BTreeMap<u32, String>,
}

impl Spirv {
    /// Compiles a shader, and reads what its entry point uses.
    fn read(&mut self, path: &str, code: &Path, stage: &str) {
        // From version 1.4 an entry point lists every variable that it uses.
        let compiled = Command::new("glslangValidator")
            .args(["-V", "--quiet", "--target-env", "vulkan1.2", path, "-o"])
            .arg(code)
            .output()
            .expect("glslangValidator is installed");
        assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stdout));
        // glslang lists those that are declared as well, and keeps functions that nothing calls.
        let reduced = Command::new("spirv-opt")
            .args(["--eliminate-dead-functions", "--remove-unused-interface-variables"])
            .arg(code)
            .arg("-o")
            .arg(code)
            .status();
        assert!(reduced.expect("spirv-opt is installed").success());
        let text = Command::new("spirv-dis").args(["--no-indent", "--raw-id"]).arg(code).output();
        let text = String::from_utf8(text.expect("spirv-dis is installed").stdout).expect("UTF-8");
        let module = Module::new(&text);
        for id in &module.interface {
            let Some(["OpVariable", pointer, storage, ..]) = module.made(id) else {
                panic!("{id} is no variable")
            };
            let Some(["OpTypePointer", _, pointee]) = module.made(pointer) else {
                panic!("{pointer} is no pointer")
            };
            let number = |what: &str| module.decoration(id, what);
            match *storage {
                "PushConstant" => {
                    let (size, by) = self.push.get_or_insert((0, Vec::new()));
                    *size = module.size(pointee).max(*size);
                    by.push(flag(stage));
                }
                "Input" if stage == "vert" && number("Location").is_some() => {
                    let location = number("Location").expect("a location");
                    module.attributes(pointee, location, &mut self.attributes);
                }
                "Uniform" | "StorageBuffer" | "UniformConstant" => {
                    let place = number("DescriptorSet").zip(number("Binding")).expect("a place");
                    let (mut ty, mut count) = (*pointee, 1);
                    while let Some(["OpTypeArray", element, length]) = module.made(ty) {
                        count *= module.constant(length);
                        ty = element;
                    }
                    if let Some(["OpTypeRuntimeArray", element]) = module.made(ty) {
                        (ty, count) = (element, u64::from(COUNT));
                    }
                    let kind = module.descriptor(ty, storage);
                    let new = (kind, count, Vec::new());
                    self.descriptors.entry(place).or_insert(new).2.push(flag(stage));
                }
                _ => {}
            }
        }
    }

    /// The rows that the compiled program prints.
    fn rows(&self) -> String {
        let mut rows = String::new();
        for ((set, binding), (kind, count, stages)) in &self.descriptors {
            let stages = stages.join(" | ");
            let _ = writeln!(rows, "set {set} binding {binding} {kind} x{count} {stages}");
        }
        if let Some((size, stages)) = &self.push {
            let _ = writeln!(rows, "push {size} {}", stages.join(" | "));
        }
        for (location, format) in &self.attributes {
            let _ = writeln!(rows, "location {location} {format}");
        }
        rows
    }
}

/// The disassembly of a module.
struct Module<'t> {
    made: BTreeMap<&'t str, Vec<&'t str>>,
    decorations: BTreeMap<(&'t str, &'t str), u32>,
    members: Vec<Vec<&'t str>>,
    interface: Vec<&'t str>,
}

impl<'t> Module<'t> {
    fn new(text: &'t str) -> Module<'t> {
        let mut module = Module {
            made: BTreeMap::new(),
            decorations: BTreeMap::new(),
            members: Vec::new(),
            interface: Vec::new(),
        };
        for line in text.lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            match &words[..] {
                [id, "=", rest @ ..] => drop(module.made.insert(id, rest.to_vec())),
                ["OpDecorate", id, what, value] => {
                    module.decorations.insert((id, what), value.parse().unwrap_or(0));
                }
                ["OpDecorate", id, what] => drop(module.decorations.insert((id, what), 1)),
                ["OpMemberDecorate", rest @ ..] => module.members.push(rest.to_vec()),
                ["OpEntryPoint", _, _, _, interface @ ..] => module.interface = interface.to_vec(),
                _ => {}
            }
        }
        module
    }

    fn made(&self, id: &str) -> Option<&[&'t str]> {
        self.made.get(id).map(Vec::as_slice)
    }

    fn decoration(&self, id: &str, what: &str) -> Option<u32> {
        self.decorations.iter().find(|((of, name), _)| *of == id && *name == what).map(|(_, n)| *n)
    }

    fn constant(&self, id: &str) -> u64 {
        self.made(id).and_then(|made| made.last()?.parse().ok()).expect("a constant")
    }

    /// The bytes of a type, by its decorations.
    fn size(&self, id: &str) -> u64 {
        match self.made(id).expect("a type") {
            ["OpTypeFloat" | "OpTypeInt", bits, ..] => bits.parse::<u64>().expect("bits") / 8,
            ["OpTypeVector", element, count] => {
                self.size(element) * count.parse::<u64>().expect("a count")
            }
            ["OpTypeMatrix", column, count] => {
                // Every matrix here has columns of 16 bytes.
                let _ = column;
                16 * count.parse::<u64>().expect("a count")
            }
            ["OpTypeStruct", members @ ..] => {
                let offset = |at: usize| {
                    let rows = self.members.iter().map(Vec::as_slice);
                    let mut found = rows.filter_map(|row| match row {
                        [of, index, "Offset", offset] if *of == id && **index == at.to_string() => {
                            offset.parse::<u64>().ok()
                        }
                        _ => None,
                    });
                    found.next_back().expect("an offset")
                };
                let ends = members.iter().enumerate().map(|(at, ty)| offset(at) + self.size(ty));
                ends.max().unwrap_or(0).next_multiple_of(16)
            }
            other => panic!("the size of {other:?}"),
        }
    }

    fn attributes(&self, ty: &str, location: u32, all: &mut BTreeMap<u32, String>) {
        let numbers = |ty: &str| match self.made(ty) {
            Some(["OpTypeFloat", "32"]) => "SFLOAT",
            Some(["OpTypeInt", "32", "0"]) => "UINT",
            Some(["OpTypeInt", "32", "1"]) => "SINT",
            other => panic!("an input of {other:?}"),
        };
        match self.made(ty).expect("a type") {
            ["OpTypeMatrix", column, count] => {
                for at in 0..count.parse().expect("a count") {
                    self.attributes(column, location + at, all);
                }
            }
            ["OpTypeArray", element, count] => {
                for at in 0..self.constant(count) as u32 {
                    self.attributes(element, location + at, all);
                }
            }
            ["OpTypeVector", element, count] => {
                let channels = ["R32", "R32G32", "R32G32B32", "R32G32B32A32"];
                let channels = channels[count.parse::<usize>().expect("a count") - 1];
                all.insert(location, format!("{channels}_{}", numbers(element)));
            }
            _ => drop(all.insert(location, format!("R32_{}", numbers(ty)))),
        }
    }

    fn descriptor(&self, ty: &str, storage: &str) -> String {
        let kind = match self.made(ty).expect("a type") {
            ["OpTypeStruct", ..] if storage == "StorageBuffer" => "STORAGE_BUFFER",
            ["OpTypeStruct", ..] => "UNIFORM_BUFFER",
            ["OpTypeSampler"] => "SAMPLER",
            ["OpTypeImage", _, "Buffer", _, _, _, "1", ..] => "UNIFORM_TEXEL_BUFFER",
            ["OpTypeImage", _, "Buffer", ..] => "STORAGE_TEXEL_BUFFER",
            ["OpTypeImage", _, _, _, _, _, "1", ..] => "SAMPLED_IMAGE",
            ["OpTypeImage", ..] => "STORAGE_IMAGE",
            ["OpTypeSampledImage", image] => match self.made(image) {
                Some(["OpTypeImage", _, "Buffer", ..]) => "UNIFORM_TEXEL_BUFFER",
                _ => "COMBINED_IMAGE_SAMPLER",
            },
            other => panic!("a descriptor of {other:?}"),
        };
        kind.to_string()
    }
}
