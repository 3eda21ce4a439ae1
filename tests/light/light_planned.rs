//! Plans on a backend: the evaluator gives the same bits by exact plans, by draws or by lists.

use std::path::Path;
use std::time::Duration;

use landfall_interp::{Cpu, Settings};
use landfall_layout::{Options, Source};
use landfall_light::culling;
use landfall_light::culling::{LightSet, Plan};
use landfall_light::reference;
use landfall_light::render::{Draw, RenderOptions, Rendered, Renderer, Work};
use landfall_light::scene;
use landfall_light::scene::Scene;
use landfall_light::shading_f32::Model;
use landfall_light::{Frame, FrameOptions, Upload};

struct Made {
    upload: Upload,
    frame: Frame,
    scene: Scene,
}

impl Made {
    fn work(&self) -> Work<'_> {
        Work {
            upload: &self.upload,
            frame: &self.frame,
            background: self.scene.background,
            limit: Duration::from_secs(120),
        }
    }
}

fn made(name: &str, size: [u32; 2], lights: usize) -> Made {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders/scenes");
    let reading = scene::read_file(folder.join(name)).expect("a scene of ours");
    let mut scene = reading.scene.unwrap_or_else(|| panic!("{:?}", reading.diagnostics));
    scene.size = size;
    scene.lights.point.truncate(lights);
    let frame = Frame::new(&scene, &FrameOptions::default());
    Made { upload: Upload::new(&scene), frame, scene }
}

fn renderer(shader: &str, options: Options) -> Renderer {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders").join(shader);
    let text = std::fs::read_to_string(&path).expect("a shader of ours");
    let source = Source::new(shader, text);
    let options = RenderOptions { layout: options, ..RenderOptions::default() };
    Renderer::new(&source, &options).unwrap_or_else(|e| panic!("{shader}: {e}"))
}

fn plan(renderer: &Renderer, made: &Made, parts: &str) -> Plan {
    let model = landfall_light::render::truth::likely_model(&renderer.map);
    let model = Model::new(&model).expect("known");
    renderer.plan(&made.work(), &model, &culling::parse(parts).expect(parts))
}

fn by_plan(renderer: &Renderer, made: &Made, plan: &Plan) -> Rendered {
    let mut cpu = Cpu::new(Settings::default());
    renderer.render_plan(&mut cpu, &made.work(), plan, &mut |_: &mut Cpu, _| {}).expect("it runs")
}

fn whole(renderer: &Renderer, made: &Made) -> Rendered {
    let mut cpu = Cpu::new(Settings::default());
    let (lights, fragments) = (LightSet::all(&made.upload.lights), made.frame.numbers());
    let draws = [Draw { fragments: &fragments, lights: &lights, tiles: None }];
    renderer.render(&mut cpu, &made.work(), &draws, &mut |_: &mut Cpu, _| {}).expect("it runs")
}

fn bits(rendered: &Rendered) -> Vec<[u32; 4]> {
    rendered.picture.pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

#[test]
fn windowed_lights_by_draws_and_by_lists_are_all_lights_bit_for_bit() {
    let made = made("lights_1024_windowed.json", [96, 54], 1024);
    for (shader, listed) in [
        ("many_lights/windowed.wgsl", "many_lights/windowed_listed.wgsl"),
        ("many_lights/windowed_450.frag", "many_lights/windowed_listed_450.frag"),
    ] {
        let all = renderer(shader, Options::default());
        let truth = whole(&all, &made);
        let fragments = made.frame.fragments.len() as u64;
        assert_eq!(truth.evaluations, 1024 * fragments);
        let plan = plan(&all, &made, "used,tiles=8");
        let drawn = by_plan(&all, &made, &plan);
        assert!(bits(&drawn) == bits(&truth), "{shader}");
        assert_eq!(drawn.evaluations, plan.evaluations());
        let listing = renderer(listed, Options::default());
        assert!(listing.reads_tile_lists() && !all.reads_tile_lists());
        let found = by_plan(&listing, &made, &plan);
        assert!(bits(&found) == bits(&truth), "{listed}");
        assert_eq!(found.evaluations, plan.evaluations());
        assert!(10 * found.evaluations < truth.evaluations, "{}", found.evaluations);
    }
}

#[test]
fn shader_compiled_for_two_of_128_lights_gives_the_same_bits_and_uploads_less() {
    let made = made("two_of_128.json", [64, 48], 2);
    let shader = "light_arrays/point_lights_450.frag";
    let full = renderer(shader, Options::default());
    let plan = plan(&full, &made, "used");
    let text =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders").join(shader));
    let settings = plan.compiled.settings(&text.expect("a shader of ours"));
    let mut options = Options::default();
    for setting in &settings {
        options.read.defines.push((setting.name.clone(), setting.text()));
    }
    assert_eq!(options.read.defines, [("POINT_LIGHT_MAX_NUM".to_string(), "2".to_string())]);
    let small = renderer(shader, options);
    let (a, b) = (by_plan(&full, &made, &plan), by_plan(&small, &made, &plan));
    assert!(bits(&a) == bits(&b));
    println!("{} bytes for 128 slots, {} for 2", a.uploaded, b.uploaded);
    // 126 slots of 48 bytes less in every upload.
    assert!(a.uploaded >= b.uploaded + 126 * 48);
    let model = reference::Model::new(reference::Family::Array);
    assert!(Model::new(&model).is_ok());
}

#[test]
fn a_plan_for_another_model_than_the_shader_has_is_found_out() {
    // The plan ends lights at their ranges; this shader does not.
    let made = made("lights_1024_windowed.json", [64, 36], 200);
    let shader = renderer("many_lights/plain.wgsl", Options::default());
    let windowed = reference::Model {
        window: reference::Window::Quartic,
        ..reference::Model::new(reference::Family::Array)
    };
    let endless = reference::Model {
        window: reference::Window::None,
        ..reference::Model::new(windowed.family)
    };
    let parts = culling::parse("tiles").expect("good");
    for (model, holds) in [(windowed, false), (endless, true)] {
        let model = Model::new(&model).expect("known");
        let plan = shader.plan(&made.work(), &model, &parts);
        let found = by_plan(&shader, &made, &plan);
        let all = whole(&shader, &made);
        let checked = shader.apart(&made.work(), &found.picture, &all.picture);
        assert_eq!(checked.fragments, made.frame.fragments.len() as u64);
        assert_eq!(plan.permits(&checked), holds, "{checked:?}");
        assert_eq!(checked.steps == 0.0, holds);
    }
}
