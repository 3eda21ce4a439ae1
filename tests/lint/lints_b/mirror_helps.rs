//! The helps of `rust-mirror`, followed: all of one structure together put its fields where the
//! shader reads them. Where that is was computed by hand from std140's rules; where the fields then
//! are says rustc.

use std::fmt::Write;

use landfall_layout::finding::Finding;

use crate::lints_b::mirror::held;
use crate::lints_b::rustc::{Math, crates, run, scratch};
use crate::support::sample::sample;

/// Members of a std140 block, fields of a wrong mirror, and the bytes at which each member is, then
/// the size of the block.
#[rustfmt::skip]
type Case = (&'static str, &'static str, &'static [(&'static str, u64)], u64);

const CASES: &[Case] = &[
    (
        "vec3 direction; vec3 color; float gain;",
        "direction: [f32; 3]; color: [f32; 3]; gain: f32",
        &[("direction", 0), ("color", 16), ("gain", 28)],
        32,
    ),
    (
        "float e[5]; vec2 size; float weight[3]; int swap;",
        "e: [f32; 5]; size: [f32; 2]; weight: [f32; 3]; swap: i32",
        &[("e", 0), ("size", 80), ("weight", 96), ("swap", 144)],
        160,
    ),
    ("vec3 color; float gain;", "color: glam::Vec3A; gain: f32", &[("color", 0), ("gain", 12)], 16),
    (
        "mat3 turn; int count;",
        "turn: [[f32; 3]; 3]; _pad: [f32; 3]; count: i32; _end: [i32; 3]",
        &[("turn", 0), ("count", 48)],
        64,
    ),
    (
        "vec3 color; vec3 place;",
        "color: [f32; 3]; _pad: [f32; 2]; place: [f32; 3]",
        &[("color", 0), ("place", 16)],
        32,
    ),
    (
        "vec3 color; float gain; vec3 place;",
        "place: [f32; 3]; gain: f32; color: [f32; 3]",
        &[("color", 0), ("gain", 12), ("place", 16)],
        32,
    ),
    (
        "vec4 color; float gain; int kind;",
        "color: [f32; 4]; kind: i32",
        &[("color", 0), ("gain", 16), ("kind", 20)],
        32,
    ),
    (
        "bool on; vec2 at; bool off;",
        "on: bool; at: [f32; 2]; off: bool",
        &[("on", 0), ("at", 8), ("off", 16)],
        32,
    ),
    ("float a; vec3 b;", "a: f32; extra: [f32; 8]; b: [f32; 3]", &[("a", 0), ("b", 16)], 32),
    (
        "float a; mat2 m; vec3 s[2]; float b;",
        "a: f32; m: [[f32; 2]; 2]; s: [[f32; 3]; 2]; b: f32",
        &[("a", 0), ("m", 16), ("s", 48), ("b", 80)],
        96,
    ),
    ("float w[2][3]; float b;", "w: [[f32; 3]; 2]; b: f32", &[("w", 0), ("b", 96)], 112),
    (
        "vec2 a; vec4 b;",
        "a: [f32; 2]; _p0: f32; _p1: f32; _p2: f32; b: [f32; 4]",
        &[("a", 0), ("b", 16)],
        32,
    ),
];

fn mirror(fields: &[String]) -> String {
    let lines: String = fields.iter().map(|field| format!("    pub {field},\n")).collect();
    format!("// landfall: mirror(Light)\n#[repr(C)]\npub struct Light {{\n{lines}}}\n")
}

fn shader(members: &str) -> String {
    format!("#version 430\nlayout(std140) uniform Light {{\n{members}\n}};\nvoid main() {{}}\n")
}

/// The words in backticks of a text.
fn quoted(text: &str) -> Vec<&str> {
    text.split('`').skip(1).step_by(2).collect()
}

fn name(field: &str) -> &str {
    field.split(':').next().unwrap_or("").trim()
}

/// Follows the help of a finding.
fn follow(fields: &mut Vec<String>, finding: &Finding) {
    let own = finding.about.strip_prefix("Light.").unwrap_or("").to_string();
    let help = finding.help.clone().unwrap_or_default();
    // An order of the fields, told once, mends several.
    if help.is_empty() {
        return;
    }
    // `make `a` `T`: `b` follows directly in the shader` is one edit.
    let help = help.replace(", which is not", " which is not");
    if let Some(order) = help.strip_prefix("declare its fields in the order ") {
        let old = std::mem::take(fields);
        for word in quoted(order) {
            let whole = old.iter().find(|field| name(field) == word);
            fields.push(whole.map_or(word.to_string(), String::clone));
        }
        return;
    }
    let mut edits: Vec<String> = Vec::new();
    for part in help.split(", and ").flat_map(|part| part.split(" and ")) {
        match (edits.last_mut(), part.starts_with('`')) {
            (Some(last), true) => last.push_str(&format!(" and {part}")),
            (_, _) => edits.push(part.to_string()),
        }
    }
    for edit in edits {
        let words = quoted(&edit);
        let at = |name_: &str| fields.iter().position(|field| name(field) == name_);
        let at = |word: &str| at(word).unwrap_or_else(|| panic!("{edit}: no {word} in {fields:?}"));
        if edit.starts_with("make it ") && edit.ends_with(" elements long") {
            let len = edit.split(' ').nth(2).expect("a number");
            let field = at(&own);
            let element = fields[field].rsplit_once(';').expect("an array").0.to_string();
            fields[field] = format!("{element}; {len}]");
        } else if edit.starts_with("make it `") {
            let field = at(&own);
            fields[field] = match words[0].contains(": ") {
                true => words[0].to_string(),
                false => format!("{own}: {}", words[0]),
            };
        } else if edit.starts_with("make `") {
            let field = at(words[0]);
            fields[field] = format!("{}: {}", words[0], words[1]);
        } else if edit.starts_with("put `") {
            let field = at(words[1]);
            fields.insert(field, words[0].to_string());
        } else if edit == "remove it" || edit.starts_with("remove it, or name it") {
            let field = at(&own);
            fields.remove(field);
        } else if edit.starts_with("remove `") {
            for word in words {
                let field = fields.iter().position(|field| name(field) == word).expect("it stands");
                fields.remove(field);
            }
        } else if edit.starts_with("end the structure with") || edit.starts_with("end it with") {
            fields.push(words[0].to_string());
        } else if edit.starts_with("add `") {
            let (new, field) = match edit.ends_with(" first") {
                true => (&words[..], 0),
                false => (&words[..words.len() - 1], at(words[words.len() - 1]) + 1),
            };
            new.iter().rev().for_each(|word| fields.insert(field, word.to_string()));
        } else if edit.starts_with("rename it to") {
            let field = at(&own);
            let ty = fields[field].split_once(": ").expect("a type").1.to_string();
            fields[field] = format!("{}: {ty}", words[0]);
        } else {
            panic!("nobody can follow: {edit}");
        }
    }
}

