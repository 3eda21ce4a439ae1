//! Bytes by name: what is set lands where OpenGL 4.6 §7.6.2.2 puts it, and nothing else moves.

// One range of bytes is what is meant.
#![allow(clippy::single_range_in_vec_init)]

use snapbox::str;

use crate::support::command::golden;
use crate::support::landfall::laid_out;
use landfall_layout::buffer::{BufferError, Upload};
use landfall_layout::{BlockLayout, Buffer};

const LIGHTS: &str = "
    struct PointLight {
        vec3 pos; vec3 color; float intensity;
        float constant; float linear; float quadratic;
    };
    layout(std140) uniform PointLightBlock {
        PointLight data[128];
        int actually_used_count;
    } u_point_light_array;
";

fn block(text: &str) -> BlockLayout {
    let text = format!("#version 460\n{text}\nvoid main() {{}}\n");
    laid_out("test.comp", &text).blocks.remove(0)
}

fn f32_at(bytes: &[u8], offset: usize) -> f32 {
    f32::from_le_bytes(bytes[offset..offset + 4].try_into().unwrap())
}

fn said<T: std::fmt::Debug>(result: Result<T, BufferError>) -> String {
    result.unwrap_err().to_string()
}

/// Offsets of the floats that are not zero, with their values.
fn floats(buffer: &Buffer) -> Vec<(usize, f32)> {
    let all = (0..buffer.bytes().len()).step_by(4).map(|at| (at, f32_at(buffer.bytes(), at)));
    all.filter(|(_, value)| *value != 0.0).collect()
}

#[test]
fn color_of_the_fourth_light_is_at_160() {
    let mut buffer = Buffer::new(&block(LIGHTS)).unwrap();
    assert_eq!(buffer.bytes().len(), 6160);
    buffer.set("data[3].color", [1.0f32, 2.0, 3.0]).unwrap();
    assert_eq!(floats(&buffer), [(160, 1.0), (164, 2.0), (168, 3.0)]);
    buffer.set("data[127].quadratic", 4.0f32).unwrap();
    assert_eq!(f32_at(buffer.bytes(), 127 * 48 + 40), 4.0);
    buffer.set("actually_used_count", 128).unwrap();
    assert_eq!(buffer.bytes()[6144..6148], [128, 0, 0, 0]);
    assert_eq!(buffer.get::<[f32; 3]>("data[3].color").unwrap(), [1.0, 2.0, 3.0]);
    assert_eq!(buffer.get::<i32>("actually_used_count").unwrap(), 128);
}

#[test]
fn components_and_columns_can_follow_a_path() {
    let mut buffer = Buffer::new(&block(LIGHTS)).unwrap();
    buffer.set("data[3].color.y", 2.0f32).unwrap();
    buffer.set("data[3].color.b", 3.0f32).unwrap();
    buffer.set("data[3].color[0]", 1.0f32).unwrap();
    assert_eq!(buffer.get::<[f32; 3]>("data[3].color").unwrap(), [1.0, 2.0, 3.0]);
    assert_eq!(buffer.get::<f32>("data[3].color.t").unwrap(), 2.0);
    assert!(buffer.get::<f32>("data[3].color.w").is_err());
    assert!(buffer.get::<f32>("data[3].color.xy").is_err());
}

#[test]
fn the_instance_or_the_block_can_precede_a_path() {
    let mut buffer = Buffer::new(&block(LIGHTS)).unwrap();
    buffer.set("u_point_light_array.data[3].color", [1.0f32, 2.0, 3.0]).unwrap();
    assert_eq!(buffer.get::<f32>("PointLightBlock.data[3].color.z").unwrap(), 3.0);
}

#[test]
fn a_member_named_like_its_block_is_the_member() {
    let block = block("struct S { float x; }; layout(std140) uniform a { float x; S a; } b;");
    let mut buffer = Buffer::new(&block).unwrap();
    buffer.set("a.x", 1.0f32).unwrap();
    assert_eq!(floats(&buffer), [(16, 1.0)]);
    buffer.set("b.x", 2.0f32).unwrap();
    assert_eq!(floats(&buffer), [(0, 2.0), (16, 1.0)]);
}

