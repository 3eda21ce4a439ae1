//! The messages of the protocol on standard input and output.

use std::io::{self, BufRead, Read, Write};

use crossbeam_channel::{Receiver, Sender};
use lsp_server::{ErrorCode, Message};
use serde_json::json;

/// Bytes of the largest message that is read.
const LARGEST: usize = 256 << 20;

/// What the client has sent, and the answer to it.
pub enum SentMessage {
    Message(Message),
    /// What is wrong with something that is no message.
    Malformed(String),
}

/// Reads messages until the input ends or has lost its frame.
pub fn read(input: &mut impl BufRead, received: &Sender<SentMessage>) {
    while let Ok(Some(body)) = body(input) {
        let message = match serde_json::from_slice::<Message>(&body) {
            Ok(message) => SentMessage::Message(message),
            Err(cause) => SentMessage::Malformed(cause.to_string()),
        };
        let is_exit = matches!(&message, SentMessage::Message(Message::Notification(one)) if one.method == "exit");
        if received.send(message).is_err() || is_exit {
            return;
        }
    }
}

/// The bytes of one message; `None` at the end of the input.
fn body(input: &mut impl BufRead) -> io::Result<Option<Vec<u8>>> {
    let mut length: Option<usize> = None;
    loop {
        let mut line = String::new();
        if input.by_ref().take(1 << 16).read_line(&mut line)? == 0 {
            return Ok(None);
        }
        let line = line.trim_end_matches(['\r', '\n']);
        if line.is_empty() {
            match length {
                Some(length) => {
                    let mut body = Vec::new();
                    input.take(length as u64).read_to_end(&mut body)?;
                    return Ok((body.len() == length).then_some(body));
                }
                // Blank lines between messages.
                None => continue,
            }
        }
        if let Some((name, value)) = line.split_once(':') {
            if name.eq_ignore_ascii_case("content-length") {
                length = value.trim().parse().ok().filter(|length| *length <= LARGEST);
                if length.is_none() {
                    return Err(io::Error::new(io::ErrorKind::InvalidData, "too long"));
                }
            }
        }
    }
}

/// Writes messages until no more come.
pub fn write(output: &mut impl Write, to_send: &Receiver<SentMessage>) {
    for one in to_send {
        let written = match one {
            SentMessage::Message(message) => message.write(output),
            SentMessage::Malformed(cause) => write_malformed(output, &cause),
        };
        if written.is_err() {
            return;
        }
    }
}

/// The number of a response is `null` where that of the request is not known (JSON-RPC 2.0 §5).
fn write_malformed(output: &mut impl Write, cause: &str) -> io::Result<()> {
    let message = format!("this is no message of the protocol: {cause}");
    let error = json!({ "code": ErrorCode::ParseError as i32, "message": message });
    let body = json!({ "jsonrpc": "2.0", "id": null, "error": error }).to_string();
    write!(output, "Content-Length: {}\r\n\r\n{body}", body.len())?;
    output.flush()
}
