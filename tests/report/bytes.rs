//! Bytes that are dropped into a map: against `landfall decode`.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::browser::Browser;
use crate::support::{Folder, landfall, output};

/// Members of most types, arrays short enough to be shown whole.
const GLSL: &str = "#version 450
#extension GL_EXT_shader_explicit_arithmetic_types : require
struct Lamp { vec3 pos; float power; bool on; };
layout(std430, binding = 0) buffer Values {
    float a; vec3 b; mat3 c; layout(row_major) mat2x3 d; int e; uint f; bvec2 g; double h; dvec3 i;
    float16_t j; f16vec3 k; int8_t l; uint16_t m; int64_t n; uint64_t o;
    Lamp lamps[3]; float row[2][2]; float rest[];
} values;
void main() {}
";

/// The leaves of decoded values by path, a list of components each.
fn leaves(value: &Value, path: &str, found: &mut BTreeMap<String, Vec<Value>>) {
    let is_scalar = |value: &Value| !value.is_array() && !value.is_object();
    match value {
        Value::Object(members) => {
            for (name, value) in members {
                let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
                leaves(value, &path, found);
            }
        }
        // Arrays of scalars, vectors, and the columns of matrices: told apart by the cells.
        Value::Array(all) if all.iter().all(is_scalar) => {
            found.insert(path.to_string(), all.clone());
            for (index, value) in all.iter().enumerate() {
                found.insert(format!("{path}[{index}]"), vec![value.clone()]);
            }
        }
        Value::Array(all) => {
            for (index, value) in all.iter().enumerate() {
                leaves(value, &format!("{path}[{index}]"), found);
            }
        }
        scalar => {
            found.insert(path.to_string(), vec![scalar.clone()]);
        }
    }
}

/// Whether the text of a cell is the value in JSON.
fn is_same(shown: &str, value: &Value, ty: &str) -> bool {
    let shown = shown.trim_start_matches("⚠ ");
    match value {
        Value::Bool(value) => shown == value.to_string(),
        // `decode` writes words for what JSON has no number for.
        Value::String(word) => match shown {
            "NaN" => word.to_lowercase().contains("nan"),
            _ => {
                word.to_lowercase().contains("inf")
                    && shown.starts_with('-') == word.starts_with('-')
            }
        },
        Value::Number(number) if number.is_f64() => {
            let (a, b): (f64, f64) = (shown.parse().unwrap(), number.as_f64().unwrap());
            // The shortest text of 32 bits, and of 64 bits for doubles.
            if ty.starts_with('d') { a == b } else { a as f32 == b as f32 }
        }
        Value::Number(number) => shown == number.to_string(),
        other => panic!("{other} is no component"),
    }
}

const CELLS: &str = "return [...document.querySelectorAll('button.cell')].map(cell => ({
    path: cell.dataset.path, type: cell.dataset.type, offset: Number(cell.dataset.offset),
    row: cell.place.byRow ? cell.place.vector : null, stray: cell.matches('.pad.odd'),
    values: [...cell.querySelectorAll('.values span')].map(one => one.textContent) }));";

