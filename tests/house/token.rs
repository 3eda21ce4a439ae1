//! Splits Rust text into identifiers and punctuation, without comments, literals and tests.

use std::ops::Range;

/// An identifier, `::`, or one character of punctuation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Token<'t> {
    pub text: &'t str,
    /// Its line, from 1.
    pub line: usize,
}

/// The tokens of a text that are neither comments nor literals.
pub fn tokens(text: &str) -> Vec<Token<'_>> {
    let bytes = text.as_bytes();
    let mut found = Vec::new();
    let (mut at, mut line) = (0, 1);
    while at < bytes.len() {
        let end = token_end(text, at);
        let is_code = match bytes[at] {
            b'/' => end == at + 1,
            b'"' => false,
            b'\'' => end == at + 1,
            byte if is_name(byte) => bytes[end - 1] != b'"' && bytes[end - 1] != b'#',
            byte => !byte.is_ascii_whitespace(),
        };
        if is_code {
            found.push(Token { text: &text[at..end], line });
        }
        line += text[at..end].matches('\n').count();
        at = end;
    }
    found
}

/// Where the token, comment, literal or white space that begins at a byte ends.
pub fn token_end(text: &str, at: usize) -> usize {
    let bytes = text.as_bytes();
    let rest = &text[at..];
    if rest.starts_with("//") {
        return at + rest.find('\n').unwrap_or(rest.len());
    }
    if rest.starts_with("/*") {
        return comment_end(text, at);
    }
    if rest.starts_with("::") {
        return at + 2;
    }
    if let Some(hashes) = raw_string(rest) {
        let opening = rest.find('"').expect("a raw string has a quote");
        let closing = format!("\"{}", "#".repeat(hashes));
        let body = opening + 1;
        return at + rest[body..].find(&closing).map_or(rest.len(), |i| body + i + closing.len());
    }
    match bytes[at] {
        b'"' => string_end(text, at),
        b'b' | b'c' if bytes.get(at + 1) == Some(&b'"') => string_end(text, at + 1),
        b'\'' => char_end(rest).map_or(at + 1, |end| at + end),
        byte if is_name(byte) => {
            at + rest.bytes().position(|byte| !is_name(byte)).unwrap_or(rest.len())
        }
        _ => at + rest.chars().next().map_or(1, char::len_utf8),
    }
}

fn is_name(byte: u8) -> bool {
    byte == b'_' || byte.is_ascii_alphanumeric()
}

/// The number of `#` of a raw string that begins here.
fn raw_string(rest: &str) -> Option<usize> {
    let rest = rest.strip_prefix('b').or_else(|| rest.strip_prefix('c')).unwrap_or(rest);
    let rest = rest.strip_prefix('r')?;
    let body = rest.trim_start_matches('#');
    body.starts_with('"').then(|| rest.len() - body.len())
}

/// The end of a block comment; they nest.
fn comment_end(text: &str, start: usize) -> usize {
    let bytes = text.as_bytes();
    let (mut depth, mut at) = (0, start);
    while at + 1 < bytes.len() {
        match &bytes[at..at + 2] {
            b"/*" => (depth, at) = (depth + 1, at + 2),
            b"*/" if depth == 1 => return at + 2,
            b"*/" => (depth, at) = (depth - 1, at + 2),
            _ => at += 1,
        }
    }
    bytes.len()
}

/// The end of a string whose quote is at `start`.
fn string_end(text: &str, start: usize) -> usize {
    let bytes = text.as_bytes();
    let mut at = start + 1;
    while at < bytes.len() {
        match bytes[at] {
            b'\\' => at += 2,
            b'"' => return at + 1,
            _ => at += 1,
        }
    }
    bytes.len()
}

/// The length of a character literal; `None` for a lifetime.
fn char_end(rest: &str) -> Option<usize> {
    let body = &rest[1..];
    let mut chars = body.char_indices();
    let (_, first) = chars.next()?;
    if first == '\\' {
        // The escaped character may be a quote itself.
        let (escaped, _) = chars.next()?;
        return Some(1 + body[escaped + 1..].find('\'')? + escaped + 2);
    }
    let (second, quote) = chars.next()?;
    (quote == '\'').then_some(second + 2)
}

