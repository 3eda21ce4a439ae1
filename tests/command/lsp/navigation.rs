//! From names to declarations, uses and Rust fields; renames.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::client::Client;
use crate::support::command::Place;

const INCLUDE: &str = "struct PointLight {\n    vec3 pos;\n    vec3 color; // \u{1f4a1} tint\n};\n";

const SHADER: &str = "#version 450\n\
    #include \"lights.glsl\"\n\
    struct Sun { vec3 color; };\n\
    struct Local { vec3 color; };\n\
    layout(std140, binding = 0) uniform Lights { PointLight data[4]; Sun sun; } lights;\n\
    layout(location = 0) out vec4 o;\n\
    void main() {\n\
        PointLight first = lights.data[0]; Local local = Local(vec3(1.0));\n\
        vec3 sum = first.color + lights.data[1].color + lights.sun.color + local.color;\n\
        o = vec4(sum, 1.0);\n\
    }\n";

/// Declares the block for itself, as the other stage of a program does.
const OTHER_STAGE: &str = "#version 450\n\
    struct PointLight { vec3 pos; vec3 color; };\n\
    struct Sun { vec3 color; };\n\
    layout(std140, binding = 0) uniform Lights { PointLight data[4]; Sun sun; } lit;\n\
    void main() { gl_Position = vec4(lit.data[0].color, 1.0); }\n";

const RUST: &str = "// landfall: mirror(PointLight)\n#[repr(C)]\nstruct PointLight {\n    \
    pos: [f32; 4],\n    color: [f32; 4],\n}\n";

fn project(name: &str) -> Place {
    let place = Place::new(name);
    place.write("lights.glsl", INCLUDE).write("a.frag", SHADER).write("a.vert", OTHER_STAGE);
    place.write("src/lights.rs", RUST);
    place
}

/// A client that waits until all shaders are checked, which a finding of this file tells.
fn checked(place: &Place) -> Client {
    // The include alone: `PointLight` is a structure that no block has.
    place.write("broken.frag", "#version 450\nuniform B { nonsense x; };\n");
    let mut client = Client::new(place);
    client.until("all are checked", |client| !client.codes("broken.frag").is_empty());
    client
}

/// The pieces of text at locations, with their files.
fn pieces(place: &Place, locations: &Value) -> Vec<(String, String)> {
    let list = locations.as_array().expect("a list");
    let piece = |location: &Value| {
        let uri = location["uri"].as_str().expect("an address");
        let file = uri.rsplit_once("/lsp-").and_then(|(_, rest)| rest.split_once('/'));
        let file = file.expect("below the folder").1.to_string();
        (file.clone(), slice(&place.read(&file), &location["range"]))
    };
    list.iter().map(piece).collect()
}

fn slice(text: &str, range: &Value) -> String {
    let byte = |position: &Value| {
        let line = position["line"].as_u64().expect("a line") as usize;
        let start: usize = text.split_inclusive('\n').take(line).map(str::len).sum();
        let mut units = position["character"].as_u64().expect("a column") as usize;
        let mut at = start;
        for c in text[start..].chars() {
            if units == 0 {
                break;
            }
            units -= c.len_utf16();
            at += c.len_utf8();
        }
        at
    };
    text[byte(&range["start"])..byte(&range["end"])].to_string()
}

/// The texts after a workspace edit.
fn edited(place: &Place, edit: &Value) -> BTreeMap<String, String> {
    let mut files = BTreeMap::new();
    for (uri, edits) in edit["changes"].as_object().expect("changes by file") {
        let file = uri.rsplit_once("/lsp-").and_then(|(_, rest)| rest.split_once('/'));
        let file = file.expect("below the folder").1.to_string();
        let text = place.read(&file);
        let mut lines: Vec<Vec<u16>> =
            text.split_inclusive('\n').map(|line| line.encode_utf16().collect()).collect();
        let mut edits = edits.as_array().expect("a list").clone();
        let start = |edit: &Value| {
            let number = |key: &str| edit["range"]["start"][key].as_u64().expect("a number");
            (number("line"), number("character"))
        };
        edits.sort_by_key(|edit| std::cmp::Reverse(start(edit)));
        for edit in &edits {
            let (line, from) = start(edit);
            let to = edit["range"]["end"]["character"].as_u64().expect("a number") as usize;
            let new = edit["newText"].as_str().expect("a text").encode_utf16();
            lines[line as usize].splice(from as usize..to, new);
        }
        let text = lines.iter().map(|line| String::from_utf16(line).expect("text")).collect();
        files.insert(file, text);
    }
    files
}

