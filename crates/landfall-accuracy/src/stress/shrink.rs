//! Simplifies failing inputs: to zeros, ones, round numbers, few bits.
//!
//! Used by [`find`](super::find).

use super::deadline::Deadline;
use super::domain::Domain;
use super::input::{Input, Sample, float};
use super::role::InputRole;

const TRIALS: usize = 600;

/// Simplifies a sample while it still fails.
pub(super) fn shrink(
    sample: &Sample,
    inputs: &[Input],
    domain: &Domain,
    until: &Deadline,
    mut breaks: impl FnMut(&Sample) -> bool,
) -> Sample {
    // Greedy: each candidate that is simpler and still fails becomes the best. First whole vectors,
    // then single scalars; a second round takes what the first made possible.
    let mut best = sample.clone();
    let mut trials = 0;
    let mut attempt = |best: &mut Sample, next: Sample| -> bool {
        // A candidate outside of the domain is no input.
        if trials >= TRIALS || until.is_over() || !domain.holds(&next, inputs) {
            return false;
        }
        trials += 1;
        let good = breaks(&next);
        if good {
            *best = next;
        }
        good
    };
    for round in 0..2 {
        let before = best.clone();
        if round == 0 {
            for input in inputs {
                if until.is_over() {
                    return best;
                }
                let now = cost(input, &best[input.range()]);
                for whole in wholes(input) {
                    if cost(input, &whole) >= now {
                        continue;
                    }
                    let mut next = best.clone();
                    next[input.range()].copy_from_slice(&whole);
                    if attempt(&mut best, next) {
                        break;
                    }
                }
            }
        }
        for input in inputs {
            if until.is_over() {
                return best;
            }
            for at in input.range() {
                let now = simplicity(input, best[at]);
                for x in simpler(input, best[at]) {
                    if simplicity(input, x) >= now {
                        continue;
                    }
                    let mut next = best.clone();
                    next[at] = x;
                    if attempt(&mut best, next) {
                        break;
                    }
                }
            }
        }
        if best == before {
            break;
        }
    }
    best
}

/// Returns the values to try for a whole input.
fn wholes(input: &Input) -> Vec<Vec<u64>> {
    let of = |x: f32| u64::from(x.to_bits());
    if !input.is_float() {
        return vec![vec![0; input.len], vec![1; input.len]];
    }
    let mut all = vec![vec![of(0.0); input.len], vec![of(1.0); input.len]];
    if input.is_vector() {
        for axis in (0..input.len.min(3)).rev() {
            for sign in [1.0, -1.0] {
                let mut v = vec![of(0.0); input.len];
                v[axis] = of(sign);
                all.push(v);
            }
        }
    }
    // The identity matrix.
    if input.len > input.rows {
        let one = |i: usize| of(f32::from(u8::from(i / input.rows == i % input.rows)));
        all.insert(0, (0..input.len).map(one).collect());
    }
    all
}

/// Returns simpler words than the given one, the simplest first.
fn simpler(input: &Input, word: u64) -> Vec<u64> {
    if !input.is_float() {
        return vec![0, 1, 2, word >> 1, word >> 4];
    }
    let x = f32::from_bits(word as u32);
    if !x.is_finite() {
        return Vec::new();
    }
    let mut all: Vec<f32> = vec![0.0, 1.0, -1.0, 0.5, 2.0, 10.0];
    // Fewer decimal digits, then fewer bits of the mantissa.
    for digits in 0..4usize {
        all.extend(format!("{x:.digits$e}").parse::<f32>());
    }
    all.push(x.round());
    // Tiny numbers that occur, in place of those next to the least one.
    if x.abs() < LEAST[0] {
        all.extend([1.0e-7f32, 1.0e-10, 1.0e-14, 1.0e-18].map(|y| y.copysign(x)));
    }
    for kept in [1, 2, 4, 8, 12, 16] {
        all.push(f32::from_bits((x.to_bits() >> (23 - kept)) << (23 - kept)));
    }
    all.into_iter().filter(|y| y.is_finite()).map(|y| u64::from(y.to_bits())).collect()
}

fn cost(input: &Input, words: &[u64]) -> u32 {
    words.iter().map(|&word| simplicity(input, word)).sum()
}

/// Returns the complexity of a word: the less, the simpler.
fn simplicity(input: &Input, word: u64) -> u32 {
    if !input.is_float() {
        return 64 - word.leading_zeros();
    }
    let x = f32::from_bits(word as u32);
    if x == 0.0 {
        return u32::from(x.is_sign_negative());
    }
    let sign = u32::from(x < 0.0);
    if x.abs() == 1.0 {
        return 2 + sign;
    }
    let digits = format!("{:e}", x.abs());
    let (mantissa, exponent) = digits.split_once('e').unwrap_or((&digits, "0"));
    let exponent = exponent.trim_start_matches('-').parse::<u32>().unwrap_or(0);
    let decimal = mantissa.len() as u32 * 3 + exponent.min(40) / 3;
    // The less of two measures: characters of the shortest decimal, or bits set, so that both 0.1
    // and 2^-20 are simple.
    let set = (x.to_bits() & 0x7f_ffff).count_ones();
    3 + sign + decimal.min(2 * set + 12)
}

/// The least magnitude that an input has in scenes, and the least whose square is not lost.
const LEAST: [f32; 2] = [1.0e-7, 1.0e-18];

/// The greatest magnitude of an input of which nothing is stated.
const LIMIT: f32 = 1.1e7;

/// Whether the inputs are values that occur: those of a domain that is stated, else those of
/// scenes.
pub(super) fn plausible(inputs: &[Input], domain: &Domain, sample: &Sample) -> bool {
    let floats = inputs.iter().enumerate().filter(|(_, input)| input.is_float());
    floats.into_iter().all(|(nth, input)| {
        input.range().all(|at| {
            let x = float(sample, at).abs();
            let is_stated = domain.states(nth, at);
            let least = LEAST[usize::from(is_stated || input.role == InputRole::Other)];
            x == 0.0 || x >= least && (is_stated || x <= LIMIT)
        })
    })
}
