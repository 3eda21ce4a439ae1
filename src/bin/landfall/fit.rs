//! Fits messages to the width of a terminal. What goes to a file or a program is not wrapped, so that
//! each message stays a line of its own.

use std::borrow::Cow;

use landfall_layout::format::columns::unpainted;
use terminal_size::{Height, Width};
use unicode_width::UnicodeWidthStr as _;

/// The least width that text is wrapped to.
const LEAST: usize = 40;

/// Wraps the messages of a text for the terminal that it is written to, if it is one.
pub fn to_terminal(text: &str, size: Option<(Width, Height)>) -> Cow<'_, str> {
    size.map_or(Cow::Borrowed(text), |(width, _)| to_width(text, width.0.into()))
}

/// Wraps titles, notes, helps and labels of messages; source lines and tables stay as they are.
fn to_width(text: &str, width: usize) -> Cow<'_, str> {
    let width = width.max(LEAST);
    if text.lines().all(|line| unpainted(line).width() <= width) {
        return Cow::Borrowed(text);
    }
    let mut fitted = String::with_capacity(text.len() + text.len() / 16);
    for line in text.split_inclusive('\n') {
        let plain = unpainted(line.trim_end());
        match indent(&plain, width).filter(|_| plain.width() > width) {
            Some(indent) => wrap(line, &indent, width, &mut fitted),
            None => fitted.push_str(line),
        }
    }
    Cow::Owned(fitted)
}

/// What the further lines of a line of a message begin with; `None` for one that is no message.
fn indent(plain: &str, width: usize) -> Option<String> {
    let is_title = ["error", "warning", "note", "help"]
        .iter()
        .any(|level| plain.strip_prefix(level).is_some_and(|rest| rest.starts_with(['[', ':'])));
    if is_title {
        return Some("    ".to_string());
    }
    let inner = plain.trim_start();
    let before = plain.len() - inner.len();
    if inner.starts_with("= note: ") || inner.starts_with("= help: ") {
        return Some(" ".repeat(before + "= note: ".len()));
    }
    // Marks below a source line, and what they say.
    let marks = inner.strip_prefix("| ")?;
    let label = marks.trim_start_matches([' ', '^', '-', '_', '|']);
    let mut column = plain.len() - label.len();
    let first = plain[..column].find(['^', '-']).filter(|_| !label.is_empty())?;
    if column + LEAST / 2 > width {
        column = first; // below the marks, which leave no room
    }
    Some(format!("{}|{}", " ".repeat(before), " ".repeat(column - before - 1)))
}

/// Wraps a line at spaces outside of code; a longer word has a line of its own.
fn wrap(line: &str, indent: &str, width: usize, out: &mut String) {
    let is_code_closed = line.matches('`').count().is_multiple_of(2);
    let (mut is_code, mut end) = (false, 0);
    let words = line.split(|c: char| {
        is_code ^= c == '`' && is_code_closed;
        c == ' ' && !is_code
    });
    for (nth, word) in words.enumerate() {
        let wide = unpainted(word.trim_end()).width();
        if nth > 0 && end + 1 + wide > width && end > indent.width() {
            out.push('\n');
            out.push_str(indent);
            end = indent.width();
        } else if nth > 0 {
            out.push(' ');
            end += 1;
        }
        out.push_str(word);
        end += wide;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn titles_notes_and_labels_are_wrapped_and_code_is_not() {
        let text = "\
warning[odd-length]: the bytes of `a file.bin` are more than its block needs
 --> a.frag:3:2
  |
3 |     vec33 a_very_long_name_of_a_member_of_a_block;
  |     ^^^^^ there is no such type in GLSL 4.50
  |
  = note: types must be declared before they are used
  = help: write `vec3 a_very_long_name_of_a_member_of_a_block;`
";
        let expected = "\
warning[odd-length]: the bytes of
    `a file.bin` are more than its block
    needs
 --> a.frag:3:2
  |
3 |     vec33 a_very_long_name_of_a_member_of_a_block;
  |     ^^^^^ there is no such type in
  |           GLSL 4.50
  |
  = note: types must be declared before
          they are used
  = help: write
          `vec3 a_very_long_name_of_a_member_of_a_block;`
";
        assert_eq!(to_width(text, 40), expected);
        assert_eq!(to_width(text, 90), text);
        let painted = "\x1b[1m\x1b[91merror[a]\x1b[0m: \x1b[1mone two three four five six\x1b[0m\n";
        let wrapped = "\x1b[1m\x1b[91merror[a]\x1b[0m: \x1b[1mone two three four five six\x1b[0m\n";
        assert_eq!(to_width(painted, 40), wrapped);
    }
}
