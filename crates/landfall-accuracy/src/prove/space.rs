//! The box of a function's inputs, and its parts.

use super::super::inputs::domain::{Domain, ValueRange};
use super::super::inputs::input::{Input, Inputs, float};
use landfall_interp::graph::Range;
use landfall_layout::shape::ScalarKind;

/// Maximum error of the squared length of a unit vector of a [`Domain`].
const UNIT: f64 = 5.1e-7;

/// The inputs of a function as a box of ranges, one for each scalar; empty where none is read.
#[derive(Debug)]
pub(super) struct InputSpace<'a> {
    pub inputs: &'a Inputs,
    pub domain: &'a Domain,
    pub root: Vec<Range>,
    /// By scalar: its input.
    of: Vec<Option<usize>>,
    /// Unit vectors, by scalars.
    pub units: Vec<Vec<usize>>,
}

/// A range without numbers, for scalars that are not read.
const NONE: Range = Range { low: 1.0, high: 0.0 };

impl<'a> InputSpace<'a> {
    pub fn new(inputs: &'a Inputs, domain: &'a Domain) -> InputSpace<'a> {
        let mut root = vec![NONE; inputs.scalars];
        let mut of = vec![None; inputs.scalars];
        let mut units = Vec::new();
        for (nth, (input, within)) in inputs.iter().zip(&domain.within).enumerate() {
            for at in input.range() {
                root[at] = input_range(input, domain.bounds(nth, at));
                of[at] = Some(nth);
            }
            if *within == ValueRange::Unit {
                units.push(input.range().collect());
            }
        }
        InputSpace { inputs, domain, root, of, units }
    }

    pub fn input(&self, at: usize) -> Option<&Input> {
        self.of[at].map(|nth| &self.inputs[nth])
    }

    /// Returns the word of a number of a scalar, rounded into its type.
    pub fn word(&self, at: usize, x: f64) -> u64 {
        let Some(input) = self.input(at) else { return 0 };
        input.word(x)
    }

    /// Returns the point of a sample as a box.
    pub fn point(&self, sample: &[u64], into: &mut Vec<Range>) {
        into.clear();
        into.extend((0..self.root.len()).map(|at| match self.input(at) {
            Some(input) => {
                let x = input.number(sample[at]);
                Range { low: x, high: x }
            }
            None => NONE,
        }));
    }

    /// Cuts off parts of a box outside of the domain; returns false if nothing is left.
    pub fn cut(&self, part: &mut [Range]) -> bool {
        // A box around the sphere has 2^n corners far outside of it: each component is limited by
        // what the least squares of the others leave, and a box inside of the sphere is empty.
        for unit in &self.units {
            for &at in unit {
                // The squares of the other components add up to the rest of one.
                let rest = |of: fn(Range) -> f64| -> f64 {
                    unit.iter().filter(|&&other| other != at).map(|&other| of(part[other])).sum()
                };
                let square = |x: Range| {
                    let least = x.low.max(-x.high).max(0.0);
                    least * least
                };
                let most = 1.0 + UNIT - rest(square);
                if most < 0.0 {
                    return false;
                }
                // Outwards by one number, since the domain contains unit vectors as they are
                // rounded.
                let bound = most.sqrt().next_up();
                let range = &mut part[at];
                // The numbers are `f32`.
                let bound = f64::from((bound as f32).next_up());
                range.low = range.low.max(-bound);
                range.high = range.high.min(bound);
                if range.low > range.high {
                    return false;
                }
            }
            let reach = |x: &usize| part[*x].low.abs().max(part[*x].high.abs()).powi(2);
            if unit.iter().map(reach).sum::<f64>() < 1.0 - UNIT {
                return false;
            }
        }
        // Two points of a least distance: parts in which all pairs are nearer hold no input.
        self.domain.apart.iter().all(|apart| {
            let (a, b) = (&self.inputs[apart.inputs.0], &self.inputs[apart.inputs.1]);
            if a.len == 1 {
                return part[a.first].high - part[b.first].low >= apart.least;
            }
            let far = a.range().zip(b.range()).map(|(i, j)| {
                let off = (part[i].high - part[j].low).max(part[j].high - part[i].low);
                off * off
            });
            far.sum::<f64>().sqrt().next_up() >= apart.least
        })
    }

    /// Returns where the lower half of a range ends and the upper one begins; `None` if it has only
    /// one number.
    pub fn middle(&self, at: usize, Range { low, high }: Range) -> Option<[f64; 2]> {
        // Halving by numbers, not by length: ranges over orders of magnitude are divided by
        // exponent, or it would take a thousand cuts to come from 1e38 to 1.
        let input = self.input(at)?;
        let is_float = input.is_float();
        // Doubles are not followed.
        if low >= high || input.scalar.kind == ScalarKind::Float && !is_float {
            return None;
        }
        // At zero first: most functions behave differently for either sign.
        let middle = if low < 0.0 && high > 0.0 {
            0.0
        } else if low == 0.0 {
            magnitude(high)
        } else if high == 0.0 {
            -magnitude(-low)
        } else if (high / low).abs().max((low / high).abs()) > 16.0 {
            // The geometric mean where the ends are far apart.
            (low.abs().sqrt() * high.abs().sqrt()) * low.signum()
        } else {
            low / 2.0 + high / 2.0
        };
        if !is_float {
            let middle = middle.floor().clamp(low, high - 1.0);
            return Some([middle, middle + 1.0]);
        }
        // The halves share no number, so each input is in one of them.
        let before = f64::from((high as f32).next_down());
        let middle = f64::from(middle as f32).clamp(low, before);
        Some([middle, f64::from((middle as f32).next_up())])
    }
}

/// Returns a number that divides those from 0 to another one.
fn magnitude(high: f64) -> f64 {
    // Down from huge numbers by square roots, then by powers of two.
    if high > 1.0e6 { high.sqrt() } else { high / 16.0 }
}

/// Returns the numbers of an input within its domain.
fn input_range(input: &Input, (low, high): (f64, f64)) -> Range {
    let of = |low: f64, high: f64| Range { low, high };
    match (input.scalar.kind, input.scalar.width) {
        (ScalarKind::Float, 4 | 2) | (ScalarKind::Bfloat, _) => {
            // Ends are rounded inwards: numbers outside of the domain are no input.
            let [least, most] = [low as f32, high as f32];
            let least = if f64::from(least) < low { least.next_up() } else { least };
            let most = if f64::from(most) > high { most.next_down() } else { most };
            of(f64::from(least), f64::from(most))
        }
        (ScalarKind::Bool, _) => of(low.max(0.0), high.min(1.0)),
        (ScalarKind::Sint, _) => of(low.max(-2_147_483_648.0), high.min(2_147_483_647.0)),
        (ScalarKind::Uint, _) => of(low.max(0.0), high.min(4_294_967_295.0)),
        _ => of(low, high),
    }
}

pub(super) fn is_finite(inputs: &Inputs, sample: &[u64]) -> bool {
    inputs.float_scalars().all(|at| float(sample, at).is_finite())
}
