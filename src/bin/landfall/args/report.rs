//! Arguments of `report`.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use super::check::{CheckArgs, Form, Report};
use super::levels::LevelArgs;
use super::{ConfigArgs, ReadArgs};

#[derive(Debug, clap::Args)]
pub struct ReportArgs {
    /// Files, directories and globs; - reads stdin [default: `paths` of the configuration, or .]
    #[arg(value_name = "PATH")]
    pub paths: Vec<PathBuf>,
    /// Write to FILE instead of stdout; a failure leaves FILE unchanged
    #[arg(short, long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Skip paths that match GLOB, wholly or in part, relative to the configuration
    #[arg(long, value_name = "GLOB")]
    pub exclude: Vec<String>,
    /// Directory of locks, with which layouts are compared [default: `locks` of the configuration,
    /// or layouts]
    #[arg(long, value_name = "DIR")]
    pub locks: Option<PathBuf>,
    /// Files processed in parallel [default: one per core]
    #[arg(short, long, value_name = "N")]
    pub jobs: Option<NonZeroUsize>,
    #[command(flatten)]
    pub config: ConfigArgs,
    #[command(flatten)]
    pub read: ReadArgs,
}

impl ReportArgs {
    /// The check that finds what the report shows.
    pub fn check(&self) -> CheckArgs {
        CheckArgs {
            paths: self.paths.clone(),
            formats: vec![Report { format: Form::Html, file: self.out.clone() }],
            exclude: self.exclude.clone(),
            locks: self.locks.clone(),
            jobs: self.jobs,
            config: self.config.clone(),
            levels: LevelArgs { defines: self.read.defines.clone(), ..LevelArgs::default() },
            text: self.read.text.clone(),
            rules: self.read.rules.clone(),
            is_report: true,
            ..CheckArgs::default()
        }
    }
}
