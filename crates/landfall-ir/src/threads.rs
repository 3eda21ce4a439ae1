//! Runs independent jobs on several threads and returns their results in order.
//!
//! The results do not depend on the number of threads.

mod ordered;

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::{self, ScopedJoinHandle};

use crate::stack::spawn_alike;

pub use ordered::{Weighed, ordered, ordered_with};

/// Returns the number of threads for a number that was asked for; 0 is all of the machine.
pub fn number(wanted: usize) -> usize {
    match wanted {
        0 => thread::available_parallelism().map_or(1, usize::from),
        wanted => wanted,
    }
}

/// Runs `own` on the calling thread, and `work` on another one for each state; returns what these
/// return in the order of the states.
pub fn beside<S: Send, T: Send, A>(
    own: impl FnOnce() -> A,
    states: impl Iterator<Item = S>,
    work: impl Fn(S) -> T + Sync,
) -> (A, Vec<T>) {
    // Each state is replaced by its result, under a lock.
    let states: Vec<_> = states.map(|state| Mutex::new((Some(state), None))).collect();
    let job = |nth: usize| {
        if let Ok(mut state) = states[nth].lock() {
            state.1 = state.0.take().map(&work).or(state.1.take());
        }
    };
    let (mut own, mut result) = (Some(own), None);
    spread(&mut || result = own.take().map(|own| own()), states.len(), &job);
    let done = states.into_iter().filter_map(|state| state.into_inner().ok()?.1);
    (result.expect("it has run"), done.collect())
}

/// Runs `own` on the calling thread, and each job on another one. Generic over nothing, as starting
/// threads is much code, and there are many kinds of jobs.
fn spread(own: &mut dyn FnMut(), jobs: usize, job: &(dyn Fn(usize) + Sync)) {
    thread::scope(|scope| {
        let spawn = |nth| spawn_alike(scope, move || job(nth));
        let running: Vec<_> = (0..jobs).flat_map(spawn).collect();
        own();
        // Where no thread could be started, this one does its work.
        (0..jobs).for_each(job);
        let joined = running.into_iter().map(ScopedJoinHandle::join);
        joined.for_each(|done| done.expect("a job does not panic"));
    });
}

/// Returns numbered results in the order of their numbers, which are those from 0.
pub fn in_order<T>(count: usize, numbered: impl Iterator<Item = (usize, T)>) -> Vec<T> {
    let mut results: Vec<Option<T>> = (0..count).map(|_| None).collect();
    numbered.for_each(|(nth, result)| results[nth] = Some(result));
    results.into_iter().flatten().collect()
}

/// Runs the jobs numbered from 0, on a thread for each state: the calling thread has the first.
pub fn run<S: Send, R: Send>(
    states: &mut [S],
    jobs: usize,
    job: impl Fn(&mut S, usize) -> R + Sync,
) -> Vec<R> {
    run_beside(states, jobs, job, || ()).0
}

/// The same; the calling thread first does `other`, while the others begin with the jobs: a thread
/// of its own would compete with one of these for a processor.
pub fn run_beside<S: Send, R: Send, O>(
    states: &mut [S],
    jobs: usize,
    job: impl Fn(&mut S, usize) -> R + Sync,
    other: impl FnOnce() -> O,
) -> (Vec<R>, O) {
    // No more threads than jobs.
    let used = states.len().min(jobs);
    let Some((own, others)) = states[..used].split_first_mut() else {
        return (Vec::new(), other());
    };
    if others.is_empty() {
        let other = other();
        return ((0..jobs).map(|nth| job(own, nth)).collect(), other);
    }
    // A thread takes the next job when it has done one: jobs may differ in length.
    let next = AtomicUsize::new(0);
    let work = |state: &mut S| {
        let claims = std::iter::from_fn(|| {
            let nth = next.fetch_add(1, Ordering::Relaxed);
            (nth < jobs).then_some(nth)
        });
        claims.map(|nth| (nth, job(state, nth))).collect::<Vec<_>>()
    };
    let (done, other) = {
        let own = || {
            let other = other();
            (work(own), other)
        };
        let ((mut done, other), parts) = beside(own, others.iter_mut(), work);
        done.extend(parts.into_iter().flatten());
        (done, other)
    };
    (in_order(jobs, done.into_iter()), other)
}

