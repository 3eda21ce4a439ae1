//! Changes of loose uniforms, which are set by name, so only names and types matter.

use rustc_hash::FxHashMap;

use super::{Change, Class, Kind, SidedBlock};
use crate::diff::elements::covers;
use crate::layout::Leaf;
use crate::shape::ArrayLen;

/// The changes of the loose uniforms of a shader.
pub(super) fn changes(old: SidedBlock<'_>, new: SidedBlock<'_>) -> Vec<Change> {
    let mut changes = Vec::new();
    let by_path = |block: SidedBlock<'_>| -> FxHashMap<String, usize> {
        let leaves = block.layout.leaves.iter().enumerate();
        leaves.map(|(i, leaf)| (leaf.path.clone(), i)).collect()
    };
    let (was_at, is_at) = (by_path(old), by_path(new));
    for leaf in &old.layout.leaves {
        let was = leaf.ty.spelled(old.side.language).to_string();
        let path = leaf.path.clone();
        let Some(&at) = is_at.get(&leaf.path) else {
            let message = format!("`{path}` was removed: values set by that name have no effect");
            let (kind, class) = (Kind::Removed, Class::Breaking);
            changes.push(Change { kind, class, path, old: Some(was), new: None, message });
            continue;
        };
        let now = &new.layout.leaves[at];
        if now.ty != leaf.ty {
            let is = now.ty.spelled(new.side.language).to_string();
            let message = format!("`{path}` changed from `{was}` to `{is}`");
            let (kind, class, path) = (Kind::Retyped, Class::Breaking, path.clone());
            changes.push(Change { kind, class, path, old: Some(was), new: Some(is), message });
        }
        if now.dims != leaf.dims {
            // Of dimensions that both have; a path tells their number, so that it is the same.
            let fewer = !leaf.dims.iter().zip(&now.dims).all(|(a, b)| covers(b, a));
            let (kind, class, word) = match fewer {
                true => (Kind::Shortened, Class::Breaking, "fewer"),
                false => (Kind::Lengthened, Class::Compatible, "more"),
            };
            let dims = |leaf: &Leaf| leaf.dims.iter().map(ArrayLen::to_string).collect::<String>();
            let (was, is) = (dims(leaf), dims(now));
            let message = format!("`{path}` has {word} elements: `{is}`, was `{was}`");
            changes.push(Change { kind, class, path, old: Some(was), new: Some(is), message });
        }
    }
    for leaf in &new.layout.leaves {
        if !was_at.contains_key(&leaf.path) {
            let ty = leaf.ty.spelled(new.side.language).to_string();
            let path = leaf.path.clone();
            let message = format!("`{path}` (`{ty}`) is new, and not set yet");
            let (kind, class) = (Kind::Appended, Class::Compatible);
            changes.push(Change { kind, class, path, old: None, new: Some(ty), message });
        }
    }
    changes
}
