//! Plans keep what they promise: exact ones change no bit, and a budget is kept on every fragment by
//! the reference in `f64`.

use std::path::Path;
use std::time::Duration;

use glam::{DVec3, Vec3};
use landfall_light::bind::Kind;
use landfall_light::culling;
use landfall_light::culling::{Claim, Measured, Options, Plan, STEP, Times, Whole, brute};
use landfall_light::reference;
use landfall_light::reference::SpecularGate;
use landfall_light::sample::texels;
use landfall_light::scene;
use landfall_light::scene::{Cone, PointLight, Scene, SpotLight};
use landfall_light::shading_f32::{
    Form, Gates, Lights, Model, Shaded, Work, execute, shade_all, surfaces,
};
use landfall_light::{Fragment, Frame, FrameOptions, Upload};
use snapbox::str;

use crate::support::command::golden;
use crate::support::schema;

const ROBUST: Form = Form::Robust(Gates::ALL);

struct FragmentLights {
    scene: Scene,
    upload: Upload,
    frame: Frame,
}

impl FragmentLights {
    fn of(scene: Scene) -> FragmentLights {
        let frame = Frame::new(&scene, &FrameOptions::default());
        FragmentLights { upload: Upload::new(&scene), frame, scene }
    }

    fn plan(&self, model: &Model, text: &str) -> Plan {
        culling::plan(&self.upload, &self.frame, model, &culling::parse(text).expect(text))
    }

    fn lit(&self, model: &Model, plan: &Plan) -> Shaded<Work> {
        let surfaces = surfaces(&self.frame, &self.upload, model, 0.0);
        execute(plan, &self.upload, &surfaces, model, ROBUST)
    }

    fn brute(&self, model: &Model) -> Shaded<Work> {
        brute(&self.upload, &self.frame, model, ROBUST)
    }
}

fn read(name: &str, seed: u32, size: [u32; 2]) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders/scenes");
    let path = folder.join(name);
    let text = std::fs::read_to_string(&path).expect("a scene of ours");
    let text = text.replace("\"seed\": 42", &format!("\"seed\": {seed}"));
    let open = |name: &str| {
        std::fs::read(folder.join(name))
            .map_err(|e| landfall_layout::Error::new(name, e.to_string()))
    };
    let reading = scene::read(name, &text, &open);
    let mut scene = reading.scene.unwrap_or_else(|| panic!("{:?}", reading.diagnostics));
    scene.size = size;
    scene
}

/// The 1,024 lights of a seed.
fn many(seed: u32, size: [u32; 2]) -> FragmentLights {
    FragmentLights::of(read("lights_1024.json", seed, size))
}

fn windowed(seed: u32, size: [u32; 2]) -> FragmentLights {
    FragmentLights::of(read("lights_1024_windowed.json", seed, size))
}

const WINDOWED: Model = Model { windowed: true, ..DEFAULT };

const DEFAULT: Model = Model {
    windowed: false,
    specular: SpecularGate::None,
    ambient: reference::AmbientTerm::PerLight,
    own_ambient: false,
    terms: landfall_light::shading_f32::Terms::Three,
    cone: landfall_light::shading_f32::ConeTerm::Ramp,
    reflectance: reference::Reflectance::Ignored,
    shininess: None,
};

fn bits(colors: &[Vec3]) -> Vec<[u32; 3]> {
    colors.iter().map(|color| color.to_array().map(f32::to_bits)).collect()
}

fn every_fragment_is_in_one_draw(plan: &Plan, frame: &Frame) {
    let mut seen: Vec<u32> =
        plan.draws.iter().flat_map(|draw| draw.fragments.iter().copied()).collect();
    assert!(plan.draws.iter().all(|draw| draw.fragments.is_sorted()));
    seen.sort_unstable();
    let all: Vec<u32> = (0..frame.fragments.len() as u32).collect();
    assert!(seen == all, "{} of {} fragments", seen.len(), all.len());
}

