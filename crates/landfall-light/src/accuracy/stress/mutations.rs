//! Changes that make the inputs of a scene coincide, oppose or vanish, or put one at an edge.
//!
//! Made of the roles of inputs; [`generate`](super::generate) applies them.

use super::input::Input;
use super::random::Random;
use super::role::Role;
use super::scene;
use super::scene::Geometry;
use landfall_layout::shape::ScalarKind;

/// A change made to a scene.
#[derive(Clone, Debug)]
pub(super) enum Change {
    /// One input is another.
    Equal(usize, usize),
    /// One input is the negative of another.
    Opposite(usize, usize),
    /// All scalars of an input are that.
    Set(usize, u32),
    /// An input is multiplied.
    Scale(usize, f32),
    /// The geometry of the scene.
    Stand(Geometry),
    /// The cone of the scene.
    Cone(usize),
}

/// Changes made together, and what they are called.
#[derive(Clone, Debug, Default)]
pub(super) struct Mutation {
    pub changes: Vec<Change>,
}

/// Mutations at most.
const MUTATIONS: usize = 6000;

/// As many as are applied: of too many, the first, which are the likeliest, and some of the others.
pub(super) fn some(mut mutations: Vec<Mutation>, seed: u64) -> Vec<Mutation> {
    if mutations.len() > MUTATIONS {
        let mut random = Random::new(seed, 77);
        let mut rest = mutations.split_off(MUTATIONS / 2);
        while mutations.len() < MUTATIONS {
            let at = random.below(rest.len());
            mutations.push(rest.swap_remove(at));
        }
    }
    mutations
}

/// Numbers at which arithmetic changes.
const EDGES: [f32; 22] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    1.0 + f32::EPSILON,
    1.0 - f32::EPSILON / 2.0,
    2.0,
    0.5,
    1.0e-3,
    1.0e3,
    1.0e7,
    1.0e15,
    2.0e19,
    1.0e30,
    f32::MAX,
    1.0e-10,
    1.0e-20,
    1.0e-23,
    f32::MIN_POSITIVE,
    1.0e-45,
    -1.0e-7,
    -1.0e19,
];

