//! Compiles naga IR to the flat form.
//!
//! Reads a [`Module`](landfall_ir::Module)'s IR; emits the instructions of [`code`](super::code).
//! Separate files compile statements, expressions, operators, math functions, pointers and images.

mod builder;
mod expression;
mod function;
mod image;
mod integer;
mod math;
mod matrix;
mod operators;
mod pointer;
mod statement;
mod value;

use std::rc::Rc;

use naga::{AddressSpace, Handle, StorageAccess};

use super::code::{Origin, Reg};
use super::program::{BufferInfo, BufferSpace, Floats, FunctionCode, ImageInfo, Program};
use builder::Builder;
use function::Function;
use landfall_ir::Module;

/// A global variable of the module in the machine.
#[derive(Clone)]
enum CompiledGlobal {
    Buffer { number: u32, read_only: bool },
    Private(Rc<[Reg]>),
    Image(Reg),
    Refused(String),
}

/// Compiles every function and entry point. One that uses unsupported features fails when it is
/// run; the others are unaffected.
pub(super) fn compile(module: &Module, overrides: &[(String, f64)], floats: Floats) -> Program {
    let (ir, info) = (&module.ir, &module.info);
    let given = overrides_of(ir, overrides);
    let pending = |handle: Handle<naga::Override>| length_of(ir, &given, handle);
    let mut builder = Builder::new(ir, info, &pending, &given, floats, &module.reduced);
    builder.locals = module.locals;
    let globals = globals(&mut builder);
    let mut functions = Vec::new();
    // naga's validator accepts a function only after those it calls, so a call finds its callee
    // compiled.
    for (handle, function) in ir.functions.iter() {
        let name = function.name.clone().unwrap_or_default();
        builder.begin(functions.len() as u32);
        let compiled = Function::new(&mut builder, function, &info[handle], &globals, &functions)
            .and_then(Function::compile);
        functions.push(builder.finish(name, None, compiled));
    }
    for (number, entry) in ir.entry_points.iter().enumerate() {
        builder.begin(functions.len() as u32);
        let info = info.get_entry_point(number);
        let compiled = Function::new(&mut builder, &entry.function, info, &globals, &functions)
            .and_then(Function::compile);
        functions.push(builder.finish(entry.name.clone(), Some(entry), compiled));
    }
    let start = start(&mut builder, &globals);
    builder.link(functions, start)
}

/// Returns the code that fills the private variables.
fn start(builder: &mut Builder, globals: &[CompiledGlobal]) -> Result<FunctionCode, String> {
    let none = naga::Function::default();
    // No function has this number: a place in an initialiser is shown without a function's name.
    builder.begin(u32::MAX);
    let compiled = Function::globals(builder, &none, globals);
    let code = builder.finish(String::new(), None, compiled);
    code.state.clone().map(|_| code)
}

fn globals(builder: &mut Builder) -> Vec<CompiledGlobal> {
    let ir = builder.ir;
    ir.global_variables
        .iter()
        .map(|(handle, variable)| {
            let name = variable.name.clone().unwrap_or_default();
            let bound = variable.binding.map_or((0, 0), |b| (b.group, b.binding));
            let inner = &ir.types[variable.ty].inner;
            let mut buffer = |space: BufferSpace, read_only: bool, size: u32| {
                let name = name.clone();
                builder.buffers.push(BufferInfo { name, variable: handle, bound, space, size });
                CompiledGlobal::Buffer { number: builder.buffers.len() as u32 - 1, read_only }
            };
            let size = inner.size(ir.to_ctx());
            match variable.space {
                AddressSpace::Uniform => buffer(BufferSpace::Uniform, true, size),
                AddressSpace::Immediate => buffer(BufferSpace::PushConstant, true, size),
                AddressSpace::Storage { access } => {
                    let writable = access.contains(StorageAccess::STORE);
                    buffer(BufferSpace::Storage { writable }, !writable, size)
                }
                AddressSpace::WorkGroup => buffer(BufferSpace::Workgroup, false, size),
                AddressSpace::Private => match builder.variable(inner) {
                    Ok(regs) => CompiledGlobal::Private(regs),
                    Err(why) => CompiledGlobal::Refused(why),
                },
                AddressSpace::Handle => match inner {
                    naga::TypeInner::Image { .. } => {
                        let number = builder.images.len() as u32;
                        builder.images.push(ImageInfo { name, bound });
                        CompiledGlobal::Image(builder.word(number))
                    }
                    // Lookups take the nearest texel whatever the sampler says, so its value is not
                    // read.
                    naga::TypeInner::Sampler { .. } => CompiledGlobal::Image(builder.word(0)),
                    other => CompiledGlobal::Refused(super::flatten::kind_name(other).into()),
                },
                space => CompiledGlobal::Refused(format!("variables in address space {space:?}")),
            }
        })
        .collect()
}

/// Returns the given values of overrides, by their index in the module.
fn overrides_of(ir: &naga::Module, given: &[(String, f64)]) -> Vec<Option<f64>> {
    ir.overrides
        .iter()
        .map(|(_, o)| {
            // An override with `@id` is set by its number, another by its name: WGSL §7.2.
            let id = o.id.map(|id| id.to_string());
            given
                .iter()
                .find(|(name, _)| Some(name) == o.name.as_ref() || Some(name) == id.as_ref())
                .map(|(_, value)| *value)
        })
        .collect()
}

/// Returns an array length that is an override: the given one, or its literal default.
fn length_of(
    ir: &naga::Module,
    given: &[Option<f64>],
    handle: Handle<naga::Override>,
) -> Option<u32> {
    if let Some(value) = given[handle.index()] {
        // Zero elements, a fraction or a NaN make no length.
        return (value.fract() == 0.0 && (1.0..4294967296.0).contains(&value))
            .then_some(value as u32);
    }
    match ir.global_expressions[ir.overrides[handle].init?] {
        naga::Expression::Literal(naga::Literal::U32(n)) => Some(n),
        naga::Expression::Literal(naga::Literal::I32(n)) => u32::try_from(n).ok(),
        // Of earlier overrides only, which bounds the recursion.
        naga::Expression::Override(other) if other < handle => length_of(ir, given, other),
        _ => None,
    }
}

/// Returns an origin without a text.
fn nowhere(function: u32) -> Origin {
    Origin { function, start: 0, end: 0 }
}
