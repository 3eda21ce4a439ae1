//! Lowers functions: all signatures, and bodies on demand.

use landfall_layout::diagnostic::Code;
use std::rc::Rc;

use naga::{Expression, FunctionArgument, FunctionResult, Handle, Statement, TypeInner};

use super::ast::*;
use super::body::{Body, Symbol, TypedValue};
use super::globals::Global;
use super::lvalue::{Lvalue, LvalueMemory};
use super::name_usage::written_names;
use super::opaque::{HandlePair, Source, handles_by_path, image_type};
use super::types::{Opaque, Ty, holds_values};
use super::{Lowerer, Lowering, refuse};
use crate::module::{Direction, FunctionInfo, Parameter as PublicParameter, SkippedFunction};
use landfall_layout::diagnostic::Diagnostic;
use landfall_layout::source::Span;

/// The deepest nesting of functions, statements and expressions together.
/// Well below what a thread's stack holds.
const DEEPEST: u32 = 1500;

/// The most expressions of a shader, which bounds the memory for hostile texts.
const MAX_EXPRESSIONS: usize = 1 << 22;

#[derive(Debug)]
pub struct Entry<'a> {
    pub declaration: Rc<FunctionDecl<'a>>,
    pub parameters: Vec<Param<'a>>,
    pub returns: Ty,
    state: GlobalState,
}

#[derive(Clone, Debug)]
pub struct Param<'a> {
    pub name: &'a str,
    pub ty: Ty,
    pub direction: Direction,
    pub span: Span,
}

#[derive(Clone, Debug)]
enum GlobalState {
    Untouched,
    Running,
    Done(Handle<naga::Function>),
    Failed(Box<Diagnostic>),
}

impl<'a> Lowerer<'a> {
    // All signatures are declared before any body is lowered: a call may precede its definition
    // only by a prototype, but overloads are chosen among all.
    pub fn declare_function(&mut self, function: &Rc<FunctionDecl<'a>>) -> Lowering<()> {
        let name = function.name;
        let mut parameters = Vec::new();
        for parameter in &function.parameters {
            let ty = match self.parameter_type(&parameter.ty, &parameter.dims) {
                Ok(ty) => ty,
                Err(why) => return self.unusable(name, why),
            };
            let direction = match parameter.qualifiers.storage {
                Storage::Out => Direction::Out,
                Storage::InOut => Direction::InOut,
                _ => Direction::In,
            };
            parameters.push(Param {
                name: parameter.name.text,
                ty,
                direction,
                span: parameter.name.span,
            });
        }
        let returns = match self.parameter_type(&function.returns, &[]) {
            Ok(ty) => ty,
            Err(why) => return self.unusable(name, why),
        };
        let known = self.function_names.entry(name.text).or_default();
        // A prototype and its definition are one entry; a second body is an error (GLSL 4.60
        // §6.1).
        for &index in known.iter() {
            let same = |a: &Param<'_>, b: &Param<'_>| a.ty == b.ty;
            let before = &mut self.functions[index];
            let fits = before.parameters.len() == parameters.len()
                && before.parameters.iter().zip(&parameters).all(|(a, b)| same(a, b));
            if !fits {
                continue;
            }
            if function.body.is_some() {
                if before.declaration.body.is_some() {
                    let message = format!("function `{}` is defined twice", name.text);
                    let diagnostic = Diagnostic::error(Code::DuplicateName, name.span, message);
                    let before = before.declaration.name.span;
                    return Err(Box::new(diagnostic.with_label(before, "first definition")));
                }
                before.declaration = function.clone();
                // The definition's parameter names count.
                before.parameters = parameters;
            }
            return Ok(());
        }
        known.push(self.functions.len());
        self.functions.push(Entry {
            declaration: function.clone(),
            parameters,
            returns,
            state: GlobalState::Untouched,
        });
        Ok(())
    }

