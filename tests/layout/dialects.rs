//! GLSL as engines and tools write it, laid out from the file and, by glslang, from the text that the
//! engine would compile; and structures without a block.

use landfall_layout::{Options, ShaderLayout, Source, Stage, layout};

use crate::support::glslang::{self, Client};
use crate::support::landfall::{first_error as error, in_memory as laid_out};

/// The blocks, leaf by leaf.
fn ours(shader: &ShaderLayout) -> Vec<String> {
    assert!(!shader.has_errors(), "{:#?}", shader.diagnostics);
    let row = |(block, path, offset, strides): (&str, &str, u64, String)| {
        format!("{block} {path} {offset} {strides}")
    };
    let leaves = |block: &'_ landfall_layout::BlockLayout| {
        let block = block.clone();
        block.leaves.clone().into_iter().map(move |leaf| {
            let offset = leaf.offset.expect("it is in a buffer");
            row((&block.name, &leaf.path, offset, format!("{:?}", leaf.strides)))
        })
    };
    let blocks = shader.blocks.iter().filter(|block| block.size.is_some());
    let mut rows: Vec<String> = blocks.flat_map(leaves).collect();
    rows.sort();
    rows
}

/// The blocks of some stages by glslang, leaf by leaf, those of several stages once.
fn theirs(stages: &[(&str, &str)], client: Client) -> Vec<String> {
    // Stages of rays need SPIR-V 1.4.
    let target_env = (client == Client::Vulkan).then_some("vulkan1.2");
    let options = glslang::Options { client, target_env, ..glslang::Options::unlisted() };
    let mut rows = Vec::new();
    for (stage, text) in stages {
        let blocks = glslang::blocks(text, stage, &options);
        for block in blocks.unwrap_or_else(|report| panic!("{report}\n{text}")) {
            rows.extend(block.leaves.iter().map(|leaf| {
                let strides: Vec<u64> = leaf.strides.iter().flatten().copied().collect();
                format!("{} {} {} {strides:?}", block.name, leaf.path, leaf.offset)
            }));
        }
    }
    rows.sort();
    rows.dedup();
    rows
}

/// The file and line of each block's name.
fn places(shader: &ShaderLayout) -> Vec<String> {
    let at = |block: &landfall_layout::BlockLayout| {
        let at = shader.files.locate(block.span);
        format!("{} {}:{}", block.name, at.path, at.line)
    };
    shader.blocks.iter().map(at).collect()
}

const SCENE: &str =
    "layout(set = 0, binding = 0, std140) uniform Scene { mat4 view; vec3 eye; float t; } scene;\n";

#[test]
fn stages_of_godot_are_read_apart() {
    let vertex = "layout(push_constant, std430) uniform Params { vec2 size; float w[3]; } params;\n\
                  struct S { vec3 a; float b; };\n\
                  layout(set = 1, binding = 0, std430) buffer Many { S all[]; } many;\n\
                  void main() { gl_Position = scene.view * vec4(params.size, params.w[1], 1.0); }\n";
    let fragment = "struct S { float a; };\n\
                    layout(set = 1, binding = 1, std140) uniform Tint { S s[2]; vec3 c; } tint;\n\
                    void main() { discard; }\n";
    let file = format!(
        "#[vertex]\n\n#version 450\n\n#VERSION_DEFINES\n\n#include \"scene_inc.glsl\"\n{vertex}\
         #[fragment]\n\n#version 450\n#VERSION_DEFINES\n#include \"scene_inc.glsl\"\n\
         #CODE : FRAGMENT\n{fragment}"
    );
    let files = [("effects/sky.glsl", file.as_str()), ("effects/scene_inc.glsl", SCENE)];
    let shader = laid_out(&files, |_| ());
    let engine = |body: &str| format!("#version 450\n{SCENE}{body}");
    assert_eq!(
        ours(&shader),
        theirs(&[("vert", &engine(vertex)), ("frag", &engine(fragment))], Client::Vulkan)
    );
    assert_eq!(
        places(&shader),
        [
            "Scene effects/scene_inc.glsl:1",
            "Params effects/sky.glsl:8",
            "Many effects/sky.glsl:10",
            "Tint effects/sky.glsl:19"
        ]
    );
    assert!(shader.blocks.iter().all(|block| block.rules_declared), "Godot compiles for Vulkan");
    // An error of the second stage stands in its own line.
    let wrong = file.replace("S s[2]", "S s[0]");
    let found = error(&laid_out(&[("sky.glsl", &wrong), ("scene_inc.glsl", SCENE)], |_| ()));
    assert_eq!((found.1.as_str(), found.0.contains("size 0")), ("sky.glsl:19", true), "{found:?}");
}

