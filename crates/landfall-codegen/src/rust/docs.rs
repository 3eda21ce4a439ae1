//! Doc comments of mirrors: the shader's comments, then offset and size.
//!
//! [`super::plan`] makes them with each mirror; [`super::mirror`] prints them.

use std::path::Path;

use landfall_layout::layout::{BlockLayout, MemberLayout, measure};
use landfall_layout::shape::{AddressSpace, Rules, Struct};
use landfall_layout::source::{Files, Language, Span};
use landfall_layout::text::escape;

use super::array::tight_size;
use super::plan::by_offset;

/// The shader a mirror comes from.
#[derive(Clone, Copy)]
pub(super) struct Origin<'a> {
    pub(super) files: &'a Files,
    pub(super) language: Language,
    /// The shader's name in the output.
    pub(super) input: &'a str,
}

/// The documentation of a mirror, and the marks that distinguish it from mirrors of the same name.
pub(super) struct MirrorDoc {
    /// The shader's comment, without `/// `.
    comment: Vec<String>,
    /// The declaration that it mirrors, with its file and line.
    fact: String,
    /// Its size in bytes, unless it mirrors only a part.
    size: Option<u64>,
    /// Whether the next member starts in its tail padding.
    cut: bool,
    /// The rules that give this layout.
    rules: Vec<Rules>,
    /// The documentation of each field, in ascending order of offset.
    pub(super) fields: Vec<Vec<String>>,
    /// The declaration of each member, in source order.
    pub(super) declared: Vec<String>,
    /// Its name in the shader.
    pub(super) shader_name: String,
    pub(super) input: String,
    /// Name suffixes: for a block, for row-major matrices, for no tail padding.
    marks: [&'static str; 3],
}

impl MirrorDoc {
    pub(super) fn of_block(
        block: &BlockLayout,
        members: &[MemberLayout],
        at: &Origin<'_>,
    ) -> MirrorDoc {
        let runtime = members.len() < block.members.len();
        let part = if runtime { "the part before the runtime-sized tail of " } else { "" };
        let place = place(at, block.span);
        let kind = match block.space {
            AddressSpace::Structure => "structure".to_string(),
            space => format!("{} block", space.name()),
        };
        MirrorDoc {
            comment: comment(at.files, &block.comment),
            fact: format!("`{}`: {part}a {kind} of {place}", block.name),
            size: block.size.filter(|_| !runtime),
            cut: false,
            rules: vec![block.rules],
            fields: fields(members, at),
            declared: members.iter().map(|member| declared(member, at.language)).collect(),
            shader_name: block.name.to_string(),
            input: at.input.to_string(),
            marks: ["Block", order_mark(members), ""],
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
        // The structure is cut where the next member begins in its padding.
        let end = measure::structure(members, rules);
        let cut = size < end.data_size.next_multiple_of(end.align);
        MirrorDoc {
            comment: before(at.files, s.span),
            fact: format!("`{name}`: a structure of {}", place(at, s.span)),
            size: Some(size),
            cut,
            rules: vec![rules],
            fields: fields(members, at),
            declared: members.iter().map(|member| declared(member, at.language)).collect(),
            shader_name: name.to_string(),
            input: at.input.to_string(),
            marks: ["", order_mark(members), if cut { "Tight" } else { "" }],
        }
    }

    /// Records that `rules` give the same layout.
    pub(super) fn also_by(&mut self, rules: Rules) {
        if !self.rules.contains(&rules) {
            self.rules.push(rules);
        }
    }

    /// Its documentation lines, without `/// `.
    pub(super) fn lines(&self) -> Vec<String> {
        let mut lines = self.comment.clone();
        paragraph(&mut lines);
        let rules: Vec<&str> = self.rules.iter().map(|rules| rules.name()).collect();
        let size = self.size.map_or(String::new(), |size| format!(", size {size}"));
        lines.push(format!("{}, {}{size}.", self.fact, rules.join(" and ")));
        if self.cut {
            lines.push("What follows it begins in the padding at its end.".to_string());
        }
        lines
    }

    pub(super) fn rules(&self) -> &[Rules] {
        &self.rules
    }

    /// The suffixes that distinguish mirrors of the same name, in the order they are tried, where
    /// these rules lay it out.
    pub(super) fn marks(&self, rules: &[Rules]) -> [&'static str; 4] {
        let [block, order, end] = self.marks;
        // Mirrors of several rules at once have no mark of one of them.
        let rules = match rules[..] {
            [one] => rules_mark(one),
            // The common case needs no mark.
            _ => "",
        };
        [block, rules, order, end]
    }
}

fn rules_mark(rules: Rules) -> &'static str {
    match rules {
        Rules::Std140 => "Std140",
        Rules::Std430 => "Std430",
        Rules::Scalar => "Scalar",
        Rules::Wgsl => "Wgsl",
        Rules::Explicit(_) => "Explicit",
    }
}

fn order_mark(members: &[MemberLayout]) -> &'static str {
    if members.iter().any(stores_rows) { "RowMajor" } else { "" }
}

