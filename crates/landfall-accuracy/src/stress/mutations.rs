//! Mutations that make inputs of a scene coincide, oppose or vanish, or put one at a limit.
//!
//! Built from the roles of inputs; [`generate`](super::generate) applies them.

use super::input::Input;
use super::random::Random;
use super::role::InputRole;
use super::scene;
use super::scene::Geometry;
use landfall_layout::shape::ScalarKind;

use SceneChange::{Cone, Equal, Opposite, Scale, Set, Stand};

#[derive(Clone, Debug)]
pub(super) enum SceneChange {
    /// Sets one input to another.
    Equal(usize, usize),
    /// Sets one input to the negative of another.
    Opposite(usize, usize),
    /// Sets all scalars of an input.
    Set(usize, u32),
    /// Multiplies an input.
    Scale(usize, f32),
    /// Sets the geometry of the scene.
    Stand(Geometry),
    Cone(usize),
}

#[derive(Clone, Debug, Default)]
pub(super) struct Mutation {
    pub changes: Vec<SceneChange>,
}

const MUTATIONS: usize = 6000;

/// Limits the number of mutations: keeps the first, which are the most likely, and some others.
pub(super) fn limited(mut mutations: Vec<Mutation>, seed: u64) -> Vec<Mutation> {
    // Pairs of n inputs grow with its square.
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
/// Zeros, one and its neighbours, powers that overflow or underflow when squared, the least normal
/// and the least subnormal number.
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

/// Returns all mutations of a scene, the most likely first.
pub(super) fn mutations(inputs: &[Input]) -> Vec<Mutation> {
    let mut made = Mutations { inputs, all: Vec::new() };
    made.unset_attenuation();
    made.equal_points();
    made.narrow_cones();
    made.shininess();
    made.counts();
    made.directions();
    // Extremes of single inputs precede the pairs, which are many.
    made.extremes();
    made.pairs();
    made.edges();
    if made.all.is_empty() {
        made.all.push(Mutation::default());
    }
    made.all
}

const ZERO: u32 = 0;
const ONE: u32 = 1.0f32.to_bits();

/// The mutations of a scene under construction.
struct Mutations<'a> {
    inputs: &'a [Input],
    all: Vec<Mutation>,
}

