//! Samples by family: changes that make inputs coincide or put one at an edge, scenes, bits,
//! scenes with an input of bits.
//!
//! Feeds [`sample`](super::sample).

use super::domain::{Domain, Within};
use super::input::{Input, Inputs, Sample, float};
use super::random::Random;
use super::role::Role;
use super::scene::{self, Geometry, Setting};
use crate::shape::ScalarKind;

/// Where samples come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Family {
    /// Inputs that coincide, oppose, vanish; single inputs at an edge.
    Coincidences,
    /// Scenes like published ones.
    Scenes,
    /// Every finite `f32`, each exponent as likely.
    Bits,
    /// Scenes with one input of bits.
    Mixed,
    /// Infinities and NaN in the inputs.
    Special,
    /// Searched from the worst of the others.
    Climbed,
}

impl Family {
    /// Every family.
    pub const ALL: [Family; 6] = [
        Family::Coincidences,
        Family::Scenes,
        Family::Bits,
        Family::Mixed,
        Family::Special,
        Family::Climbed,
    ];

    /// Its name in messages and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Family::Coincidences => "coincidences",
            Family::Scenes => "scenes",
            Family::Bits => "bits",
            Family::Mixed => "mixed",
            Family::Special => "special",
            Family::Climbed => "climbed",
        }
    }
}

/// A change made to a scene.
#[derive(Clone, Debug)]
enum Change {
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
struct Mutation {
    changes: Vec<Change>,
}

/// Makes the samples of a function.
#[derive(Debug)]
pub(super) struct Generator<'a> {
    pub inputs: &'a Inputs,
    pub domain: &'a Domain,
    mutations: Vec<Mutation>,
    seed: u64,
}

/// Samples of one kind.
pub(super) struct Chunk {
    pub family: Family,
    pub samples: Vec<Sample>,
    /// Of each: samples of one tag were made in the same way.
    pub tags: Vec<u32>,
}

/// Mutations at most.
const MUTATIONS: usize = 6000;

/// Lanes of a chunk that is watched, and of one that is not.
pub(super) const WATCHED: usize = 256;
pub(super) const UNWATCHED: usize = 1024;

/// Tags of samples that are no mutations.
pub(super) const TAG_BITS: u32 = 1 << 24;
const TAG_SCENES: u32 = 1 << 20;

