//! Reads the parameters of random scenes.

use super::lights::by_distance;
use super::objects::material;
use super::walk::{Object as Members, SceneWalk, ValueAt};
use crate::scene::{
    Attenuation, Generate, Material, Object, PointLight, RandomCubes, RandomLights, generate,
};
use landfall_layout::diagnostic::Code;

/// The most lights, and the most cubes.
const LIMIT: u32 = 1 << 16;

pub(super) fn read(
    walk: &mut SceneWalk,
    at: &ValueAt<'_>,
    materials: Option<&[Material]>,
) -> Option<(Vec<PointLight>, Vec<Object>)> {
    let object = walk.object(at, &["seed", "area", "lights", "cubes", "floor"])?;
    let seed = walk.needed(&object, "seed").and_then(|at| walk.whole(&at, 0..=u32::MAX));
    let area = walk.needed(&object, "area").and_then(|at| positive(walk, &at));
    let lights = object.optional("lights", |at| lights(walk, at));
    let cubes = object.optional("cubes", |at| cubes(walk, at, materials));
    let floor = object.optional("floor", |at| {
        let floor = walk.object(at, &["material"])?;
        material(walk, &floor, materials)
    });
    let from = Generate {
        seed: u64::from(seed?),
        area: area?,
        lights: lights?,
        cubes: cubes?,
        floor: floor?,
    };
    Some(generate(&from))
}

fn lights(walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<RandomLights> {
    let object = walk.object(at, &["count", "height", "distances", "gain", "window", "omit"])?;
    let count = count(walk, &object);
    let height = walk.needed(&object, "height").and_then(|at| positive(walk, &at));
    let height = height.and_then(|height| ordered(walk, &object, "height", height));
    let rows = walk.needed(&object, "distances").and_then(|at| rows(walk, &at));
    let gain = object.or("gain", 1.0, |at| walk.positive(at));
    let window = object.optional("window", |at| walk.positive(at));
    let omit = object.or("omit", false, |at| walk.boolean(at));
    Some(RandomLights {
        count: count?,
        height: height?,
        attenuations: rows?,
        gain: gain?,
        window: window?,
        omit: omit?,
    })
}

fn rows(walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<Vec<Attenuation>> {
    let items = walk.list(at)?;
    if items.is_empty() {
        walk.error(Code::WrongCount, at, "lists no row of the table of attenuations");
        return None;
    }
    let rows: Vec<Option<Attenuation>> = items.iter().map(|at| by_distance(walk, at)).collect();
    rows.into_iter().collect()
}

fn cubes(
    walk: &mut SceneWalk,
    at: &ValueAt<'_>,
    materials: Option<&[Material]>,
) -> Option<RandomCubes> {
    let object = walk.object(at, &["count", "edge", "material"])?;
    let count = count(walk, &object);
    let edge = walk.needed(&object, "edge").and_then(|at| positive(walk, &at));
    let edge = edge.and_then(|edge| ordered(walk, &object, "edge", edge));
    let material = material(walk, &object, materials);
    Some(RandomCubes { count: count?, edge: edge?, material: material? })
}

fn count(walk: &mut SceneWalk, object: &Members<'_>) -> Option<u32> {
    walk.needed(object, "count").and_then(|at| walk.whole(&at, 0..=LIMIT))
}

/// Reads two numbers above zero.
fn positive(walk: &mut SceneWalk, at: &ValueAt<'_>) -> Option<[f64; 2]> {
    let items: [ValueAt<'_>; 2] = walk.items(at)?;
    let numbers = items.map(|at| walk.positive(&at));
    Some([numbers[0]?, numbers[1]?])
}

fn ordered(
    walk: &mut SceneWalk,
    object: &Members<'_>,
    key: &str,
    [low, high]: [f64; 2],
) -> Option<[f64; 2]> {
    if low <= high {
        return Some([low, high]);
    }
    let at = object.get(key)?;
    walk.error(Code::ValueOutOfRange, &at, format!("is an inverted range: from {low} to {high}"))
        .help = Some(format!("write `[{high}, {low}]`"));
    None
}
