//! The members of each block that a shader's functions access, by naga's module.
//!
//! Available only for a text that naga parses completely. Doubtful cases count as use: a structure
//! copied or passed as a whole uses all of its members.

use std::borrow::Cow;
use std::fmt::Write as _;

use naga::valid::{Capabilities, FunctionInfo, ValidationFlags, Validator};
use naga::{Expression, Function, GlobalVariable, Handle, Module, TypeInner};
use rustc_hash::FxHashSet;

use super::variable_of;
use crate::layout::BlockLayout;
use crate::naga_front::{glsl_whole, guarded_validation, wgsl_module};
use crate::source::{Language, ReadOptions, Source};

/// Paths of a block that functions access, as leaves spell them; each includes everything below it.
pub type Used = FxHashSet<String>;

/// Returns the accessed paths of each block, in the order of `blocks`; `None` for a block that is
/// not a variable of naga's module. `None` for all if naga rejects the text, or if it has no entry
/// point and others may call its functions.
pub fn used(
    source: &Source,
    options: &ReadOptions,
    blocks: &[BlockLayout],
) -> Option<Vec<Option<Used>>> {
    let source = &crate::syntax::linked(source, options);
    let module = match source.language {
        Language::Wgsl => wgsl_module(&source.text)?,
        Language::SpirV => return None,
        Language::Glsl => {
            let text = with_distinct_instances(&source.text, blocks);
            glsl_whole(&text, source.stage, &options.defines)?
        }
    };
    if module.entry_points.is_empty() {
        return None;
    }
    // Layout faults do not matter here, so no flag enables their checks.
    let info = guarded_validation(|| {
        Validator::new(ValidationFlags::empty(), Capabilities::all()).validate(&module).ok()
    })?;
    let mut touched: Vec<(Handle<GlobalVariable>, Vec<AccessStep>)> = Vec::new();
    let language = source.language;
    for (handle, function) in module.functions.iter() {
        touches(&module, function, &info[handle], language, &mut touched);
    }
    for (index, entry) in module.entry_points.iter().enumerate() {
        touches(&module, &entry.function, info.get_entry_point(index), language, &mut touched);
    }
    // A function that no entry point calls counts as well: another may.
    let of_block = |block: &BlockLayout| {
        let variable = variable_of(&module, block)?;
        let own = touched.iter().filter(|(other, _)| *other == variable);
        Some(own.map(|(_, steps)| spelled(&module, variable, steps, block, source)).collect())
    };
    Some(blocks.iter().map(of_block).collect())
}

/// A GLSL text in which no instance has the name of a member of its block: naga 30 takes the former
/// for the latter. Every such name is changed but for those of members, which keep theirs.
fn with_distinct_instances<'t>(text: &'t str, blocks: &[BlockLayout]) -> Cow<'t, str> {
    let clashes = |block: &BlockLayout| {
        let instance = block.instance.clone()?;
        block.members.iter().any(|member| member.name == instance).then_some(instance)
    };
    let clashing: Vec<_> = blocks.iter().filter_map(clashes).collect();
    // Tokens of joined lines are not parts of the text.
    if clashing.is_empty() || text.contains("\\\n") {
        return text.into();
    }
    let mut renamed = String::with_capacity(text.len() + 64);
    let (mut at, mut braces) = (0, Vec::new());
    // Token by token; a name is changed unless it follows a dot or stands within a declaration of
    // members.
    let mut before = "";
    for token in crate::syntax::tokens(text, Language::Glsl) {
        match token {
            // A body follows its parameters, and stands in bodies alone.
            "{" => braces.push(before == ")" || braces.last() == Some(&true)),
            "}" => drop(braces.pop()),
            _ if before != "."
                && braces.last() != Some(&false)
                && clashing.iter().any(|name| **name == *token) =>
            {
                let start = (token.as_ptr() as usize).wrapping_sub(text.as_ptr() as usize);
                if text.get(start..start.wrapping_add(token.len())) != Some(token) {
                    return text.into();
                }
                renamed.push_str(&text[at..start]);
                let _ = write!(renamed, "{token}_instance");
                at = start + token.len();
            }
            _ => {}
        }
        before = token;
    }
    renamed.push_str(&text[at..]);
    renamed.into()
}

