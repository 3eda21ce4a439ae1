//! What several lints say or show alike: numbers of bytes, a block's listing, where a span is.
//!
//! Reads the [model](landfall_layout::layout) and [`format`](landfall_layout::format); the lints use it.

use landfall_layout::ShaderLayout;
use landfall_layout::format as emit;
use landfall_layout::format::{EmitOptions, Format};
use landfall_layout::layout::BlockLayout;
use landfall_layout::shape::AddressSpace;
use landfall_layout::source::{Files, Language, Span, Target};

use super::definition::Subject;
use landfall_layout::finding::Place;
pub(super) use landfall_layout::format::words::{bytes, counted};

/// A block of more leaves is not listed with a finding about all of it.
const MOST_LISTED: usize = 64;

/// The same of a finding for which the listing is the evidence.
const MOST_SHOWN: usize = 500;

/// The listing of one block, if it is short enough to be read.
pub(super) fn listing(shader: &ShaderLayout, block: &BlockLayout) -> Option<String> {
    (block.leaves.len() <= MOST_LISTED).then(|| listed(shader, block))
}

/// The listing of one block, for a finding for which it is the evidence.
pub(super) fn full_listing(shader: &ShaderLayout, block: &BlockLayout) -> Option<String> {
    (block.leaves.len() <= MOST_SHOWN).then(|| listed(shader, block))
}

fn listed(shader: &ShaderLayout, block: &BlockLayout) -> String {
    let one = ShaderLayout {
        path: String::new(),
        blocks: vec![block.clone()],
        overrides: Vec::new(),
        files: Files::default(),
        diagnostics: Vec::new(),
        assumed_target: None,
        ..*shader
    };
    let text = emit::shader(&one, &EmitOptions::new(Format::Listing));
    // The first line names the file; the finding's place already does.
    let body = text.split_once('\n').map_or("", |(_, rest)| rest);
    body.trim_matches('\n').to_string()
}

/// Where a span of a shader is.
pub(super) fn place(subject: &Subject<'_>, span: Span) -> Place {
    Place::of(&subject.shader.files, span)
}

/// Whether that is what the block, or its instance, is called.
pub(super) fn is_called(block: &BlockLayout, name: &str) -> bool {
    *block.name == *name || block.instance.as_deref() == Some(name)
}

/// Whether a GLSL text would do for Vulkan as it stands: its version, a binding on every block,
/// no loose uniforms. Nothing in it need say that it is Vulkan's.
pub(super) fn may_be_vulkan(subject: &Subject<'_>) -> bool {
    if subject.shader.language != Language::Glsl {
        return false;
    }
    match subject.options.read.target {
        Some(Target::Vulkan) => return true,
        Some(Target::OpenGl) => return false,
        None => {}
    }
    let version = subject.source.text.split_once("#version").map_or("", |(_, rest)| rest);
    let number: String = version.trim_start().chars().take_while(char::is_ascii_digit).collect();
    let bound = |block: &BlockLayout| match block.space {
        AddressSpace::Uniform | AddressSpace::Storage => block.binding.is_some(),
        AddressSpace::PushConstant | AddressSpace::BufferReference | AddressSpace::ShaderRecord => {
            true
        }
        AddressSpace::Default => false,
    };
    number.parse().is_ok_and(|number: u32| number >= 450) && subject.shader.blocks.iter().all(bound)
}
