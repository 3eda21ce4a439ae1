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

/// The largest error of a soft cone by cosines, in 8-bit steps.
fn cone_error(inner: f64, outer: f64) -> f64 {
    cone_errors(inner, outer)[0]
}

/// The largest errors of a soft cone, in 8-bit steps, by cosines and by the difference of the
/// vectors, over directions between its two angles.
fn cone_errors(inner: f64, outer: f64) -> [f64; 2] {
    let mut random = fastrand::Rng::with_seed(1);
    let (i, o) = (degrees(inner), degrees(outer));
    let mut worst = [0.0f64; 2];
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
        let (to, axis) = (normalized(to), normalized(axis));
        let by_difference = {
            let [i, o] = [i, o].map(|cosine| (1.0 - cosine) as f32);
            let apart = [0, 1, 2].map(|k| to[k] - axis[k]);
            (o - 0.5 * dot(apart, apart)) / (o - i)
        };
        let (i, o) = (i as f32, o as f32);
        let by_cosines = (dot(to, axis) - o) / (i - o);
        for (worst, found) in worst.iter_mut().zip([by_cosines, by_difference]) {
            *worst = worst.max((f64::from(found.clamp(0.0, 1.0)) - right).abs());
        }
    }
    worst.map(|error| error * 255.0)
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

/// A number type: its rounding of a result.
type Round = fn(f64) -> f64;

fn half_of(x: f64) -> f64 {
    half::f16::from_f64(x).to_f64()
}

/// Shades a fragment at `at` with the normal `n`: each result of the geometry rounded by `g`, of
/// the attenuation and the sum by `c`.
fn shaded([g, c]: [Round; 2], vectors: [[f64; 3]; 4]) -> f64 {
    let [at, n, light, eye] = vectors.map(|v| v.map(g));
    let dot = |a: [f64; 3], b: [f64; 3]| g(g(g(a[0] * b[0]) + g(a[1] * b[1])) + g(a[2] * b[2]));
    let zip =
        |a: [f64; 3], b: [f64; 3], f: fn(f64, f64) -> f64| [0, 1, 2].map(|k| g(f(a[k], b[k])));
    let unit = |v: [f64; 3]| v.map(|x| g(x * g(1.0 / g(dot(v, v).sqrt()))));
    let to_light = zip(light, at, |x, y| x - y);
    let (n, l, v) = (unit(n), unit(to_light), unit(zip(eye, at, |x, y| x - y)));
    let power = (0..5).fold(dot(n, unit(zip(l, v, |x, y| x + y))).max(0.0), |x, _| g(x * x));
    let d = c(g(dot(to_light, to_light).sqrt()));
    let attenuation = c(1.0 / c(1.0 + c(d * c(c(0.09) + c(d * c(0.032))))));
    c(c(c(dot(n, l).max(0.0)) + c(power)) * attenuation).min(1.0)
}

