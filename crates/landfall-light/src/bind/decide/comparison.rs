//! Compares the light of each reading with the reference, by order.

use super::reading::{BindingGroup, Ties};

#[derive(Debug, PartialEq, Eq)]
pub(super) enum ReadingComparison {
    /// The index of the only one that agrees.
    One(usize),
    /// All readings give the same light.
    Same,
    /// Several agree and give different light.
    Several(Vec<usize>),
    None,
}

/// The part of the spread of a picture by which a lit fragment must exceed a dark one.
const LIT: f64 = 0.02;

/// The part of the spread that rounding in `f32` may change.
const ROUNDING: f64 = 1e-3;

/// Returns the reading that agrees with the reference; `seen` holds the light of each. Readings of
/// a later tier count only where none of an earlier one agrees.
pub(super) fn compare(group: &BindingGroup, seen: &[Vec<f64>]) -> ReadingComparison {
    let same =
        |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| a == b || (a.is_nan() && b.is_nan()));
    // Readings that make no difference need no decision.
    if seen.windows(2).all(|pair| same(&pair[0], &pair[1])) {
        return ReadingComparison::Same;
    }
    let reference: Vec<f64> =
        // The light of all probes in one list: brightness is compared across uploads, too.
        group.probes.iter().flat_map(|probe| probe.reference.iter().copied()).collect();
    let last = group.readings.iter().map(|reading| reading.tier).max().unwrap_or(0);
    for tier in 0..=last {
        let of_tier = (0..seen.len()).filter(|&at| group.readings[at].tier == tier);
        let agreed: Vec<usize> = of_tier
            .filter(|&at| agrees(&reference, &seen[at], group.ties, group.topic.lit_from()))
            .collect();
        match agreed[..] {
            [] => {}
            [one] => return ReadingComparison::One(one),
            // Readings that give the same light are told apart by their names alone.
            [first, ..] if agreed.iter().all(|&at| same(&seen[at], &seen[first])) => {
                return ReadingComparison::One(first);
            }
            _ => return ReadingComparison::Several(agreed),
        }
    }
    ReadingComparison::None
}

/// Whether light is brighter wherever the reference is, without a look at equal light.
pub(super) fn is_ordered(reference: &[f64], seen: &[f64]) -> bool {
    agrees(reference, seen, Ties::Ignored, 0.7)
}

/// Whether light has the order of the reference: never less where that is more, more where that is
/// lit, by `lit_from` of the brightest at least, than where it is dark, and the same where `ties`
/// asks for it.
fn agrees(reference: &[f64], seen: &[f64], ties: Ties, lit_from: f64) -> bool {
    // A division by zero is no light of a correct reading.
    if seen.iter().any(|light| !light.is_finite()) {
        return false;
    }
    let least = seen.iter().copied().fold(f64::INFINITY, f64::min);
    let most = seen.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // Differences are measured against the range that the shader's light has, whatever its scale.
    let spread = most - least;
    if spread <= 0.0 {
        return false;
    }
    let brightest = reference.iter().copied().fold(0.0, f64::max);
    let pairs = reference.iter().zip(seen);
    // Each pair of fragments, in both orders: quadratic in some twenty fragments.
    pairs.clone().all(|(&more, &bright)| {
        pairs.clone().all(|(&less, &dim)| {
            let tie = (more - less).abs() <= 1e-9 * brightest;
            let tied = match ties {
                Ties::Dark => tie && more <= 0.0,
                Ties::All => tie,
                Ties::Ignored => false,
            };
            if tied {
                return (bright - dim).abs() <= ROUNDING * spread;
            }
            // Where the reference says nothing about a pair, neither must the shader.
            if tie || more < less {
                return true;
            }
            let lit = less <= 0.0 && more >= lit_from * brightest;
            let strict = lit || (ties == Ties::All);
            match strict {
                // Not less, up to rounding: a tone curve may make different light equal.
                true => bright - dim > LIT * spread,
                false => bright - dim >= -ROUNDING * spread,
            }
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_counts_and_scale_does_not() {
        let reference = [1.0, 0.8, 0.3, 0.0, 0.0];
        let curve = |x: f64| 0.1 + 5.0 * x.sqrt();
        let seen = reference.map(curve);
        assert!(agrees(&reference, &seen, Ties::Dark, 0.7));
        let reversed: Vec<f64> = reference.iter().map(|x| curve(1.0 - x)).collect();
        assert!(!agrees(&reference, &reversed, Ties::Dark, 0.7));
        // Light where the reference has none.
        assert!(!agrees(&reference, &[1.0, 0.8, 0.3, 0.0, 0.2], Ties::Dark, 0.7));
        assert!(agrees(&reference, &[1.0, 0.8, 0.3, 0.0, 0.2], Ties::Ignored, 0.7));
        assert!(!agrees(&reference, &[0.5; 5], Ties::Ignored, 0.7));
        assert!(!agrees(&reference, &[1.0, f64::NAN, 0.3, 0.0, 0.0], Ties::Ignored, 0.7));
    }
}
