//! The bounds beside errors found by dense sampling.

use pulp::WithSimd;

use super::*;
use crate::culling::lamps::{Lamp, Lamps};

struct Angles<'a>(&'a [f32], &'a mut [f32]);

impl WithSimd for Angles<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let chunks = self.0.chunks(S::F32_LANES).zip(self.1.chunks_mut(S::F32_LANES));
        for (cosines, angles) in chunks {
            angle(Lanes::load(simd, cosines)).store(angles);
        }
    }
}

#[test]
fn angles_are_as_near_as_bounds_expect() {
    let cosines: Vec<f32> = (-100_000..=100_000).map(|i| i as f32 / 100_000.0).collect();
    let mut angles = vec![0.0; cosines.len()];
    pulp::Arch::new().dispatch(Angles(&cosines, &mut angles));
    for (cosine, angle) in cosines.iter().zip(angles) {
        let exact = f64::from(*cosine).acos();
        let off = (f64::from(angle) - exact).abs();
        assert!(off < f64::from(ANGLE) * 0.75, "{cosine}: {angle}, {exact}");
    }
}

struct Cosines<'a>(&'a [f32], &'a [f32], &'a mut [f32]);

impl WithSimd for Cosines<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let angles = self.0.chunks(S::F32_LANES).zip(self.1.chunks(S::F32_LANES));
        for ((least, q), squares) in angles.zip(self.2.chunks_mut(S::F32_LANES)) {
            cosine(Lanes::load(simd, least), Lanes::load(simd, q)).store(squares);
        }
    }
}

/// The bound of a turned angle's cosine beside its maximum over the turns, sampled.
#[test]
fn cosines_of_turned_angles_are_below_their_bound() {
    let steps = || (0..=40).map(|step| step as f32 / 40.0);
    let both =
        || steps().flat_map(|least| steps().map(move |q| (least * std::f32::consts::FRAC_PI_2, q)));
    let (least, q): (Vec<f32>, Vec<f32>) = both().unzip();
    let mut bounds = vec![0.0; least.len()];
    pulp::Arch::new().dispatch(Cosines(&least, &q, &mut bounds));
    for ((least, q), bound) in both().zip(bounds) {
        let (least, q, bound) = (f64::from(least), f64::from(q), f64::from(bound));
        let square = |turn: f64| {
            let (x, y) = (q * turn.cos(), q * turn.sin());
            let b = (least - x).max(0.0).cos();
            let grown = b * y.cosh() + (1.0 - b) * (y.cosh() - 1.0) / 2.0;
            grown * grown + (1.0 - b * b) * y.sinh().powi(2)
        };
        let turns = (0..=200).map(|step| f64::from(step) / 200.0 * std::f64::consts::FRAC_PI_2);
        let most = turns.map(square).fold(0.0, f64::max);
        assert!(most <= bound * (1.0 + 1e-5), "{least} {q}: {most} {bound}");
        assert!(least > 1.0 || bound <= most * 1.3, "{least} {q}: {most} {bound}");
    }
}

/// What is taken as a group has no more error than its bound says.
#[test]
fn several_lamps_err_by_no_more_than_the_bounds_of_all() {
    let mut random = fastrand::Rng::with_seed(3);
    let mut between = |low: f64, high: f64| low + (high - low) * random.f64();
    let (order, mut bounded) = ([Order::new(4)], 0);
    for round in 0..4000 {
        let center = DVec3::new(between(-9.0, 9.0), between(-9.0, 9.0), between(-1.0, 9.0));
        let size = between(0.01, 3.0);
        let mut lamps: Vec<Lamp> = Vec::new();
        for place in 0..5 {
            let beside = DVec3::new(between(-1.0, 1.0), between(-1.0, 1.0), between(-1.0, 1.0));
            let terms = [between(0.0, 0.1), between(0.0, 1.0), between(0.0, 1.0)];
            lamps.push(Lamp {
                place,
                position: center + beside * size,
                radius: 0.0,
                attenuation: [1.0, between(0.0, 0.5) as f32, between(0.0, 0.5) as f32],
                terms: terms.map(|term| term as f32),
            });
        }
        let at = Rectangle {
            center: [between(-1.0, 1.0), 0.5],
            half: [between(0.1, 1.0), between(0.1, 1.0)],
            eye: DVec3::new(between(-9.0, 9.0), 4.0, between(1.0, 9.0)),
            off: 1e-5,
            rounding: 1e-5,
            tilt: 1e-6,
        };
        let shading =
            Shading { shininess: [32.0, 8.0, 10.5][round % 3], everywhere: round % 2 == 0 };
        // By discs, where they are known, as the bounds by size are not always the nearer ones.
        let sum_of = |lamps: &[Lamp]| {
            let mut near = Lamps::for_many(lamps.len());
            near.extend(lamps);
            let given = (1e3, near.is_ambient());
            let bound = Bound::new(&order, &at, &shading, given).expect("the camera is above");
            let mut found = Errors::default();
            found.find_by(&Bound { shines: 0.0, ..bound }, &near);
            found.of[0].iter().sum::<f32>()
        };
        let group = sum_of(&[crate::culling::near::group(0, &lamps)]);
        let each = sum_of(&lamps);
        // That each lamp is on one side is checked apart from the group.
        let known = group.is_finite() && each.is_finite();
        assert!(!known || each <= group * 1.000_1, "{each} {group}");
        bounded += usize::from(known);
    }
    assert!(bounded > 1000, "{bounded}");
}