/// The error in 8-bit steps that one of a hundred fragments exceeds, and the largest, for fragments
/// up to `far` from the origin on each axis, 1 to 4 from their light and 2 to 10 from the camera.
fn errors_of_halves(far: f64, rounds: [Round; 2]) -> [f64; 2] {
    let mut random = fastrand::Rng::with_seed(1);
    let mut errors: Vec<f64> = (0..100_000)
        .map(|_| {
            let at = [(); 3].map(|()| far * (2.0 * random.f64() - 1.0));
            let (n, mut l, v) =
                (direction(&mut random), direction(&mut random), direction(&mut random));
            if n.iter().zip(l).map(|(x, y)| x * y).sum::<f64>() < 0.0 {
                l = l.map(|x| -x);
            }
            let away = [1.0 + 3.0 * random.f64(), 2.0 + 8.0 * random.f64()];
            let beyond = |v: [f64; 3], by: f64| [0, 1, 2].map(|k| at[k] + by * v[k]);
            let vectors = [at, n, beyond(l, away[0]), beyond(v, away[1])];
            255.0 * (shaded(rounds, vectors) - shaded([|x| x; 2], vectors)).abs()
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    [errors[errors.len() * 99 / 100], errors[errors.len() - 1]]
}

#[test]
fn shading_in_halves_is_off_as_the_lint_states() {
    let code = "mediump-position";
    let near = errors_of_halves(10.0, [half_of; 2])[0];
    let far = errors_of_halves(100.0, [half_of; 2])[0];
    states(code, &format!("off by {near:.1} 8-bit steps or more in one of a hundred fragments"));
    states(code, &format!("within 10 of the origin, and by {far:.0} within 100"));
    let single: Round = |x| f64::from(x as f32);
    let colours = errors_of_halves(10.0, [single, half_of])[1];
    assert!(colours < 1.0, "{colours}");
    states(code, "Colours and attenuation lose less than a step");
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
        format!("{:.1} steps of 1/255 at 1e-4, {:.0} at 1e-6", steps(1.0e-4), steps(1.0e-6)),
        format!("0.5 and 1 degrees divides by {:.2e}", degrees(0.5) - degrees(1.0)),
    ];
    holds(Hazard::EqualCutOffs, &numbers);
    assert!(steps(1.0e-7) > 255.0, "all 255 at 1e-7");
    holds(
        Hazard::ConeEdge,
        &[format!("a band of {:.1e} degrees at 12.5 degrees", width(1.0e-6, 12.5))],
    );
    let next = f64::from(1.0f32.next_down());
    let numbers = [
        format!("no digits below {:.2} degrees", next.acos().to_degrees()),
        format!("{:.1} degrees: by cosines", 0.999f64.acos().to_degrees()),
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
    assert!((0.2..0.3).contains(&(255.0 * 0.001)), "a quarter of a step of 1/255");
    holds(Hazard::HighlightFromBehind, &["a quarter of a step of 1/255".to_string()]);
    let constant = [1.0, 0.09, 0.032];
    let text = Hazard::LoneConstant.info().why;
    let times = format!("{:.0} times too bright", constant[0] / constant[2]);
    assert!(text.contains(&times), "{times}: {text}");
}

/// Whether a hazard states a number, among those words, that is within a third of what was computed.
fn about(hazard: Hazard, words: &str, stated: f64, computed: f64) {
    let info = hazard.info();
    let text = format!("{} {}", info.why, info.threshold.map_or("", |threshold| threshold.why));
    assert!(text.contains(words), "`{words}` is not stated: {text}");
    let ratio = computed / stated;
    assert!((0.75..1.34).contains(&ratio), "{words}: {stated} stated, {computed} computed");
}

/// Divides by the length, each operation rounded to an `f32`.
fn divided(v: [f32; 3]) -> [f32; 3] {
    let length = dot(v, v).sqrt();
    v.map(|x| x / length)
}

fn rounded(v: [f64; 3]) -> [f32; 3] {
    v.map(|x| x as f32)
}

fn reflected<T: Copy + std::ops::Mul<Output = T> + std::ops::Sub<Output = T>>(
    [twice, along]: [T; 2],
    normal: [T; 3],
    light: [T; 3],
) -> [T; 3] {
    [0, 1, 2].map(|k| twice * along * normal[k] - light[k])
}

fn dot64(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.into_iter().zip(b).map(|(x, y)| x * y).sum()
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    v.map(|x| x / dot64(v, v).sqrt())
}

/// A highlight of a normal, the vector to the light and the one to the eye, in f64.
fn highlight64(n: [f64; 3], l: [f64; 3], v: [f64; 3], exponent: f64) -> f64 {
    let (n, l, v) = (unit(n), unit(l), unit(v));
    dot64(v, reflected([2.0, dot64(n, l)], n, l)).max(0.0).powf(exponent)
}

/// The same with an exact power of an f32 cosine.
fn highlight32(n: [f32; 3], l: [f32; 3], v: [f32; 3], exponent: f64) -> f64 {
    let (n, l, v) = (divided(n), divided(l), divided(v));
    let cosine = dot(v, reflected([2.0, dot(n, l)], n, l));
    f64::from(cosine.clamp(0.0, 1.0)).powf(exponent)
}

#[test]
fn highlights_lose_by_their_exponent_what_the_hazard_states() {
    let wide = |v: [f32; 3]| v.map(f64::from);
    let error = |exponent: f64| {
        let mut random = fastrand::Rng::with_seed(3);
        let mut worst = 0.0f64;
        for _ in 0..200_000 {
            let n = rounded(direction(&mut random));
            let l = rounded(direction(&mut random).map(|x| 3.0 * x));
            let (unit_n, unit_l) = (unit(wide(n)), unit(wide(l)));
            let r = reflected([2.0, dot64(unit_n, unit_l)], unit_n, unit_l);
            // A view within the highlight.
            let (off, side) =
                (1.5 * (2.0 / exponent).sqrt() * random.f64(), direction(&mut random));
            let v = rounded([0, 1, 2].map(|k| 2.0 * (r[k] + off * side[k])));
            let right = highlight64(wide(n), wide(l), wide(v), exponent);
            worst = worst.max((highlight32(n, l, v, exponent) - right).abs());
        }
        255.0 * worst
    };
    let hazard = Hazard::LargeExponent;
    about(hazard, "0.005 steps of 1/255 at 32", 0.005, error(32.0));
    about(hazard, "0.04 steps of 1/255 off at exponent 256", 0.04, error(256.0));
    about(hazard, "0.65 at 4096", 0.65, error(4096.0));
    about(hazard, "10 at 65536", 10.0, error(65536.0));
}

/// The largest error in 8-bit steps of a lit surface in a room of 3 m at a distance from the
/// origin, with positions as they are and relative to the eye.
fn far_from_origin(distance: f64) -> [f64; 2] {
    let mut random = fastrand::Rng::with_seed(5);
    let minus = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|k| a[k] - b[k]);
    let mut worst = [0.0f64; 2];
    for _ in 0..100_000 {
        let middle = direction(&mut random).map(|x| x * distance);
        let mut point = || [0, 1, 2].map(|k| middle[k] + 3.0 * (random.f64() - 0.5));
        let (at, light, eye) = (point(), point(), point());
        let (to_light, to_eye) = (minus(light, at), minus(eye, at));
        if dot64(to_light, to_light) < 1.0 || dot64(to_eye, to_eye) < 1.0 {
            continue;
        }
        // A normal about halfway, where the highlight is.
        let (l, v) = (unit(to_light), unit(to_eye));
        let side = direction(&mut random);
        let normal = unit([0, 1, 2].map(|k| l[k] + v[k] + 0.2 * side[k]));
        let square = dot64(to_light, to_light);
        let fade = |square: f64| 1.0 + 0.09 * square.sqrt() + 0.032 * square;
        let right = dot64(normal, l).max(0.0) + highlight64(normal, to_light, to_eye, 32.0);
        let right = right / fade(square);
        let origins = [[0.0; 3], eye];
        for (worst, origin) in worst.iter_mut().zip(origins) {
            let [at, light, eye] = [at, light, eye].map(|p| rounded(minus(p, origin)));
            let less = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|k| a[k] - b[k]);
            let (to_light, to_eye) = (less(light, at), less(eye, at));
            let normal = rounded(normal);
            let diffuse = f64::from(dot(normal, divided(to_light)).max(0.0));
            let lit = diffuse + highlight32(normal, to_light, to_eye, 32.0);
            let found = lit / fade(f64::from(dot(to_light, to_light)));
            *worst = worst.max(255.0 * (found - right).abs());
        }
    }
    worst
}

