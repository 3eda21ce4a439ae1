//! Fragments of a single light whose values separate the readings, with the reference's light.
//!
//! The camera is at the origin, where a shader in view space takes it to be. Each fragment faces
//! it, so that the angles to light and camera are the same for all but the one that is tried. The
//! range is 1 wherever it is not tried, which is its own square and inverse.

use std::f64::consts::PI;
use std::time::Duration;

use glam::DVec3;

use crate::bind::fill::{BlockWriter, FragmentInputs};
use crate::bind::quantity::Kind;
use crate::plan::LightSet;
use crate::reference::{Family, Model, Window, see};
use crate::scene::{
    Attenuation, Cone, DirectionalLight, Emission, Lights, Material, PointLight, Space, SpotLight,
    Surface,
};
use crate::{Chosen, Fragment, Upload, sample};
use landfall_exec::backend::Failure;
use landfall_exec::harness::fragments::{Batch, FragmentShader};
use landfall_interp::Cpu;

/// The light whose members are to be bound.
#[derive(Clone, Copy, Debug)]
pub(super) struct ProbedLight {
    pub kind: Kind,
    /// Its index among its kind; those before it are black.
    pub number: u32,
}

/// Fragments lit by one upload.
#[derive(Debug)]
pub(super) struct Probe {
    probed: ProbedLight,
    upload: Upload,
    pub fragments: Vec<Fragment>,
    /// The reference's light or factor at each fragment.
    pub reference: Vec<f64>,
}

/// The time after which a run is given up; the budget of the command ends before.
/// Given up by the command's own limit long before.
const LIMIT: Duration = Duration::from_secs(3600);

/// The most black lights that fill an array.
const FILLED: usize = 256;

/// Returns the light of each fragment of all probes, its channels added up.
///
/// # Errors
/// The interpreter does not run the shader.
pub(super) fn run(
    shader: &FragmentShader,
    writer: &BlockWriter,
    probes: &[Probe],
    cpu: &mut Cpu,
) -> Result<Vec<f64>, Failure> {
    let mut seen = Vec::new();
    for probe in probes {
        let mut upload = probe.upload.clone();
        let lit = filled(&mut upload, writer, probe.probed);
        let material = &upload.materials[0];
        let blocks = writer.blocks(&upload, &lit, material, None);
        let blocks = blocks.map_err(|error| Failure::refused(error.to_string(), ""))?;
        let numbers: Vec<u32> = (0..probe.fragments.len() as u32).collect();
        let fragments = Chosen { all: &probe.fragments, numbers: &numbers };
        let batch = Batch {
            blocks: &blocks,
            textures: &writer.textures(material),
            inputs: &FragmentInputs { writer, fragments, size: [64, 64] },
            count: probe.fragments.len(),
            limit: LIMIT,
        };
        let shaded = shader.run(cpu, &batch, |_, _| {})?;
        let sum = |color: &[f32; 4]| color[..3].iter().map(|channel| f64::from(*channel)).sum();
        seen.extend(shaded.colors.iter().map(sum).collect::<Vec<f64>>());
    }
    Ok(seen)
}

/// Adds black lights to all slots that the shader visits, since a slot of zeros divides by zero in
/// many of them; returns the lights, without the ambient one.
fn filled(upload: &mut Upload, writer: &BlockWriter, probed: ProbedLight) -> LightSet {
    // Black with a finite attenuation, so that it adds exactly zero.
    let dark = emission(DVec3::ZERO, 1.0);
    let lights = &mut upload.lights;
    let slots = Kind::ALL.map(|kind| {
        let own = if kind == probed.kind { probed.number as usize + 1 } else { 0 };
        match writer.slots(kind) {
            0 => 0,
            // A runtime-sized array is as long as the lights.
            usize::MAX => own.max(1),
            // With a count, the slots past it are not visited.
            _ if writer.counts(kind) => own.max(1),
            slots => slots.min(FILLED.max(own)),
        }
    });
    let aside = PointLight { position: DVec3::new(11.0, -7.0, 5.0), ..point(dark) };
    let direction = DVec3::new(0.0, -1.0, 0.0);
    lights.directional.resize(slots[0], DirectionalLight { direction, emission: dark });
    lights.point.resize(slots[1], aside);
    lights.spot.resize(slots[2], SpotLight { point: aside, direction, cone: CONE });
    LightSet { ambient: false, ..LightSet::first(slots) }
}

/// A cone whose cosines, radians and degrees exclude each other.
/// Read as degrees, radians or cosines, the numbers 20, 0.349 and 0.94 give cones that light
/// different fragments.
const CONE: Cone = Cone {
    inner_cos: 0.939692620785908,
    outer_cos: 0.819152044288992,
    degrees: Some([20.0, 35.0]),
};

fn emission(color: DVec3, intensity: f64) -> Emission {
    let (diffuse, none) = (color * intensity, DVec3::ZERO);
    Emission { ambient: none, diffuse, specular: none, color, intensity }
}

