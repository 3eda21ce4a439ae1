//! Commands that run shaders, in a build without the feature that brings them.

use landfall_layout::Error;
use landfall_layout::error::ErrorKind;

use crate::args::Command;
use crate::output::{Failure, Outcome};

/// Says which feature brings a command.
pub fn run(command: &Command) -> Result<Outcome, Failure> {
    let name = match command {
        Command::Verify(_) => "verify",
        Command::Run(_) => "run",
        Command::Stress(_) => "stress",
        Command::Render(_) => "render",
        Command::Bench(_) => "bench",
        Command::Devices(_) => "devices",
        _ => unreachable!("every other command is in every build"),
    };
    Err(Failure::Error(Error {
        path: name.to_string(),
        message: "is not in this build of landfall: it runs shaders".to_string(),
        help: Some(
            "install the whole of it: cargo install landfall --features full; in a checkout: \
             cargo run --release --features full"
                .to_string(),
        ),
        kind: ErrorKind::Other,
    }))
}
