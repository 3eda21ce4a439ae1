//! What happened to the bytes of a block, leaf by leaf.
//!
//! Uses [`super::elements`]; what it finds is put into words by [`super::describe`].

use rustc_hash::{FxHashMap, FxHashSet};

use super::elements::{
    MOST_ELEMENTS, bytes, common, contains, count, covers, places, same, same_kind,
};
use crate::layout::byte::{ByteOwner, owner_of_byte};
use crate::layout::measure::reach;
use crate::layout::{BlockLayout, Leaf};
use crate::shape::ArrayLen;

/// One thing that happened to a leaf.
#[derive(Debug)]
pub(super) struct Fact<'a> {
    /// As it was; `None` for a new one.
    pub old: Option<&'a Leaf>,
    /// As it is; `None` for one that is gone.
    pub new: Option<&'a Leaf>,
    pub what: What,
}

#[derive(Debug, PartialEq, Eq)]
pub(super) enum What {
    Moved,
    Retyped,
    MatrixStride,
    Majorness,
    /// Of that dimension; whether an element both have is elsewhere for it.
    Stride {
        dim: usize,
        matters: bool,
    },
    /// That dimension has more elements; `None` when other leaves stood for all of them.
    Longer {
        dim: usize,
        new: Option<New>,
    },
    /// That dimension has fewer elements; whether nothing stands for them now.
    Shorter {
        dim: usize,
        lost: bool,
    },
    Gone,
    /// Old and new leaf are one; whether the new one has more elements.
    Renamed,
    New(New),
}

/// Where a new element lies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum New {
    /// Past the last byte of the old block.
    Past,
    /// In bytes that nobody had.
    Padding,
    /// In the bytes of that old leaf.
    Reads(String),
}

/// Elements of one side that the other does not have under the same path.
struct Rest<'a> {
    leaf: &'a Leaf,
    /// The leaf of the same path on the other side.
    other: Option<&'a Leaf>,
    /// Nothing of it is left to be matched.
    done: bool,
    /// Places that are matched.
    matched: Vec<u64>,
}

impl<'a> Rest<'a> {
    fn of(leaf: &'a Leaf, other: Option<&'a Leaf>) -> Rest<'a> {
        Rest { leaf, other, done: false, matched: Vec::new() }
    }

    /// Where its elements are, if they can be counted.
    fn places(&self) -> Option<Vec<u64>> {
        count(self.leaf)?;
        Some(places(self.leaf, self.other.map(|other| other.dims.as_slice())))
    }
}

/// What happened to the leaves of a block.
pub(super) fn facts<'a>(old: &'a BlockLayout, new: &'a BlockLayout) -> Vec<Fact<'a>> {
    let at: FxHashMap<&str, &Leaf> = new.leaves.iter().map(|l| (l.path.as_str(), l)).collect();
    let was: FxHashMap<&str, &Leaf> = old.leaves.iter().map(|l| (l.path.as_str(), l)).collect();
    let mut facts = Vec::new();
    let (mut old_rest, mut new_rest) = (Vec::new(), Vec::new());
    for leaf in &old.leaves {
        match at.get(leaf.path.as_str()) {
            None => old_rest.push(Rest::of(leaf, None)),
            Some(now) => {
                of_pair(leaf, now, &mut facts);
                if !leaf.dims.iter().zip(&now.dims).all(|(a, b)| covers(b, a)) {
                    old_rest.push(Rest::of(leaf, Some(now)));
                }
            }
        }
    }
    for leaf in &new.leaves {
        match was.get(leaf.path.as_str()) {
            None => new_rest.push(Rest::of(leaf, None)),
            Some(before) if !leaf.dims.iter().zip(&before.dims).all(|(a, b)| covers(b, a)) => {
                new_rest.push(Rest::of(leaf, Some(before)));
            }
            Some(_) => {}
        }
    }
    whole_renames(&mut old_rest, &mut new_rest, &mut facts);
    single_renames(&mut old_rest, &mut new_rest, &mut facts);
    for rest in old_rest.iter().filter(|rest| !rest.done) {
        match rest.other {
            None => facts.push(Fact { old: Some(rest.leaf), new: None, what: What::Gone }),
            Some(now) => shorter(rest.leaf, now, true, &mut facts),
        }
    }
    let intact = facts.iter().all(|fact| !is_breaking(&fact.what));
    let mut owners = Owners::of(old);
    for rest in &new_rest {
        let lies = if rest.done { None } else { lies(rest, &mut owners, intact) };
        match rest.other {
            None if rest.done => {}
            None => {
                let what = What::New(lies.unwrap_or(New::Padding));
                facts.push(Fact { old: None, new: Some(rest.leaf), what });
            }
            Some(before) => longer(before, rest.leaf, lies, &mut facts),
        }
    }
    facts
}

