//! Compares a Rust structure with the members of a block or structure, field by field.
//!
//! Fields and members are matched by name. What is then wrong is worded in [`plan`](super::plan).

use std::rc::Rc;

use rustc_hash::FxHashMap;

use super::fit::{MemberView, fit};
use super::library::MirrorWriter;
use super::plan::{self, MirrorEnd, MirrorStep};
use super::rust_type::{RustType, Shape, StructureLayout};
use super::suggest::suggested;
use landfall_layout::layout::MemberLayout;
use landfall_layout::shape::{AddressSpace, Rules};
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
    pub help: Option<String>,
}

/// The shader's side of a comparison.
pub(super) struct ShaderSide<'a> {
    pub members: &'a [MemberLayout],
    pub rules: Rules,
    pub space: AddressSpace,
    pub language: Language,
    /// Members whose fields have other names: the member's, and the field's.
    pub aliases: &'a [(String, String)],
    /// The size that the structure needs.
    pub end: MirrorEnd,
}

/// The differences of a structure, and how its size is mended if it alone is wrong.
pub(super) struct Compared {
    pub differences: Vec<Difference>,
    pub tail: Option<String>,
}

/// Returns every difference between a structure and those members, including nested structures.
/// All helps of one structure followed together, it has its fields where the shader reads them.
pub(super) fn compare(laid: &Rc<StructureLayout>, against: &ShaderSide<'_>) -> Compared {
    let mut comparison = Comparison { against, planned: FxHashMap::default() };
    let mut found = Vec::new();
    let tail = comparison.structure(laid, against.members, against.end, &mut found);
    Compared { differences: found, tail }
}

struct Comparison<'c, 'a> {
    against: &'c ShaderSide<'a>,
    /// The structures that were compared with the members at that place.
    planned: FxHashMap<(usize, Span), MendedStructure>,
}

/// A structure once its helps are followed.
#[derive(Clone)]
struct MendedStructure {
    size: u64,
    align: u64,
    /// Whether it has findings of its own.
    differs: bool,
    /// How its size is mended, where only that is wrong.
    tail: Option<String>,
}

impl<'a> Comparison<'_, 'a> {
    /// Compares a structure, those inside first; returns how its size is mended, if that is all.
    fn structure(
        &mut self,
        laid: &Rc<StructureLayout>,
        members: &'a [MemberLayout],
        end: MirrorEnd,
        found: &mut Vec<Difference>,
    ) -> Option<String> {
        let (matched, renamed) = partners(laid, members, self.against.aliases);
        // The findings inside follow those of the structure around them.
        let mut inner = Vec::new();
        let mut steps = Vec::with_capacity(members.len());
        for ((member, field), renamed) in members.iter().zip(&matched).zip(renamed) {
            let step = match field {
                Some(index) => self.field(laid, *index, member, renamed, &mut inner),
                // Padding may be missing, and a runtime-sized array is no field.
                None if says_padding(&member.name) || member.size.is_none() => continue,
                None => MirrorStep::missing(self.view(laid, member)),
            };
            steps.push(step);
        }
        let plan = plan::plan(laid, &steps, end);
        let differs = !plan.differences.is_empty() || !inner.is_empty();
        found.extend(plan.differences);
        found.append(&mut inner);
        // encase may refuse what is laid out correctly.
        if !differs {
            found.extend(self.refused(laid, &steps));
        }
        let tail = plan.tail.clone();
        let planned =
            MendedStructure { size: plan.size, align: plan.align, differs, tail: plan.tail };
        self.planned.insert((laid.index, place(members)), planned);
        tail
    }

    fn view(&self, laid: &StructureLayout, member: &'a MemberLayout) -> MemberView<'a> {
        let ShaderSide { rules, language, .. } = *self.against;
        MemberView { member, rules, language, dim: 0, writer: laid.writer }
    }

    /// Compares a field with its member, and the structures in it.
    fn field(
        &mut self,
        laid: &Rc<StructureLayout>,
        index: usize,
        member: &'a MemberLayout,
        renamed: bool,
        inner: &mut Vec<Difference>,
    ) -> MirrorStep<'a> {
        let field = &laid.fields[index];
        let mut pairs = Vec::new();
        let view = self.view(laid, member);
        let mut misfit = fit(&field.ty, view, &mut pairs).err();
        let mut becomes = None;
        for (structure, member) in pairs {
            let key = (structure.index, place(&member.members));
            // A structure is compared once with the same members.
            if !self.planned.contains_key(&key) {
                let end = match member.strides.last() {
                    Some(stride) => MirrorEnd::Exactly(*stride),
                    None => MirrorEnd::Free,
                };
                self.structure(&structure, &member.members, end, inner);
            }
            let Some(planned) = self.planned.get(&key) else { continue };
            becomes = resized(&field.ty, structure.index, planned);
            if let Some(found) = misfit.as_mut().filter(|found| found.element.is_some()) {
                // Its own findings say why its size is wrong.
                match (planned.differs, &planned.tail) {
                    (true, _) => misfit = None,
                    (false, Some(tail)) => found.help = in_structure(&structure.name, tail),
                    (false, None) => {}
                }
            }
        }
        if let Some(misfit) = &misfit {
            becomes = misfit.becomes.or(becomes);
        }
        MirrorStep::matched(view, index, misfit, becomes, renamed)
    }

    /// Returns what encase refuses to write to a uniform buffer: WGSL §14.4.1 restricts arrays and
    /// structures there.
    fn refused(&self, laid: &StructureLayout, steps: &[MirrorStep<'a>]) -> Vec<Difference> {
        if laid.writer != MirrorWriter::Encase || self.against.space != AddressSpace::Uniform {
            return Vec::new();
        }
        let mut found = Vec::new();
        for step in steps {
            let Some(index) = step.field else { continue };
            let field = &laid.fields[index];
            let (name, structure) = (&field.name, &laid.name);
            let mut refuse = |why: String, help: Option<String>| {
                found.push(Difference {
                    structure: laid.index,
                    field: Some(index),
                    member: Some(step.view.member.span),
                    member_text: format!("`{}`", step.view.member.ty.spelled(step.view.language)),
                    message: format!(
                        "encase refuses `{name}` of `{structure}` in a uniform buffer: {why}"
                    ),
                    notes: Vec::new(),
                    help,
                });
            };
            if let Some(stride) = short_stride(&field.ty) {
                let help = suggested(step.view).map(|fit| format!("make it `{}`", fit.text));
                refuse(format!("its array stride is {stride} bytes, no multiple of 16"), help);
            } else if field.ty.composite && !field.offset.is_multiple_of(16) {
                refuse(format!("it is at byte {}, no multiple of 16", field.offset), None);
            }
        }
        found
    }
}

