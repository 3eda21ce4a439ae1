//! Arguments of `landfall run`.

use std::path::PathBuf;
use std::time::Duration;

use clap::ValueEnum;

use super::verify::seconds;
use super::{FloatsArgs, ReadArgs, ReaderName, setting};

#[derive(Debug, clap::Args)]
pub struct RunArgs {
    /// The shader; - reads stdin
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// The function: NAME, or 'NAME(vec3, float)' where several have the name
    #[arg(long = "fn", value_name = "NAME")]
    pub function: String,
    /// Its arguments by position, a JSON array: vectors as arrays, matrices as arrays of columns,
    /// structures as objects, "nan", "inf", "-inf"; `out` parameters may be left out
    #[arg(long = "args", value_name = "JSON", default_value = "[]", allow_hyphen_values = true)]
    pub arguments: String,
    /// What blocks hold, by name, as `landfall encode` takes it: a file, or an object
    /// [default: zeros]
    #[arg(long, value_name = "FILE|JSON")]
    pub data: Option<String>,
    /// The colour a texture has everywhere [default: white]
    #[arg(long = "texture", value_name = "NAME=[R,G,B,A]", value_parser = setting)]
    pub textures: Vec<(String, String)>,
    /// The value of an input of the shader [default: zero]
    #[arg(long = "input", value_name = "NAME=JSON", value_parser = setting)]
    pub inputs: Vec<(String, String)>,
    /// Who runs it; f64 is always the evaluator's
    #[arg(long, value_name = "READER", default_value = "cpu")]
    pub reader: ReaderName,
    /// Part of the name of the GPU adapter to take
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    #[command(flatten)]
    pub floats: FloatsArgs,
    /// Form of the output
    #[arg(short, long, value_name = "FORMAT", default_value = "human")]
    pub format: RunFormat,
    /// Seconds after which the reader has failed
    #[arg(long, value_name = "SECONDS", default_value = "20", value_parser = seconds)]
    pub limit: Duration,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RunFormat {
    /// A row for each scalar that comes back
    Human,
    /// JSON as `landfall schema run` describes it
    Json,
}