fn is_breaking(what: &What) -> bool {
    match what {
        What::Moved | What::Retyped | What::MatrixStride | What::Majorness | What::Gone => true,
        What::Stride { matters, .. } => *matters,
        What::Shorter { lost, .. } => *lost,
        What::Longer { .. } | What::Renamed | What::New(_) => false,
    }
}

/// A leaf that both have, its elements under one path.
fn of_pair<'a>(old: &'a Leaf, new: &'a Leaf, facts: &mut Vec<Fact<'a>>) {
    let mut fact = |what| facts.push(Fact { old: Some(old), new: Some(new), what });
    let shared: Vec<Option<u64>> =
        old.dims.iter().zip(&new.dims).map(|(a, b)| common(a, b)).collect();
    if shared.contains(&Some(0)) {
        return;
    }
    if old.offset != new.offset {
        fact(What::Moved);
    }
    if old.ty != new.ty {
        fact(What::Retyped);
    } else {
        if old.row_major != new.row_major {
            fact(What::Majorness);
        }
        if old.matrix_stride != new.matrix_stride {
            fact(What::MatrixStride);
        }
    }
    for (dim, (a, b)) in old.strides.iter().zip(&new.strides).enumerate() {
        if a != b {
            fact(What::Stride { dim, matters: shared.get(dim) != Some(&Some(1)) });
        }
    }
}

fn shorter<'a>(old: &'a Leaf, new: &'a Leaf, lost: bool, facts: &mut Vec<Fact<'a>>) {
    for (dim, (a, b)) in old.dims.iter().zip(&new.dims).enumerate() {
        if !covers(b, a) {
            facts.push(Fact { old: Some(old), new: Some(new), what: What::Shorter { dim, lost } });
        }
    }
}

fn longer<'a>(old: &'a Leaf, new: &'a Leaf, lies: Option<New>, facts: &mut Vec<Fact<'a>>) {
    for (dim, (a, b)) in old.dims.iter().zip(&new.dims).enumerate() {
        // What is neither longer nor shorter has been said to be shorter.
        if !covers(a, b) && covers(b, a) {
            let what = What::Longer { dim, new: lies.clone() };
            facts.push(Fact { old: Some(old), new: Some(new), what });
        }
    }
}

/// Leaves whose elements are all those of one other leaf.
fn whole_renames<'a>(old: &mut [Rest<'a>], new: &mut [Rest<'a>], facts: &mut Vec<Fact<'a>>) {
    let mut at: FxHashMap<u64, Vec<usize>> = FxHashMap::default();
    for (i, rest) in new.iter().enumerate().filter(|(_, rest)| rest.other.is_none()) {
        at.entry(rest.leaf.offset.unwrap_or(0)).or_default().push(i);
    }
    for rest in old.iter_mut().filter(|rest| rest.other.is_none()) {
        let leaf = rest.leaf;
        let Some(here) = at.get(&leaf.offset.unwrap_or(0)) else { continue };
        let found = here.iter().copied().find(|&i| {
            // What can be counted is compared one by one where it is not simply the same.
            let uncounted = count(leaf).is_none() || count(new[i].leaf).is_none();
            !new[i].done && (same(new[i].leaf, leaf) || uncounted && contains(new[i].leaf, leaf))
        });
        if let Some(i) = found {
            (rest.done, new[i].done) = (true, true);
            facts.push(Fact { old: Some(leaf), new: Some(new[i].leaf), what: What::Renamed });
        }
    }
}

