//! `reorder-saves`: the same members in another order take fewer bytes.
//!
//! The order is searched by sizes and alignments ([`order`]), then laid out by
//! [`layout`](mod@landfall_layout::layout), whose sizes are reported.

mod order;

use std::sync::Arc;

use rustc_hash::FxHashSet;

use super::definition::{Check, Lint, Subject};
use super::settings::Settings;
use super::show::{bytes, full_listing};
use super::walk::first_few;
use landfall_layout::finding::{Finding, Level, Place};
use landfall_layout::layout::lay_out;
use landfall_layout::layout::rules::{Cursor, type_layout};
use landfall_layout::shape::{AddressSpace, Block, MatrixLayout, Member, Rules, Struct, Type};
use landfall_layout::source::Span;
use landfall_layout::syntax as parse;
use landfall_layout::text::counts::number;

pub(super) const LINT: Lint = Lint {
    code: "reorder-saves",
    // The order is often chosen for readability, and every copy has to follow a change.
    level: Level::Allow,
    what: "a block or structure that takes fewer bytes with its members in another order",
    why: "A `vec3` or a matrix after a lone scalar starts at the next multiple of 16 and leaves a \
          hole. The finding names the smallest order and the bytes it saves, per element for a \
          structure in an array. Allowed by default, because it wastes memory but is correct, and \
          every copy of the structure has to follow the change. Never reported where the shader \
          declares an offset.",
    example: "\
#version 330 core
layout(std140) uniform Light {
    float intensity; // 0
    vec3 color;      // 16
    float radius;    // 28
    vec3 position;   // 32: 48 bytes
};
void main() {}
",
    fix: "Declare the members in the order that the help gives, in every copy.",
    check: Check::Shader(check),
};

fn check(subject: &Subject<'_>, _settings: &Settings) -> Vec<Finding> {
    let options = subject.options;
    // Declarations are reordered, which are then laid out as if they were written so.
    let mut shape = parse::parse(subject.source, &options.read, options.gather).shape;
    // Loose uniforms have no layout.
    shape.blocks.retain(|block| block.space != AddressSpace::Default);
    // Where the driver chooses the layout, no offset is certain.
    shape.blocks.retain(|block| block.rules_declared || options.rules.is_some());
    if let Some(rules) = options.rules {
        shape.blocks.iter_mut().for_each(|block| block.rules = rules);
    }
    let mut findings: Vec<Finding> =
        shape.blocks.iter().filter_map(|block| of_block(subject, block)).collect();
    // Each structure that is tried lays its blocks out again.
    let structures = structures(&shape.blocks);
    let leaves = shape.blocks.iter().flat_map(|block| &block.members).map(|m| m.ty.leaves());
    let leaves = leaves.fold(0u64, u64::saturating_add);
    let tried = (MAX_LEAVES / leaves.max(1)) as usize;
    for structure in structures.into_iter().take(tried) {
        findings.extend(of_structure(subject, &structure, &shape.blocks));
    }
    // Two variables of one WGSL structure are two blocks with one declaration.
    let mut said = FxHashSet::default();
    findings.retain(|finding| said.insert(finding.about.clone()));
    findings
}

/// The most leaves laid out to try structures in another order, which bounds the time on hostile
/// texts.
const MAX_LEAVES: u64 = 200_000;

fn of_block(subject: &Subject<'_>, block: &Block) -> Option<Finding> {
    let order = order::smallest(&block.members, block.rules, block.matrix_layout)?;
    let old = lay_out(block).ok()?.size?;
    let reordered = Block { members: order::apply(&block.members, &order), ..block.clone() };
    let layout = lay_out(&reordered).ok()?;
    let new = layout.size.filter(|&new| new < old)?;
    let message = format!(
        "block `{}` is {}: in another order its members take {}",
        block.name,
        bytes(old),
        number(new)
    );
    let place = Place::new(&subject.shader.files, block.span);
    let help = advice(&reordered.members, old, new, "");
    let finding = Finding::at(LINT.code, &*block.name, place, message)
        .with_note("every copy of the block has to follow the change")
        .with_help(help);
    Some(Finding { listing: full_listing(subject.shader, &layout), ..finding })
}

/// A structure and one of the rules it is laid out by.
struct StructUse {
    structure: Arc<Struct>,
    rules: Rules,
    matrix_layout: MatrixLayout,
}

/// Returns the structures of all blocks, each once for every rule it is laid out by.
fn structures(blocks: &[Block]) -> Vec<StructUse> {
    let mut found = Vec::new();
    let mut seen = FxHashSet::default();
    for block in blocks {
        collect(&block.members, block.rules, block.matrix_layout, &mut seen, &mut found);
    }
    found
}

fn collect(
    members: &[Member],
    rules: Rules,
    inherited: MatrixLayout,
    seen: &mut FxHashSet<(Span, Rules, MatrixLayout)>,
    found: &mut Vec<StructUse>,
) {
    for member in members {
        let Type::Struct(structure) = member.ty.innermost() else { continue };
        let matrix_layout = member.matrix_layout.unwrap_or(inherited);
        if seen.insert((structure.span, rules, matrix_layout)) {
            collect(&structure.members, rules, matrix_layout, seen, found);
            found.push(StructUse { structure: structure.clone(), rules, matrix_layout });
        }
    }
}

