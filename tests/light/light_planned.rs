//! Plans on a backend: the evaluator gives the same bits by exact plans, by draws or by lists.

use landfall_interp::Cpu;
use landfall_layout::Options;
use landfall_light::culling;
use landfall_light::culling::Plan;
use landfall_light::reference;
use landfall_light::render::{RenderOptions, Renderer};
use landfall_light::shading_f32::Model;

use crate::made::{Made, bits, renderer, scene, source};

fn plan(renderer: &Renderer, made: &Made, parts: &str) -> Plan {
    let model = landfall_light::render::truth::likely_model(&renderer.map);
    let model = Model::new(&model).expect("known");
    renderer.plan(&made.work(), &model, &culling::parse(parts).expect(parts))
}

#[test]
fn windowed_lights_by_draws_and_by_lists_are_all_lights_bit_for_bit() {
    let made = Made::of(scene("lights_1024_windowed.json", [96, 54]));
    let cpu = &mut Cpu::default();
    for (shader, listed) in [
        ("many_lights/windowed.wgsl", "many_lights/windowed_listed.wgsl"),
        ("many_lights/windowed_450.frag", "many_lights/windowed_listed_450.frag"),
    ] {
        let all = renderer(&source(shader));
        let truth = made.whole(&all, cpu);
        let fragments = made.frame.fragments.len() as u64;
        assert_eq!(truth.evaluations, 1024 * fragments);
        let plan = plan(&all, &made, "used,tiles=8");
        let drawn = made.by_plan(&all, cpu, &plan);
        assert!(bits(&drawn) == bits(&truth), "{shader}");
        assert_eq!(drawn.evaluations, plan.evaluations());
        let listing = renderer(&source(listed));
        assert!(listing.reads_tile_lists() && !all.reads_tile_lists());
        let found = made.by_plan(&listing, cpu, &plan);
        assert!(bits(&found) == bits(&truth), "{listed}");
        assert_eq!(found.evaluations, plan.evaluations());
        assert!(10 * found.evaluations < truth.evaluations, "{}", found.evaluations);
    }
}

#[test]
fn shader_compiled_for_two_of_128_lights_gives_the_same_bits_and_uploads_less() {
    let made = Made::of(scene("two_of_128.json", [64, 48]));
    assert_eq!(made.scene.lights.point.len(), 2);
    let source = source("light_arrays/point_lights_450.frag");
    let full = renderer(&source);
    let plan = plan(&full, &made, "used");
    let settings = plan.compiled.settings(&source.text);
    let mut options = Options::default();
    for setting in &settings {
        options.read.defines.push((setting.name.clone(), setting.text()));
    }
    assert_eq!(options.read.defines, [("POINT_LIGHT_MAX_NUM".to_string(), "2".to_string())]);
    let options = RenderOptions { layout: options, ..RenderOptions::default() };
    let small = Renderer::new(&source, &options).unwrap_or_else(|error| panic!("{error}"));
    let [a, b] = [&full, &small].map(|one| made.by_plan(one, &mut Cpu::default(), &plan));
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
    let mut scene = scene("lights_1024_windowed.json", [64, 36]);
    scene.lights.point.truncate(200);
    let (made, cpu) = (Made::of(scene), &mut Cpu::default());
    let shader = renderer(&source("many_lights/plain.wgsl"));
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
        let found = made.by_plan(&shader, cpu, &plan);
        let all = made.whole(&shader, cpu);
        let checked = shader.apart(&made.work(), &found.picture, &all.picture);
        assert_eq!(checked.fragments, made.frame.fragments.len() as u64);
        assert_eq!(plan.permits(&checked), holds, "{checked:?}");
        assert_eq!(checked.steps == 0.0, holds);
    }
}