/// Elements that are one by one at the same place under another path.
fn single_renames<'a>(old: &mut [Rest<'a>], new: &mut [Rest<'a>], facts: &mut Vec<Fact<'a>>) {
    let mut at: FxHashMap<u64, usize> = FxHashMap::default();
    for (i, rest) in new.iter().enumerate().filter(|(_, rest)| !rest.done) {
        if at.len() as u64 <= MOST_ELEMENTS {
            at.extend(rest.places().unwrap_or_default().into_iter().map(|place| (place, i)));
        }
    }
    for rest in old.iter_mut().filter(|rest| !rest.done) {
        let Some(places) = rest.places() else { continue };
        let mut names: Vec<usize> = Vec::new();
        let mut all = true;
        for place in places {
            match at.get(&place).copied().filter(|&i| same_kind(new[i].leaf, rest.leaf)) {
                Some(i) => {
                    new[i].matched.push(place);
                    if !names.contains(&i) {
                        names.push(i);
                    }
                }
                None => all = false,
            }
        }
        for &i in &names {
            facts.push(Fact { old: Some(rest.leaf), new: Some(new[i].leaf), what: What::Renamed });
        }
        rest.done = all;
        if let (true, Some(now)) = (all, rest.other) {
            shorter(rest.leaf, now, false, facts);
        }
    }
    for rest in new.iter_mut().filter(|rest| !rest.matched.is_empty()) {
        rest.done = rest.places().is_some_and(|places| places.len() == rest.matched.len());
    }
}

/// Elements of a new leaf whose bytes are looked up in the old block.
const MOST_LOOKED_UP: usize = 512;

/// Where the elements of a leaf lie that nothing old stands for; `None` when there is none.
fn lies(rest: &Rest<'_>, old: &mut Owners<'_>, intact: bool) -> Option<New> {
    let places = match rest.places() {
        Some(mut places) => {
            let matched: FxHashSet<u64> = rest.matched.iter().copied().collect();
            places.retain(|place| !matched.contains(place));
            places
        }
        None => vec![first(rest)],
    };
    let start = places.iter().min().copied()?;
    // A new element beside old ones that are all in place shares no byte with them.
    if !intact {
        for place in places.into_iter().take(MOST_LOOKED_UP) {
            for byte in bytes(rest.leaf, place).into_iter().flat_map(|(at, n)| at..at + n) {
                if let Some(leaf) = old.of_byte(byte) {
                    return Some(New::Reads(leaf));
                }
            }
        }
    }
    let end = old.block.data_size.unwrap_or(0);
    Some(if start >= end { New::Past } else { New::Padding })
}

/// Steps on the way to the owners of bytes, for one block.
const MOST_STEPS: usize = 20_000_000;

/// Who had which byte of the old block.
struct Owners<'a> {
    block: &'a BlockLayout,
    /// Where each member starts, and its index.
    starts: Vec<(u64, usize)>,
    steps: usize,
}

impl Owners<'_> {
    fn of(block: &BlockLayout) -> Owners<'_> {
        let starts = block.members.iter().enumerate().map(|(i, m)| (m.offset.unwrap_or(0), i));
        let mut starts: Vec<(u64, usize)> = starts.collect();
        starts.sort_unstable();
        Owners { block, starts, steps: 0 }
    }

    fn of_byte(&mut self, byte: u64) -> Option<String> {
        let before = self.starts.partition_point(|(start, _)| *start <= byte);
        let member = &self.block.members[self.starts[before.checked_sub(1)?].1];
        let is_past = byte >= member.offset? + reach(member);
        if is_past && member.dims.first() != Some(&ArrayLen::Runtime) {
            return None;
        }
        // The block is misread whatever is found: past some effort the member's name will do.
        self.steps += self.block.members.len();
        if self.steps > MOST_STEPS {
            return Some(member.name.to_string());
        }
        match owner_of_byte(self.block, byte) {
            ByteOwner::Component { leaf, .. } => Some(leaf),
            ByteOwner::Padding { .. } | ByteOwner::Beyond { .. } | ByteOwner::Loose => None,
        }
    }
}

/// The first element that the other leaf does not have.
fn first(rest: &Rest<'_>) -> u64 {
    let leaf = rest.leaf;
    let start = leaf.offset.unwrap_or(0);
    let Some(other) = rest.other else { return start };
    let dims = leaf.dims.iter().zip(&other.dims).zip(&leaf.strides);
    let beyond = dims.filter_map(|((a, b), stride)| match b {
        ArrayLen::Fixed(n) if !covers(b, a) => Some(start + u64::from(*n) * stride),
        ArrayLen::Fixed(_) | ArrayLen::Runtime | ArrayLen::Override(_) => None,
    });
    beyond.min().unwrap_or(start)
}
