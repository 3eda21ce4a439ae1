//! WGSL text to layouts.
//!
//! Numbers come from the WGSL specification, §14.4, or are worked out beside the text.

use crate::support::command::golden;
use landfall_layout::{
    AddressSpace, ArrayLen, BlockLayout, Options, ReadOptions, Severity, ShaderLayout, Source,
};
use snapbox::str;

pub fn laid_out(text: &str) -> ShaderLayout {
    landfall_layout::layout(&Source::new("test.wgsl", text), &Options::default())
}

fn with_overrides(text: &str, overrides: &[(&str, &str)]) -> ShaderLayout {
    let overrides = overrides.iter().map(|(n, v)| (n.to_string(), v.to_string())).collect();
    let read = ReadOptions::default().with_overrides(overrides);
    landfall_layout::layout(&Source::new("test.wgsl", text), &Options::default().with_read(read))
}

/// The only block of a text without findings.
pub fn block(text: &str) -> BlockLayout {
    let mut shader = laid_out(text);
    assert!(shader.diagnostics.is_empty(), "{text}\n{:#?}", shader.diagnostics);
    assert_eq!(shader.blocks.len(), 1, "{text}");
    shader.blocks.remove(0)
}

fn offsets(block: &BlockLayout) -> Vec<(&str, u64)> {
    block.leaves.iter().map(|leaf| (leaf.path.as_str(), leaf.offset.unwrap())).collect()
}

/// The length of `array<u32, EXPRESSION>` under those declarations.
fn length(declarations: &str, expression: &str) -> Option<u64> {
    let text =
        format!("{declarations}\n@group(0) @binding(0) var<storage> a: array<u32, {expression}>;");
    let shader = laid_out(&text);
    match shader.blocks.first()?.leaves[0].dims[0] {
        ArrayLen::Fixed(n) => Some(n.into()),
        ArrayLen::Runtime | ArrayLen::Override(_) => None,
    }
}

/// The code and message, the text pointed at, and the help of the only finding of a text.
pub fn only_finding(text: &str) -> (String, String, String) {
    let shader = laid_out(text);
    assert_eq!(shader.diagnostics.len(), 1, "{text}\n{:#?}", shader.diagnostics);
    let found = &shader.diagnostics[0];
    let at = shader.files.text(found.labels[0].at).to_string();
    (
        format!("{}: {}", found.code.name(), found.message),
        at,
        found.help.clone().unwrap_or_default(),
    )
}

#[test]
fn the_specification_s_example_of_implicit_layout() {
    let block = block(
        "struct A { u: f32, v: f32, w: vec2<f32>, x: f32 }
         struct B { a: vec2<f32>, b: vec3<f32>, c: f32, d: f32, e: A, f: vec3<f32>,
                    g: array<A, 3>, h: i32 }
         @group(0) @binding(0) var<storage, read_write> storage_buffer: B;",
    );
    let starts: Vec<u64> = block.members.iter().map(|m| m.offset.unwrap()).collect();
    assert_eq!(starts, [0, 16, 28, 32, 40, 64, 80, 152]);
    assert_eq!((block.size, block.align), (Some(160), Some(16)));
    assert_eq!(block.members[6].strides, [24]);
    let inner: Vec<u64> = block.members[4].members.iter().map(|m| m.offset.unwrap()).collect();
    assert_eq!(inner, [0, 4, 8, 16]);
    assert_eq!((&*block.name, block.instance.as_deref()), ("B", Some("storage_buffer")));
}

#[test]
fn the_specification_s_example_of_align_and_size() {
    let block = block(
        "struct A { u: f32, v: f32, w: vec2<f32>, @size(16) x: f32 }
         struct B { a: vec2<f32>, b: vec3<f32>, c: f32, d: f32, @align(16) e: A, f: vec3<f32>,
                    g: array<A, 3>, h: i32 }
         @group(0) @binding(0) var<uniform> uniform_buffer: B;",
    );
    let starts: Vec<u64> = block.members.iter().map(|m| m.offset.unwrap()).collect();
    assert_eq!(starts, [0, 16, 28, 32, 48, 80, 96, 192]);
    assert_eq!((block.size, block.align), (Some(208), Some(16)));
    assert_eq!(block.members[6].strides, [32]);
}