/// Returns the errors of interpolating the body and the highlight of a lamp, sampled in `f64`.
fn sampled(order: &Order, at: &Rectangle, shading: &Shading, lamp: &Lamp) -> [f64; 2] {
    let m = order.m as usize;
    let nodes = crate::plan::places(order.m);
    let [c, l, q] = lamp.attenuation.map(f64::from);
    let light = |x: f64, y: f64| {
        let point = DVec3::new(at.center[0] + x * at.half[0], at.center[1] + y * at.half[1], 0.0);
        let (to, view) = (lamp.position - point, at.eye - point);
        let r = to.length();
        let weight = 1.0 / (c + r * (l + q * r));
        let facing = (to.z / r).max(0.0);
        let mirrored = DVec3::new(-view.x, -view.y, view.z).normalize();
        let shine = (mirrored.dot(to) / r).max(0.0).powf(shading.shininess);
        let shine = if facing > 0.0 || shading.everywhere { shine } else { 0.0 };
        let [ambient, diffuse, specular] = lamp.terms.map(f64::from);
        [(ambient + diffuse * facing) * weight, specular * shine * weight]
    };
    let basis = |x: f64, i: usize| -> f64 {
        let factor = |j: usize| (x - nodes[j]) / (nodes[i] - nodes[j]);
        (0..m).filter(|&j| j != i).map(factor).product()
    };
    let mut most = [0f64; 2];
    let samples = || (0..=8).map(|i| f64::from(i) / 4.0 - 1.0);
    for (x, y) in samples().flat_map(|x| samples().map(move |y| (x, y))) {
        let mut sums = [0.0; 2];
        for (i, j) in (0..m).flat_map(|i| (0..m).map(move |j| (i, j))) {
            let part = basis(x, i) * basis(y, j);
            let at = light(nodes[i], nodes[j]);
            sums = [0, 1].map(|term| sums[term] + part * at[term]);
        }
        let exact = light(x, y);
        most = [0, 1].map(|term: usize| most[term].max((sums[term] - exact[term]).abs()));
    }
    most
}

