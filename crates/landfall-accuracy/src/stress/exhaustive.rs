//! Enumerates all inputs of a function with a small domain.
//!
//! Built from a [`Domain`]; [`generate`](super::generate) makes chunks of it instead of samples.

use super::domain::{Domain, ValueRange};
use super::input::{Input, Inputs, Sample};
use landfall_layout::shape::ScalarKind;

/// All combinations of a function's inputs.
#[derive(Clone, Debug)]
pub(super) struct ExhaustiveInputs {
    values: Vec<ScalarValues>,
    scalars: usize,
    count: u64,
    /// The step from one input to the next, so that an interrupted run has covered all parts.
    stride: u64,
}

#[derive(Clone, Debug)]
struct ScalarValues {
    at: usize,
    first: i64,
    count: u64,
    word: fn(i64) -> u64,
}

impl ExhaustiveInputs {
    /// Returns all inputs of a domain, if there are at most `most` and each scalar has an
    /// independent range.
    pub fn new(inputs: &Inputs, domain: &Domain, most: u64) -> Option<ExhaustiveInputs> {
        // Distances between inputs and unit vectors make scalars depend on each other.
        if !domain.apart.is_empty() {
            return None;
        }
        let (mut values, mut count) = (Vec::new(), 1u64);
        if domain.within.contains(&ValueRange::Unit) {
            return None;
        }
        for (nth, input) in inputs.iter().enumerate() {
            for at in input.range() {
                let one = values_of(at, input, domain.bounds(nth, at))?;
                count = count.checked_mul(one.count).filter(|count| *count <= most)?;
                values.push(one);
            }
        }
        // Steps of the golden section leave neighbours for late.
        let first = (count as f64 * 0.618) as u64;
        // Coprime to the count, the stride visits each number once.
        let stride = (first.max(1)..).find(|stride| divisor(*stride, count) == 1)?;
        Some(ExhaustiveInputs { values, scalars: inputs.scalars, count, stride })
    }

    pub fn count(&self) -> u64 {
        self.count
    }

    pub fn sample(&self, number: u64) -> Sample {
        // In 128 bits, since number times stride overflows 64.
        let mut rest = u128::from(number) * u128::from(self.stride) % u128::from(self.count);
        let mut sample = vec![0; self.scalars];
        // A number with one digit for each scalar, in mixed radix.
        for ScalarValues { at, first, count, word } in &self.values {
            sample[*at] = word(first + (rest % u128::from(*count)) as i64);
            rest /= u128::from(*count);
        }
        sample
    }
}

fn divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { divisor(b, a % b) }
}

/// Returns the values of a scalar; `None` for a range that cannot be enumerated or is empty.
fn values_of(at: usize, input: &Input, (low, high): (f64, f64)) -> Option<ScalarValues> {
    let whole = |least: f64, most: f64| {
        (low.ceil().clamp(least, most) as i64, high.floor().clamp(least, most) as i64)
    };
    type Word = fn(i64) -> u64;
    let as_word: Word = |x| u64::from(x as u32);
    let ((first, last), word) = match (input.scalar.kind, input.scalar.width) {
        (ScalarKind::Bool, _) => (whole(0.0, 1.0), as_word),
        (ScalarKind::Sint, 4) => (whole(f64::from(i32::MIN), f64::from(i32::MAX)), as_word),
        (ScalarKind::Uint, 4) => (whole(0.0, f64::from(u32::MAX)), as_word),
        // Floats in the order of their values, by a map of bits that preserves it.
        (ScalarKind::Float, 4) => {
            let word: Word = |place| u64::from(turned(place as i32) as u32);
            (floats(low, high), word)
        }
        _ => return None,
    };
    let inside =
        first <= last && (input.is_float() || (low <= last as f64 && first as f64 <= high));
    inside.then(|| ScalarValues { at, first, count: (last - first) as u64 + 1, word })
}

