//! What a function and those it calls do besides computing, and what is read before they run.
//!
//! Looks through naga's IR; [`pure`](super::pure) refuses by it.

use naga::{AddressSpace, Expression, Function, GlobalVariable, Handle, Statement};
use rustc_hash::FxHashSet;

use crate::run::glsl::reach;

/// What a function and those it calls do besides computing.
#[derive(Default)]
pub(super) struct Seen {
    /// Variables it writes.
    pub stored: FxHashSet<Handle<GlobalVariable>>,
    pub derivatives: bool,
    pub barriers: bool,
}

/// What a function does.
pub(super) fn look(ir: &naga::Module, target: Handle<Function>) -> Seen {
    let mut seen = Seen::default();
    let mut done = FxHashSet::default();
    let mut open = vec![target];
    while let Some(handle) = open.pop() {
        if !done.insert(handle) {
            continue;
        }
        let function = &ir.functions[handle];
        let derivative = |(_, e): (_, &Expression)| matches!(e, Expression::Derivative { .. });
        seen.derivatives |= function.expressions.iter().any(derivative);
        let mut blocks = vec![&function.body];
        while let Some(block) = blocks.pop() {
            for statement in block {
                match statement {
                    Statement::Call { function: called, arguments, .. } => {
                        open.push(*called);
                        // What a pointer to a variable is given for may be written through it.
                        for argument in arguments {
                            if is_pointer(ir, function, *argument) {
                                seen.stored.extend(root(function, *argument));
                            }
                        }
                    }
                    Statement::Store { pointer, .. } | Statement::Atomic { pointer, .. } => {
                        seen.stored.extend(root(function, *pointer));
                    }
                    Statement::ControlBarrier(_) | Statement::MemoryBarrier(_) => {
                        seen.barriers = true;
                    }
                    Statement::Block(inner) => blocks.push(inner),
                    Statement::If { accept, reject, .. } => blocks.extend([accept, reject]),
                    Statement::Switch { cases, .. } => {
                        blocks.extend(cases.iter().map(|case| &case.body));
                    }
                    Statement::Loop { body, continuing, .. } => blocks.extend([body, continuing]),
                    _ => {}
                }
            }
        }
    }
    seen
}

/// Adds what variables begin with: initialisers are run before the call, by the caller, which is
/// the last function. All that is read there, where one of them is for a variable that is reached.
pub(super) fn through_initialisers(
    ir: &naga::Module,
    reached: &mut FxHashSet<Handle<GlobalVariable>>,
) {
    let Some((_, caller)) = ir.functions.iter().last() else { return };
    let (mut written, mut called) = (FxHashSet::default(), Vec::new());
    let mut blocks = vec![&caller.body];
    while let Some(block) = blocks.pop() {
        for statement in block {
            match statement {
                Statement::Store { pointer, .. } => written.extend(root(caller, *pointer)),
                Statement::Call { function, .. } => called.push(*function),
                Statement::Block(inner) => blocks.push(inner),
                Statement::If { accept, reject, .. } => blocks.extend([accept, reject]),
                Statement::Switch { cases, .. } => blocks.extend(cases.iter().map(|c| &c.body)),
                Statement::Loop { body, continuing, .. } => blocks.extend([body, continuing]),
                _ => {}
            }
        }
    }
    // The last call is the one that is meant.
    called.pop();
    if written.is_disjoint(reached) {
        return;
    }
    let read = caller.expressions.iter().filter_map(|(_, expression)| match expression {
        Expression::Load { pointer } => root(caller, *pointer),
        _ => None,
    });
    reached.extend(read);
    called.into_iter().for_each(|function| reached.extend(reach::variables(ir, function)));
}

fn is_pointer(ir: &naga::Module, function: &Function, at: Handle<Expression>) -> bool {
    root(function, at).is_some_and(|variable| {
        !matches!(ir.global_variables[variable].space, AddressSpace::Handle)
            && !matches!(function.expressions[at], Expression::Load { .. })
    })
}

/// The variable a pointer is into.
fn root(function: &Function, mut at: Handle<Expression>) -> Option<Handle<GlobalVariable>> {
    loop {
        match function.expressions[at] {
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => at = base,
            Expression::GlobalVariable(variable) => return Some(variable),
            _ => return None,
        }
    }
}
