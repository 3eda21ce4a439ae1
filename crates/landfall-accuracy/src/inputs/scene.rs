//! Values like those of published scenes, by the role of each input: a light, a fragment, an eye
//! and a cone, placed so that special cases occur.
//!
//! Used by the [`sampler`](super::sampler) and by [`stress`](crate::stress).

use glam::DVec3;

use super::input::{Input, Inputs, Sample};
use super::random::Random;
use super::role::InputRole;
use landfall_layout::shape::ScalarKind;

/// The arrangement of light, fragment and eye.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Geometry {
    Ordinary,
    /// The fragment is on the axis of the cone.
    OnAxis,
    /// The fragment is between the inner and the outer cone.
    InRamp,
    /// The fragment is on the outer cone.
    AtEdge,
    /// The eye is in the mirror direction.
    Mirror,
    /// The light is below the horizon, the eye in its mirror direction.
    Behind,
    Near,
    Far,
    /// The light is on the horizon.
    Grazing,
}

pub(crate) const GEOMETRIES: [Geometry; 9] = [
    Geometry::Ordinary,
    Geometry::OnAxis,
    Geometry::InRamp,
    Geometry::AtEdge,
    Geometry::Mirror,
    Geometry::Behind,
    Geometry::Near,
    Geometry::Far,
    Geometry::Grazing,
];

/// The half angles of the inner and outer cones, in degrees.
pub(crate) const CONES: [(f64, f64); 6] =
    [(12.5, 17.5), (12.5, 15.0), (30.0, 60.0), (0.5, 1.0), (0.1, 0.2), (0.05, 0.06)];

pub(crate) const SHINES: [f32; 10] =
    [32.0, 1.0, 10.0, 64.0, 256.0, 1024.0, 4096.0, 65536.0, 1.0e6, 1.0e7];

/// Constant, linear and quadratic coefficients of Ogre's table; the last has no constant.
const ATTENUATIONS: [[f32; 3]; 8] = [
    [1.0, 0.7, 1.8],
    [1.0, 0.35, 0.44],
    [1.0, 0.22, 0.20],
    [1.0, 0.14, 0.07],
    [1.0, 0.09, 0.032],
    [1.0, 0.045, 0.0075],
    [1.0, 0.007, 0.0002],
    [0.0, 0.0, 1.0],
];

/// Returns the direction of a vector; divided, since `normalize` multiplies by a rounded inverse.
fn unit(a: DVec3) -> DVec3 {
    a / a.length()
}

/// Rounds a vector to `f32`.
fn single(a: DVec3) -> DVec3 {
    a.as_vec3().as_dvec3()
}

/// Returns a direction at an angle from another.
fn turned(a: DVec3, angle: f64, random: &mut Random) -> DVec3 {
    let side = loop {
        let drawn = random.direction();
        let side = drawn - a * drawn.dot(a);
        if side.length_squared() > 1e-3 {
            break unit(side);
        }
    };
    a * angle.cos() + side * angle.sin()
}

/// The choices made for a scene before its values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SceneSetting {
    pub geometry: Geometry,
    pub cone: usize,
    pub shine: usize,
    /// Whether the numbers of tables are taken as they are, not spread around.
    pub exact: bool,
}

/// The arrangements in a picture, the most likely first.
const USUAL: [Geometry; 8] = [
    Geometry::Ordinary,
    Geometry::Ordinary,
    Geometry::Ordinary,
    Geometry::OnAxis,
    Geometry::InRamp,
    Geometry::Mirror,
    Geometry::Behind,
    Geometry::Grazing,
];

/// The widest of the cones, and the exponents up to 256.
const USUAL_CONES: usize = 3;
const USUAL_SHINES: usize = 5;

/// The share of usual scenes with the numbers of tables.
const EXACT: f64 = 0.125;

impl SceneSetting {
    pub fn random(random: &mut Random) -> SceneSetting {
        SceneSetting {
            geometry: *random.pick(&GEOMETRIES),
            cone: random.below(CONES.len()),
            shine: random.below(SHINES.len()),
            exact: true,
        }
    }

    /// Returns the choices for a scene as in pictures. No float has one value in more than a
    /// quarter of such scenes, but for the last coordinate of a position.
    pub fn usual(random: &mut Random) -> SceneSetting {
        SceneSetting {
            geometry: *random.pick(&USUAL),
            cone: random.below(USUAL_CONES),
            shine: random.below(USUAL_SHINES),
            exact: random.chance(EXACT),
        }
    }

    /// Returns a number that identifies the setting.
    pub fn tag(self) -> usize {
        let geometry = GEOMETRIES.iter().position(|g| *g == self.geometry).unwrap_or(0);
        (geometry * CONES.len() + self.cone) * SHINES.len() + self.shine
    }
}

