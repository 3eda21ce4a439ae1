//! Sums of the interpreter's notes over all jobs of a picture.

use landfall_interp::{Counts, Notes, Undefined};

/// The operations and undefined operations of all jobs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    pub counts: Counts,
    /// The operations without a defined value, if the interpreter watched for them.
    pub undefined: Vec<Undefined>,
}

impl Tally {
    pub fn add(&mut self, notes: &Notes) {
        let Counts { arithmetic, transcendental, loads, stores, textures, calls } = &notes.counts;
        let sum = &mut self.counts;
        sum.arithmetic += arithmetic;
        sum.transcendental += transcendental;
        sum.loads += loads;
        sum.stores += stores;
        sum.textures += textures;
        // Functions of the wrapper that reads the inputs do not count.
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