#[test]
fn every_type_of_the_specification_s_table_has_its_alignment_and_size() {
    // WGSL §14.4.1, the table "Alignment and size".
    let table = [
        ("i32", 4, 4),
        ("u32", 4, 4),
        ("f32", 4, 4),
        ("f16", 2, 2),
        ("atomic<u32>", 4, 4),
        ("vec2<f32>", 8, 8),
        ("vec2<f16>", 4, 4),
        ("vec3<f32>", 16, 12),
        ("vec3h", 8, 6),
        ("vec4<f32>", 16, 16),
        ("vec4h", 8, 8),
        ("mat2x2<f32>", 8, 16),
        ("mat2x2h", 4, 8),
        ("mat3x2f", 8, 24),
        ("mat3x2<f16>", 4, 12),
        ("mat4x2f", 8, 32),
        ("mat4x2h", 4, 16),
        ("mat2x3f", 16, 32),
        ("mat2x3h", 8, 16),
        ("mat3x3<f32>", 16, 48),
        ("mat3x3h", 8, 24),
        ("mat4x3f", 16, 64),
        ("mat4x3h", 8, 32),
        ("mat2x4f", 16, 32),
        ("mat2x4h", 8, 16),
        ("mat3x4f", 16, 48),
        ("mat3x4h", 8, 24),
        ("mat4x4<f32>", 16, 64),
        ("mat4x4h", 8, 32),
    ];
    for (ty, align, size) in table {
        let block = block(&format!("enable f16; var<storage, read_write> x: {ty};"));
        let member = &block.members[0];
        assert_eq!((member.align, member.size), (Some(align), Some(size)), "{ty}");
    }
}

#[test]
fn a_store_type_that_is_no_struct_is_one_member_named_as_the_variable() {
    let block = block(
        "struct Particle { pos: vec3f, mass: f32 }
         @group(1) @binding(2) var<storage, read_write> data: array<Particle>;",
    );
    assert_eq!((&*block.name, block.instance.as_deref()), ("data", None));
    assert_eq!((block.group, block.binding), (Some(1), Some(2)));
    assert_eq!(offsets(&block), [("data[].pos", 0), ("data[].mass", 12)]);
    assert_eq!(block.leaves[0].dims, [ArrayLen::Runtime]);
    assert_eq!(block.leaves[0].strides, [16]);
    assert_eq!(block.space, AddressSpace::Storage);
}

#[test]
fn names_may_be_used_before_they_are_declared_and_through_aliases() {
    let block = block(
        "@binding(B) @group(0) var<uniform> u: Frame;
         alias Frame = Inner;
         const B = 3 + 1;
         struct Inner { m: Mat, v: array<Row, COUNT>, }
         alias Row = vec4<Real>;
         alias Mat = mat4x4<f32>;
         alias Real = f32;
         const COUNT: u32 = 2u * 3u;",
    );
    assert_eq!(&*block.name, "Inner");
    assert_eq!(block.binding, Some(4));
    assert_eq!(block.size, Some(64 + 6 * 16));
}

