//! Text that several lints share: numbers of bytes, a block's listing, the place of a span.
//!
//! Reads the [model](landfall_layout::layout) and [`format`](landfall_layout::format); the lints use it.

use landfall_layout::ShaderLayout;
use landfall_layout::format as emit;
use landfall_layout::format::{EmitOptions, Format};
use landfall_layout::layout::BlockLayout;
use landfall_layout::shape::AddressSpace;
use landfall_layout::source::{Language, Span, Target};

use super::definition::Subject;
use landfall_layout::finding::Place;
pub(super) use landfall_layout::format::phrases::{bytes, counted, number, numbered};

/// The most leaves of a block that is listed with a finding about the whole block.
const MAX_LISTED: usize = 64;

/// The most leaves of a block that is listed as the evidence of a finding.
const MAX_SHOWN: usize = 500;

/// Returns the listing of one block, unless it is too long to be useful.
pub(super) fn listing(shader: &ShaderLayout, block: &BlockLayout) -> Option<String> {
    (block.leaves.len() <= MAX_LISTED).then(|| listed(shader, block))
}

/// Returns the listing of one block as the evidence of a finding.
pub(super) fn full_listing(shader: &ShaderLayout, block: &BlockLayout) -> Option<String> {
    (block.leaves.len() <= MAX_SHOWN).then(|| listed(shader, block))
}

fn listed(shader: &ShaderLayout, block: &BlockLayout) -> String {
    let text = emit::shader(&shader.of_block(block), &EmitOptions::new(Format::Listing));
    // The first line names the file; the finding's place already does.
    let body = text.split_once('\n').map_or("", |(_, rest)| rest);
    body.trim_matches('\n').to_string()
}

/// Returns the place of a span of a shader.
pub(super) fn place(subject: &Subject<'_>, span: Span) -> Place {
    Place::new(&subject.shader.files, span)
}

/// Returns whether that is the name of the block or of its instance.
pub(super) fn is_called(block: &BlockLayout, name: &str) -> bool {
    *block.name == *name || block.instance.as_deref() == Some(name)
}

/// Returns whether Vulkan accepts a GLSL text as it stands: its version, a binding on every block,
/// no loose uniforms. The text need not mention Vulkan.
pub(super) fn may_be_vulkan(subject: &Subject<'_>) -> bool {
    if subject.shader.language != Language::Glsl {
        return false;
    }
    match subject.options.read.target {
        Some(Target::Vulkan) => return true,
        Some(_) => return false,
        None => {}
    }
    let version = subject.source.text.split_once("#version").map_or("", |(_, rest)| rest);
    let number: String = version.trim_start().chars().take_while(char::is_ascii_digit).collect();
    let bound = |block: &BlockLayout| match block.space {
        AddressSpace::Uniform | AddressSpace::Storage => block.binding.is_some(),
        AddressSpace::PushConstant | AddressSpace::BufferReference | AddressSpace::ShaderRecord => {
            true
        }
        _ => false,
    };
    number.parse().is_ok_and(|number: u32| number >= 450) && subject.shader.blocks.iter().all(bound)
}
