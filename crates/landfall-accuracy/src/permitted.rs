//! The largest error of a conformant device, to distinguish a wrong adapter from code that is
//! inaccurate on all of them.
//!
//! Reads calls with the bounds that WGSL and Vulkan set for each operation
//! ([`Precision::Permitted`](landfall_interp::Precision::Permitted)). Used by
//! [`stress`](super::stress) and [`bench`](mod@super::bench).

use landfall_exec::harness::call::pure::PureCallResult;

/// The largest error of a conformant device; infinite where results are unbounded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Farthest {
    /// The absolute error of the worst component.
    pub far: f64,
    /// The error in steps of 1/255 of full scale.
    pub steps: f64,
    /// Whether a branch may go the other way, with unbounded effect.
    pub unsure: bool,
}

/// Returns the largest distance of an interval's points from the truth.
pub(super) fn off_from([low, high]: [f64; 2], truth: f64) -> f64 {
    // The farthest end of the interval; NaN where both ends and the truth are infinite.
    let off = (truth - low).abs().max((high - truth).abs());
    if off.is_nan() { f64::INFINITY } else { off }
}

/// Returns the largest permitted error of the floats of a lane; `None` where it is unknown.
pub(super) fn farthest(
    called: &PureCallResult,
    floats: &[(usize, usize)],
    lane: usize,
    truth: &[f64],
) -> Option<Farthest> {
    let mut most =
        Farthest { unsure: called.called.unsure.get(lane) == Some(&true), ..Farthest::default() };
    let mut scale = 1.0f64;
    for (&(nth, at), &truth) in floats.iter().zip(truth) {
        let [low, high] = called.results[nth].permitted.as_ref()?.get(at)?[lane];
        scale = scale.max(truth.abs());
        let off = off_from([low, high], truth);
        most.far = most.far.max(off);
    }
    most.steps = 255.0 * most.far / scale;
    Some(most)
}
