//! Turns facts about leaves into changes: one for all leaves of a member with the same facts.
//!
//! Reads [`super::leaves`].

use rustc_hash::{FxHashMap, FxHashSet};

use super::leaves::{Fact, FormerContents, LeafChange};
use super::{Change, Class, Kind, SidedBlock};
use crate::layout::{BlockLayout, Leaf, MemberLayout};
use crate::shape::ArrayLen;
use crate::text::counts::number;

/// The changes that describe `facts`, by offset.
pub(super) fn changes(old: SidedBlock<'_>, new: SidedBlock<'_>, facts: &[Fact<'_>]) -> Vec<Change> {
    if facts.is_empty() {
        return Vec::new();
    }
    let mut out = Out {
        old,
        new,
        old_members: by_path(old.layout),
        new_members: by_path(new.layout),
        reported: FxHashMap::default(),
        changes: Vec::new(),
    };
    // What happened to a leaf, as a number: leaves of a member with the same one are told together.
    // A move is the difference of offsets modulo 2^64.
    let moved =
        MemberGroup::new(facts, old.layout, |fact| match (&fact.what, fact.old, fact.new) {
            (LeafChange::Moved, Some(a), Some(b)) => Some((a, start(b).wrapping_sub(start(a)))),
            _ => None,
        });
    let gone = MemberGroup::new(facts, old.layout, |fact| match (&fact.what, fact.old) {
        (LeafChange::Gone, Some(a)) => Some((a, 0)),
        _ => None,
    });
    let added = MemberGroup::new(facts, new.layout, |fact| match (&fact.what, fact.new) {
        (LeafChange::New(FormerContents::Past), Some(b)) => Some((b, 0)),
        (LeafChange::New(FormerContents::Padding), Some(b)) => Some((b, 1)),
        (LeafChange::New(FormerContents::Reads(_)), Some(b)) => Some((b, 2)),
        _ => None,
    });
    let mut renamed = RenamedPaths::new(facts, old.layout);
    for fact in facts {
        match (fact.old, fact.new) {
            (Some(a), Some(b)) => match &fact.what {
                LeafChange::Moved => out.moved(moved.whole(a), start(b).wrapping_sub(start(a))),
                LeafChange::Renamed => out.renamed(renamed.pair(a, b), a),
                what => out.both(a, b, what),
            },
            (Some(a), None) => out.gone(gone.whole(a)),
            (None, Some(b)) => {
                if let LeafChange::New(how) = &fact.what {
                    out.added(added.whole(b), how);
                }
            }
            (None, None) => {}
        }
    }
    out.changes.sort_by_key(|(at, _)| *at);
    out.changes.into_iter().map(|(_, change)| change).collect()
}

fn start(leaf: &Leaf) -> u64 {
    leaf.offset.unwrap_or(0)
}

/// The members all of whose leaves have the same facts.
struct MemberGroup<'a> {
    /// The facts of all leaves below a path, hashed; `None` where they differ.
    below: FxHashMap<&'a str, Option<u64>>,
}

impl<'a> MemberGroup<'a> {
    fn new<'f>(
        facts: &[Fact<'f>],
        block: &'a BlockLayout,
        fate: impl Fn(&Fact<'f>) -> Option<(&'f Leaf, u64)>,
    ) -> MemberGroup<'a> {
        let of: FxHashMap<&str, u64> = facts
            .iter()
            .filter_map(|fact| fate(fact).map(|(leaf, fate)| (leaf.path.as_str(), fate)))
            .collect();
        let mut below = FxHashMap::default();
        if of.is_empty() {
            return MemberGroup { below };
        }
        // The fate of all leaves below each prefix: the first leaf's, until another one differs. A
        // leaf without a fact has none, and so do all members around it.
        for leaf in &block.leaves {
            let fate = of.get(leaf.path.as_str()).copied();
            for prefix in prefixes(&leaf.path) {
                let shared = below.entry(prefix).or_insert(fate);
                if *shared != fate {
                    *shared = None;
                }
            }
        }
        MemberGroup { below }
    }

    /// The shortest prefix of a leaf's path whose leaves all have the same facts.
    fn whole<'p>(&self, leaf: &'p Leaf) -> &'p str {
        let same = |prefix: &&str| self.below.get(prefix).is_some_and(Option::is_some);
        prefixes(&leaf.path).find(same).unwrap_or(&leaf.path)
    }
}

