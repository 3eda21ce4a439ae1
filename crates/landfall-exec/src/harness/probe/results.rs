//! Infers the bytes that were read from the words that came back.
//!
//! Uses a [`Plan`] and the [`sentinel`]s its runs returned.

use super::plan::{AccessMode, Plan, Read};
use super::sentinel;
use landfall_layout::shape::ScalarKind;

/// The result of one read or write.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProbeResult {
    pub read: Read,
    pub got: ProbedLocation,
}

impl ProbeResult {
    /// Returns whether it reached the expected byte.
    pub fn is_expected(&self) -> bool {
        self.got == ProbedLocation::Byte(self.read.byte)
    }
}

/// The location a read or write reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProbedLocation {
    /// This byte of the uploaded buffer.
    Byte(u64),
    /// No byte of the buffer: bits that were never uploaded.
    Other(u64),
}

/// Returns the results of the reads, given the words of the run over sentinels, and of one run per
/// pass if the plan reads a bool.
pub fn read(plan: &Plan, buffer: u64, sentinels: &[u32], passes: &[Vec<u32>]) -> Vec<ProbeResult> {
    let words = (buffer / 4) as u32;
    let at = |results: &[u32], slot: u32| results.get(slot as usize).copied().unwrap_or(0);
    let sight = |read: &Read| {
        let got = match (read.scalar.kind, read.scalar.width) {
            (ScalarKind::Bool, _) => {
                // A pass tells one bit of the position, which is counted from 1.
                let told = passes.iter().enumerate().fold(0u64, |sum, (bit, results)| {
                    sum | u64::from(at(results, read.slot) != 0) << bit
                });
                match told.checked_sub(1) {
                    Some(place) if place < u64::from(words) => ProbedLocation::Byte(place * 4),
                    Some(_) | None => ProbedLocation::Other(told),
                }
            }
            (_, 8) => {
                // The halves of 64 bits have to be neighbours.
                let (low, high) = (at(sentinels, read.slot), at(sentinels, read.slot + 1));
                let (first, second) = (sentinel::place(low, words), sentinel::place(high, words));
                match (first, second) {
                    (Some(first), Some(second)) if second == first + 1 => {
                        ProbedLocation::Byte(u64::from(first) * 4)
                    }
                    _ => ProbedLocation::Other(u64::from(high) << 32 | u64::from(low)),
                }
            }
            _ => {
                let bits = at(sentinels, read.slot);
                match sentinel::place(bits, words) {
                    Some(place) => ProbedLocation::Byte(u64::from(place) * 4),
                    None => ProbedLocation::Other(u64::from(bits)),
                }
            }
        };
        ProbeResult { read: read.clone(), got }
    };
    plan.reads.iter().map(sight).collect()
}

/// Returns the results of the reads of a plan whose grain is another than a word, given the words
/// of each pass.
pub fn read_grains(plan: &Plan, buffer: u64, passes: &[Vec<u32>]) -> Vec<ProbeResult> {
    let grain = plan.grain;
    let sight = |read: &Read| {
        let words: Vec<u32> = passes
            .iter()
            .map(|words| words.get(read.slot as usize).copied().unwrap_or(0))
            .collect();
        let float = read.scalar.kind == ScalarKind::Float;
        let got = match sentinel::grain_place(&words, grain, float, buffer) {
            Some(place) => ProbedLocation::Byte(place * grain.size()),
            None => ProbedLocation::Other(words.first().copied().unwrap_or(0).into()),
        };
        ProbeResult { read: read.clone(), got }
    };
    plan.reads.iter().map(sight).collect()
}

/// Returns the results of the writes of such a plan into a buffer of zeros.
pub fn written_grains(plan: &Plan, after: &[u8]) -> Vec<ProbeResult> {
    let size = plan.grain.size() as usize;
    let bits = |unit: &[u8]| unit.iter().rev().fold(0, |bits, byte| bits << 8 | u64::from(*byte));
    let mut found = std::collections::BTreeMap::new();
    for (place, unit) in after.chunks_exact(size).enumerate() {
        // Of equal units the first counts.
        found.entry(bits(unit)).or_insert(place as u64 * plan.grain.size());
    }
    let sight = |read: &Read| {
        let got = match found.get(&sentinel::grain_written(read.slot, plan.grain)) {
            Some(byte) => ProbedLocation::Byte(*byte),
            None => {
                let at = read.byte as usize;
                ProbedLocation::Other(after.get(at..at + size).map_or(0, bits))
            }
        };
        ProbeResult { read: read.clone(), got }
    };
    plan.reads.iter().map(sight).collect()
}

/// Returns the results of the writes: the position of each written value in the returned buffer. A
/// byte that changed unexpectedly is attributed to the first write that missed.
pub fn written(plan: &Plan, after: &[u8]) -> Vec<ProbeResult> {
    let word = |place: usize| {
        after
            .get(place * 4..place * 4 + 4)
            .map_or(0, |bytes| u32::from_le_bytes(bytes.try_into().expect("four bytes were taken")))
    };
    let count = after.len() / 4;
    let mut found = std::collections::BTreeMap::new();
    let mut changed = Vec::new();
    for place in 0..count {
        let bits = word(place);
        if bits != sentinel::sentinel(place as u32) {
            found.entry(bits).or_insert(place as u64 * 4);
            changed.push(place as u64 * 4);
        }
    }
    // The bytes that writes should reach, with the high halves of 64 bits.
    let meant: std::collections::BTreeSet<u64> = plan
        .reads
        .iter()
        .flat_map(|read| [Some(read.byte), (read.scalar.width == 8).then_some(read.byte + 4)])
        .flatten()
        .collect();
    // The bytes that changed though no write should reach them.
    let mut stray = changed.iter().copied().filter(|byte| !meant.contains(byte));
    let sight = |read: &Read| {
        debug_assert_eq!(read.way, AccessMode::Written);
        let got = if read.scalar.kind == ScalarKind::Bool {
            // `false` is written as zero everywhere.
            if word((read.byte / 4) as usize) == 0 {
                ProbedLocation::Byte(read.byte)
            } else {
                stray.next().map_or(ProbedLocation::Other(0), ProbedLocation::Byte)
            }
        } else {
            let halves = read.scalar.width == 8;
            let high = halves.then(|| found.get(&sentinel::written(read.slot + 1)));
            match (found.get(&sentinel::written(read.slot)), high) {
                (Some(byte), None) => ProbedLocation::Byte(*byte),
                (Some(byte), Some(Some(high))) if *high == byte + 4 => ProbedLocation::Byte(*byte),
                _ => ProbedLocation::Other(u64::from(word((read.byte / 4) as usize))),
            }
        };
        ProbeResult { read: read.clone(), got }
    };
    plan.reads.iter().map(sight).collect()
}