/// Everything that is tried on a scene, the likeliest first.
pub(super) fn mutations(inputs: &[Input]) -> Vec<Mutation> {
    use Change::{Cone, Equal, Opposite, Scale, Set, Stand};
    let zero = 0u32;
    let one = 1.0f32.to_bits();
    let mut all: Vec<Mutation> = Vec::new();
    let mut push = |changes: Vec<Change>| all.push(Mutation { changes });
    let of = |is: &dyn Fn(&Input) -> bool| -> Vec<usize> {
        (0..inputs.len()).filter(|&at| is(&inputs[at])).collect()
    };
    let lights = of(&|i| i.role == Role::LightPosition);
    let points = of(&|i| i.role.is_position());
    let coefficients = of(&|i| i.role.is_attenuation());
    let distances = of(&|i| i.role == Role::Distance);
    let colors = of(&|i| i.role == Role::Color);
    let related = |a: usize, b: usize| {
        let (a, b) = (&inputs[a].owner, &inputs[b].owner);
        a == b || a.starts_with(&format!("{b}.")) || b.starts_with(&format!("{a}."))
    };
    // A light whose attenuation was not set; with the colour not set either.
    let groups: Vec<Vec<usize>> = {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for &at in &coefficients {
            match groups.iter_mut().find(|g| inputs[g[0]].owner == inputs[at].owner) {
                Some(group) => group.push(at),
                None => groups.push(vec![at]),
            }
        }
        groups
    };
    for group in &groups {
        let unset: Vec<Change> = group.iter().map(|&at| Set(at, zero)).collect();
        push(unset.clone());
        let mut black = unset;
        black.extend(colors.iter().filter(|&&c| related(c, group[0])).map(|&c| Set(c, zero)));
        push(black);
        let constants = || group.iter().filter(|&&at| inputs[at].role != Role::Quadratic);
        let no_constant: Vec<Change> = constants().map(|&at| Set(at, zero)).collect();
        for &light in lights.iter().filter(|&&l| related(l, group[0]) || groups.len() == 1) {
            for &point in points.iter().filter(|&&p| p != light) {
                let mut at_light = no_constant.clone();
                at_light.push(Equal(point, light));
                push(at_light);
            }
        }
        for &d in &distances {
            let mut at_light = no_constant.clone();
            at_light.push(Set(d, zero));
            push(at_light);
        }
        for &at in group {
            push(vec![Set(at, (-1.0f32).to_bits())]);
        }
    }
    for &a in &points {
        for &b in points.iter().filter(|&&b| b != a) {
            push(vec![Equal(a, b)]);
        }
    }
    for inner in of(&|i| i.role == Role::InnerCosine) {
        for outer in of(&|i| i.role == Role::OuterCosine) {
            if inputs[inner].owner == inputs[outer].owner {
                for geometry in [Geometry::AtEdge, Geometry::OnAxis, Geometry::InRamp] {
                    push(vec![Stand(geometry), Equal(inner, outer)]);
                }
                push(vec![Set(inner, one), Set(outer, one), Stand(Geometry::OnAxis)]);
            }
        }
    }
    for cone in of(&|i| i.role.is_cone()) {
        // Rounding puts few fragments of the axis inside such a cone.
        for _ in 0..48 {
            push(vec![Stand(Geometry::OnAxis), Set(cone, one)]);
        }
        push(vec![Stand(Geometry::Ordinary), Set(cone, one)]);
        for narrow in 3..scene::CONES.len() {
            for geometry in [Geometry::InRamp, Geometry::OnAxis] {
                push(vec![Stand(geometry), Cone(narrow)]);
            }
        }
    }
    for shine in of(&|i| i.role == Role::Shininess) {
        // Half of these cosines round past 1; of a dim light nothing is seen.
        for large in [1.0e5f32, 1.0e6, 1.0e7] {
            for _ in 0..12 {
                push(vec![Stand(Geometry::Mirror), Set(shine, large.to_bits())]);
            }
        }
        for geometry in [Geometry::Behind, Geometry::Ordinary, Geometry::Mirror] {
            push(vec![Stand(geometry), Set(shine, zero)]);
            push(vec![Stand(geometry), Set(shine, 1.0e5f32.to_bits())]);
        }
    }
    for count in of(&|i| i.role == Role::Count) {
        for many in [0u32, 1, 127, 128, 129, 65535] {
            push(vec![Set(count, many)]);
        }
    }
    let directions = of(&|i| i.is_vector());
    for &at in &directions {
        push(vec![Set(at, zero)]);
        push(vec![Scale(at, 1.0 + 1.0e-7)]);
        push(vec![Scale(at, 2.0e19)]);
        push(vec![Scale(at, 1.0e-21)]);
    }
    // Nothing, or far too much, of each input, before the pairs: those are many.
    for at in of(&|i| i.is_number()) {
        push(vec![Set(at, zero)]);
    }
    for at in of(&|i| i.is_number() || i.role.is_position()) {
        push(vec![Set(at, 2.0e19f32.to_bits())]);
    }
    // Pairs of one shape: those of one kind before the others.
    let mut pairs: Vec<(usize, usize, bool)> = Vec::new();
    for a in 0..inputs.len() {
        for b in 0..a {
            let (i, j) = (&inputs[a], &inputs[b]);
            if !(i.is_float() && j.is_float() && i.len == j.len && i.rows == j.rows) {
                continue;
            }
            let alike = i.role.is_direction() && j.role.is_direction()
                || i.role == j.role
                || i.role.is_position() && j.role.is_position();
            pairs.push((a, b, alike));
        }
    }
    pairs.sort_by_key(|pair| !pair.2);
    for (a, b, _) in pairs.into_iter().take(MUTATIONS) {
        push(vec![Equal(a, b)]);
        push(vec![Opposite(a, b)]);
    }
    for edge in EDGES {
        for at in of(&|i| i.is_number()) {
            push(vec![Set(at, edge.to_bits())]);
        }
    }
    for edge in EDGES {
        for at in of(&|i| i.is_float() && !i.is_number()) {
            push(vec![Set(at, edge.to_bits())]);
        }
    }
    for at in of(&|i| !i.is_float() && i.scalar.width <= 4 && i.scalar.kind != ScalarKind::Bool) {
        for edge in [0u32, 1, u32::MAX, 1 << 31, 31, 32, 1 << 20] {
            push(vec![Set(at, edge)]);
        }
    }
    if all.is_empty() {
        all.push(Mutation::default());
    }
    all
}
