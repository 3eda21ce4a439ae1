//! The unified diff of a change to a file, as `patch -p1` and `git apply` take it.
//!
//! For `--diff`, of what [`fix`](landfall_lint::fix) would do.

use landfall_layout::text::escape::is_bidi;
use similar::{ChangeTag, TextDiff};

pub use landfall_layout::format::paint::{HEADING, PLAIN, Paint, REMOVED, STRONG};

/// Lines around a change.
const CONTEXT: usize = 3;

/// What git writes where a last line has no end.
const NO_NEWLINE: &str = "\\ No newline at end of file\n";

/// The change of the file at `path`; empty when there is none.
pub fn diff(path: &str, old: &str, new: &str, paint: Paint) -> String {
    // Only `\n` ends a line for `patch`: a lone `\r` is a byte like any other.
    let (before, after) = (lines(old), lines(new));
    let diff = TextDiff::from_slices(&before, &after);
    let mut text = String::new();
    for group in diff.grouped_ops(CONTEXT) {
        let (Some(first), Some(last)) = (group.first(), group.last()) else { continue };
        if text.is_empty() {
            let head = format!("--- {}\n+++ {}\n", name("a/", path), name("b/", path));
            text.push_str(&paint.text(STRONG, &head));
        }
        let removed = first.old_range().start..last.old_range().end;
        let added = first.new_range().start..last.new_range().end;
        text.push_str(&format!("@@ -{} +{} @@\n", numbers(removed), numbers(added)));
        for op in &group {
            for change in diff.iter_changes(op) {
                let (sign, style) = match change.tag() {
                    ChangeTag::Equal => (' ', PLAIN),
                    ChangeTag::Delete => ('-', REMOVED),
                    ChangeTag::Insert => ('+', HEADING),
                };
                let line: &str = change.value();
                let whole = line.strip_suffix('\n');
                text.push_str(&paint.text(style, &format!("{sign}{}", whole.unwrap_or(line))));
                text.push('\n');
                if whole.is_none() {
                    text.push_str(NO_NEWLINE);
                }
            }
        }
    }
    text
}

fn lines(text: &str) -> Vec<&str> {
    text.split_inclusive('\n').collect()
}

/// First line, from 1, and how many; nothing stands behind the line before it.
fn numbers(lines: std::ops::Range<usize>) -> String {
    match lines.len() {
        0 => format!("{},0", lines.start),
        1 => (lines.start + 1).to_string(),
        len => format!("{},{len}", lines.start + 1),
    }
}

/// A path in a header: quoted where git quotes it, and ended by a tab where it has a space.
fn name(side: &str, path: &str) -> String {
    let path = path.trim_start_matches("./").trim_start_matches('/');
    let plain = |c: char| !c.is_control() && !is_bidi(c) && c != '"' && c != '\\';
    if path.chars().all(plain) {
        let end = if path.contains(' ') { "\t" } else { "" };
        return format!("{side}{path}{end}");
    }
    let mut quoted = format!("\"{side}");
    for byte in path.bytes() {
        match byte {
            b'"' | b'\\' => quoted.extend(['\\', char::from(byte)]),
            0..0x20 | 0x7f.. => quoted.push_str(&format!("\\{byte:03o}")),
            byte => quoted.push(char::from(byte)),
        }
    }
    quoted + "\""
}
