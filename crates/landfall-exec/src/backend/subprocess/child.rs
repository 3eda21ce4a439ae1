//! The process that has the driver: started, listened to, ended, and its end explained.

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

/// A process that runs jobs. It is ended when this goes.
pub(super) struct Process {
    child: Child,
    to: mpsc::Sender<Frame>,
    from: mpsc::Receiver<io::Result<Option<Frame>>>,
    said: Arc<Mutex<VecDeque<String>>>,
    said_all: mpsc::Receiver<()>,
}

/// Lines of its stderr that are kept, the last ones.
const KEPT: usize = 20;

/// How long the end of a process that has closed its stdout is waited for.
const ENDING: Duration = Duration::from_secs(2);

impl Process {
    pub(super) fn start(launch: &Launch) -> Result<Process, Failure> {
        let mut command = Command::new(&launch.program);
        command
            .args(&launch.arguments)
            // Mesa's device selection asks for a desktop session and complains without.
            .env("NODEVICE_SELECT", "1")
            // A panic is told in one line, so that the last lines are what matters.
            .env("RUST_BACKTRACE", "0")
            .envs(launch.environment.iter().map(|(name, value)| (name, value)))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        // Ctrl-C is for the one who asks: this process ends when its stdin does.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut child = command.spawn().map_err(|cause| {
            let program = launch.program.display();
            Failure::missing(
                format!("the process of the driver does not start: {program}"),
                cause.to_string(),
            )
        })?;
        let pipes = (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let (Some(mut stdin), Some(stdout), Some(stderr)) = pipes else {
            unreachable!("all three were asked for")
        };
        // Threads, since a process that hangs neither reads nor writes.
        let (to, sent) = mpsc::channel::<Frame>();
        thread::spawn(move || {
            while let Ok(frame) = sent.recv() {
                // A process that is gone shows where its replies are read.
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
        let said = Arc::new(Mutex::new(VecDeque::new()));
        let heard = Arc::clone(&said);
        let (all, said_all) = mpsc::channel();
        thread::spawn(move || {
            for line in BufReader::new(stderr).split(b'\n').map_while(Result::ok) {
                let mut heard = heard.lock().unwrap_or_else(PoisonError::into_inner);
                heard.push_back(String::from_utf8_lossy(&line).trim_end().to_string());
                if heard.len() > KEPT {
                    heard.pop_front();
                }
            }
            // Nobody may be waiting.
            let _ = all.send(());
        });
        Ok(Process { child, to, from, said, said_all })
    }

    pub(super) fn id(&self) -> u32 {
        self.child.id()
    }

    pub(super) fn send(&self, frame: Frame) {
        // If the thread that writes is gone, so is the process.
        let _ = self.to.send(frame);
    }

    /// The next reply, if it comes within the limit.
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

    /// How it ended.
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
            None => "closed its output and does not end".to_string(),
        };
        // What it wrote last may still be on its way.
        let _ = self.said_all.recv_timeout(Duration::from_millis(500));
        Failure::died(format!("the process of the driver {how}"), self.last_words())
    }

    fn last_words(&self) -> String {
        let said = self.said.lock().unwrap_or_else(PoisonError::into_inner);
        said.iter().map(String::as_str).collect::<Vec<_>>().join("\n")
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[cfg(unix)]
fn ending(status: ExitStatus) -> String {
    use std::os::unix::process::ExitStatusExt as _;

    /// Those with one number on every Unix.
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
