//! The errors of all lamps of a patch.

use pulp::{Simd, WithSimd};

use super::{Bound, ORDERS, Order, Rectangle, Shading};
use crate::culling::lamps::Lamps;

/// The errors of lamps, and memory for computing them.
#[derive(Default)]
pub(in crate::culling) struct Errors {
    /// By order.
    pub of: [Vec<f32>; ORDERS],
    /// The highlights by their size, of the last order.
    highlights: Vec<f32>,
    /// The lamps whose highlights are bounded by discs.
    pub(super) indices: Vec<u32>,
    some: Lamps,
    better: [Vec<f32>; ORDERS],
}

impl Errors {
    /// Finds the largest error of any channel for each lamp by each of the orders, the lowest first:
    /// infinite or NaN if unknown, and infinite if by the last order it is more than `most` without a
    /// highlight. Returns whether one of the last order is at most `most`.
    pub fn find(
        &mut self,
        orders: &[Order],
        lamps: &Lamps,
        at: &Rectangle,
        shading: &Shading,
        most: f32,
    ) -> bool {
        let Errors { of, highlights, indices, some, better } = self;
        let given = (most, lamps.is_ambient());
        let Some(bound) = Bound::new(orders, at, shading, given) else { return false };
        let arch = pulp::Arch::new();
        let by_size = Finding { bound: &bound, lamps, errors: of, highlights: Some(highlights) };
        let mut any = arch.dispatch(by_size);
        if !bound.whole {
            return any;
        }
        // Discs take longest: for the few lamps that might be taken by them.
        indices.clear();
        let last = &of[orders.len() - 1];
        let both = last.iter().zip(highlights.iter()).enumerate();
        let wants = |(error, highlight): (&f32, &f32)| {
            *highlight > most * 3e-3 && *error - *highlight <= most
        };
        indices.extend(both.filter(|(_, both)| wants(*both)).map(|(at, _)| at as u32));
        if !indices.is_empty() {
            lamps.copy(indices, some);
            any |= arch.dispatch(Finding {
                bound: &bound,
                lamps: some,
                errors: better,
                highlights: None,
            });
            for (errors, better) in of.iter_mut().zip(better).take(orders.len()) {
                for (at, better) in indices.iter().zip(better) {
                    errors[*at as usize] = *better;
                }
            }
        }
        any
    }
}

/// Writes the errors of lamps: by size, with the parts of them that are highlights, or by discs.
pub(super) struct Finding<'a> {
    pub bound: &'a Bound,
    pub lamps: &'a Lamps,
    pub errors: &'a mut [Vec<f32>; ORDERS],
    /// For errors by size.
    pub highlights: Option<&'a mut Vec<f32>>,
}

impl WithSimd for Finding<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let Finding { bound, lamps, errors, mut highlights } = self;
        let len = lamps.len();
        errors.iter_mut().take(bound.count).for_each(|errors| errors.resize(len, 0.0));
        if let Some(highlights) = &mut highlights {
            highlights.resize(len, 0.0);
        }
        let discs = highlights.is_none();
        let mut any = false;
        for first in (0..len).step_by(S::F32_LANES) {
            let range = first..len.min(first + S::F32_LANES);
            let light = lamps.load(simd, first, range.len());
            let (found, highlight) = bound.of(light, discs);
            any |= found[bound.count - 1].less(highlight.splat(bound.most.next_up())).any();
            for (errors, found) in errors.iter_mut().zip(found).take(bound.count) {
                found.store(&mut errors[range.clone()]);
            }
            if let Some(highlights) = &mut highlights {
                highlight.store(&mut highlights[range]);
            }
        }
        any
    }
}
