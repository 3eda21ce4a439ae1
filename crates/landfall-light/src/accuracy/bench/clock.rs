//! What time is: of the processor where it computes, of the device where that does.
//!
//! For [`measure`](super::measure) and the workloads that readers run.

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use landfall_exec::backend::{Answer, Device, Failure, Job, Reader};
use landfall_exec::processor;

/// What was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Clock {
    /// Time on a processor of all threads of the process that works, those that ended too
    /// (`CLOCK_PROCESS_CPUTIME_ID`): another program's work does not count. Of a driver in a
    /// process of its own, that process's time at its jobs.
    Processor,
    /// Time that passed, where the system has no such clock, or the work is a device's that has
    /// no timestamps.
    Elapsed,
    /// Between two timestamps of the device.
    Device,
}

impl Clock {
    /// As it is written in tables.
    pub fn name(self) -> &'static str {
        match self {
            Clock::Processor => "processor",
            Clock::Elapsed => "elapsed",
            Clock::Device => "device",
        }
    }
}

/// How long something took, and by which clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Took {
    /// How long.
    pub time: Duration,
    /// What measured it.
    pub clock: Clock,
}

/// A reader that adds up how long its jobs take.
pub struct Stopwatch<'r> {
    reader: &'r mut dyn Reader,
    took: Vec<Option<Took>>,
}

impl<'r> Stopwatch<'r> {
    /// A reader that has run nothing yet.
    pub fn new(reader: &'r mut dyn Reader) -> Stopwatch<'r> {
        Stopwatch { reader, took: Vec::new() }
    }

    /// How long it worked; none where it did so in this process, whose own clock says it.
    pub fn took(&self) -> Option<Took> {
        sum(self.took.iter().copied())
    }
}

impl Reader for Stopwatch<'_> {
    fn device(&self) -> &Device {
        self.reader.device()
    }

    /// A device that computes on a processor is not asked for timestamps: the processor's time
    /// says more.
    fn run(&mut self, job: &Job) -> Result<Answer, Failure> {
        let began = Instant::now();
        let answer = self.reader.run(job)?;
        let own = match (self.reader.device().software, self.reader.device_time()) {
            (true, _) => {
                let time = self.reader.processor_time();
                time.map(|time| Took { time, clock: Clock::Processor })
            }
            (false, Some(time)) => Some(Took { time, clock: Clock::Device }),
            (false, None) => Some(Took { time: began.elapsed(), clock: Clock::Elapsed }),
        };
        self.took.push(own);
        Ok(answer)
    }
}

/// Times of one after the other; none as soon as one is none, or of another clock.
pub fn sum(all: impl IntoIterator<Item = Option<Took>>) -> Option<Took> {
    let mut all = all.into_iter();
    let first = all.next()??;
    all.try_fold(first, |sum, one| {
        let one = one.filter(|one| one.clock == sum.clock)?;
        Some(Took { time: sum.time + one.time, ..sum })
    })
}

/// A time to count from, by the best clock of this system.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    processor: Option<Duration>,
    elapsed: Instant,
}

impl Start {
    /// Now.
    pub fn now() -> Start {
        Start { elapsed: Instant::now(), processor: processor::time() }
    }

    /// What has been used since, and by which clock.
    pub fn passed(&self) -> Took {
        match (self.processor, processor::time()) {
            (Some(before), Some(now)) => {
                Took { time: now.saturating_sub(before), clock: Clock::Processor }
            }
            _ => Took { time: self.elapsed.elapsed(), clock: Clock::Elapsed },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_of_one_clock_add_up_and_others_do_not() {
        let took = |millis, clock| Some(Took { time: Duration::from_millis(millis), clock });
        let both = [took(2, Clock::Device), took(3, Clock::Device)];
        assert_eq!(sum(both), took(5, Clock::Device));
        assert_eq!(sum([took(2, Clock::Device), took(3, Clock::Elapsed)]), None);
        assert_eq!(sum([took(2, Clock::Device), None]), None);
        assert_eq!(sum([]), None);
    }
}
