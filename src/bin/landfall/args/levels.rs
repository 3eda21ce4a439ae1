//! `-A`, `-W` and `-D`: their order counts, which clap tells only by indices.

use clap::{Arg, ArgAction, ArgMatches, Command};
use landfall_layout::finding::Level;

use super::define;

/// Levels from flags, in their order; and macros.
///
/// `-D CODE` sets a level, and a code that no lint has is refused: no macro comes of a misspelt
/// one. What has a `=` is no code but a macro, as for the other commands; one without a value is
/// written with `--define`.
#[derive(Clone, Debug, Default)]
pub struct LevelArgs {
    pub levels: Vec<(String, Level)>,
    pub defines: Vec<(String, String)>,
}

/// What `-D` was given.
#[derive(Clone, Debug)]
enum Given {
    Code(String),
    Macro(String, String),
}

fn code(text: &str) -> Result<Given, String> {
    Ok(Given::Code(text.to_string()))
}

fn code_or_macro(text: &str) -> Result<Given, String> {
    match text.contains('=') {
        true => only_macro(text),
        false => code(text),
    }
}

fn only_macro(text: &str) -> Result<Given, String> {
    define(text).map(|(name, text)| Given::Macro(name, text))
}

impl clap::Args for LevelArgs {
    fn augment_args(command: Command) -> Command {
        let arg = |id: &'static str, help: &'static str| {
            Arg::new(id).long(id).help(help).action(ArgAction::Append).value_name("CODE")
        };
        let command = command.next_help_heading("Levels of lints");
        command
            .arg(
                arg("allow", "Do not look for it; a lint's code, `warnings` or `all`")
                    .short('A')
                    .value_parser(code),
            )
            .arg(arg("warn", "Report it and succeed all the same").short('W').value_parser(code))
            .arg(
                arg("deny", "Report it and fail; NAME=TEXT defines a macro")
                    .short('D')
                    .value_name("CODE|NAME=TEXT")
                    .value_parser(code_or_macro),
            )
            .arg(
                arg("define", "Define a macro, as 1 unless a value is given")
                    .help_heading("How shaders are read")
                    .value_name("NAME[=TEXT]")
                    .value_parser(only_macro),
            )
            .next_help_heading(None::<&str>)
    }

    fn augment_args_for_update(command: Command) -> Command {
        LevelArgs::augment_args(command)
    }
}

impl clap::FromArgMatches for LevelArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<LevelArgs, clap::Error> {
        let mut given: Vec<(usize, Level, &Given)> = Vec::new();
        let flags = [
            ("allow", Level::Allow),
            ("warn", Level::Warn),
            ("deny", Level::Deny),
            ("define", Level::Deny),
        ];
        for (id, level) in flags {
            let values = matches.get_many::<Given>(id).into_iter().flatten();
            let indices = matches.indices_of(id).into_iter().flatten();
            given.extend(indices.zip(values).map(|(index, value)| (index, level, value)));
        }
        given.sort_by_key(|(index, ..)| *index);
        let mut args = LevelArgs::default();
        for (_, level, value) in given {
            match value {
                Given::Code(code) => args.levels.push((code.clone(), level)),
                Given::Macro(name, text) => args.defines.push((name.clone(), text.clone())),
            }
        }
        Ok(args)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = LevelArgs::from_arg_matches(matches)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{Args, FromArgMatches};

    fn parsed(words: &[&str]) -> LevelArgs {
        let command = LevelArgs::augment_args(Command::new("check").no_binary_name(true));
        LevelArgs::from_arg_matches(&command.get_matches_from(words)).expect("no error of its own")
    }

    #[test]
    fn levels_keep_the_order_of_their_flags() {
        let args = parsed(&["-D", "warnings", "-A", "mat3-padding", "-W", "warnings"]);
        let levels: Vec<(&str, Level)> =
            args.levels.iter().map(|(code, level)| (code.as_str(), *level)).collect();
        let expected =
            [("warnings", Level::Deny), ("mat3-padding", Level::Allow), ("warnings", Level::Warn)];
        assert_eq!(levels, expected);
    }

    #[test]
    fn what_has_a_value_is_a_macro_and_what_has_none_a_code() {
        let args = parsed(&["-DSHADOWS=2", "-D", "layout-drift", "--define", "all", "-DN"]);
        let denied = |code: &str| (code.to_string(), Level::Deny);
        assert_eq!(args.levels, [denied("layout-drift"), denied("N")]);
        let names: Vec<&str> = args.defines.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["SHADOWS", "all"]);
    }
}
