//! The points of the tables, drawn as points.py draws them: see there for what a draw is.
//!
//! Feeds the test beside it. Every product and sum is in the script's order: the bits are equal.

use glam::DVec3;
use landfall_light::reference::*;
use landfall_light::sample::Texels;
use landfall_light::scene::{
    Ambient, Attenuation, Cone, DirectionalLight, Emission, Lights, Material, PointLight, Space,
    SpotLight, Surface,
};
use landfall_light::{Fragment, Upload};

pub const FAMILIES: [(&str, Family); 4] = [
    ("multi", Family::Multi),
    ("array", Family::Array),
    ("view_space", Family::ViewSpace),
    ("casters", Family::Casters),
];

const HAZARDS: u64 = 14;

pub struct Point {
    pub model: Model,
    pub upload: Upload,
    pub fragment: Fragment,
    pub texels: Texels,
}

struct Draw(u64);

impl Draw {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    fn whole(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    fn part(&mut self) -> f64 {
        (self.next() >> 40) as f64 / 16_777_216.0
    }

    fn sign(&mut self) -> f64 {
        self.part() * 2.0 - 1.0
    }

    fn log(&mut self, a: i32, b: i32) -> f64 {
        let e = a + self.whole((b - a) as u64) as i32;
        (1.0 + (self.next() >> 41) as f64 / 8_388_608.0) * 2f64.powi(e)
    }

    fn three(&mut self, one: fn(&mut Draw) -> f64) -> DVec3 {
        DVec3::from_array([one(self), one(self), one(self)])
    }

    fn color(&mut self) -> DVec3 {
        self.three(Draw::part)
    }

    fn direction(&mut self) -> DVec3 {
        let v = self.three(Draw::sign);
        v * (1.0 / dot(v, v).sqrt())
    }

    fn texel(&mut self) -> DVec3 {
        self.three(|d| d.whole(256) as f64 / 255.0)
    }

    fn emission(&mut self) -> Emission {
        Emission {
            ambient: self.color() * 0.25,
            diffuse: self.color(),
            specular: self.color(),
            color: self.color(),
            intensity: self.log(-3, 3),
        }
    }

    fn lamp(&mut self, at: DVec3) -> PointLight {
        let emission = self.emission();
        let away = self.direction();
        let far = self.log(-10, 13);
        let position = rounded(at + away * far);
        let attenuation = Attenuation {
            constant: self.log(-2, 1),
            linear: self.log(-10, 0),
            quadratic: self.log(-20, 0),
            range: Some(single(far * self.log(-1, 3))),
        };
        PointLight { position, emission, attenuation }
    }
}

fn dot(a: DVec3, b: DVec3) -> f64 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

fn single(x: f64) -> f64 {
    f64::from(x as f32)
}

fn rounded(v: DVec3) -> DVec3 {
    DVec3::from_array(v.to_array().map(single))
}

/// Point `number` of a family's table.
pub fn draw(family: usize, number: u64) -> Point {
    let mut d = Draw((family as u64) << 32 | number);
    let mut model = Model::new(FAMILIES[family].1);
    let own = model;
    model.normal = [Normal::Unit, Normal::AsInterpolated][d.whole(2) as usize];
    model.ambient =
        [AmbientTerm::PerLight, AmbientTerm::Once, AmbientTerm::None][d.whole(3) as usize];
    model.specular_gate = [SpecularGate::None, SpecularGate::Facing][d.whole(2) as usize];
    model.highlight = [Highlight::Phong, Highlight::Blinn][d.whole(2) as usize];
    model.window = [Window::None, Window::Quartic][d.whole(2) as usize];
    model.cone_edge = [ConeEdge::Soft, ConeEdge::Hard][(d.whole(4) / 3) as usize];
    model.cone_numbers = [ConeNumbers::Cosines, ConeNumbers::Angles][d.whole(2) as usize];
    model.caster_attenuation =
        [CasterAttenuation::None, CasterAttenuation::Direct, CasterAttenuation::All]
            [d.whole(3) as usize];
    model.array_specular = [ArraySpecular::Fixed, ArraySpecular::AsPublished][d.whole(2) as usize];
    model.reflectance =
        [Reflectance::Ignored, Reflectance::Gate, Reflectance::Factor][d.whole(3) as usize];
    model.power = [Power::Material, Power::Ten][d.whole(2) as usize];
    if number.is_multiple_of(4) {
        model = Model { cone_numbers: model.cone_numbers, ..own };
    }

    let mut at = d.three(Draw::sign) * 8.0;
    let far = d.three(Draw::sign);
    if d.whole(6) == 0 {
        at += far * 1e6;
    }
    let at = rounded(at);
    let (shorter, other, which) = (d.part(), d.sign(), d.whole(2));
    let length = if which == 1 { 1.0 - shorter / 4.0 } else { 1.0 + other / 1024.0 };
    let n = rounded(d.direction() * length);

    let emission = d.emission();
    let sun = DirectionalLight { emission, direction: rounded(d.direction()) };
    let point = d.lamp(at);
    let lamp = d.lamp(at);
    let j = d.whole(23);
    let outer = (1 << j) + d.whole(1 << j);
    let inner = d.whole(outer);
    let same = d.whole(8) == 0;
    let inner = if same { outer } else { inner };
    let cosine = |k: u64| 1.0 - k as f64 / 16_777_216.0;
    let wide = d.log(-7, 6);
    let narrow = single(wide * d.part());
    let degrees = Some([if same { wide } else { narrow }, wide]);
    let aside = match model.cone_numbers {
        ConeNumbers::Angles => wide / 57.0,
        ConeNumbers::Cosines => (outer as f64 / 8_388_608.0).sqrt(),
    };
    let down = at - lamp.position;
    let size = dot(down, down).sqrt();
    let down = if size > 0.0 { down * (1.0 / size) } else { DVec3::Z };
    let aside = aside * (d.part() * 1.25);
    let direction = rounded(down + d.direction() * aside);
    let cone = Cone { inner_cos: cosine(inner), outer_cos: cosine(outer), degrees };
    let spot = SpotLight { point: lamp, direction, cone };
    let kept = |kind| model.family != Family::Casters || number % 3 == kind;
    let ambient = Some(Ambient { color: d.color(), intensity: d.part() });

    let looked = match number % 3 {
        0 => sun.direction,
        1 => at - point.position,
        _ => at - spot.point.position,
    };
    let size = dot(looked, looked).sqrt();
    let to_light = if size > 0.0 { looked * (-1.0 / size) } else { DVec3::Z };
    let unit = n * (1.0 / dot(n, n).sqrt());
    let mirror = unit * (2.0 * dot(unit, to_light)) - to_light;
    let aside = d.direction();
    let mirror = mirror + aside * 2f64.powi(-(d.whole(12) as i32));
    let anywhere = d.direction();
    let away = d.log(-10, 13);
    let camera = rounded(at + if d.whole(2) == 1 { anywhere } else { mirror } * away);

    let shininess = d.log(0, 12);
    let reflectance = if d.whole(4) != 0 { d.part() } else { 0.0 };
    let texels = Texels { ambient: d.texel(), diffuse: d.texel(), specular: d.texel() };
    let material = Material {
        name: String::new(),
        ambient: Surface::Constant(texels.ambient),
        diffuse: Surface::Constant(texels.diffuse),
        specular: Surface::Constant(texels.specular),
        shininess,
        reflectance,
    };
    let lights = Lights {
        ambient,
        directional: Vec::from_iter(kept(0).then_some(sun)),
        point: Vec::from_iter(kept(1).then_some(point)),
        spot: Vec::from_iter(kept(2).then_some(spot)),
    };
    let upload = Upload { space: Space::World, camera, lights, materials: vec![material] };
    let mut fragment = fragment(at, n);
    let mut made = Spoiled { at, n, upload, model };
    if number % 8 == 7 {
        made.spoil(number / 8 % HAZARDS);
        fragment = self::fragment(made.at, made.n);
    }
    Point { model: made.model, upload: made.upload, fragment, texels }
}

/// A fragment of material 0.
pub fn fragment(at: DVec3, n: DVec3) -> Fragment {
    let single = |v: DVec3| v.to_array().map(|x| x as f32);
    Fragment {
        pixel: 0,
        material: 0,
        object: 0,
        position: single(at),
        normal: single(n),
        uv: [0.0; 2],
    }
}

struct Spoiled {
    at: DVec3,
    n: DVec3,
    upload: Upload,
    model: Model,
}

impl Spoiled {
    fn lamps(&mut self, change: impl Fn(&mut PointLight)) {
        let lights = &mut self.upload.lights;
        lights.point.iter_mut().for_each(&change);
        lights.spot.iter_mut().for_each(|spot| change(&mut spot.point));
    }

