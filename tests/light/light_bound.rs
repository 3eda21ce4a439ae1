//! What every cull rests on: no point of a region gets more of a light than its bound there, by
//! the reference in `f64`; and where the bound is zero, `f32` arithmetic of either form gives
//! exactly zero.

use glam::{DVec3, Vec3};
use landfall_light::bind::Kind;
use landfall_light::culling::bound::bounded;
use landfall_light::culling::region::Region;
use landfall_light::reference;
use landfall_light::reference::{Family, SpecularGate, Window};
use landfall_light::sample::texels;
use landfall_light::scene;
use landfall_light::scene::{
    Attenuation, Cone, DirectionalLight, Emission, Material, PointLight, Space, SpotLight, Surface,
};
use landfall_light::shading_f32;
use landfall_light::shading_f32::{Form, Gates, Lights, Shaded, Work, shade_all};
use landfall_light::{Fragment, Upload};

struct Random(fastrand::Rng);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        f64::from((low + (high - low) * self.0.f64()) as f32)
    }

    fn power(&mut self, low: f64, high: f64) -> f64 {
        f64::from(10f64.powf(low + (high - low) * self.0.f64()) as f32)
    }

    fn vector(&mut self, most: f64) -> DVec3 {
        DVec3::new(self.between(-most, most), self.between(-most, most), self.between(-most, most))
    }

    fn color(&mut self) -> DVec3 {
        DVec3::new(self.between(0.0, 1.0), self.between(0.0, 1.0), self.between(0.0, 1.0))
    }

    fn coin(&mut self) -> bool {
        self.0.bool()
    }

    fn emission(&mut self) -> Emission {
        let dark = if self.coin() { 0.0 } else { 1.0 };
        Emission {
            ambient: self.color() * dark * 0.1,
            diffuse: self.color(),
            specular: self.color() * dark,
            color: self.color(),
            intensity: self.between(0.0, 2.0),
        }
    }

    fn lamp(&mut self) -> PointLight {
        let reach = self.power(-0.5, 1.5);
        PointLight {
            position: self.vector(12.0).as_vec3().as_dvec3(),
            emission: self.emission(),
            attenuation: Attenuation {
                constant: self.power(-1.0, 0.5),
                linear: if self.coin() { 0.0 } else { self.power(-3.0, 0.0) },
                quadratic: self.power(-4.0, 0.5),
                range: Some(f64::from(reach as f32)),
            },
        }
    }

    fn spot(&mut self) -> SpotLight {
        let outer = if self.coin() { self.power(-1.0, 1.5) } else { self.between(1.0, 175.0) };
        let inner = outer * self.between(0.1, 0.95);
        let cos = |degrees: f64| f64::from(degrees.to_radians().cos() as f32);
        let given = self.coin();
        SpotLight {
            point: self.lamp(),
            direction: self.vector(1.0).as_vec3().as_dvec3(),
            cone: Cone {
                inner_cos: cos(inner),
                outer_cos: cos(outer),
                degrees: given.then_some([inner, outer]),
            },
        }
    }

    fn upload(&mut self) -> Upload {
        let material = Material {
            name: "any".to_string(),
            ambient: Surface::Constant(self.color()),
            diffuse: Surface::Constant(self.color()),
            specular: Surface::Constant(self.color()),
            shininess: f64::from([1, 2, 7, 32, 256, 300][self.0.usize(..6)]),
            reflectance: self.between(0.0, 1.0),
        };
        let direction = self.vector(1.0).as_vec3().as_dvec3();
        Upload {
            space: Space::World,
            camera: self.vector(20.0).as_vec3().as_dvec3(),
            lights: scene::Lights {
                ambient: None,
                directional: vec![DirectionalLight { direction, emission: self.emission() }],
                point: vec![self.lamp()],
                spot: vec![self.spot()],
            },
            materials: vec![material],
        }
    }

    /// Points of a box, their normals around a direction; and what is known of all of them.
    fn region(&mut self, upload: &Upload) -> (Vec<Fragment>, Region) {
        let middle = self.vector(10.0);
        let half = DVec3::new(self.power(-2.0, 0.7), self.power(-2.0, 0.7), self.power(-2.0, 0.7));
        let axis = self.vector(1.0);
        let spread = if self.coin() { 0.0 } else { self.between(0.0, 1.5) };
        let mut region = Region::EMPTY;
        let fragments = (0..24).map(|i| {
            // Corners first, where bounds are met.
            let at = match i {
                0..8 => DVec3::new(
                    f64::from(i & 1) * 2.0 - 1.0,
                    f64::from(i >> 1 & 1) * 2.0 - 1.0,
                    f64::from(i >> 2 & 1) * 2.0 - 1.0,
                ),
                _ => self.vector(1.0),
            };
            let position = (middle + half * at).as_vec3();
            let normal = (axis + self.vector(1.0) * spread).as_vec3();
            let unit = normal.as_dvec3().normalize();
            region.low = region.low.min(position.as_dvec3());
            region.high = region.high.max(position.as_dvec3());
            let normals = region.normals.expect("they have directions");
            region.normals = Some([normals[0].min(unit), normals[1].max(unit)]);
            Fragment {
                pixel: 0,
                material: 0,
                object: 0,
                position: position.to_array(),
                normal: normal.to_array(),
                uv: [0.0; 2],
            }
        });
        let fragments: Vec<Fragment> = fragments.collect();
        let material = texels(&upload.materials[0], [0.0; 2]);
        region.body = material.ambient.max(material.diffuse);
        region.shine = material.specular;
        (fragments, region)
    }
}