impl Mutations<'_> {
    fn push(&mut self, changes: Vec<SceneChange>) {
        self.all.push(Mutation { changes });
    }

    /// Returns the indices of the inputs that match.
    fn of(&self, is: impl Fn(&Input) -> bool) -> Vec<usize> {
        (0..self.inputs.len()).filter(|&at| is(&self.inputs[at])).collect()
    }

    /// Whether one input's owner is, or contains, the other's.
    fn related(&self, a: usize, b: usize) -> bool {
        let (a, b) = (&self.inputs[a].owner, &self.inputs[b].owner);
        a == b || a.starts_with(&format!("{b}.")) || b.starts_with(&format!("{a}."))
    }

    /// Returns the attenuation coefficients of each owner.
    fn coefficients(&self) -> Vec<Vec<usize>> {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for at in self.of(|i| i.role.is_attenuation()) {
            let owner =
                |group: &&mut Vec<usize>| self.inputs[group[0]].owner == self.inputs[at].owner;
            match groups.iter_mut().find(owner) {
                Some(group) => group.push(at),
                None => groups.push(vec![at]),
            }
        }
        groups
    }

    /// Adds lights with unset attenuation, and with unset colour too.
    fn unset_attenuation(&mut self) {
        let lights = self.of(|i| i.role == InputRole::LightPosition);
        let points = self.of(|i| i.role.is_position());
        let distances = self.of(|i| i.role == InputRole::Distance);
        let colors = self.of(|i| i.role == InputRole::Color);
        let groups = self.coefficients();
        // Lights that a host has not set: coefficients of 0, black or not; and the light at the
        // point that it lights, with no constant term to keep the divisor away from zero.
        for group in &groups {
            let unset: Vec<SceneChange> = group.iter().map(|&at| Set(at, ZERO)).collect();
            self.push(unset.clone());
            let mut black = unset;
            let own = colors.iter().filter(|&&color| self.related(color, group[0]));
            black.extend(own.map(|&color| Set(color, ZERO)));
            self.push(black);
            let constants =
                group.iter().filter(|&&at| self.inputs[at].role != InputRole::Quadratic);
            let no_constant: Vec<SceneChange> = constants.map(|&at| Set(at, ZERO)).collect();
            for &light in &lights {
                // With one group of coefficients it belongs to every light.
                if !self.related(light, group[0]) && groups.len() != 1 {
                    continue;
                }
                for &point in points.iter().filter(|&&p| p != light) {
                    let mut at_light = no_constant.clone();
                    at_light.push(Equal(point, light));
                    self.push(at_light);
                }
            }
            for &distance in &distances {
                let mut at_light = no_constant.clone();
                at_light.push(Set(distance, ZERO));
                self.push(at_light);
            }
            for &at in group {
                self.push(vec![Set(at, (-1.0f32).to_bits())]);
            }
        }
    }

    /// Adds coinciding points.
    fn equal_points(&mut self) {
        let points = self.of(|i| i.role.is_position());
        for &a in &points {
            for &b in points.iter().filter(|&&b| b != a) {
                self.push(vec![Equal(a, b)]);
            }
        }
    }

    /// Adds cones with equal angles, and cones of zero width.
    fn narrow_cones(&mut self) {
        for inner in self.of(|i| i.role == InputRole::InnerCosine) {
            for outer in self.of(|i| i.role == InputRole::OuterCosine) {
                if self.inputs[inner].owner == self.inputs[outer].owner {
                    for geometry in [Geometry::AtEdge, Geometry::OnAxis, Geometry::InRamp] {
                        self.push(vec![Stand(geometry), Equal(inner, outer)]);
                    }
                    self.push(vec![Set(inner, ONE), Set(outer, ONE), Stand(Geometry::OnAxis)]);
                }
            }
        }
        for cone in self.of(|i| i.role.is_cone()) {
            // Each of the 48 is another random scene.
            // Rounding leaves few fragments on the axis inside such a cone.
            for _ in 0..48 {
                self.push(vec![Stand(Geometry::OnAxis), Set(cone, ONE)]);
            }
            self.push(vec![Stand(Geometry::Ordinary), Set(cone, ONE)]);
            for narrow in 3..scene::CONES.len() {
                for geometry in [Geometry::InRamp, Geometry::OnAxis] {
                    self.push(vec![Stand(geometry), Cone(narrow)]);
                }
            }
        }
    }

    /// Adds exponents that are large or zero.
    fn shininess(&mut self) {
        for shine in self.of(|i| i.role == InputRole::Shininess) {
            // Half of these cosines round above 1; a dim light would hide the effect.
            for large in [1.0e5f32, 1.0e6, 1.0e7] {
                for _ in 0..12 {
                    self.push(vec![Stand(Geometry::Mirror), Set(shine, large.to_bits())]);
                }
            }
            for geometry in [Geometry::Behind, Geometry::Ordinary, Geometry::Mirror] {
                self.push(vec![Stand(geometry), Set(shine, ZERO)]);
                self.push(vec![Stand(geometry), Set(shine, 1.0e5f32.to_bits())]);
            }
        }
    }

    /// Adds light counts around the usual array lengths.
    fn counts(&mut self) {
        for count in self.of(|i| i.role == InputRole::Count) {
            for many in [0u32, 1, 127, 128, 129, 65535] {
                self.push(vec![Set(count, many)]);
            }
        }
    }

    /// Adds directions that are not unit vectors, by a rounding or by far.
    fn directions(&mut self) {
        for at in self.of(|i| i.is_vector()) {
            self.push(vec![Set(at, ZERO)]);
            // A rounding; a square that overflows; one that underflows.
            self.push(vec![Scale(at, 1.0 + 1.0e-7)]);
            self.push(vec![Scale(at, 2.0e19)]);
            self.push(vec![Scale(at, 1.0e-21)]);
        }
    }

    /// Adds zeros, and numbers whose squares overflow or underflow an `f32`.
    fn extremes(&mut self) {
        for at in self.of(|i| i.is_number()) {
            self.push(vec![Set(at, ZERO)]);
        }
        for at in self.of(|i| i.is_number() || i.role.is_position()) {
            self.push(vec![Set(at, 2.0e19f32.to_bits())]);
        }
    }

    /// Adds pairs of one shape, those of the same kind first.
    fn pairs(&mut self) {
        let mut pairs: Vec<(usize, usize, bool)> = Vec::new();
        for a in 0..self.inputs.len() {
            for b in 0..a {
                let (i, j) = (&self.inputs[a], &self.inputs[b]);
                if !(i.is_float() && j.is_float() && i.len == j.len && i.rows == j.rows) {
                    continue;
                }
                let alike = i.role.is_direction() && j.role.is_direction()
                    || i.role == j.role
                    || i.role.is_position() && j.role.is_position();
                pairs.push((a, b, alike));
            }
        }
        // A stable sort: like inputs first, in the order of the text.
        pairs.sort_by_key(|pair| !pair.2);
        for (a, b, _) in pairs.into_iter().take(MUTATIONS) {
            self.push(vec![Equal(a, b)]);
            self.push(vec![Opposite(a, b)]);
        }
    }

    /// Adds each input at the numbers where arithmetic changes.
    fn edges(&mut self) {
        for edge in EDGES {
            for at in self.of(|i| i.is_number()) {
                self.push(vec![Set(at, edge.to_bits())]);
            }
        }
        for edge in EDGES {
            for at in self.of(|i| i.is_float() && !i.is_number()) {
                self.push(vec![Set(at, edge.to_bits())]);
            }
        }
        let is_integer =
            |i: &Input| !i.is_float() && i.scalar.width <= 4 && i.scalar.kind != ScalarKind::Bool;
        for at in self.of(is_integer) {
            // -1 and the least integer, shifts of 31 and 32, and a million iterations.
            for edge in [0u32, 1, u32::MAX, 1 << 31, 31, 32, 1 << 20] {
                self.push(vec![Set(at, edge)]);
            }
        }
    }
}