#[test]
fn a_compute_shader_of_godot_has_one_stage() {
    let body = "layout(local_size_x = 8) in;\n\
                layout(set = 0, binding = 0, std430) restrict buffer Data { uint n; vec3 at[]; } data;\n\
                void main() { data.n = 1u; }\n";
    let shader = laid_out(&[("a.glsl", &format!("#[compute]\n#version 450\n{body}"))], |_| ());
    assert_eq!(
        ours(&shader),
        theirs(&[("comp", &format!("#version 450\n{body}"))], Client::Vulkan)
    );
}

#[test]
fn modes_of_godots_compatibility_renderer_are_no_code() {
    let block = "layout(std140) uniform SceneData { mat4 m; vec3 v; float f; };\n";
    let main = "void main() { gl_Position = m * vec4(v, f); }\n";
    let file = format!(
        "#[modes]\n\nmode_default =\nmode_ninepatch = #define USE_NINEPATCH\n\n#[specializations]\n\n\
         DISABLE_LIGHTING = true\n\n#[vertex]\n\n{block}{main}#[fragment]\nvoid main() {{}}\n"
    );
    let shader = laid_out(&[("canvas.glsl", &file)], |_| ());
    let engine = format!("#version 330\n{block}{main}");
    assert_eq!(ours(&shader), theirs(&[("vert", &engine)], Client::OpenGl));
    assert_eq!(places(&shader), ["SceneData canvas.glsl:12"]);
}

#[test]
fn versions_and_stages_of_rays_of_godot_are_compiled_for_vulkan() {
    let push = "#version 460\n\
                layout(push_constant, std430) uniform Push { vec3 size; float step; vec2 at; } push;\n";
    let raygen = format!(
        "{push}#extension GL_EXT_ray_tracing : require\n\
         layout(set = 0, binding = 0, std430) buffer Rays {{ uint n; vec3 at[]; }} rays;\n\
         void main() {{ rays.at[0] = push.size; }}\n"
    );
    let miss = "#version 460\n#extension GL_EXT_ray_tracing : require\n\
                layout(set = 0, binding = 1) uniform Sky { vec3 a[2]; float b; } sky;\n\
                layout(location = 0) rayPayloadInEXT vec3 seen;\nvoid main() { seen = sky.a[1]; }\n";
    let file = format!(
        "#[versions]\n\nplain = \"\";\nlit = \"#define LIT\";\n\n#[raygen]\n{raygen}#[miss]\n{miss}"
    );
    let shader = laid_out(&[("rays.glsl", &file)], |_| ());
    assert_eq!(ours(&shader), theirs(&[("rgen", &raygen), ("rmiss", miss)], Client::Vulkan));
}