#[test]
fn names_lead_to_their_declarations() {
    let place = project("lsp-definition");
    let mut client = checked(&place);
    client.open("a.frag", SHADER);
    let mut definition = |piece: &str, skip: u64| {
        let mut at = client.at("a.frag", SHADER, piece);
        let character = at["position"]["character"].as_u64().expect("a number") + skip;
        at["position"]["character"] = json!(character);
        let found = client.request("textDocument/definition", at).expect("it is answered");
        pieces(&place, &found)
    };
    let file = |file: &str, name: &str| (file.to_string(), name.to_string());
    assert_eq!(definition("first.color", 6), [file("lights.glsl", "color")]);
    assert_eq!(definition("[1].color", 4), [file("lights.glsl", "color")]);
    assert_eq!(definition("sun.color", 4), [file("a.frag", "color")]);
    assert_eq!(definition("local.color", 6), [], "no block has it");
    assert_eq!(definition("PointLight data", 0), [file("lights.glsl", "PointLight")]);
    assert_eq!(definition("\"lights.glsl\"", 3), [file("lights.glsl", "")], "the include");
}

#[test]
fn references_are_the_uses_in_all_shaders_with_the_declaration() {
    let place = project("lsp-references");
    let mut client = checked(&place);
    client.open("lights.glsl", INCLUDE);
    let mut at = client.at("lights.glsl", INCLUDE, "color");
    at["context"] = json!({ "includeDeclaration": true });
    let found = client.request("textDocument/references", at).expect("it is answered");
    let mut files: Vec<String> = pieces(&place, &found).into_iter().map(|(file, _)| file).collect();
    files.sort();
    // `first.color` and `lights.data[1].color`; not those of `Sun` and `Local`.
    assert_eq!(files, ["a.frag", "a.frag", "lights.glsl"]);
}

#[test]
fn a_member_leads_to_the_field_that_feeds_it_and_back() {
    let place = project("lsp-fields");
    let mut client = checked(&place);
    client.open("a.frag", SHADER);
    let mut at = client.at("a.frag", SHADER, "first.color");
    at["position"]["character"] =
        json!(at["position"]["character"].as_u64().expect("a number") + 6);
    let hover = client.request("textDocument/hover", at.clone()).expect("it is answered");
    let hover = hover["contents"]["value"].as_str().expect("text").to_string();
    // By std140 a `vec3` is aligned to 16.
    for told in ["offset **16**", "`PointLight.color: [f32; 4]`", "byte 16", "src/lights.rs:5"] {
        assert!(hover.contains(told), "{told}: {hover}");
    }
    let field = client.request("textDocument/implementation", at).expect("it is answered");
    assert_eq!(pieces(&place, &field), [("src/lights.rs".to_string(), "color".to_string())]);
    let at = client.at("src/lights.rs", RUST, "color");
    let member = client.request("textDocument/declaration", at).expect("it is answered");
    let found = pieces(&place, &member);
    assert!(found.contains(&("lights.glsl".to_string(), "color".to_string())), "{found:?}");
}

#[test]
fn a_block_shows_its_bytes_and_those_of_its_lock() {
    let place = Place::new("lsp-block-hover");
    let shader = "#version 450\n\
        layout(std140, binding = 0) uniform Sun { vec3 way; vec3 color; } sun;\n\
        layout(location = 0) out vec4 o;\n\
        void main() { o = vec4(sun.color + sun.way, 1.0); }\n";
    place.write("a.frag", shader);
    assert_eq!(place.run(&["lock", "a.frag"]).code, 0);
    let changed = shader.replace("vec3 way;", "vec3 way; vec4 tint;");
    let mut client = Client::new(&place);
    client.open("a.frag", &changed);
    let at = client.at("a.frag", &changed, "Sun {");
    let hover = client.request("textDocument/hover", at).expect("it is answered");
    let text = hover["contents"]["value"].as_str().expect("text");
    // std140: `color` was at 16, and is behind the 16 bytes of `tint` now.
    let (now, locked) = text.split_once("In the lock:").expect("both maps");
    assert!(now.contains("   32  color.x") && locked.contains("   16  color.x"), "{text}");
    let at = client.at("a.frag", &changed, "main");
    let hover = client.request("textDocument/hover", at).expect("it is answered");
    assert_eq!(hover["contents"]["value"], "`main`: nothing was found in it");
}