/// Fragments with the lights that are in range there, by the scene's own numbers.
fn in_range(lit: &FragmentLights) -> u64 {
    let at = |f: &Fragment| DVec3::from(f.position.map(f64::from));
    let lights = &lit.upload.lights.point;
    let inside = |f: &Fragment| {
        let from = at(f);
        let near = |light: &&PointLight| {
            let range = light.attenuation.range.expect("a windowed scene");
            (light.position - from).length() < range
        };
        lights.iter().filter(near).count() as u64
    };
    lit.frame.fragments.iter().map(inside).sum()
}

#[test]
fn windowed_lights_by_tiles_are_those_of_all_lights_bit_for_bit() {
    let lit = windowed(42, [640, 360]);
    let all = lit.brute(&WINDOWED);
    let reached = in_range(&lit);
    let fragments = lit.frame.fragments.len() as u64;
    println!("{fragments} fragments, in range {:.1}", reached as f64 / fragments as f64);
    let text = "tiles=8";
    let plan = lit.plan(&WINDOWED, text);
    every_fragment_is_in_one_draw(&plan, &lit.frame);
    let culled = lit.lit(&WINDOWED, &plan);
    // Lights are added in the order of their numbers either way, and those left out add
    // exactly zero: no bit differs, not even in the order of a sum.
    assert!(bits(&culled.colors) == bits(&all.colors), "{text}");
    let after = plan.evaluations();
    println!(
        "{text}: {:.1} times fewer, {:.2} times those in range",
        plan.savings.before as f64 / after as f64,
        after as f64 / reached as f64
    );
    assert_eq!(plan.savings.before, 1024 * fragments);
    assert!(20 * after <= plan.savings.before, "{text}: {after}");
    assert!(2 * after <= 3 * reached, "{text}: {after} of {reached}");
    assert_eq!(culled.tally.trips, after);
    assert!(matches!(plan.savings.steps[0].error, Claim::Exact { .. }));
}

#[test]
fn published_form_gives_the_same_bits_by_tiles_too() {
    let lit = windowed(7, [160, 90]);
    let surfaces = surfaces(&lit.frame, &lit.upload, &WINDOWED, 0.0);
    let plan = lit.plan(&WINDOWED, "tiles=16");
    let culled: Shaded<Work> = execute(&plan, &lit.upload, &surfaces, &WINDOWED, Form::Seed);
    let all = brute(&lit.upload, &lit.frame, &WINDOWED, Form::Seed);
    assert!(bits(&culled.colors) == bits(&all.colors));
    assert!(culled.tally.evaluations * 5 < all.tally.evaluations);
}

#[test]
fn a_budget_is_kept_on_every_fragment_and_saves_little() {
    let lit = many(42, [96, 54]);
    let plan = lit.plan(&DEFAULT, "budget=0.5");
    every_fragment_is_in_one_draw(&plan, &lit.frame);
    let Claim::Proven { steps, .. } = plan.savings.steps[0].error else {
        panic!("{:?}", plan.savings.steps)
    };
    assert!(steps > 0.25 && steps <= 0.5, "{steps}");
    let model = reference::Model::default();
    let mut most = 0f64;
    for draw in &plan.draws {
        // Every tile, its first fragment: what the lights left out give there, in `f64`.
        let number = draw.fragments[0];
        let fragment = &lit.frame.fragments[number as usize];
        let texels = texels(&lit.upload.materials[fragment.material as usize], fragment.uv);
        let seen = reference::see(&model, &lit.upload, fragment, &texels).expect("defined");
        let left_out = (0..1024).filter(|n| draw.lights.of(Kind::Point).binary_search(n).is_err());
        let lost: DVec3 =
            left_out.map(|n| seen.light(Kind::Point, n as usize).expect("defined").total()).sum();
        assert!(lost.cmpge(DVec3::ZERO).all());
        most = most.max(lost.max_element() / STEP);
    }
    let times = plan.savings.before as f64 / plan.savings.after as f64;
    println!("{times:.3} times fewer, {most:.3} of {steps:.3} steps lost");
    assert!(most <= steps, "{most} {steps}");
    // Dropping cannot save much where no light ends; a plan that claims more is wrong.
    assert!(times > 1.0 && times < 1.5, "{times}");
    // A target of sRGB codes is nearly 13 times as strict near black.
    let strict = lit.plan(&DEFAULT, "budget-srgb=0.5");
    assert!(strict.evaluations() > plan.evaluations());
    let Claim::Proven { steps, .. } = strict.savings.steps[0].error else { panic!() };
    assert!(steps <= 0.5 / 12.92);
}

