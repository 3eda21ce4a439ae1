//! Measures workloads in interleaved rounds: each round runs every workload, in alternating
//! direction, and the start shifts every two rounds.
//!
//! Other load on the machine then affects all of them alike, and numbers of one round belong
//! together: [`rank`](super::rank) compares round by round. A repeated workload runs a few times
//! before it is timed, so that it does not pay for the caches of the previous one.

use std::time::{Duration, Instant};

use super::clock;
use super::clock::{Clock, Elapsed, Start};

/// One warm-up run precedes this many repetitions.
const WARMED: u32 = 8;

/// The reason why a workload has no samples.
const INTERRUPTED: &str = "interrupted before its first round was complete";

/// A part of a workload, measured separately for subtraction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Part {
    /// Every fragment with every light.
    Whole,
    /// Every fragment without lights: the difference is the cost of the lights.
    Unlit,
    /// An empty kernel for as many fragments: start, upload and read-back.
    Trivial,
}

pub trait Workload {
    /// Whether there is this part; there is always a whole.
    fn has(&self, part: Part) -> bool;

    /// Runs a part once; returns its time if the backend measured it.
    ///
    /// # Errors
    /// The reason it did not run; it is then not measured further.
    fn run(&mut self, part: Part) -> Result<Option<Elapsed>, String>;
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rounds {
    /// The rounds that count; one more precedes them and is dropped.
    pub count: u32,
    /// The least time of a sample: shorter runs are repeated.
    pub least: Duration,
}

impl Default for Rounds {
    fn default() -> Rounds {
        Rounds { count: 15, least: Duration::from_millis(20) }
    }
}

/// The longest part of a round, or four times the least time if more, where most of that time is
/// not counted.
const LONGEST: Duration = Duration::from_millis(100);

/// The seconds of each part, round by round.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    pub clock: Clock,
    /// The times of the complete run.
    pub whole: Vec<f64>,
    /// The times without lights, if there is such a part.
    pub unlit: Option<Vec<f64>>,
    /// The times of the empty kernel, if there is such a part.
    pub trivial: Option<Vec<f64>>,
}

/// Runs all workloads in interleaved rounds; `progress` receives the rounds done.
///
/// A workload that fails gets its reason instead of samples; the others continue. Once
/// `is_stopped`, the samples are those of the complete rounds.
pub fn measure(
    workloads: &mut [&mut dyn Workload],
    rounds: &Rounds,
    is_stopped: &dyn Fn() -> bool,
    progress: &mut dyn FnMut(u32),
) -> Vec<Result<Samples, String>> {
    // The dropped round fills caches, compiles shaders and chooses repetitions; a second pass
    // chooses them again with warm caches, or the first workloads would be repeated less.
    let warm = |workload: &mut &mut dyn Workload| match is_stopped() {
        true => Err(INTERRUPTED.to_string()),
        false => Running::warm(&mut **workload, rounds),
    };
    let mut all: Vec<Result<Running, String>> = workloads.iter_mut().map(warm).collect();
    for (workload, running) in workloads.iter_mut().zip(&mut all) {
        let failed = match running {
            Ok(running) => running.settle(&mut **workload, rounds).err(),
            Err(_) => None,
        };
        if let Some(failed) = failed {
            *running = Err(failed);
        }
    }
    progress(0);
    let mut complete = 0;
    'rounds: for round in 0..rounds.count {
        let mut turns: Vec<_> = workloads.iter_mut().zip(&mut all).collect();
        let first = (round / 2) as usize % turns.len().max(1);
        // Two rounds with one start, forwards and backwards, then the next start: over all rounds
        // each workload stands before and after each other one about equally often, so that a
        // drift of the clock rate affects none of them more.
        turns.rotate_left(first);
        if round % 2 == 1 {
            turns.reverse();
        }
        for (workload, running) in turns {
            if is_stopped() {
                break 'rounds;
            }
            let failed = match running {
                Ok(running) => running.round(&mut **workload, round).err(),
                Err(_) => None,
            };
            if let Some(failed) = failed {
                *running = Err(failed);
            }
        }
        complete = round + 1;
        progress(complete);
    }
    // Rounds that were broken off are dropped, so that all workloads have equal rounds.
    let samples = |running: Running| match complete {
        0 => Err(INTERRUPTED.to_string()),
        _ => Ok(running.samples(complete as usize)),
    };
    all.into_iter().map(|running| running.and_then(samples)).collect()
}

