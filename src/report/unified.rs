//! Unified diffs of a file's changes, for `patch -p1` and `git apply`.
//!
//! Used by `--diff` to show the edits of [`fix`](landfall_lint::fix).

use landfall_layout::text::escape::is_bidi;
use similar::algorithms::{Capture, Compact, Replace, myers};
use similar::{ChangeTag, DiffOp, group_diff_ops};

pub use landfall_layout::format::paint::{HEADING, PLAIN, Paint, REMOVED, STRONG};

/// The lines of context around a change.
const CONTEXT: usize = 3;

/// Git's marker for a last line without a newline.
const NO_NEWLINE: &str = "\\ No newline at end of file\n";

/// Returns the diff of the file at `path`; empty if nothing changed.
pub fn diff(path: &str, old: &str, new: &str, paint: Paint) -> String {
    // Only `\n` ends a line for `patch`: a lone `\r` is a byte like any other.
    let (before, after) = (lines(old), lines(new));
    let mut text = String::new();
    for group in group_diff_ops(operations(&before, &after), CONTEXT) {
        let (Some(first), Some(last)) = (group.first(), group.last()) else { continue };
        if text.is_empty() {
            let head = format!("--- {}\n+++ {}\n", name("a/", path), name("b/", path));
            text.push_str(&paint.text(STRONG, &head));
        }
        let removed = first.old_range().start..last.old_range().end;
        let added = first.new_range().start..last.new_range().end;
        text.push_str(&format!("@@ -{} +{} @@\n", numbers(removed), numbers(added)));
        for op in &group {
            for change in op.iter_changes(&before[..], &after[..]) {
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

/// Returns the operations that turn one text into the other. `similar::capture_diff_slices` does
/// the same, but compiles all six algorithms.
fn operations(before: &[&str], after: &[&str]) -> Vec<DiffOp> {
    let mut hook = Compact::new(Replace::new(Capture::new()), before, after);
    let Ok(()) = myers::diff(&mut hook, before, 0..before.len(), after, 0..after.len());
    hook.into_inner().into_inner().into_ops()
}

fn lines(text: &str) -> Vec<&str> {
    text.split_inclusive('\n').collect()
}

/// Returns the range of a hunk header: the first line, from 1, and the number of lines.
fn numbers(lines: std::ops::Range<usize>) -> String {
    match lines.len() {
        // An empty range names the line before it.
        0 => format!("{},0", lines.start),
        1 => (lines.start + 1).to_string(),
        len => format!("{},{len}", lines.start + 1),
    }
}

/// Returns a path for a header: quoted where git quotes it, followed by a tab if it has a space.
fn name(side: &str, path: &str) -> String {
    let path = path.trim_start_matches("./").trim_start_matches('/');
    let plain = |c: char| !c.is_control() && !is_bidi(c) && c != '"' && c != '\\';
    if path.chars().all(plain) {
        // As git does: a tab tells `patch` where a path with a space ends.
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
