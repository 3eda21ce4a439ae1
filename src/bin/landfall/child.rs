//! Runs other programs within limits. On Unix each has a process group of its own, which ends with
//! this process: on Ctrl-C, past the budget, and when its handle is dropped.

#[cfg(feature = "port")]
mod limited;

use std::io::{self, Read};
use std::process::{Command, Output, Stdio};
use std::sync::mpsc;
use std::thread;

use crate::watch;
#[cfg(feature = "port")]
pub use limited::{Ended, ProcessLimits, limited};

/// A started program, ended on drop with all that it started.
pub struct Child(std::process::Child);

impl Child {
    pub fn start(command: &mut Command) -> io::Result<Child> {
        in_own_group(command);
        Ok(Child(watch::start(command)?))
    }

    /// The process, to take its streams from.
    pub fn process(&mut self) -> &mut std::process::Child {
        &mut self.0
    }
}

/// The group ends with it: `git` and compilers start programs of their own.
impl Drop for Child {
    fn drop(&mut self) {
        watch::end_group(self.0.id());
        // It may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Runs a program to its end; it is bounded by the budget of the command alone.
pub fn output(command: &mut Command) -> io::Result<Output> {
    let piped = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = Child::start(piped)?;
    let said = said(&mut child, u64::MAX);
    let [stdout, stderr] = said.iter().next().unwrap_or_default();
    Ok(Output { status: child.0.wait()?, stdout, stderr })
}

/// What a program writes to both streams, once, when it has closed them.
fn said(child: &mut Child, most: u64) -> mpsc::Receiver<[Vec<u8>; 2]> {
    let (send, said) = mpsc::channel();
    let (stdout, stderr) = (child.0.stdout.take(), child.0.stderr.take());
    // Both streams are read at once, or a program that fills one pipe would wait for ever while
    // the other is read.
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

#[cfg(unix)]
fn in_own_group(command: &mut Command) {
    std::os::unix::process::CommandExt::process_group(command, 0);
}

#[cfg(not(unix))]
fn in_own_group(_: &mut Command) {}
