//! Structures that no block holds, and variants of which one holds, in the commands.

use crate::support::command::Place;

const COMMON: &str = "#version 450\nstruct Light { vec3 position; vec3 color; float range; };\n";

/// Offsets and sizes after OpenGL 4.6 §7.6.2.2 and GL_EXT_scalar_block_layout.
#[test]
fn a_structure_is_laid_out_by_its_name_under_each_rule() {
    let place = Place::new("structures");
    place.write("common.glsl", COMMON);
    let json = place.run(&["layout", "common.glsl", "--struct", "Light", "-f", "json"]).json();
    let blocks = json["shaders"][0]["blocks"].as_array().expect("blocks");
    let found: Vec<(&str, u64, Vec<u64>)> = blocks
        .iter()
        .map(|block| {
            let members = block["members"].as_array().expect("members");
            let offset = |member: &serde_json::Value| member["offset"].as_u64().expect("a number");
            let rules = block["rules"].as_str().expect("rules");
            (rules, block["size"].as_u64().expect("a size"), members.iter().map(offset).collect())
        })
        .collect();
    assert_eq!(
        found,
        [
            ("std140", 32, vec![0, 16, 28]),
            ("std430", 32, vec![0, 16, 28]),
            ("scalar", 28, vec![0, 12, 24]),
        ]
    );
    let explained = place.run(&["explain", "common.glsl", "Light.range", "--rules", "scalar"]);
    assert!(explained.code == 0 && explained.out.contains("24"), "{}", explained.err);
    let rust = place.run(&["emit", "common.glsl", "--struct", "Light", "--lang", "rust"]);
    assert!(rust.code == 0 && rust.out.contains("pub struct Light"), "{}", rust.err);
    // The rules tell its three layouts apart, so no name needs a number.
    assert_eq!(rust.err, "");
    assert!(rust.out.contains("pub mod light_scalar {"), "{}", rust.out);
    place.write("types.wesl", "struct Sun { direction: vec3f, power: f32 }\n");
    place.write("main.wesl", "import package::types::Sun as Star;\nfn f(star: Star) {}\n");
    let imported = place.run(&["layout", "main.wesl", "--struct", "Star"]);
    assert!(imported.code == 0 && imported.out.contains("16 bytes"), "{}", imported.err);
    let none = place.run(&["layout", "common.glsl", "--struct", "Lihgt"]);
    assert!(none.code == 2 && none.err.contains("Lihgt"), "{}", none.err);
}

#[test]
fn variants_of_which_one_holds_are_locked_and_guarded() {
    let place = Place::new("variants-one-of");
    place.write(
        "landfall.toml",
        "[[variants]]\nfile = \"*.frag\"\nsets = [[\"LOW\"], [\"HIGH\"]]\n",
    );
    let shader = "#version 450\n#if defined(LOW)\n#define N 4\n#elif defined(HIGH)\n#define N 8\n\
                  #else\n#error LOW or HIGH\n#endif\n\
                  layout(std140, binding = 0) uniform Rows { vec4 rows[N]; float scale; };\n\
                  layout(location = 0) out vec4 color;\nvoid main() { color = rows[0] * scale; }\n";
    place.write("a.frag", shader);
    let locked = place.run(&["lock"]);
    assert_eq!(locked.code, 0, "{}", locked.err);
    let lock: serde_json::Value = serde_json::from_str(&place.read("layouts/a.frag.json")).unwrap();
    let sizes = lock.to_string();
    // vec4[4] and a float, rounded up to 16 bytes; vec4[8] and the same.
    assert!(sizes.contains("\"size\":80") && sizes.contains("\"size\":144"), "{sizes}");
    assert_eq!(place.run(&["check", "-A", "define-changes-layout"]).code, 0);
    place.write("a.frag", shader.replace("#define N 8", "#define N 16"));
    let ran = place.run(&["check", "-A", "define-changes-layout"]);
    assert!(ran.code == 1 && ran.out.contains("HIGH"), "{} {}", ran.out, ran.err);
}
