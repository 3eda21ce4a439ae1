//! The radius of a light: exact, and never rounded down.
//!
//! The smallest distance from which on `k / (c + l d + q d^2) <= tau`. The textbook root of the
//! quadratic divides by `q` and cancels where `l` is large: a light with a tiny `q` would get a
//! radius of 0 and be dropped silently.

use crate::Upload;
use crate::scene::{Attenuation, PointLight};
use crate::shading_f32::Model;

/// Returns the distance from which on a light of strength `k` contributes at most `tau`: infinite
/// if it never does; `None` if the attenuation is not known to decrease.
pub fn radius(attenuation: &Attenuation, k: f64, tau: f64) -> Option<f64> {
    let Attenuation { constant: c, linear: l, quadratic: q, .. } = *attenuation;
    let known = |x: f64| x >= 0.0 && x.is_finite();
    if !(known(c) && known(l) && known(q) && known(k) && known(tau)) {
        return None;
    }
    if k == 0.0 {
        return Some(0.0);
    }
    let excess = k / tau - c;
    if excess <= 0.0 {
        return Some(0.0);
    }
    if excess.is_infinite() {
        return Some(f64::INFINITY);
    }
    // `hypot`, and the root of each factor, so that no square overflows.
    let denominator = l + l.hypot(2.0 * q.sqrt() * excess.sqrt());
    Some(if denominator == 0.0 { f64::INFINITY } else { 2.0 * (excess / denominator) })
}

/// Returns [`radius`] as an `f32` for a shader: enlarged by 2^-20 and rounded up, so that points
/// beyond it in `f32` arithmetic are really beyond it.
pub fn radius_f32(attenuation: &Attenuation, k: f64, tau: f64) -> Option<f32> {
    radius(attenuation, k, tau).map(|exact| round_up(exact * (1.0 + 2f64.powi(-20))))
}

/// Returns the smallest `f32` not below a non-negative `x`.
pub fn round_up(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) < x { nearest.next_up() } else { nearest }
}

/// Returns the strength of a light for its radius: the sum of the largest channels of its terms.
pub fn strength(colors: &[glam::DVec3; 3]) -> f64 {
    colors.iter().map(|color| color.max_element()).sum()
}

/// Returns the lights with a range where they had none: the distance at which they contribute `tau`
/// without a window. A windowed model ends them exactly there.
pub fn windowed(upload: &Upload, model: &Model, tau: f64) -> Upload {
    let mut upload = upload.clone();
    let lamps = upload.lights.spot.iter_mut().map(|spot| &mut spot.lamp);
    for lamp in upload.lights.point.iter_mut().chain(lamps) {
        let PointLight { emission, attenuation, .. } = lamp;
        if attenuation.range.is_none() {
            let reach = radius_f32(attenuation, strength(&model.colors(emission)), tau);
            attenuation.range = reach.filter(|r| r.is_finite() && *r > 0.0).map(f64::from);
        }
    }
    upload
}

#[cfg(test)]
mod tests {
    use super::*;

    fn attenuation(constant: f64, linear: f64, quadratic: f64) -> Attenuation {
        Attenuation { constant, linear, quadratic, range: None }
    }

    fn at(a: &Attenuation, k: f64, d: f64) -> f64 {
        k / (a.constant + d * (a.linear + d * a.quadratic))
    }

    /// The published point light at 1/256: `0.032 d^2 + 0.09 d + 1 = 1.85 * 256`, by hand.
    #[test]
    fn published_light_reaches_120_units() {
        let a = attenuation(1.0, 0.09, 0.032);
        let by_hand =
            (-0.09 + (0.09f64 * 0.09 + 4.0 * 0.032 * (1.85 * 256.0 - 1.0)).sqrt()) / 0.064;
        let found = radius(&a, 1.85, 1.0 / 256.0).expect("decreasing");
        assert!((found - by_hand).abs() < 1e-9 * by_hand, "{found} {by_hand}");
        assert!((found - 120.1).abs() < 0.1, "{found}");
    }

