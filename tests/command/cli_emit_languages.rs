//! `landfall emit` in each language of the table.

use snapbox::str;

use crate::support::command::Place;

#[test]
fn every_language_is_written_checked_and_prefixed() {
    let place = Place::new("emit-languages");
    let light = "layout(std140) uniform Light { vec3 pos; float power; };\n";
    place.write("light.frag", &format!("#version 450\n{light}"));
    for language in landfall_layout::codegen::languages::LANGUAGES {
        let emit =
            ["emit", "light.frag", "--lang", language.name, "--out", "code", "--prefix", "eng_"];
        place.run(&emit).code(0);
        let is_prefixed = language.options.contains(&"--prefix");
        assert_eq!(place.read("code").contains("eng_Light"), is_prefixed, "{}", language.name);
        place.run(&[&emit[..], &["--check"]].concat()).code(0);
        place.write("code", "stale");
        place.run(&[&emit[..], &["--check"]].concat()).code(1);
    }
    let numbered = "struct S { vec3 a; float b[2]; };
        layout(std140) uniform A { S s; } a; layout(std430) buffer B { S s; } b;";
    place.write("two.comp", &format!("#version 450\n{numbered}\nvoid main() {{}}\n"));
    place.run(&["emit", "two.comp", "--lang", "zig", "--out", "code"]).code(0).stderr_eq(str![[
        r#"
warning[numbered-name]: `S` of two.comp is named `S_2`: another type is `S`


"#
    ]]);
}
