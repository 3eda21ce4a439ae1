//! Limits of drivers on the lights of a draw.

use super::{Draw, Renderer};
use crate::bind::Kind;
use landfall_exec::backend::{BackendKind, Device, Failure};

/// The turns after which llvmpipe (Mesa 22.3.6) leaves all loops of an invocation, without an
/// error.
const TURNS: u64 = 65_535;

impl Renderer {
    /// Checks that a device takes as many turns of the shader's loops over lights as a draw needs.
    ///
    /// # Errors
    /// More lights than the device loops over: it would drop the rest.
    pub(super) fn within_limits(&self, device: &Device, draw: &Draw<'_>) -> Result<(), Failure> {
        let listed = draw.tiles.filter(|_| self.asks_for_tiles());
        let turns = Kind::ALL.into_iter().map(|kind| match (kind, &listed) {
            (Kind::Point, Some(tiles)) => {
                tiles.tiles.iter().map(|[_, count]| u64::from(*count)).max().unwrap_or(0)
            }
            _ => self.walked(kind, &draw.lights),
        });
        let turns: u64 = turns.sum();
        within_turns(device, turns)
    }
}

/// Checks that a device checks that loops over lights stay below the device's limit of iterations.
///
/// # Errors
/// More than the device takes: it would drop the rest.
pub(crate) fn within_turns(device: &Device, turns: u64) -> Result<(), Failure> {
    let limited = device.backend != BackendKind::Cpu && device.adapter.contains("llvmpipe");
    if !limited || turns <= TURNS {
        return Ok(());
    }
    let message = format!(
        "the shader loops over {turns} lights, but {} leaves all loops after {TURNS} turns: the other \
         lights would be missing; use `--backend cpu`, or lists of lights",
        device.adapter
    );
    Err(Failure::refused(message, ""))
}