/// Bounds hold for single lamps of all attenuations and orders, and those of bodies are near.
#[test]
fn no_lamp_errs_by_more_than_its_bound() {
    let mut random = fastrand::Rng::with_seed(11);
    let mut between = |low: f64, high: f64| low + (high - low) * random.f64();
    let orders: Vec<Order> = (2..=8).map(Order::new).collect();
    let (mut bounded, mut near, mut by_discs) = (0, 0, 0);
    for round in 0..6000 {
        let order = &orders[round % 7];
        let size = [0.02, 0.3, 1.5, 6.0][round % 4];
        let at = Rectangle {
            center: [between(-20.0, 20.0), between(-20.0, 20.0)],
            half: [size * between(0.3, 1.0), size],
            eye: DVec3::new(between(-30.0, 30.0), between(-30.0, 30.0), between(1.0, 20.0)),
            off: 0.0,
            rounding: 1e-6,
            tilt: 0.0,
        };
        let apart = DVec3::new(between(-30.0, 30.0), between(-30.0, 30.0), between(-2.0, 6.0));
        let center = DVec3::new(at.center[0], at.center[1], 0.0);
        let attenuation = [[1.0, 0.14, 0.07], [0.0, 0.0, 1.0], [0.5, 0.7, 0.0], [1.0, 0.0, 0.2]];
        let terms = [between(0.0, 0.1), between(0.0, 1.0), between(0.0, 1.0)];
        let lamp = Lamp {
            place: 0,
            position: center + apart * between(0.1, 1.0),
            radius: 0.0,
            attenuation: attenuation[round % 4],
            terms: terms.map(|term| (term * f64::from(round as u32 / 2 % 2)) as f32),
        };
        // Without highlights, to hold bodies alone.
        let lamp = match round % 3 {
            0 => Lamp { terms: [lamp.terms[0], lamp.terms[1] + 0.1, 0.0], ..lamp },
            _ => Lamp { terms: [lamp.terms[0], lamp.terms[1], lamp.terms[2] + 0.1], ..lamp },
        };
        let shading = Shading {
            shininess: [32.0, 8.0, 10.5, 128.0, 1.0, 0.5][round % 6],
            everywhere: round % 7 == 0,
        };
        let mut lamps = Lamps::for_many(1);
        lamps.extend(&[lamp]);
        let (mut errors, mut by_size) = (Errors::default(), Errors::default());
        let given = (0.05, lamps.is_ambient());
        let Some(bound) = Bound::new(&[*order], &at, &shading, given) else { continue };
        if !errors.find_by(&bound, &lamps) {
            continue;
        }
        by_size.find_by(&Bound { whole: false, ..bound }, &lamps);
        let bound = f64::from(errors.of[0][0]);
        let [body, shine] = sampled(order, &at, &shading, &lamp);
        assert!(body + shine <= bound * (1.0 + 1e-5) + 1e-9, "{round}: {body} {shine} {bound}");
        bounded += 1;
        near += usize::from(lamp.terms[2] == 0.0 && bound < 8.0 * body);
        by_discs += usize::from(errors.of[0][0] < by_size.of[0][0] && shine > 0.0);
    }
    assert!(bounded > 1500 && near > 100 && by_discs > 300, "{bounded} {near} {by_discs}");
}

/// The bounds of polynomials beside their closed forms.
#[test]
fn gegenbauer_polynomials_are_below_their_bounds() {
    struct Bounds<'a>(&'a Gegenbauer, &'a [f32], &'a mut [f32]);

    impl WithSimd for Bounds<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let chunks = self.1.chunks(S::F32_LANES).zip(self.2.chunks_mut(S::F32_LANES));
            for (squares, bounds) in chunks {
                self.0.most(Lanes::load(simd, squares)).store(bounds);
            }
        }
    }

    // C^1_n is sin((n + 1) a) / sin a, C^(3/2)_n the derivative of the Legendre polynomial n + 1.
    let second = |n: f64, t: f64| ((n + 1.0) * t.acos()).sin() / t.acos().sin();
    let legendre = |n: usize, t: f64| {
        let (mut last, mut this) = (1.0, t);
        for k in 2..=n {
            let k = k as f64;
            (last, this) = (this, ((2.0 * k - 1.0) * t * this - (k - 1.0) * last) / k);
        }
        [last, this]
    };
    let derivative = |n: usize, t: f64| {
        let [last, this] = legendre(n + 1, t);
        (n as f64 + 1.0) * (last - t * this) / (1.0 - t * t)
    };
    let cosines: Vec<f64> = (1..10_000).map(|i| f64::from(i) / 10_000.0).collect();
    let squares: Vec<f32> = cosines.iter().map(|t| (t * t) as f32).collect();
    for n in 2..=8 {
        let forms: [(f64, &dyn Fn(f64) -> f64); 2] =
            [(1.0, &|t| second(f64::from(n), t)), (1.5, &|t| derivative(n as usize, t))];
        for (of, value) in forms {
            let mut bounds = vec![0.0; squares.len()];
            pulp::Arch::new().dispatch(Bounds(&Gegenbauer::new(n, of), &squares, &mut bounds));
            let mut most = 0f64;
            for (t, bound) in cosines.iter().zip(bounds) {
                most = most.max(value(*t).abs());
                let bound = f64::from(bound);
                assert!(most <= bound * (1.0 + 1e-5), "{n} {of} {t}: {most} {bound}");
                assert!(n % 2 == 1 || bound <= most * 1.25 || *t < 0.85, "{n} {of} {t}: {bound}");
            }
        }
    }
}
