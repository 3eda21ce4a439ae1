//! What a function and those it calls do besides computing, and what is read before they run.
//!
//! Looks through naga's IR; [`make`](super::make) refuses by it.

use naga::{AddressSpace, Expression, Function, GlobalVariable, Handle, Statement};
use rustc_hash::FxHashSet;

use landfall_ir::reach;

/// What a function and those it calls do besides computing.
#[derive(Default)]
pub(super) struct Seen {
    /// Variables it writes.
    pub stored: FxHashSet<Handle<GlobalVariable>>,
    pub derivatives: bool,
    /// Whether it waits for other invocations, or computes with them.
    pub together: bool,
}

/// What a function does.
pub(super) fn look(ir: &naga::Module, target: &Function) -> Seen {
    let mut seen = Seen::default();
    for function in reach::functions(ir, target) {
        let derivative = |(_, e): (_, &Expression)| matches!(e, Expression::Derivative { .. });
        seen.derivatives |= function.expressions.iter().any(derivative);
        for statement in reach::statements(&function.body) {
            match statement {
                // What a pointer to a variable is given for may be written through it.
                Statement::Call { arguments, .. } => {
                    let roots = arguments.iter().filter_map(|at| reach::root(function, *at));
                    seen.stored.extend(roots.filter(|variable| {
                        ir.global_variables[*variable].space != AddressSpace::Handle
                    }));
                }
                Statement::Store { pointer, .. }
                | Statement::Atomic { pointer, .. }
                | Statement::ImageStore { image: pointer, .. }
                | Statement::ImageAtomic { image: pointer, .. } => {
                    seen.stored.extend(reach::root(function, *pointer));
                }
                Statement::ControlBarrier(_)
                | Statement::MemoryBarrier(_)
                | Statement::WorkGroupUniformLoad { .. }
                | Statement::SubgroupBallot { .. }
                | Statement::SubgroupGather { .. }
                | Statement::SubgroupCollectiveOperation { .. } => seen.together = true,
                _ => {}
            }
        }
    }
    seen
}

/// Adds what variables begin with: initialisers are run before the call, by the caller. All that is
/// read there, where one of them is for a variable that is reached.
pub(super) fn through_initialisers(
    ir: &naga::Module,
    caller: &Function,
    reached: &mut FxHashSet<Handle<GlobalVariable>>,
) {
    let written = reach::statements(&caller.body).filter_map(|statement| match statement {
        Statement::Store { pointer, .. } => reach::root(caller, *pointer),
        _ => None,
    });
    if written.collect::<FxHashSet<_>>().is_disjoint(reached) {
        return;
    }
    let read = caller.expressions.iter().filter_map(|(_, expression)| match expression {
        Expression::Load { pointer } => reach::root(caller, *pointer),
        _ => None,
    });
    reached.extend(read);
    let mut called: Vec<Handle<Function>> = reach::calls(caller).collect();
    // The last call is the one that is meant.
    called.pop();
    for function in called {
        reached.extend(reach::variables(ir, &ir.functions[function]));
    }
}
