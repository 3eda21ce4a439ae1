//! What holds for every layout, whatever the block: no bytes shared, none
//! outside, none unaccounted for.

use crate::support;

use landfall_layout::layout::occupied;
use landfall_layout::{
    ArrayLen, BlockLayout, Leaf, MemberLayout, Options, Rules, ShaderLayout, Source, Target, layout,
};
use support::blocks::print;
use support::generate::{COMMON, VULKAN, random};

/// Seeds of 100 blocks each, of OpenGL's kind and of Vulkan's.
const SEEDS: u64 = 40;

fn every_shader(mut check: impl FnMut(&ShaderLayout, &str)) {
    for seed in 0..SEEDS {
        for (diet, target) in [(&COMMON, Target::OpenGl), (&VULKAN, Target::Vulkan)] {
            let (standing, blocks) = random(1_000_000 + seed, 100, diet);
            let text = print(&standing, &blocks.iter().collect::<Vec<_>>());
            let shader = lay_out(&text, target, None);
            assert!(!shader.has_errors(), "{:#?}\n{text}", shader.diagnostics);
            assert_eq!(shader.blocks.len(), blocks.len());
            check(&shader, &text);
        }
    }
}

fn lay_out(text: &str, target: Target, rules: Option<Rules>) -> ShaderLayout {
    let mut options = Options::default().with_rules(rules);
    options.read.target = Some(target);
    layout(&Source::new("random.comp", text), &options)
}

/// Where each element of a leaf is, a runtime-sized array counted with one element.
fn places(leaf: &Leaf) -> Vec<u64> {
    let mut places = vec![leaf.offset.expect("these blocks have offsets")];
    for (len, stride) in leaf.dims.iter().zip(&leaf.strides) {
        let count = match len {
            ArrayLen::Fixed(n) => u64::from(*n),
            ArrayLen::Runtime | ArrayLen::Override(_) => 1,
        };
        places = places.iter().flat_map(|p| (0..count).map(move |i| p + i * stride)).collect();
    }
    places
}

#[test]
fn no_byte_is_shared_and_members_and_padding_make_the_size() {
    every_shader(|shader, text| {
        for block in &shader.blocks {
            let size = block.size.expect("these blocks have a size") as usize;
            let mut owner = vec![false; size];
            for leaf in &block.leaves {
                for place in places(leaf) {
                    for byte in bytes(leaf, place) {
                        let taken = std::mem::replace(&mut owner[byte as usize], true);
                        assert!(!taken, "{} {}: byte {byte} twice\n{text}", block.name, leaf.path);
                    }
                }
            }
            let used = owner.iter().filter(|taken| **taken).count() as u64;
            assert_eq!(used, block.used(), "{}\n{text}", block.name);
        }
    });
}

/// The bytes that hold a leaf's components: columns (rows) apart by the matrix stride.
fn bytes(leaf: &Leaf, place: u64) -> Vec<u64> {
    let whole = occupied(&leaf.ty);
    let (vectors, stride) = match (&leaf.ty, leaf.matrix_stride) {
        (landfall_layout::Type::Matrix { columns, rows, .. }, Some(stride)) => {
            (u64::from(if leaf.row_major { *rows } else { *columns }), stride)
        }
        _ => (1, 0),
    };
    let each = whole / vectors;
    (0..vectors).flat_map(|v| (0..each).map(move |b| place + v * stride + b)).collect()
}

#[test]
fn offsets_are_multiples_of_alignments() {
    fn check(members: &[MemberLayout], block: &BlockLayout) {
        for member in members {
            let (offset, align) = (member.offset.unwrap_or(0), member.align.unwrap_or(1));
            assert_eq!(offset % align, 0, "{} {}", block.name, member.name);
            if block.rules == Rules::Std140 {
                // Rules 4, 5, 7 and 9: every stride is a multiple of a vec4's alignment.
                let mut strides = member.strides.iter().chain(&member.matrix_stride);
                assert!(strides.all(|s| s % 16 == 0), "{} {}", block.name, member.name);
            }
            check(&member.members, block);
        }
    }
    every_shader(|shader, _| {
        for block in &shader.blocks {
            check(&block.members, block);
        }
    });
}

#[test]
fn leaves_lie_inside_their_block() {
    every_shader(|shader, text| {
        for block in &shader.blocks {
            for leaf in &block.leaves {
                let end = places(leaf).into_iter().max().expect("one place at least")
                    + leaf.size.expect("a placed leaf has a size");
                assert!(Some(end) <= block.size, "{} {}\n{text}", block.name, leaf.path);
            }
            assert!(block.data_size <= block.size);
        }
    });
}

#[test]
fn std430_takes_no_more_than_std140_and_scalar_no_more_than_std430() {
    for seed in 0..SEEDS {
        let (_, mut blocks) = random(2_000_000 + seed, 100, &COMMON);
        for member in blocks.iter_mut().flat_map(|block| &mut block.members) {
            (member.offset, member.align) = (None, None);
        }
        let text = print(&[], &blocks.iter().collect::<Vec<_>>());
        let sizes = |rules| -> Vec<u64> {
            let shader = lay_out(&text, Target::Vulkan, Some(rules));
            shader.blocks.iter().map(|b| b.data_size.expect("these blocks have a size")).collect()
        };
        let (std140, std430, scalar) =
            (sizes(Rules::Std140), sizes(Rules::Std430), sizes(Rules::Scalar));
        assert_eq!(std140.len(), blocks.len());
        for i in 0..std140.len() {
            assert!(std430[i] <= std140[i], "{}: {} and {}", blocks[i].name, std430[i], std140[i]);
            assert!(scalar[i] <= std430[i], "{}: {} and {}", blocks[i].name, scalar[i], std430[i]);
        }
    }
}