#[test]
fn directives_attributes_and_other_declarations_are_passed_over() {
    let shader = laid_out(
        "enable f16, wgpu_ray_query; requires readonly_and_readwrite_storage_textures;
         diagnostic(off, derivative_uniformity);
         @id(7) override scale: f32 = 1.0;
         const_assert 1 < 2;
         struct In { @location(0) @interpolate(flat, either) a: vec2h,
                     @builtin(position) @invariant p: vec4f, @my_own(1, (2)) q: f32, };
         ;
         var<private> weird: no_such_type<3>;
         var<workgroup> tile: array<f32, scale_of(3)>;
         @group(0) @binding(0) var tex: texture_2d<f32>;
         @group(0) @binding(1) var store: texture_storage_2d<rgba8unorm, write>;
         @group(0) @binding(2) var<handle> acc: acceleration_structure;
         @must_use fn f(@builtin(vertex_index) i: u32) -> vec4<f32> { return not * valid }{ ; }
         @compute @workgroup_size(8, 8, 1) fn main() { /* } */ let a = b<c>(d); // }
         }
         var<immediate> pc: In;
         var<push_constant> older: vec4f;",
    );
    // The one stray brace pair after `f` is no declaration; no compiler has `my_own`; the last space is
    // naga's alone.
    let codes: Vec<_> = shader.diagnostics.iter().map(|d| d.code.name()).collect();
    assert_eq!(codes, ["syntax", "unknown-attribute", "unknown-address-space"]);
    let spaces: Vec<_> = shader.blocks.iter().map(|b| b.space).collect();
    assert_eq!(spaces, [AddressSpace::PushConstant, AddressSpace::PushConstant]);
    assert_eq!(offsets(&shader.blocks[0]), [("a", 0), ("p", 16), ("q", 32)]);
}

#[test]
fn lengths_are_const_expressions() {
    let cases = [
        ("", "4", 4),
        ("", "0x10u", 16),
        ("", "2 + 3 * 4", 14),
        ("", "(2 + 3) * 4", 20),
        ("", "1 << 4 | 1", 17),
        ("", "(256 >> 2)", 64),
        ("", "7 % 4", 3),
        ("", "-(-5)", 5),
        ("", "~0u - 0xfffffff0u", 15),
        ("", "max(3, 9)", 9),
        ("", "u32(4.9)", 4),
        ("", "i32(true) + 1", 2),
        ("", "vec3(1, 5, 2).y", 5),
        ("", "vec2<u32>(6).yx.x", 6),
        ("", "vec3u(vec2u(1, 2), 3)[2]", 3),
        ("", "array(2, 4, 8)[1]", 4),
        ("", "array<i32, 2>(5, 6)[1]", 6),
        ("", "select(3, 4, (2 > 1))", 4),
        ("", "select(3, 4, false && (1 / 0 == 0))", 3),
        ("const N = 3; const M = N * N;", "M + N", 12),
        ("const A: vec2<i32> = vec2(3, 4);", "A.x * A.y", 12),
        ("alias U = u32; const N: U = 5;", "U(N)", 5),
        ("const F = 2.5;", "u32(F * 2.0)", 5),
        ("override N: u32 = 6;", "N", 6),
        ("override N = 6; override M = N + 1;", "M * 2", 14),
        ("", "countOneBits(0xffu)", 8),
        ("", "select(vec2(3, 4), vec2(5, 6), vec2(1, 2) == vec2(1, 3)).y", 4),
        ("", "select(3, 4, any(vec2(1, 2) != vec2(1, 3)))", 4),
    ];
    for (declarations, expression, expected) in cases {
        assert_eq!(length(declarations, expression), Some(expected), "{expression}");
    }
}

#[test]
fn what_is_not_evaluated_here_is_asked_of_naga() {
    let cases = [
        ("struct P { a: u32, b: u32 } const p = P(3, 4);", "p.a + p.b", 7),
        ("const m = mat2x2<f32>(1.0, 2.0, 3.0, 4.0);", "u32(m[1].x)", 3),
        ("", "reverseBits(0x80000000u) + 5u", 6),
        ("const K = 9.0;", "u32(saturate(K)) + 1u", 2),
    ];
    for (declarations, expression, expected) in cases {
        assert_eq!(length(declarations, expression), Some(expected), "{expression}");
    }
}

