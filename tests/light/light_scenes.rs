//! Culling on generated scenes: whatever the lights and the surfaces, exact strategies change no
//! bit, and what any strategy leaves out is within its bound by the reference in `f64`.

use fastrand::Rng;
use glam::{DMat4, DVec3, Vec3};
use landfall_light::culling::{self, Claim, Plan, STEP, brute};
use landfall_light::reference::{self, SpecularGate, Window};
use landfall_light::sample::texels;
use landfall_light::scene::{
    self, Attenuation, Camera, Cone, DirectionalLight, Emission, Lights, Material, Object,
    PointLight, Scene, SpotLight, Surface,
};
use landfall_light::shading_f32::{Form, Gates, Model, Work, execute, surfaces};
use landfall_light::{Frame, FrameOptions, Upload};

pub(super) const SCENES: u64 = 20;
const ROBUST: Form = Form::Robust(Gates::ALL);

/// The kinds of scenes, each with other surfaces or lights.
const KINDS: [&str; 8] =
    ["corridor", "cloud", "grid", "one tile", "touching", "signed", "none", "one"];

fn any(random: &mut Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * random.f64()
}

fn within(random: &mut Rng, size: DVec3) -> DVec3 {
    let [x, y, z] = size.to_array().map(|side| any(random, -side, side));
    DVec3::new(x, y, z)
}

fn object(mesh: scene::Mesh, material: usize, at: DVec3, size: DVec3) -> Object {
    let transform = DMat4::from_translation(at) * DMat4::from_scale(size);
    Object { mesh, material, transform }
}

/// The surfaces: a corridor with walls on all sides, or boxes and balls above a floor.
fn objects(kind: &str, random: &mut Rng) -> Vec<Object> {
    if kind == "corridor" {
        let walls = [
            (DVec3::new(0.0, -2.0, -15.0), DVec3::new(6.0, 0.2, 60.0)),
            (DVec3::new(0.0, 2.0, -15.0), DVec3::new(6.0, 0.2, 60.0)),
            (DVec3::new(-3.0, 0.0, -15.0), DVec3::new(0.2, 4.0, 60.0)),
            (DVec3::new(3.0, 0.0, -15.0), DVec3::new(0.2, 4.0, 60.0)),
        ];
        return walls.map(|(at, size)| object(scene::cube(), 0, at, size)).to_vec();
    }
    let mut all = vec![object(
        scene::plane(10.0),
        0,
        DVec3::new(0.0, -2.0, -15.0),
        DVec3::new(60.0, 1.0, 60.0),
    )];
    for number in 0..12usize {
        let at = within(random, DVec3::new(8.0, 2.0, 14.0)) - DVec3::new(0.0, 0.0, 12.0);
        let mesh = if number.is_multiple_of(2) { scene::cube() } else { scene::sphere(12, 8) };
        let size = DVec3::splat(any(random, 0.5, 3.0));
        all.push(object(mesh, 1 + number % 3, at, size));
    }
    all
}

fn emission(kind: &str, random: &mut Rng) -> Emission {
    let color = |random: &mut Rng| DVec3::new(random.f64(), random.f64(), random.f64());
    let factor = match (kind, random.u32(0..4)) {
        ("signed", 0) => -0.5,
        ("signed", 1) => 0.0,
        _ => 0.5,
    };
    let (diffuse, specular) = (color(random), color(random));
    // Some without a highlight, which nothing behind them shows.
    let specular = if random.u32(0..4) == 0 { DVec3::ZERO } else { specular };
    Emission {
        ambient: if random.u32(0..4) == 0 { 0.1 * diffuse } else { DVec3::ZERO } * factor,
        diffuse: diffuse * factor,
        specular: specular * factor,
        color: diffuse,
        intensity: factor,
    }
}

fn place(kind: &str, number: usize, random: &mut Rng) -> DVec3 {
    match kind {
        "corridor" => {
            DVec3::new(any(random, -2.5, 2.5), any(random, -1.5, 1.5), -0.5 * number as f64)
        }
        "grid" => DVec3::new((number % 8) as f64 * 2.0 - 7.0, 1.0, -2.0 * (number / 8) as f64),
        "one tile" => DVec3::new(0.0, 0.0, -10.0) + within(random, DVec3::splat(0.05)),
        // On the floor, within walls and balls, and behind the camera.
        "touching" if number.is_multiple_of(3) => DVec3::new(any(random, -5.0, 5.0), -2.0, -8.0),
        "touching" if number % 3 == 1 => DVec3::new(any(random, -5.0, 5.0), -2.5, -8.0),
        _ => within(random, DVec3::new(10.0, 3.0, 15.0)) - DVec3::new(0.0, 0.0, 12.0),
    }
}