/// The prefixes of a path that are members: `data[]`, `data[].pos`, …
fn prefixes(path: &str) -> impl Iterator<Item = &str> {
    let dots = path.match_indices('.').map(|(at, _)| at);
    dots.chain([path.len()]).map(|end| &path[..end])
}

fn is_below(path: &str, prefix: &str) -> bool {
    path.strip_prefix(prefix).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// A path without trailing brackets: `data` for `data[]`.
fn without_brackets(path: &str) -> &str {
    let mut path = path;
    while let Some(less) = path.strip_suffix("[]") {
        path = less;
    }
    path
}

/// Renames as pairs of old and new paths, without their common ends.
struct RenamedPaths<'a> {
    all: FxHashSet<(&'a str, &'a str)>,
    leaves: &'a [Leaf],
    at: FxHashMap<&'a str, usize>,
    /// Whether a pair of members is renamed as a whole, cached.
    known: FxHashMap<(String, String), bool>,
}

impl<'a> RenamedPaths<'a> {
    // All leaves of a renamed member have been renamed, each with the same change of its path.
    fn new(facts: &[Fact<'a>], block: &'a BlockLayout) -> RenamedPaths<'a> {
        let renames = facts.iter().filter(|fact| fact.what == LeafChange::Renamed);
        let pair = |fact: &Fact<'a>| Some((fact.old?.path.as_str(), fact.new?.path.as_str()));
        let all: FxHashSet<_> = renames.filter_map(pair).collect();
        let leaves = if all.is_empty() { &[] } else { block.leaves.as_slice() };
        let at = leaves.iter().enumerate().map(|(i, leaf)| (leaf.path.as_str(), i)).collect();
        RenamedPaths { all, leaves, at, known: FxHashMap::default() }
    }

    /// The renamed members, if all leaves of the old one are in the new one; else the leaves.
    fn pair<'p>(&mut self, old: &'p Leaf, new: &'p Leaf) -> (&'p str, &'p str) {
        let (mut a, mut b) = (old.path.as_str(), new.path.as_str());
        // Equal last names are dropped while what is left differs: `a.b.c` to `a.x.c` is `a.b` to
        // `a.x`.
        while let (Some((rest_a, end_a)), Some((rest_b, end_b))) =
            (a.rsplit_once('.'), b.rsplit_once('.'))
        {
            // A rename above the last name is a rename of the enclosing member.
            if end_a != end_b || rest_a == rest_b {
                break;
            }
            (a, b) = (rest_a, rest_b);
        }
        let key = (a.to_string(), b.to_string());
        let whole = match self.known.get(&key) {
            Some(whole) => *whole,
            None => {
                let whole = self.is_whole(old, a, b);
                self.known.insert(key, whole);
                whole
            }
        };
        if whole { (a, b) } else { (&old.path, &new.path) }
    }

    fn is_whole(&self, leaf: &Leaf, a: &str, b: &str) -> bool {
        // The leaves of a member are contiguous.
        // Both ways from the leaf, so that a block with many renames is not searched as a whole.
        let at = self.at.get(leaf.path.as_str()).copied().unwrap_or(0);
        let is_below = |leaf: &&Leaf| is_below(&leaf.path, a);
        let before = self.leaves[..at].iter().rev().take_while(is_below);
        let mut below = before.chain(self.leaves[at..].iter().take_while(is_below));
        below.all(|leaf| {
            let new = format!("{b}{}", &leaf.path[a.len()..]);
            self.all.contains(&(leaf.path.as_str(), new.as_str()))
        })
    }
}

/// Every member of a block by its path pattern, with its offset.
fn by_path(block: &BlockLayout) -> FxHashMap<String, (&MemberLayout, u64)> {
    fn collect<'a>(
        members: &'a [MemberLayout],
        (parent, base): (&str, u64),
        found: &mut FxHashMap<String, (&'a MemberLayout, u64)>,
    ) {
        for member in members {
            let path = format!("{parent}{}{}", member.name, "[]".repeat(member.dims.len()));
            let at = base + member.offset.unwrap_or(0);
            collect(&member.members, (&format!("{path}."), at), found);
            found.insert(path, (member, at));
        }
    }
    let mut found = FxHashMap::default();
    collect(&block.members, ("", 0), &mut found);
    found
}

