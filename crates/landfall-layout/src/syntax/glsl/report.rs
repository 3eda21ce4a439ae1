//! Diagnostics at tokens.

use super::lexer::Token;
use crate::Diagnostic;
use crate::diagnostic::Code;

/// Creates a diagnostic at a token, labelled with the macro it comes from.
pub(super) fn diagnostic_at(
    token: &Token<'_>,
    code: Code,
    message: impl Into<String>,
) -> Diagnostic {
    let diagnostic = Diagnostic::error(code, token.span, message);
    match token.definition {
        Some(definition) => diagnostic.with_label(definition, "from this macro"),
        None => diagnostic,
    }
}
