//! Skipping of text not parsed yet, and recovery from broken declarations.
//!
//! One mistake is to be one error, and blocks after it are still to be laid out. So a declaration
//! ends at what can only begin another, and the search for that keeps brackets balanced.

use super::{Bodies, Parser};
use crate::diagnostic::Code;
use crate::source::Span;
use crate::syntax::glsl::lexer::{Kind, Token};
use crate::syntax::glsl::report::diagnostic_at;

impl<'a> Parser<'a> {
    /// Consumes that operator or bracket, or reports that it is missing.
    pub(super) fn expect_or_report(&mut self, text: &str) -> bool {
        if self.eat(text) {
            return true;
        }
        let token = *self.token();
        let found = match token.kind {
            Kind::End => "the end of the file".to_string(),
            _ => format!("`{}`", token.text),
        };
        let diagnostic =
            diagnostic_at(&token, Code::Syntax, format!("expected `{text}`, found {found}"));
        // The token at fault is often on the next line; the label is where the missing one belongs.
        let previous = self.before(self.at);
        let after = Span { start: previous.span.end, ..previous.span };
        self.report(match previous.kind {
            Kind::End => diagnostic,
            _ => diagnostic.with_label(after, format!("`{text}` may be missing here")),
        });
        false
    }

    /// Consumes `}`, or reports the opening brace.
    pub(super) fn close(&mut self, open: &Token<'a>) -> bool {
        if self.eat("}") {
            return true;
        }
        if self.token().kind == Kind::End {
            self.report(diagnostic_at(open, Code::UnclosedBrace, "`{` is never closed"));
        } else {
            self.recover();
        }
        false
    }

    /// Skips tokens up to one of `ends` outside brackets. Words that can only begin a new
    /// declaration end it too, since something is missing then.
    // Without the words that begin declarations, `float a = 1` with no `;` would swallow the rest
    // of the file.
    pub(super) fn skip_until(&mut self, ends: &[&str]) {
        let mut depth = 0u32;
        loop {
            let token = self.token();
            if token.kind == Kind::End || begins_declaration(token.text) {
                return;
            }
            if depth == 0 && ends.contains(&token.text) {
                return;
            }
            match token.text {
                "(" | "[" | "{" => depth += 1,
                ")" | "]" | "}" if depth == 0 => return,
                ")" | "]" | "}" => depth -= 1,
                _ => {}
            }
            self.bump();
        }
    }

    /// Skips from a bracket to its partner, both included.
    // Kinds of brackets are not told apart: a wrong one is an error that the parse of the part
    // reports.
    pub(super) fn skip_balanced(&mut self) {
        let open = *self.token();
        if !self.skip_nested(&["(", "[", "{"], &[")", "]", "}"]) {
            let message = format!("`{}` is never closed", open.text);
            self.report(diagnostic_at(&open, Code::UnclosedBrace, message));
        }
    }

    /// Skips a body by its braces alone; returns whether it is closed.
    pub(super) fn skip_braces(&mut self) -> bool {
        self.skip_nested(&["{"], &["}"])
    }

    /// Skips to where as many brackets are closed as were opened; returns whether they are.
    fn skip_nested(&mut self, opening: &[&str], closing: &[&str]) -> bool {
        let mut depth = 0u32;
        loop {
            let token = *self.token();
            if token.kind == Kind::End {
                return false;
            }
            if opening.contains(&token.text) {
                depth += 1;
            } else if closing.contains(&token.text) {
                depth = depth.saturating_sub(1);
            }
            self.bump();
            if depth == 0 {
                return true;
            }
        }
    }

    /// Skips `<…>` after a type with parameters.
    pub(super) fn skip_angles(&mut self) {
        while !self.is(">") && !self.is(";") && self.token().kind != Kind::End {
            self.bump();
        }
        self.expect_or_report(">");
    }

