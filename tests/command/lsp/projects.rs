//! Findings as one edits, configurations, locks, and several folders.

use serde_json::{Value, json};

use super::client::Client;
use crate::support::command::Place;

/// `vec3` elements are 16 bytes apart: the lint `vec3-array`, which is off unless asked for.
const ARRAY: &str = "#version 450\n\
    layout(std140, binding = 0) uniform Lights { vec3 at[4]; } lights;\n\
    layout(location = 0) out vec4 o;\n\
    void main() { o = vec4(lights.at[0], 1.0); }\n";

const CONFIGURATION: &str = "[levels]\nvec3-array = \"deny\"\n";

fn actions(client: &mut Client, file: &str, text: &str, piece: &str) -> Vec<Value> {
    let at = client.at(file, text, piece)["position"].clone();
    let params = json!({
        "textDocument": client.document(file),
        "range": { "start": at, "end": at },
        "context": { "diagnostics": [] },
    });
    let found = client.request("textDocument/codeAction", params).expect("it is answered");
    found.as_array().expect("a list").clone()
}

fn titled<'a>(actions: &'a [Value], title: &str) -> &'a Value {
    let is_it = |action: &&Value| action["title"].as_str() == Some(title);
    actions.iter().find(is_it).unwrap_or_else(|| panic!("{title}: {actions:#?}"))
}

#[test]
fn findings_follow_the_text_and_the_configuration() {
    let place = Place::new("lsp-findings");
    place.write("landfall.toml", CONFIGURATION).write("a.frag", ARRAY);
    let mut client = Client::new(&place);
    // Of a file that is not open.
    client.until("a finding", |client| client.codes("a.frag") == ["vec3-array"]);
    let found = &client.findings[&client.uri("a.frag")]["diagnostics"][0];
    assert_eq!((&found["severity"], &found["source"]), (&json!(1), &json!("landfall")));
    let start = client.at("a.frag", ARRAY, "at[4]")["position"].clone();
    assert_eq!(found["range"]["start"], start);

    client.open("a.frag", ARRAY);
    client.replace(
        "a.frag",
        2,
        &ARRAY.replace("vec3 at", "vec4 at").replace("vec4(lights.at[0], 1.0)", "lights.at[0]"),
    );
    client.until("none", |client| client.codes("a.frag").is_empty());
    client.replace("a.frag", 3, &ARRAY.replace("at[4]", "at[4"));
    client.until("an error", |client| client.codes("a.frag").contains(&"syntax".to_string()));
    // A document that is closed with changes counts as it was saved.
    client.notify("textDocument/didClose", json!({ "textDocument": client.document("a.frag") }));
    client.until("as saved", |client| client.codes("a.frag") == ["vec3-array"]);

    // While a configuration is broken, the last good one holds.
    client.open("landfall.toml", CONFIGURATION);
    client.replace("landfall.toml", 2, "[levels\n");
    client.until("a fault", |client| !client.codes("landfall.toml").is_empty());
    assert_eq!(client.codes("a.frag"), ["vec3-array"]);
    client.replace("landfall.toml", 3, "[levels]\nvec3-array = \"allow\"\n");
    client.until("mended", |client| {
        client.codes("landfall.toml").is_empty() && client.codes("a.frag").is_empty()
    });
    assert_eq!(place.read("landfall.toml"), CONFIGURATION, "nothing is written");
    assert_eq!(client.leave(), 0);
}

#[test]
fn a_finding_offers_its_fix_and_comments() {
    let place = Place::new("lsp-actions");
    place.write("landfall.toml", CONFIGURATION);
    let mut client = Client::new(&place);
    client.open("a.frag", ARRAY);
    client.until("a finding", |client| client.codes("a.frag") == ["vec3-array"]);
    let offered = actions(&mut client, "a.frag", ARRAY, "at[4]");
    let line = titled(&offered, "Allow `vec3-array` in this line");
    let edits = &line["edit"]["changes"][client.uri("a.frag")];
    assert_eq!(edits[0]["newText"], "// landfall: allow(vec3-array)\n", "{line}");
    assert_eq!(edits[0]["range"]["start"], json!({ "line": 1, "character": 0 }));
    titled(&offered, "Allow `vec3-array` in this file");
    let meaning = titled(&offered, "What `vec3-array` means");
    assert_eq!(meaning["command"]["command"], "landfall.rule");
    let allowed = format!("{}// landfall: allow(vec3-array)\n{}", &ARRAY[..13], &ARRAY[13..]);
    client.replace("a.frag", 2, &allowed);
    client.until("allowed", |client| client.codes("a.frag").is_empty());
}

