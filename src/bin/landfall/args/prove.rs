//! Arguments of `landfall prove`.

use std::path::PathBuf;
use std::time::Duration;

use clap::ValueEnum;

use super::budget::seconds;
use super::stress::at_most;
use super::{ReadArgs, setting};

/// What is known of operations and demands, as the help states it.
const VERDICTS: &str = "\
Verdicts on an operation:
  found          an input was found for which it breaks
  proved absent  it breaks for no input in the ranges
  open           neither

An operation breaks if its result is undefined: the root of a negative number, a
division of zero by zero. A finite result that f32 cannot hold is counted apart.";

#[derive(Debug, clap::Args)]
#[command(after_help = VERDICTS)]
pub struct ProveArgs {
    /// The shader; - reads stdin
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// The function: NAME, or an overload such as 'NAME(vec3, float)'
    #[arg(long = "fn", value_name = "NAME")]
    pub function: String,
    /// Ranges of the inputs by path, as a JSON file or object [default: from comments beside them,
    /// such as `// in 0..1`, else every finite value]
    #[arg(help_heading = "Inputs", long, value_name = "FILE|JSON")]
    pub domain: Option<String>,
    /// Contents of blocks by name, as a JSON file or object in the form of `landfall encode`
    /// [default: their members are inputs]
    #[arg(help_heading = "Inputs", long, value_name = "FILE|JSON")]
    pub data: Option<String>,
    /// Uniform colour of a texture [default: white]
    #[arg(
        help_heading = "Inputs", long = "texture", value_name = "NAME=[R,G,B,A]",
        value_parser = setting
    )]
    pub textures: Vec<(String, String)>,
    /// Limit of processor time, in seconds
    #[arg(
        help_heading = "Inputs", long, value_name = "SECONDS", default_value = "6",
        value_parser = seconds
    )]
    pub time: Duration,
    /// Demand that no result is NaN [default: that no operation has an undefined result]
    #[arg(help_heading = "Demands", long)]
    pub no_nan: bool,
    /// Demand that no result is infinite
    #[arg(help_heading = "Demands", long)]
    pub no_inf: bool,
    /// Demand that errors are at most ULP units in the last place
    #[arg(help_heading = "Demands", long, value_name = "ULP", value_parser = at_most)]
    pub max_ulp: Option<f64>,
    /// Demand that errors are at most STEPS steps of 1/255 of full scale
    #[arg(help_heading = "Demands", long, value_name = "STEPS", value_parser = at_most)]
    pub max_step: Option<f64>,
    /// Bound the error of the function computed in f64 on a processor, instead of in f32 on any
    /// device that conforms to WGSL and Vulkan
    #[arg(help_heading = "Demands", long)]
    pub f64: bool,
    /// List every operation, proved ones too
    #[arg(help_heading = "Output", long)]
    pub all: bool,
    /// Output format
    #[arg(help_heading = "Output", short, long, value_name = "FORMAT", default_value = "human")]
    pub format: ProveFormat,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ProveFormat {
    /// The operations that can break, and the demands
    Human,
    /// JSON, described by `landfall schema prove`
    Json,
}