    /// Skips to after `;`, brackets balanced.
    // A word at the start of a line that can only begin a declaration ends it: a `;` is missing
    // before.
    pub(super) fn skip_statement(&mut self) {
        let start = self.token().span;
        while !self.is(";") && self.token().kind != Kind::End {
            let token = self.token();
            if begins_declaration(token.text) && token.first && token.span != start {
                break;
            }
            if matches!(token.text, "(" | "[" | "{") {
                self.skip_balanced();
            } else if token.is("}") {
                break;
            } else {
                self.bump();
            }
        }
        self.end_of_statement();
    }

    /// Skips to after `;`, ignoring brackets.
    pub(super) fn skip_to_semicolon(&mut self) {
        while !self.is(";") && self.token().kind != Kind::End {
            self.bump();
        }
        self.eat(";");
    }

    /// Consumes `;`, or reports that it is missing and skips to the next declaration.
    pub(super) fn end_of_statement(&mut self) {
        if !self.expect_or_report(";") {
            self.recover();
        }
    }

    /// Reports the current token as unexpected and skips to the next declaration.
    pub(super) fn report_unexpected(&mut self) {
        let token = *self.token();
        let previous = self.before(self.at);
        let diagnostic = match (token.kind, token.text) {
            (Kind::End, _) => {
                diagnostic_at(&token, Code::Syntax, "the file ends inside a declaration")
            }
            (_, "}") => diagnostic_at(&token, Code::Syntax, "unmatched `}`"),
            (Kind::Stray, text) => {
                let message = format!("unexpected character `{}`", text.escape_debug());
                diagnostic_at(&token, Code::Syntax, message)
            }
            // `MACRO(x)` at global level, whose definition is in a file that was not read.
            (_, "(") if previous.kind == Kind::Name => {
                let name = previous.text;
                let message = format!("expected a declaration, found a call of `{name}`");
                diagnostic_at(&previous, Code::Syntax, message)
                    .with_help(format!("if `{name}` is a macro, define it"))
            }
            (_, text) => {
                diagnostic_at(&token, Code::Syntax, format!("unexpected `{text}` in a declaration"))
            }
        };
        self.report(diagnostic);
        self.recover();
    }

    /// Skips to what looks like the next declaration.
    // Among members the next member is the place to go on; outside, the next line that begins with
    // a word of declarations, a `;`, or the end of a body. A stray `}` takes those beside it along,
    // so that one brace too many is one error.
    pub(super) fn recover(&mut self) {
        if self.open_members > 0 {
            self.recover_member();
            self.eat(";");
            return;
        }
        if self.stands_at_declaration() {
            return;
        }
        let stray_brace = self.is("}");
        loop {
            match self.token().text {
                "{" => return self.recover_past_braces(),
                ";" => {
                    self.bump();
                    return;
                }
                "}" if stray_brace => {
                    while self.eat("}") {}
                    return;
                }
                _ if self.token().kind == Kind::End => return,
                _ => {}
            }
            self.bump();
            if self.stands_at_declaration() {
                return;
            }
        }
    }

    fn recover_past_braces(&mut self) {
        if self.bodies == Bodies::Keep {
            self.skip_braces();
            return;
        }
        let open = *self.token();
        // Nothing after the `{` may have been read as tokens, or the preprocessor is past a part of
        // the body.
        if self.tokens.len() == self.at + 1 && self.preprocessor().skip_body(&open) {
            self.tokens.pop();
            self.load(self.at);
            return;
        }
        // Never closed, or examined past its end: the cause is reported already.
        while self.token().kind != Kind::End && !self.is("}") {
            self.bump();
        }
        self.bump();
    }

    /// Skips to the next `;` or before the closing brace, after a syntax error among members.
    pub(super) fn recover_member(&mut self) {
        while !matches!(self.token().text, ";" | "}") && self.token().kind != Kind::End {
            if matches!(self.token().text, "(" | "[" | "{") {
                self.skip_balanced();
            } else {
                self.bump();
            }
        }
    }

    fn stands_at_declaration(&self) -> bool {
        let token = self.token();
        token.first && begins_declaration(token.text)
    }
}

/// Whether a word begins a declaration and occurs nowhere else at this level.
fn begins_declaration(word: &str) -> bool {
    matches!(word, "uniform" | "struct" | "layout" | "void" | "precision" | "attribute" | "varying")
}
