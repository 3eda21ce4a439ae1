//! Shaders become runnable modules: naga IR that its validator takes, with landfall's offsets.
//!
//! The numbers a module's memory has are read from the SPIR-V that naga writes of it, by the
//! backend the other oracles use; `spirv-val` (Debian package `spirv-tools`) says whether it is
//! legal. That the right values come out is proven by running it.

use crate::support;

use landfall_ir::Module;
use landfall_ir::module::{Direction, HandleKind};
use landfall_layout::{Diagnostic, Options, Source, Stage};
use support::files::shaders;

fn module(path: &str, text: &str) -> Result<Module, Vec<Diagnostic>> {
    Module::new(&Source::new(path, text), &Options::default())
}

/// A module of a text that has to run.
fn runs(path: &str, text: &str) -> Module {
    module(path, text).unwrap_or_else(|why| panic!("{why:#?}\n{text}"))
}

/// A fragment shader around some statements.
fn fragment(outside: &str, inside: &str) -> Module {
    let text = format!(
        "#version 450\nlayout(location = 0) out vec4 color;\n{outside}\nvoid main() {{ {inside} }}"
    );
    runs("a.frag", &text)
}

/// The one thing that keeps a text from running.
fn refused(path: &str, text: &str) -> Diagnostic {
    let mut why = module(path, text).expect_err("it cannot run");
    why.swap_remove(0)
}

#[test]
fn every_shader_of_the_repository_runs_but_those_naga_has_no_types_for() {
    // 8-bit numbers, and addresses: naga's IR has neither.
    let without = ["small_and_large_scalars.comp", "buffer_reference.comp"];
    for path in shaders() {
        let name = path.file_name().unwrap().to_str().unwrap();
        let source = Source::read(&path).unwrap();
        let mut options = Options::default();
        options.read.include_dirs.push("shaders/include".into());
        match Module::new(&source, &options) {
            Ok(module) => {
                assert!(!without.contains(&name), "{name} runs now");
                assert!(module.left_out().is_empty(), "{name}: {:#?}", module.left_out());
            }
            Err(why) => assert!(without.contains(&name), "{name}: {why:#?}"),
        }
    }
}

#[cfg(feature = "gpu")]
mod written {
    use super::*;
    use std::io::Write as _;
    use std::process::{Command, Stdio};
    use support::blocks::{Block, Standing, print};
    use support::generate::{COMMON, VULKAN, random};
    use support::leaf::{OracleBlock, What, differences};
    use support::{landfall as ours, spirv};

