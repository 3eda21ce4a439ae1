//! Lowers calls of the shader's functions, with copies in and out, and of built-in functions.

use landfall_layout::diagnostic::Code;
use landfall_layout::text::edit_distance::suggestion;
use naga::{Expression, Handle, Statement};

use super::ast::*;
use super::body::{Body, Symbol, TypedValue};
use super::expression::ExpressionOperand;
use super::globals::Global;
use super::lvalue::{HandlePath, Lvalue};
use super::name_usage::is_simple;
use super::opaque::{HandleChoice, HandlePair, handles_by_path};
use super::types::{Kind, Opaque, Ty, holds_values};
use super::{Help, Lowering, refuse};
use crate::module::Direction;

/// The built-in functions that write to their arguments.
pub const OUTPUTS: &[&str] =
    &["modf", "frexp", "uaddCarry", "usubBorrow", "umulExtended", "imulExtended"];

enum EvaluatedArgument {
    Value(TypedValue),
    /// An `out` or `inout` argument: the pointer passed, the variable it points to, and the place
    /// that receives the result.
    Back(Handle<Expression>, Lvalue, Lvalue),
    /// A handle, or a value that contains handles: its other values, and its path.
    Handles(Option<TypedValue>, HandleChoice, Ty),
}

impl<'a> Body<'_, 'a> {
    /// Lowers a call whose value is not needed.
    pub fn call_for_effect(&mut self, e: &Expr<'a>) -> Lowering<()> {
        self.deeper(|this| this.call_of(e, true).map(|_| ()))
    }

    pub fn call(&mut self, e: &Expr<'a>) -> Lowering<ExpressionOperand> {
        self.call_of(e, false)
    }

    // In the order in which GLSL resolves a call: constructor of a type, of a structure, of a
    // combined sampler, function of the shader, built-in function.
    fn call_of(&mut self, e: &Expr<'a>, for_effect: bool) -> Lowering<ExpressionOperand> {
        let (name, arguments) = match &e.kind {
            ExprKind::Construct(spec, arguments) => match spec.base {
                TypeBase::Name(text) if is_handle(text) => {
                    (Name { text, span: e.span, at: spec.at }, arguments)
                }
                _ => return self.construct(spec, arguments, e).map(ExpressionOperand::Value),
            },
            ExprKind::Call(name, arguments) => (*name, arguments),
            _ => return self.refuse("expected a function call"),
        };
        // A local variable hides a structure of the same name.
        let structure = match self.symbol(name.text) {
            Some(Symbol::Structure(ty)) => Some(ty.clone()),
            Some(_) => None,
            None => self.cx.global_structure(name.text).cloned(),
        };
        if let Some(Ty::Struct(s)) = structure {
            return self.construct_structure(&s, arguments, e).map(ExpressionOperand::Value);
        }
        if name.text.starts_with("sampler")
            || name.text.starts_with("isampler")
            || name.text.starts_with("usampler")
        {
            if let [texture, sampler] = &arguments[..] {
                return self.pair(name, texture, sampler).map(ExpressionOperand::Handle);
            }
        }
        // A function of the shader hides built-in ones of its name (GLSL 4.60 §6.1), if its
        // parameters fit.
        if self.cx.function_names.contains_key(name.text) {
            if let Some(value) = self.own_call(name, arguments, e)? {
                return Ok(ExpressionOperand::Value(value));
            }
        }
        if let Some(value) = self.builtin_call(name.text, arguments, e, for_effect)? {
            return Ok(ExpressionOperand::Value(value));
        }
        self.span = name.span;
        if let Some(&index) = self.cx.global_names.get(name.text) {
            if let Global::Refused(why) = &self.cx.globals[index] {
                return Err(why.clone());
            }
        }
        let mut why = refuse(name.span, format!("there is no function `{}`", name.text));
        why.code = Code::UnknownName;
        let known = self.cx.function_names.keys().copied();
        why.help = suggestion(name.text, known);
        Err(why)
    }

    fn builtin_call(
        &mut self,
        name: &str,
        arguments: &[Expr<'a>],
        e: &Expr<'a>,
        for_effect: bool,
    ) -> Lowering<Option<TypedValue>> {
        // `nonuniformEXT(i)` has the value of `i`.
        if let ("nonuniformEXT", [inner]) = (name, arguments) {
            return self.value(inner).map(Some);
        }
        // Output for a debugger has no effect on the result.
        if name == "debugPrintfEXT" {
            return Ok(Some(TypedValue { expr: self.u32(0), ty: Ty::Void }));
        }
        if let Some(value) = self.texture_call(name, arguments, e)? {
            return Ok(Some(value));
        }
        if let Some(value) = self.memory_call(name, arguments, e, for_effect)? {
            return Ok(Some(value));
        }
        // These read places, not values, so their arguments are not evaluated here.
        if OUTPUTS.contains(&name) {
            return self.output_call(name, arguments, e).map(Some);
        }
        if !super::math::is_known(name) {
            return Ok(None);
        }
        let values = self.values(arguments)?;
        self.span = e.span;
        match self.math_call(name, &values)? {
            Some(value) => Ok(Some(value)),
            None => {
                let types: Vec<String> = values.iter().map(|v| format!("`{}`", v.ty)).collect();
                self.refuse(format!("`{name}` does not take {}", types.join(", ")))
            }
        }
    }

    /// `sampler2D(texture, sampler)`
    fn pair(
        &mut self,
        name: Name<'a>,
        texture: &Expr<'a>,
        sampler: &Expr<'a>,
    ) -> Lowering<HandleChoice> {
        let (texture, sampler) = (self.chosen(texture)?, self.chosen(sampler)?);
        self.span = name.span;
        let Some(Ty::Opaque(opaque)) = super::value_types::builtin(name.text) else {
            return self.refuse(format!("`{}` is not a sampler", name.text));
        };
        // A comparison needs a texture of naga's class Depth, which Vulkan's `texture2D` is not.
        if let Opaque::Combined(image) = &opaque {
            if image.depth {
                return self
                    .refuse(
                        "naga does not support combining a texture and a sampler for a comparison",
                    )
                    .map_err(|why: Box<landfall_layout::Diagnostic>| {
                        why.help(format!("declare one `uniform {} …`", name.text))
                    });
            }
        }
        Ok(HandleChoice::Joined(opaque, Box::new([texture, sampler])))
    }

    /// Returns the handle that an expression refers to.
    pub fn chosen(&mut self, e: &Expr<'a>) -> Lowering<HandleChoice> {
        let operand = self.operand(e)?;
        self.span = e.span;
        match operand {
            ExpressionOperand::Handle(chosen) => Ok(chosen),
            ExpressionOperand::Lvalue(Lvalue {
                path: Some(way), ty: ty @ Ty::Opaque(_), ..
            }) => Ok(HandleChoice::At(way, ty)),
            _ => self.refuse("expected a sampler, texture or image"),
        }
    }

    /// Lowers a call of a shader's function; `None` if there is none of that name.
    fn own_call(
        &mut self,
        name: Name<'a>,
        arguments: &[Expr<'a>],
        e: &Expr<'a>,
    ) -> Lowering<Option<TypedValue>> {
        let overloads = self.cx.function_names.get(name.text).cloned().unwrap_or_default();
        let fitting: Vec<usize> = overloads
            .iter()
            .copied()
            .filter(|&i| self.cx.functions[i].parameters.len() == arguments.len())
            .collect();
        if fitting.is_empty() {
            if super::math::is_known(name.text) || super::texture::is_known(name.text) {
                return Ok(None);
            }
            let count = arguments.len();
            return self.refuse(format!("no `{}` takes {count} arguments", name.text));
        }
        let mut operands = Vec::new();
        let mut types = Vec::new();
        // A later argument may change what an earlier one names: `f(a, a++)` passes the old `a`
        // (GLSL 4.60 §6.1.1).
        let last_effect = arguments.iter().rposition(|argument| !is_simple(argument));
        for (index, argument) in arguments.iter().enumerate() {
            let operand = self.operand(argument)?;
            types.push(match &operand {
                ExpressionOperand::Value(value) => value.ty.clone(),
                ExpressionOperand::Lvalue(place) => place.ty.clone(),
                ExpressionOperand::Handle(HandleChoice::At(_, ty)) => ty.clone(),
                ExpressionOperand::Handle(HandleChoice::Joined(opaque, _)) => {
                    Ty::Opaque(opaque.clone())
                }
                ExpressionOperand::Blocks(..) => Ty::Void,
            });
            operands.push(match operand {
                ExpressionOperand::Lvalue(place)
                    if last_effect.is_some_and(|last| index < last)
                        && !place.ty.has_opaque()
                        && self.always_in(&fitting, index) =>
                {
                    ExpressionOperand::Value(self.load(&place)?)
                }
                other => other,
            });
        }
        self.span = e.span;
        let Some(index) = self.best(&fitting, &types) else {
            if super::math::is_known(name.text) || super::texture::is_known(name.text) {
                return Ok(None);
            }
            let types: Vec<String> = types.iter().map(|ty| format!("`{ty}`")).collect();
            let message = format!("no `{}` takes {}", name.text, types.join(", "));
            return self.refuse(message);
        };
        let function = self.cx.function(index, name.span)?;
        let parameters = self.cx.functions[index].parameters.clone();
        let returns = self.cx.functions[index].returns.clone();
        let mut ready = Vec::new();
        for ((operand, parameter), argument) in operands.into_iter().zip(&parameters).zip(arguments)
        {
            self.span = argument.span;
            ready.push(self.argument_of(operand, &parameter.ty, parameter.direction)?);
        }
        self.span = e.span;
        self.emit_call(function, ready, &returns).map(Some)
    }

    // Whether the argument is `in` in every overload that may be chosen: `out` needs the place
    // itself.
    fn always_in(&self, fitting: &[usize], parameter: usize) -> bool {
        fitting.iter().all(|&i| {
            self.cx.functions[i]
                .parameters
                .get(parameter)
                .is_none_or(|p| p.direction == Direction::In)
        })
    }

    /// Returns the overload that matches exactly, or with the fewest conversions.
    fn best(&self, fitting: &[usize], types: &[Ty]) -> Option<usize> {
        // An exact match costs 0. The sum over all parameters decides, a simplification of the
        // pairwise rule of GLSL 4.60 §6.1.
        let cost = |index: usize| {
            let parameters = &self.cx.functions[index].parameters;
            parameters.iter().zip(types).try_fold(0u32, |sum, (parameter, ty)| {
                let fits = match parameter.direction {
                    Direction::In => ty.converts_to(&parameter.ty),
                    // An `out` argument is converted on the way back.
                    Direction::Out => parameter.ty.converts_to(ty),
                    Direction::InOut => *ty == parameter.ty,
                };
                let exact = *ty == parameter.ty;
                // Float to double is worse than int to float (GLSL 4.60 §6.1).
                let wide = parameter.ty.kind() == Some(Kind::Double);
                fits.then_some(
                    sum + if exact {
                        0
                    } else if wide {
                        3
                    } else {
                        2
                    },
                )
            })
        };
        let costs = fitting.iter().filter_map(|&index| Some((cost(index)?, index)));
        costs.min_by_key(|(cost, _)| *cost).map(|(_, index)| index)
    }

    fn argument_of(
        &mut self,
        operand: ExpressionOperand,
        ty: &Ty,
        direction: Direction,
    ) -> Lowering<EvaluatedArgument> {
        if ty.has_opaque() {
            return match operand {
                ExpressionOperand::Handle(chosen) => {
                    Ok(EvaluatedArgument::Handles(None, chosen, ty.clone()))
                }
                ExpressionOperand::Lvalue(place) => {
                    let Some(way) = place.path.clone() else {
                        return self.refuse(
                            "a sampler or image has two variable indices: use a constant for one",
                        );
                    };
                    let rest = if holds_values(ty) { Some(self.load_rest(&place)?) } else { None };
                    Ok(EvaluatedArgument::Handles(
                        rest,
                        HandleChoice::At(way, ty.clone()),
                        ty.clone(),
                    ))
                }
                ExpressionOperand::Value(_) | ExpressionOperand::Blocks(..) => {
                    self.refuse("expected a sampler or image")
                }
            };
        }
        // `in`: a copy, converted to the parameter's type (GLSL 4.60 §6.1.1).
        if direction == Direction::In {
            let value = self.value_of_operand(operand)?;
            return self.coerce(&value, ty).map(EvaluatedArgument::Value);
        }
        let ExpressionOperand::Lvalue(place) = operand else {
            return self.refuse("an `out` argument must be a variable");
        };
        if !place.writable {
            return self.refuse("an `out` argument must be writable");
        }
        // `out` and `inout`: a copy of the parameter's type, whose pointer is passed; the result
        // is stored back after the call.
        let local = self.local("", ty)?;
        let pointer = self.local_pointer(local);
        if direction == Direction::InOut {
            let value = self.load(&place)?;
            let value = self.coerce(&value, ty)?;
            self.statement(Statement::Store { pointer, value: value.expr });
        }
        let copy = self.local_place(local, ty);
        Ok(EvaluatedArgument::Back(pointer, copy, place))
    }

    /// Returns the values of a structure without its handles.
    fn load_rest(&mut self, place: &Lvalue) -> Lowering<TypedValue> {
        let plain = Lvalue { path: None, ..place.clone() };
        self.load(&plain)
    }

    fn emit_call(
        &mut self,
        function: Handle<naga::Function>,
        arguments: Vec<EvaluatedArgument>,
        returns: &Ty,
    ) -> Lowering<TypedValue> {
        // One handle chosen at run time becomes a `switch` over the calls with each of them.
        let chosen = arguments.iter().find_map(|argument| match argument {
            EvaluatedArgument::Handles(_, chosen, _) if is_variable(chosen) => Some(chosen.clone()),
            _ => None,
        });
        let value = match chosen {
            None => self.emit_with(function, &arguments, returns, None)?,
            Some(chosen @ (HandleChoice::At(_, Ty::Opaque(_)) | HandleChoice::Joined(..))) => {
                let several = arguments.iter().filter(|argument| {
                    matches!(argument, EvaluatedArgument::Handles(_, chosen, _) if is_variable(chosen))
                });
                if several.count() > 1 {
                    return self
                        .refuse("a call takes two samplers or images with variable indices: use a constant index for one");
                }
                self.with_handle(&chosen, returns, |this, pair| {
                    this.emit_with(function, &arguments, returns, Some(pair))
                })?
            }
            Some(_) => {
                return self.refuse(
                    "a structure with samplers or images has a variable index: use a constant one",
                );
            }
        };
        // Results are copied back in the order of the parameters.
        for argument in &arguments {
            let EvaluatedArgument::Back(_, copy, place) = argument else { continue };
            let result = self.load(copy)?;
            let result = self.coerce(&result, &place.ty)?;
            self.store(place, &result)?;
        }
        Ok(value)
    }

    fn emit_with(
        &mut self,
        function: Handle<naga::Function>,
        arguments: &[EvaluatedArgument],
        returns: &Ty,
        pair: Option<&HandlePair>,
    ) -> Lowering<TypedValue> {
        // A handle is passed as its texture and its sampler, which are two arguments for naga.
        let mut flat = Vec::new();
        for argument in arguments {
            match argument {
                EvaluatedArgument::Value(value) => flat.push(value.expr),
                EvaluatedArgument::Back(pointer, ..) => flat.push(*pointer),
                EvaluatedArgument::Handles(rest, chosen, ty) => {
                    flat.extend(rest.as_ref().map(|rest| rest.expr));
                    let pairs: Vec<HandlePair> = match (chosen, pair) {
                        (
                            HandleChoice::Joined(..)
                            | HandleChoice::At(HandlePath { dynamic: Some(_), .. }, _),
                            Some(pair),
                        ) => vec![pair.clone()],
                        (HandleChoice::Joined(..), None) => {
                            return self
                                .refuse("a sampler or image is selected in two ways at once");
                        }
                        (HandleChoice::At(way, _), _) => {
                            let all = handles_by_path(ty).into_iter();
                            all.map(|(rest, _)| self.handle(&format!("{}{rest}", way.text)))
                                .collect::<Lowering<_>>()?
                        }
                    };
                    for pair in pairs {
                        let (image, sampler) = (pair.image, pair.sampler);
                        if image.is_some() {
                            flat.push(self.source(image)?);
                        }
                        if sampler.is_some() {
                            flat.push(self.source(sampler)?);
                        }
                    }
                }
            }
        }
        let result =
            (*returns != Ty::Void).then(|| self.add_result(Expression::CallResult(function)));
        self.statement(Statement::Call { function, arguments: flat, result });
        match result {
            Some(expr) => Ok(TypedValue { expr, ty: returns.clone() }),
            // `void`: no expression can use the value.
            None => Ok(TypedValue { expr: self.u32(0), ty: Ty::Void }),
        }
    }
}

/// Returns whether a handle is selected at run time, or combined from a texture and a sampler.
fn is_variable(chosen: &HandleChoice) -> bool {
    match chosen {
        HandleChoice::At(way, _) => way.dynamic.is_some(),
        HandleChoice::Joined(..) => true,
    }
}

/// Returns whether the name of a constructor is that of a handle type; some legacy functions share
/// these names.
fn is_handle(name: &str) -> bool {
    matches!(super::value_types::builtin(name), Some(Ty::Opaque(_)))
}
