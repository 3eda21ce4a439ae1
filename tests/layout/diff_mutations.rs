//! 500 random edits of declarations: what `diff` says of each is what the oracle's offsets before
//! and after it say, by a classifier of its own (`naive`).

use crate::support;

mod mutate;
mod naive;

use std::collections::BTreeMap;

use landfall_layout::diff::{BlockDiff, Class, Kind, Side, diff, verdict};
use landfall_layout::{Options, ShaderLayout, Source, Target, layout};
use mutate::{EDITS, Edit};
use naive::Naive;
use support::blocks::{Block, Rules, Scalar, Space, print};
use support::generate::{Diet, random};
use support::glslang;
use support::landfall::table;
use support::leaf::{OracleBlock, differences};
use support::sample::{self, everything};

/// Vulkan's blocks without bool, which SPIR-V has none of.
const DIET: Diet = Diet {
    kinds: &[
        (Space::Uniform, Rules::Std140),
        (Space::Uniform, Rules::Std430),
        (Space::Uniform, Rules::Scalar),
        (Space::Buffer, Rules::Std140),
        (Space::Buffer, Rules::Std430),
        (Space::Buffer, Rules::Scalar),
    ],
    scalars: &[
        Scalar::Float,
        Scalar::Float,
        Scalar::Int,
        Scalar::Uint,
        Scalar::Double,
        Scalar::Uint64,
        Scalar::Float16,
        Scalar::Int16,
        Scalar::Uint8,
    ],
    matrices: &[Scalar::Float, Scalar::Float, Scalar::Double],
    push_constant: false,
};

const MUTATIONS: usize = 500;

/// Blocks that one run of the oracle is asked about.
const BATCH: usize = 25;

#[test]
fn the_class_of_an_edit_is_the_one_the_oracle_shows() {
    let mut classes: BTreeMap<(Edit, &str), usize> = BTreeMap::new();
    let mutations = if everything() { MUTATIONS } else { MUTATIONS / 5 };
    let (mut done, mut refused, mut seed) =
        (0, 0, if everything() { 0 } else { 1000 * sample::seed() });
    while done < mutations {
        seed += 1;
        let edits = edits(seed, &mut refused);
        let mut rng = fastrand::Rng::with_seed(seed);
        let old = Sides::of(edits.iter().map(|edit| &edit.old).collect(), str::to_string);
        let new = edits.iter().map(|edit| &edit.new).collect();
        // Comments lie everywhere: they must never matter.
        let new = Sides::of(new, |text| mutate::commented(&mut rng, text));
        for (at, edit) in edits.iter().enumerate() {
            let mut found = diff(old.side(at), new.side(at));
            // Structures go by other names only so that one text can hold them all.
            for block in &mut found {
                block.changes.retain(|change| change.kind != Kind::StructureRenamed);
            }
            found.retain(|block| !block.changes.is_empty());
            let class = verdict(&found);
            let expected = naive::classify(&old.theirs[at], &new.theirs[at]);
            let told = || {
                let (before, after) = (print(&[], &[&edit.old]), print(&[], &[&edit.new]));
                format!(
                    "seed {seed}, edit {at}: {:?}: naive {expected:?}, diff {class:?}\n{found:#?}\n\
                     --- old\n{before}\n--- new\n{after}",
                    edit.kind
                )
            };
            let sizes = (old.size(at), new.size(at));
            assert!(agrees(expected, class, &found, sizes), "{}", told());
            match edit.kind {
                Edit::Comment => assert!(found.is_empty(), "{}", told()),
                Edit::Rename | Edit::Rules => assert!(!found.is_empty(), "{}", told()),
                Edit::Swap
                | Edit::Retype
                | Edit::ArraySize
                | Edit::MatrixLayout
                | Edit::Offset
                | Edit::Add
                | Edit::Remove => {}
            }
            *classes.entry((edit.kind, class.map_or("nothing", Class::name))).or_default() += 1;
            done += 1;
        }
    }
    println!("{done} edits, {refused} refused: {classes:#?}");
    assert!(refused < mutations / 5, "{refused} refused");
    // None of the classes is there by chance only.
    for class in ["nothing", "cosmetic", "compatible", "breaking"] {
        let n: usize = classes.iter().filter(|((_, c), _)| *c == class).map(|(_, n)| n).sum();
        assert!(n * 25 >= mutations, "{class}: {n}");
    }
}

struct Edited {
    kind: Edit,
    old: Block,
    new: Block,
}

/// A batch of edits that are legal.
fn edits(seed: u64, refused: &mut usize) -> Vec<Edited> {
    let mut rng = fastrand::Rng::with_seed(seed);
    let (_, blocks) = random(7_000_000 + seed, BATCH, &DIET);
    let mut edits = Vec::new();
    for (at, block) in blocks.into_iter().enumerate() {
        let kind = EDITS[(at + seed as usize) % EDITS.len()];
        let old = mutate::plain(block);
        let Some(new) = mutate::mutate(&mut rng, &old, kind) else { continue };
        // Offsets that overlap or are misaligned, a name that is there twice.
        if lay_out(&print(&[], &[&new])).has_errors() {
            *refused += 1;
            continue;
        }
        let new = mutate::named_apart(&new, at);
        edits.push(Edited { kind, old, new });
    }
    edits
}

