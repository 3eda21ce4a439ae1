//! What the evaluator noted over all jobs of a picture.

use landfall_exec::interp::{Counts, Notes, Undefined};

/// Operations and undefined operations, added up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// What it cost.
    pub counts: Counts,
    /// Operations without a defined value, if the evaluator watched.
    pub undefined: Vec<Undefined>,
}

impl Tally {
    /// Adds what one job noted.
    pub fn add(&mut self, notes: &Notes) {
        let Counts { arithmetic, transcendental, loads, stores, textures, calls } = &notes.counts;
        let sum = &mut self.counts;
        sum.arithmetic += arithmetic;
        sum.transcendental += transcendental;
        sum.loads += loads;
        sum.stores += stores;
        sum.textures += textures;
        // What reads the inputs is none of the shader's.
        for (name, count) in calls.iter().filter(|(name, _)| !name.starts_with("landfall_")) {
            match sum.calls.iter_mut().find(|(known, _)| known == name) {
                Some((_, all)) => *all += count,
                None => sum.calls.push((name.clone(), *count)),
            }
        }
        for found in &notes.undefined {
            let same =
                |known: &&mut Undefined| known.kind == found.kind && known.place == found.place;
            match self.undefined.iter_mut().find(same) {
                Some(known) => known.count += found.count,
                None => self.undefined.push(found.clone()),
            }
        }
    }
}
