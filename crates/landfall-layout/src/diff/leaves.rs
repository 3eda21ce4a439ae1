//! Compares the bytes of two versions of a block, leaf by leaf.
//!
//! Uses [`super::elements`]; [`super::describe`] turns the facts into messages.

use rustc_hash::{FxHashMap, FxHashSet};

use super::elements::{
    MAX_ELEMENTS, bytes, common, contains, count, covers, places, same, same_kind,
};
use crate::layout::byte::{ByteOwner, owner_of_byte};
use crate::layout::measure::{fixed, reach};
use crate::layout::{BlockLayout, Leaf};
use crate::shape::ArrayLen;

#[derive(Debug)]
pub(super) struct Fact<'a> {
    /// The old leaf; `None` if it is new.
    pub old: Option<&'a Leaf>,
    /// The new leaf; `None` if it was removed.
    pub new: Option<&'a Leaf>,
    pub what: LeafChange,
}

#[derive(Debug, PartialEq, Eq)]
pub(super) enum LeafChange {
    Moved,
    Retyped,
    MatrixStride,
    MatrixLayout,
    /// The stride of a dimension changed; whether this moves a common element.
    Stride {
        dim: usize,
        matters: bool,
    },
    /// A dimension has more elements; `None` if other old leaves had all of them.
    Longer {
        dim: usize,
        new: Option<FormerContents>,
    },
    /// A dimension has fewer elements; whether no other leaf has the rest.
    Shorter {
        dim: usize,
        lost: bool,
    },
    Gone,
    /// The leaf has another path.
    Renamed,
    New(FormerContents),
}

/// What old uploads hold under the bytes of a new element.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum FormerContents {
    /// Past the last byte of the old block.
    Past,
    Padding,
    /// The named old leaf.
    Reads(String),
}

/// The elements of one side that the other lacks under the same path.
struct Rest<'a> {
    leaf: &'a Leaf,
    /// The other side's leaf with the same path.
    other: Option<&'a Leaf>,
    /// Whether all its elements are matched.
    done: bool,
    /// The offsets of matched elements.
    matched: Vec<u64>,
}

impl<'a> Rest<'a> {
    fn new(leaf: &'a Leaf, other: Option<&'a Leaf>) -> Rest<'a> {
        Rest { leaf, other, done: false, matched: Vec::new() }
    }

    /// The offsets of its elements, if they can be counted.
    fn places(&self) -> Option<Vec<u64>> {
        count(self.leaf)?;
        Some(places(self.leaf, self.other.map(|other| other.dims.as_slice())))
    }
}

/// The facts about the leaves of a block.
pub(super) fn facts<'a>(old: &'a BlockLayout, new: &'a BlockLayout) -> Vec<Fact<'a>> {
    let at: FxHashMap<&str, &Leaf> = new.leaves.iter().map(|l| (l.path.as_str(), l)).collect();
    let was: FxHashMap<&str, &Leaf> = old.leaves.iter().map(|l| (l.path.as_str(), l)).collect();
    let mut facts = Vec::new();
    let (mut old_rest, mut new_rest) = (Vec::new(), Vec::new());
    // Leaves with the same path are compared as patterns: offset, type, strides. What is left on
    // each side is elements, under other paths or past the other's lengths.
    for leaf in &old.leaves {
        match at.get(leaf.path.as_str()) {
            None => old_rest.push(Rest::new(leaf, None)),
            Some(now) => {
                of_pair(leaf, now, &mut facts);
                if !leaf.dims.iter().zip(&now.dims).all(|(a, b)| covers(b, a)) {
                    old_rest.push(Rest::new(leaf, Some(now)));
                }
            }
        }
    }
    for leaf in &new.leaves {
        match was.get(leaf.path.as_str()) {
            None => new_rest.push(Rest::new(leaf, None)),
            Some(before) if !leaf.dims.iter().zip(&before.dims).all(|(a, b)| covers(b, a)) => {
                new_rest.push(Rest::new(leaf, Some(before)));
            }
            Some(_) => {}
        }
    }
    // What is left may have been renamed: leaf by leaf first, then element by element, as when
    // three members become one array.
    whole_renames(&mut old_rest, &mut new_rest, &mut facts);
    single_renames(&mut old_rest, &mut new_rest, &mut facts);
    for rest in old_rest.iter().filter(|rest| !rest.done) {
        match rest.other {
            None => facts.push(Fact { old: Some(rest.leaf), new: None, what: LeafChange::Gone }),
            Some(now) => shorter(rest.leaf, now, true, &mut facts),
        }
    }
    // Old elements still in place leave no room for a new one over them.
    let intact = facts.iter().all(|fact| !is_breaking(&fact.what));
    let mut owners = Owners::from_block(old);
    for rest in &new_rest {
        let lies = if rest.done { None } else { lies(rest, &mut owners, intact) };
        match rest.other {
            None if rest.done => {}
            None => {
                let what = LeafChange::New(lies.unwrap_or(FormerContents::Padding));
                facts.push(Fact { old: None, new: Some(rest.leaf), what });
            }
            Some(before) => longer(before, rest.leaf, lies, &mut facts),
        }
    }
    facts
}

