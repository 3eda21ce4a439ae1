//! The GLSL lexer: tokens of one file, with their spans. Comments are recorded, not returned.
//!
//! Feeds `preprocess`; knows neither macros nor directives. A line ends with CR, LF or both (GLSL
//! 4.60 §3.1); `splice` removes line continuations first.

use super::splice::{self, Cuts};
use super::texts::Texts;
use crate::source::Span;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Name,
    Number,
    Punctuation,
    /// A double-quoted string, quotes included: in directives, and for `debugPrintfEXT`.
    Text,
    /// A character that GLSL does not use.
    Stray,
    End,
}

#[derive(Clone, Copy, Debug)]
pub struct Token<'a> {
    pub kind: Kind,
    pub text: &'a str,
    /// The span in the user's text; for a token from a macro, that of the outermost use of the
    /// macro.
    pub span: Span,
    /// The span in the macro's definition, for a token from a macro.
    pub definition: Option<Span>,
    /// The number of comments before it in the whole shader.
    pub comments: u32,
    /// Whether it is the first on its line.
    pub first: bool,
    /// Whether whitespace or a comment precedes it.
    pub spaced: bool,
    /// Whether it is exempt from macro expansion.
    pub frozen: bool,
}

impl Token<'_> {
    /// The end of a text.
    pub(crate) fn end(span: Span) -> Token<'static> {
        Token {
            kind: Kind::End,
            text: "",
            span,
            definition: None,
            comments: 0,
            first: false,
            spaced: false,
            frozen: false,
        }
    }

    /// Whether it is that operator, bracket or word.
    #[inline]
    pub fn is(&self, text: &str) -> bool {
        self.text == text && self.kind != Kind::Text
    }
}

#[derive(Clone, Debug)]
pub struct Lexer<'a> {
    text: &'a str,
    at: usize,
    file: u32,
    line_start: bool,
    /// The positions of line continuations, if there are any.
    cuts: Option<Cuts>,
    /// The start of a comment that is never closed.
    open_comment: Option<usize>,
}

/// The stop of a skip: the next brace, directive or the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// `#` at the start of a line, not yet passed.
    Directive,
    /// `{`, passed.
    Open,
    /// `}`, passed.
    Close,
    End,
}

impl<'a> Lexer<'a> {
    /// Starts at a text without line continuations.
    pub fn new(text: &'a str, file: u32) -> Lexer<'a> {
        Lexer { text, at: 0, file, line_start: true, cuts: None, open_comment: None }
    }

    /// Starts at a file; `texts` owns the text without line continuations.
    pub fn of_file(text: &'a str, file: u32, texts: &'a Texts) -> Lexer<'a> {
        match splice::splice(text) {
            None => Lexer::new(text, file),
            Some((clean, cuts)) => {
                Lexer { cuts: Some(cuts), ..Lexer::new(texts.alloc(clean.into()), file) }
            }
        }
    }

    /// The byte offset in the file.
    pub fn offset(&self) -> u32 {
        match &self.cuts {
            None => self.at as u32,
            Some(cuts) => splice::end(cuts, self.at),
        }
    }

    pub(crate) fn is_spliced(&self) -> bool {
        self.cuts.is_some()
    }

    pub(crate) fn open_comment(&self) -> Option<Span> {
        let start = self.open_comment?;
        Some(self.span(start, start + 2))
    }

    pub fn file(&self) -> u32 {
        self.file
    }

    // 0 past the end: no rule begins with it, so no rule needs a check of its own.
    fn byte(&self, ahead: usize) -> u8 {
        self.text.as_bytes().get(self.at + ahead).copied().unwrap_or(0)
    }

    fn span_from(&self, start: usize) -> Span {
        self.span(start, self.at)
    }

    fn span(&self, start: usize, end: usize) -> Span {
        let (start, end) = match &self.cuts {
            None => (start as u32, end as u32),
            Some(cuts) => (splice::start(cuts, start), splice::end(cuts, end)),
        };
        // The empty range after a continuation at the end of the text.
        Span { file: self.file, start, end: end.max(start) }
    }