#[test]
fn retroarchs_stages_share_what_comes_first() {
    let common = "#version 450\n\
                  layout(push_constant) uniform Push { vec4 SourceSize; uint FrameCount; float G; } params;\n\
                  #pragma parameter G \"Gamma\" 2.2 1.0 3.0 0.1\n\
                  layout(std140, set = 0, binding = 0) uniform UBO { mat4 MVP; float k[3]; } global;\n";
    let vertex = "layout(location = 0) in vec4 Position;\n\
                  void main() { gl_Position = global.MVP * Position * params.G; }\n";
    let fragment = "layout(std140, set = 0, binding = 1) uniform More { vec3 a; float b; } more;\n\
                    layout(location = 0) out vec4 c;\nvoid main() { c = vec4(more.a, global.k[1]); }\n";
    let file = format!("{common}#pragma stage vertex\n{vertex}#pragma stage fragment\n{fragment}");
    let shader = laid_out(&[("crt.slang", &file)], |_| ());
    let engine = |body: &str| format!("{common}{body}");
    assert_eq!(
        ours(&shader),
        theirs(&[("vert", &engine(vertex)), ("frag", &engine(fragment))], Client::Vulkan)
    );
    assert_eq!(places(&shader), ["Push crt.slang:2", "UBO crt.slang:4", "More crt.slang:9"]);
    let slang = Source::from_bytes("a.slang", b"import scene;\nstruct S { float4 a; };\n".to_vec());
    assert!(slang.is_err_and(|error| error.message.contains("is Slang")));
}

#[test]
fn blocks_of_sokol_are_in_the_stages_that_include_them() {
    let light = "struct light { vec3 dir; float power; vec3 color; };\n";
    let vs = "layout(binding = 0) uniform vs_params { mat4 mvp; light sun; };\n\
              in vec4 position;\nvoid main() { gl_Position = mvp * position; }\n";
    let fs = "layout(binding = 1) uniform fs_params { light l[2]; vec2 off; };\n\
              layout(binding = 0) readonly buffer items { light all[]; };\n\
              out vec4 c;\nvoid main() { c = vec4(l[0].dir, all[0].power); }\n";
    let noise = "float hash(float x) { return fract(x); }\n";
    let file = format!(
        "@module demo\n@ctype mat4 hmm_mat4\n@include common.glsl\n\n@block light\n{light}@end\n\
         @block all\n@include_block light\n@end\n@block unused\nsyntax error\n@end\n\
         @vs vs\n@glsl_options flip_vert_y\n@include_block all\n{vs}@end\n\n\
         @fs fs\n@include_block light\n@include noise.glsl\n{fs}@end\n\n@program demo vs fs\n"
    );
    let files = [
        ("demo.glsl", file.as_str()),
        ("common.glsl", "@block common\nconst int N = 3;\n@end\n"),
        ("noise.glsl", noise),
    ];
    let shader = laid_out(&files, |_| ());
    let engine = |body: &str| format!("#version 450\n{light}{body}");
    let fs = engine(&format!("{noise}{fs}"));
    assert_eq!(ours(&shader), theirs(&[("vert", &engine(vs)), ("frag", &fs)], Client::Vulkan));
    assert_eq!(
        places(&shader),
        ["vs_params demo.glsl:17", "fs_params demo.glsl:25", "items demo.glsl:26"]
    );
    assert!(shader.blocks.iter().all(|block| block.rules_declared));
}

#[test]
fn imports_of_minecraft_are_found_once() {
    let core = "assets/minecraft/shaders/core/terrain.vsh";
    let text = "#version 150\n#moj_import <fog.glsl>\n#moj_import <minecraft:globals.glsl>\n\
                #moj_import <minecraft:globals.glsl>\nin vec3 Position;\n\
                layout(std140) uniform Own { mat3 m; vec2 v; };\nvoid main() { gl_Position = vec4(1.0); }\n";
    let (fog, globals) = (
        "#version 150\nlayout(std140) uniform Fog { vec4 FogColor; float FogStart; vec2 range; };\n",
        "layout(std140) uniform Globals { vec3 at; float time; int n; };\n",
    );
    let files = [
        (core, text),
        ("assets/minecraft/shaders/include/fog.glsl", fog),
        ("assets/minecraft/shaders/include/globals.glsl", globals),
    ];
    let shader = laid_out(&files, |_| ());
    // The game's importer leaves out the version of an import.
    let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
    let fog = fog.split_once('\n').expect("two lines").1;
    // 330 stands for 150, which SPIR-V does not have.
    let engine = format!("#version 330\n{fog}{globals}{}", lines.join("\n"));
    assert_eq!(ours(&shader), theirs(&[("vert", &engine)], Client::OpenGl));
    assert_eq!(places(&shader)[0], "Fog assets/minecraft/shaders/include/fog.glsl:2");
}

