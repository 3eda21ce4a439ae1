//! Facts about leaves as changes: one line for all leaves of a member that share a fate.
//!
//! Reads [`super::leaves`].

use std::collections::HashSet;

use super::leaves::{Fact, New, What};
use super::{Block, Change, Class, Kind};
use crate::layout::{BlockLayout, Leaf, MemberLayout};
use crate::shape::ArrayLen;

/// The changes that those facts are, in the order of the bytes.
pub(super) fn changes(old: Block<'_>, new: Block<'_>, facts: &[Fact<'_>]) -> Vec<Change> {
    let mut out = Out { old, new, said: HashSet::new(), changes: Vec::new() };
    let moved = Group::of(facts, old.layout, |fact| match (&fact.what, fact.old, fact.new) {
        (What::Moved, Some(a), Some(b)) => Some((a, start(b).wrapping_sub(start(a)))),
        _ => None,
    });
    let gone = Group::of(facts, old.layout, |fact| match (&fact.what, fact.old) {
        (What::Gone, Some(a)) => Some((a, 0)),
        _ => None,
    });
    let added = Group::of(facts, new.layout, |fact| match (&fact.what, fact.new) {
        (What::New(New::Past), Some(b)) => Some((b, 0)),
        (What::New(New::Padding), Some(b)) => Some((b, 1)),
        (What::New(New::Reads(_)), Some(b)) => Some((b, 2)),
        _ => None,
    });
    let renamed = Renames::of(facts, old.layout);
    for fact in facts {
        match (fact.old, fact.new) {
            (Some(a), Some(b)) => match &fact.what {
                What::Moved => out.moved(moved.whole(a), start(b).wrapping_sub(start(a))),
                What::Renamed => out.renamed(renamed.pair(a, b), a),
                what => out.both(a, b, what),
            },
            (Some(a), None) => out.gone(gone.whole(a), a),
            (None, Some(b)) => {
                if let What::New(how) = &fact.what {
                    out.added(added.whole(b), b, how);
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

/// Leaves that share a fate, so that a member can stand for all of its own.
struct Group<'a> {
    /// The leaves of the block, and for each the fate it has.
    fates: Vec<(&'a str, Option<u64>)>,
}

impl<'a> Group<'a> {
    fn of<'f>(
        facts: &[Fact<'f>],
        block: &'a BlockLayout,
        fate: impl Fn(&Fact<'f>) -> Option<(&'f Leaf, u64)>,
    ) -> Group<'a> {
        let of: rustc_hash::FxHashMap<&str, u64> = facts
            .iter()
            .filter_map(|fact| fate(fact).map(|(leaf, fate)| (leaf.path.as_str(), fate)))
            .collect();
        let leaves = block.leaves.iter().map(|leaf| leaf.path.as_str());
        Group { fates: leaves.map(|path| (path, of.get(path).copied())).collect() }
    }

    /// The shortest path that stands for a leaf and only for leaves of the same fate.
    fn whole<'p>(&self, leaf: &'p Leaf) -> &'p str {
        let fate = self.fates.iter().find(|(path, _)| *path == leaf.path).and_then(|f| f.1);
        let same = |prefix: &str| {
            let mut below = self.fates.iter().filter(|(path, _)| is_below(path, prefix));
            below.all(|(_, other)| *other == fate)
        };
        prefixes(&leaf.path).find(|prefix| same(prefix)).unwrap_or(&leaf.path)
    }
}

/// `data[]`, `data[].pos`, …
fn prefixes(path: &str) -> impl Iterator<Item = &str> {
    let dots = path.match_indices('.').map(|(at, _)| at);
    dots.chain([path.len()]).map(|end| &path[..end])
}

fn is_below(path: &str, prefix: &str) -> bool {
    path.strip_prefix(prefix).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// A path without the brackets at its end: `data` for `data[]`.
fn bare(path: &str) -> &str {
    let mut path = path;
    while let Some(less) = path.strip_suffix("[]") {
        path = less;
    }
    path
}

/// Pairs of old and new paths that are renames, the ends they share cut off.
struct Renames<'a> {
    all: Vec<(&'a str, &'a str)>,
    leaves: Vec<&'a str>,
}

impl<'a> Renames<'a> {
    fn of(facts: &[Fact<'a>], block: &'a BlockLayout) -> Renames<'a> {
        let renames = facts.iter().filter(|fact| fact.what == What::Renamed);
        let pair = |fact: &Fact<'a>| Some((fact.old?.path.as_str(), fact.new?.path.as_str()));
        Renames {
            all: renames.filter_map(pair).collect(),
            leaves: block.leaves.iter().map(|leaf| leaf.path.as_str()).collect(),
        }
    }

    /// The members that are one, if all leaves of the old one are in the new one; else the leaves.
    fn pair<'p>(&self, old: &'p Leaf, new: &'p Leaf) -> (&'p str, &'p str) {
        let (mut a, mut b) = (old.path.as_str(), new.path.as_str());
        while let (Some((rest_a, end_a)), Some((rest_b, end_b))) =
            (a.rsplit_once('.'), b.rsplit_once('.'))
        {
            // What stands above a rename that is not at the end has been renamed itself.
            if end_a != end_b || rest_a == rest_b {
                break;
            }
            (a, b) = (rest_a, rest_b);
        }
        let follows = |path: &&str| {
            let rest = &path[a.len()..];
            self.all.iter().any(|(x, y)| x == path && y.strip_prefix(b) == Some(rest))
        };
        let below = self.leaves.iter().filter(|path| is_below(path, a));
        let all = below.clone().all(follows);
        if all { (a, b) } else { (&old.path, &new.path) }
    }
}

struct Out<'a> {
    old: Block<'a>,
    new: Block<'a>,
    /// What has been said of a member for all its leaves.
    said: HashSet<(Kind, String, String)>,
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
        if self.said.insert((kind, path.to_string(), message.clone())) {
            let path = bare(path).to_string();
            self.changes.push((at, Change { kind, class, path, old, new, message }));
        }
    }

    fn moved(&mut self, path: &str, by: u64) {
        let below = self.old.layout.leaves.iter().filter(|leaf| is_below(&leaf.path, path));
        let from = below.filter_map(|leaf| leaf.offset).min().unwrap_or(0);
        let to = from.wrapping_add(by);
        let name = bare(path);
        let values = (Some(from.to_string()), Some(to.to_string()));
        let message = format!("`{name}` moved from {from} to {to}");
        self.say(from, (Kind::Moved, Class::Breaking), path, values, message);
    }

    fn gone(&mut self, path: &str, leaf: &Leaf) {
        let below = self.old.layout.leaves.iter().filter(|leaf| is_below(&leaf.path, path));
        let at = below.filter_map(|leaf| leaf.offset).min().unwrap_or(0);
        let ty = spelled(self.old, path, leaf);
        let name = bare(path);
        let message = format!("`{name}` (`{ty}` at {at}) is gone");
        self.say(at, (Kind::Removed, Class::Breaking), path, (Some(ty), None), message);
    }

    fn added(&mut self, path: &str, leaf: &Leaf, how: &New) {
        let below = self.new.layout.leaves.iter().filter(|leaf| is_below(&leaf.path, path));
        let below: Vec<&Leaf> = below.collect();
        let at = below.iter().filter_map(|leaf| leaf.offset).min().unwrap_or(0);
        let ty = spelled(self.new, path, leaf);
        let name = bare(path);
        let (kind, class, message) = match how {
            New::Past => (
                Kind::Appended,
                Class::Compatible,
                format!("`{name}` (`{ty}`) is appended at {at}"),
            ),
            New::Padding => (
                Kind::PaddingUsed,
                Class::Compatible,
                format!("`{name}` (`{ty}`) takes bytes at {at} that were padding"),
            ),
            New::Reads(other) => {
                // Said once for a structure, of the first of its leaves that does.
                if self.changes.iter().any(|(_, c)| c.kind == Kind::Inserted && c.path == name) {
                    return;
                }
                let message = format!(
                    "`{name}` (`{ty}`) is inserted at {at}, where old uploads have `{other}`"
                );
                (Kind::Inserted, Class::Breaking, message)
            }
        };
        self.say(at, (kind, class), path, (None, Some(ty)), message);
    }

    fn renamed(&mut self, (from, to): (&str, &str), leaf: &Leaf) {
        let (name, now) = (bare(from), bare(to));
        // Within one structure the last part of the path says it all.
        let short = match (from.rsplit_once('.'), to.rsplit_once('.')) {
            (Some((a, _)), Some((b, last))) if a == b => bare(last),
            _ => now,
        };
        if name == now {
            // `x` and `x[]` are other paths, but the name is the same.
            let types = [(self.old, from), (self.new, to)].map(|(block, path)| {
                let member = member(&block.layout.members, path);
                member.map(|m| m.ty.spelled(block.side.language).to_string()).unwrap_or_default()
            });
            let [was, is] = types;
            let message =
                format!("`{name}` is `{is}` now, was `{was}`: what it had stays in place");
            let values = (Some(was), Some(is));
            self.say(start(leaf), (Kind::Reshaped, Class::Cosmetic), from, values, message);
            return;
        }
        let message = format!("`{name}` is called `{short}` now, in the same place");
        let values = (Some(name.to_string()), Some(now.to_string()));
        self.say(start(leaf), (Kind::Renamed, Class::Cosmetic), from, values, message);
    }

    /// What can happen to a leaf that both have.
    fn both(&mut self, old: &Leaf, new: &Leaf, what: &What) {
        let path = old.path.as_str();
        let name = bare(path);
        let at = start(old);
        match what {
            What::Retyped => {
                let was = old.ty.spelled(self.old.side.language).to_string();
                let is = new.ty.spelled(self.new.side.language).to_string();
                let message = format!("`{name}` changed from `{was}` to `{is}`");
                let kind = (Kind::Retyped, Class::Breaking);
                self.say(at, kind, path, (Some(was), Some(is)), message);
            }
            What::Majorness => {
                let word = |rows| if rows { "rows" } else { "columns" };
                let (was, is) = (word(old.row_major), word(new.row_major));
                let message = format!("`{name}` is stored by {is}, was by {was}");
                let values = (Some(was.to_string()), Some(is.to_string()));
                self.say(at, (Kind::Majorness, Class::Breaking), path, values, message);
            }
            What::MatrixStride => {
                let (was, is) = (old.matrix_stride.unwrap_or(0), new.matrix_stride.unwrap_or(0));
                let message = format!("`{name}` changed its matrix stride from {was} to {is}");
                let values = (Some(was.to_string()), Some(is.to_string()));
                self.say(at, (Kind::MatrixStride, Class::Breaking), path, values, message);
            }
            What::Stride { dim, matters } => {
                let (was, is) = (old.strides[*dim], new.strides[*dim]);
                let owner = owner_of_dim(path, *dim);
                let name = bare(owner);
                let mut message = format!("`{name}` changed its array stride from {was} to {is}");
                let class = if *matters { Class::Breaking } else { Class::Cosmetic };
                if !matters {
                    message.push_str("; its one element stays where it is");
                }
                let values = (Some(was.to_string()), Some(is.to_string()));
                self.say(at, (Kind::ArrayStride, class), owner, values, message);
            }
            What::Longer { dim, new: how } => {
                let (was, is) = (len(&old.dims[*dim]), len(&new.dims[*dim]));
                let owner = owner_of_dim(path, *dim);
                let name = bare(owner);
                let (class, rest) = match how {
                    None => (Class::Cosmetic, "over what had names of its own".to_string()),
                    Some(New::Past) => (Class::Compatible, "the new ones at the end".to_string()),
                    Some(New::Padding) => {
                        (Class::Compatible, "the new ones in what was padding".to_string())
                    }
                    Some(New::Reads(other)) => {
                        (Class::Breaking, format!("the new ones where old uploads have `{other}`"))
                    }
                };
                let values = (Some(was.clone()), Some(is.clone()));
                let said = self.changes.iter_mut().find(|(_, c)| {
                    c.kind == Kind::Lengthened
                        && c.path == name
                        && c.old == values.0
                        && c.new == values.1
                });
                let message = format!("`{name}` grew from {was} to {is} elements, {rest}");
                match said {
                    // All leaves of a structure grow with its array: the most serious is said.
                    Some((_, change)) if change.class >= class => {}
                    Some((_, change)) => (change.class, change.message) = (class, message),
                    None => self.say(at, (Kind::Lengthened, class), owner, values, message),
                }
            }
            What::Shorter { dim, lost } => {
                let (was, is) = (len(&old.dims[*dim]), len(&new.dims[*dim]));
                let owner = owner_of_dim(path, *dim);
                let name = bare(owner);
                let class = if *lost { Class::Breaking } else { Class::Cosmetic };
                let rest = if *lost { "the last are gone" } else { "the last have other names" };
                let values = (Some(was.clone()), Some(is.clone()));
                let message = format!("`{name}` shrank from {was} to {is} elements: {rest}");
                self.say(at, (Kind::Shortened, class), owner, values, message);
            }
            // Said of whole members, or of leaves that only one side has.
            What::Moved | What::Renamed | What::Gone | What::New(_) => {}
        }
    }
}

