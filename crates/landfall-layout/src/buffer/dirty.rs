//! Tracking of the bytes of a buffer written since the last upload.
//!
//! One bit stands for a word of 4 bytes: WebGPU rejects smaller uploads, and they are no faster
//! elsewhere. A bit map takes a 32nd of the block whatever the order of writes, marking is an `or`,
//! and neighbours merge by themselves; a sorted list of ranges would cost a search and a move for
//! each write of a scattered pattern.

use std::ops::Range;

pub(crate) const WORD: usize = 4;
const BITS: usize = 64;
const CLEAN: u64 = u64::MAX;

/// The words written since the last [`clear`](Dirty::clear).
#[derive(Clone, Debug)]
pub(crate) struct Dirty {
    /// Bit `i % 64` of entry `i / 64` is set while word `i` is clean, so that one test shows
    /// whether there is anything to mark; one entry more than needed.
    map: Vec<u64>,
    /// Bytes of the buffer.
    len: usize,
}

/// Precomputed bits for bytes at a known offset.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mark {
    /// The entry of the map; past its end if the bits span more than one entry.
    entry: usize,
    bits: u64,
}

impl Mark {
    pub fn of(offset: usize, size: usize) -> Mark {
        let (first, last) = (offset / WORD, (offset + size.max(1) - 1) / WORD);
        if first / BITS != last / BITS {
            return Mark { entry: usize::MAX, bits: 0 };
        }
        let bits = (u64::MAX >> (BITS - 1 - (last - first))) << (first % BITS);
        Mark { entry: first / BITS, bits }
    }
}

impl Dirty {
    pub fn new(len: usize) -> Dirty {
        Dirty { map: vec![CLEAN; len / (WORD * BITS) + 2], len }
    }

    /// Marks `size` bytes at `offset`; they lie within the buffer.
    pub fn mark(&mut self, offset: usize, size: usize) {
        if size == 0 {
            return;
        }
        let (first, last) = (offset / WORD, (offset + size - 1) / WORD);
        let (entry, bit) = (first / BITS, first % BITS);
        let count = last - first + 1;
        if bit + count > BITS {
            return self.mark_across(first, last);
        }
        let mask = (u64::MAX >> (BITS - count)) << bit;
        if let Some(bits) = self.map.get_mut(entry) {
            *bits &= !mask;
        }
    }

    /// Marks `size` bytes at `offset`, for which `mark` was precomputed.
    #[inline]
    pub fn mark_at(&mut self, mark: Mark, offset: usize, size: usize) {
        match self.map.get_mut(mark.entry) {
            // Bits already set are not stored again, so the next write need not wait for the store.
            Some(bits) if *bits & mark.bits == 0 => {}
            Some(bits) => *bits &= !mark.bits,
            None => self.mark(offset, size),
        }
    }

    /// Marks 1 to 64 words from `offset`, a multiple of 4 within the buffer.
    #[inline]
    pub fn mark_words(&mut self, offset: usize, count: usize) {
        let (entry, bit) = (offset / (WORD * BITS), offset / WORD % BITS);
        if bit > BITS - count {
            return self.mark(offset, count * WORD);
        }
        let mask = (u64::MAX >> (BITS - count)) << bit;
        if let Some(bits) = self.map.get_mut(entry) {
            // Bits already set are not stored again, so the next write need not wait for the store.
            if *bits & mask != 0 {
                *bits &= !mask;
            }
        }
    }

    fn mark_across(&mut self, first: usize, last: usize) {
        let (low, high) = (first / BITS, last / BITS);
        let low_mask = u64::MAX << (first % BITS);
        let high_mask = u64::MAX >> (BITS - 1 - last % BITS);
        self.map[low] &= !low_mask;
        self.map[low + 1..high].fill(!CLEAN);
        self.map[high] &= !high_mask;
    }

    pub fn clear(&mut self) {
        self.map.fill(CLEAN);
    }

    pub fn ranges(&self, gap: usize) -> Ranges<'_> {
        Ranges { dirty: self, word: 0, gap }
    }

    /// Returns the first word at or after `from` that is dirty, or clean.
    fn find(&self, from: usize, dirty: bool) -> Option<usize> {
        let flip = if dirty { u64::MAX } else { 0 };
        let mut entry = from / BITS;
        let mut bits = (self.map.get(entry)? ^ flip) & (u64::MAX << (from % BITS));
        while bits == 0 {
            entry += 1;
            bits = self.map.get(entry)? ^ flip;
        }
        Some(entry * BITS + bits.trailing_zeros() as usize)
    }
}

