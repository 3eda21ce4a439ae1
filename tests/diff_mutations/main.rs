//! 500 random edits of declarations: what `diff` says of each is what the oracle's offsets before
//! and after it say, by a classifier of its own (`naive`).

#[path = "../support/mod.rs"]
mod support;

mod mutate;
mod naive;

use std::collections::BTreeMap;

use landfall::diff::{BlockDiff, Class, Kind, Side, diff, verdict};
use landfall::{Options, ShaderLayout, Source, Target, layout};
use mutate::{EDITS, Edit};
use naive::Naive;
use support::blocks::{Block, Rules, Scalar, Space, print};
use support::generate::{Diet, random};
use support::glslang;
use support::landfall::table;
use support::leaf::{OracleBlock, differences};

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

#[test]
fn the_class_of_an_edit_is_the_one_the_oracle_shows() {
    let mut classes: BTreeMap<(Edit, Option<&str>), usize> = BTreeMap::new();
    let (mut done, mut refused, mut seed) = (0, 0, 0);
    while done < MUTATIONS {
        seed += 1;
        assert!(seed < 4 * MUTATIONS as u64, "{done} mutations, {refused} refused");
        let mut rng = fastrand::Rng::with_seed(seed);
        let edit = EDITS[seed as usize % EDITS.len()];
        let (_, mut blocks) = random(7_000_000 + seed, 1, &DIET);
        let block = mutate::plain(blocks.remove(0));
        let Some(after) = mutate::mutate(&mut rng, &block, edit) else { continue };
        let old = Text::of(&block, print(&[], &[&block]));
        let mut text = print(&[], &[&after]);
        if edit == Edit::Comment {
            text = mutate::commented(&mut rng, &text);
        }
        let new = Text::of(&after, text);
        let (Some(old), Some(new)) = (old, new) else {
            // Offsets that overlap, a block past its limits: nobody takes the text.
            refused += 1;
            continue;
        };
        let found = diff(Side::of(&old.ours), Side::of(&new.ours));
        let class = verdict(&found);
        let expected = naive::classify(&old.theirs, &new.theirs);
        let told = format!(
            "seed {seed}: {edit:?}: naive {expected:?}, diff {class:?}\n{found:#?}\n--- old\n{}\n--- new\n{}",
            old.text, new.text
        );
        assert!(agrees(expected, class, &found, &old, &new), "{told}");
        let has = |kind| found.iter().flat_map(|block| &block.changes).any(|c| c.kind == kind);
        match edit {
            Edit::Comment => assert!(found.is_empty(), "{told}"),
            Edit::Rename => assert!(
                has(Kind::Renamed)
                    || has(Kind::Moved)
                    || has(Kind::Retyped)
                    || has(Kind::Removed)
                    || has(Kind::Inserted)
                    || class == Some(Class::Breaking),
                "{told}"
            ),
            Edit::Rules => assert!(has(Kind::Rules), "{told}"),
            Edit::Swap
            | Edit::Retype
            | Edit::ArraySize
            | Edit::Majorness
            | Edit::Offset
            | Edit::Add
            | Edit::Remove => {}
        }
        *classes.entry((edit, class.map(Class::name))).or_default() += 1;
        done += 1;
    }
    println!("{done} mutations of {seed} seeds, {refused} refused by both: {classes:#?}");
    assert!(refused < MUTATIONS / 5, "{refused} refused");
    // None of the classes is there by chance only.
    for class in [None, Some("cosmetic"), Some("compatible"), Some("breaking")] {
        let n: usize = classes.iter().filter(|((_, c), _)| *c == class).map(|(_, n)| n).sum();
        assert!(n >= 20, "{class:?}: {n}");
    }
}

/// A block's text, and what both sides make of it.
struct Text {
    text: String,
    ours: ShaderLayout,
    theirs: OracleBlock,
    /// What a buffer must hold, from the oracle's end of the last member.
    size: Option<u64>,
}

impl Text {
    /// `None` when the text is refused: by both, or the test fails.
    fn of(block: &Block, text: String) -> Option<Text> {
        let theirs = glslang::blocks(&text, "comp", &glslang::Options::default());
        let mut options = Options::default();
        options.read.target = Some(Target::Vulkan);
        let ours = layout(&Source::new("mutated.comp", text.as_str()), &options);
        let theirs = match theirs {
            Ok(mut theirs) => theirs.remove(0),
            Err(_) => return None,
        };
        if ours.has_errors() {
            return None;
        }
        let runtime = theirs.leaves.iter().any(|leaf| leaf.dims.contains(&None));
        let wrong = differences(&table(&ours), std::slice::from_ref(&theirs));
        // What glslang is known to get wrong of ends (`known.rs`) is no matter here.
        let of_leaves: Vec<_> = wrong.iter().filter(|d| d.path.is_some()).collect();
        assert!(of_leaves.is_empty(), "{of_leaves:#?}\n{text}");
        let end = theirs.data_size.filter(|_| wrong.is_empty() && !runtime);
        let size = end.and_then(|end| match block.rules {
            Rules::Std140 => Some(end.next_multiple_of(16)),
            Rules::Scalar => Some(end),
            // The alignment of a structure is not in SPIR-V.
            Rules::Std430 => None,
        });
        Some(Text { text, ours, theirs, size })
    }
}

/// Whether both say the same, the size of the block left to the oracle where it knows it.
fn agrees(
    expected: Naive,
    class: Option<Class>,
    found: &[BlockDiff],
    old: &Text,
    new: &Text,
) -> bool {
    let kinds = || found.iter().flat_map(|block| &block.changes).map(|change| change.kind);
    let resized = kinds().any(|kind| matches!(kind, Kind::Grew | Kind::Shrank));
    if let (Some(a), Some(b)) = (old.size, new.size) {
        if resized != (a != b) || kinds().any(|kind| kind == Kind::Grew) != (b > a) {
            return false;
        }
    }
    let names_only = kinds().all(|kind| match kind {
        Kind::Rules | Kind::Alignment | Kind::ArrayStride | Kind::Order => true,
        Kind::Grew | Kind::Shrank => true,
        _ => false,
    });
    match expected {
        Naive::Same if resized => class == Some(Class::Compatible) && names_only,
        Naive::Same => class.is_none_or(|class| class == Class::Cosmetic) && names_only,
        Naive::Renamed if resized => class == Some(Class::Compatible),
        Naive::Renamed => {
            class == Some(Class::Cosmetic)
                && kinds()
                    .any(|k| k == Kind::Renamed || k == Kind::Shortened || k == Kind::Lengthened)
        }
        Naive::Added => class == Some(Class::Compatible),
        Naive::Misread => class == Some(Class::Breaking),
    }
}
