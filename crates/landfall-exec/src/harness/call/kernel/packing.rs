//! The position of each scalar of a call among the words of its lane: 32 bits each, the low half of
//! 64-bit scalars first.
//!
//! Computed from a [`PureFunction`]; the modules and texts of [`kernel`](super) read and write at
//! these positions.

use crate::harness::call::pure::{ParameterSlot, PureFunction};
use landfall_interp::{ValueType, Words};

/// The words of one lane.
#[derive(Clone, Debug, Default)]
pub(super) struct LaneWords {
    /// By parameter of the function: its first input word.
    pub parameters: Vec<u32>,
    /// The number of input words.
    pub words_in: u32,
    /// By result: its first output word.
    pub results: Vec<u32>,
    /// The output word that is 1 if the function returned.
    pub done: u32,
    /// The number of output words.
    pub words_out: u32,
}

impl LaneWords {
    /// Returns the positions of a function's scalars; `None` if there are too many.
    pub fn new(pure: &PureFunction) -> Option<LaneWords> {
        let mut places = LaneWords::default();
        for parameter in &pure.parameters {
            places.parameters.push(places.words_in);
            places.words_in = places.words_in.checked_add(words(&parameter.ty)?)?;
        }
        // `done` counts the words of the results, behind which its own is.
        for result in &pure.results {
            places.results.push(places.done);
            places.done = places.done.checked_add(words(&result.ty)?)?;
        }
        // A buffer has at least one word.
        places.words_in = places.words_in.max(1);
        places.words_out = places.done.checked_add(1)?;
        Some(places)
    }

    /// Returns the first word of a caller's parameter, if it is an input.
    pub fn slot(&self, slot: &ParameterSlot) -> Option<u32> {
        match slot {
            ParameterSlot::Given(parameters) => {
                parameters.first().map(|first| self.parameters[*first])
            }
            ParameterSlot::Zero(_) | ParameterSlot::Out => None,
        }
    }
}

/// Returns the number of words of a type.
fn words(ty: &ValueType) -> Option<u32> {
    ty.scalars().into_iter().try_fold(0u32, |sum, scalar| sum.checked_add(width(scalar.width)))
}

/// Returns the number of words of a scalar of `bytes` bytes.
pub(super) fn width(bytes: u8) -> u32 {
    if bytes == 8 { 2 } else { 1 }
}

/// Returns the words of some lanes in order, the last lane repeated up to `padded` lanes.
pub(super) fn packed(
    pure: &PureFunction,
    places: &LaneWords,
    columns: &[Vec<u64>],
    lanes: std::ops::Range<usize>,
    padded: usize,
) -> Vec<u8> {
    let stride = places.words_in as usize;
    let mut words = vec![0u32; stride * padded];
    let scalars = pure.parameters.iter().flat_map(|parameter| parameter.ty.scalars());
    let mut at = 0;
    // The last lane stands for those that fill the job up.
    let last = lanes.len().saturating_sub(1);
    for (column, scalar) in columns.iter().zip(scalars) {
        let column = &column[lanes.clone()];
        let to = words.chunks_exact_mut(stride).enumerate();
        to.for_each(|(lane, words)| {
            let word = column[lane.min(last)];
            words[at] = word as u32;
            if width(scalar.width) == 2 {
                words[at + 1] = (word >> 32) as u32;
            }
        });
        at += width(scalar.width) as usize;
    }
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

/// Appends the results of some lanes, and whether they were discarded.
pub(super) fn unpacked(
    pure: &PureFunction,
    places: &LaneWords,
    bytes: &[u8],
    lanes: usize,
    results: &mut [Words],
    discarded: &mut Vec<bool>,
) {
    let stride = places.words_out as usize * 4;
    let word = |lane: &[u8], at: u32| -> u64 {
        let at = at as usize * 4;
        u64::from(u32::from_le_bytes([lane[at], lane[at + 1], lane[at + 2], lane[at + 3]]))
    };
    let lanes = || bytes.chunks_exact(stride).take(lanes);
    for ((result, words), first) in pure.results.iter().zip(results).zip(&places.results) {
        let mut at = *first;
        for (scalar, column) in result.ty.scalars().into_iter().zip(words) {
            column.extend(lanes().map(|lane| match width(scalar.width) {
                2 => word(lane, at) | word(lane, at + 1) << 32,
                _ => word(lane, at),
            }));
            at += width(scalar.width);
        }
    }
    discarded.extend(lanes().map(|lane| word(lane, places.done) == 0));
}
