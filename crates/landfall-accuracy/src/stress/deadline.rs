//! Deadlines: at a time, or when the caller requests a stop.
//!
//! Created by [`stress`](super::stress()), checked in every loop that may take long.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

#[derive(Clone, Debug, Default)]
pub(super) struct Deadline {
    /// The time limit; `None` for no limit.
    at: Option<Instant>,
    /// The caller's flag to stop early.
    stop: Arc<AtomicBool>,
    /// The time to finish started work after a stop.
    grace: Duration,
    /// The time at which the flag was first seen set.
    stopped: Arc<OnceLock<Instant>>,
}

impl Deadline {
    /// A deadline after that time, or as soon as `stop` is set.
    pub fn after(time: Option<Duration>, stop: &Arc<AtomicBool>) -> Deadline {
        let at = time.and_then(|time| Instant::now().checked_add(time));
        Deadline { at, stop: Arc::clone(stop), ..Deadline::default() }
    }

    /// Returns the deadline with time to finish started work after a stop.
    pub fn with_grace(self, grace: Duration) -> Deadline {
        Deadline { grace, ..self }
    }

    /// Returns the deadline, moved to at most that time from now.
    pub fn shortened_to(&self, time: Duration) -> Deadline {
        // A time beyond the clock's range is not sooner.
        let new = Instant::now().checked_add(time);
        Deadline { at: [self.at, new].into_iter().flatten().min(), ..self.clone() }
    }

    pub fn is_over(&self) -> bool {
        self.end().is_some_and(|end| Instant::now() >= end)
    }

    /// Returns the remaining time; `None` for no limit.
    pub fn left(&self) -> Option<Duration> {
        self.end().map(|end| end.saturating_duration_since(Instant::now()))
    }

    /// Returns the end time, as known now.
    pub fn end(&self) -> Option<Instant> {
        if !self.is_stopped() {
            return self.at;
        }
        // Grace begins where the stop is first seen, for all clones of the deadline alike.
        let end = self.stopped.get_or_init(Instant::now).checked_add(self.grace);
        [self.at, end].into_iter().flatten().min()
    }

    /// Returns the end time, but at least that time from now.
    pub fn end_with(&self, least: Duration) -> Instant {
        let latest = Instant::now() + least;
        self.end().map_or(latest, |end| end.max(latest))
    }

    /// Returns the caller's flag, unless started work may be finished after a stop.
    pub fn flag(&self) -> Option<Arc<AtomicBool>> {
        // With grace, calls must not end at the flag.
        self.grace.is_zero().then(|| Arc::clone(&self.stop))
    }

    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stop_ends_it_after_the_grace() {
        let stop = Arc::new(AtomicBool::new(false));
        let hour = Duration::from_secs(3600);
        let sampling = Deadline::after(Some(hour), &stop);
        let writing = sampling.clone().with_grace(hour / 2);
        assert!(!sampling.is_over() && sampling.left().is_some_and(|left| left > hour / 2));
        stop.store(true, Ordering::Relaxed);
        assert!(sampling.is_over() && !writing.is_over());
        assert!(writing.left().is_some_and(|left| left <= hour / 2));
        assert!(writing.shortened_to(Duration::ZERO).is_over());
    }

    #[test]
    fn what_no_clock_reaches_is_no_end() {
        let stop = Arc::default();
        let never = Deadline::after(Some(Duration::MAX), &stop).shortened_to(Duration::MAX);
        assert_eq!((never.end(), never.is_over()), (None, false));
        let hour = Duration::from_secs(3600);
        assert!(
            never
                .shortened_to(hour)
                .shortened_to(Duration::MAX)
                .left()
                .is_some_and(|left| left <= hour)
        );
    }
}
