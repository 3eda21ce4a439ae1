//! The verdicts of [`prove`](mod@crate::prove), as a part of the search.
//!
//! Its inputs are examined with the samples; the report ends with what is known of each operation.

use std::sync::Arc;
use std::time::Duration;

use super::Request;
use super::climb::Climbs;
use super::find::{self, UnreportedFinding};
use super::kept::{Exemplars, KeepReason, Kept};
use super::plan::{Plan, SampleSearch};
use crate::prove::{Goal, ProofLimits, ProvedFunction, Verdict, goals};
use landfall_interp::graph::Fault;

/// The error in units of the last place from which a cancellation is a finding.
const LOST: f64 = 4096.0;

/// The error in steps below which a cancellation is no finding.
const VISIBLE: f64 = 1.0 / 64.0;

/// The parts of the domain that are examined: the same on every machine.
const PARTS: u64 = 1 << 13;

/// The time for the proof if there is no limit.
const UNHURRIED: Duration = Duration::from_secs(30);

const TAG: u32 = 1 << 23;

/// Returns the findings among kept samples and those that the proof adds.
pub(super) fn findings(
    search: SampleSearch<'_>,
    mut exemplars: Exemplars,
    climbs: &mut Climbs<'_, '_>,
    goals: &[Goal],
) -> Vec<UnreportedFinding> {
    // Cancellations are examined with a limit of 4096 units, where the user's is higher or none.
    let lost = witnesses(goals, &mut exemplars);
    let mut raws = find::findings(search, exemplars, climbs);
    let plan = search.plan;
    let least_steps = if plan.ulp <= LOST { plan.least_steps } else { VISIBLE };
    let plan = &Plan { ulp: plan.ulp.min(LOST), least_steps, ..plan.clone() };
    let lost = find::findings(SampleSearch { plan, ..search }, lost, climbs);
    // What the samples found is not told twice.
    raws.extend(find::unknown(search.pure, &raws, lost));
    raws
}

/// Returns what is known of each operation; nothing of code that is too large to follow.
pub(super) fn proof(search: SampleSearch<'_>, request: &Request) -> ProvedFunction {
    let Plan { until, threads, .. } = search.plan;
    if until.is_stopped() {
        return ProvedFunction::default();
    }
    // Examining the samples needs the rest.
    let left = until.left().unwrap_or(UNHURRIED) / 4;
    let time = request.time.map_or(UNHURRIED, |time| time / 4).min(left);
    let stop = Arc::clone(&request.stop);
    let limits = ProofLimits {
        time,
        parts: PARTS,
        stop,
        seed: request.seed,
        threads: *threads,
        samples_always: false,
    };
    goals(search.pure, search.inputs(), search.domain(), &limits).unwrap_or_default()
}

/// Adds the inputs at which operations break to the samples to examine, and returns those at which
/// differences lose their digits.
fn witnesses(goals: &[Goal], exemplars: &mut Exemplars) -> Exemplars {
    let mut lost = Exemplars::default();
    for (nth, goal) in goals.iter().enumerate() {
        let Verdict::Found(sample) = &goal.verdict else { continue };
        let tag = TAG + nth as u32;
        let kept = Kept { sample: sample.clone(), severity: 0.0, at: (usize::MAX, nth) };
        let span = goal.place.span;
        match goal.fault {
            Fault::Undefined(kind) => {
                exemplars.insert((tag, KeepReason::Undefined(kind, span.file, span.start)), kept);
            }
            Fault::Cancellation => {
                lost.insert((tag, KeepReason::Above), kept);
            }
            Fault::Endless | Fault::Unfollowed => {}
        }
    }
    lost
}
