//! Measuring in turns: every round runs every workload, one round forwards, the next backwards,
//! and each two rounds another begins.
//!
//! Whatever else the machine does hits all of them alike, and numbers of one round belong
//! together: [`rank`](super::rank) compares round by round. What is repeated runs some times
//! before it is timed, or it would pay for what the one before it left in the caches.

use std::time::{Duration, Instant};

use super::clock;
use super::clock::{Clock, Start, Took};

/// Of so many repetitions there is one more, before time counts.
const WARMED: u32 = 8;

/// A part of a workload, so that what is not meant can be subtracted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Part {
    /// All of it: every fragment by every light.
    Whole,
    /// The same with no light: the difference is what lights cost.
    Unlit,
    /// A kernel that does nothing for as many fragments: start, upload and read-back.
    Trivial,
}

/// Something to be measured.
pub trait Workload {
    /// Whether there is this part; there is always a whole.
    fn has(&self, part: Part) -> bool;

    /// Runs a part once. Where whoever ran it timed it itself, how long it took.
    ///
    /// # Errors
    /// Why it did not run: it is measured no further.
    fn run(&mut self, part: Part) -> Result<Option<Took>, String>;
}

/// How to measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rounds {
    /// Rounds that count; one more goes before and is dropped.
    pub count: u32,
    /// What takes less is repeated until it has taken this long.
    pub least: Duration,
}

impl Default for Rounds {
    fn default() -> Rounds {
        Rounds { count: 15, least: Duration::from_millis(20) }
    }
}

/// No part of a round takes longer than that, or than four times the least time, where most of it
/// is not counted.
const LONGEST: Duration = Duration::from_millis(100);

/// Seconds of each round, of each part.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    /// What measured them.
    pub clock: Clock,
    /// One number a round.
    pub whole: Vec<f64>,
    /// One a round, if there is such a part.
    pub unlit: Option<Vec<f64>>,
    /// One a round, if there is such a part.
    pub trivial: Option<Vec<f64>>,
}

/// Runs everything in turns. `progress` is told the rounds done.
///
/// A workload that fails has its reason instead of samples; the others go on.
pub fn measure(
    workloads: &mut [&mut dyn Workload],
    rounds: &Rounds,
    progress: &mut dyn FnMut(u32),
) -> Vec<Result<Samples, String>> {
    // The round that is dropped: caches fill, drivers compile, and the repetitions are chosen;
    // again when all are warm, or who came first would be repeated less.
    let mut all: Vec<Result<Running, String>> =
        workloads.iter_mut().map(|workload| Running::warm(&mut **workload, rounds)).collect();
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
    for round in 0..rounds.count {
        let mut turns: Vec<_> = workloads.iter_mut().zip(&mut all).collect();
        let first = (round / 2) as usize % turns.len().max(1);
        turns.rotate_left(first);
        if round % 2 == 1 {
            turns.reverse();
        }
        for (workload, running) in turns {
            let failed = match running {
                Ok(running) => running.round(&mut **workload, round).err(),
                Err(_) => None,
            };
            if let Some(failed) = failed {
                *running = Err(failed);
            }
        }
        progress(round + 1);
    }
    all.into_iter().map(|running| running.map(Running::samples)).collect()
}

/// One part while it is measured.
struct Timing {
    part: Part,
    repeat: u32,
    seconds: Vec<f64>,
}

struct Running {
    clock: Clock,
    parts: Vec<Timing>,
}

impl Running {
    fn warm(workload: &mut dyn Workload, rounds: &Rounds) -> Result<Running, String> {
        let mut running = Running { clock: Clock::Processor, parts: Vec::new() };
        for part in [Part::Whole, Part::Unlit, Part::Trivial] {
            if part != Part::Whole && !workload.has(part) {
                continue;
            }
            workload.run(part)?;
            let (repeat, clock) = repetitions(workload, part, 1, rounds)?;
            running.clock = clock;
            let seconds = Vec::with_capacity(rounds.count as usize);
            running.parts.push(Timing { part, repeat, seconds });
        }
        Ok(running)
    }

    /// Chooses the repetitions by as many as were chosen.
    fn settle(&mut self, workload: &mut dyn Workload, rounds: &Rounds) -> Result<(), String> {
        for timing in self.parts.iter_mut().filter(|timing| timing.repeat > 1) {
            timing.repeat = repetitions(workload, timing.part, timing.repeat, rounds)?.0;
        }
        Ok(())
    }

    fn round(&mut self, workload: &mut dyn Workload, round: u32) -> Result<(), String> {
        let mut turns: Vec<&mut Timing> = self.parts.iter_mut().collect();
        if round % 2 == 1 {
            turns.reverse();
        }
        for timing in turns {
            for _ in 0..timing.repeat / WARMED {
                workload.run(timing.part)?;
            }
            let (seconds, clock) = timed(workload, timing.part, timing.repeat)?;
            if clock != self.clock {
                return Err(format!(
                    "its time was of the {} clock, now it is of the {}",
                    self.clock.name(),
                    clock.name()
                ));
            }
            timing.seconds.push(seconds);
        }
        Ok(())
    }

    fn samples(self) -> Samples {
        let mut samples =
            Samples { clock: self.clock, whole: Vec::new(), unlit: None, trivial: None };
        for Timing { part, seconds, .. } in self.parts {
            match part {
                Part::Whole => samples.whole = seconds,
                Part::Unlit => samples.unlit = Some(seconds),
                Part::Trivial => samples.trivial = Some(seconds),
            }
        }
        samples
    }
}

/// How often a part is to be repeated, as it took in some runs, and the clock of those.
fn repetitions(
    workload: &mut dyn Workload,
    part: Part,
    runs: u32,
    rounds: &Rounds,
) -> Result<(u32, Clock), String> {
    let began = Instant::now();
    let (once, clock) = timed(workload, part, runs)?;
    let least = rounds.least.as_secs_f64();
    let repeat = (least / once.max(1e-9)).ceil();
    // What is not counted, as the way to a driver and back, takes its time too.
    let most = LONGEST.as_secs_f64().max(4.0 * least);
    let each = began.elapsed().as_secs_f64() / f64::from(runs);
    let repeat = repeat.min((most / each.max(1e-9)).ceil()).clamp(1.0, 1e6);
    Ok((repeat as u32, clock))
}

/// Seconds of one run, over `repeat` of them.
fn timed(workload: &mut dyn Workload, part: Part, repeat: u32) -> Result<(f64, Clock), String> {
    let start = Start::now();
    let mut own = Vec::with_capacity(repeat as usize);
    for _ in 0..repeat {
        own.push(workload.run(part)?);
    }
    let Took { time, clock } = clock::sum(own).unwrap_or_else(|| start.passed());
    Ok((time.as_secs_f64() / f64::from(repeat), clock))
}
