//! Inlay hints against `layout --format json`, and against the bytes of the whole block.

use std::collections::BTreeMap;

use landfall_layout::format::phrases;
use serde_json::{Value, json};

use super::client::Client;
use crate::support::blocks::print;
use crate::support::command::Place;
use crate::support::generate::{COMMON, VULKAN, random};
use crate::support::sample::{everything, sample, seed};

/// Numbers that a hint tells of a member.
#[derive(Debug, Default, PartialEq)]
struct Told {
    offset: u64,
    /// `None` if runtime-sized.
    size: Option<u64>,
    before: u64,
    after: u64,
}

/// The numbers in the label of a member, for each of its places.
fn told(label: &str) -> Vec<Told> {
    let place = |text: &str| {
        let mut told = Told::default();
        for part in text.split(", ") {
            let number = |text: &str| text.replace(',', "").parse::<u64>().ok();
            if let Some(offset) = part.rsplit_once('@').and_then(|(_, text)| number(text)) {
                told.offset = offset;
            } else if let Some(padding) = part.strip_suffix(" padding before") {
                // Behind the rules, where several are told.
                told.before = padding.rsplit(' ').next().and_then(number).expect("a number");
            } else if let Some(padding) = part.strip_suffix(" padding") {
                told.after = number(padding.trim_start_matches('+')).expect("a number");
            } else if let Some((bytes, "byte" | "bytes")) = part.split_once(' ') {
                told.size = number(bytes);
            }
        }
        told
    };
    label.split(" · ").map(place).collect()
}

fn all_hints() -> Value {
    json!({ "inlayHints": { "offsets": true, "sizes": true, "padding": true, "blocks": true } })
}

fn client(place: &Place) -> Client {
    let mut client = Client::started(place);
    client.initialize(json!({
        "capabilities": {},
        "workspaceFolders": [{ "uri": client.uri(""), "name": "folder" }],
        "initializationOptions": all_hints(),
    }));
    client
}

/// Holds the hints of a shader against its layout; the number of blocks.
fn compare(client: &mut Client, place: &Place, file: &str, text: &str) -> usize {
    let printed = place.run(&["layout", file, "--format", "json"]);
    assert_eq!(printed.code, 0, "{file}: {}", printed.err);
    let layout: Value = serde_json::from_str(&printed.out).expect("JSON");
    client.open(file, text);
    let hints = client.hints(file);
    let mut by_line: BTreeMap<u64, Vec<(u64, Vec<Told>)>> = BTreeMap::new();
    for (line, character, label) in &hints {
        if label.contains('@') {
            by_line.entry(*line).or_default().push((*character, told(label)));
        }
    }
    let blocks = layout["shaders"][0]["blocks"].as_array().expect("a list").clone();
    for block in &blocks {
        // A variable of WGSL whose type has no members is block and member in one.
        let is_variable = block["members"][0]["span"] == block["span"];
        if !is_variable {
            members(&block["members"], &by_line, file);
        }
        if let Some(size) = block["size"].as_u64() {
            covers(&block["members"], size, &by_line, file);
        }
    }
    hovers(client, file, &blocks);
    client.notify("textDocument/didClose", json!({ "textDocument": client.document(file) }));
    blocks.len()
}

