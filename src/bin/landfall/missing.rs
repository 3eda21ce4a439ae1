//! Commands that are not in this build: those that run shaders need the feature `exec`, `lights`
//! needs `analysis`, `lsp`, `port` and `serve` need theirs, `completions` and `man` need
//! `completions`.

use landfall_layout::Error;

use crate::args::Command;
use crate::output::{CommandFailure, Outcome};

/// Returns the error that names the missing feature.
pub fn run(command: &Command) -> Result<Outcome, CommandFailure> {
    // The last is the feature to install: commands that run shaders want the drivers as well.
    let (name, feature, all) = match command {
        Command::Completions(_) => ("completions", "completions", "completions"),
        Command::Man(_) => ("man", "completions", "completions"),
        Command::Verify(_) => ("verify", "exec", "full"),
        Command::Run(_) => ("run", "exec", "full"),
        Command::Stress(_) => ("stress", "exec", "full"),
        Command::Prove(_) => ("prove", "exec", "full"),
        Command::Render(_) => ("render", "exec", "full"),
        Command::Bench(_) => ("bench", "exec", "full"),
        Command::Devices(_) => ("devices", "exec", "full"),
        Command::Lights(_) => ("lights", "analysis", "analysis"),
        Command::Lsp(_) => ("lsp", "lsp", "lsp"),
        Command::Port(_) => ("port", "port", "port"),
        Command::Serve(_) => ("serve", "serve", "full"),
        _ => unreachable!("every other command is in every build"),
    };
    let message = format!("is not in this build of landfall: it needs the feature `{feature}`");
    let help = format!(
        "cargo install landfall --features {all}; in a checkout: cargo run --release --features {all}"
    );
    Err(Error::new(name, message).with_help(help).into())
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::args::Args;

    #[cfg(not(feature = "completions"))]
    #[test]
    fn completions_and_man_name_their_feature() {
        for arguments in [["landfall", "completions", "bash"], ["landfall", "man", "out"]] {
            let args = Args::parse_from(arguments);
            let Err(CommandFailure::Error(error)) = run(&args.command) else { panic!("it ran") };
            assert!(error.message.contains("`completions`"), "{}", error.message);
            let help = error.help.expect("it says what to install");
            assert!(help.contains("--features completions"), "{help}");
        }
    }

    #[cfg(not(feature = "port"))]
    #[test]
    fn port_names_its_feature() {
        let args = Args::parse_from(["landfall", "port", "a.frag", "--to", "naga"]);
        let Err(CommandFailure::Error(error)) = run(&args.command) else { panic!("it ran") };
        assert!(error.message.contains("`port`"), "{}", error.message);
        let help = error.help.expect("it says what to install");
        assert!(help.starts_with("cargo install landfall --features port;"), "{help}");
    }

    #[cfg(not(feature = "analysis"))]
    #[test]
    fn lights_names_the_smaller_feature() {
        let args = Args::parse_from(["landfall", "lights", "a.frag", "--deny", "likely"]);
        let Err(CommandFailure::Error(error)) = run(&args.command) else { panic!("it ran") };
        assert!(error.message.contains("`analysis`"), "{}", error.message);
    }

    #[cfg(not(feature = "exec"))]
    #[test]
    fn every_missing_command_names_the_feature_that_brings_it() {
        for name in ["verify", "run", "stress", "prove", "render", "bench", "devices"] {
            let args =
                Args::parse_from(["landfall", name, "a.frag", "--backend", "gpu", "-f=json"]);
            let Err(CommandFailure::Error(error)) = run(&args.command) else {
                panic!("{name} ran");
            };
            assert_eq!(error.path, name);
            assert!(error.help.is_some_and(|help| help.contains("--features full")), "{name}");
        }
    }
}