fn point(emission: Emission) -> PointLight {
    let attenuation = Attenuation { constant: 1.0, linear: 0.0, quadratic: 0.0, range: Some(1.0) };
    PointLight { position: DVec3::ZERO, emission, attenuation }
}

/// The axis of the light, in no plane of the coordinates.
fn axis() -> DVec3 {
    // Not a multiple of a coordinate axis either: a shader that swaps two of them shows.
    DVec3::new(0.48, -0.6, 0.64)
}

fn upload(probed: ProbedLight, light: PointLight) -> Upload {
    let mut lights = Lights::default();
    let before = probed.number as usize;
    let emission = light.emission;
    let dark = Emission { diffuse: DVec3::ZERO, color: DVec3::ZERO, ..emission };
    match probed.kind {
        Kind::Directional => {
            let one = |emission| DirectionalLight { direction: axis(), emission };
            lights.directional = vec![one(dark); before];
            lights.directional.push(one(emission));
        }
        Kind::Point => {
            lights.point = vec![PointLight { emission: dark, ..light }; before];
            lights.point.push(light);
        }
        Kind::Spot => {
            let one = |point| SpotLight { point, direction: axis(), cone: CONE };
            lights.spot = vec![one(PointLight { emission: dark, ..light }); before];
            lights.spot.push(one(light));
        }
    }
    let material = Material {
        name: "white".to_string(),
        ambient: Surface::Constant(DVec3::ZERO),
        diffuse: Surface::Constant(DVec3::ONE),
        specular: Surface::Constant(DVec3::ZERO),
        shininess: 32.0,
        reflectance: 1.0,
    };
    Upload { space: Space::View, camera: DVec3::ZERO, lights, materials: vec![material] }
}

/// A fragment at a place, facing the origin.
fn at(place: DVec3) -> Fragment {
    let normal = -place.normalize();
    Fragment {
        pixel: 0,
        material: 0,
        object: 0,
        position: place.as_vec3().to_array(),
        normal: normal.as_vec3().to_array(),
        uv: [0.25, 0.25],
    }
}

/// The value of the reference that a probe is about.
#[derive(Clone, Copy)]
enum ProbedTerm {
    Diffuse,
    Specular,
    Cone,
    Attenuation,
}

fn probe(
    probed: ProbedLight,
    light: PointLight,
    fragments: Vec<Fragment>,
    value: ProbedTerm,
) -> Probe {
    of_upload(probed, upload(probed, light), fragments, value)
}

fn of_upload(
    probed: ProbedLight,
    upload: Upload,
    fragments: Vec<Fragment>,
    value: ProbedTerm,
) -> Probe {
    // The quartic window is what ends a light in the reference; a shader may have another.
    let model = Model { window: Window::Quartic, ..Model::new(Family::Multi) };
    let number = probed.number as usize;
    let of = |fragment: &Fragment| {
        let texels = sample::texels(&upload.materials[0], fragment.uv);
        let seen = see(&model, &upload, fragment, &texels);
        let light = seen.and_then(|seen| seen.light(probed.kind, number));
        light.map_or(f64::NAN, |light| match value {
            ProbedTerm::Diffuse => light.diffuse.x,
            ProbedTerm::Specular => light.specular.x,
            ProbedTerm::Cone => light.cone,
            ProbedTerm::Attenuation => light.attenuation,
        })
    };
    let reference = fragments.iter().map(of).collect();
    Probe { probed, upload, fragments, reference }
}

/// Returns the unit vectors of a spiral over the sphere.
fn spiral(count: usize) -> impl Iterator<Item = DVec3> {
    // A golden spiral: directions spread evenly, none twice.
    (0..count).map(move |nth| {
        let z = 1.0 - (2.0 * nth as f64 + 1.0) / count as f64;
        let turn = nth as f64 * PI * (3.0 - 5f64.sqrt());
        let radius = (1.0 - z * z).sqrt();
        DVec3::new(radius * turn.cos(), radius * turn.sin(), z)
    })
}

fn white() -> PointLight {
    point(emission(DVec3::splat(0.5), 1.0))
}

/// Surfaces of all directions under a directional light, near and far.
pub(super) fn facing(probed: ProbedLight) -> Probe {
    let ends = [axis(), -axis()];
    // Four distances in turn, so that facing does not go with distance.
    let all = ends.into_iter().chain(spiral(22)).zip([0.5, 30.0, 2.0, 8.0].into_iter().cycle());
    probe(
        probed,
        white(),
        all.map(|(normal, far)| at(-far * normal)).collect(),
        ProbedTerm::Diffuse,
    )
}

