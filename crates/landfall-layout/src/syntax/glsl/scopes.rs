//! The global names that expressions and function bodies use: local names hide them by scope
//! (GLSL 4.60 §4.2.2).

use rustc_hash::FxHashSet;

use super::ast::{Declaration, Expr, ExprKind, FunctionDecl, Statement, TypeBase, TypeSpec};
use super::walk::{self, Part};

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
    // The parameters are a scope around that of the body (GLSL 4.60 §4.2.2 has one for both; a
    // local that repeats a parameter is an error that is not of interest here).
    pub fn function(&mut self, function: &FunctionDecl<'a>) {
        let Some(body) = &function.body else { return };
        self.ty(&function.returns);
        function.parameters.iter().for_each(|parameter| self.ty(&parameter.ty));
        self.locals.push(function.parameters.iter().map(|p| p.name.text).collect());
        self.scope(body);
        self.locals.pop();
    }

    fn scope(&mut self, statements: &[Statement<'a>]) {
        walk::scope(statements, &mut |part| match part {
            Part::Open => self.locals.push(FxHashSet::default()),
            Part::Close => drop(self.locals.pop()),
            Part::Declaration(declaration) => self.declaration(declaration),
            Part::Expression(e) => self.expression(e),
        });
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

    // At global scope nothing is local.
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

    pub fn expression(&mut self, e: &Expr<'a>) {
        match &e.kind {
            ExprKind::Name(name) if !self.is_local(name) => (self.found)(Use::Name(name)),
            ExprKind::Call(name, _) if !self.is_local(name.text) => {
                (self.found)(Use::Call(name.text));
            }
            ExprKind::Construct(ty, all) => {
                self.ty(ty);
                (self.found)(Use::Construct(all));
            }
            _ => {}
        }
        walk::operands(e, &mut |operand| self.expression(operand));
    }
}
