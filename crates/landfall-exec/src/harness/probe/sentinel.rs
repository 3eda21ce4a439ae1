//! Buffers in which every word is different, so that a word identifies its position.
//!
//! A word is a small integer as a 32-bit float: neither zero, NaN nor subnormal, so it survives as
//! float, int, uint, and as half of 64 bits. A bool keeps one bit of it only and needs [`passes`],
//! one per bit of the position. There are fewer values of 8 and 16 bits than positions in a buffer:
//! each [`sentinel_buffer`] encodes some bits of every position, and several passes all of them.

/// The word at position 0; position `i` holds `BASE + i`.
const BASE: u32 = 1_000;

/// Returns the word at a position, counted in words from the start of the buffer.
pub fn sentinel(place: u32) -> u32 {
    // Exact below 2^24; the largest buffer has 2^23 words.
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

/// The units of a buffer that the values of a plan's components identify.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Grain {
    /// Single bytes, by 8-bit integers.
    Byte,
    /// Two bytes, by 16-bit integers and floats.
    Half,
    /// Words, by sentinels.
    #[default]
    Word,
    /// Eight bytes, by doubles whose value is a sentinel's.
    Double,
}

/// The first of the 16-bit values that encode positions, 2.0 as a float; those below 4.0 follow.
/// They are positive normal floats, which every conversion keeps, and positive integers.
const HALVES: u32 = 0x4000;

/// The first of the 16-bit values that are written: -2.0.
const HALVES_WRITTEN: u32 = 0xC000;

/// The number of the 16-bit values from 2.0 to below 4.0.
const HALVES_COUNT: u32 = 1 << 10;

impl Grain {
    /// Returns the size in bytes.
    pub fn size(self) -> u64 {
        match self {
            Grain::Byte => 1,
            Grain::Half => 2,
            Grain::Word => 4,
            Grain::Double => 8,
        }
    }

    /// Returns the number of different values that can be written in one run.
    pub fn written(self) -> u32 {
        match self {
            Grain::Byte => 255,
            Grain::Half => HALVES_COUNT,
            Grain::Word | Grain::Double => u32::MAX,
        }
    }

    /// Returns the number of bits of a position that one value encodes.
    fn position_bits(self) -> u32 {
        match self {
            Grain::Byte => 8,
            Grain::Half => HALVES_COUNT.trailing_zeros(),
            Grain::Word | Grain::Double => u32::BITS,
        }
    }

    /// Returns the number of buffers that identify every position of a buffer of that size.
    pub fn passes(self, bytes: u64) -> u32 {
        (u64::BITS - (bytes / self.size()).leading_zeros()).div_ceil(self.position_bits())
    }
}

/// Returns the buffer of a pass: each unit encodes some bits of its position, counted from 1.
pub fn sentinel_buffer(bytes: u64, grain: Grain, pass: u32) -> Vec<u8> {
    let told = grain.position_bits();
    let bits = |place: u64| (((place + 1) >> (told * pass)) & ((1 << told) - 1)) as u32;
    let units = 0..bytes / grain.size();
    let mut buffer: Vec<u8> = match grain {
        Grain::Byte => units.map(|place| bits(place) as u8).collect(),
        Grain::Half => {
            units.flat_map(|place| ((HALVES + bits(place)) as u16).to_le_bytes()).collect()
        }
        Grain::Word => return self::buffer(bytes),
        Grain::Double => {
            units.flat_map(|place| (f64::from(BASE) + place as f64).to_le_bytes()).collect()
        }
    };
    buffer.resize(bytes as usize, 0);
    buffer
}

/// Returns the position that the words of all passes encode, counted in units; `None` for bits that
/// were never uploaded. A word holds an integer's bits, or a float's value in 32 bits.
pub fn grain_place(words: &[u32], grain: Grain, float: bool, bytes: u64) -> Option<u64> {
    let units = bytes / grain.size();
    let told = |word: u32| match (grain, float) {
        (Grain::Byte, _) => (word <= 0xFF).then_some(u64::from(word)),
        (Grain::Half, false) => word.checked_sub(HALVES).map(u64::from),
        (Grain::Half, true) => {
            // The distance of 16-bit floats from 2.0 to 4.0 is 1/512.
            let steps = (f32::from_bits(word) - 2.0) * (HALVES_COUNT / 2) as f32;
            (steps >= 0.0 && steps.fract() == 0.0).then_some(steps as u64)
        }
        (Grain::Word | Grain::Double, _) => place(word, units as u32).map(|it| u64::from(it) + 1),
    };
    let each = words.iter().enumerate().map(|(pass, word)| {
        let bits = told(*word).filter(|bits| bits >> grain.position_bits().min(32) == 0)?;
        Some(bits << (grain.position_bits() * pass as u32))
    });
    let place = each.sum::<Option<u64>>()?.checked_sub(1)?;
    (place < units).then_some(place)
}

/// Returns the bits of write number `k` of a unit, in a buffer of zeros; distinct for as many as
/// [`Grain::written`].
pub fn grain_written(k: u32, grain: Grain) -> u64 {
    match grain {
        Grain::Byte => u64::from(k % 255 + 1),
        Grain::Half => u64::from(HALVES_WRITTEN + k % HALVES_COUNT),
        Grain::Word => u64::from(written(k)),
        Grain::Double => f64::from(f32::from_bits(written(k))).to_bits(),
    }
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
    fn grains_tell_every_place_of_the_largest_buffer() {
        let bytes = super::super::plan::LARGEST_BUFFER;
        for (grain, float) in
            [(Grain::Byte, false), (Grain::Half, false), (Grain::Half, true), (Grain::Double, true)]
        {
            let buffers: Vec<_> =
                (0..grain.passes(bytes)).map(|pass| sentinel_buffer(bytes, grain, pass)).collect();
            let units = bytes / grain.size();
            let size = grain.size() as usize;
            let word = |unit: &[u8]| match (grain, float) {
                (Grain::Byte, _) => u32::from(unit[0]),
                (Grain::Half, true) => {
                    let bits = u32::from(u16::from_le_bytes(unit.try_into().unwrap()));
                    // A normal positive half as a single: its exponent is biased by 15, not 127.
                    ((bits << 13) + ((127 - 15) << 23)).min(0x7F7F_FFFF)
                }
                (Grain::Half, false) => u32::from(u16::from_le_bytes(unit.try_into().unwrap())),
                _ => (f64::from_le_bytes(unit.try_into().unwrap()) as f32).to_bits(),
            };
            let told = |byte: u64| {
                let at = byte as usize;
                let words: Vec<u32> = buffers.iter().map(|b| word(&b[at..at + size])).collect();
                grain_place(&words, grain, float, bytes)
            };
            for at in [0, 1, 254, 255, 256, 1023, 1024, units / 2, units - 1] {
                assert_eq!(told(at * grain.size()), Some(at), "{grain:?} {float}");
            }
            // A read between two units is none of the first.
            if size > 1 {
                assert_ne!(told(8 * size as u64 + 1), Some(8), "{grain:?} {float}");
            }
            let zeros = vec![0; buffers.len()];
            assert_eq!(grain_place(&zeros, grain, float, bytes), None, "{grain:?}");
        }
    }

    #[test]
    fn written_values_of_a_run_differ() {
        for grain in [Grain::Byte, Grain::Half, Grain::Double] {
            let count = grain.written().min(5_000);
            let values: std::collections::BTreeSet<u64> =
                (0..count).map(|k| grain_written(k, grain)).collect();
            assert_eq!(values.len(), count as usize);
            assert!(!values.contains(&0));
        }
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
