//! Limits of processor time and memory of a program that is run.

use std::io::{self, Write};
use std::process::{Command, ExitStatus, Output, Stdio};
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use super::{Child, said};
use crate::watch;

/// Time between two looks at a program that runs.
const INTERVAL: Duration = Duration::from_millis(10);

/// Ratio of elapsed time to processor time at which a program that waits is ended.
/// A program that waits for input or a lock uses no processor time.
const PATIENCE: u32 = 10;

/// The most bytes read of each stream of a program with limits.
const MAX_SAID: u64 = 1 << 20;

/// The limits of a program. Without Linux, elapsed time alone is limited.
pub struct ProcessLimits {
    /// Processor time; a program that waits is ended after [`PATIENCE`] times as long.
    pub time: Duration,
    /// Bytes of address space.
    pub memory: u64,
}

pub enum Ended {
    Itself(Output),
    /// Past its limit of time.
    Late,
    /// Ctrl-C was pressed.
    Interrupted,
}

/// Runs a program with this input within limits.
pub fn limited(command: &mut Command, input: Vec<u8>, limits: &ProcessLimits) -> io::Result<Ended> {
    let piped = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let began = Instant::now();
    let mut child = Child::start(piped)?;
    // Set from outside, right after the start: nothing runs between fork and exec.
    limit(child.0.id(), limits);
    let stdin = child.0.stdin.take();
    // A program may end before it has read all; one that hangs reads nothing.
    thread::spawn(move || stdin.map(|mut stdin| stdin.write_all(&input)));
    let said = said(&mut child, MAX_SAID);
    let mut streams = None;
    loop {
        match said.recv_timeout(INTERVAL) {
            Ok(both) => streams = Some(both),
            Err(mpsc::RecvTimeoutError::Timeout) => {}
            Err(mpsc::RecvTimeoutError::Disconnected) => thread::sleep(INTERVAL),
        }
        // Ended only with both streams closed: what it started may still write.
        let status = if streams.is_some() { child.0.try_wait()? } else { None };
        match (status, streams.take()) {
            (Some(status), _) if is_late(status) => return Ok(Ended::Late),
            (Some(status), Some([stdout, stderr])) => {
                return Ok(Ended::Itself(Output { status, stdout, stderr }));
            }
            // Kept until the program has ended.
            (_, waiting) => streams = waiting,
        }
        if watch::is_stopped() {
            return Ok(Ended::Interrupted);
        }
        if began.elapsed() > limits.time.saturating_mul(PATIENCE) {
            return Ok(Ended::Late);
        }
    }
}

/// Sets the limits of a process that has just started.
#[cfg(target_os = "linux")]
fn limit(process: u32, limits: &ProcessLimits) {
    use rustix::process::{Pid, Resource, Rlimit, prlimit};

    let pid = i32::try_from(process).ok().and_then(Pid::from_raw);
    // The kernel counts whole seconds of processor time; the hard limit ends what ignores the soft.
    let seconds = limits.time.as_secs_f64().ceil() as u64;
    for (resource, most, hard) in
        [(Resource::Cpu, seconds, seconds + 1), (Resource::As, limits.memory, limits.memory)]
    {
        // A process that has ended needs no limits.
        let _ = prlimit(pid, resource, Rlimit { current: Some(most), maximum: Some(hard) });
    }
}

/// Other systems limit a process from within only.
#[cfg(not(target_os = "linux"))]
fn limit(_: u32, limits: &ProcessLimits) {
    let _ = limits.memory;
}

/// Whether a process was ended because of its limit of processor time.
#[cfg(unix)]
fn is_late(status: ExitStatus) -> bool {
    let signal = std::os::unix::process::ExitStatusExt::signal(&status);
    signal == Some(rustix::process::Signal::XCPU.as_raw())
}

#[cfg(not(unix))]
fn is_late(_: ExitStatus) -> bool {
    false
}