/// One step from a variable to the place accessed.
#[derive(Clone, Copy)]
enum AccessStep {
    /// A member, or an element of a non-array.
    Index(u32),
    /// A dynamically indexed element.
    Any,
}

/// Returns the places a function accesses: expressions used by anything other than a further access
/// step.
fn touches(
    module: &Module,
    function: &Function,
    info: &FunctionInfo,
    language: Language,
    touched: &mut Vec<(Handle<GlobalVariable>, Vec<AccessStep>)>,
) {
    // The number of times an expression is only the base of a further step.
    let mut steps = vec![0usize; function.expressions.len()];
    for (_, expression) in function.expressions.iter() {
        match expression {
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => {
                steps[base.index()] += 1;
            }
            // For a block with an instance name, naga's GLSL front end loads the whole, then
            // accesses a member.
            Expression::Load { pointer } => steps[pointer.index()] += 1,
            _ => {}
        }
    }
    for (handle, _) in function.expressions.iter() {
        // Used by something else than a further step: the place itself is read or written.
        let further = info[handle].ref_count > steps[handle.index()];
        // `let x = u.a;`, `_ = u.a;` read `a`, though nothing reads `x`.
        let last = info[handle].ref_count == 0;
        if !further && !last {
            continue;
        }
        let Some(way) = way_to(module, function, handle) else { continue };
        // naga's GLSL front end adds every variable to every function: only loaded ones are
        // mentioned.
        let mentioned = match language {
            Language::Wgsl => true,
            Language::Glsl | Language::SpirV => way.loaded,
        };
        if further || mentioned {
            touched.push((way.variable, way.steps));
        }
    }
}

/// The steps from a variable to a place in it, or to its value.
struct AccessPath {
    variable: Handle<GlobalVariable>,
    steps: Vec<AccessStep>,
    loaded: bool,
}

/// Returns the variable an expression is part of, and the steps to it; `None` for computed values.
fn way_to(
    module: &Module,
    function: &Function,
    mut handle: Handle<Expression>,
) -> Option<AccessPath> {
    let (mut steps, mut loaded) = (Vec::new(), false);
    loop {
        // From the place back to the variable; the steps are found in reverse.
        match function.expressions[handle] {
            Expression::GlobalVariable(variable) => {
                steps.reverse();
                return (!matches!(
                    module.global_variables[variable].space,
                    naga::AddressSpace::Handle
                ))
                .then_some(AccessPath { variable, steps, loaded });
            }
            Expression::AccessIndex { base, index } => {
                steps.push(AccessStep::Index(index));
                handle = base;
            }
            Expression::Access { base, .. } => {
                steps.push(AccessStep::Any);
                handle = base;
            }
            Expression::Load { pointer } => {
                loaded = true;
                handle = pointer;
            }
            _ => return None,
        }
    }
}

/// Returns the path of a place as leaves spell it, down to the last member or element.
fn spelled(
    module: &Module,
    variable: Handle<GlobalVariable>,
    steps: &[AccessStep],
    block: &BlockLayout,
    source: &Source,
) -> String {
    let mut path = match (source.language, &block.instance) {
        // A store type that is not a structure: its one member has the variable's name.
        (Language::Wgsl, None) => block.name.to_string(),
        (Language::Wgsl, Some(_)) | (Language::Glsl | Language::SpirV, _) => String::new(),
    };
    let mut ty = module.global_variables[variable].ty;
    // The dimensions of an array of blocks are not part of a path.
    let mut outer = block.count.len();
    for step in steps {
        match (&module.types[ty].inner, step) {
            (TypeInner::Array { base, .. } | TypeInner::BindingArray { base, .. }, _) => {
                match outer {
                    0 => path.push_str("[]"),
                    _ => outer -= 1,
                }
                ty = *base;
            }
            (TypeInner::Struct { members, .. }, AccessStep::Index(index)) => {
                let Some(member) = members.get(*index as usize) else { break };
                if !path.is_empty() {
                    path.push('.');
                }
                path.push_str(member.name.as_deref().unwrap_or(""));
                ty = member.ty;
            }
            // A component of a vector, a column of a matrix: the leaf as a whole.
            _ => break,
        }
    }
    path
}