#[test]
fn a_new_layout_is_accepted_into_the_lock() {
    let place = Place::new("lsp-accept");
    place.write("a.frag", ARRAY);
    assert_eq!(place.run(&["lock", "a.frag"]).code, 0);
    let lock = place.read("layouts/a.frag.json");
    let mut client = Client::new(&place);
    client.open("a.frag", ARRAY);
    let changed = ARRAY.replace("at[4]", "at[5]");
    client.replace("a.frag", 2, &changed);
    client.until("drift", |client| client.codes("a.frag").contains(&"layout-drift".to_string()));
    let found = client.findings[&client.uri("a.frag")]["diagnostics"].as_array().expect("a list");
    let found = found.iter().find(|one| one["code"] == "layout-drift").expect("the drift");
    let message = found["message"].as_str().expect("a text");
    // Elements of 16 bytes, four of them in the lock and five now.
    assert!(message.contains("0 64    vec3 at[4]"), "{message}");
    assert!(message.contains("0 80    vec3 at[5]"), "{message}");
    let offered = actions(&mut client, "a.frag", &changed, "Lights");
    let command = titled(&offered, "Accept the new layout: write the lock")["command"].clone();
    assert_eq!(place.read("layouts/a.frag.json"), lock, "nothing is written unasked");
    let params = json!({ "command": command["command"], "arguments": command["arguments"] });
    let done = client.request("workspace/executeCommand", params.clone()).expect("accepted");
    assert_eq!(done["written"], 1);
    client.until("no drift", |client| client.codes("a.frag").is_empty());
    place.write("a.frag", &changed);
    assert_eq!(place.run(&["check", "a.frag"]).code, 0, "the lock is that of the new layout");
    let again = client.request("workspace/executeCommand", params).expect_err("nothing to accept");
    assert!(again["message"].as_str().is_some_and(|text| text.starts_with("no lock was written")));
}

#[test]
fn each_folder_has_its_own_configuration() {
    let place = Place::new("lsp-folders");
    place.write("strict/landfall.toml", CONFIGURATION).write("strict/a.frag", ARRAY);
    place.write("lax/landfall.toml", "").write("lax/a.frag", ARRAY);
    let mut client = Client::started(&place);
    let folder = |name: &str| json!({ "uri": client.uri(name), "name": name });
    let folders = json!([folder("lax"), folder("strict")]);
    client.initialize(json!({ "capabilities": {}, "workspaceFolders": folders }));
    client.until("a finding", |client| client.codes("strict/a.frag") == ["vec3-array"]);
    client.open("lax/a.frag", ARRAY);
    client.open("strict/a.frag", ARRAY);
    assert!(!client.hints("lax/a.frag").is_empty());
    assert_eq!(client.codes("lax/a.frag"), [""; 0]);
    let gone = json!([{ "uri": client.uri("strict"), "name": "strict" }]);
    client.notify(
        "textDocument/didClose",
        json!({ "textDocument": client.document("strict/a.frag") }),
    );
    client.notify(
        "workspace/didChangeWorkspaceFolders",
        json!({ "event": { "added": [], "removed": gone } }),
    );
    client.until("the folder is gone", |client| client.codes("strict/a.frag").is_empty());
}

#[test]
fn an_unsaved_include_counts() {
    let place = Place::new("lsp-unsaved");
    place.write("light.glsl", "struct Light { vec3 color; };\n");
    let shader = "#version 450\n#include \"light.glsl\"\n\
        layout(std140, binding = 0) uniform Lights { Light one; } lights;\n\
        layout(location = 0) out vec4 o;\n\
        void main() { o = vec4(lights.one.glow, 1.0); }\n";
    place.write("a.frag", shader);
    let mut client = Client::new(&place);
    client.open("a.frag", shader);
    client.until("no such member", |client| client.codes("a.frag").len() == 1);
    client.open("light.glsl", "struct Light { vec3 glow; };\n");
    client.until("it has it", |client| client.codes("a.frag").is_empty());
    client
        .notify("textDocument/didClose", json!({ "textDocument": client.document("light.glsl") }));
    client.until("as it is saved", |client| client.codes("a.frag").len() == 1);
}

#[test]
fn odd_folders_and_files_end_nothing() {
    let place = Place::new("lsp-odd");
    place.write("landfall.toml", CONFIGURATION).write("a.frag", ARRAY);
    #[cfg(unix)]
    std::os::unix::fs::symlink(&place.0, place.0.join("circle")).expect("a link");
    place.write("layouts/b.frag.json", "{\"schema_version\": 9999, \"blocks\": []}");
    let mut client = Client::new(&place);
    client.until("a finding", |client| client.codes("a.frag").contains(&"vec3-array".to_string()));
    // A lock of a newer version is an error of its shader alone, where that declares its first block.
    place.write("b.frag", ARRAY);
    client.open("b.frag", ARRAY);
    let newer = "unreadable-lock".to_string();
    client.until("the lock", |client| client.codes("b.frag").contains(&newer));
    let found = client.findings[&client.uri("b.frag")]["diagnostics"].as_array().expect("a list");
    let found = found.iter().find(|one| one["code"] == "unreadable-lock").expect("the lock");
    assert_eq!(found["range"]["start"], client.at("b.frag", ARRAY, "Lights")["position"]);
    let lock = &found["relatedInformation"][0]["location"]["uri"];
    assert_eq!(*lock, json!(client.uri("layouts/b.frag.json")));
    // 50 MB: checked as it is saved, and nothing is told while it is edited.
    let huge = format!(
        "#version 450\n{}",
        "// a line of a long text, again and again\n".repeat(1_200_000)
    );
    client.open("huge.frag", &huge);
    assert!(client.hints("huge.frag").is_empty());
    client.notify("textDocument/didClose", json!({ "textDocument": client.document("huge.frag") }));
    assert_eq!(client.leave(), 0);
}
