//! Uses of block members whose declarations leave their length open, in expressions, with names
//! resolved by scope.

use rustc_hash::FxHashMap;

use super::ast::{Declaration, Expr, ExprKind, FunctionDecl, Item, Statement, TypeBase};
use super::constants::Constants;
use super::declarations::{Unknown, Unsized};
use super::evaluate::{Names, Problem, evaluate};
use super::types::{Builtin, builtin};
use super::walk::{self, Part};
use crate::shape::Type;
use crate::source::Span;
use crate::syntax::constant::{Kind, Value};

/// The local names of a scope; constants of a scalar type have a value.
type Scope<'a> = FxHashMap<&'a str, Option<Value>>;

/// The array lengths that the uses of members imply.
// Per member the lattice none < index < unknown: `largest` only grows, and an error stays.
pub(super) struct MemberUses<'m, 'a> {
    members: &'m [Unsized<'a>],
    constants: &'m Constants<'a>,
    scopes: Vec<Scope<'a>>,
    /// The largest index so far, or why the length cannot be told.
    largest: Vec<Result<Option<u32>, Unknown>>,
}

struct NameResolver<'u, 'm, 'a> {
    scopes: &'u [Scope<'a>],
    constants: &'m Constants<'a>,
}

impl Names for NameResolver<'_, '_, '_> {
    fn value(&mut self, name: &str, span: Span) -> Result<Value, Problem> {
        match self.scopes.iter().rev().find_map(|scope| scope.get(name)) {
            Some(Some(value)) => Ok(value.clone()),
            Some(None) => Err(Problem::new(span, "is not constant")),
            None => self.constants.value(name, span),
        }
    }
}

impl<'m, 'a> MemberUses<'m, 'a> {
    pub fn new(members: &'m [Unsized<'a>], constants: &'m Constants<'a>) -> MemberUses<'m, 'a> {
        let largest = vec![Ok(None); members.len()];
        MemberUses { members, constants, scopes: Vec::new(), largest }
    }

    /// The length of each member, or why it is not known.
    pub fn lengths(&self) -> impl Iterator<Item = Result<u32, Unknown>> {
        self.largest.iter().map(|largest| (*largest)?.map(|index| index + 1).ok_or(Unknown::Unused))
    }

    /// Records that uses at that place may be of any member.
    pub fn unread(&mut self, at: Span) {
        self.largest.fill(Err(Unknown::Ambiguous(at)));
    }

    /// Reads a global declaration, whose expressions are parsed.
    pub fn item(&mut self, item: &Item<'a>) {
        match item {
            Item::Variables(declaration) => {
                let inits = declaration.names.iter().filter_map(|name| name.init.as_deref());
                inits.for_each(|init| self.expression(init));
            }
            Item::Function(function) => self.function(function),
            Item::Block(_)
            | Item::Interface(_)
            | Item::Defaults(_)
            | Item::Requalified(..)
            | Item::Precision(_)
            | Item::Other(_) => {}
        }
    }

    fn function(&mut self, function: &FunctionDecl<'a>) {
        let Some(body) = &function.body else { return };
        let parameters = function.parameters.iter().map(|parameter| (parameter.name.text, None));
        self.scopes.push(parameters.collect());
        self.statements(body);
        self.scopes.pop();
    }

    fn statements(&mut self, statements: &[Statement<'a>]) {
        walk::scope(statements, &mut |part| match part {
            Part::Open => self.scopes.push(Scope::default()),
            Part::Close => drop(self.scopes.pop()),
            Part::Declaration(declaration) => self.declaration(declaration),
            Part::Expression(e) => self.expression(e),
        });
    }

    /// A name hides another from the end of its initialiser (GLSL 4.60 §4.2.2).
    fn declaration(&mut self, declaration: &Declaration<'a>) {
        // Indices are computed from scalars; a constant of another type only hides the names
        // outside.
        let scalar = match &declaration.ty.base {
            TypeBase::Struct(structure) => {
                self.declare(structure.name.text, None);
                None
            }
            TypeBase::Name(name) => match builtin(name) {
                Some(Builtin::Data(Type::Scalar(scalar))) if declaration.ty.dims.is_empty() => {
                    Some(Kind::from(scalar)).filter(|_| declaration.qualifiers.constant)
                }
                _ => None,
            },
        };
        for name in &declaration.names {
            let mut value = None;
            if let Some(init) = name.init.as_deref() {
                self.expression(init);
                let scalar = scalar.filter(|_| name.dims.is_empty());
                value = scalar.and_then(|kind| self.value(init).ok()?.convert(kind).ok());
            }
            self.declare(name.name.text, value);
        }
    }

    fn declare(&mut self, name: &'a str, value: Option<Value>) {
        if let Some(scope) = self.scopes.last_mut() {
            scope.insert(name, value);
        }
    }

    fn value(&self, e: &Expr<'a>) -> Result<Value, Problem> {
        evaluate(e, &mut NameResolver { scopes: &self.scopes, constants: self.constants })
    }

    /// The member that an expression is, by its position.
    // `a` of a block without an instance, `u.a` or `u[i].a` of one with: unless a local variable
    // hides the name.
    fn member(&self, e: &Expr<'a>) -> Option<usize> {
        let (instance, name) = match &e.kind {
            ExprKind::Name(name) => (None, *name),
            ExprKind::Member(block, name) => match &element_of(block).kind {
                ExprKind::Name(instance) => (Some(*instance), name.text),
                _ => return None,
            },
            _ => return None,
        };
        let root = instance.unwrap_or(name);
        if self.scopes.iter().any(|scope| scope.contains_key(root)) {
            return None;
        }
        self.members.iter().position(|m| (m.instance, m.name) == (instance, name))
    }

    fn expression(&mut self, e: &Expr<'a>) {
        if let Some(member) = self.member(e) {
            // Not indexed: `a.length()`, or the array as a whole.
            self.largest[member] = Err(Unknown::Ambiguous(e.span));
            return;
        }
        match &e.kind {
            ExprKind::Index(base, index) => {
                match self.member(base) {
                    Some(member) => {
                        self.index(member, index);
                        if let ExprKind::Member(block, _) = &base.kind {
                            self.expression(block);
                        }
                    }
                    None => self.expression(base),
                }
                self.expression(index);
            }
            _ => walk::operands(e, &mut |operand| self.expression(operand)),
        }
    }

    fn index(&mut self, member: usize, index: &Expr<'a>) {
        let value = self.value(index).ok().and_then(|value| value.integer());
        let now = match value.map(u32::try_from) {
            // The length is the index plus one, which must not overflow.
            Some(Ok(index)) if index < u32::MAX => Ok(Some(index)),
            Some(_) | None => Err(Unknown::NotConstant(index.span)),
        };
        let largest = &mut self.largest[member];
        *largest = largest.and_then(|before| now.map(|now| before.max(now)));
    }
}

/// The array of blocks that an element is of: `u` of `u[1]`.
fn element_of<'e, 'a>(e: &'e Expr<'a>) -> &'e Expr<'a> {
    match &e.kind {
        ExprKind::Index(base, _) => element_of(base),
        _ => e,
    }
}
