//! The six lights of `shaders/`, in every language, against values computed with 50 digits.

use glam::{DQuat, DVec3};

use super::support::single;
use landfall_interp::backend::{Resource, ResourceKind};
use landfall_interp::{Floats, Invocations, Outputs, Port, Precision, Program, Settings};
use landfall_ir::Module;
use landfall_ir::module::HandleKind;
use landfall_layout::Options;
use landfall_layout::buffer::Buffer;
use landfall_layout::source::{Source, Stage};

/// A place and a normal.
pub type Fragment = [[f32; 3]; 2];
/// Place, normal, the sum of six lights with white textures as tutorials compute it, the sum
/// without highlights of lights behind the surface, and the flashlight's share; uniforms
/// rounded to `f32`.
type Golden = ([f32; 3], [f32; 3], f64, f64, f64);
const GOLDEN: [Golden; 7] = [
    ([0.0, 0.0, 0.5], [0.0, 0.0, 1.0], 2.26911252149039, 2.26911252149039, 1.40350875377),
    ([0.4, 0.3, 0.5], [0.0, 0.0, 1.0], 2.1077796668398, 2.1077796668398, 0.735869414475),
    ([0.5, 0.1, 0.2], [1.0, 0.0, 0.0], 1.02367277644811, 0.390140750261857, 0.0),
    ([0.75, 0.0, -1.0], [0.3, 0.2, 1.0], 1.29382812566422, 1.29382812566422, 0.460165239996),
    ([-1.3, 1.5, -1.5], [0.0, 1.0, 0.0], 0.540766189282212, 0.540766140614674, 0.0),
    ([0.0, 0.0, -3.5], [0.0, 0.0, 1.0], 3.28179947116479, 3.28179947116479, 0.680966952823),
    ([0.61, 0.0, 0.5], [0.0, 0.0, 1.0], 1.65452576515039, 1.65452576515039, 0.369866580314),
];

/// The published scene; members a shader does not have are left out.
fn fill(buffer: &mut Buffer) {
    let mut vector = |path: &str, value: [f32; 3]| {
        let _ = buffer.set(path, value);
    };
    for prefix in ["dirLight", "pointLights[0]", "pointLights[1]", "pointLights[2]"]
        .into_iter()
        .chain(["pointLights[3]", "spotLight"])
    {
        let [ambient, diffuse, specular] = match prefix {
            "dirLight" => [0.05, 0.4, 0.5],
            "spotLight" => [0.0, 1.0, 1.0],
            _ => [0.05, 0.8, 1.0],
        };
        vector(&format!("{prefix}.ambient"), [ambient; 3]);
        vector(&format!("{prefix}.diffuse"), [diffuse; 3]);
        vector(&format!("{prefix}.specular"), [specular; 3]);
    }
    let places = [[0.7, 0.2, 2.0], [2.3, -3.3, -4.0], [-4.0, 2.0, -12.0], [0.0, 0.0, -3.0]];
    for (i, place) in places.into_iter().enumerate() {
        vector(&format!("pointLights[{i}].position"), place);
    }
    vector("dirLight.direction", [-0.2, -1.0, -0.3]);
    vector("spotLight.position", [0.0, 0.0, 3.0]);
    vector("spotLight.direction", [0.0, 0.0, -1.0]);
    vector("viewPos", [0.0, 0.0, 3.0]);
    let mut number = |path: &str, value: f64| {
        let _ = buffer.set(path, value as f32);
    };
    for prefix in ["pointLights[0]", "pointLights[1]", "pointLights[2]", "pointLights[3]"]
        .into_iter()
        .chain(["spotLight"])
    {
        number(&format!("{prefix}.constant"), 1.0);
        number(&format!("{prefix}.linear"), 0.09);
        number(&format!("{prefix}.quadratic"), 0.032);
    }
    number("spotLight.cutOff", 12.5f64.to_radians().cos());
    number("spotLight.outerCutOff", 15f64.to_radians().cos());
    number("material.shininess", 32.0);
    number("shininess", 32.0);
}

/// A shader of ours, each text of `changes` replaced by the one beside it.
pub fn module(file: &str, changes: &[(&str, &str)]) -> Module {
    let folder = if file.contains('/') { "" } else { "six_lights/" };
    let path = format!("{}/../../shaders/{folder}{file}", env!("CARGO_MANIFEST_DIR"));
    let source = Source::read(&path).expect("the shader is there");
    let mut text = source.text.to_string();
    for (old, new) in changes {
        assert!(text.contains(old), "{file} has no `{old}`");
        text = text.replace(old, new);
    }
    let source = Source::new(file, text);
    Module::new(&source, &Options::default()).unwrap_or_else(|found| panic!("{found:?}"))
}

