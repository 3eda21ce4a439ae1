//! Constraints on the layout of WGSL uniform buffers besides the layout rules (WGSL §14.4.5).
//!
//! The language feature `uniform_buffer_standard_layout` lifts these constraints; without it the
//! shader is rejected. naga 30 always rejects it. The layout itself is the same either way.

use crate::diagnostic::Code;
use std::sync::Arc;

use rustc_hash::FxHashSet;

use super::rules;
use super::rules::{Alignment, Cursor, Placed};
use crate::diagnostic::Diagnostic;
use crate::shape::{AddressSpace, Block, MatrixLayout, Member, Rules, Struct, Type};
use crate::source::Language;

/// Returns the warnings about a block; none unless it is a WGSL block in uniform memory.
pub fn check(block: &Block) -> Vec<Diagnostic> {
    let mut diagnostics = Vec::new();
    let leaves = block.members.iter().fold(0u64, |sum, m| sum.saturating_add(m.ty.leaves()));
    let constrained = block.space == AddressSpace::Uniform && block.rules == Rules::Wgsl;
    if constrained && leaves <= super::MAX_LEAVES {
        check_members(&block.members, &mut FxHashSet::default(), &mut diagnostics);
    }
    diagnostics
}

fn check_members(
    members: &[Member],
    seen: &mut FxHashSet<*const Struct>,
    diagnostics: &mut Vec<Diagnostic>,
) {
    let mut cursor = Cursor::new(Rules::Wgsl);
    // The member before, and where it starts.
    let mut previous: Option<(&Member, u64)> = None;
    for member in members {
        // A member that is too large is rejected when it is laid out.
        let Ok(placed) = cursor.place(member, MatrixLayout::Column) else { return };
        // One cause, one finding: elements of 16 bytes start at a multiple of 16, and such a start is
        // far enough behind a structure.
        let found = check_strides(member).or_else(|| check_offset(member, placed)).or_else(|| {
            let (before, offset) = previous?;
            check_after_struct(before, offset, member, placed)
        });
        // Each structure once, by address: its members' offsets do not depend on where it is used.
        diagnostics.extend(found);
        if let Type::Struct(inner) = member.ty.innermost() {
            if seen.insert(Arc::as_ptr(inner)) {
                check_members(&inner.members, seen, diagnostics);
            }
        }
        previous = Some((member, placed.offset));
    }
}

/// Checks RequiredAlignOf: structures and arrays start at multiples of 16.
fn check_offset(member: &Member, placed: Placed) -> Option<Diagnostic> {
    let what = match member.ty {
        Type::Struct(_) => "structure",
        Type::Array { .. } => "array",
        _ => return None,
    };
    if Alignment::VEC4.divides(placed.offset) {
        return None;
    }
    let message = format!(
        "`{}` is at offset {}, but a {what} in uniform memory starts at a multiple of 16 bytes",
        member.name, placed.offset
    );
    Some(warning(member, message).with_help(format!("write `@align(16) {}: …`", member.name)))
}

/// Checks that the stride of every dimension is a multiple of 16, from the outermost inwards.
fn check_strides(member: &Member) -> Option<Diagnostic> {
    let mut ty = &member.ty;
    while let Type::Array { element, .. } = ty {
        let stride = rules::type_layout(ty, Rules::Wgsl, MatrixLayout::Column).ok()?.array_stride?;
        if !Alignment::VEC4.divides(stride) {
            let message = format!(
                "the elements of `{}` are {stride} bytes apart, but in uniform memory their \
                 distance is a multiple of 16 bytes",
                member.name
            );
            return Some(warning(member, message).with_help(stride_help(element)));
        }
        ty = element;
    }
    None
}

fn stride_help(element: &Type) -> String {
    match element {
        // A structure is as long as a multiple of its alignment: one member aligned to 16 suffices.
        Type::Struct(s) => match s.members.first() {
            Some(first) => format!("write `@align(16)` before `{}` of `{}`", first.name, s.name),
            None => format!("give `{}` a size of 16 bytes", s.name),
        },
        Type::Scalar(_) | Type::Atomic(_) | Type::Vector { .. } => format!(
            "pack them as `array<vec4<…>>`, or wrap each in `struct {{ @size(16) value: {} }}`",
            element.spelled(Language::Wgsl)
        ),
        Type::Matrix { .. } | Type::Array { .. } | Type::Address(_) => format!(
            "wrap each in `struct {{ @align(16) value: {} }}`",
            element.spelled(Language::Wgsl)
        ),
    }
}

/// Checks that the member after a structure starts no earlier than its size rounded up to 16.
fn check_after_struct(
    before: &Member,
    offset: u64,
    member: &Member,
    placed: Placed,
) -> Option<Diagnostic> {
    let Type::Struct(_) = before.ty else { return None };
    let size = rules::type_layout(&before.ty, Rules::Wgsl, MatrixLayout::Column).ok()?.size?;
    let least = Alignment::VEC4.round_up(size).ok()?;
    let distance = placed.offset.saturating_sub(offset);
    if distance >= least {
        return None;
    }
    let message = format!(
        "`{}` is {distance} bytes after the start of `{}`, but in uniform memory the member \
         after this structure starts at least {least} bytes after the structure's start",
        member.name, before.name
    );
    Some(
        warning(member, message)
            .with_label(before.span, "the structure")
            .with_help(format!("write `@align(16) {}: …`", member.name)),
    )
}

fn warning(member: &Member, message: String) -> Diagnostic {
    Diagnostic::warning(Code::UniformConstraints, member.span, message).with_note(
        "rejected unless the language feature `uniform_buffer_standard_layout` is available",
    )
}
