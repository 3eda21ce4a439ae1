//! `landfall __reader`: the hidden command that serves a driver to another process.

use landfall_exec::backend::subprocess::{DriverKind, serve};
use landfall_layout::Error;

use crate::args::{ServeBackendArgs, ServedDriver};
use crate::output::{CommandFailure, Outcome};

pub fn run(args: &ServeBackendArgs) -> Result<Outcome, CommandFailure> {
    let driver_kind = match args.driver {
        ServedDriver::Gl => DriverKind::Gl,
        ServedDriver::Gpu => DriverKind::Gpu(args.adapter.clone()),
    };
    // The client has disconnected, and the driver may hang.
    let on_stdin_end = || std::process::exit(0);
    serve(&driver_kind, on_stdin_end).map_err(|cause| Error::new("<stdin>", cause.to_string()))?;
    Ok(Outcome::Clean)
}
