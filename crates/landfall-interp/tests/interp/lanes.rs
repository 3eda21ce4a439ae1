//! Operations written to be vectorised give what Rust's give.

use landfall_interp::internals::{lanes_of, quotient, remainder, saturated};

const LANES: usize = 64;

#[test]
fn lanes_are_those_of_the_last_bits() {
    let mut rng = fastrand::Rng::with_seed(3);
    for _ in 0..1000 {
        let words = [0; LANES].map(|_| rng.u32(..));
        let lanes = lanes_of(&words);
        assert!((0..LANES).all(|lane| lanes >> lane & 1 == u64::from(words[lane] & 1)));
    }
}

#[test]
fn numbers_are_converted_as_by_rust() {
    let mut rng = fastrand::Rng::with_seed(4);
    let special = [0.0, -0.0, 0.5, -0.5, 2147483646.5, 2147483647.0, 2147483648.0, 1e300];
    let special = special.into_iter().flat_map(|x: f64| [x, -x, x + 1e-9, x - 1e-9]);
    let bits = std::iter::repeat_with(|| f64::from_bits(rng.u64(..))).take(1000);
    let all: Vec<f64> =
        special.chain([f64::NAN, f64::INFINITY, -f64::INFINITY]).chain(bits).collect();
    let small = std::iter::repeat_with(|| rng.f64() * 5e9 - 2.5e9).take(100_000);
    for x in all.into_iter().chain(small) {
        assert_eq!(saturated(x), x as i32, "{x:e}");
    }
}

#[test]
fn quotients_are_those_of_integers() {
    let mut rng = fastrand::Rng::with_seed(5);
    let mut number = || match rng.u32(..4) {
        0 => rng.u32(..),
        1 => u32::MAX - rng.u32(..9),
        _ => rng.u32(..) >> rng.u32(..32),
    };
    for _ in 0..1_000_000 {
        let (a, b) = (number(), number());
        let near = b.wrapping_mul(number()).wrapping_sub(number() & 1);
        for a in [a, near] {
            assert_eq!(quotient(a, b), a.checked_div(b).unwrap_or(a), "{a} / {b}");
            assert_eq!(remainder(a, b), a.checked_rem(b).unwrap_or(0), "{a} % {b}");
        }
    }
}