#[test]
fn column_major_matrices_step_by_16_from_column_to_column() {
    let mut buffer = Buffer::new(&block("layout(std140) uniform B { mat2x3 m; };")).unwrap();
    buffer.set("m", [[1.0f32, 2.0, 3.0], [4.0, 5.0, 6.0]]).unwrap();
    let wanted = [(0, 1.0), (4, 2.0), (8, 3.0), (16, 4.0), (20, 5.0), (24, 6.0)];
    assert_eq!(floats(&buffer), wanted);
    assert_eq!(buffer.get::<[f32; 3]>("m[1]").unwrap(), [4.0, 5.0, 6.0]);
    assert_eq!(buffer.get::<f32>("m[1].y").unwrap(), 5.0);
    assert_eq!(buffer.dirty(0).collect::<Vec<_>>(), [0..28]);
}

#[test]
fn row_major_matrices_step_by_16_from_row_to_row() {
    let text = "layout(std140, row_major) uniform B { float a; mat2x3 m; };";
    let mut buffer = Buffer::new(&block(text)).unwrap();
    let value = [[1.0f32, 2.0, 3.0], [4.0, 5.0, 6.0]];
    buffer.set("m", value).unwrap();
    let wanted = [(16, 1.0), (20, 4.0), (32, 2.0), (36, 5.0), (48, 3.0), (52, 6.0)];
    assert_eq!(floats(&buffer), wanted);
    assert_eq!(buffer.get::<[[f32; 3]; 2]>("m").unwrap(), value);
    buffer.clear_dirty();
    buffer.set("m[1]", [7.0f32, 8.0, 9.0]).unwrap();
    assert_eq!([20, 36, 52].map(|at| f32_at(buffer.bytes(), at)), [7.0, 8.0, 9.0]);
    assert_eq!(buffer.dirty(0).collect::<Vec<_>>(), [20..24, 36..40, 52..56]);
    assert_eq!(buffer.upload(12), Upload { ranges: 1, bytes: 36, whole: 64 });
}

#[test]
fn arrays_of_arrays_step_by_each_dimension() {
    let text = "layout(std430) buffer B { float a; vec2 w[3][5]; };";
    let mut buffer = Buffer::new(&block(text)).unwrap();
    buffer.set("w[2][4]", [1.0f32, 2.0]).unwrap();
    let at = 8 + 2 * 40 + 4 * 8;
    assert_eq!(floats(&buffer), [(at, 1.0), (at + 4, 2.0)]);
    let handle = buffer.handle::<[f32; 2]>("w[2][]").unwrap();
    assert_eq!(buffer.get_at(&handle, [4]).unwrap(), [1.0, 2.0]);
    let handle = buffer.handle::<f32>("w[][].y").unwrap();
    assert_eq!(buffer.get_at(&handle, [2, 4]).unwrap(), 2.0);
}

