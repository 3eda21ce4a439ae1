//! The help texts: commands grouped by purpose, and examples of each command.

use std::ffi::OsString;
use std::fmt::Write as _;
use std::io;

use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Args as _, Command, CommandFactory, FromArgMatches};
use landfall_layout::text::edit_distance::nearest;
use landfall_layout::text::escape;

use super::examples::{EXAMPLES, Example};
use super::{
    Args, CheckArgs, DecodeArgs, DiffArgs, EmitArgs, EncodeArgs, ExplainArgs, GlobalArgs,
    LayoutArgs, LockArgs,
};
use crate::stdout;

/// The commands by what people do with them, in the order of the help.
const GROUPS: [(&str, &[&str]); 6] = [
    ("Lay out", &["layout", "explain", "report", "serve", "lsp"]),
    ("Generate", &["emit", "port", "encode", "decode", "schema"]),
    ("Guard", &["init", "lock", "check", "diff", "rule"]),
    ("Prove", &["verify", "prove", "run", "devices"]),
    ("Light", &["lights", "render"]),
    ("Measure", &["stress", "bench"]),
];

/// Parses the arguments of this process; wrong usage and `--help` end it.
pub fn parse() -> Args {
    if let Some(args) = parse_one() {
        return args;
    }
    let mut command = command();
    let matches = command.try_get_matches_from_mut(std::env::args_os());
    let matches = matches.unwrap_or_else(|error| exit(with_value(error, &command)));
    Args::from_arg_matches(&matches).unwrap_or_else(|error| exit(error.format(&mut command)))
}

/// Adds the arguments of a command.
type Augment = fn(Command) -> Command;

/// The commands of scripts and builds, which are started often.
const ALONE: &[(&str, Augment)] = &[
    ("layout", LayoutArgs::augment_args),
    ("explain", ExplainArgs::augment_args),
    ("emit", EmitArgs::augment_args),
    ("encode", EncodeArgs::augment_args),
    ("decode", DecodeArgs::augment_args),
    ("lock", LockArgs::augment_args),
    ("diff", DiffArgs::augment_args),
    ("check", CheckArgs::augment_args),
];

/// Parses the arguments of a command without building the others, which takes longer than laying
/// out a file. `None` for any other command, help and wrong usage.
fn parse_one() -> Option<Args> {
    let arguments: Vec<OsString> = std::env::args_os().collect();
    let name = arguments.get(1)?.to_str()?;
    let (name, add) = *ALONE.iter().find(|(alone, _)| *alone == name)?;
    let global = GlobalArgs::augment_args(Command::new("landfall"));
    // Help is part of the whole command.
    let one = add(Command::new(name).disable_help_flag(true));
    let mut command = global.disable_help_subcommand(true).subcommand(one);
    let matches = command.try_get_matches_from_mut(arguments).ok()?;
    Args::from_arg_matches(&matches).ok()
}

/// Suggests the option of which an unknown one is a value: for `--json`, `--format json`.
fn with_value(mut error: clap::Error, command: &Command) -> clap::Error {
    let given = match error.get(ContextKind::InvalidArg) {
        Some(ContextValue::String(given)) if error.kind() == ErrorKind::UnknownArgument => given,
        _ => return error,
    };
    let mut names = std::env::args().skip(1);
    let named = names.find_map(|name| command.find_subcommand(name));
    let options = named.into_iter().flat_map(Command::get_arguments);
    let values: Vec<(&str, String)> = options
        .filter_map(|option| Some((option.get_long()?, option.get_possible_values())))
        .flat_map(|(long, values)| {
            values.into_iter().map(move |v| (long, v.get_name().to_string()))
        })
        .collect();
    let meant = nearest(given.trim_start_matches('-'), values.iter().map(|(_, value)| &**value));
    let option = meant.and_then(|meant| values.iter().find(|(_, value)| value == meant));
    if let Some((long, value)) = option {
        let tip = StyledStr::from(format!("there is `--{long} {value}`"));
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip]));
    }
    error
}

