//! What both drivers say of a job that cannot be run, in the same words.

use crate::backend::Failure;

/// Refuses what is more than a device takes, with both numbers.
pub(super) fn exceeds(
    what: &str,
    size: usize,
    unit: &str,
    limit: Option<u64>,
) -> Result<(), Failure> {
    match limit {
        Some(limit) if size as u64 > limit => {
            let message = format!("{what} has {size} {unit}, and this device takes {limit}");
            Err(Failure::refused(message, ""))
        }
        Some(_) | None => Ok(()),
    }
}

/// A place with two resources.
pub(super) fn twice(place: &str) -> Failure {
    Failure::refused(format!("{place} is bound twice in one job"), "")
}
