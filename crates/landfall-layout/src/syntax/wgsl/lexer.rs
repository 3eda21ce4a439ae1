//! The WGSL lexer: tokens on demand.
//!
//! `>` is always a separate token: the parser decides whether two of them are a shift or the ends
//! of two template lists.

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// An identifier or keyword.
    Word,
    Number,
    /// Any other ASCII character.
    Sign(u8),
    End,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct WgslToken {
    pub(super) kind: Kind,
    pub(super) start: u32,
    pub(super) end: u32,
}

impl WgslToken {
    pub(super) fn is(self, sign: u8) -> bool {
        self.kind == Kind::Sign(sign)
    }

    pub(super) fn sign(self) -> Option<u8> {
        match self.kind {
            Kind::Sign(sign) => Some(sign),
            Kind::Word | Kind::Number | Kind::End => None,
        }
    }
}

/// A position in a text from which tokens are read.
#[derive(Clone, Debug)]
pub(super) struct WgslLexer<'a> {
    text: &'a str,
    at: usize,
    peeked: Option<WgslToken>,
    /// Byte ranges of the comments skipped so far.
    pub(super) comments: Vec<(u32, u32)>,
    /// The start of a block comment that is never closed.
    pub(super) unclosed_comment: Option<u32>,
}

impl<'a> WgslLexer<'a> {
    pub(super) fn new(text: &'a str, at: u32) -> WgslLexer<'a> {
        let at = at as usize;
        WgslLexer { text, at, peeked: None, comments: Vec::new(), unclosed_comment: None }
    }

    pub(super) fn text(&self) -> &'a str {
        self.text
    }

    #[inline]
    pub(super) fn text_of(&self, token: WgslToken) -> &'a str {
        &self.text[token.start as usize..token.end as usize]
    }

    #[inline]
    pub(super) fn peek(&mut self) -> WgslToken {
        match self.peeked {
            Some(token) => token,
            None => {
                let token = self.read();
                self.peeked = Some(token);
                token
            }
        }
    }

    #[inline]
    pub(super) fn next(&mut self) -> WgslToken {
        match self.peeked.take() {
            Some(token) => token,
            None => self.read(),
        }
    }

    /// Returns the next token, if it begins before a place.
    pub(super) fn next_before(&mut self, end: u32) -> Option<WgslToken> {
        let token = self.next();
        (token.kind != Kind::End && token.start < end).then_some(token)
    }

    /// Consumes the next token if it is that sign.
    #[inline]
    pub(super) fn take(&mut self, sign: u8) -> bool {
        let found = self.peek().is(sign);
        if found {
            self.peeked = None;
        }
        found
    }

    pub(super) fn jump(&mut self, at: u32) {
        self.at = at as usize;
        self.peeked = None;
    }

    /// Skips from after a `{` past its `}`, examining only braces and comments; returns the offset
    /// of the `}`.
    // Function bodies are most of a text. They have braces and comments; WGSL has no strings, so no
    // brace stands where it does not count.
    pub(super) fn skip_body(&mut self) -> Option<u32> {
        debug_assert!(self.peeked.is_none(), "a body starts right after its brace");
        let bytes = self.text.as_bytes();
        let mut depth = 0u32;
        let mut at = self.at;
        while let Some(&byte) = bytes.get(at) {
            match byte {
                b'{' => depth += 1,
                b'}' if depth == 0 => {
                    self.at = at + 1;
                    return Some(at as u32);
                }
                b'}' => depth -= 1,
                b'/' => {
                    if let Some(end) = self.comment_end(at) {
                        at = end;
                        continue;
                    }
                }
                _ => {}
            }
            at += 1;
        }
        self.at = bytes.len();
        None
    }

    /// Skips to the next of those signs outside comments, and consumes it.
    pub(super) fn scan_to(&mut self, signs: [u8; 4]) -> WgslToken {
        debug_assert!(self.peeked.is_none(), "a scan starts right after a token");
        let bytes = self.text.as_bytes();
        let mut at = self.at;
        while let Some(&byte) = bytes.get(at) {
            if signs.contains(&byte) {
                self.at = at + 1;
                return self.token(Kind::Sign(byte), at);
            }
            at = match byte {
                b'/' => self.comment_end(at).unwrap_or(at + 1),
                _ => at + 1,
            };
        }
        self.at = bytes.len();
        self.token(Kind::End, self.at)
    }

    /// Returns the end of the comment that starts there, if any.
    fn comment_end(&mut self, start: usize) -> Option<usize> {
        let bytes = self.text.as_bytes();
        match bytes.get(start + 1) {
            Some(b'/') => {
                let mut at = start + 2;
                while at < bytes.len() && !ends_line(bytes, at) {
                    at += 1;
                }
                Some(at)
            }
            Some(b'*') => {
                let mut depth = 1u32;
                let mut at = start + 2;
                while at + 1 < bytes.len() {
                    match (bytes[at], bytes[at + 1]) {
                        (b'*', b'/') => {
                            depth -= 1;
                            at += 2;
                            if depth == 0 {
                                return Some(at);
                            }
                        }
                        // WGSL §3.6: block comments nest.
                        (b'/', b'*') => {
                            depth += 1;
                            at += 2;
                        }
                        _ => at += 1,
                    }
                }
                self.unclosed_comment = Some(start as u32);
                Some(bytes.len())
            }
            _ => None,
        }
    }

    // token: blankspace and comments skipped, then word | number | one sign
    // Bytes are enough: no byte of a character beyond ASCII is an ASCII byte in UTF-8. Signs are
    // single, the parser joins `&&`, `<=` and the like by their places.
    fn read(&mut self) -> WgslToken {
        let bytes = self.text.as_bytes();
        let start = loop {
            match bytes.get(self.at) {
                None => return self.token(Kind::End, self.at),
                Some(b' ' | b'\t'..=b'\r') => self.at += 1,
                Some(b'/') => match self.comment_end(self.at) {
                    Some(end) => {
                        self.comments.push((self.at as u32, end as u32));
                        self.at = end;
                    }
                    None => break self.at,
                },
                Some(0x80..) => match wide_blank(&bytes[self.at..]) {
                    Some(length) => self.at += length,
                    None => break self.at,
                },
                Some(_) => break self.at,
            }
        };
        let first = bytes[start];
        if is_word(first) && !first.is_ascii_digit() {
            let length = bytes[start..].iter().take_while(|&&b| is_word(b)).count();
            // A non-ASCII blank ends a word; it starts with a byte that words may contain.
            let length = match bytes[start..start + length].iter().position(|&b| b >= 0x80) {
                Some(from) => (from..length)
                    .find(|&i| wide_blank(&bytes[start + i..]).is_some())
                    .unwrap_or(length),
                None => length,
            };
            self.at = start + length;
            return self.token(Kind::Word, start);
        }
        // `.5` is a number, `a.x` is not.
        let digit_follows = bytes.get(start + 1).is_some_and(u8::is_ascii_digit);
        if first.is_ascii_digit() || (first == b'.' && digit_follows) {
            self.at = number_end(bytes, start);
            return self.token(Kind::Number, start);
        }
        self.at = start + 1;
        self.token(Kind::Sign(first), start)
    }

    fn token(&self, kind: Kind, start: usize) -> WgslToken {
        WgslToken { kind, start: start as u32, end: self.at as u32 }
    }
}

