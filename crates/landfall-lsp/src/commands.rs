//! Commands of the client: of this program, run as processes of their own, so that long work can be
//! ended and nothing in it ends the server.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;

use crossbeam_channel::Sender;
use gen_lsp_types::{ExecuteCommandParams, Uri};
use landfall_check::stop::StopFlag;
use landfall_layout::Rules;
use lsp_server::{ErrorCode, RequestId, Response, ResponseError};
use serde_json::{Value, json};

use crate::answers::RequestAnswer;
use crate::client::MessageLevel;
use crate::declarations::DeclarationKind;
use crate::processes::{CommandResult, ProcessOutput, RunningCommand, wait};
use crate::server::{EditorServer, error};

/// The commands that the server runs.
pub const COMMANDS: [&str; 7] = [
    "landfall.acceptLayout",
    "landfall.emit",
    "landfall.lights",
    "landfall.memoryMap",
    "landfall.rule",
    "landfall.stress",
    "landfall.verify",
];

/// A process to start.
struct CommandJob {
    id: RequestId,
    title: &'static str,
    options: Vec<String>,
    /// The shader that it reads.
    file: Option<PathBuf>,
    /// The name of the file that shows its result.
    shown: &'static str,
    /// Under which the client wants to be told of progress.
    token: Option<Value>,
}

