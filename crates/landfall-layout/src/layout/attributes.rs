//! Checks of WGSL's `@align` and `@size` attributes (§11) against the types they apply to.
//!
//! Reads [`shape`](crate::shape) before layout: a block with such an error is not laid out.

use crate::diagnostic::Code;
use std::sync::Arc;

use rustc_hash::FxHashSet;

use super::rules;
use super::rules::TypeLayout;
use crate::diagnostic::Diagnostic;
use crate::shape::{Block, MatrixLayout, Member, Rules, Struct, Type};

/// Returns the errors in attributes of a block; each structure is checked once.
pub fn check(block: &Block) -> Vec<Diagnostic> {
    let mut diagnostics = Vec::new();
    check_members(&block.members, &mut FxHashSet::default(), &mut diagnostics);
    diagnostics
}

fn check_members(
    members: &[Member],
    seen: &mut FxHashSet<*const Struct>,
    diagnostics: &mut Vec<Diagnostic>,
) {
    for member in members {
        if let Type::Struct(inner) = member.ty.innermost() {
            // By address: members of one type share its structure. Without this, structures that
            // each hold two of the one before would be visited 2^depth times.
            if seen.insert(Arc::as_ptr(inner)) {
                check_members(&inner.members, seen, diagnostics);
            }
        }
        if member.align.is_none() && member.size.is_none() {
            continue;
        }
        // A type that is too large, or has too many leaves, is rejected when it is laid out.
        if member.ty.leaves() > super::MAX_LEAVES {
            continue;
        }
        if let Ok(type_layout) = rules::type_layout(&member.ty, Rules::Wgsl, MatrixLayout::Column) {
            check_align(member, type_layout, diagnostics);
            check_size(member, type_layout, diagnostics);
        }
    }
}

/// Checks `@align` (§11.1): a power of two, and a multiple of the type's own alignment.
fn check_align(member: &Member, type_layout: TypeLayout, diagnostics: &mut Vec<Diagnostic>) {
    let Some(written) = member.align else { return };
    let own = type_layout.align.bytes();
    let message = if !written.value.is_power_of_two() {
        format!("`@align({})` is not a power of two", written.value)
    // Alignments of types are powers of two as well, so one that is not less is a multiple.
    } else if written.value < own {
        format!(
            "`@align({})` is less than {own}, the alignment of `{}`",
            written.value,
            member.ty.spelled(crate::Language::Wgsl),
        )
    } else {
        return;
    };
    // 2^63 is the last power of two: past it the type's own alignment is advised.
    let fits = written.value.checked_next_power_of_two().map_or(own, |power| power.max(own));
    diagnostics.push(
        Diagnostic::error(Code::InvalidAlign, written.span, message)
            .with_label(member.span, "on this member")
            .with_help(format!("write `@align({fits})`")),
    );
}

/// Checks `@size` (§11.10): at least the size of the type, which must not be runtime-sized.
fn check_size(member: &Member, type_layout: TypeLayout, diagnostics: &mut Vec<Diagnostic>) {
    let Some(written) = member.size else { return };
    let diagnostic = match type_layout.size {
        None => Diagnostic::error(
            Code::InvalidSize,
            written.span,
            format!("`@size` cannot apply to `{}`, which is runtime-sized", member.name),
        )
        .with_help("remove `@size`"),
        Some(own) if written.value < own => Diagnostic::error(
            Code::InvalidSize,
            written.span,
            format!(
                "`@size({})` is less than {own}, the size of `{}`",
                written.value,
                member.ty.spelled(crate::Language::Wgsl),
            ),
        )
        .with_help(format!("write `@size({own})`")),
        Some(_) => return,
    };
    diagnostics.push(diagnostic.with_label(member.span, "on this member"));
}