fn len(len: &ArrayLen) -> String {
    match len {
        ArrayLen::Fixed(n) => n.to_string(),
        ArrayLen::Runtime => "any number of".to_string(),
        ArrayLen::Override(name) => format!("`{name}`"),
    }
}

/// The part of a path that a dimension belongs to: `data[]` for the first of `data[].w[]`.
fn owner_of_dim(path: &str, dim: usize) -> &str {
    let brackets = path.match_indices("[]").nth(dim);
    let mut end = brackets.map_or(path.len(), |(at, _)| at + 2);
    // All dimensions of one member are its own.
    while path[end..].starts_with("[]") {
        end += 2;
    }
    &path[..end]
}

/// The type of what a path stands for: a leaf's, or the structure's that holds it.
fn spelled(block: Block<'_>, path: &str, leaf: &Leaf) -> String {
    match member(&block.layout.members, path) {
        Some(member) => member.ty.spelled(block.side.language).to_string(),
        None => leaf.ty.spelled(block.side.language).to_string(),
    }
}

/// The member a pattern leads to.
pub(super) fn member<'a>(members: &'a [MemberLayout], path: &str) -> Option<&'a MemberLayout> {
    let (first, rest) = path.split_once('.').map_or((path, None), |(a, b)| (a, Some(b)));
    let found = members.iter().find(|member| *member.name == *bare(first))?;
    match rest {
        Some(rest) => member(&found.members, rest),
        None => Some(found),
    }
}