impl EditorServer {
    pub fn execute(&mut self, id: RequestId, params: &ExecuteCommandParams) -> RequestAnswer {
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
                ("Rule", options, None, "rule.md")
            }
            "landfall.memoryMap" => return self.show_memory_map(&document()?, text(1)),
            "landfall.emit" => {
                let (name, language) = (needed(1, "a block")?, needed(2, "a language")?);
                let name = name.to_string();
                let language = language.to_string();
                let shown = match language.as_str() {
                    "rust" => "mirror.rs",
                    "c" => "mirror.h",
                    _ => "mirror.txt",
                };
                let path = document()?;
                let mut options = vec!["emit".to_string(), format!("--lang={language}")];
                // Blocks are emitted with all of their shader.
                if self.is_structure(&path, &name)? {
                    options.push(format!("--struct={name}"));
                }
                ("Emit", options, Some(path), shown)
            }
            "landfall.verify" => {
                let mut options = vec!["verify".to_string()];
                let path = document()?;
                let block = text(1).map(|name| self.verified_name(&path, name));
                options.extend(block.map(|block| format!("--block={block}")));
                ("Verify", options, Some(path), "verify.txt")
            }
            "landfall.lights" => {
                let options = vec!["lights".to_string()];
                ("Lights", options, Some(document()?), "lights.txt")
            }
            "landfall.stress" => {
                let function = needed(1, "a function")?;
                let options = vec!["stress".to_string(), format!("--fn={function}")];
                ("Stress", options, Some(document()?), "stress.txt")
            }
            other => {
                let message = format!("landfall has no command `{other}`");
                return Err(error(ErrorCode::InvalidParams, message));
            }
        };
        let given = params.work_done_progress_params.work_done_token.as_ref();
        let job =
            CommandJob { id, title, options, file, shown, token: given.map(|one| json!(one)) };
        self.start(job)?;
        Ok(None)
    }

    /// The name by which `verify` has a block: in WGSL that of its variable.
    fn verified_name(&mut self, path: &Path, name: &str) -> String {
        let document = self.layouts_in(&self.documents.uri(path));
        let layouts = document.map(|document| document.layouts).unwrap_or_default();
        let mut blocks = layouts.iter().flat_map(|one| &one.shader.blocks);
        let variable = blocks.find(|block| &*block.name == name && block.rules == Rules::Wgsl);
        let variable = variable.and_then(|block| block.instance.as_deref());
        variable.unwrap_or(name).to_string()
    }

    /// Whether a name is that of a structure, not of a block.
    fn is_structure(&mut self, path: &Path, name: &str) -> Result<bool, ResponseError> {
        let document = self.layouts_in(&self.documents.uri(path));
        let layouts = document.map(|document| document.layouts).unwrap_or_default();
        let mut all = layouts.iter().flat_map(|one| &one.declarations);
        let found = all.find(|one| one.name == name && one.kind != DeclarationKind::Member);
        let message = || format!("the shader has no block or structure `{name}`");
        let found = found.ok_or_else(|| error(ErrorCode::InvalidParams, message()))?;
        Ok(found.kind == DeclarationKind::Structure)
    }

    /// Shows the page of `report` for a shader as it is edited, opened at a block.
    fn show_memory_map(&self, path: &Path, block: Option<&str>) -> RequestAnswer {
        let Some((_, setup, _)) = self.setup_of(path) else {
            return Err(error(ErrorCode::RequestFailed, "the document is of no project"));
        };
        let page = setup.page(path, &self.open_files(), &self.texts, block);
        let file = shown_file("memory-map.html")?;
        landfall_layout::file::FileWriter::default()
            .write(&file, page)
            .map_err(|cause| error(ErrorCode::RequestFailed, cause.to_string()))?;
        self.show_file(&file, true);
        Ok(Some(json!({ "code": 0, "text": file.display().to_string(), "messages": "" })))
    }

    /// Writes the lock of a shader as it is edited.
    fn accept(&mut self, path: &Path) -> RequestAnswer {
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

    fn start(&mut self, job: CommandJob) -> Result<(), ResponseError> {
        let CommandJob { id, title, mut options, file, shown, token } = job;
        let failed = |cause: std::io::Error| error(ErrorCode::RequestFailed, cause.to_string());
        let mut input = None;
        if let Some(file) = &file {
            options.extend(self.settings.defines.iter().map(|one| format!("--define={one}")));
            options.extend(self.settings.targets.iter().map(|one| format!("--target={one}")));
            // What is edited is not what the file holds.
            match self.documents.get(file) {
                Some(document) => {
                    input = Some(document.text.text().to_string());
                    options.push(format!("--stdin-filename={}", file.display()));
                    options.push("-".to_string());
                }
                None => options.push(file.display().to_string()),
            }
        }
        let mut command = Command::new(std::env::current_exe().map_err(failed)?);
        command.args(&options).current_dir(&self.current).env("NO_COLOR", "1");
        let stdin = if input.is_some() { Stdio::piped() } else { Stdio::null() };
        let child = command.stdin(stdin).stdout(Stdio::piped()).stderr(Stdio::piped());
        let child = child.spawn().map_err(failed)?;
        let stop = StopFlag::default();
        // The client's own token needs no leave; another has to be made.
        let has_token = token.is_some();
        let token = token.unwrap_or_else(|| json!(format!("landfall-command-{id}")));
        if !has_token && self.support.shows_progress {
            self.client.request("window/workDoneProgress/create", json!({ "token": token }));
        }
        let token = Some(token).filter(|_| has_token || self.support.shows_progress);
        let begin = json!({ "kind": "begin", "title": title, "cancellable": true });
        self.progress(token.as_ref(), begin);
        let running = RunningCommand { stop: stop.clone(), token };
        self.running_commands.insert(id.clone(), running);
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

    fn progress(&self, token: Option<&Value>, value: Value) {
        if let Some(token) = token {
            self.client.notify("$/progress", json!({ "token": token, "value": value }));
        }
    }

    /// Ends the command whose progress the client has cancelled.
    pub fn cancel_progress(&self, token: &Value) {
        let mut running = self.running_commands.values();
        if let Some(command) = running.find(|one| one.token.as_ref() == Some(token)) {
            command.stop.set();
        }
    }

    /// Answers the request of a command, and shows its result.
    pub fn finish_command(&mut self, result: CommandResult) {
        let CommandResult { id, title, shown, output, was_stopped } = result;
        let running = self.running_commands.remove(&id);
        let token = running.and_then(|command| command.token);
        self.progress(token.as_ref(), json!({ "kind": "end" }));
        let answer = match output {
            _ if was_stopped => Err(error(ErrorCode::RequestCanceled, "the command was cancelled")),
            Err(cause) => Err(error(ErrorCode::RequestFailed, cause)),
            // Findings are a result, too.
            Ok(output) if matches!(output.code, Some(0 | 1)) => {
                self.show_result(shown, &output);
                Ok(json!({ "code": output.code, "text": output.stdout, "messages": output.stderr }))
            }
            Ok(output) => {
                let message = format!("{title}: {}", output.stderr.trim());
                Err(error(ErrorCode::RequestFailed, message))
            }
        };
        self.client.respond(Response { id, response_result: answer });
    }

    fn show_result(&self, name: &str, output: &ProcessOutput) {
        let text = [output.stdout.as_str(), output.stderr.as_str()].concat();
        let Ok(path) = shown_file(name) else { return };
        if !self.support.shows_documents || std::fs::write(&path, &text).is_err() {
            self.client.show(MessageLevel::Info, text.trim());
            return;
        }
        self.show_file(&path, false);
    }

    /// Shows a file in the editor, or in the browser.
    fn show_file(&self, path: &Path, is_external: bool) {
        if self.support.shows_documents {
            let uri = crate::uris::uri(path);
            let params = json!({ "uri": uri, "external": is_external, "takeFocus": true });
            self.client.request("window/showDocument", params);
        } else {
            self.client.show(MessageLevel::Info, &format!("written to {}", path.display()));
        }
    }
}

/// The path of a file that is shown, in a directory of this process.
fn shown_file(name: &str) -> Result<PathBuf, ResponseError> {
    let folder = std::env::temp_dir().join(format!("landfall-lsp-{}", std::process::id()));
    std::fs::create_dir_all(&folder).map_err(|cause| {
        error(ErrorCode::RequestFailed, format!("`{}` cannot be made: {cause}", folder.display()))
    })?;
    Ok(folder.join(name))
}