fn lay_out(text: &str) -> ShaderLayout {
    let mut options = Options::default();
    options.read.target = Some(Target::Vulkan);
    layout(&Source::new("edited.comp", text), &options)
}

/// Many blocks in one shader, and what both make of it.
struct Sides<'a> {
    blocks: Vec<&'a Block>,
    ours: ShaderLayout,
    theirs: Vec<OracleBlock>,
    /// Blocks on whose end they do not agree.
    disputed: Vec<String>,
}

impl<'a> Sides<'a> {
    fn of(blocks: Vec<&'a Block>, edit: impl FnOnce(&str) -> String) -> Sides<'a> {
        let text = edit(&print(&[], &blocks));
        let ours = lay_out(&text);
        assert!(!ours.has_errors(), "{:#?}\n{text}", ours.diagnostics);
        let theirs = glslang::blocks(&text, "comp", &glslang::Options::default())
            .unwrap_or_else(|e| panic!("{e}\n{text}"));
        // What glslang's listing is known to get wrong of ends (`known.rs`) is left aside.
        let wrong = differences(&table(&ours), &theirs);
        let of_leaves: Vec<_> = wrong.iter().filter(|d| d.path.is_some()).collect();
        assert!(of_leaves.is_empty(), "{of_leaves:#?}\n{text}");
        assert_eq!(blocks.len(), ours.blocks.len());
        let disputed = wrong.into_iter().map(|d| d.block).collect();
        Sides { blocks, ours, theirs, disputed }
    }

    fn side(&self, at: usize) -> Side<'_> {
        Side { blocks: &self.ours.blocks[at..=at], ..Side::from_shader(&self.ours) }
    }

    /// What a buffer must hold by the oracle's end of the last member, where that can be said: the
    /// alignment of a structure is not in SPIR-V, and glslang counts a tail in its own way.
    fn size(&self, at: usize) -> Option<u64> {
        let (block, theirs) = (self.blocks[at], &self.theirs[at]);
        let open = theirs.leaves.iter().any(|leaf| leaf.dims.contains(&None));
        if open || self.disputed.contains(&theirs.name) {
            return None;
        }
        match block.rules {
            Rules::Std140 => Some(theirs.data_size?.next_multiple_of(16)),
            Rules::Scalar => theirs.data_size,
            Rules::Std430 => None,
        }
    }
}

/// Whether both say the same, the size of the block left to the oracle where it knows it.
fn agrees(
    expected: Naive,
    class: Option<Class>,
    found: &[BlockDiff],
    sizes: (Option<u64>, Option<u64>),
) -> bool {
    let kinds = || found.iter().flat_map(|block| &block.changes).map(|change| change.kind);
    let has = |kind| kinds().any(|other| other == kind);
    if let (Some(old), Some(new)) = sizes {
        if has(Kind::Grew) != (new > old) || has(Kind::Shrank) != (new < old) {
            return false;
        }
    }
    let resized = has(Kind::Grew) || has(Kind::Shrank);
    // Facts that say something other than that bytes are read otherwise.
    let aside =
        [Kind::Rules, Kind::Alignment, Kind::ArrayStride, Kind::Order, Kind::Grew, Kind::Shrank];
    match expected {
        Naive::Same | Naive::Renamed if resized && class != Some(Class::Compatible) => false,
        Naive::Same => class < Some(Class::Breaking) && kinds().all(|kind| aside.contains(&kind)),
        Naive::Renamed => {
            class < Some(Class::Breaking) && (has(Kind::Renamed) || has(Kind::Reshaped))
        }
        Naive::Added => class == Some(Class::Compatible),
        Naive::Misread => class == Some(Class::Breaking),
    }
}

/// A buffer that the program binds and the shader no longer has is an error of the API; one that the
/// shader has more is not read by what was compiled before.
#[test]
fn fewer_buffers_in_an_array_of_blocks_break_and_more_do_not() {
    let of = |count: &str| {
        let text = format!(
            "#version 450\nlayout(std140, binding = 0) uniform Lamp {{ vec4 color; }} lamps{count};\n"
        );
        layout(&Source::new("a.frag", text), &Options::default())
    };
    for (old, new, class) in [
        ("[4]", "[2]", Class::Breaking),
        ("[2]", "[4]", Class::Compatible),
        ("[2][2]", "[3]", Class::Breaking),
    ] {
        let (before, after) = (of(old), of(new));
        let found = diff(Side::from_shader(&before), Side::from_shader(&after));
        let classes: Vec<Class> =
            found.iter().flat_map(|block| &block.changes).map(|change| change.class).collect();
        assert_eq!(classes, [class], "{old} to {new}");
    }
}
