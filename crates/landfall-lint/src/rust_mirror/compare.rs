//! Compares a Rust structure with the members of a block or structure, field by field.
//!
//! Fields and members are matched by name; a misplaced field shifts the following ones, so only the
//! first of a run is reported, with the names of the rest.

use std::rc::Rc;

use rustc_hash::{FxHashMap, FxHashSet};

use super::fit::{View, fit};
use super::rust_type::{LaidField, StructureLayout};
use crate::show::bytes;
use crate::walk::first_few;
use landfall_layout::layout::MemberLayout;
use landfall_layout::shape::Rules;
use landfall_layout::source::{Language, Span};

/// A difference, with its place on both sides.
pub(super) struct Difference {
    /// The index of the structure in the file, and of its field; `None` for the structure itself.
    pub structure: usize,
    pub field: Option<usize>,
    /// The member on the shader's side.
    pub member: Option<Span>,
    pub member_text: String,
    pub message: String,
    pub notes: Vec<String>,
    pub help: String,
}

/// The shader's side of a comparison.
pub(super) struct Against<'a> {
    pub members: &'a [MemberLayout],
    pub rules: Rules,
    pub language: Language,
    /// Members whose fields have other names: the member's, and the field's.
    pub aliases: &'a [(String, String)],
}

/// Returns every difference between a structure and those members, including nested structures.
pub(super) fn differences(laid: &Rc<StructureLayout>, against: &Against<'_>) -> Vec<Difference> {
    let mut found = Vec::new();
    let mut seen: FxHashSet<(usize, Span)> = FxHashSet::default();
    let mut waiting = vec![(laid.clone(), against.members)];
    while let Some((laid, members)) = waiting.pop() {
        let mut pairs = Vec::new();
        of_structure(&laid, members, against, &mut pairs, &mut found);
        for (inner, member) in pairs {
            let place = member.members.first().map_or(member.span, |first| first.span);
            if seen.insert((inner.index, place)) {
                waiting.push((inner, &member.members));
            }
        }
    }
    found
}

fn of_structure<'a>(
    laid: &Rc<StructureLayout>,
    members: &'a [MemberLayout],
    against: &Against<'a>,
    pairs: &mut Vec<(Rc<StructureLayout>, &'a MemberLayout)>,
    found: &mut Vec<Difference>,
) {
    let matched = matching(laid, members, against.aliases);
    let mut free = vec![true; laid.fields.len()];
    matched.iter().flatten().for_each(|&index| free[index] = false);
    // A field at the byte of a missing member may be that member under another name.
    let mut at_byte: FxHashMap<u64, usize> = FxHashMap::default();
    for (index, field) in laid.fields.iter().enumerate() {
        if free[index] && field.ty.size > 0 {
            at_byte.entry(field.offset).or_insert(index);
        }
    }
    let mut shift = Shift::default();
    for (member, field) in members.iter().zip(&matched) {
        let Some(index) = *field else {
            if !says_padding(&member.name) && member.size.is_some() {
                let there = at_byte.get(&member.offset.unwrap_or(0)).copied();
                // Already reported with the member.
                there.into_iter().for_each(|index| free[index] = false);
                found.push(missing(laid, member, there));
            }
            continue;
        };
        let field = &laid.fields[index];
        let offset = member.offset.unwrap_or(0);
        shift.follow(laid, index, offset, member, members, &matched, found);
        let view = View { member, rules: against.rules, language: against.language, dim: 0 };
        if let Err(misfit) = fit(&field.ty, view, pairs) {
            found.push(Difference {
                structure: laid.index,
                field: Some(index),
                member: Some(member.span),
                member_text: format!("`{}`", member.ty.spelled(against.language)),
                message: format!("`{}` of `{}` {}", field.name, laid.name, misfit.text),
                notes: Vec::new(),
                help: misfit.help,
            });
        }
    }
    let last = members.last();
    for (index, field) in laid.fields.iter().enumerate() {
        if free[index] && !says_padding(&field.name) && field.ty.size > 0 {
            found.push(Difference {
                structure: laid.index,
                field: Some(index),
                member: last.map(|member| member.span),
                member_text: "the shader's last member".to_string(),
                message: format!(
                    "`{}` of `{}`, {} at {}, is not a member in the shader",
                    field.name,
                    laid.name,
                    bytes(field.ty.size),
                    field.offset,
                ),
                notes: Vec::new(),
                help: format!(
                    "remove it, or name it `_{}` if it is padding",
                    field.name.trim_start_matches('_')
                ),
            });
        }
    }
}

/// Returns the field of each member: by an alias, the same name, or one that differs only in case,
/// underscores or a prefix such as `u_`.
fn matching(
    laid: &StructureLayout,
    members: &[MemberLayout],
    aliases: &[(String, String)],
) -> Vec<Option<usize>> {
    // Of two fields that fold to one name the first counts.
    let index = |key: &dyn Fn(&str) -> String| {
        let mut index: FxHashMap<String, usize> = FxHashMap::default();
        for (at, field) in laid.fields.iter().enumerate() {
            index.entry(key(&field.name)).or_insert(at);
        }
        index
    };
    let plain = |name: &str| folded(without_prefix(name));
    let (exact, close, bare) = (index(&str::to_string), index(&folded), index(&plain));
    let of_member = |member: &MemberLayout| {
        let name = &*member.name;
        if let Some((_, field)) = aliases.iter().find(|(alias, _)| *alias == *name) {
            return exact.get(field);
        }
        exact.get(name).or_else(|| close.get(&folded(name))).or_else(|| bare.get(&plain(name)))
    };
    members.iter().map(|member| of_member(member).copied()).collect()
}

