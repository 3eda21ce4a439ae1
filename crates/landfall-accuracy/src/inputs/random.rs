//! Random numbers that are the same on every machine (splitmix64).
//!
//! Used by the samples of [`stress`](crate::stress) and
//! [`bench`](mod@crate::bench).

use glam::DVec3;

use landfall_light::splitmix64::{STEP, SplitMix64};

#[derive(Clone, Debug)]
pub(crate) struct Random {
    numbers: SplitMix64,
}

impl Random {
    /// Returns the stream with that number for a seed.
    pub fn new(seed: u64, stream: u64) -> Random {
        let state = seed ^ stream.wrapping_mul(STEP);
        let mut random = Random { numbers: SplitMix64(state) };
        random.word();
        random
    }

    pub fn word(&mut self) -> u64 {
        self.numbers.next_u64()
    }

    /// Returns an integer from 0 to `end`, exclusive.
    pub fn below(&mut self, end: usize) -> usize {
        ((u128::from(self.word()) * end.max(1) as u128) >> 64) as usize
    }

    /// Returns a number from 0 to 1.
    pub fn unit(&mut self) -> f64 {
        self.numbers.unit()
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Returns a number between two positive ones, each power of two equally likely.
    pub fn scale(&mut self, low: f64, high: f64) -> f64 {
        (self.between(low.ln(), high.ln())).exp()
    }

    pub fn chance(&mut self, share: f64) -> bool {
        self.unit() < share
    }

    pub fn pick<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[self.below(all.len())]
    }

    /// Returns a number of the normal distribution with mean 0 and deviation 1 (Box and Muller).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.unit()).cos()
    }

    /// Returns a vector of length one, uniform over all directions.
    pub fn unit_vector(&mut self, len: usize) -> Vec<f64> {
        loop {
            let v: Vec<f64> = (0..len).map(|_| self.normal()).collect();
            let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
            if length > 1e-3 {
                return v.into_iter().map(|x| x / length).collect();
            }
        }
    }

    /// Returns a direction, uniform over the sphere.
    pub fn direction(&mut self) -> DVec3 {
        loop {
            let mut part = || self.between(-1.0, 1.0);
            let v = DVec3::new(part(), part(), part());
            let d2 = v.length_squared();
            // Rejecting what is outside the ball makes all directions equally likely.
            if d2 > 1e-3 && d2 <= 1.0 {
                return v / d2.sqrt();
            }
        }
    }

    /// Returns a finite `f32`, each exponent equally likely.
    pub fn bits(&mut self) -> f32 {
        loop {
            let x = f32::from_bits(self.word() as u32);
            if x.is_finite() {
                return x;
            }
        }
    }
}
