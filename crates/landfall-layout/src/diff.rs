//! What happened between two layouts, in the words of a reviewer, and whether bytes uploaded for
//! the old one still land where the new shader reads them.
//!
//! A pure function over the model: [`diff`] reads [`BlockLayout`]s, gives plain [`Change`]s.
//! `pair` finds which blocks belong together, `leaves` compares bytes, `describe` folds what it
//! finds into one line a change, `block` compares the rest. Fed by shaders and
//! [`locks`](crate::lock); read by [`format`](mod@crate::format) and the lint `layout-drift`.
//!
//! The classes follow from the bytes alone. Every element of every array of the old block has a
//! path, a place and a type (matrix stride and majorness with it). It is *in place* when the new
//! block has at the same place the same type under the same path; or under another one that the
//! old block did not have, while the old path is not in the new block: then it is renamed.
//! An old element that is not in place makes the change breaking. A new element that no old one
//! stands for is compatible as long as it lies in bytes that were padding, or past the end.

mod block;
mod describe;
mod elements;
mod leaves;
mod loose;
mod pair;

use crate::layout::BlockLayout;
use crate::shape::AddressSpace;
use crate::source::Language;

/// What a change does to bytes uploaded for the old layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Class {
    /// No byte changes.
    Cosmetic,
    /// Old uploads still land; a buffer may have become too small.
    Compatible,
    /// Bytes uploaded for the old layout are misread.
    Breaking,
}

impl Class {
    /// `cosmetic`, `compatible` or `breaking`.
    pub fn name(self) -> &'static str {
        match self {
            Class::Cosmetic => "cosmetic",
            Class::Compatible => "compatible",
            Class::Breaking => "breaking",
        }
    }
}

/// The kinds of changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub enum Kind {
    Moved,
    Retyped,
    Renamed,
    /// A member became an array, or an array one of other dimensions, over the same elements.
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
    Majorness,
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

impl Kind {
    /// The kebab-case name used in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Moved => "moved",
            Kind::Retyped => "retyped",
            Kind::Renamed => "renamed",
            Kind::Reshaped => "reshaped",
            Kind::Appended => "appended",
            Kind::Inserted => "inserted",
            Kind::PaddingUsed => "padding-used",
            Kind::Removed => "removed",
            Kind::Lengthened => "lengthened",
            Kind::Shortened => "shortened",
            Kind::ArrayStride => "array-stride",
            Kind::MatrixStride => "matrix-stride",
            Kind::Majorness => "majorness",
            Kind::Grew => "grew",
            Kind::Shrank => "shrank",
            Kind::Rules => "rules",
            Kind::RulesDeclared => "rules-declared",
            Kind::AddressSpace => "address-space",
            Kind::Slot => "slot",
            Kind::Count => "count",
            Kind::Instance => "instance",
            Kind::StructureRenamed => "structure-renamed",
            Kind::Alignment => "alignment",
            Kind::Order => "order",
            Kind::BlockAdded => "block-added",
            Kind::BlockRemoved => "block-removed",
            Kind::BlockRenamed => "block-renamed",
        }
    }
}

/// One change.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// What kind of change it is.
    pub kind: Kind,
    /// What it does to bytes uploaded for the old layout.
    pub class: Class,
    /// What it is about, as a pattern in the old block, or in the new one when only that has it:
    /// `data[].color`; empty for the block.
    pub path: String,
    /// What was, in one word: a number, a type, a name.
    pub old: Option<String>,
    /// What is.
    pub new: Option<String>,
    /// All of it in one sentence, lower case, names in backticks.
    pub message: String,
}

/// What happened to one block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlockDiff {
    /// Its index among the old blocks; `None` when it is new.
    pub old: Option<usize>,
    /// Its index among the new blocks; `None` when it is gone.
    pub new: Option<usize>,
    /// What messages call it: the block's name, `(loose uniforms)`.
    pub name: String,
    /// One at least, the most serious first, those of a class in the order of the block.
    pub changes: Vec<Change>,
}

impl BlockDiff {
    /// The class of its most serious change.
    pub fn class(&self) -> Class {
        self.changes.iter().map(|change| change.class).max().unwrap_or(Class::Cosmetic)
    }
}

/// The blocks of one side, and the language their types are spelled in.
#[derive(Clone, Copy, Debug)]
pub struct Side<'a> {
    /// The blocks.
    pub blocks: &'a [BlockLayout],
    /// The language of the shader.
    pub language: Language,
}

impl<'a> Side<'a> {
    /// The blocks of a shader.
    pub fn of(shader: &'a crate::ShaderLayout) -> Side<'a> {
        Side { blocks: &shader.blocks, language: shader.language }
    }
}

/// Everything that changed from one side to the other, block by block in the new side's order,
/// then the blocks that are gone. Blocks without a change are left out.
pub fn diff(old: Side<'_>, new: Side<'_>) -> Vec<BlockDiff> {
    let mut found = Vec::new();
    for (before, after) in pair::pairs(old.blocks, new.blocks) {
        let (a, b) = (before.map(|i| &old.blocks[i]), after.map(|i| &new.blocks[i]));
        let mut changes = match (a, b) {
            (Some(a), Some(b)) => {
                both(Block { layout: a, side: old }, Block { layout: b, side: new })
            }
            (Some(a), None) => vec![block::removed(a)],
            (None, Some(b)) => vec![block::added(b)],
            (None, None) => Vec::new(),
        };
        if changes.is_empty() {
            continue;
        }
        // Stable: changes of a class stay in the order of the block.
        changes.sort_by_key(|change| std::cmp::Reverse(change.class));
        let name = b.or(a).map(shown_name).unwrap_or_default();
        found.push(BlockDiff { old: before, new: after, name, changes });
    }
    found
}

/// The class of the most serious change; `None` when there is none.
pub fn verdict(blocks: &[BlockDiff]) -> Option<Class> {
    blocks.iter().map(BlockDiff::class).max()
}

/// A block, and the side it is on.
#[derive(Clone, Copy)]
struct Block<'a> {
    layout: &'a BlockLayout,
    side: Side<'a>,
}

fn both(old: Block<'_>, new: Block<'_>) -> Vec<Change> {
    let loose = |block: Block<'_>| block.layout.space == AddressSpace::Default;
    match (loose(old), loose(new)) {
        (true, true) => loose::changes(old, new),
        (false, false) => {
            let facts = leaves::facts(old.layout, new.layout);
            let mut changes = describe::changes(old, new, &facts);
            block::changes(old, new, &mut changes);
            changes
        }
        (true, false) | (false, true) => vec![block::space(old.layout, new.layout)],
    }
}

/// What messages call a block.
fn shown_name(block: &BlockLayout) -> String {
    if block.space == AddressSpace::Default {
        return "(loose uniforms)".to_string();
    }
    match &*block.name {
        "" => block.instance.as_deref().unwrap_or("(nameless block)").to_string(),
        name => name.to_string(),
    }
}