fn mended(members: &str, fields: &[String]) -> Vec<String> {
    let found = held(&mirror(fields), &shader(members));
    assert!(!found.is_empty(), "{members}: {fields:?}");
    assert!(found.iter().filter(|finding| finding.listing.is_some()).count() == 1, "{found:#?}");
    let mut fields = fields.to_vec();
    found.iter().for_each(|finding| follow(&mut fields, finding));
    let left = held(&mirror(&fields), &shader(members));
    assert_eq!(left, [], "{members}: followed {found:#?}: {fields:?}");
    fields
}

#[test]
fn all_helps_together_put_every_field_where_the_shader_reads_it() {
    let mut program = String::from("#![allow(dead_code)]\nfn main() {}\n");
    for (at, (members, fields, places, size)) in CASES.iter().enumerate() {
        let fields: Vec<String> = fields.split("; ").map(str::to_string).collect();
        // A length has a `; ` of its own.
        let fields = fields.iter().fold(Vec::new(), |mut joined: Vec<String>, part| {
            match joined
                .last_mut()
                .filter(|last| last.matches('[').count() > last.matches(']').count())
            {
                Some(last) => last.push_str(&format!("; {part}")),
                None => joined.push(part.clone()),
            }
            joined
        });
        let text = mirror(&mended(members, &fields)).replace("Light {", &format!("Light{at} {{"));
        program.push_str(&text);
        for (field, offset) in *places {
            writeln!(
                program,
                "const _: () = assert!(core::mem::offset_of!(Light{at}, {field}) == {offset});"
            )
            .expect("a string takes all");
        }
        writeln!(program, "const _: () = assert!(size_of::<Light{at}>() >= {size});")
            .expect("a string takes all");
    }
    let root = scratch("lint").join("followed_helps.rs");
    std::fs::write(&root, program).expect("scratch can be written to");
    run(crates(Math::Simd), &root, "2021");
}

/// A small generator of numbers.
struct Dice(u64);

impl Dice {
    fn roll(&mut self, below: usize) -> usize {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % below
    }
}

#[test]
fn helps_of_random_mirrors_can_be_followed() {
    const TYPES: &[(&str, &[&str])] = &[
        ("float X", &["f32", "[f32; 2]"]),
        ("vec2 X", &["[f32; 2]", "glam::Vec2", "[f32; 3]"]),
        ("vec3 X", &["[f32; 3]", "glam::Vec3A", "glam::Vec3", "[f32; 2]"]),
        ("vec4 X", &["[f32; 4]", "glam::Vec4", "[f32; 3]"]),
        ("int X", &["i32", "i16"]),
        ("mat3 X", &["[[f32; 4]; 3]", "[[f32; 3]; 3]", "glam::Mat3"]),
        ("mat2 X", &["[[f32; 2]; 2]", "[[f32; 4]; 2]"]),
        ("float X[3]", &["[f32; 3]", "[[f32; 4]; 3]", "[[f32; 4]; 2]"]),
        ("vec3 X[2]", &["[[f32; 3]; 2]", "[[f32; 4]; 2]"]),
        ("vec4 X[2]", &["[[f32; 4]; 2]", "[f32; 4]"]),
    ];
    let (mut tried, mut wrong) = (0, 0);
    for seed in sample(0..30, 10) {
        let mut dice = Dice(seed);
        for _ in 0..200 {
            let (mut members, mut fields) = (String::new(), Vec::new());
            for at in 0..1 + dice.roll(6) {
                let (member, types) = TYPES[dice.roll(TYPES.len())];
                members.push_str(&format!("{}; ", member.replace('X', &format!("m{at}"))));
                // Fields that mirror no member are for the cases above: two helps are about each.
                if dice.roll(12) == 0 {
                    fields.push(format!("_pad{at}: [f32; {}]", 1 + dice.roll(3)));
                }
                if dice.roll(12) > 0 {
                    fields.push(format!("m{at}: {}", types[dice.roll(types.len())]));
                }
            }
            if dice.roll(10) == 0 && fields.len() > 1 {
                let (a, b) = (dice.roll(fields.len()), dice.roll(fields.len()));
                fields.swap(a, b);
            }
            tried += 1;
            if !fields.is_empty() && !held(&mirror(&fields), &shader(&members)).is_empty() {
                mended(&members, &fields);
                wrong += 1;
            }
        }
    }
    assert!(3 * wrong > 2 * tried, "{wrong} of {tried}");
}
