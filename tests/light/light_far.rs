//! Far lights interpolated keep the error that their plan proves, by the reference in `f64`.

use glam::{DMat4, DVec3};
use landfall_light::culling;
use landfall_light::culling::{Claim, STEP};
use landfall_light::reference;
use landfall_light::reference::{SpecularGate, Window};
use landfall_light::sample::texels;
use landfall_light::scene::{Attenuation, Emission, Material, Object, PointLight, Scene, Surface};
use landfall_light::shading_f32::{Form, Gates, Model, Shaded, Work, execute, surfaces};
use landfall_light::{Frame, FrameOptions, Upload};

/// The error of `f32` and of adding in another order, in steps.
const ROUNDING: f64 = 1e-2;

struct Random(fastrand::Rng);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.f64()
    }

    fn lamp(&mut self, position: DVec3, strength: f64) -> PointLight {
        let color = DVec3::new(self.0.f64(), self.0.f64(), self.0.f64());
        let [constant, linear, quadratic] = [
            [1.0, 0.35, 0.44],
            [1.0, 0.14, 0.07],
            [0.0, 0.0, 1.0],
            [0.5, 0.7, 0.0],
            [1.0, 0.0, 0.2],
        ][self.0.usize(0..5)];
        let attenuation = Attenuation { constant, linear, quadratic, range: None };
        let sent = color * strength;
        let emission = Emission {
            ambient: sent * self.between(0.0, 0.05),
            diffuse: sent,
            specular: sent,
            color,
            intensity: strength,
        };
        PointLight { position, emission, attenuation }
    }

    /// The lights of one of several arrangements.
    fn lights(&mut self, kind: usize) -> Vec<PointLight> {
        let count = [160, 160, 144, 200, 120, 0, 1, 150][kind];
        let strength = 0.6;
        let place = |random: &mut Random, i: usize| match kind {
            // A corridor, a cloud, a grid, all in one place.
            0 => DVec3::new(random.between(-1.5, 1.5), 2.5, random.between(-20.0, 20.0)),
            1 => DVec3::new(
                random.between(-20.0, 20.0),
                random.between(0.2, 9.0),
                random.between(-20.0, 20.0),
            ),
            2 => DVec3::new((i % 12) as f64 * 3.0 - 17.0, 3.0, (i / 12) as f64 * 3.0 - 17.0),
            3 => DVec3::new(
                random.between(3.0, 3.4),
                random.between(0.5, 1.0),
                random.between(3.0, 3.4),
            ),
            // Below the floor, in it and touching it.
            4 => DVec3::new(
                random.between(-9.0, 9.0),
                [-2.0, 0.0, 1e-4][i % 3],
                random.between(-9.0, 9.0),
            ),
            // Behind the camera.
            _ => DVec3::new(
                random.between(-20.0, 20.0),
                random.between(0.5, 6.0),
                random.between(12.0, 30.0),
            ),
        };
        (0..count)
            .map(|i| {
                let position = place(self, i);
                self.lamp(position, if i % 9 == 8 { 0.0 } else { strength })
            })
            .collect()
    }

    fn scene(&mut self, number: usize, mut scene: Scene) -> Scene {
        let material = |shininess: f64, random: &mut Random| Material {
            diffuse: Surface::Constant(DVec3::splat(random.between(0.2, 0.8))),
            specular: Surface::Constant(DVec3::splat(random.between(0.05, 0.5))),
            shininess,
            ..scene.materials[0].clone()
        };
        let base = std::mem::take(&mut scene.objects);
        let shininess = [32.0, 8.0, 128.0, 10.5][number % 4];
        scene.materials = vec![material(shininess, self), material(32.0, self)];
        let floor = DMat4::from_scale(DVec3::new(40.0, 1.0, 40.0));
        scene.objects = vec![Object { material: 0, transform: floor, ..base[0].clone() }];
        for _ in 0..6 {
            let at = DVec3::new(self.between(-8.0, 8.0), 1.0, self.between(-8.0, 8.0));
            let turned = DMat4::from_rotation_y(self.between(0.0, 3.0))
                * DMat4::from_rotation_x(self.between(0.0, 1.0));
            let transform =
                DMat4::from_translation(at) * turned * DMat4::from_scale(DVec3::splat(2.0));
            scene.objects.push(Object { material: 1, transform, ..base[1].clone() });
        }
        scene.lights.point = self.lights(number % 8);
        if number % 7 == 3 {
            for (i, light) in scene.lights.point.iter_mut().enumerate() {
                // Without a bound: kept exact everywhere.
                if i % 11 == 0 {
                    light.emission.diffuse = -light.emission.diffuse;
                }
            }
        }
        // Plain lights, which are lit with fused operations.
        if number % 2 == 1 {
            scene.lights.point.iter_mut().for_each(|light| light.emission.ambient = DVec3::ZERO);
        }
        scene.size = [160, 90];
        scene
    }
}

fn truth(specular_gate: SpecularGate) -> reference::Model {
    reference::Model { window: Window::None, specular_gate, ..reference::Model::default() }
}

fn base() -> Scene {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders/scenes");
    let reading = landfall_light::scene::read_file(folder.join("lights_1024.json"));
    let mut scene = reading.expect("a scene of ours").scene.expect("it is good");
    scene.camera.position = DVec3::new(0.0, 5.0, 14.0);
    scene
}

