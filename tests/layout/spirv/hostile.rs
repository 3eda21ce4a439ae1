//! Modules that are broken or made to exhaust the reader: one clear answer each, within bounds.

use std::fs;

use fastrand::Rng;
use landfall_layout::{Options, Source, layout};

use super::forms::{assembled, offsets, uniform};
use super::{bytes, read};
use crate::fuzz::{MAX_MEMORY_KB, peak_memory_kb};
use crate::support::glslang::{self, compiled};
use crate::support::sample::sample;

/// How many mutants there are.
const MUTANTS: u64 = 50_000;

/// Processor time of one mutant: the slowest takes milliseconds.
const SLOWEST_NS: u64 = 5_000_000_000;

/// Processor time of all of them, for each.
const AVERAGE_NS: u64 = 2_000_000;

/// The errors of a module, without their help.
fn errors(words: &[u32]) -> Vec<String> {
    read(words).diagnostics.into_iter().map(|found| found.message).collect()
}

fn refused(name: &str, bytes: Vec<u8>) -> String {
    Source::from_bytes(name, bytes).expect_err("it is no module").to_string()
}

/// The header of a module, then instructions.
fn module(bound: u32, instructions: &[&[u32]]) -> Vec<u32> {
    let mut words = vec![0x0723_0203, 0x0001_0000, 0, bound, 0];
    for instruction in instructions {
        words.push((instruction.len() as u32) << 16 | instruction[0]);
        words.extend(&instruction[1..]);
    }
    words
}

#[test]
fn what_is_no_module_is_one_error() {
    assert!(
        refused("a.spv", b"#version 450\n".to_vec())
            .starts_with("`a.spv` is not SPIR-V: it begins with the bytes 23 76 65 72\n")
    );
    assert!(refused("a.SPV", vec![]).starts_with("`a.SPV` is not SPIR-V: it has 0 bytes\n"));
    let cut = bytes(&module(9, &[]))[..18].to_vec();
    assert!(refused("a.spv", cut).starts_with("`a.spv` is not a whole SPIR-V module: 18 bytes"));
    // A text that is said to be SPIR-V.
    let text = layout(&Source::new("a.spv", "#version 450\n"), &Options::default());
    assert_eq!(text.diagnostics[0].message, "a module is bytes, but this is a text");
}

#[test]
fn broken_modules_are_one_error() {
    let one = |words: &[u32]| {
        let [error] = errors(words).try_into().expect("one error");
        error
    };
    assert_eq!(
        one(&[0x0723_0203, 0x0001_0000]),
        "the module is 2 words long, but its header has 5"
    );
    assert_eq!(
        one(&module(u32::MAX, &[])),
        "the bound of ids is 4294967295, but it is 1 to 4194303"
    );
    let mut second = module(9, &[]);
    second[1] = 0x0002_0000;
    assert_eq!(one(&second), "the module is of SPIR-V 2.0, but landfall reads 1.x");
    let mut zero = module(9, &[]);
    zero.push(19);
    assert_eq!(one(&zero), "the instruction at word 5 is 0 words long");
    zero[5] = 7 << 16 | 19;
    assert_eq!(one(&zero), "the instruction at word 5 is 7 words long, but the module has 6");
    let past =
        "the instruction at word 5, of opcode 22, lacks operands or has an id past the bound";
    assert_eq!(one(&module(9, &[&[22, 9, 32]])), past);
    assert_eq!(one(&module(9, &[&[22]])), past);
    // OpMemoryModel Physical64 OpenCL
    assert_eq!(
        one(&module(9, &[&[14, 2, 2]])),
        "the module is a kernel of OpenCL, whose buffers have no blocks and no layouts in SPIR-V"
    );
    // Cut off in a function, after all that a layout needs.
    let mut cut = assembled(&uniform(&offsets(&[0]), "", "%6"));
    let last = cut.len() - 1;
    cut[last] = 2 << 16 | 56;
    assert!(one(&cut).ends_with(&format!("is 2 words long, but the module has {}", last + 1)));
}