#[test]
fn positions_far_from_the_origin_lose_what_the_hazard_states() {
    let hazard = Hazard::FarFromOrigin;
    about(hazard, "0.08 steps of 1/255 at this distance", 0.08, far_from_origin(1.0e3)[0]);
    about(hazard, "1 step of 1/255 at 1e4", 1.0, far_from_origin(1.0e4)[0]);
    about(hazard, "9 at 1e5", 9.0, far_from_origin(1.0e5)[0]);
    let [here, relative] = far_from_origin(1.0e6);
    about(hazard, "80 at 1e6", 80.0, here);
    assert!(relative < 0.01, "{relative}");
}

#[test]
fn normalised_vectors_and_cosines_exceed_one_as_often_as_the_hazards_state() {
    let mut random = fastrand::Rng::with_seed(7);
    let (mut longer, mut above) = (0, 0);
    let count = 1_000_000;
    for _ in 0..count {
        let size = 1.0 + random.f64();
        let axis = divided(rounded(direction(&mut random).map(|x| x * size)));
        longer += u32::from(exact(axis, axis) > 1.0);
        let distance = 10.0 * random.f32() + 0.1;
        above += u32::from(dot(divided(axis.map(|x| x * distance)), axis) > 1.0);
    }
    let share = |some: u32| f64::from(some) / f64::from(count);
    about(Hazard::BaseAboveOne, "Half of all normalised vectors", 0.5, share(longer));
    about(Hazard::ZeroWidthCone, "above 1 in 14 of 100 fragments", 0.14, share(above));
}