/// Prints help or an error and ends the process. Clap repeats values as they are: with control
/// characters among the arguments, its message is escaped.
fn exit<T>(error: clap::Error) -> T {
    let hostile = std::env::args_os().any(|argument| {
        let argument = argument.to_string_lossy();
        escape::name(&argument) != argument
    });
    if hostile && error.use_stderr() {
        let text = error.render().to_string();
        eprint!("{}", escape::output(&text, escape::Styles::Shown));
        std::process::exit(error.exit_code());
    }
    let lost = match error.print() {
        _ if !error.use_stderr() && stdout::was_closed() => Some("it is closed".to_string()),
        Err(cause) if !error.use_stderr() && cause.kind() != io::ErrorKind::BrokenPipe => {
            Some(landfall_layout::file::reason(&cause))
        }
        Ok(()) | Err(_) => None,
    };
    if let Some(cause) = lost {
        eprintln!("error: standard output cannot be written: {cause}");
        std::process::exit(2);
    }
    std::process::exit(error.exit_code())
}

/// The command line with its help texts.
pub fn command() -> Command {
    let command = Args::command();
    let template = template(&command);
    EXAMPLES.iter().fold(command.help_template(template), |command, (name, examples)| {
        command.mut_subcommand(name, |command| {
            let text = examples_text(&command, examples);
            command.after_long_help(text)
        })
    })
}

/// The help of `landfall` itself, with the commands in their groups.
fn template(command: &Command) -> StyledStr {
    let styles = command.get_styles();
    let (header, literal) = (styles.get_header(), styles.get_literal());
    let mut text = String::from("{about-with-newline}\n{usage-heading} {usage}\n");
    let shown = command.get_subcommands().filter(|command| !command.is_hide_set());
    let width = shown.map(|command| command.get_name().len()).max().unwrap_or(0);
    for (group, names) in GROUPS {
        let _ = writeln!(text, "\n{header}{group}:{header:#}");
        for name in names {
            let about = command.find_subcommand(name).and_then(Command::get_about);
            let about = about.map(StyledStr::to_string).unwrap_or_default();
            let _ = writeln!(
                text,
                "  {literal}{name}{literal:#}{:1$}  {about}",
                "",
                width - name.len()
            );
        }
    }
    let _ = write!(text, "\n{header}Options:{header:#}\n{{options}}\n\n");
    let _ = write!(
        text,
        "`{literal}landfall COMMAND --help{literal:#}` prints options and examples of a command."
    );
    text.into()
}

/// The end of a command's long help: its exit codes or notes if it has any, then its examples.
fn examples_text(command: &Command, examples: &[Example]) -> StyledStr {
    let styles = command.get_styles();
    let (header, literal) = (styles.get_header(), styles.get_literal());
    let mut text = String::new();
    if let Some(notes) = command.get_after_help() {
        let _ = write!(text, "{}\n\n", notes.ansi());
    }
    let _ = write!(text, "{header}Examples:{header:#}");
    for (purpose, line) in examples {
        if !purpose.is_empty() {
            let _ = write!(text, "\n  # {purpose}");
        }
        let _ = write!(text, "\n  {literal}{line}{literal:#}");
    }
    text.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn visible(command: &Command) -> impl Iterator<Item = &Command> {
        command.get_subcommands().filter(|command| !command.is_hide_set())
    }

    #[test]
    fn every_command_is_in_one_group_and_every_group_names_commands() {
        let command = command();
        let mut grouped: Vec<&str> = GROUPS.iter().flat_map(|(_, names)| *names).copied().collect();
        let mut names: Vec<&str> = visible(&command).map(Command::get_name).collect();
        grouped.sort_unstable();
        names.sort_unstable();
        assert_eq!(grouped, names);
    }

    /// Usage of the first argument alone is that of the whole command.
    #[test]
    fn a_command_parsed_alone_takes_the_arguments_of_the_whole_one() {
        let whole = command();
        for (name, add) in ALONE {
            let alone = add(Command::new(*name));
            let names = |command: &Command| -> Vec<String> {
                command.get_arguments().map(|argument| argument.get_id().to_string()).collect()
            };
            let found = whole.find_subcommand(name).expect("it is a command");
            assert_eq!(names(&alone), names(found), "{name}");
        }
    }

    #[test]
    fn every_command_has_a_short_description_and_examples() {
        let command = command();
        for command in visible(&command) {
            let name = command.get_name();
            let about = command.get_about().map(StyledStr::to_string).unwrap_or_default();
            assert!(!about.is_empty() && about.len() < 72, "{name}: {about}");
            let examples = command.get_after_long_help().map(StyledStr::to_string);
            assert!(examples.is_some_and(|text| text.contains("\n  landfall ")), "{name}");
        }
    }
}
