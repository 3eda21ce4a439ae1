//! The form of a function whose `f64` results are the truth of a bench.
//!
//! Chosen for [`Calls`](super::function::Calls) among the function and its variants, unless one is
//! named.

use super::errors::{Quantiles, Results};

/// The largest difference of two forms' `f64` results, as a part of the error of the first one's
/// `f32` results, for which they are the same function: rounding errors of `f64` are 2^-29 of those
/// of `f32`, and single ones differ by a factor of less than 2^8.
const SAME: f64 = 1.0 / (1 << 21) as f64;

/// The part of the first form's error from which another form is more accurate.
const CLEARLY: f64 = 0.5;

/// The results of a form for some calls.
pub(super) struct Evaluated {
    pub single: Vec<Results>,
    pub double: Vec<Results>,
}

/// Returns the form with the most accurate `f64`: that whose `f32` results are the nearest to its
/// own `f64`, since both lose digits at the same operations. Only forms are considered whose `f64`
/// results are those of the first one, up to the rounding errors of `f64`. `None` stands for forms
/// that do not run.
pub(super) fn most_accurate(forms: &[Option<Evaluated>]) -> usize {
    // Two forms that are equal in exact arithmetic differ by rounding only. The form whose `f32`
    // is close to its `f64` has a small error in `f32`, hence a small one in `f64`, too. A form
    // that computes something else (another attenuation, say) must not become the truth, however
    // accurate.
    let Some(first) = forms.first().and_then(Option::as_ref) else { return 0 };
    let own = |form: &Evaluated| distances(first, &form.single, &form.double);
    let Some(error) = own(first) else { return 0 };
    let mut best = (0, error.p999 * CLEARLY);
    for (nth, form) in forms.iter().enumerate().skip(1) {
        let Some(form) = form else { continue };
        let (Some(apart), Some(own)) = (distances(first, &first.double, &form.double), own(form))
        else {
            continue;
        };
        // An error below 1 unit of the last place is taken for one, or exact functions would have
        // no equal.
        let is_same =
            apart.p999 <= error.p999.max(1.0) * SAME && apart.max <= error.max.max(1.0) * SAME;
        if is_same && own.p999 < best.1 {
            best = (nth, own.p999);
        }
    }
    best.0
}

/// Returns the distances of two forms' results in units of the last place of an `f32`, where all
/// results of the first form are finite.
fn distances(first: &Evaluated, ours: &[Results], theirs: &[Results]) -> Option<Quantiles> {
    let mut all = Vec::new();
    for (call, (ours, theirs)) in ours.iter().zip(theirs).enumerate() {
        if !is_finite(&first.single[call]) || !is_finite(&first.double[call]) {
            continue;
        }
        let floats = ours.floats.iter().zip(&theirs.floats);
        all.extend(floats.map(|(ours, theirs)| distance(*ours, *theirs)));
    }
    Quantiles::new(&mut all)
}

fn is_finite(results: &Results) -> bool {
    !results.missing && results.floats.iter().all(|x| x.is_finite())
}

fn distance(ours: f64, theirs: f64) -> f64 {
    match (ours - theirs).abs() {
        apart if apart.is_nan() => f64::INFINITY,
        apart => apart / landfall_layout::buffer::float::last_place(theirs),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The results of a form from its values in `f32` and `f64`.
    fn form(of: impl Fn(f64) -> (f32, f64)) -> Option<Evaluated> {
        let results = |x: f64| Results { floats: vec![x], ..Results::default() };
        let all: Vec<(f32, f64)> = (0..4096).map(|i| of(f64::from(i) / 4096.0)).collect();
        let single = all.iter().map(|(x, _)| results(f64::from(*x))).collect();
        Some(Evaluated { single, double: all.iter().map(|(_, x)| results(*x)).collect() })
    }

    /// `1 - x * x` near 1, which loses digits there.
    fn square(t: f64) -> (f32, f64) {
        let x = f64::from(1.0 - t as f32 * 1e-3);
        (1.0 - x as f32 * x as f32, 1.0 - x * x)
    }

    /// `(1 - x) * (1 + x)`, which does not.
    fn product(t: f64) -> (f32, f64) {
        let x = 1.0 - t as f32 * 1e-3;
        ((1.0 - x) * (1.0 + x), (1.0 - f64::from(x)) * (1.0 + f64::from(x)))
    }

    #[test]
    fn the_form_that_keeps_digits_is_the_truth_wherever_it_stands() {
        assert_eq!(most_accurate(&[form(square), form(product)]), 1);
        assert_eq!(most_accurate(&[form(product), form(square)]), 0);
        assert_eq!(most_accurate(&[form(square), None, form(product)]), 2);
    }

    #[test]
    fn another_function_is_no_truth_however_accurate() {
        assert_eq!(most_accurate(&[form(square), form(|_| (0.0, 0.0))]), 0);
        // Nor one that is off by a part in ten million.
        let near = |t| (product(t).0, product(t).1 * (1.0 + 1e-7));
        assert_eq!(most_accurate(&[form(square), form(near)]), 0);
    }
}
