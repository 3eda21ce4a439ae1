//! The engine of Landfall's playground as WebAssembly: requests and answers in JSON, in three
//! functions of the C ABI. The page's `engine.js` is their only caller.
//!
//! `allocate(n)` returns `n` bytes for a request. `answer(at, n)` takes them back, and returns the
//! address of two words: where the answer is, and how many bytes it has. `release` frees that.

#![allow(unsafe_code, reason = "memory is passed to JavaScript by its address")]

use crate::playground;

/// Returns the address of `length` bytes, which [`answer`] takes.
#[unsafe(no_mangle)]
pub extern "C" fn allocate(length: usize) -> *mut u8 {
    Box::into_raw(vec![0u8; length].into_boxed_slice()).cast()
}

/// An answer: its text, without a terminator.
#[repr(C)]
#[derive(Debug)]
pub struct Answer {
    text: *mut u8,
    length: usize,
}

/// Answers a request.
///
/// # Safety
/// `request` and `length` are those of one call of [`allocate`], whose bytes are not used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn answer(request: *mut u8, length: usize) -> *mut Answer {
    // SAFETY: `allocate` made a box of this address and length, which nobody else owns.
    let request = unsafe { Box::from_raw(std::ptr::slice_from_raw_parts_mut(request, length)) };
    let text = playground::answer(&String::from_utf8_lossy(&request)).into_bytes();
    let (length, text) = (text.len(), Box::into_raw(text.into_boxed_slice()).cast());
    Box::into_raw(Box::new(Answer { text, length }))
}

/// Frees an answer.
///
/// # Safety
/// `given` comes from [`answer`] and is not used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn release(given: *mut Answer) {
    // SAFETY: `answer` made both boxes, which nobody else owns.
    unsafe {
        let Answer { text, length } = *Box::from_raw(given);
        drop(Box::from_raw(std::ptr::slice_from_raw_parts_mut(text, length)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_is_answered_through_memory() {
        let request =
            br#"{"path": "a.wgsl", "text": "", "want": [{"kind": "layout", "format": "csv"}]}"#;
        let at = allocate(request.len());
        // SAFETY: as the page does, which writes to what it has allocated and reads what it is given.
        let text = unsafe {
            std::ptr::copy_nonoverlapping(request.as_ptr(), at, request.len());
            let given = answer(at, request.len());
            let bytes = std::slice::from_raw_parts((*given).text, (*given).length);
            let text = String::from_utf8(bytes.to_vec()).expect("an answer is text");
            release(given);
            text
        };
        assert!(text.starts_with("{\"answers\":[{\"stdout\":\"shader,block,"), "{text}");
    }
}
