//! Syntax errors in a part of a shader's text.

use crate::diagnostic::{Code, Diagnostic};
use crate::source::Span;

pub type Parsed<T> = Result<T, SyntaxError>;

#[derive(Clone, Debug)]
pub enum SyntaxError {
    Unexpected {
        span: Span,
        /// The spelling; empty at the end of the file.
        found: String,
        /// Whether it is past the end of the parsed part.
        end: bool,
        wanted: Wanted,
    },
    TooDeep {
        /// The place where the limit was exceeded.
        span: Span,
        /// The nested construct, with its verb.
        what: &'static str,
        limit: u32,
    },
    // Boxed: the other variants are small, and a `Result` of each parser function has their size.
    Other(Box<Diagnostic>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    Token(&'static str),
    CommaOr(&'static str),
    Name,
    Expression,
    End,
}

impl SyntaxError {
    pub fn place(&self) -> Span {
        match self {
            SyntaxError::Unexpected { span, .. } | SyntaxError::TooDeep { span, .. } => *span,
            SyntaxError::Other(found) => {
                found.labels.first().map_or(Span::default(), |label| label.at)
            }
        }
    }

    pub fn diagnostic(self) -> Box<Diagnostic> {
        Box::new(match self {
            SyntaxError::Unexpected { span, found, wanted, .. } => {
                let found = match found.as_str() {
                    "" => "the end of the file".to_string(),
                    found => format!("`{found}`"),
                };
                let message = match wanted {
                    Wanted::Token(text) => format!("expected `{text}`, found {found}"),
                    Wanted::CommaOr(close) => format!("expected `,` or `{close}`, found {found}"),
                    Wanted::Name => format!("expected a name, found {found}"),
                    Wanted::Expression => format!("expected an expression, found {found}"),
                    Wanted::End => format!("unexpected {found} after an expression"),
                };
                Diagnostic::error(Code::Syntax, span, message)
            }
            SyntaxError::TooDeep { span, what, limit } => {
                let message = format!("{what} more than {limit} deep");
                Diagnostic::error(Code::NestedTooDeep, span, message)
            }
            SyntaxError::Other(diagnostic) => *diagnostic,
        })
    }
}

impl From<SyntaxError> for Box<Diagnostic> {
    fn from(error: SyntaxError) -> Box<Diagnostic> {
        error.diagnostic()
    }
}