fn is_breaking(what: &LeafChange) -> bool {
    match what {
        LeafChange::Moved
        | LeafChange::Retyped
        | LeafChange::MatrixStride
        | LeafChange::MatrixLayout
        | LeafChange::Gone => true,
        LeafChange::Stride { matters, .. } => *matters,
        LeafChange::Shorter { lost, .. } => *lost,
        LeafChange::Longer { .. } | LeafChange::Renamed | LeafChange::New(_) => false,
    }
}

/// Adds the facts about a leaf that both sides have under one path.
fn of_pair<'a>(old: &'a Leaf, new: &'a Leaf, facts: &mut Vec<Fact<'a>>) {
    let mut fact = |what| facts.push(Fact { old: Some(old), new: Some(new), what });
    let shared: Vec<Option<u64>> =
        old.dims.iter().zip(&new.dims).map(|(a, b)| common(a, b)).collect();
    // No element in common: all of them are new or gone.
    if shared.contains(&Some(0)) {
        return;
    }
    if old.offset != new.offset {
        fact(LeafChange::Moved);
    }
    if old.ty != new.ty {
        fact(LeafChange::Retyped);
    } else {
        if old.row_major != new.row_major {
            fact(LeafChange::MatrixLayout);
        }
        if old.matrix_stride != new.matrix_stride {
            fact(LeafChange::MatrixStride);
        }
    }
    // A stride moves every element but the first.
    for (dim, (a, b)) in old.strides.iter().zip(&new.strides).enumerate() {
        if a != b {
            fact(LeafChange::Stride { dim, matters: shared.get(dim) != Some(&Some(1)) });
        }
    }
}

fn shorter<'a>(old: &'a Leaf, new: &'a Leaf, lost: bool, facts: &mut Vec<Fact<'a>>) {
    for (dim, (a, b)) in old.dims.iter().zip(&new.dims).enumerate() {
        if !covers(b, a) {
            facts.push(Fact {
                old: Some(old),
                new: Some(new),
                what: LeafChange::Shorter { dim, lost },
            });
        }
    }
}

fn longer<'a>(
    old: &'a Leaf,
    new: &'a Leaf,
    lies: Option<FormerContents>,
    facts: &mut Vec<Fact<'a>>,
) {
    for (dim, (a, b)) in old.dims.iter().zip(&new.dims).enumerate() {
        // A dimension that is neither longer nor shorter counts as shorter.
        if !covers(a, b) && covers(b, a) {
            let what = LeafChange::Longer { dim, new: lies.clone() };
            facts.push(Fact { old: Some(old), new: Some(new), what });
        }
    }
}

/// Adds the renames of leaves whose elements are all those of one other leaf.
fn whole_renames<'a>(old: &mut [Rest<'a>], new: &mut [Rest<'a>], facts: &mut Vec<Fact<'a>>) {
    // By offset, so that each leaf is compared with few others.
    let mut at: FxHashMap<u64, Vec<usize>> = FxHashMap::default();
    for (i, rest) in new.iter().enumerate().filter(|(_, rest)| rest.other.is_none()) {
        at.entry(rest.leaf.offset.unwrap_or(0)).or_default().push(i);
    }
    for rest in old.iter_mut().filter(|rest| rest.other.is_none()) {
        let leaf = rest.leaf;
        let Some(here) = at.get(&leaf.offset.unwrap_or(0)) else { continue };
        let found = here.iter().copied().find(|&i| {
            // Countable leaves that are not the same are compared element by element later.
            let uncounted = count(leaf).is_none() || count(new[i].leaf).is_none();
            !new[i].done && (same(new[i].leaf, leaf) || uncounted && contains(new[i].leaf, leaf))
        });
        if let Some(i) = found {
            (rest.done, new[i].done) = (true, true);
            facts.push(Fact { old: Some(leaf), new: Some(new[i].leaf), what: LeafChange::Renamed });
        }
    }
}

