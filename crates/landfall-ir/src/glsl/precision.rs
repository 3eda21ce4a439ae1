//! Finds the expressions of an ES shader that need no more than `mediump` (GLSL ES 3.20 §4.7).
//!
//! The parser records the precision of every declared type; this module walks the syntax tree and
//! returns the spans of the expressions whose operands are all `mediump` or `lowp`. Lowering
//! ignores them: the interpreter looks spans up when it rounds. Integers are not rounded;
//! expressions from one macro share a span.

use std::rc::Rc;

use rustc_hash::{FxHashMap, FxHashSet};

use super::ast::*;
use landfall_layout::source::Span;
use landfall_layout::syntax::glsl::walk::{self, Part};

/// Returns the spans of expressions that may be rounded; empty if the dialect has no precisions.
pub fn reduced(items: &[Item<'_>]) -> FxHashSet<Span> {
    let mut walk = PrecisionWalk { scopes: vec![FxHashMap::default()], ..PrecisionWalk::default() };
    // All functions first: a call may come before the definition.
    for item in items {
        if let Item::Function(function) = item {
            let returns = walk.known(&function.returns);
            walk.functions.insert(function.name.text, returns);
        }
    }
    for item in items {
        walk.item(item);
    }
    walk.reduced
}

type Members<'a> = FxHashMap<&'a str, KnownPrecision<'a>>;

/// The precision of a variable or value, `None` for a literal, and its members.
#[derive(Clone, Debug, Default)]
struct KnownPrecision<'a> {
    precision: Option<PrecisionQualifier>,
    members: Option<Rc<Members<'a>>>,
}

#[derive(Default)]
struct PrecisionWalk<'a> {
    scopes: Vec<Members<'a>>,
    structures: FxHashMap<&'a str, Rc<Members<'a>>>,
    functions: FxHashMap<&'a str, KnownPrecision<'a>>,
    reduced: FxHashSet<Span>,
}

impl<'a> PrecisionWalk<'a> {
    fn item(&mut self, item: &Item<'a>) {
        match item {
            Item::Variables(declaration) => self.declaration(declaration),
            Item::Block(block) | Item::Interface(block) => {
                let members = self.members(&block.members);
                // Members of a block without an instance name are global.
                match &block.instance {
                    Some(instance) => {
                        let members = Some(Rc::new(members));
                        self.declare(instance.text, KnownPrecision { precision: None, members });
                    }
                    None => members.into_iter().for_each(|(name, known)| self.declare(name, known)),
                }
            }
            Item::Function(function) => {
                self.scopes.push(FxHashMap::default());
                for parameter in &function.parameters {
                    let known = self.known(&parameter.ty);
                    // A parameter is rounded where it is passed.
                    if is_reduced(known.precision) {
                        self.reduced.insert(parameter.name.span);
                    }
                    self.declare(parameter.name.text, known);
                }
                self.statements(function.body.as_deref().unwrap_or_default());
                self.scopes.pop();
            }
            Item::Defaults(_) | Item::Requalified(..) | Item::Precision(_) | Item::Other(_) => {}
        }
    }

    fn declare(&mut self, name: &'a str, known: KnownPrecision<'a>) {
        self.scopes.last_mut().expect("the outermost scope stays").insert(name, known);
    }

