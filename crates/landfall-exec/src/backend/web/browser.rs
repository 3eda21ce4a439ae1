//! A browser without a window, driven over a pipe by the DevTools protocol.
//!
//! A shell connects the pipe to the descriptors that the browser expects (3 and 4), waits for its
//! end, and removes its profile: even if this process is killed, the browser sees the pipe close
//! and ends, and nothing of it stays.

use std::fmt::Write as _;
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{ChildStdin, ChildStdout, Command};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

use serde::Serialize;
use serde_json::{Value, json};

use super::Launch;
use super::wire::PageReply;
use crate::backend::child::{ChildRole, Message, Process};
use crate::backend::{BackendKind, Failure};

/// The script that runs jobs in the page.
const SCRIPT: &str = include_str!("reader.js");

/// The page, which may load and run nothing by itself. It is a file, since WebGPU needs an origin
/// that can be trusted.
const PAGE: &str = "<!doctype html><meta charset=\"utf-8\"><title>landfall</title>\
     <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'\">\n";

/// The browser needs some time to remove what it has written.
const ROLE: ChildRole =
    ChildRole { name: "browser", works: false, parting: Duration::from_secs(5) };

/// `$1` is the profile's directory, the rest the browser's command. The browser's own processes may
/// write to the directory while it is removed.
const SUPERVISOR: &str = "directory=$1; shift; \"$@\" 3<&0 4>&1 </dev/null >/dev/null; status=$?; \
     for _ in 1 2 3 4 5 6 7 8 9; do \
     rm -rf -- \"$directory\" 2>/dev/null; [ -e \"$directory\" ] || break; sleep 1; done; \
     exit $status";

/// No window, no requests of the browser's own, no names that resolve, WebGPU where it is not on by
/// default, and a software renderer where there is no GPU.
const FLAGS: [&str; 17] = [
    "--headless",
    "--remote-debugging-pipe",
    "--no-first-run",
    "--no-default-browser-check",
    "--no-service-autorun",
    "--disable-background-networking",
    "--disable-breakpad",
    "--disable-component-update",
    "--disable-default-apps",
    "--disable-dev-shm-usage",
    "--disable-extensions",
    "--disable-sync",
    "--host-resolver-rules=MAP * ~NOTFOUND",
    "--password-store=basic",
    "--ignore-gpu-blocklist",
    "--enable-unsafe-swiftshader",
    "--enable-unsafe-webgpu",
];

/// A running browser with the page open.
pub(super) struct Browser {
    process: Process<Text>,
    /// The directory of its profile and page, dropped after the process.
    #[expect(dead_code, reason = "removed when it is dropped")]
    directory: Directory,
    /// Its name and version: `Chrome/156.0.8078.79`.
    pub(super) version: String,
    /// The number of the last command.
    last: u64,
    /// The page's session.
    session: String,
    /// The object of [`SCRIPT`].
    script: String,
}

impl Browser {
    /// Starts a browser and opens the page; fails where there is no Unix shell.
    pub(super) fn start(launch: &Launch) -> Result<Browser, Failure> {
        if cfg!(not(unix)) {
            let message = "landfall drives browsers on Linux, macOS and other Unix systems only";
            return Err(Failure::missing(message, ""));
        }
        let directory = Directory::create(&launch.scratch)?;
        let page = directory.0.join("page.html");
        std::fs::write(&page, PAGE).map_err(|cause| unwritable(&page, &cause))?;
        let url = file_url(&page);
        let mut profile = std::ffi::OsString::from("--user-data-dir=");
        profile.push(directory.0.join("profile"));
        let mut command = Command::new("/bin/sh");
        command.args(["-c", SUPERVISOR, "sh"]).arg(&directory.0).arg(&launch.program);
        command.args(FLAGS).arg(profile);
        // Chromium's sandbox refuses to run as root.
        if runs_as_root() {
            command.arg("--no-sandbox");
        }
        // Of a switch that is given twice, Chromium takes the last.
        command.args(&launch.arguments).arg(&url);
        let mut browser = Browser {
            process: Process::start(command, ROLE)?,
            directory,
            version: String::new(),
            last: 0,
            session: String::new(),
            script: String::new(),
        };
        browser.open(launch.opening)?;
        // Only now: until its page is open, the browser starts processes.
        browser.process.measure_group();
        Ok(browser)
    }

