//! WGSL text to layouts and findings.
//!
//! Numbers come from the WGSL specification, §14.4, or are worked out beside the text.

use landfall::{
    AddressSpace, ArrayLen, BlockLayout, Language, Options, ReadOptions, Severity, ShaderLayout,
    Source,
};

fn laid_out(text: &str) -> ShaderLayout {
    landfall::layout(&Source::new("test.wgsl", text), &Options::default())
}

fn with_overrides(text: &str, overrides: &[(&str, &str)]) -> ShaderLayout {
    let overrides = overrides.iter().map(|(n, v)| (n.to_string(), v.to_string())).collect();
    let read = ReadOptions { overrides, ..ReadOptions::default() };
    landfall::layout(&Source::new("test.wgsl", text), &Options { read, ..Options::default() })
}

/// The only block of a text without findings.
fn block(text: &str) -> BlockLayout {
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

/// The code of every finding, and the text it points at.
fn findings(text: &str) -> Vec<(&'static str, String)> {
    let shader = laid_out(text);
    let told = shader.diagnostics.iter().map(|d| {
        let at = d.labels.first().map_or("", |label| shader.files.text(label.span));
        (d.code, at.to_string())
    });
    told.collect()
}

fn only_finding(text: &str) -> (String, String, String) {
    let shader = laid_out(text);
    assert_eq!(shader.diagnostics.len(), 1, "{text}\n{:#?}", shader.diagnostics);
    let found = &shader.diagnostics[0];
    let at = shader.files.text(found.labels[0].span).to_string();
    (format!("{}: {}", found.code, found.message), at, found.help.clone().unwrap_or_default())
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
    // The one stray brace pair after `f` is no declaration.
    let codes: Vec<_> = shader.diagnostics.iter().map(|d| d.code).collect();
    assert_eq!(codes, ["unexpected-token"]);
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
fn overrides_are_recorded_and_can_be_set_by_name_and_id() {
    let text = "@id(12) override COUNT: u32 = 4; override TWICE = COUNT * 2;
                var<storage> a: array<f32, TWICE>;";
    let shader = laid_out(text);
    assert_eq!(shader.blocks[0].size, Some(32));
    let told: Vec<_> = shader.diagnostics.iter().map(|d| (d.code, d.severity)).collect();
    assert_eq!(told, [("override-sized-array", Severity::Warning)]);
    let known: Vec<_> = shader.overrides.iter().map(|o| (&*o.name, o.id, o.value)).collect();
    assert_eq!(known, [("COUNT", Some(12), Some(4)), ("TWICE", None, Some(8))]);
    for key in ["COUNT", "12"] {
        assert_eq!(with_overrides(text, &[(key, "5")]).blocks[0].size, Some(40));
    }
    assert_eq!(with_overrides(text, &[("TWICE", "3")]).blocks[0].size, Some(12));
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
    assert!(message.starts_with("runtime-sized-array: `a`"), "{message}");
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
    let told = |spans: &[landfall::Span]| -> Vec<String> {
        spans.iter().map(|span| shader.files.text(*span).to_string()).collect()
    };
    let block = &shader.blocks[0];
    assert_eq!(told(&block.comment), ["// about the block", "/* and more */", "// behind it"]);
    assert_eq!(told(&block.members[0].comment), ["// first", "// second", "// third"]);
    assert_eq!(told(&block.members[1].comment), ["/* fourth */"]);
}

#[test]
fn unknown_types_are_named_with_the_nearest_name() {
    let (message, at, help) = only_finding("struct S { a: vec3ff } var<uniform> s: S;");
    assert_eq!(message, "unknown-type: there is no type named `vec3ff`");
    assert_eq!((at.as_str(), help.as_str()), ("vec3ff", "write `vec3f`"));
    let (_, _, help) = only_finding("struct Light { a: f32 } var<uniform> s: Ligth;");
    assert_eq!(help, "write `Light`");
    let (_, _, help) = only_finding("var<uniform> s: float4;");
    assert_eq!(help, "write `vec4f`");
}

#[test]
fn every_error_of_a_file_is_found() {
    let text = "struct A { a: vec5f, b: array<f32, 0>, c }
                struct B { a: f32; b: f32 }
                struct C { a: f32 b: f32 }
                var<storage> a: A; var<storage> b: B; var<storage> c: C;
                var<unifrom> d: B;
                var<storage> e: Missing;";
    assert_eq!(
        findings(text),
        [
            ("unknown-type", "vec5f".to_string()),
            ("array-size", "0".to_string()),
            ("unexpected-token", "}".to_string()),
            ("unexpected-token", ";".to_string()),
            ("unexpected-token", "b".to_string()),
            ("unknown-address-space", "unifrom".to_string()),
            ("unknown-type", "Missing".to_string()),
        ]
    );
}

#[test]
fn what_no_block_depends_on_is_not_looked_at() {
    let text = "struct Broken { a: nothing, b: array<f32, -1>, }
                const c = no_such(1); alias T = Nope;
                var<private> p: Broken; var<workgroup> w: T;
                fn f(x: Broken) -> T { }
                var<uniform> u: vec4f;";
    assert_eq!(findings(text), []);
}

#[test]
fn array_lengths_that_are_none_are_refused() {
    let cases = [
        ("0", "", "array-size"),
        ("-1", "", "array-size"),
        ("4294967296", "", "array-size"),
        ("2.0", "", "array-size"),
        ("1 / 0", "", "array-size"),
        ("v", "var<private> v: u32;", "array-size"),
        ("f()", "fn f() -> u32 { return 3u; }", "array-size"),
        ("n", "const m = 1;", "unknown-name"),
        ("n", "const n = n + 1;", "recursive-constant"),
    ];
    for (expression, declarations, code) in cases {
        let text = format!("{declarations} var<storage> a: array<f32, {expression}>;");
        let found = findings(&text);
        assert_eq!(found.len(), 1, "{expression}: {found:?}");
        assert_eq!(found[0].0, code, "{expression}");
    }
}

#[test]
fn structs_that_contain_themselves_are_refused() {
    let found = findings("struct A { b: B } struct B { a: array<A, 2> } var<storage> a: A;");
    assert_eq!(found, [("recursive-struct", "A".to_string())]);
}

#[test]
fn a_name_is_defined_once() {
    let text = "struct S { a: f32, a: u32 } struct T { a: f32 } alias T = f32; var<uniform> s: S;";
    let codes: Vec<_> = findings(text).into_iter().map(|f| f.0).collect();
    assert_eq!(codes, ["duplicate-definition", "duplicate-definition"]);
}

#[test]
fn types_without_bytes_are_refused_in_buffers() {
    let cases = [
        ("struct S { on: bool }", "uniform", "S", "bool"),
        ("struct S { on: vec2<bool> }", "storage", "array<S>", "vec2"),
        ("struct S { t: texture_2d<f32>, a: f32 }", "uniform", "S", "texture_2d"),
        ("", "uniform", "sampler", "sampler"),
        ("struct S { n: atomic<u32> }", "uniform", "S", "atomic"),
    ];
    for (declarations, space, ty, at) in cases {
        let found = findings(&format!("{declarations} var<{space}> s: {ty};"));
        assert_eq!(found, [("not-host-shareable", at.to_string())], "{ty}");
    }
    assert_eq!(findings("struct S { n: atomic<i32> } var<storage, read_write> s: S;"), []);
}

#[test]
fn runtime_sized_arrays_come_last_and_in_storage() {
    for text in [
        "struct S { a: array<f32>, b: f32 } var<storage> s: S;",
        "struct S { a: array<f32> } struct T { s: S } var<storage> t: T;",
        "var<storage> a: array<array<f32>, 2>;",
        "struct S { a: array<f32> } var<storage> a: array<S, 2>;",
        "var<uniform> a: array<vec4f>;",
    ] {
        let codes: Vec<_> = findings(text).into_iter().map(|f| f.0).collect();
        assert_eq!(codes, ["runtime-sized-array"], "{text}");
    }
    let block = block("struct S { n: u32, a: array<vec4f> } var<storage> s: S;");
    assert_eq!(block.members[1].offset, Some(16));
}

#[test]
fn align_and_size_must_fit_their_type() {
    let cases = [
        ("@align(3) a: f32", "invalid-align", "3", "write `@align(4)`"),
        ("@align(8) a: vec4f", "invalid-align", "8", "write `@align(16)`"),
        ("@align(0) a: f32", "invalid-align", "0", "write `@align(4)`"),
        ("@size(8) a: vec4f", "invalid-size", "8", "write `@size(16)`"),
        ("@size(64) a: array<f32>", "invalid-size", "64", "remove `@size`"),
        ("@align(-4) a: f32", "invalid-attribute", "-4", ""),
        ("@size(n) a: f32", "unknown-name", "n", ""),
    ];
    for (member, code, at, help) in cases {
        let (message, found, said) =
            only_finding(&format!("struct S {{ {member} }} var<storage> s: S; var<storage> t: S;"));
        assert!(message.starts_with(code), "{member}: {message}");
        assert_eq!((found.as_str(), said.as_str()), (at, help), "{member}");
    }
    let block = block(
        "const A = 32; struct S { a: f32, @align(A) @size(A * 2) b: f32 }
                       var<storage> s: S;",
    );
    assert_eq!((block.members[1].offset, block.size), (Some(32), Some(96)));
}

#[test]
fn what_is_left_open_is_said_once() {
    assert_eq!(findings("struct S { a: f32, \nvar<uniform> s: S;").len(), 2);
    assert_eq!(findings("fn f() { if x { }"), [("unclosed-brace", "{".to_string())]);
    assert_eq!(findings("var<uniform> v: vec4f; /* /* */"), [("unclosed-comment", "/*".into())]);
    assert_eq!(findings("fn f() { /* "), [("unclosed-comment", "/*".to_string())]);
    assert_eq!(
        findings("alias A = f32\nvar<uniform> v: vec4f;"),
        [("unexpected-token", "var".into())]
    );
}

#[test]
fn text_for_another_tool_is_refused_as_a_whole() {
    for (text, at) in [
        ("#import bevy_pbr::view\nvar<uniform> v: View;", "#import"),
        ("struct S {\n#ifdef A\n a: f32,\n#endif\n}\nvar<uniform> s: S;", "#ifdef"),
        ("import package::lights::Light; var<uniform> l: Light;", "import"),
        ("@if(FANCY) struct S { a: f32 } var<uniform> s: S;", "if"),
    ] {
        assert_eq!(findings(text), [("preprocessor", at.to_string())], "{text}");
    }
    let inside = "fn f() {\n#ifdef A\n#endif\n}\nvar<uniform> v: vec4f;";
    assert_eq!(findings(inside), []);
}

#[test]
fn old_bracket_attributes_are_explained() {
    let (_, _, help) = only_finding("[[block]] struct S { a: f32 }");
    assert!(help.contains("@group(0) @binding(0)"), "{help}");
}

#[test]
fn f16_without_its_directive_is_a_warning() {
    let shader = laid_out("var<storage> a: array<f16>; var<storage> b: vec2h;");
    assert_eq!(shader.blocks.len(), 2);
    assert_eq!(shader.diagnostics.len(), 1);
    assert_eq!(shader.diagnostics[0].severity, Severity::Warning);
}

#[test]
fn deep_text_gets_one_finding_and_no_stack_overflow() {
    let n = 10_000;
    let structs: String = (0..n).map(|i| format!("struct S{i} {{ s: S{} }}\n", i + 1)).collect();
    let aliases: String = (0..n).map(|i| format!("alias T{i} = T{};\n", i + 1)).collect();
    let arrays: String = (0..n).map(|i| format!("alias T{} = array<T{i}, 1>;\n", i + 1)).collect();
    for text in [
        format!("var<uniform> a: {}f32{};", "array<".repeat(n), ", 1>".repeat(n)),
        format!("var<uniform> a: array<f32, {}1{}>;", "(".repeat(n), ")".repeat(n)),
        format!("var<uniform> a: array<f32, {}1>;", "-".repeat(n)),
        format!("var<uniform> a: array<f32, {}1>;", "!(".repeat(n)),
        format!("var<uniform> a: array<f32, 1{}>;", "[0".repeat(n)),
        format!("var<uniform> a: array<f32, {}1>;", "max(".repeat(n)),
        format!("{structs} struct S{n} {{ a: f32 }} var<uniform> s: S0;"),
        format!("{aliases} alias T{n} = f32; var<uniform> s: T0;"),
        format!("alias T0 = vec4f; {arrays} var<uniform> s: T{n};"),
    ] {
        let codes: Vec<_> = findings(&text).into_iter().map(|f| f.0).collect();
        assert_eq!(codes, ["nested-too-deep"], "{}", &text[..40]);
    }
    let unclosed = format!("fn f() {{ {}", "{ /*".repeat(n));
    assert_eq!(findings(&unclosed).len(), 1);
}

#[test]
fn a_long_chain_of_constants_is_no_deep_text() {
    let chain: String = (0..5000).map(|i| format!("const C{} = C{i} + 1;\n", i + 1)).collect();
    let text = format!("const C0 = 1;\n{chain} var<storage> a: array<u32, C5000>;");
    assert_eq!(block(&text).size, Some(4 * 5001));
}

#[test]
fn structs_that_double_at_every_level_are_refused_in_no_time() {
    let structs: String =
        (0..60).map(|i| format!("struct S{} {{ a: S{i}, b: S{i} }}\n", i + 1)).collect();
    let text = format!("struct S0 {{ a: f32 }} {structs} var<uniform> s: S60;");
    assert_eq!(findings(&text), [("too-many-members", "s".to_string())]);
}

#[test]
fn findings_are_capped() {
    let text = "var<uniform> a: nope;".repeat(500);
    let shader = laid_out(&text);
    assert_eq!(shader.diagnostics.len(), 100);
    assert_eq!(shader.language, Language::Wgsl);
}

#[test]
fn uniform_memory_wants_more_than_the_rules() {
    let warned = |text: &str| {
        let shader = laid_out(text);
        assert_eq!(shader.blocks.len(), 1, "the layout stands");
        let told = shader.diagnostics.iter().map(|d| {
            assert_eq!((d.code, d.severity), ("uniform-constraints", Severity::Warning));
            (shader.files.text(d.labels[0].span).to_string(), d.help.clone().unwrap())
        });
        told.collect::<Vec<_>>()
    };
    let found = warned("struct S { w: array<f32, 4> } var<uniform> s: S;");
    assert_eq!(found[0].0, "w");
    assert!(found[0].1.contains("@size(16)"), "{found:?}");
    let found = warned("struct T { a: f32 } struct S { x: f32, t: T } var<uniform> s: S;");
    assert_eq!(found, [("t".to_string(), "write `@align(16) t: …`".to_string())]);
    let found = warned("struct T { a: f32 } struct S { t: T, x: f32 } var<uniform> s: S;");
    assert_eq!(found, [("x".to_string(), "write `@align(16) x: …`".to_string())]);
    let found = warned("struct T { a: vec2f } var<uniform> s: array<T, 3>;");
    assert_eq!(found, [("s".to_string(), "write `@align(16)` before `a` of `T`".to_string())]);
    // The mended twins.
    for good in [
        "struct W { @size(16) v: f32 } struct S { w: array<W, 4> } var<uniform> s: S;",
        "struct T { a: f32 } struct S { x: f32, @align(16) t: T } var<uniform> s: S;",
        "struct T { a: f32 } struct S { t: T, @align(16) x: f32 } var<uniform> s: S;",
        "struct T { @align(16) a: vec2f } var<uniform> s: array<T, 3>;",
        "struct T { a: f32 } struct S { x: f32, t: T } var<storage> s: S;",
    ] {
        assert_eq!(warned(good), [], "{good}");
    }
}

/// Uses most of what the reader knows, for the tests that damage it.
const RICH: &str = "enable f16; // größe
@id(3) override N: u32 = 4u * 2u; const K = vec3<u32>(1, 2, 3).z + u32(max(1.5, 2.0));
alias Row = array<vec4<f32>, K>;
struct Inner { @align(16) a: f16, /* x /* y */ */ @size(0x40) b: mat3x3<f32>, c: array<Row, N>, }
@group(0) @binding(K - 1) var<uniform> u: Inner; fn f(a: u32) -> u32 { return a; }
struct Tail { n: atomic<u32>, bits: array<Inner> };
@group(0) @binding(1) var<storage, read_write> tail: Tail;
var<storage> sel: array<f32, select(array(1, 2)[1], 3, (K > 2) && !(1 == 2))>;
@group(0) @binding(2) var t: texture_2d<f32>;
";

#[test]
fn damaged_text_gets_findings_and_never_a_panic() {
    let rich = RICH;
    assert!(!laid_out(rich).has_errors());
    for (at, removed) in rich.char_indices() {
        laid_out(&rich[..at]);
        laid_out(&rich[at..]);
        let rest = &rich[at + removed.len_utf8()..];
        laid_out(&format!("{}{rest}", &rich[..at]));
        for sign in ["{", "}", "(", ")", "<", ">", "@", ",", ";", "/*", "#", "[", "é", "0", "-"] {
            laid_out(&format!("{}{sign}{rest}", &rich[..at]));
        }
    }
}
