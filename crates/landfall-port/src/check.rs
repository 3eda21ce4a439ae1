//! Checks of a ported shader before anybody sees it.

use super::shader::refusal;
use super::{PortOptions, Ported, edit};
use landfall_layout::source::{Source, Span};
use landfall_layout::{AddressSpace, BlockLayout, Diagnostic, Leaf, Options, Severity, layout};

/// Checks that the gathered uniforms have the layout of the original's, that both stages agree on
/// the block they share, that no loose uniform is left, and that our own parser takes the result.
pub(super) fn check(
    source: &Source,
    options: &PortOptions,
    ported: &Ported,
) -> Result<(), Vec<Diagnostic>> {
    let read = |gather| Options::default().with_read(options.read.clone()).with_gather(gather);
    // The original with its loose uniforms gathered is what an application may have laid out
    // before.
    let before = layout(source, &read(true));
    let after = layout(&ported.source, &read(false));
    let mut problems = after.diagnostics;
    problems.retain(|diagnostic| diagnostic.severity == Severity::Error);
    if problems.is_empty() {
        problems.extend(landfall_layout::syntax::syntax_error(&ported.source, &options.read));
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    // With a shared block members are divided among two blocks, and offsets start anew.
    let is_placed = ported.shared.is_none();
    let rows = |block: Option<&BlockLayout>, name: &dyn Fn(&str) -> String| {
        let leaves = block.map_or(&[][..], |block| &block.leaves);
        let row = |leaf: &Leaf| {
            let offset = leaf.offset.filter(|_| is_placed);
            format!("{} {:?} {offset:?} {:?}", name(&leaf.path), leaf.ty, leaf.strides)
        };
        leaves.iter().map(row).collect::<Vec<_>>()
    };
    let loose = before.blocks.iter().rfind(|block| block.gathered);
    let mut gathered = rows(loose, &|path| ported.new_path(path));
    let named = |name: &Option<String>| {
        after.blocks.iter().find(|block| Some(&*block.name) == name.as_deref())
    };
    let shared = named(&ported.shared);
    let mut moved = rows(named(&ported.block), &str::to_string);
    moved.extend(rows(shared, &str::to_string));
    gathered.sort();
    moved.sort();
    // A uniform outside blocks would not compile for Vulkan.
    let is_left = after.blocks.iter().any(|block| block.space == AddressSpace::Default);
    if gathered != moved || is_left {
        return Err(limit(
            "the ported shader lacks uniforms of the original, or lays them out differently",
        ));
    }
    let theirs = partners_block(source, options);
    let differs = |theirs: &BlockLayout| shared.map(places) != Some(places(theirs));
    // Whichever stage is ported first has to come to the same block.
    if theirs.as_ref().is_some_and(differs) {
        return Err(limit("the two stages lay out the block that they share differently"));
    }
    Ok(())
}

fn limit(message: &str) -> Vec<Diagnostic> {
    let problem = refusal(Span::default(), message);
    vec![problem.with_note("this is a limitation of landfall, not an error in the shader")]
}

/// The shared block as the ported partner declares it.
fn partners_block(source: &Source, options: &PortOptions) -> Option<BlockLayout> {
    let partner = options.partner.as_ref()?;
    let beside = PortOptions { partner: Some(source.clone()), ..options.clone() };
    let (ported, _) = edit(partner, &beside).ok()?;
    let name = ported.shared?;
    let read = Options::default().with_read(options.read.clone());
    layout(&ported.source, &read).blocks.into_iter().find(|block| *block.name == *name)
}

/// The places of a block's leaves.
// Names do not matter: stages of Vulkan meet at a set and binding.
fn places(block: &BlockLayout) -> Vec<String> {
    let row = |leaf: &Leaf| format!("{:?} {:?} {:?}", leaf.ty, leaf.offset, leaf.strides);
    block.leaves.iter().map(row).collect()
}
