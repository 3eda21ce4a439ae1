//! Ordinary samples: values of published scenes, without the cones, highlights and distances that
//! only occur in stress tests.
//!
//! Used by [`bench`](mod@crate::accuracy::bench), whose errors and times are those of real use.

use super::domain::Domain;
use super::input::{Inputs, Sample};
use super::random::Random;
use super::scene::{Geometry, Setting, sample};

/// The arrangements of light, fragment and eye in a picture, the most likely first.
const GEOMETRIES: [Geometry; 8] = [
    Geometry::Ordinary,
    Geometry::Ordinary,
    Geometry::Ordinary,
    Geometry::OnAxis,
    Geometry::InRamp,
    Geometry::Mirror,
    Geometry::Behind,
    Geometry::Grazing,
];

/// The widest of the scenes' cones; exponents go up to 256.
const CONES: usize = 3;
const SHINES: usize = 5;

/// Returns samples in the domain; fewer or none if it excludes nearly all of them.
pub(in crate::accuracy) fn published(
    inputs: &Inputs,
    domain: &Domain,
    seed: u64,
    count: usize,
) -> Vec<Sample> {
    let mut random = Random::new(seed, 0);
    let mut samples = Vec::with_capacity(count);
    for _ in 0..8 * count {
        if samples.len() == count {
            break;
        }
        let setting = Setting {
            geometry: *random.pick(&GEOMETRIES),
            cone: random.below(CONES),
            shine: random.below(SHINES),
        };
        let mut one = sample(inputs, setting, &mut random);
        if domain.fit(&mut one, inputs, &mut random) {
            samples.push(one);
        }
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::super::{domain, input, matched};
    use super::*;
    use landfall_exec::harness::call::pure::{PureFunction, PureRequest};
    use landfall_layout::Options;
    use landfall_layout::source::Source;

    fn samples(text: &str, json: &str, seed: u64) -> (Inputs, Domain, Vec<Sample>) {
        let source = Source::new("f.frag", text);
        let request = PureRequest { function: "f".to_string(), ..PureRequest::default() };
        let pure = PureFunction::new(&source, &Options::default(), &request).expect("it is pure");
        let inputs = matched::shared(&pure, &[]);
        let json = serde_json::from_str(json).expect("it is JSON");
        let domain = domain(&source, &pure, &inputs, Some(&json)).expect("it has something in it");
        let all = published(&inputs, &domain, seed, 500);
        (inputs, domain, all)
    }

    const LIT: &str = "#version 450
layout(binding = 0) uniform Light { vec3 position; float cutOff; float shininess; } light;
float f(vec3 normal, vec3 fragPos, float d) { // d in 0..3
    return dot(normal, light.position - fragPos) + light.cutOff + light.shininess + d;
}
void main() {}
";

    #[test]
    fn samples_are_in_the_domain_of_comments_and_of_json_and_as_scenes_have_them() {
        let (inputs, domain, all) = samples(LIT, r#"{"normal": "unit"}"#, 1);
        assert_eq!(all.len(), 500);
        assert!(all.iter().all(|sample| domain.holds(sample, &inputs)));
        let of = |path: &str| inputs.iter().find(|i| i.path == path).expect("it is read").first;
        let float = |sample: &Sample, path: &str| input::float(sample, of(path));
        assert!(all.iter().all(|s| (0.0..=3.0).contains(&float(s, "d"))));
        // By their names: exponents up to 256, cones of 12.5 to 60 degrees.
        assert!(all.iter().all(|s| (1.0..=256.0).contains(&float(s, "light.shininess"))));
        assert!(all.iter().all(|s| (0.49..0.98).contains(&float(s, "light.cutOff"))));
    }

    #[test]
    fn a_seed_gives_the_same_samples_again_and_another_gives_others() {
        let of = |seed| samples(LIT, "{}", seed).2;
        assert_eq!(of(3), of(3));
        assert_ne!(of(3), of(4));
    }
}
