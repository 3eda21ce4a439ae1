//! Buffers in which every word is different, so that a word identifies its position.
//!
//! A word is a small integer as a 32-bit float: neither zero, NaN nor subnormal, so it survives as
//! float, int, uint, and as half of a double. A bool keeps one bit of it only and needs [`passes`],
//! one per bit of the position.

/// The word at position 0; position `i` holds `BASE + i`.
const BASE: u32 = 1_000;

/// Returns the word at a position, counted in words from the start of the buffer.
pub fn sentinel(place: u32) -> u32 {
    ((BASE + place) as f32).to_bits()
}

/// Returns the position of a sentinel; `None` for bits that were never uploaded.
pub fn place(bits: u32, words: u32) -> Option<u32> {
    let value = f32::from_bits(bits);
    let least = BASE as f32;
    if !(value >= least && value < least + words as f32 && value.fract() == 0.0) {
        return None;
    }
    Some(value as u32 - BASE)
}

/// Returns the value of write number `k`: a negative number, never a sentinel.
pub fn written(k: u32) -> u32 {
    (-((BASE + k) as f32)).to_bits()
}

/// Returns a buffer of sentinels; bytes past the last whole word are zero.
pub fn buffer(bytes: u64) -> Vec<u8> {
    filled(bytes, sentinel)
}

/// Returns the number of passes that identify every position of a buffer by bools alone.
pub fn passes(bytes: u64) -> u32 {
    // Position i is encoded as i + 1, so that no position is encoded without a set bit.
    u64::BITS - (bytes / 4).leading_zeros()
}

/// Returns the buffer of a pass: a word is 1.0 where that bit of its position, counted from 1, is
/// set.
pub fn pass(bytes: u64, bit: u32) -> Vec<u8> {
    filled(bytes, |place| if (place + 1) >> bit & 1 == 1 { 1f32.to_bits() } else { 0 })
}

fn filled(bytes: u64, word: impl Fn(u32) -> u32) -> Vec<u8> {
    let mut buffer = Vec::with_capacity(bytes as usize);
    for place in 0..(bytes / 4) as u32 {
        buffer.extend_from_slice(&word(place).to_le_bytes());
    }
    buffer.resize(bytes as usize, 0);
    buffer
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_word_of_the_largest_buffer_says_its_place() {
        let words = (super::super::plan::LARGEST_BUFFER / 4) as u32;
        for at in [0, 1, 999, words / 2, words - 1] {
            assert_eq!(place(sentinel(at), words), Some(at));
            assert_eq!(place(written(at), words), None);
        }
        assert_eq!(place(0, words), None);
        assert_eq!(place(f32::NAN.to_bits(), words), None);
        assert_eq!(place(sentinel(words), words), None);
    }

    #[test]
    fn passes_tell_every_place_apart() {
        let bytes = 4 * 37;
        let told = |at: u32| {
            (0..passes(bytes)).fold(0, |sum, bit| {
                let buffer = pass(bytes, bit);
                let set = buffer[at as usize * 4..][..4] != [0; 4];
                sum | u32::from(set) << bit
            })
        };
        for at in 0..37 {
            assert_eq!(told(at), at + 1);
        }
    }
}
