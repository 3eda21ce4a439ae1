//! Inputs from a seed: edges, numbers uniform over bit patterns, and numbers uniform over the
//! domain. Feeds the cases.

use crate::support::sample::everything;

/// Inputs of a case: a whole number of workgroups.
pub fn count() -> usize {
    if everything() { 4096 } else { 512 }
}

/// Numbers that show edges; each domain takes those in it.
const EDGES: [f32; 34] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.999_999_94,
    1.000_000_1,
    -0.999_999_94,
    -1.000_000_1,
    0.5,
    -0.5,
    0.499_999_97,
    1.5,
    -1.5,
    2.0,
    2.5,
    -2.5,
    3.0,
    0.1,
    std::f32::consts::PI,
    std::f32::consts::FRAC_PI_2,
    std::f32::consts::E,
    1e-45,
    -1e-45,
    1.175_494_2e-38,
    f32::MIN_POSITIVE,
    -f32::MIN_POSITIVE,
    8_388_607.5,
    8_388_609.0,
    16_777_216.0,
    2_147_483_648.0,
    4_294_967_040.0,
    1e30,
    f32::MAX,
    f32::MIN,
];

/// Floats in order as integers in order.
fn key(x: f32) -> i64 {
    let bits = i64::from(x.to_bits() & 0x7fff_ffff);
    if x.is_sign_negative() { -bits - 1 } else { bits }
}

fn of_key(key: i64) -> f32 {
    if key < 0 { f32::from_bits((-key - 1) as u32 | 1 << 31) } else { f32::from_bits(key as u32) }
}

pub struct Draw(pub fastrand::Rng);

impl Draw {
    pub fn new(name: &str) -> Draw {
        // The name's own seed, so that a case of before keeps its inputs when one is added.
        let fold = |seed: u64, b: u8| (seed ^ u64::from(b)).wrapping_mul(0x100_0000_01b3);
        Draw(fastrand::Rng::with_seed(name.bytes().fold(0xcbf2_9ce4_8422_2325, fold)))
    }

    /// A float of the range, no subnormal nearer to zero than `least`.
    pub fn float(&mut self, low: f32, high: f32) -> f32 {
        match self.0.u32(0..8) {
            0 => {
                let edges: Vec<f32> = EDGES
                    .into_iter()
                    .chain([low, high, of_key(key(low) + 1), of_key(key(high) - 1)])
                    .filter(|e| (key(low)..=key(high)).contains(&key(*e)))
                    .collect();
                edges[self.0.usize(0..edges.len())]
            }
            1..4 => of_key(self.0.i64(key(low)..=key(high))),
            _ => {
                let (low, high) = (f64::from(low), f64::from(high));
                (low + self.0.f64() * (high - low)) as f32
            }
        }
    }

    /// A word: small, all bits, or any.
    pub fn word(&mut self) -> u32 {
        const EDGES: [u32; 10] =
            [0, 1, 2, 31, 32, 0x7fff_ffff, 0x8000_0000, 0x8000_0001, u32::MAX - 1, u32::MAX];
        match self.0.u32(0..8) {
            0 => EDGES[self.0.usize(0..EDGES.len())],
            1..4 => self.0.u32(..) >> self.0.u32(0..32),
            4 => (self.0.u32(..) >> self.0.u32(0..32)).wrapping_neg(),
            _ => self.0.u32(..),
        }
    }
}