fn resources(module: &Module) -> Vec<Resource> {
    let blocks = module.blocks().iter().map(|block| {
        let mut buffer = Buffer::new(&block.layout).expect("the block is laid out");
        fill(&mut buffer);
        let kind = ResourceKind::Uniform(buffer.into_bytes());
        Resource { name: String::new(), group: block.group, binding: block.binding, kind }
    });
    let handles = module.handles().iter().map(|handle| {
        let kind = match handle.kind {
            HandleKind::Texture | HandleKind::Image => {
                ResourceKind::Texture { width: 1, height: 1, texels: vec![[1.0; 4]] }
            }
            HandleKind::Sampler => ResourceKind::Sampler,
        };
        let name = handle.path.clone();
        Resource { name, group: handle.group, binding: handle.binding, kind }
    });
    blocks.chain(handles).collect()
}

/// Shades every fragment and returns its outputs.
pub fn shade(
    module: &Module,
    fragments: &[Fragment],
    settings: &Settings,
    floats: Floats,
) -> Outputs {
    let entry = module
        .entry_points()
        .into_iter()
        .find(|e| e.stage == Stage::Fragment)
        .expect("it has a fragment stage");
    let columns = |part: usize| -> Vec<Vec<u64>> {
        let bits = |i: usize| fragments.iter().map(move |f| u64::from(f[part][i].to_bits()));
        (0..3).map(|i| bits(i).collect()).collect()
    };
    let location = |name: &str, other: u32| {
        let input = module.inputs().iter().find(|i| i.name.to_lowercase().contains(name));
        Port::Location(input.map_or(other, |i| i.location))
    };
    let inputs = vec![(location("pos", 0), columns(0)), (location("normal", 1), columns(1))];
    let invocations = Invocations { count: fragments.len(), inputs };
    let resources = resources(module);
    Program::rounded(module, &[], floats)
        .run_entry(&entry.name, &invocations, &resources, settings)
        .unwrap_or_else(|failure| panic!("{failure:?}"))
}

/// Fragments of the scene's ten cubes that face the camera.
pub fn fragments(count: usize) -> Vec<Fragment> {
    let cubes = [
        [0.0, 0.0, 0.0],
        [2.0, 5.0, -15.0],
        [-1.5, -2.2, -2.5],
        [-3.8, -2.0, -12.3],
        [2.4, -0.4, -3.5],
        [-1.7, 3.0, -7.5],
        [1.3, -2.0, -2.5],
        [1.5, 2.0, -2.5],
        [1.5, 0.2, -1.5],
        [-1.3, 1.0, -1.5],
    ];
    let axis = DVec3::new(1.0, 0.3, 0.5).normalize();
    let camera = DVec3::new(0.0, 0.0, 3.0);
    let mut random = fastrand::Rng::with_seed(6);
    let mut fragments = Vec::new();
    while fragments.len() < count {
        let cube = random.usize(0..10);
        let turn = DQuat::from_axis_angle(axis, (20.0 * cube as f64).to_radians());
        let mut corner = [0.0; 3].map(|_| random.f64() - 0.5);
        let mut normal = [0.0; 3];
        let (side, sign) = (random.usize(0..3), if random.bool() { 1.0 } else { -1.0 });
        (corner[side], normal[side]) = (0.5 * sign, sign);
        let place = turn * DVec3::from_array(corner) + DVec3::from_array(cubes[cube]);
        let normal = turn * DVec3::from_array(normal);
        if normal.dot(camera - place) > 0.0 {
            fragments.push([place, normal].map(|v| v.to_array().map(|x| x as f32)));
        }
    }
    fragments
}

fn holds(file: &str, expected: fn(&Golden) -> f64) {
    for (precision, tolerance) in [(Precision::Double, 1e-11), (Precision::Single, 2e-6)] {
        let settings = Settings { precision, ..single() };
        let fragments: Vec<Fragment> = GOLDEN.iter().map(|g| [g.0, g.1]).collect();
        let lit = shade(&module(file, &[]), &fragments, &settings, Floats::AsWritten);
        for (got, golden) in lit.ports[0].1.doubles[0].iter().zip(&GOLDEN) {
            let (place, expected) = (golden.0, expected(golden));
            let off = (got - expected).abs() / expected;
            assert!(off < tolerance, "{file}, {precision:?}, {place:?}: {got}, {expected}");
        }
    }
}

#[test]
fn six_lights_are_as_bright_as_they_should_be_in_every_language() {
    for file in ["phong.wgsl", "phong_450.frag", "phong_330.frag", "phong_300es.frag"] {
        holds(&format!("six_lights/{file}"), |g| g.3);
    }
    // The oldest dialect has no flashlight.
    holds("six_lights/phong_100es.frag", |g| g.3 - g.4);
}

#[test]
fn seed_forms_are_as_bright_as_tutorials_say() {
    for file in ["six_lights.wgsl", "six_lights_450.frag", "six_lights_330.frag"] {
        holds(&format!("seed/{file}"), |g| g.2);
    }
}
