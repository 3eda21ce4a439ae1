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

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::args::Args;

    #[test]
    fn every_missing_command_names_the_feature_that_brings_it() {
        for name in ["verify", "run", "stress", "render", "bench", "devices"] {
            let args =
                Args::parse_from(["landfall", name, "a.frag", "--backend", "gpu", "-f=json"]);
            let Err(Failure::Error(error)) = run(&args.command) else {
                panic!("{name} ran");
            };
            assert_eq!(error.path, name);
            assert!(error.help.is_some_and(|help| help.contains("--features full")), "{name}");
        }
    }
}
