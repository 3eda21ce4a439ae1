//! Where each scalar of a call is among the words of its lane: 32 bits each, doubles and long
//! integers the low half first.
//!
//! Fed by [`Pure`]; the modules and texts of [`driven`](super) read and write at these places.

use crate::harness::call::pure::{Pure, Slot};
use crate::interp::{ValueType, Words};

/// The words of one lane.
#[derive(Clone, Debug, Default)]
pub(super) struct Places {
    /// By parameter of the function: its first word among those that go in.
    pub parameters: Vec<u32>,
    /// Words that go in.
    pub words_in: u32,
    /// By result: its first word among those that come out.
    pub results: Vec<u32>,
    /// The word that is 1 where the function came back.
    pub done: u32,
    /// Words that come out.
    pub words_out: u32,
}

impl Places {
    /// The places of a function's scalars; none where there are too many.
    pub fn of(pure: &Pure) -> Option<Places> {
        let mut places = Places::default();
        for parameter in &pure.parameters {
            places.parameters.push(places.words_in);
            places.words_in = places.words_in.checked_add(words(&parameter.ty)?)?;
        }
        for result in &pure.results {
            places.results.push(places.done);
            places.done = places.done.checked_add(words(&result.ty)?)?;
        }
        // A buffer has at least a word.
        places.words_in = places.words_in.max(1);
        places.words_out = places.done.checked_add(1)?;
        Some(places)
    }

    /// The first word of what stands for a parameter of the caller, where it is given.
    pub fn slot(&self, slot: &Slot) -> Option<u32> {
        match slot {
            Slot::Given(parameters) => parameters.first().map(|first| self.parameters[*first]),
            Slot::Zero(_) | Slot::Out => None,
        }
    }
}

/// Words of a type.
fn words(ty: &ValueType) -> Option<u32> {
    ty.scalars().into_iter().try_fold(0u32, |sum, scalar| sum.checked_add(width(scalar.width)))
}

/// Words of a scalar of so many bytes.
pub(super) fn width(bytes: u8) -> u32 {
    if bytes == 8 { 2 } else { 1 }
}

/// The words of some lanes one after the other, the last of them again up to `padded`.
pub(super) fn packed(
    pure: &Pure,
    places: &Places,
    columns: &[Vec<u64>],
    lanes: std::ops::Range<usize>,
    padded: usize,
) -> Vec<u8> {
    let stride = places.words_in as usize;
    let mut words = vec![0u32; stride * padded];
    let scalars = pure.parameters.iter().flat_map(|parameter| parameter.ty.scalars());
    let mut at = 0;
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

/// Appends what some lanes gave, and whether they did not come back.
pub(super) fn unpacked(
    pure: &Pure,
    places: &Places,
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
