//! Structures in the JSON of layouts: what they say suffices to place every leaf.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::support::command::{self, Place};
use crate::support::files;

/// The paths and offsets of the leaves below members, by the structures alone.
fn place(
    members: &Value,
    structures: &Value,
    (prefix, base): (&str, u64),
    out: &mut BTreeMap<String, u64>,
) {
    for member in members.as_array().expect("members") {
        let dims = member["dims"].as_array().map_or(0, Vec::len);
        let name = member["name"].as_str().expect("a name");
        let path = format!("{prefix}{name}{}", "[]".repeat(dims));
        let at = base + member["offset"].as_u64().expect("an offset");
        match member["structure"].as_u64() {
            Some(of) => {
                let of = &structures[of as usize];
                // Elements are as far apart as one is long, but where rules let a structure end early.
                if let Some(stride) = member["strides"].as_array().and_then(|all| all.last()) {
                    let (stride, size) = (stride.as_u64(), of["size"].as_u64());
                    let is_whole =
                        ["std140", "std430", "wgsl"].contains(&of["rules"].as_str().unwrap());
                    assert!(if is_whole { stride == size } else { stride >= size }, "{path}");
                }
                place(&of["members"], structures, (&format!("{path}."), at), out);
            }
            None => drop(out.insert(path, at)),
        }
    }
}

#[test]
fn structures_place_every_leaf_of_every_shader() {
    let mut held = 0;
    let shaders = files::shaders();
    let paths: Vec<String> = shaders.iter().map(|path| path.display().to_string()).collect();
    let arguments: Vec<&str> = ["layout", "--format", "json"]
        .into_iter()
        .chain(paths.iter().map(String::as_str))
        .collect();
    let json: Value = serde_json::from_str(&command::run(&arguments).out).expect("JSON");
    for shader in json["shaders"].as_array().expect("shaders") {
        for block in shader["blocks"].as_array().expect("blocks") {
            if block["rules"].is_null() {
                continue;
            }
            let mut placed = BTreeMap::new();
            place(&block["members"], &shader["structures"], ("", 0), &mut placed);
            let leaves = block["leaves"].as_array().expect("leaves").iter().map(|leaf| {
                (leaf["path"].as_str().unwrap().to_string(), leaf["offset"].as_u64().unwrap())
            });
            // A bare variable of WGSL has its name as its path.
            let leaves: BTreeMap<String, u64> = leaves.collect();
            assert_eq!(placed, leaves, "{}: {}", shader["path"], block["name"]);
            held += leaves.len();
        }
    }
    assert!(held > 500, "{held}");
}

/// OpenGL 4.6, section 7.6.2.2: an array of structures, and a structure in std140, is aligned to 16.
#[test]
fn a_structure_stands_once_for_each_layout() {
    let folder = Place::new("schema-structures-rules");
    folder.write(
        "a.comp",
        "#version 450\nlayout(local_size_x = 1) in;\nstruct Range { float near; float far; };\n\
         struct Light { vec3 color; float power; Range range; };\n\
         layout(std140, binding = 0) uniform A { Light one; Light all[2]; } a;\n\
         layout(std430, binding = 1) buffer B { Light all[]; } b;\nvoid main() {}\n",
    );
    let ran = folder.run(&["layout", "a.comp", "--format", "json"]);
    let json: Value = serde_json::from_str(&ran.out).expect("JSON");
    let structures = json["shaders"][0]["structures"].as_array().expect("structures");
    let row = |of: &Value| {
        let text = |key: &str| of[key].as_str().expect("a text").to_string();
        (text("name"), text("rules"), of["size"].as_u64(), of["align"].as_u64())
    };
    let expected = [
        ("Range", "std140", 16, 16),
        ("Light", "std140", 32, 16),
        ("Range", "std430", 8, 4),
        ("Light", "std430", 32, 16),
    ];
    let expected = expected.map(|(name, rules, size, align)| {
        (name.to_string(), rules.to_string(), Some(size), Some(align))
    });
    assert_eq!(structures.iter().map(row).collect::<Vec<_>>(), expected);
    assert_eq!(structures[1]["members"][2]["structure"], 0);
    assert!(structures[1]["members"][2].get("members").is_none());
}
