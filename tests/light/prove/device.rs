//! A conformant device that rounds at random: each operation within the error that WGSL 15.7.4 and
//! Vulkan's appendix on precision permit, two evaluations of one expression to one value.

use std::collections::HashMap;

use super::expression::Tree;
use super::soundness::Random;

pub struct Device<'r> {
    inputs: [f32; 3],
    random: &'r mut Random,
    known: HashMap<String, Option<f32>>,
}

/// The distance of neighbouring `f32`.
fn unit(x: f64) -> f64 {
    let exponent = (x.abs().to_bits() >> 52) as i32 - 1023 - 23;
    2f64.powi(exponent.max(-149))
}

impl<'r> Device<'r> {
    pub fn new(inputs: [f32; 3], random: &'r mut Random) -> Device<'r> {
        Device { inputs, random, known: HashMap::new() }
    }

    /// Returns a value that it may give; `None` where none is defined.
    pub fn value(&mut self, tree: &Tree) -> Option<f32> {
        let text = tree.text();
        if let Some(known) = self.known.get(&text) {
            return *known;
        }
        let value = match tree {
            Tree::Input(n) => Some(self.inputs[*n]),
            Tree::Constant(x) => Some(*x),
            Tree::Call(form, operands) => self.call(form, operands),
        };
        let value = value.filter(|x| x.is_finite());
        self.known.insert(text, value);
        value
    }

    /// Rounds to either neighbour.
    fn rounded(&mut self, x: f64) -> Option<f32> {
        let near = x as f32;
        let (low, high) = match f64::from(near) {
            y if y > x => (near.next_down(), near),
            y if y < x => (near, near.next_up()),
            _ => (near, near),
        };
        let chosen = if self.random.below(2) == 0 { low } else { high };
        (low.is_finite() && high.is_finite()).then_some(chosen)
    }

    /// Takes a number up to an error away.
    fn within(&mut self, x: f64, error: f64) -> Option<f32> {
        let y = (x + self.random.between(-0.999, 0.999) * error) as f32;
        // Rounding to an `f32` must not leave the error.
        let fits = (f64::from(y) - x).abs() <= error;
        if fits { Some(y) } else { Some(x as f32) }
    }

    fn add(&mut self, x: f32, y: f32) -> Option<f32> {
        // The sum of numbers far apart is off in `f64`, too, by too little to matter.
        self.rounded(f64::from(x) + f64::from(y))
    }

    fn mul(&mut self, x: f32, y: f32) -> Option<f32> {
        self.rounded(f64::from(x) * f64::from(y))
    }

    fn div(&mut self, x: f32, y: f32) -> Option<f32> {
        let size = y.abs();
        if !(2f32.powi(-126)..=2f32.powi(126)).contains(&size) {
            return None;
        }
        let q = f64::from(x) / f64::from(y);
        self.within(q, 2.5 * unit(q))
    }

    /// The reciprocal of a reciprocal root within 2 units.
    fn sqrt(&mut self, x: f32) -> Option<f32> {
        if x < f32::MIN_POSITIVE {
            return (x == 0.0).then_some(0.0);
        }
        let inverse = 1.0 / f64::from(x).sqrt();
        let inverse = self.within(inverse, 2.0 * unit(inverse))?;
        self.div(1.0, inverse)
    }

    fn call(&mut self, form: &str, operands: &[Tree]) -> Option<f32> {
        // Both sides of a selection are evaluated, and only what is used counts.
        let [x, y, z] = [0, 1, 2].map(|n| &operands[n]);
        if form == "(x < y ? z : x)" {
            let x = self.value(x)?;
            return if x < self.value(y)? { self.value(z) } else { Some(x) };
        }
        let x = self.value(x)?;
        match form {
            "sqrt(x)" => return self.sqrt(x),
            "abs(x)" => return Some(x.abs()),
            "sin(x)" => {
                let inside = f64::from(x).abs() <= std::f64::consts::PI;
                let sine = f64::from(x).sin();
                return if inside { self.within(sine, 2f64.powi(-11)) } else { None };
            }
            "exp(x)" => {
                let value = f64::from(x).exp();
                let error = (3.0 + 2.0 * f64::from(x).abs()) * unit(value);
                return if value < 1e38 { Some(self.within(value, error)?.max(0.0)) } else { None };
            }
            "clamp(x, -1.0, 1.0)" => return Some(x.clamp(-1.0, 1.0)),
            "floor(x)" => return Some(x.floor()),
            "smoothstep(-1.0, 2.0, x)" => {
                let (past, width) = (self.add(x, 1.0)?, 3.0);
                let t = self.div(past, width)?.clamp(0.0, 1.0);
                let (square, twice) = (self.mul(t, t)?, self.mul(2.0, t)?);
                let rest = self.add(3.0, -twice)?;
                return self.mul(square, rest);
            }
            _ => {}
        }
        let y = self.value(y)?;
        match form {
            "(x + y)" => self.add(x, y),
            "(x - y)" => self.add(x, -y),
            "(x * y)" => self.mul(x, y),
            "(x / y)" => self.div(x, y),
            "min(x, y)" => Some(x.min(y)),
            "max(x, y)" => Some(x.max(y)),
            "length(vec2(x, y))" => {
                let (a, b) = (self.mul(x, x)?, self.mul(y, y)?);
                let sum = self.add(a, b)?;
                self.sqrt(sum)
            }
            "mix(x, y, z)" => {
                let z = self.value(z)?;
                let rest = self.add(1.0, -z)?;
                let (a, b) = (self.mul(x, rest)?, self.mul(y, z)?);
                self.add(a, b)
            }
            "dot(vec2(x, y), vec2(y, z))" => {
                let z = self.value(z)?;
                let (a, b) = (self.mul(x, y)?, self.mul(y, z)?);
                self.add(a, b)
            }
            other => unreachable!("{other} is no operation"),
        }
    }
}
