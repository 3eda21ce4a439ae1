//! The life of a session, and messages that are not those of the protocol.

use std::time::Duration;

use serde_json::{Value, json};

use super::client::Client;
use crate::support::command::Place;

const SHADER: &str = "#version 450\n\
    layout(std140, binding = 0) uniform Lights { vec3 color; float power; } lights;\n\
    layout(location = 0) out vec4 o;\n\
    void main() { o = vec4(lights.color * lights.power, 1.0); }\n";

#[test]
fn a_session_begins_and_ends_as_the_protocol_says() {
    let place = Place::new("lsp-session");
    let mut early = Client::started(&place);
    let refused = early.request("textDocument/hover", json!({})).unwrap_err();
    assert_eq!(refused["code"], -32002, "ServerNotInitialized");
    early.initialize(json!({ "capabilities": {}, "rootUri": null }));
    let twice = early.request("initialize", json!({ "capabilities": {} })).unwrap_err();
    assert_eq!(twice["code"], -32600, "InvalidRequest");
    let unknown = early.request("textDocument/nonsense", json!({})).unwrap_err();
    assert_eq!(unknown["code"], -32601, "MethodNotFound");
    let wrong = early.request("textDocument/hover", json!({ "position": 3 })).unwrap_err();
    assert_eq!(wrong["code"], -32602, "InvalidParams");
    assert_eq!(early.request("shutdown", Value::Null), Ok(Value::Null));
    let after = early.request("textDocument/hover", json!({})).unwrap_err();
    assert_eq!(after["code"], -32600, "InvalidRequest");
    early.notify("exit", Value::Null);
    assert_eq!(early.exit_code(), 0);

    let mut hasty = Client::new(&place);
    hasty.notify("exit", Value::Null);
    assert_eq!(hasty.exit_code(), 1, "without shutdown");
    let mut gone = Client::new(&place);
    gone.vanish();
    assert_eq!(gone.exit_code(), 1, "the client has gone");
}

#[test]
fn positions_are_counted_as_the_client_asks() {
    let place = Place::new("lsp-encodings");
    for (offered, chosen) in [
        (json!(["utf-16", "utf-8"]), "utf-8"),
        (json!(["utf-32", "utf-16"]), "utf-32"),
        (json!(["utf-16"]), "utf-16"),
        (Value::Null, "utf-16"),
    ] {
        let client = Client::with(&place, json!({ "general": { "positionEncodings": offered } }));
        assert_eq!(client.initialized["capabilities"]["positionEncoding"], chosen);
    }
}

#[test]
fn what_is_no_message_is_answered_and_harms_nothing() {
    let place = Place::new("lsp-malformed");
    place.write("a.frag", SHADER);
    let mut client = Client::new(&place);
    client.open("a.frag", SHADER);
    for body in ["{", "[]", "{\"jsonrpc\":\"2.0\"}", "\"text\""] {
        client.send_raw(format!("Content-Length: {}\r\n\r\n{body}", body.len()).as_bytes());
        let answer = loop {
            let message = client.receive(Duration::from_secs(60)).expect("an answer");
            if message.get("error").is_some() {
                break message;
            }
        };
        assert_eq!(answer["id"], Value::Null, "{body}");
        assert_eq!(answer["error"]["code"], -32700, "{body}");
    }
    // A client may send more headers, in any order and case.
    let body = json!({ "jsonrpc": "2.0", "id": 99, "method": "shutdown" }).to_string();
    let length = body.len();
    let header = "Content-Type: application/vscode-jsonrpc; charset=utf-8";
    client.send_raw(format!("{header}\r\ncontent-length: {length}\r\n\r\n{body}").as_bytes());
    assert_eq!(client.answer_to(99), Ok(Value::Null));
}

#[test]
fn a_request_that_waits_can_be_cancelled() {
    let place = Place::new("lsp-cancelled");
    place.write("a.frag", SHADER);
    let mut client = Client::new(&place);
    client.open("a.frag", SHADER);
    // In one piece, so that all wait when the first is taken.
    let message = |value: Value| {
        let body = value.to_string();
        format!("Content-Length: {}\r\n\r\n{body}", body.len())
    };
    let request = |id: u64| {
        let params = client.at("a.frag", SHADER, "color");
        message(
            json!({ "jsonrpc": "2.0", "id": id, "method": "textDocument/hover", "params": params }),
        )
    };
    let cancel = json!({ "jsonrpc": "2.0", "method": "$/cancelRequest", "params": { "id": 702 } });
    let all = [request(700), request(701), request(702), message(cancel), request(703)].concat();
    client.send_raw(all.as_bytes());
    let mut answers = std::collections::BTreeMap::new();
    while answers.len() < 4 {
        let answer = client.receive(Duration::from_secs(60)).expect("each is answered");
        if let Some(id @ 700..) = answer["id"].as_u64() {
            answers.insert(id, answer);
        }
    }
    for id in [700, 701, 703] {
        assert!(answers[&id].get("result").is_some(), "{}", answers[&id]);
    }
    // It waits, unless the machine was so slow that it was answered before the rest was read.
    let cancelled = &answers[&702];
    assert!(
        cancelled.get("result").is_some() || cancelled["error"]["code"] == -32800,
        "{cancelled}"
    );
}

#[test]
fn a_client_that_never_answers_is_answered() {
    let place = Place::new("lsp-silent");
    place.write("a.frag", SHADER);
    let everything = json!({
        "workspace": {
            "configuration": true,
            "didChangeWatchedFiles": { "dynamicRegistration": true },
            "inlayHint": { "refreshSupport": true },
        },
        "window": { "workDoneProgress": true, "showDocument": { "support": true } },
    });
    let mut client = Client::started(&place);
    client.answers = false;
    client.initialize(json!({
        "capabilities": everything,
        "workspaceFolders": [{ "uri": client.uri(""), "name": "folder" }],
    }));
    client.open("a.frag", SHADER);
    assert!(!client.hints("a.frag").is_empty());
    let rule = json!({ "command": "landfall.rule", "arguments": ["vec3-array"] });
    let answer = client.request("workspace/executeCommand", rule).expect("it is answered");
    assert!(answer["text"].as_str().is_some_and(|text| text.contains("vec3")), "{answer}");
    let methods: Vec<&str> = client.asked.iter().filter_map(|one| one["method"].as_str()).collect();
    assert!(methods.contains(&"workspace/configuration"), "{methods:?}");
    assert_eq!(client.leave(), 0);
}

#[test]
fn positions_past_an_end_are_answered() {
    let place = Place::new("lsp-past-end");
    let mut client = Client::new(&place);
    client.open("a.frag", SHADER);
    for (line, character) in [(0, 5000), (5000, 0), (u32::MAX, u32::MAX)] {
        let position = json!({ "line": line, "character": character });
        let params = json!({ "textDocument": client.document("a.frag"), "position": position });
        for method in ["hover", "definition", "implementation", "declaration"] {
            let answer = client.request(&format!("textDocument/{method}"), params.clone());
            let empty =
                answer.as_ref().is_ok_and(|found| *found == Value::Null || *found == json!([]));
            assert!(empty, "{method}: {answer:?}");
        }
        let range = json!({ "start": position, "end": position });
        let context = json!({ "diagnostics": [] });
        let params = json!({
            "textDocument": client.document("a.frag"), "range": range, "context": context,
        });
        assert!(client.request("textDocument/codeAction", params).is_ok());
    }
    // A document that is not open has nothing to tell.
    let params = client.at("b.frag", SHADER, "color");
    assert_eq!(client.request("textDocument/hover", params), Ok(Value::Null));
}
