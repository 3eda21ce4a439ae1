//! Waste and traps in a layout that is right: vec3 slots, padded columns, bools, strides.
//!
//! Numbers are computed by hand from OpenGL 4.6 §7.6.2.2 and WGSL §14.4.

use snapbox::str;

use landfall_layout::finding::Level;

use crate::lints_b::{found, help, one, said, std140};
use crate::support::command::golden;

#[test]
fn a_scalar_in_a_vec3s_slot_is_reported_with_both_offsets() {
    let finding = one("scalar-after-vec3", "a.frag", &std140("    vec3 color;\n    float gain;"));
    assert_eq!(
        said(&finding),
        "4:11 `gain` is at 12, in the last 4 bytes of the 16 that `color` is aligned to: a copy \
         whose `vec3` takes 16 bytes has it at 16"
    );
    assert_eq!((finding.related()[0].at.line, finding.related()[0].at.column), (3, 10));
    assert_eq!(help(&finding), "in the copy, give `color` 12 bytes and let `gain` follow directly");
    assert_eq!(finding.about, "B.gain");
}

#[test]
fn a_scalar_that_a_copy_cannot_misplace_is_not_reported() {
    for members in [
        "    float gain;\n    vec3 color;",    // in front
        "    vec3 color;\n    vec4 gain;",     // at 16 for everybody
        "    vec4 color;\n    float gain;",    // no slot is left open
        "    vec3 color[2];\n    float gain;", // an array's end is rounded: 32
        "    mat3 color;\n    float gain;",
    ] {
        assert_eq!(found("scalar-after-vec3", "a.frag", &std140(members)), [], "{members}");
    }
}

#[test]
fn a_member_of_a_structure_is_reported_once_for_all_its_uses() {
    let text = "#version 330 core
struct Light { vec3 color; float gain; };
layout(std140) uniform B { Light a; Light b[4]; };
layout(std140) uniform C { Light c; };
void main() {}
";
    let finding = one("scalar-after-vec3", "a.frag", text);
    assert_eq!((finding.place().line, finding.about.as_str()), (2, "Light.gain"));
}

#[test]
fn members_that_one_macro_declares_are_told_apart() {
    let text = "#version 330 core
#define LIGHT(n) vec3 n##Color; float n##Gain; vec3 n##Dir; float n##Angle;
layout(std140) uniform B { LIGHT(sun) };
void main() {}
";
    assert_eq!(found("scalar-after-vec3", "a.frag", text).len(), 2);
}

#[test]
fn a_vec3_array_is_reported_with_both_distances() {
    let finding = one("vec3-array", "a.frag", &std140("    vec3 samples[7];"));
    assert_eq!(
        said(&finding),
        "3:10 elements of `samples` are 16 bytes apart: packed `vec3`s are 12 apart, and only the \
         first is read correctly"
    );
    golden().eq(help(&finding), str!["upload 4 components per element, or declare `vec4 samples[7]`: 112 bytes as before, and the fourth component is free to use"]);
    assert_eq!(found("vec3-array", "a.frag", &std140("    vec4 samples[7];\n    vec3 one;")), []);
}

#[test]
fn each_hole_is_reported_with_its_bytes() {
    // By rule 4 a `vec3` is aligned to 16.
    let finding = one("implicit-padding", "a.frag", &std140("    float a;\n    vec3 b;"));
    assert_eq!(
        said(&finding),
        "4:10 12 bytes before `b` hold nothing: `a` ends at 4, and it is at 16"
    );
    assert_eq!(found("implicit-padding", "a.frag", &std140("    vec3 b;\n    float a;")), []);
}

#[test]
fn a_packed_vec3_array_under_scalar_rules_is_no_trap() {
    let text = "#version 450
#extension GL_EXT_scalar_block_layout : require
layout(scalar, set = 0, binding = 0) buffer B { vec3 samples[7]; float after; };
void main() {}
";
    assert_eq!(found("vec3-array", "a.comp", text), []);
    assert_eq!(found("scalar-after-vec3", "a.comp", text), []);
}