/// Returns the positions of the first and last `f32` of a range in the order of all floats, both
/// zeros included.
fn floats(low: f64, high: f64) -> (i64, i64) {
    // Ends are rounded inwards; a zero at an end is both zeros.
    let most = f64::from(f32::MAX);
    let (low, high) = (low.clamp(-most, most), high.clamp(-most, most));
    let (mut first, mut last) = (low as f32, high as f32);
    if f64::from(first) < low {
        first = first.next_up();
    }
    if f64::from(last) > high {
        last = last.next_down();
    }
    let first = if first == 0.0 { -0.0 } else { first };
    let last = if last == 0.0 { 0.0 } else { last };
    let place = |x: f32| i64::from(turned(x.to_bits() as i32));
    (place(first), place(last))
}

/// Converts between the bits of a float and its position in the order of all floats; negative ones
/// run backwards.
fn turned(bits: i32) -> i32 {
    // Negative floats have descending bits: flipping all but the sign reverses them.
    if bits < 0 { bits ^ i32::MAX } else { bits }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::super::matched;
    use super::*;
    use landfall_exec::harness::call::pure::{PureFunction, PureRequest};
    use landfall_layout::{Options, Source};

    fn every(parameters: &str, json: &str, most: u64) -> Option<ExhaustiveInputs> {
        let text =
            format!("#version 450\nfloat f({parameters}) {{ return 1.0; }}\nvoid main() {{}}\n");
        let source = Source::new("f.frag", text);
        let request = PureRequest { function: "f".to_string(), ..PureRequest::default() };
        let pure = PureFunction::new(&source, &Options::default(), &request).expect("it is pure");
        let inputs = matched::shared(&pure, &[]);
        let mut domain = Domain::any(&inputs);
        let json = serde_json::from_str(json).expect("it is JSON");
        domain.add_json(&json, &inputs).expect("it has something in it");
        ExhaustiveInputs::new(&inputs, &domain, most)
    }

    #[test]
    fn floats_of_a_range_are_counted_with_both_ends_and_both_zeros() {
        for (json, count) in [
            // The exponent below 1, and 1.
            (r#"{"x": [0.5, 1]}"#, (1 << 23) + 1),
            // 127 exponents with the subnormals, 1, and the zero below.
            (r#"{"x": [0, 1]}"#, 127 * (1 << 23) + 2),
            (r#"{"x": [-1, 1]}"#, 2 * (127 * (1 << 23) + 1)),
            // All but the last exponent of either sign.
            (r#"{"x": "any"}"#, 2 * 255 * (1 << 23)),
            // Neither end is an f32.
            (r#"{"x": [0.99999999, 1.00000001]}"#, 1),
        ] {
            let all = every("float x", json, 1 << 32).expect("it is a range");
            assert_eq!(all.count(), count, "{json}");
        }
        assert!(every("float x", r#"{"x": [0.5, 1]}"#, 1 << 23).is_none(), "one too many");
    }

    #[test]
    fn several_small_inputs_are_each_with_each_once() {
        let json = r#"{"n": [-2, 2.5], "v": [-1.5e-45, 1.5e-45]}"#;
        let all = every("bool b, int n, vec2 v", json, 1000).expect("each is small");
        // Two booleans, -2 to 2, and twice the two zeros with the subnormal at either side.
        assert_eq!(all.count(), 2 * 5 * 4 * 4);
        let samples: HashSet<Sample> = (0..all.count()).map(|n| all.sample(n)).collect();
        assert_eq!(samples.len() as u64, all.count());
        let numbers: HashSet<i32> = samples.iter().map(|sample| sample[1] as u32 as i32).collect();
        assert_eq!(numbers, HashSet::from([-2, -1, 0, 1, 2]));
        let signs: HashSet<u32> = samples.iter().map(|sample| sample[2] as u32).collect();
        assert_eq!(signs, HashSet::from([0, 1, 1 << 31, 1 << 31 | 1]));
    }

    #[test]
    fn what_is_no_range_of_each_scalar_is_left_to_samples() {
        assert!(every("vec2 v", r#"{"v": "unit"}"#, u64::MAX).is_none());
        let apart = r#"{"no_coincidence": ["a", "b"], "a": [1, 1.00001], "b": [1, 1.00001]}"#;
        assert!(every("float a, float b", apart, u64::MAX).is_none());
    }
}