/// Holds hovers over members against their layout: each, or one in seven.
fn hovers(client: &mut Client, file: &str, blocks: &[Value]) {
    let mut waiting: Vec<&Value> = blocks.iter().filter_map(|block| block.get("members")).collect();
    let mut number = 0;
    while let Some(list) = waiting.pop() {
        for member in list.as_array().into_iter().flatten() {
            waiting.extend(member.get("members"));
            let (Some(offset), None) = (member["offset"].as_u64(), member["span"].get("path"))
            else {
                continue;
            };
            number += 1;
            if !everything() && number % 7 != 0 {
                continue;
            }
            let at = |key: &str| member["span"][key].as_u64().expect("a number") - 1;
            let position = json!({ "line": at("line"), "character": at("column") });
            let params = json!({ "textDocument": client.document(file), "position": position });
            let hover = client.request("textDocument/hover", params).expect("it is answered");
            let text = hover["contents"]["value"].as_str().unwrap_or_default();
            let size = match member["size"].as_u64() {
                Some(size) => phrases::bytes(size),
                None => "runtime-sized".to_string(),
            };
            // A variable of WGSL without members is told as a block.
            let is_told = text.contains(&format!("offset **{offset}**")) && text.contains(&size);
            let is_block =
                file.ends_with(".wgsl") && text.contains("**, ") && !text.contains("offset **");
            assert!(is_told || is_block, "{file}: {member}:\n{text}");
        }
    }
}

/// The places that the hint behind a member's name tells.
fn of_member<'h>(
    member: &Value,
    by_line: &'h BTreeMap<u64, Vec<(u64, Vec<Told>)>>,
) -> Option<&'h [Told]> {
    let number = |key: &str| member["span"][key].as_u64().expect("a number");
    let is_here = member["span"].get("path").is_none();
    let behind = by_line.get(&(number("line") - 1)).filter(|_| is_here)?.iter();
    // The first behind the name; the texts here have no character beyond ASCII.
    let next = behind.filter(|(character, _)| *character >= number("column"));
    next.min_by_key(|(character, _)| *character).map(|(_, told)| told.as_slice())
}

fn members(list: &Value, by_line: &BTreeMap<u64, Vec<(u64, Vec<Told>)>>, file: &str) {
    for member in list.as_array().into_iter().flatten() {
        let Some(offset) = member["offset"].as_u64() else { continue };
        // Of an include, which is another document.
        if member["span"].get("path").is_some() {
            continue;
        }
        let places =
            of_member(member, by_line).unwrap_or_else(|| panic!("{file}: no hint: {member}"));
        let is_told =
            |place: &Told| (place.offset, place.size) == (offset, member["size"].as_u64());
        assert!(places.iter().any(is_told), "{file}: {places:?}: {member}");
        members(&member["members"], by_line, file);
    }
}

/// The members of a block with the holes beside them cover it, each byte once.
fn covers(list: &Value, size: u64, by_line: &BTreeMap<u64, Vec<(u64, Vec<Told>)>>, file: &str) {
    let list = list.as_array().expect("a list");
    let places: Option<Vec<&Told>> = list
        .iter()
        .map(|member| match of_member(member, by_line)? {
            [one] => Some(one),
            // Of several places it is not told which is that of this block.
            _ => None,
        })
        .collect();
    let Some(mut places) = places else { return };
    places.sort_by_key(|one| one.offset);
    let mut end = 0;
    for place in places {
        assert_eq!(place.offset, end + place.before, "{file}: {list:?}");
        let Some(bytes) = place.size else { return };
        end = place.offset + bytes + place.after;
    }
    assert_eq!(end, size, "{file}: {list:?}");
}

#[test]
fn hints_of_the_shaders_here_are_those_of_layout() {
    let place = Place::new("lsp-hints");
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut folders = vec![root.join("shaders")];
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder").map(|one| one.expect("an entry"))
        {
            let path = entry.path();
            match path.is_dir() {
                true => folders.push(path),
                false => files.push(path),
            }
        }
    }
    files.sort();
    let mut blocks = 0;
    let mut shaders = Vec::new();
    for path in &files {
        let file = path.strip_prefix(root).expect("below").display().to_string();
        let text = std::fs::read(path).expect("readable");
        place.write(&file, &text);
        if file.ends_with(".frag") || file.ends_with(".vert") || file.ends_with(".wgsl") {
            shaders.push((file, String::from_utf8(text).expect("UTF-8")));
        }
    }
    let mut client = client(&place);
    for (file, text) in &shaders {
        if text.is_ascii() && place.run(&["layout", file]).code == 0 {
            blocks += compare(&mut client, &place, file, text);
        }
    }
    assert!(blocks > 40, "{blocks} blocks");
}