fn stores_rows(member: &MemberLayout) -> bool {
    member.row_major || member.members.iter().any(stores_rows)
}

/// `FILE:LINE` of a span, in the shader or an include.
fn place(at: &Origin<'_>, span: Span) -> String {
    let location = at.files.locate(span);
    let path = match span.file {
        0 => at.input.to_string(),
        _ => escape::comment(relative(&location.path)),
    };
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
    let mut fact = format!("`{}`: offset {offset}, size {size}", declared(member, at.language));
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

/// A member's declaration in the shader's language.
fn declared(member: &MemberLayout, language: Language) -> String {
    let (name, ty) = (&member.name, member.ty.spelled(language).to_string());
    match language {
        Language::Glsl | Language::SpirV => {
            let (of, dims) = ty.split_at(ty.find('[').unwrap_or(ty.len()));
            format!("{of} {name}{dims}")
        }
        Language::Wgsl => format!("{name}: {ty}"),
    }
}

/// Adds an empty line unless there are no lines yet.
fn paragraph(lines: &mut Vec<String>) {
    if !lines.is_empty() {
        lines.push(String::new());
    }
}

/// The text of comments as lines of documentation.
pub(super) fn comment(files: &Files, spans: &[Span]) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for span in spans {
        for line in comment_lines(files.text(*span)) {
            // One empty line separates paragraphs; the others are dropped.
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

/// The comments right before the declaration of a structure, whose name is at `span`; the model
/// only holds those of blocks and members.
fn before(files: &Files, span: Span) -> Vec<String> {
    let text = files.get(span.file).map_or("", |file| &file.text);
    let Some(mut text) = text.get(..span.start as usize) else { return Vec::new() };
    text = text.trim_end();
    text = text.strip_suffix("struct").unwrap_or(text);
    let mut found = Vec::new();
    // From the name backwards: comment after comment, as long as nothing but white space is
    // between.
    loop {
        let rest = text.trim_end();
        // An empty line ends the association of a comment with what follows.
        if text[rest.len()..].bytes().filter(|b| *b == b'\n').count() > 1 {
            break;
        }
        let line = rest.rfind('\n').map_or(0, |end| end + 1);
        let start = if rest[line..].trim_start().starts_with("//") {
            line
        } else if rest.ends_with("*/") {
            let start = rest.rfind("/*").unwrap_or(rest.len());
            // A comment after code on its line belongs to that code.
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

/// The lines of one comment without its markers.
fn comment_lines(comment: &str) -> Vec<String> {
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

/// Strips decoration from both ends of a line: `---- lights ----`.
fn undecorated(line: &str) -> &str {
    let mut line = line;
    // A run of three or more signs at either end is decoration, and so is a line of nothing else:
    // `-1` and `*p` stay.
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

/// Escapes a line for rustdoc, rustc and clippy: no links, HTML, lists, headings, code blocks or
/// bidirectional characters.
fn markdown(line: &str) -> String {
    // Code stays as it is, if its backticks are paired.
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
            letter if escape::is_bidi(letter) => continue,
            letter if letter.is_control() => continue,
            '[' | ']' | '<' | '>' | '\\' | '`' | '*' | '|' if !inside => result.push('\\'),
            '#' | '+' if at == 0 => result.push('\\'),
            '-' if at == 0 && line.starts_with("- ") => result.push('\\'),
            // `1. ` and `1) ` begin a list.
            '.' | ')' if at > 0 && line[..at].bytes().all(|b| b.is_ascii_digit()) => {
                result.push('\\')
            }
            // rustdoc warns of bare URLs (`bare_urls`).
            ':' if !inside && line[at..].starts_with("://") => result.push('\\'),
            _ => {}
        }
        result.push(letter);
    }
    result.trim_end().to_string()
}

/// A path independent of the machine: an absolute one is reduced to its file name.
pub(super) fn relative(path: &str) -> &str {
    let path = path.strip_prefix("./").unwrap_or(path);
    if Path::new(path).is_absolute() {
        Path::new(path).file_name().and_then(|name| name.to_str()).unwrap_or(path)
    } else {
        path
    }
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
