//! Runs jobs on several threads and returns their results in order, with a bound on the number and
//! size of waiting results.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use crate::stack::spawn_alike;

/// Maximum number of waiting results per thread.
const WAITING: usize = 512;

/// Maximum number of items a thread claims at a time, if each takes microseconds.
const LARGEST_CLAIM: usize = 16;

/// Bytes of waiting results above which no further work is started.
const WAITING_BYTES: usize = 4 << 20;

/// The time for which a thread collects results before handing them over: waking another thread
/// costs more than laying out a small shader.
const PATIENCE: Duration = Duration::from_millis(1);

/// The size of a waiting result.
pub trait Weighed {
    /// Approximate bytes of memory.
    fn bytes(&self) -> usize;
}

/// A result with its size.
impl<T> Weighed for (usize, T) {
    fn bytes(&self) -> usize {
        self.0
    }
}

impl<T: Weighed, E> Weighed for Result<T, E> {
    fn bytes(&self) -> usize {
        self.as_ref().map_or(0, T::bytes)
    }
}

/// Runs `job` on every item and hands the results to `take` in the items' order, until `take`
/// fails. What `take` returns is dropped on the thread of the job while that thread runs: to free
/// memory of another thread takes the lock of its allocator. A single item runs on the calling
/// thread.
pub fn ordered<I: Send, O: Weighed + Send, R: Send, E>(
    items: impl Iterator<Item = I> + Send,
    threads: Option<NonZeroUsize>,
    job: impl Fn(I) -> O + Sync,
    take: impl FnMut(O) -> Result<R, E>,
) -> Result<(), E> {
    let states = (|| Ok(()), || Some(()));
    run(items, threads, LARGEST_CLAIM, states, |(), item| job(item), take)
}

/// The same for items that take long, with a state for each thread: what `own` returns on the
/// calling thread, and meanwhile `open` on each other one. A thread that opens none does no work.
pub fn ordered_with<S, I: Send, O: Weighed + Send, R: Send, E>(
    items: impl Iterator<Item = I> + Send,
    threads: Option<NonZeroUsize>,
    (own, open): (impl FnOnce() -> Result<S, E>, impl Fn() -> Option<S> + Sync),
    job: impl Fn(&mut S, I) -> O + Sync,
    take: impl FnMut(O) -> Result<R, E>,
) -> Result<(), E> {
    run(items, threads, 1, (own, open), job, take)
}

fn run<S, I: Send, O: Weighed + Send, R: Send, E>(
    items: impl Iterator<Item = I> + Send,
    threads: Option<NonZeroUsize>,
    largest_claim: usize,
    (own, open): (impl FnOnce() -> Result<S, E>, impl Fn() -> Option<S> + Sync),
    job: impl Fn(&mut S, I) -> O + Sync,
    mut take: impl FnMut(O) -> Result<R, E>,
) -> Result<(), E> {
    // Two items are looked at: for a single one no thread is started, nor the number of processors
    // read.
    let mut items = items;
    let (first, second) = (items.next(), items.next());
    // The number of processors is in files of the system.
    let threads = match second {
        None => 1,
        Some(_) => threads.or_else(|| thread::available_parallelism().ok()).map_or(1, |n| n.get()),
    };
    let mut items = first.into_iter().chain(second).chain(items);
    if threads == 1 {
        let mut own = own()?;
        return items.try_for_each(|item| take(job(&mut own, item)).map(drop));
    }
    let queue = Queue {
        items: Mutex::new(items),
        claimed: AtomicUsize::new(0),
        state: Mutex::new(QueueState {
            taken: 0,
            done: BTreeMap::new(),
            bytes: 0,
            to_drop: (0..threads).map(|_| Vec::new()).collect(),
            working: threads - 1,
            stop: false,
        }),
        ready: Condvar::new(),
        room: Condvar::new(),
        // A thread that meets a slow item lets the others run ahead by this much.
        window: threads * WAITING,
        largest_claim,
    };
    thread::scope(|scope| {
        let (shared, open, job) = (&queue, &open, &job);
        for number in 1..threads {
            let work = move || shared.work(number, open, job);
            // The thread could not be started; its share of `working` must end, or the taker would
            // wait for it.
            if spawn_alike(scope, work).is_err() {
                // The others do its work.
                drop(LeaveAtEnd(&queue));
            }
        }
        let _stop = StopAtEnd(&queue);
        let mut own = own()?;
        queue.work_and_take(&mut |item| job(&mut own, item), &mut take)
    })
}

struct Queue<T, O, R> {
    items: Mutex<T>,
    /// Items that threads have claimed.
    claimed: AtomicUsize,
    state: Mutex<QueueState<O, R>>,
    /// Signals that the next result has arrived or that the last thread has ended.
    ready: Condvar,
    /// Signals that results were taken, so that work may continue.
    room: Condvar,
    /// Number of items that may be claimed ahead of the taken results.
    window: usize,
    largest_claim: usize,
}

