//! The bytes of a block by an oracle of `leaf`: the components of its leaves are counted from 0, and
//! the `k`th of a block has a value of its own where its type has room for it.

use super::leaf::OracleLeaf;

/// Elements a runtime-sized dimension is given.
pub const TAIL: u64 = 3;

/// What a leaf is made of.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    pub columns: u64,
    pub rows: u64,
    /// Bytes of a component.
    pub width: u64,
    /// Whether it is a floating-point number of C.
    pub float: bool,
    pub signed: bool,
}

impl Shape {
    pub fn of(leaf: &OracleLeaf) -> Shape {
        let word = leaf.ty.as_str();
        let digits = |c: char| c.is_ascii_digit();
        let (prefix, columns, rows) = match (word.split_once("vec"), word.split_once("mat")) {
            (Some((prefix, rows)), _) => (prefix, "1", rows),
            (_, Some((prefix, size))) => {
                let (columns, rows) = size.split_once('x').unwrap_or((size, size));
                (prefix, columns, rows)
            }
            _ => (word, "1", "1"),
        };
        let (width, float) = match prefix {
            "" | "float" => (4, true),
            "d" | "double" => (8, true),
            "i" | "u" | "int" | "uint" => (4, false),
            word => {
                let bits: String = word.chars().filter(|c| digits(*c)).collect();
                (bits.parse::<u64>().unwrap_or_else(|_| panic!("type {word}")) / 8, false)
            }
        };
        let (columns, rows) = (columns.parse().expect("columns"), rows.parse().expect("rows"));
        Shape { columns, rows, width, float, signed: prefix.starts_with('i') }
    }
}

/// What the components of a leaf are that the shader declares as `bool`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Truth {
    /// Numbers as those of any other leaf.
    Number,
    /// 0 or 1.
    Bit,
}

/// Whether the `k`th component is true.
pub fn truth(k: u64) -> bool {
    k.is_multiple_of(3)
}

/// The length of each dimension.
pub fn counts(leaf: &OracleLeaf) -> Vec<u64> {
    leaf.dims.iter().map(|dim| dim.unwrap_or(TAIL)).collect()
}

pub fn element_offset(leaf: &OracleLeaf, indices: &[u64]) -> u64 {
    let strides = leaf.strides.iter().map(|s| s.expect("SPIR-V has every stride"));
    leaf.offset + strides.zip(indices).map(|(stride, i)| stride * i).sum::<u64>()
}

/// Puts the values of a leaf into an image of its block, and counts on.
pub fn fill(leaf: &OracleLeaf, image: &mut [u8], k: &mut u64, truths: Truth) {
    let Shape { columns, rows, width, float, .. } = Shape::of(leaf);
    let counts = counts(leaf);
    for element in 0..counts.iter().product::<u64>() {
        let mut rest = element;
        let mut indices = vec![0; counts.len()];
        for (index, count) in indices.iter_mut().zip(&counts).rev() {
            *index = rest % count;
            rest /= count;
        }
        let start = element_offset(leaf, &indices);
        for c in 0..columns {
            for r in 0..rows {
                let stride = leaf.matrix_stride.unwrap_or(0);
                let inside = if leaf.row_major && columns > 1 {
                    r * stride + c * width
                } else {
                    c * stride + r * width
                };
                let at = (start + inside) as usize;
                let bytes: Vec<u8> = match (width, float) {
                    _ if truths == Truth::Bit => u32::from(truth(*k)).to_le_bytes().to_vec(),
                    (1, _) => vec![(*k % 251 + 1) as u8],
                    (2, _) => ((*k % 65521 + 1) as u16).to_le_bytes().to_vec(),
                    (4, true) => ((*k + 1) as f32).to_le_bytes().to_vec(),
                    (4, false) => ((*k + 1) as u32).to_le_bytes().to_vec(),
                    (_, true) => ((*k + 1) as f64).to_le_bytes().to_vec(),
                    (_, false) => (*k + 1).to_le_bytes().to_vec(),
                };
                image[at..at + bytes.len()].copy_from_slice(&bytes);
                *k += 1;
            }
        }
    }
}
