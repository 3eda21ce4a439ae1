//! The child process: starting it, exchanging messages, ending it, and explaining how it ended.

use std::collections::VecDeque;
use std::io::{self, BufRead, BufReader};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use crate::processor::Stopwatch;

use super::Launch;
use super::frame::Frame;
use crate::backend::Failure;

/// A child process that runs jobs; ended on drop.
pub(super) struct Process {
    child: Child,
    to: mpsc::Sender<Frame>,
    from: mpsc::Receiver<io::Result<Option<Frame>>>,
    stderr_lines: Arc<Mutex<VecDeque<String>>>,
    stderr_ended: mpsc::Receiver<()>,
}

/// The number of last stderr lines kept.
const KEPT: usize = 20;

/// The time to wait for a process to end after it has closed its stdout.
const ENDING: Duration = Duration::from_secs(2);

impl Process {
    pub(super) fn start(launch: &Launch) -> Result<Process, Failure> {
        let mut command = Command::new(&launch.program);
        command
            .args(&launch.arguments)
            // Mesa's device selection layer complains without a desktop session.
            .env("NODEVICE_SELECT", "1")
            // A panic without a backtrace is one line, so that the last lines hold it.
            .env("RUST_BACKTRACE", "0")
            .envs(launch.environment.iter().map(|(name, value)| (name, value)))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        // Ctrl-C is meant for the parent: this process ends when its stdin does.
        in_own_group(&mut command);
        let mut child = command.spawn().map_err(|cause| {
            let program = launch.program.display();
            Failure::missing(
                format!("the driver process does not start: {program}"),
                cause.to_string(),
            )
        })?;
        let pipes = (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let (Some(mut stdin), Some(stdout), Some(stderr)) = pipes else {
            unreachable!("all three were asked for")
        };
        // Separate threads, since a process that hangs neither reads nor writes.
        let (to, sent) = mpsc::channel::<Frame>();
        thread::spawn(move || {
            while let Ok(frame) = sent.recv() {
                // A process that has ended is noticed when its reply is read.
                if frame.write(&mut stdin).is_err() {
                    break;
                }
            }
        });
        let (received, from) = mpsc::channel();
        thread::spawn(move || {
            let mut stdout = BufReader::new(stdout);
            loop {
                let frame = Frame::read(&mut stdout);
                let over = !matches!(frame, Ok(Some(_)));
                if received.send(frame).is_err() || over {
                    break;
                }
            }
        });
        let stderr_lines = Arc::new(Mutex::new(VecDeque::new()));
        let recorder = Arc::clone(&stderr_lines);
        let (all, stderr_ended) = mpsc::channel();
        thread::spawn(move || {
            for line in BufReader::new(stderr).split(b'\n').map_while(Result::ok) {
                let mut recorded = recorder.lock().unwrap_or_else(PoisonError::into_inner);
                recorded.push_back(String::from_utf8_lossy(&line).trim_end().to_string());
                if recorded.len() > KEPT {
                    recorded.pop_front();
                }
            }
            // The receiver may be gone.
            let _ = all.send(());
        });
        Ok(Process { child, to, from, stderr_lines, stderr_ended })
    }

    pub(super) fn id(&self) -> u32 {
        self.child.id()
    }

    pub(super) fn send(&self, frame: Frame) {
        // The writing thread ends only with the process.
        let _ = self.to.send(frame);
    }

    /// Returns the next reply, or a failure if it does not come within the limit.
    pub(super) fn receive(&mut self, limit: Duration) -> Result<Frame, Failure> {
        let clock = Stopwatch::start_of(self.child.id());
        loop {
            match self.from.recv_timeout(limit.saturating_sub(clock.elapsed())) {
                Ok(Ok(Some(frame))) => return Ok(frame),
                Err(RecvTimeoutError::Timeout) if clock.elapsed() < limit => {}
                Err(RecvTimeoutError::Timeout) => {
                    return Err(Failure { log: self.last_words(), ..Failure::timed_out(limit) });
                }
                Ok(Ok(None) | Err(_)) | Err(RecvTimeoutError::Disconnected) => {
                    return Err(self.death());
                }
            }
        }
    }

    /// Ends the process if need be and returns how it ended.
    pub(super) fn death(&mut self) -> Failure {
        let asked = Instant::now();
        let status = loop {
            match self.child.try_wait() {
                Ok(None) if asked.elapsed() < ENDING => thread::sleep(Duration::from_millis(5)),
                Ok(status) => break status,
                Err(_) => break None,
            }
        };
        let how = match status {
            Some(status) => ending(status),
            None => "closed its output but is still running".to_string(),
        };
        // Its last output may still be in the pipe.
        let _ = self.stderr_ended.recv_timeout(Duration::from_millis(500));
        Failure::died(format!("the driver process {how}"), self.last_words())
    }

    fn last_words(&self) -> String {
        let lines = self.stderr_lines.lock().unwrap_or_else(PoisonError::into_inner);
        lines.iter().map(String::as_str).collect::<Vec<_>>().join("\n")
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // The process may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[cfg(unix)]
fn in_own_group(command: &mut Command) {
    std::os::unix::process::CommandExt::process_group(command, 0);
}

#[cfg(windows)]
fn in_own_group(command: &mut Command) {
    /// `CREATE_NEW_PROCESS_GROUP`.
    const NEW_GROUP: u32 = 0x200;
    std::os::windows::process::CommandExt::creation_flags(command, NEW_GROUP);
}

/// Without process groups, Ctrl-C ends the driver's process together with this one.
#[cfg(not(any(unix, windows)))]
fn in_own_group(_: &mut Command) {}

#[cfg(unix)]
fn ending(status: ExitStatus) -> String {
    use std::os::unix::process::ExitStatusExt as _;

    /// Signals with the same number on every Unix.
    const SIGNALS: [(i32, &str); 6] = [
        (4, "SIGILL"),
        (6, "SIGABRT"),
        (8, "SIGFPE"),
        (9, "SIGKILL"),
        (11, "SIGSEGV"),
        (15, "SIGTERM"),
    ];
    let Some(signal) = status.signal() else { return exit(status) };
    match SIGNALS.iter().find(|row| row.0 == signal) {
        Some((_, name)) => format!("was ended by signal {signal} ({name})"),
        None => format!("was ended by signal {signal}"),
    }
}

#[cfg(not(unix))]
fn ending(status: ExitStatus) -> String {
    exit(status)
}

fn exit(status: ExitStatus) -> String {
    match status.code() {
        Some(code) => format!("ended with exit code {code}"),
        None => "ended without an exit code".to_string(),
    }
}
