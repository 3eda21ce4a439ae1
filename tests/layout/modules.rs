//! Shaders that are put together from several files: WESL, naga_oil, and files included as text.
//!
//! Trees of WESL are held against the package `wesl` of npm, whose WGSL is laid out by naga.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;

use landfall_layout::source::OpenFiles;
use landfall_layout::{Options, ShaderLayout, Source, layout};
use serde_json::{Map, Value, json};

use super::support::landfall::{first_error as error, in_memory};
use super::support::sample::everything;
use super::wgsl_naga::compare;

/// Lays out the first of some files, with definitions.
fn laid_out(files: &[(&str, &str)], defines: &[(&str, &str)]) -> ShaderLayout {
    let defines = defines.iter().map(|(name, value)| (name.to_string(), value.to_string()));
    in_memory(files, |options| options.read.defines = defines.collect())
}

/// The blocks as `name: offsets of its members, size`.
fn blocks(shader: &ShaderLayout) -> Vec<String> {
    assert!(!shader.has_errors(), "{:#?}", shader.diagnostics);
    let shown = |block: &landfall_layout::BlockLayout| {
        let offsets: Vec<String> = block
            .members
            .iter()
            .map(|m| format!("{} {}", m.name, m.offset.unwrap_or_default()))
            .collect();
        format!("{}: {}; {}", block.name, offsets.join(", "), block.size.unwrap_or_default())
    };
    shader.blocks.iter().map(shown).collect()
}

// --- WESL ---

#[test]
fn imports_of_every_form_are_followed() {
    let main = "
        import package::types::{Light as Lamp, sizes::COUNT};
        import super::types;
        import lib::fog::Fog;
        @group(0) @binding(0) var<uniform> lamps: array<Lamp, COUNT>;
        @group(0) @binding(1) var<uniform> one: types::Light;
        @group(0) @binding(2) var<uniform> fog: Fog;
        @group(0) @binding(constants::SLOT) var<uniform> two: package::types::sizes::Pair;";
    let files = [
        ("game/main.wesl", main),
        ("game/types.wesl", "struct Light { at: vec3f, power: f32, color: vec3f }"),
        (
            "game/types/sizes.wesl",
            "import super::super::types::Light;\nconst COUNT = 3u;\nstruct Pair { a: Light, b: f32 }",
        ),
        ("lib/src/fog.wesl", "import package::density::D; struct Fog { color: vec3f, density: D }"),
        ("lib/src/density.wesl", "alias D = f32;"),
    ];
    let shader = laid_out(&files, &[("SLOT", "7")]);
    let expected = [
        "lamps: lamps 0; 96",
        "Light: at 0, power 12, color 16; 32",
        "Fog: color 0, density 12; 16",
        "Pair: a 0, b 32; 48",
    ];
    assert_eq!(blocks(&shader), expected);
    assert_eq!(shader.blocks[3].binding, Some(7));
    // Members stand in the file of their structure.
    let at = shader.files.locate(shader.blocks[2].members[1].span);
    assert_eq!((at.path.as_str(), at.line), ("lib/src/fog.wesl", 1));
}

#[test]
fn declarations_of_one_name_stay_apart() {
    let files = [
        (
            "main.wesl",
            "import package::a::make;
             struct S { x: vec3f }
             @group(0) @binding(0) var<uniform> s: S;
             @group(0) @binding(1) var<uniform> t: package::a::T;
             fn f() -> f32 { let make = 1.0; return make; }",
        ),
        ("a.wesl", "struct S { y: f32, z: f32 } struct T { s: S, n: u32 } fn make() {}"),
    ];
    assert_eq!(blocks(&laid_out(&files, &[])), ["S: x 0; 16", "T: s 0, n 8; 12"]);
}

