//! Doc comments: the shader's own words, then offset and size.
//!
//! Made by [`super::plan`] with each mirror, printed by [`super::mirror`].

use crate::layout::{BlockLayout, MemberLayout};
use crate::shape::{Rules, Struct};
use crate::source::{Files, Language, Span};

use super::array::{reach, tight_size};
use super::plan::{by_offset, structure_align};

/// The shader a mirror comes from.
#[derive(Clone, Copy)]
pub(super) struct Origin<'a> {
    pub(super) files: &'a Files,
    pub(super) language: Language,
    /// What the shader is called in the output.
    pub(super) input: &'a str,
}

/// What is said about a mirror, and what sets it apart from another of its name.
pub(super) struct MirrorDoc {
    /// Lines of documentation, as they stand after `/// `.
    pub(super) lines: Vec<String>,
    /// The same for each field, in ascending order of offset.
    pub(super) fields: Vec<Vec<String>>,
    /// What the shader calls it.
    pub(super) shader_name: String,
    /// The shader.
    pub(super) input: String,
    /// What can be added to its name, in this order, to tell it from others of that name.
    pub(super) marks: [&'static str; 4],
}

impl MirrorDoc {
    pub(super) fn of_block(
        block: &BlockLayout,
        members: &[MemberLayout],
        at: &Origin<'_>,
    ) -> MirrorDoc {
        let size = block.size.unwrap_or(0);
        let mut lines = comment(at.files, &block.comment);
        paragraph(&mut lines);
        let runtime = members.len() < block.members.len();
        let part = if runtime { "the part before the runtime-sized tail of " } else { "" };
        let fact = format!(
            "`{}`: {part}a {} block of {}, {}",
            block.name,
            block.space.name(),
            place(at, block.span),
            block.rules.name()
        );
        lines.push(if runtime { format!("{fact}.") } else { format!("{fact}, size {size}.") });
        MirrorDoc {
            lines,
            fields: fields(members, at),
            shader_name: block.name.to_string(),
            input: at.input.to_string(),
            marks: ["Block", rules_mark(block.rules), order_mark(members), ""],
        }
    }

    pub(super) fn of_structure(
        s: &Struct,
        members: &[MemberLayout],
        size: u64,
        rules: Rules,
        at: &Origin<'_>,
    ) -> MirrorDoc {
        let name = if s.name.is_empty() { "struct" } else { &s.name };
        let mut lines = before(at.files, s.span);
        paragraph(&mut lines);
        let (place, rules_name) = (place(at, s.span), rules.name());
        lines.push(format!("`{name}`: a structure of {place}, {rules_name}, size {size}."));
        let cut = size < reach(members).next_multiple_of(structure_align(members, rules));
        if cut {
            lines.push("What follows it begins in the padding at its end.".to_string());
        }
        let end = if cut { "Tight" } else { "" };
        MirrorDoc {
            lines,
            fields: fields(members, at),
            shader_name: name.to_string(),
            input: at.input.to_string(),
            marks: ["", rules_mark(rules), order_mark(members), end],
        }
    }
}

fn rules_mark(rules: Rules) -> &'static str {
    match rules {
        Rules::Std140 => "Std140",
        Rules::Std430 => "Std430",
        Rules::Scalar => "Scalar",
        Rules::Wgsl => "Wgsl",
    }
}

fn order_mark(members: &[MemberLayout]) -> &'static str {
    if members.iter().any(stores_rows) { "RowMajor" } else { "" }
}

fn stores_rows(member: &MemberLayout) -> bool {
    member.row_major || member.members.iter().any(stores_rows)
}

/// File and line: the shader's name, or that of the include the span is in.
fn place(at: &Origin<'_>, span: Span) -> String {
    let location = at.files.locate(span);
    let path = if span.file == 0 { at.input } else { super::header::relative(&location.path) };
    format!("`{path}:{}`", location.line)
}

fn fields(members: &[MemberLayout], at: &Origin<'_>) -> Vec<Vec<String>> {
    by_offset(members).iter().map(|&(_, order)| field(&members[order], at)).collect()
}

fn field(member: &MemberLayout, at: &Origin<'_>) -> Vec<String> {
    let mut lines = comment(at.files, &member.comment);
    paragraph(&mut lines);
    let offset = member.offset.unwrap_or(0);
    let size = member.size.unwrap_or_else(|| tight_size(member, 0));
    let mut fact = format!(
        "`{} {}`: offset {offset}, size {size}",
        member.ty.spelled(at.language),
        member.name
    );
    if let [stride] = member.strides[..] {
        fact.push_str(&format!(", stride {stride}"));
    } else if !member.strides.is_empty() {
        let strides: Vec<String> = member.strides.iter().map(u64::to_string).collect();
        fact.push_str(&format!(", strides {}", strides.join(" and ")));
    }
    if let Some(stride) = member.matrix_stride {
        let lines = if member.row_major { "rows" } else { "columns" };
        fact.push_str(&format!(", {lines} {stride} bytes apart"));
    }
    fact.push('.');
    lines.push(fact);
    lines
}

/// An empty line between what was said and what follows.
fn paragraph(lines: &mut Vec<String>) {
    if !lines.is_empty() {
        lines.push(String::new());
    }
}

/// The text of comments as lines of documentation.
pub(super) fn comment(files: &Files, spans: &[Span]) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for span in spans {
        for line in bare(files.text(*span)) {
            // One empty line parts paragraphs; more say nothing.
            if !line.is_empty() || lines.last().is_some_and(|last| !last.is_empty()) {
                lines.push(line);
            }
        }
    }
    while lines.last().is_some_and(String::is_empty) {
        lines.pop();
    }
    lines
}

