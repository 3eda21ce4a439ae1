//! Shaders rewritten to read lists of lights: the same bits as the loops they replace, on every
//! backend.

use landfall_exec::backend::BackendKind;
use landfall_interp::Cpu;
use landfall_layout::{Options, ReadOptions, Source};
use landfall_light::bind::Kind;
use landfall_light::culling::{self, Plan};
use landfall_light::listed::listed;
use landfall_light::render::truth::likely_model;
use landfall_light::render::{Rendered, Renderer, Work};
use landfall_light::shading_f32::Model;

use crate::light_scenes::{SCENES, generated};
use crate::made::{Made, bits, renderer, source};
use crate::support::backends::with_readers;
use crate::support::command::Place;
use crate::support::glslang;
use crate::support::sample::everything;

/// The kinds that lists are read for, and a renderer of the text that reads them.
fn rewritten(source: &Source, whole: &Renderer) -> (Vec<Kind>, Renderer, Source) {
    let made = listed(source, &ReadOptions::default(), &whole.shader, &whole.map);
    let made = made.unwrap_or_else(|why| panic!("{}: {why}", source.path));
    (made.kinds, renderer(&made.source), made.source)
}

fn model(renderer: &Renderer) -> Model {
    Model::new(&likely_model(&renderer.map)).expect("a compiled model")
}

/// A plan whose lists are set.
fn plan(renderer: &Renderer, work: &Work<'_>, model: &Model, parts: &str) -> Plan {
    let mut plan = renderer.plan(work, model, &culling::parse(parts).expect(parts));
    plan.tiles = Some(plan.tile_lists(work.frame.height).expect("tiles have lists"));
    plan
}

/// The largest difference of two pictures in steps.
fn apart(a: &Rendered, b: &Rendered) -> f64 {
    let pairs = a.picture.pixels.iter().flatten().zip(b.picture.pixels.iter().flatten());
    pairs.map(|(a, b)| (f64::from(*a) - f64::from(*b)).abs() * 255.0).fold(0.0, f64::max)
}

const ALL: [Kind; 3] = Kind::ALL;

/// Shaders with arrays of lights, and the kinds of them.
const SHADERS: [(&str, &[Kind]); 10] = [
    ("many_lights/windowed.wgsl", &ALL),
    ("many_lights/windowed_450.frag", &ALL),
    ("many_lights/windowed_330.frag", &ALL),
    ("many_lights/plain.wgsl", &ALL),
    ("many_lights/plain_450.frag", &ALL),
    ("light_arrays/lights.wgsl", &[Kind::Directional, Kind::Point]),
    ("light_arrays/all_lights_450.frag", &[Kind::Directional, Kind::Point]),
    ("light_arrays/all_lights_330.frag", &[Kind::Directional, Kind::Point]),
    ("six_lights/phong_330.frag", &[Kind::Point]),
    ("six_lights/phong_300es.frag", &[Kind::Point]),
];

/// A scene with lights of all kinds that end, for a shader: some reach few tiles, a sun lights
/// nothing that faces the camera.
fn all_kinds(shader: &str) -> Made {
    // The others do not end their lights, which their plan would.
    let (mut scene, _) = generated(1, shader.contains("windowed"));
    if shader.starts_with("light_arrays") || shader.starts_with("six_lights") {
        scene.lights.spot.truncate(1);
        scene.lights.point.truncate(4);
    }
    if shader.starts_with("six_lights") {
        // What the shader has slots for.
        scene.lights.directional.truncate(1);
    } else {
        if shader.starts_with("light_arrays") {
            scene.lights.spot.clear();
        }
        let mut below = scene.lights.directional[0];
        below.direction = glam::DVec3::new(0.1, 1.0, 0.05).normalize();
        scene.lights.directional.insert(0, below);
    }
    Made::of(scene)
}

