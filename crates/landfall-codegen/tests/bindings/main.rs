//! Generated bindings, compiled and run: wgpu of each supported major version makes a pipeline of
//! every entry point with them on the Vulkan driver, and refuses each of them with a fault in it.

mod application;
mod ash;
mod errors;
mod gl;
mod sources;

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use landfall_codegen::rust::{Api, RustOptions, Sources, Tables, Vectors, WgpuMajor, rust};
use landfall_layout::{Options, Source, layout};
use naga::{Binding, BuiltIn, ScalarKind, ShaderStage, TypeInner};

const TESTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/bindings");

fn scratch(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bindings").join(name);
    fs::create_dir_all(&path).expect("target/tmp can be written to");
    path
}

/// Every WGSL shader of the repository that has an entry point, and those of this test.
fn shaders(major: WgpuMajor) -> Vec<(String, String)> {
    let root =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().expect("the workspace");
    let mut all = Vec::new();
    let mut folders = vec![root.join("shaders"), root.join("tests/bindings/shaders")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("a folder of shaders") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "wgsl") {
                let text = fs::read_to_string(&path).expect("a shader");
                // naga's name before version 28.
                let text = match major {
                    WgpuMajor::V27 => text.replace("var<immediate>", "var<push_constant>"),
                    _ => text,
                };
                all.push((path.display().to_string(), text));
            }
        }
    }
    all.sort();
    all
}

#[test]
#[ignore = "compiles an older wgpu: ./tests/run bindings"]
fn wgpu_27_takes_every_layout_and_refuses_each_with_a_fault() {
    wgpu_takes_them(WgpuMajor::V27, 27);
}

#[test]
#[ignore = "compiles an older wgpu: ./tests/run bindings"]
fn wgpu_28_takes_every_layout_and_refuses_each_with_a_fault() {
    wgpu_takes_them(WgpuMajor::V28, 28);
}

#[test]
#[ignore = "compiles an older wgpu: ./tests/run bindings"]
fn wgpu_29_takes_every_layout_and_refuses_each_with_a_fault() {
    wgpu_takes_them(WgpuMajor::V29, 29);
}

#[test]
fn wgpu_30_takes_every_layout_and_refuses_each_with_a_fault() {
    wgpu_takes_them(WgpuMajor::V30, 30);
}

fn wgpu_takes_them(major: WgpuMajor, number: u32) {
    let folder = scratch(&format!("wgpu{number}"));
    let mut text = String::new();
    let mut programs = Vec::new();
    let mut formatted = Vec::new();
    for (path, shader) in shaders(major) {
        let parsed = naga::front::wgsl::parse_str(&shader.replace("push_constant", "immediate"));
        let Ok(parsed) = parsed else { continue };
        if parsed.entry_points.is_empty() {
            continue;
        }
        let at = programs.len();
        let file = folder.join(format!("s{at}.wgsl"));
        fs::write(&file, &shader).expect("scratch can be written to");
        let generated = generated(&[file.display().to_string()], Api::WgpuMajor(major));
        let alone = file.with_extension("rs");
        fs::write(&alone, &generated).expect("scratch can be written to");
        formatted.push(alone);
        let _ = write!(text, "/// {path}\npub mod s{at} {{\n{generated}}}\n\n");
        // Where naga departs from WGSL, sizes do so, too.
        let is_exact = !shader.contains("naga-disagrees");
        programs.push(program(at, &path, is_exact, &generated, &parsed));
    }
    for (name, row) in glsl_programs() {
        let stages = if name == "wave" { &["vert", "frag"][..] } else { &["comp"][..] };
        let files = stages.iter().map(|stage| format!("{TESTS}/shaders/glsl/{name}.{stage}"));
        let generated = generated(&files.collect::<Vec<_>>(), Api::WgpuMajor(major));
        let alone = folder.join(format!("{name}.rs"));
        fs::write(&alone, &generated).expect("scratch can be written to");
        formatted.push(alone);
        let _ = write!(text, "pub mod {name} {{\n{generated}}}\n\n");
        let push = if major == WgpuMajor::V27 {
            "PUSH_CONSTANT_RANGE.range.end"
        } else {
            "IMMEDIATE_SIZE"
        };
        programs.push(row.replace("PUSH", push));
    }
    text.push_str(&two_files(Api::WgpuMajor(major)));
    let arrays = generated(&[format!("{TESTS}/compiled/arrays.wgsl")], Api::WgpuMajor(major));
    let _ = write!(text, "pub mod arrays {{\n{arrays}}}\n\n");
    assert!(programs.len() >= 20, "{} programs", programs.len());
    assert_formatted(&folder, &formatted);
    let list = programs.concat();
    let _ = write!(text, "pub fn programs() -> Vec<Program> {{\n    vec![\n{list}    ]\n}}\n");
    let file = folder.join("generated.rs");
    fs::write(&file, text).expect("scratch can be written to");
    let (ran, said, errors) = run(&format!("wgpu{number}"), &file);
    assert!(ran, "{said}\n{errors}");
    println!("{said}");
    // As many lines as programs, after the adapter's.
    assert_eq!(said.lines().count(), programs.len() + 1, "{said}");
    assert!(said.lines().skip(1).all(|line| line.contains("faults refused")), "{said}");
}