#[test]
fn far_lights_err_by_no_more_than_proven_on_20_scenes() {
    let base = base();
    let mut random = Random(fastrand::Rng::with_seed(31));
    let (mut applied, mut nearest, mut fewer) = (0, 0f64, 0);
    for number in 0..20 {
        let scene = random.scene(number, base.clone());
        let frame = Frame::new(&scene, &FrameOptions::default());
        let upload = Upload::new(&scene);
        // In every fifth scene the array of the shader goes on with what is no number.
        let slots = scene.lights.point.len();
        let mut scene = scene;
        if number % 5 == 2 {
            let mut unset = random.lamp(DVec3::splat(f64::NAN), 1.0);
            unset.emission.diffuse = DVec3::NAN;
            scene.lights.point.push(unset);
        }
        let uploaded = Upload::new(&scene);
        let gate = [SpecularGate::None, SpecularGate::Facing][number % 2];
        let truth = truth(gate);
        let model = Model::of(&truth).expect("known");
        let steps = [0.5, 0.05, 2.0][number % 3];
        let nodes = [4, 6, 8][number % 3];
        let parts = format!("slots={slots},far={steps}x{nodes},always");
        let plan = culling::plan(&uploaded, &frame, &model, &culling::parse(&parts).expect("good"));
        let Claim::Proven { steps: proven, .. } = plan.savings.steps[0].error else { panic!() };
        assert!(proven <= steps, "{proven}");
        let surfaces = surfaces(&frame, &upload, &model, 0.0);
        let lit: Shaded<()> =
            execute(&plan, &uploaded, &surfaces, &model, Form::Robust(Gates::ALL));
        let mut most = 0f64;
        for (fragment, color) in frame.fragments.iter().zip(&lit.colors).step_by(3) {
            let texels = texels(&upload.materials[fragment.material as usize], fragment.uv);
            let Ok(exact) = reference::shade(&truth, &upload, fragment, &texels) else { continue };
            // Beside a light within a hair of the surface `f32` is off by more than a step alone.
            let rounding = 1e-6 * exact.total.abs().max_element() / STEP + ROUNDING;
            let error = (color.as_dvec3() - exact.total).abs().max_element() / STEP;
            assert!(error <= proven + rounding, "scene {number}: {error} steps, {proven} proven");
            most = most.max(error - rounding);
        }
        applied += usize::from(!plan.grids.is_empty());
        fewer += usize::from(2 * plan.evaluations() < plan.savings.before);
        nearest = nearest.max(most / proven.max(1e-9));
        println!(
            "{number}: {most:.1e} of {proven:.2} steps; {} of {}",
            plan.evaluations(),
            plan.savings.before
        );
    }
    println!(
        "{applied} scenes with grids, {fewer} at half the evaluations; {nearest} of the bound"
    );
    assert!(applied >= 12 && fewer >= 6, "{applied} {fewer}");
}

/// Several fragments at once have the colours of one at a time up to rounding, and the same bits where
/// the fused form overflows.
#[test]
fn fused_operations_differ_by_rounding() {
    let form = Form::Robust(Gates::ALL);
    let mut random = Random(fastrand::Rng::with_seed(5));
    for (round, shininess) in [32.0, 16.0, 64.0, 8.0, 12.0, 32.0].into_iter().enumerate() {
        let mut scene = random.scene(1, base());
        scene.materials.iter_mut().for_each(|material| material.shininess = shininess);
        let frame = Frame::new(&scene, &FrameOptions::default());
        // Beside a lamp the distance times the attenuation's divisor is no normal number.
        let beside = (round == 5).then_some(7000);
        if let Some(number) = beside {
            let at = DVec3::from(frame.fragments[number].position.map(f64::from));
            scene.lights.point[3].position = at + DVec3::Y * 0.01;
            scene.lights.point[3].attenuation =
                Attenuation { constant: 0.0, linear: 0.0, quadratic: 1e-33, range: None };
        }
        // Here it is larger than any number for all fragments, and what is lit an ordinary colour.
        if round == 4 {
            let light = &mut scene.lights.point[3];
            light.attenuation =
                Attenuation { constant: 0.0, linear: 0.0, quadratic: 1e36, range: None };
            light.emission.diffuse = DVec3::splat(1e36);
        }
        let upload = Upload::new(&scene);
        let gate = [SpecularGate::None, SpecularGate::Facing][round % 2];
        let truth = truth(gate);
        let model = Model::of(&truth).expect("known");
        let options = culling::parse("far=0.5,always").expect("good");
        let plan = culling::plan(&upload, &frame, &model, &options);
        assert!(!plan.grids.is_empty());
        let surfaces = surfaces(&frame, &upload, &model, 0.0);
        let single = execute::<Work>(&plan, &upload, &surfaces, &model, form).colors;
        let several = execute::<()>(&plan, &upload, &surfaces, &model, form).colors;
        let mut others = 0;
        for (number, (single, several)) in single.iter().zip(&several).enumerate() {
            let off = (*single - *several).abs().max_element();
            let most = 2e-5 * single.abs().max_element().max(1e-3);
            assert!(off <= most, "{round}, {number}: {several} beside {single}");
            others += usize::from(off > 0.0);
        }
        assert!(round == 4 || others > 1000, "{others} are fused");
        if let Some(number) = beside {
            assert!(single[number].max_element() > 1e33, "{}", single[number]);
            assert_eq!(single[number].to_array(), several[number].to_array());
        }
    }
}
