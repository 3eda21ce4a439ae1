//! The neutral table every oracle answers with, and the comparison of two of
//! them. `spirv`, `driver` and `wgsl` fill it; it knows none of them.

use std::collections::HashMap;
use std::fmt;

/// One row of a layout as an oracle reports it: a scalar, vector or matrix at
/// the end of the tree, with the array dimensions along its path flattened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OracleLeaf {
    /// GL spelling without the block's name, array dimensions as `[]`:
    /// `data[].pos`, `w[]`.
    pub path: String,
    /// The shader's word for it: `float`, `dvec3`, `mat2x3`. SPIR-V has no
    /// `bool` in memory, so glslang says `uint` there.
    pub ty: String,
    /// Bytes from the start of the block to element zero of every dimension.
    pub offset: u64,
    /// Outermost first; `None` is runtime-sized.
    pub dims: Vec<Option<u64>>,
    /// Outermost first; `None` where the oracle does not say (OpenGL lists
    /// the elements of an array of structures one by one, so an array of one
    /// element shows no stride).
    pub strides: Vec<Option<u64>>,
    /// Bytes between columns (or rows), for matrices.
    pub matrix_stride: Option<u64>,
    /// Meaningful only with `matrix_stride`.
    pub row_major: bool,
}

/// One block as an oracle reports it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OracleBlock {
    /// The block's name, not the instance's.
    pub name: String,
    /// Lengths of an array of blocks, outermost first; empty for one block.
    pub count: Vec<Option<u64>>,
    /// What a buffer must hold, where the oracle says so. With a
    /// runtime-sized tail: as if that had one element.
    pub size: Option<u64>,
    /// The end of the last member, where the oracle says so.
    pub data_size: Option<u64>,
    pub leaves: Vec<OracleLeaf>,
}

/// What two oracles say differently.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// Only one of the two lists it.
    Presence,
    Count,
    Size,
    DataSize,
    Type,
    Offset,
    Dims,
    /// The stride of this dimension, outermost 0.
    Stride(usize),
    MatrixStride,
    RowMajor,
}

/// One disagreement between two tables.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    pub block: String,
    /// `None` for a fact about the block itself.
    pub path: Option<String>,
    pub what: What,
    pub left: String,
    pub right: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path = self.path.as_deref().unwrap_or("(the block)");
        write!(f, "{} {path}: {:?}: {} against {}", self.block, self.what, self.left, self.right)
    }
}

/// Everything both tables speak of and do not agree on. `None` on either side
/// is silence, not disagreement.
pub fn differences(left: &[OracleBlock], right: &[OracleBlock]) -> Vec<Difference> {
    let mut found = Vec::new();
    let rights: HashMap<&str, &OracleBlock> = right.iter().map(|b| (b.name.as_str(), b)).collect();
    let lefts: HashMap<&str, &OracleBlock> = left.iter().map(|b| (b.name.as_str(), b)).collect();
    for block in left {
        match rights.get(block.name.as_str()) {
            Some(other) => of_block(block, other, &mut found),
            None => found.push(presence(&block.name, None, true)),
        }
    }
    for block in right {
        if !lefts.contains_key(block.name.as_str()) {
            found.push(presence(&block.name, None, false));
        }
    }
    found
}

fn presence(block: &str, path: Option<&str>, on_the_left: bool) -> Difference {
    let (left, right) = if on_the_left { ("listed", "absent") } else { ("absent", "listed") };
    Difference {
        block: block.to_owned(),
        path: path.map(str::to_owned),
        what: What::Presence,
        left: left.to_owned(),
        right: right.to_owned(),
    }
}

fn of_block(left: &OracleBlock, right: &OracleBlock, found: &mut Vec<Difference>) {
    let name = left.name.as_str();
    if left.count != right.count {
        found.push(told(name, None, What::Count, &left.count, &right.count));
    }
    spoken(name, None, What::Size, left.size, right.size, found);
    spoken(name, None, What::DataSize, left.data_size, right.data_size, found);
    let rights: HashMap<&str, &OracleLeaf> =
        right.leaves.iter().map(|l| (l.path.as_str(), l)).collect();
    let lefts: HashMap<&str, &OracleLeaf> =
        left.leaves.iter().map(|l| (l.path.as_str(), l)).collect();
    for leaf in &left.leaves {
        match rights.get(leaf.path.as_str()) {
            Some(other) => of_leaf(name, leaf, other, found),
            None => found.push(presence(name, Some(&leaf.path), true)),
        }
    }
    for leaf in &right.leaves {
        if !lefts.contains_key(leaf.path.as_str()) {
            found.push(presence(name, Some(&leaf.path), false));
        }
    }
}

fn of_leaf(block: &str, left: &OracleLeaf, right: &OracleLeaf, found: &mut Vec<Difference>) {
    let path = Some(left.path.as_str());
    if left.ty != right.ty {
        found.push(told(block, path, What::Type, &left.ty, &right.ty));
    }
    if left.offset != right.offset {
        found.push(told(block, path, What::Offset, &left.offset, &right.offset));
    }
    if left.dims != right.dims {
        found.push(told(block, path, What::Dims, &left.dims, &right.dims));
        return;
    }
    for (dim, (l, r)) in left.strides.iter().zip(&right.strides).enumerate() {
        spoken(block, path, What::Stride(dim), *l, *r, found);
    }
    if left.matrix_stride != right.matrix_stride {
        found.push(told(
            block,
            path,
            What::MatrixStride,
            &left.matrix_stride,
            &right.matrix_stride,
        ));
    }
    if left.matrix_stride.is_some() && left.row_major != right.row_major {
        found.push(told(block, path, What::RowMajor, &left.row_major, &right.row_major));
    }
}

fn spoken(
    block: &str,
    path: Option<&str>,
    what: What,
    left: Option<u64>,
    right: Option<u64>,
    found: &mut Vec<Difference>,
) {
    if let (Some(l), Some(r)) = (left, right) {
        if l != r {
            found.push(told(block, path, what, &l, &r));
        }
    }
}

fn told<T: fmt::Debug>(
    block: &str,
    path: Option<&str>,
    what: What,
    left: &T,
    right: &T,
) -> Difference {
    Difference {
        block: block.to_owned(),
        path: path.map(str::to_owned),
        what,
        left: format!("{left:?}"),
        right: format!("{right:?}"),
    }
}
