//! Limits of drivers on the lights of a draw.

use super::{Draw, Renderer};
use crate::bind::Kind;
use landfall_exec::backend::{BackendKind, Device, Failure};

/// The iterations after which llvmpipe (Mesa 22.3.6) ends all loops of an invocation, without an
/// error.
const MAX_ITERATIONS: u64 = 65_535;

impl Renderer {
    /// Checks that a device runs as many iterations of the shader's loops over lights as a draw
    /// needs.
    ///
    /// # Errors
    /// More lights than the device loops over: it would drop the rest.
    pub(super) fn within_limits(&self, device: &Device, draw: &Draw<'_>) -> Result<(), Failure> {
        let longest = |lists: &[[u32; 2]]| lists.iter().map(|[_, count]| u64::from(*count)).max();
        let iterations = Kind::ALL.into_iter().map(|kind| match (kind, &draw.tiles) {
            (Kind::Point, Some(tiles)) if self.lists(kind) => longest(&tiles.tiles).unwrap_or(0),
            (Kind::Spot, Some(tiles)) if self.lists(kind) => longest(&tiles.spots).unwrap_or(0),
            _ => self.walked(kind, draw.lights),
        });
        check_iterations(device, iterations.sum())
    }
}

/// Checks that loops over lights stay within the device's limit of iterations.
///
/// # Errors
/// More lights than the device loops over: it would drop the rest.
pub fn check_iterations(device: &Device, iterations: u64) -> Result<(), Failure> {
    let limited = device.backend != BackendKind::Cpu && device.adapter.contains("llvmpipe");
    if !limited || iterations <= MAX_ITERATIONS {
        return Ok(());
    }
    let message = format!(
        "the shader loops over {iterations} lights, but {} ends all loops after {MAX_ITERATIONS} \
         iterations: the other lights would be missing; use `--backend cpu`, or lists of lights",
        device.adapter
    );
    Err(Failure::refused(message, ""))
}
