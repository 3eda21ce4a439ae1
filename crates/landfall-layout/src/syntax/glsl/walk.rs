//! A walk over statements, in the order of the text: scopes, declarations and expressions.

use super::ast::{Condition, Declaration, Expr, Statement, StatementKind};

pub enum Part<'e, 'a> {
    /// A scope begins (GLSL 4.60 §4.2.2).
    Open,
    Close,
    Declaration(&'e Declaration<'a>),
    Expression(&'e Expr<'a>),
}

/// Passes the parts of statements in a scope of their own to `see`.
pub fn scope<'e, 'a>(statements: &'e [Statement<'a>], see: &mut impl FnMut(Part<'e, 'a>)) {
    see(Part::Open);
    statements.iter().for_each(|one| statement(one, see));
    see(Part::Close);
}

/// Passes all expressions of statements to `see`, each before those in it.
pub fn expressions<'e, 'a>(statements: &'e [Statement<'a>], see: &mut impl FnMut(&'e Expr<'a>)) {
    scope(statements, &mut |part| match part {
        Part::Open | Part::Close => {}
        Part::Declaration(declaration) => {
            let inits = declaration.names.iter().filter_map(|name| name.init.as_deref());
            inits.for_each(|init| inside(init, see));
        }
        Part::Expression(e) => inside(e, see),
    });
}

fn inside<'e, 'a>(e: &'e Expr<'a>, see: &mut impl FnMut(&'e Expr<'a>)) {
    see(e);
    operands(e, &mut |operand| inside(operand, see));
}

fn statement<'e, 'a>(statement: &'e Statement<'a>, see: &mut impl FnMut(Part<'e, 'a>)) {
    let one = std::slice::from_ref;
    match &statement.kind {
        StatementKind::Declaration(declaration) => see(Part::Declaration(declaration)),
        StatementKind::Expression(e) | StatementKind::Case(e) | StatementKind::Return(Some(e)) => {
            see(Part::Expression(e));
        }
        StatementKind::Block(statements) => scope(statements, see),
        // GLSL 4.60 §6.2, §6.3 and §4.2.2: a branch or body is a scope even without braces; a
        // variable declared in a condition or a `for` head is in scope in the body as well. The
        // condition of `do … while` is outside its body's scope.
        StatementKind::If(if_true, accept, reject) => {
            see(Part::Open);
            condition(if_true, see);
            scope(one(accept), see);
            if let Some(reject) = reject {
                scope(one(reject), see);
            }
            see(Part::Close);
        }
        StatementKind::For(parts) => {
            see(Part::Open);
            self::statement(&parts.init, see);
            if let Some(until) = &parts.condition {
                condition(until, see);
            }
            if let Some(step) = &parts.step {
                see(Part::Expression(step));
            }
            scope(one(&parts.body), see);
            see(Part::Close);
        }
        StatementKind::While(until, body) => {
            see(Part::Open);
            condition(until, see);
            scope(one(body), see);
            see(Part::Close);
        }
        StatementKind::DoWhile(body, until) => {
            scope(one(body), see);
            see(Part::Expression(until));
        }
        StatementKind::Switch(selector, statements) => {
            see(Part::Expression(selector));
            scope(statements, see);
        }
        StatementKind::Empty
        | StatementKind::Default
        | StatementKind::Break
        | StatementKind::Continue
        | StatementKind::Discard
        | StatementKind::Return(None) => {}
    }
}

fn condition<'e, 'a>(condition: &'e Condition<'a>, see: &mut impl FnMut(Part<'e, 'a>)) {
    match condition {
        Condition::Expression(e) => see(Part::Expression(e)),
        Condition::Declaration(declaration) => see(Part::Declaration(declaration)),
    }
}

/// Passes the expressions that an expression consists of to `see`.
pub fn operands<'e, 'a>(e: &'e Expr<'a>, see: &mut impl FnMut(&'e Expr<'a>)) {
    use super::ast::ExprKind as Kind;
    match &e.kind {
        Kind::Unary(_, a) | Kind::Step(_, a) | Kind::Member(a, _) | Kind::Length(a) => see(a),
        Kind::Binary(_, a, b) | Kind::Assign(_, a, b) | Kind::Comma(a, b) | Kind::Index(a, b) => {
            see(a);
            see(b);
        }
        Kind::Choose(parts) => parts.iter().for_each(see),
        Kind::Call(_, all) | Kind::Construct(_, all) | Kind::List(all) => all.iter().for_each(see),
        Kind::Number(_) | Kind::Bool(_) | Kind::Name(_) => {}
    }
}