#[test]
fn a_function_shows_the_lights_that_it_reads() {
    let place = Place::new("lsp-function-hover");
    let shader = "#version 450\n\
        struct PointLight { vec3 position; float range; vec3 color; float intensity; };\n\
        struct SpotLight { vec3 position; vec3 direction; vec3 color; float outerCone; };\n\
        layout(std140, binding = 0) uniform Lights { PointLight points[8]; int pointCount; } lights;\n\
        layout(std140, binding = 1) uniform Spots { SpotLight spot; };\n\
        layout(location = 0) in vec3 p;\n\
        layout(location = 0) out vec4 o;\n\
        vec3 lit(PointLight light) { return light.color * light.intensity; }\n\
        vec3 cone() { return spot.color; }\n\
        float plain(float a) { return a + 1.0; }\n\
        void main() {\n\
          vec3 sum = cone();\n\
          for (int i = 0; i < lights.pointCount; i++) { sum += lit(lights.points[i]); }\n\
          o = vec4(sum * plain(1.0), 1.0);\n\
        }\n";
    place.write("a.frag", shader);
    let mut client = Client::new(&place);
    client.open("a.frag", shader);
    let mut hover = |piece: &str| {
        let at = client.at("a.frag", shader, piece);
        let hover = client.request("textDocument/hover", at).expect("it is answered");
        hover["contents"]["value"].as_str().expect("text").to_string()
    };
    let main = hover("main()");
    // std140: `position` and `range` in 16 bytes, `color` and `intensity` in 16 more.
    for told in ["point", "32", "PointLight points[]", "count: pointCount of Lights at byte 256"] {
        assert!(main.contains(told), "{told}: {main}");
    }
    assert!(main.contains("loop to the count, not clamped to the array"), "{main}");
    assert!(!main.contains("SpotLight"), "it reads no spot light: {main}");
    assert!(main.contains("(`loop-past-count`)") || main.contains("(`unclamped-count`)"), "{main}");
    let lit = hover("lit(PointLight");
    assert!(lit.contains("PointLight points[]") && !lit.contains("index:"), "{lit}");
    let cone = hover("cone() {");
    for told in ["SpotLight spot", "outer cone", "direction"] {
        assert!(cone.contains(told), "{told}: {cone}");
    }
    assert!(!cone.contains("PointLight"), "{cone}");
    assert_eq!(hover("plain(float"), "`plain`: nothing was found in it");
}

#[test]
fn a_member_is_renamed_in_every_shader_that_has_it() {
    let place = project("lsp-rename");
    let mut client = checked(&place);
    client.open("lights.glsl", INCLUDE);
    let mut at = client.at("lights.glsl", INCLUDE, "color");
    for (new, refusal) in [
        ("pos", "`lights.glsl` has the name `pos` already"),
        ("gl_Color", "`gl_Color` is a reserved name"),
    ] {
        at["newName"] = json!(new);
        let error = client.request("textDocument/rename", at.clone()).expect_err("refused");
        assert_eq!(error["message"], refusal);
    }
    at["newName"] = json!("tint2");
    let edit = client.request("textDocument/rename", at).expect("it is renamed");
    let files = edited(&place, &edit);
    let expected = [
        ("a.frag", SHADER.replace("first.color", "first.tint2").replace("[1].color", "[1].tint2")),
        ("a.vert", OTHER_STAGE.replacen("color", "tint2", 1).replace("[0].color", "[0].tint2")),
        ("lights.glsl", INCLUDE.replacen("color", "tint2", 1)),
    ];
    let expected: BTreeMap<String, String> =
        expected.into_iter().map(|(file, text)| (file.to_string(), text)).collect();
    assert_eq!(files, expected);
}

#[test]
fn a_rename_is_refused_where_a_use_is_not_known() {
    let place = project("lsp-rename-refused");
    let unknown = SHADER.replace("first.color +", "(first).color + first.color +");
    place.write("a.frag", &unknown);
    let mut client = checked(&place);
    client.open("a.frag", &unknown);
    let mut refused = |piece: &str, skip: u64, new: &str| {
        let mut at = client.at("a.frag", &unknown, piece);
        let character = at["position"]["character"].as_u64().expect("a number") + skip;
        at["position"]["character"] = json!(character);
        at["newName"] = json!(new);
        let error = client.request("textDocument/rename", at).expect_err("it is refused");
        error["message"].as_str().expect("a message").to_string()
    };
    assert_eq!(refused("sun.color", 4, "glow"), "it is not known what `color` means at a.frag:9");
    assert_eq!(refused("sun.color", 4, "2x"), "`2x` is no name");
    assert_eq!(refused("Sun { vec3", 0, "Star"), "`Sun` is no member; only members are renamed");
    assert_eq!(refused("void main", 0, "x"), "there is no member of a block here");
}

#[test]
fn symbols_are_the_blocks_and_structures() {
    let place = project("lsp-symbols");
    let mut client = checked(&place);
    client.open("a.frag", SHADER);
    let params = json!({ "textDocument": client.document("a.frag") });
    let found = client.request("textDocument/documentSymbol", params).expect("it is answered");
    let names: Vec<(&str, usize)> = found
        .as_array()
        .expect("a list")
        .iter()
        .map(|one| {
            let children = one["children"].as_array().map_or(0, Vec::len);
            (one["name"].as_str().expect("a name"), children)
        })
        .collect();
    assert_eq!(names, [("Sun", 1), ("Lights", 2)]);
    let all = client.request("workspace/symbol", json!({ "query": "lgts" })).expect("answered");
    let mut shaders: Vec<&str> = all
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(|one| one["containerName"].as_str())
        .collect();
    shaders.sort_unstable();
    assert_eq!(shaders, ["a.frag", "a.vert"]);
}
