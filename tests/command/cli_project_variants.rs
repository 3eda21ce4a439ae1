//! Variants of `[[variants]]` in `layout`, `report` and `emit`: a block that differs is shown once, with
//! what makes it differ.

use serde_json::Value;

use crate::support::command::Place;

const SHADER: &str = "#version 450\n#if defined(LOW)\n#define N 4\n#elif defined(HIGH)\n#define N 8\n\
    #else\n#error LOW or HIGH\n#endif\nlayout(std140, binding = 0) uniform Camera { mat4 view; };\n\
    layout(std140, binding = 1) uniform Rows { vec4 rows[N]; float scale; };\n\
    #ifdef FOG\nlayout(std140, binding = 2) uniform Fog { vec3 color; float density; };\n#endif\n\
    layout(location = 0) out vec4 color_;\nvoid main() { color_ = rows[0] * scale; }\n";

fn project(name: &str) -> Place {
    let place = Place::new(&format!("project-variants-{name}"));
    place.write(
        "landfall.toml",
        "[[variants]]\nfile = \"*.frag\"\nsets = [[\"LOW\"], [\"LOW\", \"FOG\"], [\"HIGH\"], \
         [\"HIGH\", \"FOG\"]]\n",
    );
    place.write("a.frag", SHADER).write("b.comp", "#version 450\nvoid main() {}\n");
    place
}

/// Sizes after OpenGL 4.6 §7.6.2.2: a `mat4` has 64 bytes; `vec4[4]` and a float, rounded up to 16, have
/// 80, `vec4[8]` and a float 144; a `vec3` and a float have 16.
#[test]
fn layout_shows_a_block_once_with_what_makes_it_differ() {
    let place = project("layout");
    let ran = place.run(&["layout", "a.frag", "-f", "json"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    let json: Value = serde_json::from_str(&ran.out).expect("JSON");
    let shaders = json["shaders"].as_array().expect("a list").iter();
    let shown: Vec<(Vec<String>, String)> = shaders
        .map(|shader| {
            let blocks = shader["blocks"].as_array().expect("blocks").iter();
            let blocks = blocks.map(|block| format!("{} {}", block["name"], block["size"]));
            let sets = shader["variants"].as_array().map(Vec::as_slice).unwrap_or_default();
            (sets.iter().map(Value::to_string).collect(), blocks.collect::<Vec<_>>().join(", "))
        })
        .collect();
    let sets = |sets: &[&str]| sets.iter().map(|set| set.to_string()).collect::<Vec<_>>();
    assert_eq!(
        shown,
        [
            (sets(&[]), "\"Camera\" 64".to_string()),
            (sets(&["[\"LOW\"]", "[\"LOW\",\"FOG\"]"]), "\"Rows\" 80".to_string()),
            (sets(&["[\"LOW\",\"FOG\"]", "[\"HIGH\",\"FOG\"]"]), "\"Fog\" 16".to_string()),
            (sets(&["[\"HIGH\"]", "[\"HIGH\",\"FOG\"]"]), "\"Rows\" 144".to_string()),
        ]
    );
    let table = place.run(&["layout", "a.frag"]).out;
    let heads: Vec<&str> = table.lines().filter(|line| line.starts_with("a.frag")).collect();
    assert_eq!(
        heads,
        [
            "a.frag (fragment)",
            "a.frag with LOW (fragment)",
            "a.frag with FOG (fragment)",
            "a.frag with HIGH (fragment)"
        ]
    );
    // Other formats, and a file of its own.
    for format in ["listing", "csv", "md"] {
        let ran = place.run(&["layout", "a.frag", "-f", format]);
        assert!(ran.code == 0 && ran.out.contains("a.frag with HIGH"), "{format} {}", ran.err);
    }
    let one = place.run(&["layout", "a.frag", "-b", "Fog"]).out;
    assert!(one.starts_with("a.frag with FOG") && !one.contains("Camera"), "{one}");
    place.run(&["layout", ".", "-f", "json", "--out", "out"]).code(0);
    place.run(&["layout", ".", "-f", "json", "--out", "out"]).code(0);
    place.run(&["diff", "out/a.frag.json", "out/a.frag.json"]).code(0);
    // Without the configuration, the text is no shader.
    let bare = place.run(&["layout", "a.frag", "--no-config"]);
    assert!(bare.code == 2 && bare.err.contains("LOW or HIGH"), "{}", bare.err);
}

#[test]
fn a_variant_that_fails_is_named() {
    let place = project("fails");
    place.write("a.frag", SHADER.replace("float density", "float density[COUNT]"));
    for command in [&["layout", "a.frag"][..], &["emit", "a.frag", "-l", "rust"]] {
        let ran = place.run(command);
        assert_eq!(ran.code, 2, "{}", ran.out);
        assert!(ran.err.contains("COUNT") && ran.err.contains("with `LOW FOG`"), "{}", ran.err);
    }
}

#[test]
fn emit_writes_a_module_for_each_variant_and_shares_what_is_equal() {
    let place = project("emit");
    let ran = place.run(&["emit", "a.frag", "-l", "rust", "--vectors", "array"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    let text = &ran.out;
    for module in
        ["a_frag_with_low", "a_frag_with_low_fog", "a_frag_with_high", "a_frag_with_high_fog"]
    {
        assert_eq!(text.matches(&format!("pub mod {module} {{")).count(), 1, "{module}\n{text}");
    }
    // The two layouts of `Rows`, and one of the others.
    assert_eq!(text.matches("pub struct Rows {").count(), 1, "{text}");
    assert_eq!(text.matches("pub struct Rows2 {").count(), 1, "{text}");
    assert_eq!(text.matches("::Rows2 as Rows;").count(), 2, "{text}");
    assert_eq!(text.matches("pub struct Camera {").count(), 1, "{text}");
    assert_eq!(text.matches("pub struct Fog {").count(), 1, "{text}");
    assert_eq!(text.matches("pub const N: usize = 4;").count(), 2, "{text}");
    assert_eq!(text.matches("pub const N: usize = 8;").count(), 2, "{text}");
    let header = place.run(&["emit", "a.frag", "-l", "c"]);
    assert_eq!(header.code, 0, "{}", header.err);
    assert_eq!(header.out.matches("typedef struct Camera {").count(), 1, "{}", header.out);
    assert!(header.out.contains("typedef struct Rows_2 {"), "{}", header.out);
}

#[test]
fn bindings_have_a_program_for_each_variant() {
    let place = project("bindings");
    place.write(
        "landfall.toml",
        "[[variants]]\nfile = \"*.frag\"\nsets = [[\"LOW\"], [\"HIGH\"]]\n",
    );
    let ran = place.run(&["emit", "-l", "rust", "--bindings", "wgpu", "a.frag"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    for (name, rows) in [("a_with_low", 80), ("a_with_high", 144)] {
        let text = ran.out.split_once(&format!("pub mod {name} {{")).expect(name).1;
        let rows = format!("/// Binding 1, `Rows`: {rows} bytes.");
        let at = |of: &str| text.find(of).unwrap_or(usize::MAX);
        assert!(at(&rows) < at("pub mod a_with"), "{name} {text}");
    }
}

#[test]
fn the_report_has_the_blocks_of_every_variant() {
    let place = project("report");
    place.run(&["report", "a.frag", "-o", "page.html"]).code(0);
    let page = place.read("page.html");
    for variant in ["with LOW", "with FOG", "with HIGH"] {
        let part = format!("\"path\":\"a.frag\",\"variant\":\"{variant}\"");
        assert!(page.contains(&part), "{variant}");
    }
}