/// Compiles a program of `tests/bindings` with a generated file and runs it: whether it ended without
/// an error, and what it printed.
fn run(program: &str, generated: &Path) -> (bool, String, String) {
    let package = program.trim_end_matches("-application");
    let mut cargo = Command::new(env!("CARGO"));
    let alone = format!("{TESTS}/{package}/Cargo.lock");
    if Path::new(&alone).exists() {
        cargo.args(["run", "--manifest-path", &format!("{TESTS}/{package}/Cargo.toml")]);
        cargo.arg("--target-dir").arg(scratch("target"));
    } else {
        // As all tests are built, so that wgpu is compiled once.
        cargo.args(["test", "--workspace", "--features"]);
        cargo.arg(format!("full,bindings-{package}/generated"));
    }
    let out = cargo
        .args(["--bin", &format!("bindings-{program}")])
        .args(["--locked", "--quiet"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .env("LANDFALL_GENERATED", generated)
        .env("CARGO_INCREMENTAL", "0")
        // `tests/run` sets it for libtest.
        .env_remove("RUSTC_BOOTSTRAP")
        .output()
        .expect("cargo runs this test");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (out.status.success(), text(&out.stdout), text(&out.stderr))
}

/// The rows of the programs of GLSL, with `PUSH` for the size of the push constants.
fn glsl_programs() -> [(&'static str, &'static str); 2] {
    let wave = "Program { name: \"wave\",
            groups: vec![(0, wave::wgpu_bindings::wave::Group0::ENTRIES.to_vec()),
                (1, wave::wgpu_bindings::wave::Group1::ENTRIES.to_vec())],
            immediates: wave::wgpu_bindings::wave::PUSH, is_exact: true,
            module: |device| glsl(device, wave::wgpu_bindings::wave::FRAGMENT_SOURCE,
                naga::ShaderStage::Fragment),
            layout: wave::wgpu_bindings::wave::pipeline_layout,
            pipelines: vec![Pipeline::Render(Render {
                vertex_module: Some(|device| glsl(device,
                    wave::wgpu_bindings::wave::VERTEX_SOURCE, naga::ShaderStage::Vertex)),
                vertex: wave::wgpu_bindings::wave::MAIN_ENTRY,
                fragment: Some(wave::wgpu_bindings::wave::MAIN_ENTRY),
                buffer: Some((std::mem::size_of::<wave::wgpu_bindings::wave::MainVertex>() as u64,
                    wave::wgpu_bindings::wave::MainVertex::ATTRIBUTES.to_vec())),
                targets: vec![TextureFormat::Rgba8Unorm], has_depth: false, samples: 1,
                constants: vec![] })] },\n";
    let total = "Program { name: \"total\",
            groups: vec![(0, total::wgpu_bindings::total::Group0::ENTRIES.to_vec())],
            immediates: 0, is_exact: true,
            module: |device| glsl(device, total::wgpu_bindings::total::SOURCE,
                naga::ShaderStage::Compute),
            layout: total::wgpu_bindings::total::pipeline_layout,
            pipelines: vec![Pipeline::Compute {
                entry: total::wgpu_bindings::total::MAIN_ENTRY, constants: vec![] }] },\n";
    [("wave", wave), ("total", total)]
}