#[test]
fn narrow_cones_lose_what_the_hazard_states() {
    let hazard = Hazard::NarrowCone;
    for (words, stated, inner, outer) in [
        ("12.5 and 15 degrees is 0.01 steps of", 0.01, 12.5, 15.0),
        ("and 2 degrees 0.2", 0.2, 1.0, 2.0),
        ("0.5 and 1 degrees 0.7", 0.7, 0.5, 1.0),
        ("19 from 0.1 to 0.2", 19.0, 0.1, 0.2),
        ("0.05 and 0.06 degrees all", 255.0, 0.05, 0.06),
    ] {
        let [by_cosines, by_difference] = cone_errors(inner, outer);
        about(hazard, words, stated, by_cosines);
        assert!(by_difference < 0.15, "{inner} and {outer} degrees: {by_difference}");
    }
}

#[test]
fn single_results_are_what_the_hazards_state() {
    let stated = |hazard: Hazard, number: String| {
        let why = hazard.info().why;
        assert!(why.contains(&number), "{number}: {why}");
    };
    stated(Hazard::PowOfNegative, format!("is {} in the C library", (-0.25f64).powf(2.0)));
    assert!((2.0 * (-0.25f64).log2()).exp2().is_nan());
    assert_eq!(8_388_608.0f32 + 0.25, 8_388_608.0);
    stated(Hazard::Uninitialised, "8388608 swallows".to_string());
    // A light 0.2 below the plane of the normal, and a view along the plane.
    let (below, along) = (0.2f64, (1.0 - 0.2f64 * 0.2).sqrt());
    let mirrored = highlight64([0.0, 1.0, 0.0], [-along, -below, 0.0], [1.0, 0.0, 0.0], 32.0);
    stated(Hazard::HighlightFromBehind, format!("{mirrored:.2} bright at a grazing view"));
    stated(Hazard::AmbientPerLight, format!("of 0.05 add up to {:.1}", 128.0 * 0.05));
    let unit = 2.0f32.powi(-24);
    assert_eq!((0..500).fold(1.0f32, |sum, _| sum + unit), 1.0);
    let sum = 1.0 + 500.0 * f64::from(unit);
    stated(Hazard::KahanWithoutPrecise, format!("1.0 instead of {sum:.7}"));
    let moved = |angle: f64| width(3.0 * f64::from(unit), angle);
    let edge = Hazard::ConeEdge.info().citation;
    let words = format!("{:.1e} degrees at 12.5 degrees, by {:.1e} at 1", moved(12.5), moved(1.0));
    assert!(edge.contains(&words), "{words}: {edge}");
    let above = format!("3 ULP ({:.0e})", 3.0 * f32::EPSILON);
    holds(Hazard::BaseAboveOne, &[above]);
    // The share by which a square in f32 differs from the exact one.
    let lost = |x: f32| (f64::from(x * x) / f64::from(x).powi(2) - 1.0).abs();
    holds(Hazard::ZeroVector, &["errors begin at lengths of 1e-20".to_string()]);
    assert!(lost(1.0e-19) < 2.0e-7 && lost(1.0e-20) > 1.0e-6, "{}", lost(1.0e-20));
    let length = |distance: f32| distance / (distance * distance).sqrt();
    let brighter = f64::from(length(1.0e-22)).powi(32);
    stated(Hazard::Underflow, format!("At a distance of 1e-22 a highlight is {brighter:.2} times"));
    assert_eq!(length(1.0e-23), f32::INFINITY, "times the zeros of the other components, NaN");
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