#[test]
fn conditions_choose_declarations_and_members() {
    let files = [
        (
            "main.wesl",
            "@if(WIDE) import package::wide::Tint;
             @else import package::narrow::Tint;
             struct S { @if(BIG && !WIDE) a: mat4x4f, @size(32) @else b: f32, c: Tint }
             @if(BIG) { @group(0) @binding(0) var<uniform> s: S; }
             @if(!BIG) { @group(0) @binding(1) var<storage> s: S; }",
        ),
        ("wide.wesl", "alias Tint = vec4f;"),
        ("narrow.wesl", "alias Tint = f32;"),
    ];
    for (defines, expected) in [
        (&[][..], "S: b 0, c 32; 36"),
        (&[("BIG", "true")], "S: a 0, c 64; 80"),
        (&[("BIG", "true"), ("WIDE", "true")], "S: b 0, c 32; 48"),
        (&[("BIG", "true"), ("WIDE", "false")], "S: a 0, c 64; 80"),
    ] {
        assert_eq!(blocks(&laid_out(&files, defines)), [expected], "{defines:?}");
    }
}

/// After WESL's extension "Visibility": words before declarations; what the shader imports publicly is
/// its own, by its new name.
#[test]
fn public_imports_are_part_of_the_shader() {
    let files = [
        (
            "game/main.wesl",
            "public import package::gfx::{scene as world, exposure};
             @if(FOG) public import super::gfx::fog;
             import package::LIMIT;
             private const COUNT = LIMIT + 1;
             public struct Own { @size(16) a: f32, b: array<f32, COUNT> }
             @group(0) @binding(0) public var<storage> own: Own;
             var<private> counter: u32;",
        ),
        (
            "game/gfx.wesl",
            "public struct Scene { at: vec3f, power: f32 }
             @group(1) @binding(2) public var<storage, read_write> scene: array<Scene>;
             @group(1) @binding(3) public var<uniform> fog: vec4f;
             @group(1) @binding(4) var<uniform> unused: vec4f;
             public override exposure: f32 = 1.0;",
        ),
        ("game/package.wesl", "const LIMIT = 2;"),
    ];
    let own = "Own: a 0, b 16; 28";
    let world = "world: world 0; 16";
    assert_eq!(blocks(&laid_out(&files, &[])), [own, world]);
    let fog = laid_out(&files, &[("FOG", "true")]);
    assert_eq!(blocks(&fog), [own, world, "fog: fog 0; 16"]);
    let at = fog.files.locate(fog.blocks[1].span);
    assert_eq!((at.path.as_str(), at.line), ("game/gfx.wesl", 2));
    let plain = laid_out(&[("main.wgsl", "public struct S { a: f32 }")], &[]);
    assert!(plain.has_errors(), "WGSL reserves these words");
}

#[test]
fn what_functions_lack_is_told_and_blocks_are_laid_out() {
    let files = [
        (
            "main.wesl",
            "import package::a::{S, gone};
             @group(0) @binding(0) var<uniform> s: S;
             fn f() -> f32 { return gone() + package::missing::g(); }",
        ),
        ("a.wesl", "struct S { a: f32 } @if(MORE) fn gone() -> f32 { return 1.0; }"),
    ];
    let shader = laid_out(&files, &[]);
    assert_eq!(blocks(&shader), ["S: a 0; 4"]);
    let said: Vec<&str> = shader.diagnostics.iter().map(|found| &*found.message).collect();
    assert_eq!(said, ["`a.wesl` has no `gone`", "the module `package::missing` is not found"]);
}