#[test]
fn blocks_without_a_layout_are_named() {
    let one = |decorations: &str, types: &str, members: &str| {
        let [error] = errors(&assembled(&uniform(decorations, types, members)))
            .try_into()
            .expect("one error");
        error
    };
    let of = |problem: &str| format!("block `Block` has no layout: `member_0{problem}");
    assert_eq!(one("", "", "%6"), of("` has no Offset"));
    let at = offsets(&[0]);
    assert_eq!(
        one(&at, "%20 = OpTypeStruct %20", "%20"),
        of(".member_0` has the type %20, which contains itself")
    );
    let array = "%20 = OpTypeArray %6 %8";
    assert_eq!(one(&at, array, "%20"), of("` is an array without an ArrayStride"));
    let matrix = "%20 = OpTypeMatrix %6 4";
    assert_eq!(one(&at, matrix, "%20"), of("` is a matrix without a MatrixStride"));
    assert_eq!(one(&at, "%20 = OpTypeBool", "%20"), of("` is a bool, which has no size in SPIR-V"));
    assert_eq!(one(&at, "", "%99"), of("` has the type %99, which the module does not declare"));
    assert_eq!(
        one(&at, "%20 = OpTypeSampler", "%20"),
        of("` has a type without a layout, %20 of opcode 26")
    );
    let close = format!("{at}OpDecorate %20 ArrayStride 8");
    assert_eq!(
        one(&close, array, "%20"),
        "`member_0` of block `Block` has ArrayStride 8, but an element takes 16 bytes"
    );
    let float = "%9 = OpConstant %4 1\n%20 = OpTypeArray %6 %9";
    assert_eq!(
        one(&close, float, "%20"),
        of("` has an array whose length is %9, which is no integer")
    );
    assert_eq!(
        one(&offsets(&[0, 8]), "", "%6 %4"),
        "`member_1` at offset 8 overlaps `member_0`, which occupies 0 to 15"
    );
    let runtime = "%20 = OpTypeRuntimeArray %6";
    assert_eq!(
        one(&format!("{}OpDecorate %20 ArrayStride 16", offsets(&[0, 16])), runtime, "%20 %4"),
        "`member_0` is a runtime-sized array, but not the last member of block `Block`"
    );
    let huge = "%9 = OpConstant %7 4294967295\n%20 = OpTypeArray %6 %9";
    assert_eq!(
        one(&format!("{at}OpDecorate %20 ArrayStride 16"), huge, "%20"),
        "block `Block` is larger than 2^32 bytes at member `member_0`"
    );
}

/// Structures of two members each, both of the structure before: 2^n of them.
#[test]
fn structures_in_structures_are_bounded() {
    let mut instructions: Vec<Vec<u32>> = vec![vec![22, 1, 32]];
    for id in 2..60 {
        instructions.push(vec![72, id, 0, 35, 0]);
        instructions.push(vec![72, id, 1, 35, 1 << id.min(30)]);
        instructions.push(vec![30, id, id - 1, id - 1]);
    }
    instructions.push(vec![32, 60, 2, 59]);
    instructions.push(vec![59, 60, 61, 2]);
    let all: Vec<&[u32]> = instructions.iter().map(Vec::as_slice).collect();
    let errors = errors(&module(99, &all));
    assert_eq!(errors.len(), 1, "{errors:?}");
    assert!(errors[0].contains("more members than landfall lays out"), "{errors:?}");
}

/// A chain of structures, of which one block has all and another half: only the first is too deep,
/// whichever comes first.
#[test]
fn structures_are_too_deep_only_in_blocks_that_have_all_of_them() {
    for blocks in [[(201, 199), (203, 100)], [(201, 100), (203, 199)]] {
        let mut instructions: Vec<Vec<u32>> = vec![vec![22, 1, 32]];
        for id in 2..200 {
            instructions.push(vec![72, id, 0, 35, 0]);
            instructions.push(vec![30, id, id - 1]);
        }
        for (pointer, structure) in blocks {
            instructions.push(vec![32, pointer, 2, structure]);
            instructions.push(vec![59, pointer, pointer + 1, 2]);
        }
        let all: Vec<&[u32]> = instructions.iter().map(Vec::as_slice).collect();
        let shader = read(&module(300, &all));
        let [found] = shader.diagnostics.as_slice() else { panic!("{:#?}", shader.diagnostics) };
        let message = &found.message;
        assert!(message.starts_with("block `block_199` has no layout: `member_0.member_0."));
        assert!(message.ends_with("` is nested deeper than 128"), "{message}");
        assert_eq!(
            shader.blocks.iter().map(|block| &*block.name).collect::<Vec<_>>(),
            ["block_100"]
        );
    }
}

#[test]
fn a_module_of_100_000_types_is_laid_out() {
    let mut instructions: Vec<Vec<u32>> = vec![vec![22, 1, 32]];
    for id in 2..100_000 {
        instructions.push(vec![72, id, 0, 35, 0]);
        instructions.push(vec![30, id, 1]);
    }
    instructions.push(vec![32, 100_000, 2, 99_999]);
    instructions.push(vec![59, 100_000, 100_001, 2]);
    let all: Vec<&[u32]> = instructions.iter().map(Vec::as_slice).collect();
    let shader = read(&module(100_002, &all));
    assert_eq!(shader.diagnostics, []);
    assert_eq!(shader.blocks[0].leaves.len(), 1);
}

