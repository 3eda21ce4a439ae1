//! Runs other programs within limits. On Unix each has a process group of its own, which ends with
//! this process: on Ctrl-C, past the budget, and when its handle is dropped.

use std::io::{self, Read, Write};
use std::process::{Command, ExitStatus, Output, Stdio};
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use crate::watch;

/// Time between two looks at a program that runs.
const INTERVAL: Duration = Duration::from_millis(10);

/// Ratio of elapsed time to processor time at which a program that waits is ended.
const PATIENCE: u32 = 10;

/// The most bytes read of each stream of a program with limits.
const MOST_SAID: u64 = 1 << 20;

/// A started program, ended on drop with all that it started.
pub struct Child(std::process::Child);

impl Child {
    pub fn start(command: &mut Command) -> io::Result<Child> {
        in_own_group(command);
        let child = command.spawn()?;
        watch::started(child.id());
        Ok(Child(child))
    }

    /// The process, to take its streams from.
    pub fn process(&mut self) -> &mut std::process::Child {
        &mut self.0
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        watch::end_group(self.0.id());
        // It may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The limits of a program. Without Linux, elapsed time alone is limited.
pub struct Limits {
    /// Processor time; a program that waits is ended after [`PATIENCE`] times as long.
    pub time: Duration,
    /// Bytes of address space.
    pub memory: u64,
}

/// How a program with limits ended.
pub enum Ended {
    Itself(Output),
    /// Past its limit of time.
    Late,
    /// Ctrl-C was pressed.
    Interrupted,
}

/// Runs a program to its end; it is bounded by the budget of the command alone.
pub fn output(command: &mut Command) -> io::Result<Output> {
    let piped = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = Child::start(piped)?;
    let said = said(&mut child, u64::MAX);
    let [stdout, stderr] = said.iter().next().unwrap_or_default();
    Ok(Output { status: child.0.wait()?, stdout, stderr })
}

/// Runs a program with this input within limits.
pub fn limited(command: &mut Command, input: Vec<u8>, limits: &Limits) -> io::Result<Ended> {
    let piped = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let began = Instant::now();
    let mut child = Child::start(piped)?;
    limit(child.0.id(), limits);
    let stdin = child.0.stdin.take();
    // A program may end before it has read all; one that hangs reads nothing.
    thread::spawn(move || stdin.map(|mut stdin| stdin.write_all(&input)));
    let said = said(&mut child, MOST_SAID);
    let mut streams = None;
    loop {
        match said.recv_timeout(INTERVAL) {
            Ok(both) => streams = Some(both),
            Err(mpsc::RecvTimeoutError::Timeout) => {}
            Err(mpsc::RecvTimeoutError::Disconnected) => thread::sleep(INTERVAL),
        }
        let status = if streams.is_some() { child.0.try_wait()? } else { None };
        match (status, streams.take()) {
            (Some(status), _) if is_late(status) => return Ok(Ended::Late),
            (Some(status), Some([stdout, stderr])) => {
                return Ok(Ended::Itself(Output { status, stdout, stderr }));
            }
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

/// What a program writes to both streams, once, when it has closed them.
fn said(child: &mut Child, most: u64) -> mpsc::Receiver<[Vec<u8>; 2]> {
    let (send, said) = mpsc::channel();
    let (stdout, stderr) = (child.0.stdout.take(), child.0.stderr.take());
    let stderr = thread::spawn(move || all(stderr, most));
    thread::spawn(move || {
        let stdout = all(stdout, most);
        let _ = send.send([stdout, stderr.join().unwrap_or_default()]);
    });
    said
}

/// The first bytes of a stream; the rest is read and dropped.
fn all(stream: Option<impl Read>, most: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    if let Some(mut stream) = stream {
        // What was read before an error counts.
        let _ = stream.by_ref().take(most).read_to_end(&mut bytes);
        let _ = io::copy(&mut stream, &mut io::sink());
    }
    bytes
}

/// Sets the limits of a process that has just started.
#[cfg(target_os = "linux")]
fn limit(process: u32, limits: &Limits) {
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
fn limit(_: u32, limits: &Limits) {
    let _ = limits.memory;
}

#[cfg(unix)]
fn in_own_group(command: &mut Command) {
    std::os::unix::process::CommandExt::process_group(command, 0);
}

#[cfg(not(unix))]
fn in_own_group(_: &mut Command) {}

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