/// Dirty byte ranges in order, returned by [`Buffer::dirty`](super::Buffer::dirty).
///
/// Starts and ends are multiples of 4, except the end of a buffer whose length is not.
#[derive(Clone, Debug)]
pub struct Ranges<'b> {
    dirty: &'b Dirty,
    word: usize,
    gap: usize,
}

impl Iterator for Ranges<'_> {
    type Item = Range<usize>;

    fn next(&mut self) -> Option<Range<usize>> {
        let start = self.dirty.find(self.word, true)?;
        loop {
            // The map has a clean word after the last.
            let end = self.dirty.find(self.word.max(start), false)?;
            self.word = end;
            match self.dirty.find(end, true) {
                Some(next) if (next - end) * WORD <= self.gap => self.word = next,
                _ => return Some(start * WORD..(end * WORD).min(self.dirty.len)),
            }
        }
    }
}

/// The cost of uploading the dirty ranges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Upload {
    /// Number of ranges, and so of upload calls.
    pub ranges: usize,
    /// Bytes in the ranges.
    pub bytes: usize,
    /// Bytes of the whole buffer.
    pub whole: usize,
}

impl Upload {
    /// Whether one call with the whole buffer costs no more than one per range, if a call costs as
    /// much as moving `call` bytes.
    pub fn whole_is_cheaper(&self, call: usize) -> bool {
        let parts = call.saturating_mul(self.ranges).saturating_add(self.bytes);
        self.ranges > 0 && self.whole.saturating_add(call) <= parts
    }
}

#[cfg(test)]
// One range of bytes is what is meant.
#[allow(clippy::single_range_in_vec_init)]
mod tests {
    use super::*;

    fn ranges(dirty: &Dirty, gap: usize) -> Vec<Range<usize>> {
        dirty.ranges(gap).collect()
    }

    #[test]
    fn nothing_written_is_nothing_to_upload() {
        assert!(ranges(&Dirty::new(6160), 1 << 20).is_empty());
        assert!(ranges(&Dirty::new(0), 0).is_empty());
    }

    #[test]
    fn a_write_is_rounded_out_to_words_and_cut_at_the_end() {
        let mut dirty = Dirty::new(11);
        dirty.mark(1, 2);
        dirty.mark(9, 2);
        assert_eq!(ranges(&dirty, 0), [0..4, 8..11]);
    }

    #[test]
    fn gaps_up_to_the_one_chosen_are_uploaded_with_it() {
        let mut dirty = Dirty::new(4096);
        for offset in [512, 16, 32] {
            dirty.mark(offset, 12);
        }
        assert_eq!(ranges(&dirty, 3), [16..28, 32..44, 512..524]);
        assert_eq!(ranges(&dirty, 4), [16..44, 512..524]);
        assert_eq!(ranges(&dirty, 468), [16..524]);
    }

    #[test]
    fn writes_across_many_entries_are_one_range() {
        for (offset, size) in [(240, 40), (0, 256), (0, 4096), (252, 3000), (1020, 4)] {
            let mut dirty = Dirty::new(4096);
            dirty.mark(offset, size);
            assert_eq!(ranges(&dirty, 0), [offset..offset + size]);
            dirty.clear();
            assert!(ranges(&dirty, 0).is_empty());
        }
    }

    #[test]
    fn a_mark_made_beforehand_is_the_same_as_one_made_then() {
        for (offset, size) in [(0, 4), (252, 12), (16, 12), (1, 1), (508, 256), (1023, 2)] {
            let (mut then, mut beforehand) = (Dirty::new(2048), Dirty::new(2048));
            then.mark(offset, size);
            beforehand.mark_at(Mark::of(offset, size), offset, size);
            assert_eq!(then.map, beforehand.map, "{size} at {offset}");
        }
    }

    #[test]
    fn bits_agree_with_a_list_of_bytes() {
        let mut rng = fastrand::Rng::with_seed(1);
        for _ in 0..300 {
            let len = rng.usize(1..900) * 4;
            let mut dirty = Dirty::new(len);
            let mut bytes = vec![false; len + 4];
            for _ in 0..rng.usize(0..12) {
                let offset = rng.usize(0..len);
                let size = rng.usize(0..=(len - offset).min(600));
                dirty.mark(offset, size);
                if size > 0 {
                    bytes[offset / 4 * 4..(offset + size).next_multiple_of(4)].fill(true);
                }
            }
            let mut wanted = Vec::new();
            let mut start = None;
            for (at, &set) in bytes.iter().enumerate() {
                match (set, start) {
                    (true, None) => start = Some(at),
                    (false, Some(from)) => {
                        wanted.push(from..at);
                        start = None;
                    }
                    _ => {}
                }
            }
            assert_eq!(ranges(&dirty, 0), wanted);
        }
    }
}
