//! Many jobs on several threads, their results in the order of the jobs, and never more of them
//! waiting than a few a thread.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

/// Results that may wait for their turn, for each thread.
const WAITING: usize = 8;

/// Runs `job` on every item and hands the results to `take` in the items' order, until `take`
/// fails. One item is worked on right here.
pub fn ordered<I: Send, O: Send, E>(
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
    let state =
        State { items, next: 0, taken: 0, done: BTreeMap::new(), working: threads, stop: false };
    let queue = Queue { state: Mutex::new(state), changed: Condvar::new() };
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| queue.work(&job, threads * WAITING));
        }
        while let Some(result) = queue.result() {
            if let Err(failure) = take(result) {
                queue.lock().stop = true;
                queue.changed.notify_all();
                return Err(failure);
            }
        }
        Ok(())
    })
}

struct Queue<T, O> {
    state: Mutex<State<T, O>>,
    changed: Condvar,
}

struct State<T, O> {
    items: T,
    /// Number of the next item.
    next: usize,
    /// Results handed on.
    taken: usize,
    /// Results waiting for their turn.
    done: BTreeMap<usize, O>,
    /// Threads that may still bring results.
    working: usize,
    stop: bool,
}

impl<I, T: Iterator<Item = I>, O> Queue<T, O> {
    fn lock(&self) -> MutexGuard<'_, State<T, O>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait<'a>(&self, state: MutexGuard<'a, State<T, O>>) -> MutexGuard<'a, State<T, O>> {
        self.changed.wait(state).unwrap_or_else(PoisonError::into_inner)
    }

    /// Works until no item is left.
    fn work(&self, job: &(impl Fn(I) -> O + Sync), window: usize) {
        loop {
            let mut state = self.lock();
            while !state.stop && state.next >= state.taken + window {
                state = self.wait(state);
            }
            let item = if state.stop { None } else { state.items.next() };
            let Some(item) = item else {
                state.working -= 1;
                drop(state);
                self.changed.notify_all();
                return;
            };
            let number = state.next;
            state.next += 1;
            drop(state);
            let result = job(item);
            self.lock().done.insert(number, result);
            self.changed.notify_all();
        }
    }

    /// The next result in order; `None` after the last.
    fn result(&self) -> Option<O> {
        let mut state = self.lock();
        loop {
            let turn = state.taken;
            if let Some(result) = state.done.remove(&turn) {
                state.taken += 1;
                drop(state);
                self.changed.notify_all();
                return Some(result);
            }
            if state.working == 0 {
                return None;
            }
            state = self.wait(state);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

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
                    i
                };
                let done: Result<(), ()> = ordered(0..n, threads(t), slow, |i| {
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
                assert!(ahead <= 2 * WAITING + 2, "{ahead}");
            },
            |()| {
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
            |i| i,
            |_| {
                taken += 1;
                if taken == 5 { Err("enough") } else { Ok(()) }
            },
        );
        assert_eq!((done, taken), (Err("enough"), 5));
    }
}