fn lamp(kind: &str, number: usize, ends: bool, random: &mut Rng) -> PointLight {
    let range = (ends && random.u32(0..8) > 0).then(|| any(random, 0.5, 5.0));
    let attenuation = Attenuation {
        constant: 1.0,
        linear: any(random, 0.0, 0.5),
        quadratic: any(random, 0.01, 1.0),
        range,
    };
    PointLight {
        position: place(kind, number, random),
        emission: emission(kind, random),
        attenuation,
    }
}

fn lights(kind: &str, ends: bool, random: &mut Rng) -> Lights {
    let count = match kind {
        "none" => 0,
        "one" => 1,
        _ => 48,
    };
    let mut lights = Lights::default();
    for number in 0..count {
        let lamp = lamp(kind, number, ends, random);
        if number % 3 < 2 {
            lights.point.push(lamp);
            continue;
        }
        let outer: f64 = [3.0, 10.0, 30.0, 100.0][random.usize(0..4)];
        let cosine = |angle: f64| angle.to_radians().cos();
        let cone = Cone { inner_cos: cosine(0.7 * outer), outer_cos: cosine(outer), degrees: None };
        let direction = (within(random, DVec3::ONE) - DVec3::Y * 0.5).normalize();
        lights.spot.push(SpotLight { point: lamp, direction, cone });
    }
    if count > 1 {
        let direction = within(random, DVec3::ONE).normalize();
        lights.directional.push(DirectionalLight { direction, emission: emission(kind, random) });
    }
    lights
}

pub(super) fn generated(number: u64, ends: bool) -> (Scene, &'static str) {
    let mut random = Rng::with_seed(0x1911 + number);
    let kind = KINDS[number as usize % KINDS.len()];
    let material = |shininess: f64, specular: f64, random: &mut Rng| Material {
        name: String::new(),
        ambient: Surface::Constant(DVec3::splat(0.5)),
        diffuse: Surface::Constant(DVec3::new(random.f64(), random.f64(), random.f64())),
        specular: Surface::Constant(DVec3::splat(specular)),
        shininess,
        reflectance: 1.0,
    };
    let materials = [(32.0, 0.2), (10.0, 0.5), (40.5, 0.3), (32.0, 0.0)];
    let materials = materials.map(|(n, specular)| material(n, specular, &mut random)).to_vec();
    let camera = Camera {
        position: DVec3::new(0.0, 0.5, 4.0),
        front: DVec3::new(any(&mut random, -0.1, 0.1), -0.1, -1.0).normalize(),
        up: DVec3::Y,
        fov: 60.0,
        near: 0.1,
        far: 100.0,
    };
    let scene = Scene {
        name: kind.to_string(),
        // No multiple of a tile, nor of the lanes of a register.
        size: [61, 35],
        background: DVec3::ZERO,
        camera,
        lights: lights(kind, ends, &mut random),
        materials,
        objects: objects(kind, &mut random),
        space: scene::Space::World,
        shader: None,
        model: None,
        bind: None,
    };
    (scene, kind)
}

fn bits(colors: &[Vec3]) -> Vec<[u32; 3]> {
    colors.iter().map(|color| color.to_array().map(f32::to_bits)).collect()
}

/// What the lights that a plan leaves out add to any of some fragments by the reference, in steps.
fn lost(plan: &Plan, model: &reference::Model, upload: &Upload, frame: &Frame) -> f64 {
    let mut most = 0f64;
    for draw in &plan.draws {
        for number in draw.fragments.iter().step_by(5) {
            let fragment = &frame.fragments[*number as usize];
            let texels = texels(&upload.materials[fragment.material as usize], fragment.uv);
            let seen = reference::see(model, upload, fragment, &texels).expect("not at the eye");
            let mut sum = DVec3::ZERO;
            for (kind, light) in seen.lights() {
                if draw.lights.of(kind).binary_search(&(light as u32)).is_err() {
                    sum += seen.light(kind, light).expect("not at a light left out").total();
                }
            }
            // Two of opposite signs must not hide each other.
            assert!(sum.cmpge(DVec3::ZERO).all());
            most = most.max(sum.max_element() / STEP);
        }
    }
    most
}

fn models() -> [reference::Model; 2] {
    [SpecularGate::None, SpecularGate::Facing].map(|specular_gate| reference::Model {
        window: Window::Quartic,
        specular_gate,
        ..reference::Model::default()
    })
}