#[test]
fn an_array_of_vec3_in_wgsl_is_spelled_in_wgsl() {
    let text = "@group(0) @binding(0) var<storage> samples: array<vec3f>;\n";
    let finding = one("vec3-array", "a.wgsl", text);
    golden().eq(help(&finding), str!["upload 4 components per element, or declare `samples: array<vec4<f32>>`: 16 bytes per element as before, and the fourth component is free to use"]);
}

#[test]
fn a_padded_matrix_is_reported_with_both_sizes() {
    let finding = one("mat3-padding", "a.frag", &std140("    mat3 normal;"));
    assert_eq!(
        said(&finding),
        "3:10 `normal` is 3 columns of 12 bytes, 16 apart: 48 bytes, where a packed `mat3` is 36"
    );
    assert_eq!(help(&finding), "upload 4 components per column (`[[f32; 4]; 3]`)");
    assert_eq!(found("mat3-padding", "a.frag", &std140("    mat4 normal;\n    mat3x4 three;")), []);
}

#[test]
fn a_row_major_matrix_is_padded_by_rows() {
    // Three columns of two rows, by rows: two vectors of three components.
    let finding = one("mat3-padding", "a.frag", &std140("    layout(row_major) mat3x2 uv;"));
    golden().eq(
        said(&finding),
        str!["3:30 `uv` is 2 rows of 12 bytes, 16 apart: 32 bytes, where a packed `mat3x2` is 24"],
    );
}

#[test]
fn a_mat2_is_padded_in_std140_only() {
    let block = |rules: &str| {
        format!("#version 430 core\nlayout({rules}) buffer B {{ mat2 m; }};\nvoid main() {{}}\n")
    };
    let finding = one("mat3-padding", "a.comp", &block("std140"));
    golden().eq(
        said(&finding),
        str!["2:32 `m` is 2 columns of 8 bytes, 16 apart: 32 bytes, where a packed `mat2` is 16"],
    );
    assert_eq!(found("mat3-padding", "a.comp", &block("std430")), []);
}

/// OpenGL 4.6 §7.6.2.2, rule 7: R rows of C components. Column 1 of row 0 is one component after
/// the start, row 1 of column 0 one row; a `mat4` by columns has the two exchanged.
#[test]
fn a_row_major_matrix_is_reported_with_the_bytes_of_two_elements() {
    let finding = one("row-major-matrix", "a.frag", &std140("    layout(row_major) mat4 view;"));
    assert_eq!(landfall_lint::lint("row-major-matrix").map(|lint| lint.level), Some(Level::Allow));
    assert_eq!(
        said(&finding),
        "3:28 `view` is stored row-major: `view[1][0]` is 4 bytes after its start, `view[0][1]` \
         16, so a column-major copy is read transposed"
    );
    assert_eq!(
        help(&finding),
        "declare `layout(column_major)` for `view`, or upload its transpose"
    );
    // By columns: by default, and by a qualifier that overrides the block's.
    assert_eq!(found("row-major-matrix", "a.frag", &std140("    mat4 view;")), []);
    let block =
        std140("    layout(column_major) mat4 view; vec4 w[3];").replace("140", "140, row_major");
    assert_eq!(found("row-major-matrix", "a.frag", &block), []);
}

