//! Macro definitions, and token pasting.

use std::cell::Cell;

use super::lexer::{Lexer, Token};
use super::texts::Texts;
use crate::source::Span;
use std::sync::Arc;

#[derive(Debug)]
pub struct Macro<'a> {
    /// The parameters of a function-like macro.
    pub parameters: Option<Vec<&'a str>>,
    pub body: Vec<Token<'a>>,
    pub span: Span,
    /// Whether its expansion is being read, in which its name is not expanded again.
    pub expanding: Cell<bool>,
}

impl<'a> Macro<'a> {
    pub(crate) fn new(
        name: Token<'a>,
        parameters: Option<Vec<&'a str>>,
        body: Vec<Token<'a>>,
    ) -> Macro<'a> {
        Macro { parameters, body, span: name.span, expanding: Cell::new(false) }
    }

    /// Whether both macros have the same replacement, so that redefinition is allowed.
    // Spellings alone: blanks between tokens, which C compares too, are ignored.
    pub(crate) fn same_as(&self, other: &Macro<'_>) -> bool {
        self.parameters == other.parameters
            && self.body.len() == other.body.len()
            && self.body.iter().zip(&other.body).all(|(a, b)| a.text == b.text)
    }

    /// Whether the braces of the replacement are unbalanced.
    pub(crate) fn has_unpaired_brace(&self) -> bool {
        let count = |brace| self.body.iter().filter(|t| t.is(brace)).count();
        count("{") != count("}")
    }
}

/// Joins the operands of every `##`.
// GLSL 4.60 §3.3: `A ## B ## C` joins from the left: the result of the first is popped as the
// operand of the second. The joined text is read again for its kind, and may be the name of a
// macro.
pub(crate) fn paste<'a>(tokens: Vec<Token<'a>>, texts: &'a Texts) -> Vec<Token<'a>> {
    if !tokens.iter().any(|token| token.is("##")) {
        return tokens;
    }
    let mut result: Vec<Token<'a>> = Vec::with_capacity(tokens.len());
    let mut rest = tokens.into_iter();
    while let Some(token) = rest.next() {
        if !token.is("##") {
            result.push(token);
            continue;
        }
        let (Some(left), Some(right)) = (result.pop(), rest.next()) else { continue };
        let text: &'a str = texts.alloc(Arc::from(format!("{}{}", left.text, right.text)));
        let kind = Lexer::new(text, 0).next(&mut Vec::new()).kind;
        result.push(Token { kind, text, frozen: false, ..left });
    }
    result
}
