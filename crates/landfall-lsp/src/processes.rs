//! The processes of commands: each is waited for on a thread of its own, and ended if that is asked for.

use std::io::{Read, Write};
use std::process::Child;
use std::thread;
use std::time::Duration;

use landfall_check::stop::StopFlag;
use lsp_server::RequestId;
use serde_json::Value;

/// How often a process is asked whether it has ended.
const POLL: Duration = Duration::from_millis(20);

/// A process that runs.
pub struct RunningCommand {
    pub stop: StopFlag,
    /// Under which the client is told of progress.
    pub token: Option<Value>,
}

/// A process that has ended.
pub struct CommandResult {
    pub id: RequestId,
    pub title: String,
    /// The name of the file that is shown.
    pub shown: &'static str,
    pub output: Result<ProcessOutput, String>,
    pub was_stopped: bool,
}

pub struct ProcessOutput {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

/// Waits for a process, and ends it if it is to stop.
pub fn wait(
    mut child: Child,
    input: Option<String>,
    stop: &StopFlag,
) -> std::io::Result<ProcessOutput> {
    let stdin = child.stdin.take();
    let feed = thread::spawn(move || {
        if let (Some(mut stdin), Some(input)) = (stdin, input) {
            // A process that has ended reads no further.
            let _ = stdin.write_all(input.as_bytes());
        }
    });
    let (stdout, stderr) = (reading(child.stdout.take()), reading(child.stderr.take()));
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        if stop.is_set() {
            child.kill()?;
        }
        thread::sleep(POLL);
    };
    let text = |reader: thread::JoinHandle<Vec<u8>>| {
        String::from_utf8_lossy(&reader.join().unwrap_or_default()).into_owned()
    };
    let _ = feed.join();
    Ok(ProcessOutput { code: status.code(), stdout: text(stdout), stderr: text(stderr) })
}

fn reading(stream: Option<impl Read + Send + 'static>) -> thread::JoinHandle<Vec<u8>> {
    thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut stream) = stream {
            let _ = stream.read_to_end(&mut bytes);
        }
        bytes
    })
}
