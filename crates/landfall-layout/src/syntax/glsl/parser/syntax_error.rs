//! Syntax errors in a part of a shader's text.

use crate::diagnostic::Code;
use crate::diagnostic::Diagnostic;
use crate::source::Span;

/// The result of parsing.
pub type Parsed<T> = Result<T, SyntaxError>;

/// A syntax error.
#[derive(Clone, Debug)]
pub enum SyntaxError {
    /// An unexpected token.
    Unexpected {
        /// The span.
        span: Span,
        /// The spelling; empty at the end of the file.
        found: String,
        /// Whether it is past the end of the parsed part.
        end: bool,
        /// The expected syntax.
        wanted: Wanted,
    },
    /// Nesting deeper than the limit.
    TooDeep {
        /// The place where the limit was exceeded.
        span: Span,
        /// The nested construct, with its verb.
        what: &'static str,
        /// The limit.
        limit: u32,
    },
    /// Any other error.
    Other(Box<Diagnostic>),
}

/// The syntax allowed at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// A given token.
    Token(&'static str),
    /// A comma or the closing bracket.
    CommaOr(&'static str),
    /// A name.
    Name,
    /// An expression.
    Expression,
    /// The end.
    End,
}

impl SyntaxError {
    /// Returns the place of the error.
    pub fn place(&self) -> Span {
        match self {
            SyntaxError::Unexpected { span, .. } | SyntaxError::TooDeep { span, .. } => *span,
            SyntaxError::Other(found) => {
                found.labels.first().map_or(Span::default(), |label| label.at)
            }
        }
    }

    /// Returns the error as a diagnostic.
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
