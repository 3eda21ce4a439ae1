//! How far from the truth a conformant device may be: what tells an adapter that is wrong from
//! code that any of them may get wrong.
//!
//! Reads calls made with the bounds WGSL and Vulkan set to each operation
//! ([`Precision::Permitted`](landfall_exec::interp::Precision::Permitted)). Feeds
//! [`stress`](super::stress) and [`bench`](mod@super::bench).

use landfall_exec::harness::call::pure::PureCalled;

/// The farthest from the truth that a conformant device may be; infinite where it may give
/// anything.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Farthest {
    /// The distance, of the worst component.
    pub far: f64,
    /// In steps of 1/255 of full scale.
    pub steps: f64,
    /// Whether a branch may go the other way, and so lead anywhere.
    pub unsure: bool,
}

/// The farthest from a truth in an interval.
pub(super) fn off_from([low, high]: [f64; 2], truth: f64) -> f64 {
    let off = (truth - low).abs().max((high - truth).abs());
    if off.is_nan() { f64::INFINITY } else { off }
}

/// What is permitted in a lane around the truth of those floats; none where it is not known.
pub(super) fn farthest(
    called: &PureCalled,
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
