//! WGSL layouts against naga's own numbers, over many random blocks.
//!
//! Left out is what naga 30.0.1 gets wrong: `@align` on a member of a nested structure.

use std::fmt::Write;

use fastrand::Rng;
use landfall_layout::{BlockLayout, MemberLayout, Options, ShaderLayout, Source};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{ArraySize, Handle, Module, TypeInner};

const PLAIN: [&str; 32] = [
    "f32",
    "i32",
    "u32",
    "f16",
    "i64",
    "u64",
    "f64",
    "vec2f",
    "vec3<f32>",
    "vec4f",
    "vec2h",
    "vec3<f16>",
    "vec4h",
    "vec2<u32>",
    "vec3i",
    "vec4<f64>",
    "vec3<u64>",
    "mat2x2f",
    "mat2x3<f32>",
    "mat2x4f",
    "mat3x2f",
    "mat3x3f",
    "mat3x4f",
    "mat4x2f",
    "mat4x3f",
    "mat4x4<f32>",
    "mat2x2h",
    "mat3x3<f16>",
    "mat4x3h",
    "mat3x2h",
    "mat4x4h",
    "mat2x3h",
];

fn member_type(random: &mut Rng, structs: u64) -> String {
    let base = match random.u64(..4) {
        0 if structs > 0 => format!("S{}", random.u64(..structs)),
        _ => PLAIN[random.usize(..PLAIN.len())].to_string(),
    };
    match random.u64(..8) {
        0 => format!("array<{base}, {}>", 1 + random.u64(..5)),
        1 => format!("array<array<{base}, {}>, 1 + {}>", 1 + random.u64(..3), random.u64(..4)),
        _ => base,
    }
}

/// A text of some structures and one block of the last.
fn text(random: &mut Rng, space: &str) -> String {
    let mut text = String::from("enable f16;\n");
    let structs = 1 + random.u64(..4);
    for index in 0..structs {
        let outermost = index + 1 == structs;
        writeln!(text, "struct S{index} {{").unwrap();
        let members = 1 + random.u64(..6);
        for member in 0..members {
            if outermost && random.u64(..6) == 0 {
                write!(text, "  @align({})", 32 << random.u64(..2)).unwrap();
            }
            let ty = member_type(random, index);
            // The largest type without a structure is 768 bytes.
            if !ty.contains('S') && random.u64(..8) == 0 {
                write!(text, "  @size({})", 768 + random.u64(..100)).unwrap();
            }
            writeln!(text, "  m{member}: {ty},").unwrap();
        }
        if outermost && space == "storage" && random.u64(..3) == 0 {
            writeln!(text, "  tail: array<{}>,", PLAIN[random.usize(..PLAIN.len())]).unwrap();
        }
        text.push_str("}\n");
    }
    writeln!(text, "@group(0) @binding(0) var<{space}> block: S{};", structs - 1).unwrap();
    text
}

fn laid_out(text: &str) -> ShaderLayout {
    landfall_layout::layout(&Source::new("random.wgsl", text), &Options::default())
}

/// Members compared, all the way down.
pub(super) fn compare(
    module: &Module,
    ty: Handle<naga::Type>,
    ours: &[MemberLayout],
    text: &str,
) -> usize {
    let TypeInner::Struct { members, .. } = &module.types[ty].inner else {
        panic!("a structure: {text}");
    };
    assert_eq!(members.len(), ours.len(), "{text}");
    let mut compared = 0;
    for (theirs, ours) in members.iter().zip(ours) {
        assert_eq!(theirs.name.as_deref(), Some(&*ours.name));
        assert_eq!(ours.offset, Some(theirs.offset.into()), "{} in\n{text}", ours.name);
        let (mut inner, mut strides, mut lengths) = (theirs.ty, Vec::new(), Vec::new());
        while let TypeInner::Array { base, size, stride } = module.types[inner].inner {
            strides.push(u64::from(stride));
            lengths.push(match size {
                ArraySize::Constant(length) => Some(length.get()),
                ArraySize::Dynamic | ArraySize::Pending(_) => None,
            });
            inner = base;
        }
        assert_eq!(ours.strides, strides, "{} in\n{text}", ours.name);
        let ours_lengths = ours.dims.iter().map(|len| match len {
            landfall_layout::ArrayLen::Fixed(length) => Some(*length),
            landfall_layout::ArrayLen::Runtime | landfall_layout::ArrayLen::Override(_) => None,
        });
        assert!(ours_lengths.eq(lengths), "{} in\n{text}", ours.name);
        compared += 1;
        if let TypeInner::Struct { .. } = module.types[inner].inner {
            compared += compare(module, inner, &ours.members, text);
        }
    }
    compared
}

