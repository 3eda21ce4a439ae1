//! `stale-comment` where no word that it knows says what a number counts: columns in any language,
//! half-open and inclusive ranges, running totals, counts of floats. The numbers of the layouts were
//! worked out by hand from std140.

use super::{Fixture, Score};

/// A member: name, and in bytes its offset, size, alignment and where the next one starts.
type Row = (&'static str, u64, u64, u64, u64);

/// 48 bytes.
const BLOCK: &[Row] = &[
    ("vec3 color", 0, 12, 16, 12),
    ("float power", 12, 4, 4, 16),
    ("vec4 ambient", 16, 16, 16, 32),
    ("vec2 range", 32, 8, 8, 40),
    ("float bias", 40, 4, 4, 44),
    ("int kind", 44, 4, 4, 48),
];

/// The same with a `vec4` behind `color`, which nobody commented.
const GROWN: &[Row] = &[
    ("vec3 color", 0, 12, 16, 16),
    ("vec4 added", 16, 16, 16, 32),
    ("float power", 32, 4, 4, 48),
    ("vec4 ambient", 48, 16, 16, 64),
    ("vec2 range", 64, 8, 8, 72),
    ("float bias", 72, 4, 4, 76),
    ("int kind", 76, 4, 4, 80),
];

/// Comments as people write them, `{o}` for the offset, `{e}` for the end, `{l}` for the last byte,
/// `{s}` for the size, `{a}` for the alignment, `{f}`, `{g}` and `{n}` for the offset, the last and
/// the number in floats, `{x}` for the offset in hexadecimal.
#[rustfmt::skip]
const FORMS: &[&str] = &[
    "{o}", "({o})", "[{o}]", "+{o}", "+0x{x}", "0x{x}", "{o}: what it is", "[{o}] what it is",
    "what it is ({o})", "@ {o}",
    // Ranges.
    "[{o}, {e})", "{o}..{e}", "[{o}-{l}]", "{o}–{l}", "{o} -> {e}", "bytes {o}-{l}", "[{o}:{l}]",
    // Running totals.
    "{e}", "{o} + {s} = {e}", "so far {e}", "up to {e}",
    // Floats.
    "floats {f}..{g}", "float offset {f}", "{f} floats in",
    // Columns.
    "{o} | {s}", "{a} {o} {s}", "{o}, {s}",
    // Other languages.
    "desplazamiento {o}", "décalage : {o}", "смещение {o}", "オフセット {o}", "오프셋: {o}, 크기: {s}",
    "przesunięcie {o}", "η θέση είναι {o}",
];

/// Numbers that are something else, one a member.
#[rustfmt::skip]
const OTHERS: &[[&str; 6]] = &[
    ["0", "1", "2", "3", "4", "5"], ["1", "2", "4", "8", "16", "32"], ["c0", "c1", "c2", "c3", "c4", "c5"],
    ["unit 0", "unit 4", "unit 8", "unit 12", "unit 16", "unit 20"],
    ["0-1", "0-255", "0-16", "1-4", "0-360", "0-8"], ["1.0", "0.5", "16", "32", "0.1", "8"],
    ["default 0", "default 10", "default 20", "default 30", "default 40", "default 50"],
    ["2010", "2011", "2012", "2013", "2014", "2015"], ["5%", "10%", "15%", "20%", "25%", "30%"],
    ["[0, 1]", "[0, 2]", "[0, 3]", "[0, 4]", "[0, 5]", "[0, 6]"],
    ["0x4", "0x8", "0x10", "0x20", "0x40", "0x80"], ["x0", "x4", "x8", "x12", "x16", "x20"],
    ["16 steps", "32 samples", "4 taps", "8 lights", "2 cascades", "64 at most"],
    ["0 on the CPU", "12 on the CPU", "24 on the CPU", "40 on the CPU", "48 on the CPU", "52 on the CPU"],
    ["location 0", "location 1", "location 2", "location 3", "location 4", "location 5"],
    ["rgb", "in watts", "see #12", "unused", "w is 1", "0 = off"],
    ["0", "4", "8", "100", "3", "1"], ["step 1", "step 2", "step 3", "step 4", "step 5", "step 6"],
];

fn comment(form: &str, row: &Row) -> String {
    let &(_, offset, size, align, _) = row;
    form.replace("{o}", &offset.to_string())
        .replace("{e}", &(offset + size).to_string())
        .replace("{l}", &(offset + size - 1).to_string())
        .replace("{s}", &size.to_string())
        .replace("{a}", &align.to_string())
        .replace("{f}", &(offset / 4).to_string())
        .replace("{g}", &((offset + size) / 4 - 1).to_string())
        .replace("{x}", &format!("{offset:02x}"))
}

/// A block of those members, the first of them on line 3.
fn block(rows: &[Row], comments: &[String]) -> String {
    let lines = rows.iter().zip(comments).map(|((member, ..), comment)| match comment.as_str() {
        "" => format!("    {member};\n"),
        comment => format!("    {member}; // {comment}\n"),
    });
    let lines: String = lines.collect();
    format!(
        "#version 330 core\nlayout(std140) uniform Block {{\n{lines}}} u_block;\nvoid main() {{}}\n"
    )
}

fn fixture(name: &str, rows: &[Row], comments: &[String], wrong: &[u32]) -> Fixture {
    let text = block(rows, comments);
    let expected: Vec<(&str, u32)> = wrong.iter().map(|line| ("a.frag", *line)).collect();
    Fixture::of(name, &[("a.frag", &text)], &expected)
}

#[test]
fn numbers_in_the_same_place_of_comments_are_read_in_any_language() {
    let mut all = Vec::new();
    for form in FORMS {
        let right: Vec<String> = BLOCK.iter().map(|row| comment(form, row)).collect();
        all.push(fixture(&format!("right: {form}"), BLOCK, &right, &[]));
        // One member's numbers are off.
        let mut typo = right.clone();
        let (member, offset, size, align, next) = BLOCK[3];
        typo[3] = comment(form, &(member, offset + 4, size, align, next));
        all.push(fixture(&format!("one wrong: {form}"), BLOCK, &typo, &[6]));
        // A member was inserted, and the comments stayed.
        let mut old = right.clone();
        old.insert(1, String::new());
        all.push(fixture(&format!("inserted: {form}"), GROWN, &old, &[5, 6, 7, 8, 9]));
    }
    for other in OTHERS {
        let comments: Vec<String> = other.iter().map(|text| text.to_string()).collect();
        all.push(fixture(other[0], BLOCK, &comments, &[]));
        let mut grown = comments.clone();
        grown.insert(1, String::new());
        all.push(fixture(other[0], GROWN, &grown, &[]));
    }
    Score::of("stale-comment", &all).at_least(1.0, 0.99);
}

#[test]
fn sizes_are_counted_in_floats_and_vectors() {
    let above = |text: &str| {
        block(BLOCK, &vec![String::new(); BLOCK.len()])
            .replace("layout(std140)", &format!("// {text}\nlayout(std140)"))
    };
    let behind = |text: &str| {
        block(BLOCK, &vec![String::new(); BLOCK.len()])
            .replace("} u_block;", &format!("}} u_block; // {text}"))
    };
    let mut all = Vec::new();
    for (right, wrong) in [
        ("12 floats", "16 floats"),
        ("12 words", "20 words"),
        ("3 vec4s", "4 vec4s"),
        ("sum 48", "sum 64"),
        ("sizeof == 48", "sizeof == 40"),
    ] {
        all.push(Fixture::of(right, &[("a.frag", &above(right))], &[]));
        all.push(Fixture::of(right, &[("a.frag", &behind(right))], &[]));
        all.push(Fixture::of(wrong, &[("a.frag", &above(wrong))], &[("a.frag", 2)]));
        all.push(Fixture::of(wrong, &[("a.frag", &behind(wrong))], &[("a.frag", 9)]));
    }
    all.push(Fixture::of("= 48", &[("a.frag", &behind("= 48"))], &[]));
    all.push(Fixture::of("= 64", &[("a.frag", &behind("= 64"))], &[("a.frag", 9)]));
    all.push(Fixture::of("3 floats", &[("a.frag", &above("8 lights, 3 floats each"))], &[]));
    Score::of("stale-comment", &all).at_least(1.0, 1.0);
}