#[test]
fn two_of_128_slots_are_lit_by_64_times_fewer_evaluations_and_the_same_bits() {
    let lit = FragmentLights::of(read("two_of_128.json", 0, [200, 150]));
    let array = reference::Model::new(reference::Family::Array);
    let model = Model::new(&array).expect("known");
    let slots = [128, 128, 0].map(Some);
    let used = Options { used: true, slots, ..Options::default() };
    let plan = culling::plan(&lit.upload, &lit.frame, &model, &used);
    assert_eq!(plan.savings.before, 64 * plan.savings.after);
    assert_eq!((plan.compiled.directional, plan.compiled.point, plan.compiled.spot), (2, 2, 0));
    let eye = lit.upload.camera.as_vec3();
    let surfaces = surfaces(&lit.frame, &lit.upload, &model, 0.0);
    let two = Lights::new(&lit.upload, &model);
    for form in [Form::Seed, ROBUST] {
        let planned: Shaded<Work> = execute(&plan, &lit.upload, &surfaces, &model, form);
        let exact: Shaded<Work> = shade_all(&surfaces, eye, &two, &model, form);
        assert!(bits(&planned.colors) == bits(&exact.colors), "{form:?}");
        // The loop over every slot: 64 times the trips, and no number anywhere.
        let slots = two.clone().padded([128, 128, 0]);
        let naive: Shaded<Work> = shade_all(&surfaces, eye, &slots, &model, form);
        assert_eq!(naive.tally.trips, 64 * planned.tally.trips);
        assert!(naive.colors.iter().all(|color| color.is_nan()), "{form:?}");
        assert!(planned.colors.iter().all(|color| color.is_finite()));
    }
    // The array sized to the scene.
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders/light_arrays/point_lights_330.frag");
    let text = std::fs::read_to_string(path).expect("a shader of ours");
    let settings = plan.compiled.settings(&text);
    let names: Vec<(String, String)> =
        settings.iter().map(|s| (s.name.clone(), s.text())).collect();
    assert_eq!(names, [("POINT_LIGHT_MAX_NUM".to_string(), "2".to_string())]);
    let mut options = landfall_layout::Options::default();
    let source = landfall_layout::Source::new("point_lights_330.frag", text);
    let size = |options: &landfall_layout::Options| {
        let layouts = landfall_layout::layout(&source, options);
        let block = layouts.blocks.iter().find(|b| b.name.contains("PointLight")).cloned();
        block.expect("there is one").size
    };
    // 48 bytes a light and the count: 128 of them, then 2.
    let whole = size(&options);
    options.read.defines = names;
    assert_eq!((whole, size(&options)), (Some(128 * 48 + 16), Some(2 * 48 + 16)));
}

