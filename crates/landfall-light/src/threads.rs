//! Runs independent jobs on several threads and returns their results in order.
//!
//! The results do not depend on the number of threads. Used where pictures are lit and functions
//! are proved and stressed.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, mpsc};
use std::thread::{self, ScopedJoinHandle};

use landfall_ir::stack::spawn_alike;

/// The results of [`in_order`] that wait for each thread.
const WAITING: usize = 8;

/// The fragments that a thread lights at a time.
pub const FRAGMENTS: usize = 2048;

/// Returns the number of threads for a number that was asked for; 0 is all of the machine.
pub fn number(wanted: usize) -> usize {
    match wanted {
        0 => thread::available_parallelism().map_or(1, usize::from),
        wanted => wanted,
    }
}

/// Runs the jobs numbered from 0, on a thread for each state: the calling thread has the first.
pub fn run<S: Send, R: Send>(
    states: &mut [S],
    jobs: usize,
    job: impl Fn(&mut S, usize) -> R + Sync,
) -> Vec<R> {
    run_beside(states, jobs, job, || ()).0
}

/// The same; the calling thread first does `other`, while the others begin with the jobs: a thread of
/// its own would compete with one of these for a processor.
pub fn run_beside<S: Send, R: Send, O>(
    states: &mut [S],
    jobs: usize,
    job: impl Fn(&mut S, usize) -> R + Sync,
    other: impl FnOnce() -> O,
) -> (Vec<R>, O) {
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
    let (mut done, other) = thread::scope(|scope| {
        let work = &work;
        let spawn = |state| spawn_alike(scope, || work(state));
        // Where no thread can be started, the others do its work.
        let running: Vec<_> = others.iter_mut().flat_map(spawn).collect();
        let other = other();
        let mut done = work(own);
        let joined = running.into_iter().map(ScopedJoinHandle::join);
        done.extend(joined.flat_map(|part| part.expect("a job does not panic")));
        (done, other)
    });
    done.sort_unstable_by_key(|(nth, _)| *nth);
    (done.into_iter().map(|(_, result)| result).collect(), other)
}

/// Passes the results of the jobs numbered from 0 to `take` in their order, while later ones run on
/// all threads of the machine; the calling thread runs those that none has begun. A few results wait
/// at most for each thread.
///
/// # Errors
/// That of `take`, after which each thread ends with its next result.
pub fn in_order<R: Send, E>(
    jobs: usize,
    job: impl Fn(usize) -> R + Sync,
    mut take: impl FnMut(R) -> Result<(), E>,
) -> Result<(), E> {
    let next = AtomicUsize::new(0);
    let claim = || Some(next.fetch_add(1, Ordering::Relaxed)).filter(|nth| *nth < jobs);
    thread::scope(|scope| {
        let threads = number(0).min(jobs);
        let (sender, results) = mpsc::sync_channel(WAITING * threads);
        let (job, claim) = (&job, &claim);
        for _ in 1..threads {
            let sender = sender.clone();
            let work = move || {
                // Until the receiver has failed.
                let sent = |nth: &usize| sender.send((*nth, job(*nth))).is_ok();
                std::iter::from_fn(claim).take_while(sent).for_each(drop);
            };
            // Where no thread can be started, the others do its work.
            let _ = spawn_alike(scope, work);
        }
        drop(sender);
        let mut early = BTreeMap::new();
        for nth in 0..jobs {
            let result = loop {
                if let Some(result) = early.remove(&nth) {
                    break result;
                }
                let done = results.try_recv().ok();
                let own = || claim().map(|own| (own, job(own)));
                let done = done.or_else(own).or_else(|| results.recv().ok());
                early.extend([done.expect("a job does not panic")]);
            };
            take(result)?;
        }
        Ok(())
    })
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
    let other = Mutex::new(Some(other));
    let other = || {
        let other = other.lock().ok().and_then(|mut other| other.take());
        other.expect("a job is taken once")()
    };
    thread::scope(|scope| match spawn_alike(scope, other) {
        Ok(running) => (own(), running.join().expect("a job does not panic")),
        // Where no thread can be started, this one does its work.
        Err(_) => (own(), other()),
    })
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
    use std::hint::black_box;
    use std::time::Duration;

    use super::*;

    /// The longest that threads wait for each other.
    const MOST: Duration = Duration::from_secs(60);

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
            let is_told = || other_begun.lock().is_ok_and(|told| told.recv_timeout(MOST).is_ok());
            nth > 0 || job.send(()).is_ok() && is_told()
        };
        let other = || other.send(()).is_ok() && job_begun.recv_timeout(MOST).is_ok();
        assert_eq!(run_beside(&mut [(), ()], 2, waits, other), (vec![true; 2], true));
        let items: Vec<usize> = (0..1000).collect();
        assert_eq!(
            map(&items, 7, |item| item + 1).collect::<Vec<_>>(),
            (1..1001).collect::<Vec<_>>()
        );
        for threads in [1, 2] {
            assert_eq!(both(threads, || items.len(), || items[7]), (1000, 7));
        }
        for jobs in [0, 1, 2, 1000] {
            let mut taken = Vec::new();
            // Later jobs are shorter, so that they are done first.
            let job = |nth: usize| (nth..jobs).fold(nth, |nth, _| black_box(nth));
            let all = in_order(jobs, job, |nth| {
                taken.push(nth);
                if nth == 700 { Err(nth) } else { Ok(()) }
            });
            let last = jobs.min(701);
            assert_eq!(taken, (0..last).collect::<Vec<_>>());
            assert_eq!(all, if jobs > 700 { Err(700) } else { Ok(()) });
        }
        let mut squares = vec![0; 1000];
        each(squares.chunks_mut(7).enumerate(), |(nth, part)| {
            part.iter_mut().zip(nth * 7..).for_each(|(square, at)| *square = at * at);
        });
        assert_eq!(squares, (0..1000).map(|at| at * at).collect::<Vec<_>>());
    }
}
