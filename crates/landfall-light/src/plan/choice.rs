//! The choice among ways to light a scene, by times measured on a sample of its fragments.

use super::{Claim, Plan};

/// A way must be faster by this factor: its slowest round than the fastest one without skipping.
const MARGIN: f64 = 1.05;

/// The ways measured, and the one picked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Choice {
    /// The error permitted, in steps.
    pub permitted: f64,
    /// The fragments measured.
    pub fragments: u64,
    /// The fragments of the frame.
    pub of: u64,
    /// The ways; the first skips nothing.
    pub timed: Vec<Timed>,
    /// The index of the one picked.
    pub picked: usize,
}

/// A way to light a scene, measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Timed {
    /// The parts of `--skip`; empty for skipping nothing.
    pub parts: String,
    /// The seconds of each round, of planning and lighting, times the fragments of the frame over
    /// those measured.
    pub seconds: Vec<f64>,
    /// The largest error in steps: none, the proven one, or twice the one measured with the model;
    /// `None` if it is not known.
    pub error: Option<f64>,
    /// The difference from the picture with all lights, as this backend shows it.
    pub seen: f64,
    /// Why it was not measured as often as the others; empty if it was.
    pub note: String,
}

impl Timed {
    /// Returns the median of its rounds; infinite without any.
    pub fn median(&self) -> f64 {
        let mut sorted = self.seconds.clone();
        sorted.sort_by(f64::total_cmp);
        sorted.get(sorted.len() / 2).copied().unwrap_or(f64::INFINITY)
    }

    /// Returns the fastest and the slowest of its rounds.
    pub fn range(&self) -> [f64; 2] {
        let of = |start, pick: fn(f64, f64) -> f64| self.seconds.iter().copied().fold(start, pick);
        [of(f64::INFINITY, f64::min), of(f64::NEG_INFINITY, f64::max)]
    }

    /// Whether its error, by its plan and as seen, is permitted.
    pub fn is_within(&self, permitted: f64) -> bool {
        self.error.is_some_and(|error| error <= permitted) && self.seen <= permitted
    }
}

impl Choice {
    /// Picks the fastest way without a note within the permitted error that is faster than skipping nothing by
    /// more than the spread of both; skipping nothing if there is none.
    pub fn pick(&mut self) {
        let Some((none, others)) = self.timed.split_first() else { return };
        let [fastest, _] = none.range();
        let faster = others.iter().enumerate().filter(|(_, timed)| {
            let [_, slowest] = timed.range();
            !timed.seconds.is_empty()
                && timed.note.is_empty()
                && timed.is_within(self.permitted)
                && slowest * MARGIN < fastest
        });
        let best = faster.min_by(|(_, a), (_, b)| a.median().total_cmp(&b.median()));
        self.picked = best.map_or(0, |(at, _)| at + 1);
    }
}

impl Plan {
    /// Returns the largest error in steps that its claims permit on other fragments too: of what was
    /// measured, twice; `None` if a part was not measured.
    pub fn expected(&self) -> Option<f64> {
        let each = self.savings.steps.iter().map(|step| match &step.error {
            Claim::Exact(_) | Claim::Unused => Some(0.0),
            Claim::Proven { steps, .. } => Some(*steps),
            Claim::Measured(measured) => Some(2.0 * measured.steps),
            Claim::Unmeasured => None,
        });
        each.sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Picks among ways of these seconds and errors; the first skips nothing.
    fn picked(permitted: f64, ways: &[(&[f64], Option<f64>, f64)]) -> usize {
        let timed = ways.iter().map(|(seconds, error, seen)| Timed {
            seconds: seconds.to_vec(),
            error: *error,
            seen: *seen,
            ..Timed::default()
        });
        let mut choice = Choice { permitted, timed: timed.collect(), ..Choice::default() };
        choice.pick();
        choice.picked
    }

    #[test]
    fn nothing_is_skipped_where_nothing_is_faster_beyond_the_spread() {
        let none: (&[f64], _, _) = (&[1.0, 1.2, 1.1], Some(0.0), 0.0);
        assert_eq!(picked(0.0, &[none]), 0);
        assert_eq!(picked(0.0, &[none, (&[2.0, 3.0, 2.5], Some(0.0), 0.0)]), 0);
        // A faster median whose slowest round is not faster than the fastest without skipping.
        assert_eq!(picked(0.0, &[none, (&[0.7, 0.8, 1.01], Some(0.0), 0.0)]), 0);
        // Faster in all rounds, by less than the margin.
        assert_eq!(picked(0.0, &[none, (&[0.96, 0.97, 0.98], Some(0.0), 0.0)]), 0);
        assert_eq!(picked(0.0, &[none, (&[], Some(0.0), 0.0)]), 0);
        assert_eq!(picked(0.0, &[none, (&[0.9, 0.9, 0.9], Some(0.0), 0.0)]), 1);
    }

    #[test]
    fn the_fastest_within_the_error_is_picked() {
        let ways: [(&[f64], _, _); 5] = [
            (&[1.0, 1.0, 1.0], Some(0.0), 0.0),
            (&[0.5, 0.5, 0.6], Some(0.0), 0.0),
            (&[0.2, 0.2, 0.2], Some(0.4), 0.1),
            (&[0.1, 0.1, 0.1], Some(0.4), 0.7),
            (&[0.1, 0.1, 0.1], None, 0.0),
        ];
        assert_eq!(picked(0.0, &ways), 1);
        assert_eq!(picked(0.3, &ways), 1);
        assert_eq!(picked(0.5, &ways), 2);
        // More than its plan says was seen, but permitted.
        assert_eq!(picked(0.7, &ways), 3);
    }

    #[test]
    fn an_error_seen_that_is_no_number_is_not_permitted() {
        let none: (&[f64], _, _) = (&[1.0], Some(0.0), 0.0);
        assert_eq!(picked(9.0, &[none, (&[0.1], Some(0.0), f64::INFINITY)]), 0);
        assert_eq!(picked(9.0, &[none, (&[0.1], Some(0.0), f64::NAN)]), 0);
        assert_eq!(picked(9.0, &[none, (&[0.1], Some(f64::NAN), 0.0)]), 0);
    }
}