/// Panics where rustfmt would change one of the files.
fn assert_formatted(folder: &Path, files: &[PathBuf]) {
    // Its defaults, not this project's.
    let defaults = folder.join("rustfmt.toml");
    fs::write(&defaults, "").expect("scratch can be written to");
    let out = Command::new("rustfmt")
        .args(["--check", "--edition", "2024", "--config-path"])
        .arg(defaults)
        .args(files)
        .output()
        .expect("rustfmt is part of the toolchain");
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stdout));
}

/// Two generated files in one module, and what a program uses of each.
fn two_files(api: Api) -> String {
    let wave = ["vert", "frag"].map(|stage| format!("{TESTS}/shaders/glsl/wave.{stage}"));
    let total = [format!("{TESTS}/shaders/glsl/total.comp")];
    let (wave, total) = (generated(&wave, api), generated(&total, api));
    format!(
        "pub mod two_files {{\n{wave}\n{total}\npub const NAMES: [&str; 2] = \
         [wave_bindings::wgpu_bindings::wave::MAIN_ENTRY, \
         total_bindings::wgpu_bindings::total::MAIN_ENTRY];\n}}\n\n"
    )
}

/// The number of elements of arrays that are declared without.
const COUNT: u32 = 48;

/// The mirrors and bindings of the shaders of one program.
fn generated(files: &[String], api: Api) -> String {
    let read = |file: &String| {
        let text = fs::read_to_string(file).expect("a shader");
        let source = Source::new(file.clone(), text);
        let shader = layout(&source, &Options::default().with_interface(true));
        assert!(!shader.has_errors(), "{file}: {:?}", shader.diagnostics);
        shader
    };
    let shaders: Vec<_> = files.iter().map(read).collect();
    let mut options = RustOptions::default();
    options.vectors = Vectors::Array;
    options.tables = Tables::Without;
    options.bindings.apis = vec![api];
    options.bindings.dynamic_offsets = ["Camera", "Object"].map(str::to_string).to_vec();
    options.bindings.counts = ["many", "tiles"].map(|name| (name.to_string(), COUNT)).to_vec();
    options.bindings.sources = Sources::LoadedInDebug;
    options.bindings.paths = files.iter().map(|file| format!("{file:?}")).collect();
    let name = |file: &String| file.rsplit('/').next().expect("a name").to_string();
    options.inputs = files.iter().map(name).collect();
    let output = rust(&shaders.iter().collect::<Vec<_>>(), &options);
    let errors: Vec<_> =
        output.diagnostics.iter().filter(|one| one.code.name() == "no-binding").collect();
    assert!(errors.is_empty(), "{files:?}: {errors:?}");
    output.text
}

