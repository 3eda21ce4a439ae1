//! Compiles one function: its arguments, variables, result, and the values of its expressions.

use std::rc::Rc;

use naga::proc::TypeResolution;
use naga::valid::{FunctionInfo, ModuleInfo};
use naga::{Arena, Expression, Handle, LocalVariable, TypeInner};

use super::super::body::{Argument, Compiled};
use super::super::code::{Class, Op, Origin, Reg};
use super::super::flatten::class;
use super::super::program::{Floats, FunctionCode};
use super::super::value::value_type;
use super::builder::Builder;
use super::value::Value;
use super::{CompiledGlobal, nowhere};
pub use landfall_ir::module::Locals;

/// The source of expressions' types.
#[derive(Clone, Copy)]
pub(super) enum ExpressionTypes<'a> {
    Function(&'a FunctionInfo),
    Module(&'a ModuleInfo),
}

/// The place of a function's result.
pub(super) enum Returned {
    /// Registers that callers read.
    In(Rc<[Reg]>),
    /// The registers of the value itself, in code that stands in place of a call.
    Inline(Rc<[Reg]>),
}

pub(super) struct Function<'f, 'a> {
    pub b: &'f mut Builder<'a>,
    pub function: &'f naga::Function,
    pub arena: &'f Arena<Expression>,
    pub resolved: ExpressionTypes<'f>,
    pub globals: &'f [CompiledGlobal],
    pub functions: &'f [FunctionCode],
    pub arguments: Vec<Argument>,
    pub locals: Vec<Rc<[Reg]>>,
    pub returned: Returned,
    /// By expression: its form, once it is compiled.
    pub values: Vec<Option<Value>>,
}

impl<'f, 'a> Function<'f, 'a> {
    /// Returns a function whose arguments callers copy.
    pub fn new(
        b: &'f mut Builder<'a>,
        function: &'f naga::Function,
        info: &'f FunctionInfo,
        globals: &'f [CompiledGlobal],
        functions: &'f [FunctionCode],
    ) -> Result<Function<'f, 'a>, String> {
        let types = &b.ir.types;
        let mut arguments = Vec::new();
        for argument in &function.arguments {
            arguments.push(compiled_argument(b, argument, None)?);
        }
        let result = match &function.result {
            Some(result) => b.variable(&types[result.ty].inner)?,
            None => Rc::from([]),
        };
        Function::with(b, function, info, (globals, functions), (arguments, Returned::In(result)))
    }

    /// Returns a function with these arguments.
    pub fn with(
        b: &'f mut Builder<'a>,
        function: &'f naga::Function,
        info: &'f FunctionInfo,
        (globals, functions): (&'f [CompiledGlobal], &'f [FunctionCode]),
        (arguments, returned): (Vec<Argument>, Returned),
    ) -> Result<Function<'f, 'a>, String> {
        let types = &b.ir.types;
        let mut locals = Vec::new();
        for (_, local) in function.local_variables.iter() {
            locals.push(b.variable(&types[local.ty].inner)?);
        }
        Ok(Function {
            b,
            function,
            arena: &function.expressions,
            resolved: ExpressionTypes::Function(info),
            globals,
            functions,
            arguments,
            locals,
            returned,
            values: vec![None; function.expressions.len()],
        })
    }

    /// Returns a function over the expressions of the module's arena.
    pub fn of_module(
        b: &'f mut Builder<'a>,
        function: &'f naga::Function,
        globals: &'f [CompiledGlobal],
    ) -> Function<'f, 'a> {
        let (ir, info) = (b.ir, b.info);
        Function {
            b,
            function,
            arena: &ir.global_expressions,
            resolved: ExpressionTypes::Module(info),
            globals,
            functions: &[],
            arguments: Vec::new(),
            locals: Vec::new(),
            returned: Returned::In(Rc::from([])),
            values: vec![None; ir.global_expressions.len()],
        }
    }

    /// Compiles the code that fills the private variables.
    pub fn globals(
        b: &'f mut Builder<'a>,
        none: &'f naga::Function,
        globals: &'f [CompiledGlobal],
    ) -> Result<Compiled, String> {
        let ir = b.ir;
        let mut this = Function::of_module(b, none, globals);
        for ((_, variable), global) in ir.global_variables.iter().zip(globals) {
            // Buffers and images have no registers to fill.
            if let CompiledGlobal::Private(regs) = global {
                let from = match variable.init {
                    Some(init) => this.regs(init)?,
                    None => this.zero(&ir.types[variable.ty].inner)?,
                };
                this.copy(Op::Move, regs, &from);
            }
        }
        this.b.push(Op::End, &[], &[]);
        Ok(Compiled { arguments: Vec::new(), result: Rc::from([]), result_type: None })
    }

    pub fn compile(mut self) -> Result<Compiled, String> {
        self.body()?;
        self.b.push(Op::End, &[], &[]);
        let ir = self.b.ir;
        let result_type = self.function.result.as_ref();
        let result_type = result_type.and_then(|r| value_type(&self.b.types, &ir.types[r.ty]));
        let (Returned::In(result) | Returned::Inline(result)) = self.returned;
        Ok(Compiled { arguments: self.arguments, result, result_type })
    }

    /// Compiles the variables and statements.
    pub fn body(&mut self) -> Result<(), String> {
        let function = self.function;
        let locals: Vec<(Handle<LocalVariable>, &LocalVariable)> =
            function.local_variables.iter().collect();
        // At each call: the registers keep what the call before left there.
        for (handle, local) in locals {
            let to = self.locals[handle.index()].clone();
            match local.init {
                Some(init) => {
                    let from = self.regs(init)?;
                    self.copy(Op::Move, &to, &from);
                }
                None => {
                    let from = self.zero(&self.b.ir.types[local.ty].inner)?;
                    // Both store zeros, as WGSL requires; reads of a `Undefined` before a store are
                    // noted, as GLSL leaves such a variable undefined.
                    let op: fn(Class) -> Op = match self.b.locals {
                        Locals::Zeros => Op::Move,
                        Locals::Anything => Op::Undefined,
                    };
                    self.copy(op, &to, &from);
                }
            }
        }
        self.block(&function.body)?;
        self.b.body.locals.extend(self.locals.iter().flat_map(|regs| regs.iter().copied()));
        Ok(())
    }

    pub fn ty(&self, handle: Handle<Expression>) -> &'f TypeInner
    where
        'a: 'f,
    {
        let types = &self.b.ir.types;
        match self.resolved {
            ExpressionTypes::Function(info) => info[handle].ty.inner_with(types),
            ExpressionTypes::Module(info) => info[handle].inner_with(types),
        }
    }

    pub fn resolution(&self, handle: Handle<Expression>) -> &'f TypeResolution {
        match self.resolved {
            ExpressionTypes::Function(info) => &info[handle].ty,
            ExpressionTypes::Module(info) => &info[handle],
        }
    }

    /// Sets the origin of the next instructions.
    pub fn at(&mut self, span: naga::Span) {
        // What has no span of its own keeps the one before.
        if let Some(range) = span.to_range() {
            let function = self.b.body.origin.unwrap_or(nowhere(0)).function;
            let origin = Origin { function, start: range.start as u32, end: range.end as u32 };
            self.b.body.origin = Some(origin);
        }
    }

    /// Returns the scalars of an expression, loaded if necessary.
    pub fn regs(&mut self, handle: Handle<Expression>) -> Result<Rc<[Reg]>, String> {
        match self.value(handle)? {
            // The operands of a rounded operation are rounded too, literals included.
            Value::Regs(regs) if self.b.rounds && self.b.floats == Floats::Mediump => {
                Ok(self.round_to_half(&regs))
            }
            Value::Regs(regs) => Ok(regs),
            Value::View(pointer) => self.load_all(&pointer),
            Value::Pointer(_) => Err("a pointer used as a value".into()),
        }
    }

    /// Returns the only scalar of an expression.
    pub fn scalar(&mut self, handle: Handle<Expression>) -> Result<Reg, String> {
        let regs = self.regs(handle)?;
        regs.first().copied().ok_or_else(|| "a value without a scalar".into())
    }

    pub fn value(&mut self, handle: Handle<Expression>) -> Result<Value, String> {
        if let Some(value) = &self.values[handle.index()] {
            return Ok(value.clone());
        }
        let value = self.expression(handle)?;
        // The default of an override may be computed in a branch that other uses do not execute.
        if !matches!(self.arena[handle], Expression::Override(_)) {
            self.values[handle.index()] = Some(value.clone());
        }
        Ok(value)
    }

    pub fn zero(&mut self, inner: &TypeInner) -> Result<Rc<[Reg]>, String> {
        let leaves = self.b.types.leaves(inner)?;
        // The bits of zero are 0 in every class.
        leaves.iter().map(|leaf| Ok(self.b.constant(class(leaf.scalar)?, 0))).collect()
    }

    /// Copies scalars, with one instruction per class.
    pub fn copy(&mut self, op: impl Fn(Class) -> Op, to: &[Reg], from: &[Reg]) {
        self.groups(op, &[], to, from);
    }

    /// Emits one instruction per class, with pairs of operands.
    pub fn groups(&mut self, op: impl Fn(Class) -> Op, head: &[Reg], a: &[Reg], b: &[Reg]) {
        for class in [Class::Real, Class::Word, Class::Wide] {
            let operands: Vec<u32> = a
                .iter()
                .zip(b)
                .filter(|(a, _)| a.class() == class)
                .flat_map(|(a, b)| [a.0, b.0])
                .collect();
            if !operands.is_empty() {
                self.b.push(op(class), head, &operands);
            }
        }
    }
}

/// Returns an argument in the given registers, or in new ones: a pointer's contents are always
/// copied.
pub(super) fn compiled_argument(
    b: &mut Builder<'_>,
    argument: &naga::FunctionArgument,
    given: Option<Rc<[Reg]>>,
) -> Result<Argument, String> {
    let types = &b.ir.types;
    let (pointer, ty) = match &types[argument.ty].inner {
        TypeInner::Pointer { base, .. } => (true, types[*base].clone()),
        TypeInner::ValuePointer { size, scalar, .. } => {
            let inner = match size {
                Some(size) => TypeInner::Vector { size: *size, scalar: *scalar },
                None => TypeInner::Scalar(*scalar),
            };
            (true, naga::Type { name: None, inner })
        }
        _ => (false, types[argument.ty].clone()),
    };
    // The function may write what a pointer points to, but not a value.
    let regs = match given.filter(|_| !pointer) {
        Some(given) => given,
        None => b.variable(&ty.inner)?,
    };
    let regs = regs.to_vec();
    let name = argument.name.clone().unwrap_or_default();
    let ty = value_type(&b.types, &ty);
    Ok(Argument { name, regs, pointer, ty })
}