    fn validate(words: &[u32], of: &str) {
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        let mut child = Command::new("spirv-val")
            .args(["--target-env", "vulkan1.2", "-"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("spirv-val, of the Debian package spirv-tools");
        child.stdin.take().unwrap().write_all(&bytes).unwrap();
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned()
            + &String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{of}: {said}");
    }

    #[test]
    fn what_naga_writes_of_the_repository_is_legal() {
        for path in shaders() {
            let source = Source::read(&path).unwrap();
            let mut options = Options::default();
            options.read.include_dirs.push("shaders/include".into());
            let Ok(module) = Module::new(&source, &options) else { continue };
            if module.entry_points().is_empty() {
                continue; // Vulkan has no libraries
            }
            validate(&module.spirv().unwrap(), &path.display().to_string());
        }
    }

    /// The members that naga carries as they are: no bool, no matrix by rows.
    fn plain(blocks: &mut Vec<OracleBlock>) {
        for block in blocks {
            block.leaves.retain(|leaf| {
                let carried = leaf.ty.contains("bool") || leaf.ty.starts_with("bvec");
                !carried && !leaf.ty.contains("mat")
            });
        }
    }

    /// Random blocks of every kind become modules, and those that are not words have every
    /// scalar and vector where landfall says. Gives how many cannot run.
    fn agree(batch: (Vec<Standing>, Vec<Block>), target: landfall_layout::Target) -> usize {
        let (standing, blocks) = batch;
        let mut refused = 0;
        for block in &blocks {
            let text = print(&standing, &[block]);
            let mut options = Options::default();
            options.read.target = Some(target);
            let made = match Module::new(&Source::new("a.comp", text.as_str()), &options) {
                Ok(made) => made,
                // Doubles cannot be words, and naga has no 8-bit numbers and no addresses.
                Err(why) => {
                    let without = [
                        "naga cannot represent the layout",
                        "unsupported type",
                        "naga does not support",
                        "not supported by naga",
                    ];
                    let known = |d: &Diagnostic| without.iter().any(|w| d.message.contains(w));
                    assert!(why.iter().all(known), "{why:#?}\n{text}");
                    refused += 1;
                    continue;
                }
            };
            let words = made.spirv().unwrap();
            let mut theirs = spirv::blocks(&words).unwrap();
            theirs.retain(|t| t.leaves.iter().all(|leaf| !leaf.path.starts_with("words")));
            let mut own = ours::glsl_blocks(&text, target);
            own.retain(|o| theirs.iter().any(|t| t.name == o.name));
            plain(&mut own);
            plain(&mut theirs);
            let mut found = differences(&own, &theirs);
            found.retain(|difference| {
                matches!(difference.what, What::Offset | What::Dims | What::Stride(_))
            });
            assert!(found.is_empty(), "{found:#?}\n{text}");
        }
        refused
    }

    #[test]
    fn random_blocks_have_their_members_where_the_layout_says() {
        for seed in 0..4 {
            assert_eq!(agree(random(seed, 40, &COMMON), landfall_layout::Target::OpenGl), 0);
        }
        // Half of these have 8-bit numbers or addresses.
        assert!(agree(random(7, 40, &VULKAN), landfall_layout::Target::Vulkan) < 30);
    }
}

#[test]
fn loose_uniforms_become_one_block_and_samplers_a_texture_and_a_sampler() {
    let text = "#version 330
        struct Material { sampler2D diffuse; vec3 tint; };
        uniform Material materials[2];
        uniform float exposure;
        in vec2 uv;
        out vec4 color;
        void main() { color = texture(materials[1].diffuse, uv) * exposure + vec4(materials[0].tint, 1); }";
    let module = runs("a.frag", text);
    let [block] = module.blocks() else { panic!("{:?}", module.blocks()) };
    assert_eq!(&*block.layout.name, "DefaultBlock");
    let handles: Vec<_> = module.handles().iter().map(|h| (h.path.as_str(), h.kind)).collect();
    assert_eq!(
        handles,
        [
            ("materials[0].diffuse", HandleKind::Texture),
            ("materials[0].diffuse", HandleKind::Sampler),
            ("materials[1].diffuse", HandleKind::Texture),
            ("materials[1].diffuse", HandleKind::Sampler),
        ]
    );
    let mut places: Vec<_> = module.handles().iter().map(|h| (h.group, h.binding)).collect();
    places.push((block.group, block.binding));
    places.sort();
    places.dedup();
    assert_eq!(places.len(), 5, "no two share a binding");
}

#[test]
fn the_bindings_of_the_text_are_kept_and_given_to_nobody_else() {
    let text = "#version 450
        layout(std140) uniform A { vec4 a; };
        layout(std140, binding = 0) uniform B { vec4 b; };
        layout(std140, binding = 2) uniform C { vec4 c; } cs[2];
        layout(binding = 2) uniform sampler2D map;
        layout(location = 0) out vec4 color;
        void main() { color = a + b + cs[1].c + texture(map, a.xy); }";
    let module = runs("a.frag", text);
    let places: Vec<_> =
        module.blocks().iter().map(|b| (b.layout.name.to_string(), b.element, b.binding)).collect();
    assert_eq!(places[0], ("A".to_string(), None, 1));
    assert_eq!(places[1], ("B".to_string(), None, 0));
    assert_eq!(places[2], ("C".to_string(), Some(0), 2));
    assert_eq!(places[3], ("C".to_string(), Some(1), 3));
    let map = module.handles().iter().map(|h| h.binding).collect::<Vec<_>>();
    assert_eq!(map, [4, 5], "OpenGL's textures have bindings of their own");
}

#[test]
fn old_shaders_run_as_they_are() {
    runs(
        "a.vert",
        "attribute vec4 position; varying vec2 uv; uniform mat4 mvp;
         void main() { uv = gl_MultiTexCoord0.xy; gl_Position = mvp * position + gl_Vertex; }",
    );
    runs(
        "a.frag",
        "#version 100
         precision mediump float; varying lowp vec2 uv; uniform sampler2D map; uniform samplerCube sky;
         void main() {
             gl_FragColor = texture2D(map, uv, 0.5) * textureCube(sky, vec3(uv, 1.0))
                 + texture2DProj(map, vec3(uv, 2.0));
         }",
    );
    runs("a.frag", "#version 120\nvoid main() { gl_FragData[1] = gl_FragCoord; }");
}

#[test]
fn functions_without_a_main_are_a_module_and_are_described() {
    let module = runs(
        "lights.frag",
        "#version 330
         struct Light { vec3 pos; float range; };
         float attenuate(in Light light, vec3 at, out float left[2], inout int count);
         float attenuate(in Light light, vec3 at, out float left[2], inout int count) {
             left[0] = left[1] = distance(light.pos, at) / light.range; count++; return left[0];
         }",
    );
    assert!(module.entry_points().is_empty());
    let [function] = module.functions() else { panic!("{:?}", module.functions()) };
    let parameters: Vec<_> =
        function.parameters.iter().map(|p| (p.name.as_str(), p.ty.as_str(), p.direction)).collect();
    assert_eq!(
        parameters,
        [
            ("light", "Light", Direction::In),
            ("at", "vec3", Direction::In),
            ("left", "float[2]", Direction::Out),
            ("count", "int", Direction::InOut),
        ]
    );
    assert_eq!(function.returns.as_deref(), Some("float"));
    assert_eq!(module.files().locate(function.span).line, 4);
}

#[test]
fn a_function_that_cannot_run_is_left_out_when_nobody_calls_it() {
    let module = runs(
        "a.frag",
        "#version 450
         layout(location = 0) out vec4 color;
         float odd(float x) { return noise1(x); }
         void main() { color = vec4(1); }",
    );
    assert_eq!(module.functions().len(), 1);
    assert_eq!(module.left_out()[0].why.message, "`noise1` is not supported by naga");
}

#[test]
fn names_shadow_and_members_of_named_blocks_do_not_leak() {
    // naga 30.0.1 reads `blk.pos` for the input `pos`.
    let module = fragment(
        "layout(location = 0) in vec2 pos;
         layout(std140, binding = 0) uniform B { vec4 pad; vec3 pos; } blk;
         float pad(float pad) { return pad; }",
        "vec2 p = pos; { vec3 pos = blk.pos; p += pos.xy; } float color2 = pad(p.x); color = vec4(color2);",
    );
    assert_eq!(module.inputs().len(), 1);
}

#[test]
fn inputs_and_outputs_are_taken_apart_into_locations() {
    let module = runs(
        "a.vert",
        "#version 330
         layout(location = 1) in mat4 world; in vec3 position; in float weights[2];
         struct Surface { vec3 normal; mat2 basis; };
         out Surface surface; flat out ivec2 id; out Block { vec2 uv; } block;
         void main() {
             surface = Surface(position, mat2(1)); id = ivec2(gl_VertexID); block.uv = vec2(weights[1]);
             gl_Position = world * vec4(position, 1);
         }",
    );
    let inputs: Vec<_> = module.inputs().iter().map(|i| (i.name.as_str(), i.location)).collect();
    assert_eq!(
        inputs,
        [
            ("world[0]", 1),
            ("world[1]", 2),
            ("world[2]", 3),
            ("world[3]", 4),
            ("position", 0),
            ("weights[0]", 5),
            ("weights[1]", 6),
        ]
    );
    let outputs: Vec<_> = module.outputs().iter().map(|o| o.name.as_str()).collect();
    assert_eq!(
        outputs,
        ["surface.normal", "surface.basis[0]", "surface.basis[1]", "id", "Block.uv"]
    );
}

#[test]
fn samplers_go_through_parameters_arrays_and_variable_indices() {
    fragment(
        "uniform sampler2D maps[3]; uniform sampler2DShadow shadow; uniform usampler2D ids;
         uniform int which;
         vec4 twice(sampler2D map, vec2 uv) { return texture(map, uv) + textureLod(map, uv, 1.0); }
         float lit(sampler2DShadow map, vec3 at) { return texture(map, at); }",
        "color = twice(maps[1], vec2(0)) + twice(maps[which], vec2(1)) + texture(maps[which], vec2(1));
         color += lit(shadow, vec3(1)) + vec4(texture(ids, vec2(0.5)));
         color += texelFetch(maps[0], ivec2(1), 0) + vec4(textureSize(maps[2], 0), 0, 0);",
    );
}

#[test]
fn separate_textures_samplers_and_images_run() {
    fragment(
        "layout(set = 0, binding = 0) uniform texture2D map; layout(set = 0, binding = 1) uniform sampler samp;
         layout(set = 1, binding = 0, rgba8) uniform image2D img; layout(set = 1, binding = 1) uniform texture2D many[];
         layout(set = 2, binding = 0, input_attachment_index = 0) uniform subpassInput att;",
        "color = texture(sampler2D(map, samp), vec2(0)) + imageLoad(img, ivec2(0)) + subpassLoad(att);
         int i = int(color.x); color += texture(sampler2D(many[i], samp), vec2(0));
         imageStore(img, ivec2(1), color);",
    );
}

#[test]
fn what_naga_cannot_place_is_carried_all_the_same() {
    let module = runs(
        "a.comp",
        "#version 450
         #extension GL_EXT_scalar_block_layout : require
         layout(local_size_x = 4) in;
         struct S { vec3 a; float b; mat2 m; bool on; };
         layout(std140, binding = 0) uniform U { float x; S s[2]; mat3x2 n; layout(row_major) mat4x3 r; } u;
         layout(scalar, binding = 1) uniform V { float x; vec3 tight; S s[2]; mat3 n; } v;
         layout(std430, binding = 2) buffer W { S s; layout(row_major) mat2x3 r; bvec2 flags; S tail[]; } w;
         layout(push_constant) uniform P { vec2 g; float a[3]; } p;
         void main() {
             int i = int(u.x);
             S copy[2] = u.s; copy[i] = v.s[i]; w.s = copy[1]; w.tail[i] = w.s;
             w.r[i] = (u.r * vec4(p.a[i])).xyz + v.n[i] + v.tight; w.r[0][i] = u.n[2].y;
             w.flags = bvec2(w.s.on, u.s[i].on); w.flags[i] = w.tail.length() > 3;
         }",
    );
    assert_eq!(module.entry_points()[0].workgroup_size, [4, 1, 1]);
    assert_eq!(module.entry_points()[0].stage, Stage::Compute);
}

#[test]
fn the_language_runs() {
    fragment(
        "#define SQUARE(x) ((x) * (x))
         const int N = 2 + 1; const float W[N] = float[](1.0, 2.0, 3.0); const vec3 C = vec3(N) * 2.0;
         float state = C.x; bool step1() { state += 1.0; return state > 3.0; }
         void swap(inout float a, inout float b) { float t = a; a = b; b = t; }",
        "vec4 v = vec4(1, 2u, 3.0, W[N - 1]); swap(v.x, v[2]); v.zy = v.yz; v.w++; --v.x;
         int a = 7, b[2] = int[2](1, 2); a <<= 1; a %= 5; a ^= b[a & 1];
         for (int i = 0, j = 9; i < j; i++, j--) { if (i == 2) continue; if (step1() && j < 4 || i > 7) break; v.x += float(j); }
         do { a--; } while (a > 0);
         switch (a) { case 0: case 1: v.y = 1.0; case 2: v.y += SQUARE(2.0); break; default: discard; }
         mat3 m = mat3(mat2(1, 2, 3, 4)); m[a][1] = 5.0; m = -m / 2.0 + m * inverse(m);
         float whole; float f = modf(v.x, whole); int e; f += frexp(f, e) + mod(f, 2.0);
         color = a > 0 ? v : (v = v.wzyx, v * 2.0); color.rgb *= m; color += mix(v, color, lessThan(v, color));",
    );
}

#[test]
fn what_cannot_run_is_named_with_its_place() {
    let geometry =
        "#version 330\nlayout(points) in; layout(points, max_vertices = 1) out; void main() {}";
    assert_eq!(refused("a.geom", geometry).message, "geometry shaders are not supported");
    let head = "#version 450\nlayout(location = 0) out vec4 color;\n";
    for (text, message) in [
        (
            "float f(float x) { return f(x); } void main() { color = vec4(f(1)); }",
            "`f` calls itself",
        ),
        (
            "float f(float x); void main() { color = vec4(f(1)); }",
            "`f` is declared but not defined",
        ),
        ("void main() { color = vec4(colour); }", "there is no variable `colour`"),
        ("void main() { color[4] = 1.0; }", "index 4 is past the end of `vec4`"),
        (
            "void main() { color = gl_ModelViewMatrix[0]; }",
            "`gl_ModelViewMatrix` is state of the fixed-function pipeline, which is not supported",
        ),
        ("void main() { color = vec4(1) }", "expected `;`, found `}`"),
    ] {
        let found = refused("a.frag", &format!("{head}{text}"));
        assert_eq!(found.message, message);
        assert!(found.labels[0].at.start >= head.len() as u32, "{found:?}");
    }
}

#[test]
fn hostile_texts_get_one_clear_error() {
    let head = "#version 450\nlayout(location = 0) out vec4 color;\n";
    let many = 20_000;
    for inside in [
        format!("color = vec4({}1.0{});", "(".repeat(many), ")".repeat(many)),
        format!("color = vec4({}1.0);", "1.0 + ".repeat(many)),
        format!("color = vec4({}1.0);", "- ".repeat(many)),
        format!("{}{}", "{".repeat(many), "}".repeat(many)),
        format!("{} color.x = 1.0;", "if (color.x > 1.0) color.y = 1.0; else ".repeat(many)),
        format!("color{} = 1.0;", "[0]".repeat(many)),
        format!("{}1.0;", "color.x = ".repeat(many)),
        "float a[1000000000]; a[0] = 1.0;".to_string(),
    ] {
        let text = format!("{head}void main() {{ {inside} }}");
        let why = module("a.frag", &text).unwrap_err();
        assert_eq!(why.len(), 1);
    }
    let mut chain = String::from(head);
    for i in 0..many {
        chain.push_str(&format!(
            "float f{}(float x); float f{i}(float x) {{ return f{}(x); }}\n",
            i + 1,
            i + 1
        ));
    }
    assert!(module("a.frag", &format!("{chain}void main() {{ color = vec4(f0(1)); }}")).is_err());
}

#[test]
fn wgsl_has_the_offsets_that_naga_forgets() {
    // naga 30.0.1 aligns `inner` to 4, not to 16 (gfx-rs/wgpu#4377).
    let text = "struct Inner { @align(16) a: u32 }
        struct Outer { x: u32, inner: Inner, y: array<Inner, 2> }
        @group(1) @binding(3) var<storage, read_write> block: Outer;
        fn twice(x: u32) -> u32 { return 2 * x; }
        @compute @workgroup_size(2) fn main() { block.x = twice(block.inner.a) + block.y[1].a; }";
    let module = runs("a.wgsl", text);
    assert_eq!((module.blocks()[0].group, module.blocks()[0].binding), (1, 3));
    assert_eq!(module.blocks()[0].layout.members[1].offset, Some(16));
    assert_eq!(module.functions()[0].returns.as_deref(), Some("u32"));
    #[cfg(feature = "gpu")]
    {
        let offsets = |module: &Module| {
            let blocks = support::spirv::blocks(&module.spirv().unwrap()).unwrap();
            blocks[0].leaves.iter().map(|leaf| leaf.offset).collect::<Vec<_>>()
        };
        assert_eq!(offsets(&module), [0, 16, 32]);
        let naga = Module::by_naga(&Source::new("a.wgsl", text), &Options::default()).unwrap();
        assert_ne!(offsets(&naga), [0, 16, 32], "mended: take it out of the list of faults");
    }
}

#[test]
fn naga_itself_is_to_be_had_unpatched() {
    let text = "#version 450
        layout(std140, binding = 0) uniform B { float f[2][3]; };
        layout(location = 0) out vec4 color;
        void main() { color = vec4(f[1][1]); }";
    let source = Source::new("a.frag", text);
    assert!(Module::by_naga(&source, &Options::default()).is_ok());
    let old = Source::new("a.frag", "#version 330\nvoid main() {}");
    let why = Module::by_naga(&old, &Options::default()).unwrap_err();
    assert!(why[0].message.starts_with("naga: "), "{why:?}");
    let hostile = format!("#version 450\nvoid main() {{ {} }}", "{".repeat(10_000));
    let hostile = Source::new("a.frag", hostile.as_str());
    assert!(Module::by_naga(&hostile, &Options::default()).is_err());
}

#[test]
fn constant_expressions_size_blocks_and_local_arrays_alike() {
    // GLSL 4.60 §4.3.3: built-in functions of constants are constants.
    for (outside, size, elements) in [
        ("", "int(clamp(5., 0., 3.))", 3),
        ("", "int(mod(7., 4.))", 3),
        ("", "int(pow(2., 3.))", 8),
        ("", "int(dot(vec2(1., 2.), vec2(1., 1.)))", 3),
        ("", "int((vec2(1., 2.) + vec2(2.)).x)", 3),
        ("", "(ivec2(1, 2) * 3).y", 6),
        ("", "int(round(2.6) + sign(-2.) + step(1., 2.))", 3),
        ("", "int(trunc(3.9))", 3),
        ("", "int(fract(2.75) * exp2(2.))", 3),
        ("", "2 << 1u", 4),
        ("const float F = 1.5 * 2.0;", "int(F)", 3),
        ("const vec2 V = vec2(2.0, 3.0);", "int(V.y)", 3),
        ("const bool B = any(bvec2(false, true));", "B ? 3 : 1", 3),
        ("const int N = 0;", "N == 0 ? 3 : 8 / N", 3),
        ("const int64_t L = 3L;", "int(L)", 3),
    ] {
        let text = |at: u32| {
            format!(
                "#version 450\n#extension GL_ARB_gpu_shader_int64 : require\n\
                 layout(location = 0) out vec4 color;\n{outside}\n\
                 layout(std140) uniform U {{ float a[{size}]; }};\n\
                 void main() {{ float l[{size}]; l[{at}] = a[0]; color = vec4(l[{at}]); }}\n"
            )
        };
        let module = runs("a.frag", &text(elements - 1));
        assert_eq!(
            module.blocks()[0].layout.size,
            Some(16 * u64::from(elements)),
            "{outside} {size}"
        );
        let past = refused("a.frag", &text(elements)).message;
        assert!(past.contains(&format!("index {elements} is past the end")), "{size}: {past}");
    }
}