#[test]
fn lists_give_the_bits_of_the_loops_on_every_backend() {
    for (name, kinds) in SHADERS {
        let source = source(name);
        let all = renderer(&source);
        let (read, lists, _) = rewritten(&source, &all);
        assert_eq!(read, kinds, "{name}");
        assert!(kinds.iter().all(|kind| lists.lists(*kind)), "{name}");
        let made = all_kinds(name);
        let (work, model) = (made.work(), model(&all));
        let plans =
            ["used,tiles=8", "tiles=16", "used"].map(|parts| plan(&all, &work, &model, parts));
        with_readers(|backends| {
            for backend in backends {
                if name.ends_with(".wgsl") && backend.device().backend == BackendKind::Gl {
                    continue;
                }
                let truth = made.whole(&all, backend.as_mut());
                assert!(truth.picture.pixels.iter().any(|pixel| pixel[0] > 0.1), "{name}");
                for plan in &plans {
                    let found = made.by_plan(&lists, backend.as_mut(), plan);
                    let steps = apart(&found, &truth);
                    let device = &backend.device().backend;
                    assert!(bits(&found) == bits(&truth), "{name} on {device:?}: {steps} steps");
                    if kinds.len() == 3 {
                        assert_eq!(found.evaluations, plan.evaluations(), "{name}");
                    }
                }
            }
        });
        if kinds.len() == 3 && name.contains("windowed") {
            let (before, after) = (plans[0].savings.before, plans[0].evaluations());
            assert!(2 * after < before, "{name}: {after} of {before}");
        }
    }
}

#[test]
fn lists_give_the_bits_of_the_loops_on_generated_scenes() {
    let source = source("many_lights/windowed.wgsl");
    let all = renderer(&source);
    let (_, lists, _) = rewritten(&source, &all);
    let model = model(&all);
    let mut cpu = Cpu::new(Default::default());
    let (mut masked, mut spots) = (0, 0);
    for number in crate::support::sample::sample(0..SCENES, 4) {
        let (scene, kind) = generated(number, true);
        let made = Made::of(scene);
        let work = made.work();
        let plan = plan(&all, &work, &model, "used,tiles=8");
        let (found, truth) = (made.by_plan(&lists, &mut cpu, &plan), made.whole(&all, &mut cpu));
        assert!(bits(&found) == bits(&truth), "{kind} {number}");
        let tiles = plan.tiles.as_ref().expect("lists");
        let suns = made.upload.lights.directional.len() as u32;
        masked += tiles.directional.iter().filter(|mask| mask.count_ones() < suns).count();
        spots += tiles.spots.iter().filter(|[_, count]| *count > 0).count();
    }
    println!("{masked} tiles without a sun, {spots} with spotlights");
    let least = if everything() { 100 } else { 0 };
    assert!(masked > least && spots > least);
}

#[test]
fn lists_hold_what_the_bytes_of_the_buffers_say() {
    for name in [
        "many_lights/windowed.wgsl",
        "many_lights/windowed_450.frag",
        "many_lights/windowed_330.frag",
    ] {
        let source = source(name);
        let all = renderer(&source);
        let (_, lists, text) = rewritten(&source, &all);
        let made = all_kinds(name);
        let work = made.work();
        let plan = plan(&all, &work, &model(&all), "used,tiles=8");
        let expected = plan.tiles.as_ref().expect("lists").bytes();
        let group = &lists.plan_fragment_groups(&work, &plan).expect("it fits")[0];
        // Written by the offsets that `landfall layout` prints for the text.
        let printed = landfall_layout::layout(&text, &Options::default());
        assert!(!printed.has_errors(), "{name}");
        for (block, expected) in ["LandfallTileBlock", "LandfallIndexBlock"].iter().zip(expected) {
            let at = lists.shader.blocks().iter().position(|b| *b.layout.name == **block);
            assert!(printed.blocks.iter().any(|laid| *laid.name == **block), "{name}");
            assert!(group.prepared.blocks[at.expect("a block")] == expected, "{name} {block}");
        }
    }
}

#[test]
fn what_is_written_is_valid_for_the_compilers_of_both_languages() {
    let folder = Place::new("listed-naga");
    for (name, _) in SHADERS {
        let source = source(name);
        let (.., text) = rewritten(&source, &renderer(&source));
        if name.ends_with(".wgsl") {
            folder.write("listed.wgsl", &*text.text);
            let module = naga::front::wgsl::parse_str(&text.text).expect(name);
            let mut validator = naga::valid::Validator::new(
                naga::valid::ValidationFlags::all(),
                naga::valid::Capabilities::all(),
            );
            validator.validate(&module).expect(name);
        } else {
            let client = match name.contains("450") {
                true => glslang::Client::Vulkan,
                false => glslang::Client::OpenGl,
            };
            let options = glslang::Options { client, reflect: false, ..Default::default() };
            glslang::blocks(&text.text, "frag", &options)
                .unwrap_or_else(|log| panic!("{name}: {log}\n{}", text.text));
        }
    }
}

