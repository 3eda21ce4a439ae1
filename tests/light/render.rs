//! Scenes lit by our shaders on every backend, held against the reference.

use landfall_exec::backend::Backend;
use landfall_exec::backend::gl::Gl;
use landfall_exec::backend::wgpu::{AdapterChoice, Gpu};
use landfall_interp::Cpu;
use landfall_layout::{Options, Source};
use landfall_light::bind::{Kind, OverflowPolicy};
use landfall_light::culling::LightSet;
use landfall_light::picture::compare::{Compare, compare};
use landfall_light::picture::{Comparison, Transfer};
use landfall_light::reference::{Model, Window};
use landfall_light::render::truth::{Truth, likely_model, nearest};
use landfall_light::render::{Draw, RenderError, RenderOptions, Rendered, Renderer};
use snapbox::str;

use crate::made::{Made, renderer, scene, source};
use crate::support::command::golden;

fn backends() -> Vec<Box<dyn Backend>> {
    let gl = Gl::open().unwrap_or_else(|failure| panic!("{failure}"));
    let gpu = Gpu::open(&AdapterChoice::default()).unwrap_or_else(|failure| panic!("{failure}"));
    vec![Box::new(Cpu::default()), Box::new(gl), Box::new(gpu)]
}

fn held(rendered: &Rendered, truth: &Truth) -> Comparison {
    let leave_out = Some(&truth.leave_out[..]);
    let options = Compare { transfer: Transfer::Linear, leave_out };
    compare(&truth.picture, &rendered.picture, &options).expect("they are of one size")
}

/// The backend that takes a shader: OpenGL does not accept WGSL.
fn takes(backend: &dyn Backend, shader: &str) -> bool {
    backend.device().backend.name() != "gl" || !shader.ends_with("wgsl")
}

#[test]
fn six_lights_are_the_reference_to_a_step_on_every_reader() {
    let made = Made::of(scene("six_lights.json", [400, 300]));
    let mut backends = backends();
    for shader in ["phong_330.frag", "phong_450.frag", "phong.wgsl"] {
        let renderer = renderer(&source(&format!("six_lights/{shader}")));
        for backend in &mut backends {
            // The modules of both texts are held on the evaluator by the first.
            let who = backend.device().backend.name();
            if !takes(backend.as_ref(), shader) || (who == "cpu" && shader == "phong_450.frag") {
                continue;
            }
            let rendered = made.whole(&renderer, backend.as_mut());
            let model = likely_model(&renderer.map);
            let model = nearest(&model, &made.upload, &made.frame, &rendered.picture);
            let held = held(&rendered, &made.truth(&model));
            assert_eq!(rendered.picture.non_finite(), 0, "{shader} on {who}");
            assert_eq!(held.left_out, 0, "{shader} on {who}: nothing is undefined");
            assert!(held.codes.max <= 1, "{shader} on {who}: {:?}", held.codes);
            // Of the channels that were lit: the background is the same in any case.
            let flips: u64 = held.codes.counts[1..].iter().sum();
            let part = flips as f64 / (3 * rendered.fragments) as f64;
            assert!(part <= 5e-5, "{shader} on {who}: {:?}", held.codes);
            assert!(held.linear.max <= 2e-3, "{shader} on {who}: {:?}", held.linear);
            let lights = 6 * rendered.fragments;
            assert_eq!(rendered.evaluations, lights, "{shader} on {who}");
        }
    }
}

#[test]
fn ambient_terms_are_the_share_of_red_that_the_lint_states() {
    let mut made = Made::of(scene("six_lights.json", [400, 300]));
    let red = |made: &Made| {
        let picture = made.truth(&Model::default()).picture;
        let at = made.frame.fragments.iter().map(|fragment| fragment.pixel as usize);
        at.map(|pixel| f64::from(picture.pixels[pixel][0])).sum::<f64>()
    };
    let with = red(&made);
    let lights = &mut made.upload.lights;
    let emissions = lights.directional.iter_mut().map(|light| &mut light.emission);
    let emissions = emissions.chain(lights.point.iter_mut().map(|light| &mut light.emission));
    let ambient = emissions.map(|emission| std::mem::take(&mut emission.ambient));
    assert_eq!(ambient.filter(|ambient| (ambient.x - 0.05).abs() < 1e-8).count(), 5);
    let share = 100.0 * (1.0 - red(&made) / with);
    let why = landfall_lint::lint("ambient-per-light").expect("a lint of that code").why;
    let stated = format!("five of 0.05 are {share:.0} % of the red of the surfaces");
    assert!(why.contains(&stated), "{stated}: {why}");
}

#[test]
fn every_scene_is_lit_as_its_reference_says() {
    let mut backends = backends();
    for (name, shaders, most) in [
        (
            "two_of_128.json",
            &["light_arrays/all_lights_330.frag", "light_arrays/lights.wgsl"][..],
            1,
        ),
        ("view_space.json", &["view_space/scene_330.frag", "view_space/scene.wgsl"], 1),
        ("caster_directional.json", &["casters/directional_330.frag"], 1),
        ("caster_point.json", &["casters/point_330.frag", "casters/point.wgsl"], 1),
        ("caster_spot_soft.json", &["casters/spot_soft_330.frag"], 1),
        ("caster_spot_hard.json", &["casters/spot_hard_330.frag", "casters/spot_hard.wgsl"], 1),
    ] {
        let made = Made::of(scene(name, [160, 120]));
        for shader in shaders {
            let renderer = renderer(&source(shader));
            for backend in &mut backends {
                let who = backend.device().backend.name();
                if !takes(backend.as_ref(), shader) {
                    continue;
                }
                let rendered = made.whole(&renderer, backend.as_mut());
                let model = likely_model(&renderer.map);
                let model = nearest(&model, &made.upload, &made.frame, &rendered.picture);
                let held = held(&rendered, &made.truth(&model));
                assert!(held.codes.max <= most, "{shader} on {who}: {:?} {model:?}", held.codes);
                assert_eq!(rendered.picture.non_finite(), 0, "{shader} on {who}");
                let lit = rendered.picture.pixels.iter().flatten().any(|c| *c > 0.2 && *c < 1.0);
                assert!(lit, "{shader} on {who} is black");
            }
        }
    }
}

