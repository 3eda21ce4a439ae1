//! Generates samples by family: [`mutations`](super::mutations) of scenes, scenes, samples as the
//! domain distributes them, random bits, scenes with an input of random bits; or every input
//! ([`exhaustive`](super::exhaustive)).
//!
//! Used by [`sample`](super::sample).

use super::domain::{Domain, ValueRange};
use super::exhaustive::ExhaustiveInputs;
use super::input::{Inputs, Sample, float};
use super::mutations::{Mutation, SceneChange, limited, mutations};
use super::random::Random;
use super::sampler::Sampler;
use super::scene::SceneSetting;
use landfall_layout::named;
use landfall_layout::shape::ScalarKind;

named! {
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
    pub enum Family {
        /// Inputs that coincide, oppose or vanish; single inputs at a limit.
        Coincidences = "coincidences",
        /// Scenes like published ones.
        Scenes = "scenes",
        /// As the domain distributes the inputs, if it states anything of them.
        Drawn = "drawn",
        /// Random finite `f32`, each exponent equally likely.
        Bits = "bits",
        /// Scenes with one input of random bits.
        Mixed = "mixed",
        /// Inputs with infinities and NaN.
        Special = "special",
        /// Found by climbing from the worst samples of the other families.
        Climbed = "climbed",
        /// Every input of a small domain, instead of all others.
        Every = "every",
    }

    const ALL;
}

#[derive(Debug)]
pub(super) struct Generator<'a> {
    pub inputs: &'a Inputs,
    pub domain: &'a Domain,
    pub sampler: Sampler<'a>,
    mutations: Vec<Mutation>,
    seed: u64,
    /// All inputs, if there are few.
    every: Option<ExhaustiveInputs>,
}

/// Samples of one family.
pub(super) struct Chunk {
    pub family: Family,
    pub samples: Vec<Sample>,
    /// The tag of each sample: equal tags were made in the same way.
    pub tags: Vec<u32>,
}

/// The lanes of a chunk whose operations are watched.
pub(super) const WATCHED: usize = 256;
/// The lanes of any other chunk.
pub(super) const UNWATCHED: usize = 1024;

/// The number of small chunks at the start of an enumeration.
const SMALL: usize = 32;

/// Tags of samples that are not mutations.
pub(super) const TAG_BITS: u32 = 1 << 24;
const TAG_SCENES: u32 = 1 << 20;
const TAG_DRAWN: u32 = 1 << 21;

