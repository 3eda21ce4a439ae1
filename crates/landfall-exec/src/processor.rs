//! Time on a processor, of all threads of this process.
//!
//! For [`subprocess`](crate::backend::subprocess), whose driver works in a process of its own, and the clock of
//! `landfall_light::accuracy::bench`.

use std::time::{Duration, Instant};

/// Time on a processor of all threads of this process, those that ended too
/// (`CLOCK_PROCESS_CPUTIME_ID`), where the system tells it.
#[cfg(unix)]
pub fn time() -> Option<Duration> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    let seconds = u64::try_from(time.tv_sec).ok()?;
    Some(Duration::new(seconds, u32::try_from(time.tv_nsec).ok()?))
}

/// Time on a processor of all threads of this process, where the system tells it.
#[cfg(not(unix))]
pub fn time() -> Option<Duration> {
    None
}

/// Processor time of another process, where the system tells it (`/proc/PID/stat`).
#[cfg(target_os = "linux")]
fn time_of(process: u32) -> Option<Duration> {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The name of the program is in parentheses and may hold anything; fields are counted after it.
    let (_, fields) = stat.rsplit_once(')')?;
    let mut fields = fields.split_ascii_whitespace().skip(11);
    let user: u64 = fields.next()?.parse().ok()?;
    let system: u64 = fields.next()?.parse().ok()?;
    let ticks = rustix::param::clock_ticks_per_second();
    Some(Duration::from_secs_f64((user + system) as f64 / ticks as f64))
}

/// Processor time of another process, where the system tells it.
#[cfg(not(target_os = "linux"))]
fn time_of(_: u32) -> Option<Duration> {
    None
}

/// A clock for limits: on a busy machine it runs as slowly as the work it watches.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch {
    begun: Instant,
    /// The process whose time counts; `None` is this one.
    process: Option<u32>,
    processor: Option<Duration>,
}

impl Stopwatch {
    /// Work that never gets the processor ends all the same, after so many times its limit.
    const PATIENCE: u32 = 10;

    /// A clock for work in this process.
    pub fn start() -> Stopwatch {
        Stopwatch { begun: Instant::now(), process: None, processor: time() }
    }

    /// A clock for work in another process.
    pub fn start_of(process: u32) -> Stopwatch {
        Stopwatch { begun: Instant::now(), process: Some(process), processor: time_of(process) }
    }

    /// Elapsed time, but no more than the processor time since the start; at least a tenth of
    /// the elapsed time.
    pub fn elapsed(&self) -> Duration {
        let elapsed = self.begun.elapsed();
        let now = match self.process {
            None => time(),
            Some(process) => time_of(process),
        };
        match (self.processor, now) {
            (Some(before), Some(now)) => {
                now.saturating_sub(before).min(elapsed).max(elapsed / Stopwatch::PATIENCE)
            }
            _ => elapsed,
        }
    }
}
