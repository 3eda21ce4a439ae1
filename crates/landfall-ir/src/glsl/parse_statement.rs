//! From tokens to [`ast`](super::ast): statements.
//!
//! One of the three parts of the parser, with [`parse`](super::parse) and
//! [`declare`](super::declare).

use super::ast::*;
use super::parse::{Parsed, Parser};
use landfall_layout::diagnostic::Code;
use landfall_layout::diagnostic::Diagnostic;
pub use landfall_layout::syntax::glsl::lexer::Kind;
pub use landfall_layout::syntax::glsl::types::builtin;

/// Statements nest this deep at most; `else if` nests.
const DEEPEST_STATEMENT: u32 = 200;

impl<'a> Parser<'a, '_> {
    /// Statements up to `}`, which is passed.
    pub fn block(&mut self) -> Parsed<Vec<Statement<'a>>> {
        let structures = self.structures.clone();
        let precisions = self.precisions;
        let mut statements = Vec::new();
        while !self.eat("}") {
            statements.push(self.statement()?);
        }
        self.structures = structures;
        self.precisions = precisions;
        Ok(statements)
    }

    pub fn statement(&mut self) -> Parsed<Statement<'a>> {
        self.statements += 1;
        if self.statements > DEEPEST_STATEMENT {
            let message = format!("statements nest more than {DEEPEST_STATEMENT} deep");
            return Err(Box::new(Diagnostic::error(
                Code::NestedTooDeep,
                self.token().span,
                message,
            )));
        }
        let start = self.token().span;
        let kind = self.statement_kind()?;
        self.statements -= 1;
        Ok(Statement { kind, span: self.since(start) })
    }

    pub fn statement_kind(&mut self) -> Parsed<StatementKind<'a>> {
        // GL_EXT_control_flow_attributes: `[[unroll]]`.
        while self.is("[") && self.ahead(1).is("[") {
            while !self.is("]") && self.token().kind != Kind::End {
                self.bump();
            }
            self.expect("]")?;
            self.expect("]")?;
        }
        let word = self.token().text;
        match word {
            ";" => {
                self.bump();
                Ok(StatementKind::Empty)
            }
            "{" => {
                self.bump();
                Ok(StatementKind::Block(self.block()?))
            }
            "if" => {
                self.bump();
                self.expect("(")?;
                let condition = self.condition()?;
                self.expect(")")?;
                let accept = Box::new(self.statement()?);
                let reject = match self.eat("else") {
                    true => Some(Box::new(self.statement()?)),
                    false => None,
                };
                Ok(StatementKind::If(condition, accept, reject))
            }
            "for" => self.for_loop(),
            "while" => {
                self.bump();
                self.expect("(")?;
                let condition = self.condition()?;
                self.expect(")")?;
                Ok(StatementKind::While(condition, Box::new(self.statement()?)))
            }
            "do" => {
                self.bump();
                let body = Box::new(self.statement()?);
                self.expect("while")?;
                self.expect("(")?;
                let condition = self.expression()?;
                self.expect(")")?;
                self.expect(";")?;
                Ok(StatementKind::DoWhile(body, condition))
            }
            "switch" => {
                self.bump();
                self.expect("(")?;
                let selector = self.expression()?;
                self.expect(")")?;
                self.expect("{")?;
                Ok(StatementKind::Switch(selector, self.block()?))
            }
            "case" => {
                self.bump();
                let label = self.expression()?;
                self.expect(":")?;
                Ok(StatementKind::Case(label))
            }
            "default" if self.ahead(1).is(":") => {
                self.at += 2;
                Ok(StatementKind::Default)
            }
            "break" => self.jump(StatementKind::Break),
            "continue" => self.jump(StatementKind::Continue),
            "discard" | "terminateInvocation" | "demote" => self.jump(StatementKind::Discard),
            "return" => {
                self.bump();
                let value = if self.is(";") { None } else { Some(self.expression()?) };
                self.expect(";")?;
                Ok(StatementKind::Return(value))
            }
            "precision" => {
                self.precision_statement();
                Ok(StatementKind::Empty)
            }
            _ if self.begins_declaration() => {
                let declaration = self.local_declaration()?;
                Ok(declaration.map_or(StatementKind::Empty, StatementKind::Declaration))
            }
            _ => {
                let expression = self.expression()?;
                self.expect(";")?;
                Ok(StatementKind::Expression(expression))
            }
        }
    }

    pub fn skip_to_semicolon(&mut self) {
        while !self.is(";") && self.token().kind != Kind::End {
            self.bump();
        }
        self.eat(";");
    }

    fn jump(&mut self, kind: StatementKind<'a>) -> Parsed<StatementKind<'a>> {
        self.bump();
        self.expect(";")?;
        Ok(kind)
    }

    fn for_loop(&mut self) -> Parsed<StatementKind<'a>> {
        self.bump();
        self.expect("(")?;
        let init = self.statement()?;
        let condition = if self.is(";") { None } else { Some(self.condition()?) };
        self.expect(";")?;
        let step = if self.is(")") { None } else { Some(self.expression()?) };
        self.expect(")")?;
        let body = self.statement()?;
        Ok(StatementKind::For(Box::new(For { init, condition, step, body })))
    }

    fn condition(&mut self) -> Parsed<Condition<'a>> {
        if !self.begins_declaration() {
            return Ok(Condition::Expression(self.expression()?));
        }
        let qualifiers = self.qualifiers()?;
        let ty = self.type_spec()?;
        let name = self.name()?;
        self.expect("=")?;
        let init = Some(self.assignment()?);
        let names = vec![Declarator { name, dims: Vec::new(), init }];
        Ok(Condition::Declaration(Declaration { qualifiers, ty, names }))
    }

    /// Whether a declaration stands here, not an expression.
    pub fn begins_declaration(&self) -> bool {
        let token = self.token();
        if token.kind != Kind::Name {
            return false;
        }
        if self.stands_qualifier() || token.is("struct") {
            return true;
        }
        if builtin(token.text).is_none() && !self.structures.contains(token.text) {
            return token.kind == Kind::Name && self.ahead(1).kind == Kind::Name;
        }
        self.ahead(self.past_dims(1)).kind == Kind::Name
    }
}