impl<'a> Generator<'a> {
    pub fn new(inputs: &'a Inputs, domain: &'a Domain, seed: u64) -> Generator<'a> {
        // Mutations are built once from the roles of the inputs and applied to random scenes.
        let mutations = limited(mutations(inputs), seed);
        let sampler = Sampler::new(inputs, domain);
        Generator { inputs, domain, sampler, mutations, seed, every: None }
    }

    /// Switches to every input once, if there are at most `most`.
    pub fn or_every(self, most: u64) -> Generator<'a> {
        Generator { every: ExhaustiveInputs::new(self.inputs, self.domain, most), ..self }
    }

    /// Returns the number of inputs, if each is run once.
    pub fn all(&self) -> Option<u64> {
        self.every.as_ref().map(ExhaustiveInputs::count)
    }

    /// Returns the scenes to which each mutation is applied in the first pass.
    fn lanes_each(&self) -> usize {
        // More scenes for each where there are few mutations: about 8192 samples in all.
        (8192 / self.mutations.len().max(1)).clamp(6, 24)
    }

    /// Returns the number of chunks of mutations.
    fn structured(&self) -> usize {
        (self.mutations.len() * self.lanes_each()).div_ceil(WATCHED)
    }

    /// Returns the samples of a chunk: mutations first, then the other families in turn.
    pub fn chunk(&self, number: usize) -> Chunk {
        if let Some(every) = &self.every {
            // Small chunks first, so that a slow function has results early.
            let small = number.min(SMALL);
            // The first 32 chunks are small.
            let first = small * WATCHED + (number - small) * UNWATCHED;
            let lanes = if number < SMALL { WATCHED } else { UNWATCHED };
            let [first, last] = [first, first + lanes].map(|nth| every.count().min(nth as u64));
            let samples: Vec<Sample> = (first..last).map(|nth| every.sample(nth)).collect();
            let tags = vec![TAG_BITS; samples.len()];
            return Chunk { family: Family::Every, samples, tags };
        }
        // A generator for each chunk, by its number: chunks can be made in any order by any
        // thread.
        let mut random = Random::new(self.seed, number as u64 + 1);
        if number < self.structured() {
            return self.mutated(number, &mut random);
        }
        // After all mutations once, families in turns of eight chunks: bits and mixed twice,
        // special once.
        let family = match (number - self.structured()) % 8 {
            0 if self.sampler.is_stated() => Family::Drawn,
            0 | 4 => Family::Scenes,
            1 | 5 => Family::Bits,
            2 | 6 => Family::Mixed,
            3 => Family::Special,
            _ => Family::Coincidences,
        };
        if family == Family::Coincidences {
            return self.mutated(random.below(self.structured().max(1)), &mut random);
        }
        let watched = matches!(family, Family::Scenes | Family::Drawn);
        let lanes = if watched { WATCHED } else { UNWATCHED };
        let mut chunk = Chunk { family, samples: Vec::new(), tags: Vec::new() };
        // A domain may reject a whole family; then the chunk stays short.
        let mut tries = 0;
        while chunk.samples.len() < lanes && tries < 8 * lanes {
            tries += 1;
            let setting = SceneSetting::random(&mut random);
            let made = match family {
                Family::Bits => Some((self.bits(&mut random), TAG_BITS)),
                Family::Drawn => self.sampler.drawn(&mut random).map(|one| (one, TAG_DRAWN)),
                Family::Scenes
                | Family::Mixed
                | Family::Special
                | Family::Climbed
                | Family::Every
                | Family::Coincidences => {
                    let sample = self.sampler.scene(setting, &mut random);
                    sample.map(|sample| (sample, TAG_SCENES + setting.tag() as u32))
                }
            };
            // One input of a scene replaced by any value: the rest of the function still works as
            // usual.
            let Some((mut sample, mut tag)) = made else { continue };
            if matches!(family, Family::Mixed | Family::Special) && !self.inputs.is_empty() {
                let at = random.below(self.inputs.len());
                let input = &self.inputs[at];
                self.any_of(at, &mut sample, &mut random);
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
            // Lanes of a mutation are in sequence across chunks.
            let nth = (number * WATCHED + lane) / each;
            let Some(mutation) = self.mutations.get(nth) else { break };
            let mut setting = SceneSetting::random(random);
            // Half of the scenes are of the usual cones and exponents.
            if random.chance(0.5) {
                setting.cone = random.below(3);
                setting.shine = random.below(5);
            }
            for change in &mutation.changes {
                match change {
                    SceneChange::Stand(geometry) => setting.geometry = *geometry,
                    SceneChange::Cone(cone) => setting.cone = *cone,
                    _ => {}
                }
            }
            let Some(mut sample) = self.sampler.scene(setting, random) else { continue };
            for change in &mutation.changes {
                self.apply(change, &mut sample);
            }
            self.push(&mut chunk, sample, nth as u32, random);
        }
        chunk
    }

    fn apply(&self, change: &SceneChange, sample: &mut Sample) {
        match change {
            SceneChange::Equal(a, b) | SceneChange::Opposite(a, b) => {
                let (a, b) = (&self.inputs[*a], &self.inputs[*b]);
                let opposite = matches!(change, SceneChange::Opposite(..));
                for (to, from) in a.range().zip(b.range()) {
                    // The sign bit.
                    sample[to] = sample[from] ^ if opposite { 1 << 31 } else { 0 };
                }
            }
            SceneChange::Set(at, bits) => {
                self.inputs[*at].range().for_each(|i| sample[i] = u64::from(*bits));
            }
            SceneChange::Scale(at, factor) => {
                for i in self.inputs[*at].range() {
                    sample[i] = u64::from((float(sample, i) * factor).to_bits());
                }
            }
            SceneChange::Stand(_) | SceneChange::Cone(_) => {}
        }
    }

    fn bits(&self, random: &mut Random) -> Sample {
        let mut sample = vec![0; self.inputs.scalars];
        for at in 0..self.inputs.len() {
            self.any_of(at, &mut sample, random);
        }
        sample
    }

    /// Draws any value of an input's domain, each exponent equally likely.
    pub fn any_of(&self, at: usize, sample: &mut Sample, random: &mut Random) {
        let input = &self.inputs[at];
        let within = self.domain.within[at];
        if !input.is_float() {
            // Integers of which nothing is stated are small: counts and indices of shaders.
            if within != ValueRange::Any {
                self.sampler.draw(at, sample, random);
                return;
            }
            for i in input.range() {
                sample[i] = match (input.scalar.kind, input.scalar.width) {
                    (ScalarKind::Bool, _) => random.word() & 1,
                    (ScalarKind::Float, 8) => (f64::from(random.bits()) * random.unit()).to_bits(),
                    _ => random.below(17) as u64,
                };
            }
            return;
        }
        // Mostly one exponent for the whole vector: otherwise all but one of its components are
        // negligible.
        // Squares, sums and products of a vector's components then matter to each other.
        let together = random.scale(1e-38, 1e38);
        let alike = random.chance(0.7);
        for i in input.range() {
            let (low, high) = self.domain.bounds(at, i);
            let x = match within {
                ValueRange::Any if alike => (random.between(-1.0, 1.0) * together) as f32,
                ValueRange::Any => random.bits(),
                // Near 1, where cosines lose digits.
                ValueRange::Cosine => match random.below(4) {
                    0 => (1.0 - random.scale(1e-7, 1.0)) as f32,
                    _ => random.between(-1.0, 1.0) as f32,
                },
                ValueRange::Range(..)
                | ValueRange::Unit
                | ValueRange::Position
                | ValueRange::Color => {
                    // Anywhere; near either end, by orders of magnitude; near zero, by orders of
                    // magnitude.
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
