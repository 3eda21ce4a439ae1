//! The blocks that have no mirror, and their diagnostics.

use landfall_layout::diagnostic::Code;
use landfall_layout::diagnostic::Diagnostic;
use landfall_layout::layout::{BlockLayout, MemberLayout, measure};
use landfall_layout::shape::{AddressSpace, ArrayLen, Packing, Rules};
use landfall_layout::source::Language;

/// The largest mirror in bytes: a Rust type has at most `isize::MAX`, also on 32-bit targets.
const LARGEST_MIRROR: u64 = i32::MAX as u64;

/// The error of a block that cannot be mirrored; `None` if it can.
pub(super) fn reason(block: &BlockLayout, language: Language) -> Option<Diagnostic> {
    let name = &block.name;
    if block.space == AddressSpace::Default {
        let message = "no mirror is generated for uniforms outside blocks: they are set one by one";
        return Some(
            Diagnostic::warning(Code::NotMirrored, block.span, message)
                .with_help("lay them out as one block with `--gather`"),
        );
    }
    if let Some((member, constant)) = block.members.iter().find_map(sized_by_override) {
        let message = format!(
            "block `{name}` has no mirror: the size of `{}` depends on `{constant}`, \
             which has no value",
            member.name
        );
        let kind = match language {
            Language::Glsl | Language::SpirV => "specialisation constant",
            Language::Wgsl => "override",
        };
        return Some(
            Diagnostic::error(Code::NotMirrored, member.span, message)
                .with_help(format!("give the {kind} a value: `-O {constant}=16`")),
        );
    }
    let size = block.size.unwrap_or(0);
    if size > LARGEST_MIRROR {
        let message = format!("block `{name}` has no mirror: it is {size} bytes large");
        return Some(Diagnostic::error(Code::NotMirrored, block.span, message).with_note(format!(
            "a Rust type is at most `isize::MAX` bytes large, {LARGEST_MIRROR} on 32-bit targets"
        )));
    }
    // The Rust type of a matrix holds the padding of its last vector.
    if let (Rules::Explicit(_), Some(member)) = (block.rules, cut_matrix(&block.members, size)) {
        let message = format!(
            "block `{name}` has no mirror: another member, or the end, lies in the padding after the last \
             vector of `{}`",
            member.name
        );
        return Some(Diagnostic::error(Code::NotMirrored, member.span, message));
    }
    None
}

/// The first matrix that ends, padding of its last vector included, past the next member of its
/// structure of `whole` bytes.
fn cut_matrix(members: &[MemberLayout], whole: u64) -> Option<&MemberLayout> {
    let starts = || members.iter().filter_map(|member| member.offset);
    members.iter().find_map(|member| {
        let offset = member.offset?;
        // A module may have its members in any order.
        let next = starts().filter(|start| *start > offset).min().unwrap_or(whole);
        let padding = match (measure::matrix_vector(member), member.matrix_stride) {
            (Some(vector), Some(stride)) => stride - vector.bytes,
            _ => 0,
        };
        // The next member begins in that padding.
        if padding > 0 && member.size.is_some_and(|size| offset + size + padding > next) {
            return Some(member);
        }
        let size = measure::structure(&member.members, Rules::Explicit(Packing::Free)).data_size;
        cut_matrix(&member.members, size)
    })
}

/// The first member whose size depends on a constant without a value, and that constant's name.
fn sized_by_override(member: &MemberLayout) -> Option<(&MemberLayout, &str)> {
    let own = member.dims.iter().find_map(|len| match len {
        ArrayLen::Override(name) => Some((member, &**name)),
        ArrayLen::Fixed(_) | ArrayLen::Runtime => None,
    });
    own.or_else(|| member.members.iter().find_map(sized_by_override))
}
