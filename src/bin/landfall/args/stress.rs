//! Arguments of `landfall stress`.

use std::path::PathBuf;
use std::time::Duration;

use clap::ValueEnum;

use super::budget::seconds;
use super::function::FunctionArgs;
use super::words::words;
use super::{BackendName, CodeArgs, FloatsArgs};

/// The rows of the table, as the help states them.
const ROWS: &str = concat!(
    words!(),
    "

Rows of the table, by the source of the samples:
  coincidences  inputs that are equal, opposite, zero or at a limit
  scenes        values as they occur in scenes, where the domain has them
  drawn         as --domain and comments distribute the inputs, uniformly by default
  bits          random finite floats, each exponent equally likely
  mixed         values of scenes, but one input of random bits
  special       inputs with infinity or NaN
  climbed       found by changing the worst samples of the other rows
  every         every input of a small domain, instead of all other rows"
);

#[derive(Debug, clap::Args)]
#[command(after_help = ROWS)]
pub struct StressArgs {
    #[command(flatten)]
    pub function: FunctionArgs,
    /// Seed of the random inputs
    #[arg(help_heading = "Inputs", long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Samples to run before the search from the worst ones; a domain with no more inputs is run
    /// exhaustively
    #[arg(help_heading = "Inputs", long, value_name = "N", default_value = "100000")]
    pub samples: std::num::NonZeroU64,
    /// Time limit of sampling, in seconds; analysing the findings takes up to half as much again
    #[arg(
        help_heading = "Inputs", long, value_name = "SECONDS", default_value = "6",
        value_parser = seconds
    )]
    pub time: Duration,
    /// Threads [default: one per core]
    #[arg(
        help_heading = "Backends", short, long, value_name = "N",
        value_parser = clap::value_parser!(u16).range(1..=256)
    )]
    pub jobs: Option<u16>,
    /// Fail on errors of more than ULP units in the last place
    #[arg(help_heading = "Limits", long, value_name = "ULP", value_parser = at_most)]
    pub max_ulp: Option<f64>,
    /// Fail on errors of more than STEPS steps of 1/255 of full scale
    #[arg(help_heading = "Limits", long, value_name = "STEPS", value_parser = at_most)]
    pub max_step: Option<f64>,
    /// Print how inputs were drawn, the table of errors, the drivers, and help for each finding, too
    #[arg(help_heading = "Output", long)]
    pub details: bool,
    /// Print findings with values that do not occur in scenes, too, and all details
    #[arg(help_heading = "Output", long)]
    pub all: bool,
    /// Shader with a robust form of the function, called with the inputs of each finding; #NAME if
    /// the function has another name there
    #[arg(help_heading = "Output", long, value_name = "FILE[#NAME]")]
    pub against: Option<String>,
    #[command(flatten)]
    pub floats: FloatsArgs,
    /// Draw the error over the inputs --map-x and --map-y, as .svg or .html
    #[arg(
        help_heading = "Maps", long, value_name = "FILE", requires_all = ["map_x", "map_y"],
        value_parser = drawing
    )]
    pub map: Option<PathBuf>,
    /// Horizontal input of --map: the path of a scalar, such as light.position.x
    #[arg(help_heading = "Maps", long, value_name = "PATH", requires = "map")]
    pub map_x: Option<String>,
    /// Vertical input of --map
    #[arg(help_heading = "Maps", long, value_name = "PATH", requires = "map")]
    pub map_y: Option<String>,
    /// Backends that also run every sample in f32 and are compared with the interpreter's f64: gl,
    /// gpu; --max-ulp and --max-step apply to them too
    #[arg(
        help_heading = "Backends",
        long = "backend",
        value_name = "BACKEND",
        value_delimiter = ','
    )]
    pub backends: Vec<BackendName>,
    /// GPU adapter, by a part of its name
    #[arg(help_heading = "Backends", long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Output format
    #[arg(help_heading = "Output", short, long, value_name = "FORMAT", default_value = "human")]
    pub format: StressFormat,
    #[command(flatten)]
    pub read: CodeArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StressFormat {
    /// A table of errors, then each finding with its source line
    Human,
    /// JSON, described by `landfall schema stress`
    Json,
    /// Findings as SARIF 2.1.0
    Sarif,
}

/// Parses a limit of errors: finite and not negative.
pub fn at_most(text: &str) -> Result<f64, String> {
    let most: Option<f64> = text.parse().ok().filter(|most: &f64| *most >= 0.0 && most.is_finite());
    most.ok_or_else(|| "a limit is a finite number of at least 0".to_string())
}

/// Parses the path of a drawing, which must end in `.svg`, `.html` or `.htm`.
fn drawing(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let known =
        path.extension().is_some_and(|e| ["svg", "html", "htm"].map(AsRef::as_ref).contains(&e));
    if known { Ok(path) } else { Err("a map is an .svg or .html file".to_string()) }
}