#[test]
fn bytes_are_shown_in_place_as_decode_reads_them() {
    let (browser, folder) = (Browser::start("bytes"), Folder::new("bytes"));
    let shader = folder.file("values.comp", GLSL);
    let page = folder.path().join("page.html");
    output(folder.path(), 0, &["report", "values.comp", "-o", "page.html"]);
    browser.open(&page);
    let layout = output(folder.path(), 0, &["layout", "values.comp", "--format", "json"]);
    let layout: Value = serde_json::from_str(&layout).unwrap();
    let size = layout["shaders"][0]["blocks"][0]["size"].as_u64().unwrap() as usize + 8;
    let mut random = fastrand::Rng::with_seed(20);
    for round in 0..6 {
        // The first round has zeros but for a few values; the others every kind of bits.
        let mut bytes = vec![0u8; size];
        if round > 0 {
            bytes.iter_mut().for_each(|byte| *byte = random.u8(..));
        }
        let file = folder.file(&format!("bytes-{round}.bin"), &bytes);
        let name = file.to_str().unwrap();
        let decoded = landfall(
            folder.path(),
            &["decode", shader.to_str().unwrap(), name, "--format", "json"],
        );
        let values: Value = serde_json::from_slice(&decoded.stdout).unwrap();
        let mut wanted = BTreeMap::new();
        leaves(&values, "", &mut wanted);
        browser.choose_file("article.block input[type=file]", &file);
        let ready = "const [name, done] = arguments; (function wait() {
            document.querySelector('.oddities').textContent.includes(name)
                ? done(true) : setTimeout(wait, 20); })();";
        let shown_name = file.file_name().unwrap().to_str().unwrap();
        browser.run_async(ready, &[json!(shown_name)]);
        let mut compared = 0;
        let cells = browser.run(CELLS, &[]);
        for cell in cells.as_array().unwrap() {
            let values: Vec<String> = serde_json::from_value(cell["values"].clone()).unwrap();
            if values.is_empty() {
                continue;
            }
            let (path, ty) = (cell["path"].as_str().unwrap(), cell["type"].as_str().unwrap());
            // A row has the same component of every column.
            let components: Vec<Value> = match cell["row"].as_u64() {
                None => wanted[path].clone(),
                Some(row) => (0..values.len())
                    .map(|column| wanted[&format!("{path}[{column}]")][row as usize].clone())
                    .collect(),
            };
            assert_eq!(values.len(), components.len(), "{path}");
            for (shown, value) in values.iter().zip(&components) {
                assert!(is_same(shown, value, ty), "{path}: {shown} for {value}");
                compared += 1;
            }
        }
        assert!(compared > 40, "{compared}");
        let lines = String::from_utf8(decoded.stderr).unwrap();
        let suspicious = lines.lines().filter_map(|line| {
            let finding: Value = serde_json::from_str(line).ok()?;
            let message = finding["message"].as_str()?.to_string();
            message.contains("at byte").then(|| (place(&message), kind(&message)))
        });
        let wanted: Vec<(u64, &str)> = suspicious.collect();
        let list =
            "return [...document.querySelectorAll('.oddities li')].map(li => li.textContent)";
        let list: Vec<String> = serde_json::from_value(browser.run(list, &[])).unwrap();
        let found: Vec<(u64, &str)> = list.iter().map(|text| (place(text), kind(text))).collect();
        assert_eq!(found, wanted[..wanted.len().min(50)], "round {round}");
        assert_eq!(round > 0, !found.is_empty());
    }
}

/// The byte that a message names.
fn place(message: &str) -> u64 {
    let rest = message.split_once("at byte ").unwrap().1;
    rest.split(' ').next().unwrap().parse().unwrap()
}

fn kind(message: &str) -> &'static str {
    let words = ["not a number", "infinite", "bool", "padding"];
    words.into_iter().find(|word| message.contains(word)).unwrap_or_else(|| panic!("{message}"))
}

#[test]
fn planted_values_are_marked_where_they_are() {
    let (browser, folder) = (Browser::start("planted"), Folder::new("planted"));
    folder.file(
        "one.frag",
        "#version 450\nlayout(std140, binding = 0) uniform One { vec3 a; vec2 b; float c; };\nvoid main() {}\n",
    );
    // By the rules of std140: a at 0, b at 16, c at 24; 12 to 15 and 28 to 31 are padding.
    let mut bytes = vec![0u8; 8 + 32];
    bytes[8 + 4..8 + 8].copy_from_slice(&f32::NAN.to_le_bytes());
    bytes[8 + 13] = 0xab;
    bytes[8 + 24..8 + 28].copy_from_slice(&0.1f32.to_le_bytes());
    let file = folder.file("dump.bin", &bytes);
    output(folder.path(), 0, &["report", "one.frag", "-o", "page.html"]);
    browser.open(&folder.path().join("page.html"));
    browser.choose_file("article.block input[type=file]", &file);
    let at_eight = "const done = arguments[0]; (function wait() {
        const from = document.querySelector('.from');
        if (from.closest('[hidden]')) return setTimeout(wait, 20);
        from.value = '0x8';
        from.dispatchEvent(new Event('input'));
        done();
    })();";
    browser.run_async(at_eight, &[]);
    let cells = browser.run(CELLS, &[]);
    let cell = |offset: u64| {
        let mut all = cells.as_array().unwrap().iter();
        all.find(|cell| cell["offset"] == json!(offset)).unwrap()
    };
    assert_eq!(cell(0)["values"], json!(["0", "⚠ NaN", "0"]));
    assert_eq!(cell(24)["values"], json!(["0.1"]));
    assert_eq!(cell(12)["stray"], json!(true));
    assert_eq!(cell(28)["stray"], json!(false));
    let listed = browser.run("return document.querySelector('.oddities').innerText", &[]);
    let listed = listed.as_str().unwrap();
    assert!(listed.contains("a.y at byte 4 is not a number"), "{listed}");
    assert!(listed.contains("padding at byte 13 is not zero: ab"), "{listed}");
}