/// WGSL §3.7 requires XID characters; every non-ASCII character is accepted here.
fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_' || byte >= 0x80
}

/// Returns the length of a non-ASCII blank character (WGSL §3.2).
fn wide_blank(bytes: &[u8]) -> Option<usize> {
    match bytes {
        [0xc2, 0x85, ..] => Some(2),
        // U+200E, U+200F, U+2028, U+2029.
        [0xe2, 0x80, 0x8e | 0x8f | 0xa8 | 0xa9, ..] => Some(3),
        _ => None,
    }
}

/// Whether a line break is at that byte (WGSL §3.2); each of them ends a line comment.
fn ends_line(bytes: &[u8], at: usize) -> bool {
    match bytes[at] {
        b'\n' | 0x0b | 0x0c | b'\r' => true,
        0xc2 => bytes.get(at + 1) == Some(&0x85),
        0xe2 => matches!(bytes.get(at + 1..at + 3), Some([0x80, 0xa8 | 0xa9])),
        _ => false,
    }
}

// decimal: digits, `.`, exponent with sign, suffix    hex: `0x`, hex digits, `.`, `p` exponent
// The longest run that may be one; `numbers::literal` checks its form. A sign belongs to it only
// after `e` of a decimal or `p` of a hexadecimal literal.
fn number_end(bytes: &[u8], start: usize) -> usize {
    let hex = matches!(bytes.get(start + 1), Some(b'x' | b'X')) && bytes[start] == b'0';
    let mut at = start + if hex { 2 } else { 1 };
    while let Some(&byte) = bytes.get(at) {
        let exponent = match bytes[at - 1] {
            b'e' | b'E' => !hex,
            b'p' | b'P' => hex,
            _ => false,
        };
        match byte {
            b'0'..=b'9' | b'a'..=b'z' | b'A'..=b'Z' | b'.' => at += 1,
            b'+' | b'-' if exponent => at += 1,
            _ => break,
        }
    }
    at
}

#[cfg(test)]
mod tests {
    use super::super::tokens;
    use super::*;

    #[test]
    fn two_closing_angles_are_two_tokens() {
        assert_eq!(tokens("a<b<c>>=1"), ["a", "<", "b", "<", "c", ">", ">", "=", "1"]);
    }

    #[test]
    fn exponents_belong_to_their_number_and_differences_do_not() {
        assert_eq!(
            tokens("1e+5 0x1p-2f 0xe+1 3-2 .5h"),
            ["1e+5", "0x1p-2f", "0xe", "+", "1", "3", "-", "2", ".5h"]
        );
    }

    #[test]
    fn block_comments_nest_and_line_comments_end_at_every_line_break() {
        assert_eq!(tokens("a /* /* } */ { */ b // c\u{2028}d // e\r f"), ["a", "b", "d", "f"]);
    }

    #[test]
    fn a_body_ends_at_its_own_brace() {
        let text = "{ if x { /* } */ } // }\n } after";
        let mut lexer = WgslLexer::new(text, 1);
        assert_eq!(lexer.skip_body(), Some(25));
        assert_eq!(tokens(&text[lexer.at..]), ["after"]);
    }

    #[test]
    fn blanks_beyond_ascii_separate_tokens() {
        assert_eq!(tokens("größe\u{2028}x\u{85}y"), ["größe", "x", "y"]);
    }
}