    #[test]
    fn radius_survives_coefficients_the_textbook_form_does_not() {
        // 1 + d = 256 once q no longer matters.
        for q in [0.0, 1e-30, 1e-20, 1e-12] {
            let found = radius(&attenuation(1.0, 1.0, q), 1.0, 1.0 / 256.0).expect("decreasing");
            assert!((found - 255.0).abs() < 1e-6, "q {q}: {found}");
        }
        let found = radius(&attenuation(1.0, 1.0, 1e-8), 1.0, 1.0 / 256.0).expect("decreasing");
        assert!((found - 254.999).abs() < 1e-3, "{found}");
        assert_eq!(radius(&attenuation(1.0, 0.0, 0.0), 1.0, 0.5), Some(f64::INFINITY));
        assert_eq!(radius(&attenuation(1.0, 0.5, 0.5), 0.1, 0.5), Some(0.0));
        assert_eq!(radius(&attenuation(1.0, 0.5, 0.5), 1.0, 0.0), Some(f64::INFINITY));
        assert_eq!(radius(&attenuation(1.0, -0.1, 0.5), 1.0, 0.5), None);
        assert_eq!(radius(&attenuation(f64::NAN, 0.1, 0.5), 1.0, 0.5), None);
    }

    #[test]
    fn light_beyond_its_rounded_radius_is_never_above_the_threshold() {
        let mut random = fastrand::Rng::with_seed(7);
        let mut nearest_breaks = 0;
        for _ in 0..20_000 {
            let mut exponent = |low: f64, high: f64| 10f64.powf(low + (high - low) * random.f64());
            let a = attenuation(
                f64::from(exponent(-3.0, 1.0) as f32),
                f64::from(exponent(-6.0, 1.0) as f32),
                f64::from(exponent(-12.0, 1.0) as f32),
            );
            let (k, tau) = (exponent(-2.0, 2.0), exponent(-4.0, -1.0));
            let reach = radius_f32(&a, k, tau).expect("decreasing");
            if reach == 0.0 {
                assert!(k / a.constant <= tau);
                continue;
            }
            assert!(at(&a, k, f64::from(reach)) <= tau, "{a:?} {k} {tau}");
            // What a shader computes in `f32` just beyond stays within the proof's margin.
            let d = reach.next_up();
            let [c, l, q] = [a.constant, a.linear, a.quadratic].map(|x| x as f32);
            let in_f32 = k as f32 / (c + d * (l + q * d));
            assert!(f64::from(in_f32) <= tau * (1.0 + 2f64.powi(-20)), "{a:?} {k} {tau}");
            let nearest = radius(&a, k, tau).expect("decreasing") as f32;
            nearest_breaks += usize::from(at(&a, k, f64::from(nearest)) > tau);
        }
        // The same with rounding to nearest is wrong about every second time: the margin is used.
        assert!(nearest_breaks > 5_000, "{nearest_breaks}");
    }

    #[test]
    fn adversarial_coefficients_have_safe_radii() {
        let corners = [0.0, f64::MIN_POSITIVE, 1e-38, 1e-12, 1.0, 1e12, 1e300];
        for c in corners {
            for l in corners {
                for q in corners {
                    for tau in [1e-300, 1.0 / 256.0, 1.0] {
                        let a = attenuation(c, l, q);
                        let reach = radius(&a, 1.0, tau).expect("decreasing");
                        assert!(!reach.is_nan(), "{a:?}");
                        let beyond = reach * (1.0 + 1e-9);
                        if beyond.is_finite() && beyond > 0.0 {
                            let left = at(&a, 1.0, beyond);
                            assert!(left <= tau * (1.0 + 1e-9), "{a:?} {tau}: {reach} {left}");
                        }
                    }
                }
            }
        }
    }
}
