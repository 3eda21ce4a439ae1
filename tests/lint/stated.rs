//! Numbers that lints state, computed again; the other half is `figures.rs`.

use landfall_ir::analysis::hazard::Hazard;
use landfall_lint::lint;

/// Whether a lint states a number, among those words.
fn states(code: &str, words: &str) {
    let why = lint(code).expect("a lint of that code").why;
    assert!(why.contains(words), "{code} does not state `{words}`: {why}");
}

fn threshold(hazard: Hazard) -> &'static str {
    hazard.info().threshold.expect("a hazard with a threshold").why
}

/// The largest angle in degrees by which a normal is bent halfway between two vertices, each
/// normalised with its fourth component, minus the dot product of normal and translation.
fn bend(apart: f64, camera: f64) -> f64 {
    let at = |angle: f64| [angle.cos(), angle.sin()];
    let bent = |middle: f64| {
        let half = (apart / 2.0).to_radians();
        let [a, b] = [middle - half, middle + half].map(at);
        let length = |n: [f64; 2]| (1.0 + (camera * n[1]).powi(2)).sqrt();
        let sum = |x: f64, y: f64| [0, 1].map(|k| a[k] / x + b[k] / y);
        let ([found, right], [x, y]) = ([sum(length(a), length(b)), sum(1.0, 1.0)], [0, 1]);
        let cross = found[x] * right[y] - found[y] * right[x];
        let along = found[x] * right[x] + found[y] * right[y];
        cross.atan2(along).to_degrees().abs()
    };
    (0..3600).map(|tenth| bent((f64::from(tenth) / 10.0).to_radians())).fold(0.0, f64::max)
}

#[test]
fn normals_of_four_components_bend_as_the_lint_states() {
    let [near, far] = [bend(30.0, 2.0), bend(30.0, 100.0)];
    states(
        "vec4-normalise",
        &format!(
            "30 degrees apart by up to {near:.0} degrees with the camera 2 units away, by {far:.0} \
             at 100 units"
        ),
    );
}

#[test]
fn a_highlight_from_behind_is_as_bright_as_the_lint_states() {
    // The mirrored direction of a light 0.2 below the surface, against a view along the surface.
    let bright = (1.0 - 0.2f64 * 0.2).sqrt().powf(32.0);
    states(
        "ungated-specular",
        &format!("-0.2 adds a highlight of exponent 32 of {bright:.2} times its colour"),
    );
}

/// A direction of f32, normalised as shaders do it, and its length in f64.
fn normalised(random: &mut fastrand::Rng) -> ([f32; 3], f64) {
    let v = [(); 3].map(|()| random.f32() * 2.0 - 1.0);
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    if !(0.1..1.0).contains(&length) {
        return normalised(random);
    }
    let n = v.map(|x| x / length);
    (n, n.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt())
}

#[test]
fn normalised_vectors_are_as_long_as_the_thresholds_state() {
    let mut random = fastrand::Rng::with_seed(11);
    let ulp = f64::from(f32::EPSILON);
    let (mut longest, mut squared, mut apart, mut above) = (0.0f64, 0.0f64, 0.0f64, 0);
    let count = 1_000_000;
    for _ in 0..count {
        let (a, length) = normalised(&mut random);
        longest = longest.max((length - 1.0).abs());
        let dot = f64::from(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
        squared = squared.max((dot - 1.0).abs());
        // The axis of a cone, and a direction along it.
        let distance = 10.0 * random.f32() + 0.1;
        let b = a.map(|x| x * distance);
        let length = (b[0] * b[0] + b[1] * b[1] + b[2] * b[2]).sqrt();
        let b = b.map(|x| x / length);
        above += u32::from(a[0] * b[0] + a[1] * b[1] + a[2] * b[2] > 1.0);
        // Two directions, their cosine in f32 against that of the exact angle.
        let (c, norm) = normalised(&mut random);
        let exact: f64 = a.iter().zip(c).map(|(x, y)| f64::from(*x) * f64::from(y)).sum();
        let exact = exact / norm / a.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
        let found = f64::from(a[0] * c[0] + a[1] * c[1] + a[2] * c[2]);
        apart = apart.max((found - exact).abs());
    }
    let text = threshold(Hazard::BaseAboveOne);
    assert!(text.contains("within 3 ULP (4e-7) of 1 and its dot product within twice that"));
    assert!(longest < 3.0 * ulp && squared < 6.0 * ulp, "{longest:e}, {squared:e}");
    let share = f64::from(above) / f64::from(count);
    states("cone-division", "above 1 in one of nine fragments");
    assert!((1.0 / 10.0..1.0 / 8.0).contains(&share), "{share}");
    // Half a unit in the last place below 1 for the uploaded cosine.
    let together = apart + f64::from(f32::EPSILON) / 4.0;
    assert!(threshold(Hazard::ConeEdge).contains("together up to 3e-7 off"));
    assert!((2.0e-7..3.5e-7).contains(&together), "{together:e}");
}

#[test]
fn points_of_a_scene_are_as_far_apart_as_the_threshold_states() {
    assert!(threshold(Hazard::ZeroVector).contains("coordinates above 1e-7 are so near"));
    let least = f64::from(1.0e-7f32.next_up()) - f64::from(1.0e-7f32);
    assert!(least > 1.0e-15, "{least:e}");
    let [below, half] = [1.0e-6f64, f64::from(half::f16::MAX)];
    assert!(threshold(Hazard::AttenuationAtLight).contains("1e-6 is subnormal in 16 bits"));
    assert!(below < f64::from(half::f16::MIN_POSITIVE) && 1.0 / below > half);
}
