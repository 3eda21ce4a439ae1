//! `-A`, `-W` and `-D` of `check`, whose order counts, and `--define`.

use clap::{Arg, ArgAction, ArgMatches, Command};
use landfall_layout::finding::Level;

use super::define;

/// Lint levels in the order of their flags, and macros.
///
/// `-D` denies a lint, as in rustc and clippy; a macro is defined with `--define`. A level for
/// `NAME=TEXT` or for an unknown code is refused with a finding that names `--define`.
#[derive(Clone, Debug, Default)]
pub struct LevelArgs {
    pub levels: Vec<(String, Level)>,
    pub defines: Vec<(String, String)>,
}

const LEVELS: [(&str, char, Level, &str); 3] = [
    ("allow", 'A', Level::Allow, "Disable a lint: its code, `warnings` or `all`"),
    ("warn", 'W', Level::Warn, "Report a lint as a warning"),
    ("deny", 'D', Level::Deny, "Report a lint and exit with 1 if it finds something"),
];

impl clap::Args for LevelArgs {
    fn augment_args(command: Command) -> Command {
        let levels = LEVELS.map(|(name, short, _, help)| {
            Arg::new(name)
                .long(name)
                .short(short)
                .help(help)
                .help_heading("Lint levels")
                .value_name("CODE")
                .action(ArgAction::Append)
        });
        let define = Arg::new("define")
            .long("define")
            .help("Define a macro [default value: 1]")
            .help_heading("Reading shaders")
            .value_name("NAME[=TEXT]")
            .value_parser(define)
            .action(ArgAction::Append);
        command.args(levels).arg(define)
    }

    fn augment_args_for_update(command: Command) -> Command {
        LevelArgs::augment_args(command)
    }
}

impl clap::FromArgMatches for LevelArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<LevelArgs, clap::Error> {
        let mut flags: Vec<(usize, (String, Level))> = Vec::new();
        for (name, _, level, _) in LEVELS {
            let codes = matches.get_many::<String>(name).into_iter().flatten();
            let indices = matches.indices_of(name).into_iter().flatten();
            flags.extend(indices.zip(codes.map(|code| (code.clone(), level))));
        }
        flags.sort_by_key(|(index, _)| *index);
        let defines = matches.get_many::<(String, String)>("define").into_iter().flatten();
        Ok(LevelArgs {
            levels: flags.into_iter().map(|(_, level)| level).collect(),
            defines: defines.cloned().collect(),
        })
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

    fn parsed(arguments: &[&str]) -> Result<LevelArgs, clap::Error> {
        let command = LevelArgs::augment_args(Command::new("check").no_binary_name(true));
        LevelArgs::from_arg_matches(&command.try_get_matches_from(arguments)?)
    }

    #[test]
    fn levels_keep_the_order_of_their_flags() {
        let args = parsed(&["-D", "warnings", "-A", "mat3-padding", "-W", "warnings"]).unwrap();
        let levels: Vec<(&str, Level)> =
            args.levels.iter().map(|(code, level)| (code.as_str(), *level)).collect();
        let expected =
            [("warnings", Level::Deny), ("mat3-padding", Level::Allow), ("warnings", Level::Warn)];
        assert_eq!(levels, expected);
    }

    #[test]
    fn a_level_takes_a_code_and_define_a_macro() {
        let args = parsed(&["-D", "layout-drift", "--define", "all", "--define=N=2", "-DN"]);
        let args = args.unwrap();
        let denied = |code: &str| (code.to_string(), Level::Deny);
        assert_eq!(args.levels, [denied("layout-drift"), denied("N")]);
        let setting = |name: &str, text: &str| (name.to_string(), text.to_string());
        assert_eq!(args.defines, [setting("all", "1"), setting("N", "2")]);
    }
}
