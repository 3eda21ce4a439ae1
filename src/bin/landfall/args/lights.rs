//! Arguments of `landfall lights`.

use std::path::PathBuf;

use clap::ValueEnum;
use landfall_ir::analysis::occurrence::Certainty;

use super::ReadArgs;

#[derive(Debug, clap::Args)]
pub struct LightsArgs {
    /// Files, directories (searched for shaders, .gitignore respected) and globs; - reads stdin
    #[arg(value_name = "FILE", required = true)]
    pub files: Vec<PathBuf>,
    /// Output format
    #[arg(short, long, value_name = "FORMAT", default_value = "human")]
    pub format: LightsFormat,
    /// Only hazards of at least this certainty
    #[arg(long, value_name = "CERTAINTY", default_value = "possible")]
    pub least: CertaintyFilter,
    /// Exit with 1 on a hazard of at least this certainty
    #[arg(long, value_name = "CERTAINTY")]
    pub deny: Option<CertaintyFilter>,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LightsFormat {
    /// Tables and source excerpts
    Human,
    /// JSON, described by `landfall schema lights`
    Json,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CertaintyFilter {
    /// Only unusual inputs, which a program may never pass, trigger it
    Possible,
    /// Ordinary inputs trigger it
    Likely,
    /// The source alone proves it
    Certain,
}

impl CertaintyFilter {
    pub fn certainty(self) -> Certainty {
        match self {
            CertaintyFilter::Possible => Certainty::Possible,
            CertaintyFilter::Likely => Certainty::Likely,
            CertaintyFilter::Certain => Certainty::Certain,
        }
    }
}
