//! Elementary functions in all lanes have the bits of the scalar functions.

use landfall_interp::internals::{RealUnary, powers, series};

const LANES: usize = 64;

fn scalar(f: RealUnary, x: f64) -> f64 {
    match f {
        RealUnary::Exp => x.exp(),
        RealUnary::Exp2 => x.exp2(),
        RealUnary::Log => x.ln(),
        RealUnary::Log2 => x.log2(),
        RealUnary::Sin => x.sin(),
        RealUnary::Cos => x.cos(),
        _ => unreachable!("{f:?} has no series"),
    }
}

/// Every lane of every processor's registers has the bits of the scalar function, or is left
/// to it.
fn agree(
    functions: &[RealUnary],
    columns: impl Fn(&mut fastrand::Rng) -> [f32; LANES],
    most: usize,
) {
    let mut rng = fastrand::Rng::with_seed(7);
    for &f in functions {
        let mut left = 0;
        for _ in 0..2000 {
            let a = columns(&mut rng);
            for (to, rest) in series(f, &a) {
                left += rest.count_ones() as usize;
                for lane in (0..LANES).filter(|lane| rest >> lane & 1 == 0) {
                    let expected = scalar(f, f64::from(a[lane])) as f32;
                    let same = to[lane].to_bits() == expected.to_bits();
                    assert!(same, "{f:?}({:e}) = {:e}, not {expected:e}", a[lane], to[lane]);
                }
            }
        }
        assert!(left < most, "{f:?} leaves {left} of {}", 4000 * LANES);
    }
}

#[test]
fn functions_of_usual_numbers_have_the_bits_of_the_scalar_ones() {
    let small = |rng: &mut fastrand::Rng| [0; LANES].map(|_| 20.0 * rng.f32() - 10.0);
    agree(&[RealUnary::Exp, RealUnary::Exp2, RealUnary::Sin, RealUnary::Cos], small, 500);
    let positive = |rng: &mut fastrand::Rng| [0; LANES].map(|_| 4.0 * rng.f32() + 1e-6);
    agree(&[RealUnary::Log, RealUnary::Log2], positive, 500);
}

#[test]
fn functions_of_any_bits_have_the_bits_of_the_scalar_ones() {
    let any = |rng: &mut fastrand::Rng| [0; LANES].map(|_| f32::from_bits(rng.u32(..)));
    let all = [
        RealUnary::Exp,
        RealUnary::Exp2,
        RealUnary::Log,
        RealUnary::Log2,
        RealUnary::Sin,
        RealUnary::Cos,
    ];
    agree(&all, any, usize::MAX);
    // Multiples of a right angle, and what is beside them.
    let close = |rng: &mut fastrand::Rng| {
        [0; LANES].map(|_| {
            let angle = rng.i32(-600_000..600_000) as f32 * std::f32::consts::FRAC_PI_2;
            f32::from_bits(angle.to_bits().wrapping_add(rng.u32(..3)).wrapping_sub(1))
        })
    };
    agree(&[RealUnary::Sin, RealUnary::Cos], close, usize::MAX);
}

#[test]
fn powers_have_the_bits_of_the_scalar_ones() {
    let mut rng = fastrand::Rng::with_seed(11);
    let special = [0.0, -0.0, 1.0, -1.0, 2.0, 0.5, f32::INFINITY, f32::NAN, 1e-45, f32::MAX];
    for round in 0..6000 {
        let mut column = |base: bool| {
            [0; LANES].map(|_| match round % 3 {
                0 if base => rng.f32(),
                0 => [1.0, 2.0, 5.0, 32.0, 64.0, 256.0, 2.2, 0.5][rng.usize(..8)],
                1 => f32::from_bits(rng.u32(..)),
                _ => special[rng.usize(..special.len())],
            })
        };
        let (a, mut b) = (column(true), column(false));
        if round % 2 == 1 {
            // One exponent for all lanes, mostly whole.
            b = [[b[0], b[0].floor(), (round % 1030) as f32][round % 6 / 2]; LANES];
        }
        for (to, rest) in powers(&a, &b) {
            if round % 3 == 0 {
                assert!(rest.count_ones() < 16, "{rest:x}");
            }
            for lane in (0..LANES).filter(|lane| rest >> lane & 1 == 0) {
                let expected = f64::from(a[lane]).powf(f64::from(b[lane])) as f32;
                let same = to[lane].to_bits() == expected.to_bits();
                assert!(same, "pow({:e}, {:e}) = {:e}", a[lane], b[lane], to[lane]);
            }
        }
    }
}
