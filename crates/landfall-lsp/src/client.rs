//! What the client can do, and the messages to it.

use std::cell::Cell;

use crossbeam_channel::Sender;
use gen_lsp_types::PositionEncodingKind;
use lsp_server::{Message, Notification, Request, RequestId, Response};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::messages::SentMessage;
use crate::positions::PositionEncoding;

/// What the client says it can do.
#[derive(Clone, Copy, Debug, Default)]
pub struct ClientSupport {
    pub encoding: PositionEncoding,
    pub watches_files: bool,
    pub has_configuration: bool,
    pub registers_configuration: bool,
    pub refreshes_hints: bool,
    pub shows_documents: bool,
    pub shows_progress: bool,
    /// Edits of documents with their versions.
    pub document_changes: bool,
    /// Edits that create files.
    pub creates_files: bool,
}

impl ClientSupport {
    pub fn from_capabilities(capabilities: &Value) -> ClientSupport {
        let has = |path: &str| capabilities.pointer(path).and_then(Value::as_bool) == Some(true);
        let offered = capabilities.pointer("/general/positionEncodings");
        let offered = offered.and_then(|list| Vec::<PositionEncodingKind>::deserialize(list).ok());
        let operations = capabilities.pointer("/workspace/workspaceEdit/resourceOperations");
        let operations = operations.and_then(Value::as_array);
        ClientSupport {
            encoding: PositionEncoding::chosen(&offered.unwrap_or_default()),
            watches_files: has("/workspace/didChangeWatchedFiles/dynamicRegistration"),
            has_configuration: has("/workspace/configuration"),
            registers_configuration: has("/workspace/didChangeConfiguration/dynamicRegistration"),
            refreshes_hints: has("/workspace/inlayHint/refreshSupport"),
            shows_documents: has("/window/showDocument/support"),
            shows_progress: has("/window/workDoneProgress"),
            document_changes: has("/workspace/workspaceEdit/documentChanges"),
            // These are changes of documents, also where a client says no more, as Neovim does.
            creates_files: operations.is_some_and(|list| list.iter().any(|one| one == "create")),
        }
    }
}

/// The client, to which messages go.
#[derive(Clone)]
pub struct Client {
    sender: Sender<SentMessage>,
    next: Cell<i32>,
}

/// The severity of a message that a person reads.
#[derive(Clone, Copy)]
pub enum MessageLevel {
    Error = 1,
    Info = 3,
}

impl Client {
    pub fn new(sender: Sender<SentMessage>) -> Client {
        Client { sender, next: Cell::new(0) }
    }

    /// Sends a message; a client that has left is noticed where its messages are read.
    fn send(&self, message: impl Into<Message>) {
        let _ = self.sender.send(SentMessage::Message(message.into()));
    }

    pub fn respond(&self, response: Response) {
        self.send(response);
    }

    pub fn malformed(&self, cause: &str) {
        let _ = self.sender.send(SentMessage::Malformed(cause.to_string()));
    }

    pub fn notify(&self, method: &str, params: impl Serialize) {
        self.send(Notification::new(method.to_string(), params));
    }

    /// Asks the client; its answer comes with that number.
    pub fn request(&self, method: &str, params: impl Serialize) -> RequestId {
        self.next.set(self.next.get() + 1);
        let id = RequestId::from(format!("landfall-{}", self.next.get()));
        self.send(Request::new(id.clone(), method.to_string(), params));
        id
    }

    pub fn show(&self, level: MessageLevel, text: &str) {
        self.notify("window/showMessage", json!({ "type": level as i32, "message": text }));
    }

    pub fn log(&self, text: &str) {
        self.notify("window/logMessage", json!({ "type": 1, "message": text }));
    }
}
