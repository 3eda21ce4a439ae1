//! Commands of the client: of this program, run as processes of their own, so that long work can be
//! ended and nothing in it ends the server.

use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::Duration;

use crossbeam_channel::Sender;
use gen_lsp_types::{ExecuteCommandParams, Uri};
use landfall_check::stop::StopFlag;
use lsp_server::{ErrorCode, RequestId, Response};
use serde_json::{Value, json};

use crate::answers::Answer;
use crate::client::MessageLevel;
use crate::server::{Server, error};

/// The commands that the server runs.
pub const COMMANDS: [&str; 6] = [
    "landfall.acceptLayout",
    "landfall.emit",
    "landfall.memoryMap",
    "landfall.rule",
    "landfall.stress",
    "landfall.verify",
];

/// How often a process is asked whether it has ended.
const POLL: Duration = Duration::from_millis(20);

/// A process that has ended.
pub struct CommandResult {
    id: RequestId,
    title: String,
    /// The file that is shown.
    shown: ShownResult,
    output: Result<ProcessOutput, String>,
    was_stopped: bool,
}

struct ProcessOutput {
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

/// Where a result is shown.
enum ShownResult {
    /// In the editor, from a file of this name.
    Text(&'static str),
    /// In the browser: a page that the process has written.
    Page(PathBuf),
}

impl Server {
    pub fn execute(&mut self, id: RequestId, params: &ExecuteCommandParams) -> Answer {
        let arguments = params.arguments.as_deref().unwrap_or_default();
        let text = |index: usize| arguments.get(index).and_then(Value::as_str);
        let needed = |index: usize, what: &str| {
            let message = format!("`{}` needs {what}", params.command);
            text(index).ok_or_else(|| error(ErrorCode::InvalidParams, message))
        };
        let document = || {
            let uri = Uri(needed(0, "the address of a shader")?.to_string());
            crate::uris::path(&uri)
                .ok_or_else(|| error(ErrorCode::InvalidParams, format!("`{}` is no file", uri.0)))
        };
        let (title, options, file, shown) = match params.command.as_str() {
            "landfall.acceptLayout" => return self.accept(&document()?),
            "landfall.rule" => {
                let options = vec!["rule".to_string(), needed(0, "a code")?.to_string()];
                ("Rule", options, None, ShownResult::Text("rule.md"))
            }
            "landfall.memoryMap" => {
                let page = shown_file("memory-map.html")?;
                let out = page.display().to_string();
                let options = vec!["report".to_string(), "--out".to_string(), out];
                ("Memory map", options, Some(document()?), ShownResult::Page(page))
            }
            "landfall.emit" => {
                let block = needed(1, "a block")?.to_string();
                let language = needed(2, "a language")?.to_string();
                let shown = match language.as_str() {
                    "rust" => "mirror.rs",
                    "c" => "mirror.h",
                    _ => "mirror.txt",
                };
                let options = ["emit", "--lang", &language, "--struct", &block].map(str::to_string);
                ("Emit", options.to_vec(), Some(document()?), ShownResult::Text(shown))
            }
            "landfall.verify" => {
                let mut options = vec!["verify".to_string()];
                options.extend(text(1).map(|block| format!("--block={block}")));
                ("Verify", options, Some(document()?), ShownResult::Text("verify.txt"))
            }
            "landfall.stress" => {
                let function = needed(1, "a function")?;
                let options = vec!["stress".to_string(), format!("--function={function}")];
                ("Stress", options, Some(document()?), ShownResult::Text("stress.txt"))
            }
            other => {
                let message = format!("landfall has no command `{other}`");
                return Err(error(ErrorCode::InvalidParams, message));
            }
        };
        self.start(id, title, options, file.as_deref(), shown)?;
        Ok(None)
    }

    /// Writes the lock of a shader as it is edited.
    fn accept(&mut self, path: &Path) -> Answer {
        let Some((index, setup, _)) = self.setup_of(path) else {
            return Err(error(ErrorCode::RequestFailed, "the document is of no project"));
        };
        let (_, written) = setup.check_one(path, &self.open_files(), true);
        if written == 0 {
            let message = "no lock was written: the layout has not changed, has errors, or a policy \
                           forbids the change";
            return Err(error(ErrorCode::RequestFailed, message));
        }
        self.edited.insert(path.to_path_buf());
        self.postpone_pass(index);
        Ok(Some(json!({ "written": written })))
    }