#[test]
fn includes_from_a_root_are_found_above() {
    let block = "layout(std140, binding = 0) uniform Pack { vec3 a; float b[2]; };\n";
    let main = "void main() {}\n";
    let text = format!(
        "#version 330 core\n#extension GL_ARB_shading_language_420pack : enable\n#include \"/lib/uniforms.glsl\"\n{main}"
    );
    let files = [
        ("pack/shaders/world0/gbuffers.fsh", text.as_str()),
        ("pack/shaders/lib/uniforms.glsl", "#include \"/lib/inner.glsl\"\n"),
        ("pack/shaders/lib/inner.glsl", block),
    ];
    let engine = format!("#version 450\n{block}{main}");
    let shader = laid_out(&files, |_| ());
    assert_eq!(ours(&shader), theirs(&[("frag", &engine)], Client::OpenGl));
}

#[test]
fn a_missing_include_names_the_folder_that_has_it() {
    let root = std::env::temp_dir().join(format!("landfall-dialects-{}", std::process::id()));
    for (path, text) in [
        (".git/HEAD", ""),
        ("shaders/a.frag", "#version 450\n#include \"lib/x.glsl\"\n#include \"no.glsl\"\n"),
        ("engine/lib/x.glsl", "const int N = 3;\n"),
    ] {
        let path = root.join(path);
        std::fs::create_dir_all(path.parent().expect("below the root")).expect("created");
        std::fs::write(path, text).expect("written");
    }
    let source = Source::read(root.join("shaders/a.frag")).expect("it is there");
    let shader = layout(&source, &Options::default());
    let helps: Vec<&str> =
        shader.diagnostics.iter().filter_map(|found| found.help.as_deref()).collect();
    let folder = format!("pass `-I {}`", root.join("engine").display());
    assert_eq!(helps, [folder.as_str(), "pass its directory with `-I DIR`"]);
    std::fs::remove_dir_all(root).expect("removed");
}

#[test]
fn chunks_of_three_js_are_read_from_their_folder() {
    let common = "layout(std140) uniform Camera { mat3 m; vec3 at; };\n";
    let fog = "layout(std140) uniform Fog { float near; vec3 color; };\n";
    let main = "out highp vec4 c;\nvoid main() { c = vec4(at, near); }\n";
    let version = "#version 330\n";
    let text = format!("{version}#include <common>\n#include <fog_pars>\n{main}");
    let js = format!("export default /* glsl */`\n{fog}`;\n");
    let files = [
        ("src/ShaderLib/mine.frag", text.as_str()),
        ("src/ShaderChunk/common.glsl", common),
        ("src/ShaderChunk/fog_pars.glsl.js", js.as_str()),
    ];
    let engine = format!("{version}{common}{fog}{main}");
    let theirs = theirs(&[("frag", &engine)], Client::OpenGl);
    let shader = laid_out(&files, |_| ());
    assert_eq!(ours(&shader), theirs);
    assert_eq!(places(&shader)[1], "Fog src/ShaderChunk/fog_pars.glsl.js:2");
    // A folder that `-I` names.
    let files = [
        ("mine.frag", text.as_str()),
        ("vendor/chunks/common.glsl", common),
        ("vendor/chunks/fog_pars.glsl.js", js.as_str()),
    ];
    let shader =
        laid_out(&files, |options| options.read.include_dirs = vec!["vendor/chunks".into()]);
    assert_eq!(ours(&shader), theirs);
}

