//! The thresholds of the catalogue of hazards, measured: each is right where it stands, and the
//! values that other places had are not.

use half::f16;
use landfall_ir::analysis::hazard::threshold::{
    ATTENUATION, CONE_WIDTH, COORDINATE, EDGE, HALF_DISTANCE, LENGTH,
};

type Vector = [f32; 3];

fn dot(a: Vector, b: Vector) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn normalize(v: Vector) -> Vector {
    let length = dot(v, v).sqrt();
    v.map(|x| x / length)
}

/// A vector with parts from -1 to 1.
fn vector(random: &mut fastrand::Rng) -> Vector {
    [0; 3].map(|_| random.f32() * 2.0 - 1.0)
}

/// Steps of 255 by which rounding lights the axis of a cone of no width.
fn sparkle(width: f32) -> f32 {
    let mut random = fastrand::Rng::with_seed(8);
    let one = |_| {
        let axis = normalize(vector(&mut random));
        // From the lamp to a point on its axis, as a shader computes it.
        let distance = random.f32() * 10.0 + 0.1;
        let theta = dot(normalize(axis.map(|x| x * distance)), axis);
        ((theta - 1.0) / width).clamp(0.0, 1.0)
    };
    255.0 * (0..200_000).map(one).fold(0.0, f32::max)
}

#[test]
fn a_cone_of_no_width_is_dark_to_a_step_at_its_threshold_and_sparkles_below() {
    let at = sparkle(CONE_WIDTH.value as f32);
    assert!(at > 0.1 && at < 1.0, "{at}");
    assert!(sparkle(1.0e-6) > 20.0);
    assert_eq!(sparkle(1.0e-7), 255.0);
}

#[test]
fn a_cone_of_half_a_degree_keeps_its_width() {
    let width = 0.5f64.to_radians().cos() - 1f64.to_radians().cos();
    assert!(width > CONE_WIDTH.value, "{width}");
    // The next narrower one in the table of errors is beyond cosines: 16 of 255 steps off.
    let beyond = 0.1f64.to_radians().cos() - 0.2f64.to_radians().cos();
    assert!(beyond < CONE_WIDTH.value, "{beyond}");
}

#[test]
fn attenuation_is_a_normal_number_and_finite_in_16_bits() {
    let least = f16::from_f64(ATTENUATION.value);
    assert!(least.is_normal() && (f16::ONE / least).is_finite(), "{least}");
    let smaller = f16::from_f64(1.0e-6);
    assert!(!smaller.is_normal() && (f16::ONE / smaller).is_infinite(), "{smaller}");
    assert!(!f16::from_f64(ATTENUATION.value / 10.0).is_normal());
}

#[test]
fn squares_of_lengths_and_coordinates_stay_in_f32() {
    let square = (LENGTH.value * LENGTH.value) as f32;
    // The rounding error of the square is a normal number, too: no digit is lost to flushing.
    assert!(square.is_normal() && (square * f32::EPSILON).is_normal(), "{square}");
    let far = COORDINATE.value as f32;
    let across = [2.0 * far; 3];
    assert!(dot(across, across).is_finite());
    assert!(dot(across.map(|x| x * 10.0), across.map(|x| x * 10.0)).is_infinite());
    let half = f16::from_f64(HALF_DISTANCE.value);
    assert!((half * half).is_infinite());
    let less = f16::from_f64(HALF_DISTANCE.value - 1.0);
    assert!((less * less).is_finite());
}

#[test]
fn fragments_on_the_other_side_of_an_edge_are_within_its_threshold() {
    let mut random = fastrand::Rng::with_seed(17);
    let mut worst = 0.0f64;
    for _ in 0..200_000 {
        let (a, b) = (vector(&mut random), vector(&mut random));
        let wide = |v: Vector| v.map(f64::from);
        let exact = {
            let (a, b) = (wide(a), wide(b));
            let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            dot(a, b) / (dot(a, a) * dot(b, b)).sqrt()
        };
        worst = worst.max((f64::from(dot(normalize(a), normalize(b))) - exact).abs());
    }
    // What a uniform loses when it is rounded comes on top.
    let rounded = worst + f64::from(f32::EPSILON) / 4.0;
    assert!(rounded < EDGE.value && rounded > EDGE.value / 10.0, "{rounded}");
}