#[test]
fn dark_lights_and_those_without_slot_are_left_out_and_named() {
    let mut lit = many(42, [64, 36]);
    for (number, light) in lit.upload.lights.point.iter_mut().enumerate() {
        if number % 4 == 3 {
            light.emission.diffuse = DVec3::ZERO;
            light.emission.specular = DVec3::ZERO;
        }
    }
    let slots = [None, Some(1000), None];
    let used = Options { used: true, slots, ..Options::default() };
    let plan = culling::plan(&lit.upload, &lit.frame, &DEFAULT, &used);
    let lights = plan.draws[0].lights.of(Kind::Point);
    assert_eq!(lights.len(), 750);
    assert!(lights.iter().all(|n| n % 4 != 3 && *n < 1000));
    golden().eq(
        &plan.savings.notes[0],
        str!["1024 point lights, but the shader's array has 1000 slots: the last 24 are left out"],
    );
    // Left out, they change no bit.
    lit.upload.lights.point.truncate(1000);
    let (some, all) = (lit.lit(&DEFAULT, &plan), lit.brute(&DEFAULT));
    assert!(bits(&some.colors) == bits(&all.colors));
}

#[test]
fn gates_count_what_they_leave_out() {
    let lit = FragmentLights::of(read("six_lights.json", 0, [400, 300]));
    let plan = lit.plan(&DEFAULT, "gates");
    assert!(matches!(plan.savings.steps[0].error, Claim::Exact { .. }));
    let near = lit.plan(&DEFAULT, "gates=1/64");
    let Claim::Measured { measured: Measured { steps, .. } } = near.savings.steps[0].error else {
        panic!()
    };
    // Six powers below 1/64 of a step, a specular colour of at most 1 each.
    assert!(steps > 0.0 && steps <= 6.0 / 64.0, "{steps}");
    let surfaces = |least: f64| surfaces(&lit.frame, &lit.upload, &DEFAULT, least);
    let work = |least: f64, gates: Gates| -> Shaded<Work> {
        execute(&plan, &lit.upload, &surfaces(least), &DEFAULT, Form::Robust(gates))
    };
    let [open, exact, tiny] =
        [work(0.0, Gates::NONE), work(0.0, Gates::ALL), work(STEP / 64.0, Gates::ALL)];
    assert!(bits(&open.colors) == bits(&exact.colors));
    let [a, b, c] = [open.tally, exact.tally, tiny.tally];
    assert_eq!(a.powers, a.trips);
    assert!(b.evaluations < a.evaluations && b.attenuations < a.attenuations);
    assert!(b.powers < a.powers && c.powers < b.powers);
}

