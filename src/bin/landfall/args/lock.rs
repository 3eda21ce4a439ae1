//! What `lock` and `diff` take.

use std::path::PathBuf;

use clap::ValueEnum;

use super::{ConfigArgs, ReadArgs};

#[derive(Debug, clap::Args)]
pub struct LockArgs {
    /// Files, directories and globs [default: `paths` of the configuration, or .]
    #[arg(value_name = "PATH")]
    pub paths: Vec<PathBuf>,
    /// Directory of the locks, which are the same tree as the shaders from the configuration's
    /// folder [default: `locks` of the configuration, or layouts]
    #[arg(long, value_name = "DIR")]
    pub locks: Option<PathBuf>,
    /// Write nothing; exit with 1 if a lock would change
    #[arg(long)]
    pub check: bool,
    /// Remove locks whose shaders are gone
    #[arg(long)]
    pub prune: bool,
    /// Write over files that have the name of a lock and are none
    #[arg(long)]
    pub force: bool,
    /// Files laid out at a time [default: one a core]
    #[arg(short, long, value_name = "N")]
    pub jobs: Option<std::num::NonZeroUsize>,
    #[command(flatten)]
    pub config: ConfigArgs,
    #[command(flatten)]
    pub read: ReadArgs,
}

/// Exits with 0 when no layout changed, 1 when one did, 2 when that could not be told.
#[derive(Debug, clap::Args)]
pub struct DiffArgs {
    /// Old, then new: shaders, locks, or directories of either, as a path or as git spells one
    /// of a revision (HEAD~1:shaders/light.frag). With --rev: what to compare, . without any
    #[arg(value_name = "A B")]
    pub sides: Vec<PathBuf>,
    /// Compare with what the paths were at this git revision
    #[arg(long, value_name = "REV")]
    pub rev: Option<String>,
    /// Form of the output
    #[arg(short, long, value_name = "FORMAT", default_value = "human")]
    pub format: DiffFormat,
    /// Exit with 1 only if a change is breaking
    #[arg(long)]
    pub breaking: bool,
    /// Renew the lock among A and B by the other side
    #[arg(long, conflicts_with = "rev")]
    pub accept: bool,
    /// Columns of the human form [default: the terminal's, 100 without one]
    #[arg(long, value_name = "N")]
    pub width: Option<usize>,
    #[command(flatten)]
    pub config: ConfigArgs,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DiffFormat {
    /// One line a change, then both listings side by side
    Human,
    /// JSON as `landfall schema diff` describes it
    Json,
    /// Markdown, for a comment on a pull request
    Md,
}
