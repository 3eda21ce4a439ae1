//! Side effects of a function and its callees, and reads of initialisers before it runs.
//!
//! Walks naga's IR; [`make`](super::make) rejects functions by it.

use naga::{AddressSpace, Expression, Function, GlobalVariable, Handle, Statement};
use rustc_hash::FxHashSet;
use std::collections::BTreeSet;

use landfall_ir::call_graph;
use landfall_ir::module::FunctionInfo;

/// The side effects of a function and its callees.
#[derive(Default)]
pub(super) struct Effects {
    /// The variables it writes.
    pub stored: FxHashSet<Handle<GlobalVariable>>,
    pub derivatives: bool,
    /// Whether it waits for other invocations or uses their values.
    pub together: bool,
}

/// Returns the side effects of a function.
pub(super) fn effects_of(ir: &naga::Module, target: &Function) -> Effects {
    let mut effects = Effects::default();
    for function in call_graph::functions(ir, target) {
        let derivative = |(_, e): (_, &Expression)| matches!(e, Expression::Derivative { .. });
        effects.derivatives |= function.expressions.iter().any(derivative);
        for statement in call_graph::statements(&function.body) {
            match statement {
                // A variable whose pointer is passed on may be written through it.
                Statement::Call { arguments, .. } => {
                    let roots = arguments.iter().filter_map(|at| call_graph::root(function, *at));
                    effects.stored.extend(roots.filter(|variable| {
                        // Textures and samplers are passed on, but not written.
                        ir.global_variables[*variable].space != AddressSpace::Handle
                    }));
                }
                Statement::Store { pointer, .. }
                | Statement::Atomic { pointer, .. }
                | Statement::ImageStore { image: pointer, .. }
                | Statement::ImageAtomic { image: pointer, .. } => {
                    effects.stored.extend(call_graph::root(function, *pointer));
                }
                Statement::ControlBarrier(_)
                | Statement::MemoryBarrier(_)
                | Statement::WorkGroupUniformLoad { .. }
                | Statement::SubgroupBallot { .. }
                | Statement::SubgroupGather { .. }
                | Statement::SubgroupCollectiveOperation { .. } => effects.together = true,
                _ => {}
            }
        }
    }
    effects
}

/// Returns the global variables that are the results of a function: those that it writes, if it
/// returns nothing.
pub(super) fn written(
    ir: &naga::Module,
    info: &FunctionInfo,
    effects: &Effects,
) -> Vec<Handle<GlobalVariable>> {
    let private = |(handle, variable): (Handle<GlobalVariable>, &GlobalVariable)| {
        let written = variable.space == AddressSpace::Private && effects.stored.contains(&handle);
        written.then_some(handle)
    };
    match info.returns {
        Some(_) => Vec::new(),
        None => ir.global_variables.iter().filter_map(private).collect(),
    }
}

/// Adds the effects of variables' initialisers, which the caller runs before the call: all of them
/// if one is for a variable in use.
pub(super) fn through_initialisers(
    ir: &naga::Module,
    caller: &Function,
    reached: &mut BTreeSet<Handle<GlobalVariable>>,
) {
    let mut called: Vec<Handle<Function>> = call_graph::calls(caller).collect();
    // The last call is the call of the target.
    called.pop();
    for function in called {
        let function = &ir.functions[function];
        let mut stores = call_graph::statements(&function.body);
        let is_needed = stores.any(|statement| match statement {
            Statement::Store { pointer, .. } => {
                call_graph::root(function, *pointer).is_some_and(|to| reached.contains(&to))
            }
            _ => false,
        });
        if is_needed {
            reached.extend(call_graph::variables(ir, function));
        }
    }
}
