//! The largest values of Gegenbauer polynomials.

use pulp::Simd;

use crate::lanes::Lanes;

/// The largest absolute value of a Gegenbauer polynomial of order 2 to 8 from 0 to a number.
#[derive(Clone, Copy, Default)]
pub(super) struct Gegenbauer {
    /// That of its extrema within 0 to 1.
    extremum: f32,
    /// The coefficients of every second power, from the lowest.
    coefficients: [f32; 5],
    count: usize,
}

impl Gegenbauer {
    /// Returns the bound of `C` of an order, whose generating function is `(1 - 2 t y + y^2)^-of`.
    pub fn new(order: u32, of: f64) -> Gegenbauer {
        // By powers of t.
        let (mut last, mut this) = ([0.0; 9], [0.0; 9]);
        (last[0], this[1]) = (1.0, 2.0 * of);
        for n in 2..=order {
            let n = f64::from(n);
            let mut next = last.map(|x| -x * (n + 2.0 * of - 2.0) / n);
            for power in 1..9 {
                next[power] += this[power - 1] * 2.0 * (n + of - 1.0) / n;
            }
            (last, this) = (this, next);
        }
        let value = |t: f64| this.iter().rev().fold(0.0, |sum, x| sum * t + x).abs();
        let steps = 1 << 9;
        let at = |step: i32| value(f64::from(step) / f64::from(steps));
        let is_extremum = |step: &i32| at(*step) >= at(step - 1).max(at(step + 1));
        let extremum = (0..steps).filter(is_extremum).map(at).fold(0.0, f64::max);
        let first = order as usize % 2;
        let coefficient = |at: usize| this.get(first + 2 * at).map_or(0.0, |x| *x as f32);
        Gegenbauer {
            extremum: (extremum * 1.001) as f32,
            coefficients: [0, 1, 2, 3, 4].map(coefficient),
            count: order as usize / 2 + 1,
        }
    }

    /// Returns the bound from 0 to the root of `square`: an odd polynomial is less than itself over `t`.
    #[inline(always)]
    pub fn most<S: Simd>(&self, square: Lanes<S>) -> Lanes<S> {
        let mut value = square.splat(0.0);
        for coefficient in self.coefficients[..self.count].iter().rev() {
            value = value.mul_add(square, square.splat(*coefficient));
        }
        value.larger(value.splat(self.extremum))
    }
}