    fn directions(&mut self, direction: DVec3) {
        self.upload.lights.directional.iter_mut().for_each(|sun| sun.direction = direction);
    }

    fn spoil(&mut self, hazard: u64) {
        let at = self.at;
        match hazard {
            0 | 1 => self.lamps(|lamp| {
                lamp.position = at;
                lamp.attenuation.constant = if hazard == 1 { 0.0 } else { 1.0 };
            }),
            2 => self.upload.camera = at,
            3 => self.lamps(|lamp| {
                let range = lamp.attenuation.range;
                lamp.attenuation =
                    Attenuation { constant: 0.0, linear: 0.0, quadratic: 0.0, range };
            }),
            4 => self.lamps(|lamp| lamp.position = rounded(DVec3::new(0.0, 1e19, 3e18))),
            5 => {
                self.at = DVec3::ZERO;
                self.lamps(|lamp| lamp.position = rounded(DVec3::new(1e-20, 0.0, 1e-17)));
            }
            6 | 7 => {
                self.at = DVec3::new(1.0, 2.0, 3.0);
                for spot in &mut self.upload.lights.spot {
                    spot.point.position = DVec3::new(4.0, 6.0, 5.0);
                    spot.direction = DVec3::new(-3.0, -4.0, -2.0);
                    let (cos, angle) =
                        if hazard == 6 { (1.0 - 2f64.powi(-24), 0.0078125) } else { (1.0, 0.0) };
                    spot.cone =
                        Cone { inner_cos: cos, outer_cos: cos, degrees: Some([angle, angle]) };
                }
            }
            8 | 13 => {
                (self.at, self.n, self.upload.camera) = (DVec3::ZERO, DVec3::Z, DVec3::Z * 2.0);
                self.directions(DVec3::Z);
                self.lamps(|lamp| lamp.position = -DVec3::Z);
                self.upload.lights.spot.iter_mut().for_each(|spot| spot.direction = DVec3::Z);
                self.upload.materials[0].shininess = if hazard == 8 { 0.0 } else { -1.0 };
                self.model.power = Power::Material;
            }
            9 => {
                self.directions(DVec3::ZERO);
                self.upload.lights.spot.iter_mut().for_each(|spot| spot.direction = DVec3::ZERO);
            }
            10 => self.n = DVec3::ZERO,
            11 => {
                let bad = DVec3::new(0.5, f64::NAN, 0.5);
                let change = |e: &mut Emission| (e.diffuse, e.color) = (bad, bad);
                let suns = &mut self.upload.lights.directional;
                suns.iter_mut().for_each(|sun| change(&mut sun.emission));
                self.lamps(|lamp| change(&mut lamp.emission));
            }
            12 => {
                self.at = DVec3::new(1.0, 2.0, 3.0);
                self.upload.camera = DVec3::new(2.0, 4.0, 6.0);
                self.model.highlight = Highlight::Blinn;
                self.directions(DVec3::new(1.0, 2.0, 3.0));
                self.lamps(|lamp| lamp.position = DVec3::ZERO);
            }
            _ => unreachable!("there are {HAZARDS}"),
        }
    }
}

/// The published scene of six lights, at a fragment, all colours of the surface white.
pub fn six_lights() -> Upload {
    let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let gray = |x: f32| DVec3::splat(f64::from(x));
    let emission = |a, d, s| Emission {
        ambient: gray(a),
        diffuse: gray(d),
        specular: gray(s),
        color: DVec3::ONE,
        intensity: 1.0,
    };
    let lamp = |position, emission| PointLight {
        position: wide(position),
        emission,
        attenuation: Attenuation {
            constant: 1.0,
            linear: f64::from(0.09f32),
            quadratic: f64::from(0.032f32),
            range: None,
        },
    };
    let four = [[0.7, 0.2, 2.0], [2.3, -3.3, -4.0], [-4.0, 2.0, -12.0], [0.0, 0.0, -3.0]];
    let cosine = |degrees: f64| single(degrees.to_radians().cos());
    let white = Surface::Constant(DVec3::ONE);
    Upload {
        space: Space::World,
        camera: DVec3::new(0.0, 0.0, 3.0),
        lights: Lights {
            ambient: None,
            directional: vec![DirectionalLight {
                direction: wide([-0.2, -1.0, -0.3]),
                emission: emission(0.05, 0.4, 0.5),
            }],
            point: four.map(|p| lamp(p, emission(0.05, 0.8, 1.0))).to_vec(),
            spot: vec![SpotLight {
                point: lamp([0.0, 0.0, 3.0], emission(0.0, 1.0, 1.0)),
                direction: -DVec3::Z,
                cone: Cone {
                    inner_cos: cosine(12.5),
                    outer_cos: cosine(15.0),
                    degrees: Some([12.5, 15.0]),
                },
            }],
        },
        materials: vec![Material {
            name: "white".into(),
            ambient: white.clone(),
            diffuse: white.clone(),
            specular: white,
            shininess: 32.0,
            reflectance: 1.0,
        }],
    }
}