    fn members(&mut self, declarations: &[Declaration<'a>]) -> Members<'a> {
        let mut members = Members::default();
        for declaration in declarations {
            // A later declaration of the same name hides this one in its scope.
            let known = self.known(&declaration.ty);
            let names = declaration.names.iter().map(|declarator| declarator.name.text);
            members.extend(names.map(|name| (name, known.clone())));
        }
        members
    }

    fn known(&mut self, ty: &TypeSpec<'a>) -> KnownPrecision<'a> {
        let members = match &ty.base {
            TypeBase::Name(name) => self.structures.get(name).cloned(),
            TypeBase::Struct(structure) => {
                let members = Rc::new(self.members(&structure.members));
                self.structures.insert(structure.name.text, members.clone());
                Some(members)
            }
        };
        // The precision of a structure is that of each of its members.
        let precision = if members.is_some() { None } else { ty.precision };
        KnownPrecision { precision, members }
    }

    fn declaration(&mut self, declaration: &Declaration<'a>) {
        let known = self.known(&declaration.ty);
        for declarator in &declaration.names {
            if let Some(init) = &declarator.init {
                self.expression(init);
            }
            self.declare(declarator.name.text, known.clone());
        }
    }

    fn statements(&mut self, statements: &[Statement<'a>]) {
        walk::scope(statements, &mut |part| match part {
            Part::Open => self.scopes.push(FxHashMap::default()),
            Part::Close => drop(self.scopes.pop()),
            Part::Declaration(declaration) => self.declaration(declaration),
            Part::Expression(e) => drop(self.expression(e)),
        });
    }

    fn expression(&mut self, e: &Expr<'a>) -> KnownPrecision<'a> {
        let known = self.of(e);
        if is_reduced(known.precision) {
            self.reduced.insert(e.span);
        }
        known
    }

    /// Returns the highest precision of several; literals have none of their own.
    fn highest<'e>(&mut self, all: impl IntoIterator<Item = &'e Expr<'a>>) -> KnownPrecision<'a>
    where
        'a: 'e,
    {
        let mut known = KnownPrecision::default();
        // An operation has the highest precision of its operands (GLSL ES 3.20 §4.7.3). `None` is
        // below all others.
        for e in all {
            let one = self.expression(e);
            known.precision = known.precision.max(one.precision);
            known.members = known.members.or(one.members);
        }
        known
    }

    fn of(&mut self, e: &Expr<'a>) -> KnownPrecision<'a> {
        match &e.kind {
            ExprKind::Number(_) | ExprKind::Bool(_) => KnownPrecision::default(),
            ExprKind::Name(name) => {
                let found = self.scopes.iter().rev().find_map(|scope| scope.get(name));
                found.cloned().unwrap_or_else(|| predeclared(name))
            }
            ExprKind::Unary(_, inner) | ExprKind::Step(_, inner) => self.expression(inner),
            ExprKind::Binary(operator, a, b) => {
                let known = self.highest([&**a, &**b]);
                // Comparisons and logic give booleans, which have no precision.
                if is_arithmetic(*operator) { known } else { KnownPrecision::default() }
            }
            // `a += b` computes with both; `a = b` has that of `a`.
            ExprKind::Assign(operator, left, right) => match operator {
                Some(_) => self.highest([&**left, &**right]),
                None => {
                    self.expression(right);
                    self.expression(left)
                }
            },
            ExprKind::Choose(parts) => {
                let [condition, accept, reject] = &**parts;
                self.expression(condition);
                self.highest([accept, reject])
            }
            ExprKind::Comma(a, b) => {
                self.expression(a);
                self.expression(b)
            }
            ExprKind::Index(base, index) => {
                self.expression(index);
                self.expression(base)
            }
            ExprKind::Member(base, name) => {
                let base = self.expression(base);
                match &base.members {
                    Some(members) => members.get(name.text).cloned().unwrap_or_default(),
                    None => base,
                }
            }
            ExprKind::Call(name, arguments) => {
                let all: Vec<KnownPrecision> =
                    // A function of the shader: the precision of its result is declared.
                    arguments.iter().map(|e| self.expression(e)).collect();
                if let Some(returns) = self.functions.get(name.text) {
                    return returns.clone();
                }
                if let Some(members) = self.structures.get(name.text) {
                    return KnownPrecision { precision: None, members: Some(members.clone()) };
                }
                // A sampled value has the precision of its sampler.
                let counted = if name.text.starts_with("texture") { 1 } else { all.len() };
                let precision = all.iter().take(counted).filter_map(|one| one.precision).max();
                KnownPrecision { precision, members: None }
            }
            ExprKind::Construct(ty, arguments) => {
                let all = self.highest(arguments);
                let known = self.known(ty);
                // A constructor has no precision of its own; a structure's members do.
                match known.members {
                    Some(_) => known,
                    None => KnownPrecision { precision: all.precision, members: None },
                }
            }
            ExprKind::Length(inner) => {
                self.expression(inner);
                KnownPrecision::default()
            }
            ExprKind::List(all) => self.highest(all),
        }
    }
}

fn is_reduced(precision: Option<PrecisionQualifier>) -> bool {
    match precision {
        Some(PrecisionQualifier::Low | PrecisionQualifier::Medium) => true,
        Some(PrecisionQualifier::High) | None => false,
    }
}

/// Returns the precision of a built-in variable (GLSL ES 3.20 §7, 1.00 §7).
fn predeclared<'a>(name: &str) -> KnownPrecision<'a> {
    let precision = match name {
        "gl_FragColor" | "gl_FragData" | "gl_PointCoord" => PrecisionQualifier::Medium,
        _ => PrecisionQualifier::High,
    };
    KnownPrecision { precision: Some(precision), members: None }
}

fn is_arithmetic(operator: Binary) -> bool {
    match operator {
        Binary::Add
        | Binary::Subtract
        | Binary::Multiply
        | Binary::Divide
        | Binary::Modulo
        | Binary::ShiftLeft
        | Binary::ShiftRight
        | Binary::BitAnd
        | Binary::BitXor
        | Binary::BitOr => true,
        Binary::Less
        | Binary::LessEqual
        | Binary::Greater
        | Binary::GreaterEqual
        | Binary::Equal
        | Binary::NotEqual
        | Binary::And
        | Binary::Xor
        | Binary::Or => false,
    }
}
