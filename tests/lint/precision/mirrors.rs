//! `rust-mirror`. Where rustc puts the fields of a `#[repr(C)]` structure of `f32`, `u32` and arrays
//! of them follows from their sizes, and where std140 puts the members from its rules. `//<` marks
//! each field that has to be reported.

use landfall_lint::Settings;
use landfall_lint::settings::RustFile;

use super::{Fixture, Score};

/// Members of a std140 block, and fields of structures written for it by hand.
const MIRRORS: &[(&str, &[&str])] = &[
    (
        "vec3 color; float power; vec3 place; float reach;",
        &[
            "color: [f32; 3], power: f32, place: [f32; 3], reach: f32,",
            "color: [f32; 3],\npower: f32,\nplace: [f32; 3],\nreach: f32,",
            "place: [f32; 3], //<\npower: f32,\ncolor: [f32; 3], //<\nreach: f32,",
            "color: [f32; 3],\npower: u32, //<\nplace: [f32; 3],\nreach: f32,",
        ],
    ),
    (
        "vec3 color; vec3 place;",
        &[
            "color: [f32; 3], _pad: f32, place: [f32; 3], _pad2: f32,",
            "color: [f32; 4], place: [f32; 4],",
            "color: [f32; 3],\nplace: [f32; 3], //<",
            "color: [f32; 3],\n_pad: [f32; 2],\nplace: [f32; 3], //<",
        ],
    ),
    (
        "float weights[2]; vec2 scale;",
        &[
            "weights: [[f32; 4]; 2], scale: [f32; 2], _pad: [f32; 2],",
            "weights: [f32; 2], //<\n_pad: [f32; 6],\nscale: [f32; 2],\n_end: [f32; 2],",
        ],
    ),
    (
        "mat3 turn; int count;",
        &[
            "turn: [[f32; 4]; 3], count: i32, _pad: [i32; 3],",
            "turn: [[f32; 3]; 3], //<\n_pad: [f32; 3],\ncount: i32,\n_end: [i32; 3],",
        ],
    ),
];

#[test]
fn structures_written_by_hand() {
    let fixture = |members: &str, fields: &str| {
        let shader = format!(
            "#version 330 core\nlayout(std140) uniform Light {{ {members} }};\nvoid main() {{}}\n"
        );
        let rust =
            format!("// landfall: mirror(Light)\n#[repr(C)]\nstruct Light {{\n{fields}\n}}\n");
        let marked = rust.lines().zip(1..).filter(|(line, _)| line.ends_with("//<"));
        let expected: Vec<(&str, u32)> = marked.map(|(_, line)| ("light.rs", line)).collect();
        let file = RustFile { path: "light.rs".into(), text: rust.as_str().into() };
        Fixture::of(fields, &[("a.frag", &shader)], &expected)
            .with(Settings { rust_files: vec![file], ..Settings::default() })
    };
    let all = MIRRORS
        .iter()
        .flat_map(|(members, mirrors)| mirrors.iter().map(move |fields| fixture(members, fields)));
    Score::of("rust-mirror", &all.collect::<Vec<_>>()).at_least(1.0, 1.0);
}
