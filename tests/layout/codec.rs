//! JSON to the bytes of a block and back: known bytes, the identity on random blocks, and what
//! is said of bad input.

mod random;

use snapbox::str;

use crate::support::command::golden;
use crate::support::landfall::laid_out;
use fastrand::Rng;
use landfall_layout::buffer::{EncodeError, Finding, Missing, decode, encode, read_json};
use landfall_layout::shape::{ScalarKind, Type};
use landfall_layout::{ArrayLen, BlockLayout, Buffer, Leaf};

const LIGHTS: &str = "
    struct PointLight {
        vec3 pos; vec3 color; float intensity;
        float constant; float linear; float quadratic;
    };
    layout(std140) uniform PointLightBlock {
        PointLight data[128];
        int actually_used_count;
    } u_lights;
";

fn block(text: &str) -> BlockLayout {
    laid_out("test.comp", text).blocks.remove(0)
}

fn bytes(block: &BlockLayout, json: &str) -> Result<Vec<u8>, EncodeError> {
    encode(block, &read_json(json)?, Missing::Zero)
}

fn said(block: &BlockLayout, json: &str) -> String {
    bytes(block, json).unwrap_err().to_string()
}

fn text(block: &BlockLayout, bytes: &[u8]) -> String {
    serde_json::to_string(&decode(block, bytes).unwrap()).unwrap()
}

#[test]
fn members_land_where_std140_puts_them_and_the_rest_is_zero() {
    let block = block(LIGHTS);
    let json = r#"{
        "data": [{"pos": [1, 2, 3]}, {"color": [0.5, 0.25, 0.125], "intensity": 4}],
        "data[3].color": [5, 6, 7],
        "u_lights.data[4].pos.y": 8,
        "actually_used_count": 2
    }"#;
    let bytes = bytes(&block, json).unwrap();
    assert_eq!(bytes.len(), 6160);
    let mut wanted = vec![0u8; 6160];
    let mut put = |at: usize, value: f32| wanted[at..at + 4].copy_from_slice(&value.to_le_bytes());
    for (at, value) in [(0, 1.0), (4, 2.0), (8, 3.0), (64, 0.5), (68, 0.25), (72, 0.125), (76, 4.0)]
    {
        put(at, value);
    }
    for (at, value) in [(160, 5.0), (164, 6.0), (168, 7.0), (196, 8.0)] {
        put(at, value);
    }
    wanted[6144] = 2;
    assert_eq!(bytes, wanted);
}

#[test]
fn what_json_has_no_number_for_is_a_string() {
    let block = block("layout(std430) buffer B { float f[7]; double d; };");
    let json = r#"{"f":["nan","inf","-inf","nan:0x7fc00001","nan:0xff800001",-0.0,0.1],"d":"nan:0x7ff8000000000001"}"#;
    let bytes = bytes(&block, json).unwrap();
    let words: Vec<u32> =
        bytes[..28].chunks(4).map(|w| u32::from_le_bytes(w.try_into().unwrap())).collect();
    let wanted =
        [0x7fc0_0000, 0x7f80_0000, 0xff80_0000, 0x7fc0_0001, 0xff80_0001, 0x8000_0000, 0x3dcc_cccd];
    assert_eq!(words, wanted);
    assert_eq!(bytes[32..], [1, 0, 0, 0, 0, 0, 0xf8, 0x7f]);
    assert_eq!(text(&block, &bytes), json);
}

#[test]
fn matrices_are_arrays_of_columns_however_they_are_stored() {
    let json = r#"{"m":[[1.0,2.0,3.0],[4.0,5.0,6.0]]}"#;
    for (major, second) in [("column_major", 2.0f32), ("row_major", 4.0)] {
        let block = block(&format!("layout(std140, {major}) uniform B {{ mat2x3 m; }};"));
        let bytes = bytes(&block, json).unwrap();
        assert_eq!(bytes[4..8], second.to_le_bytes());
        assert_eq!(text(&block, &bytes), json);
    }
}

