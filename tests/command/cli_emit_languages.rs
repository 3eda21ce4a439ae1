//! `landfall emit` in each language of the table, and with types of the program.

use snapbox::str;

use crate::support::command::Place;

#[test]
fn every_language_is_written_checked_and_prefixed() {
    let place = Place::new("emit-languages");
    let light = "layout(std140) uniform Light { vec3 pos; float power; };\n";
    place.write("light.frag", format!("#version 450\n{light}"));
    for language in landfall_codegen::languages::LANGUAGES {
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
    place.write("two.comp", format!("#version 450\n{numbered}\nvoid main() {{}}\n"));
    place.run(&["emit", "two.comp", "--lang", "zig", "--out", "code"]).code(0).stderr_eq(str![[
        r#"
warning[numbered-name]: `S` of two.comp is named `S_2`: another type is `S`


"#
    ]]);
}

#[test]
fn a_list_says_what_each_language_is_for() {
    let place = Place::new("emit-list");
    place.run(&["emit", "--list"]).code(0).stderr_eq("").stdout_eq(str![[r#"
rust        `#[repr(C)]` structures for bytemuck, offsets checked at compile time
c           A header for C11 and C++17, offsets checked at compile time
csharp      C# structures with explicit offsets, and a method that checks them
python      A Python module of NumPy data types, offsets checked on import
typescript  A TypeScript module of classes over a `DataView`, with typed arrays
zig         Zig extern structures, offsets checked at compile time
gdscript    A Godot script that reads and writes members in a `PackedByteArray`
renderdoc   Formats for RenderDoc's buffer viewer, one for each block

"#]]);
    place.run(&["emit", "--list", "--lang", "zig", "a.frag"]).code(2).stdout_eq("");
}

#[test]
fn types_of_the_program_come_from_flags_and_the_configuration() {
    let place = Place::new("emit-types");
    let light = "layout(std140) uniform Light { vec3 pos; float power; vec3 color; };\n";
    place.write("light.frag", format!("#version 450\n{light}"));
    place.write("landfall.toml", "[types]\nvec3 = \"crate::Vec\"\nmat4 = \"crate::Mat\"\n");
    let emit = ["emit", "light.frag", "--lang", "rust"];
    let flagged = [&emit[..], &["--type", "Light.pos=crate::Pos<f32>"]].concat();
    let ran = place.run(&flagged);
    ran.code(0).stderr_eq("");
    for field in ["pub pos: crate::Pos<f32>,", "pub color: crate::Vec,", "pub power: f32,"] {
        assert!(ran.out.contains(field), "{field}: {}", ran.out);
    }
    place.run(&[&emit[..], &["--type", "mat3=crate::Mat"]].concat()).code(0).stderr_eq(str![[r#"
warning[unused-option]: the type for `mat3` has no effect: no member is one
  |
  = help: write a type as the shader spells it, or `STRUCTURE.MEMBER`


"#]]);
    place
        .run(&[&emit[..], &["--type", "vec3=crate::Vec; fn"]].concat())
        .code(2)
        .stdout_eq("")
        .stderr_eq(str![[r#"
error[bad-name]: `vec3` cannot have the type `crate::Vec; fn`: it is no path in Rust
  |
  = help: write a path such as `crate::engine::Pos3` or `nalgebra::Vector3<f32>`


"#]]);
}
