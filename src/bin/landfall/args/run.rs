//! Arguments of `landfall run`.

use std::path::PathBuf;
use std::time::Duration;

use clap::ValueEnum;

use super::budget::seconds;
use super::{BackendName, CodeArgs, FloatsArgs, setting};

#[derive(Debug, clap::Args)]
pub struct RunArgs {
    /// The shader; - reads stdin
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// The function: NAME, or an overload such as 'NAME(vec3, float)'
    #[arg(help_heading = "Inputs", long = "fn", value_name = "NAME")]
    pub function: String,
    /// Arguments by position, as a JSON array: vectors as arrays, matrices as arrays of columns,
    /// structures as objects, "nan", "inf", "-inf"; `out` parameters may be omitted
    #[arg(
        help_heading = "Inputs",
        long = "args",
        value_name = "JSON",
        default_value = "[]",
        allow_hyphen_values = true
    )]
    pub arguments: String,
    /// Contents of blocks by name, as a JSON file or object in the form of `landfall encode`
    /// [default: zeros]
    #[arg(help_heading = "Inputs", long, value_name = "FILE|JSON")]
    pub data: Option<String>,
    /// Uniform colour of a texture [default: white]
    #[arg(
        help_heading = "Inputs", long = "texture", value_name = "NAME=[R,G,B,A]",
        value_parser = setting
    )]
    pub textures: Vec<(String, String)>,
    /// Value of a stage input [default: zero]
    #[arg(
        help_heading = "Inputs", long = "input", value_name = "NAME=JSON", value_parser = setting
    )]
    pub inputs: Vec<(String, String)>,
    /// Backend of the f32 call; the f64 call always runs on cpu
    #[arg(help_heading = "Backend", long, value_name = "BACKEND", default_value = "cpu")]
    pub backend: BackendName,
    /// GPU adapter, by a part of its name
    #[arg(help_heading = "Backend", long, value_name = "NAME")]
    pub adapter: Option<String>,
    #[command(flatten)]
    pub floats: FloatsArgs,
    /// Output format
    #[arg(short, long, value_name = "FORMAT", default_value = "human")]
    pub format: RunFormat,
    /// Time limit of the backend, in seconds
    #[arg(
        help_heading = "Backend", long, value_name = "SECONDS", default_value = "20",
        value_parser = seconds
    )]
    pub limit: Duration,
    #[command(flatten)]
    pub read: CodeArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RunFormat {
    /// A row per scalar of the result
    Human,
    /// JSON, described by `landfall schema run`
    Json,
}