#[test]
fn hints_of_random_blocks_are_those_of_layout() {
    let place = Place::new("lsp-random-hints");
    let mut client = client(&place);
    for number in sample(0..200, 10) {
        let diet = if number % 2 == 0 { &COMMON } else { &VULKAN };
        let (standing, blocks) = random(seed() + number, 1, diet);
        let text = print(&standing, &blocks.iter().collect::<Vec<_>>());
        let file = format!("random{number}.comp");
        place.write(&file, &text);
        compare(&mut client, &place, &file, &text);
    }
}

#[test]
fn each_kind_of_hint_can_be_switched_off() {
    let place = Place::new("lsp-switches");
    let text = "#version 450\nlayout(std140) uniform B { vec3 a; vec2 b[2]; } u;\nvoid main() {}\n";
    let labels = |settings: Value| {
        let mut client = Client::started(&place);
        client.initialize(json!({
            "capabilities": {},
            "initializationOptions": { "inlayHints": settings },
        }));
        client.open("a.frag", text);
        client.hints("a.frag").into_iter().map(|(_, _, label)| label).collect::<Vec<_>>()
    };
    // std140: `b` is aligned to 16 and its elements are 16 apart.
    assert_eq!(
        labels(json!({})),
        ["48 bytes, 20 of them padding, std140", "@0, +4 padding", "@16"]
    );
    let off = json!({ "offsets": false, "padding": false, "blocks": false });
    assert_eq!(labels(off), [""; 0]);
    let strides = json!({ "offsets": false, "padding": false, "blocks": false, "strides": true });
    assert_eq!(labels(strides), ["stride 16"]);
}

#[test]
fn a_structure_under_two_rules_shows_both() {
    let place = Place::new("lsp-two-rules");
    let text = "#version 450\n\
        struct S { float a[2]; float b; };\n\
        layout(std140, binding = 0) uniform U { S s; } u;\n\
        layout(std430, binding = 1) buffer B { S s; } b;\n\
        void main() {}\n";
    let mut client = Client::new(&place);
    client.open("a.frag", text);
    let labels: Vec<String> =
        client.hints("a.frag").into_iter().filter(|hint| hint.0 == 1).map(|hint| hint.2).collect();
    // By the rules of OpenGL 4.6 §7.6.2.2: under std140 elements are 16 apart, under std430 4.
    assert_eq!(
        labels,
        [
            "std140: 48 bytes, 36 of them padding · std430: 12 bytes",
            "@0",
            "std140: @32, +12 padding · std430: @8"
        ]
    );
}

#[test]
fn an_include_shows_what_its_shaders_give_it() {
    let place = Place::new("lsp-include-hints");
    let include = "struct Light { vec3 color; float power; vec2 at; };\n";
    let shader = "#version 450\n#include \"light.glsl\"\n\
        layout(std140) uniform Lights { Light all[4]; } u;\nvoid main() {}\n";
    place.write("light.glsl", include).write("a.frag", shader);
    let mut client = Client::new(&place);
    client.open("light.glsl", include);
    // Once the shaders that include it are known.
    let end = std::time::Instant::now() + std::time::Duration::from_secs(60);
    let expected = ["32 bytes, 8 of them padding", "@0", "@12", "@16, +8 padding"];
    loop {
        let labels: Vec<String> =
            client.hints("light.glsl").into_iter().map(|hint| hint.2).collect();
        if labels == expected {
            break;
        }
        assert!(labels.is_empty() && std::time::Instant::now() < end, "{labels:?}");
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    // The include as it is edited, not as it is saved.
    client.replace("light.glsl", 2, "struct Light { vec2 at; };\n");
    client.open("a.frag", shader);
    let labels: Vec<String> = client.hints("a.frag").into_iter().map(|hint| hint.2).collect();
    assert_eq!(labels, ["64 bytes, 32 of them padding, std140", "@0"]);
}
