//! `stale-comment`.

use std::path::Path;

use landfall_lint::lint;
use snapbox::str;

use super::{edited, found_in, messages, only, place};
use crate::support::command::golden;

const CODE: &str = "stale-comment";

fn fixture(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/lints").join(CODE).join(name);
    std::fs::read_to_string(path).expect("the fixture is there")
}

/// A std140 block of those members.
fn block(members: &str) -> String {
    format!(
        "#version 330 core\nlayout(std140) uniform B {{\n{members}\n}} b;\nout vec4 o;\n\
         void main() {{ o = vec4(0.0); }}\n"
    )
}

#[test]
fn the_alignment_of_a_vec3_is_not_12() {
    let finding = only(found_in(CODE, "light.frag", lint(CODE).unwrap().example));
    assert_eq!(finding.message, "comment aligns `color` to 12 bytes, but it is aligned to 16");
    assert_eq!(finding.about, "PointLight.color alignment");
    assert_eq!(place(&finding), "4:35");
    assert_eq!(finding.help.as_deref(), Some("write 16 instead of 12"));
    assert_eq!(finding.related().len(), 1);
    assert_eq!((finding.related()[0].at.line, finding.related()[0].at.column), (7, 24));
    let listing = finding.listing.expect("the block's listing");
    golden().eq(
        &listing,
        str![[r#"
/*            align(16) size(32) */ struct PointLight {
/* offset( 0) align(16) size(12) */     vec3 pos;
/* offset(12)           size( 4) */     // -- hole
/* offset(16) align(16) size(12) */     vec3 color;
/* offset(28) align( 4) size( 4) */     float intensity;
/*                               */ };

/*           align(16) size(128)            */ layout(std140) uniform PointLightBlock {
/* offset(0) align(16) size(128) stride(32) */     PointLight data[4];
/*                                          */ } u_lights;
// 128 bytes: 112 used, 16 padding (12.5 %)
"#]],
    );
}

#[test]
fn the_bad_twin_becomes_the_good_one_digit_by_digit() {
    let (bad, good) = (fixture("bad.frag"), fixture("good.frag"));
    let findings = found_in(CODE, "bad.frag", &bad);
    assert_eq!(edited(&bad, &findings), good, "{:#?}", messages(&findings));
    assert_eq!(messages(&found_in(CODE, "good.frag", &good)), [""; 0]);
}

#[test]
fn an_edit_is_of_digits_only() {
    let bad = fixture("bad.frag");
    for finding in found_in(CODE, "bad.frag", &bad) {
        assert!(!finding.fix.is_empty(), "{finding:#?}");
        for edit in &finding.fix {
            let old = &bad[edit.at.start as usize..edit.at.end as usize];
            for number in [old, &edit.new] {
                let digits = number.trim_start_matches("0x");
                assert!(digits.chars().all(|c| c.is_ascii_hexdigit()), "{number:?}");
            }
            assert_eq!(old.starts_with("0x"), edit.new.starts_with("0x"));
        }
    }
}

#[test]
fn every_wording_is_read() {
    // The member is at offset 16, aligned to 16, 12 bytes long; each comment is off.
    let wrong = [
        "offset:12",
        "offset: 12",
        "offset 12",
        "Offset = 12",
        "offset(12)",
        "offset is 12",
        "@ 12",
        "@ 0x0c",
        "@12",
        "byte offset: 12",
        "offset 12 bytes",
        "offset in bytes: 12",
        "the colour, offset 12",
        "colour (offset 12)",
        "offset 12: the colour",
        "offset 12 - the colour",
        "offset 12; align 16",
        "offset 12.",
        "colour align:16 offset:12",
        "偏移:12",
        "偏移量：12",
        "偏移 12 字节",
        "字节偏移：12",
        "颜色 偏移:12",
        "颜色，偏移12",
        "alignment:12",
        "align 8",
        "align = 8, offset 16",
        "alignment of 8",
        "align(8)",
        "base alignment: 12",
        "对齐:12",
        "对齐 12",
        "对齐：8，偏移：16",
        "基准对齐量 12",
        "20 bytes",
        "24 bytes.",
        "24字节",
        "size = 24",
        "size: 24 bytes",
        "size(24)",
        "sizeof = 24",
        "takes 24 bytes",
        "大小 24",
        "大小：24字节",
        "占24字节",
        "offsets 12-23",
        "offsets 16-29",
        "offset 12..24",
        "offset 0x0C",
        "align 16, size 24",
    ];
    for comment in wrong {
        let text = block(&format!("vec4 a;\nvec3 color; // {comment}\nvec4 z;"));
        let findings = found_in(CODE, "a.frag", &text);
        assert_eq!(findings.len(), 1, "{comment}: {:#?}", messages(&findings));
        let mended = edited(&text, &findings);
        assert_ne!(mended, text, "{comment}");
        assert_eq!(messages(&found_in(CODE, "a.frag", &mended)), [""; 0], "{mended}");
    }
}

#[test]
fn right_numbers_are_right_in_every_reading() {
    let right = [
        "offset 16",
        "@ 0x10",
        "alignment:16 offset:16",
        "12 bytes",
        "16 bytes",
        "size 12",
        "size = 16",
        "28 bytes",
        "32 bytes",
        "offsets 16-27",
        "offsets 16-28",
        "offset 16..32",
        "16 - 28",
        "size 3",
        "对齐:16 偏移:16",
        "12字节",
        "占 16 字节",
        "16字节对齐",
    ];
    for comment in right {
        let text = block(&format!("vec4 a;\nvec3 color; // {comment}\nvec4 z;"));
        assert_eq!(messages(&found_in(CODE, "a.frag", &text)), [""; 0], "{comment}");
    }
}

#[test]
fn numbers_about_something_else_are_let_be() {
    let other = [
        "0",
        "12",
        "0 - 1",
        "0..255",
        "[0, 1]",
        "12 of them",
        "8 bytes of padding here",
        "Will be 24-byte packed",
        "8b boundary",
        "8-byte aligned on the host",
        "offset 12 is used by the vertex shader",
        "offset of the table is 12 bytes",
        "uv offset: 4",
        "tile size: 24",
        "shadow map size = 1024",
        "4 bytes of padding before",
        "size 1024x768",
        "offset 0.5",
        "align 0.5",
        "offset -12",
        "offset 4 * 3",
        "12.5 bytes",
        "offset = 12;",
        "layout(offset = 12) vec3 color",
        "vec3 color; offset 12;",
        "#define N 12",
        "was at offset 12 before",
        "offset 12 in std430",
        "24 bytes in C++",
        "offset 12 on the CPU",
        "stride 12 for std430, 16 for std140",
        "should be offset 12",
        "case 2: vec3",
        "see issue 12",
        "RGB, 8 bits each",
        "12 bytes + 4 padding",
        "needs 4 bytes of padding",
        "binding 3",
        "set 0, binding 2",
        "x 12 bytes",
        "最多 12 个",
        "第 12 个",
        "8字节对齐的地方",
        "1: on, 0: off",
        "total lights: 12",
    ];
    for comment in other {
        let text = block(&format!("vec4 a;\nvec3 color; // {comment}\nvec4 z;"));
        assert_eq!(messages(&found_in(CODE, "a.frag", &text)), [""; 0], "{comment}");
    }
}

#[test]
fn a_number_that_the_member_holds_is_no_size() {
    for member in [
        "int mapSize; // size: 1024",
        "float radius; // size 10",
        "vec2 texel; // size 7",
        "int offset; // offset 5",
        "uint stride; // stride: 32",
        "int tableStart; // offset: 3",
    ] {
        let text = block(&format!("vec4 a;\n{member}"));
        assert_eq!(messages(&found_in(CODE, "a.frag", &text)), [""; 0], "{member}");
    }
}

#[test]
fn offsets_may_count_from_the_block_or_in_words() {
    let text = "#version 330 core\nstruct S { vec3 p; // offset 16\n float q; // offset 28\n };\n\
                layout(std140) uniform B { vec4 a; S s; } b; out vec4 o;\n\
                void main() { o = b.a; }";
    assert_eq!(messages(&found_in(CODE, "a.frag", text)), [""; 0]);
    // With one that counts from the block, the others are taken to do so too.
    let text = text.replace("offset 28", "offset 24");
    assert_eq!(only(found_in(CODE, "a.frag", &text)).fix[0].new, "28");
    let words = block("vec4 a; // offset 0\nvec3 b; // offset 4\nfloat c; // offset 7\n");
    assert_eq!(messages(&found_in(CODE, "a.frag", &words)), [""; 0]);
}

#[test]
fn a_structure_of_two_rules_is_judged_where_both_agree() {
    let shader = |comment: &str| {
        format!(
            "#version 450\nstruct S {{ float a; float w[2]; // {comment}\n }};\n\
             layout(std140, binding = 0) uniform U {{ S s; }} u;\n\
             layout(std430, binding = 1) buffer V {{ S s; }} v;\n\
             void main() {{ }}"
        )
    };
    // In std140 `w` is at 16, in std430 at 4.
    for right in ["offset 16", "offset 4", "offset 8", "stride 16", "stride 4"] {
        assert_eq!(messages(&found_in(CODE, "a.comp", &shader(right))), [""; 0], "{right}");
    }
    let same =
        shader("x").replace("float a; float w[2]; // x", "float a; // offset 4\n float w[2];");
    let finding = only(found_in(CODE, "a.comp", &same));
    assert_eq!(finding.message, "comment puts `a` at offset 4, but it is at 0");
}

#[test]
fn what_is_not_laid_out_for_certain_is_not_judged() {
    let loose = "#version 330 core\nstruct L { vec3 p; // offset 4\n }; uniform L l; out vec4 o;\n\
                 void main() { o = vec4(l.p, 1.0); }";
    assert_eq!(messages(&found_in(CODE, "a.frag", loose)), [""; 0]);
    let bare = block("vec3 a; // offset 4").replace("layout(std140) ", "");
    assert_eq!(messages(&found_in(CODE, "a.frag", &bare)), [""; 0]);
    let condition = block("#ifdef FOG\nvec4 fog;\n#endif\nvec3 a; // offset 16");
    assert_eq!(messages(&found_in(CODE, "a.frag", &condition)), [""; 0]);
    let several = block("vec4 z;\nfloat a, b; // offset 20");
    assert_eq!(messages(&found_in(CODE, "a.frag", &several)), [""; 0]);
}

#[test]
fn wgsl_is_read_too() {
    let text = "struct Light {\n    pos: vec3f,   // offset(0)  align(16) size(12)\n    \
                color: vec3f, // offset(12) align(16) size(12)\n    \
                power: f32,   // offset(28) align(4)  size(4)\n}\n// 28 bytes\n\
                struct Fog { near: f32, far: f32 } // 16 bytes\n\
                @group(0) @binding(0) var<uniform> light: Light;\n\
                @group(0) @binding(1) var<uniform> fog: Fog;\n";
    let findings = found_in(CODE, "a.wgsl", text);
    assert_eq!(
        messages(&findings),
        [
            "comment puts `color` at offset 12, but it is at 16",
            "comment says `Fog` is 28 bytes, but it is 8",
            "comment says `Fog` is 16 bytes, but it is 8",
        ]
    );
}

#[test]
fn each_offset_in_our_shaders_is_read_and_right() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    let (mut stated, mut told) = (0, 0);
    for folder in std::fs::read_dir(root).expect("our shaders").map(|e| e.unwrap().path()) {
        let Ok(files) = std::fs::read_dir(&folder) else { continue };
        for path in files.map(|entry| entry.unwrap().path()) {
            let Ok(text) = std::fs::read_to_string(&path) else { continue };
            // Includes are found next to the file that has them.
            if text.contains("#include") || landfall_layout::source::kind_of_path(&path).is_none() {
                continue;
            }
            let name = path.to_str().unwrap();
            assert_eq!(messages(&found_in(CODE, name, &text)), [""; 0], "{name}");
            // `// offset 16` at the end of a member's line; off by 2 it is no word or row either.
            for (at, _) in text.match_indices("// offset ") {
                let digits = at + "// offset ".len();
                let length = text[digits..].find(|c: char| !c.is_ascii_digit()).unwrap_or(0);
                let Ok(offset) = text[digits..digits + length].parse::<u64>() else { continue };
                let mut wrong = text.clone();
                wrong.replace_range(digits..digits + length, &(offset + 2).to_string());
                stated += 1;
                let findings = found_in(CODE, name, &wrong);
                let here = findings.iter().any(|f| f.place().start as usize == digits);
                told += usize::from(here);
                let line = text[at..].lines().next().unwrap_or("");
                let others: Vec<_> =
                    findings.iter().filter(|f| f.place().start as usize != digits).collect();
                assert!(others.is_empty(), "{name}: {line}: {others:#?}");
            }
        }
    }
    // The rest are behind an `#if`, or of loose uniforms.
    assert!(stated > 150 && told * 100 >= stated * 95, "{told} of {stated} are told");
}

#[test]
fn hostile_comments_are_passed_over() {
    let long = block(&format!("vec3 a; // {}", "offset 4 ".repeat(20_000)));
    found_in(CODE, "a.frag", &long);
    let wide = block(&format!("vec3 a; //{}", " // 16".repeat(50_000)));
    found_in(CODE, "a.frag", &wide);
    let chinese = block(&format!("vec3 a; // {}", "偏移".repeat(50_000)));
    found_in(CODE, "a.frag", &chinese);
    let one_line: String = (0..5_000).map(|n| format!("vec3 m{n}; /* offset 4 */ ")).collect();
    found_in(CODE, "a.frag", &block(&one_line));
    for odd in
        ["offset 99999999999999999999999", "offset 0x", "@ 0xZZ", "offset ：", "//|//|", "- 3 -"]
    {
        found_in(CODE, "a.frag", &block(&format!("vec3 a; // {odd}\nvec3 b; /* {odd} */")));
    }
}
