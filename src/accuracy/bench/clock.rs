//! What time is: of the processor where it computes, of the device where that does.
//!
//! For [`rounds`](super::measure).

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

/// What was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Clock {
    /// Time on a processor of all threads of this process, those that ended too
    /// (`CLOCK_PROCESS_CPUTIME_ID`): another program's work does not count.
    Processor,
    /// Time that passed, where the system has no such clock.
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

/// A time to count from, by the best clock of this system.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    processor: Option<Duration>,
    elapsed: Instant,
}

impl Start {
    /// Now.
    pub fn now() -> Start {
        Start { elapsed: Instant::now(), processor: processor() }
    }

    /// What has been used since, and by which clock.
    pub fn passed(&self) -> (Duration, Clock) {
        match (self.processor, processor()) {
            (Some(before), Some(now)) => (now.saturating_sub(before), Clock::Processor),
            _ => (self.elapsed.elapsed(), Clock::Elapsed),
        }
    }
}

/// Time on a processor of all threads of this process, where the system tells it.
#[cfg(all(unix, feature = "cli"))]
pub fn processor() -> Option<Duration> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    let seconds = u64::try_from(time.tv_sec).ok()?;
    Some(Duration::new(seconds, u32::try_from(time.tv_nsec).ok()?))
}

/// Time on a processor of all threads of this process, where the system tells it.
#[cfg(not(all(unix, feature = "cli")))]
pub fn processor() -> Option<Duration> {
    None
}