/// One part during the measurement.
struct TimedPart {
    part: Part,
    repeat: u32,
    seconds: Vec<f64>,
}

struct Running {
    clock: Clock,
    parts: Vec<TimedPart>,
}

impl Running {
    fn warm(workload: &mut dyn Workload, rounds: &Rounds) -> Result<Running, String> {
        let mut running = Running { clock: Clock::Processor, parts: Vec::new() };
        for part in [Part::Whole, Part::Unlit, Part::Trivial] {
            if part != Part::Whole && !workload.has(part) {
                continue;
            }
            // The first run compiles shaders and allocates.
            workload.run(part)?;
            let (repeat, clock) = repetitions(workload, part, 1, rounds)?;
            running.clock = clock;
            let seconds = Vec::with_capacity(rounds.count as usize);
            running.parts.push(TimedPart { part, repeat, seconds });
        }
        Ok(running)
    }

    /// Chooses the repetitions from a run with the current number.
    fn settle(&mut self, workload: &mut dyn Workload, rounds: &Rounds) -> Result<(), String> {
        // Parts that need one run need no better estimate.
        for timing in self.parts.iter_mut().filter(|timing| timing.repeat > 1) {
            timing.repeat = repetitions(workload, timing.part, timing.repeat, rounds)?.0;
        }
        Ok(())
    }

    fn round(&mut self, workload: &mut dyn Workload, round: u32) -> Result<(), String> {
        let mut turns: Vec<&mut TimedPart> = self.parts.iter_mut().collect();
        if round % 2 == 1 {
            turns.reverse();
        }
        for timing in turns {
            // Untimed runs bring the caches back to this workload.
            for _ in 0..timing.repeat / WARMED {
                workload.run(timing.part)?;
            }
            let (seconds, clock) = timed(workload, timing.part, timing.repeat)?;
            if clock != self.clock {
                return Err(format!(
                    "its clock changed from {} to {}",
                    self.clock.name(),
                    clock.name()
                ));
            }
            timing.seconds.push(seconds);
        }
        Ok(())
    }

    fn samples(self, complete: usize) -> Samples {
        let mut samples =
            Samples { clock: self.clock, whole: Vec::new(), unlit: None, trivial: None };
        for TimedPart { part, mut seconds, .. } in self.parts {
            seconds.truncate(complete);
            match part {
                Part::Whole => samples.whole = seconds,
                Part::Unlit => samples.unlit = Some(seconds),
                Part::Trivial => samples.trivial = Some(seconds),
            }
        }
        samples
    }
}

/// Returns the repetitions of a part and its clock, from the time of some runs.
fn repetitions(
    workload: &mut dyn Workload,
    part: Part,
    runs: u32,
    rounds: &Rounds,
) -> Result<(u32, Clock), String> {
    let began = Instant::now();
    let (once, clock) = timed(workload, part, runs)?;
    let least = rounds.least.as_secs_f64();
    // 1 ns for a clock too coarse to see one run.
    let repeat = (least / once.max(1e-9)).ceil();
    // Time that is not counted, as for transfers, passes too.
    let most = LONGEST.as_secs_f64().max(4.0 * least);
    let each = began.elapsed().as_secs_f64() / f64::from(runs);
    let repeat = repeat.min((most / each.max(1e-9)).ceil()).clamp(1.0, 1e6);
    Ok((repeat as u32, clock))
}

/// Returns the mean seconds of `repeat` runs and the clock.
fn timed(workload: &mut dyn Workload, part: Part, repeat: u32) -> Result<(f64, Clock), String> {
    let start = Start::now();
    let mut own = Vec::with_capacity(repeat as usize);
    // Either every run has its own time, or the clock of the process counts all of them.
    for _ in 0..repeat {
        own.push(workload.run(part)?);
    }
    let Elapsed { time, clock } = clock::sum(own).unwrap_or_else(|| start.elapsed());
    Ok((time.as_secs_f64() / f64::from(repeat), clock))
}
