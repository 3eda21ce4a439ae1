//! Turns kept samples into findings: examines each, makes one finding per hazard and line, climbs
//! from the worst and simplifies its input.
//!
//! Reads [`sample`](super::sample); used by the report.

use std::time::{Duration, Instant};

use rustc_hash::FxHashMap;

use super::classify::{Examined, HazardCandidate, examine};
use super::climb::{ClimbTarget, Climbs, climb};
use super::deadline::Deadline;
use super::input::Sample;
use super::kept::{Exemplars, KeepReason, Kept};
use super::measure::{Outcome, SampleError};
use super::plan::{Plan, SampleSearch};
use super::random::Random;
use super::shrink::shrink;
use landfall_exec::harness::call::pure::PureFunction;
use landfall_ir::analysis::hazard::Hazard;
use landfall_ir::threads;
use landfall_layout::finding::Level;

#[derive(Clone, Debug)]
pub(super) struct UnreportedFinding {
    pub candidate: HazardCandidate,
    pub outcome: Outcome,
    pub sample: Sample,
    pub severity: f64,
    /// The number of kept samples that meet it.
    pub seen: usize,
    pub plausible: bool,
}

/// A kept sample with how it was made and why it was kept.
type Exemplar = ((u32, KeepReason), Kept);

/// The hazard's code, the file and the line of a finding.
type Key = (&'static str, u32, u32);

/// The most samples examined for each operation and kind.
const EACH: usize = 40;

/// The samples examined, for each thread, before the results are sorted into groups.
const AT_ONCE: usize = 16;

/// The total time to examine samples if there is no limit.
const UNHURRIED: Duration = Duration::from_secs(60);

pub(super) fn findings(
    search: SampleSearch<'_>,
    exemplars: Exemplars,
    climbs: &mut Climbs<'_, '_>,
) -> Vec<UnreportedFinding> {
    let plan = search.plan;
    let mut groups: FxHashMap<Key, UnreportedFinding> = FxHashMap::default();
    // A fixed seed: findings do not depend on what ran before.
    let mut random = Random::new(7, 7);
    let mut threads = vec![(); plan.threads];
    let mut look = |samples: &[&Sample], until: &Deadline| {
        // Examined in parallel, sorted into groups in order, so that the groups are the same for
        // any number of threads.
        for some in samples.chunks(AT_ONCE * plan.threads) {
            let examined =
                threads::run(&mut threads, some.len(), |(), nth| match until.is_over() {
                    true => None,
                    false => examine(search, some[nth]).ok().map(Examined::without_trace),
                });
            for (examined, sample) in examined.into_iter().zip(some) {
                if let Some(examined) = examined {
                    sort(search, &examined, sample, &mut groups);
                }
            }
        }
    };
    let ordered = order(exemplars);
    // Climb from the worst losses first, and examine the results with the other samples.
    let mut climbed = Vec::new();
    let losses =
        ordered.iter().filter(|(key, _)| matches!(key.1, KeepReason::Above | KeepReason::Below));
    let left = plan.until.left().unwrap_or(UNHURRIED);
    // Examining has half of the time that is left, the climbs a quarter, simplifying the rest.
    let looking = plan.until.shortened_to(left / 2);
    let plan_of_climbs = &Plan { until: plan.until.shortened_to(left / 4), ..plan.clone() };
    for (_, kept) in losses.take(4) {
        let steps = |off: &SampleError| off.steps;
        let to = (steps, ClimbTarget::Interpreter);
        let search = SampleSearch { plan: plan_of_climbs, ..search };
        climbed.push(climb(search, &kept.sample, to, &mut random, climbs).0);
    }
    // Climbed samples are few and the worst: always examined.
    look(&climbed.iter().collect::<Vec<_>>(), &Deadline::default());
    let mut each: FxHashMap<KeepReason, usize> = FxHashMap::default();
    let chosen = ordered.iter().filter(|((_, why), _)| {
        let count = each.entry(*why).or_default();
        *count += 1;
        // An undefined operation has a place already; other reasons say less, so more samples are
        // examined.
        let most = if matches!(why, KeepReason::Undefined(..)) { EACH } else { 10 * EACH };
        *why != KeepReason::Endless && *count <= most
    });
    look(&chosen.map(|(_, kept)| &kept.sample).collect::<Vec<_>>(), &looking);
    let mut all: Vec<(Key, UnreportedFinding)> = groups.into_iter().collect();
    // Order first, since each finding gets a share of the time left: the important ones come
    // first.
    all.sort_by(|a, b| order_of(&a.1).cmp(&order_of(&b.1)).then(a.0.cmp(&b.0)));
    let mut all = simplified(search, &all);
    all.sort_by_key(order_of);
    all
}

/// Returns findings with the simplest samples found, in the same order.
fn simplified(
    search: SampleSearch<'_>,
    all: &[(Key, UnreportedFinding)],
) -> Vec<UnreportedFinding> {
    let SampleSearch { pure, plan, .. } = search;
    let left = plan.until.left().unwrap_or(UNHURRIED);
    let last = Instant::now().checked_add(left.max(Duration::from_millis(300)));
    let mut threads = vec![(); plan.threads];
    let at_once = u32::try_from(plan.threads).unwrap_or(u32::MAX);
    threads::run(&mut threads, all.len(), |(), nth| {
        let (key, mut raw) = all[nth].clone();
        // Each finding gets its share of the remaining time.
        // Twice the fair share: most findings need less.
        let left = last.map_or(left, |last| last.saturating_duration_since(Instant::now()));
        let more = u32::try_from(all.len() - nth).unwrap_or(u32::MAX);
        let share = plan.until.shortened_to(left.saturating_mul(2) / more.div_ceil(at_once));
        let loss = raw.candidate.kind.is_none();
        let apart = raw.candidate.hazard == Hazard::BranchDivergence;
        let was = raw.plausible;
        let breaks = |sample: &Sample| -> bool {
            let Ok(examined) = examine(search, sample) else { return false };
            let still = |c: &&HazardCandidate| c.key(pure) == key;
            // A plausible finding must not become implausible by simplification.
            let stays = search.is_plausible(sample) || !was;
            stays
                && examined.candidates.iter().any(|c| still(&c))
                // The simplified sample must show the same hazard in the same line, and a loss
                // must still be one.
                && (!loss || apart || bad(&examined, plan))
        };
        raw.sample = shrink(&raw.sample, search.inputs(), search.domain(), &share, breaks);
        raw.plausible |= search.is_plausible(&raw.sample);
        if let Ok(examined) = examine(search, &raw.sample) {
            raw.outcome = examined.outcome;
            if let (true, Some(off)) = (apart, examined.diverged) {
                raw.severity = off.steps;
            }
            if let Some(found) = examined.candidates.into_iter().find(|c| c.key(pure) == key) {
                raw.candidate = found;
            }
        }
        raw
    })
}

/// Returns the findings whose hazard and line are not among others.
pub(super) fn unknown(
    pure: &PureFunction,
    known: &[UnreportedFinding],
    more: Vec<UnreportedFinding>,
) -> Vec<UnreportedFinding> {
    let keys: Vec<Key> = known.iter().map(|raw| raw.candidate.key(pure)).collect();
    more.into_iter().filter(|raw| !keys.contains(&raw.candidate.key(pure))).collect()
}

/// Returns the sort key: findings with plausible inputs first, then by level.
fn order_of(raw: &UnreportedFinding) -> (bool, std::cmp::Reverse<Level>, bool, Hazard) {
    // Then hazards of lighting before those of arithmetic.
    let hazard = raw.candidate.hazard;
    let level = std::cmp::Reverse(hazard.info().level);
    (!raw.plausible, level, hazard.is_arithmetic(), hazard)
}

fn bad(examined: &Examined, plan: &Plan) -> bool {
    match examined.outcome {
        Outcome::Finite(off, _) => plan.is_large(&off),
        Outcome::Discarded => false,
        Outcome::NotANumber | Outcome::Infinite => true,
    }
}

/// Takes one of each kind in turn; within a kind, mutations, then scenes, then bits, worse first.
fn order(exemplars: Exemplars) -> Vec<Exemplar> {
    let mut all: Vec<Exemplar> = exemplars.into_iter().collect();
    all.sort_by(|a, b| {
        // Tags of random bits and of their kind come last: their inputs say little to a reader.
        let rank = |key: &(u32, KeepReason)| key.0 >= 1 << 24;
        rank(&a.0).cmp(&rank(&b.0)).then(b.1.severity.total_cmp(&a.1.severity)).then(a.0.cmp(&b.0))
    });
    // The first of every kind, then the second of every kind: with little time each kind is
    // examined.
    let mut turns: FxHashMap<KeepReason, usize> = FxHashMap::default();
    let mut numbered: Vec<(usize, Exemplar)> = all
        .into_iter()
        .map(|one| {
            let turn = turns.entry((one.0).1).or_default();
            *turn += 1;
            (*turn, one)
        })
        .collect();
    numbered.sort_by_key(|(turn, _)| *turn);
    numbered.into_iter().map(|(_, one)| one).collect()
}

fn sort(
    search: SampleSearch<'_>,
    examined: &Examined,
    sample: &Sample,
    groups: &mut FxHashMap<Key, UnreportedFinding>,
) {
    let severity = match examined.outcome {
        Outcome::Discarded => 0.0,
        Outcome::NotANumber => f64::INFINITY,
        Outcome::Infinite => f64::MAX,
        Outcome::Finite(off, _) => off.steps,
    };
    let plausible = search.is_plausible(sample);
    let mut met: Vec<Key> = Vec::new();
    for candidate in &examined.candidates {
        let key = candidate.key(search.pure);
        // Once for a sample, however often the line is executed.
        if met.contains(&key) {
            continue;
        }
        met.push(key);
        let severity = match (candidate.hazard, examined.diverged) {
            (Hazard::BranchDivergence, Some(off)) => off.steps,
            _ => severity,
        };
        let seen = groups.get(&key).map_or(0, |best| best.seen) + 1;
        match groups.get_mut(&key) {
            Some(best) if (plausible, severity) <= (best.plausible, best.severity) => {
                best.seen = seen;
            }
            _ => {
                let (candidate, sample) = (candidate.clone(), sample.clone());
                let outcome = examined.outcome;
                let best =
                    UnreportedFinding { candidate, outcome, sample, severity, seen, plausible };
                groups.insert(key, best);
            }
        }
    }
}
