//! The errors of all lamps of a patch.

use pulp::{Simd, WithSimd};

use super::{Bound, ORDERS, Order, Rectangle, Shading};
use crate::culling::lamps::Lamps;

/// The errors of lamps, by order.
#[derive(Default)]
pub(in crate::culling) struct Errors {
    pub of: [Vec<f32>; ORDERS],
}

impl Errors {
    /// Finds the largest error of any channel for each lamp by each of the orders, the lowest first:
    /// infinite or NaN if unknown, and perhaps infinite if by the last order it is more than `most` without
    /// a highlight. Returns whether one of the last order is at most `most`.
    pub fn find(
        &mut self,
        orders: &[Order],
        lamps: &Lamps,
        at: &Rectangle,
        shading: &Shading,
        most: f32,
    ) -> bool {
        let bound = Bound::new(orders, at, shading, (most, lamps.is_ambient()));
        bound.is_some_and(|bound| self.find_by(&bound, lamps))
    }

    pub(super) fn find_by(&mut self, bound: &Bound, lamps: &Lamps) -> bool {
        pulp::Arch::new().dispatch(Finding { bound, lamps, errors: &mut self.of })
    }
}

struct Finding<'a> {
    bound: &'a Bound,
    lamps: &'a Lamps,
    errors: &'a mut [Vec<f32>; ORDERS],
}

impl WithSimd for Finding<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let Finding { bound, lamps, errors } = self;
        let len = lamps.len();
        errors.iter_mut().take(bound.count).for_each(|errors| errors.resize(len, 0.0));
        let mut any = false;
        for first in (0..len).step_by(S::F32_LANES) {
            let range = first..len.min(first + S::F32_LANES);
            let light = lamps.load(simd, first, range.len());
            let found = bound.of(light);
            any |= found[bound.count - 1].less(light[0].splat(bound.most.next_up())).any();
            for (errors, found) in errors.iter_mut().zip(found).take(bound.count) {
                found.store(&mut errors[range.clone()]);
            }
        }
        any
    }
}
