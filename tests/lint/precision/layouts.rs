//! Lints of single blocks. `//<` marks each line that has to be reported.

use super::{Fixture, Score};

/// Blocks, by lint: those that are right stand beside those that are not.
pub const CORPUS: &[(&str, &[&str])] = &[
    (
        "array-stride-waste",
        &[
            "layout(std140) uniform B {\nfloat a[4]; //<\nvec4 b[4];\nmat4 c[2];\nfloat d;\n} b;",
            "layout(std140) uniform B {\nivec2 a[3]; //<\nuvec4 b[3];\nvec2 c;\n} b;",
            "layout(std430) buffer B {\nfloat a[4];\nvec2 b[3];\n} b;",
        ],
    ),
    (
        "bool-in-block",
        &[
            "layout(std140) uniform B {\nbool a; //<\nuint b;\nbvec3 c; //<\n} b;",
            "struct S {\nfloat a;\nbool b; //<\n};\nlayout(std430) buffer B {\nS s[];\n} b;",
            "layout(std140) uniform B {\nuint enabled;\nint is_on;\n} b;",
        ],
    ),
    (
        "mat3-padding",
        &[
            "layout(std140) uniform B {\nmat3 a; //<\nmat4 b;\nmat3x4 c;\n} b;",
            "layout(std430) buffer B {\nmat2x3 a; //<\nmat2 b;\nmat4x2 c;\n} b;",
            "layout(std140) uniform B {\nvec4 a[3];\nvec3 b;\n} b;",
        ],
    ),
    (
        "row-major-matrix",
        &[
            "layout(std140) uniform B {\nlayout(row_major) mat4 a; //<\nmat4 b;\n} b;",
            "layout(std140, row_major) uniform B {\nvec4 a;\nmat3x4 b; //<\nlayout(column_major) mat4 c;\n} b;",
            "layout(std430, column_major) buffer B {\nmat4 a;\n} b;",
        ],
    ),
    (
        "rules-undeclared",
        &[
            "uniform B { //<\nvec4 a;\n} b;",
            "buffer B { //<\nvec4 a;\n} b;",
            "layout(std140) uniform B {\nvec4 a;\n} b;",
            "layout(std430) buffer B {\nvec4 a;\n} b;",
            "layout(std140) uniform;\nuniform B {\nvec4 a;\n} b;",
        ],
    ),
    (
        "scalar-after-vec3",
        &[
            "layout(std140) uniform B {\nvec3 a;\nfloat b; //<\nvec4 c;\nfloat d;\n} b;",
            "struct S {\nvec3 a;\nuint b; //<\n};\nlayout(std430) buffer B {\nS s[];\n} b;",
            "layout(std140) uniform B {\nvec3 a;\nvec2 b;\nfloat c;\nvec3 d;\nvec3 e;\n} b;",
        ],
    ),
    (
        "implicit-padding",
        &[
            "layout(std140) uniform B {\nfloat a;\nvec3 b; //<\nvec2 c; //<\n} b;",
            "layout(std140) uniform B {\nvec3 a;\nfloat b;\nvec4 c[2];\nmat3 d;\n} b;",
            "struct S {\nuint a;\nvec2 b; //<\n};\nlayout(std430) buffer B {\nS s[4];\nfloat c;\n} b;",
            "layout(std430) buffer B {\nlayout(offset = 32) vec4 b; //<\nlayout(offset = 8) float a;\n} b;",
        ],
    ),
    (
        "vec3-array",
        &[
            "layout(std140) uniform B {\nvec3 a[4]; //<\nvec4 b[4];\nvec3 c;\n} b;",
            "layout(std430) buffer B {\nvec2 a[4];\nivec3 b[]; //<\n} b;",
            "struct S { vec3 a; float b; };\nlayout(std430) buffer B {\nS a[4];\n} b;",
        ],
    ),
    (
        "push-constant-limit",
        &[
            "layout(push_constant) uniform B { //<\nmat4 a;\nmat4 b;\nfloat c;\n} b;",
            "layout(push_constant) uniform B {\nmat4 a;\nmat4 b;\n} b;",
            "layout(std140) uniform B {\nmat4 a[9];\n} b;",
        ],
    ),
    (
        "reorder-saves",
        &[
            "layout(std430) buffer B { //<\nfloat a;\nvec4 b;\nfloat c;\n} b;",
            "layout(std430) buffer B {\nvec4 b;\nfloat a;\nfloat c;\n} b;",
            "layout(std430) buffer B {\nvec3 b;\nfloat a;\n} b;",
        ],
    ),
];

/// Bodies that use some of a block, by lint: in Vulkan's GLSL, as naga has to take the text.
pub const USES: &[(&str, &[&str])] = &[
    (
        "unused-block",
        &[
            "layout(set = 0, binding = 0) uniform A {\nvec4 a;\n} a;\n\
             layout(set = 0, binding = 1) uniform B { //<\nvec4 b;\n} b;\n\
             vec4 used() { return a.a; }",
            "layout(set = 0, binding = 0) uniform A {\nvec4 a;\n};\nvec4 used() { return a; }",
        ],
    ),
    (
        "unused-member",
        &[
            "layout(set = 0, binding = 0) uniform A {\nvec4 a;\nvec4 b; //<\nfloat c;\n} u;\n\
             vec4 used() { return u.a * u.c; }",
            // The instance has the name of a member, which a local variable has, too.
            "layout(set = 0, binding = 0) uniform A {\nvec4 a;\nvec4 b; //<\nfloat c;\n} a;\n\
             vec4 used() { return a.a * a.c; }",
            "struct S { vec4 a; };\nlayout(set = 0, binding = 0) uniform A {\nvec4 a; //<\nS b;\n\
             float c; //<\n} a;\nvec4 used() { vec4 sum = a.b.a; { vec4 a = sum; sum += a.x; } \
             return sum; }",
            "layout(set = 0, binding = 0) uniform A {\nvec4 a;\nvec4 b;\n};\n\
             vec4 used() { return a + b; }",
        ],
    ),
];

#[test]
fn blocks_on_which_one_lint_speaks_and_blocks_on_which_it_does_not() {
    let mut wrong = String::new();
    let all = CORPUS.iter().map(|(code, texts)| (code, texts, ""));
    for (code, texts, main) in all.chain(USES.iter().map(|(code, texts)| (code, texts, "used();")))
    {
        let whole = |text| format!("#version 460\n{text}\nvoid main() {{ {main} }}\n");
        let fixtures = texts.iter().map(|text| Fixture::marked(text, &whole(text)));
        wrong.push_str(&Score::of(code, &fixtures.collect::<Vec<_>>()).differences(code, texts));
    }
    assert_eq!(wrong, "");
}