struct QueueState<O, R> {
    /// Number of results taken.
    taken: usize,
    /// Waiting results with the thread of each, and their total size.
    done: BTreeMap<usize, (usize, O)>,
    bytes: usize,
    /// What each thread has to drop of its results.
    to_drop: Vec<Vec<R>>,
    /// Threads that are still working.
    working: usize,
    stop: bool,
}

/// The results of a thread that it has not handed over, with their numbers.
struct ThreadResults<O> {
    thread: usize,
    results: Vec<(usize, O)>,
}

/// Signals on drop that a thread has ended, also after a panic of a job.
struct LeaveAtEnd<'a, T, O, R>(&'a Queue<T, O, R>);

impl<T, O, R> Drop for LeaveAtEnd<'_, T, O, R> {
    fn drop(&mut self) {
        self.0.lock().working -= 1;
        self.0.ready.notify_one();
    }
}

/// Stops the other threads on drop, when the thread that takes results is done or has failed.
struct StopAtEnd<'a, T, O, R>(&'a Queue<T, O, R>);

impl<T, O, R> Drop for StopAtEnd<'_, T, O, R> {
    fn drop(&mut self) {
        self.0.lock().stop = true;
        self.0.room.notify_all();
    }
}

impl<T, O, R> Queue<T, O, R> {
    fn lock(&self) -> MutexGuard<'_, QueueState<O, R>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<I, T: Iterator<Item = I>, O: Weighed, R> Queue<T, O, R> {
    fn work<S>(&self, number: usize, open: &impl Fn() -> Option<S>, job: &impl Fn(&mut S, I) -> O) {
        // Also where `open` fails or a job panics.
        let _leave = LeaveAtEnd(self);
        let Some(mut state) = open() else { return };
        let mut job = |item| job(&mut state, item);
        let mut kept = ThreadResults { thread: number, results: Vec::new() };
        while self.wait_for_room(&mut kept) && self.work_on_claim(&mut job, &mut kept) {}
        self.bring(&mut self.lock(), &mut kept);
    }

    /// Works like the other threads, and takes the next results between claims.
    fn work_and_take<E>(
        &self,
        job: &mut impl FnMut(I) -> O,
        take: &mut impl FnMut(O) -> Result<R, E>,
    ) -> Result<(), E> {
        let mut kept = ThreadResults { thread: 0, results: Vec::new() };
        let mut to_drop: Vec<(usize, R)> = Vec::new();
        let mut items_left = true;
        // This thread takes when the next result is there, works when it is not, and sleeps only
        // if it may do neither.
        loop {
            let mut state = self.lock();
            self.bring(&mut state, &mut kept);
            to_drop.drain(..).for_each(|(thread, rest)| state.to_drop[thread].push(rest));
            // The next result is missing.
            while state.done.first_key_value().is_none_or(|(number, _)| *number != state.taken) {
                if items_left && !self.is_full(&state) {
                    break;
                }
                if state.working == 0 && !items_left {
                    return Ok(());
                }
                state = self.ready.wait(state).unwrap_or_else(PoisonError::into_inner);
            }
            let results = Self::results(&mut state);
            drop(state);
            if !results.is_empty() {
                // Before `take`, which may be slow: the others go on meanwhile.
                self.room.notify_all();
                for (thread, result) in results {
                    let rest = take(result)?;
                    // Dropped by the thread that allocated it.
                    if thread != 0 {
                        to_drop.push((thread, rest));
                    }
                }
            }
            items_left = items_left && self.work_on_claim(job, &mut kept);
        }
    }

    /// Claims some items and works on them; `false` if none are left.
    fn work_on_claim(&self, job: &mut impl FnMut(I) -> O, kept: &mut ThreadResults<O>) -> bool {
        let claim = self.claim();
        let some = !claim.is_empty();
        let mut since = Instant::now();
        for (number, item) in claim {
            kept.results.push((number, job(item)));
            if since.elapsed() >= PATIENCE {
                self.bring(&mut self.lock(), kept);
                since = Instant::now();
            }
        }
        some
    }

    /// Whether work is as far ahead as permitted.
    fn is_full(&self, state: &QueueState<O, R>) -> bool {
        let ahead = self.claimed.load(Ordering::Relaxed) - state.taken;
        // `stop` opens the window, so that waiting threads wake and see it.
        !state.stop && (ahead >= self.window || state.bytes >= WAITING_BYTES)
    }

    /// Waits until work may continue; `false` if it must stop.
    fn wait_for_room(&self, kept: &mut ThreadResults<O>) -> bool {
        let mut state = self.lock();
        let to_drop = std::mem::take(&mut state.to_drop[kept.thread]);
        // Outside of the lock: freeing takes time.
        if !to_drop.is_empty() {
            drop(state);
            drop(to_drop);
            state = self.lock();
        }
        // A thread hands over what it has before it sleeps: the next result may be among it.
        if self.is_full(&state) {
            self.bring(&mut state, kept);
            while self.is_full(&state) {
                state = self.room.wait(state).unwrap_or_else(PoisonError::into_inner);
            }
        }
        !state.stop
    }

