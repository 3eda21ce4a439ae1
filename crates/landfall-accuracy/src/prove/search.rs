//! Searches for inputs at which goals break, for several goals at once.
//!
//! What is found does not depend on the number of threads.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use super::points::{self, Scratch};
use super::split::Split;
use super::{Confirm, Goal, ProvedFunction};
use crate::inputs::input::Sample;
use crate::inputs::random::Random;
use landfall_interp::graph::Site;
use landfall_ir::threads;

/// The most sites of one goal that are searched for.
/// Sites of one goal are copies of an operation (iterations, components), of which a few tell as
/// much.
const SITES: usize = 4;

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
        proof: &mut ProvedFunction,
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

    /// Searches from the middles of the parts in which each goal may break, and notes the goals
    /// met.
    pub(super) fn near_parts(
        &self,
        split: &Split<'_>,
        random: &Random,
        proof: &mut ProvedFunction,
        scratch: &mut [Scratch],
    ) {
        let (space, graph) = (self.space, self.graph);
        let all: Vec<usize> = (0..proof.goals.len()).collect();
        let firsts: Vec<usize> = proof.goals.iter().map(|goal| goal.sites[0]).collect();
        self.in_turn(&all, proof, scratch, |nth, site, scratch| {
            let mut random = random.clone();
            let mut starts: Vec<Sample> = Vec::new();
            // The largest open parts are where a proof needs longest, so a counterexample is most
            // useful there.
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
            // The starts themselves are tried once for a goal, not for each of its sites.
            let tried = if firsts[nth] == site { starts } else { Vec::new() };
            tried.into_iter().chain(near).collect()
        });
    }

    /// Searches for goals in turn, by a search for each of their sites, and notes the goals met.
    ///
    /// Threads search ahead, and the points of a goal are tried once those of all goals before it
    /// are. A goal that those before it meet is left out in any case, so that the same is found by
    /// one thread.
    fn in_turn(
        &self,
        goals: &[usize],
        proof: &mut ProvedFunction,
        scratch: &mut [Scratch],
        search: impl Fn(usize, usize, &mut Scratch) -> Vec<Sample> + Sync,
    ) {
        let of = |&nth: &usize| proof.goals[nth].searched().map(move |site| (nth, site));
        let jobs: Vec<(usize, usize)> = goals.iter().flat_map(of).collect();
        let is_found = proof.goals.iter().map(|goal| AtomicBool::new(goal.is_found())).collect();
        let turns = Turns { jobs, is_found, near: Mutex::default(), proof: Mutex::new((0, proof)) };
        threads::run(scratch, turns.jobs.len(), |scratch, job| {
            let (nth, site) = turns.jobs[job];
            let is_over = || self.limits.is_over(self.began);
            // A goal already met by points of one before it is not searched any more.
            let is_left_out = turns.is_found[nth].load(Ordering::Relaxed) || is_over();
            let near = if is_left_out { Vec::new() } else { search(nth, site, scratch) };
            turns.add(job, near);
            turns.try_next(self, scratch);
        });
        // All jobs are done: whatever waits is tried in order.
        // A thread may have ended its last search while another one tried points.
        turns.try_next(self, &mut scratch[0]);
    }
}

/// The searches for goals, and the points that they found.
struct Turns<'p> {
    /// A goal and one of its sites each, those of a goal in a row.
    jobs: Vec<(usize, usize)>,
    is_found: Vec<AtomicBool>,
    /// The points found by jobs, until it is their turn.
    near: Mutex<BTreeMap<usize, Vec<Sample>>>,
    /// The first job whose points were not tried.
    proof: Mutex<(usize, &'p mut ProvedFunction)>,
}

impl Turns<'_> {
    fn add(&self, job: usize, near: Vec<Sample>) {
        self.near.lock().expect("no thread panics").insert(job, near);
    }

    /// Returns the points of the goal whose first job is given, and the job after its last; `None`
    /// while one of them is running.
    fn take(&self, first: usize) -> Option<(Vec<Sample>, usize)> {
        let goal = self.jobs.get(first)?.0;
        let count = self.jobs[first..].iter().take_while(|(nth, _)| *nth == goal).count();
        let mut near = self.near.lock().expect("no thread panics");
        // All sites of the goal must have been searched.
        let jobs = first..first + count;
        if !jobs.clone().all(|job| near.contains_key(&job)) {
            return None;
        }
        Some((jobs.clone().flat_map(|job| near.remove(&job)).flatten().collect(), jobs.end))
    }

    /// Tries the points of goals whose turn it is, unless another thread does.
    fn try_next(&self, confirm: &Confirm<'_>, scratch: &mut Scratch) {
        // Another thread is at it, and will take what has just been added, or the call after the
        // last job.
        let Ok(mut proof) = self.proof.try_lock() else { return };
        let (next, proof) = &mut *proof;
        while let Some((near, end)) = self.take(*next) {
            let nth = self.jobs[*next].0;
            *next = end;
            // One thread would not have searched for it: its points are dropped.
            if proof.goals[nth].is_found() {
                continue;
            }
            confirm.points(&near, proof, scratch);
            for (goal, is_found) in proof.goals.iter().zip(&self.is_found) {
                is_found.store(goal.is_found(), Ordering::Relaxed);
            }
        }
    }
}
