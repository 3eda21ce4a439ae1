//! What `landfall lights` may be told.

use std::path::PathBuf;

use clap::ValueEnum;
use landfall_ir::analysis::hazards::Certainty;

use super::ReadArgs;

#[derive(Debug, clap::Args)]
pub struct LightsArgs {
    /// Files, directories (searched for shaders, .gitignore respected) and globs; - reads stdin
    #[arg(value_name = "FILE", required = true)]
    pub files: Vec<PathBuf>,
    /// Form of the output
    #[arg(short, long, value_name = "FORMAT", default_value = "human")]
    pub format: LightsFormat,
    /// Only hazards that are at least so sure
    #[arg(long, value_name = "HOW", default_value = "possible")]
    pub least: Sureness,
    /// Exit with 1 if there is a hazard at least so sure
    #[arg(long, value_name = "HOW")]
    pub deny: Option<Sureness>,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LightsFormat {
    /// Tables and excerpts
    Human,
    /// JSON as `landfall schema lights` describes it
    Json,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Sureness {
    /// Only inputs that the program may never give meet it
    Possible,
    /// Ordinary inputs meet it
    Likely,
    /// The text alone shows it
    Certain,
}

impl Sureness {
    pub fn certainty(self) -> Certainty {
        match self {
            Sureness::Possible => Certainty::Possible,
            Sureness::Likely => Certainty::Likely,
            Sureness::Certain => Certainty::Certain,
        }
    }
}
