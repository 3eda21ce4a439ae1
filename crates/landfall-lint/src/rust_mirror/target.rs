//! Finds the blocks, or structures in them, that a mirror copies.

use crate::definition::Subject;
use crate::settings::RustMirror;
pub use landfall_layout::layout::measure::{element_size, fixed};
use landfall_layout::layout::{BlockLayout, MemberLayout};
use landfall_layout::shape::Type;
use landfall_layout::source::Span;
use landfall_layout::text::glob;

/// The block or structure that a mirror is compared with.
pub(super) struct Target<'s, 'a> {
    pub subject: &'s Subject<'a>,
    pub block: &'s BlockLayout,
    /// The block's name, or the structure's.
    pub name: String,
    pub members: &'s [MemberLayout],
    pub span: Span,
    /// The size in bytes that the mirror needs; `None` for a header before a runtime-sized array.
    pub size: Option<u64>,
    /// The array stride, for a structure in an array.
    pub stride: Option<u64>,
}

/// Returns the targets of a mirror in all shaders, and the number of shaders searched.
pub(super) fn targets<'s, 'a>(
    subjects: &'s [Subject<'a>],
    mirror: &RustMirror,
) -> (Vec<Target<'s, 'a>>, usize) {
    let (mut found, mut shaders) = (Vec::new(), 0);
    for subject in
        subjects.iter().filter(|subject| glob::matches(&mirror.shader, &subject.shader.path))
    {
        shaders += 1;
        for block in subject.shader.blocks.iter().filter(|block| block.size.is_some()) {
            let names = [Some(&block.name), block.instance.as_ref()];
            if names.into_iter().flatten().any(|name| **name == *mirror.block) {
                found.push(of_block(subject, block));
            } else {
                of_structures(subject, block, &block.members, &mirror.block, &mut found);
            }
        }
    }
    (found, shaders)
}

fn of_block<'s, 'a>(subject: &'s Subject<'a>, block: &'s BlockLayout) -> Target<'s, 'a> {
    let endless = block.members.last().is_some_and(|last| last.size.is_none());
    // `var<storage> lights: array<Light>` is one member: the mirror is of its elements.
    if let ([only], None) = (block.members.as_slice(), &block.instance) {
        if let (Type::Struct(_), Some(stride)) = (only.ty.innermost(), only.strides.last()) {
            if only.name == block.name {
                return Target {
                    subject,
                    block,
                    name: block.name.to_string(),
                    members: &only.members,
                    span: only.span,
                    size: None,
                    stride: Some(*stride),
                };
            }
        }
    }
    Target {
        subject,
        block,
        name: block.name.to_string(),
        members: &block.members,
        span: block.span,
        size: block.size.filter(|_| !endless),
        stride: None,
    }
}

/// Returns the first use of a structure of that name as an array element, and the first outside
/// arrays.
fn of_structures<'s, 'a>(
    subject: &'s Subject<'a>,
    block: &'s BlockLayout,
    members: &'s [MemberLayout],
    name: &str,
    found: &mut Vec<Target<'s, 'a>>,
) {
    for member in members {
        let Type::Struct(structure) = member.ty.innermost() else { continue };
        if *structure.name != *name {
            of_structures(subject, block, &member.members, name, found);
            continue;
        }
        // One element alone needs no stride.
        let many = member.dims.iter().any(|len| fixed(len) != Some(1));
        found.push(Target {
            subject,
            block,
            name: name.to_string(),
            members: &member.members,
            span: structure.span,
            size: Some(element_size(member, block.rules)).filter(|_| !many),
            stride: member.strides.last().copied().filter(|_| many),
        });
    }
}