#[test]
fn lights_without_a_bound_are_never_left_out() {
    let mut lit = windowed(42, [64, 36]);
    lit.upload.lights.point[5].attenuation.linear = -0.1;
    lit.upload.lights.point[9].emission.diffuse.y = -0.5;
    lit.upload.lights.point[11].attenuation.quadratic = f64::NAN;
    for text in ["tiles", "budget=0.5"] {
        let plan = lit.plan(&WINDOWED, text);
        let holds = |n: u32| plan.draws.iter().all(|draw| draw.lights.of(Kind::Point).contains(&n));
        assert!(holds(5) && holds(9) && holds(11) && !holds(6), "{text}");
        assert_eq!(plan.savings.notes.len(), 3, "{:?}", plan.savings.notes);
        golden().eq(plan.savings.notes.join("\n"), str![[r#"
point light 5 has an attenuation that is zero, negative or not a number: no bound is known, so it is never dropped
point light 9 has a colour that is negative or not a number: no bound is known, so it is never dropped
point light 11 has an attenuation that is zero, negative or not a number: no bound is known, so it is never dropped
"#]]);
    }
}

#[test]
fn spots_are_left_out_of_tiles_their_cones_do_not_touch() {
    let mut scene = read("lights_1024.json", 3, [320, 180]);
    let lamps: Vec<PointLight> = scene.lights.point.drain(..).take(200).collect();
    let spot = |(number, lamp): (usize, PointLight)| {
        let angle = number as f64;
        let direction = DVec3::new(angle.cos(), -1.0, angle.sin()).normalize();
        let outer = [2.0, 15.0, 40.0, 100.0][number % 4];
        let [inner_cos, outer_cos] = [0.8 * outer, outer].map(|a: f64| a.to_radians().cos());
        SpotLight { point: lamp, direction, cone: Cone { inner_cos, outer_cos, degrees: None } }
    };
    scene.lights.spot = lamps.into_iter().enumerate().map(spot).collect();
    let lit = FragmentLights::of(scene);
    let plan = lit.plan(&DEFAULT, "tiles=8");
    let (some, all) = (lit.lit(&DEFAULT, &plan), lit.brute(&DEFAULT));
    assert!(bits(&some.colors) == bits(&all.colors));
    let inside = all.tally.evaluations;
    println!("{} of {} spots, {inside} inside", plan.evaluations(), plan.savings.before);
    // Not far above those whose cone the fragment is in.
    assert!(plan.evaluations() < 2 * inside && 2 * plan.evaluations() < plan.savings.before);
}

#[test]
fn lists_of_tiles_as_buffers_are_those_of_the_draws() {
    let lit = windowed(42, [170, 91]);
    let plan = lit.plan(&WINDOWED, "tiles=16");
    let tiles = plan.tiles.as_ref().expect("divided in tiles");
    assert_eq!((tiles.columns, tiles.tiles.len()), (11, 66));
    for draw in &plan.draws {
        for number in &draw.fragments {
            let pixel = lit.frame.fragments[*number as usize].pixel;
            let [x, y] = [pixel % 170 / 16, pixel / 170 / 16];
            let [first, count] = tiles.tiles[(y * 11 + x) as usize].map(|n| n as usize);
            assert_eq!(tiles.indices[first..first + count], *draw.lights.of(Kind::Point));
        }
    }
    assert!(lit.plan(&WINDOWED, "used").tiles.is_none());
}

#[test]
fn nothing_to_light_and_nothing_to_light_with_are_plans_too() {
    let parts = ["used,gates", "tiles", "budget=1"];
    let full = windowed(42, [32, 18]);
    for text in parts {
        let mut dark = windowed(42, [32, 18]);
        dark.upload.lights = scene::Lights::default();
        let plan = dark.plan(&WINDOWED, text);
        every_fragment_is_in_one_draw(&plan, &dark.frame);
        assert_eq!(plan.savings.after, 0);
        assert!(dark.lit(&WINDOWED, &plan).colors.iter().all(|c| *c == Vec3::ZERO));
        let empty = FragmentLights {
            frame: Frame::default(),
            upload: full.upload.clone(),
            scene: full.scene.clone(),
        };
        assert_eq!(empty.plan(&WINDOWED, text).savings.after, 0);
        // Places that are no numbers: kept, with every light.
        let mut broken = windowed(42, [32, 18]);
        broken.frame.fragments[3].position[1] = f32::NAN;
        broken.frame.fragments[7].position[0] = f32::INFINITY;
        broken.frame.fragments[9].normal = [0.0; 3];
        broken.frame.fragments[11].material = 99;
        let plan = broken.plan(&WINDOWED, text);
        every_fragment_is_in_one_draw(&plan, &broken.frame);
    }
}

#[test]
// One range of bytes is what is meant.
#[allow(clippy::single_range_in_vec_init)]
fn only_what_changed_is_uploaded_unless_all_is_cheaper() {
    let source = landfall_layout::Source::new(
        "lights.frag",
        "struct PointLight { vec3 pos; vec3 color; float intensity; float constant; float linear; float quadratic; };
         layout(std140) uniform PointLightBlock { PointLight data[128]; int actually_used_count; } lights;",
    );
    let block =
        landfall_layout::layout(&source, &landfall_layout::Options::default()).blocks.remove(0);
    let mut buffer = landfall_layout::Buffer::new(&block).expect("a fixed size");
    buffer.clear_dirty();
    assert_eq!(culling::choose(&buffer, 64).0, culling::UploadChoice::Nothing);
    let position = buffer.handle::<[f32; 3]>("data[].pos").expect("a vec3");
    buffer.set_at(&position, [3], [1.0; 3]).expect("in range");
    let (choice, upload) = culling::choose(&buffer, 64);
    assert_eq!(choice, culling::UploadChoice::Ranges(vec![144..156]));
    assert_eq!((upload.bytes, upload.whole), (12, 6160));
    // Every light moved: 128 calls of 12 bytes, or ranges run together, or all at once.
    for light in 0..128 {
        buffer.set_at(&position, [light], [2.0; 3]).expect("in range");
    }
    assert_eq!(
        culling::choose(&buffer, 0).0,
        culling::UploadChoice::Ranges((0..128).map(|i| 48 * i..48 * i + 12).collect())
    );
    // Apart from the last light's other members and the count, all of it in one call either way.
    assert_eq!(culling::choose(&buffer, 64).0, culling::UploadChoice::Ranges(vec![0..6108]));
    buffer.mark_all();
    assert_eq!(culling::choose(&buffer, 64).0, culling::UploadChoice::Whole);
}

#[test]
fn a_plan_is_told_in_lines_and_in_json_by_its_schema() {
    let lit = windowed(42, [96, 54]);
    let validator = schema::validator(landfall::report::plan::PLAN_SCHEMA);
    let measured = Measured { steps: 0.25, codes: 1, of: 9, fragments: 3, every: 1 };
    let whole = Whole { time: Duration::from_millis(40), fragments: 512, measured: false };
    let (planning, lighting) = (Duration::from_millis(3), Duration::from_millis(7));
    for text in ["used,tiles,gates", "budget=0.5", "tiles,gates=1/8", "tiles"] {
        let mut plan = lit.plan(&WINDOWED, text);
        if text.starts_with("budget") {
            plan.confirm(measured);
            let times = Times { planning, lighting, whole: Some(whole), ..Times::default() };
            plan.savings.times = Some(times);
        }
        let json = landfall::report::plan::json(&plan);
        let value = schema::holds(&validator, &json, text);
        assert_eq!(value["evaluations"]["after"], plan.savings.after);
        let lines = landfall::report::plan::text(&plan, landfall_layout::format::Paint::Plain);
        println!("{lines}");
        assert!(lines.ends_with('\n') && lines.starts_with("plan  "));
        let steps = value["steps"].as_array().expect("steps").iter();
        let measured = steps.filter(|step| step["error"]["kind"] == "measured").count();
        assert_eq!(lines.matches("measured, not proven").count(), measured);
        let timed = "10.0 ms from the start of planning to the picture: 3.0 ms planning, 7.0 ms lighting\n        \
                     0.25 of the 40.0 ms without skipping, estimated from 512 fragments";
        assert_eq!(lines.contains(timed), text.starts_with("budget"), "{lines}");
    }
}

/// A plan is judged by all of its time and by all of its error.
#[test]
fn a_plan_that_costs_more_than_it_saves_or_errs_more_than_it_may_is_not_applied() {
    let lit = windowed(42, [32, 18]);
    let plan = lit.plan(&WINDOWED, "budget=0.5");
    let millis = Duration::from_millis;
    let whole = Some(Whole { time: millis(100), fragments: 576, measured: true });
    let times = |planning, lighting| Times {
        planning: millis(planning),
        lighting: millis(lighting),
        whole,
        ..Times::default()
    };
    let within = Measured { steps: plan.permitted(), ..Measured::default() };
    let beyond = Measured { steps: plan.permitted() + 0.1, ..Measured::default() };
    for (checked, planning, lighting, always, applied) in [
        (None, 10, 30, false, true),
        (None, 60, 60, false, false),
        (None, 120, 0, false, false),
        (None, 60, 60, true, true),
        (Some(within), 10, 30, false, true),
        (Some(beyond), 10, 30, false, false),
        (Some(beyond), 10, 30, true, false),
    ] {
        let times = times(planning, lighting);
        let why = plan.drawback(checked.as_ref(), &times, always);
        assert_eq!(why.is_none(), applied, "{planning} {lighting} {always}: {why:?}");
    }
}