    fn start(
        &mut self,
        id: RequestId,
        title: &str,
        mut options: Vec<String>,
        file: Option<&Path>,
        shown: ShownResult,
    ) -> Result<(), lsp_server::ResponseError> {
        let failed = |cause: std::io::Error| error(ErrorCode::RequestFailed, cause.to_string());
        let mut input = None;
        if let Some(file) = file {
            options.extend(self.settings.defines.iter().map(|one| format!("--define={one}")));
            options.extend(self.settings.targets.iter().map(|one| format!("--target={one}")));
            // What is edited is not what the file holds.
            match self.documents.get(file) {
                Some(document) if !matches!(shown, ShownResult::Page(_)) => {
                    input = Some(document.text.text().to_string());
                    options.push(format!("--stdin-filename={}", file.display()));
                    options.push("-".to_string());
                }
                _ => options.push(file.display().to_string()),
            }
        }
        let mut command = Command::new(std::env::current_exe().map_err(failed)?);
        command.args(&options).current_dir(&self.current).env("NO_COLOR", "1");
        let stdin = if input.is_some() { Stdio::piped() } else { Stdio::null() };
        let child = command.stdin(stdin).stdout(Stdio::piped()).stderr(Stdio::piped());
        let child = child.spawn().map_err(failed)?;
        let stop = StopFlag::default();
        self.running_commands.insert(id.clone(), stop.clone());
        self.progress(&id, json!({ "kind": "begin", "title": title, "cancellable": true }));
        let results: Sender<CommandResult> = self.command_results.clone();
        let title = title.to_string();
        let run = move || {
            let output = wait(child, input, &stop).map_err(|cause| cause.to_string());
            let was_stopped = stop.is_set();
            let _ = results.send(CommandResult { id, title, shown, output, was_stopped });
        };
        thread::Builder::new().name("command".to_string()).spawn(run).map_err(failed)?;
        Ok(())
    }

    fn progress(&self, id: &RequestId, value: Value) {
        if self.support.shows_progress {
            let token = format!("landfall-command-{id}");
            if value["kind"] == "begin" {
                self.client.request("window/workDoneProgress/create", json!({ "token": token }));
            }
            self.client.notify("$/progress", json!({ "token": token, "value": value }));
        }
    }

    /// Answers the request of a command, and shows its result.
    pub fn finish_command(&mut self, result: CommandResult) {
        let CommandResult { id, title, shown, output, was_stopped } = result;
        self.running_commands.remove(&id);
        self.progress(&id, json!({ "kind": "end" }));
        let answer = match output {
            _ if was_stopped => Err(error(ErrorCode::RequestCanceled, "the command was cancelled")),
            Err(cause) => Err(error(ErrorCode::RequestFailed, cause)),
            // Findings are a result, too.
            Ok(output) if matches!(output.code, Some(0 | 1)) => {
                self.show_result(&shown, &output);
                Ok(json!({ "code": output.code, "text": output.stdout, "messages": output.stderr }))
            }
            Ok(output) => {
                let message = format!("{title}: {}", output.stderr.trim());
                Err(error(ErrorCode::RequestFailed, message))
            }
        };
        self.client.respond(Response { id, response_result: answer });
    }

    fn show_result(&self, shown: &ShownResult, output: &ProcessOutput) {
        let (path, is_external) = match shown {
            ShownResult::Page(page) => (page.clone(), true),
            ShownResult::Text(name) => {
                let text = [output.stdout.as_str(), output.stderr.as_str()].concat();
                let Ok(path) = shown_file(name) else { return };
                if !self.support.shows_documents || std::fs::write(&path, &text).is_err() {
                    self.client.show(MessageLevel::Info, text.trim());
                    return;
                }
                (path, false)
            }
        };
        let params = json!({
            "uri": crate::uris::uri(&path),
            "external": is_external,
            "takeFocus": true,
        });
        match self.support.shows_documents {
            true => {
                self.client.request("window/showDocument", params);
            }
            false => {
                self.client.show(MessageLevel::Info, &format!("written to {}", path.display()));
            }
        }
    }
}

/// The path of a file that is shown, in a directory of this process.
fn shown_file(name: &str) -> Result<PathBuf, lsp_server::ResponseError> {
    let folder = std::env::temp_dir().join(format!("landfall-lsp-{}", std::process::id()));
    std::fs::create_dir_all(&folder).map_err(|cause| {
        error(ErrorCode::RequestFailed, format!("`{}` cannot be made: {cause}", folder.display()))
    })?;
    Ok(folder.join(name))
}

/// Waits for a process, and ends it if it is to stop.
fn wait(
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
