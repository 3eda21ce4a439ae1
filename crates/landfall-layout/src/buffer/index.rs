//! An automaton over the paths of a block's leaves that resolves a path without searching or
//! copying.
//!
//! A path is read in chunks: 8 bytes, or fewer up to and including a `[`, or the rest. The digits
//! after a `[` index the array named so far; reading continues at the `]`. Each chunk is a
//! transition between states, looked up in a hash table by state and chunk, so a match is exact and
//! each stride is known when its index is. Paths not matched here, whether other spellings or
//! errors, go to [`resolve`](super::resolve).

use std::hash::Hasher;

use rustc_hash::FxHasher;

use super::grid::{ComponentGrid, Dim};
use super::value::code;
use crate::layout::BlockLayout;
use crate::layout::measure::fixed;

/// The index of a block's leaves by path.
#[derive(Debug)]
pub(crate) struct LeafIndex {
    /// Slots, a power of two, probed linearly from the hash on.
    slots: Box<[TrieStep]>,
    /// A fingerprint of the layout, equal for blocks laid out alike.
    pub fingerprint: u64,
}

/// A transition from one state to the next by a chunk; one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct TrieStep {
    /// The chunk's bytes, the first one lowest; no name contains a zero byte.
    chunk: u64,
    /// The source state.
    from: u32,
    /// The target state; [`NOWHERE`] in a free slot.
    to: u32,
    /// Number of bytes in the chunk.
    size: usize,
    /// The array indexed next, if the chunk ends in `[`.
    dim: Dim,
    /// The leaf, if a path may end here.
    row: Row,
}

/// The data needed to set a leaf.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    /// Offset of the first element.
    pub offset: usize,
    /// The [`code`] of the type; [`NO_CODE`] where the components have gaps or no path ends.
    pub code: u32,
}

/// A code that no type has.
pub(crate) const NO_CODE: u32 = u32::MAX;

const START: u32 = 0;
const NOWHERE: u32 = u32::MAX;

/// Slots probed before giving up; a leaf that needs more is left to `resolve`, so that names made
/// to collide cost no more than others.
const PROBES: usize = 16;

const FREE: TrieStep = TrieStep {
    chunk: 0,
    from: NOWHERE,
    to: NOWHERE,
    size: 0,
    dim: Dim { len: None, stride: 0 },
    row: Row { offset: 0, code: NO_CODE },
};

impl LeafIndex {
    /// Builds the index of a block whose size is known to fit.
    pub fn from_block(block: &BlockLayout) -> LeafIndex {
        let chunks: usize = block.leaves.iter().map(|leaf| leaf.path.len() / 8 + 2).sum();
        let dims: usize = block.leaves.iter().map(|leaf| leaf.dims.len()).sum();
        // A small table is sparse, so that transitions rarely collide; a large one is kept small.
        let sparse = if chunks + dims < 1000 { 8 } else { 2 };
        let bits = (sparse * (chunks + dims)).next_power_of_two().trailing_zeros().max(4);
        let slots = vec![FREE; 1 << bits].into();
        let mut index = LeafIndex { slots, fingerprint: fingerprint(block) };
        let mut states = START;
        for leaf in &block.leaves {
            let grid = ComponentGrid::new(&leaf.ty, leaf.matrix_stride, leaf.row_major);
            let offset = leaf.offset.and_then(|offset| usize::try_from(offset).ok());
            // Matrices with gaps are left to `resolve`.
            let Some((grid, offset)) = grid.zip(offset).filter(|(grid, _)| grid.is_plain()) else {
                continue;
            };
            let dims = leaf.dims.iter().zip(&leaf.strides);
            let mut dims = dims.map(|(len, &stride)| Dim::new(len, stride));
            let path = leaf.path.as_bytes();
            let text = PathBytes::from_bytes(path);
            let (mut state, mut at) = (START, 0);
            while at < path.len() {
                let (chunk, size, opens) = chunk(text, at);
                at += size;
                // Left to `resolve`; the states so far serve other leaves.
                let Some(slot) = index.slot_for(state, chunk) else { break };
                let step = &mut index.slots[slot];
                if step.to == NOWHERE {
                    states += 1;
                    *step = TrieStep { chunk, from: state, to: states, size, ..FREE };
                }
                if opens {
                    // All leaves that come here share this array, and so its length and stride.
                    step.dim = dims.next().unwrap_or(FREE.dim);
                }
                if at == path.len() {
                    step.row = Row { offset, code: code(grid.scalar, grid.columns, grid.rows) };
                }
                state = step.to;
            }
        }
        index
    }

