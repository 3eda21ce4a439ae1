//! The cores that threads run on, with the processes that they start.

/// The cores of several threads, each with processes of its own. A thread and a process that wait for each
/// other in turn fill one core; on two, both cores idle while one wakes the other.
pub struct Cores(Vec<usize>);

impl Cores {
    /// Returns the cores for so many threads: one each, if the calling thread may run on as many. Where
    /// it may run on more, others may be free, and all stay free to move.
    pub fn of(threads: usize) -> Cores {
        let cores = of_thread();
        Cores(if cores.len() == threads { cores } else { Vec::new() })
    }

    /// Keeps the calling thread, and the processes and threads that it starts, on the core of that number.
    pub fn keep(&self, number: usize) {
        if let Some(core) = self.0.get(number) {
            keep_to(*core);
        }
    }
}

/// Returns the cores that the calling thread may run on.
#[cfg(target_os = "linux")]
fn of_thread() -> Vec<usize> {
    use rustix::thread::{CpuSet, sched_getaffinity};

    let Ok(set) = sched_getaffinity(None) else { return Vec::new() };
    (0..CpuSet::MAX_CPU).filter(|core| set.is_set(*core)).collect()
}

/// Returns none: threads run on any core.
#[cfg(not(target_os = "linux"))]
fn of_thread() -> Vec<usize> {
    Vec::new()
}

#[cfg(target_os = "linux")]
fn keep_to(core: usize) {
    use rustix::thread::{CpuSet, sched_setaffinity};

    let mut set = CpuSet::new();
    set.set(core);
    // Without it the thread runs anywhere.
    let _ = sched_setaffinity(None, &set);
}

#[cfg(not(target_os = "linux"))]
fn keep_to(_core: usize) {}

#[cfg(test)]
mod tests {
    use std::thread;

    use super::*;

    /// The cores of a thread of that number.
    fn kept(cores: &Cores, number: usize) -> Vec<usize> {
        let here = || {
            cores.keep(number);
            of_thread()
        };
        thread::scope(|scope| scope.spawn(here).join().unwrap())
    }

    #[test]
    fn each_thread_has_a_core_if_there_are_as_many() {
        let all = of_thread();
        assert_eq!(all.is_empty(), cfg!(not(target_os = "linux")));
        let cores = Cores::of(all.len());
        let each: Vec<usize> = (0..all.len()).flat_map(|number| kept(&cores, number)).collect();
        assert_eq!(each, all);
        assert_eq!(kept(&Cores::of(all.len() + 1), 0), all);
    }
}
