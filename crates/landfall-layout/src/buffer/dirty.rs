//! The bytes of a buffer, with a record of those written since the last upload.
//!
//! One bit stands for a word of 4 bytes: WebGPU rejects smaller uploads, and they are no faster
//! elsewhere. A bit map takes a 32nd of the block whatever the order of writes, marking clears bits,
//! and neighbours merge by themselves; a sorted list of ranges would cost a search and a move for
//! each write of a scattered pattern. The map follows the bytes in one allocation, and its entries
//! are counted from the end, so that a write loads one pointer and one length.

use std::ops::Range;

use super::value::Value;

pub(crate) const WORD: usize = 4;
const BITS: usize = 64;
/// Size of an entry of the map in bytes.
const ENTRY: usize = 8;

/// Bytes, and which of their words were written since the last [`clear`](Tracked::clear).
#[derive(Clone, Debug)]
pub(crate) struct Tracked {
    /// The bytes, followed by the map: entries of 64 bits in native order, the last one first, one
    /// more than needed. Bit `i % 64` of entry `i / 64` is set while word `i` is clean, so that one
    /// test shows whether there is anything to mark.
    data: Vec<u8>,
    /// Number of bytes without the map.
    len: usize,
}

/// Where a value is in buffers of one length: in the lower half the offset, as no block is larger than
/// 2^32 bytes, in the upper half where the entry of its bits starts, or [`NOWHERE`] if they span two
/// entries or it begins within a word. One word, as the number of loads limits how fast values are set.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DirtyPlace(u64);

/// Past the end of any map that has [places](Tracked::has_places).
const NOWHERE: usize = u32::MAX as usize - ENTRY;

impl DirtyPlace {
    pub fn offset(self) -> u32 {
        self.0 as u32
    }

    fn entry(self) -> usize {
        (self.0 >> 32) as usize
    }
}

/// Returns `count` bits from bit `first`.
#[inline]
fn mask(first: usize, count: usize) -> u64 {
    (u64::MAX >> (BITS - count)) << first
}

impl Tracked {
    /// Returns zeroes, all clean; `None` if there is not enough memory.
    pub fn zeroed(len: usize) -> Option<Tracked> {
        // One entry for the last, partly used 64 words, and one whose words are always clean.
        let map = (len / (WORD * BITS) + 2) * ENTRY;
        let mut tracked = Tracked { data: zeroed(len.checked_add(map)?)?, len };
        tracked.clear();
        Some(tracked)
    }

    /// Returns the place of `size` bytes at `offset`.
    pub fn place(&self, offset: usize, size: usize) -> DirtyPlace {
        // A value without bytes has the place of its first.
        let (first, last) = (offset / WORD, (offset + size.max(1) - 1) / WORD);
        let entry = self.data.len().checked_sub((first / BITS + 1) * ENTRY);
        let is_in_one = offset.is_multiple_of(WORD) && first / BITS == last / BITS;
        let entry = entry.filter(|_| is_in_one).unwrap_or(NOWHERE);
        DirtyPlace(u64::from(offset as u32) | (entry as u64) << 32)
    }

    /// Whether values can be stored [at places](Tracked::store_at): not in buffers of nearly 4 GiB.
    pub fn has_places(&self) -> bool {
        self.data.len() <= NOWHERE
    }

    #[inline]
    pub fn bytes(&self) -> &[u8] {
        &self.data[..self.len]
    }

    pub fn into_bytes(mut self) -> Vec<u8> {
        self.data.truncate(self.len);
        self.data
    }

    /// Returns bytes to write, which remain as clean or dirty as they are.
    pub fn bytes_mut(&mut self) -> &mut [u8] {
        &mut self.data[..self.len]
    }

    /// Returns `size` bytes at `offset` to write, marked; `None` if they end past the buffer.
    pub fn write(&mut self, offset: usize, size: usize) -> Option<&mut [u8]> {
        let end = offset.checked_add(size).filter(|&end| end <= self.len)?;
        mark(&mut self.data, offset, size);
        self.data.get_mut(offset..end)
    }

