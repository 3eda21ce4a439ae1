//! Chooses between uploading the changed ranges of a buffer and all of it.
//!
//! A call costs as much as transferring some number of bytes; ranges closer together than that are
//! better merged. `cargo bench --bench light` measures that number.

use std::ops::Range;

use landfall_layout::Buffer;
use landfall_layout::buffer::Upload;

/// The bytes that could be transferred in place of a call, in many cases.
pub const CALL: usize = 1024;

#[derive(Clone, Debug, PartialEq, Eq)]
pub enum UploadChoice {
    Nothing,
    /// These byte ranges, one call each.
    Ranges(Vec<Range<usize>>),
    /// All of it, in one call.
    Whole,
}

/// Returns the cheaper choice, where a call costs as much as transferring `call` bytes, and the
/// bytes of either.
pub fn choose(buffer: &Buffer, call: usize) -> (UploadChoice, Upload) {
    let upload = buffer.upload(call);
    let choice = if upload.ranges == 0 {
        UploadChoice::Nothing
    } else if upload.whole_is_cheaper(call) {
        UploadChoice::Whole
    } else {
        UploadChoice::Ranges(buffer.dirty(call).collect())
    };
    (choice, upload)
}
