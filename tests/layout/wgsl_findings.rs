//! What is said about WGSL text, and where: code, place and the smallest edit that mends it.

use snapbox::str;

use crate::support::command::golden;
use crate::wgsl::{block, laid_out, only_finding};
use landfall_layout::{Language, Severity};

/// The code of every finding, and the text it points at.
fn findings(text: &str) -> Vec<(&'static str, String)> {
    let shader = laid_out(text);
    let told = shader.diagnostics.iter().map(|d| {
        let at = d.labels.first().map_or("", |label| shader.files.text(label.at));
        (d.code.name(), at.to_string())
    });
    told.collect()
}

#[test]
fn unknown_types_are_named_with_the_nearest_name() {
    let (message, at, help) = only_finding("struct S { a: vec3ff } var<uniform> s: S;");
    assert_eq!(message, "unknown-type: unknown type `vec3ff`");
    assert_eq!((at.as_str(), help.as_str()), ("vec3ff", "did you mean `vec3f`?"));
    let (_, _, help) = only_finding("struct Light { a: f32 } var<uniform> s: Ligth;");
    assert_eq!(help, "did you mean `Light`?");
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
            ("syntax", "}".to_string()),
            ("syntax", ";".to_string()),
            ("syntax", "b".to_string()),
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
    // No compiler takes it, whatever its members mean.
    let text = "struct Unused { a: f32 b: nothing } var<uniform> u: vec4f;";
    assert_eq!(findings(text), [("syntax", "b".to_string())]);
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
    assert_eq!(codes, ["duplicate-name", "duplicate-name"]);
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
    assert_eq!(findings("alias A = f32\nvar<uniform> v: vec4f;"), [("syntax", "var".into())]);
}

#[test]
fn lines_of_other_tools_and_late_imports_are_refused_as_a_whole() {
    for (text, at) in [
        ("#pragma once\nvar<uniform> v: vec4f;", "#pragma"),
        ("struct S {\n#region\n a: f32,\n}\nvar<uniform> s: S;", "#region"),
        ("const a = 1; import package::b::c; var<uniform> l: vec4f;", "import"),
    ] {
        assert_eq!(findings(text), [("preprocessor", at.to_string())], "{text}");
    }
    let inside = "fn f() {\n#ifdef A\n#endif\n}\nvar<uniform> v: vec4f;";
    assert_eq!(findings(inside), []);
}

#[test]
fn old_bracket_attributes_are_explained() {
    let (_, _, help) = only_finding("[[block]] struct S { a: f32 }");
    golden().eq(help, str!["write `@group(0) @binding(0)` for `[[group(0), binding(0)]]`"]);
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
            assert_eq!((d.code.name(), d.severity), ("uniform-constraints", Severity::Warning));
            (shader.files.text(d.labels[0].at).to_string(), d.help.clone().unwrap())
        });
        told.collect::<Vec<_>>()
    };
    let found = warned("struct S { w: array<f32, 4> } var<uniform> s: S;");
    assert_eq!(found[0].0, "w");
    golden().eq(
        found[0].1.clone(),
        str!["pack them as `array<vec4<…>>`, or wrap each in `struct { @size(16) value: f32 }`"],
    );
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
