//! The member that counts the used slots of an array of lights.

use super::names::is_light;
use super::{Count, LightBinding};
use crate::analysis::identifier::identifier_words;
use landfall_layout::layout::{BlockLayout, MemberLayout};
use landfall_layout::shape::{ScalarKind, Type};

/// An integer whose name means a count, and the words of the name.
pub(super) struct CountCandidate<'a> {
    count: Count<'a>,
    said: Vec<String>,
}

/// Returns every member of the blocks that may be a count.
pub(super) fn counts(blocks: &[BlockLayout]) -> Vec<CountCandidate<'_>> {
    let mut all = Vec::new();
    for block in blocks {
        for member in block.members.iter().filter(|m| is_whole_number(m)) {
            let said = identifier_words(&member.name);
            if says_count(&said) && all.len() < MAX_COUNTS {
                all.push(CountCandidate { count: Count { block, member }, said });
            }
        }
    }
    all
}

/// The most counts of a shader that are examined.
const MAX_COUNTS: usize = 256;

/// Returns the count of an array of lights: beside it, or in another block if its name mentions the
/// lights.
pub(super) fn count_of<'a>(
    light: &LightBinding<'a>,
    counts: &[CountCandidate<'a>],
) -> Option<Count<'a>> {
    if light.dims.is_empty() {
        return None;
    }
    let own =
        [light.roles.name.as_ref(), &light.path, light.block.name.as_ref()].map(identifier_words);
    let is_own = |word: &String| own.iter().flatten().any(|o| same_word(o, word));
    let kinds = ["point", "spot", "directional", "dir", "area"];
    let mut best: Option<(usize, Count<'a>)> = None;
    for CountCandidate { count, said } in counts {
        // `numSpotLights` does not count point lights.
        if said.iter().any(|word| kinds.contains(&word.as_str()) && !is_own(word)) {
            continue;
        }
        let beside = std::ptr::eq(count.block, light.block);
        let of_lights = is_light(said);
        let shared = said.iter().filter(|word| is_own(word)).count();
        if !beside && !of_lights && shared == 0 {
            continue;
        }
        // Being in the same block counts most, then words shared with the array, then that it is
        // about lights.
        let score = 4 * usize::from(beside) + 2 * shared + usize::from(of_lights);
        // The first of equal scores: the order of the text.
        if best.as_ref().is_none_or(|(known, _)| *known < score) {
            best = Some((score, *count));
        }
    }
    best.map(|(_, count)| count)
}

fn is_whole_number(member: &MemberLayout) -> bool {
    match &member.ty {
        Type::Scalar(scalar) => matches!(scalar.kind, ScalarKind::Sint | ScalarKind::Uint),
        Type::Atomic(_)
        | Type::Vector { .. }
        | Type::Matrix { .. }
        | Type::Address(_)
        | Type::Struct(_)
        | Type::Array { .. } => false,
    }
}

fn says_count(said: &[String]) -> bool {
    let count = ["count", "num", "nr", "number", "amount", "used", "total", "length", "len", "n"];
    said.iter().any(|word| count.contains(&word.as_str()))
}

/// Returns whether two words are equal up to the plural.
fn same_word(a: &str, b: &str) -> bool {
    a.trim_end_matches('s') == b.trim_end_matches('s')
}
