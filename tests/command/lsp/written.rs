//! What the server has the client write, and what it shows of files that are not shaders.

use serde_json::{Value, json};

use super::client::Client;
use crate::support::command::Place;

const SHADER: &str = "#version 450\n\
    struct PointLight { vec3 pos; float power; };\n\
    layout(std140, binding = 0) uniform Lights { PointLight data[4]; } lights;\n\
    layout(location = 0) out vec4 o;\n\
    void main() { o = vec4(lights.data[0].pos * lights.data[1].power, 1.0); }\n";

const HEADER: &str = "#pragma once\n#include \"math.h\"\nnamespace engine {\n// struct PointLight { float m_pos[3]; };\n\
    struct alignas(16) PointLight {\n    Vec3 m_pos; /* \u{1f4a1} */ float m_power = 1.0f;\n};\n}\n";

const CONFIGURATION: &str = "[[assert]]\nout = \"src/lights_assert.hpp\"\nlang = \"c\"\n\
    shaders = [\"a.frag\"]\nstructures = { \"engine::PointLight\" = \"PointLight\" }\n\
    field-prefix = \"m_\"\ninclude-header = [\"engine/light.h\"]\n";

fn creating() -> Value {
    json!({ "workspace": { "workspaceEdit": {
        "documentChanges": true, "resourceOperations": ["create", "rename", "delete"],
    } } })
}

fn action(client: &mut Client, file: &str, text: &str, piece: &str, title: &str) -> Option<Value> {
    let at = client.at(file, text, piece)["position"].clone();
    let params = json!({
        "textDocument": client.document(file),
        "range": { "start": at, "end": at },
        "context": { "diagnostics": [] },
    });
    let found = client.request("textDocument/codeAction", params).expect("it is answered");
    let is_it = |one: &&Value| one["title"].as_str().is_some_and(|text| text.starts_with(title));
    found.as_array().expect("a list").iter().find(is_it).cloned()
}

/// Writes what an edit creates or appends to; that is all that these edits do.
fn apply(place: &Place, client: &Client, edit: &Value) -> Vec<String> {
    let mut files = Vec::new();
    for change in edit["documentChanges"].as_array().expect("changes") {
        let named = change["uri"].as_str().or(change["textDocument"]["uri"].as_str());
        let uri = named.expect("a file").to_string();
        let file = uri.strip_prefix(&client.uri("")).expect("below the folder").to_string();
        if change["kind"] == "create" {
            assert!(!place.0.join(&file).exists(), "{file} is there");
            place.write(&file, "");
            continue;
        }
        let [only] = &change["edits"].as_array().expect("edits")[..] else { panic!("{change}") };
        let old = place.read(&file);
        let (line, start) = (&only["range"]["start"]["line"], &only["range"]["start"]["character"]);
        let is_start = (line, start) == (&json!(0), &json!(0));
        let before = if is_start { "" } else { old.as_str() };
        assert!(is_start || *line == json!(old.matches('\n').count()), "at its end: {only}");
        place.write(&file, format!("{before}{}", only["newText"].as_str().expect("a text")));
        files.push(file);
    }
    files
}

#[test]
fn a_member_leads_to_its_field_in_a_header_and_back() {
    let place = Place::new("lsp-headers");
    place.write("a.frag", SHADER).write("landfall.toml", CONFIGURATION);
    place.write("src/engine/light.h", "#include \"detail/point.h\"\n");
    place.write("src/engine/detail/point.h", HEADER);
    assert_eq!(place.run(&["emit"]).code, 0);
    place.write("broken.frag", "#version 450\nuniform B { nonsense x; };\n");
    let mut client = Client::new(&place);
    client.until("all are checked", |client| !client.codes("broken.frag").is_empty());
    client.open("a.frag", SHADER);
    let at = client.at("a.frag", SHADER, "power;");
    let hover = client.request("textDocument/hover", at.clone()).expect("it is answered");
    let hover = hover["contents"]["value"].as_str().expect("text");
    assert!(
        hover.contains("`engine::PointLight.m_power`, [src/engine/detail/point.h:6]("),
        "{hover}"
    );
    let header = "src/engine/detail/point.h";
    let field = client.at(header, HEADER, "m_power");
    let found = client.request("textDocument/implementation", at).expect("it is answered");
    assert_eq!(found[0]["uri"], json!(client.uri(header)), "{found}");
    assert_eq!(found[0]["range"]["start"], field["position"]);

    let back = client.request("textDocument/declaration", field).expect("it is answered");
    assert_eq!(back[0]["uri"], json!(client.uri("a.frag")), "{back}");
    assert_eq!(back[0]["range"]["start"], client.at("a.frag", SHADER, "power;")["position"]);
    let structure = client.at(header, HEADER, "PointLight {\n");
    let back = client.request("textDocument/declaration", structure).expect("it is answered");
    assert_eq!(back[0]["range"]["start"], client.at("a.frag", SHADER, "PointLight {")["position"]);

    // As the header is edited; a field that it does not declare has no place.
    client.open(header, &HEADER.replace("m_power", "m_force"));
    let at = client.at("a.frag", SHADER, "power;");
    let found = client.request("textDocument/implementation", at.clone()).expect("it is answered");
    assert_eq!(found, json!([]));
    let hover = client.request("textDocument/hover", at).expect("it is answered");
    let hover = hover["contents"]["value"].as_str().expect("text");
    assert!(hover.contains("`engine::PointLight.m_power` is held to it by ["), "{hover}");
}