    /// Returns the next token. Comments before it are added to `comments`.
    #[inline]
    pub fn next(&mut self, comments: &mut Vec<Span>) -> Token<'a> {
        let spaced = self.skip_blank(comments, false);
        self.token(comments.len() as u32, spaced)
    }

    /// Returns the next token of this line, or `None` at its end.
    pub(crate) fn next_on_line(&mut self, comments: &mut Vec<Span>) -> Option<Token<'a>> {
        let spaced = self.skip_blank(comments, true);
        if self.at == self.text.len() || self.byte(0) == b'\n' || self.byte(0) == b'\r' {
            return None;
        }
        Some(self.token(comments.len() as u32, spaced))
    }

    /// Returns the rest of this line as it is, without looking for comments.
    pub(crate) fn rest_of_line(&mut self) -> &'a str {
        let start = self.at;
        let rest = &self.text.as_bytes()[start..];
        self.at += memchr::memchr2(b'\n', b'\r', rest).unwrap_or(rest.len());
        &self.text[start..self.at]
    }

    fn token(&mut self, comments: u32, spaced: bool) -> Token<'a> {
        let start = self.at;
        let first = self.line_start;
        self.line_start = false;
        let kind = self.advance();
        Token {
            kind,
            text: &self.text[start..self.at],
            span: self.span_from(start),
            definition: None,
            comments,
            first,
            spaced,
            frozen: false,
        }
    }

    // identifier: nondigit { nondigit | digit }                            (GLSL 4.60 §3.7)
    // number: see `number`; string: `"` … `"` (GL_EXT_debug_printf, names of files)
    // Operators are of one character, except those of constant expressions and `##`: the parser
    // joins `+=`, `<<=` and `++`.
    fn advance(&mut self) -> Kind {
        let byte = self.byte(0);
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'_' => {
                self.eat_while(|b| b.is_ascii_alphanumeric() || b == b'_');
                Kind::Name
            }
            b'0'..=b'9' => self.number(),
            b'.' if self.byte(1).is_ascii_digit() => self.number(),
            b'"' => {
                self.at += 1;
                self.eat_while(|b| !matches!(b, b'"' | b'\n' | b'\r'));
                if self.byte(0) == b'"' {
                    self.at += 1;
                }
                Kind::Text
            }
            b'!'..=b'~' => {
                let pair = [byte, self.byte(1)];
                let two = matches!(
                    &pair,
                    b"<<" | b">>" | b"<=" | b">=" | b"==" | b"!=" | b"&&" | b"||" | b"^^" | b"##"
                );
                self.at += if two { 2 } else { 1 };
                match byte {
                    b'$' | b'@' | b'`' | b'\'' | b'\\' => Kind::Stray,
                    _ => Kind::Punctuation,
                }
            }
            _ => match self.text[self.at..].chars().next() {
                Some(c) => {
                    self.at += c.len_utf8();
                    Kind::Stray
                }
                None => Kind::End,
            },
        }
    }

    // number: (digit | . digit) { digit | letter | _ | . | e sign | E sign }
    // As in C, any run that begins like a number is one token; whether it is a literal with a valid
    // suffix is checked where its value is needed (`literal`): `1.0lf`, `0x1Fu` and `08` are read
    // alike here.
    fn number(&mut self) -> Kind {
        loop {
            match self.byte(0) {
                b'e' | b'E' if matches!(self.byte(1), b'+' | b'-') && !self.in_hex() => {
                    self.at += 2
                }
                b'0'..=b'9' | b'a'..=b'z' | b'A'..=b'Z' | b'_' | b'.' => self.at += 1,
                _ => return Kind::Number,
            }
        }
    }

    /// Whether the number that ends here began with `0x`: then `e` is a digit.
    // `0xe+1` is a sum, `1e+1` is not. Looked at only where an `e` stands before a sign.
    fn in_hex(&self) -> bool {
        let before = &self.text.as_bytes()[..self.at];
        let start = before.iter().rposition(|b| !b.is_ascii_alphanumeric()).map_or(0, |i| i + 1);
        before[start..].starts_with(b"0x") || before[start..].starts_with(b"0X")
    }

    fn eat_while(&mut self, want: impl Fn(u8) -> bool) {
        let rest = &self.text.as_bytes()[self.at..];
        self.at += rest.iter().position(|&b| !want(b)).unwrap_or(rest.len());
    }

    /// Skips whitespace and comments; returns whether there were any.
    // `stay_on_line` is for directives, which end with their line. A block comment may go on past
    // it, and the directive with it, as in C: a comment counts as one blank (§3.4).
    fn skip_blank(&mut self, comments: &mut Vec<Span>, stay_on_line: bool) -> bool {
        let start = self.at;
        loop {
            match self.byte(0) {
                b'\n' | b'\r' if stay_on_line => break,
                b'\n' | b'\r' => {
                    self.at += 1;
                    self.line_start = true;
                }
                b' ' | b'\t' | 0x0b | 0x0c => self.at += 1,
                b'/' if self.byte(1) == b'/' => {
                    let from = self.at;
                    self.line_comment();
                    comments.push(self.span_from(from));
                }
                b'/' if self.byte(1) == b'*' => {
                    let from = self.at;
                    self.block_comment();
                    comments.push(self.span_from(from));
                }
                _ => break,
            }
        }
        self.at > start
    }

    fn line_comment(&mut self) {
        let rest = &self.text.as_bytes()[self.at..];
        self.at += memchr::memchr2(b'\n', b'\r', rest).unwrap_or(rest.len());
    }

    /// Skips a comment; one that is never closed extends to the end and is reported by the
    /// preprocessor.
    fn block_comment(&mut self) {
        let rest = &self.text.as_bytes()[self.at + 2..];
        match memchr::memmem::find(rest, b"*/") {
            Some(end) => self.at += 2 + end + 2,
            None => {
                self.open_comment = Some(self.at);
                self.at = self.text.len();
            }
        }
    }

    /// Skips text up to the end of the next occurrence of a word outside comments; returns whether
    /// there is one.
    // Searches for the word first and for comments only up to each place found: the word is rare,
    // and comments are many.
    pub(crate) fn skip_past(&mut self, word: &str) -> bool {
        let bytes = self.text.as_bytes();
        let inside =
            |byte: Option<&u8>| byte.is_some_and(|b| b.is_ascii_alphanumeric() || *b == b'_');
        let from = self.at;
        for at in memchr::memmem::find_iter(&bytes[from..], word).map(|at| from + at) {
            while let Some(slash) = bytes.get(self.at..at).and_then(|b| memchr::memchr(b'/', b)) {
                self.at += slash;
                match self.byte(1) {
                    b'/' => self.line_comment(),
                    b'*' => self.block_comment(),
                    _ => self.at += 1,
                }
            }
            // Inside a comment.
            if self.at > at {
                continue;
            }
            self.at = at;
            let end = at + word.len();
            if !inside(bytes[..at].last()) && !inside(bytes.get(end)) {
                self.at = end;
                return true;
            }
        }
        self.at = self.text.len();
        false
    }

    /// Skips text up to the next brace or directive.
    // Five bytes matter in a body; all others are passed without becoming tokens.
    pub(crate) fn skip_to_brace(&mut self) -> Stop {
        let mut seen = ScannedText { to: self.at, blank: self.line_start };
        self.line_start = false;
        loop {
            let rest = &self.text.as_bytes()[self.at..];
            let found = rest.iter().position(|b| matches!(b, b'{' | b'}' | b'/' | b'#' | b'"'));
            let Some(found) = found else {
                self.at = self.text.len();
                return Stop::End;
            };
            self.at += found;
            match rest[found] {
                b'{' => {
                    self.at += 1;
                    return Stop::Open;
                }
                b'}' => {
                    self.at += 1;
                    return Stop::Close;
                }
                // A `#` after code on its line is no directive (§3.3).
                b'#' if seen.line_is_blank(self.text, self.at) => {
                    self.line_start = true;
                    return Stop::Directive;
                }
                // The format of `debugPrintfEXT`. Text that is not compiled may hold a quote alone.
                b'"' => {
                    let text = self.text[self.at + 1..].lines().next().unwrap_or_default();
                    self.at += 1 + text.find('"').map_or(0, |end| end + 1);
                }
                b'/' if matches!(self.byte(1), b'/' | b'*') => {
                    let blank = seen.line_is_blank(self.text, self.at);
                    if self.byte(1) == b'/' {
                        self.line_comment();
                    } else {
                        self.block_comment();
                    }
                    seen = ScannedText { to: self.at, blank };
                }
                _ => self.at += 1,
            }
        }
    }

    /// Skips text of an inactive branch up to the next directive.
    pub(crate) fn skip_to_directive(&mut self) -> Stop {
        loop {
            match self.skip_to_brace() {
                Stop::Open | Stop::Close => {}
                stop @ (Stop::Directive | Stop::End) => return stop,
            }
        }
    }
}

/// The extent of skipped text examined so far, and whether its current line is blank except for
/// comments.
// `skip_to_brace` does not look at the ends of lines as it passes them. When it meets a `#` it
// looks back instead, at most to the last comment, where `blank` has the state.
struct ScannedText {
    to: usize,
    blank: bool,
}

impl ScannedText {
    /// Whether only blanks and comments are between the start of the line and `at`.
    fn line_is_blank(&self, text: &str, at: usize) -> bool {
        let before = &text.as_bytes()[self.to..at];
        let last = before.iter().rposition(|b| !matches!(b, b' ' | b'\t' | 0x0b | 0x0c));
        last.map_or(self.blank, |last| matches!(before[last], b'\n' | b'\r'))
    }
}