fn block_of(shader: &ShaderLayout, text: &str) -> BlockLayout {
    assert!(!shader.has_errors(), "{text}\n{:#?}", shader.diagnostics);
    assert_eq!(shader.blocks.len(), 1, "{text}");
    shader.blocks[0].clone()
}

#[test]
fn random_storage_blocks_lie_where_naga_says() {
    let mut random = Rng::with_seed(20_240_607);
    let mut compared = 0;
    for _ in 0..1500 {
        let text = text(&mut random, "storage");
        let block = block_of(&laid_out(&text), &text);
        let module = naga::front::wgsl::parse_str(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
        let (_, variable) = module.global_variables.iter().next().expect("one variable");
        compared += compare(&module, variable.ty, &block.members, &text);
        if block.members.iter().all(|m| m.size.is_some()) {
            let size = module.types[variable.ty].inner.size(module.to_ctx());
            assert_eq!(block.size, Some(size.into()), "{text}");
        }
    }
    eprintln!("{compared} members of 1500 random blocks lie where naga says");
    assert!(compared > 10_000, "{compared}");
}

#[test]
fn uniform_constraints_are_those_of_naga_s_validator() {
    let mut random = Rng::with_seed(7);
    let (mut clean, mut warned) = (0, 0);
    for _ in 0..1500 {
        let text = text(&mut random, "uniform");
        let shader = laid_out(&text);
        block_of(&shader, &text);
        let module = naga::front::wgsl::parse_str(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
        let valid = Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&module);
        assert_eq!(
            shader.diagnostics.is_empty(),
            valid.is_ok(),
            "{text}\n{:#?}\n{valid:?}",
            shader.diagnostics
        );
        if valid.is_ok() {
            clean += 1;
        } else {
            warned += 1;
        }
    }
    eprintln!("{clean} uniform blocks are clean, {warned} are warned of, as naga has it");
    assert!(clean > 200 && warned > 200, "{clean} {warned}");
}

fn asked(path: &str, text: &str) -> ShaderLayout {
    let options = Options::default().with_naga(true);
    landfall_layout::layout(&Source::new(path, text), &options)
}

fn disagreements(shader: &ShaderLayout) -> Vec<(String, u64)> {
    let leaves = shader.blocks.iter().flat_map(|block| &block.leaves);
    leaves.filter_map(|l| Some((l.path.clone(), l.naga.as_ref()?.offset))).collect()
}

/// gfx-rs/wgpu#4377, seen in naga 30.0.1; when this fails, take it out of the list of faults.
#[test]
fn naga_ignores_align_of_nested_structures() {
    let shader = asked(
        "a.wgsl",
        "struct S { @align(16) a: u32 } struct B { x: u32, s: S, y: u32 }
         @group(0) @binding(0) var<storage> b: B;
         fn f(s: S) -> u32 { return anything naga would not take; }",
    );
    let ours: Vec<_> = shader.blocks[0].leaves.iter().map(|l| l.offset.unwrap()).collect();
    assert_eq!(ours, [0, 16, 32]);
    assert_eq!(disagreements(&shader), [("s.a".to_string(), 4), ("y".to_string(), 20)]);
}

#[test]
fn naga_agrees_where_it_has_no_fault() {
    let shader = asked(
        "a.wgsl",
        "struct P { pos: vec3f, w: array<mat2x2f, 3> }
         override N: u32 = 3;
         @group(0) @binding(0) var<storage> ps: array<P>;
         @group(0) @binding(1) var<uniform> one: P;
         @compute @workgroup_size(1) fn main() { }",
    );
    assert_eq!(shader.blocks.len(), 2);
    assert_eq!(disagreements(&shader), []);
}
