//! The changes between two layouts, and whether bytes uploaded for the old one still land where
//! the new shader reads them.
//!
//! [`diff`] is a pure function from [`BlockLayout`]s to [`Change`]s. `pair` matches blocks,
//! `leaves` compares bytes, `describe` groups its facts into one line per change, `block`
//! compares the rest. Input comes from shaders and [`locks`](crate::lock); output goes to
//! [`format`](mod@crate::format) and the lint `layout-drift`. `policy` has the changes that a
//! project may forbid, `variants` compares a shader under each set of macros.
//!
//! The classes follow from the bytes alone. Every array element of the old block has a path, an
//! offset and a type (with matrix stride and majorness). It is *in place* if the new block has
//! the same type at the same offset under the same path, or under a path new to it while the old
//! path is gone: then it is renamed. An old element that is not in place makes the change
//! breaking. A new element without an old counterpart is compatible if it lies in former padding
//! or past the end.

mod block;
mod default_uniforms;
mod describe;
mod elements;
mod leaves;
mod pair;
mod policy;
mod variants;

use std::borrow::Cow;

use crate::layout::BlockLayout;
use crate::shape::{AddressSpace, ScalarKind, Type};
use crate::source::Language;

pub use policy::Policy;
pub use variants::{VariantDiff, diff_variants};

/// The effect of a change on bytes uploaded for the old layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// No byte changes.
    Cosmetic,
    /// Old uploads are still read correctly; a buffer may be too small.
    Compatible,
    /// Bytes uploaded for the old layout are misread.
    Breaking,
}

impl Class {
    /// The name in JSON: `cosmetic`, `compatible` or `breaking`.
    pub fn name(self) -> &'static str {
        match self {
            Class::Cosmetic => "cosmetic",
            Class::Compatible => "compatible",
            Class::Breaking => "breaking",
        }
    }
}

/// The kind of a change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs)]
#[non_exhaustive]
pub enum Kind {
    Moved,
    Retyped,
    Renamed,
    /// The array dimensions changed over the same elements.
    Reshaped,
    Appended,
    Inserted,
    PaddingUsed,
    Removed,
    /// An array has more elements.
    Lengthened,
    /// An array has fewer elements.
    Shortened,
    ArrayStride,
    MatrixStride,
    #[serde(rename = "majorness")]
    MatrixLayout,
    /// The block is larger.
    Grew,
    /// The block is smaller.
    Shrank,
    Rules,
    RulesDeclared,
    AddressSpace,
    Slot,
    Count,
    Instance,
    StructureRenamed,
    Alignment,
    Order,
    BlockAdded,
    BlockRemoved,
    BlockRenamed,
}

/// One change.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// The kind of change.
    pub kind: Kind,
    /// The effect on bytes uploaded for the old layout.
    pub class: Class,
    /// The path pattern of the member, in the old block, or in the new one if only that has it:
    /// `data[].color`; empty for the block.
    pub path: String,
    /// The old value: a number, a type, a name.
    pub old: Option<String>,
    /// The new value.
    pub new: Option<String>,
    /// The description, in one lower-case sentence with names in backticks.
    pub message: String,
}

/// The changes of one block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlockDiff {
    /// The index among the old blocks; `None` if it is new.
    pub old: Option<usize>,
    /// The index among the new blocks; `None` if it was removed.
    pub new: Option<usize>,
    /// The block's name in messages; `(loose uniforms)` for those.
    pub name: String,
    /// At least one change, the most serious first, those of a class in the order of the block.
    pub changes: Vec<Change>,
}

impl BlockDiff {
    /// The class of the most serious change.
    pub fn class(&self) -> Class {
        self.changes.iter().map(|change| change.class).max().unwrap_or(Class::Cosmetic)
    }
}

/// The blocks of one side, and the language that spells their types.
#[derive(Clone, Copy, Debug)]
pub struct Side<'a> {
    /// The blocks.
    pub blocks: &'a [BlockLayout],
    /// The language of the shader.
    pub language: Language,
}

impl<'a> Side<'a> {
    /// The blocks of a shader.
    pub fn from_shader(shader: &'a crate::ShaderLayout) -> Side<'a> {
        Side { blocks: &shader.blocks, language: shader.language }
    }
}

/// Compares two sides. Returns the changed blocks in the new side's order, then the removed ones;
/// unchanged blocks are left out.
pub fn diff(old: Side<'_>, new: Side<'_>) -> Vec<BlockDiff> {
    let mut found = Vec::new();
    // Blocks that only one side has have no partner.
    for (before, after) in pair::pairs(old.blocks, new.blocks) {
        let (a, b) = (before.map(|i| &old.blocks[i]), after.map(|i| &new.blocks[i]));
        let mut changes = match (a, b) {
            (Some(a), Some(b)) => {
                both(SidedBlock { layout: a, side: old }, SidedBlock { layout: b, side: new })
            }
            (Some(a), None) => vec![block::removed(a)],
            (None, Some(b)) => vec![block::added(b)],
            (None, None) => Vec::new(),
        };
        if changes.is_empty() {
            continue;
        }
        // A stable sort keeps the changes of a class in the order of the block.
        changes.sort_by_key(|change| std::cmp::Reverse(change.class));
        let name = b.or(a).map(shown_name).unwrap_or_default();
        found.push(BlockDiff { old: before, new: after, name, changes });
    }
    found
}

/// The class of the most serious change; `None` if nothing changed.
pub fn verdict(blocks: &[BlockDiff]) -> Option<Class> {
    blocks.iter().map(BlockDiff::class).max()
}

/// A block and its side.
#[derive(Clone, Copy)]
struct SidedBlock<'a> {
    layout: &'a BlockLayout,
    side: Side<'a>,
}

fn both(old: SidedBlock<'_>, new: SidedBlock<'_>) -> Vec<Change> {
    let loose = |block: SidedBlock<'_>| block.layout.space == AddressSpace::Default;
    match (loose(old), loose(new)) {
        (true, true) => default_uniforms::changes(old, new),
        (false, false) => {
            let (a, b) = (spelled_as(new, old), spelled_as(old, new));
            let facts = leaves::facts(&a, &b);
            let mut changes = describe::changes(old, new, &facts);
            block::changes(old, new, &mut changes);
            changes
        }
        // The bytes of a block and uniforms that are set one by one have nothing to compare.
        (true, false) | (false, true) => vec![block::space(old.layout, new.layout)],
    }
}

/// A block as it is compared with another: beside a module with a `uint` for each `bool`, which
/// compilers write so.
fn spelled_as<'a>(other: SidedBlock<'_>, block: SidedBlock<'a>) -> Cow<'a, BlockLayout> {
    if other.side.language != Language::SpirV {
        return Cow::Borrowed(block.layout);
    }
    let mut layout = block.layout.clone();
    for leaf in &mut layout.leaves {
        if let Type::Scalar(scalar) | Type::Vector { scalar, .. } = &mut leaf.ty {
            if scalar.kind == ScalarKind::Bool {
                scalar.kind = ScalarKind::Uint;
            }
        }
    }
    Cow::Owned(layout)
}

/// The name of a block in messages.
fn shown_name(block: &BlockLayout) -> String {
    if block.space == AddressSpace::Default {
        return "(loose uniforms)".to_string();
    }
    match &*block.name {
        "" => block.instance.as_deref().unwrap_or("(nameless block)").to_string(),
        name => name.to_string(),
    }
}
