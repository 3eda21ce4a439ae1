//! Messages shared by both drivers for jobs that cannot be run.

use crate::backend::Failure;

/// Fails if a size exceeds the device's limit, and names both.
pub(super) fn exceeds(
    what: &str,
    size: usize,
    unit: &str,
    limit: Option<u64>,
) -> Result<(), Failure> {
    match limit {
        Some(limit) if size as u64 > limit => {
            let message = format!("{what} has {size} {unit}, but this device supports {limit}");
            Err(Failure::refused(message, ""))
        }
        Some(_) | None => Ok(()),
    }
}

/// Returns the failure of a job that binds two resources in one place.
pub(super) fn twice(place: &str) -> Failure {
    Failure::refused(format!("{place} is bound twice in one job"), "")
}

/// Returns the failure of a job without a resource that the shader reads.
#[cfg(feature = "gl")]
pub(super) fn unbound(what: &str, name: &str) -> Failure {
    let message = format!("the shader reads the {what} `{name}`, but nothing is bound to it");
    Failure::refused(message, "")
}