/// Returns the stride of an array in a type that is no multiple of 16.
fn short_stride(ty: &RustType) -> Option<u64> {
    match &ty.shape {
        Shape::Array { element, .. } if ty.composite => match element.size.is_multiple_of(16) {
            false => Some(element.size),
            true => short_stride(element),
        },
        Shape::Array { .. } | Shape::Scalar { .. } | Shape::Struct(_) => None,
    }
}

/// Returns the size and alignment of a type once a structure in it is mended.
fn resized(ty: &RustType, index: usize, planned: &MendedStructure) -> Option<(u64, u64)> {
    match &ty.shape {
        Shape::Scalar { .. } => None,
        Shape::Struct(laid) if laid.index == index => Some((planned.size, planned.align)),
        Shape::Struct(_) => None,
        Shape::Array { element, len } => {
            let (size, align) = resized(element, index, planned)?;
            Some((size.checked_mul(*len)?, align))
        }
    }
}

/// `in `Point` make `_end` 4 bytes`, `` end `Point` with … ``.
fn in_structure(name: &str, tail: &str) -> String {
    match tail.strip_prefix("end it with ") {
        Some(padding) => format!("end `{name}` with {padding}"),
        None => format!("in `{name}` {tail}"),
    }
}

/// What identifies the declaration of members.
fn place(members: &[MemberLayout]) -> Span {
    members.first().map_or(Span { file: 0, start: 0, end: 0 }, |first| first.span)
}

/// Returns the field of each member, and whether it stands there under another name.
fn partners(
    laid: &StructureLayout,
    members: &[MemberLayout],
    aliases: &[(String, String)],
) -> (Vec<Option<usize>>, Vec<bool>) {
    let mut matched = matching(laid, members, aliases);
    let mut free = vec![true; laid.fields.len()];
    matched.iter().flatten().for_each(|&index| free[index] = false);
    // A field at the byte of a missing member may be that member under another name.
    let mut at_byte: FxHashMap<u64, usize> = FxHashMap::default();
    for (index, field) in laid.fields.iter().enumerate() {
        if free[index] && field.ty.size > 0 {
            at_byte.entry(field.offset).or_insert(index);
        }
    }
    let mut renamed = vec![false; members.len()];
    for (at, member) in members.iter().enumerate().filter(|(_, member)| member.size.is_some()) {
        if matched[at].is_some() || says_padding(&member.name) {
            continue;
        }
        let there = at_byte.get(&member.offset.unwrap_or(0)).copied();
        if let Some(index) = there.filter(|&index| free[index]) {
            free[index] = false;
            (matched[at], renamed[at]) = (Some(index), true);
        }
    }
    (matched, renamed)
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
    // From the strictest index to the loosest.
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