#[test]
fn overrides_are_recorded_and_their_defaults_lay_buffers_out() {
    let text = "@id(12) override COUNT: u32 = 4; override TWICE = COUNT * 2;
                var<storage> a: array<f32, TWICE>;";
    let shader = laid_out(text);
    assert_eq!(shader.blocks[0].size, Some(32));
    let told: Vec<_> = shader.diagnostics.iter().map(|d| (d.code.name(), d.severity)).collect();
    assert_eq!(told, [("override-sized-array", Severity::Warning)]);
    let known: Vec<_> = shader.overrides.iter().map(|o| (&*o.name, o.id, o.value)).collect();
    assert_eq!(known, [("COUNT", Some(12), Some(4)), ("TWICE", None, Some(8))]);
    for key in ["COUNT", "12"] {
        // The defaults lay buffers out: only workgroup memory has such lengths (WGSL §6.2.9).
        assert_eq!(with_overrides(text, &[(key, "5")]).blocks[0].size, Some(32));
    }
    assert_eq!(with_overrides(text, &[("TWICE", "3")]).blocks[0].size, Some(32));
    let shader = with_overrides(text, &[("COUNT", "many")]);
    assert_eq!(shader.diagnostics[0].code, "override-value");
}

#[test]
fn an_override_without_a_value_stands_only_where_a_runtime_sized_array_may() {
    let last = laid_out("override N: u32; var<storage> a: array<vec4f, N>;");
    assert_eq!(last.blocks[0].leaves[0].dims, [ArrayLen::Override("N".into())]);
    assert_eq!(last.overrides[0].value, None);
    let text = "override N: u32;
                struct S { a: array<vec4f, N>, b: f32 } var<storage> s: S;";
    let (message, _, help) = only_finding(text);
    golden().eq(
        message,
        str!["runtime-sized-array: `a` is runtime-sized, but it is not the last member"],
    );
    assert_eq!(help, "`N` has no default: pass `-O N=VALUE`");
    assert_eq!(with_overrides(text, &[("N", "2")]).blocks[0].size, Some(48));
}

#[test]
fn a_binding_array_is_an_array_of_blocks() {
    let block = block(
        "enable wgpu_binding_array; struct S { a: vec4f }
         @group(0) @binding(0) var<storage> s: binding_array<S, 4>;",
    );
    assert_eq!(block.count, [ArrayLen::Fixed(4)]);
    assert_eq!((&*block.name, block.size), ("S", Some(16)));
}

#[test]
fn comments_belong_to_the_member_before_or_below_them() {
    let text = "// far away

// about the block
/* and more */
@group(0) @binding(0) var<uniform> u: S; // behind it
struct S {
    // first
    // second
    @size(16) a: f32, // third
    b: vec4f /* fourth */,
    // nobody's
}";
    let shader = laid_out(text);
    let told = |spans: &[landfall_layout::Span]| -> Vec<String> {
        spans.iter().map(|span| shader.files.text(*span).to_string()).collect()
    };
    let block = &shader.blocks[0];
    assert_eq!(told(&block.comment), ["// about the block", "/* and more */", "// behind it"]);
    assert_eq!(told(&block.members[0].comment), ["// first", "// second", "// third"]);
    assert_eq!(told(&block.members[1].comment), ["/* fourth */"]);
}

#[test]
fn the_insides_of_functions_are_known_without_their_braces() {
    let text = "fn a() {} fn b() -> f32 { if x { /* } */ } } var<uniform> u: vec4f;";
    let source = Source::new("test.wgsl", text);
    let parsed = landfall_layout::syntax::parse(&source, &ReadOptions::default(), false);
    let bodies: Vec<_> = parsed.bodies.iter().map(|body| parsed.files.text(*body)).collect();
    assert_eq!(bodies, ["", " if x { /* } */ } "]);
    assert_eq!(parsed.shape.blocks.len(), 1);
}
