//! The tokens of a shader's text that the compiler reads, in both languages.

use landfall_layout::ReadOptions;
use landfall_layout::source::{Language, Source};
use landfall_layout::syntax::glsl::raw;

/// A name, a number, or one character of punctuation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ListedToken<'t> {
    pub text: &'t str,
    pub start: usize,
    pub end: usize,
}

/// Reads the tokens of a text, without comments, directives and excluded parts.
pub(super) fn read<'t>(source: &'t Source, options: &ReadOptions) -> Vec<ListedToken<'t>> {
    match source.language {
        Language::Glsl | Language::SpirV => {
            // Tokens of excluded branches of `#if` are not compiled.
            let raw = raw::read(source, options);
            let code = raw.tokens.iter().filter(|token| token.active && token.directive.is_none());
            code.flat_map(|token| split(&source.text, token.start, token.end)).collect()
        }
        Language::Wgsl => wgsl(&source.text),
    }
}

/// Splits operators into characters.
fn split(text: &str, start: usize, end: usize) -> Vec<ListedToken<'_>> {
    let whole = ListedToken { text: &text[start..end], start, end };
    // Numbers and names stay whole; `+=` becomes `+` and `=`, as WGSL's reader below has it.
    let is_word = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
    if whole.text.chars().count() < 2 || whole.text.chars().any(is_word) {
        return vec![whole];
    }
    let each = whole.text.char_indices();
    each.map(|(at, c)| {
        let (start, end) = (start + at, start + at + c.len_utf8());
        ListedToken { text: &text[start..end], start, end }
    })
    .collect()
}

fn wgsl(text: &str) -> Vec<ListedToken<'_>> {
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(c) = text[at..].chars().next() {
        let rest = &text[at..];
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        let length = match c {
            _ if rest.starts_with("//") => rest.find(['\n', '\r']).unwrap_or(rest.len()),
            _ if rest.starts_with("/*") => comment(rest),
            c if is_word(c) => rest.find(|c| !is_word(c)).unwrap_or(rest.len()),
            c => c.len_utf8(),
        };
        let is_comment = rest.starts_with("//") || rest.starts_with("/*");
        if !is_comment && !c.is_whitespace() {
            tokens.push(ListedToken { text: &text[at..at + length], start: at, end: at + length });
        }
        at += length;
    }
    tokens
}

/// Returns the length of a block comment, which may hold others.
fn comment(text: &str) -> usize {
    let (mut depth, mut at) = (0u32, 0);
    loop {
        let rest = &text[at..];
        match rest.find(['/', '*']) {
            None => return text.len(),
            Some(skip) if rest[skip..].starts_with("/*") => {
                (depth, at) = (depth + 1, at + skip + 2)
            }
            Some(skip) if rest[skip..].starts_with("*/") => {
                (depth, at) = (depth - 1, at + skip + 2);
                if depth == 0 {
                    return at;
                }
            }
            Some(skip) => at += skip + 1,
        }
    }
}

/// Returns tokens as text, with a space wherever something was between them.
pub(super) fn joined(tokens: &[ListedToken<'_>]) -> String {
    let mut joined = String::new();
    let mut before = tokens.first().map_or(0, |token| token.start);
    for token in tokens {
        if token.start > before {
            joined.push(' ');
        }
        joined.push_str(token.text);
        before = token.end;
    }
    joined
}

/// Returns the index of the bracket that closes the one at `open`.
pub(super) fn closing(tokens: &[ListedToken<'_>], open: usize) -> Option<usize> {
    let mut depth = 0u32;
    for (at, token) in tokens.iter().enumerate().skip(open) {
        match token.text {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => {
                depth = depth.checked_sub(1)?;
                if depth == 0 {
                    return Some(at);
                }
            }
            _ => {}
        }
    }
    None
}