/// A light relative to the fragment.
struct Light {
    position: DVec3,
    to_light: DVec3,
    distance: f64,
    axis: DVec3,
    cone: (f64, f64),
    attenuation: [f32; 3],
}

fn light(setting: &SceneSetting, fragment: DVec3, normal: DVec3, random: &mut Random) -> Light {
    let behind = setting.geometry == Geometry::Behind;
    let height = match setting.geometry {
        Geometry::Behind => -random.between(0.01, 0.4),
        Geometry::Grazing => random.scale(1e-6, 1e-2),
        _ => random.between(0.05, 1.0),
    };
    let flat = turned(normal, std::f64::consts::FRAC_PI_2, random);
    let to_light = flat * (1.0 - height * height).sqrt() + normal * height;
    let distance = match setting.geometry {
        Geometry::Near => random.scale(1e-6, 1e-2),
        Geometry::Far => random.scale(1e2, 1e5),
        Geometry::Mirror => random.scale(0.1, 3.0),
        _ => random.scale(0.1, 50.0),
    };
    // The position is rounded first, and the rest follows from the rounded one, as in a shader.
    let position = single(fragment + to_light * distance);
    let path = position - fragment;
    let (distance, to_light) = match path.length_squared() > 0.0 {
        true => (path.length(), unit(path)),
        false => (0.0, to_light),
    };
    let mut spread = |x: f64| if setting.exact { x } else { x * random.scale(0.7, 1.4) };
    let cone = CONES[setting.cone];
    let inner = spread(cone.0);
    let (inner, outer) = (inner.to_radians(), (inner + spread(cone.1 - cone.0)).to_radians());
    let angle = match setting.geometry {
        Geometry::OnAxis => 0.0,
        Geometry::InRamp => random.between(inner, outer),
        Geometry::AtEdge => outer,
        _ if behind => 0.0,
        _ => random.between(0.0, 2.0 * outer),
    };
    let axis = turned(-to_light, angle, random);
    let table = *random.pick(&ATTENUATIONS);
    let attenuation = match setting.exact {
        true => table,
        false => table.map(|x| x * random.scale(0.5, 2.0) as f32),
    };
    Light { position, to_light, distance, axis, cone: (inner.cos(), outer.cos()), attenuation }
}

/// Returns a sample of a scene; the setting determines the light of one owner.
pub(crate) fn sample(inputs: &Inputs, setting: SceneSetting, random: &mut Random) -> Sample {
    let mut to = vec![0u64; inputs.scalars];
    let fragment = single(DVec3::from([0; 3].map(|_| random.between(-5.0, 5.0))));
    let normal = random.direction();
    let owners: Vec<&str> = {
        let lit = |i: &&Input| {
            i.role == InputRole::LightPosition || i.role.is_cone() || i.role == InputRole::Axis
        };
        let mut owners: Vec<&str> = inputs.iter().filter(lit).map(|i| i.owner.as_str()).collect();
        owners.dedup();
        owners
    };
    // One light has the geometry of the setting, and the others are ordinary.
    let focus = if owners.is_empty() { "" } else { *random.pick(&owners) };
    let main = light(&setting, fragment, normal, random);
    let mirror = normal * (2.0 * normal.dot(main.to_light)) - main.to_light;
    let to_view = to_view(setting.geometry, mirror, normal, random);
    let view = fragment + to_view * random.scale(0.5, 20.0);
    let mut others: Vec<(String, Light)> = Vec::new();
    for input in inputs.iter() {
        if !input.is_float() {
            integers(input, &mut to, random);
            continue;
        }
        let of_light = input.role == InputRole::LightPosition
            || input.role == InputRole::Axis
            || input.role.is_cone()
            || input.role.is_attenuation();
        let nested = |owner: &str| {
            input.owner == owner
                || input.owner.starts_with(&format!("{owner}."))
                || owner.starts_with(&format!("{}.", input.owner))
        };
        let main_light = focus.is_empty() || input.owner.is_empty() || nested(focus) || !of_light;
        let source = if main_light {
            &main
        } else {
            let known = others.iter().position(|(owner, _)| *owner == input.owner);
            let known = known.unwrap_or_else(|| {
                let setting = SceneSetting {
                    geometry: Geometry::Ordinary,
                    exact: setting.exact,
                    ..SceneSetting::random(random)
                };
                let other = light(&setting, fragment, normal, random);
                others.push((input.owner.clone(), other));
                others.len() - 1
            });
            &others[known].1
        };
        let mut put = |values: &[f64], last: f64| {
            for (i, at) in input.range().enumerate() {
                let x = values.get(i).copied().unwrap_or(last);
                to[at] = u64::from((x as f32).to_bits());
            }
        };
        match input.role {
            InputRole::LightPosition => put(source.position.as_ref(), 1.0),
            InputRole::FragmentPosition => put(fragment.as_ref(), 1.0),
            InputRole::ViewPosition => put(view.as_ref(), 1.0),
            InputRole::Axis => {
                let length = if random.chance(0.5) { 1.0 } else { random.scale(0.5, 2.0) };
                put((source.axis * length).as_ref(), 0.0);
            }
            InputRole::ToLight => put(source.to_light.as_ref(), 0.0),
            InputRole::ToView => put(to_view.as_ref(), 0.0),
            InputRole::Normal => put(normal.as_ref(), 0.0),
            // Not quite the sum: exactly opposite directions would have none.
            InputRole::Halfway => {
                put(unit(main.to_light + to_view * (1.0 + 1e-9)).as_ref(), 0.0);
            }
            InputRole::Reflected => put(mirror.as_ref(), 0.0),
            InputRole::Color => put(&color(setting, random)[..input.len.min(3)], 1.0),
            InputRole::Constant => put(&[f64::from(source.attenuation[0])], 0.0),
            InputRole::Linear => put(&[f64::from(source.attenuation[1])], 0.0),
            InputRole::Quadratic => put(&[f64::from(source.attenuation[2])], 0.0),
            InputRole::Attenuation => put(&source.attenuation.map(f64::from), 0.0),
            InputRole::InnerCosine => put(&[source.cone.0], 0.0),
            InputRole::OuterCosine => put(&[source.cone.1], 0.0),
            InputRole::ConeCosine => put(&[source.cone.1], 0.0),
            InputRole::Cosine => {
                let x = match random.below(4) {
                    0 => 1.0 - random.scale(1e-7, 1e-1),
                    _ => random.between(-1.0, 1.0),
                };
                put(&[x], 0.0);
            }
            InputRole::Shininess => put(&[shininess(setting, random)], 0.0),
            InputRole::Intensity => put(&[random.between(0.1, 2.0)], 1.0),
            InputRole::Distance => put(&[main.distance], 0.0),
            InputRole::Count | InputRole::Other => other(input, &mut put, setting.exact, random),
        }
    }
    to
}