#[test]
fn every_component_type_has_its_rust_type() {
    let text = "
        #extension GL_EXT_shader_explicit_arithmetic_types : require
        layout(std430) buffer B {
            bool b; bvec2 b2; double d; int64_t i64; uint64_t u64; int16_t i16; uint16_t u16;
            int8_t i8; uint8_t u8; float16_t f16; uvec3 u3; dmat2 dm;
        };";
    let mut buffer = Buffer::new(&block(text)).unwrap();
    buffer.set("b", true).unwrap();
    buffer.set("b2", [false, true]).unwrap();
    buffer.set("d", -0.1f64).unwrap();
    buffer.set("i64", i64::MIN).unwrap();
    buffer.set("u64", u64::MAX).unwrap();
    buffer.set("i16", -2i16).unwrap();
    buffer.set("u16", 65535u16).unwrap();
    buffer.set("i8", -3i8).unwrap();
    buffer.set("u8", 255u8).unwrap();
    buffer.set("f16", 1.0f32 / 3.0).unwrap();
    buffer.set("u3", [1u32, 2, 3]).unwrap();
    buffer.set("dm", [[1.0f64, 2.0], [3.0, 4.0]]).unwrap();
    let bytes = buffer.bytes();
    // std430: b 0, b2 8, d 16, i64 24, u64 32, i16 40, u16 42, i8 44, u8 45, f16 46, u3 48, dm 64.
    assert_eq!(bytes[0..16], [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0]);
    assert_eq!(bytes[16..24], (-0.1f64).to_le_bytes());
    assert_eq!(bytes[24..32], i64::MIN.to_le_bytes());
    assert_eq!(bytes[32..40], [255; 8]);
    assert_eq!(bytes[40..48], [0xfe, 0xff, 0xff, 0xff, 0xfd, 0xff, 0x55, 0x35]);
    assert_eq!(bytes[48..60], [1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0]);
    assert_eq!(bytes[88..96], 4.0f64.to_le_bytes());
    assert_eq!(buffer.get::<f32>("f16").unwrap(), 0.333_251_95);
    assert_eq!(buffer.get::<[bool; 2]>("b2").unwrap(), [false, true]);
}

