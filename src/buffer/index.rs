//! The leaves of a block by the hash of their path, so that a path is found without a search.
//!
//! A path is hashed with the digits between brackets left out, which makes the path of every
//! element that of the pattern. A second pass compares it with the pattern and adds up the
//! strides. What is not found here, whether another spelling or an error, goes to
//! [`resolve`](super::resolve).

use std::hash::Hasher;

use rustc_hash::FxHasher;

use super::grid::{Dim, Grid};
use crate::layout::BlockLayout;
use crate::shape::ArrayLen;

/// The leaves of a block, in buckets by hash.
#[derive(Debug)]
pub(crate) struct Index {
    /// Bucket `b` holds rows `starts[b]..starts[b + 1]`.
    starts: Box<[u32]>,
    rows: Box<[Row]>,
    /// The patterns of all rows.
    text: Box<[u8]>,
    /// The dimensions of all rows.
    dims: Box<[Dim]>,
    /// 64 less the bits of a bucket's number.
    shift: u32,
    /// The same for any two blocks laid out alike.
    pub fingerprint: u64,
}

/// A leaf as setting it needs it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    hash: u64,
    text: (usize, usize),
    dims: (usize, usize),
    /// Of its first element.
    pub offset: usize,
    pub grid: Grid,
    /// Whether its components follow each other without a gap.
    pub plain: bool,
}

impl Index {
    /// The index of a block whose size is known to fit.
    pub fn of(block: &BlockLayout) -> Index {
        let mut text = Vec::new();
        let mut dims = Vec::new();
        let mut rows = Vec::with_capacity(block.leaves.len());
        let mut print = FxHasher::default();
        for leaf in &block.leaves {
            let grid = Grid::of(&leaf.ty, leaf.matrix_stride, leaf.row_major);
            let Some((grid, offset)) = grid.zip(leaf.offset.and_then(|o| o.try_into().ok())) else {
                continue;
            };
            let (text_start, dims_start) = (text.len(), dims.len());
            text.extend_from_slice(leaf.path.as_bytes());
            dims.extend(leaf.dims.iter().zip(&leaf.strides).map(|(len, &stride)| Dim {
                len: match len {
                    ArrayLen::Fixed(len) => Some(*len as usize),
                    ArrayLen::Runtime | ArrayLen::Override(_) => None,
                },
                // A stride is less than the block's size, which fits.
                stride: stride as usize,
            }));
            print.write(leaf.path.as_bytes());
            print.write_usize(offset);
            let Grid { scalar, columns, rows: count, column_step, row_step } = grid;
            print.write(&[scalar.kind as u8, scalar.width, columns, count]);
            for number in [column_step, row_step] {
                print.write_usize(number);
            }
            for dim in &dims[dims_start..] {
                print.write_usize(dim.len.unwrap_or(usize::MAX));
                print.write_usize(dim.stride);
            }
            rows.push(Row {
                hash: hash(leaf.path.as_bytes()),
                text: (text_start, text.len()),
                dims: (dims_start, dims.len()),
                offset,
                grid,
                plain: grid.is_plain(),
            });
        }
        let bits = (2 * rows.len()).next_power_of_two().trailing_zeros().max(1);
        let shift = 64 - bits;
        rows.sort_by_key(|row| row.hash);
        let mut starts = vec![0u32; (1 << bits) + 1];
        for row in &rows {
            starts[(row.hash >> shift) as usize + 1] += 1;
        }
        for bucket in 1..starts.len() {
            starts[bucket] += starts[bucket - 1];
        }
        Index {
            starts: starts.into(),
            rows: rows.into(),
            text: text.into(),
            dims: dims.into(),
            shift,
            fingerprint: print.finish(),
        }
    }

    /// The leaf that a path names, and the offset of the element; `None` when it takes more
    /// thought. `tail` is the length of a runtime-sized dimension.
    #[inline]
    pub fn find(&self, path: &str, tail: usize) -> Option<(&Row, usize)> {
        let path = path.as_bytes();
        let hash = hash(path);
        let bucket = (hash >> self.shift) as usize;
        let (start, end) = (*self.starts.get(bucket)?, *self.starts.get(bucket + 1)?);
        self.rows.get(start as usize..end as usize)?.iter().filter(|row| row.hash == hash).find_map(
            |row| {
                let pattern = self.text.get(row.text.0..row.text.1)?;
                let dims = self.dims.get(row.dims.0..row.dims.1)?;
                let offset = place(path, pattern, dims, row.offset, tail)?;
                Some((row, offset))
            },
        )
    }
}

/// Compares a path with a pattern and adds up the offset of its element.
#[inline]
fn place(path: &[u8], pattern: &[u8], dims: &[Dim], start: usize, tail: usize) -> Option<usize> {
    let mut offset = start;
    let mut dims = dims.iter();
    let mut at = 0;
    for &wanted in pattern {
        if *path.get(at)? != wanted {
            return None;
        }
        at += 1;
        if wanted == b'[' {
            let dim = dims.next()?;
            let mut index = 0usize;
            let first = at;
            while let Some(digit) = path.get(at).map(|b| b.wrapping_sub(b'0')).filter(|&d| d < 10) {
                // Nine digits cannot overflow on any machine.
                if at - first == 9 {
                    return None;
                }
                index = index * 10 + usize::from(digit);
                at += 1;
            }
            if at == first || index >= dim.len.unwrap_or(tail) {
                return None;
            }
            offset += index * dim.stride;
        }
    }
    (at == path.len()).then_some(offset)
}

/// The hash of a path or pattern, digits between brackets left out.
///
/// Rotating by 5 keeps the loop at two cycles a byte, half of what a multiplication takes; the
/// one at the end spreads the bits.
#[inline]
fn hash(path: &[u8]) -> u64 {
    let mut hash = 0u64;
    let mut bytes = path.iter();
    while let Some(&byte) = bytes.next() {
        hash = hash.rotate_left(5) ^ u64::from(byte);
        if byte == b'[' {
            while let Some(digit) = bytes.as_slice().first() {
                if !digit.is_ascii_digit() {
                    break;
                }
                bytes.next();
            }
        }
    }
    hash.wrapping_mul(0x9e37_79b9_7f4a_7c15)
}