#[test]
fn row_major_is_followed_from_blocks_and_defaults_into_arrays_and_structures() {
    // A `mat4x3` of doubles by rows: three rows of 32 bytes. A `mat2` by rows in std430: 8 apart.
    let text = "#version 430 core
layout(row_major) uniform;
struct Bone { dmat4x3 pose; };
layout(std140) uniform Bones { Bone bones[2]; };
layout(std140) uniform Camera { layout(column_major) mat4 view; };
layout(std430, row_major) buffer Warps { mat2 warps[]; };
layout(std430) buffer Columns { Bone columns; };
void main() {}
";
    let found = found("row-major-matrix", "a.comp", text);
    let all: Vec<_> = found.iter().map(|finding| (said(finding), help(finding))).collect();
    golden().eq(format!("{all:#?}"), str![[r#"
[
    (
        "3:23 `pose` is stored row-major: `pose[1][0]` is 8 bytes after its start, `pose[0][1]` 32, so a column-major copy is read transposed",
        "declare `layout(column_major)` for the member of block `Bones` that holds `pose`, or upload its transpose",
    ),
    (
        "6:47 `warps` is stored row-major: `warps[0][1][0]` is 4 bytes after its start, `warps[0][0][1]` 8, so a column-major copy is read transposed",
        "declare `layout(column_major)` for `warps`, or upload its transpose",
    ),
]
"#]]);
    assert_eq!(found[0].about, "Bone.pose");
}

#[test]
fn a_bool_is_reported_with_both_sizes() {
    let found_here = found("bool-in-block", "a.frag", &std140("    bool on;\n    bvec3 mask[2];"));
    let said: Vec<String> = found_here.iter().map(said).collect();
    assert_eq!(
        said,
        [
            "3:10 `on` is a `bool` of 4 bytes, where the CPU has 1",
            "4:11 `mask` is a `bvec3` of 12 bytes, where the CPU has 3",
        ]
    );
    golden().eq(
        help(&found_here[1]),
        str!["declare `uvec3 mask[2]`, the same bytes, and compare with 0"],
    );
    assert_eq!(found("bool-in-block", "a.frag", &std140("    uint on;\n    uvec3 mask[2];")), []);
}

#[test]
fn a_float_array_is_reported_with_the_packing_and_the_bytes_saved() {
    let finding = one("array-stride-waste", "a.frag", &std140("    float w[64];"));
    assert_eq!(said(&finding), "3:11 `w` is 1,024 bytes: its elements are 4 bytes, 16 apart");
    assert_eq!(
        help(&finding),
        "declare `vec4 w[16]` and read `w[i / 4][i % 4]`: 256 bytes, 768 saved"
    );
}

#[test]
fn packings_have_room_for_every_element() {
    let cases = [
        ("int n[5];", "declare `ivec4 n[2]` and read `n[i / 4][i % 4]`: 32 bytes, 48 saved"),
        ("float w[4];", "declare `vec4 w` and read `w[i]`: 16 bytes, 48 saved"),
        ("vec2 p[3];", "declare `vec4 p[2]` and read `p[i / 2].xy` or `.zw`: 32 bytes, 16 saved"),
        (
            "float f[2][9];",
            "declare `vec4 f[2][3]` and read `f[i][j / 4][j % 4]`: 96 bytes, 192 saved",
        ),
        ("double d[4];", "declare `dvec2 d[2]` and read `d[i / 2][i % 2]`: 32 bytes, 32 saved"),
    ];
    for (member, wanted) in cases {
        let text = std140(member).replace("330", "430");
        assert_eq!(help(&one("array-stride-waste", "a.frag", &text)), wanted, "{member}");
    }
}

#[test]
fn arrays_that_waste_nothing_are_not_reported() {
    for member in ["vec4 w[16];", "mat4 m[4];", "vec3 v[4];", "float one[1];", "float plain;"] {
        assert_eq!(found("array-stride-waste", "a.frag", &std140(member)), [], "{member}");
    }
    let packed = "#version 430\nlayout(std430) buffer B { float w[64]; };\nvoid main() {}\n";
    assert_eq!(found("array-stride-waste", "a.comp", packed), []);
    // Where the driver decides, nobody knows what is wasted.
    let shared = "#version 330\nuniform B { float w[64]; };\nvoid main() {}\n";
    assert_eq!(found("array-stride-waste", "a.frag", shared), []);
}
