//! Options for reading shaders whose code is followed, whatever the offsets in their blocks are.

use landfall_check::config::define;

use super::{ReadArgs, RulesArgs, TextArgs};

/// [`ReadArgs`] without rules, for commands whose results do not depend on offsets.
#[derive(Clone, Debug)]
pub struct CodeArgs(ReadArgs);

/// The options of [`CodeArgs`].
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Reading shaders")]
struct CodeReadOptions {
    #[command(flatten)]
    text: TextArgs,
    /// Define a macro [default value: 1]; in WESL, set a feature, which `NAME=false` clears
    #[arg(short = 'D', long = "define", value_name = "NAME[=TEXT]", value_parser = define)]
    defines: Vec<(String, String)>,
}

impl clap::Args for CodeArgs {
    fn augment_args(command: clap::Command) -> clap::Command {
        CodeReadOptions::augment_args(command)
    }

    fn augment_args_for_update(command: clap::Command) -> clap::Command {
        CodeReadOptions::augment_args_for_update(command)
    }
}

impl clap::FromArgMatches for CodeArgs {
    fn from_arg_matches(matches: &clap::ArgMatches) -> Result<CodeArgs, clap::Error> {
        let CodeReadOptions { text, defines } = CodeReadOptions::from_arg_matches(matches)?;
        Ok(CodeArgs(ReadArgs { text, defines, rules: RulesArgs::default() }))
    }

    fn update_from_arg_matches(&mut self, matches: &clap::ArgMatches) -> Result<(), clap::Error> {
        *self = CodeArgs::from_arg_matches(matches)?;
        Ok(())
    }
}

impl std::ops::Deref for CodeArgs {
    type Target = ReadArgs;

    fn deref(&self) -> &ReadArgs {
        &self.0
    }
}
