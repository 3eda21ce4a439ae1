//! Writes the comments that [`allow`](super::allow) reads: `// landfall: allow(code)` above a line,
//! `// landfall: allow-file(code)` at the start of a file.

use std::collections::{BTreeMap, BTreeSet};

use super::allow::comments;
use landfall_layout::finding::{Edit, Place};
use landfall_layout::source::{Files, Language, Span};

/// Returns the insertions that allow these codes in these lines of a text.
///
/// None above a line inside a block comment or a continued line, where a comment would have no
/// effect or change the code.
pub fn above_lines(
    path: &str,
    text: &str,
    language: Language,
    codes: &BTreeMap<u32, BTreeSet<&str>>,
) -> Vec<Edit> {
    let files = files(path, text);
    let comments = comments(text, language);
    let starts: Vec<usize> =
        std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
    let mut edits = Vec::new();
    for (line, codes) in codes {
        let Some(start) = starts.get((*line as usize).wrapping_sub(1)) else { continue };
        // The comments are in order, so only the last one before the line can reach into it.
        let before = comments.partition_point(|comment| comment.start < *start);
        let is_inside = before > 0 && comments[before - 1].end > *start;
        let above = text[..*start].strip_suffix('\n').unwrap_or_default();
        // A `\` at the end continues a line: the comment would be part of a macro.
        let is_continued = above.strip_suffix('\r').unwrap_or(above).ends_with('\\');
        if is_inside || is_continued {
            continue;
        }
        let rest = &text[*start..];
        let indent = &rest[..rest.len() - rest.trim_start_matches([' ', '\t']).len()];
        edits.push(insertion(
            &files,
            text,
            *start,
            format!("{indent}// landfall: allow({})", list(codes)),
        ));
    }
    edits
}

/// Returns the insertion that allows these codes in a whole file: below `#version`, which some
/// engines expect in the first line.
pub fn in_file(path: &str, text: &str, codes: &BTreeSet<&str>) -> Edit {
    // The start of the file, or behind the line of `#version`.
    let mut start = 0;
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        at += line.len();
        if line.trim_start().starts_with("#version") && line.ends_with('\n') {
            start = at;
            break;
        }
    }
    insertion(&files(path, text), text, start, format!("// landfall: allow-file({})", list(codes)))
}

fn files(path: &str, text: &str) -> Files {
    let mut files = Files::default();
    files.add(path, text.into());
    files
}

fn list(codes: &BTreeSet<&str>) -> String {
    codes.iter().copied().collect::<Vec<_>>().join(", ")
}

/// The insertion of a line, with the line ends of the text.
fn insertion(files: &Files, text: &str, at: usize, line: String) -> Edit {
    // The first line tells which line ends the file has.
    let first = text.find('\n').is_some_and(|end| text[..end].ends_with('\r'));
    let end = if first { "\r\n" } else { "\n" };
    let place = Place::new(files, Span { file: 0, start: at as u32, end: at as u32 });
    Edit { at: place, new: line + end }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::allow::allows;

    fn written(text: &str, lines: &[(u32, &'static str)]) -> String {
        let mut codes: BTreeMap<u32, BTreeSet<&str>> = BTreeMap::new();
        for (line, code) in lines {
            codes.entry(*line).or_default().insert(code);
        }
        let mut text = text.to_string();
        let edits = above_lines("a.frag", &text, Language::Glsl, &codes);
        for edit in edits.into_iter().rev() {
            text.insert_str(edit.at.start as usize, &edit.new);
        }
        text
    }

    #[test]
    fn a_comment_has_the_indentation_and_line_end_of_its_line() {
        let text = "struct S {\r\n\tvec3 a; // 3\r\n};\r\n";
        let new = written(text, &[(2, "stale-comment"), (2, "vec3-array")]);
        let expected = "struct S {\r\n\t// landfall: allow(stale-comment, vec3-array)\r\n\tvec3 a; // 3\r\n};\r\n";
        assert_eq!(new, expected);
        let mut files = Files::default();
        files.add("a.frag", new.into());
        let lines: Vec<_> = allows(&files, Language::Glsl).iter().map(|a| a.lines).collect();
        assert_eq!(lines, [Some((2, 3)); 2], "they are read as written");
    }

    #[test]
    fn no_comment_is_put_into_a_comment_or_a_macro() {
        for text in ["/*\n offset 3\n*/\n", "#define A \\\n b\n", "#define A \\\r\n b\r\n"] {
            assert_eq!(written(text, &[(2, "stale-comment")]), text);
        }
        assert_ne!(written("/* a */\nb\n", &[(2, "stale-comment")]), "/* a */\nb\n");
        assert_eq!(written("a\n", &[(9, "stale-comment"), (0, "stale-comment")]), "a\n");
    }

    #[test]
    fn a_comment_for_a_file_stands_below_the_version() {
        let codes = BTreeSet::from(["stale-comment"]);
        let of = |text: &str| in_file("a.frag", text, &codes).at.start;
        assert_eq!(of("// notice\n#version 450\nvoid main() {}\n"), 23);
        assert_eq!(of("@group(0) @binding(0) var<uniform> a: f32;\n"), 0);
        assert_eq!(of("#version 450"), 0);
    }
}
