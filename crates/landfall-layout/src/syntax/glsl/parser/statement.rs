//! Statements, in function bodies (GLSL 4.60 §6).

use super::{Parsed, Parser, SyntaxError};
use crate::syntax::glsl::ast::{Condition, Declaration, Declarator, For, Statement, StatementKind};
use crate::syntax::glsl::lexer::Kind;
use crate::syntax::glsl::types::builtin;

/// The limit on nested statements; `else if` nests.
const DEEPEST_STATEMENT: u32 = 200;

impl<'a> Parser<'a> {
    // compound_statement_no_new_scope: LEFT_BRACE [statement_list] RIGHT_BRACE
    // Structures and precisions declared in a body end with it (§4.2.2, §4.7.4).
    pub(super) fn body(&mut self) -> Parsed<Vec<Statement<'a>>> {
        (self.depth, self.statements) = (0, 0);
        self.scope(|this| this.token().kind == Kind::End)
    }

    /// Parses statements up to `}`, which is consumed.
    // compound_statement: LEFT_BRACE [statement_list] RIGHT_BRACE
    pub(super) fn block(&mut self) -> Parsed<Vec<Statement<'a>>> {
        self.scope(|this| this.eat("}"))
    }

    fn scope(&mut self, ends: impl Fn(&mut Self) -> bool) -> Parsed<Vec<Statement<'a>>> {
        let (structures, precisions) = (self.structures.clone(), self.precisions);
        let mut statements = Vec::new();
        while !ends(self) {
            statements.push(self.statement()?);
        }
        (self.structures, self.precisions) = (structures, precisions);
        Ok(statements)
    }

    pub(super) fn statement(&mut self) -> Parsed<Statement<'a>> {
        self.statements += 1;
        if self.statements > DEEPEST_STATEMENT {
            return Err(SyntaxError::TooDeep {
                span: self.token().span,
                what: "statements nest",
                limit: DEEPEST_STATEMENT,
            });
        }
        let start = self.token().span;
        let kind = self.statement_kind()?;
        self.statements -= 1;
        Ok(Statement { kind, span: self.since(start) })
    }

    // GLSL 4.60 §9, with `selection_statement` and `switch_statement` under their keywords:
    // statement: compound_statement | declaration_statement | expression_statement
    //     | selection_statement | switch_statement | case_label | iteration_statement
    //     | jump_statement
    // A declaration and an expression may both begin with a name, so they come last.
    pub(super) fn statement_kind(&mut self) -> Parsed<StatementKind<'a>> {
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
            // `case_label` is a statement like others (§9), so the cases are not grouped here.
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
                self.eat_two();
                Ok(StatementKind::Default)
            }
            "break" => self.jump(StatementKind::Break),
            "continue" => self.jump(StatementKind::Continue),
            // GL_EXT_terminate_invocation, GL_EXT_demote_to_helper_invocation: for the result of a
            // function alike.
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

    fn jump(&mut self, kind: StatementKind<'a>) -> Parsed<StatementKind<'a>> {
        self.bump();
        self.expect(";")?;
        Ok(kind)
    }

    // FOR LEFT_PAREN for_init_statement [condition] SEMICOLON [expression] RIGHT_PAREN
    //     statement_no_new_scope
    // for_init_statement: expression_statement | declaration_statement
    // The first statement includes its `;`.
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

    // condition: expression | fully_specified_type IDENTIFIER EQUAL initializer
    fn condition(&mut self) -> Parsed<Condition<'a>> {
        if !self.begins_declaration() {
            return Ok(Condition::Expression(self.expression()?));
        }
        let start = self.at;
        let qualifiers = self.qualifiers();
        let ty = self.type_spec()?;
        let name = self.name()?;
        self.expect("=")?;
        let from = self.at;
        let init = Some(Box::new(self.assignment()?));
        let names = vec![Declarator { name, dims: Vec::new(), tokens: from..self.at, init }];
        let tokens = start..self.at;
        Ok(Condition::Declaration(Declaration { tokens, qualifiers, ty, names, broken: false }))
    }

    /// Whether a declaration is next rather than an expression.
    // `Unknown a` is taken for a declaration, since no expression has two names in a row; the
    // unknown type is then the error. After a known type, with its `[…]`, a name has to follow:
    // `vec2 a`, `S[2] a`, but `vec2(1.0)` and `S[2](…)` are expressions.
    pub(super) fn begins_declaration(&mut self) -> bool {
        let token = *self.token();
        if token.kind != Kind::Name {
            return false;
        }
        if self.stands_qualifier() || token.is("struct") {
            return true;
        }
        if builtin(token.text).is_none() && !self.structures.contains(token.text) {
            return token.kind == Kind::Name && self.ahead(1).kind == Kind::Name;
        }
        let past = self.past_dims(1);
        self.ahead(past).kind == Kind::Name
    }
}
