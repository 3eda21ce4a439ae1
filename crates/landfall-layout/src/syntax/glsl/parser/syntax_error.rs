//! Why a part of a shader's text cannot be parsed.

use crate::diagnostic::Code;
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::syntax::glsl::evaluate::Problem;

/// A result of parsing.
pub type Parsed<T> = Result<T, SyntaxError>;

/// A syntax error.
#[derive(Clone, Debug)]
pub enum SyntaxError {
    /// A token that does not belong where it stands.
    Unexpected {
        /// Its place.
        span: Span,
        /// Its spelling; empty at the end of the file.
        found: String,
        /// Whether it stands after the end of what is parsed.
        end: bool,
        /// What the grammar allows there.
        wanted: Wanted,
    },
    /// Nesting deeper than the parser goes.
    TooDeep {
        /// Where the limit was reached.
        span: Span,
        /// What nests.
        what: &'static str,
        /// The limit.
        limit: u32,
    },
    /// Any other.
    Other(Box<Diagnostic>),
}

/// What the grammar allows at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// That token.
    Token(&'static str),
    /// A comma or the closing bracket.
    CommaOr(&'static str),
    /// A name.
    Name,
    /// An expression.
    Expression,
    /// Nothing more.
    End,
}

impl SyntaxError {
    /// The error as a finding.
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

    /// The error as why a constant expression that stands at `whole` has no value.
    pub fn problem(self, whole: Span) -> Problem {
        match self {
            SyntaxError::Unexpected { end: true, .. } => Problem::new(whole, "ends too early"),
            SyntaxError::Unexpected { span, found, wanted, .. } => {
                let message = match wanted {
                    Wanted::Token(text) => format!("has `{found}` where `{text}` is wanted"),
                    Wanted::CommaOr(_) => format!("has `{found}` where `,` is wanted"),
                    Wanted::Name | Wanted::Expression | Wanted::End => {
                        format!("has an unexpected `{found}`")
                    }
                };
                Problem::new(span, message)
            }
            SyntaxError::TooDeep { span, limit, .. } => {
                Problem::new(span, format!("is nested more than {limit} deep"))
            }
            SyntaxError::Other(diagnostic) => {
                let span = diagnostic.labels.first().map_or(whole, |label| label.span);
                Problem::new(span, format!("cannot be read: {}", diagnostic.message))
            }
        }
    }
}

impl From<SyntaxError> for Box<Diagnostic> {
    fn from(error: SyntaxError) -> Box<Diagnostic> {
        error.diagnostic()
    }
}
