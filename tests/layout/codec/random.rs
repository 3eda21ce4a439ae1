//! Random GLSL blocks from a seed: every component type, nested structures, arrays of arrays,
//! row-major matrices, runtime-sized tails.

use fastrand::Rng;

const SCALARS: &[&str] = &[
    "float",
    "int",
    "uint",
    "bool",
    "double",
    "float16_t",
    "int8_t",
    "uint8_t",
    "int16_t",
    "uint16_t",
    "int64_t",
    "uint64_t",
];
const VECTORS: &[&str] = &["", "i", "u", "b", "d", "f16", "i8", "u8", "i16", "u16", "i64", "u64"];
const MATRICES: &[&str] = &["", "d", "f16"];

/// The text of a shader with one block in it.
pub fn shader(seed: u64) -> String {
    let mut rng = Rng::with_seed(seed);
    let rules = ["std140", "std430", "scalar"][(seed % 3) as usize];
    let structs = rng.usize(0..4);
    let mut text = "#version 460\n\
        #extension GL_EXT_scalar_block_layout : require\n\
        #extension GL_EXT_shader_explicit_arithmetic_types : require\n"
        .to_string();
    for number in 0..structs {
        text += &format!("struct S{number} {{\n");
        for member in 0..rng.usize(1..6) {
            text += &member_text(&mut rng, number, &format!("m{member}"), false);
        }
        text += "};\n";
    }
    let major = ["", ", row_major", ", column_major"][rng.usize(0..3)];
    let instance = rng.bool();
    text += &format!("layout({rules}{major}) buffer Block {{\n");
    for member in 0..rng.usize(1..7) {
        text += &member_text(&mut rng, structs, &format!("b{member}"), true);
    }
    if rng.u8(0..3) == 0 {
        let inner = if rng.bool() { "[2]" } else { "" };
        text += &format!("  {} tail[]{inner};\n", type_text(&mut rng, structs));
    }
    text + if instance { "} block;\n" } else { "};\n" } + "void main() {}\n"
}

fn member_text(rng: &mut Rng, structs: usize, name: &str, in_block: bool) -> String {
    let ty = type_text(rng, structs);
    let major = match rng.u8(0..8) {
        0 if in_block && ty.contains("mat") => "layout(row_major) ",
        1 if in_block && ty.contains("mat") => "layout(column_major) ",
        _ => "",
    };
    let mut dims = String::new();
    while rng.u8(0..3) == 0 && dims.len() < 6 {
        dims += &format!("[{}]", rng.u8(1..4));
    }
    format!("  {major}{ty} {name}{dims};\n")
}

fn type_text(rng: &mut Rng, structs: usize) -> String {
    match rng.u8(0..8) {
        0 | 1 if structs > 0 => format!("S{}", rng.usize(0..structs)),
        0..=2 => SCALARS[rng.usize(0..SCALARS.len())].to_string(),
        3..=5 => format!("{}vec{}", VECTORS[rng.usize(0..VECTORS.len())], rng.u8(2..5)),
        _ => {
            let prefix = MATRICES[rng.usize(0..MATRICES.len())];
            format!("{prefix}mat{}x{}", rng.u8(2..5), rng.u8(2..5))
        }
    }
}
