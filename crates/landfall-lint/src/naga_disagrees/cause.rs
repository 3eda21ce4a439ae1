//! The construct that naga lays out differently, found at or before the first leaf that differs.
//!
//! Each arm is a fault of naga 30.0.1, pinned by a test of [`parse::naga`](landfall_layout::syntax)
//! or of this lint; when naga fixes it, the arm is removed.

pub use landfall_layout::layout::measure::fixed;
use landfall_layout::layout::{BlockLayout, Leaf, MemberLayout, NagaPlace};
use landfall_layout::shape::{AddressSpace, Rules, Scalar, ScalarKind, Struct, Type};
use landfall_layout::source::Span;

pub(super) struct DisagreementCause {
    /// One sentence that explains the difference.
    pub text: String,
    /// The construct's span.
    pub span: Option<Span>,
    /// The label at the span.
    pub word: &'static str,
    /// A declaration that naga lays out correctly.
    pub help: &'static str,
}

/// The construct that explains the first leaf that differs.
pub(super) fn find_cause(block: &BlockLayout, leaf: &Leaf, naga: &NagaPlace) -> DisagreementCause {
    let before: Vec<&MemberLayout> = up_to(block, leaf);
    // The first construct that naga gets wrong explains the difference; some have none that is
    // known.
    if swapped(leaf, naga) {
        return DisagreementCause {
            text: "naga swaps the dimensions of an array of arrays".to_string(),
            span: Some(leaf.span),
            word: "",
            help: "declare one dimension and compute the index: `m[i * 3 + j]`",
        };
    }
    if let Some(member) = before.iter().find(|member| is_bool(&member.ty)) {
        return DisagreementCause {
            text: "naga lays out a `bool` as 1 byte; in a block it takes 4".to_string(),
            span: Some(member.span),
            word: "the `bool`",
            help: "declare a `uint` and compare it with 0",
        };
    }
    if block.space == AddressSpace::PushConstant && block.rules != Rules::Std140 {
        return DisagreementCause {
            text: format!(
                "naga lays push constants out in std140; their default is {}",
                block.rules.name()
            ),
            span: Some(block.span),
            word: "the push constants",
            help: "write `layout(push_constant, std140)`, or members that both rules put at the \
                   same byte",
        };
    }
    if let Some((structure, member)) = before.iter().find_map(|member| inner_align(&member.ty)) {
        return DisagreementCause {
            text: format!(
                "naga ignores that `@align` on a member aligns the structure `{}` around it \
                 (gfx-rs/wgpu#4377)",
                structure.name
            ),
            span: Some(member),
            word: "the `@align`",
            help: "put the same `@align` on the member that has the structure's type, and the \
                   same `@size`, or pad with members",
        };
    }
    if let Some((member, name)) = before.iter().find_map(|member| small(block.rules, member)) {
        return DisagreementCause {
            text: format!(
                "naga does not round the alignment of structure `{name}` up to 16, as std140 does"
            ),
            span: Some(member.span),
            word: "the small structure",
            help: "pad the structure with members to 16 bytes and put a `vec4` into it",
        };
    }
    DisagreementCause {
        text: "naga uses another layout".to_string(),
        span: None,
        word: "",
        help: "use a declaration that both lay out alike: `vec4`s and explicit padding",
    }
}

/// The members around a leaf, and all that precede them in the same block or structure.
fn up_to<'a>(block: &'a BlockLayout, leaf: &Leaf) -> Vec<&'a MemberLayout> {
    let mut found = Vec::new();
    let (mut members, mut rest) = (block.members.as_slice(), leaf.path.as_str());
    loop {
        let name = rest.split(['.', '[']).next().unwrap_or("");
        let Some(at) = members.iter().position(|member| &*member.name == name) else { break };
        // A member before the leaf counts as a whole, one around it only down to the leaf.
        for member in &members[..at] {
            below(member, &mut found);
        }
        found.push(&members[at]);
        members = &members[at].members;
        match rest.split_once('.') {
            Some((_, inner)) => rest = inner,
            None => break,
        }
    }
    found
}

fn below<'a>(member: &'a MemberLayout, found: &mut Vec<&'a MemberLayout>) {
    found.push(member);
    member.members.iter().for_each(|inner| below(inner, found));
}

fn swapped(leaf: &Leaf, naga: &NagaPlace) -> bool {
    leaf.dims.len() > 1 && leaf.dims.iter().map(fixed).ne(naga.dims.iter().copied())
}

fn is_bool(ty: &Type) -> bool {
    match ty.innermost() {
        Type::Scalar(Scalar { kind, .. }) | Type::Vector { scalar: Scalar { kind, .. }, .. } => {
            *kind == ScalarKind::Bool
        }
        Type::Atomic(_)
        | Type::Matrix { .. }
        | Type::Address(_)
        | Type::Struct(_)
        | Type::Array { .. } => false,
    }
}

/// A structure that has a member with `@align`, and that member's span.
fn inner_align(ty: &Type) -> Option<(&Struct, Span)> {
    let Type::Struct(structure) = ty.innermost() else { return None };
    let own = structure.members.iter().find(|member| member.align.is_some());
    match own {
        Some(member) => Some((structure, member.span)),
        None => structure.members.iter().find_map(|member| inner_align(&member.ty)),
    }
}

/// A structure that std140 aligns to 16 though none of its members is.
fn small(rules: Rules, member: &MemberLayout) -> Option<(&MemberLayout, String)> {
    let Type::Struct(structure) = member.ty.innermost() else { return None };
    let largest = member.members.iter().filter_map(|inner| inner.align).max().unwrap_or(1);
    (rules == Rules::Std140 && largest < 16).then(|| (member, structure.name.to_string()))
}
