//! The statements, called functions and global variables that a function of naga's IR reaches.
//!
//! Used by static analyses: [`hazards`](crate::analysis::hazards), and calls, coverage and
//! fragments in `landfall_exec::harness`.

use naga::{Block, Expression, Function, GlobalVariable, Handle, Module, Statement};
use rustc_hash::FxHashSet;
use std::collections::BTreeSet;

/// Returns the statements of a block in the order of the text, nested ones after the statement that
/// contains them.
pub fn statements(block: &Block) -> impl Iterator<Item = &Statement> {
    // A stack of iterators instead of recursion, for nesting that a text can make arbitrarily
    // deep.
    let mut open = vec![block.iter()];
    std::iter::from_fn(move || {
        let statement = loop {
            match open.last_mut()?.next() {
                Some(statement) => break statement,
                None => drop(open.pop()),
            }
        };
        match statement {
            Statement::Block(inner) => open.push(inner.iter()),
            // Pushed in reverse, so that the first body is walked first.
            Statement::If { accept, reject, .. } => open.extend([reject.iter(), accept.iter()]),
            Statement::Switch { cases, .. } => {
                open.extend(cases.iter().rev().map(|case| case.body.iter()));
            }
            Statement::Loop { body, continuing, .. } => {
                open.extend([continuing.iter(), body.iter()]);
            }
            _ => {}
        }
        Some(statement)
    })
}

/// Returns the functions that a function calls directly, once for each call.
pub fn calls(function: &Function) -> impl Iterator<Item = Handle<Function>> {
    statements(&function.body).filter_map(|statement| match statement {
        Statement::Call { function, .. } => Some(*function),
        _ => None,
    })
}

/// Returns a function and all functions it calls, directly or indirectly, each once.
pub fn functions<'m>(module: &'m Module, first: &'m Function) -> Vec<&'m Function> {
    // Breadth first; the list is both result and queue.
    let mut seen = FxHashSet::default();
    let mut reached = vec![first];
    let mut next = 0;
    while let Some(function) = reached.get(next).copied() {
        next += 1;
        let new = calls(function).filter(|called| seen.insert(*called));
        reached.extend(new.map(|called| &module.functions[called]));
    }
    reached
}

/// Returns the global variables used by a function and the functions it calls.
pub fn variables(module: &Module, first: &Function) -> BTreeSet<Handle<GlobalVariable>> {
    functions(module, first).into_iter().flat_map(direct_variables).collect()
}

/// Returns the global variables that a function uses directly.
pub(super) fn direct_variables(
    function: &Function,
) -> impl Iterator<Item = Handle<GlobalVariable>> {
    function.expressions.iter().filter_map(|(_, expression)| match expression {
        Expression::GlobalVariable(variable) => Some(*variable),
        _ => None,
    })
}

/// Returns the global variable that a pointer points into.
pub fn root(function: &Function, mut at: Handle<Expression>) -> Option<Handle<GlobalVariable>> {
    loop {
        match function.expressions[at] {
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => at = base,
            Expression::GlobalVariable(variable) => return Some(variable),
            _ => return None,
        }
    }
}
