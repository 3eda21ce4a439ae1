//! Time on a processor, of all threads of this process.
//!
//! For [`subprocess`](crate::backend::subprocess), whose driver works in a process of its own, and the clock of
//! `landfall_light::accuracy::bench`.

use std::time::Duration;

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
