//! Arguments of `check` and `rule`.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::ValueEnum;
use landfall_lint::render::ReportFormat;

use super::levels::LevelArgs;
use super::{RulesArgs, TextArgs};

#[derive(Debug, Default, clap::Args)]
pub struct CheckArgs {
    /// Files, directories and globs; - reads stdin [default: `paths` of the configuration, or .]
    #[arg(value_name = "PATH")]
    pub paths: Vec<PathBuf>,
    /// Report format (human, short, json, github, sarif, junit or html) and file; repeat it for
    /// several reports, at most one of them to stdout [default: human]
    #[arg(
        help_heading = "Reports", short, long = "format", value_name = "FORMAT[=FILE]",
        value_parser = report
    )]
    pub formats: Vec<Report>,
    /// Apply the fixes of findings, then check again
    #[arg(help_heading = "Fixes and locks", long, conflicts_with = "diff")]
    pub fix: bool,
    /// Print the edits of --fix as a patch, change no file, and exit with 1 if there are any
    #[arg(help_heading = "Fixes and locks", long, conflicts_with = "accept")]
    pub diff: bool,
    /// Update the locks of changed shaders and write missing ones
    #[arg(help_heading = "Fixes and locks", long)]
    pub accept: bool,
    /// Permit the findings that FILE records, and fail on every other one [default: `baseline` of
    /// the configuration, or none]
    #[arg(help_heading = "Baseline", long, value_name = "FILE")]
    pub baseline: Option<PathBuf>,
    /// Write all findings to the baseline [default file: landfall-baseline.json]
    #[arg(help_heading = "Baseline", long, conflicts_with = "diff")]
    pub write_baseline: bool,
    /// Insert comments that allow all findings, then check again
    #[arg(
        help_heading = "Baseline", long,
        conflicts_with_all = ["diff", "fix", "write_baseline"]
    )]
    pub add_allow: bool,
    /// Compare layouts with those of a git revision instead of locks
    #[arg(help_heading = "Fixes and locks", long, value_name = "REV", conflicts_with_all = ["accept", "locks"])]
    pub against: Option<String>,
    /// Also report mismatches recorded in a JSON report of `landfall verify`
    #[arg(help_heading = "Scope", long, value_name = "REPORT")]
    pub verified: Vec<PathBuf>,
    /// Directory of locks [default: `locks` of the configuration, or layouts]
    #[arg(help_heading = "Fixes and locks", long, value_name = "DIR")]
    pub locks: Option<PathBuf>,
    /// Skip paths that match GLOB, wholly or in part, relative to the configuration
    #[arg(help_heading = "Scope", long, value_name = "GLOB")]
    pub exclude: Vec<String>,
    /// Cache findings in DIR and recheck only changed shaders [default: `cache-dir` of the
    /// configuration, or none]
    #[arg(help_heading = "Cache and threads", long, value_name = "DIR")]
    pub cache_dir: Option<PathBuf>,
    /// Do not use a cache, even if the configuration sets one
    #[arg(help_heading = "Cache and threads", long, conflicts_with = "cache_dir")]
    pub no_cache: bool,
    /// Print the number of findings per lint
    #[arg(help_heading = "Reports", long)]
    pub statistics: bool,
    /// Check again when a shader, an include, a lock or the configuration changes; Ctrl-C ends with
    /// the exit code of the last check
    #[arg(
        help_heading = "Scope", long,
        conflicts_with_all = ["diff", "add_allow", "write_baseline"]
    )]
    pub watch: bool,
    /// Files processed in parallel [default: one per core]
    #[arg(help_heading = "Cache and threads", short, long, value_name = "N")]
    pub jobs: Option<NonZeroUsize>,
    #[command(flatten)]
    pub config: ConfigArgs,
    #[command(flatten)]
    pub levels: LevelArgs,
    #[command(flatten)]
    pub text: TextArgs,
    #[command(flatten)]
    pub rules: RulesArgs,
    /// Whether this is `report`, which shows findings and does not fail for them.
    #[arg(skip)]
    pub is_report: bool,
}

/// The choice of the configuration file.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct ConfigArgs {
    /// Configuration file [default: landfall.toml or .landfall.toml, here or in a parent directory]
    #[arg(help_heading = "Configuration", long, value_name = "FILE", conflicts_with = "no_config")]
    pub config: Option<PathBuf>,
    /// Ignore configuration files
    #[arg(help_heading = "Configuration", long)]
    pub no_config: bool,
}

#[derive(Debug, clap::Args)]
pub struct RuleArgs {
    /// Code of a lint or hazard; without it, all are listed
    #[arg(value_name = "CODE")]
    pub code: Option<String>,
    /// Output format
    #[arg(short, long, value_name = "FORMAT", default_value = "human")]
    pub format: RuleFormat,
    /// Explain all lints and hazards
    #[arg(long, conflicts_with = "code")]
    pub all: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RuleFormat {
    /// Text
    Human,
    /// One object per lint or hazard
    Json,
    /// Markdown
    Md,
}

/// The format and destination of a report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
    pub format: Form,
    /// `None` for stdout.
    pub file: Option<PathBuf>,
}

/// The form of a report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Findings alone.
    Findings(ReportFormat),
    /// A page of findings and layouts.
    Html,
}

const FORMATS: [(&str, Form); 7] = [
    ("human", Form::Findings(ReportFormat::Human)),
    ("short", Form::Findings(ReportFormat::Short)),
    ("json", Form::Findings(ReportFormat::Json)),
    ("github", Form::Findings(ReportFormat::Github)),
    ("sarif", Form::Findings(ReportFormat::Sarif)),
    ("junit", Form::Findings(ReportFormat::Junit)),
    ("html", Form::Html),
];

/// Parses `FORMAT` or `FORMAT=FILE`.
fn report(text: &str) -> Result<Report, String> {
    let (name, file) = match text.split_once('=') {
        Some((_, "")) => return Err("no file name after `=`".to_string()),
        Some((name, file)) => (name, Some(PathBuf::from(file))),
        None => (text, None),
    };
    let known = FORMATS.iter().find(|(known, _)| *known == name);
    let names = || FORMATS.map(|(name, _)| name).join(", ");
    match known {
        Some((_, format)) => Ok(Report { format: *format, file }),
        None => Err(format!("the formats are {}", names())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_may_name_its_file() {
        let sarif = Form::Findings(ReportFormat::Sarif);
        let sarif = Report { format: sarif, file: Some(PathBuf::from("a=b.sarif")) };
        assert_eq!(report("sarif=a=b.sarif"), Ok(sarif));
        assert_eq!(report("short").map(|report| report.file), Ok(None));
        assert!(report("json=").is_err() && report("xml").is_err());
    }
}
