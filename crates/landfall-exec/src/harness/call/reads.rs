//! Finds the block members that a function reads, directly and through its callees.
//!
//! Used by [`make`](super::make), which makes parameters of the members that are read.

use naga::{Expression, Function, GlobalVariable, Handle, Module, Statement};
use rustc_hash::{FxHashMap, FxHashSet};

use landfall_ir::call_graph;

/// Member indices; `None` if all may be read.
pub(super) type Members = Option<FxHashSet<u32>>;

/// Returns the members a function reads of each variable in use.
pub(super) fn members(
    ir: &Module,
    function: &Function,
) -> FxHashMap<Handle<GlobalVariable>, Members> {
    let mut all: FxHashMap<Handle<GlobalVariable>, Members> = FxHashMap::default();
    for function in call_graph::functions(ir, function) {
        let wholes = passed(function);
        for (at, expression) in function.expressions.iter() {
            let (variable, member) = match *expression {
                Expression::AccessIndex { base, index } => {
                    (variable_of(function, base), Some(index))
                }
                // A load of the whole variable.
                Expression::Load { pointer } => (variable_of(function, pointer), None),
                _ if wholes.contains(&at) => (variable_of(function, at), None),
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
    all
}

fn variable_of(function: &Function, at: Handle<Expression>) -> Option<Handle<GlobalVariable>> {
    match function.expressions[at] {
        Expression::GlobalVariable(variable) => Some(variable),
        _ => None,
    }
}

/// Returns the expressions passed to other functions, which may read all of them.
fn passed(function: &Function) -> FxHashSet<Handle<Expression>> {
    let arguments =
        call_graph::statements(&function.body).filter_map(|statement| match statement {
            Statement::Call { arguments, .. } => Some(arguments),
            _ => None,
        });
    arguments.flatten().copied().collect()
}