    /// Stores a value of whole words at `offset`; it lies within the buffer, or `false` is returned.
    #[inline]
    pub fn store<T: Value>(&mut self, offset: u32, value: T) -> bool {
        let (data, offset) = (&mut self.data[..], offset as usize);
        debug_assert!(offset + T::BYTES <= self.len, "past the end");
        let Some(to) = data.get_mut(offset..offset + T::BYTES) else { return false };
        value.store(to);
        // `value` has at most 16 words of 8 bytes, so that its bits span at most two entries.
        let (entry, bit) = (offset / WORD / BITS, offset / WORD % BITS);
        let count = T::BYTES / WORD;
        // SPIR-V may place a value across two words.
        if bit > BITS - count || !offset.is_multiple_of(WORD) {
            mark_two(data, offset, T::BYTES);
            return true;
        }
        let at = data.len().wrapping_sub((entry + 1) * ENTRY);
        mark_bits(data.get_mut(at..).and_then(<[u8]>::first_chunk_mut), mask(bit, count))
    }

    /// Stores a value of whole words at a place, as [`store`](Tracked::store) does. The place is that of
    /// as many words in a buffer of this length.
    #[inline]
    pub fn store_at<T: Value>(&mut self, place: DirtyPlace, value: T) -> bool {
        let (data, offset) = (&mut self.data[..], place.offset() as usize);
        debug_assert!(offset + T::BYTES <= self.len, "past the end");
        let Some(to) = data.get_mut(offset..offset + T::BYTES) else { return false };
        value.store(to);
        let entry =
            data.get_mut(place.entry()..place.entry() + ENTRY).and_then(<[u8]>::first_chunk_mut);
        if !mark_bits(entry, mask(offset / WORD % BITS, T::BYTES / WORD)) {
            mark_two(data, offset, T::BYTES);
        }
        true
    }

    /// Marks `size` bytes at `offset`; they lie within the buffer.
    pub fn mark(&mut self, offset: usize, size: usize) {
        mark(&mut self.data, offset, size);
    }

    pub fn clear(&mut self) {
        self.data[self.len..].fill(u8::MAX);
    }

    pub fn ranges(&self, gap: usize) -> Ranges<'_> {
        Ranges { tracked: self, word: 0, gap }
    }

    /// Returns an entry of the map.
    fn entry(&self, entry: usize) -> Option<u64> {
        let map = &self.data[self.len..];
        let at = map.len().checked_sub((entry + 1) * ENTRY)?;
        map[at..].first_chunk().map(|&bits| u64::from_ne_bytes(bits))
    }

    /// Returns the first word at or after `from` that is dirty, or clean.
    fn find(&self, from: usize, dirty: bool) -> Option<usize> {
        // Set bits are sought: those of clean words as they are, those of dirty words flipped.
        let flip = if dirty { u64::MAX } else { 0 };
        let mut entry = from / BITS;
        let mut bits = (self.entry(entry)? ^ flip) & (u64::MAX << (from % BITS));
        while bits == 0 {
            entry += 1;
            bits = self.entry(entry)? ^ flip;
        }
        Some(entry * BITS + bits.trailing_zeros() as usize)
    }
}

/// Returns zeroed bytes; `None` if there is not enough memory.
pub(super) fn zeroed(len: usize) -> Option<Vec<u8>> {
    // Fails here rather than in the allocation of zeroed pages.
    Vec::<u8>::new().try_reserve_exact(len).ok()?;
    Some(vec![0; len])
}

/// Marks bits of an entry; `false` if there is none.
#[inline]
fn mark_bits(entry: Option<&mut [u8; ENTRY]>, bits: u64) -> bool {
    let Some(entry) = entry else { return false };
    let clean = u64::from_ne_bytes(*entry);
    // Bits already set are not stored again, so the next write need not wait for the store.
    if clean & bits != 0 {
        *entry = (clean & !bits).to_ne_bytes();
    }
    true
}

/// [`mark`], where bits rarely span two entries or begin within a word.
#[cold]
fn mark_two(data: &mut [u8], offset: usize, size: usize) {
    mark(data, offset, size);
}