    /// A function with unsupported types is an error where it is called.
    fn unusable(&mut self, name: Name<'a>, why: Box<Diagnostic>) -> Lowering<()> {
        self.left_out
            .push(SkippedFunction { function: name.text.to_string(), why: (*why).clone() });
        self.declare_global(name.text, Global::Refused(why));
        Ok(())
    }

    fn parameter_type(&mut self, spec: &TypeSpec<'a>, dims: &[Dim<'a>]) -> Lowering<Ty> {
        let TypeBase::Name(base) = &spec.base else {
            return Err(refuse(spec.span, "structures cannot be declared in parameters"));
        };
        let base = self.named_type(base, spec.span)?;
        let own = self.dims(&spec.dims, &|e| self.constant(e))?;
        let name = self.dims(dims, &|e| self.constant(e))?;
        Ok(Self::arrayed(base, &own, &name))
    }

    pub fn lower_functions(&mut self) -> Result<Vec<FunctionInfo>, Vec<Diagnostic>> {
        // A function that cannot be lowered does not stop the others: it is left out, and an error
        // only for `main` or its callers.
        let mut failed: Vec<SkippedFunction> = Vec::new();
        for index in 0..self.functions.len() {
            if self.functions[index].declaration.body.is_none() {
                continue;
            }
            let name = self.functions[index].declaration.name;
            if let Err(why) = self.function(index, name.span) {
                failed.push(SkippedFunction { function: name.text.to_string(), why: *why });
            }
        }
        let main = self.function_names.get("main").and_then(|all| all.first().copied());
        // Something must be left to run.
        let runs = match main {
            Some(main) => matches!(self.functions[main].state, GlobalState::Done(_)),
            None => self.functions.iter().any(|f| matches!(f.state, GlobalState::Done(_))),
        };
        if !runs && !failed.is_empty() {
            let mut all: Vec<Diagnostic> = Vec::new();
            for SkippedFunction { why, .. } in failed {
                if !all.contains(&why) {
                    all.push(why);
                }
            }
            return Err(all);
        }
        self.left_out.append(&mut failed);
        Ok(self.functions.iter().filter_map(describe).collect())
    }

    pub fn main_function(&self) -> Option<Handle<naga::Function>> {
        let main = *self.function_names.get("main")?.first()?;
        match self.functions[main].state {
            GlobalState::Done(handle) => Some(handle),
            GlobalState::Untouched | GlobalState::Running | GlobalState::Failed(_) => None,
        }
    }

    /// Returns the function of that index, lowering it first if necessary; `span` is the call.
    pub fn function(&mut self, index: usize, span: Span) -> Lowering<Handle<naga::Function>> {
        // On demand: a callee before its caller, as naga requires functions in that order.
        let entry = &mut self.functions[index];
        let name = entry.declaration.name.text;
        match &entry.state {
            GlobalState::Done(handle) => return Ok(*handle),
            GlobalState::Failed(why) => return Err(why.clone()),
            GlobalState::Running => {
                let message = format!("`{name}` calls itself");
                let diagnostic = Diagnostic::error(Code::Recursion, span, message);
                return Err(Box::new(
                    diagnostic.with_note("GLSL does not allow recursion (4.60 §6.1)"),
                ));
            }
            GlobalState::Untouched if entry.declaration.body.is_none() => {
                let message = format!("`{name}` is declared but not defined");
                return Err(Box::new(Diagnostic::error(Code::UndefinedFunction, span, message)));
            }
            // A function that is met again while `Running` calls itself.
            GlobalState::Untouched => entry.state = GlobalState::Running,
        }
        let (declaration, parameters, returns) =
            (entry.declaration.clone(), entry.parameters.clone(), entry.returns.clone());
        let result = self.deeper(span, |this| this.body_of(&declaration, &parameters, returns));
        let entry = &mut self.functions[index];
        match result {
            Ok(handle) => {
                entry.state = GlobalState::Done(handle);
                Ok(handle)
            }
            Err(why) => {
                entry.state = GlobalState::Failed(why.clone());
                Err(why)
            }
        }
    }

    fn deeper<T>(&mut self, span: Span, run: impl FnOnce(&mut Self) -> Lowering<T>) -> Lowering<T> {
        self.nesting += 1;
        let result = if self.nesting > DEEPEST {
            Err(refuse(span, "functions, statements or expressions are nested too deeply"))
        } else {
            run(self)
        };
        self.nesting -= 1;
        result
    }

    fn body_of(
        &mut self,
        declaration: &FunctionDecl<'a>,
        parameters: &[Param<'a>],
        returns: Ty,
    ) -> Lowering<Handle<naga::Function>> {
        let statements = declaration.body.as_deref().unwrap_or_default();
        // Parameters that are never written need no variable.
        let changed = written_names(statements, &|name| self.writes_arguments(name));
        let span = declaration.name.span;
        let mut body = Body::new(self, returns.clone(), span);
        for (index, parameter) in parameters.iter().enumerate() {
            body.parameter(parameter, index, changed.contains(parameter.name))?;
        }
        if returns != Ty::Void {
            let ty = body.cx.value_type(&returns, span)?;
            body.function.result = Some(FunctionResult { ty, binding: None });
        }
        // The body has a scope of its own, in which a parameter's name may not be declared again.
        body.scoped(|body| body.statements(statements))?;
        body.span = span;
        if !body.dead {
            let value = match &returns {
                Ty::Void => None,
                // A function that ends without `return` has no defined value (4.60 §6.4.2).
                other => Some(body.zero(other)?.expr),
            };
            body.statement(Statement::Return { value });
        }
        let mut function = body.finish();
        self.expressions += function.expressions.len();
        function.name = Some(declaration.name.text.to_string());
        Ok(self.ir.functions.append(function, self.bases.to_naga(span)))
    }

    /// Returns whether a function of that name may write to its arguments.
    fn writes_arguments(&self, name: &str) -> bool {
        if super::call::OUTPUTS.contains(&name) {
            return true;
        }
        let Some(overloads) = self.function_names.get(name) else { return false };
        let mut parameters = overloads.iter().flat_map(|&i| &self.functions[i].parameters);
        parameters.any(|p| p.direction != Direction::In)
    }
}