fn folded(name: &str) -> String {
    name.chars().filter(|c| *c != '_').flat_map(char::to_lowercase).collect()
}

/// `u_color` and `m_color` are `color`.
fn without_prefix(name: &str) -> &str {
    match name.split_once('_') {
        Some((prefix, rest)) if prefix.len() == 1 && !rest.is_empty() => rest,
        Some(_) | None => name,
    }
}

/// Returns whether the name marks padding.
pub(super) fn says_padding(name: &str) -> bool {
    name.starts_with('_') || name.to_ascii_lowercase().starts_with("pad")
}

fn missing(laid: &StructureLayout, member: &MemberLayout, there: Option<usize>) -> Difference {
    let offset = member.offset.unwrap_or(0);
    let (message, help) = match there.map(|index| &laid.fields[index]) {
        Some(field) => (
            format!(
                "`{}` has no field `{}`; at its byte {offset} is `{}`",
                laid.name, member.name, field.name,
            ),
            format!("rename it to `{}`, or declare an alias for it", member.name),
        ),
        None => (
            format!(
                "`{}` has no field `{}`, which the shader reads at {offset}",
                laid.name, member.name
            ),
            format!("add `{}` at byte {offset}", member.name),
        ),
    };
    Difference {
        structure: laid.index,
        field: there,
        member: Some(member.span),
        member_text: format!("read at byte {offset}"),
        message,
        notes: Vec::new(),
        help,
    }
}

/// The current displacement of fields, and the finding that reports it.
#[derive(Default)]
struct Shift {
    by: i128,
    /// The index of the finding.
    finding: Option<usize>,
    followers: Vec<String>,
}

impl Shift {
    #[allow(clippy::too_many_arguments, reason = "the state of one walk over two lists")]
    fn follow(
        &mut self,
        laid: &StructureLayout,
        index: usize,
        offset: u64,
        member: &MemberLayout,
        members: &[MemberLayout],
        matched: &[Option<usize>],
        found: &mut Vec<Difference>,
    ) {
        let field = &laid.fields[index];
        let by = i128::from(field.offset) - i128::from(offset);
        if by == 0 || by != self.by {
            self.finding = None;
            self.followers.clear();
        }
        self.by = by;
        if by == 0 {
            return;
        }
        if let Some(finding) = self.finding.and_then(|at| found.get_mut(at)) {
            self.followers.push(format!("`{}`", field.name));
            let (are, land) = match self.followers.len() {
                1 => ("is", "it"),
                _ => ("are", "them"),
            };
            finding.notes = vec![format!(
                "{} {are} shifted by the same {}: fixing this field fixes {land}",
                first_few(&self.followers),
                bytes(by.unsigned_abs() as u64),
            )];
            return;
        }
        self.finding = Some(found.len());
        self.followers.clear();
        found.push(Difference {
            structure: laid.index,
            field: Some(index),
            member: Some(member.span),
            member_text: format!("read at byte {offset}"),
            message: format!(
                "`{}` is at byte {} of `{}`, the shader reads it at {offset}",
                field.name, field.offset, laid.name,
            ),
            notes: Vec::new(),
            help: mend(laid, index, offset, members, matched),
        });
    }
}

/// Returns the smallest edit that moves a field to the byte where it is read.
fn mend(
    laid: &StructureLayout,
    index: usize,
    offset: u64,
    members: &[MemberLayout],
    matched: &[Option<usize>],
) -> String {
    let field = &laid.fields[index];
    let Some(before) = index.checked_sub(1).map(|before| &laid.fields[before]) else {
        return format!("put {} before `{}`", padding(0, offset), field.name);
    };
    let end = before.offset + before.ty.size;
    if offset >= end && offset > field.offset {
        return match says_padding(&before.name) {
            true => format!("make `{}` {}", before.name, bytes(offset - before.offset)),
            false => format!("put {} before `{}`", padding(end, offset - end), field.name),
        };
    }
    // The field's offset is too large.
    if says_padding(&before.name) {
        return match offset.checked_sub(before.offset) {
            Some(0) | None => format!("remove `{}`", before.name),
            Some(left) => format!("make `{}` {}", before.name, bytes(left)),
        };
    }
    let partner = members.iter().zip(matched).find(|(_, at)| **at == Some(index - 1));
    let own = partner.and_then(|(member, _)| member.size);
    if end > offset {
        return match own {
            Some(own) if own < before.ty.size => format!(
                "make `{}` {}: `{}` follows directly in the shader",
                before.name,
                bytes(own),
                field.name
            ),
            Some(_) | None => format!("declare `{}` in the shader's order", field.name),
        };
    }
    aligned(field, offset)
}

/// Returns the help for a field that its type's alignment moves.
fn aligned(field: &LaidField, offset: u64) -> String {
    format!(
        "use a type for `{}` that is not aligned to {}: {offset} is not a multiple of it",
        field.name, field.ty.align,
    )
}

/// `` `_pad_12: [u8; 4]` ``.
pub(super) fn padding(at: u64, size: u64) -> String {
    format!("`_pad_{at}: [u8; {size}]`")
}
