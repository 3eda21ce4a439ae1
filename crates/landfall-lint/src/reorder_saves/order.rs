//! The order of members that ends earliest.
//!
//! Members of the same size and alignment are interchangeable, so a state of the search is the
//! number of members of each kind that are already placed. A later end of the placed members never
//! makes the whole end earlier, so it is enough to keep the earliest end of each state, and the
//! search is exact. With too many kinds for that, a heuristic places the largest alignment first
//! and fills holes with what fits.

use rustc_hash::FxHashMap;

use super::footprint;
use landfall_layout::shape::{MatrixLayout, Member, Rules};

/// The most states that are searched; with more, a heuristic builds the order.
const MAX_STATES: u64 = 20_000;

/// The most kinds of members that are ordered.
const MAX_KINDS: usize = 1_000;

/// Members of one size and alignment, and their indices in the text.
struct AlikeMembers {
    size: u64,
    align: u64,
    members: Vec<usize>,
}

/// Returns an order that may be smaller; `None` if there is only one.
pub(super) fn smallest(
    members: &[Member],
    rules: Rules,
    matrix_layout: MatrixLayout,
) -> Option<Vec<usize>> {
    if members.len() < 2 || members.iter().any(|member| member.offset.is_some()) {
        return None;
    }
    // Only the last member may be runtime-sized, and it stays there.
    let free = match members.last().map(|member| footprint(member, rules, matrix_layout)) {
        Some(None) => members.len() - 1,
        Some(Some(_)) | None => members.len(),
    };
    let mut kinds: Vec<AlikeMembers> = Vec::new();
    for (index, member) in members[..free].iter().enumerate() {
        let (size, align) = footprint(member, rules, matrix_layout)?;
        match kinds.iter().position(|kind| (kind.size, kind.align) == (size, align)) {
            Some(kind) => kinds[kind].members.push(index),
            None if kinds.len() == MAX_KINDS => return None,
            None => kinds.push(AlikeMembers { size, align, members: vec![index] }),
        }
    }
    let states = kinds.iter().fold(1u64, |n, k| n.saturating_mul(k.members.len() as u64 + 1));
    let mut order =
        if states <= MAX_STATES { exact(&kinds, states as usize) } else { by_thumb(&kinds) };
    order.extend(free..members.len());
    Some(order)
}

/// Returns the members in that order.
pub(super) fn apply(members: &[Member], order: &[usize]) -> Vec<Member> {
    order.iter().map(|&index| members[index].clone()).collect()
}

/// Computes the earliest end of every state, then follows the choices back from the last state.
/// Between equal ends, the later member is placed last.
fn exact(kinds: &[AlikeMembers], states: usize) -> Vec<usize> {
    // A state is a number in a mixed base: digit `k` counts the members of kind `k` that are placed.
    let mut weights = Vec::with_capacity(kinds.len());
    let mut weight = 1;
    for kind in kinds {
        weights.push(weight);
        weight *= kind.members.len() + 1;
    }
    let count = |state: usize, k: usize| state / weights[k] % (kinds[k].members.len() + 1);
    let mut ends = vec![u64::MAX; states];
    ends[0] = 0;
    // The states that lead to one have smaller numbers: their ends are known.
    for state in 1..states {
        for (k, kind) in kinds.iter().enumerate().filter(|(k, _)| count(state, *k) > 0) {
            ends[state] = ends[state].min(placed(ends[state - weights[k]], kind));
        }
    }
    let mut order = Vec::new();
    let mut state = states - 1;
    while state > 0 {
        let last = (0..kinds.len())
            .filter(|&k| count(state, k) > 0)
            .filter(|&k| placed(ends[state - weights[k]], &kinds[k]) == ends[state])
            .max_by_key(|&k| kinds[k].members[count(state, k) - 1])
            .expect("the earliest end was found by one of them");
        order.push(kinds[last].members[count(state, last) - 1]);
        state -= weights[last];
    }
    order.reverse();
    order
}

fn by_thumb(kinds: &[AlikeMembers]) -> Vec<usize> {
    let mut left: FxHashMap<usize, usize> =
        kinds.iter().enumerate().map(|(k, kind)| (k, kind.members.len())).collect();
    let (mut end, mut order) = (0, Vec::new());
    while !left.is_empty() {
        let hole = |kind: &AlikeMembers| end_of_padding(end, kind) - end;
        let next = *left
            .keys()
            .min_by_key(|&&k| {
                let kind = &kinds[k];
                // The smallest hole, then the largest alignment, then the largest size.
                (hole(kind), u64::MAX - kind.align, u64::MAX - kind.size, k)
            })
            .expect("it is not empty");
        let standing = left.get_mut(&next).expect("it was just found");
        order.push(kinds[next].members[kinds[next].members.len() - *standing]);
        *standing -= 1;
        if *standing == 0 {
            left.remove(&next);
        }
        end = placed(end, &kinds[next]);
    }
    order
}

/// Returns the end of a member of that kind placed after `end`.
fn placed(end: u64, kind: &AlikeMembers) -> u64 {
    end_of_padding(end, kind).saturating_add(kind.size)
}

fn end_of_padding(end: u64, kind: &AlikeMembers) -> u64 {
    end.checked_next_multiple_of(kind.align).unwrap_or(u64::MAX)
}