#[test]
fn what_is_wrong_has_its_place_and_reason() {
    for (main, message, place) in [
        (
            "import package::a::Lihgt;\nvar<uniform> l: Lihgt;",
            "`a.wesl` has no `Lihgt`",
            "main.wesl:1",
        ),
        (
            "import package::b::X;\n\nvar<uniform> l: X;",
            "the module `package::b` is not found",
            "main.wesl:1",
        ),
        (
            "import super::super::x::Y;\nvar<uniform> l: Y;",
            "the module `super::super::x` is not found",
            "main.wesl:1",
        ),
        (
            "import package::a::Light\nvar<uniform> l: Light;",
            "expected `;`, found `var`",
            "main.wesl:2",
        ),
        (
            "import package::a::Light;\nstruct Light { b: f32 }\nvar<uniform> l: Light;",
            "`Light` is defined twice",
            "main.wesl:1",
        ),
        (
            "import package::a::Light;\nimport package::broken::B as Light;",
            "`Light` is defined twice",
            "main.wesl:2",
        ),
        ("@else var<uniform> l: f32;", "`@else` without an `@if` before it", "main.wesl:1"),
        ("import package::broken::B;\nvar<uniform> l: B;", "unknown type `vec33`", "broken.wesl:2"),
        ("var<uniform> l: array<vec4f, constants::N>;", "`N` has no value", "main.wesl:1"),
        (
            "import package::filled::F;\nvar<uniform> l: F;",
            "`filled.wesl` is a template: line 2 has `{{ more }}`",
            "main.wesl:1",
        ),
    ] {
        let files = [
            ("main.wesl", main),
            ("a.wesl", "struct Light { a: f32 }"),
            ("broken.wesl", "struct B {\n  a: vec33 }"),
            ("filled.wesl", "struct F {\n  {{ more }} a: f32 }"),
        ];
        let (found, at, _) = error(&laid_out(&files, &[]));
        assert_eq!((&*found, &*at), (message, place), "{main}");
    }
}

#[test]
fn a_type_that_a_module_declares_is_told_with_its_file() {
    let main = "import package::util::types::{Ligth, lum};
        @group(0) @binding(0) var<uniform> light: Light;
        @fragment fn f() -> @location(0) vec4f { return vec4f(lum(light)); }";
    let types = "struct Light { at: vec3f } fn lum(l: Light) -> f32 { return l.at.x; }";
    let shader = laid_out(&[("main.wesl", main), ("util/types.wesl", types)], &[]);
    assert_eq!(error(&shader).0, "unknown type `Light`");
    let help = shader.diagnostics.iter().find_map(|found| found.help.as_deref());
    assert_eq!(help, Some("`util/types.wesl` declares it: import it from there"));
}