#[test]
fn a_mirror_is_written_once_and_compared() {
    let place = Place::new("lsp-write-mirror");
    place.write("s/a.frag", SHADER);
    let title = "Write the mirror of `Lights` in Rust: `s/lights.rs`";
    let mut plain = Client::new(&place);
    plain.open("s/a.frag", SHADER);
    let none = action(&mut plain, "s/a.frag", SHADER, "Lights", title);
    assert!(none.is_none(), "the client creates no files");

    let mut client = Client::with(&place, creating());
    client.open("s/a.frag", SHADER);
    let offered = action(&mut client, "s/a.frag", SHADER, "Lights", title).expect("it is offered");
    assert!(!place.0.join("s/lights.rs").exists(), "nothing is written unasked");
    assert_eq!(apply(&place, &client, &offered["edit"]), ["s/lights.rs"]);
    let written = place.read("s/lights.rs");
    assert!(written.contains("// landfall: mirror(Lights)\n"), "{written}");
    assert_eq!(
        place.run(&["check", "--deny", "rust-mirror-unknown"]).code,
        0,
        "it is as the block"
    );
    place.write("s/a.frag", SHADER.replace("float power;", "float a; float power;"));
    let changed = place.run(&["check"]);
    assert!(changed.out.contains("error[rust-mirror]"), "{}", changed.out);
    place.write("s/a.frag", SHADER);
    let again = action(&mut client, "s/a.frag", SHADER, "Lights", "Write the mirror");
    assert!(again.is_none(), "nothing is written over: {again:?}");
}

#[test]
fn a_mirror_is_written_where_the_configuration_has_it() {
    let place = Place::new("lsp-write-configured");
    place.write("a.frag", SHADER);
    let row =
        "[[rust-mirror]]\nfile = \"src/gpu.rs\"\nstructure = \"GpuLights\"\nblock = \"Lights\"\n";
    place.write("landfall.toml", row).write("src/main.rs", "fn main() {}\n");
    // As Neovim says it.
    let operations = json!({ "workspaceEdit": { "resourceOperations": ["create"] } });
    let mut client = Client::with(&place, json!({ "workspace": operations }));
    client.open("a.frag", SHADER);
    let title = "Write the mirror of `Lights` in Rust: `src/gpu.rs`";
    let offered = action(&mut client, "a.frag", SHADER, "Lights", title).expect("it is offered");
    apply(&place, &client, &offered["edit"]);
    assert!(place.read("src/gpu.rs").contains("pub struct GpuLights {"));
    assert_eq!(place.run(&["check", "--deny", "rust-mirror-unknown"]).code, 0);
}

