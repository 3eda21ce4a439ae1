//! Names of blocks and members: those of the module as identifiers, or made from numbers.

use std::collections::HashSet;
use std::sync::Arc;

/// The most characters of a name that are kept: names are debug information of any length.
const LONGEST: usize = 255;

/// Returns a name as an identifier: `type.Camera` is `type_Camera`. `None` if nothing is left of it.
pub(super) fn identifier(name: &str) -> Option<Arc<str>> {
    let is_part = |c: char| c == '_' || c.is_alphanumeric();
    let mut kept: String =
        name.chars().take(LONGEST).map(|c| if is_part(c) { c } else { '_' }).collect();
    if kept.chars().all(|c| c == '_') {
        return None;
    }
    // No identifier of any output language begins with a digit.
    if kept.starts_with(|c: char| c.is_numeric()) {
        kept.insert(0, '_');
    }
    Some(kept.into())
}

/// Returns the name of a structure without what DirectX's compiler puts before the name of the text:
/// `type.Camera`, `type.StructuredBuffer.Light`.
pub(super) fn without_kind(name: &str) -> &str {
    match name.strip_prefix("type.") {
        Some(rest) => rest.rsplit('.').next().filter(|last| !last.is_empty()).unwrap_or(rest),
        None => name,
    }
}

/// Gives the members of a structure names of their own: the second `a` becomes `a_3`, by its index.
pub(super) fn distinct(names: Vec<Arc<str>>) -> Vec<Arc<str>> {
    let mut taken: HashSet<Arc<str>> = HashSet::with_capacity(names.len());
    // A name that is made does not take one of the module's.
    let own: HashSet<Arc<str>> = names.iter().cloned().collect();
    let one = |(index, name): (usize, Arc<str>)| {
        if taken.insert(Arc::clone(&name)) {
            return name;
        }
        let mut made: Arc<str> = format!("{name}_{index}").into();
        while own.contains(&made) || !taken.insert(Arc::clone(&made)) {
            made = format!("{made}_{index}").into();
        }
        made
    };
    names.into_iter().enumerate().map(one).collect()
}
