//! `landfall devices`: lists backends and adapters. Each driver and the browser is opened in its
//! own process, so a crash is a line of the table.

use landfall::report::devices::{json, table};
use landfall_exec::backend::BackendKind;
use landfall_exec::backend::devices::{BackendEntry, cpu};

use crate::args::{DevicesArgs, DevicesFormat, VerifierName};
use crate::browser;
use crate::output::{CommandFailure, Outcome, Streams};

pub fn run(args: &DevicesArgs, streams: &Streams) -> Result<Outcome, CommandFailure> {
    let asked = |name: VerifierName| args.backends.is_empty() || args.backends.contains(&name);
    let mut found = Vec::new();
    if asked(VerifierName::Cpu) {
        found.push(cpu());
    }
    found.extend(drivers(asked));
    if asked(VerifierName::Web) {
        found.extend(browser::list());
    }
    match args.format {
        DevicesFormat::Table => streams.product(&table(&found, streams.paint))?,
        DevicesFormat::Json => streams.json(&json(&found))?,
    }
    Ok(Outcome::Clean)
}

#[cfg(any(feature = "gl", feature = "gpu"))]
fn drivers(asked: impl Fn(VerifierName) -> bool) -> Vec<BackendEntry> {
    use landfall_exec::backend::Failure;
    use landfall_exec::backend::subprocess::{DriverKind, Launch, list};

    let open = |(_, backend, driver_kind): (VerifierName, BackendKind, DriverKind)| {
        // A driver that crashes ends its process, not the list.
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
    [
        (VerifierName::Gl, BackendKind::Gl, DriverKind::Gl),
        (VerifierName::Gpu, BackendKind::Gpu, DriverKind::Gpu(None)),
    ]
    .into_iter()
    .filter(|(name, ..)| asked(*name))
    .flat_map(open)
    .collect()
}

#[cfg(not(any(feature = "gl", feature = "gpu")))]
fn drivers(asked: impl Fn(VerifierName) -> bool) -> Vec<BackendEntry> {
    [(VerifierName::Gl, BackendKind::Gl), (VerifierName::Gpu, BackendKind::Gpu)]
        .into_iter()
        .filter(|(name, _)| asked(*name))
        .map(|(_, backend)| BackendEntry::not_built(backend))
        .collect()
}