#[test]
fn exact_strategies_change_no_bit_on_generated_scenes() {
    let strategies = ["used", "tiles=8", "tiles=16"];
    let mut left_out = [0; 3];
    for number in 0..SCENES {
        let (scene, kind) = generated(number, true);
        let (upload, frame) = (Upload::new(&scene), Frame::new(&scene, &FrameOptions::default()));
        assert!(frame.fragments.len() > 500, "{kind}: {}", frame.fragments.len());
        for truth in models() {
            let model = Model::new(&truth).expect("a compiled model");
            let surfaces = surfaces(&frame, &upload, &model, 0.0);
            let all = bits(&brute(&upload, &frame, &model, ROBUST).colors);
            for (at, text) in strategies.into_iter().enumerate() {
                let plan =
                    culling::plan(&upload, &frame, &model, &culling::parse(text).expect(text));
                let drawn: usize = plan.draws.iter().map(|draw| draw.fragments.len()).sum();
                assert_eq!(drawn, frame.fragments.len(), "{kind} {number} {text}");
                left_out[at] += plan.savings.before - plan.evaluations();
                // One fragment at a time, and as many as registers hold.
                let counted = execute::<Work>(&plan, &upload, &surfaces, &model, ROBUST);
                assert!(bits(&counted.colors) == all, "{kind} {number} {text}");
                let wide = execute::<()>(&plan, &upload, &surfaces, &model, ROBUST);
                assert!(bits(&wide.colors) == all, "{kind} {number} {text}, in lanes");
                assert_eq!(lost(&plan, &truth, &upload, &frame), 0.0, "{kind} {number} {text}");
            }
        }
    }
    println!("evaluations left out: {left_out:?}");
    assert!(left_out.iter().skip(1).all(|n| *n > 1_000_000), "{left_out:?}");
}

#[test]
fn budgets_are_kept_on_generated_scenes() {
    let mut spent = 0f64;
    for number in 0..SCENES {
        // Lights of infinite range, which no exact strategy leaves out.
        let (scene, kind) = generated(number, number.is_multiple_of(2));
        let (upload, frame) = (Upload::new(&scene), Frame::new(&scene, &FrameOptions::default()));
        for truth in models() {
            let model = Model::new(&truth).expect("a compiled model");
            let options = culling::parse("budget=2").expect("good");
            let plan = culling::plan(&upload, &frame, &model, &options);
            let Claim::Proven { steps, .. } = plan.savings.steps[0].error else {
                panic!("{:?}", plan.savings.steps)
            };
            let lost = lost(&plan, &truth, &upload, &frame);
            assert!(lost <= steps && steps <= 2.0, "{kind} {number}: {lost} of {steps}");
            spent = spent.max(lost);
        }
    }
    println!("at most {spent} steps lost");
    // Near enough to its bound that a smaller one would be noticed.
    assert!(spent > 0.2, "{spent}");
}

#[test]
fn a_slot_not_in_use_may_hold_what_is_no_number() {
    for number in 0..SCENES {
        let (mut scene, kind) = generated(number, true);
        let [points, spots] = [scene.lights.point.len(), scene.lights.spot.len()];
        let clean = Upload::new(&scene);
        let mut random = Rng::with_seed(number);
        let mut unset = lamp(kind, 0, true, &mut random);
        unset.emission.diffuse = DVec3::NAN;
        unset.position.y = f64::NAN;
        scene.lights.point.push(unset);
        let upload = Upload::new(&scene);
        let frame = Frame::new(&scene, &FrameOptions::default());
        let model = Model::new(&models()[0]).expect("a compiled model");
        let surfaces = surfaces(&frame, &upload, &model, 0.0);
        let directional = scene.lights.directional.len();
        let all = bits(&brute(&clean, &frame, &model, ROBUST).colors);
        for strategy in ["used", "tiles=8", "tiles=16", "budget=2"] {
            let lit = |upload: &Upload, slots: [Option<u32>; 3]| {
                let options = culling::parse(strategy).expect("good");
                let options = culling::Options { slots, ..options };
                let plan = culling::plan(upload, &frame, &model, &options);
                execute::<()>(&plan, upload, &surfaces, &model, ROBUST).colors
            };
            let slots = [directional, points, spots].map(|slots| Some(slots as u32));
            let unused = bits(&lit(&upload, slots));
            assert!(unused == bits(&lit(&clean, [None; 3])), "{kind} {number} {strategy}");
            // A budget leaves light out.
            assert!(unused == all || strategy.starts_with("budget"), "{kind} {number} {strategy}");
            // In use, it is in every list, and every fragment shows it.
            let used = lit(&upload, [None; 3]);
            assert!(used.iter().all(|color| color.is_nan()), "{kind} {number} {strategy}");
        }
    }
}