/// Each a module of a few hundred words.
fn corpus() -> Vec<Vec<u32>> {
    let mut found = vec![
        assembled(&uniform(&offsets(&[0, 16, 20]), "", "%6 %4 %5")),
        assembled(&uniform(
            &format!("{}OpDecorate %20 ArrayStride 16\nOpDecorate %8 SpecId 1", offsets(&[0, 20])),
            "%9 = OpSpecConstant %7 2\n%14 = OpSpecConstantOp %7 IMul %9 %8\n%20 = OpTypeArray %4 %14",
            "%20 %4",
        )),
    ];
    for text in [
        "struct L { vec3 p; float r; mat3x4 m[2]; };
         layout(std140, set = 0, binding = 1) uniform U { L l[3]; dvec2 d; } u[2];
         layout(std430, set = 0, binding = 2) buffer S { uint n; L tail[]; };",
        "layout(constant_id = 2) const int N = 3;
         layout(push_constant) uniform P { layout(offset = 32) vec4 c; float w[N]; };
         layout(row_major, set = 1, binding = 0) uniform M { mat2x3 a; layout(column_major) mat4 b; };",
    ] {
        let text = format!("#version 450\nlayout(local_size_x = 1) in;\n{text}\nvoid main() {{}}\n");
        let options = glslang::Options::unlisted();
        found.push(compiled(&text, "comp", &options).unwrap_or_else(|e| panic!("{e}")).0);
    }
    found
}

/// A module with a few things done to its words.
fn mutant(corpus: &[Vec<u32>], seed: u64) -> Vec<u8> {
    let mut rng = Rng::with_seed(seed);
    let mut words = corpus[rng.usize(..corpus.len())].clone();
    for _ in 0..rng.usize(1..4) {
        let at = rng.usize(..words.len());
        match rng.u8(..8) {
            0 => words[at] = rng.u32(..),
            1 => words[at] ^= 1 << rng.u32(..32),
            2 => words[at] = rng.u32(..64),
            3 => words[at] = words[rng.usize(..words.len())],
            4 => words.truncate(at.max(1)),
            5 => drop(words.remove(at)),
            6 => words.insert(at, rng.u32(..64)),
            _ => {
                let end = rng.usize(at..words.len());
                let part = words[at..end].to_vec();
                let to = rng.usize(..words.len());
                words.splice(to..to, part);
            }
        }
        if words.is_empty() {
            words.push(0);
        }
    }
    words[0] = 0x0723_0203;
    bytes(&words)
}

/// Processor time of this thread in nanoseconds.
fn processor_ns() -> u64 {
    let text = fs::read_to_string("/proc/thread-self/schedstat").expect("Linux has it");
    text.split_whitespace().next().and_then(|first| first.parse().ok()).expect("a number")
}

#[test]
fn mutants_end_in_an_answer_or_an_error() {
    let corpus = corpus();
    let (mut laid_out, mut refused, mut count) = (0, 0, 0);
    let start = processor_ns();
    for seed in sample(0..MUTANTS, 10) {
        count += 1;
        let before = processor_ns();
        let source =
            Source::from_bytes("a.spv", mutant(&corpus, seed)).expect("the magic is there");
        let shader = layout(&source, &Options::default());
        for block in &shader.blocks {
            let padding = landfall_layout::layout::padding::padding(block);
            let padding: u64 = padding.iter().map(|one| one.size * one.times).sum();
            // One element of a runtime-sized tail counts as used with its padding.
            assert!(padding <= block.size.unwrap_or(0), "mutant {seed}: {block:#?}");
            for leaf in block.leaves.iter().filter(|leaf| leaf.dims.is_empty()) {
                let end = leaf.offset.zip(leaf.size).map(|(offset, size)| offset + size);
                assert!(end <= block.size, "mutant {seed}: {} ends past its block", leaf.path);
            }
        }
        match shader.has_errors() {
            true => refused += 1,
            false => laid_out += 1,
        }
        let took = processor_ns() - before;
        assert!(took < SLOWEST_NS, "mutant {seed} took {took} ns");
    }
    let all = processor_ns() - start;
    println!("{count} mutants: {laid_out} laid out, {refused} refused, {all} ns");
    assert!(all / count < AVERAGE_NS, "{count} mutants took {all} ns");
    if let Some(peak) = peak_memory_kb() {
        assert!(peak < MAX_MEMORY_KB, "the run took {peak} KB at its peak");
    }
    assert!(laid_out > 50 && refused > 50, "{laid_out} were laid out, {refused} refused");
}
