//! Proof of members of 16 and 64 bits: every backend that has the type reads each leaf where it is
//! laid out, sees a planted fault, and one that lacks the type says so.

use std::collections::BTreeSet;

use crate::support;
use crate::support::backends::with_readers;
use landfall_exec::harness::verify::{Outcome, ShaderReport, Subject, VerifyOptions, verify};
use landfall_layout::{BlockLayout, Source};
use support::blocks::{Block, Rules as BlockRules, Scalar, Space, print};
use support::generate::{Diet, random};
use support::known::{Subject as Asked, within_the_driver};
use support::sample::{everything, sample};

const KINDS: &[(Space, BlockRules)] = &[
    (Space::Uniform, BlockRules::Std140),
    (Space::Buffer, BlockRules::Std140),
    (Space::Buffer, BlockRules::Std430),
];

/// 64 bits: what every driver here has.
const LONG: Diet = Diet {
    kinds: KINDS,
    scalars: &[Scalar::Float, Scalar::Int64, Scalar::Uint64, Scalar::Double, Scalar::Bool],
    matrices: &[Scalar::Float],
    push_constant: false,
};

/// 16 bits: what the interpreter and Vulkan have.
const SHORT: Diet = Diet {
    kinds: KINDS,
    scalars: &[Scalar::Float, Scalar::Float16, Scalar::Int16, Scalar::Uint16, Scalar::Uint],
    matrices: &[Scalar::Float],
    push_constant: false,
};

fn verified(source: &Source, given: Option<Vec<BlockLayout>>) -> ShaderReport {
    let limit = std::time::Duration::from_secs(180);
    let options = VerifyOptions { limit, given, ..VerifyOptions::default() };
    let subject = Subject::new(source, &options)
        .unwrap_or_else(|(_, found)| panic!("{found:?}\n{}", source.text));
    with_readers(|backends| verify(&subject, &options, backends))
}

/// Verifies random blocks; every backend in `lacking` skips them, the others read every leaf.
fn confirmed(diet: &Diet, seeds: std::ops::Range<u64>, lacking: &[&str]) -> usize {
    let mut reads = 0;
    for seed in sample(seeds, 4) {
        let (standing, made) = random(seed, 3, diet);
        let whole = |block: &&Block| within_the_driver(Asked { block, standing: &standing });
        let made: Vec<&Block> = made.iter().filter(whole).collect();
        // OpenGL's own name of the extension.
        let text = print(&standing, &made)
            .replace("GL_EXT_shader_explicit_arithmetic_types_int64", "GL_ARB_gpu_shader_int64");
        let source = Source::new(format!("seed_{seed}.comp"), text.as_str());
        let report = verified(&source, None);
        for block in &report.blocks {
            assert_eq!(block.unprobed, [], "{text}");
            for backend in &block.backends {
                let about = format!(
                    "{}: {:?}\n{}\n{text}",
                    backend.backend.name(),
                    backend.reason,
                    backend.log
                );
                if lacking.contains(&backend.backend.name())
                    && backend.outcome != Outcome::Confirmed
                {
                    assert_eq!(backend.outcome, Outcome::Skipped, "{about}");
                    assert!(backend.log.contains("extension"), "{about}");
                    continue;
                }
                assert_eq!(backend.outcome, Outcome::Confirmed, "{about}");
                let leaves: BTreeSet<&str> = backend.reads.iter().map(|read| &*read.leaf).collect();
                assert_eq!(leaves.len(), block.leaves, "{about}");
                reads += backend.reads.len();
            }
        }
    }
    reads
}

#[test]
fn blocks_of_64_bits_are_read_where_they_are_laid_out() {
    let reads = confirmed(&LONG, 0..16, &[]);
    println!("{reads} reads");
    assert!(reads > if everything() { 5_000 } else { 500 }, "{reads}");
}

#[test]
fn blocks_of_16_bits_are_read_where_they_are_laid_out() {
    let reads = confirmed(&SHORT, 0..16, &["gl"]);
    println!("{reads} reads");
    assert!(reads > if everything() { 5_000 } else { 500 }, "{reads}");
}

const WIDTHS: [(&str, &str, &[&str]); 3] = [
    (
        "long.comp",
        "#version 450\n#extension GL_ARB_gpu_shader_int64 : require\n
        layout(std430, binding = 0) buffer B {
            float before; int64_t a; u64vec3 b[3]; double c; uint64_t d; float after;
        };\nvoid main() { after = before; }\n",
        &["cpu", "gl", "gpu"],
    ),
    (
        "short.comp",
        "#version 450\n#extension GL_EXT_shader_explicit_arithmetic_types : require\n
        layout(std430, binding = 0) buffer B {
            float before; int16_t a; f16vec3 b[3]; float16_t c; uint16_t d; float after;
        };\nvoid main() { after = before; }\n",
        &["cpu", "gpu"],
    ),
    (
        "wide.wgsl",
        "enable f16;\nstruct B { before: f32, a: f16, b: array<vec3<f16>, 3>, c: f64, d: u64, after: f32 }
        @group(0) @binding(0) var<storage, read_write> s: B;
        @compute @workgroup_size(1) fn main() { s.after = s.before; }\n",
        &["cpu", "gpu"],
    ),
];

