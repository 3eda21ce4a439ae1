//! The global names that expressions and function bodies use: local names hide them by scope
//! (GLSL 4.60 §4.2.2).

use rustc_hash::FxHashSet;

use super::ast::{
    Condition, Declaration, Expr, ExprKind, FunctionDecl, Statement, StatementKind, TypeBase,
    TypeSpec,
};

/// A use of a name that no local declaration hides.
#[derive(Clone, Copy, Debug)]
pub(super) enum Use<'e, 'a> {
    /// A variable, block or constant.
    Name(&'a str),
    /// A function or a structure's constructor.
    Call(&'a str),
    /// The arguments of a constructor of a built-in type or of an array.
    Construct(&'e [Expr<'a>]),
}

/// Walks over expressions and bodies, and passes each use of a global name to `found`.
pub(super) struct Scopes<'a, F> {
    locals: Vec<FxHashSet<&'a str>>,
    found: F,
}

impl<'a, F: FnMut(Use<'_, 'a>)> Scopes<'a, F> {
    /// Starts at global scope.
    pub fn new(found: F) -> Scopes<'a, F> {
        Scopes { locals: Vec::new(), found }
    }

    /// Walks over a function whose parameters and body are parsed.
    pub fn function(&mut self, function: &FunctionDecl<'a>) {
        let Some(body) = &function.body else { return };
        self.ty(&function.returns);
        function.parameters.iter().for_each(|parameter| self.ty(&parameter.ty));
        self.locals.push(function.parameters.iter().map(|p| p.name.text).collect());
        self.scope(body);
        self.locals.pop();
    }

    fn scope(&mut self, statements: &[Statement<'a>]) {
        self.locals.push(FxHashSet::default());
        statements.iter().for_each(|statement| self.statement(statement));
        self.locals.pop();
    }

    fn statement(&mut self, statement: &Statement<'a>) {
        match &statement.kind {
            StatementKind::Declaration(declaration) => self.declaration(declaration),
            StatementKind::Expression(e)
            | StatementKind::Case(e)
            | StatementKind::Return(Some(e)) => self.expression(e),
            StatementKind::Block(statements) => self.scope(statements),
            StatementKind::If(condition, accept, reject) => {
                self.locals.push(FxHashSet::default());
                self.condition(condition);
                self.scope(std::slice::from_ref(accept));
                reject.iter().for_each(|reject| self.scope(std::slice::from_ref(reject)));
                self.locals.pop();
            }
            StatementKind::For(parts) => {
                self.locals.push(FxHashSet::default());
                self.statement(&parts.init);
                parts.condition.iter().for_each(|condition| self.condition(condition));
                parts.step.iter().for_each(|step| self.expression(step));
                self.scope(std::slice::from_ref(&parts.body));
                self.locals.pop();
            }
            StatementKind::While(condition, body) => {
                self.locals.push(FxHashSet::default());
                self.condition(condition);
                self.scope(std::slice::from_ref(body));
                self.locals.pop();
            }
            StatementKind::DoWhile(body, condition) => {
                self.scope(std::slice::from_ref(body));
                self.expression(condition);
            }
            StatementKind::Switch(selector, statements) => {
                self.expression(selector);
                self.scope(statements);
            }
            StatementKind::Empty
            | StatementKind::Default
            | StatementKind::Break
            | StatementKind::Continue
            | StatementKind::Discard
            | StatementKind::Return(None) => {}
        }
    }

    fn condition(&mut self, condition: &Condition<'a>) {
        match condition {
            Condition::Expression(e) => self.expression(e),
            Condition::Declaration(declaration) => self.declaration(declaration),
        }
    }

    /// Walks over a declaration, global ones included, whose initialisers are parsed.
    pub fn declaration(&mut self, declaration: &Declaration<'a>) {
        self.ty(&declaration.ty);
        if let TypeBase::Struct(structure) = &declaration.ty.base {
            self.declare(structure.name.text);
        }
        for declarator in &declaration.names {
            let sizes = declarator.dims.iter().filter_map(|dim| dim.size.as_deref());
            sizes.for_each(|size| self.expression(size));
            if let Some(init) = &declarator.init {
                self.expression(init);
            }
            // A name hides another from the end of its initialiser.
            self.declare(declarator.name.text);
        }
    }

    fn declare(&mut self, name: &'a str) {
        if let Some(scope) = self.locals.last_mut() {
            scope.insert(name);
        }
    }

    fn ty(&mut self, ty: &TypeSpec<'a>) {
        let sizes = ty.dims.iter().filter_map(|dim| dim.size.as_deref());
        sizes.for_each(|size| self.expression(size));
        if let TypeBase::Struct(structure) = &ty.base {
            for member in &structure.members {
                self.ty(&member.ty);
                let dims = member.names.iter().flat_map(|name| &name.dims);
                dims.filter_map(|dim| dim.size.as_deref()).for_each(|size| self.expression(size));
            }
        }
    }

    fn is_local(&self, name: &str) -> bool {
        self.locals.iter().any(|scope| scope.contains(name))
    }

    /// Walks over an expression.
    pub fn expression(&mut self, e: &Expr<'a>) {
        match &e.kind {
            ExprKind::Name(name) => {
                if !self.is_local(name) {
                    (self.found)(Use::Name(name));
                }
            }
            ExprKind::Unary(_, a)
            | ExprKind::Step(_, a)
            | ExprKind::Member(a, _)
            | ExprKind::Length(a) => self.expression(a),
            ExprKind::Binary(_, a, b)
            | ExprKind::Assign(_, a, b)
            | ExprKind::Comma(a, b)
            | ExprKind::Index(a, b) => {
                self.expression(a);
                self.expression(b);
            }
            ExprKind::Choose(parts) => parts.iter().for_each(|e| self.expression(e)),
            ExprKind::Call(name, all) => {
                if !self.is_local(name.text) {
                    (self.found)(Use::Call(name.text));
                }
                all.iter().for_each(|e| self.expression(e));
            }
            ExprKind::Construct(ty, all) => {
                self.ty(ty);
                (self.found)(Use::Construct(all));
                all.iter().for_each(|e| self.expression(e));
            }
            ExprKind::List(all) => all.iter().for_each(|e| self.expression(e)),
            ExprKind::Number(_) | ExprKind::Bool(_) => {}
        }
    }
}
