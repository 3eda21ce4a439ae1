//! The code of a text, as naga's front ends see it: without comments, and in GLSL without text that
//! `#if 0` leaves out, and with nothing of directives but macros and conditions.

use std::borrow::Cow;
use std::mem;

use crate::source::Language;

/// Returns a text with its continued lines joined, which comes before all else in GLSL; WGSL has none.
pub(super) fn joined(text: &str, language: Language) -> Cow<'_, str> {
    match language {
        Language::Glsl if text.contains('\\') => {
            text.replace("\\\r\n", "").replace("\\\n", "").replace("\\\r", "").into()
        }
        Language::Glsl | Language::Wgsl | Language::SpirV => text.into(),
    }
}

/// Returns the greatest number of line continuations in a row, in comments as well.
pub(super) fn continuations(text: &str, language: Language) -> u64 {
    let (mut run, mut longest) = (0, 0);
    let mut bytes = text.bytes().peekable();
    while let (Language::Glsl, Some(byte)) = (language, bytes.next()) {
        match byte {
            b'\\' if matches!(bytes.peek(), Some(b'\r' | b'\n')) => run += 1,
            b'\r' | b'\n' => {}
            _ => run = 0,
        }
        longest = longest.max(run);
    }
    longest
}

/// Returns the words and signs of a text with joined lines. A number is a word, and each sign is one
/// character. Macros and conditions come last, with a `;` before each.
pub(super) fn code(text: &str, language: Language) -> Vec<&str> {
    let mut scanner = Scanner { text, at: 0, language };
    let (mut found, mut directives) = (Vec::new(), Vec::new());
    // The number of conditions open in text that `#if 0` leaves out.
    let mut left_out = 0u32;
    let mut starts_line = true;
    while let Some(token) = scanner.next() {
        if token == "\n" {
            starts_line = true;
        } else if token == "#" && mem::take(&mut starts_line) && language == Language::Glsl {
            let mut line = Vec::new();
            while let Some(token) = scanner.next().filter(|token| *token != "\n") {
                line.push(token);
            }
            starts_line = true;
            match (line.first().copied().unwrap_or_default(), left_out) {
                ("if", 0) if line == ["if", "0"] => left_out = 1,
                ("if" | "ifdef" | "ifndef", 1..) => left_out += 1,
                // Back at 0 with the `#endif` of the `#if 0` itself.
                ("endif", 1..) => left_out -= 1,
                ("else" | "elif", 1) => left_out = 0,
                ("define" | "if" | "elif", 0) => {
                    directives.push(";");
                    directives.append(&mut line);
                }
                _ => {}
            }
        } else {
            starts_line = false;
            if left_out == 0 {
                found.push(token);
            }
        }
    }
    found.append(&mut directives);
    found
}

struct Scanner<'t> {
    text: &'t str,
    at: usize,
    language: Language,
}

impl<'t> Scanner<'t> {
    /// Returns the next word, sign or line break.
    fn next(&mut self) -> Option<&'t str> {
        loop {
            // White space and comments are skipped; whatever is left is a word or one sign.
            let rest = &self.text[self.at..];
            let first = rest.chars().next()?;
            let length = match first {
                _ if self.ends_line(first) => {
                    self.at += first.len_utf8();
                    return Some("\n");
                }
                '/' if rest.starts_with("//") => {
                    rest.find(|c| self.ends_line(c)).unwrap_or(rest.len())
                }
                '/' if rest.starts_with("/*") => self.block_comment(rest),
                _ if first.is_whitespace() => first.len_utf8(),
                _ => {
                    let inside = |c: char| c.is_alphanumeric() || c == '_';
                    let length = match inside(first) {
                        true => rest.find(|c| !inside(c)).unwrap_or(rest.len()),
                        false => first.len_utf8(),
                    };
                    self.at += length;
                    return Some(&rest[..length]);
                }
            };
            self.at += length;
        }
    }

    /// Whether a character ends a line comment (WGSL §3.2; GLSL 4.60 §3.1).
    fn ends_line(&self, c: char) -> bool {
        match self.language {
            Language::Glsl | Language::SpirV => matches!(c, '\n' | '\r'),
            Language::Wgsl => matches!(c, '\n'..='\r' | '\u{85}' | '\u{2028}' | '\u{2029}'),
        }
    }

    /// Returns the length of the comment that a text begins with; those of WGSL nest.
    fn block_comment(&self, text: &str) -> usize {
        let (mut at, mut depth) = (2, 1u32);
        let bytes = text.as_bytes();
        while depth > 0 {
            match bytes.get(at..at + 2) {
                Some(b"*/") => {
                    depth -= 1;
                    at += 2;
                }
                Some(b"/*") if self.language == Language::Wgsl => {
                    depth += 1;
                    at += 2;
                }
                Some(_) => at += 1,
                None => return text.len(),
            }
        }
        at
    }
}
