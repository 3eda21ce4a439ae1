//! Many jobs on several threads, their results in the order of the jobs, and never more of them
//! waiting than a few a thread or a few megabytes.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Results that may wait for their turn, for each thread.
const WAITING: usize = 64;

/// Items a thread takes on at a time, at most.
const LARGEST_CLAIM: usize = 16;

/// Bytes of results that may wait for their turn before no further work is begun.
const WAITING_BYTES: usize = 4 << 20;

/// A thread keeps finished results to itself for this long: waking another one costs more than
/// laying out a small shader.
const PATIENCE: Duration = Duration::from_millis(1);

/// What a result weighs while it waits.
pub trait Weighed {
    /// Bytes of memory, roughly.
    fn bytes(&self) -> usize;
}

/// Runs `job` on every item and hands the results to `take` in the items' order, until `take`
/// fails. One item is worked on right here.
pub fn ordered<I: Send, O: Weighed + Send, E>(
    items: impl Iterator<Item = I> + Send,
    threads: Option<NonZeroUsize>,
    job: impl Fn(I) -> O + Sync,
    mut take: impl FnMut(O) -> Result<(), E>,
) -> Result<(), E> {
    let mut items = items;
    let (first, second) = (items.next(), items.next());
    let threads = threads.or_else(|| thread::available_parallelism().ok()).map_or(1, |n| n.get());
    let here = threads == 1 || second.is_none();
    let mut items = first.into_iter().chain(second).chain(items);
    if here {
        return items.try_for_each(|item| take(job(item)));
    }
    let queue = Queue {
        items: Mutex::new(items),
        claimed: AtomicUsize::new(0),
        state: Mutex::new(State {
            taken: 0,
            done: BTreeMap::new(),
            bytes: 0,
            working: threads,
            stop: false,
        }),
        ready: Condvar::new(),
        room: Condvar::new(),
        window: threads * WAITING,
    };
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| queue.work(&job));
        }
        loop {
            let results = queue.results();
            if results.is_empty() {
                return Ok(());
            }
            if let Err(failure) = results.into_iter().try_for_each(&mut take) {
                queue.lock().stop = true;
                queue.room.notify_all();
                return Err(failure);
            }
        }
    })
}

struct Queue<T, O> {
    items: Mutex<T>,
    /// Items that threads have taken on.
    claimed: AtomicUsize,
    state: Mutex<State<O>>,
    /// The result whose turn it is has come, or the last thread has ended.
    ready: Condvar,
    /// Results were handed on, so that work may run ahead again.
    room: Condvar,
    /// Items that work may run ahead.
    window: usize,
}

struct State<O> {
    /// Results handed on.
    taken: usize,
    /// Results waiting for their turn, and what they weigh.
    done: BTreeMap<usize, O>,
    bytes: usize,
    /// Threads that may still bring results.
    working: usize,
    stop: bool,
}

impl<I, T: Iterator<Item = I>, O: Weighed> Queue<T, O> {
    fn lock(&self) -> MutexGuard<'_, State<O>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Works until no item is left.
    fn work(&self, job: &(impl Fn(I) -> O + Sync)) {
        let mut kept: Vec<(usize, O)> = Vec::new();
        let mut since = Instant::now();
        while self.wait_for_room(&mut kept) {
            let claim = self.claim();
            if claim.is_empty() {
                break;
            }
            for (number, item) in claim {
                if kept.is_empty() {
                    since = Instant::now();
                }
                kept.push((number, job(item)));
                if since.elapsed() >= PATIENCE {
                    self.bring(&mut self.lock(), &mut kept);
                }
            }
        }
        let mut state = self.lock();
        self.bring(&mut state, &mut kept);
        state.working -= 1;
        self.ready.notify_one();
    }

    /// Waits until work may run further ahead; `false` when there is to be no more.
    fn wait_for_room(&self, kept: &mut Vec<(usize, O)>) -> bool {
        let mut state = self.lock();
        let full = |s: &State<O>| {
            let ahead = self.claimed.load(Ordering::Relaxed) - s.taken;
            !s.stop && (ahead >= self.window || s.bytes >= WAITING_BYTES)
        };
        if full(&state) {
            self.bring(&mut state, kept);
            while full(&state) {
                state = self.room.wait(state).unwrap_or_else(PoisonError::into_inner);
            }
        }
        !state.stop
    }

    /// The next items with their numbers: one at first, so that a few large ones are shared out,
    /// more later, so that many small ones cost few locks.
    fn claim(&self) -> Vec<(usize, I)> {
        let mut items = self.items.lock().unwrap_or_else(PoisonError::into_inner);
        let next = self.claimed.load(Ordering::Relaxed);
        let claim: Vec<(usize, I)> =
            (next..).zip(items.by_ref().take((next / 8).clamp(1, LARGEST_CLAIM))).collect();
        self.claimed.store(next + claim.len(), Ordering::Relaxed);
        claim
    }

    /// Hands over what a thread kept to itself.
    fn bring(&self, state: &mut State<O>, kept: &mut Vec<(usize, O)>) {
        for (number, result) in kept.drain(..) {
            state.bytes += result.bytes();
            state.done.insert(number, result);
        }
        if state.done.first_key_value().is_some_and(|(number, _)| *number == state.taken) {
            self.ready.notify_one();
        }
    }

    /// The next results in order, as many as there are; none after the last.
    fn results(&self) -> Vec<O> {
        let mut state = self.lock();
        loop {
            let mut results = Vec::new();
            loop {
                let turn = state.taken;
                let Some(result) = state.done.remove(&turn) else { break };
                state.taken += 1;
                state.bytes -= result.bytes();
                results.push(result);
            }
            if !results.is_empty() || state.working == 0 {
                drop(state);
                self.room.notify_all();
                return results;
            }
            state = self.ready.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl<T> Weighed for (T,) {
        fn bytes(&self) -> usize {
            1
        }
    }

    fn threads(n: usize) -> Option<NonZeroUsize> {
        NonZeroUsize::new(n)
    }

    #[test]
    fn results_come_in_order_whatever_the_threads() {
        for n in [0usize, 1, 2, 3, 500] {
            for t in [1, 2, 7] {
                let mut seen = Vec::new();
                let slow = |i: usize| {
                    if i.is_multiple_of(3) {
                        thread::sleep(std::time::Duration::from_micros(200));
                    }
                    (i,)
                };
                let done: Result<(), ()> = ordered(0..n, threads(t), slow, |(i,)| {
                    seen.push(i);
                    Ok(())
                });
                assert!(done.is_ok());
                assert_eq!(seen, (0..n).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn work_runs_ahead_only_so_far() {
        let (started, taken) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let done: Result<(), ()> = ordered(
            0..1000,
            threads(2),
            |_| {
                let ahead =
                    started.fetch_add(1, Ordering::SeqCst) + 1 - taken.load(Ordering::SeqCst);
                assert!(ahead <= 2 * 2 * WAITING + 2, "{ahead}");
                ((),)
            },
            |((),)| {
                taken.fetch_add(1, Ordering::SeqCst);
                Ok(())
            },
        );
        assert!(done.is_ok());
    }

    #[test]
    fn a_failure_stops_the_rest() {
        let mut taken = 0;
        let done = ordered(
            0..1_000_000_000u64,
            threads(2),
            |i| (i,),
            |_| {
                taken += 1;
                if taken == 5 { Err("enough") } else { Ok(()) }
            },
        );
        assert_eq!((done, taken), (Err("enough"), 5));
    }
}
