//! The sampler of a function's inputs: as their domain says, else like those of published scenes.
//!
//! Draws the samples whose errors and times [`bench`](mod@crate::bench) measures and the
//! samples that [`stress`](mod@crate::stress) starts from.

use super::distribution::Distribution;
use super::domain::{Component, Domain, ValueRange};
use super::input::{Inputs, Sample};
use super::random::Random;
use super::scene::{self, SceneSetting};

/// The samples drawn until one has no inputs that must not coincide.
const TRIES: usize = 32;

/// The vectors drawn until one has the ranges stated for its components; then these are drawn
/// first.
const DIRECTIONS: usize = 64;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Sampler<'a> {
    inputs: &'a Inputs,
    domain: &'a Domain,
}

impl<'a> Sampler<'a> {
    pub fn new(inputs: &'a Inputs, domain: &'a Domain) -> Sampler<'a> {
        Sampler { inputs, domain }
    }

    /// Whether anything is stated of any input.
    pub fn is_stated(&self) -> bool {
        self.scalars().any(|(input, at)| self.domain.states(input, at))
    }

    /// Draws each input as it is distributed over its range, or, where nothing is stated, as in a
    /// scene; `None` if the domain excludes nearly all samples.
    pub fn drawn(&self, random: &mut Random) -> Option<Sample> {
        // A scene is made for what nothing is stated of; the rest is then drawn over it.
        let is_scene = self.scalars().any(|(input, at)| !self.domain.states(input, at));
        (0..TRIES).find_map(|_| {
            let mut sample = match is_scene {
                true => scene::sample(self.inputs, SceneSetting::usual(random), random),
                false => vec![0; self.inputs.scalars],
            };
            let drawn = (0..self.inputs.len()).all(|nth| self.draw(nth, &mut sample, random));
            (drawn && self.domain.keeps_apart(&sample, self.inputs)).then_some(sample)
        })
    }

    /// Draws samples as they are distributed; fewer or none if the domain excludes nearly all.
    pub fn all_drawn(&self, seed: u64, count: usize) -> Vec<Sample> {
        let mut random = Random::new(seed, 0);
        std::iter::from_fn(|| self.drawn(&mut random)).take(count).collect()
    }

    /// Draws samples of which some inputs are at an end of their range or another special value;
    /// none if no range is stated.
    pub fn at_ends(&self, seed: u64, count: usize) -> Vec<Sample> {
        let mut random = Random::new(seed, 1);
        let stated = |nth: &usize| self.domain.within[*nth] != ValueRange::Any;
        let ranges: Vec<usize> = (0..self.inputs.len()).filter(stated).collect();
        if ranges.is_empty() {
            return Vec::new();
        }
        let one = |random: &mut Random| {
            let mut sample = self.drawn(random)?;
            // At least one input is at an end, and others by chance.
            let first = *random.pick(&ranges);
            for &nth in &ranges {
                if nth == first || random.chance(0.5) {
                    self.put_at_end(nth, &mut sample, random);
                }
            }
            Some(sample)
        };
        let mut samples = Vec::new();
        for _ in 0..8 * count {
            let Some(sample) = one(&mut random).filter(|_| samples.len() < count) else { break };
            if self.domain.holds(&sample, self.inputs) {
                samples.push(sample);
            }
        }
        samples
    }

    /// Returns a scene for a search: values that it has outside of the domain are drawn; `None` if
    /// inputs coincide that must not.
    pub fn scene(&self, setting: SceneSetting, random: &mut Random) -> Option<Sample> {
        let mut sample = scene::sample(self.inputs, setting, random);
        for (nth, input) in self.inputs.iter().enumerate() {
            let is_in = |at: usize| {
                let (low, high) = self.domain.bounds(nth, at);
                !self.domain.states(nth, at) || (low..=high).contains(&input.number(sample[at]))
            };
            let is_unit = self.domain.within[nth] == ValueRange::Unit;
            if !is_unit && !input.range().all(is_in) && !self.draw(nth, &mut sample, random) {
                return None;
            }
        }
        self.domain.fit(&mut sample, self.inputs, random).then_some(sample)
    }

    /// Draws what is stated of an input; returns false if no such value is found.
    pub fn draw(&self, nth: usize, sample: &mut Sample, random: &mut Random) -> bool {
        let (domain, input) = (self.domain, &self.inputs[nth]);
        let scalar = |at: usize, random: &mut Random| {
            let bounds @ (low, high) = domain.bounds(nth, at);
            match input.scalar.kind.is_float() {
                true => domain.distribution(nth, at).draw(bounds, random),
                // Each integer has the same part of the range.
                false => {
                    let x = domain.distribution(nth, at).draw((low - 0.5, high + 0.5), random);
                    x.round().clamp(low, high)
                }
            }
        };
        if domain.within[nth] != ValueRange::Unit {
            for at in input.range().filter(|at| domain.states(nth, *at)) {
                sample[at] = input.word(scalar(at, random));
            }
            return true;
        }
        let uniform = |c: &Component| c.distribution == Distribution::Uniform;
        // By rejection, which keeps directions uniform; it cannot serve another distribution.
        let tries = if domain.components_of(input).all(uniform) { DIRECTIONS } else { 0 };
        let mut all = (0..tries).map(|_| random.unit_vector(input.len));
        if let Some(v) = all.find(|v| domain.is_unit(v, input)) {
            input.put(sample, &v);
            return true;
        }
        // Rare or distributed otherwise: the components are drawn, and a direction of the rest.
        let mut v = random.unit_vector(input.len);
        for c in domain.components_of(input) {
            v[c.at - input.first] = c.distribution.draw(c.bounds, random);
        }
        let found = domain.scale_others(&mut v, input, random);
        input.put(sample, &v);
        found
    }

    /// Moves an input to an end of its range or to another special value in it.
    fn put_at_end(&self, nth: usize, sample: &mut Sample, random: &mut Random) {
        let input = &self.inputs[nth];
        if self.domain.within[nth] == ValueRange::Unit {
            let mut axis = vec![0.0; input.len];
            axis[random.below(input.len)] = if random.chance(0.5) { 1.0 } else { -1.0 };
            if self.domain.is_unit(&axis, input) {
                input.put(sample, &axis);
            }
            return;
        }
        for at in input.range() {
            let (low, high) = self.domain.bounds(nth, at);
            let beside = |x: f64, up: bool| match (input.is_float(), up) {
                (true, true) => f64::from((x as f32).next_up()),
                (true, false) => f64::from((x as f32).next_down()),
                (false, true) => x + 1.0,
                (false, false) => x - 1.0,
            };
            let special =
                [low, high, beside(low, true), beside(high, false), 0.0, 1.0, -1.0, 0.5 * high];
            let inside: Vec<f64> =
                special.into_iter().filter(|x| (low..=high).contains(x)).collect();
            sample[at] = input.word(*random.pick(&inside));
        }
    }

    fn scalars(&self) -> impl Iterator<Item = (usize, usize)> {
        let of = |(nth, input): (usize, &'a super::Input)| input.range().map(move |at| (nth, at));
        self.inputs.iter().enumerate().flat_map(of)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{domain, input, matched};
    use super::*;
    use landfall_exec::harness::call::pure::{PureFunction, PureRequest};
    use landfall_layout::Options;
    use landfall_layout::source::Source;

    const COUNT: usize = 20_000;

    fn domain_of(text: &str, json: &str) -> (Inputs, Domain) {
        let source = Source::new("f.frag", text);
        let request = PureRequest { function: "f".to_string(), ..PureRequest::default() };
        let pure = PureFunction::new(&source, &Options::default(), &request).expect("it is pure");
        let inputs = matched::shared(&pure, &[]);
        let json = serde_json::from_str(json).expect("it is JSON");
        let domain = domain(&source, &pure, &inputs, Some(&json)).expect("it has something in it");
        (inputs, domain)
    }

    fn numbers(samples: &[Sample], inputs: &Inputs, path: &str, component: usize) -> Vec<f64> {
        let input = inputs.iter().find(|i| i.path == path).expect("it is read");
        let at = input.first + component;
        samples.iter().map(|sample| input.number(sample[at])).collect()
    }

    /// Whether numbers are distributed uniformly over a range: by the test of Kolmogorov and
    /// Smirnov, which rejects a uniform sampler with one seed in 10,000.
    fn is_uniform(mut numbers: Vec<f64>, low: f64, high: f64) -> bool {
        numbers.sort_by(f64::total_cmp);
        let count = numbers.len() as f64;
        let part = |x: f64| (x - low) / (high - low);
        let off = numbers.iter().enumerate().map(|(nth, x)| {
            let (below, upto) = (nth as f64 / count, (nth + 1) as f64 / count);
            (part(*x) - below).abs().max((upto - part(*x)).abs())
        });
        off.fold(0.0, f64::max) * count.sqrt() < 2.23
    }

    /// Names with a role each, in every form that a role has.
    const NAMES: [&str; 16] = [
        "c",
        "d",
        "x",
        "shininess",
        "linear",
        "quadratic",
        "constant",
        "cutOff",
        "outerCutOff",
        "cos",
        "intensity",
        "radius",
        "ndotl",
        "inner",
        "exponent",
        "roughness",
    ];

    #[test]
    fn a_stated_range_is_sampled_uniformly_whatever_its_input_is_called() {
        for name in NAMES {
            let text = format!("#version 450\nfloat f(float {name}) {{ return {name}; }}\n");
            for (low, high) in [(0.0, 1.0), (3.0, 7.0), (-2.0, 300.0)] {
                let (inputs, domain) =
                    domain_of(&text, &format!("{{\"{name}\": [{low}, {high}]}}"));
                let all = Sampler::new(&inputs, &domain).all_drawn(1, COUNT);
                assert_eq!(all.len(), COUNT);
                let drawn = numbers(&all, &inputs, name, 0);
                assert!(is_uniform(drawn, low, high), "{name} in {low}..{high}");
            }
        }
    }

    /// What the test above is for: values of scenes, clamped into the range.
    #[test]
    fn a_sampler_that_clamps_is_found() {
        let text = "#version 450\nfloat f(float c) { return c; }\n";
        let (inputs, domain) = domain_of(text, r#"{"c": [0, 1]}"#);
        let mut random = Random::new(1, 0);
        let clamped = (0..COUNT).map(|_| {
            let mut sample = scene::sample(&inputs, SceneSetting::usual(&mut random), &mut random);
            assert!(domain.fit(&mut sample, &inputs, &mut random));
            sample
        });
        let clamped: Vec<Sample> = clamped.collect();
        assert!(!is_uniform(numbers(&clamped, &inputs, "c", 0), 0.0, 1.0));
    }

    const VECTORS: &str = "#version 450
float f(vec3 n, vec2 t, vec4 q, vec3 p, int i, bool b, double g, vec3 color) {
    return n.x + t.x + q.x + p.x + float(i) + float(b) + float(g) + color.x;
}
";

    #[test]
    fn directions_components_integers_and_doubles_are_uniform_too() {
        let (inputs, domain) = domain_of(
            VECTORS,
            r#"{"n": "unit", "n.z": [0.25, 1], "t": "unit", "q": "unit", "p.y": [-3, 5],
                "p.x": "color", "i": [-8, 7], "b": [0, 1], "g": [1, 2], "color": "color"}"#,
        );
        let all = Sampler::new(&inputs, &domain).all_drawn(3, COUNT);
        assert!(all.iter().all(|sample| domain.holds(sample, &inputs)));
        let of = |path: &str, at| numbers(&all, &inputs, path, at);
        assert!(is_uniform(of("n", 2), 0.25, 1.0));
        assert!(is_uniform(of("p", 1), -3.0, 5.0) && is_uniform(of("p", 0), 0.0, 1.0));
        assert!(is_uniform(of("color", 1), 0.0, 1.0) && is_uniform(of("g", 0), 1.0, 2.0));
        let turns = of("t", 0).into_iter().zip(of("t", 1)).map(|(x, y)| y.atan2(x));
        assert!(is_uniform(turns.collect(), -std::f64::consts::PI, std::f64::consts::PI));
        // The square of one coordinate of four has the mean 1/4.
        let squares = of("q", 3).iter().map(|x| x * x).sum::<f64>() / COUNT as f64;
        assert!((squares - 0.25).abs() < 0.01, "{squares}");
        for whole in -8..8 {
            let count = of("i", 0).iter().filter(|x| **x == f64::from(whole)).count();
            // 1,250 of 20,000 are expected, and 35 are a standard deviation.
            assert!((1100..1400).contains(&count), "{whole}: {count}");
        }
        let text: Vec<Option<String>> =
            (0..3).map(|at| domain.distribution_text(at, &inputs[at])).collect();
        let n = Some("unit, uniform over directions, z uniform in 0.25..1".to_string());
        assert_eq!(text[0], n);
    }

    #[test]
    fn a_narrow_part_of_the_sphere_is_drawn_from() {
        let (inputs, domain) = domain_of(
            "#version 450\nfloat f(vec3 n) { return n.x; }\n",
            r#"{"n.z": [0.999, 1], "n": "unit"}"#,
        );
        let all = Sampler::new(&inputs, &domain).all_drawn(1, 2000);
        assert!(all.len() == 2000 && all.iter().all(|sample| domain.holds(sample, &inputs)));
        // The coordinate of a point of the sphere is uniform (Archimedes).
        assert!(is_uniform(numbers(&all, &inputs, "n", 2), 0.999, 1.0));
        let turns = numbers(&all, &inputs, "n", 0).into_iter().zip(numbers(&all, &inputs, "n", 1));
        let turns: Vec<f64> = turns.map(|(x, y)| y.atan2(x)).collect();
        assert!(is_uniform(turns, -std::f64::consts::PI, std::f64::consts::PI));
    }

    #[test]
    fn a_component_of_a_direction_has_the_distribution_stated() {
        let (inputs, domain) = domain_of(
            "#version 450\nfloat f(vec3 n) { return n.x; }\n",
            r#"{"n": "unit", "n.z": {"log": [0.01, 1]}}"#,
        );
        let all = Sampler::new(&inputs, &domain).all_drawn(1, COUNT);
        assert!(all.len() == COUNT && all.iter().all(|sample| domain.holds(sample, &inputs)));
        let exponents = numbers(&all, &inputs, "n", 2).into_iter().map(f64::log10);
        assert!(is_uniform(exponents.collect(), -2.0, 0.0));
    }

    #[test]
    fn a_range_of_one_number_is_a_fixed_value() {
        let text = "#version 450\nfloat f(float x, int k) { return x * float(k); }\n";
        let (inputs, domain) = domain_of(text, r#"{"x": [0.1, 0.1], "k": [4, 4]}"#);
        let sampler = Sampler::new(&inputs, &domain);
        for all in [sampler.all_drawn(1, 100), sampler.at_ends(1, 100)] {
            assert_eq!(numbers(&all, &inputs, "x", 0), [f64::from(0.1f32); 100]);
            assert_eq!(numbers(&all, &inputs, "k", 0), [4.0; 100]);
        }
    }

    #[test]
    fn some_samples_are_at_ends_and_nowhere_else() {
        let text = "#version 450\nfloat f(float x, vec3 n) { return x * n.x; }\n";
        let (inputs, domain) = domain_of(text, r#"{"x": [-2, 8], "n": "unit"}"#);
        let all = Sampler::new(&inputs, &domain).at_ends(1, 2000);
        assert!(all.len() == 2000 && all.iter().all(|sample| domain.holds(sample, &inputs)));
        let known = [-2.0, 8.0, 0.0, 1.0, -1.0, 4.0];
        let beside = [(-2.0f32).next_up(), 8f32.next_down()].map(f64::from);
        let of = |path: &str, at| numbers(&all, &inputs, path, at);
        for (nth, x) in of("x", 0).into_iter().enumerate() {
            let axis = (0..3).any(|at| of("n", at)[nth].abs() == 1.0);
            assert!(axis || known.contains(&x) || beside.contains(&x), "{x}");
        }
        assert!(known.iter().chain(&beside).all(|x| of("x", 0).contains(x)));
    }

    const LIT: &str = "#version 450
layout(binding = 0) uniform Light {
    vec3 position; float cutOff; float shininess; float constant; float linear; vec3 color;
} light;
float f(vec3 normal, vec3 fragPos, float d, float free) { // d in 0..3
    return dot(normal, light.position - fragPos) + light.cutOff + light.shininess + d + free
        + light.constant + light.linear + light.color.x;
}
void main() {}
";

    #[test]
    fn inputs_without_a_range_are_as_in_scenes_and_seldom_at_one_value() {
        let (inputs, domain) = domain_of(LIT, r#"{"normal": "unit"}"#);
        let all = Sampler::new(&inputs, &domain).all_drawn(1, COUNT);
        assert!(all.iter().all(|sample| domain.holds(sample, &inputs)));
        // By their names: exponents up to 256, cones of 12.5 to 60 degrees.
        let of = |path: &str| numbers(&all, &inputs, path, 0);
        assert!(of("light.shininess").iter().all(|x| (1.0..=256.0).contains(x)));
        assert!(of("light.cutOff").iter().all(|x| (0.1..0.99).contains(x)));
        for input in inputs.iter() {
            for at in 0..input.len {
                let mut words: Vec<u64> =
                    numbers(&all, &inputs, &input.path, at).iter().map(|x| x.to_bits()).collect();
                words.sort_unstable();
                let most = words.chunk_by(|a, b| a == b).map(<[u64]>::len).max().unwrap_or(0);
                assert!(4 * most <= COUNT, "{}: {most} at one value", input.path);
            }
        }
    }

    #[test]
    fn a_seed_gives_the_same_samples_again_and_another_gives_others() {
        let (inputs, domain) = domain_of(LIT, "{}");
        let of = |seed| Sampler::new(&inputs, &domain).all_drawn(seed, 100);
        assert_eq!(of(3), of(3));
        assert_ne!(of(3), of(4));
        assert!(Sampler::new(&inputs, &domain).at_ends(1, 10).iter().all(|s| {
            let at = inputs.iter().find(|i| i.path == "d").expect("it is read").first;
            (0.0..=3.0).contains(&input::float(s, at))
        }));
    }
}
