//! `landfall devices`: what can run a shader here. Each driver is opened in a process of
//! its own, so one that crashes is a line of the table and not the end of it.

use landfall::report::devices::{json, table};
use landfall_exec::backend::BackendKind;
use landfall_exec::backend::devices::{Found, cpu};

use crate::args::{DevicesArgs, DevicesFormat};
use crate::output::{Failure, Outcome, Streams};

pub fn run(args: &DevicesArgs, streams: &Streams) -> Result<Outcome, Failure> {
    let mut found = vec![cpu()];
    found.extend(drivers());
    match args.format {
        DevicesFormat::Table => streams.product(&table(&found, streams.paint))?,
        DevicesFormat::Json => streams.json(&json(&found))?,
    }
    Ok(Outcome::Clean)
}

#[cfg(any(feature = "gl", feature = "gpu"))]
fn drivers() -> Vec<Found> {
    use landfall_exec::backend::Failure;
    use landfall_exec::backend::subprocess::{Behind, Launch, list};

    let ask = |(reader, behind): (BackendKind, Behind)| {
        let found = match std::env::current_exe() {
            Ok(program) => list(&Launch::new(program, &behind)),
            Err(cause) => {
                let message = "the path of this program is not to be had, to start it again";
                Err(Failure::missing(message, cause.to_string()))
            }
        };
        found.unwrap_or_else(|failure| {
            vec![Found { reader, kind: String::new(), outcome: Err(failure) }]
        })
    };
    [(BackendKind::Gl, Behind::Gl), (BackendKind::Gpu, Behind::Gpu(None))]
        .into_iter()
        .flat_map(ask)
        .collect()
}

#[cfg(not(any(feature = "gl", feature = "gpu")))]
fn drivers() -> Vec<Found> {
    [BackendKind::Gl, BackendKind::Gpu].map(Found::not_built).into()
}
