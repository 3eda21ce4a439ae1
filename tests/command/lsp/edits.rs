//! Random edits: the server's text is always the client's, and nothing ends it.

use fastrand::Rng;
use serde_json::{Value, json};

use super::client::Client;
use crate::support::command::Place;
use crate::support::sample::{everything, seed};

const SHADER: &str = "#version 450\r\n// \u{1f4a1} lights é\r\n\
    struct Light { vec3 color; float power; };\r\n\
    layout(std140, binding = 0) uniform Lights { Light all[4]; int count; } lights;\n\
    layout(location = 0) out vec4 o;\n\
    void main() { o = vec4(lights.all[0].color, 1.0); }\n";

const PIECES: [&str; 14] = [
    "",
    "{",
    "}",
    ";",
    "vec3 x;",
    "/*",
    "*/",
    "\n",
    "\r\n",
    "\u{1f4a1}",
    "é",
    "#if 1\n",
    "[",
    "float",
];

/// A position before a byte, in units of UTF-16; lines end as the protocol says.
fn position(text: &str, at: usize) -> Value {
    let (mut line, mut start) = (0, 0);
    let bytes = text.as_bytes();
    for (index, byte) in bytes[..at].iter().enumerate() {
        if *byte == b'\n' || *byte == b'\r' && bytes.get(index + 1) != Some(&b'\n') {
            line += 1;
            start = index + 1;
        }
    }
    json!({ "line": line, "character": text[start..at].encode_utf16().count() })
}

fn boundary(text: &str, rng: &mut Rng) -> usize {
    let mut at = rng.usize(0..=text.len());
    while !text.is_char_boundary(at) || is_inside_line_end(text, at) {
        at -= 1;
    }
    at
}

/// Between `\r` and `\n`, where no position of the protocol is.
fn is_inside_line_end(text: &str, at: usize) -> bool {
    text[..at].ends_with('\r') && text[at..].starts_with('\n')
}

#[test]
fn the_text_is_that_of_the_client_after_random_edits() {
    let place = Place::new("lsp-edits");
    let mut client = Client::new(&place);
    let mut rng = Rng::with_seed(seed());
    let rounds = if everything() { 100_000 } else { 1_000 };
    let mut text = SHADER.to_string();
    client.open("a.frag", &text);
    for round in 2..rounds + 2 {
        if text.len() > 4000 || rng.usize(0..40) == 0 {
            text = SHADER.to_string();
            client.replace("a.frag", round, &text);
        }
        let (a, b) = (boundary(&text, &mut rng), boundary(&text, &mut rng));
        let (start, mut end) = (a.min(b), a.max(b));
        if end - start > 12 {
            end = start;
        }
        let new = PIECES[rng.usize(0..PIECES.len())];
        let range = json!({ "start": position(&text, start), "end": position(&text, end) });
        let document = json!({ "uri": client.uri("a.frag"), "version": round });
        client.notify(
            "textDocument/didChange",
            json!({ "textDocument": document, "contentChanges": [{ "range": range, "text": new }] }),
        );
        text.replace_range(start..end, new);
        if round % 100 == 0 {
            let edited = client.hints("a.frag");
            // A document that is opened with the client's text must be told the same.
            client.open("b.frag", &text);
            assert_eq!(client.hints("b.frag"), edited, "after {round} edits:\n{text}");
            client.notify(
                "textDocument/didClose",
                json!({ "textDocument": client.document("b.frag") }),
            );
        }
    }
    client.replace("a.frag", rounds + 2, SHADER);
    assert_eq!(client.hints("a.frag").len(), 6);
    let panics = client.notes.iter().filter(|note| note["method"] == "window/logMessage");
    assert_eq!(panics.count(), 0, "{:?}", client.notes);
    assert_eq!(client.leave(), 0);
}
