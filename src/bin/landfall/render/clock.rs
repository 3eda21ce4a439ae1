//! The time of work that may use a backend.

use std::time::Duration;

use landfall_accuracy::bench::clock::{BackendStopwatch, Start};
use landfall_exec::backend::Backend;

/// Runs work on a backend, and returns its time: that of the processor, and of the jobs on a
/// driver.
pub fn timed<T, E>(
    backend: &mut dyn Backend,
    work: &mut dyn FnMut(&mut dyn Backend) -> Result<T, E>,
) -> Result<(T, Duration), E> {
    // A driver works in another process, whose time the own clock of the processor does not count.
    let mut watch = BackendStopwatch::new(backend);
    let start = Start::now();
    let result = work(&mut watch)?;
    let own = start.elapsed().time;
    Ok((result, own + watch.elapsed().map_or(Duration::ZERO, |jobs| jobs.time)))
}