    /// Waits for the page and runs the script in it.
    fn open(&mut self, limit: Duration) -> Result<(), Failure> {
        let begun = Instant::now();
        let mut ask = |command: &str, parameters: Value| {
            self.command(command, &parameters, limit.saturating_sub(begun.elapsed()))
        };
        let text = |value: &Value| value.as_str().unwrap_or_default().to_string();
        let version = text(&ask("Browser.getVersion", json!({}))?["product"]);
        let is_page = |target: &&Value| {
            let url = target["url"].as_str().unwrap_or_default();
            target["type"] == "page" && url.starts_with("file:") && url.ends_with("/page.html")
        };
        // The browser answers before its page is open.
        let page = loop {
            let found = ask("Target.getTargets", json!({}))?;
            let mut targets = found["targetInfos"].as_array().into_iter().flatten();
            match targets.find(is_page) {
                Some(page) => break page["targetId"].clone(),
                None => std::thread::sleep(Duration::from_millis(10)),
            }
        };
        let attached = ask("Target.attachToTarget", json!({ "targetId": page, "flatten": true }))?;
        self.session = text(&attached["sessionId"]);
        self.version = version;
        let mut ask = |command: &str, parameters: Value| {
            self.command(command, &parameters, limit.saturating_sub(begun.elapsed()))
        };
        // From here on the browser tells when the page crashes.
        ask("Inspector.enable", json!({}))?;
        // Until the page is loaded, whose title is `landfall`.
        loop {
            let state = json!({ "expression": "document.title + document.readyState" });
            match &ask("Runtime.evaluate", state)?["result"]["value"] {
                state if state == "landfallcomplete" => break,
                _ => std::thread::sleep(Duration::from_millis(10)),
            }
        }
        let made = ask("Runtime.evaluate", json!({ "expression": SCRIPT }))?;
        self.script = text(&made["result"]["objectId"]);
        Ok(())
    }

    /// Returns the ID of the process that supervises the browser.
    pub(super) fn process(&self) -> u32 {
        self.process.id()
    }

    /// Calls a function of the script.
    pub(super) fn call(
        &mut self,
        function: &str,
        backend: BackendKind,
        argument: &impl Serialize,
        limit: Duration,
    ) -> Result<PageReply, Failure> {
        /// A call by name, its arguments as data.
        #[derive(Serialize)]
        #[serde(rename_all = "camelCase")]
        struct BrowserCall<'a, T> {
            object_id: &'a str,
            function_declaration: &'static str,
            arguments: (Value, Value, BrowserArgument<'a, T>),
            await_promise: bool,
            return_by_value: bool,
        }

        #[derive(Serialize)]
        struct BrowserArgument<'a, T> {
            value: &'a T,
        }