#[test]
fn preludes_come_before_the_text_of_their_language() {
    let text = "layout(std140) uniform U { S s; float a[COUNT]; };\nvoid main() { gl_Position = vec4(1.0); }\n";
    let (version, head) = ("#version 330\n#define COUNT 3\n", "struct S { vec3 v; };\n");
    let files =
        [("a.vert", text), ("head.glsl", version), ("types.glsl", head), ("x.wgsl", "struct")];
    let shader = laid_out(&files, |options| {
        options.read.preludes = vec!["head.glsl".into(), "x.wgsl".into(), "types.glsl".into()];
    });
    let engine = format!("{version}{head}{text}");
    assert_eq!(ours(&shader), theirs(&[("vert", &engine)], Client::OpenGl));
    assert_eq!(places(&shader), ["U a.vert:1"]);
    let wgsl = [("a.wgsl", "var<private> x: f32;"), ("head.glsl", version)];
    let shader = laid_out(&wgsl, |options| options.read.preludes = vec!["head.glsl".into()]);
    assert!(!shader.has_errors(), "{:#?}", shader.diagnostics);
}

// --- Structures without a block ---

#[test]
fn a_structure_is_laid_out_by_each_rules() {
    let types = "struct Inner { vec2 a; float b; };\n\
                 struct Light { vec3 at; float w[3]; mat2 m; Inner inner; float last; };\n";
    let text = format!("#version 450\n{types}void main() {{}}\n");
    let shader = laid_out(&[("types.frag", &text)], |options| {
        options.read.structure = Some("Light".into());
    });
    assert!(!shader.has_errors(), "{:#?}", shader.diagnostics);
    let rules: Vec<&str> = shader.blocks.iter().map(|block| block.rules.name()).collect();
    assert_eq!(rules, ["std140", "std430", "scalar"]);
    for block in &shader.blocks {
        // The structure as the element of a block: its offsets, and its size as the stride.
        let wrapped = format!(
            "#version 450\n#extension GL_EXT_scalar_block_layout : enable\n{types}\
             layout({}, binding = 0) buffer B {{ Light x[2]; }};\nvoid main() {{}}\n",
            block.rules.name()
        );
        let options = glslang::Options::unlisted();
        let oracle = glslang::blocks(&wrapped, "frag", &options).expect("glslang takes it");
        let theirs: Vec<(String, u64)> = oracle[0]
            .leaves
            .iter()
            .map(|leaf| (leaf.path.replacen("x[].", "", 1), leaf.offset))
            .collect();
        let ours: Vec<(String, u64)> = block
            .leaves
            .iter()
            .map(|leaf| (leaf.path.clone(), leaf.offset.expect("it has one")))
            .collect();
        assert_eq!(ours, theirs, "{}", block.rules.name());
        let stride = oracle[0].leaves[0].strides[0];
        if block.rules.name() != "scalar" {
            assert_eq!(block.size, stride, "{}", block.rules.name());
        }
    }
    let one = laid_out(&[("types.frag", &text)], |options| {
        options.read.structure = Some("Inner".into());
        options.rules = Some(landfall_layout::Rules::Std430);
    });
    assert_eq!(one.blocks.len(), 1);
    let none = laid_out(&[("types.frag", &text)], |options| {
        options.read.structure = Some("Lihgt".into());
    });
    let found = error(&none);
    assert_eq!(found.0, "no structure named `Lihgt`");
    assert_eq!(found.2, "did you mean `Light`?");
}

#[test]
fn a_structure_of_an_imported_module_is_found_by_name_and_path() {
    let files = [
        ("game/main.wesl", "import package::types::Light as Lamp;\nstruct Light { x: f32 }\n"),
        (
            "game/types.wesl",
            "struct Light { @size(32) at: vec3f, power: f32 }\nstruct Other { a: u32 }\n",
        ),
    ];
    let structure = |name: &str| {
        let shader = laid_out(&files, |options| options.read.structure = Some(name.into()));
        assert!(!shader.has_errors(), "{name}: {:#?}", shader.diagnostics);
        let block = &shader.blocks[0];
        let at = shader.files.locate(block.members[0].span);
        (block.size.expect("it has a size"), format!("{}:{}", at.path, at.line))
    };
    // WGSL 14.4.1: the last member ends at 36, the alignment is 16.
    assert_eq!(structure("Lamp"), (48, "game/types.wesl:1".to_string()));
    assert_eq!(structure("Light"), (4, "game/main.wesl:2".to_string()));
    assert_eq!(structure("package::types::Light"), (48, "game/types.wesl:1".to_string()));
    assert_eq!(structure("package::types::Other"), (4, "game/types.wesl:2".to_string()));
    let shader = laid_out(&files, |options| options.read.structure = Some("Lamb".into()));
    assert_eq!(error(&shader).0, "no structure named `Lamb`");
}

