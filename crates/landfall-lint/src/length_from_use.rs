//! `length-from-use`: arrays without a length before other members, which glslang lays out as one
//! element.

use super::definition::{Check, Lint, Subject};
use super::settings::Settings;
use super::show::{counted, place};
use landfall_layout::finding::{Finding, Level};
use landfall_layout::layout::{BlockLayout, MemberLayout};
use landfall_layout::shape::ArrayLen;

pub(super) const LINT: Lint = Lint {
    code: "length-from-use",
    level: Level::Warn,
    what: "an array without a length before other members, which compilers lay out differently",
    why: "A member `float a[];` that is not the last of a `buffer` block is as long as its largest \
          constant index asks for (GLSL 4.60 §4.1.9), and the members behind it move with that \
          index. Drivers of OpenGL place them so, and so does Landfall. glslang 12 writes SPIR-V in \
          which the array has its length, but what follows begins behind its first element: the \
          members overlap, and a buffer filled for one is read wrong by the other.",
    example: "\
#version 450
layout(local_size_x = 1) in;
layout(std430, set = 0, binding = 0) buffer Scene {
    vec3 heads[]; // 3 elements
    float weight; // at 48; glslang writes 16
};
void main() { weight = heads[2].x; }
",
    fix: "Write the number of elements between the brackets, or move the array to the end of a \
          `buffer` block.",
    check: Check::Shader(check),
};

fn check(subject: &Subject<'_>, _settings: &Settings) -> Vec<Finding> {
    if subject.shader.sized_by_use.is_empty() {
        return Vec::new();
    }
    let blocks = subject.shader.blocks.iter().filter(|block| block.size.is_some());
    blocks.filter_map(|block| first(subject, block)).collect()
}

/// Returns a finding for the first member that glslang places elsewhere.
fn first(subject: &Subject<'_>, block: &BlockLayout) -> Option<Finding> {
    let by_use = |member: &MemberLayout| subject.shader.sized_by_use.contains(&member.span);
    // The ends of the members so far, here and in glslang's SPIR-V.
    let (mut end, mut theirs) = (0_u64, 0_u64);
    let mut array = None;
    for member in &block.members {
        let (offset, align) = (member.offset?, member.align?);
        // An offset that is not the next aligned byte is written in the text.
        let explicit = offset != end.next_multiple_of(align);
        let there = if explicit { offset } else { theirs.next_multiple_of(align) };
        if let (Some(array), true) = (array, there != offset) {
            return Some(finding(subject, block, array, member, there));
        }
        let size = member.size?;
        end = offset + size;
        theirs = there + size;
        if by_use(member) {
            array = Some(member);
            // glslang places what follows as if the array had one element.
            let behind = member.strides.first()? * length(member).saturating_sub(1);
            theirs = there + size.saturating_sub(behind);
        }
    }
    None
}

fn length(member: &MemberLayout) -> u64 {
    match member.dims.first() {
        Some(ArrayLen::Fixed(length)) => (*length).into(),
        Some(ArrayLen::Runtime | ArrayLen::Override(_)) | None => 1,
    }
}

fn finding(
    subject: &Subject<'_>,
    block: &BlockLayout,
    array: &MemberLayout,
    member: &MemberLayout,
    there: u64,
) -> Finding {
    let message = format!(
        "`{}` is at byte {}, but glslang writes {there} into SPIR-V: `{}` has no length of its own",
        member.name,
        member.offset.unwrap_or(0),
        array.name
    );
    let about = format!("{}.{}", block.name, member.name);
    let elements = counted(length(array) as usize, "element");
    let taken = format!("{elements}, by its largest constant index");
    Finding::at(LINT.code, about, place(subject, member.span), message)
        .with_label(place(subject, array.span), taken)
        .with_note("glslang 12 places what follows such an array behind its first element")
        .with_help(format!("write `{}[{}]`", array.name, length(array)))
}
