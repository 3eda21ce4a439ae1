//! Lowers statements.

use naga::{Statement as S, SwitchCase, SwitchValue};

use super::ast::*;
use super::body::{Body, Symbol, TypedValue};
use super::constant::Const;
use super::construct::sized_by;
use super::types::Ty;
use super::{Lowerer, Lowering};

/// The most statements that fall-through may duplicate in one `switch`.
/// Each case is written again for every case that falls into it: quadratic in their number.
const MAX_REPEATED: usize = 1000;

impl<'a> Body<'_, 'a> {
    pub fn statements(&mut self, statements: &[Statement<'a>]) -> Lowering<()> {
        for statement in statements {
            if self.dead {
                return Ok(()); // nothing after a jump is ever run
            }
            self.lower(statement)?;
        }
        Ok(())
    }

    fn lower(&mut self, statement: &Statement<'a>) -> Lowering<()> {
        self.span = statement.span;
        self.deeper(|this| this.lower_kind(statement))
    }

    fn lower_kind(&mut self, statement: &Statement<'a>) -> Lowering<()> {
        // One case for each kind of statement of GLSL 4.60 §6.
        match &statement.kind {
            StatementKind::Empty | StatementKind::Case(_) | StatementKind::Default => Ok(()),
            StatementKind::Declaration(declaration) => self.declaration(declaration),
            StatementKind::Expression(e) => self.effect(e),
            StatementKind::Block(statements) => self.scoped(|this| this.statements(statements)),
            // The condition may declare a name, which is in the scope of both branches.
            StatementKind::If(condition, accept, reject) => self.scoped(|this| {
                let condition = this.condition(condition)?;
                let (accept, ends) = this.branch(Some(accept))?;
                let (reject, other_ends) = this.branch(reject.as_deref())?;
                this.span = statement.span;
                this.statement(S::If { condition: condition.expr, accept, reject });
                // Nothing follows an `if` of which both branches jump.
                this.dead |= ends && other_ends;
                Ok(())
            }),
            // for = "for" "(" init [condition] ";" [step] ")" body: the step is the continuing
            // block, so that `continue` runs it (GLSL 4.60 §6.3).
            StatementKind::For(parts) => self.scoped(|this| {
                this.lower(&parts.init)?;
                let step = |this: &mut Self| match &parts.step {
                    Some(step) => this.effect(step),
                    None => Ok(()),
                };
                this.looped(parts.condition.as_ref(), &parts.body, step, statement)
            }),
            StatementKind::While(condition, body) => {
                self.scoped(|this| this.looped(Some(condition), body, |_| Ok(()), statement))
            }
            // do = "do" body "while" "(" condition ")": the condition is in the continuing block,
            // where naga tests it.
            StatementKind::DoWhile(body, condition) => {
                let (body, ()) = self.nested(|this| this.scoped(|this| this.lower(body)))?;
                let (continuing, stop) = self.nested(|this| {
                    let goes_on = this.boolean(condition)?;
                    Ok(this.not(goes_on.expr))
                })?;
                self.span = statement.span;
                self.statement(S::Loop { body, continuing, break_if: Some(stop) });
                Ok(())
            }
            StatementKind::Switch(selector, statements) => {
                self.switch(selector, statements, statement)
            }
            StatementKind::Break => self.jump(S::Break),
            StatementKind::Continue => self.jump(S::Continue),
            StatementKind::Discard => self.jump(S::Kill),
            StatementKind::Return(value) => {
                let value = match value {
                    None => None,
                    Some(e) => {
                        let value = self.value(e)?;
                        let returns = self.returns.clone();
                        self.span = e.span;
                        if returns == Ty::Void {
                            return self.refuse("a `void` function returns a value");
                        }
                        Some(self.coerce(&value, &returns)?.expr)
                    }
                };
                self.span = statement.span;
                self.jump(S::Return { value })
            }
        }
    }

    fn jump(&mut self, statement: S) -> Lowering<()> {
        self.statement(statement);
        Ok(())
    }

    /// Lowers a branch, and returns whether it ends in a jump.
    fn branch(&mut self, statement: Option<&Statement<'a>>) -> Lowering<(naga::Block, bool)> {
        let Some(statement) = statement else { return Ok((naga::Block::new(), false)) };
        self.nested(|this| {
            this.scoped(|this| this.lower(statement))?;
            Ok(this.dead)
        })
    }

    fn condition(&mut self, condition: &Condition<'a>) -> Lowering<TypedValue> {
        match condition {
            Condition::Expression(e) => self.boolean(e),
            // `while (bool b = f())`.
            Condition::Declaration(declaration) => {
                self.declaration(declaration)?;
                let name = declaration.names[0].name;
                self.span = name.span;
                let value = self.named(name.text)?;
                let value = self.value_of_operand(value)?;
                self.coerce(&value, &Ty::BOOL)
            }
        }
    }

    pub fn boolean(&mut self, e: &Expr<'a>) -> Lowering<TypedValue> {
        let value = self.value(e)?;
        self.span = e.span;
        self.coerce(&value, &Ty::BOOL)
    }

    fn looped(
        &mut self,
        condition: Option<&Condition<'a>>,
        body: &Statement<'a>,
        step: impl FnOnce(&mut Self) -> Lowering<()>,
        whole: &Statement<'a>,
    ) -> Lowering<()> {
        let (body, ()) = self.nested(|this| {
            let always = match condition {
                // `for (;;)` and `while (true)` have no test.
                None => true,
                Some(Condition::Expression(e)) => this.constant(e) == Some(Const::Bool(true)),
                Some(Condition::Declaration(_)) => false,
            };
            // The test is made at the beginning of the body: `if (condition) {} else break;`.
            if let (false, Some(condition)) = (always, condition) {
                let goes_on = this.condition(condition)?;
                let (stop, ()) = this.nested(|this| this.jump(S::Break))?;
                this.statement(S::If {
                    condition: goes_on.expr,
                    accept: naga::Block::new(),
                    reject: stop,
                });
            }
            this.scoped(|this| this.lower(body))
        })?;
        let (continuing, ()) = self.nested(step)?;
        self.span = whole.span;
        self.statement(S::Loop { body, continuing, break_if: None });
        Ok(())
    }

    fn switch(
        &mut self,
        selector: &Expr<'a>,
        statements: &[Statement<'a>],
        whole: &Statement<'a>,
    ) -> Lowering<()> {
        let selector = self.value(selector)?;
        // The selector is an `int` or `uint` scalar (GLSL 4.60 §6.2).
        let unsigned = match selector.ty {
            Ty::INT => false,
            Ty::UINT => true,
            _ => return self.refuse(format!("`switch` does not take a `{}`", selector.ty)),
        };
        let groups = match groups(statements) {
            Ok(groups) => groups,
            Err(first) => {
                self.span = first;
                return self.refuse("statement before the first `case`");
            }
        };
        let mut cases: Vec<SwitchCase> = Vec::new();
        let mut has_default = false;
        let mut repeated = 0;
        self.scoped(|this| {
            // Each group is some labels and the statements to the next label.
            for (index, (labels, _)) in groups.iter().enumerate() {
                for label in *labels {
                    let value = this.label(label, unsigned)?;
                    has_default |= value == SwitchValue::Default;
                    cases.push(SwitchCase { value, body: naga::Block::new(), fall_through: true });
                }
                // naga 30.0.1 writes wrong SPIR-V where a case that does something goes on with
                // the next one: what it goes on with is written out again.
                let (body, ()) = this.nested(|this| {
                    for (later, (_, inside)) in groups[index..].iter().enumerate() {
                        repeated += if later > 0 { inside.len() } else { 0 };
                        if repeated > MAX_REPEATED {
                            return this.refuse("too many cases fall through to the next one");
                        }
                        this.statements(inside)?;
                        if this.dead {
                            break;
                        }
                    }
                    Ok(())
                })?;
                let last = cases.last_mut().expect("a group has a label");
                (last.body, last.fall_through) = (body, false);
            }
            Ok(())
        })?;
        // naga requires a default case.
        if !has_default {
            let value = SwitchValue::Default;
            cases.push(SwitchCase { value, body: naga::Block::new(), fall_through: false });
        }
        self.span = whole.span;
        self.statement(S::Switch { selector: selector.expr, cases });
        Ok(())
    }

    fn label(&mut self, label: &Statement<'a>, unsigned: bool) -> Lowering<SwitchValue> {
        let StatementKind::Case(e) = &label.kind else { return Ok(SwitchValue::Default) };
        let value = self.constant(e).and_then(|c| c.integer());
        let Some(value) = value else {
            self.span = e.span;
            return self.refuse("expected a constant integer");
        };
        Ok(if unsigned { SwitchValue::U32(value as u32) } else { SwitchValue::I32(value as i32) })
    }

    pub fn declaration(&mut self, declaration: &Declaration<'a>) -> Lowering<()> {
        let base = match &declaration.ty.base {
            TypeBase::Name(name) => self.named_type(name, declaration.ty.span)?,
            // A structure declared in a function is known by its name in its scope.
            TypeBase::Struct(structure) => {
                let ty = self.cx.make_structure(structure)?;
                if !structure.name.text.is_empty() {
                    self.declare(structure.name.text, Symbol::Structure(ty.clone()));
                }
                ty
            }
        };
        let own = self.dims(&declaration.ty.dims)?;
        // A local constant whose value is known serves in constant expressions.
        let constant = declaration.qualifiers.storage == Storage::Const;
        for declarator in &declaration.names {
            self.span = declarator.name.span;
            let name = self.dims(&declarator.dims)?;
            let mut ty = Lowerer::arrayed(base.clone(), &own, &name);
            if let Some(init) = &declarator.init {
                let scope: &Self = self;
                ty = sized_by(ty, init, &|e| scope.constant(e));
            }
            self.local_variable(declarator, ty, constant)?;
        }
        Ok(())
    }

    fn local_variable(
        &mut self,
        declarator: &Declarator<'a>,
        ty: Ty,
        constant: bool,
    ) -> Lowering<()> {
        let name = declarator.name.text;
        let Some(init) = &declarator.init else {
            let local = self.local(name, &ty)?;
            let place = self.local_place(local, &ty);
            self.declare(name, Symbol::Lvalue(place));
            return Ok(());
        };
        let known = match constant {
            true => self.constant(init).and_then(|value| Lowerer::typed(value, &ty)),
            false => None,
        };
        // An exact value becomes a literal; others are computed as written.
        let whole = known.clone().and_then(|value| Lowerer::exact_constant(value, init, &ty));
        let value = match whole.as_ref().and_then(|whole| self.value_of(whole)) {
            Some(value) => value,
            None => self.initial(init, &ty)?,
        };
        let symbol = match (constant, known) {
            (true, Some(known)) => Symbol::Const(value, known),
            (true, None) => Symbol::Value(value),
            (false, _) => {
                self.span = declarator.name.span;
                let local = self.local(name, &value.ty)?;
                let place = self.local_place(local, &value.ty);
                let pointer = self.local_pointer(local);
                self.span = declarator.name.span.to(init.span);
                self.statement(S::Store { pointer, value: value.expr });
                Symbol::Lvalue(place)
            }
        };
        self.declare(name, symbol);
        Ok(())
    }

    pub fn dims(&self, dims: &[Dim<'a>]) -> Lowering<Vec<Option<u32>>> {
        self.cx.dims(dims, &|e| self.constant(e))
    }

    pub fn named_type(&self, name: &str, span: landfall_layout::Span) -> Lowering<Ty> {
        match self.symbol(name) {
            Some(Symbol::Structure(ty)) => Ok(ty.clone()),
            _ => self.cx.named_type(name, span),
        }
    }

    pub fn constant(&self, e: &Expr<'_>) -> Option<Const> {
        super::constant::evaluate(e, &|name| match self.symbol(name) {
            Some(Symbol::Const(_, value)) => Some(value.clone()),
            Some(_) => None,
            None => self.cx.constant_named(name),
        })
    }
}

/// The labels of a case, and the statements after them.
type Group<'s, 'a> = (&'s [Statement<'a>], &'s [Statement<'a>]);

/// Returns the cases of a `switch`, or the span of a statement before the first label.
fn groups<'s, 'a>(
    mut rest: &'s [Statement<'a>],
) -> Result<Vec<Group<'s, 'a>>, landfall_layout::Span> {
    let mut groups = Vec::new();
    while let Some(first) = rest.first() {
        let (labels, after) = rest.split_at(rest.iter().take_while(|s| is_label(s)).count());
        if labels.is_empty() {
            return Err(first.span);
        }
        let (inside, after) = after.split_at(after.iter().take_while(|s| !is_label(s)).count());
        groups.push((labels, inside));
        rest = after;
    }
    Ok(groups)
}

fn is_label(statement: &Statement<'_>) -> bool {
    matches!(statement.kind, StatementKind::Case(_) | StatementKind::Default)
}
