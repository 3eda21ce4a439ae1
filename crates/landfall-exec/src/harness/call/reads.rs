//! Which members of a block a function reads, by itself and through those it calls.
//!
//! Feeds [`make`](super::make): only what is read is worth a value.

use naga::{Expression, Function, GlobalVariable, Handle, Module, Statement};
use rustc_hash::{FxHashMap, FxHashSet};

use landfall_ir::reach;

/// Members by number; none where it may be all of them.
pub(super) type Members = Option<FxHashSet<u32>>;

/// The members that a function reads of each variable it names.
pub(super) fn members(
    ir: &Module,
    function: &Function,
) -> FxHashMap<Handle<GlobalVariable>, Members> {
    let mut all: FxHashMap<Handle<GlobalVariable>, Members> = FxHashMap::default();
    for function in reach::functions(ir, function) {
        let wholes = passed(function);
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
    all
}

fn named(function: &Function, at: Handle<Expression>) -> Option<Handle<GlobalVariable>> {
    match function.expressions[at] {
        Expression::GlobalVariable(variable) => Some(variable),
        _ => None,
    }
}

/// What is passed to functions, which may read all of it.
fn passed(function: &Function) -> FxHashSet<Handle<Expression>> {
    let arguments = reach::statements(&function.body).filter_map(|statement| match statement {
        Statement::Call { arguments, .. } => Some(arguments),
        _ => None,
    });
    arguments.flatten().copied().collect()
}
