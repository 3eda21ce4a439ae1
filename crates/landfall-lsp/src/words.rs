//! The identifiers of a text, without those in comments.

use std::ops::Range;

/// An identifier, with what tells a member from another name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TextWord<'t> {
    pub text: &'t str,
    pub span: Range<u32>,
    /// Whether a `.` stands before it.
    pub is_behind_dot: bool,
    /// Whether it stands in a line that begins with `#`.
    pub is_in_directive: bool,
    /// Whether it stands between `#if` and `#endif`, those of an include guard apart.
    pub is_conditional: bool,
}

/// Returns the identifiers of GLSL or WGSL in order.
pub fn words(text: &str) -> Vec<TextWord<'_>> {
    let mut scanner = WordScanner {
        text,
        at: 0,
        last: None,
        is_in_directive: false,
        nesting: 0,
        has_guard: false,
    };
    let mut is_first = true;
    let mut found = Vec::new();
    while let Some(word) = scanner.next() {
        if word.is_in_directive && scanner.begins_directive(&word) {
            match word.text {
                "if" | "ifdef" | "ifndef" => scanner.nesting += 1,
                "endif" => scanner.nesting = scanner.nesting.saturating_sub(1),
                _ => {}
            }
            scanner.has_guard |= is_first && word.text == "ifndef";
            is_first = false;
        }
        found.push(word);
    }
    found
}

/// The name and body of the function whose definition or declaration a byte of a text is in the name of.
pub fn function_at(text: &str, offset: u32) -> Option<(&str, Range<u32>)> {
    let all = words(text);
    let at = all.iter().position(|word| (word.span.start..=word.span.end).contains(&offset))?;
    let (before, word) = (all[..at].last()?, &all[at]);
    let is_followed = text[word.span.end as usize..].trim_start().starts_with('(');
    let between = &text[before.span.end as usize..word.span.start as usize];
    let outside = &text[..word.span.start as usize];
    let is_outside = outside.matches('{').count() == outside.matches('}').count();
    let is_declared = between.trim().is_empty() && is_outside && !word.is_in_directive;
    let start = word.span.end;
    let body = start..start + end_of_body(&text[start as usize..]) as u32;
    (is_followed && is_declared && word.text != "layout").then_some((word.text, body))
}

/// The end of the braces that a text begins with, or of a declaration without any.
fn end_of_body(text: &str) -> usize {
    let mut depth = 0_usize;
    for (at, c) in text.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth <= 1 => return at,
            '}' => depth -= 1,
            ';' if depth == 0 => return at,
            _ => {}
        }
    }
    text.len()
}

struct WordScanner<'t> {
    text: &'t str,
    at: usize,
    /// The last character that is neither white space nor comment.
    last: Option<char>,
    is_in_directive: bool,
    /// How many `#if` are open.
    nesting: usize,
    has_guard: bool,
}

impl<'t> WordScanner<'t> {
    /// Whether a word is the name of its directive.
    fn begins_directive(&self, word: &TextWord<'_>) -> bool {
        let before = self.text[..word.span.start as usize].trim_end_matches([' ', '\t']);
        before.ends_with('#')
    }

    fn next(&mut self) -> Option<TextWord<'t>> {
        let text = self.text;
        loop {
            let rest = &text[self.at..];
            let c = rest.chars().next()?;
            if rest.starts_with("//") {
                self.at += rest.find(['\n', '\r']).unwrap_or(rest.len());
            } else if rest.starts_with("/*") {
                self.at += block_comment(rest);
            } else if c == '_' || c.is_alphabetic() {
                let is_part = |c: char| c == '_' || c.is_alphanumeric();
                let length = rest.find(|c| !is_part(c)).unwrap_or(rest.len());
                let span = self.at as u32..(self.at + length) as u32;
                let is_behind_dot = self.last == Some('.');
                self.at += length;
                self.last = Some('a');
                return Some(TextWord {
                    text: &rest[..length],
                    span,
                    is_behind_dot,
                    is_in_directive: self.is_in_directive,
                    is_conditional: self.nesting > usize::from(self.has_guard),
                });
            } else if c.is_ascii_digit() {
                // Suffixes and exponents are no names.
                let is_part = |c: char| c == '.' || c == '_' || c.is_alphanumeric();
                self.at += rest.find(|c| !is_part(c)).unwrap_or(rest.len());
                self.last = Some('0');
            } else {
                self.character(c);
            }
        }
    }

    fn character(&mut self, c: char) {
        let is_start = self.text[..self.at].trim_end_matches([' ', '\t']).ends_with(['\n', '\r']);
        match c {
            '#' if is_start || self.text[..self.at].trim().is_empty() => {
                self.is_in_directive = true
            }
            '\n' => {
                let line = self.text[..self.at].trim_end_matches('\r');
                self.is_in_directive &= line.ends_with('\\');
            }
            _ => {}
        }
        self.at += c.len_utf8();
        if !c.is_whitespace() {
            self.last = Some(c);
        }
    }
}

/// The length of a comment that begins with `/*`. In WGSL they nest; GLSL's end first, and one of
/// GLSL that holds another `/*` is rare enough.
fn block_comment(text: &str) -> usize {
    let mut depth = 0;
    let mut at = 0;
    while at < text.len() {
        let rest = &text[at..];
        if rest.starts_with("/*") {
            depth += 1;
            at += 2;
        } else if rest.starts_with("*/") {
            depth -= 1;
            at += 2;
            if depth == 0 {
                return at;
            }
        } else {
            at += rest.chars().next().map_or(1, char::len_utf8);
        }
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_are_named_where_they_are_declared() {
        let text =
            "vec3 shade(vec3 a) { return mix(a, a, 0.5); }\nlayout(std140) uniform B { vec3 c; };";
        let at = |piece: &str| function_at(text, text.find(piece).expect(piece) as u32 + 1);
        let (name, body) = at("shade").expect("a function");
        assert_eq!(name, "shade");
        assert_eq!(
            &text[body.start as usize..body.end as usize],
            "(vec3 a) { return mix(a, a, 0.5); "
        );
        for other in ["mix", "layout", "vec3 a", "B {"] {
            assert_eq!(at(other), None, "{other}");
        }
    }

    #[test]
    fn comments_and_numbers_have_no_words() {
        let text = "// a\nb /* c /* d */ e */ .f 1.0e5f x0 \u{1f4a1}g\n#define h i\\\n j\nk";
        let found: Vec<(&str, bool, bool)> = words(text)
            .iter()
            .map(|word| (word.text, word.is_behind_dot, word.is_in_directive))
            .collect();
        let expected = [
            ("b", false, false),
            ("f", true, false),
            ("x0", false, false),
            ("g", false, false),
            ("define", false, true),
            ("h", false, true),
            ("i", false, true),
            ("j", false, true),
            ("k", false, false),
        ];
        assert_eq!(found, expected);
        for word in words(text) {
            assert_eq!(&text[word.span.start as usize..word.span.end as usize], word.text);
        }
    }
}
