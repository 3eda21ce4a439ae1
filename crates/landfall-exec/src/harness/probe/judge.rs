//! From the words that came back to the bytes that were read.
//!
//! Reads a [`Plan`] and the [`words`] its runs returned.

use super::plan::{Plan, Read, Way};
use super::words;
use landfall_layout::shape::ScalarKind;

/// What one read saw.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sighting {
    /// The read.
    pub read: Read,
    /// What it saw.
    pub got: Got,
}

impl Sighting {
    /// Whether it saw the byte it had to.
    pub fn lands(&self) -> bool {
        self.got == Got::Byte(self.read.byte)
    }
}

/// What a read saw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Got {
    /// The upload from this byte on.
    Byte(u64),
    /// Bits that were never uploaded.
    Other(u64),
}

/// The results of reading: the words of the run over sentinels, and of one run for each pass
/// where the plan reads a bool.
pub fn read(plan: &Plan, buffer: u64, sentinels: &[u32], passes: &[Vec<u32>]) -> Vec<Sighting> {
    let words = (buffer / 4) as u32;
    let at = |results: &[u32], slot: u32| results.get(slot as usize).copied().unwrap_or(0);
    let sight = |read: &Read| {
        let got = match (read.scalar.kind, read.scalar.width) {
            (ScalarKind::Bool, _) => {
                let told = passes.iter().enumerate().fold(0u64, |sum, (bit, results)| {
                    sum | u64::from(at(results, read.slot) != 0) << bit
                });
                match told.checked_sub(1) {
                    Some(place) if place < u64::from(words) => Got::Byte(place * 4),
                    Some(_) | None => Got::Other(told),
                }
            }
            (_, 8) => {
                let (low, high) = (at(sentinels, read.slot), at(sentinels, read.slot + 1));
                let (first, second) = (words::place(low, words), words::place(high, words));
                match (first, second) {
                    (Some(first), Some(second)) if second == first + 1 => {
                        Got::Byte(u64::from(first) * 4)
                    }
                    _ => Got::Other(u64::from(high) << 32 | u64::from(low)),
                }
            }
            _ => {
                let bits = at(sentinels, read.slot);
                match words::place(bits, words) {
                    Some(place) => Got::Byte(u64::from(place) * 4),
                    None => Got::Other(u64::from(bits)),
                }
            }
        };
        Sighting { read: read.clone(), got }
    };
    plan.reads.iter().map(sight).collect()
}

/// The results of writing: where in the buffer that came back each written value lies. A byte
/// that changed though nobody meant it to is laid to the first write that did not land.
pub fn written(plan: &Plan, after: &[u8]) -> Vec<Sighting> {
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
        if bits != words::sentinel(place as u32) {
            found.entry(bits).or_insert(place as u64 * 4);
            changed.push(place as u64 * 4);
        }
    }
    let meant: std::collections::BTreeSet<u64> = plan
        .reads
        .iter()
        .flat_map(|read| [Some(read.byte), (read.scalar.width == 8).then_some(read.byte + 4)])
        .flatten()
        .collect();
    let mut stray = changed.iter().copied().filter(|byte| !meant.contains(byte));
    let sight = |read: &Read| {
        debug_assert_eq!(read.way, Way::Written);
        let got = if read.scalar.kind == ScalarKind::Bool {
            // `false` is zero, wherever it was written.
            if word((read.byte / 4) as usize) == 0 {
                Got::Byte(read.byte)
            } else {
                stray.next().map_or(Got::Other(0), Got::Byte)
            }
        } else {
            match found.get(&words::written(read.slot)) {
                Some(byte) => Got::Byte(*byte),
                None => Got::Other(u64::from(word((read.byte / 4) as usize))),
            }
        };
        Sighting { read: read.clone(), got }
    };
    plan.reads.iter().map(sight).collect()
}