fn color(setting: SceneSetting, random: &mut Random) -> [f64; 3] {
    let table = *random.pick(&[0.05, 0.2, 0.5, 0.8, 1.0]);
    let value = if setting.exact { table } else { random.unit() };
    let mixed = random.chance(0.5);
    [0; 3].map(|_| if mixed { random.unit() } else { value })
}

fn shininess(setting: SceneSetting, random: &mut Random) -> f64 {
    match setting.exact {
        true => f64::from(SHINES[setting.shine]),
        false => random.scale(1.0, 256.0),
    }
}

/// Returns the direction from the fragment to the eye, relative to the mirrored light.
fn to_view(geometry: Geometry, mirror: DVec3, normal: DVec3, random: &mut Random) -> DVec3 {
    match geometry {
        Geometry::Mirror => mirror,
        Geometry::Behind => {
            let lift = (0.02 - mirror.dot(normal)).max(0.0);
            unit(mirror + normal * lift)
        }
        _ if random.chance(0.5) => turned(mirror, random.scale(1e-4, 0.5), random),
        _ => {
            let v = random.direction();
            if v.dot(normal) < 0.0 { -v } else { v }
        }
    }
}

fn integers(input: &Input, to: &mut Sample, random: &mut Random) {
    for at in input.range() {
        to[at] = match (input.scalar.kind, input.scalar.width) {
            (ScalarKind::Bool, _) => random.word() & 1,
            (ScalarKind::Float, 8) => random.between(-2.0, 2.0).to_bits(),
            _ if input.role == InputRole::Count => random.below(5) as u64,
            _ => random.below(8) as u64,
        };
    }
}

fn other(input: &Input, put: &mut dyn FnMut(&[f64], f64), exact: bool, random: &mut Random) {
    if input.len > input.rows {
        // A matrix: the identity with a slight rotation and translation.
        let mild = random.chance(0.5) || !exact;
        let rows = input.rows;
        let values: Vec<f64> = (0..input.len)
            .map(|i| {
                let diagonal = f64::from(u8::from(i / rows == i % rows));
                diagonal + if mild { random.between(-0.5, 0.5) } else { 0.0 }
            })
            .collect();
        return put(&values, 0.0);
    }
    let spread = *random.pick(&[1.0, 2.0, 100.0]);
    let positive = random.chance(0.5);
    let values: Vec<f64> = (0..input.len)
        .map(|_| random.between(if positive { 0.0 } else { -spread }, spread))
        .collect();
    put(&values, 0.0);
}
