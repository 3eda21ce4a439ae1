//! Searches for inputs at which goals break, for several goals at once.
//!
//! What is found does not depend on the number of threads.

use std::collections::BTreeMap;

use super::points::{self, Scratch};
use super::split::Split;
use super::{Confirm, Goal, Proof};
use crate::accuracy::inputs::input::Sample;
use crate::accuracy::inputs::random::Random;
use crate::threads;
use landfall_exec::interp::graph::Site;

/// The most sites of one goal that are searched for.
const SITES: usize = 4;

/// The goals searched for at once, for each thread of several.
const AT_ONCE: usize = 4;

impl Goal {
    /// Returns the sites that are searched for.
    fn searched(&self) -> impl Iterator<Item = usize> {
        self.sites.iter().copied().take(SITES)
    }
}

impl Confirm<'_> {
    /// Searches from some points for each goal that is open, and notes the goals met.
    pub(super) fn near_all(
        &self,
        starts: &[Sample],
        split: &Split<'_>,
        random: &Random,
        proof: &mut Proof,
        scratch: &mut [Scratch],
    ) {
        let (space, graph) = (self.space, self.graph);
        let is_open = |nth: &usize| !proof.goals[*nth].is_found() && split.is_open(*nth as u32);
        let open: Vec<usize> = (0..proof.goals.len()).filter(is_open).collect();
        if open.is_empty() || self.limits.is_over(self.began) {
            return;
        }
        let of = |&nth: &usize| proof.goals[nth].searched().map(move |site| (nth, site));
        let all: Vec<(usize, usize)> = open.iter().flat_map(of).collect();
        let sites: Vec<&Site> = all.iter().map(|(_, site)| &graph.sites()[*site]).collect();
        // A point is evaluated once for all.
        let nearest = points::nearest(space, graph, &sites, starts, scratch);
        let nearest: BTreeMap<(usize, usize), Vec<usize>> = all.into_iter().zip(nearest).collect();
        self.in_turn(&open, proof, scratch, |nth, site, scratch| {
            let from = (starts, &nearest[&(nth, site)][..]);
            let with = (&mut random.clone(), scratch);
            points::descend(space, graph, &graph.sites()[site], from, with)
        });
    }

    /// Searches from the middles of the parts in which each goal may break, and notes the goals met.
    pub(super) fn near_parts(
        &self,
        split: &Split<'_>,
        random: &Random,
        proof: &mut Proof,
        scratch: &mut [Scratch],
    ) {
        let (space, graph) = (self.space, self.graph);
        let all: Vec<usize> = (0..proof.goals.len()).collect();
        let firsts: Vec<usize> = proof.goals.iter().map(|goal| goal.sites[0]).collect();
        self.in_turn(&all, proof, scratch, |nth, site, scratch| {
            let mut random = random.clone();
            let mut starts: Vec<Sample> = Vec::new();
            for middle in split.largest_midpoints(nth as u32, 24) {
                let words = middle.iter().enumerate().map(|(at, x)| space.word(at, *x));
                let mut sample: Sample = words.collect();
                if points::fits(space, &mut sample, &mut random) {
                    starts.push(sample);
                }
            }
            let of = &graph.sites()[site];
            let own = std::slice::from_mut(scratch);
            let nearest = points::nearest(space, graph, &[of], &starts, own);
            let from = (&starts[..], &nearest[0][..]);
            let near = points::descend(space, graph, of, from, (&mut random, scratch));
            let tried = if firsts[nth] == site { starts } else { Vec::new() };
            tried.into_iter().chain(near).collect()
        });
    }

    /// Searches for goals in turn, by a search for each of their sites, and notes the goals met.
    ///
    /// Several threads search for some goals at once. A goal that those before it meet is left out
    /// in any case, so that the same is found by one thread.
    fn in_turn(
        &self,
        goals: &[usize],
        proof: &mut Proof,
        scratch: &mut [Scratch],
        search: impl Fn(usize, usize, &mut Scratch) -> Vec<Sample> + Sync,
    ) {
        let at_once = if scratch.len() == 1 { 1 } else { AT_ONCE * scratch.len() };
        let mut left = goals.iter().copied();
        loop {
            let open = left.by_ref().filter(|&nth| !proof.goals[nth].is_found());
            let some: Vec<usize> = open.take(at_once).collect();
            if some.is_empty() || self.limits.is_over(self.began) {
                return;
            }
            let of = |&nth: &usize| proof.goals[nth].searched().map(move |site| (nth, site));
            let jobs: Vec<(usize, usize)> = some.iter().flat_map(of).collect();
            let near = threads::run(scratch, jobs.len(), |scratch, job| {
                let (nth, site) = jobs[job];
                let is_over = self.limits.is_over(self.began);
                if is_over { Vec::new() } else { search(nth, site, scratch) }
            });
            let mut near = jobs.iter().zip(near).peekable();
            for nth in some {
                let mut own: Vec<Sample> = Vec::new();
                while let Some((_, more)) = near.next_if(|((goal, _), _)| *goal == nth) {
                    own.extend(more);
                }
                if !proof.goals[nth].is_found() {
                    self.points(&own, proof, &mut scratch[0]);
                }
            }
        }
    }
}
