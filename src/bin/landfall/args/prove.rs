//! Arguments of `landfall prove`.

use std::time::Duration;

use clap::ValueEnum;

use super::CodeArgs;
use super::budget::seconds;
use super::function::FunctionArgs;
use super::stress::at_most;
use super::words::words;

/// The verdicts of the report, as the help states them.
const VERDICTS: &str = concat!(
    words!(),
    "

Verdicts on an operation:
  found          an input was found for which it breaks
  proved absent  it breaks for no input in the ranges
  open           neither

An operation breaks if its result is undefined, such as the square root of a
negative number or zero divided by zero. Results that overflow an f32 are
counted separately."
);

#[derive(Debug, clap::Args)]
#[command(after_help = VERDICTS)]
pub struct ProveArgs {
    #[command(flatten)]
    pub function: FunctionArgs,
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
    /// Bound the error of the function computed in f64 on a CPU, instead of in f32 on any
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
    pub read: CodeArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ProveFormat {
    /// The operations that can break, and the demands
    Human,
    /// JSON, described by `landfall schema prove`
    Json,
}
