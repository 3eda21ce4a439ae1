//! Matches the blocks of both sides.

use crate::layout::BlockLayout;

/// The indices of matching blocks, in the order of the new ones, then the removed ones.
///
/// Blocks match by name, and by instance if several share a name. The others match by set and
/// binding, by instance name, or by equal leaves; of several that do, by the first.
pub(super) fn pairs(
    old: &[BlockLayout],
    new: &[BlockLayout],
) -> Vec<(Option<usize>, Option<usize>)> {
    let mut of_new: Vec<Option<usize>> = vec![None; new.len()];
    let mut taken = vec![false; old.len()];
    let reasons: [fn(&BlockLayout, &BlockLayout) -> bool; 6] = [
        |a, b| a.name == b.name && a.instance == b.instance && a.space == b.space,
        |a, b| a.name == b.name && a.space == b.space,
        |a, b| a.name == b.name,
        |a, b| a.space == b.space && a.binding.is_some() && slot(a) == slot(b),
        |a, b| a.space == b.space && a.instance.is_some() && a.instance == b.instance,
        |a, b| a.space == b.space && !a.leaves.is_empty() && same_leaves(a, b),
    ];
    // Each reason is tried for all blocks before the next, weaker one: a block that kept its name
    // is not taken by one that has its binding.
    for reason in reasons {
        for (i, after) in new.iter().enumerate() {
            if of_new[i].is_some() {
                continue;
            }
            let found = (0..old.len()).find(|&at| !taken[at] && reason(&old[at], after));
            if let Some(at) = found {
                taken[at] = true;
                of_new[i] = Some(at);
            }
        }
    }
    let gone = (0..old.len()).filter(|&at| !taken[at]).map(|at| (Some(at), None));
    of_new.iter().enumerate().map(|(i, at)| (*at, Some(i))).chain(gone).collect()
}

fn slot(block: &BlockLayout) -> (u32, Option<u32>) {
    // The default set is 0.
    (block.group.unwrap_or(0), block.binding)
}

fn same_leaves(a: &BlockLayout, b: &BlockLayout) -> bool {
    a.leaves.len() == b.leaves.len()
        && a.leaves.iter().zip(&b.leaves).all(|(a, b)| {
            (&a.path, a.offset, &a.ty, &a.dims, &a.strides)
                == (&b.path, b.offset, &b.ty, &b.dims, &b.strides)
        })
}