/// A tree of modules, whose root is `main.wesl`, and the conditions that hold.
struct Tree {
    files: Vec<(String, String)>,
    conditions: Vec<(&'static str, bool)>,
}

const PATHS: [&str; 5] = ["a", "b", "b/c", "b/d", "e/f/g"];

/// A tree in which modules use structures, constants and aliases of those before them.
fn tree(random: &mut fastrand::Rng) -> Tree {
    let types = ["f32", "u32", "vec2f", "vec3f", "vec4<f32>", "mat3x3f", "mat2x2f", "vec3i"];
    let flags = ["A", "B", "C"];
    let mut files = Vec::new();
    let mut known: Vec<(usize, String)> = Vec::new();
    let mut constants: Vec<(usize, String)> = Vec::new();
    let count = random.usize(1..=PATHS.len());
    for (module, path) in PATHS.iter().chain(["main"].iter()).enumerate() {
        // The root comes last.
        let is_root = *path == "main";
        if !is_root && module >= count {
            continue;
        }
        let mut imports = String::new();
        let mut named = 0;
        // Imports a name, or writes its path.
        let mut used = |random: &mut fastrand::Rng, (of, name): &(usize, String)| -> String {
            if *of == module {
                return name.clone();
            }
            let path = format!("package::{}::{name}", PATHS[*of].replace('/', "::"));
            if random.bool() {
                return path;
            }
            named += 1;
            let alias = format!("{name}{module}x{named}");
            imports.push_str(&format!("import {path} as {alias};\n"));
            alias
        };
        let mut text = String::new();
        if random.bool() {
            let name = format!("N{}", random.u8(0..2));
            if constants.iter().all(|known| known != &(module, name.clone())) {
                text.push_str(&format!("const {name} = {}u;\n", random.u8(1..6)));
                constants.push((module, name));
            }
        }
        let (before, structures) = (known.len(), random.usize(1..4));
        for index in 0..structures {
            // Some names are in several modules.
            let name = format!("S{index}");
            let mut members = String::new();
            for member in 0..random.usize(1..6) {
                let mut ty = match random.u8(0..3) {
                    0 if !known.is_empty() => {
                        let one = random.choice(&known).expect("there are some").clone();
                        used(random, &one)
                    }
                    _ => random.choice(types).expect("there are some").to_string(),
                };
                if random.u8(0..4) == 0 {
                    let length = match random.choice(&constants).cloned() {
                        Some(one) if random.bool() => used(random, &one),
                        _ => random.u8(1..5).to_string(),
                    };
                    ty = format!("array<{ty}, {length}>");
                }
                let condition = match random.u8(0..4) {
                    0 if member > 0 => format!("@if({}) ", random.choice(flags).expect("three")),
                    1 if member > 0 => format!(
                        "@if(!{} || {}) ",
                        random.choice(flags).expect("three"),
                        random.choice(flags).expect("three")
                    ),
                    _ => String::new(),
                };
                members.push_str(&format!("  {condition}m{member}: {ty},\n"));
            }
            text.push_str(&format!("struct {name} {{\n{members}}}\n"));
            known.push((module, name));
        }
        if is_root {
            let own = known[before..].to_vec();
            for (binding, one) in own.iter().chain(known.first()).enumerate() {
                let ty = used(random, one);
                text.push_str(&format!(
                    "@group(0) @binding({binding}) var<storage> v{binding}: {ty};\n"
                ));
            }
        }
        files.push((format!("{path}.wesl"), format!("{imports}{text}")));
    }
    let conditions = flags.map(|flag| (flag, random.bool())).to_vec();
    Tree { files, conditions }
}

/// What the package `wesl` makes of trees.
fn linked_by_wesl(trees: &[Tree]) -> Vec<String> {
    let given: Vec<Value> = trees
        .iter()
        .map(|tree| {
            let files: Map<String, Value> =
                tree.files.iter().map(|(path, text)| (path.clone(), json!(text))).collect();
            let conditions: Map<String, Value> =
                tree.conditions.iter().map(|(flag, is)| (flag.to_string(), json!(is))).collect();
            json!([files, conditions])
        })
        .collect();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut node = Command::new("node")
        .arg(root.join("tests/support/wesl.mjs"))
        .arg(root.join("target/wesl"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("`node`: tests/run installs it");
    let text = serde_json::to_string(&given).expect("keys are strings");
    node.stdin.take().expect("it is piped").write_all(text.as_bytes()).expect("node reads it");
    let output = node.wait_with_output().expect("node ends");
    assert!(output.status.success(), "the package `wesl` refuses a tree");
    serde_json::from_slice(&output.stdout).expect("it prints JSON")
}

#[test]
fn random_trees_of_wesl_lie_where_wesl_and_naga_put_them() {
    let mut random = fastrand::Rng::with_seed(47);
    let trees: Vec<Tree> =
        (0..if everything() { 400 } else { 60 }).map(|_| tree(&mut random)).collect();
    let mut compared = 0;
    for (tree, text) in trees.iter().zip(linked_by_wesl(&trees)) {
        let mut files: Vec<(&str, &str)> =
            tree.files.iter().map(|(path, text)| (&**path, &**text)).collect();
        files.reverse();
        let defines: Vec<(&str, &str)> = tree
            .conditions
            .iter()
            .map(|(flag, is)| (*flag, if *is { "true" } else { "false" }))
            .collect();
        let shader = laid_out(&files, &defines);
        let shown = format!("{:?}\n{:#?}\n{text}", tree.conditions, tree.files);
        assert!(!shader.has_errors(), "{:#?}\n{shown}", shader.diagnostics);
        let module = naga::front::wgsl::parse_str(&text).unwrap_or_else(|e| panic!("{e}\n{shown}"));
        assert_eq!(module.global_variables.len(), shader.blocks.len(), "{shown}");
        for (_, variable) in module.global_variables.iter() {
            let binding = variable.binding.map(|at| at.binding);
            let block = shader.blocks.iter().find(|block| block.binding == binding);
            let block = block.unwrap_or_else(|| panic!("{binding:?}\n{shown}"));
            compared += compare(&module, variable.ty, &block.members, &shown);
        }
    }
    eprintln!("{compared} members of {} trees lie where wesl and naga put them", trees.len());
    assert!(compared > 10 * trees.len(), "{compared}");
}

// --- naga_oil ---

#[test]
fn modules_of_naga_oil_are_found_by_the_path_they_state() {
    let files = [
        (
            "game/main.wgsl",
            "#import engine::view::{
                View, // the camera
                COUNT as VIEWS,
            }
            #import engine::lights as lit
            #ifdef MANY
            @group(0) @binding(#{LIGHTS_BINDING}) var<storage> lights: array<lit::Light>;
            #else
            @group(0) @binding(1) var<uniform> lights: lit::Light;
            #endif
            @group(0) @binding(0) var<uniform> views: array<View, VIEWS>;
            fn f() -> f32 { return engine::lights::power(lights); }",
        ),
        (
            "engine/a.wgsl",
            "#define_import_path engine::view\nstruct View { m: mat4x4f }\nconst COUNT = 2;",
        ),
        (
            "engine/b.wgsl",
            "#define_import_path engine::lights
            struct Light { at: vec3f,
            #if QUALITY >= 2
                color: vec3f,
            #else if QUALITY == 1
                tint: f32,
            #endif
            }
            fn power(light: Light) -> f32 { return 1.0; }",
        ),
    ];
    for (defines, expected) in [
        (&[("QUALITY", "0")][..], ["Light: at 0; 16", "views: views 0; 128"]),
        (&[("QUALITY", "1")], ["Light: at 0, tint 12; 16", "views: views 0; 128"]),
        (&[("QUALITY", "2")], ["Light: at 0, color 16; 32", "views: views 0; 128"]),
    ] {
        assert_eq!(blocks(&laid_out(&files, defines)), expected, "{defines:?}");
    }
    let many = laid_out(&files, &[("QUALITY", "2"), ("MANY", ""), ("LIGHTS_BINDING", "5")]);
    let bindings: Vec<_> = many.blocks.iter().map(|block| block.binding).collect();
    assert_eq!(bindings, [Some(5), Some(0)]);
    let without = laid_out(&files, &[]);
    assert_eq!(blocks(&without)[0], "Light: at 0; 16");
    let message = "`QUALITY` is not defined, so this condition does not hold";
    assert_eq!(without.diagnostics[0].message, message);
}

#[test]
fn the_module_of_naga_oil_that_declares_a_name_is_taken() {
    let lights = |path, text| (path, format!("#define_import_path engine::lights\n{text}"));
    let stub = lights("engine/a.wgsl", "// Where the plugin is not loaded.");
    let real = lights("engine/b.wgsl", "struct Light { at: vec3f }");
    let other = lights("engine/c.wgsl", "struct Light { power: f32, at: vec3f }");
    let main = "#import engine::lights::{Light, power}
        @group(0) @binding(0) var<uniform> light: Light;
        fn power() -> f32 { return 1.0; }";
    let of = |modules: &[&(&'static str, String)]| {
        let mut files = vec![("main.wgsl", main)];
        files.extend(modules.iter().map(|(path, text)| (*path, text.as_str())));
        laid_out(&files, &[])
    };
    let shader = of(&[&stub, &real]);
    assert_eq!(blocks(&shader), ["Light: at 0; 16"]);
    assert!(shader.diagnostics.is_empty(), "{:#?}", shader.diagnostics);
    let shader = of(&[&stub, &real, &other]);
    assert_eq!(blocks(&shader), ["Light: at 0; 16"]);
    let found = &shader.diagnostics[0];
    assert_eq!(
        (found.message.as_str(), found.notes[0].as_str()),
        (
            "`engine::lights` is the path of two modules that declare `Light`",
            "`engine/b.wgsl` is read, `engine/c.wgsl` is not"
        )
    );
}

#[test]
fn conditions_of_lines_must_match() {
    for (text, message) in [
        ("#ifdef A\nvar<uniform> v: vec4f;", "this condition is never closed"),
        ("#endif\nvar<uniform> v: vec4f;", "`#endif` without a condition"),
        ("#else\nvar<uniform> v: vec4f;", "`#else` without a condition"),
        ("#ifdef A\n#else unless B\n#endif", "`#else` is followed by `unless`"),
        (
            "#if A\n#endif\nvar<uniform> v: vec4f;",
            "`#if` expects `NAME == VALUE`, or another comparison",
        ),
    ] {
        assert_eq!(error(&laid_out(&[("a.wgsl", text)], &[])).0, message, "{text}");
    }
    // In comments nothing is a line of a preprocessor.
    let text = "/*\n#ifdef A\n#{B}\n*/\n// #import x::y\nvar<uniform> v: vec4f;";
    assert_eq!(blocks(&laid_out(&[("a.wgsl", text)], &[])), ["v: v 0; 16"]);
}

// --- Files included as text ---

#[test]
fn files_are_included_as_text_in_every_style() {
    let light = "struct Light { at: vec3f, power: f32 }";
    for line in [
        "#include \"light.wgsl\"",
        "#include <light.wgsl>",
        "#import \"light.wgsl\"",
        "#import <light.wgsl>",
        "#import light",
        "#import ./light.wgsl // as some loaders have it",
    ] {
        let line = line.replace("./light.wgsl", "\"./light.wgsl\"");
        let main = format!("{line}\n{line}\nvar<uniform> l: Light;");
        let files = [("src/main.wgsl", main.as_str()), ("src/light.wgsl", light)];
        let shader = laid_out(&files, &[]);
        assert_eq!(blocks(&shader), ["Light: at 0, power 12; 16"], "{line}");
        let at = shader.files.locate(shader.blocks[0].members[1].span);
        assert_eq!((at.path.ends_with("light.wgsl"), at.line, at.column), (true, 1, 27), "{line}");
    }
    let (message, place, _) =
        error(&laid_out(&[("a.wgsl", "\n#include \"b.wgsl\"\nvar<uniform> v: B;")], &[]));
    assert_eq!((&*message, &*place), ("`b.wgsl` not found", "a.wgsl:2"));
}

#[test]
fn a_prelude_comes_before_the_text() {
    let files = [
        ("a.wgsl", "\nvar<uniform> v: D;"),
        ("common.wgsl", "struct C { a: vec3f }"),
        ("more.wgsl", "alias D = C;"),
    ];
    let shader = in_memory(&files, |options| {
        options.read.preludes = vec!["common.wgsl".into(), "more.wgsl".into()];
    });
    assert_eq!(blocks(&shader), ["C: a 0; 16"]);
    let at = shader.files.locate(shader.blocks[0].span);
    assert_eq!((at.path.as_str(), at.line), ("a.wgsl", 2));
}

/// As an editor has them, whether or not they were saved.
#[test]
fn a_module_that_is_only_open_is_imported() {
    let texts = [("game/types.wesl", "struct Light { at: vec3f }")];
    let texts = texts.map(|(path, text)| (PathBuf::from(path), Arc::from(text)));
    let mut options = Options::default();
    let folder = std::env::temp_dir().join("landfall-no-such-folder");
    options.read.open_files = Some(Arc::new(OpenFiles::new(folder, texts)));
    let text = "import package::types::Light;\nvar<uniform> light: Light;";
    let shader = layout(&Source::new("game/main.wesl", text), &options);
    assert_eq!(blocks(&shader), ["Light: at 0; 16"]);
}

#[test]
fn cycles_and_chains_end() {
    let files = [
        ("main.wesl", "import package::a::A; var<uniform> v: A;"),
        ("a.wesl", "import package::b::B; struct A { b: B }"),
        ("b.wesl", "import package::a::A; struct B { a: A }"),
    ];
    assert!(error(&laid_out(&files, &[])).0.contains("itself"));
    let files = [
        ("a.wesl", "import package::b::X; var<uniform> v: X;"),
        ("b.wesl", "import package::b::X;"),
    ];
    assert!(laid_out(&files, &[]).has_errors());
    let chain: Vec<(String, String)> = (0..1000)
        .map(|i| {
            let text = format!("import package::m{}::T;\nvar<uniform> v: T; alias U = T;", i + 1);
            (format!("m{i}.wesl"), text)
        })
        .collect();
    let mut files: Vec<(&str, &str)> = chain.iter().map(|(a, b)| (&**a, &**b)).collect();
    files.push(("m1000.wesl", "alias T = vec4f;"));
    assert!(laid_out(&files, &[]).has_errors());
}
