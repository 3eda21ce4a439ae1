//! The lamps of a patch's grids, by the errors of interpolating them.
//!
//! A lamp goes into the grid of the lowest order whose error is at most `t` times what that order saves
//! beside the next, with a `t` near the largest by which all errors stay within the patch's share: so the cost
//! is least where the error that a lamp adds is in one proportion to what it saves.

use pulp::{Simd, WithSimd};

use super::smooth::ORDERS;
use crate::lanes::Lanes;

/// The halvings of the range of `t`.
const HALVINGS: usize = 6;

/// The lamps whose errors are added in `f32`; longer sums would round too much.
const BLOCK: usize = 1024;

/// The errors of lamps.
pub(super) struct Select<'a> {
    /// By order, the lowest first.
    pub errors: &'a [Vec<f32>],
    /// What each order saves, in the same unit for all; 0 for those that are not to be used.
    pub saved: [f32; ORDERS],
    /// The largest sum of the errors.
    pub share: f32,
}

/// The lamps of each order.
#[derive(Default)]
pub(super) struct Selected {
    /// The order of each lamp; one more than the last for those of none.
    pub orders: Vec<f32>,
    /// The lamps of each order.
    pub counts: [usize; ORDERS],
    /// The sum of the errors, up to its rounding.
    pub spent: f64,
}

impl Selected {
    /// Selects the lamps of each order.
    pub fn find(&mut self, select: &Select<'_>) {
        pulp::Arch::new().dispatch(Selecting { select, into: self });
    }
}

struct Selecting<'a> {
    select: &'a Select<'a>,
    into: &'a mut Selected,
}

impl WithSimd for Selecting<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Selecting { select: Select { errors, saved, share }, into } = self;
        let lamps = errors.first().map_or(0, Vec::len);
        let used = || saved[..errors.len()].iter().copied().filter(|saved| *saved > 0.0);
        // Between a `t` by which all lamps are within the share, and one by which one may not be.
        let most = used().fold(0.0, f32::max);
        let least = used().fold(f32::INFINITY, f32::min);
        let mut low = (share / (most * lamps as f32)).log2();
        let mut high = (share / least).log2();
        for _ in 0..HALVINGS {
            let middle = (low + high) / 2.0;
            let t = middle.exp2();
            match sum(simd, errors, &saved.map(|saved| saved * t)) <= *share {
                true => low = middle,
                false => high = middle,
            }
        }
        let t = low.exp2();
        sort(simd, errors, &saved.map(|saved| saved * t), into);
    }
}

/// Returns the sum of the errors that are less than those thresholds.
#[inline(always)]
fn sum<S: Simd>(simd: S, errors: &[Vec<f32>], thresholds: &[f32; ORDERS]) -> f32 {
    let zero = Lanes::zero(simd);
    let lamps = errors[0].len();
    let mut all = 0.0;
    for block in (0..lamps).step_by(BLOCK) {
        let mut sum = zero;
        for first in (block..lamps.min(block + BLOCK)).step_by(S::F32_LANES) {
            let range = first..lamps.min(first + S::F32_LANES);
            let mut error = zero;
            for (errors, threshold) in errors.iter().zip(thresholds).rev() {
                let of = Lanes::load(simd, &errors[range.clone()]);
                error = of.less(zero.splat(*threshold)).select(of, error);
            }
            sum = sum + error;
        }
        all += f64::from(sum.sum());
    }
    all as f32
}

/// Writes the order of each lamp, the number of lamps of each order and the sum of their errors.
#[inline(always)]
fn sort<S: Simd>(simd: S, errors: &[Vec<f32>], thresholds: &[f32; ORDERS], into: &mut Selected) {
    let zero = Lanes::zero(simd);
    let lamps = errors[0].len();
    into.orders.resize(lamps, 0.0);
    into.counts = [0; ORDERS];
    into.spent = 0.0;
    for block in (0..lamps).step_by(BLOCK) {
        let mut counts = [zero; ORDERS];
        let mut spent = zero;
        for first in (block..lamps.min(block + BLOCK)).step_by(S::F32_LANES) {
            let range = first..lamps.min(first + S::F32_LANES);
            let mut order = zero.splat(errors.len() as f32);
            let mut error = zero;
            let mut before = zero;
            for (at, (errors, threshold)) in errors.iter().zip(thresholds).enumerate().rev() {
                let of = Lanes::load(simd, &errors[range.clone()]);
                let takes = of.less(zero.splat(*threshold));
                order = takes.select(zero.splat(at as f32), order);
                error = takes.select(of, error);
            }
            order.store(&mut into.orders[range]);
            spent = spent + error;
            for (at, count) in counts.iter_mut().enumerate().take(errors.len()) {
                let upto = order.less(zero.splat(at as f32 + 0.5)).select(zero.splat(1.0), zero);
                *count = *count + (upto - before);
                before = upto;
            }
        }
        into.spent += f64::from(spent.sum());
        for (all, count) in into.counts.iter_mut().zip(counts) {
            *all += count.sum() as usize;
        }
    }
    // Lanes beyond the last lamp have an error of 0, which the first order used takes.
    let beyond = lamps.next_multiple_of(S::F32_LANES) - lamps;
    let mut both = into.counts.iter_mut().zip(thresholds);
    if let Some((count, _)) = both.find(|(_, threshold)| **threshold > 0.0) {
        *count -= beyond;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sum found is that of the errors, within the share, and nearly all of it.
    #[test]
    fn lamps_go_into_the_lowest_order_within_the_share() {
        let mut random = fastrand::Rng::with_seed(3);
        for lamps in [1, 5, 8, 13, 1024, 3000] {
            let error = |random: &mut fastrand::Rng| match random.usize(0..20) {
                0 => f32::NAN,
                1 => f32::INFINITY,
                _ => 10f32.powf(random.f32() * -6.0),
            };
            let first: Vec<f32> = (0..lamps).map(|_| error(&mut random)).collect();
            let errors = [first.clone(), first.iter().map(|x| x * x).collect()];
            let saved = [12.0, 48.0, 0.0, 0.0];
            let share = 0.01 * lamps as f32;
            let mut selected = Selected::default();
            selected.find(&Select { errors: &errors, saved, share });
            let (mut spent, mut counts) = (0.0, [0; ORDERS]);
            for (lamp, order) in selected.orders.iter().enumerate() {
                let order = *order as usize;
                if let Some(errors) = errors.get(order) {
                    spent += f64::from(errors[lamp]);
                    counts[order] += 1;
                }
            }
            assert_eq!(counts, selected.counts);
            assert!((spent - selected.spent).abs() <= 1e-5 * spent, "{spent}");
            assert!(spent <= f64::from(share) * 1.000_01, "{lamps}: {spent} of {share}");
            assert!(lamps < 1000 || spent > 0.6 * f64::from(share), "{lamps}: {spent} of {share}");
            // An order that is not used takes none.
            let saved = [0.0, 48.0, 0.0, 0.0];
            selected.find(&Select { errors: &errors, saved, share });
            assert_eq!(selected.counts[0], 0);
        }
    }
}
