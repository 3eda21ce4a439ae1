//! Which members of a block a function reads, by itself and through those it calls.
//!
//! Feeds [`pure`](super::pure): only what is read is worth a value.

use naga::{Block, Expression, Function, GlobalVariable, Handle, Module, Statement};
use rustc_hash::{FxHashMap, FxHashSet};

/// Members by number; none where it may be all of them.
type Members = Option<FxHashSet<u32>>;

/// The members that a function reads of each variable it names.
pub(super) fn members(
    ir: &Module,
    function: Handle<Function>,
) -> FxHashMap<Handle<GlobalVariable>, Members> {
    let mut all: FxHashMap<Handle<GlobalVariable>, Members> = FxHashMap::default();
    let mut done = FxHashSet::default();
    let mut open = vec![function];
    while let Some(handle) = open.pop() {
        if done.insert(handle) {
            let function = &ir.functions[handle];
            let wholes = passed(&function.body, &mut open);
            for (at, expression) in function.expressions.iter() {
                let (variable, member) = match *expression {
                    Expression::AccessIndex { base, index } => (named(function, base), Some(index)),
                    Expression::Load { pointer } => (named(function, pointer), None),
                    _ if wholes.contains(&at) => (named(function, at), None),
                    _ => continue,
                };
                let Some(variable) = variable else { continue };
                let members = all.entry(variable).or_insert_with(|| Some(FxHashSet::default()));
                match (member, members.as_mut()) {
                    (Some(member), Some(members)) => drop(members.insert(member)),
                    (None, _) => *members = None,
                    (Some(_), None) => {}
                }
            }
        }
    }
    all
}

fn named(function: &Function, at: Handle<Expression>) -> Option<Handle<GlobalVariable>> {
    match function.expressions[at] {
        Expression::GlobalVariable(variable) => Some(variable),
        _ => None,
    }
}

/// What is passed to functions, which may read all of it; adds those functions.
fn passed(body: &Block, open: &mut Vec<Handle<Function>>) -> FxHashSet<Handle<Expression>> {
    let mut wholes = FxHashSet::default();
    let mut blocks = vec![body];
    while let Some(block) = blocks.pop() {
        for statement in block {
            match statement {
                Statement::Call { function, arguments, .. } => {
                    open.push(*function);
                    wholes.extend(arguments.iter().copied());
                }
                Statement::Block(inner) => blocks.push(inner),
                Statement::If { accept, reject, .. } => blocks.extend([accept, reject]),
                Statement::Switch { cases, .. } => blocks.extend(cases.iter().map(|c| &c.body)),
                Statement::Loop { body, continuing, .. } => blocks.extend([body, continuing]),
                _ => {}
            }
        }
    }
    wholes
}