    /// Resolves a path to its leaf, at the offset of the element; `None` if it needs
    /// [`resolve`](super::resolve). `tail` is the length of a runtime-sized dimension.
    #[inline]
    pub fn find(&self, path: &str, tail: usize) -> Option<Row> {
        let path = path.as_bytes();
        let text = PathBytes::from_bytes(path);
        let (mut state, mut at, mut offset) = (START, 0, 0);
        // One transition for each chunk. Each `None` means that `resolve` finds the leaf or the
        // error.
        loop {
            let (chunk, size, opens) = chunk(text, at);
            at += size;
            let step = self.step(state, chunk)?;
            state = step.to;
            if opens {
                let (index, end) = number(path, at)?;
                if index >= step.dim.len.unwrap_or(tail) {
                    return None;
                }
                at = end;
                offset += index * step.dim.stride;
            } else if at >= path.len() {
                // Only the size tells zero bytes at the end of a path from padding of the chunk.
                let code = if size == step.size { step.row.code } else { NO_CODE };
                return Some(Row { offset: step.row.offset + offset, code });
            }
        }
    }

    #[inline]
    fn step(&self, state: u32, chunk: u64) -> Option<&TrieStep> {
        let home = self.home(state, chunk);
        let step = self.slots.get(home)?;
        if step.chunk == chunk && step.from == state {
            return Some(step);
        }
        self.probe(home, state, chunk)
    }

    #[inline(never)]
    fn probe(&self, home: usize, state: u32, chunk: u64) -> Option<&TrieStep> {
        (1..PROBES)
            .map(|probe| &self.slots[(home + probe) & (self.slots.len() - 1)])
            .take_while(|step| step.to != NOWHERE)
            .find(|step| step.chunk == chunk && step.from == state)
    }

    /// Returns the slot of a transition, or the free one for it.
    fn slot_for(&self, state: u32, chunk: u64) -> Option<usize> {
        let home = self.home(state, chunk);
        (0..PROBES).map(|probe| (home + probe) & (self.slots.len() - 1)).find(|&slot| {
            let step = &self.slots[slot];
            step.to == NOWHERE || (step.chunk == chunk && step.from == state)
        })
    }

    #[inline]
    fn home(&self, state: u32, chunk: u64) -> usize {
        // Fibonacci hashing: the factor is 2^64 divided by the golden ratio. The state goes into
        // the upper bytes, which most chunks leave zero.
        let mixed = chunk ^ u64::from(state).rotate_right(8);
        (mixed.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as usize & (self.slots.len() - 1)
    }
}

/// Repeats a byte 8 times.
const fn each(byte: u8) -> u64 {
    u64::from_le_bytes([byte; 8])
}

/// A path read 8 bytes at a time.
#[derive(Clone, Copy)]
struct PathBytes<'p> {
    bytes: &'p [u8],
    /// Its last 8 bytes, the very last one highest; zeros before a shorter path.
    last: u64,
}