/// Adds the renames of single elements: same offset, another path.
fn single_renames<'a>(old: &mut [Rest<'a>], new: &mut [Rest<'a>], facts: &mut Vec<Fact<'a>>) {
    let mut at: FxHashMap<u64, usize> = FxHashMap::default();
    for (i, rest) in new.iter().enumerate().filter(|(_, rest)| !rest.done) {
        // A limit on memory: beyond it, renames of single elements are reported as removed and new.
        if at.len() as u64 <= MAX_ELEMENTS {
            at.extend(rest.places().unwrap_or_default().into_iter().map(|place| (place, i)));
        }
    }
    for rest in old.iter_mut().filter(|rest| !rest.done) {
        let Some(places) = rest.places() else { continue };
        let mut names: Vec<usize> = Vec::new();
        let mut all = true;
        for place in places {
            match at.get(&place).copied().filter(|&i| same_kind(new[i].leaf, rest.leaf)) {
                // The bytes have another name.
                Some(i) => {
                    new[i].matched.push(place);
                    if !names.contains(&i) {
                        names.push(i);
                    }
                }
                None => all = false,
            }
        }
        // One fact for each leaf that has some of the elements.
        for &i in &names {
            facts.push(Fact {
                old: Some(rest.leaf),
                new: Some(new[i].leaf),
                what: LeafChange::Renamed,
            });
        }
        rest.done = all;
        if let (true, Some(now)) = (all, rest.other) {
            shorter(rest.leaf, now, false, facts);
        }
    }
    // All elements of a new leaf were elsewhere before: nothing in it is new.
    for rest in new.iter_mut().filter(|rest| !rest.matched.is_empty()) {
        rest.done = rest.places().is_some_and(|places| places.len() == rest.matched.len());
    }
}

/// The most elements of a new leaf whose bytes are looked up in the old block.
const MAX_LOOKED_UP: usize = 512;

/// The old contents under the unmatched elements of a leaf; `None` if all are matched.
fn lies(rest: &Rest<'_>, old: &mut Owners<'_>, intact: bool) -> Option<FormerContents> {
    let places = match rest.places() {
        Some(mut places) => {
            let matched: FxHashSet<u64> = rest.matched.iter().copied().collect();
            places.retain(|place| !matched.contains(place));
            places
        }
        None => vec![first(rest)],
    };
    let start = places.iter().min().copied()?;
    // If all old elements are in place, a new one shares no byte with them.
    if !intact {
        for place in places.into_iter().take(MAX_LOOKED_UP) {
            // The first byte that an old leaf owns names it.
            for byte in bytes(rest.leaf, place).into_iter().flat_map(|(at, n)| at..at + n) {
                if let Some(leaf) = old.of_byte(byte) {
                    return Some(FormerContents::Reads(leaf));
                }
            }
        }
    }
    // Padding at the end of the old block lies past its data.
    let end = old.block.data_size.unwrap_or(0);
    Some(if start >= end { FormerContents::Past } else { FormerContents::Padding })
}

/// The most steps in searching the owners of bytes of one block.
const MAX_STEPS: usize = 20_000_000;

/// The owners of the old block's bytes.
struct Owners<'a> {
    block: &'a BlockLayout,
    /// The start of each member, and its index.
    starts: Vec<(u64, usize)>,
    steps: usize,
}

impl Owners<'_> {
    fn from_block(block: &BlockLayout) -> Owners<'_> {
        let starts = block.members.iter().enumerate().map(|(i, m)| (m.offset.unwrap_or(0), i));
        let mut starts: Vec<(u64, usize)> = starts.collect();
        starts.sort_unstable();
        Owners { block, starts, steps: 0 }
    }

    fn of_byte(&mut self, byte: u64) -> Option<String> {
        // The last member that starts at or before the byte.
        let before = self.starts.partition_point(|(start, _)| *start <= byte);
        let member = &self.block.members[self.starts[before.checked_sub(1)?].1];
        let is_past = byte >= member.offset? + reach(member);
        if is_past && member.dims.first() != Some(&ArrayLen::Runtime) {
            return None;
        }
        // The change is breaking anyway: beyond this effort, report the member only.
        self.steps += self.block.members.len();
        if self.steps > MAX_STEPS {
            return Some(member.name.to_string());
        }
        match owner_of_byte(self.block, byte) {
            ByteOwner::Component { leaf, .. } => Some(leaf),
            ByteOwner::Padding { .. } | ByteOwner::Beyond { .. } | ByteOwner::Loose => None,
        }
    }
}

/// The offset of the first element that the other leaf lacks.
fn first(rest: &Rest<'_>) -> u64 {
    let leaf = rest.leaf;
    let start = leaf.offset.unwrap_or(0);
    let Some(other) = rest.other else { return start };
    // The first element past the other's length in one dimension has index 0 in all others. The
    // least of these offsets is that of the first element.
    let dims = leaf.dims.iter().zip(&other.dims).zip(&leaf.strides);
    let beyond = dims
        .filter(|((a, b), _)| !covers(b, a))
        .filter_map(|((_, b), stride)| Some(start + fixed(b)? * stride));
    beyond.min().unwrap_or(start)
}