fn models() -> Vec<reference::Model> {
    let families = [Family::Multi, Family::Array, Family::ViewSpace];
    let windows = [Window::None, Window::Quartic];
    let gates = [SpecularGate::None, SpecularGate::Facing];
    let mut models = Vec::new();
    for family in families {
        for window in windows {
            for specular_gate in gates {
                models.push(reference::Model {
                    window,
                    specular_gate,
                    ..reference::Model::new(family)
                });
            }
        }
    }
    models
}

#[test]
fn no_point_of_a_region_gets_more_of_a_light_than_its_bound() {
    let mut random = Random(fastrand::Rng::with_seed(20));
    let (mut held, mut met, mut zero) = (0, 0, 0);
    for round in 0..400 {
        let upload = random.upload();
        let (fragments, region) = random.region(&upload);
        for model in models() {
            let switches = shading_f32::Model::new(&model).expect("known");
            for light in bounded(&upload, &switches) {
                let most = light.most(&region, &switches);
                assert!(light.shape.is_ok(), "{light:?}");
                let mut largest = 0f64;
                for fragment in &fragments {
                    let texels = texels(&upload.materials[0], fragment.uv);
                    let Ok(seen) = reference::see(&model, &upload, fragment, &texels) else {
                        continue;
                    };
                    let Ok(given) = seen.light(light.kind, 0) else { continue };
                    let given = given.total();
                    assert!(
                        given.cmpge(DVec3::ZERO).all() && given.cmple(most).all(),
                        "round {round}, {:?} of {:?}: {given} is above {most}",
                        light.kind,
                        model.family,
                    );
                    held += 1;
                    largest = largest.max((given / most).max_element());
                }
                met += usize::from(largest > 0.5);
                zero += usize::from(most == DVec3::ZERO);
            }
        }
    }
    println!("{held} contributions held; {met} bounds within twice; {zero} bounds of zero");
    // Bounds that never come near, or never are zero, would hold too.
    assert!(held > 300_000 && met > 2_000 && zero > 2_000, "{held} {met} {zero}");
}

#[test]
fn light_whose_bound_is_zero_gives_exactly_zero_in_f32() {
    let mut random = Random(fastrand::Rng::with_seed(21));
    let (mut zero, mut edge) = (0, 0);
    for _ in 0..1500 {
        let mut upload = random.upload();
        let (fragments, mut region) = random.region(&upload);
        if random.coin() {
            // Just beyond the window of the nearest corner, where a margin is needed.
            let lamp = &mut upload.lights.point[0];
            let reach = region.distance(lamp.position);
            let off = 1.0 + random.between(-3e-6, 3e-6);
            lamp.attenuation.range = Some(f64::from((reach * off).max(1e-3) as f32));
        }
        if random.coin() {
            // Just below the lamp's horizon: all normals one, across the way to a corner.
            let corner = DVec3::from(fragments[0].position.map(f64::from));
            let to = upload.lights.point[0].position - corner;
            let tilt = to.normalize() * random.between(-4e-6, 4e-6);
            let normal = to.any_orthonormal_vector() + tilt;
            let normal = normal.as_vec3();
            region.normals = Some([normal.as_dvec3().normalize(); 2]);
            [region.low, region.high] = [corner; 2];
            upload.lights.point[0].emission.ambient = DVec3::ZERO;
            let one = Fragment { normal: normal.to_array(), ..fragments[0] };
            edge += check(&upload, &[one], &region);
            continue;
        }
        zero += check(&upload, &fragments, &region);
    }
    println!("{zero} regions and {edge} single points with a bound of zero");
    assert!(zero > 1_000 && edge > 200, "{zero} {edge}");
}

fn check(upload: &Upload, fragments: &[Fragment], region: &Region) -> usize {
    let mut zero = 0;
    for model in models() {
        let model = shading_f32::Model::new(&model).expect("known");
        for light in bounded(upload, &model) {
            if light.most(region, &model) != DVec3::ZERO {
                continue;
            }
            zero += 1;
            let all = Lights::new(upload, &model);
            let mut alone = Lights::default();
            match light.kind {
                Kind::Directional => alone.directional = all.directional,
                Kind::Point => alone.point = all.point,
                Kind::Spot => alone.spot = all.spot,
            }
            let surfaces: Vec<_> =
                fragments.iter().map(|f| shading_f32::surface(f, upload, &model)).collect();
            for form in [Form::Seed, Form::Robust(Gates::NONE), Form::Robust(Gates::ALL)] {
                let eye = upload.camera.as_vec3();
                let shaded: Shaded<Work> = shade_all(&surfaces, eye, &alone, &model, form);
                for color in shaded.colors {
                    assert_eq!(color, Vec3::ZERO, "{:?} {form:?}", light.kind);
                }
            }
        }
    }
    zero
}