/// A shader may hold a range and cut lights off there, or window them: its picture tells.
#[test]
fn a_range_is_a_window_only_where_the_picture_has_one() {
    let plain = include_str!("../../shaders/casters/point_330.frag");
    let ranged =
        plain.replace("    float quadratic;\n};", "    float quadratic;\n    float range;\n};");
    let last = "    return lit * attenuation(";
    let cut = "    if (d2 > light.range * light.range) return vec3(0.0);\n";
    let window = "    float s = d2 / (light.range * light.range);\n    \
                  lit *= pow(max(1.0 - s * s, 0.0), 2.0);\n";
    let mut made = Made::of(scene("caster_point.json", [80, 60]));
    made.upload.lights.point[0].attenuation.range = Some(40.0);
    for (added, wanted) in [(cut, Window::None), (window, Window::Quartic)] {
        let text = ranged.replace(last, &format!("{added}{last}"));
        assert_eq!(text.matches("light.range").count(), 2);
        let source = Source::new("ranged.frag", text);
        let renderer = Renderer::new(&source, &RenderOptions::default());
        let renderer = renderer.unwrap_or_else(|error| panic!("{error}"));
        let rendered = made.whole(&renderer, &mut Cpu::default());
        let infer = likely_model(&renderer.map);
        assert_eq!(infer.window, Window::Quartic, "the guess goes by the member");
        let model = nearest(&infer, &made.upload, &made.frame, &rendered.picture);
        assert_eq!(model.window, wanted, "{added}");
        let held = held(&rendered, &made.truth(&model));
        assert!(held.linear.max < 0.01, "{added}: {:?}", held.linear);
    }
}

#[test]
fn a_picture_of_several_draws_is_that_of_one() {
    let made = Made::of(scene("six_lights.json", [120, 90]));
    let renderer = renderer(&source("six_lights/phong_330.frag"));
    let all = LightSet::all(&made.upload.lights);
    assert_eq!(all.counts(), [1, 4, 1]);
    let (even, odd): (Vec<u32>, Vec<u32>) =
        (0..made.frame.fragments.len() as u32).partition(|n| n % 2 == 0);
    let mut dark = all.clone();
    dark.numbers[Kind::Spot as usize].clear();
    let draws = [
        Draw { fragments: &odd, lights: &all, tiles: None },
        Draw { fragments: &even, lights: &dark, tiles: None },
    ];
    let mut cpu = Cpu::default();
    let whole = made.whole(&renderer, &mut cpu);
    let mut done = 0;
    let parts = renderer.render(&mut cpu, &made.work(), &draws, &mut |_: &mut Cpu, n| done += n);
    let parts = parts.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(done, made.frame.fragments.len());
    let at = |n: &u32| made.frame.fragments[*n as usize].pixel as usize;
    let same = |n: &u32| whole.picture.pixels[at(n)] == parts.picture.pixels[at(n)];
    assert!(odd.iter().all(same), "all lights give the same bits");
    assert!(!even.iter().all(same), "without the flashlight something is darker");
}

#[test]
fn a_shader_with_no_room_for_the_lights_refuses_the_scene() {
    let made = Made::of(scene("lights_1024.json", [16, 9]));
    let renderer = renderer(&source("light_arrays/all_lights_330.frag"));
    let error = renderer.lights(&made.upload, OverflowPolicy::Refuse).expect_err("128 slots");
    let message = error.to_string();
    golden().eq(
        &message,
        str!["the scene has 1024 point lights, but `PointLightBlock.data[].pos` has slots for 128"],
    );
    let unlit = "#version 330\nout vec4 c;\nvoid main() { c = vec4(1.0); }";
    let options = RenderOptions { layout: Options::default(), ..RenderOptions::default() };
    let error = Renderer::new(&Source::new("unlit.frag", unlit), &options).expect_err("no lights");
    assert!(matches!(error, RenderError::Bind(_)), "{error}");
}

#[test]
fn a_thousand_lights_are_the_reference_whole_and_by_lists() {
    let made = Made::of(scene("lights_1024_windowed.json", [64, 36]));
    let gpu =
        &mut Gpu::open(&AdapterChoice::default()).unwrap_or_else(|failure| panic!("{failure}"));
    let mut pictures = Vec::new();
    for shader in ["many_lights/windowed_450.frag", "many_lights/windowed_listed_450.frag"] {
        let renderer = renderer(&source(shader));
        let rendered = made.whole(&renderer, gpu);
        let model = likely_model(&renderer.map);
        let model = nearest(&model, &made.upload, &made.frame, &rendered.picture);
        let held = held(&rendered, &made.truth(&model));
        assert!(held.codes.max <= 1, "{shader}: {:?} {model:?}", held.codes);
        pictures.push(rendered.picture);
    }
    assert!(pictures[0] == pictures[1], "one list of everything is no list");
}
