//! Arguments of `lock` and `diff`.

use std::path::PathBuf;

use clap::ValueEnum;
use landfall_layout::diff::Policy;

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
    /// Keep the locks of shaders with changes that POLICY forbids, and exit with 1: none, superset,
    /// bytes, names or code [default: `policy` of the configuration, or none]
    #[arg(long, value_name = "POLICY", value_parser = policy)]
    pub policy: Option<Policy>,
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
    /// Write to FILE instead of stdout; a failure leaves FILE unchanged
    #[arg(short, long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Exit with 1 only on breaking changes
    #[arg(long)]
    pub breaking: bool,
    /// Exit with 1 only on changes that POLICY forbids: none, superset (what --breaking reports),
    /// bytes, names or code [default: `policy` of the configuration; without one, any change]
    #[arg(long, value_name = "POLICY", value_parser = policy, conflicts_with = "breaking")]
    pub policy: Option<Policy>,
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
    /// A page with the old and the new memory map of each block
    Html,
}

fn policy(text: &str) -> Result<Policy, String> {
    let names = || Policy::ALL.map(Policy::name).join(", ");
    Policy::from_name(text).ok_or_else(|| format!("the policies are {}", names()))
}
