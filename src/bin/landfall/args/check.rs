//! What `check`, `merge` and `rule` take.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::ValueEnum;
use landfall_lint::render::ReportFormat;

use super::TextArgs;
use super::levels::LevelArgs;

#[derive(Debug, clap::Args)]
pub struct CheckArgs {
    /// Files, directories and globs; - reads stdin [default: `paths` of the configuration, or .]
    #[arg(value_name = "PATH")]
    pub paths: Vec<PathBuf>,
    /// Form of the report, human, short, json, github, sarif or junit, and the file it goes to;
    /// may be given several times, once without a file [default: human]
    #[arg(short, long = "format", value_name = "FORMAT[=FILE]", value_parser = report)]
    pub formats: Vec<Report>,
    /// Mend what can be mended mechanically, and check again
    #[arg(long, conflicts_with_all = ["diff", "shard"])]
    pub fix: bool,
    /// Show what --fix would do, change nothing, exit with 1 if it is something
    #[arg(long, conflicts_with_all = ["accept", "shard"])]
    pub diff: bool,
    /// Write the locks of shaders that have drifted from them, and those that are missing
    #[arg(long)]
    pub accept: bool,
    /// Report what a JSON report of `landfall verify` saw read from other bytes, at its members
    #[arg(long, value_name = "REPORT", conflicts_with = "shard")]
    pub verified: Vec<PathBuf>,
    /// Where locks are [default: `locks` of the configuration, or layouts]
    #[arg(long, value_name = "DIR")]
    pub locks: Option<PathBuf>,
    /// Leave out what GLOB matches, by its path from the configuration or by a part of it
    #[arg(long, value_name = "GLOB")]
    pub exclude: Vec<String>,
    /// Check the I-th of N parts only; `landfall merge` makes one report of all
    #[arg(long, value_name = "I/N", value_parser = shard)]
    pub shard: Option<Shard>,
    /// Remember in DIR what was found, and lay out only what changed [default: `cache-dir` of the
    /// configuration, or none]
    #[arg(long, value_name = "DIR")]
    pub cache_dir: Option<PathBuf>,
    /// No cache, whatever the configuration says
    #[arg(long, conflicts_with = "cache_dir")]
    pub no_cache: bool,
    /// Say how many findings each lint has
    #[arg(long)]
    pub statistics: bool,
    /// Files checked at a time [default: one a core]
    #[arg(short, long, value_name = "N")]
    pub jobs: Option<NonZeroUsize>,
    #[command(flatten)]
    pub config: ConfigArgs,
    #[command(flatten)]
    pub levels: LevelArgs,
    #[command(flatten)]
    pub text: TextArgs,
}

/// Where the configuration is.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct ConfigArgs {
    /// The configuration [default: landfall.toml or .landfall.toml, here or in a folder above]
    #[arg(long, value_name = "FILE", conflicts_with = "no_config")]
    pub config: Option<PathBuf>,
    /// No configuration, even if there is one
    #[arg(long)]
    pub no_config: bool,
}

#[derive(Debug, clap::Args)]
pub struct MergeArgs {
    /// JSON reports of all shards of one check
    #[arg(value_name = "REPORT", required = true)]
    pub reports: Vec<PathBuf>,
    /// Form of the report and the file it goes to, as for `check`
    #[arg(short, long = "format", value_name = "FORMAT[=FILE]", value_parser = report)]
    pub formats: Vec<Report>,
    /// Say how many findings each lint has
    #[arg(long)]
    pub statistics: bool,
}

#[derive(Debug, clap::Args)]
pub struct RuleArgs {
    /// The code of a lint or hazard; without one, all are listed
    #[arg(value_name = "CODE")]
    pub code: Option<String>,
    /// Form of the output
    #[arg(short, long, value_name = "FORMAT", default_value = "human")]
    pub format: RuleFormat,
    /// Explain every lint and hazard
    #[arg(long, conflicts_with = "code")]
    pub all: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RuleFormat {
    Human,
    /// One object a lint or hazard
    Json,
    /// Markdown
    Md,
}

/// One part of a report's way: its form, and where it goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
    pub format: ReportFormat,
    /// `None` for stdout.
    pub file: Option<PathBuf>,
}

/// The `index`-th of `count` parts, from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    pub index: u32,
    pub count: u32,
}

const FORMATS: [(&str, ReportFormat); 6] = [
    ("human", ReportFormat::Human),
    ("short", ReportFormat::Short),
    ("json", ReportFormat::Json),
    ("github", ReportFormat::Github),
    ("sarif", ReportFormat::Sarif),
    ("junit", ReportFormat::Junit),
];

/// `FORMAT`, `FORMAT=FILE`.
fn report(text: &str) -> Result<Report, String> {
    let (name, file) = match text.split_once('=') {
        Some((_, "")) => return Err("a file's name is missing after `=`".to_string()),
        Some((name, file)) => (name, Some(PathBuf::from(file))),
        None => (text, None),
    };
    let known = FORMATS.iter().find(|(known, _)| *known == name);
    let names = || FORMATS.map(|(name, _)| name).join(", ");
    match known {
        Some((_, format)) => Ok(Report { format: *format, file }),
        None => Err(format!("formats are {}", names())),
    }
}

/// `I/N`.
fn shard(text: &str) -> Result<Shard, String> {
    let numbers = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    match numbers {
        Some((index, count)) if 1 <= index && index <= count => Ok(Shard { index, count }),
        _ => Err("a shard is I/N with I from 1 to N, such as 2/3".to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_may_name_its_file() {
        let sarif = Report { format: ReportFormat::Sarif, file: Some(PathBuf::from("a=b.sarif")) };
        assert_eq!(report("sarif=a=b.sarif"), Ok(sarif));
        assert_eq!(report("short").map(|report| report.file), Ok(None));
        assert!(report("json=").is_err() && report("xml").is_err());
    }

    #[test]
    fn shards_count_from_one_to_their_number() {
        assert_eq!(shard("2/3"), Ok(Shard { index: 2, count: 3 }));
        for wrong in ["0/3", "4/3", "3", "a/b", "1/0", "-1/2"] {
            assert!(shard(wrong).is_err(), "{wrong}");
        }
    }
}
