//! The variables that `main` can reach: inputs and outputs of dead functions are none of the
//! entry point's, so that a pipeline need not provide them.

use naga::{Block, Expression, Function, GlobalVariable, Handle, Module, Statement};
use rustc_hash::FxHashSet;

/// The global variables named in a function and in those it calls.
pub(in crate::run) fn variables(
    module: &Module,
    main: Handle<Function>,
) -> FxHashSet<Handle<GlobalVariable>> {
    let mut variables = FxHashSet::default();
    let mut seen = FxHashSet::default();
    let mut open = vec![main];
    while let Some(handle) = open.pop() {
        if !seen.insert(handle) {
            continue;
        }
        let function = &module.functions[handle];
        variables.extend(function.expressions.iter().filter_map(|(_, e)| match e {
            Expression::GlobalVariable(variable) => Some(*variable),
            _ => None,
        }));
        calls(&function.body, &mut open);
    }
    variables
}

fn calls(block: &Block, found: &mut Vec<Handle<Function>>) {
    let mut blocks = vec![block];
    while let Some(block) = blocks.pop() {
        for statement in block {
            match statement {
                Statement::Call { function, .. } => found.push(*function),
                Statement::Block(inner) => blocks.push(inner),
                Statement::If { accept, reject, .. } => blocks.extend([accept, reject]),
                Statement::Switch { cases, .. } => blocks.extend(cases.iter().map(|c| &c.body)),
                Statement::Loop { body, continuing, .. } => blocks.extend([body, continuing]),
                _ => {}
            }
        }
    }
}