/// A shader of point lights with that loop; `LIGHT` is what it adds.
fn with_loop(version: &str, code: &str) -> Source {
    let text = format!(
        "#version {version}\nstruct PointLight {{ vec3 position; vec3 color; }};\n\
         layout(std140) uniform PointLights {{ PointLight pointLights[8]; int pointCount; }};\n\
         in vec3 FragPos;\nin vec3 Normal;\nout vec4 FragColor;\n\
         vec3 lit(PointLight light) {{\n\
         vec3 d = light.position - FragPos;\n\
         return light.color * max(dot(Normal, d), 0.0) / dot(d, d);\n}}\n\
         void main() {{\nvec3 sum = vec3(0.0);\n{code}\nFragColor = vec4(sum, 1.0);\n}}\n"
    )
    .replace("LIGHT", "sum += lit(pointLights[i]);");
    Source::new("own.frag", text)
}

#[test]
fn a_loop_whose_lights_cannot_be_listed_says_why() {
    for (version, code, why) in [
        ("330", "for (int i = 1; i < pointCount; i++) { LIGHT }", "starts elsewhere than at 0"),
        ("330", "for (int i = 0; i < pointCount; i += 2) { LIGHT }", "does not count one by one"),
        ("330", "for (int i = 0; ; i++) { if (i == pointCount) break; LIGHT }", "has no condition"),
        (
            "330",
            "for (int i = 0; i < 8; i++) { if (i >= pointCount) break; LIGHT }",
            "ends by `break`",
        ),
        (
            "330",
            "for (int i = 0; i < 8; i++) { if (sum.x > 1.0) { FragColor = vec4(1.0); return; } LIGHT }",
            "ends by `return`",
        ),
        ("330", "for (int i = 0; i < 8; i++) { LIGHT i++; }", "changes its variable"),
        ("330", "for (int i = 0; i < 8; i++) if (i < pointCount) { LIGHT }", "without braces"),
        (
            "330",
            "for (int i = 0; pointLights[i].color.x > 0.0; i++) { LIGHT }",
            "reads a light in its condition",
        ),
        ("330", "int i = 0; while (i < pointCount) { LIGHT i++; }", "not the variable of a `for`"),
        ("330", "sum += lit(pointLights[0]);", "an index that is not the variable of a loop"),
        ("130", "for (int i = 0; i < 8; i++) { LIGHT }", "`#version 130` cannot be raised"),
    ] {
        let source = with_loop(version, code);
        let all = renderer(&source);
        let said = listed(&source, &ReadOptions::default(), &all.shader, &all.map);
        let said = said.expect_err(code);
        assert!(said.contains(why), "{code}: {said}");
    }
    // Written in other ways, but all of them loops over lights.
    for code in [
        "for (int i = 0; i < pointCount; ++i) LIGHT",
        "for (highp uint i = 0u; i < uint(pointCount); i += 1u) { LIGHT }",
        "for (int i = 0; i != pointCount; i = i + 1) { if (sum.x > 9.0) continue; LIGHT }",
        "for (int i = 0; i < 8; i++) { for (int k = 0; k < 2; k++) { if (k == 1) break; \
         if (i < pointCount) { LIGHT } } }",
        "if (pointCount > 0) for (int i = 0; i < min(pointCount, 8); i++) { PointLight one = \
         pointLights[int(i)]; sum += lit(one); }",
    ] {
        let source = with_loop("330", code);
        let all = renderer(&source);
        let (kinds, lists, text) = rewritten(&source, &all);
        assert_eq!(kinds, [Kind::Point], "{code}");
        let mut made = all_kinds("light_arrays");
        made.scene.lights.point.truncate(4);
        made.scene.lights.directional.clear();
        let made = Made::of(made.scene);
        let work = made.work();
        let mut plan = plan(&all, &work, &model(&all), "used");
        let mut cpu = Cpu::new(Default::default());
        let found = made.by_plan(&lists, &mut cpu, &plan);
        assert!(bits(&found) == bits(&made.whole(&all, &mut cpu)), "{}", text.text);
        // Lists are read: without lights in them, there is none.
        plan.draws[0].lights.numbers[Kind::Point as usize].clear();
        plan.tiles = None;
        plan.tiles = Some(plan.tile_lists(work.frame.height).expect("lists"));
        let found = made.by_plan(&lists, &mut cpu, &plan);
        let lit = |pixel: &[f32; 4]| pixel[..3] != [0.0; 3];
        assert!(!found.picture.pixels.iter().any(lit), "{}", text.text);
    }
}