    /// Claims the next items with their numbers: single ones at first, to spread a few large jobs,
    /// more later, to take fewer locks for many small jobs.
    fn claim(&self) -> Vec<(usize, I)> {
        let mut items = self.items.lock().unwrap_or_else(PoisonError::into_inner);
        let next = self.claimed.load(Ordering::Relaxed);
        let claim: Vec<(usize, I)> =
            // An eighth of what is done: at the start single items, so that a few large jobs
            // spread over the threads.
            (next..).zip(items.by_ref().take((next / 8).clamp(1, self.largest_claim))).collect();
        self.claimed.store(next + claim.len(), Ordering::Relaxed);
        claim
    }

    /// Hands over the collected results of a thread.
    fn bring(&self, state: &mut QueueState<O, R>, kept: &mut ThreadResults<O>) {
        for (number, result) in kept.results.drain(..) {
            state.bytes += result.bytes();
            state.done.insert(number, (kept.thread, result));
        }
        // The taker is woken only if the result that it waits for has arrived.
        if state.done.first_key_value().is_some_and(|(number, _)| *number == state.taken) {
            self.ready.notify_one();
        }
    }

    /// Removes the waiting results that are next in order.
    fn results(state: &mut QueueState<O, R>) -> Vec<(usize, O)> {
        let mut results = Vec::new();
        while let Some((thread, result)) = state.done.remove(&state.taken) {
            state.taken += 1;
            state.bytes -= result.bytes();
            results.push((thread, result));
        }
        results
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
                    (1, i)
                };
                let done: Result<(), ()> = ordered(0..n, threads(t), slow, |(_, i)| {
                    seen.push(i);
                    Ok(())
                });
                assert!(done.is_ok());
                assert_eq!(seen, (0..n).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn what_is_taken_is_dropped_on_the_thread_of_its_job() {
        struct Made<'a>(thread::ThreadId, &'a AtomicUsize);

        impl Drop for Made<'_> {
            fn drop(&mut self) {
                self.1.fetch_add(usize::from(thread::current().id() != self.0), Ordering::Relaxed);
            }
        }

        impl Weighed for Made<'_> {
            fn bytes(&self) -> usize {
                1
            }
        }

        let (elsewhere, others) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let own = thread::current().id();
        let job = |_| {
            let id = thread::current().id();
            match id == own {
                // So that the other thread does most.
                true => thread::sleep(Duration::from_micros(50)),
                false => drop(others.fetch_add(1, Ordering::Relaxed)),
            }
            Made(id, &elsewhere)
        };
        let done: Result<(), ()> = ordered(0..20_000, threads(2), job, Ok);
        assert!(done.is_ok());
        let (elsewhere, others) = (elsewhere.into_inner(), others.into_inner());
        assert!(others > 5_000, "{others}");
        // The last ones, whose thread has ended.
        assert!(elsewhere <= 2 * (2 * WAITING) + 4 * LARGEST_CLAIM, "{elsewhere}");
    }

    #[test]
    fn each_thread_has_a_state_of_its_own_or_does_no_work() {
        let opened = AtomicUsize::new(0);
        // The third thread opens none.
        let open = || Some(opened.fetch_add(1, Ordering::SeqCst) + 1).filter(|&n| n != 2);
        let job = |state: &mut usize, i: usize| {
            assert_ne!(*state, 2);
            thread::sleep(Duration::from_micros(100));
            (1, *state * 1000 + i)
        };
        let mut seen = Vec::new();
        let done: Result<(), ()> =
            ordered_with(0..200, threads(4), (|| Ok(0), open), job, |(_, n)| {
                seen.push(n);
                Ok(())
            });
        assert!(done.is_ok());
        // Without a state of its own the calling thread stops the others.
        for count in [1, 200] {
            let own = || Err("none");
            let done = ordered_with(0..count, threads(4), (own, open), job, |_| Ok(()));
            assert_eq!(done, Err("none"));
        }
        assert_eq!(seen.iter().map(|n| n % 1000).collect::<Vec<_>>(), (0..200).collect::<Vec<_>>());
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
                // A window of work, a window being taken, and the claims made meanwhile.
                assert!(ahead <= 2 * (2 * WAITING) + 4 * LARGEST_CLAIM, "{ahead}");
                (1, ())
            },
            |(_, ())| {
                taken.fetch_add(1, Ordering::SeqCst);
                Ok(())
            },
        );
        assert!(done.is_ok());
    }

    #[test]
    fn a_job_that_panics_ends_the_run() {
        for panicking in [0, 500, 999] {
            let run = || {
                let job = |i| if i == panicking { panic!("as planned") } else { (1, i) };
                ordered(0..1000, threads(2), job, |_| Ok::<(), ()>(()))
            };
            assert!(std::panic::catch_unwind(run).is_err());
        }
    }

    #[test]
    fn a_failure_stops_the_rest() {
        let mut taken = 0;
        let done = ordered(
            0..1_000_000_000u64,
            threads(2),
            |i| (1, i),
            |_| {
                taken += 1;
                if taken == 5 { Err("enough") } else { Ok(()) }
            },
        );
        assert_eq!((done, taken), (Err("enough"), 5));
    }
}
