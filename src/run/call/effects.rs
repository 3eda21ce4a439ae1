//! What a function and those it calls do besides computing, and what is read before they run.
//!
//! Looks through naga's IR; [`make`](super::make) refuses by it.

use naga::{AddressSpace, Expression, Function, GlobalVariable, Handle, Statement};
use rustc_hash::FxHashSet;

use crate::run::reach;

/// What a function and those it calls do besides computing.
#[derive(Default)]
pub(super) struct Seen {
    /// Variables it writes.
    pub stored: FxHashSet<Handle<GlobalVariable>>,
    pub derivatives: bool,
    pub barriers: bool,
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
                    let pointers = arguments.iter().filter(|at| is_pointer(ir, function, **at));
                    seen.stored.extend(pointers.filter_map(|at| reach::root(function, *at)));
                }
                Statement::Store { pointer, .. } | Statement::Atomic { pointer, .. } => {
                    seen.stored.extend(reach::root(function, *pointer));
                }
                Statement::ControlBarrier(_) | Statement::MemoryBarrier(_) => {
                    seen.barriers = true;
                }
                _ => {}
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

fn is_pointer(ir: &naga::Module, function: &Function, at: Handle<Expression>) -> bool {
    reach::root(function, at).is_some_and(|variable| {
        !matches!(ir.global_variables[variable].space, AddressSpace::Handle)
            && !matches!(function.expressions[at], Expression::Load { .. })
    })
}