/// The row of a program: what the generated text has, and what naga says of the entry points.
fn program(
    at: usize,
    path: &str,
    is_exact: bool,
    generated: &str,
    module: &naga::Module,
) -> String {
    let bindings = format!("s{at}::wgpu_bindings::s{at}");
    let numbers = generated.match_indices("pub struct Group").map(|(at, found)| {
        let rest = &generated[at + found.len()..];
        rest[..rest.find('<').expect("a lifetime")].to_string()
    });
    let groups: String =
        numbers.map(|n| format!("({n}, {bindings}::Group{n}::ENTRIES.to_vec()), ")).collect();
    let immediates = if generated.contains("pub const IMMEDIATE_SIZE") {
        format!("{bindings}::IMMEDIATE_SIZE")
    } else if generated.contains("pub const PUSH_CONSTANT_RANGE") {
        format!("{bindings}::PUSH_CONSTANT_RANGE.range.end")
    } else {
        "0".to_string()
    };
    // wgpu compares the size when it draws; naga says what it is.
    if let Some(size) = immediates_of(module) {
        let said = ["IMMEDIATE_SIZE: u32 = ", "range: 0.."].iter().find_map(|before| {
            let rest = &generated[generated.find(before)? + before.len()..];
            rest[..rest.find([';', ','])?].parse().ok()
        });
        assert_eq!(said, Some(size), "{path}");
    }
    let constants = constants(&bindings, generated);
    let mut pipelines = String::new();
    for entry in &module.entry_points {
        let name = format!("{bindings}::{}_ENTRY", screaming(&entry.name));
        match entry.stage {
            ShaderStage::Compute => {
                let _ = writeln!(
                    pipelines,
                    "                Pipeline::Compute {{ entry: {name}, constants: {constants} }},"
                );
            }
            ShaderStage::Fragment => {
                pipelines.push_str(&render(&bindings, generated, module, entry, &constants));
            }
            ShaderStage::Vertex => {
                let buffer = buffer(&bindings, generated, &entry.name);
                let _ = writeln!(
                    pipelines,
                    "                Pipeline::Render(Render {{ vertex_module: None, vertex: {name}, \
                     fragment: None, buffer: {buffer}, targets: vec![], has_depth: true, samples: \
                     1, constants: {constants} }}),"
                );
            }
            _ => {}
        }
    }
    format!(
        "        Program {{\n            name: {path:?},\n            groups: vec![{groups}],\n            \
         immediates: {immediates},\n            is_exact: {is_exact},\n            module: {bindings}::shader_module,\n            \
         layout: {bindings}::pipeline_layout,\n            pipelines: vec![\n{pipelines}            \
         ],\n        }},\n"
    )
}

/// The bytes of the largest immediates.
fn immediates_of(module: &naga::Module) -> Option<u32> {
    let mut layouter = naga::proc::Layouter::default();
    layouter.update(module.to_ctx()).expect("naga lays it out");
    let all = module.global_variables.iter().map(|(_, global)| global);
    let all = all.filter(|global| global.space == naga::AddressSpace::Immediate);
    all.map(|global| layouter[global.ty].size).max()
}

fn screaming(name: &str) -> String {
    let mut text = String::new();
    for (at, c) in name.char_indices() {
        if c.is_ascii_uppercase() && at > 0 && !text.ends_with('_') {
            text.push('_');
        }
        text.push(c.to_ascii_uppercase());
    }
    text
}

/// Values of all constants: those that a shader without them has, or 1.
fn constants(bindings: &str, generated: &str) -> String {
    let Some(at) = generated.find("pub struct Constants {") else { return "vec![]".to_string() };
    let body = &generated[at..];
    let body = &body[..body.find("\n            }").expect("its end")];
    let fields: String = body
        .lines()
        .filter_map(|line| line.trim().strip_prefix("pub ")?.strip_suffix(',')?.split_once(": "))
        .map(|(name, ty)| {
            let value = |ty: &str| match ty {
                "f32" => "1.0",
                "bool" => "true",
                _ => "1",
            };
            match ty.strip_prefix("Option<").and_then(|ty| ty.strip_suffix('>')) {
                Some(ty) => format!("{name}: Some({}), ", value(ty)),
                None => format!("{name}: {}, ", value(ty)),
            }
        })
        .collect();
    format!("{bindings}::Constants {{ {fields}}}.entries()")
}

/// The vertex buffer of an entry point that has inputs.
fn buffer(bindings: &str, generated: &str, entry: &str) -> String {
    let camel: String = entry
        .split('_')
        .map(|word| word[..1].to_ascii_uppercase() + &word[1..])
        .collect::<Vec<_>>()
        .concat();
    let name = format!("{camel}Vertex");
    match generated.contains(&format!("pub struct {name} {{")) {
        true => format!(
            "Some((std::mem::size_of::<{bindings}::{name}>() as u64, \
             {bindings}::{name}::ATTRIBUTES.to_vec()))"
        ),
        false => "None".to_string(),
    }
}

