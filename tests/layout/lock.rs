//! A lock says what the shader says: written, read and written again it is the same, whatever the
//! block; and what is wrong with one is said with its line.

use snapbox::str;

use crate::support;
use crate::support::command::golden;

use std::path::Path;

use landfall_layout::finding::Level;
use landfall_layout::format::{EmitOptions, Format, document};
use landfall_layout::lock;
use landfall_layout::lock::{Lock, read, write};
use landfall_layout::{BlockLayout, MemberLayout, Options, ShaderLayout, Source, Type, layout};
use landfall_lint::drift::drift;
use support::blocks::print;
use support::files::shaders;
use support::generate::{COMMON, VULKAN, random};
use support::landfall::laid_out_for_vulkan as lay_out;

/// All that can be asked of a block, spans and comments left out.
fn facts(block: &BlockLayout) -> String {
    fn member(m: &MemberLayout) -> String {
        let members: Vec<String> = m.members.iter().map(member).collect();
        let innermost = match m.ty.innermost() {
            Type::Struct(s) => format!("struct {} of {}", s.name, s.members.len()),
            plain => format!("{plain:?}"),
        };
        format!(
            "{} {innermost} {:?} {:?} {:?} {:?} {:?} {:?} {} {members:?}",
            m.name, m.offset, m.size, m.align, m.dims, m.strides, m.matrix_stride, m.row_major
        )
    }
    let members: Vec<String> = block.members.iter().map(member).collect();
    let leaves: Vec<String> = block
        .leaves
        .iter()
        .map(|l| {
            format!(
                "{} {:?} {:?} {:?} {:?} {:?} {:?} {}",
                l.path, l.ty, l.offset, l.dims, l.strides, l.size, l.matrix_stride, l.row_major
            )
        })
        .collect();
    format!(
        "{} {:?} {:?} {:?} {} {:?} {:?} {:?} {:?} {:?} {members:#?} {leaves:#?}",
        block.name,
        block.instance,
        block.space,
        (block.size.is_some()).then_some(block.rules),
        block.rules_declared,
        block.group,
        block.binding,
        block.size,
        block.data_size,
        block.align
    )
}

fn all_facts(blocks: &[BlockLayout]) -> Vec<String> {
    blocks.iter().map(facts).collect()
}