fn describe(entry: &Entry<'_>) -> Option<FunctionInfo> {
    let GlobalState::Done(handle) = entry.state else { return None };
    let parameters = entry.parameters.iter().map(|parameter| PublicParameter {
        name: parameter.name.to_string(),
        ty: parameter.ty.to_string(),
        direction: parameter.direction,
    });
    Some(FunctionInfo {
        name: entry.declaration.name.text.to_string(),
        parameters: parameters.collect(),
        returns: (entry.returns != Ty::Void).then(|| entry.returns.to_string()),
        span: entry.declaration.name.span,
        handle,
    })
}

impl<'a> Body<'_, 'a> {
    /// Limits the recursion over the syntax tree.
    pub fn deeper<T>(&mut self, run: impl FnOnce(&mut Self) -> Lowering<T>) -> Lowering<T> {
        if self.cx.expressions + self.function.expressions.len() > MAX_EXPRESSIONS {
            return self.refuse("the shader has too many operations");
        }
        self.cx.nesting += 1;
        let result = if self.cx.nesting > DEEPEST {
            self.refuse("functions, statements or expressions are nested too deeply")
        } else {
            run(self)
        };
        self.cx.nesting -= 1;
        result
    }

    fn argument(&mut self, name: &str, ty: Handle<naga::Type>) -> (u32, Handle<Expression>) {
        let index = self.function.arguments.len() as u32;
        let name = (!name.is_empty()).then(|| name.to_string());
        self.function.arguments.push(FunctionArgument { name, ty, binding: None });
        (index, self.add(Expression::FunctionArgument(index)))
    }

    fn parameter(&mut self, parameter: &Param<'a>, index: usize, changed: bool) -> Lowering<()> {
        let Param { name, ty, direction, span } = parameter;
        // `out` and `inout` are pointers to copies of the caller.
        if *direction != Direction::In {
            if ty.has_opaque() {
                return self
                    .refuse(format!("`{name}` is a sampler or image, which is not writable"));
            }
            let base = self.cx.value_type(ty, self.span)?;
            let inner = TypeInner::Pointer { base, space: naga::AddressSpace::Function };
            let pointer = self.cx.nameless(inner);
            let (_, expr) = self.argument(name, pointer);
            self.declare(name, Symbol::Lvalue(Lvalue::new(LvalueMemory::Own(expr), ty.clone())));
            return Ok(());
        }
        let mut symbol = None;
        if holds_values(ty) {
            let value_type = self.cx.value_type(ty, self.span)?;
            let outer = std::mem::replace(&mut self.span, *span);
            let (_, expr) = self.argument(name, value_type);
            self.span = outer;
            let value = TypedValue { expr, ty: ty.clone() };
            // A value unless the body writes to it: naga's arguments cannot be stored to.
            symbol = Some(if changed {
                let local = self.local(name, ty)?;
                let pointer = self.local_pointer(local);
                self.statement(Statement::Store { pointer, value: expr });
                Symbol::Lvalue(Lvalue::new(LvalueMemory::Own(pointer), ty.clone()))
            } else {
                Symbol::Value(value)
            });
        }
        if !ty.has_opaque() {
            if let Some(symbol) = symbol {
                self.declare(name, symbol);
            }
            return Ok(());
        }
        // Handles in a parameter, also those in structures and arrays, are separate arguments;
        // `#0.diffuse` is the path of one in parameter 0.
        let root = format!("#{index}");
        for (way, opaque) in handles_by_path(ty) {
            let mut pair = HandlePair { opaque: opaque.clone(), image: None, sampler: None };
            for (inner, sampler) in handle_types(self, &opaque)? {
                let handle = self.cx.nameless(inner);
                let label = if sampler { format!("{name}_sampler") } else { name.to_string() };
                let (index, _) = self.argument(&label, handle);
                let slot = if sampler { &mut pair.sampler } else { &mut pair.image };
                *slot = Some(Source::Argument(index));
            }
            self.handles.insert(format!("{root}{way}"), pair);
        }
        self.declare(name, Symbol::Handles(root, ty.clone(), symbol.map(Box::new)));
        Ok(())
    }

    pub fn initialise(
        &mut self,
        global: usize,
        declaration: &Declaration<'a>,
        index: usize,
    ) -> Lowering<()> {
        let Global::Variable { handle, ty, .. } = self.cx.globals[global].clone() else {
            return Ok(());
        };
        let Some(init) = &declaration.names[index].init else { return Ok(()) };
        self.span = init.span;
        let value = self.initial(init, &ty)?;
        let pointer = self.global_pointer(handle);
        self.statement(Statement::Store { pointer, value: value.expr });
        Ok(())
    }
}

/// Returns the types of the arguments that a handle is passed as; `true` for a sampler.
fn handle_types(body: &Body<'_, '_>, opaque: &Opaque) -> Lowering<Vec<(TypeInner, bool)>> {
    Ok(match opaque {
        Opaque::Combined(image) => {
            let sampler = TypeInner::Sampler { comparison: image.depth };
            vec![(image_type(image), false), (sampler, true)]
        }
        Opaque::Texture(image) => vec![(image_type(image), false)],
        Opaque::Sampler { comparison } => {
            vec![(TypeInner::Sampler { comparison: *comparison }, true)]
        }
        Opaque::Storage(_) | Opaque::Foreign(_) => {
            return body.refuse(format!("a `{opaque}` cannot be a parameter"));
        }
    })
}
