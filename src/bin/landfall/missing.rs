//! Commands that are not in this build: those that run shaders need the feature `exec`, `lights`
//! needs `analysis`, `lsp`, `port` and `serve` need theirs, `completions` and `man` need
//! `completions`.

use landfall_layout::Error;

use crate::args::Command;
use crate::output::{Failure, Outcome};

/// Returns the error that names the missing feature.
pub fn run(command: &Command) -> Result<Outcome, Failure> {
    let name = match command {
        Command::Completions(_) => "completions",
        Command::Man(_) => "man",
        Command::Verify(_) => "verify",
        Command::Run(_) => "run",
        Command::Stress(_) => "stress",
        Command::Prove(_) => "prove",
        Command::Render(_) => "render",
        Command::Bench(_) => "bench",
        Command::Devices(_) => "devices",
        Command::Lights(_) => "lights",
        Command::Lsp(_) => "lsp",
        Command::Port(_) => "port",
        Command::Serve(_) => "serve",
        _ => unreachable!("every other command is in every build"),
    };
    // The second is the feature to install: commands that run shaders want the drivers as well.
    let (feature, all) = match name {
        "completions" | "man" => ("completions", "completions"),
        "lights" => ("analysis", "analysis"),
        "port" => ("port", "port"),
        "lsp" => ("lsp", "lsp"),
        "serve" => ("serve", "full"),
        _ => ("exec", "full"),
    };
    let message = format!("is not in this build of landfall: it needs the feature `{feature}`");
    let help = format!(
        "cargo install landfall --features {all}; in a checkout: cargo run --release --features {all}"
    );
    Err(Error::new(name, message).with_help(help))
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
            let Err(error) = run(&args.command) else { panic!("it ran") };
            assert!(error.message.contains("`completions`"), "{}", error.message);
            let help = error.help.expect("it says what to install");
            assert!(help.contains("--features completions"), "{help}");
        }
    }

    #[cfg(not(feature = "port"))]
    #[test]
    fn port_names_its_feature() {
        let args = Args::parse_from(["landfall", "port", "a.frag", "--to", "naga"]);
        let Err(error) = run(&args.command) else { panic!("it ran") };
        assert!(error.message.contains("`port`"), "{}", error.message);
        let help = error.help.expect("it says what to install");
        assert!(help.starts_with("cargo install landfall --features port;"), "{help}");
    }

    #[cfg(not(feature = "analysis"))]
    #[test]
    fn lights_names_the_smaller_feature() {
        let args = Args::parse_from(["landfall", "lights", "a.frag", "--deny", "likely"]);
        let Err(error) = run(&args.command) else { panic!("it ran") };
        assert!(error.message.contains("`analysis`"), "{}", error.message);
    }

    #[cfg(not(feature = "exec"))]
    #[test]
    fn every_missing_command_names_the_feature_that_brings_it() {
        for name in ["verify", "run", "stress", "prove", "render", "bench", "devices"] {
            let args =
                Args::parse_from(["landfall", name, "a.frag", "--backend", "gpu", "-f=json"]);
            let Err(error) = run(&args.command) else {
                panic!("{name} ran");
            };
            assert_eq!(error.path, name);
            assert!(error.help.is_some_and(|help| help.contains("--features full")), "{name}");
        }
    }
}