/// Runs one job on the calling thread, and another one beside it if there is more than one thread.
/// The other one may itself use as many threads.
pub fn both<A, B: Send>(
    threads: usize,
    own: impl FnOnce() -> A,
    other: impl FnOnce() -> B + Send,
) -> (A, B) {
    if threads == 1 {
        return (own(), other());
    }
    let (own, mut other) = beside(own, std::iter::once(other), |other| other());
    (own, other.remove(0))
}

/// Returns what `of` returns for each item, on all threads of the machine; a thread takes so many
/// items at a time.
pub fn map<T: Sync, R: Send>(
    items: &[T],
    pack: usize,
    of: impl Fn(&T) -> R + Sync,
) -> impl Iterator<Item = R> {
    let packs: Vec<&[T]> = items.chunks(pack).collect();
    let mut states = vec![(); number(0)];
    let done =
        run(&mut states, packs.len(), |(), nth| packs[nth].iter().map(&of).collect::<Vec<R>>());
    done.into_iter().flatten()
}

/// Calls `of` for each part, on all threads of the machine.
pub fn each<P: Send>(parts: impl Iterator<Item = P>, of: impl Fn(P) + Sync) {
    let parts: Vec<Mutex<Option<P>>> = parts.map(|part| Mutex::new(Some(part))).collect();
    let mut states = vec![(); number(0)];
    run(&mut states, parts.len(), |(), nth| {
        let part = parts[nth].lock().ok().and_then(|mut part| part.take());
        of(part.expect("a part is taken once"));
    });
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;
    use std::time::Duration;

    use super::*;

    /// The longest that threads wait for each other.
    const LIMIT: Duration = Duration::from_secs(60);

    #[test]
    fn results_are_in_the_order_of_the_jobs() {
        for threads in 0..5 {
            for jobs in [0, 1, 2, 1000] {
                let mut counts = vec![0; threads];
                let results = run(&mut counts, jobs, |count, nth| {
                    *count += 1;
                    nth * 3
                });
                let ran = if threads == 0 { 0 } else { jobs };
                assert_eq!(results, (0..ran).map(|nth| nth * 3).collect::<Vec<_>>());
                assert_eq!(counts.iter().sum::<usize>(), ran);
            }
        }
        for (threads, jobs) in [(0, 3), (1, 3), (2, 0), (2, 1), (2, 1000)] {
            let own = thread::current().id();
            let other = || (thread::current().id() == own).then_some(threads);
            let (results, other) = run_beside(&mut vec![(); threads], jobs, |(), nth| nth, other);
            let ran = if threads == 0 { 0 } else { jobs };
            assert_eq!((results, other), ((0..ran).collect(), Some(threads)));
        }
        // Another thread runs a job while this one runs `other`: each waits for the other.
        let ((job, job_begun), (other, other_begun)) = (mpsc::channel(), mpsc::channel());
        let other_begun = Mutex::new(other_begun);
        let waits = |(): &mut (), nth: usize| {
            let is_told = || other_begun.lock().is_ok_and(|told| told.recv_timeout(LIMIT).is_ok());
            nth > 0 || job.send(()).is_ok() && is_told()
        };
        let other = || other.send(()).is_ok() && job_begun.recv_timeout(LIMIT).is_ok();
        assert_eq!(run_beside(&mut [(), ()], 2, waits, other), (vec![true; 2], true));
        let items: Vec<usize> = (0..1000).collect();
        assert_eq!(
            map(&items, 7, |item| item + 1).collect::<Vec<_>>(),
            (1..1001).collect::<Vec<_>>()
        );
        for threads in [1, 2] {
            assert_eq!(both(threads, || items.len(), || items[7]), (1000, 7));
        }
        let mut squares = vec![0; 1000];
        each(squares.chunks_mut(7).enumerate(), |(nth, part)| {
            part.iter_mut().zip(nth * 7..).for_each(|(square, at)| *square = at * at);
        });
        assert_eq!(squares, (0..1000).map(|at| at * at).collect::<Vec<_>>());
    }
}
