//! Processor time of all threads of a process.
//!
//! Used by [`subprocess`](crate::backend::subprocess), whose driver has a separate process, and by
//! the clock of `landfall_light::accuracy::bench`.

use std::time::{Duration, Instant};

/// Returns the processor time of all threads of this process, ended ones included
/// (`CLOCK_PROCESS_CPUTIME_ID`); `None` if the system does not report it.
#[cfg(unix)]
pub fn time() -> Option<Duration> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    let seconds = u64::try_from(time.tv_sec).ok()?;
    Some(Duration::new(seconds, u32::try_from(time.tv_nsec).ok()?))
}

/// Returns the processor time of all threads of this process (`GetProcessTimes`); `None` if the
/// system does not report it.
#[cfg(windows)]
pub fn time() -> Option<Duration> {
    cpu_time::ProcessTime::try_now().ok().map(|time| time.as_duration())
}

/// Returns `None`: this system is not known to report processor time.
#[cfg(not(any(unix, windows)))]
pub fn time() -> Option<Duration> {
    None
}

/// Returns the processor time of another process (`/proc/PID/stat`); `None` if the system does not
/// report it.
#[cfg(target_os = "linux")]
fn time_of(process: u32) -> Option<Duration> {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The program's name is in parentheses and may hold anything; fields are counted after it.
    let (_, fields) = stat.rsplit_once(')')?;
    let mut fields = fields.split_ascii_whitespace().skip(11);
    let user: u64 = fields.next()?.parse().ok()?;
    let system: u64 = fields.next()?.parse().ok()?;
    let ticks = rustix::param::clock_ticks_per_second();
    Some(Duration::from_secs_f64((user + system) as f64 / ticks as f64))
}

/// Returns the processor time of another process; `None` if the system does not report it.
#[cfg(not(target_os = "linux"))]
fn time_of(_: u32) -> Option<Duration> {
    None
}

/// Returns the end of a time limit that begins now; `None` where there is no clock, as in
/// WebAssembly: there the interpreter ends after its budget of steps.
pub fn deadline(limit: Duration) -> Option<Instant> {
    if cfg!(target_family = "wasm") { None } else { Instant::now().checked_add(limit) }
}

/// A clock for time limits: on a busy machine it runs as slowly as the work it measures.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch {
    begun: Instant,
    /// The measured process; `None` is this one.
    process: Option<u32>,
    processor: Option<Duration>,
}

impl Stopwatch {
    /// Ratio of elapsed time to its limit at which work ends even without processor time.
    const PATIENCE: u32 = 10;

    /// Starts a clock for work in this process.
    pub fn start() -> Stopwatch {
        Stopwatch { begun: Instant::now(), process: None, processor: time() }
    }

    /// Starts a clock for work in another process.
    pub fn start_of(process: u32) -> Stopwatch {
        Stopwatch { begun: Instant::now(), process: Some(process), processor: time_of(process) }
    }

    /// Starts a clock for work in processes whose processor time is not measured.
    #[cfg(any(feature = "gl", feature = "gpu", feature = "web"))]
    pub(crate) fn start_of_clock() -> Stopwatch {
        Stopwatch { begun: Instant::now(), process: None, processor: None }
    }

    /// Returns the smaller of elapsed time and processor time since the start, but at least a tenth
    /// of the elapsed time.
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