struct Out<'a> {
    old: SidedBlock<'a>,
    new: SidedBlock<'a>,
    old_members: FxHashMap<String, (&'a MemberLayout, u64)>,
    new_members: FxHashMap<String, (&'a MemberLayout, u64)>,
    /// The index of the change already reported for a member, by kind and path.
    reported: FxHashMap<(Kind, String), usize>,
    changes: Vec<(u64, Change)>,
}

impl Out<'_> {
    fn say(
        &mut self,
        at: u64,
        (kind, class): (Kind, Class),
        path: &str,
        (old, new): (Option<String>, Option<String>),
        message: String,
    ) {
        // Leaves of a member give the same text: told once. NUL separates what may hold any other
        // text.
        let key = format!("{path}\0{old:?}\0{new:?}");
        match self.reported.get(&(kind, key.clone())) {
            // The leaves of one member may differ in class: keep the most serious.
            Some(&known) if self.changes[known].1.class < class => {
                let change = &mut self.changes[known].1;
                (change.class, change.message) = (class, message);
            }
            Some(_) => {}
            None => {
                self.reported.insert((kind, key), self.changes.len());
                let path = without_brackets(path).to_string();
                self.changes.push((at, Change { kind, class, path, old, new, message }));
            }
        }
    }

    fn moved(&mut self, path: &str, by: u64) {
        let from = self.old_members.get(path).map_or(0, |(_, at)| *at);
        let to = from.wrapping_add(by);
        let name = without_brackets(path);
        let values = (Some(from.to_string()), Some(to.to_string()));
        let message = format!("`{name}` moved from {from} to {to}");
        self.say(from, (Kind::Moved, Class::Breaking), path, values, message);
    }

    fn gone(&mut self, path: &str) {
        let at = self.old_members.get(path).map_or(0, |(_, at)| *at);
        let ty = spelled(&self.old_members, self.old, path);
        let name = without_brackets(path);
        let message = format!("`{name}` (`{ty}` at {at}) was removed");
        self.say(at, (Kind::Removed, Class::Breaking), path, (Some(ty), None), message);
    }

    fn added(&mut self, path: &str, how: &FormerContents) {
        let at = self.new_members.get(path).map_or(0, |(_, at)| *at);
        let ty = spelled(&self.new_members, self.new, path);
        let name = without_brackets(path);
        let (kind, class, message) = match how {
            FormerContents::Past => (
                Kind::Appended,
                Class::Compatible,
                format!("`{name}` (`{ty}`) is appended at {at}"),
            ),
            FormerContents::Padding => (
                Kind::PaddingUsed,
                Class::Compatible,
                format!("`{name}` (`{ty}`) uses former padding at {at}"),
            ),
            FormerContents::Reads(other) => {
                let message = format!(
                    "`{name}` (`{ty}`) is inserted at {at}, where old uploads have `{other}`"
                );
                (Kind::Inserted, Class::Breaking, message)
            }
        };
        self.say(at, (kind, class), path, (None, Some(ty)), message);
    }

    fn renamed(&mut self, (from, to): (&str, &str), leaf: &Leaf) {
        let (name, now) = (without_brackets(from), without_brackets(to));
        // Within one structure the last name suffices.
        let short = match (from.rsplit_once('.'), to.rsplit_once('.')) {
            (Some((a, _)), Some((b, last))) if a == b => without_brackets(last),
            _ => now,
        };
        if name == now {
            // `x` and `x[]` differ in path, but not in name.
            let was = spelled(&self.old_members, self.old, from);
            let is = spelled(&self.new_members, self.new, to);
            let message =
                format!("`{name}` is now `{is}`, was `{was}`: its elements stay in place");
            let values = (Some(was), Some(is));
            self.say(start(leaf), (Kind::Reshaped, Class::Cosmetic), from, values, message);
            return;
        }
        let message = format!("`{name}` was renamed to `{short}`, in the same place");
        let values = (Some(name.to_string()), Some(now.to_string()));
        self.say(start(leaf), (Kind::Renamed, Class::Cosmetic), from, values, message);
    }

    /// Adds the change of a leaf that both sides have.
    fn both(&mut self, old: &Leaf, new: &Leaf, what: &LeafChange) {
        let path = old.path.as_str();
        let name = without_brackets(path);
        let at = start(old);
        match what {
            LeafChange::Retyped => {
                let was = old.ty.spelled(self.old.side.language).to_string();
                let is = new.ty.spelled(self.new.side.language).to_string();
                let message = format!("`{name}` changed from `{was}` to `{is}`");
                let kind = (Kind::Retyped, Class::Breaking);
                self.say(at, kind, path, (Some(was), Some(is)), message);
            }
            LeafChange::MatrixLayout => {
                let word = |rows| if rows { "rows" } else { "columns" };
                let (was, is) = (word(old.row_major), word(new.row_major));
                let message = format!("`{name}` is stored by {is}, was by {was}");
                let values = (Some(was.to_string()), Some(is.to_string()));
                self.say(at, (Kind::MatrixLayout, Class::Breaking), path, values, message);
            }
            LeafChange::MatrixStride => {
                let (was, is) = (old.matrix_stride.unwrap_or(0), new.matrix_stride.unwrap_or(0));
                let message = format!("`{name}` changed its matrix stride from {was} to {is}");
                let values = (Some(was.to_string()), Some(is.to_string()));
                self.say(at, (Kind::MatrixStride, Class::Breaking), path, values, message);
            }
            LeafChange::Stride { dim, matters } => {
                let (was, is) = (old.strides[*dim], new.strides[*dim]);
                let owner = owner_of_dim(path, *dim);
                let name = without_brackets(owner);
                let mut message = format!("`{name}` changed its array stride from {was} to {is}");
                let class = if *matters { Class::Breaking } else { Class::Cosmetic };
                if !matters {
                    message.push_str("; its one element stays where it is");
                }
                let values = (Some(was.to_string()), Some(is.to_string()));
                self.say(at, (Kind::ArrayStride, class), owner, values, message);
            }
            LeafChange::Longer { dim, new: how } => {
                let (was, is) = (len(&old.dims[*dim]), len(&new.dims[*dim]));
                let owner = owner_of_dim(path, *dim);
                let name = without_brackets(owner);
                let (class, rest) = match how {
                    None => (Class::Cosmetic, "over former separate members".to_string()),
                    Some(FormerContents::Past) => {
                        (Class::Compatible, "the new ones at the end".to_string())
                    }
                    Some(FormerContents::Padding) => {
                        (Class::Compatible, "the new ones in former padding".to_string())
                    }
                    Some(FormerContents::Reads(other)) => {
                        (Class::Breaking, format!("the new ones where old uploads have `{other}`"))
                    }
                };
                let values = (Some(was.clone()), Some(is.clone()));
                let (was, is) = (counted(&old.dims[*dim]), counted(&new.dims[*dim]));
                let message = format!("`{name}` grew from {was} to {is} elements, {rest}");
                self.say(at, (Kind::Lengthened, class), owner, values, message);
            }
            LeafChange::Shorter { dim, lost } => {
                let (was, is) = (len(&old.dims[*dim]), len(&new.dims[*dim]));
                let owner = owner_of_dim(path, *dim);
                let name = without_brackets(owner);
                let class = if *lost { Class::Breaking } else { Class::Cosmetic };
                let rest = if *lost { "the last were removed" } else { "the last were renamed" };
                let values = (Some(was.clone()), Some(is.clone()));
                let (was, is) = (counted(&old.dims[*dim]), counted(&new.dims[*dim]));
                let message = format!("`{name}` shrank from {was} to {is} elements: {rest}");
                self.say(at, (Kind::Shortened, class), owner, values, message);
            }
            // Reported for whole members, or for leaves of one side only.
            LeafChange::Moved | LeafChange::Renamed | LeafChange::Gone | LeafChange::New(_) => {}
        }
    }
}

fn len(len: &ArrayLen) -> String {
    match len {
        ArrayLen::Fixed(n) => n.to_string(),
        _ => counted(len),
    }
}

/// A length in a sentence.
fn counted(len: &ArrayLen) -> String {
    match len {
        ArrayLen::Fixed(n) => number(u64::from(*n)),
        ArrayLen::Runtime => "any number of".to_string(),
        ArrayLen::Override(name) => format!("`{name}`"),
    }
}

/// The member that array dimension `dim` belongs to: `data[]` for the first of `data[].w[]`.
fn owner_of_dim(path: &str, dim: usize) -> &str {
    // A path has one `[]` for each dimension.
    let brackets = path.match_indices("[]").nth(dim);
    let mut end = brackets.map_or(path.len(), |(at, _)| at + 2);
    // Include all dimensions of the member.
    while path[end..].starts_with("[]") {
        end += 2;
    }
    &path[..end]
}

/// The spelled type of the member at a path.
fn spelled(
    members: &FxHashMap<String, (&MemberLayout, u64)>,
    block: SidedBlock<'_>,
    path: &str,
) -> String {
    let member = members.get(path).map(|(member, _)| *member);
    member.map(|member| member.ty.spelled(block.side.language).to_string()).unwrap_or_default()
}