#[test]
fn an_assertion_is_configured_and_its_file_written() {
    let place = Place::new("lsp-write-assertion");
    place.write("a.frag", SHADER).write("landfall.toml", "[levels]\nvec3-array = \"deny\"");
    let mut client = Client::with(&place, creating());
    client.open("a.frag", SHADER);
    let title = "Hold a structure of the program to `PointLight`: `[[assert]]`";
    let offered =
        action(&mut client, "a.frag", SHADER, "PointLight {", title).expect("it is offered");
    assert_eq!(apply(&place, &client, &offered["edit"]), ["landfall.toml"]);
    let configuration = place.read("landfall.toml");
    client.open("landfall.toml", &configuration);
    let stale = "stale-assertions".to_string();
    client.until("a finding", |client| client.codes("landfall.toml").contains(&stale));
    let again = action(&mut client, "a.frag", SHADER, "PointLight {", title);
    assert!(again.is_none(), "it has one: {again:?}");

    let title = "Write `point_light_assert.hpp`";
    let write = action(&mut client, "landfall.toml", &configuration, "[[assert]]", title);
    let write = write.expect("it is offered");
    assert_eq!(apply(&place, &client, &write["edit"]), ["point_light_assert.hpp"]);
    assert_eq!(place.run(&["emit", "--check"]).code, 0, "it is what `emit` writes");
    let text = place.read("point_light_assert.hpp");
    assert!(text.contains("offsetof(PointLight, power), 12u"), "{text}");

    // One that is out of date is written anew as a whole.
    place.write("point_light_assert.hpp", "// of another shader\n");
    client.replace("landfall.toml", 2, &configuration);
    client.until("out of date", |client| {
        let found = &client.findings[&client.uri("landfall.toml")]["diagnostics"][0]["message"];
        found.as_str().is_some_and(|text| text.contains("is out of date"))
    });
    let write = action(&mut client, "landfall.toml", &configuration, "[[assert]]", title);
    apply(&place, &client, &write.expect("it is offered")["edit"]);
    assert_eq!(place.read("point_light_assert.hpp"), text);
}

#[test]
fn the_memory_map_opens_at_the_block_as_it_is_edited() {
    let place = Place::new("lsp-map");
    place.write("light.glsl", "struct PointLight { vec3 pos; };\n");
    let shader = "#version 450\n#include \"light.glsl\"\n\
        layout(std140, binding = 0) uniform First { vec4 one; } first;\n\
        layout(std140, binding = 1) uniform Lights { PointLight data[4]; } lights;\n\
        void main() { gl_Position = first.one + vec4(lights.data[0].pos, 1.0); }\n";
    place.write("a.vert", shader);
    let mut client =
        Client::with(&place, json!({ "window": { "showDocument": { "support": true } } }));
    client.open("a.vert", &shader.replace("vec4 one;", "vec4 one; vec4 unsaved;"));
    client.open("light.glsl", "struct PointLight { vec3 pos; vec3 also_unsaved; };\n");
    let run =
        json!({ "command": "landfall.memoryMap", "arguments": [client.uri("a.vert"), "Lights"] });
    client.request("workspace/executeCommand", run).expect("it is shown");
    client.until("a page", |client| {
        client.asked.iter().any(|one| one["method"] == "window/showDocument")
    });
    let shown = client.asked.iter().find(|one| one["method"] == "window/showDocument");
    let shown = &shown.expect("a page")["params"];
    assert_eq!(shown["external"], true);
    let file = shown["uri"].as_str().and_then(|uri| uri.strip_prefix("file://")).expect("a file");
    let page = std::fs::read_to_string(file).expect("it is written");
    let (_, data) = page.split_once("id=\"data\">").expect("its data");
    let data = data.split_once("</script>").expect("its end").0;
    let data: Value = serde_json::from_str(data).expect("JSON");
    assert_eq!(data["at"], "Lights");
    let texts = data["texts"].to_string() + &data["shaders"].to_string();
    assert!(texts.contains("\"unsaved\"") && texts.contains("\"also_unsaved\""), "{texts}");
    let own = std::fs::read_dir(&place.0).expect("the folder").count();
    assert_eq!(
        own, 3,
        "nothing is written into the project beside the configuration and the shaders"
    );
}

#[test]
fn no_assertions_are_written_over_the_configuration_or_a_shader() {
    let place = Place::new("lsp-write-inputs");
    place.write("a.frag", SHADER);
    let mut client = Client::with(&place, creating());
    for (version, out) in ["landfall.toml", "a.frag"].iter().enumerate() {
        let configuration = CONFIGURATION.replace("src/lights_assert.hpp", out);
        match version {
            0 => client.open("landfall.toml", &configuration),
            _ => client.replace("landfall.toml", 2, &configuration),
        }
        client.until("a finding", |client| {
            let found = &client.findings.get(&client.uri("landfall.toml"));
            let found = found.and_then(|found| found["diagnostics"][0]["message"].as_str());
            found.is_some_and(|text| text.contains(&format!("`{out}` is out of date")))
        });
        let write = action(&mut client, "landfall.toml", &configuration, "[[assert]]", "Write");
        assert!(write.is_none(), "{out}: {write:?}");
    }
}