/// The locations of the arguments or the result of an entry point, with their types.
fn locations(module: &naga::Module, entry: &naga::EntryPoint, output: bool) -> Vec<(u32, String)> {
    let mut all = Vec::new();
    let mut one = |binding: Option<&Binding>, ty: naga::Handle<naga::Type>| {
        let mut add = |binding: &Binding, ty| {
            if let Binding::Location { location, .. } = binding {
                all.push((*location, spelled(module, ty)));
            }
        };
        match (binding, &module.types[ty].inner) {
            (Some(binding), _) => add(binding, ty),
            (None, TypeInner::Struct { members, .. }) => {
                for member in members {
                    add(
                        member.binding.as_ref().expect("a binding of an input or output"),
                        member.ty,
                    );
                }
            }
            (None, _) => {}
        }
    };
    if output {
        if let Some(result) = &entry.function.result {
            one(result.binding.as_ref(), result.ty);
        }
    } else {
        for argument in &entry.function.arguments {
            one(argument.binding.as_ref(), argument.ty);
        }
    }
    all.sort();
    all
}

fn spelled(module: &naga::Module, ty: naga::Handle<naga::Type>) -> String {
    let (scalar, size) = match module.types[ty].inner {
        TypeInner::Scalar(scalar) => (scalar, 1),
        TypeInner::Vector { size, scalar } => (scalar, size as u8),
        ref other => panic!("an input or output of {other:?}"),
    };
    let scalar = match scalar.kind {
        ScalarKind::Sint => "i32",
        ScalarKind::Uint => "u32",
        _ => "f32",
    };
    if size == 1 { scalar.to_string() } else { format!("vec{size}<{scalar}>") }
}

/// A pipeline of a fragment shader, with a vertex shader of the module or one made for it.
fn render(
    bindings: &str,
    generated: &str,
    module: &naga::Module,
    entry: &naga::EntryPoint,
    constants: &str,
) -> String {
    let inputs = locations(module, entry, false);
    let fits = |other: &&naga::EntryPoint| {
        let outputs = locations(module, other, true);
        other.stage == ShaderStage::Vertex && inputs.iter().all(|input| outputs.contains(input))
    };
    let own = module.entry_points.iter().find(fits);
    let (text, vertex, buffer) = match own {
        Some(own) => (
            "None".to_string(),
            format!("{bindings}::{}_ENTRY", screaming(&own.name)),
            buffer(bindings, generated, &own.name),
        ),
        None => {
            let mut text = "struct Out {\n    @builtin(position) p: vec4<f32>,\n".to_string();
            for (location, ty) in &inputs {
                let flat =
                    if ty.contains("32<") || ty.contains('f') { "" } else { "@interpolate(flat) " };
                let _ = writeln!(text, "    @location({location}) {flat}v{location}: {ty},");
            }
            text.push_str(
                "}\n@vertex\nfn made() -> Out {\n    var out: Out;\n    return out;\n}\n",
            );
            (
                format!("Some(|device| wgsl(device, {text:?}))"),
                "\"made\"".to_string(),
                "None".to_string(),
            )
        }
    };
    let outputs = locations(module, entry, true);
    let targets: String = outputs
        .iter()
        .map(|(_, ty)| match ty.as_str() {
            ty if ty.contains("i32") => "TextureFormat::R32Sint, ",
            ty if ty.contains("u32") => "TextureFormat::R32Uint, ",
            _ => "TextureFormat::R32Float, ",
        })
        .collect();
    let is_depth =
        |binding: Option<&Binding>| matches!(binding, Some(Binding::BuiltIn(BuiltIn::FragDepth)));
    let has_depth = entry.function.result.as_ref().is_some_and(|result| {
        let inside = match &module.types[result.ty].inner {
            TypeInner::Struct { members, .. } => {
                members.iter().any(|member| is_depth(member.binding.as_ref()))
            }
            _ => false,
        };
        inside || is_depth(result.binding.as_ref())
    });
    format!(
        "                Pipeline::Render(Render {{ vertex_module: {text}, vertex: {vertex}, fragment: \
         Some({bindings}::{}_ENTRY), buffer: {buffer}, targets: vec![{targets}], has_depth: \
         {has_depth}, samples: 1, constants: {constants} }}),\n",
        screaming(&entry.name)
    )
}