/// Surfaces around a spotlight at the origin, whose shader has so many angles; only ahead of it and
/// behind it for a shader with angles of its own.
pub(super) fn cone(probed: ProbedLight, angles: usize) -> Probe {
    let across = axis().any_orthonormal_vector();
    let other = axis().cross(across);
    let degrees: &[f64] = match angles {
        // A shader without a cone of its own lights all that is ahead.
        0 => &[0.0, 1.0, 120.0, 150.0, 180.0],
        _ => &[
            0.0, 4.0, 9.0, 14.0, 19.0, 22.0, 25.0, 28.0, 31.0, 34.0, 36.0, 40.0, 46.0, 53.0, 62.0,
            75.0, 90.0, 110.0, 135.0, 160.0, 180.0,
        ],
    };
    // A single angle is the edge, whatever the names call it.
    let [_, outer] = CONE.degrees.unwrap_or_default();
    let single =
        Cone { inner_cos: CONE.outer_cos, outer_cos: CONE.outer_cos, degrees: Some([outer; 2]) };
    let shape = if angles == 1 { single } else { CONE };
    let place = |(nth, degrees): (usize, &f64)| {
        // 2.4 radians from one fragment to the next: around the axis, so that only the angle
        // matters.
        let turn = 2.4 * nth as f64;
        let side = across * turn.cos() + other * turn.sin();
        let angle = degrees.to_radians();
        at(0.5 * (axis() * angle.cos() + side * angle.sin()))
    };
    let fragments = degrees.iter().enumerate().map(place).collect();
    let mut upload = upload(probed, white());
    upload.lights.spot.iter_mut().for_each(|light| light.cone = shape);
    of_upload(probed, upload, fragments, ProbedTerm::Cone)
}

/// Surfaces inside and outside a range of 3.
pub(super) fn range(probed: ProbedLight) -> Probe {
    let mut light = white();
    light.attenuation.range = Some(3.0);
    // On both sides of 3, and of 9, where a squared range would end.
    let distances = [2.0, 2.15, 2.3, 2.45, 2.6, 3.05, 3.2, 3.6, 4.5, 6.0, 8.5, 9.5, 12.0, 40.0];
    let fragments = distances.map(|distance| at(axis() * distance)).to_vec();
    probe(probed, light, fragments, ProbedTerm::Attenuation)
}

/// A surface half a unit away, by coefficients of which many give the same attenuation.
pub(super) fn attenuation(probed: ProbedLight) -> Vec<Probe> {
    // The first four have the divisor 5, the others 1 and 2, so an exchange of coefficients shows
    // in the order.
    let all = [
        [5.0, 0.0, 0.0],
        [1.0, 8.0, 0.0],
        [1.0, 0.0, 16.0],
        [3.0, 2.0, 4.0],
        [1.0, 0.0, 0.0],
        [1.0, 2.0, 0.0],
        [1.0, 0.0, 4.0],
        [1.0, 1.0, 2.0],
    ];
    let one = |[constant, linear, quadratic]: [f64; 3]| {
        let mut light = white();
        light.attenuation = Attenuation { constant, linear, quadratic, range: Some(1.0) };
        probe(probed, light, vec![at(axis() * 0.5)], ProbedTerm::Attenuation)
    };
    all.map(one).into()
}

/// A surface lit by colours and intensities of which many have the same product.
pub(super) fn strength(probed: ProbedLight) -> Vec<Probe> {
    // A shader that multiplies once too often squares some of them.
    let all = [[0.5, 1.0], [1.0, 0.5], [0.25, 1.0], [1.0, 0.25], [0.5, 0.5], [0.75, 1.0]];
    let one = |[color, intensity]: [f64; 2]| {
        let light = point(emission(DVec3::splat(color), intensity));
        let place = match probed.kind {
            // Facing the light, whose direction is that of its travel.
            Kind::Directional => axis(),
            Kind::Point | Kind::Spot => axis() * 0.5,
        };
        probe(probed, light, vec![at(place)], ProbedTerm::Diffuse)
    };
    all.map(one).into()
}

/// A floor below the camera at the origin with the highlight of a far light.
pub(super) fn highlight(probed: ProbedLight) -> Probe {
    let towards = DVec3::new(0.5, 0.0, 1.0).normalize();
    let mut light = white();
    light.emission =
        Emission { diffuse: DVec3::ZERO, specular: DVec3::splat(0.5), ..light.emission };
    light.attenuation.range = None;
    // The light is far away, so that its direction is the same at all fragments.
    // Where the light is mirrored into the camera, and around it.
    let middle = DVec3::new(1.0, 0.0, -2.0);
    light.position = middle + towards * 1000.0;
    let mut upload = upload(probed, light);
    upload.lights.directional.iter_mut().for_each(|sun| sun.direction = -towards);
    upload.materials[0].diffuse = Surface::Constant(DVec3::ZERO);
    upload.materials[0].specular = Surface::Constant(DVec3::ONE);
    let sides = [-1.6, -1.1, -0.8, -0.5, -0.3, -0.1, 0.0, 0.15, 0.4, 0.7, 1.2, 2.5];
    let fragments = sides.map(|side| {
        let place = middle + DVec3::new(side, 0.3 * side, 0.0);
        Fragment { normal: [0.0, 0.0, 1.0], ..at(place) }
    });
    of_upload(probed, upload, fragments.to_vec(), ProbedTerm::Specular)
}