        let script = self.script.clone();
        let call = BrowserCall {
            object_id: &script,
            // The name and the arguments are data: no text of a shader becomes code of the page.
            function_declaration: "function (name, api, value) { return this[name](api, value); }",
            arguments: (
                json!({ "value": function }),
                json!({ "value": backend.name() }),
                BrowserArgument { value: argument },
            ),
            await_promise: true,
            return_by_value: true,
        };
        let mut answer = self.command("Runtime.callFunctionOn", &call, limit)?;
        if let Some(thrown) = answer.get("exceptionDetails") {
            return Err(Failure::died("the script of the page failed", thrown.to_string()));
        }
        serde_json::from_value(answer["result"]["value"].take()).map_err(garbled)
    }

    /// Sends a command of the DevTools protocol and returns its result.
    fn command(
        &mut self,
        method: &str,
        parameters: &impl Serialize,
        limit: Duration,
    ) -> Result<Value, Failure> {
        #[derive(Serialize)]
        #[serde(rename_all = "camelCase")]
        struct Sent<'a, T> {
            id: u64,
            method: &'a str,
            params: &'a T,
            #[serde(skip_serializing_if = "str::is_empty")]
            session_id: &'a str,
        }

        let begun = self.process.clock();
        self.last += 1;
        let sent = Sent { id: self.last, method, params: parameters, session_id: &self.session };
        self.process.send(Text(serde_json::to_vec(&sent).map_err(garbled)?));
        loop {
            let left = limit.saturating_sub(begun.elapsed());
            let Text(text) = self.process.receive(left).map_err(|failure| match failure.kind {
                // The time limit of the command, not what was left of it.
                crate::backend::FailureKind::TimedOut => {
                    Failure { log: failure.log, ..Failure::timed_out(limit) }
                }
                _ => failure,
            })?;
            let mut message: Value = serde_json::from_slice(&text).map_err(garbled)?;
            let event = message["method"].as_str().unwrap_or_default();
            if matches!(event, "Inspector.targetCrashed" | "Inspector.detached") {
                return Err(Failure::died("the page crashed", self.process.last_words()));
            }
            // An event, or the answer to an earlier command that was not waited for.
            if message["id"] != self.last {
                continue;
            }
            if let Some(error) = message["error"]["message"].as_str() {
                return Err(Failure::died(format!("the browser refuses `{method}`"), error));
            }
            return Ok(message["result"].take());
        }
    }
}

#[cfg(unix)]
fn runs_as_root() -> bool {
    rustix::process::geteuid().is_root()
}

#[cfg(not(unix))]
fn runs_as_root() -> bool {
    false
}

fn garbled(cause: serde_json::Error) -> Failure {
    Failure::died("a message of the browser cannot be decoded", cause.to_string())
}

/// A message of the DevTools protocol over pipes: JSON that a zero byte ends.
struct Text(Vec<u8>);

impl Message for Text {
    fn write(&self, to: &mut ChildStdin) -> io::Result<()> {
        to.write_all(&self.0)?;
        to.write_all(&[0])?;
        to.flush()
    }

    fn read(from: &mut BufReader<ChildStdout>) -> io::Result<Option<Text>> {
        let mut text = Vec::new();
        from.read_until(0, &mut text)?;
        // A message that breaks off is the end, too.
        Ok(text.pop_if(|last| *last == 0).map(|_| Text(text)))
    }
}

/// A directory that is removed with the value.
struct Directory(PathBuf);

impl Directory {
    /// Creates a directory that only this user may read.
    fn create(scratch: &Path) -> Result<Directory, Failure> {
        /// The number of directories that this process has made.
        static MADE: AtomicU32 = AtomicU32::new(0);

        loop {
            let number = MADE.fetch_add(1, Ordering::Relaxed);
            let path = scratch.join(format!("landfall-browser-{}-{number}", std::process::id()));
            match create_private(&path) {
                Ok(()) => return Ok(Directory(path)),
                // An earlier process of the same number may have left one.
                Err(cause) if cause.kind() == io::ErrorKind::AlreadyExists => {}
                Err(cause) => return Err(unwritable(&path, &cause)),
            }
        }
    }
}

#[cfg(unix)]
fn create_private(path: &Path) -> io::Result<()> {
    let mut builder = std::fs::DirBuilder::new();
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(path)
}

#[cfg(not(unix))]
fn create_private(path: &Path) -> io::Result<()> {
    std::fs::create_dir(path)
}

impl Drop for Directory {
    fn drop(&mut self) {
        // The supervisor may have removed it.
        landfall_layout::file::remove_directory(&self.0);
    }
}

fn unwritable(path: &Path, cause: &io::Error) -> Failure {
    let message = format!("{} cannot be written for the browser", path.display());
    Failure::missing(message, cause.to_string())
}

/// Returns the URL of a file.
fn file_url(path: &Path) -> String {
    let mut url = "file://".to_string();
    for &byte in path.as_os_str().as_encoded_bytes() {
        if byte.is_ascii_alphanumeric() || b"/-._~".contains(&byte) {
            url.push(char::from(byte));
        } else {
            let _ = write!(url, "%{byte:02X}");
        }
    }
    url
}