/// Each leaf in turn is claimed one alignment further on, and each stride one longer.
#[test]
fn a_fault_of_any_width_is_caught() {
    for (name, text, having) in WIDTHS {
        let source = Source::new(name, text);
        let layout = landfall_layout::layout(&source, &landfall_layout::Options::default());
        assert!(!layout.has_errors(), "{:?}", layout.diagnostics);
        for nth in 0..layout.blocks[0].leaves.len() {
            for stride in [false, true] {
                let mut given = layout.blocks.clone();
                let leaf = &mut given[0].leaves[nth];
                let path = leaf.path.clone();
                let width = if name.starts_with("short") { 2 } else { 4 };
                match (stride, leaf.strides.first_mut()) {
                    (false, _) => leaf.offset = leaf.offset.map(|offset| offset + width),
                    (true, Some(stride)) => *stride += width,
                    (true, None) => continue,
                }
                // Room for what the fault claims.
                given[0].size = given[0].size.map(|size| size + 16);
                let report = verified(&source, Some(given));
                let backends = report.blocks[0].backends.iter();
                for backend in backends.filter(|b| having.contains(&b.backend.name())) {
                    let wrong = |way: &str| {
                        let missed = |read: &&landfall_exec::harness::verify::ElementReport| {
                            read.byte_read != Some(read.expected_byte) && read.way == way
                        };
                        backend.reads.iter().filter(missed).map(|read| &*read.leaf).collect()
                    };
                    for way in ["constant", "written"] {
                        let wrong: BTreeSet<&str> = wrong(way);
                        let about = (backend.backend.name(), &backend.reason, &backend.log);
                        assert_eq!(wrong, BTreeSet::from([&*path]), "{name} {way} {about:?}");
                    }
                }
            }
        }
    }
}

/// No backend here has 8 bits: nothing is read, and each says why.
#[test]
fn a_type_that_a_backend_lacks_is_named() {
    let text = "#version 450\n#extension GL_EXT_shader_explicit_arithmetic_types : require\n
        layout(std430, binding = 0) buffer B { float a; int8_t b; u8vec3 c; };
        void main() { a = float(b); }\n";
    let report = verified(&Source::new("byte.comp", text), None);
    for backend in &report.blocks[0].backends {
        let said = format!("{:?} {}", backend.reason, backend.log);
        assert_eq!((backend.outcome, backend.reads.len()), (Outcome::Skipped, 0), "{said}");
        let named =
            said.contains("`b` is a `int8_t`") || said.contains("explicit_arithmetic_types");
        assert!(named, "{said}");
    }
}

/// Integer constants keep their low bits (GL_EXT_shader_explicit_arithmetic_types, conversions).
#[test]
fn constants_of_16_and_64_bits_keep_their_low_bits() {
    let text = "#version 450\n#extension GL_EXT_shader_explicit_arithmetic_types : require\n
        layout(std430, binding = 0) buffer B { uint words[6]; };
        void main() {
            words[0] = uint(int(int16_t(49161u)));
            words[1] = uint(uint16_t(-5));
            words[2] = uint(uint16_t(70000));
            words[3] = uint(uint64_t(-2) >> 32);
            words[4] = uint(uint64_t(-2) & 0xFFFFFFFFul);
            words[5] = uint(int(int16_t(-70000)));
        }\n";
    let expected = [
        49161u32 as i16 as i32 as u32,
        u32::from(-5i32 as u16),
        u32::from(70000u32 as u16),
        u32::MAX,
        (-2i32) as u32,
        -70000i32 as i16 as i32 as u32,
    ];
    let source = Source::new("constants.comp", text);
    let module = landfall_ir::Module::new(&source, &landfall_layout::Options::default());
    let module = std::sync::Arc::new(module.unwrap_or_else(|found| panic!("{found:?}")));
    let job = landfall_exec::backend::Job {
        stages: vec![landfall_exec::backend::StageCode::of_module(
            landfall_layout::Stage::Compute,
            "main",
            module,
        )],
        resources: vec![landfall_exec::backend::Resource {
            name: "B".to_string(),
            group: 0,
            binding: 0,
            kind: landfall_exec::backend::ResourceKind::Storage {
                bytes: vec![0; 24],
                writable: true,
            },
        }],
        grid: landfall_exec::backend::Grid::Groups([1, 1, 1]),
        limit: std::time::Duration::from_secs(20),
    };
    with_readers(|backends| {
        for backend in backends {
            let name = backend.device().backend.name();
            if name == "gl" {
                continue;
            }
            let output = backend.run(&job).unwrap_or_else(|failure| panic!("{name}: {failure}"));
            let bytes = output.buffers[0].as_ref().expect("the buffer is writable");
            let words: Vec<u32> = bytes
                .chunks_exact(4)
                .map(|word| u32::from_le_bytes(word.try_into().expect("four bytes")))
                .collect();
            // Mesa 22.3.6 on Vulkan gives 0 for the high half of a 64-bit constant.
            let kept = |at: &usize| name == "cpu" || *at != 3;
            let pick = |all: &[u32]| (0..6).filter(kept).map(|at| all[at]).collect::<Vec<_>>();
            assert_eq!(pick(&words), pick(&expected), "{name}");
        }
    });
}
