//! `landfall devices`: lists backends and adapters. Each driver and the browser is opened in its own
//! process, so a crash is a line of the table.

use landfall::report::devices::{json, table};
use landfall_exec::backend::BackendKind;
use landfall_exec::backend::devices::{BackendEntry, cpu};

use crate::args::{DevicesArgs, DevicesFormat};
use crate::browser;
use crate::output::{Failure, Outcome, Streams};

pub fn run(args: &DevicesArgs, streams: &Streams) -> Result<Outcome, Failure> {
    let mut found = vec![cpu()];
    found.extend(drivers());
    found.extend(browser::list());
    match args.format {
        DevicesFormat::Table => streams.product(&table(&found, streams.paint))?,
        DevicesFormat::Json => streams.json(&json(&found))?,
    }
    Ok(Outcome::Clean)
}

#[cfg(any(feature = "gl", feature = "gpu"))]
fn drivers() -> Vec<BackendEntry> {
    use landfall_exec::backend::Failure;
    use landfall_exec::backend::subprocess::{DriverKind, Launch, list};

    let ask = |(backend, driver_kind): (BackendKind, DriverKind)| {
        let found = match std::env::current_exe() {
            Ok(program) => list(&Launch::new(program, &driver_kind)),
            Err(cause) => {
                let message =
                    "the path of the landfall executable is unknown; drivers run in a copy of it";
                Err(Failure::missing(message, cause.to_string()))
            }
        };
        found.unwrap_or_else(|failure| {
            vec![BackendEntry { backend, kind: String::new(), outcome: Err(failure) }]
        })
    };
    [(BackendKind::Gl, DriverKind::Gl), (BackendKind::Gpu, DriverKind::Gpu(None))]
        .into_iter()
        .flat_map(ask)
        .collect()
}

#[cfg(not(any(feature = "gl", feature = "gpu")))]
fn drivers() -> Vec<BackendEntry> {
    [BackendKind::Gl, BackendKind::Gpu].map(BackendEntry::not_built).into()
}