fn holds(shader: &ShaderLayout) {
    let text = write(shader);
    let lock = read("lock.json", &text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    assert_eq!(all_facts(&lock.blocks), all_facts(&shader.blocks), "{text}");
    assert_eq!(lock.text(), text);
    assert_eq!(write(&lock.layout()), text);
    assert!(drift(shader, "lock.json", Some(&lock)).is_empty());
    // The layout's own JSON holds the same blocks.
    let json = document(shader, &EmitOptions::new(Format::Json));
    let lock = read("layout.json", &json).unwrap_or_else(|e| panic!("{e}\n{json}"));
    assert_eq!(all_facts(&lock.blocks), all_facts(&shader.blocks), "{json}");
    assert!(drift(shader, "layout.json", Some(&lock)).is_empty());
}

#[test]
fn random_blocks_survive_being_written_and_read() {
    for seed in 0..12 {
        for diet in [&COMMON, &VULKAN] {
            let (standing, blocks) = random(9_000_000 + seed, 60, diet);
            holds(&lay_out("random.comp", &print(&standing, &blocks.iter().collect::<Vec<_>>())));
        }
    }
}

#[test]
fn the_shaders_of_the_repository_survive_it_too() {
    for path in shaders() {
        for gather in [false, true] {
            let source = Source::read(&path).expect("a readable shader");
            holds(&layout(&source, &Options::default().with_gather(gather)));
        }
    }
}

#[test]
fn what_only_some_shaders_have_survives_it() {
    holds(&lay_out(
        "a.comp",
        "#version 460
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
layout(constant_id = 0) const int N = 3;
layout(buffer_reference, std430) buffer Node { Node next; vec3 at; Node all[2]; };
struct Inner { vec2 a; float b; };
layout(set = 1, binding = 2) uniform Many { Inner inner[N]; } many[2][3];
layout(std430) buffer Tail { Node first; dmat2x3 m[2]; layout(row_major) mat3 rows[]; };
void main() {}
",
    ));
    holds(&lay_out(
        "a.wgsl",
        "override count: u32;
struct Inner { @align(32) a: atomic<u32>, @size(64) b: f32 }
struct Outer { all: array<array<Inner, 2>, 3>, tail: array<vec3<f32>> }
@group(0) @binding(1) var<storage, read_write> outer: Outer;
@group(0) @binding(2) var<storage, read_write> twice: Outer;
@group(0) @binding(3) var<storage> plain: array<mat3x2<f32>>;
",
    ));
    holds(&lay_out("nothing.frag", "#version 330\nvoid main() {}\n"));
    holds(&lay_out(
        "loose.frag",
        "#version 330\nstruct L { vec3 p; sampler2D s; }; struct S { sampler2D t; };
uniform L lights[4]; uniform S s[2]; uniform mat4 m; void main() {}\n",
    ));
}

const SHADER: &str = "#version 450
struct Light { vec3 color; float range; };
layout(std140, binding = 0) uniform Lights { Light all[4]; int count; mat3 turn; } lights;
void main() {}
";

fn refusal(text: &str) -> String {
    match read("layouts/a.frag.json", text) {
        Ok(_) => panic!("this was read:\n{text}"),
        Err(error) => {
            assert!(error.help.is_some(), "{error}");
            assert_eq!(error.path, "layouts/a.frag.json");
            error.message
        }
    }
}

/// The lock of the shader with a part of its text replaced.
fn edited(from: &str, to: &str) -> String {
    let text = write(&lay_out("a.frag", SHADER));
    assert!(text.contains(from), "{from}\n{text}");
    text.replacen(from, to, 1)
}

#[test]
fn a_lock_that_is_cut_short_is_told_from_one_that_is_no_json() {
    let text = write(&lay_out("a.frag", SHADER));
    for end in 1..text.trim_end().len() {
        let message = refusal(&text[..end]);
        assert!(message.starts_with("is cut short: it ends in the middle, at line"), "{message}");
    }
    assert_eq!(refusal(""), "is empty, not a lock");
    assert_eq!(
        refusal(&edited("\"size\": 64, ", "\"size\": 64; ")),
        "is not JSON: line 16, column 68 has `;` where `,` or `}` should be"
    );
    let message = refusal("void main() {}");
    assert_eq!(message, "is not JSON: line 1, column 1 has `v` where a value should be");
    golden().eq(
        refusal("\u{1}\u{2}\u{3}"),
        str![[r#"is not JSON: line 1, column 1 has `\u{1}` where a value should be"#]],
    );
    let deep = "[".repeat(1 << 22);
    assert_eq!(refusal(&deep), "is not a layout: it is nested too deeply, at line 1");
}

#[test]
fn merge_conflicts_are_named_with_their_line() {
    let text = edited("      \"size\"", "<<<<<<< HEAD\n      \"size\"");
    assert_eq!(refusal(&text), "has a merge conflict at line 12: `<<<<<<< HEAD`");
    let text = edited("  \"blocks\"", "=======\n  \"blocks\"");
    assert_eq!(refusal(&text), "has a merge conflict at line 4: `=======`");
}

#[test]
fn a_newer_lock_is_not_guessed_at() {
    let text = edited("\"schema_version\": 1", "\"schema_version\": 7");
    let message = refusal(&text);
    let version = env!("CARGO_PKG_VERSION");
    assert_eq!(
        message,
        format!("has schema version 7, but this landfall ({version}) reads up to 2, at line 2")
    );
    assert!(lock::is_newer(&text));
    assert!(!lock::is_newer(&write(&lay_out("a.frag", SHADER))));
    assert_eq!(refusal("{}"), "is not a lock: it has no `schema_version`");
    assert_eq!(
        refusal("{\"schema_version\": 1}"),
        "is not a lock: it has neither `blocks` nor `shaders`"
    );
}

#[test]
fn values_of_the_wrong_kind_are_named() {
    for (from, to, message) in [
        (
            "\"offset\": 64",
            "\"offset\": \"64\"",
            "has a string where `offset` must be a whole number, at line 20",
        ),
        (
            "\"offset\": 64",
            "\"offset\": -4",
            "has -4 where `offset` must be a whole number up to 4294967296, at line 20",
        ),
        (
            "\"offset\": 64",
            "\"offset\": 6.5",
            "has 6.5 where `offset` must be a whole number up to 4294967296, at line 20",
        ),
        (
            "\"name\": \"Lights\"",
            "\"name\": 3",
            "has a number where `name` must be a string, at line 6",
        ),
        (
            "\"rules\": \"std140\"",
            "\"rules\": \"std141\"",
            "has `std141` where `rules` must be one of std140, std430, scalar, wgsl, relaxed, d3d, \
             explicit, at line 9",
        ),
        (
            "\"rules_declared\": true",
            "\"rules_declared\": 1",
            "has a number where `rules_declared` must be true or false, at line 10",
        ),
        (
            "\"strides\": [16]",
            "\"strides\": 16",
            "has a number where `strides` must be a list, at line 16",
        ),
        (
            "\"language\": \"glsl\"",
            "\"language\": \"hlsl\"",
            "has `hlsl` where `language` must be one of glsl, wgsl, spirv, at line 3",
        ),
        ("\"binding\": 0", "\"biding\": 0", "has an unknown key `biding`, at line 11"),
        (
            "\"align\": 16,\n      \"members\"",
            "\"align\": 16,\n      \"align\": 16,\n      \"members\"",
            "has the key `align` twice in one object, at line 15",
        ),
        (
            "\"type\": \"int\"",
            "\"type\": \"vec5\"",
            "gives `count` the unknown type `vec5`, at line 20",
        ),
        (
            "\"type\": \"int\"",
            "\"type\": \"int[\"",
            "gives `count` the unknown type `int[`, at line 20",
        ),
    ] {
        assert_eq!(refusal(&edited(from, to)), message);
    }
}

#[test]
fn a_lock_that_contradicts_itself_is_refused() {
    for (from, to, message) in [
        ("\"offset\": 64", "\"offset\": 63", "20: `count` is at offset 63, but aligned to 4"),
        (
            "\"offset\": 64",
            "\"offset\": 60",
            "20: `count` at offset 60 overlaps `all`, which occupies 0 to 63",
        ),
        ("\"size\": 64, ", "\"size\": 48, ", "16: `all` is 48 bytes, but its contents take 64"),
        (
            "\"strides\": [16]",
            "\"strides\": [12]",
            "16: `all` has an array stride of 12, but an element takes 16 bytes",
        ),
        ("\"strides\": [16]", "\"strides\": []", "16: `all` has 1 array dimensions and 0 strides"),
        ("\"size\": 128", "\"size\": 112", "6: `Lights` is 112 bytes, but its members end at 128"),
        (
            "\"data_size\": 128",
            "\"data_size\": 124",
            "6: `Lights` has `data_size` 124, but its members end at 128",
        ),
        ("\"name\": \"range\"", "\"name\": \"color\"", "18: the member `color` is listed twice"),
        ("\"matrix_stride\": 16, ", "", "21: `turn` holds matrices, but lacks `matrix_stride`"),
        (
            "\"offset\": 12,",
            "\"offset\": 8,",
            "18: `range` at offset 8 overlaps `color`, which occupies 0 to 11",
        ),
        (
            "\"align\": 4}\n        ]}",
            "\"align\": 3}\n        ]}",
            "18: `range` is aligned to 3, which is not a power of two",
        ),
    ] {
        let text = edited(from, to);
        assert_eq!(refusal(&text), format!("contradicts itself at line {message}"));
    }
}

#[test]
fn a_leaf_that_contradicts_its_member_is_refused() {
    let shader = lay_out("a.frag", SHADER);
    let json = document(&shader, &EmitOptions::new(Format::Json));
    for (from, to, message) in [
        (
            "\"kind\":\"sint\",\"width\":4,\"columns\":1,\"rows\":1,\"offset\":64",
            "\"kind\":\"sint\",\"width\":4,\"columns\":1,\"rows\":1,\"offset\":68",
            "the leaf `count` has `offset` 68, but its member puts it at 64",
        ),
        (
            "{\"path\":\"count\",\"type\":\"int\"",
            "{\"path\":\"count\",\"type\":\"uint\"",
            "the leaf `count` is a `uint`, its member a `int`",
        ),
        ("{\"path\":\"count\"", "{\"path\":\"cuont\"", "no member of `Lights` is the leaf `cuont`"),
        (
            "{\"path\":\"count\"",
            "{\"path\":\"all[].color\"",
            "the leaf `all[].color` is listed twice",
        ),
    ] {
        assert!(json.contains(from), "{from}\n{json}");
        let message_found = refusal(&json.replacen(from, to, 1));
        let (_, said) = message_found.split_once(": ").expect("a line, then what is wrong");
        assert_eq!(said, message);
    }
}

#[test]
fn an_output_about_many_shaders_is_many_locks() {
    let shader = lay_out("a.frag", SHADER);
    let one = document(&shader, &EmitOptions::new(Format::Json));
    let inner =
        one.split_once("\"shaders\":[").expect("shaders").1.rsplit_once("]}").expect("end").0;
    let two = one.replacen(inner, &format!("{},{inner}", inner.trim_end()), 1);
    assert_eq!(refusal(&two), "holds the layouts of 2 shaders, not of one");
    assert_eq!(lock::read_all("a.json", &two).expect("two shaders").len(), 2);
}

#[test]
fn what_was_verified_stays_while_the_layout_does() {
    let shader = lay_out("a.frag", SHADER);
    let verified = "  ],\n  \"verified\": [\n    {\"backend\": \"gl\", \"adapter\": \"llvmpipe\", \"driver\": \"Mesa 22.3.6\", \"version\": \"0.1.0\"}\n  ]\n}\n";
    let text = write(&shader).replace("  ]\n}\n", verified);
    let lock = read("a.json", &text).expect("a lock");
    assert_eq!(lock.verified[0].adapter, "llvmpipe");
    assert_eq!(lock::renew(&shader, Some(&lock)), text);
    let other = lay_out("a.frag", &SHADER.replace("int count", "uint count"));
    assert_eq!(lock::renew(&other, Some(&lock)), write(&other));
    assert!(!write(&other).contains("verified"));
}

/// The lock of one text held against another text.
fn drifted(old: &str, new: &str) -> Vec<landfall_layout::finding::Finding> {
    let lock: Lock = read("layouts/a.frag.json", &write(&lay_out("a.frag", old))).expect("a lock");
    drift(&lay_out("a.frag", new), "layouts/a.frag.json", Some(&lock))
}

#[test]
fn layout_drift_says_what_moved_with_both_numbers() {
    let new = SHADER.replace("float range;", "float range; vec2 size;");
    let found = drifted(SHADER, &new);
    assert_eq!(found.len(), 1, "{found:#?}");
    let drift = &found[0];
    assert_eq!((drift.code.as_str(), drift.level()), ("layout-drift", Level::Deny));
    assert_eq!(drift.about, "Lights");
    assert_eq!(
        drift.message,
        "`Lights` differs from its lock: `all` changed its array stride from 16 to 32; \
         buffers filled for the lock's layout are misread"
    );
    assert_eq!(
        (drift.place().path.as_str(), drift.place().line, drift.place().column),
        ("a.frag", 3, 37)
    );
    assert_eq!(
        (drift.related()[0].at.path.as_str(), drift.related()[0].at.line),
        ("layouts/a.frag.json", 6)
    );
    golden().eq(
        drift.notes.join("\n"),
        str![[r#"
breaking: `all[].size` (`vec2`) is inserted at 16, where old uploads have `all[1].color`
breaking: `count` moved from 64 to 128
breaking: `turn` moved from 80 to 144
compatible: grew from 128 to 192 bytes: make its buffer 192 bytes
"#]],
    );
    let listing = drift.listing.as_deref().expect("both listings");
    golden().eq(
        listing,
        str![[r#"
-     128  uniform Lights lights std140 binding 0
-   0  64    Light all[4] stride 16
+     192  uniform Lights lights std140 binding 0
+   0 128    Light all[4] stride 32
    0  12      vec3 color
   12   4      float range
-  64   4    int count
-  68  12    -- hole
-  80  48    mat3 turn columns 16
+  16   8      vec2 size
+  24   8      -- tail padding
+ 128   4    int count
+ 132  12    -- hole
+ 144  48    mat3 turn columns 16

"#]],
    );
    // The good twin: comments, spaces and names of the shader's own do not matter.
    let same = SHADER.replace("float range;", "float  range; // offset 99\n\n");
    assert!(drifted(SHADER, &same).is_empty());
}

#[test]
fn drift_that_misreads_nothing_is_said_in_other_words() {
    let found = drifted(SHADER, &SHADER.replace("int count;", "int count, more;"));
    assert_eq!(
        found[0].message,
        "`Lights` differs from its lock: `more` (`int`) uses former padding at 68; \
         buffers filled for it are still read correctly, but the lock is out of date"
    );
    let found = drifted(SHADER, &SHADER.replace("range", "reach"));
    assert_eq!(
        found[0].message,
        "`Lights` differs from its lock: `all[].range` was renamed to `reach`, in the same place; \
         no byte changes, but the lock is out of date"
    );
    golden().eq(
        found[0].help.clone().unwrap_or_default(),
        str!["renew the lock with `landfall check --accept` or `landfall lock`"],
    );
}

#[test]
fn a_shader_without_a_lock_and_a_lock_without_a_shader_are_reported() {
    let shader = lay_out("a.frag", SHADER);
    let found = drift(&shader, "layouts/a.frag.json", None);
    assert_eq!(found.len(), 1);
    assert_eq!(
        (found[0].code.as_str(), found[0].place().path.as_str()),
        ("lock-missing", "a.frag")
    );
    assert_eq!(found[0].message, "`a.frag` has no lock: changes of its layout go unseen");
    golden().eq(found[0].notes[0].clone(), str!["its lock would be `layouts/a.frag.json`"]);
    // The good twin has nothing to lock.
    let empty = lay_out("a.frag", "#version 330\nvoid main() {}\n");
    assert!(drift(&empty, "layouts/a.frag.json", None).is_empty());
    let orphan = landfall_lint::drift::orphan("layouts/gone.frag.json");
    assert_eq!(orphan.message, "`layouts/gone.frag.json` is a lock without a shader");
    assert_eq!((orphan.code.as_str(), orphan.level()), ("lock-orphan", Level::Warn));
    assert_eq!(
        lock::path_of(Path::new("layouts"), Path::new("x/a.frag")),
        Path::new("layouts/x/a.frag.json")
    );
}
