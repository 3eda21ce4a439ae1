//! Macros as defined, and the pasting of tokens.

use super::lexer::{Lexer, Token};
use super::preprocess::Texts;
use crate::source::Span;
use std::sync::Arc;

/// A macro as `#define` made it.
#[derive(Debug)]
pub struct Macro<'a> {
    /// Its name.
    pub name: &'a str,
    /// Parameters of a function-like macro.
    pub parameters: Option<Vec<&'a str>>,
    /// What it stands for.
    pub body: Vec<Token<'a>>,
    /// Its name in the text.
    pub span: Span,
}

impl Macro<'_> {
    /// Whether both stand for the same tokens: then defining it again changes nothing.
    pub fn same_as(&self, other: &Macro<'_>) -> bool {
        self.parameters == other.parameters
            && self.body.len() == other.body.len()
            && self.body.iter().zip(&other.body).all(|(a, b)| a.text == b.text)
    }

    /// Whether its braces do not pair up.
    pub fn has_unpaired_brace(&self) -> bool {
        let count = |brace| self.body.iter().filter(|t| t.is(brace)).count();
        count("{") != count("}")
    }
}

/// Joins the operands of every `##`.
pub fn paste<'a>(tokens: Vec<Token<'a>>, texts: &'a Texts) -> Vec<Token<'a>> {
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