impl<'a> Generator<'a> {
    pub fn new(inputs: &'a Inputs, domain: &'a Domain, seed: u64) -> Generator<'a> {
        let mut mutations = mutations(inputs);
        if mutations.len() > MUTATIONS {
            // The first ones are the likeliest; of the others, some.
            let mut random = Random::new(seed, 77);
            let mut rest = mutations.split_off(MUTATIONS / 2);
            while mutations.len() < MUTATIONS {
                let at = random.below(rest.len());
                mutations.push(rest.swap_remove(at));
            }
        }
        Generator { inputs, domain, mutations, seed }
    }

    /// Scenes each mutation is applied to in the first pass.
    fn lanes_each(&self) -> usize {
        (8192 / self.mutations.len().max(1)).clamp(6, 24)
    }

    /// Chunks of mutations.
    fn structured(&self) -> usize {
        (self.mutations.len() * self.lanes_each()).div_ceil(WATCHED)
    }

    /// The samples of a chunk: the mutations first, then the other families in turn.
    pub fn chunk(&self, number: usize) -> Chunk {
        let mut random = Random::new(self.seed, number as u64 + 1);
        if number < self.structured() {
            return self.mutated(number, &mut random);
        }
        let family = match (number - self.structured()) % 8 {
            0 | 4 => Family::Scenes,
            1 | 5 => Family::Bits,
            2 | 6 => Family::Mixed,
            3 => Family::Special,
            _ => Family::Coincidences,
        };
        if family == Family::Coincidences {
            return self.mutated(random.below(self.structured().max(1)), &mut random);
        }
        let watched = family == Family::Scenes;
        let lanes = if watched { WATCHED } else { UNWATCHED };
        let mut chunk = Chunk { family, samples: Vec::new(), tags: Vec::new() };
        let mut tries = 0;
        while chunk.samples.len() < lanes && tries < 8 * lanes {
            tries += 1;
            let setting = Setting::random(&mut random);
            let (mut sample, tag) = match family {
                Family::Bits => (self.bits(&mut random), TAG_BITS),
                Family::Scenes
                | Family::Mixed
                | Family::Special
                | Family::Climbed
                | Family::Coincidences => {
                    let sample = scene::sample(self.inputs, setting, &mut random);
                    (sample, TAG_SCENES + setting.tag() as u32)
                }
            };
            let mut tag = tag;
            if matches!(family, Family::Mixed | Family::Special) && !self.inputs.is_empty() {
                let at = random.below(self.inputs.len());
                let input = &self.inputs[at];
                self.draw(at, &mut sample, &mut random);
                tag = TAG_BITS + 1 + at as u32;
                if family == Family::Special && input.is_float() {
                    let scalar = input.first + random.below(input.len);
                    let odd = *random.pick(&[f32::INFINITY, f32::NEG_INFINITY, f32::NAN]);
                    sample[scalar] = u64::from(odd.to_bits());
                }
            }
            self.push(&mut chunk, sample, tag, &mut random);
        }
        chunk
    }

    fn push(&self, chunk: &mut Chunk, mut sample: Sample, tag: u32, random: &mut Random) {
        let special = chunk.family == Family::Special;
        if special || self.domain.fit(&mut sample, self.inputs, random) {
            chunk.samples.push(sample);
            chunk.tags.push(tag);
        }
    }

    fn mutated(&self, number: usize, random: &mut Random) -> Chunk {
        let mut chunk =
            Chunk { family: Family::Coincidences, samples: Vec::new(), tags: Vec::new() };
        let each = self.lanes_each();
        for lane in 0..WATCHED {
            let nth = (number * WATCHED + lane) / each;
            let Some(mutation) = self.mutations.get(nth) else { break };
            let mut setting = Setting::random(random);
            if random.chance(0.5) {
                setting.cone = random.below(3);
                setting.shine = random.below(5);
            }
            for change in &mutation.changes {
                match change {
                    Change::Stand(geometry) => setting.geometry = *geometry,
                    Change::Cone(cone) => setting.cone = *cone,
                    _ => {}
                }
            }
            let mut sample = scene::sample(self.inputs, setting, random);
            for change in &mutation.changes {
                self.apply(change, &mut sample);
            }
            self.push(&mut chunk, sample, nth as u32, random);
        }
        chunk
    }

    fn apply(&self, change: &Change, sample: &mut Sample) {
        match change {
            Change::Equal(a, b) | Change::Opposite(a, b) => {
                let (a, b) = (&self.inputs[*a], &self.inputs[*b]);
                let opposite = matches!(change, Change::Opposite(..));
                for (to, from) in a.range().zip(b.range()) {
                    sample[to] = sample[from] ^ if opposite { 1 << 31 } else { 0 };
                }
            }
            Change::Set(at, bits) => {
                self.inputs[*at].range().for_each(|i| sample[i] = u64::from(*bits));
            }
            Change::Scale(at, factor) => {
                for i in self.inputs[*at].range() {
                    sample[i] = u64::from((float(sample, i) * factor).to_bits());
                }
            }
            Change::Stand(_) | Change::Cone(_) => {}
        }
    }

    fn bits(&self, random: &mut Random) -> Sample {
        let mut sample = vec![0; self.inputs.scalars];
        for at in 0..self.inputs.len() {
            self.draw(at, &mut sample, random);
        }
        sample
    }

    /// Any value of an input's domain, each exponent as likely.
    pub fn draw(&self, at: usize, sample: &mut Sample, random: &mut Random) {
        let input = &self.inputs[at];
        let within = self.domain.within[at];
        if !input.is_float() {
            for i in input.range() {
                sample[i] = match (input.scalar.kind, input.scalar.width) {
                    (ScalarKind::Bool, _) => random.word() & 1,
                    (ScalarKind::Float, 8) => (f64::from(random.bits()) * random.unit()).to_bits(),
                    _ => random.below(17) as u64,
                };
            }
            return;
        }
        // One exponent for the whole vector most of the time: else all but one of its
        // components are as good as zero.
        let (low, high) = within.bounds();
        let together = random.scale(1e-38, 1e38);
        let alike = random.chance(0.7);
        for i in input.range() {
            let x = match within {
                Within::Any if alike => (random.between(-1.0, 1.0) * together) as f32,
                Within::Any => random.bits(),
                Within::Cosine => match random.below(4) {
                    0 => (1.0 - random.scale(1e-7, 1.0)) as f32,
                    _ => random.between(-1.0, 1.0) as f32,
                },
                Within::Range(..) | Within::Unit | Within::Position | Within::Color => {
                    let reach = low.abs().max(high.abs());
                    match random.below(4) {
                        0 => random.between(low, high) as f32,
                        1 => (low + (high - low) * random.scale(1e-9, 1.0)) as f32,
                        2 => (high - (high - low) * random.scale(1e-9, 1.0)) as f32,
                        _ if low >= 0.0 => random.scale(reach * 1e-12, reach) as f32,
                        _ => {
                            let x = random.scale(reach * 1e-9, reach);
                            (if random.chance(0.5) { x } else { -x }) as f32
                        }
                    }
                }
            };
            sample[i] = u64::from(x.to_bits());
        }
    }
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
fn mutations(inputs: &[Input]) -> Vec<Mutation> {
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
