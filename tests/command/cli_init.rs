//! `landfall init`, and the JSON Schema of the configuration.

use serde_json::{Value, json};
use snapbox::str;

use crate::schema::validator;
use crate::support::command::{self, Place};

const SHADER: &str =
    "#version 450\nlayout(std140, binding = 0) uniform A { vec4 a; } a;\nvoid main() {}\n";

fn empty(name: &str) -> Place {
    let place = Place::new(name);
    std::fs::remove_file(place.0.join("landfall.toml")).unwrap();
    // No configuration above is found from a repository.
    std::fs::create_dir(place.0.join(".git")).unwrap();
    place
}

#[test]
fn init_writes_what_it_finds_and_check_takes_it() {
    let place = empty("init");
    let including = SHADER.replace(
        "layout",
        "#extension GL_GOOGLE_include_directive : require\n#include \"tone.glsl\"\nlayout",
    );
    place.write("assets/shaders/a.frag", including);
    place.write("assets/shaders/common/tone.glsl", "float tone(float x) { return x; }\n");
    place.write("assets/shaders/deep/b.wgsl", "@group(0) @binding(0) var<uniform> a: vec4<f32>;\n");
    place.write("web/c.frag", SHADER.replace("450", "300 es").replace(", binding = 0", ""));
    place.write("third_party/x/broken.frag", "#version 450\nuniform B {");
    place.run(&["check"]).code(2);
    let ran = place.run(&["init"]);
    ran.code(0).stdout_eq("").stderr_eq(str![[r#"
wrote landfall.toml for 4 shaders

"#]]);
    snapbox::assert_data_eq!(
        place.read("landfall.toml"),
        str![[r##"
# Settings of landfall. `landfall schema config` prints their JSON Schema.

# What `landfall check` and `landfall lock` read: 4 shaders.
paths = ["assets/shaders", "web"]

# Not checked: a path, or a file or directory name anywhere.
exclude = ["third_party"]

# Directories of files that `#include` names.
include = ["assets/shaders/common"]

# `landfall lock` records layouts in `layouts`; then check reports changes.
# locks = "layouts"

# APIs whose limits hold: gl33, gles30, webgl2, webgpu, vulkan.
# targets = ["webgl2", "webgpu"]

# Findings of today that are permitted, as `landfall check --write-baseline`
# records them.
# baseline = "landfall-baseline.json"

# Changes of layouts that are refused: superset, bytes, names or code.
# policy = "bytes"

# Levels of lints, which `landfall rule` lists: allow, warn or deny.
# [levels]
# warnings = "deny"
# mat3-padding = "allow"

# Levels in some files.
# [[path-levels]]
# file = "old/**"
# levels = { all = "allow" }

"##]]
    );
    let checked = place.run(&["check", "-A", "all"]);
    checked.code(0).stderr_eq(str![[r#"
checked 4 shaders: no findings

"#]]);
    // Without their signs, the suggestions are a configuration, too.
    let all: String = place
        .read("landfall.toml")
        .lines()
        .map(|line| {
            line.strip_prefix("# ")
                .filter(|rest| rest.contains(" = ") || rest.starts_with('['))
                .unwrap_or(line)
                .to_string()
                + "\n"
        })
        .collect();
    place.write("landfall.toml", &all);
    place.write("landfall-baseline.json", "{\"schema_version\": 1, \"findings\": []}");
    place.run(&["lock"]).code(0);
    place.run(&["check", "-A", "all"]).code(0);
}

#[test]
fn init_overwrites_no_configuration() {
    for name in ["landfall.toml", ".landfall.toml"] {
        let place = empty("init-there");
        place.write("a.frag", SHADER).write(name, "# mine\n");
        let ran = place.run(&["init"]);
        assert_eq!(ran.code(2).out, "");
        assert!(
            ran.err.contains(&format!("`{name}` exists and is not overwritten")),
            "{}",
            ran.err
        );
        assert_eq!(place.read(name), "# mine\n");
        place.run(&["init", "--print"]).code(0);
    }
    let place = empty("init-nothing");
    place.run(&["init"]).code(2);
    place.run(&["init", "gone"]).code(2);
    assert!(!place.has("landfall.toml"));
}

#[test]
fn names_of_any_kind_are_written_as_toml_reads_them() {
    let place = empty("init-names");
    let folder = "sh \"q\" é";
    place.write(&format!("{folder}/a.frag"), SHADER).write("other/b.frag", SHADER);
    place.run(&["init"]).code(0);
    let ran = place.run(&["check", "-A", "all"]);
    ran.code(0).stderr_eq(str![[r#"
checked 2 shaders: no findings

"#]]);
}

/// The keys that the parser knows, as it names them beside an unknown one.
fn known(place: &Place, table: &str) -> Vec<String> {
    place.write("landfall.toml", format!("{table}xyzxyzxyz = 1\n"));
    let ran = place.run(&["check"]);
    let line = ran
        .code(2)
        .err
        .lines()
        .find_map(|line| line.split_once("` has `").or(line.split_once("configuration has `")));
    let keys = line.unwrap_or_else(|| panic!("{}", ran.err)).1;
    let mut keys: Vec<String> =
        keys.trim_end_matches('`').split("`, `").map(str::to_string).collect();
    keys.sort();
    keys.dedup();
    keys
}

#[test]
fn the_schema_has_the_keys_of_the_parser() {
    let place = Place::new("config-schema-keys");
    place.write("a.frag", SHADER);
    let schema = command::run(&["schema", "config"]).json();
    let resolved = |value: &Value| match value["$ref"].as_str() {
        Some(name) => schema.pointer(name.trim_start_matches('#')).unwrap().clone(),
        None => value.clone(),
    };
    let keys = |value: &Value| {
        let mut keys: Vec<String> =
            resolved(value)["properties"].as_object().unwrap().keys().cloned().collect();
        keys.sort();
        keys
    };
    assert_eq!(keys(&schema), known(&place, ""));
    assert_eq!(keys(&schema["properties"]["bindings"]), known(&place, "[bindings]\n"));
    let tables = [
        ("path-policy", "file = \"a\"\npolicy = \"bytes\"\n"),
        ("path-levels", "file = \"a\"\nlevels = {}\n"),
        ("mirror-group", "name = \"a\"\ncopies = [{ block = \"A\" }, { block = \"B\" }]\n"),
        ("table", "block = \"A\"\nsize = 1\n"),
        ("rust-mirror", "file = \"a.rs\"\nstructure = \"A\"\nblock = \"A\"\n"),
        ("variants", "file = \"a\"\nsets = []\n"),
        ("assert", "out = \"a.h\"\nlang = \"c\"\nshaders = [\"a\"]\nstructures = { A = \"A\" }\n"),
        ("compiled", "source = \"a.frag\"\nspirv = \"a.frag.spv\"\n"),
        ("prove", "file = \"a.frag\"\nfunction = \"f\"\n"),
    ];
    for (table, rest) in tables {
        let there = known(&place, &format!("[[{table}]]\n{rest}"));
        assert_eq!(keys(&schema["properties"][table]["items"]), there, "{table}");
    }
    let arrays = schema["properties"].as_object().unwrap().iter();
    let arrays = arrays.filter(|(_, value)| resolved(&value["items"])["properties"].is_object());
    assert_eq!(arrays.count(), tables.len(), "every table is compared");
    let groups = resolved(&schema["properties"]["mirror-group"]["items"]);
    let copies = &groups["properties"]["copies"]["items"];
    assert_eq!(keys(copies), ["aliases", "block", "file", "prefix"]);
}

#[test]
fn the_schema_takes_what_the_parser_takes() {
    let place = Place::new("config-schema");
    place.write("a.frag", SHADER).write("src/lights.rs", "#[repr(C)] struct P { pos: [f32; 4] }\n");
    place.write("b.json", "{\"schema_version\": 1, \"findings\": []}");
    let validator = validator("config");
    let example = include_str!("../../crates/landfall-check/src/config/example.toml");
    let rows = [
        (example.to_string(), true),
        (String::new(), true),
        ("baseline = \"b.json\"\n".to_string(), true),
        ("baseline = 1\n".to_string(), false),
        ("paths = \"a\"\n".to_string(), false),
        ("paths = [1]\n".to_string(), false),
        ("gather = \"yes\"\n".to_string(), false),
        ("rules = \"std141\"\n".to_string(), false),
        ("api = \"metal\"\n".to_string(), false),
        ("targets = [\"webgl3\"]\n".to_string(), false),
        ("define = [\"3D\"]\n".to_string(), false),
        ("define = [\"D=\", \"E\"]\n".to_string(), true),
        ("override = [\"x\"]\n".to_string(), false),
        ("permutations = [[\"A\"], []]\n".to_string(), true),
        ("permutations = [\"A\"]\n".to_string(), false),
        ("[levels]\nwarnings = \"forbid\"\n".to_string(), false),
        ("[levels]\nwarnings = 1\n".to_string(), false),
        ("[[path-levels]]\nfile = \"a\"\n".to_string(), false),
        ("[[path-levels]]\nlevels = { all = \"warn\" }\n".to_string(), false),
        ("[[path-levels]]\nfile = \"a/**\"\nlevels = { all = \"warn\" }\n".to_string(), true),
        ("[path-levels]\nfile = \"a\"\nlevels = { all = \"warn\" }\n".to_string(), false),
        ("[[mirror-group]]\nname = \"a\"\ncopies = [{ block = \"A\" }]\n".to_string(), false),
        ("[[table]]\nblock = \"A\"\n".to_string(), false),
        ("[[table]]\nblock = \"A\"\nsize = -1\n".to_string(), false),
        ("[[table]]\nblock = \"A\"\nsize = \"4 * 4\"\n".to_string(), true),
        ("[[rust-mirror]]\nfile = \"src/lights.rs\"\nstructure = \"P\"\n".to_string(), false),
        ("[[prove]]\nfile = \"a.frag\"\nfunction = \"f\"\nmax-ulp = -1\n".to_string(), false),
        ("colour = 1\n".to_string(), false),
    ];
    for (text, takes) in rows {
        let value: toml::Table = text.parse().unwrap_or_else(|e| panic!("{e}\n{text}"));
        let value = json!(value);
        assert_eq!(validator.is_valid(&value), takes, "the schema\n{text}");
        let text = text.replace("landfall-baseline.json", "b.json");
        let ran = place.write("landfall.toml", &text).run(&["check", "-A", "all", "a.frag"]);
        assert_eq!(ran.code == 0, takes, "the parser\n{text}\n{}", ran.err);
    }
}
