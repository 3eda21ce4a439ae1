//! Arguments of `landfall stress`.

use std::path::PathBuf;
use std::time::Duration;

use clap::ValueEnum;

use super::verify::seconds;
use super::{FloatsArgs, ReadArgs, ReaderName, setting};

#[derive(Debug, clap::Args)]
pub struct StressArgs {
    /// The shader; - reads stdin
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// The function: NAME, or 'NAME(vec3, float)' where several have the name
    #[arg(long = "fn", value_name = "NAME")]
    pub function: String,
    /// What inputs may be, by path: {"normal": "unit", "shininess": [1, 256], "no_coincidence":
    /// [["light.position", "fragPos"]]}, a file or an object; any, unit, position, color, cos
    /// [default: what comments beside them say, such as `// in 0..1`, else all that is finite]
    #[arg(long, value_name = "FILE|JSON")]
    pub domain: Option<String>,
    /// What blocks hold, by name, as `landfall encode` takes it: a file, or an object
    /// [default: their members are inputs as parameters are]
    #[arg(long, value_name = "FILE|JSON")]
    pub data: Option<String>,
    /// The colour a texture has everywhere [default: white]
    #[arg(long = "texture", value_name = "NAME=[R,G,B,A]", value_parser = setting)]
    pub textures: Vec<(String, String)>,
    /// What random numbers start from
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Samples to run before climbing from the worst; where no more inputs are possible, each of
    /// them runs once
    #[arg(long, value_name = "N", default_value = "100000")]
    pub samples: std::num::NonZeroU64,
    /// Seconds to sample at most; what was found is looked at in half as much again
    #[arg(long, value_name = "SECONDS", default_value = "6", value_parser = seconds)]
    pub time: Duration,
    /// Threads [default: one a core]
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: Option<u16>,
    /// Fail where a result is off by more units of the last place
    #[arg(long, value_name = "ULP", value_parser = at_most)]
    pub max_ulp: Option<f64>,
    /// Fail where a result is off by more steps of 1/255 of full scale
    #[arg(long, value_name = "STEPS", value_parser = at_most)]
    pub max_step: Option<f64>,
    /// A robust form to hold beside each finding: FILE, or FILE#NAME for a function of another name
    #[arg(long, value_name = "FILE[#NAME]")]
    pub against: Option<String>,
    #[command(flatten)]
    pub floats: FloatsArgs,
    /// Draw the error over two inputs, --map-x and --map-y: .svg or .html
    #[arg(long, value_name = "FILE", requires_all = ["map_x", "map_y"], value_parser = drawing)]
    pub map: Option<PathBuf>,
    /// The input from left to right: the path of a scalar, light.position.x
    #[arg(long, value_name = "PATH", requires = "map")]
    pub map_x: Option<String>,
    /// The input from below to above
    #[arg(long, value_name = "PATH", requires = "map")]
    pub map_y: Option<String>,
    /// Drivers that run every sample too, in f32 as it is written, and are held against the
    /// evaluator's f64 of the same bits: gl, gpu; --max-ulp and --max-step hold for them too
    #[arg(long = "reader", value_name = "READER", value_delimiter = ',')]
    pub readers: Vec<ReaderName>,
    /// Part of the name of the GPU adapter to take
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Form of the output
    #[arg(short, long, value_name = "FORMAT", default_value = "human")]
    pub format: StressFormat,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StressFormat {
    /// A table of errors, then each finding with its line
    Human,
    /// JSON as `landfall schema stress` describes it
    Json,
    /// The findings as SARIF 2.1.0
    Sarif,
}

/// An error that is allowed.
fn at_most(text: &str) -> Result<f64, String> {
    let most: Option<f64> = text.parse().ok().filter(|most: &f64| *most >= 0.0 && most.is_finite());
    most.ok_or_else(|| "a limit is a number from 0 on".to_string())
}

/// A file for a drawing.
fn drawing(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let known =
        path.extension().is_some_and(|e| ["svg", "html", "htm"].map(AsRef::as_ref).contains(&e));
    if known { Ok(path) } else { Err("a drawing is .svg or .html".to_string()) }
}
