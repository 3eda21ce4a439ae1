//! Passing over what is not read, and going on where a declaration is broken.
//!
//! The other half of [`declarations`](super).

use super::Reader;
use crate::diagnostic::Code;
use crate::syntax::glsl::lexer::{Kind, Token};

impl<'a> Reader<'a> {
    /// The tokens up to one of `ends` outside brackets. Words that can only begin a new
    /// declaration end it too: then something is missing.
    pub fn collect_until(&mut self, ends: &[&str]) -> Vec<Token<'a>> {
        let mut tokens = Vec::new();
        let mut depth = 0u32;
        loop {
            let token = self.token;
            if token.kind == Kind::End || begins_declaration(token.text) {
                return tokens;
            }
            if depth == 0 && ends.contains(&token.text) {
                return tokens;
            }
            match token.text {
                "(" | "[" | "{" => depth += 1,
                ")" | "]" | "}" if depth == 0 => return tokens,
                ")" | "]" | "}" => depth -= 1,
                _ => {}
            }
            tokens.push(token);
            self.bump();
        }
    }

    /// Passes what stands between a bracket and its partner, both included.
    pub fn skip_balanced(&mut self) {
        let open = self.token;
        let mut depth = 0u32;
        loop {
            match self.token.text {
                "(" | "[" | "{" => depth += 1,
                ")" | "]" | "}" => depth = depth.saturating_sub(1),
                _ if self.token.kind == Kind::End => {
                    let message = format!("`{}` is never closed", open.text);
                    return self.report_at(&open, Code::UnclosedBrace, message);
                }
                _ => {}
            }
            self.bump();
            if depth == 0 {
                return;
            }
        }
    }

    /// `<…>` after a type that has parameters.
    pub(super) fn skip_angles(&mut self) {
        while !self.token.is(">") && !self.token.is(";") && self.token.kind != Kind::End {
            self.bump();
        }
        self.expect(">");
    }

    /// Passes everything up to `;`.
    pub fn skip_statement(&mut self) {
        let start = self.token.span;
        while !self.token.is(";") && self.token.kind != Kind::End {
            let begins = begins_declaration(self.token.text) && self.token.first;
            if begins && self.token.span != start {
                break;
            }
            if matches!(self.token.text, "(" | "[" | "{") {
                self.skip_balanced();
            } else if self.token.is("}") {
                break;
            } else {
                self.bump();
            }
        }
        self.end_of_statement();
    }

    /// Passes `;`, or says that it is missing and goes on at the next declaration.
    pub fn end_of_statement(&mut self) {
        if !self.expect(";") {
            self.recover();
        }
    }

    /// Says that the token makes no sense here, and goes on at the next declaration.
    pub fn unexpected(&mut self) {
        let token = self.token;
        let diagnostic = match (token.kind, token.text) {
            (Kind::End, _) => {
                self.diagnostic(&token, Code::Syntax, "the file ends inside a declaration")
            }
            (_, "}") => self.diagnostic(&token, Code::Syntax, "`}` closes nothing"),
            (Kind::Stray, text) => {
                let message =
                    format!("GLSL has no use for the character `{}`", text.escape_debug());
                self.diagnostic(&token, Code::Syntax, message)
            }
            (_, "(") if self.previous.kind == Kind::Name => {
                let name = self.previous;
                let message = format!("`{}` is called where a declaration is wanted", name.text);
                self.diagnostic(&name, Code::Syntax, message)
                    .with_help(format!("define the macro `{}`, if it is one", name.text))
            }
            (_, text) => self.diagnostic(
                &token,
                Code::Syntax,
                format!("unexpected `{text}` in a declaration"),
            ),
        };
        self.report(diagnostic);
        self.recover();
    }

    /// Goes on at what looks like the next declaration.
    pub fn recover(&mut self) {
        if begins_declaration(self.token.text) && self.token.first {
            return;
        }
        let stray_brace = self.token.is("}");
        loop {
            match self.token.text {
                "{" => {
                    let open = self.token;
                    if self.peeked.is_none() && self.preprocessor.skip_body(&open) {
                        self.token = self.preprocessor.next();
                        return;
                    }
                    // Never closed, or looked beyond: what caused it is reported already.
                    while self.token.kind != Kind::End && !self.token.is("}") {
                        self.bump();
                    }
                    self.bump();
                    return;
                }
                ";" => {
                    self.bump();
                    return;
                }
                "}" if stray_brace => {
                    while self.token.is("}") {
                        self.bump();
                    }
                    return;
                }
                _ if self.token.kind == Kind::End => return,
                _ => {}
            }
            self.bump();
            if begins_declaration(self.token.text) && self.token.first {
                return;
            }
        }
    }
}

/// Words that begin a declaration and stand nowhere else at this level.
fn begins_declaration(word: &str) -> bool {
    matches!(word, "uniform" | "struct" | "layout" | "void" | "precision" | "attribute" | "varying")
}