#[test]
fn an_unknown_type_names_the_file_beside_that_declares_it() {
    let files = [
        ("shaders/draw.wgsl", "@group(0) @binding(0) var<uniform> t: Transforms;\n"),
        ("shaders/common.wgsl", "// Transforms\nstruct Transforms { view: mat4x4f }\n"),
        ("shaders/another.wgsl", "// No Transforms.\nvar<private> Transforms: f32;\n"),
        ("elsewhere/a.wgsl", "struct Transforms { x: f32 }\n"),
    ];
    let found = error(&laid_out(&files, |_| ()));
    assert_eq!(found.0, "unknown type `Transforms`");
    assert!(
        found.2.starts_with("`shaders/common.wgsl` declares it: pass `--prelude"),
        "{}",
        found.2
    );
    let shader = laid_out(&files, |options| {
        options.read.preludes = vec!["shaders/common.wgsl".into()];
    });
    assert_eq!(shader.blocks[0].size, Some(64));
}

/// A file of Godot with two stages, of which each has a function of its own.
const TWO_STAGES: &str = "#[vertex]\n#version 450\nlayout(location = 0) out float far;\n\
    float half_of(float x) { return x * 0.5; }\n\
    void main() { far = half_of(4.0); gl_Position = vec4(far); }\n\
    #[fragment]\n#version 450\nlayout(location = 0) in float far;\n\
    layout(location = 0) out vec4 color;\n\
    float third_of(float x) { return x / 3.0; }\n\
    void main() { color = vec4(third_of(far)); if (far < 0.0) discard; }\n";

/// The errors in function bodies, and those that glslang finds in each stage.
fn body_errors(text: &str) -> (Vec<String>, usize) {
    let options = Options::default();
    let found = landfall_layout::syntax::body_errors(&Source::new("two.glsl", text), &options.read);
    let (vertex, fragment) = text.split_once("#[fragment]\n").expect("two stages");
    let vertex = vertex.trim_start_matches("#[vertex]\n");
    let refused =
        [(vertex, "vert"), (fragment, "frag")].into_iter().filter(|(t, s)| !glslang::accepts(t, s));
    (found.errors.into_iter().map(|found| found.message).collect(), refused.count())
}

#[test]
fn bodies_of_every_stage_are_checked() {
    assert_eq!(body_errors(TWO_STAGES), (Vec::new(), 0));
    for (name, stages) in [("half_of(4.0)", 1), ("third_of(far)", 1)] {
        let broken = TWO_STAGES.replace(name, "unknown_name");
        let (found, refused) = body_errors(&broken);
        assert_eq!((found.len(), refused), (stages, stages), "{found:?}");
        assert!(found[0].contains("unknown_name"), "{found:?}");
    }
    let both = TWO_STAGES.replace("half_of(4.0)", "a_name").replace("third_of(far)", "b_name");
    let (found, refused) = body_errors(&both);
    assert_eq!((found.len(), refused), (2, 2), "{found:?}");
}

/// The stage of a source is the one whose bodies are parsed.
#[test]
fn the_stage_of_a_source_is_read_of_a_file_with_several() {
    let broken = TWO_STAGES.replace("third_of(far)", "third_of(far");
    let error = |stage| {
        let source = Source { stage, ..Source::new("two.glsl", broken.as_str()) };
        landfall_layout::syntax::syntax_error(&source, &Options::default().read).is_some()
    };
    assert_eq!([None, Some(Stage::Vertex), Some(Stage::Fragment)].map(error), [false, false, true]);
}