impl<'p> PathBytes<'p> {
    #[inline]
    fn from_bytes(bytes: &'p [u8]) -> PathBytes<'p> {
        let last = match bytes.last_chunk() {
            Some(last) => u64::from_le_bytes(*last),
            None => bytes.iter().fold(0, |word, &byte| word >> 8 | u64::from(byte) << 56),
        };
        PathBytes { bytes, last }
    }

    /// Returns the 8 bytes from `at`, the first one lowest, and their number: those past the end
    /// are zero.
    #[inline]
    fn word(self, at: usize) -> (u64, usize) {
        let have = self.bytes.len().saturating_sub(at);
        if have < 8 {
            // With no bytes left this is a shift by 64.
            return (self.last.checked_shr(64 - 8 * have as u32).unwrap_or(0), have);
        }
        match self.bytes.get(at..).and_then(<[u8]>::first_chunk) {
            Some(word) => (u64::from_le_bytes(*word), 8),
            None => (0, 0),
        }
    }
}

/// Returns the high bit of the first byte equal to `byte` in a word, or 0.
#[inline]
fn first(word: u64, byte: u64) -> u64 {
    // A byte of `differs` is 0 where the word has `byte`; subtracting 1 from it borrows, which sets
    // its high bit.
    let differs = word ^ byte;
    // Bits above the lowest may be false positives.
    let found = differs.wrapping_sub(each(1)) & !differs & each(0x80);
    found & found.wrapping_neg()
}

/// Returns up to eight bytes of a path at `at` as a little-endian word, up to and with the first
/// `[`; their number; and whether they end in `[`.
#[inline]
fn chunk(path: PathBytes<'_>, at: usize) -> (u64, usize, bool) {
    let (word, have) = path.word(at);
    let bracket = first(word, const { each(b'[') });
    if bracket == 0 {
        return (word, have, false);
    }
    // All bits up to that one.
    (word & (bracket | (bracket - 1)), bracket.trailing_zeros() as usize / 8 + 1, true)
}

/// Returns the number of 1 to 9 digits at `at`, and the offset after it.
///
/// So few digits are read faster by a loop than by arithmetic on all at once.
#[inline]
fn number(path: &[u8], at: usize) -> Option<(usize, usize)> {
    let digit = |at: usize| path.get(at).map(|byte| byte.wrapping_sub(b'0')).filter(|&d| d < 10);
    let mut number = usize::from(digit(at)?);
    let mut end = at + 1;
    while let Some(digit) = digit(end) {
        // Nine digits cannot overflow on any machine.
        if end - at == 9 {
            return None;
        }
        number = number * 10 + usize::from(digit);
        end += 1;
    }
    Some((number, end))
}

/// Returns a fingerprint of the layout, equal for blocks laid out alike.
// All that a handle relies on, which works in any buffer with the same.
fn fingerprint(block: &BlockLayout) -> u64 {
    let mut print = FxHasher::default();
    for leaf in &block.leaves {
        print.write(leaf.path.as_bytes());
        print.write_u64(leaf.offset.unwrap_or(u64::MAX));
        if let Some(grid) = ComponentGrid::new(&leaf.ty, leaf.matrix_stride, leaf.row_major) {
            print.write_u32(code(grid.scalar, grid.columns, grid.rows));
            print.write_usize(grid.column_step);
            print.write_usize(grid.row_step);
        }
        for (len, stride) in leaf.dims.iter().zip(&leaf.strides) {
            print.write_u64(fixed(len).unwrap_or(u64::MAX));
            print.write_u64(*stride);
        }
    }
    print.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_1_to_9_digits() {
        for text in ["0", "7", "37", "128", "9999", "00012", "654321", "999999999"] {
            for (before, after) in [("data[", "].color"), ("d[", "]"), ("", "]"), ("", "")] {
                let path = format!("{before}{text}{after}");
                let wanted = Some((text.parse().unwrap(), before.len() + text.len()));
                assert_eq!(number(path.as_bytes(), before.len()), wanted, "{path}");
            }
        }
        for text in ["", "a", "a1", "-1", " 1", ":", "/", "1234567890", "\u{ff}", "\0"] {
            assert_eq!(number(format!("data[{text}]").as_bytes(), 5), None, "{text}");
        }
        assert_eq!(number(b"data[", 5), None);
    }

    #[test]
    fn chunks_end_after_a_bracket_after_8_bytes_or_at_the_end() {
        let word =
            |text: &str| text.bytes().rev().fold(0u64, |word, byte| word << 8 | u64::from(byte));
        let chunk = |text: &[u8], at| chunk(PathBytes::from_bytes(text), at);
        let path = b"data[37].intensity";
        assert_eq!(chunk(path, 0), (word("data["), 5, true));
        assert_eq!(chunk(path, 7), (word("].intens"), 8, false));
        assert_eq!(chunk(path, 15), (word("ity"), 3, false));
        assert_eq!(chunk(path, 18), (0, 0, false));
        assert_eq!(chunk(b"a[", 0), (word("a["), 2, true));
        assert_eq!(chunk(b"count", 0), (word("count"), 5, false));
        assert_eq!(chunk(b"[[[[[[[[", 0), (word("["), 1, true));
        assert_eq!(chunk(b"Z[Z\\\\[Z[", 1), (word("["), 1, true));
        assert_eq!(chunk(b"", 0), (0, 0, false));
    }
}
