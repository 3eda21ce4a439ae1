//! Arguments of `lock` and `diff`.

use std::path::PathBuf;

use clap::ValueEnum;

use super::{ConfigArgs, ReadArgs};

#[derive(Debug, clap::Args)]
pub struct LockArgs {
    /// Files, directories and globs [default: `paths` of the configuration, or .]
    #[arg(value_name = "PATH")]
    pub paths: Vec<PathBuf>,
    /// Directory of locks, which mirrors the tree of shaders below the configuration's directory
    /// [default: `locks` of the configuration, or layouts]
    #[arg(long, value_name = "DIR")]
    pub locks: Option<PathBuf>,
    /// Write nothing; exit with 1 if a lock would change
    #[arg(long)]
    pub check: bool,
    /// Remove locks whose shaders no longer exist
    #[arg(long)]
    pub prune: bool,
    /// Overwrite files that have the name of a lock but are not locks
    #[arg(long)]
    pub force: bool,
    /// Files processed in parallel [default: one per core]
    #[arg(short, long, value_name = "N")]
    pub jobs: Option<std::num::NonZeroUsize>,
    #[command(flatten)]
    pub config: ConfigArgs,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Debug, clap::Args)]
pub struct DiffArgs {
    /// Old and new: shaders, locks or directories of them, as paths or in a git revision
    /// (HEAD~1:shaders/light.frag); with --rev, the paths to compare [default: .]
    #[arg(value_name = "A B")]
    pub sides: Vec<PathBuf>,
    /// Compare the paths with a git revision
    #[arg(long, value_name = "REV")]
    pub rev: Option<String>,
    /// Output format
    #[arg(short, long, value_name = "FORMAT", default_value = "human")]
    pub format: DiffFormat,
    /// Exit with 1 only on breaking changes
    #[arg(long)]
    pub breaking: bool,
    /// Update the lock among A and B to match the other side
    #[arg(long, conflicts_with = "rev")]
    pub accept: bool,
    /// Width of the human format in columns [default: the terminal's, else 100]
    #[arg(long, value_name = "N")]
    pub width: Option<usize>,
    #[command(flatten)]
    pub config: ConfigArgs,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DiffFormat {
    /// A line per change, then both listings side by side
    Human,
    /// JSON, described by `landfall schema diff`
    Json,
    /// Markdown, for pull-request comments
    Md,
}