fn of_structure(subject: &Subject<'_>, one: &StructUse, blocks: &[Block]) -> Option<Finding> {
    let structure = &one.structure;
    // A structure without a name has nowhere to be reported at.
    if structure.name.is_empty() {
        return None;
    }
    let order = order::smallest(&structure.members, one.rules, one.matrix_layout)?;
    let members = order::apply(&structure.members, &order);
    let old = stride(&structure.members, one)?;
    let new = stride(&members, one).filter(|&new| new < old)?;
    let replaced = |block: &Block| {
        let members = with_structure(&block.members, structure, &members);
        lay_out(&Block { members, ..block.clone() }).ok()?.size
    };
    let sizes: Option<Vec<(u64, u64)>> =
        blocks.iter().map(|block| Some((lay_out(block).ok()?.size?, replaced(block)?))).collect();
    // Other rules may need another order: an order that enlarges a block is not suggested.
    let sizes = sizes.filter(|sizes| sizes.iter().all(|(old, new)| new <= old))?;
    let message = format!(
        "`{}` is {}: in another order its members take {}",
        structure.name,
        bytes(old),
        number(new)
    );
    let place = Place::new(&subject.shader.files, structure.span);
    let mut finding = Finding::at(LINT.code, &*structure.name, place, message)
        .with_help(advice(&members, old, new, " each"));
    for (block, (old, new)) in blocks.iter().zip(sizes).filter(|(_, (old, new))| new < old) {
        let (old, new) = (number(old), number(new));
        finding = finding.with_note(format!("block `{}` shrinks from {old} to {new}", block.name));
    }
    Some(finding.with_note("every copy of the structure has to follow the change"))
}

fn advice(members: &[Member], old: u64, new: u64, each: &str) -> String {
    let names: Vec<String> = members.iter().map(|member| format!("`{}`", member.name)).collect();
    let names = if names.len() <= MAX_NAMES { names.join(", ") } else { first_few(&names) };
    format!(
        "declare the members in the order {names}: {} instead of {}, {} saved{each}",
        bytes(new),
        number(old),
        number(old - new)
    )
}

/// The most names that a message lists.
const MAX_NAMES: usize = 24;

/// Returns the names of a structure's members in an order that takes fewer bytes, and the stride of
/// the structure in that order; `None` if there is no such order.
pub fn smaller_order(
    structure: &Arc<Struct>,
    rules: Rules,
    matrix_layout: MatrixLayout,
) -> Option<(Vec<Arc<str>>, u64)> {
    let one = StructUse { structure: structure.clone(), rules, matrix_layout };
    let order = order::smallest(&structure.members, rules, matrix_layout)?;
    let members = order::apply(&structure.members, &order);
    let old = stride(&structure.members, &one)?;
    let new = stride(&members, &one).filter(|&new| new < old)?;
    Some((members.into_iter().map(|member| member.name).collect(), new))
}

/// Returns the bytes from one structure of those members to the next, or to the member after it.
fn stride(members: &[Member], one: &StructUse) -> Option<u64> {
    let mut cursor = Cursor::new(one.rules);
    for member in members {
        cursor.place(member, one.matrix_layout).ok()?;
    }
    let whole = cursor.structure().ok()?;
    whole.align.round_up(whole.size?).ok()
}

/// Returns the members with that structure's own members reordered, wherever it occurs.
fn with_structure(members: &[Member], structure: &Arc<Struct>, new: &[Member]) -> Vec<Member> {
    members
        .iter()
        .map(|member| Member { ty: replace(&member.ty, structure, new), ..member.clone() })
        .collect()
}

fn replace(ty: &Type, structure: &Arc<Struct>, new: &[Member]) -> Type {
    match ty {
        Type::Array { element, len } => {
            Type::Array { element: Arc::new(replace(element, structure, new)), len: len.clone() }
        }
        Type::Struct(s) => {
            let members = match s.span == structure.span && s.name == structure.name {
                true => new.to_vec(),
                false => with_structure(&s.members, structure, new),
            };
            Type::Struct(Arc::new(Struct::new(s.name.clone(), members, s.opaque.clone(), s.span)))
        }
        Type::Scalar(_)
        | Type::Atomic(_)
        | Type::Vector { .. }
        | Type::Matrix { .. }
        | Type::Address(_) => ty.clone(),
    }
}

/// Returns the size and alignment of a member for the search.
fn footprint(member: &Member, rules: Rules, inherited: MatrixLayout) -> Option<(u64, u64)> {
    let type_layout =
        type_layout(&member.ty, rules, member.matrix_layout.unwrap_or(inherited)).ok()?;
    let align = member.align.map_or(1, |written| written.value).max(type_layout.align.bytes());
    let size = type_layout.size?.max(member.size.map_or(0, |written| written.value));
    Some((size, align))
}
