//! Runs the samples on all cores in chunks, and merges the results of the threads.
//!
//! Takes chunks of [`generate`](super::generate); used by [`find`](super::find). Feeds the
//! [`drivers`](super::drivers), which the calling thread owns.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Condvar, Mutex};

use super::batch::SampleBatch;
use super::drivers::Drivers;
use super::generate::Chunk;
use super::kept::{SampledResults, keep_most_severe, top};
use super::plan::SampleSearch;
use super::worker::Worker;
use landfall_exec::backend::Failure;
use landfall_ir::stack::spawn_alike;

/// Receives the number of samples run.
pub(super) type Progress<'p> = &'p (dyn Fn(u64) + Sync);

#[derive(Default)]
struct Claims {
    counts: Mutex<Counts>,
    /// Signals that a chunk is counted.
    counted: Condvar,
}

#[derive(Default)]
struct Counts {
    /// The chunks claimed, and those of them whose samples are counted.
    claimed: usize,
    counted: usize,
    samples: u64,
}

impl Claims {
    /// Makes the next chunk; `None` if there are enough samples before it.
    ///
    /// Threads make chunks at once, but count them in order, so that the same are run for any
    /// number of threads.
    fn next(&self, make: impl Fn(usize) -> Chunk, enough: u64) -> Option<(usize, Chunk)> {
        let lock = || self.counts.lock().expect("counting does not panic");
        // The claim is counted before the chunk is made, which takes long; its samples are counted
        // after, in the order of claims. Whether there are enough samples thus depends on the
        // chunks before alone.
        let number = {
            let mut counts = lock();
            if counts.samples >= enough {
                return None;
            }
            counts.claimed += 1;
            counts.claimed - 1
        };
        let making = Making(self);
        let chunk = make(number);
        std::mem::forget(making);
        // Waits for the chunks claimed before it.
        let is_later = |counts: &mut Counts| counts.counted < number;
        let mut counts =
            self.counted.wait_while(lock(), is_later).expect("counting does not panic");
        let is_enough = counts.samples >= enough;
        // The domain may exclude a whole family.
        counts.samples += (chunk.samples.len() as u64).max(1);
        counts.counted += 1;
        self.counted.notify_all();
        (!is_enough).then_some((number, chunk))
    }
}

/// A chunk in the making.
struct Making<'c>(&'c Claims);

impl Drop for Making<'_> {
    /// Where making one panics, no thread waits until it is counted, and no other is made.
    fn drop(&mut self) {
        if let Ok(mut counts) = self.0.counts.lock() {
            counts.samples = u64::MAX / 2;
            counts.counted = usize::MAX / 2;
        }
        self.0.counted.notify_all();
    }
}

/// Runs samples until there are enough, time runs out or a stop is requested.
pub(super) fn run(
    search: SampleSearch<'_>,
    drivers: &mut Drivers<'_>,
    progress: Progress<'_>,
) -> Result<SampledResults, Failure> {
    let SampleSearch { pure, generator, plan } = search;
    let claims = Claims::default();
    let done = AtomicU64::new(0);
    let work = |to: Option<SyncSender<SampleBatch>>| -> Result<SampledResults, Failure> {
        let mut mine = Worker::new(pure, plan, to);
        loop {
            if plan.until.is_over() {
                // Stopped only if samples are missing.
                mine.sampled.stopped |= done.load(Ordering::Relaxed) < plan.samples;
                break;
            }
            let Some((number, chunk)) = claims.next(|nth| generator.chunk(nth), plan.samples)
            else {
                break;
            };
            let lanes = chunk.samples.len() as u64;
            mine.run(number, &chunk)?;
            let all = done.fetch_add(lanes.max(1), Ordering::Relaxed) + lanes;
            progress(all);
        }
        Ok(mine.sampled)
    };
    let threads = plan.threads.max(1);
    // Without drivers nobody receives batches, so none are made.
    let alone = drivers.all_failed();
    let parts: Vec<Result<SampledResults, Failure>> = if threads == 1 && alone {
        vec![work(None)]
    } else {
        std::thread::scope(|scope| {
            // A bounded channel limits memory if a driver is slower than the interpreter.
            let (to, from) = sync_channel::<SampleBatch>(threads);
            let work = &work;
            let spawn = |_| {
                let to = (!alone).then(|| to.clone());
                // The interpreter recurses on the function's calls.
                let running = spawn_alike(scope, move || work(to));
                running.expect("the system starts threads")
            };
            let handles: Vec<_> = (0..threads).map(spawn).collect();
            // The last sender must go, or the receiver would wait for it.
            drop(to);
            from.iter().for_each(|batch| drivers.take(&batch));
            handles.into_iter().map(|h| h.join().expect("sampling does not panic")).collect()
        })
    };
    let mut all = SampledResults::new();
    all.stopped = drivers.is_cut();
    for part in parts {
        let part = part?;
        all.stopped |= part.stopped;
        for ((_, sum), (_, more)) in all.families.iter_mut().zip(&part.families) {
            sum.merge(more);
        }
        for (which, tops) in part.tops.into_iter().enumerate() {
            for kept in tops {
                top(&mut all.tops[which], kept.severity, kept.at, || kept.sample);
            }
        }
        for (key, kept) in part.exemplars {
            // Merged by severity and position, in any order of the parts.
            keep_most_severe(&mut all.exemplars, key, kept, usize::MAX);
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::super::generate::Family;
    use super::*;

    #[test]
    fn a_chunk_that_panics_keeps_no_thread_waiting() {
        let claims = Claims::default();
        let make = |nth: usize| {
            // The other threads wait for this one.
            std::thread::sleep(std::time::Duration::from_millis(if nth == 1 { 50 } else { 0 }));
            assert!(nth != 1, "as meant");
            Chunk { family: Family::Coincidences, samples: Vec::new(), tags: Vec::new() }
        };
        let work = || {
            let mut made = 0;
            while claims.next(make, u64::MAX / 4).is_some() {
                made += 1;
            }
            made
        };
        let ended = std::thread::scope(|scope| {
            let running: Vec<_> = (0..3).map(|_| scope.spawn(work)).collect();
            running.into_iter().map(|thread| thread.join().is_ok()).collect::<Vec<bool>>()
        });
        assert_eq!(ended.iter().filter(|is_ok| **is_ok).count(), 2);
    }
}
