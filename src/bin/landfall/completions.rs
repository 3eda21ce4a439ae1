//! `landfall completions`: prints the completion script of a shell. `landfall man`: writes manual
//! pages. Both are derived from the command line as clap parses it.

use clap::Command;
use clap_mangen::Man;
use landfall_check::files;

use crate::args::{CompletionsArgs, ManArgs, command};
use crate::output::{CommandFailure, Outcome, Streams};

/// The section of manuals, and what the pages come from.
const MANUAL: &str = "Landfall";
const SOURCE: &str = concat!("landfall ", env!("CARGO_PKG_VERSION"));

pub fn run(args: &CompletionsArgs, streams: &Streams) -> Result<Outcome, CommandFailure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command(), "landfall", &mut script);
    streams.exactly(&String::from_utf8_lossy(&script))?;
    Ok(Outcome::Clean)
}

pub fn man(args: &ManArgs) -> Result<Outcome, CommandFailure> {
    let mut command = command().disable_help_subcommand(true);
    command.build();
    let writer = files::writer();
    // The pages are named as `git` names those of its commands: `landfall-check.1`.
    let own = std::iter::once(&command);
    for command in own.chain(command.get_subcommands().filter(|command| !command.is_hide_set())) {
        let name = command.get_display_name().unwrap_or(command.get_name());
        writer.write(&args.folder.join(format!("{name}.1")), page(command))?;
    }
    Ok(Outcome::Clean)
}

fn page(command: &Command) -> Vec<u8> {
    let mut page = Vec::new();
    Man::new(command.clone())
        .source(SOURCE)
        .manual(MANUAL)
        .render(&mut page)
        .expect("memory takes what is written");
    page
}
