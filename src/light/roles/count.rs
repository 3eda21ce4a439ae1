//! The member that says how many slots of an array of lights are in use.

use super::names::is_light;
use super::{Count, Held};
use crate::layout::{BlockLayout, MemberLayout};
use crate::light::words::words;
use crate::shape::{ScalarKind, Type};

/// The whole number beside an array of lights, or in another block, that counts them.
pub(super) fn count_of<'a>(light: &Held<'a>, blocks: &'a [BlockLayout]) -> Option<Count<'a>> {
    if light.dims.is_empty() {
        return None;
    }
    let own = [light.roles.name.as_ref(), &light.path, light.block.name.as_ref()].map(words);
    let kinds = ["point", "spot", "directional", "dir", "area"];
    let mut best: Option<(u32, Count<'a>)> = None;
    for block in blocks {
        let beside = std::ptr::eq(block, light.block);
        for member in block.members.iter().filter(|m| is_whole_number(m)) {
            let said = words(&member.name);
            if !says_count(&said) {
                continue;
            }
            // `numSpotLights` does not count point lights.
            let foreign = said.iter().filter(|w| kinds.contains(&w.as_str()));
            if foreign.clone().any(|w| !own.iter().flatten().any(|o| same_word(o, w))) {
                continue;
            }
            let is_light = is_light(&said);
            let shared = said.iter().filter(|w| own.iter().flatten().any(|o| same_word(o, w)));
            let shared = shared.count() as u32;
            if !beside && !is_light && shared == 0 {
                continue;
            }
            let score = 4 * u32::from(beside) + 2 * shared + u32::from(is_light);
            if best.as_ref().is_none_or(|(known, _)| *known < score) {
                best = Some((score, Count { block, member }));
            }
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

/// The same word, in singular or plural.
fn same_word(a: &str, b: &str) -> bool {
    a.trim_end_matches('s') == b.trim_end_matches('s')
}