#[test]
fn a_runtime_sized_tail_is_as_long_as_what_is_given() {
    let block = block(
        "struct L { vec3 p; float i; };
        layout(std430) buffer B { uint n; L l[]; } b;",
    );
    let len = |json| bytes(&block, json).map(|bytes| bytes.len());
    assert_eq!(len(r#"{"n":1,"l":[{},{},{"i":1}]}"#), Ok(16 + 3 * 16));
    assert_eq!(len(r#"{"l[4].i":1}"#), Ok(16 + 5 * 16));
    assert_eq!(len(r#"{"b.l[4].i":1}"#), Ok(16 + 5 * 16));
    assert_eq!(len(r#"{"b":{"l":[{},{}]}}"#), Ok(16 + 2 * 16));
    // A buffer must hold one element even when none is given.
    assert_eq!(len("{}"), Ok(32));
    assert_eq!(len(r#"{"l":[]}"#), Ok(32));
    let error = said(&block, r#"{"l[99999999999].i":1}"#);
    golden().eq(
        error,
        str!["`B` would be 18,446,744,073,709,551,615 bytes, more than can be allocated"],
    );
    assert_eq!(decode(&block, &[0; 16 + 48]).unwrap().tail_len(), 3);
    assert_eq!(decode(&block, &[0; 4]).unwrap().tail_len(), 0);
    let longer = [0; 16 + 48 + 5];
    let longer = decode(&block, &longer).unwrap();
    assert_eq!(longer.notes, ["bytes past the last whole element of `l`: 5"]);
}

#[test]
fn missing_members_are_zero_or_an_error_as_asked() {
    let block =
        block("struct S { vec2 a; float b; }; layout(std140) uniform B { S s[2]; mat2 m; };");
    let missing = |json: &str| {
        let values = read_json(json).unwrap();
        encode(&block, &values, Missing::Error).map(|_| ()).map_err(|error| error.to_string())
    };
    let first = |path| {
        Err(format!("`{path}` is missing\nhelp: add it, or allow missing members to be zero"))
    };
    assert_eq!(missing("{}"), first("s[0].a"));
    assert_eq!(missing(r#"{"s":[{"a":[0,0],"b":0}]}"#), first("s[1].a"));
    assert_eq!(missing(r#"{"s":[{"a":[0,0],"b":0},{"a":[0,0]}]}"#), first("s[1].b"));
    let both = r#""s":[{"a":[0,0],"b":0},{"a.x":0,"a.y":0,"b":0}]"#;
    assert_eq!(missing(&format!("{{{both}}}")), first("m"));
    assert_eq!(missing(&format!("{{{both},\"m[0]\":[1,2]}}")), first("m"));
    assert_eq!(missing(&format!("{{{both},\"m[0]\":[1,2],\"m[1]\":[1,2]}}")), Ok(()));
    assert_eq!(bytes(&block, "{}").unwrap(), [0; 64]);
}

#[test]
fn bad_values_are_refused_with_their_place() {
    let block = block(LIGHTS);
    let cases = [
        r#"{"data":[{"colour":[1,2,3]}]}"#,
        r#"{"dta":[]}"#,
        r#"{"data[128].pos":[1,2,3]}"#,
        r#"{"data":[{},{"pos":[1,2]}]}"#,
        r#"{"data":[{"pos":[1,2,3,4]}]}"#,
        r#"{"data":[{"pos":1}]}"#,
        r#"{"data":{"pos":1}}"#,
        r#"{"data":[[1]]}"#,
        r#"{"data":[null]}"#,
        r#"{"data[3].pos":[1,"x",3]}"#,
        r#"{"data[3].pos":[1,1e39,3]}"#,
        r#"{"data[3].pos":[1,"nan:0x7f800000",3]}"#,
        r#"{"data[3].pos":[1,true,3]}"#,
        r#"{"actually_used_count":2147483648}"#,
        r#"{"actually_used_count":1.5}"#,
        r#"{"actually_used_count":"1"}"#,
        r#"{"data":[{"pos":[1,2,3]}],"data[0].pos.x":4}"#,
        "[]",
    ];
    let all: Vec<String> =
        cases.iter().map(|json| format!("{json}\n  {}\n", said(&block, json))).collect();
    golden().eq(all.concat(), str![[r#"
{"data":[{"colour":[1,2,3]}]}
  no member `colour` in `data[0]` (path `data[0].colour`)
help: did you mean `data[0].color`?
{"dta":[]}
  no member `dta` in the block (path `dta`)
help: did you mean `data`?
{"data[128].pos":[1,2,3]}
  index 128 in `data[128].pos` is out of range: the length is 128
{"data":[{},{"pos":[1,2]}]}
  `data[1].pos`: `vec3` has 3 elements, not 2
{"data":[{"pos":[1,2,3,4]}]}
  `data[0].pos`: `vec3` has 3 elements, not 4
{"data":[{"pos":1}]}
  `data[0].pos`: expected an array of 3 numbers for `vec3`, found 1
{"data":{"pos":1}}
  `data`: expected an array for `PointLight[128]`, found an object
{"data":[[1]]}
  `data[0]`: expected an object of members for `PointLight`, found an array of 1 value
{"data":[null]}
  `data[0]`: expected an object of members for `PointLight`, found null
{"data[3].pos":[1,"x",3]}
  `data[3].pos[1]`: expected a number, "inf", "-inf", "nan" or "nan:0x…" (a NaN by its bits) for `float`, found "x"
{"data[3].pos":[1,1e39,3]}
  `data[3].pos[1]`: 1e+39 does not fit `float`
{"data[3].pos":[1,"nan:0x7f800000",3]}
  `data[3].pos[1]`: "nan:0x7f800000" does not fit `float`
{"data[3].pos":[1,true,3]}
  `data[3].pos[1]`: expected a number for `float`, found true
{"actually_used_count":2147483648}
  `actually_used_count`: 2147483648 does not fit `int`
{"actually_used_count":1.5}
  `actually_used_count`: expected an integer for `int`, found 1.5
{"actually_used_count":"1"}
  `actually_used_count`: expected an integer for `int`, found "1"
{"data":[{"pos":[1,2,3]}],"data[0].pos.x":4}
  `data[0].pos.x`: its value is given twice
[]
  the block: expected an object of members for `PointLightBlock`, found an array of 0 values

"#]]);
    let many = format!(r#"{{"data":[{}]}}"#, vec!["{}"; 129].join(","));
    assert_eq!(said(&block, &many), "`data`: `PointLight[128]` has 128 elements, not 129");
}

#[test]
fn integers_fit_to_the_last_one() {
    let block = block(
        "#extension GL_EXT_shader_explicit_arithmetic_types : require
        layout(std430) buffer B { int64_t a; uint64_t b; int8_t c; uint16_t d; float16_t e; };",
    );
    let json =
        r#"{"a":-9223372036854775808,"b":18446744073709551615,"c":-128,"d":65535,"e":65504.0}"#;
    let made = bytes(&block, json).unwrap();
    assert_eq!(text(&block, &made), json);
    let cases = [
        r#"{"a":9223372036854775808}"#,
        r#"{"b":-1}"#,
        r#"{"c":128}"#,
        r#"{"c":-129}"#,
        r#"{"d":65536}"#,
        r#"{"e":65520}"#,
    ];
    let all: Vec<String> =
        cases.iter().map(|json| format!("{json}\n  {}\n", said(&block, json))).collect();
    golden().eq(
        all.concat(),
        str![[r#"
{"a":9223372036854775808}
  `a`: 9223372036854775808 does not fit `int64_t`
{"b":-1}
  `b`: -1 does not fit `uint64_t`
{"c":128}
  `c`: 128 does not fit `int8_t`
{"c":-129}
  `c`: -129 does not fit `int8_t`
{"d":65536}
  `d`: 65536 does not fit `uint16_t`
{"e":65520}
  `e`: 65520 does not fit `float16_t`

"#]],
    );
}

#[test]
fn malformed_json_is_refused_with_line_and_column() {
    let syntax = |json: &str| read_json(json).unwrap_err().to_string();
    assert_eq!(syntax("{\n  \"data\": [1,\n}"), "line 3, column 1: expected a value");
    golden().eq(syntax("{\"a\":1} x"), str!["line 1, column 9: expected nothing more"]);
    golden().eq(syntax(""), str!["line 1, column 1: the text ends before the value is complete"]);
    golden().eq(syntax("{\"a\": NaN}"), str!["line 1, column 7: expected a value"]);
    // Behind the last character that there is, as in scenes.
    assert_eq!(syntax("{\n"), "line 1, column 2: the text ends before the value is complete");
    let range = "line 1, column 7: expected a number in the range of `f64`";
    assert_eq!(syntax("[\"é\", 1e400]"), range);
    golden().eq(syntax("{\"a\":1,\n\"a\":2}"), str!["line 2, column 1: `a` is given twice"]);
}

#[test]
fn padding_that_is_not_zero_is_named_by_its_neighbours() {
    let block = block(LIGHTS);
    let mut bytes = vec![0u8; 6160];
    bytes[13] = 0xaa;
    bytes[14] = 0xbb;
    bytes[3 * 48 + 44] = 1;
    bytes[6159] = 2;
    bytes[48 + 16..48 + 20].copy_from_slice(&f32::NAN.to_le_bytes());
    bytes[48 + 28..48 + 32].copy_from_slice(&f32::NEG_INFINITY.to_le_bytes());
    let found = decode(&block, &bytes).unwrap().findings;
    let said: Vec<String> = found.list.iter().map(Finding::to_string).collect();
    assert_eq!(
        said,
        [
            "padding at byte 13 is not zero: aa bb, between `data[0].pos` and `data[0].color`",
            "`data[1].color.x` at byte 64 is not a number: nan",
            "`data[1].intensity` at byte 76 is infinite: -inf",
            "padding at byte 188 is not zero: 01, between `data[3].quadratic` and `data[4].pos`",
            "padding at byte 6159 is not zero: 02, after `actually_used_count`",
        ]
    );
    assert_eq!(found.more, 0);
    let all = decode(&block, &[0xff; 6160]).unwrap().findings;
    assert_eq!((all.list.len(), all.more), (1000, 128 * 12 + 1 - 1000));
}

#[test]
fn odd_bools_are_kept_and_flagged() {
    let block = block("layout(std430) buffer B { bool a; bool b; };");
    let bytes = [1, 0, 0, 0, 0xff, 0xff, 0xff, 0xff];
    let decoded = decode(&block, &bytes).unwrap();
    assert_eq!(decoded.findings.list.len(), 1);
    let json = serde_json::to_string(&decoded).unwrap();
    assert_eq!(json, r#"{"a":true,"b":4294967295}"#);
    assert_eq!(self::bytes(&block, &json).unwrap(), bytes);
}

#[test]
fn bytes_of_another_length_are_an_error_or_a_note() {
    let block = block(LIGHTS);
    let short = decode(&block, &[0; 160]).unwrap_err().to_string();
    assert_eq!(
        short,
        "`PointLightBlock` has 6,160 bytes, but 160 bytes were given: they end before or in \
         `data[3].color`"
    );
    let most = decode(&block, &[0; 6147]).unwrap_err().to_string();
    golden().eq(most, str!["`PointLightBlock` has 6,160 bytes, but 6,147 bytes were given: they end before or in `actually_used_count`"]);
    let bytes = [0; 6164];
    assert_eq!(decode(&block, &bytes[..6160]).unwrap().notes, [""; 0]);
    assert_eq!(
        decode(&block, &bytes[..6148]).unwrap().notes,
        ["6,148 bytes hold every member of `PointLightBlock`, but a buffer for it must hold 6,160"]
    );
    assert_eq!(
        decode(&block, &bytes).unwrap().notes,
        ["4 bytes follow the 6,160 of `PointLightBlock`"]
    );
}

/// Every element of a leaf: its path and offset, taken from the model alone.
fn elements(leaf: &Leaf, tail: u64) -> Vec<(String, u64)> {
    let mut all = vec![(leaf.path.clone(), leaf.offset.unwrap())];
    for (len, stride) in leaf.dims.iter().zip(&leaf.strides) {
        let len = match len {
            ArrayLen::Fixed(len) => u64::from(*len),
            ArrayLen::Runtime => tail,
            ArrayLen::Override(name) => panic!("{name}"),
        };
        let of = |(path, offset): &(String, u64)| {
            let at = |i| (path.replacen("[]", &format!("[{i}]"), 1), offset + i * stride);
            (0..len).map(at).collect::<Vec<_>>()
        };
        all = all.iter().flat_map(of).collect();
    }
    all
}

/// Offsets of the components of a leaf from its start, and their width and kind.
fn components(leaf: &Leaf) -> (Vec<u64>, u64, ScalarKind) {
    let (scalar, columns, rows) = match &leaf.ty {
        Type::Scalar(scalar) => (*scalar, 1, 1),
        Type::Vector { scalar, rows } => (*scalar, 1, *rows),
        Type::Matrix { scalar, columns, rows } => (*scalar, *columns, *rows),
        other => panic!("{other:?}"),
    };
    let (width, stride) = (u64::from(scalar.width), leaf.matrix_stride.unwrap_or(0));
    let at = |column: u8, row: u8| match leaf.row_major {
        true => u64::from(row) * stride + u64::from(column) * width,
        false => u64::from(column) * stride + u64::from(row) * width,
    };
    let all = (0..columns).flat_map(|column| (0..rows).map(move |row| at(column, row)));
    (all.collect(), width, scalar.kind)
}

/// Bits that try the edges of every format.
fn random_bits(rng: &mut Rng, width: u64, kind: ScalarKind) -> u64 {
    let bits = match (kind, rng.u8(0..8)) {
        (ScalarKind::Bool, _) => return rng.u64(0..2),
        // Exponent of all ones: NaN with a payload, or infinity.
        (ScalarKind::Float, 0) => {
            rng.u64(..) | [0, 0, 0x7c00, 0, 0x7f80_0000, 0, 0, 0, 0x7ff << 52][width as usize]
        }
        // -0.0, the least integer.
        (_, 1) => 1 << (8 * width - 1),
        (_, 2) => rng.u64(0..100),
        (_, 3) if width == 4 => rng.f32().to_bits().into(),
        (_, 3) if width == 8 => rng.f64().to_bits(),
        _ => rng.u64(..),
    };
    bits & (u64::MAX >> (64 - 8 * width))
}

#[test]
fn encoding_what_was_decoded_gives_the_same_bytes() {
    let (mut nans, mut tails, mut components_seen) = (0u64, 0u64, 0u64);
    for seed in 0..4000 {
        let shader = random::shader(seed);
        let block = block(&shader);
        let mut rng = Rng::with_seed(seed);
        let tail_leaf =
            block.leaves.iter().find(|leaf| leaf.dims.first() == Some(&ArrayLen::Runtime));
        let mut size = block.size.unwrap();
        let mut tail = 0;
        if let Some(leaf) = tail_leaf {
            let start = block.members.last().unwrap().offset.unwrap();
            size = size.max(start + rng.u64(0..4) * leaf.strides[0]);
            tail = (size - start) / leaf.strides[0];
            tails += 1;
        }
        let mut bytes = vec![0u8; size as usize];
        let mut flat = serde_json::Map::new();
        for leaf in &block.leaves {
            let (offsets, width, kind) = components(leaf);
            for (path, start) in elements(leaf, tail) {
                for offset in &offsets {
                    let bits = random_bits(&mut rng, width, kind);
                    let at = (start + offset) as usize;
                    bytes[at..at + width as usize]
                        .copy_from_slice(&bits.to_le_bytes()[..width as usize]);
                    components_seen += 1;
                }
                flat.insert(path, serde_json::Value::Null);
            }
        }
        let decoded = decode(&block, &bytes).unwrap();
        nans += decoded.findings.list.iter().filter(|f| matches!(f, Finding::Nan { .. })).count()
            as u64;
        assert!(
            !decoded.findings.list.iter().any(|f| matches!(f, Finding::Padding { .. })),
            "{shader}"
        );
        let json = serde_json::to_string(&decoded).unwrap();
        let values = read_json(&json).unwrap();
        let again = encode(&block, &values, Missing::Error)
            .unwrap_or_else(|e| panic!("{e}\n{shader}\n{json}"));
        assert!(again == bytes, "seed {seed}\n{shader}\n{json}");

        // The same from flat paths, each value as the buffer's own table names it.
        decoded.for_each(|element| {
            let cells: Vec<_> =
                element.cells.iter().map(|cell| serde_json::to_value(cell).unwrap()).collect();
            let value = match (element.cells.len(), element.rows) {
                (1, _) => cells[0].clone(),
                (len, rows) if len == rows => cells.into(),
                (_, rows) => cells.chunks(rows).map(<[_]>::to_vec).collect::<Vec<_>>().into(),
            };
            let slot =
                flat.get_mut(element.path).unwrap_or_else(|| panic!("{}\n{shader}", element.path));
            *slot = value;
        });
        let again = encode(&block, &flat.into(), Missing::Error)
            .unwrap_or_else(|e| panic!("{e}\n{shader}"));
        assert!(again == bytes, "seed {seed}, flat\n{shader}");
    }
    assert!(
        nans > 10_000 && tails > 1000,
        "{nans} NaNs, {tails} tails, {components_seen} components"
    );
}

/// Sets one component of a buffer by its path, from its bits.
fn set(buffer: &mut Buffer, path: &str, kind: ScalarKind, width: u64, bits: u64) {
    macro_rules! number {
        ($ty:ty) => {{
            let bytes = bits.to_le_bytes();
            let value = <$ty>::from_le_bytes(bytes[..size_of::<$ty>()].try_into().unwrap());
            buffer.set(path, value).unwrap();
            let read: $ty = buffer.get(path).unwrap();
            assert_eq!(read.to_le_bytes(), value.to_le_bytes());
        }};
    }
    match (kind, width) {
        (ScalarKind::Bool, _) => buffer.set(path, bits != 0).unwrap(),
        (ScalarKind::Sint, 1) => number!(i8),
        (ScalarKind::Sint, 2) => number!(i16),
        (ScalarKind::Sint, 4) => number!(i32),
        (ScalarKind::Sint, _) => number!(i64),
        (ScalarKind::Uint, 1) => number!(u8),
        (ScalarKind::Uint, 2) => number!(u16),
        (ScalarKind::Uint, 4) => number!(u32),
        (ScalarKind::Uint, _) => number!(u64),
        (ScalarKind::Float, 4) => number!(f32),
        (ScalarKind::Float, 8) => number!(f64),
        (kind, width) => panic!("{kind:?} of {width} bytes"),
    }
}

#[test]
fn a_buffer_set_component_by_component_holds_the_same_bytes() {
    for seed in 0..1500 {
        let shader = random::shader(seed);
        let block = block(&shader);
        let mut rng = Rng::with_seed(seed);
        let mut buffer =
            match block.leaves.iter().any(|l| l.dims.first() == Some(&ArrayLen::Runtime)) {
                true => Buffer::with_tail(&block, 3).unwrap(),
                false => Buffer::new(&block).unwrap(),
            };
        let mut bytes = vec![0u8; buffer.bytes().len()];
        for leaf in &block.leaves {
            let (offsets, width, kind) = components(leaf);
            let rows = match &leaf.ty {
                Type::Matrix { rows, .. } | Type::Vector { rows, .. } => usize::from(*rows),
                _ => 1,
            };
            for (path, start) in elements(leaf, buffer.tail_len() as u64) {
                for (i, offset) in offsets.iter().enumerate() {
                    let path = match &leaf.ty {
                        Type::Matrix { .. } => format!("{path}[{}][{}]", i / rows, i % rows),
                        Type::Vector { .. } => format!("{path}[{i}]"),
                        _ => path.clone(),
                    };
                    let at = (start + offset) as usize;
                    // Halves are set from f32, which has no room for their NaN's payload.
                    let bits = match (kind, width) {
                        (ScalarKind::Float, 2) => {
                            buffer.set(&path, 0.333_333_34f32).unwrap();
                            0x3555
                        }
                        _ => {
                            let bits = random_bits(&mut rng, width, kind);
                            set(&mut buffer, &path, kind, width, bits);
                            bits
                        }
                    };
                    bytes[at..at + width as usize]
                        .copy_from_slice(&bits.to_le_bytes()[..width as usize]);
                }
            }
        }
        assert!(buffer.bytes() == bytes, "seed {seed}\n{shader}");
        for range in buffer.dirty(0) {
            bytes[range].fill(0);
        }
        assert!(
            bytes.iter().all(|&byte| byte == 0),
            "written but not dirty: seed {seed}\n{shader}"
        );
    }
}
