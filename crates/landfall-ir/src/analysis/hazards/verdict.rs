//! The results at the end of the walk: how loops index arrays of lights, and all hazards, each
//! place once.

use rustc_hash::{FxHashMap, FxHashSet};

use super::checks::Candidate;
use super::graph::{Id, Leaf};
use super::walk::Walk;
use super::{Access, Certainty, Hazard, HazardReport, IndexBound, Kind, Occurrence};
use crate::analysis::roles::Role;
use landfall_layout::source::Span;

impl Walk<'_> {
    /// Returns all hazards and accesses, each place once.
    pub fn into_report(mut self) -> HazardReport {
        self.look_at_specular();
        self.look_at_accesses();
        let cut_short = self.is_cut_short();
        let mut hazards: Vec<Occurrence> = Vec::new();
        let mut places: FxHashMap<(Kind, Span), usize> = FxHashMap::default();
        // Inlined functions and the two turns of loops meet the same place several times: the most
        // certain report stays.
        for Candidate { hazard, .. } in std::mem::take(&mut self.candidates) {
            let next = hazards.len();
            let at = *places.entry((hazard.kind, hazard.span)).or_insert(next);
            match hazards.get_mut(at) {
                Some(known) => known.certainty = known.certainty.max(hazard.certainty),
                None => hazards.push(hazard),
            }
        }
        // The order of the text, so that output does not depend on that of the walk.
        hazards.sort_by_key(|h| (h.span.file, h.span.start, h.span.end, h.kind));
        let mut seen = FxHashSet::default();
        let accesses: Vec<Access> = self.accesses.into_iter().map(|(_, access)| access).collect();
        let mut accesses = accesses;
        accesses.retain(|access| seen.insert((access.light, access.span)));
        HazardReport { hazards, accesses, cut_short }
    }

    fn look_at_accesses(&mut self) {
        // One loop reads several members.
        let mut seen = FxHashSet::default();
        let mut accesses: Vec<(Id, Access)> = self.accesses.clone();
        accesses.retain(|(index, access)| seen.insert((*index, access.light)));
        let accesses: Vec<Access> = accesses.into_iter().map(|(_, access)| access).collect();
        for access in &accesses {
            let light = &self.lights[access.light];
            let about = light.path.clone();
            let (Some(slots), Some(count)) = (light.slots(), &light.count) else { continue };
            // If some loop over the array heeds the count, one to a constant is deliberate.
            let counted = accesses.iter().any(|other| {
                other.light == access.light
                    && matches!(other.bound, IndexBound::Count | IndexBound::ClampedCount)
            });
            let name = format!("{about} {}", count.member.name);
            match access.bound {
                // A single slot is in use or not; two or more are the array with empty slots.
                IndexBound::Constant(n) if !counted && n > 1 => {
                    // A slot that is switched off may be multiplied away.
                    let switched = |leaf: &Leaf| {
                        leaf.light.as_ref().is_some_and(|(own, _)| *own == access.light)
                            && matches!(leaf.role, Some(Role::Enabled | Role::Intensity))
                    };
                    let sure = match self.graph.leaves.iter().any(switched) {
                        true => Certainty::Possible,
                        false => Certainty::Likely,
                    };
                    let found = self.report(Hazard::LoopPastCount, sure, access.span, name);
                    found.hazard.number = Some(n as f64);
                }
                IndexBound::Count => {
                    let sure = Certainty::Possible;
                    let found = self.report(Hazard::CountPastArray, sure, access.span, name);
                    found.hazard.number = Some(slots as f64);
                }
                IndexBound::Constant(_)
                | IndexBound::Fixed(_)
                | IndexBound::ClampedCount
                | IndexBound::Length
                | IndexBound::Unknown => {}
            }
        }
        // The ambient colour of an element of an array that the shader reads is added once for
        // each light.
        for leaf in self.graph.leaves.clone() {
            let (Some((light, _)), Some(Role::Ambient)) = (&leaf.light, leaf.role) else {
                continue;
            };
            let light = &self.lights[*light];
            let several = light.slots().is_none_or(|slots| slots > 1) && !light.dims.is_empty();
            let Some(part) = light.roles.part(Role::Ambient).filter(|_| several) else { continue };
            let (span, about) = (part.span, light.full_path(part));
            self.report(Hazard::AmbientPerLight, Certainty::Possible, span, about);
        }
    }
}
