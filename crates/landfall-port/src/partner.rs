//! The other stage of a program: locations, bindings and loose uniforms that both stages share.
//!
//! The earlier stage decides. The later one takes over the binding of everything that has the same
//! name in both, and numbers the rest after it. Loose uniforms that both declare alike go into one
//! block, declared in both, in the order of the earlier stage.

use super::interface::{self, InterfaceDeclaration};
use super::ported::{Binding, Ported};
use super::shader::Shader;
use super::uniforms::{PartnerBindings, explicit};
use super::{PortOptions, edit, stage_of};
use landfall_layout::source::{Source, Span, Stage};
use landfall_layout::{BlockLayout, Options, layout};

/// The facts about the other stage that porting a stage needs.
#[derive(Debug, Default)]
pub(super) struct Partner {
    /// Its inputs and outputs.
    pub passed: Vec<InterfaceDeclaration>,
    /// The loose uniforms that go into the shared block, in their order there.
    pub shared: Vec<String>,
    /// The binding of the shared block, if the partner is the earlier stage.
    pub block: Option<u32>,
    pub bindings: PartnerBindings,
}

impl Partner {
    /// Reads the partner of a shader of `stage`.
    pub fn new(source: &Source, options: &PortOptions, stage: Stage) -> Partner {
        let Some(partner) = &options.partner else { return Partner::default() };
        let shader = Shader::new(partner, &options.read);
        let Some(theirs) = partner.stage.or_else(|| stage_of(&shader)) else {
            return Partner::default();
        };
        let mut passed = interface::inputs_and_outputs(&shader, partner, theirs, &options.read);
        for passed in &mut passed {
            passed.span = Span::default(); // the partner's text is not among the shader's files
        }
        let written: Vec<Binding> = explicit(&shader, options.set);
        let taken = written.iter().map(|binding| binding.binding).collect();
        let bindings = PartnerBindings { by_name: written, taken, next: 0 };
        let mut read = Partner { passed, bindings, ..Partner::default() };
        // A shader beside itself, or two of one stage, share nothing.
        if partner.path == source.path || order(theirs) == order(stage) {
            return read;
        }
        let is_earlier = order(theirs) < order(stage);
        let (first, second) = if is_earlier { (partner, source) } else { (source, partner) };
        read.shared = shared(first, second, options);
        // This ends: the earlier stage does not ask for the later one's result.
        if is_earlier {
            let beside = PortOptions { partner: Some(source.clone()), ..options.clone() };
            if let Ok((ported, _)) = edit(partner, &beside) {
                read.follow(ported);
            }
        }
        read
    }

    /// Takes over the bindings of the earlier stage.
    fn follow(&mut self, earlier: Ported) {
        // What it does not share is numbered behind all of the earlier stage's bindings.
        self.bindings.next = earlier.bindings.iter().map(|b| b.binding + 1).max().unwrap_or(0);
        self.bindings.taken.extend(earlier.bindings.iter().map(|binding| binding.binding));
        let of = |name: &str| earlier.bindings.iter().find(|binding| binding.name == name);
        self.block = earlier.shared.as_deref().and_then(of).map(|binding| binding.binding);
        let own = [&earlier.block, &earlier.shared];
        self.bindings.by_name = earlier.bindings;
        self.bindings.by_name.retain(|b| own.iter().all(|own| own.as_ref() != Some(&b.name)));
    }
}

/// The place of a stage in the pipeline.
fn order(stage: Stage) -> u32 {
    match stage {
        Stage::Vertex => 0,
        Stage::TessellationControl => 1,
        Stage::TessellationEvaluation => 2,
        Stage::Geometry => 3,
        Stage::Fragment => 4,
        _ => 5,
    }
}

/// The loose uniforms that two stages lay out alike, in the order of the first.
fn shared(first: &Source, second: &Source, options: &PortOptions) -> Vec<String> {
    let gather = Options::default().with_read(options.read.clone()).with_gather(true);
    let [first, second] = [first, second].map(|source| layout(source, &gather));
    let loose = |block: &&BlockLayout| block.gathered;
    let (Some(first), Some(second)) =
        (first.blocks.iter().rfind(loose), second.blocks.iter().rfind(loose))
    else {
        return Vec::new();
    };
    // Compared member by member, as offsets in the two gathered blocks differ.
    let names = first.members.iter().map(|member| member.name.to_string());
    let alike = |name: &String| {
        let rows = member_rows(first, name);
        !rows.is_empty() && rows == member_rows(second, name)
    };
    names.filter(alike).collect()
}

/// The leaves of a member, with offsets from its first one.
fn member_rows(block: &BlockLayout, name: &str) -> Vec<String> {
    let of_member = |path: &str| path.split(['.', '[']).next() == Some(name);
    let leaves: Vec<_> = block.leaves.iter().filter(|leaf| of_member(&leaf.path)).collect();
    let start = leaves.first().and_then(|leaf| leaf.offset).unwrap_or(0);
    let row = |leaf: &&landfall_layout::Leaf| {
        let offset = leaf.offset.map(|offset| offset - start);
        format!("{} {:?} {:?} {:?} {offset:?}", leaf.path, leaf.ty, leaf.dims, leaf.strides)
    };
    leaves.iter().map(row).collect()
}
