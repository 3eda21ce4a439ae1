//! Processor time of all threads of a process.
//!
//! Used for drivers and browsers, which have processes of their own, and by the clock of
//! `landfall_accuracy::bench`.

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

/// Returns the process group of another process, and its processor time (`/proc/PID/stat`); `None`
/// if the system does not report them.
#[cfg(target_os = "linux")]
fn facts_of(process: u32) -> Option<(u32, Duration)> {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The program's name is in parentheses and may hold anything; fields are counted after it.
    let (_, fields) = stat.rsplit_once(')')?;
    let fields: Vec<&str> = fields.split_ascii_whitespace().collect();
    // Fields 5, 14 and 15 of proc_pid_stat(5): process group, user time and system time.
    let [group, user, system] = [2, 11, 12].map(|at| fields.get(at)?.parse::<u64>().ok());
    let ticks = rustix::param::clock_ticks_per_second();
    let time = Duration::from_secs_f64((user? + system?) as f64 / ticks as f64);
    Some((u32::try_from(group?).ok()?, time))
}

/// Returns nothing: this system is not known to report it of another process.
#[cfg(not(target_os = "linux"))]
fn facts_of(_: u32) -> Option<(u32, Duration)> {
    None
}

/// Returns the processes of a process group that there are now; none if the system does not list
/// them.
#[cfg(feature = "web")]
pub(crate) fn in_group(group: u32) -> Vec<u32> {
    let all = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    // Other names than numbers are no processes.
    let ids = all.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    ids.filter(|id| facts_of(*id).is_some_and(|(found, _)| found == group)).collect()
}

/// Returns the processor time of those processes that there are; `None` if there are none, or the
/// system does not report it.
fn time_of_all(processes: &[u32]) -> Option<Duration> {
    let times = processes.iter().filter_map(|process| Some(facts_of(*process)?.1));
    times.reduce(|all, one| all + one)
}

/// A clock for time limits: on a busy machine it runs as slowly as the work it measures.
#[derive(Clone, Debug)]
pub struct Stopwatch {
    begun: Instant,
    /// The measured processes; `None` is this one.
    processes: Option<Vec<u32>>,
    processor: Option<Duration>,
}

impl Stopwatch {
    /// Ratio of elapsed time to its limit at which work ends even without processor time.
    const PATIENCE: u32 = 10;

    /// Starts a clock for work in this process.
    pub fn start() -> Stopwatch {
        Stopwatch { begun: Instant::now(), processes: None, processor: time() }
    }

    /// Starts a clock for work in other processes; without any, processor time is not measured.
    pub fn start_of(processes: &[u32]) -> Stopwatch {
        let processor = time_of_all(processes);
        Stopwatch { begun: Instant::now(), processes: Some(processes.to_vec()), processor }
    }

    /// Returns the smaller of elapsed time and processor time since the start, but at least a tenth
    /// of the elapsed time.
    pub fn elapsed(&self) -> Duration {
        let elapsed = self.begun.elapsed();
        let now = match &self.processes {
            None => time(),
            Some(processes) => time_of_all(processes),
        };
        match (self.processor, now) {
            (Some(before), Some(now)) => {
                now.saturating_sub(before).min(elapsed).max(elapsed / Stopwatch::PATIENCE)
            }
            _ => elapsed,
        }
    }
}