/// The comments right before the declaration of a structure, whose name is at `span`: the model
/// has those of blocks and members only.
fn before(files: &Files, span: Span) -> Vec<String> {
    let text = files.get(span.file).map_or("", |file| &file.text);
    let Some(mut text) = text.get(..span.start as usize) else { return Vec::new() };
    text = text.trim_end();
    text = text.strip_suffix("struct").unwrap_or(text);
    let mut found = Vec::new();
    loop {
        let rest = text.trim_end();
        // An empty line parts a comment from what follows it.
        if text[rest.len()..].bytes().filter(|b| *b == b'\n').count() > 1 {
            break;
        }
        let line = rest.rfind('\n').map_or(0, |end| end + 1);
        let start = if rest[line..].trim_start().starts_with("//") {
            line
        } else if rest.ends_with("*/") {
            let start = rest.rfind("/*").unwrap_or(rest.len());
            // A comment after something else on its line is that one's.
            match rest[..start].rsplit('\n').next() {
                Some(alone) if alone.trim().is_empty() => start,
                _ => break,
            }
        } else {
            break;
        };
        let (from, to) = (start as u32, rest.len() as u32);
        found.push(Span { file: span.file, start: from, end: to });
        text = &rest[..start];
    }
    found.reverse();
    comment(files, &found)
}

/// The lines of one comment without the signs that make it one.
fn bare(comment: &str) -> Vec<String> {
    let comment = comment.trim();
    let (inside, sign) = match comment.strip_prefix("/*") {
        Some(rest) => (rest.strip_suffix("*/").unwrap_or(rest), '*'),
        None => (comment, '/'),
    };
    inside
        .split(['\n', '\r'])
        .map(|line| {
            // `///`, `/**`, and Doxygen's `//!<`.
            let line = line.trim().trim_start_matches(sign);
            let line = line.strip_prefix('!').unwrap_or(line);
            let line = line.strip_prefix('<').unwrap_or(line);
            markdown(undecorated(line.trim_end_matches(sign).trim()))
        })
        .collect()
}

/// A line without the rules that people draw at its ends: `---- lights ----`.
fn undecorated(line: &str) -> &str {
    let mut line = line;
    for sign in ['=', '-', '~', '*', '#', '_', '/'] {
        let inner = line.trim_start_matches(sign);
        if inner.is_empty() || line.len() - inner.len() > 2 {
            line = inner;
        }
        let inner = line.trim_end_matches(sign);
        if line.len() - inner.len() > 2 {
            line = inner;
        }
    }
    line.trim()
}

/// Plain words such that rustdoc, rustc and clippy take them for nothing else: no links, HTML,
/// lists, headings, code blocks or letters that turn the direction of text.
fn markdown(line: &str) -> String {
    let code = line.matches('`').count().is_multiple_of(2) && !line.contains("``");
    let mut inside = false;
    let mut result = String::with_capacity(line.len());
    for (at, letter) in line.char_indices() {
        match letter {
            '`' if code => inside = !inside,
            '\t' => {
                result.push(' ');
                continue;
            }
            // rustc denies these in comments (`text_direction_codepoint_in_comment`).
            '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => continue,
            letter if letter.is_control() => continue,
            '[' | ']' | '<' | '>' | '\\' | '`' | '*' | '|' if !inside => result.push('\\'),
            '#' | '+' if at == 0 => result.push('\\'),
            '-' if at == 0 && line.starts_with("- ") => result.push('\\'),
            // `1. ` and `1) ` begin a list.
            '.' | ')' if at > 0 && line[..at].bytes().all(|b| b.is_ascii_digit()) => {
                result.push('\\')
            }
            // A bare address is to stand in angle brackets.
            ':' if !inside && line[at..].starts_with("://") => result.push('\\'),
            _ => {}
        }
        result.push(letter);
    }
    result.trim_end().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cleaned(comment_text: &str) -> Vec<String> {
        let mut files = Files::default();
        let file = files.add("a.frag", comment_text.into());
        comment(&files, &[Span { file, start: 0, end: comment_text.len() as u32 }])
    }

    #[test]
    fn comment_signs_are_taken_off() {
        assert_eq!(cleaned("// in metres"), ["in metres"]);
        assert_eq!(cleaned("//!< in metres"), ["in metres"]);
        assert_eq!(cleaned("/* in metres */"), ["in metres"]);
        assert_eq!(
            cleaned("/**\n * World space.\n *\n *\n * In metres.\n */"),
            ["World space.", "", "In metres."]
        );
        assert_eq!(cleaned("//////////////////"), [""; 0]);
        assert_eq!(cleaned("// ---- lights ----"), ["lights"]);
    }

    #[test]
    fn what_markdown_would_take_for_more_is_escaped() {
        assert_eq!(cleaned("// data[3] <T> `x[1]`"), [r"data\[3\] \<T\> `x[1]`"]);
        assert_eq!(cleaned("// 1. first"), [r"1\. first"]);
        assert_eq!(cleaned("// # x"), [r"\# x"]);
        assert_eq!(cleaned("// - x"), [r"\- x"]);
        assert_eq!(cleaned("// -1 is off"), ["-1 is off"]);
        assert_eq!(cleaned("// see https://a.b"), [r"see https\://a.b"]);
        assert_eq!(cleaned("// one ` tick"), [r"one \` tick"]);
        assert_eq!(cleaned("//\ta\tb\u{202e}"), ["a b"]);
    }
}
