//! Clocks: processor time for work on a processor, device time for work on a device.
//!
//! Used by [`measure`](super::measure) and by the workloads on backends.

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use landfall_exec::backend::{Backend, Device, Failure, Job, JobOutput};
use landfall_exec::processor;
use landfall_layout::named;

named! {
    /// A clock.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
    #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
    #[serde(rename_all = "lowercase")]
    pub enum Clock {
        /// Processor time of all threads of the working process, ended ones included
        /// (`CLOCK_PROCESS_CPUTIME_ID`), so that other programs do not count. For a driver in a process
        /// of its own, the time of that process during its jobs.
        Processor = "processor",
        /// Wall-clock time, for systems without a processor clock and devices without timestamps.
        Elapsed = "elapsed",
        /// The difference of two timestamps of the device.
        Device = "device",
    }
}

/// A duration and the clock that measured it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Elapsed {
    /// The duration.
    pub time: Duration,
    /// The clock.
    pub clock: Clock,
}

/// A backend that adds up the time of its jobs.
pub struct BackendStopwatch<'r> {
    backend: &'r mut dyn Backend,
    took: Vec<Option<Elapsed>>,
}

impl<'r> BackendStopwatch<'r> {
    /// A backend with no time on its clock.
    pub fn new(backend: &'r mut dyn Backend) -> BackendStopwatch<'r> {
        BackendStopwatch { backend, took: Vec::new() }
    }

    /// Returns the time of all jobs so far; `None` for a backend in this process, whose own clock
    /// counts it.
    pub fn elapsed(&self) -> Option<Elapsed> {
        sum(self.took.iter().copied())
    }
}

impl Backend for BackendStopwatch<'_> {
    fn device(&self) -> &Device {
        self.backend.device()
    }

    fn run(&mut self, job: &Job) -> Result<JobOutput, Failure> {
        self.timed(|backend| backend.run(job))
    }

    fn run_concurrently(
        &mut self,
        job: &Job,
        other: &mut (dyn FnMut() + Send),
    ) -> Result<JobOutput, Failure> {
        self.timed(|backend| backend.run_concurrently(job, other))
    }

    fn device_time(&self) -> Option<Duration> {
        self.backend.device_time()
    }

    fn processor_time(&self) -> Option<Duration> {
        self.backend.processor_time()
    }
}

impl BackendStopwatch<'_> {
    /// A software device is not asked for timestamps: processor time is more precise.
    fn timed(
        &mut self,
        run: impl FnOnce(&mut dyn Backend) -> Result<JobOutput, Failure>,
    ) -> Result<JobOutput, Failure> {
        let began = Instant::now();
        let answer = run(self.backend)?;
        // Without a timestamp of the device all that passed counts, transfers and waiting
        // included.
        let own = match (self.backend.device().software, self.backend.device_time()) {
            (true, _) => {
                let time = self.backend.processor_time();
                time.map(|time| Elapsed { time, clock: Clock::Processor })
            }
            (false, Some(time)) => Some(Elapsed { time, clock: Clock::Device }),
            (false, None) => Some(Elapsed { time: began.elapsed(), clock: Clock::Elapsed }),
        };
        self.took.push(own);
        Ok(answer)
    }
}

/// Returns the sum of times; `None` if one is missing or from another clock.
pub fn sum(all: impl IntoIterator<Item = Option<Elapsed>>) -> Option<Elapsed> {
    let mut all = all.into_iter();
    let first = all.next()??;
    // Times of different clocks have no sum.
    all.try_fold(first, |sum, one| {
        let one = one.filter(|one| one.clock == sum.clock)?;
        Some(Elapsed { time: sum.time + one.time, ..sum })
    })
}

/// A point in time on the best clock of this system.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    processor: Option<Duration>,
    elapsed: Instant,
}

impl Start {
    /// Returns the current time.
    pub fn now() -> Start {
        Start { elapsed: Instant::now(), processor: processor::time() }
    }

    /// Returns the time used since.
    pub fn elapsed(&self) -> Elapsed {
        match (self.processor, processor::time()) {
            (Some(before), Some(now)) => {
                Elapsed { time: now.saturating_sub(before), clock: Clock::Processor }
            }
            _ => Elapsed { time: self.elapsed.elapsed(), clock: Clock::Elapsed },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_of_one_clock_add_up_and_others_do_not() {
        let took = |millis, clock| Some(Elapsed { time: Duration::from_millis(millis), clock });
        let both = [took(2, Clock::Device), took(3, Clock::Device)];
        assert_eq!(sum(both), took(5, Clock::Device));
        assert_eq!(sum([took(2, Clock::Device), took(3, Clock::Elapsed)]), None);
        assert_eq!(sum([took(2, Clock::Device), None]), None);
        assert_eq!(sum([]), None);
    }
}