/// Tokens without the items under `#[cfg(test)]`, and the modules in files of their own that
/// are such items.
pub fn without_tests<'t>(tokens: &[Token<'t>]) -> (Vec<Token<'t>>, Vec<&'t str>) {
    let mut kept = Vec::new();
    let mut modules = Vec::new();
    let mut at = 0;
    for item in test_items(tokens) {
        kept.extend_from_slice(&tokens[at..item.start]);
        let own = &tokens[item.clone()];
        if let Some(name) = own.iter().position(|t| t.text == "mod").and_then(|i| own.get(i + 1)) {
            modules.push(name.text);
        }
        at = item.end;
    }
    kept.extend_from_slice(&tokens[at..]);
    (kept, modules)
}

/// The items under `#[cfg(test)]`, each with its attributes.
pub fn test_items(tokens: &[Token<'_>]) -> Vec<Range<usize>> {
    const MARK: [&str; 7] = ["#", "[", "cfg", "(", "test", ")", "]"];
    let mut found = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        if starts_with(&tokens[at..], &MARK) {
            let end = item(tokens, at + MARK.len()).end;
            found.push(at..end);
            at = end;
        } else {
            at += 1;
        }
    }
    found
}

fn starts_with(tokens: &[Token<'_>], texts: &[&str]) -> bool {
    tokens.len() >= texts.len() && tokens.iter().zip(texts).all(|(a, b)| a.text == *b)
}

/// The item that begins at a token, other attributes included.
fn item(tokens: &[Token<'_>], start: usize) -> Range<usize> {
    let mut at = start;
    while starts_with(&tokens[at..], &["#", "["]) {
        at = matching(tokens, at + 1) + 1;
    }
    let is_use = tokens[at..].iter().take(5).any(|t| t.text == "use");
    while let Some(token) = tokens.get(at) {
        match token.text {
            ";" => return start..at + 1,
            "{" if !is_use => return start..matching(tokens, at) + 1,
            "(" | "[" | "{" => at = matching(tokens, at) + 1,
            _ => at += 1,
        }
    }
    start..tokens.len()
}

/// The token that closes the bracket at a token.
pub fn matching(tokens: &[Token<'_>], open: usize) -> usize {
    let mut depth = 0;
    for (at, token) in tokens.iter().enumerate().skip(open) {
        match token.text {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return at;
        }
    }
    tokens.len().saturating_sub(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(text: &str) -> Vec<&str> {
        tokens(text).iter().map(|token| token.text).collect()
    }

    #[test]
    fn comments_and_literals_are_no_tokens() {
        let text =
            "a /* b /* c */ d */ // e\n\"f \\\" g\" r#\"h \" i\"# b\"j\" 'k' '\\'' '\\u{6c}' l";
        assert_eq!(texts(text), ["a", "l"]);
    }

    #[test]
    fn lifetimes_are_no_literals() {
        assert_eq!(texts("&'a str, 'b: x"), ["&", "'", "a", "str", ",", "'", "b", ":", "x"]);
    }

    #[test]
    fn lines_are_counted_through_strings_and_comments() {
        let all = tokens("a\n\"\n\n\" /*\n*/ b");
        assert_eq!(all.last().map(|token| (token.text, token.line)), Some(("b", 5)));
    }

    #[test]
    fn items_under_cfg_test_are_left_out() {
        let text = "a; #[cfg(test)] #[x] mod tests { b { c } } d; #[cfg(test)] use e::{f}; \
                    #[cfg(test)] pub(crate) mod g; h";
        let all = tokens(text);
        let (kept, modules) = without_tests(&all);
        let kept: Vec<&str> = kept.iter().map(|token| token.text).collect();
        assert_eq!(kept, ["a", ";", "d", ";", "h"]);
        assert_eq!(modules, ["tests", "g"]);
    }
}
