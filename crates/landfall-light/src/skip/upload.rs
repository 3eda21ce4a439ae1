//! Upload only what changed, or everything: whichever is cheaper.
//!
//! A call costs as much as moving some number of bytes; ranges that are nearer than that are
//! better one. `cargo bench --bench light` measures the number.

use std::ops::Range;

use landfall_layout::Buffer;
use landfall_layout::buffer::Upload;

/// What to upload of a buffer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Choice {
    /// Nothing changed.
    Nothing,
    /// These ranges of bytes, a call each.
    Ranges(Vec<Range<usize>>),
    /// All of it, in one call.
    Whole,
}

/// What to upload of a buffer where a call costs as much as moving `call` bytes, and what either
/// way would move.
pub fn choose(buffer: &Buffer, call: usize) -> (Choice, Upload) {
    let upload = buffer.upload(call);
    let choice = if upload.ranges == 0 {
        Choice::Nothing
    } else if upload.whole_is_cheaper(call) {
        Choice::Whole
    } else {
        Choice::Ranges(buffer.dirty(call).collect())
    };
    (choice, upload)
}
