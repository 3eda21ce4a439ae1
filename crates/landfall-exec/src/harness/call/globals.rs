//! Turns blocks and global variables of a module into arguments of its last function, the caller:
//! blocks are passed by value, written variables returned through pointers.
//!
//! Used by [`make`](super::make).

use naga::{
    AddressSpace, Block, Expression, Function, FunctionArgument, GlobalVariable, Handle, Span,
    Statement, Type, TypeInner,
};

use landfall_interp::ValueType;
use landfall_ir::Module;

/// A block whose members become parameters.
pub(super) struct SampledBlock {
    /// The index among the module's blocks.
    pub number: usize,
    pub variable: Handle<GlobalVariable>,
    pub members: Vec<SampledMember>,
}

/// A member that becomes a parameter.
pub(super) struct SampledMember {
    pub name: String,
    pub ty: ValueType,
    pub read: bool,
}

/// Adds a parameter to the caller for each block, then one for each written variable.
pub(super) fn through_arguments(
    module: &mut Module,
    handle: Handle<Function>,
    blocks: &[SampledBlock],
    written: &[Handle<GlobalVariable>],
) {
    let ir = &mut module.ir;
    let mut function = std::mem::take(&mut ir.functions[handle]);
    let mut front = Block::new();
    for SampledBlock { number, variable, .. } in blocks {
        let name = module.blocks[*number].layout.name.to_string();
        let global = &mut ir.global_variables[*variable];
        // The function reads the block as before: it becomes a private variable, which the caller
        // fills.
        global.space = AddressSpace::Private;
        global.binding = None;
        let at = function.arguments.len() as u32;
        function.arguments.push(FunctionArgument {
            name: Some(name),
            ty: global.ty,
            binding: None,
        });
        let mut push = |e| function.expressions.append(e, Span::UNDEFINED);
        let value = push(Expression::FunctionArgument(at));
        let pointer = push(Expression::GlobalVariable(*variable));
        front.push(Statement::Store { pointer, value }, Span::UNDEFINED);
    }
    let mut tail = Vec::new();
    for variable in written {
        let global = &ir.global_variables[*variable];
        let (name, space) = (global.name.clone(), AddressSpace::Function);
        let inner = TypeInner::Pointer { base: global.ty, space };
        let ty = ir.types.insert(Type { name: None, inner }, Span::UNDEFINED);
        tail.push((function.arguments.len() as u32, *variable));
        function.arguments.push(FunctionArgument { name, ty, binding: None });
    }
    surround(&mut function, front, &tail);
    ir.functions[handle] = function;
}

/// Prepends statements to the body, and copies variables into pointers before each return.
fn surround(function: &mut Function, front: Block, tail: &[(u32, Handle<GlobalVariable>)]) {
    let mut body = front;
    let old = std::mem::take(&mut function.body);
    for (statement, span) in old.span_iter() {
        // The caller's body is flat: each of its returns is here.
        if matches!(statement, Statement::Return { .. }) {
            for (argument, variable) in tail {
                let mut push = |e| function.expressions.append(e, Span::UNDEFINED);
                let to = push(Expression::FunctionArgument(*argument));
                let from = push(Expression::GlobalVariable(*variable));
                let before = function.expressions.len();
                let load = Expression::Load { pointer: from };
                let value = function.expressions.append(load, Span::UNDEFINED);
                let emitted = function.expressions.range_from(before);
                body.push(Statement::Emit(emitted), Span::UNDEFINED);
                body.push(Statement::Store { pointer: to, value }, Span::UNDEFINED);
            }
        }
        body.push(statement.clone(), *span);
    }
    function.body = body;
}
