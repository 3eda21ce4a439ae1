//! A client of the Language Server Protocol: it writes and reads JSON, and answers what it is asked.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStdin, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::support::command::{Place, landfall};

/// The time within which any answer comes, on a machine that is busy.
const LIMIT: Duration = Duration::from_secs(120);

/// A client with a server of its own.
pub struct Client {
    process: Child,
    input: Option<ChildStdin>,
    messages: Receiver<Value>,
    next: u64,
    /// What the server has sent last of the findings in each file.
    pub findings: BTreeMap<String, Value>,
    /// Other notifications, and requests that the server sent.
    pub notes: Vec<Value>,
    pub asked: Vec<Value>,
    /// Whether requests of the server are answered.
    pub answers: bool,
    /// The answer to `initialize`.
    pub initialized: Value,
    folder: PathBuf,
}

impl Client {
    /// A client whose one folder is a place, and that can do what `capabilities` says.
    pub fn with(place: &Place, capabilities: Value) -> Client {
        let mut client = Client::started(place);
        let folder = client.folder.clone();
        let folders = json!([{ "uri": uri(&folder), "name": "folder" }]);
        client.initialize(json!({ "capabilities": capabilities, "workspaceFolders": folders }));
        client
    }

    pub fn new(place: &Place) -> Client {
        Client::with(place, json!({}))
    }

