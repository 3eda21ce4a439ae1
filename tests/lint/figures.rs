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

/// What the texts of a hazard state: its effect, its threshold and its source.
fn stated(hazard: Hazard) -> String {
    let info = hazard.info();
    let threshold = info.threshold.expect("a hazard with a threshold");
    format!("{} {} {}", info.why, threshold.why, info.citation)
}

fn holds(hazard: Hazard, numbers: &[String]) {
    let text = stated(hazard);
    for number in numbers {
        assert!(text.contains(number), "`{number}` is not stated: {text}");
    }
}

/// The width in degrees of a band of cosines around the edge of a cone.
fn width(cosines: f64, angle: f64) -> f64 {
    (cosines / angle.to_radians().sin()).to_degrees()
}

#[test]
fn limits_of_floats_are_what_the_thresholds_state() {
    let (tiny, huge) = (f64::from(f32::MIN_POSITIVE), f64::from(f32::MAX));
    let half = [half::f16::MIN_POSITIVE, half::f16::MAX].map(f64::from);
    assert!(1.0e-4 > half[0] && 1.0e-5 < half[0] && 1.0 / 1.0e-4 < half[1]);
    let numbers = [
        format!("({:.1e})", half[0]),
        format!("{:.0e}, is finite there ({})", 1.0 / 1.0e-4, half[1]),
    ];
    holds(Hazard::AttenuationAtLight, &numbers);
    let square = 1.0e-15f64.powi(2);
    let numbers = [
        format!(
            "{square:.0e}, is {:.1e} times the smallest normal f32 ({tiny:.1e})",
            square / tiny
        ),
        format!("lengths below {:.1e} vanish", tiny.sqrt()),
    ];
    holds(Hazard::ZeroVector, &numbers);
    let numbers = [
        // Two corners of a cube of that coordinate.
        format!("is at most {:.1e}", 3.0 * (2.0 * 1.0e18f64).powi(2)),
        format!("largest f32 ({huge:.1e})"),
        "at distances of 1.85e19".to_string(),
    ];
    holds(Hazard::Overflow, &numbers);
    let squared = |distance: f32| distance * distance;
    assert!(squared(1.84e19).is_finite() && squared(1.85e19).is_infinite());
    let text = Hazard::LargeValues.info().why;
    for number in [format!("Above {huge:.1e}"), format!("above {} a 16-bit", half[1])] {
        assert!(text.contains(&number), "{number}: {text}");
    }
}

#[test]
fn widths_of_cones_are_what_the_thresholds_state() {
    // A dot product two units of the last place above 1.
    let above = 2.0 * f64::from(f32::EPSILON);
    let steps = |divisor: f64| 255.0 * above / divisor;
    let numbers = [
        format!("up to {above:.1e} above 1"),
        format!("{:.1} of 255 steps at 1e-4, {:.0} at 1e-6", steps(1.0e-4), steps(1.0e-6)),
        format!("0.5 and 1 degrees divides by {:.2e}", degrees(0.5) - degrees(1.0)),
    ];
    holds(Hazard::EqualCutOffs, &numbers);
    assert!(steps(1.0e-7) > 255.0, "all of them at 1e-7");
    holds(Hazard::ConeEdge, &[format!("{:.1e} degrees wide at 12.5 degrees", width(1.0e-6, 12.5))]);
    let next = f64::from(1.0f32.next_down());
    let numbers = [
        format!("no digits below {:.2} degrees", next.acos().to_degrees()),
        format!("{:.1} degrees: measured", 0.999f64.acos().to_degrees()),
    ];
    holds(Hazard::NarrowCone, &numbers);
    let soft = |x: f64| (x - 17.5) / (12.5 - 17.5);
    holds(Hazard::ConeOutOfRange, &[format!("(1 - 17.5) / (12.5 - 17.5) = {:.1}", soft(1.0))]);
}

#[test]
fn powers_and_steps_are_what_the_hazards_state() {
    let excess = 1.0 + 2.0f64.powi(-23);
    let numbers = [format!("1 + 2^-23 to the power of 1e7 is {:.1}", excess.powf(1.0e7))];
    holds(Hazard::BaseAboveOne, &numbers);
    holds(Hazard::LargeExponent, &["by 16 it loses four bits".to_string()]);
    assert_eq!(16.0f64.log2(), 4.0);
    assert!((0.2..0.3).contains(&(255.0 * 0.001)), "a quarter of one of 255 steps");
    holds(Hazard::HighlightFromBehind, &["a quarter of one of 255 steps".to_string()]);
    let constant = [1.0, 0.09, 0.032];
    let text = Hazard::LoneConstant.info().why;
    let times = format!("{:.0} times too bright", constant[0] / constant[2]);
    assert!(text.contains(&times), "{times}: {text}");
}

/// The sizes that a lint about arrays states are those of the layout.
#[test]
fn an_array_of_floats_wastes_what_its_lint_states() {
    let size = |member: &str| {
        let text = format!("#version 330\nlayout(std140) uniform U {{ {member}; }};\n");
        let shader =
            ::landfall::layout(&::landfall::Source::new("a.frag", &*text), &Default::default());
        shader.blocks[0].size.expect("a fixed size")
    };
    let (apart, packed) = (size("float w[64]"), size("vec4 w[16]"));
    let code = "array-stride-waste";
    states(code, &format!("a `float[64]` takes {apart} bytes, three quarters"));
    assert_eq!(apart - 64 * 4, apart * 3 / 4);
    states(code, &format!("Packed into `vec4 w[16]` it takes {packed}"));
    assert_eq!(packed, 64 * 4);
}