/// Marks `size` bytes at `offset`.
fn mark(data: &mut [u8], offset: usize, size: usize) {
    if size == 0 {
        return;
    }
    let (first, last) = (offset / WORD, (offset + size - 1) / WORD);
    for entry in first / BITS..=last / BITS {
        let first = first.max(entry * BITS);
        let last = last.min(entry * BITS + BITS - 1);
        let at = data.len() - (entry + 1) * ENTRY;
        mark_bits(data[at..].first_chunk_mut(), mask(first % BITS, last - first + 1));
    }
}

/// Dirty byte ranges in order, returned by [`Buffer::dirty`](super::Buffer::dirty).
///
/// Starts and ends are multiples of 4, except the end of a buffer whose length is not.
#[derive(Clone, Debug)]
pub struct Ranges<'b> {
    tracked: &'b Tracked,
    word: usize,
    gap: usize,
}

impl Iterator for Ranges<'_> {
    type Item = Range<usize>;

    fn next(&mut self) -> Option<Range<usize>> {
        let start = self.tracked.find(self.word, true)?;
        // From the end of a dirty run to the start of the next one: taken along if the gap is
        // small.
        loop {
            // The map has a clean word after the last.
            let end = self.tracked.find(self.word.max(start), false)?;
            self.word = end;
            match self.tracked.find(end, true) {
                Some(next) if (next - end) * WORD <= self.gap => self.word = next,
                _ => return Some(start * WORD..(end * WORD).min(self.tracked.len)),
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

    fn ranges(dirty: &Tracked, gap: usize) -> Vec<Range<usize>> {
        dirty.ranges(gap).collect()
    }

    fn tracked(len: usize) -> Tracked {
        Tracked::zeroed(len).expect("memory for a few bytes")
    }

    #[test]
    fn nothing_written_is_nothing_to_upload() {
        assert!(ranges(&tracked(6160), 1 << 20).is_empty());
        assert!(ranges(&tracked(0), 0).is_empty());
    }

    #[test]
    fn a_write_is_rounded_out_to_words_and_cut_at_the_end() {
        let mut dirty = tracked(11);
        dirty.mark(1, 2);
        dirty.mark(9, 2);
        assert_eq!(ranges(&dirty, 0), [0..4, 8..11]);
    }

    #[test]
    fn gaps_up_to_the_one_chosen_are_uploaded_with_it() {
        let mut dirty = tracked(4096);
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
            let mut dirty = tracked(4096);
            dirty.mark(offset, size);
            assert_eq!(ranges(&dirty, 0), [offset..offset + size]);
            dirty.clear();
            assert!(ranges(&dirty, 0).is_empty());
        }
    }

    #[test]
    fn every_way_of_writing_marks_the_same_words() {
        for (offset, size) in [(0, 4), (252, 12), (16, 12), (508, 64), (1020, 4), (2, 4), (253, 12)]
        {
            let mut wanted = tracked(1024);
            wanted.mark(offset, size);
            let (mut bytes, mut words, mut at) = (tracked(1024), tracked(1024), tracked(1024));
            assert_eq!(bytes.write(offset, size).map(|to| to.len()), Some(size));
            assert_eq!(bytes.data, wanted.data);
            let place = at.place(offset, size);
            let stored = match size {
                4 => [words.store(offset as u32, 0u32), at.store_at(place, 0u32)],
                12 => [words.store(offset as u32, [0f32; 3]), at.store_at(place, [0f32; 3])],
                _ => {
                    [words.store(offset as u32, [[0f32; 4]; 4]), at.store_at(place, [[0f32; 4]; 4])]
                }
            };
            assert_eq!(stored, [true; 2]);
            assert_eq!([&words.data, &at.data], [&wanted.data; 2]);
        }
    }

    #[test]
    fn nothing_is_written_or_marked_past_the_end() {
        let mut data = tracked(20);
        assert!(data.write(16, 8).is_none());
        assert!(data.write(usize::MAX, 2).is_none());
        assert_eq!(data.data, tracked(20).data);
        assert_eq!(data.into_bytes(), [0; 20]);
    }

    #[test]
    fn bits_agree_with_a_list_of_bytes() {
        let mut rng = fastrand::Rng::with_seed(1);
        for _ in 0..300 {
            let len = rng.usize(1..900) * 4;
            let mut dirty = tracked(len);
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
