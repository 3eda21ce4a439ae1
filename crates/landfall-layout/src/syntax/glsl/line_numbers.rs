//! `#line`, and the values of `__LINE__` and `__FILE__`.
//!
//! Diagnostics have the lines of the text as it stands.

use super::evaluate::{Names, Problem, evaluate_tokens};
use super::lexer::Token;
use super::preprocess::Preprocessor;
use crate::source::Span;
use crate::syntax::constant::Value;

/// The line number and file name that `#line` sets for the lines after it.
#[derive(Clone, Copy, Debug)]
pub(super) struct LineNumbers {
    file: u32,
    /// Its line in the text.
    line: u32,
    /// `__LINE__` less the line in the text.
    shift: i64,
    /// `__FILE__`, if set.
    string: Option<i64>,
}

impl<'a> Preprocessor<'a> {
    /// Executes `#line LINE [STRING]`, whose name is at `at`.
    pub(super) fn set_line(&mut self, at: Span) {
        let line = self.line();
        let tokens = self.expand_alone(&line);
        // `#line LINE STRING` has two expressions without anything between them (§3.3). If the
        // tokens are not one expression, the last is the string.
        let (number, string) = match (value(&tokens, at), tokens.split_last()) {
            (Some(number), _) => (Some(number), None),
            (None, Some((last, first))) => (value(first, at), value(&[*last], at)),
            (None, None) => (None, None),
        };
        let Some(number) = number else { return };
        // Only the difference to the text's own lines is kept, which holds for all lines that
        // follow.
        let line = self.files.locate(at).line;
        // From 3.30 and ES 3.00 on, the number is that of the next line, before that of this one.
        let is_next = self.version.number >= if self.version.es { 300 } else { 330 };
        let shift = number - i64::from(line) - i64::from(is_next);
        let string = string.or_else(|| self.line_numbers(at, line)?.string);
        self.lines.push(LineNumbers { file: at.file, line, shift, string });
    }

    /// Returns the value of `__LINE__` or `__FILE__`; `None` for other names.
    pub(super) fn line_or_file(&self, token: &Token<'a>) -> Option<&'a str> {
        if !matches!(token.text, "__LINE__" | "__FILE__") {
            return None;
        }
        let line = self.files.locate(token.span).line;
        let set = self.line_numbers(token.span, line);
        let value = match token.text {
            "__LINE__" => i64::from(line) + set.map_or(0, |set| set.shift),
            _ => set.and_then(|set| set.string).unwrap_or(i64::from(token.span.file)),
        };
        Some(self.keep(&value.to_string()))
    }

    /// Returns the last `#line` before a line of a file.
    fn line_numbers(&self, at: Span, line: u32) -> Option<&LineNumbers> {
        self.lines.iter().rev().find(|set| set.file == at.file && set.line < line)
    }
}

/// Returns the value of an expression if it is an integer.
fn value(tokens: &[Token<'_>], at: Span) -> Option<i64> {
    struct NoNames;
    impl Names for NoNames {
        const DIRECTIVE: bool = true;

        fn value(&mut self, name: &str, span: Span) -> Result<Value, Problem> {
            Err(Problem::new(span, format!("has the name `{name}`")))
        }
    }
    let value = evaluate_tokens(tokens, at, &mut NoNames).ok()?;
    value.integer().and_then(|number| i64::try_from(number).ok())
}
