//! Numbers that lints state, computed again.

use landfall_ir::analysis::hazard::Hazard;
use landfall_lint::lint;

fn why(code: &str) -> &'static str {
    lint(code).expect("a lint of that code").why
}

/// Whether a lint states a number, among those words.
fn states(code: &str, words: &str) {
    assert!(why(code).contains(words), "{code} does not state `{words}`: {}", why(code));
}

fn degrees(angle: f64) -> f64 {
    angle.to_radians().cos()
}

/// As shaders do it, each operation rounded to an `f32`.
fn normalized(v: [f32; 3]) -> [f32; 3] {
    let root = 1.0 / dot(v, v).sqrt();
    v.map(|x| x * root)
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn exact(a: [f32; 3], b: [f32; 3]) -> f64 {
    a.into_iter().zip(b).map(|(x, y)| f64::from(x) * f64::from(y)).sum()
}

fn direction(random: &mut fastrand::Rng) -> [f64; 3] {
    loop {
        let v = [(); 3].map(|()| random.f64() * 2.0 - 1.0);
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        if (0.1..1.0).contains(&length) {
            return v.map(|x| x / length);
        }
    }
}

/// The largest error of a soft cone, in 8-bit steps, over directions between its two angles.
fn cone_error(inner: f64, outer: f64) -> f64 {
    let mut random = fastrand::Rng::with_seed(1);
    let (i, o) = (degrees(inner), degrees(outer));
    let mut worst = 0.0f64;
    for _ in 0..400_000 {
        let axis = direction(&mut random);
        let other = direction(&mut random);
        let along: f64 = axis.iter().zip(other).map(|(x, y)| x * y).sum();
        let side = [0, 1, 2].map(|k| other[k] - along * axis[k]);
        let length = side.iter().map(|x| x * x).sum::<f64>().sqrt();
        let angle = (inner + (outer - inner) * random.f64()).to_radians();
        let distance = 1.0 + 9.0 * random.f64();
        let to = [0, 1, 2]
            .map(|k| (distance * (angle.cos() * axis[k] + angle.sin() * side[k] / length)) as f32);
        let axis = axis.map(|x| x as f32);
        let right = exact(axis, to) / (exact(axis, axis) * exact(to, to)).sqrt();
        let right = ((right - o) / (i - o)).clamp(0.0, 1.0);
        let (i, o) = (i as f32, o as f32);
        let found = ((dot(normalized(to), normalized(axis)) - o) / (i - o)).clamp(0.0, 1.0);
        worst = worst.max((f64::from(found) - right).abs());
    }
    worst * 255.0
}

#[test]
fn a_cone_by_cosines_loses_what_its_lint_states() {
    let code = "cosine-cone";
    let step = f64::from(1.0f32 - 1.0f32.next_down());
    states(code, &format!("steps of {step:.0e}"));
    states(code, &format!("1 degree is {:.0} of them", (1.0 - degrees(1.0)) / step));
    states(code, &format!("of 0.1 degrees {:.0}", (1.0 - degrees(0.1)) / step));
    states(code, &format!("0.5 to 1 degree is up to {:.1} of an 8-bit step", cone_error(0.5, 1.0)));
    states(code, &format!("0.1 to 0.2 degrees {:.0} steps", cone_error(0.1, 0.2)));
    states(code, &format!("0.05 to 0.06 degrees all {:.0}", cone_error(0.05, 0.06)));
}

/// `reflect` of a light direction about a normal of another length, seen at a right angle to it.
fn highlight(length: f64) -> f64 {
    let n = [0.0, length];
    let root = 0.5f64.sqrt();
    let (l, v) = ([-root, root], [root, root]);
    let twice = 2.0 * (n[0] * l[0] + n[1] * l[1]);
    let r = [twice * n[0] - l[0], twice * n[1] - l[1]];
    (r[0] * v[0] + r[1] * v[1]).powi(32)
}

#[test]
fn a_normal_of_another_length_changes_a_highlight_as_its_lint_states() {
    let code = "unnormalised-normal";
    // Halfway between two unit vectors that far apart.
    states(code, &format!("20 degrees apart leave {:.2}", highlight(degrees(10.0))));
    states(code, &format!("40 degrees {:.2}", highlight(degrees(20.0))));
    states(code, &format!("10 % too long makes it {:.0} times", highlight(1.1)));
    let hazard = Hazard::UnnormalisedNormal.info().why;
    for number in [
        format!(
            "20 degrees apart a highlight of exponent 32 falls to {:.2}",
            highlight(degrees(10.0))
        ),
        format!("10 % too long makes it {:.0} times", highlight(1.1)),
    ] {
        assert!(hazard.contains(&number), "{number}: {hazard}");
    }
}

#[test]
fn half_floats_hold_positions_as_the_lint_states() {
    let code = "mediump-position";
    let half = |x: f32| half::f16::from_f32(x);
    let overflow = (1..1000).find(|&x| half((x * x) as f32).is_infinite()).unwrap();
    states(code, &format!("overflows at {overflow}"));
    let at = half(300.0);
    let step = half::f16::from_bits(at.to_bits() + 1).to_f32() - at.to_f32();
    states(code, &format!("step of {step} at 300"));
}