    /// A client that has not said `initialize`.
    pub fn started(place: &Place) -> Client {
        let folder = place.0.canonicalize().expect("the folder is there");
        let mut command = landfall(&["lsp"]);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::inherit());
        let mut process = command.spawn().expect("the command of this package");
        let mut output = BufReader::new(process.stdout.take().expect("it is piped"));
        let (sender, messages) = channel();
        std::thread::spawn(move || {
            while let Some(message) = read(&mut output) {
                if sender.send(message).is_err() {
                    return;
                }
            }
        });
        let input = process.stdin.take();
        Client {
            process,
            input,
            messages,
            next: 0,
            findings: BTreeMap::new(),
            notes: Vec::new(),
            asked: Vec::new(),
            answers: true,
            initialized: Value::Null,
            folder,
        }
    }

    pub fn initialize(&mut self, params: Value) {
        self.initialized = self.request("initialize", params).expect("it is answered");
        self.notify("initialized", json!({}));
    }

    pub fn uri(&self, file: &str) -> String {
        uri(&self.folder.join(file))
    }

    /// Sends bytes as they are.
    pub fn send_raw(&mut self, bytes: &[u8]) {
        let input = self.input.as_mut().expect("the server is running");
        input.write_all(bytes).expect("the server reads");
        input.flush().expect("the server reads");
    }

    pub fn send(&mut self, message: &Value) {
        let body = message.to_string();
        self.send_raw(format!("Content-Length: {}\r\n\r\n{body}", body.len()).as_bytes());
    }

    pub fn notify(&mut self, method: &str, params: Value) {
        self.send(&json!({ "jsonrpc": "2.0", "method": method, "params": params }));
    }

    /// Sends a request and returns its number.
    pub fn ask(&mut self, method: &str, params: Value) -> u64 {
        self.next += 1;
        let id = self.next;
        self.send(&json!({ "jsonrpc": "2.0", "id": id, "method": method, "params": params }));
        id
    }

    /// Sends a request and returns its result, or its error.
    pub fn request(&mut self, method: &str, params: Value) -> Result<Value, Value> {
        let id = self.ask(method, params);
        self.answer_to(id)
    }

    pub fn answer_to(&mut self, id: u64) -> Result<Value, Value> {
        loop {
            let message = self.receive(LIMIT).unwrap_or_else(|| panic!("no answer to {id}"));
            if message.get("method").is_none() && message["id"] == json!(id) {
                return match message.get("error") {
                    Some(error) => Err(error.clone()),
                    None => Ok(message["result"].clone()),
                };
            }
        }
    }

    /// Takes the next message; responses to others than the one waited for are lost.
    pub fn receive(&mut self, limit: Duration) -> Option<Value> {
        let message = match self.messages.recv_timeout(limit) {
            Ok(message) => message,
            Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => return None,
        };
        let method = message["method"].as_str().unwrap_or_default();
        if method == "textDocument/publishDiagnostics" {
            let params = &message["params"];
            let file = params["uri"].as_str().unwrap_or_default();
            self.findings.insert(file.to_string(), params.clone());
        } else if message.get("id").is_some() && !method.is_empty() {
            self.asked.push(message.clone());
            if self.answers {
                self.send(&json!({ "jsonrpc": "2.0", "id": message["id"], "result": null }));
            }
        } else if !method.is_empty() {
            self.notes.push(message.clone());
        }
        Some(message)
    }

    /// Takes messages until a condition holds.
    pub fn until(&mut self, what: &str, holds: impl Fn(&Client) -> bool) {
        let end = Instant::now() + LIMIT;
        while !holds(self) {
            let left = end.saturating_duration_since(Instant::now());
            self.receive(left).unwrap_or_else(|| panic!("{what}: {:#?}", self.findings));
        }
    }

    pub fn open(&mut self, file: &str, text: &str) {
        let document =
            json!({ "uri": self.uri(file), "languageId": "shader", "version": 1, "text": text });
        self.notify("textDocument/didOpen", json!({ "textDocument": document }));
    }

    /// Replaces the whole text of an open document.
    pub fn replace(&mut self, file: &str, version: u64, text: &str) {
        let document = json!({ "uri": self.uri(file), "version": version });
        let changes = json!([{ "text": text }]);
        self.notify(
            "textDocument/didChange",
            json!({ "textDocument": document, "contentChanges": changes }),
        );
    }

    pub fn document(&self, file: &str) -> Value {
        json!({ "uri": self.uri(file) })
    }

    /// The parameters of a request about the place where a piece of a text first stands.
    pub fn at(&self, file: &str, text: &str, piece: &str) -> Value {
        let before = &text[..text.find(piece).unwrap_or_else(|| panic!("no `{piece}`"))];
        let line = before.matches('\n').count();
        let start = before.rfind('\n').map_or(0, |end| end + 1);
        let character = before[start..].encode_utf16().count();
        json!({
            "textDocument": self.document(file),
            "position": { "line": line, "character": character },
        })
    }

    /// The inlay hints of a document: line, character and label.
    pub fn hints(&mut self, file: &str) -> Vec<(u64, u64, String)> {
        let range = json!({
            "start": { "line": 0, "character": 0 },
            "end": { "line": 1_000_000, "character": 0 },
        });
        let params = json!({ "textDocument": self.document(file), "range": range });
        let hints = self.request("textDocument/inlayHint", params).expect("it is answered");
        let hints = hints.as_array().cloned().unwrap_or_default();
        let hint = |hint: &Value| {
            let number = |key: &str| hint["position"][key].as_u64().expect("a number");
            let label = hint["label"].as_str().expect("a text").to_string();
            (number("line"), number("character"), label)
        };
        hints.iter().map(hint).collect()
    }

    /// The codes of the findings in a file, in order.
    pub fn codes(&self, file: &str) -> Vec<String> {
        let found = self.findings.get(&self.uri(file));
        let list = found.and_then(|found| found["diagnostics"].as_array()).cloned();
        let codes = list.unwrap_or_default();
        codes.iter().filter_map(|one| Some(one["code"].as_str()?.to_string())).collect()
    }

    /// Says `shutdown` and `exit`; the server's exit code.
    pub fn leave(mut self) -> i32 {
        self.request("shutdown", Value::Null).expect("it is answered");
        self.notify("exit", Value::Null);
        self.exit_code()
    }

    /// The exit code of a server that is to end by itself.
    pub fn exit_code(&mut self) -> i32 {
        let end = Instant::now() + LIMIT;
        loop {
            if let Some(status) = self.process.try_wait().expect("the process is ours") {
                return status.code().unwrap_or(-1);
            }
            assert!(Instant::now() < end, "the server does not end");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// Closes the server's input without a word.
    pub fn vanish(&mut self) {
        self.input = None;
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn uri(path: &std::path::Path) -> String {
    format!("file://{}", path.display())
}

fn read(output: &mut impl BufRead) -> Option<Value> {
    let mut length = 0;
    loop {
        let mut line = String::new();
        output.read_line(&mut line).ok().filter(|read| *read > 0)?;
        match line.trim_end() {
            "" => break,
            header => {
                if let Some(value) = header.strip_prefix("Content-Length: ") {
                    length = value.parse().expect("a length");
                }
            }
        }
    }
    let mut body = vec![0; length];
    output.read_exact(&mut body).ok()?;
    Some(serde_json::from_slice(&body).expect("messages are JSON"))
}