#[test]
fn another_type_is_refused_by_both_names_and_nothing_is_written() {
    let mut buffer = Buffer::new(&block(LIGHTS)).unwrap();
    let text = said(buffer.set("data[3].color", [1.0f32, 2.0]));
    assert_eq!(text, "`data[3].color` is `vec3`, not `[f32; 2]`\nhelp: use `[f32; 3]`");
    let text = said(buffer.set("data[3].intensity", 1));
    assert_eq!(text, "`data[3].intensity` is `float`, not `i32`\nhelp: use `f32`");
    golden().eq(
        said(buffer.set("actually_used_count", 1u32)),
        str![[r#"
`actually_used_count` is `int`, not `u32`
help: use `i32`
"#]],
    );
    golden().eq(
        said(buffer.set("actually_used_count", true)),
        str![[r#"
`actually_used_count` is `int`, not `bool`
help: use `i32`
"#]],
    );
    golden().eq(
        said(buffer.set("data[3].color.x", 1.0f64)),
        str![[r#"
`data[3].color.x` is `float`, not `f64`
help: use `f32`
"#]],
    );
    golden().eq(
        said(buffer.handle::<[f32; 4]>("data[].pos")),
        str![[r#"
`data[].pos` is `vec3`, not `[f32; 4]`
help: use `[f32; 3]`
"#]],
    );
    assert!(buffer.bytes().iter().all(|&byte| byte == 0));
    assert_eq!(buffer.dirty(0).count(), 0);
}

#[test]
fn a_wrong_path_is_refused_with_what_would_be_right() {
    let mut buffer = Buffer::new(&block(LIGHTS)).unwrap();
    let mut said = |path: &str| said(buffer.set(path, [0.0f32; 3]));
    assert_eq!(
        said("data[3].colour"),
        "no member `colour` in `data[3]` (path `data[3].colour`)\n\
         help: did you mean `data[3].color`?"
    );
    assert_eq!(
        said("date[3].color"),
        "no member `date` in the block (path `date[3].color`)\nhelp: did you mean `data[3].color`?"
    );
    assert_eq!(
        said("data[128].color"),
        "index 128 in `data[128].color` is out of range: the length is 128"
    );
    golden().eq(said("data[99999999999999999999].color"), str!["index 18446744073709551615 in `data[99999999999999999999].color` is out of range: the length is 128"]);
    assert_eq!(said("data.color"), "`data.color` lacks the index of an array of 128 elements");
    golden().eq(
        said("data[].color"),
        str!["`data[].color` lacks the index of an array of 128 elements"],
    );
    assert_eq!(
        said("data"),
        "`data` is `PointLight[128]`, not a single value\nhelp: continue the path with an index"
    );
    golden().eq(
        said("data[3]"),
        str![[r#"
`data[3]` is `PointLight`, not a single value
help: continue the path with `.pos`, `.color`, `.intensity`, `.constant`, `.linear`, `.quadratic`
"#]],
    );
    assert_eq!(
        said("data[3].color[3]"),
        "index 3 in `data[3].color[3]` is out of range: the length is 3"
    );
    assert_eq!(
        said("data[3][1].color"),
        "`data[3]` is `PointLight` and takes no further index or component"
    );
    assert_eq!(
        said("data[3].intensity.x"),
        "`data[3].intensity` is `float` and takes no further index or component"
    );
    let mut all = String::new();
    for path in [
        "data[3",
        "data[-1].color",
        "data[3].",
        ".data",
        "data[3]color",
        "data[x].color",
        "data[3]..color",
        "[3]",
        "data[ 3].color",
        "u_point_light_array.",
        "é[1]",
        "data[é]",
        "data[3].color\0",
        "data[3].color\0\0",
        "data\0[3].color",
    ] {
        all += &format!("{path:?}: {}\n", said(path).replace('\0', "\\0"));
    }
    golden().eq(
        all,
        str![[r#"
"data[3": `data[3` is not a path: expected `]` at byte 6
"data[-1].color": `data[-1].color` is not a path: expected a number at byte 5
"data[3].": `data[3].` is not a path: expected a name at byte 8
".data": `.data` is not a path: expected a name at byte 0
"data[3]color": `data[3]color` is not a path: expected `.` or `[` at byte 7
"data[x].color": `data[x].color` is not a path: expected a number at byte 5
"data[3]..color": `data[3]..color` is not a path: expected a name at byte 8
"[3]": `[3]` is not a path: expected a name at byte 0
"data[ 3].color": `data[ 3].color` is not a path: expected a number at byte 5
"u_point_light_array.": `u_point_light_array.` is not a path: expected a name at byte 20
"é[1]": no member `é` in the block (path `é[1]`)
"data[é]": `data[é]` is not a path: expected a number at byte 5
"data[3].color\0": no member `color\0` in `data[3]` (path `data[3].color\0`)
help: did you mean `data[3].color`?
"data[3].color\0\0": no member `color\0\0` in `data[3]` (path `data[3].color\0\0`)
help: did you mean `data[3].color`?
"data\0[3].color": no member `data\0` in the block (path `data\0[3].color`)
help: did you mean `data[3].color`?

"#]],
    );
    assert!(buffer.bytes().iter().all(|&byte| byte == 0));
}

#[test]
fn a_handle_sets_what_its_path_does() {
    let block = block(LIGHTS);
    let mut buffer = Buffer::new(&block).unwrap();
    let color = buffer.handle::<[f32; 3]>("data[].color").unwrap();
    for i in 0..128 {
        buffer.set_at(&color, [i], [i as f32, 0.0, 1.0]).unwrap();
    }
    assert_eq!(buffer.get::<[f32; 3]>("data[77].color").unwrap(), [77.0, 0.0, 1.0]);
    assert_eq!(
        said(buffer.set_at(&color, [128], [0.0; 3])),
        "index 128 in `data[].color` is out of range: the length is 128"
    );
    golden().eq(
        said(buffer.set_at(&color, [], [0.0; 3])),
        str!["`data[].color` takes 1 indices, but 0 were given"],
    );
    let fixed = buffer.handle::<f32>("data[5].color.y").unwrap();
    buffer.set_at(&fixed, [], 9.0).unwrap();
    assert_eq!(f32_at(buffer.bytes(), 5 * 48 + 20), 9.0);
    // Another buffer of a block laid out alike takes it, one of another block does not.
    Buffer::new(&block).unwrap().set_at(&color, [1], [0.0; 3]).unwrap();
    let text = LIGHTS.replace("[128]", "[64]");
    let mut other = Buffer::new(&self::block(&text)).unwrap();
    golden().eq(
        said(other.set_at(&color, [1], [0.0; 3])),
        str!["the handle was created for another block than `PointLightBlock`"],
    );
}

#[test]
fn one_moved_light_is_one_range_of_12_bytes() {
    let mut buffer = Buffer::new(&block(LIGHTS)).unwrap();
    buffer.set("data[3].pos", [1.0f32, 2.0, 3.0]).unwrap();
    assert_eq!(buffer.dirty(64).collect::<Vec<_>>(), [144..156]);
    assert_eq!(buffer.upload(64), Upload { ranges: 1, bytes: 12, whole: 6160 });
    buffer.set("data[5].pos", [1.0f32, 2.0, 3.0]).unwrap();
    assert_eq!(buffer.dirty(83).collect::<Vec<_>>(), [144..156, 240..252]);
    assert_eq!(buffer.dirty(84).collect::<Vec<_>>(), [144..252]);
    buffer.clear_dirty();
    assert_eq!(buffer.dirty(84).count(), 0);
}

#[test]
fn the_whole_is_cheaper_once_calls_cost_more_than_bytes() {
    let mut buffer = Buffer::new(&block(LIGHTS)).unwrap();
    let pos = buffer.handle::<[f32; 3]>("data[].pos").unwrap();
    assert!(!buffer.upload(0).whole_is_cheaper(1 << 20));
    for light in 0..128 {
        buffer.set_at(&pos, [light], [1.0; 3]).unwrap();
    }
    let upload = buffer.upload(0);
    assert_eq!((upload.ranges, upload.bytes), (128, 1536));
    assert!(!upload.whole_is_cheaper(16));
    assert!(upload.whole_is_cheaper(64));
    assert!(!buffer.upload(64).whole_is_cheaper(64));
    buffer.mark_all();
    assert_eq!(buffer.dirty(0).collect::<Vec<_>>(), [0..6160]);
}

/// A mirror of `PointLight`: its bytes as a type that `bytemuck` knows already.
const LIGHT: [f32; 12] = [1.0, 2.0, 3.0, 0.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 0.0];

#[test]
fn a_mirror_is_written_over_its_element() {
    let mut buffer = Buffer::new(&block(LIGHTS)).unwrap();
    buffer.write_pod("data[3]", &LIGHT).unwrap();
    assert_eq!(buffer.get::<[f32; 3]>("data[3].color").unwrap(), [4.0, 5.0, 6.0]);
    assert_eq!(buffer.get::<f32>("data[3].quadratic").unwrap(), 10.0);
    assert_eq!(buffer.dirty(0).collect::<Vec<_>>(), [144..188]);
    assert_eq!(buffer.read_pod::<[f32; 12]>("data[3]").unwrap(), LIGHT);
    let text = said(buffer.write_pod("data[3]", &[0f32; 10]));
    assert_eq!(text, "`data[3]` is `PointLight` of 48 bytes, but the mirror has 40 bytes");
    assert!(buffer.write_pod("data[128]", &LIGHT).is_err());
    buffer.write_pod("data[4].pos", &[1f32, 2.0, 3.0]).unwrap();
}

#[test]
fn a_mirror_of_a_block_has_its_size_or_ends_with_its_data() {
    let block = block("layout(std140) uniform B { vec4 a; vec3 b; float c; vec2 d; } u;");
    let mut buffer = Buffer::new(&block).unwrap();
    buffer.write_pod("", &[1u32; 12]).unwrap();
    assert_eq!(buffer.bytes()[40..], [0; 8], "padding at the end stays zero");
    buffer.write_pod("u", &[2u32; 10]).unwrap();
    assert_eq!(buffer.bytes()[36..], [2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    golden().eq(
        said(buffer.write_pod("B", &[3u32; 11])),
        str!["`B` is `B` of 48 bytes, but the mirror has 44 bytes"],
    );
    assert_eq!(buffer.read_pod::<[u32; 12]>("").unwrap()[9..], [2, 0, 0]);
}

#[test]
fn mirrors_are_written_over_elements_that_follow_each_other() {
    let mut buffer = Buffer::new(&block(LIGHTS)).unwrap();
    buffer.write_slice("data[2]", &[LIGHT; 3]).unwrap();
    assert_eq!(buffer.dirty(0).collect::<Vec<_>>(), [96..236]);
    assert_eq!(buffer.get::<f32>("data[4].intensity").unwrap(), 7.0);
    buffer.write_slice("data", &[LIGHT; 128]).unwrap();
    assert_eq!(
        said(buffer.write_slice("data[126]", &[LIGHT; 3])),
        "index 128 in `data[126]` is out of range: the length is 128"
    );
    golden().eq(
        said(buffer.write_slice("data", &[0f32; 12])),
        str!["`data[]` is `PointLight` of 48 bytes, but the mirror has 4 bytes"],
    );
    golden().eq(
        said(buffer.write_slice("actually_used_count", &[0f32])),
        str!["`actually_used_count` is `int` and takes no further index or component"],
    );
}

#[test]
fn the_last_element_in_scalar_layout_leaves_the_next_member_alone() {
    let text = "
        #extension GL_EXT_scalar_block_layout : require
        #extension GL_EXT_shader_explicit_arithmetic_types : require
        struct S { double d; float f; };
        layout(scalar) buffer B { S s[2]; float after; };";
    let mut buffer = Buffer::new(&block(text)).unwrap();
    // Stride 16, but `s` ends with its last float at 28.
    buffer.set("after", 5.0f32).unwrap();
    assert_eq!(f32_at(buffer.bytes(), 28), 5.0);
    buffer.write_slice("s", &[[0u64; 2]; 2]).unwrap();
    buffer.write_pod("s[1]", &[0u64; 2]).unwrap();
    buffer.write_pod("s", &[[0u32; 4]; 2]).unwrap();
    assert_eq!(buffer.get::<f32>("after").unwrap(), 5.0);
}

#[test]
fn a_runtime_sized_tail_has_the_elements_it_was_made_with() {
    let text = "struct L { vec3 p; float i; };
        layout(std430) buffer B { vec4 head; uint count; L lights[]; } b;";
    let block = block(text);
    golden().eq(
        said(Buffer::new(&block)),
        str![[r#"
`B` ends in the runtime-sized array `lights[]`
help: say how many elements it has with `Buffer::with_tail`
"#]],
    );
    let mut buffer = Buffer::with_tail(&block, 3).unwrap();
    assert_eq!((buffer.bytes().len(), buffer.tail_len()), (32 + 3 * 16, 3));
    buffer.set("lights[2].i", 1.0f32).unwrap();
    assert_eq!(floats(&buffer), [(32 + 2 * 16 + 12, 1.0)]);
    assert_eq!(
        said(buffer.set("b.lights[3].i", 1.0f32)),
        "index 3 in `b.lights[3].i` is out of range: the runtime-sized array of this buffer was \
         made with 3 elements"
    );
    let handle = buffer.handle::<f32>("lights[].i").unwrap();
    golden().eq(said(buffer.set_at(&handle, [3], 1.0)), str!["index 3 in `lights[].i` is out of range: the runtime-sized array of this buffer was made with 3 elements"]);
    let fixed = buffer.handle::<f32>("lights[2].i").unwrap();
    let mut shorter = Buffer::with_tail(&block, 0).unwrap();
    assert_eq!(shorter.bytes().len(), 48);
    golden().eq(
        said(shorter.set_at(&fixed, [], 1.0)),
        str!["4 bytes at offset 76 end past the buffer's 48 bytes"],
    );
    buffer.write_slice("lights", &[[1f32; 4]; 3]).unwrap();
    assert!(buffer.write_slice("lights", &[[1f32; 4]; 4]).is_err());
    buffer.write_pod("", &[0u32; 5]).unwrap();
    assert_eq!(buffer.get::<f32>("lights[0].i").unwrap(), 1.0);
    let again = Buffer::from_bytes(&block, buffer.bytes()).unwrap();
    assert_eq!((again.tail_len(), again.bytes()), (3, buffer.bytes()));
}

#[test]
fn a_block_without_bytes_of_its_own_is_refused() {
    let loose = block("uniform vec3 color;");
    golden().eq(
        said(Buffer::new(&loose)),
        str![[r#"
`DefaultBlock` has no bytes: loose uniforms are set one by one
help: lay them out as one block with `gather`
"#]],
    );
    let fixed = block(LIGHTS);
    golden().eq(
        said(Buffer::with_tail(&fixed, 1)),
        str![[r#"
`PointLightBlock` does not end in a runtime-sized array
help: use `Buffer::new`
"#]],
    );
    let tail = block("layout(std430) buffer B { vec4 a[]; };");
    golden().eq(
        said(Buffer::with_tail(&tail, 1 << 40)),
        str!["`B` would be 18,446,744,073,709,551,615 bytes, more than can be allocated"],
    );
    golden().eq(
        said(Buffer::with_tail(&tail, usize::MAX)),
        str!["`B` would be 18,446,744,073,709,551,615 bytes, more than can be allocated"],
    );
    let text = said(Buffer::from_bytes(&fixed, &[0; 6148]));
    assert_eq!(text, "`PointLightBlock` has 6,160 bytes, but 6,148 bytes were given");
}

/// Values of glam land where arrays do, also where the matrix has padding or its rows are stored.
#[test]
fn values_of_glam_are_set_and_read_like_arrays() {
    let mut by_glam = Buffer::new(&block(
        "layout(std140) uniform B {
            vec2 a; vec3 b; vec3 c; vec4 d; ivec3 e; uvec2 f; dvec3 g;
            mat2 h; mat3 i; mat3 j; mat4 k; layout(row_major) mat3 l; dmat2 m;
        };",
    ))
    .unwrap();
    let mut by_arrays = by_glam.clone();
    let floats = |n: usize| std::array::from_fn::<f32, 16, _>(|i| (n * 100 + i) as f32);
    let mat3 = |n: usize| glam::Mat3::from_cols_slice(&floats(n)[..9]);
    let mat4 = glam::Mat4::from_cols_slice(&floats(5));
    macro_rules! both {
        ($($path:literal $ty:ty, $glam:expr, $array:expr;)*) => {$(
            by_glam.set($path, $glam).unwrap();
            by_arrays.set($path, $array).unwrap();
            assert_eq!(by_glam.get::<$ty>($path).unwrap(), $glam);
        )*};
    }
    both! {
        "a" glam::Vec2, glam::Vec2::new(1., 2.), [1f32, 2.];
        "b" glam::Vec3, glam::Vec3::new(3., 4., 5.), [3f32, 4., 5.];
        "c" glam::Vec3A, glam::Vec3A::new(6., 7., 8.), [6f32, 7., 8.];
        "d" glam::Vec4, glam::Vec4::new(9., 10., 11., 12.), [9f32, 10., 11., 12.];
        "e" glam::IVec3, glam::IVec3::new(-1, 2, -3), [-1, 2, -3];
        "f" glam::UVec2, glam::UVec2::new(4, 5), [4u32, 5];
        "g" glam::DVec3, glam::DVec3::new(0.1, 0.2, 0.3), [0.1, 0.2, 0.3];
        "h" glam::Mat2, glam::Mat2::from_cols_array(&[1., 2., 3., 4.]), [[1f32, 2.], [3., 4.]];
        "i" glam::Mat3, mat3(1), mat3(1).to_cols_array_2d();
        "j" glam::Mat3A, glam::Mat3A::from(mat3(2)), mat3(2).to_cols_array_2d();
        "k" glam::Mat4, mat4, mat4.to_cols_array_2d();
        "l" glam::Mat3, mat3(3), mat3(3).to_cols_array_2d();
        "m" glam::DMat2, glam::DMat2::from_cols_array(&[1., 2., 3., 4.]), [[1f64, 2.], [3., 4.]];
    }
    assert_eq!(by_glam.bytes(), by_arrays.bytes());
    let wrong = by_glam.set("b", glam::UVec3::ONE);
    assert!(matches!(wrong, Err(BufferError::WrongType { .. })), "{wrong:?}");
}

/// A component narrower than a word starts anywhere in one.
#[test]
fn narrow_components_are_dirty_wherever_they_start() {
    let text = "#extension GL_EXT_shader_16bit_storage : require
#extension GL_EXT_scalar_block_layout : require
layout(scalar) buffer B { int16_t a; i16vec2 b; int16_t c[3]; };";
    let mut buffer = Buffer::new(&block(text)).unwrap();
    let b = buffer.handle::<[i16; 2]>("b").unwrap();
    buffer.set_at(&b, [], [1, 2]).unwrap();
    assert_eq!(buffer.dirty(0).collect::<Vec<_>>(), [0..8]);
    buffer.clear_dirty();
    let c = buffer.handle::<i16>("c[]").unwrap();
    buffer.set_at(&c, [1], 3).unwrap();
    assert_eq!(buffer.dirty(0).collect::<Vec<_>>(), [8..12]);
    assert_eq!(buffer.bytes(), [0, 0, 1, 0, 2, 0, 0, 0, 3, 0, 0, 0]);
}

/// Blocks whose members are laid out alike may differ in the padding at their end.
#[test]
fn a_handle_works_with_buffers_of_another_length() {
    for count in [1usize, 31, 32, 33, 70] {
        let members: String = (0..count).map(|n| format!("float m{n};")).collect();
        let of = |layout| block(&format!("layout({layout}) buffer B {{ {members} }};"));
        let [short, long] = ["std430", "std140"].map(|layout| Buffer::new(&of(layout)).unwrap());
        let last = format!("m{}", count - 1);
        for [from, to] in [[&short, &long], [&long, &short]] {
            let handle = from.handle::<f32>(&last).unwrap();
            let mut to = to.clone();
            to.set_at(&handle, [], 1.0).unwrap();
            let range = 4 * (count - 1)..4 * count;
            let mut bytes = vec![0; to.bytes().len()];
            bytes[range.clone()].copy_from_slice(&1f32.to_ne_bytes());
            assert_eq!(to.bytes(), bytes);
            assert_eq!(to.dirty(0).collect::<Vec<_>>(), [range], "{count} members");
        }
    }
}

/// A matrix whose columns are apart stays so, whatever the length of the tail.
#[test]
fn a_matrix_with_padding_is_written_by_columns_at_any_length_of_the_tail() {
    let block = block("layout(std430) buffer B { mat3 m; float tail[]; };");
    let ones = [[1f32; 3]; 3];
    for (made, used) in [(0, 1 << 16), (1 << 16, 0), (3, 255), (1, 256)] {
        let handle = Buffer::with_tail(&block, made).unwrap().handle::<[[f32; 3]; 3]>("m").unwrap();
        let mut buffer = Buffer::with_tail(&block, used).unwrap();
        buffer.set_at(&handle, [], ones).unwrap();
        let floats: Vec<f32> = bytemuck::pod_collect_to_vec(&buffer.bytes()[..48]);
        assert_eq!(floats, [1., 1., 1., 0., 1., 1., 1., 0., 1., 1., 1., 0.]);
    }
}

/// A description made by hand or read from a file may be wrong.
#[test]
fn members_past_the_size_of_their_block_are_not_written() {
    let mut short = block("layout(std430) buffer B { float a; float b[4]; };");
    short.size = Some(8);
    let mut buffer = Buffer::new(&short).unwrap();
    let past = "4 bytes at offset 8 end past the buffer's 8 bytes";
    assert_eq!(said(buffer.set("b[1]", 1f32)), past);
    let second = buffer.handle::<f32>("b[1]").unwrap();
    assert_eq!(said(buffer.set_at(&second, [], 1f32)), past);
    let any = buffer.handle::<f32>("b[]").unwrap();
    assert_eq!(said(buffer.set_at(&any, [1], 1f32)), past);
    buffer.set_at(&any, [0], 1f32).unwrap();
    assert_eq!(buffer.dirty(0).collect::<Vec<_>>(), [4..8]);
    // As many components as the code of a `vec4` has in one byte.
    let mut vector =
        Buffer::new(&block("layout(std430) buffer B { vec4 a; float b[256]; };")).unwrap();
    assert!(said(vector.set("a", [0f32; 260])).contains("[f32; 260]"));
}
