//! A child process: starting it, exchanging messages, ending it, and explaining how it ended.
//!
//! Used by [`subprocess`](super::subprocess) for drivers and by `web` for the browser.

use std::collections::VecDeque;
use std::io::{self, BufRead, BufReader};
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use crate::processor::Stopwatch;

use crate::backend::Failure;

/// A message to a child process or from it.
pub(super) trait Message: Send + Sized + 'static {
    /// Writes the message to the child's stdin.
    fn write(&self, to: &mut ChildStdin) -> io::Result<()>;

    /// Reads the next message from the child's stdout; `None` at its end.
    fn read(from: &mut BufReader<ChildStdout>) -> io::Result<Option<Self>>;
}

/// What messages call a child process, and how it ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChildRole {
    /// The noun: `driver process`.
    pub(super) name: &'static str,
    /// Whether the process itself works, not others that it starts: its processor time is measured
    /// against limits from its start on.
    pub(super) works: bool,
    /// The time to end on its own after its stdin is closed, before it is killed.
    pub(super) parting: Duration,
}

/// A child process that exchanges messages; ended on drop, with its group.
pub(super) struct Process<M> {
    child: Child,
    /// Whether the process has ended and was waited for: its number may be another's by now.
    over: bool,
    role: ChildRole,
    /// The processes whose processor time counts.
    workers: Vec<u32>,
    /// `None` once the stdin of the process is to be closed.
    to: Option<mpsc::Sender<M>>,
    from: mpsc::Receiver<io::Result<Option<M>>>,
    stderr_lines: Arc<Mutex<VecDeque<String>>>,
    stderr_ended: mpsc::Receiver<()>,
}

/// The number of last stderr lines kept.
const KEPT: usize = 20;

/// The time to wait for a process to end after it has closed its stdout.
const ENDING: Duration = Duration::from_secs(2);

impl<M: Message> Process<M> {
    /// Starts a command, its three streams connected.
    pub(super) fn start(mut command: Command, role: ChildRole) -> Result<Process<M>, Failure> {
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        // Ctrl-C is meant for the parent: this process ends when its stdin does.
        in_own_group(&mut command);
        let mut child = command.spawn().map_err(|cause| {
            let program = command.get_program().to_string_lossy().into_owned();
            Failure::missing(
                format!("the {} does not start: {program}", role.name),
                cause.to_string(),
            )
        })?;
        let pipes = (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let (Some(mut stdin), Some(stdout), Some(stderr)) = pipes else {
            unreachable!("all three were asked for")
        };
        // Separate threads, since a process that hangs neither reads nor writes.
        let (to, sent) = mpsc::channel::<M>();
        thread::spawn(move || {
            while let Ok(message) = sent.recv() {
                // A process that has ended is noticed when its reply is read.
                if message.write(&mut stdin).is_err() {
                    break;
                }
            }
        });
        let (received, from) = mpsc::channel();
        thread::spawn(move || {
            let mut stdout = BufReader::new(stdout);
            loop {
                let message = M::read(&mut stdout);
                let over = !matches!(message, Ok(Some(_)));
                if received.send(message).is_err() || over {
                    break;
                }
            }
        });
        let stderr_lines = Arc::new(Mutex::new(VecDeque::new()));
        let recorder = Arc::clone(&stderr_lines);
        let (all, stderr_ended) = mpsc::channel();
        thread::spawn(move || {
            // By bytes: what a driver prints need not be UTF-8.
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
        let workers = if role.works { vec![child.id()] } else { Vec::new() };
        let to = Some(to);
        Ok(Process { child, over: false, role, workers, to, from, stderr_lines, stderr_ended })
    }

    pub(super) fn id(&self) -> u32 {
        self.child.id()
    }

    /// Measures the processor time of all processes that this one has started so far.
    #[cfg(feature = "web")]
    pub(super) fn measure_group(&mut self) {
        self.workers = crate::processor::in_group(self.child.id());
    }

    /// Starts a clock for a time limit.
    pub(super) fn clock(&self) -> Stopwatch {
        Stopwatch::start_of(&self.workers)
    }

    pub(super) fn send(&self, message: M) {
        // The writing thread ends only with the process.
        let _ = self.to.as_ref().map(|to| to.send(message));
    }

    /// Returns the next reply, or a failure if it does not come within the limit.
    pub(super) fn receive(&mut self, limit: Duration) -> Result<M, Failure> {
        let clock = self.clock();
        // The limit is of the processor time of the child (`Stopwatch`), the wait of the wall
        // clock: it may end before the child has had that much time.
        loop {
            match self.from.recv_timeout(limit.saturating_sub(clock.elapsed())) {
                Ok(Ok(Some(message))) => return Ok(message),
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

    /// Waits for the end of the process and returns how it ended.
    fn death(&mut self) -> Failure {
        let status = self.wait(ENDING);
        let how = match status {
            Some(status) => ending(status),
            None => "closed its output but is still running".to_string(),
        };
        // Its last output may still be in the pipe.
        let _ = self.stderr_ended.recv_timeout(Duration::from_millis(500));
        Failure::died(format!("the {} {how}", self.role.name), self.last_words())
    }

    /// Returns the last lines of its stderr.
    pub(super) fn last_words(&self) -> String {
        let lines = self.stderr_lines.lock().unwrap_or_else(PoisonError::into_inner);
        lines.iter().map(String::as_str).collect::<Vec<_>>().join("\n")
    }
}

impl<M> Process<M> {
    /// Waits for the end of the process; `None` if it still runs after the limit.
    fn wait(&mut self, limit: Duration) -> Option<ExitStatus> {
        let asked = Instant::now();
        loop {
            match self.child.try_wait() {
                // The standard library has no wait with a limit.
                Ok(None) if asked.elapsed() < limit => thread::sleep(Duration::from_millis(5)),
                Ok(status) => {
                    self.over |= status.is_some();
                    return status;
                }
                Err(_) => return None,
            }
        }
    }
}

impl<M> Drop for Process<M> {
    fn drop(&mut self) {
        // Closes its stdin, unless it does not read.
        self.to = None;
        self.wait(self.role.parting);
        if !self.over {
            kill_group(&self.child);
            // It may have ended meanwhile.
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}

/// Kills what runs in the process group of a child.
#[cfg(unix)]
fn kill_group(child: &Child) {
    use rustix::process::{Pid, Signal, kill_process_group};

    if let Some(pid) = i32::try_from(child.id()).ok().and_then(Pid::from_raw) {
        // It may have ended already.
        let _ = kill_process_group(pid, Signal::KILL);
    }
}

#[cfg(not(unix))]
fn kill_group(_: &Child) {}

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
