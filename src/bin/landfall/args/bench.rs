//! Arguments of `landfall bench`.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::time::Duration;

use clap::ValueEnum;

use super::budget::seconds;
use super::render::size;
use super::{BackendName, ReadArgs, setting};

/// The exit codes, as the help states them.
const EXITS: &str = "Exit codes: 0: measured; 2: wrong arguments, nothing could be measured, or a \
                     backend named by --backend is missing (results of the others are printed).";

/// Options that need `--fn`. clap drops `requires` beside an option that conflicts with `--fn`, so
/// those options conflict with these too.
const OF_FUNCTIONS: [&str; 6] = ["domain", "data", "textures", "truth", "samples", "seed"];

#[derive(Debug, clap::Args)]
#[command(after_help = EXITS)]
pub struct BenchArgs {
    /// The scene to light, or with --fn a shader
    #[arg(value_name = "SCENE.json|FILE")]
    pub subject: PathBuf,
    /// Measure calls of a function, with inputs in the range of scenes: NAME, or an overload such
    /// as 'NAME(vec3, float)'
    #[arg(
        help_heading = "Variants", long = "fn", value_name = "NAME",
        conflicts_with_all = ["size", "model", "model_of", "bind", "most"]
    )]
    pub function: Option<String>,
    /// A named variant to measure, once per variant [default: the scene's shader and the compiled
    /// kernels; the function]
    ///
    /// A scene takes a shader's FILE; rust:seed, rust:ungated or rust:robust, kernels compiled into
    /// landfall, of which rust:robust skips lights without a contribution and rust:robust=POWER
    /// also specular terms below POWER; plan:PARTS, which skips lights as `render --skip` does; or
    /// FILE+plan:PARTS. With --fn: FILE, FILE#NAME, or #NAME in the same file. The suffix :half
    /// rounds every float to f16, :mediump only those that OpenGL ES declares mediump or lowp; both
    /// on backend cpu only
    #[arg(
        help_heading = "Variants", long = "variant", value_name = "NAME=VARIANT",
        value_parser = setting
    )]
    pub variants: Vec<(String, String)>,
    /// Backends to run shaders on [default: all available]
    #[arg(
        help_heading = "Backends",
        long,
        alias = "reader",
        value_name = "BACKEND",
        value_delimiter = ','
    )]
    pub backend: Vec<BackendName>,
    /// GPU adapter, by a part of its name
    #[arg(help_heading = "Backends", long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Measured rounds, 3 to 10000, after one to warm up; below 8, no difference of times is
    /// called significant
    #[arg(
        help_heading = "Backends", long, value_name = "N", default_value = "15",
        value_parser = clap::value_parser!(u32).range(3..=10_000)
    )]
    pub rounds: u32,
    /// Upper limit of fragments times lights in a run: a larger picture is sampled at regular
    /// steps, except by plan variants, which need all fragments
    #[arg(
        help_heading = "Scenes", long, value_name = "N", default_value = "2000000",
        conflicts_with_all = OF_FUNCTIONS
    )]
    pub most: u64,
    /// Width and height in pixels [default: the scene's]
    #[arg(
        help_heading = "Scenes", long, value_name = "WxH", value_parser = size,
        conflicts_with_all = OF_FUNCTIONS
    )]
    pub size: Option<[u32; 2]>,
    /// Lighting model of the reference [default: the scene's, or inferred from the shader]
    #[arg(help_heading = "Scenes", long, value_name = "MODEL", conflicts_with_all = OF_FUNCTIONS)]
    pub model: Option<String>,
    /// Lighting model of one variant, whose error is measured against that model's reference; once
    /// per variant
    #[arg(
        help_heading = "Scenes", long, value_name = "NAME=MODEL", value_parser = setting,
        conflicts_with_all = OF_FUNCTIONS
    )]
    pub model_of: Vec<(String, String)>,
    /// Scene values for block members, as a JSON file or object
    #[arg(
        help_heading = "Scenes", long, value_name = "FILE|JSON", conflicts_with_all = OF_FUNCTIONS
    )]
    pub bind: Vec<String>,
    /// Ranges of the function's inputs, as for `stress`: a JSON file or an object such as
    /// {"normal": "unit", "d": [0, 100]} [default: from comments beside them, else by their names]
    #[arg(
        help_heading = "Functions (--fn)",
        long,
        value_name = "FILE|JSON",
        requires = "function"
    )]
    pub domain: Option<String>,
    /// Contents of blocks by name, as a JSON file or object [default: their members are inputs]
    #[arg(
        help_heading = "Functions (--fn)",
        long,
        value_name = "FILE|JSON",
        requires = "function"
    )]
    pub data: Option<String>,
    /// Uniform colour of a texture [default: white]
    #[arg(
        help_heading = "Functions (--fn)", long = "texture", value_name = "NAME=[R,G,B,A]",
        value_parser = setting, requires = "function"
    )]
    pub textures: Vec<(String, String)>,
    /// Variant whose f64 results errors are measured against [default: the function, `as it is`]
    #[arg(help_heading = "Functions (--fn)", long, value_name = "NAME", requires = "function")]
    pub truth: Option<String>,
    /// Calls in a run
    #[arg(
        help_heading = "Functions (--fn)", long, value_name = "N", default_value = "16384",
        value_parser = samples, requires = "function"
    )]
    pub samples: NonZeroUsize,
    /// Seed of the random inputs
    #[arg(
        help_heading = "Functions (--fn)",
        long,
        value_name = "N",
        default_value = "1",
        requires = "function"
    )]
    pub seed: u64,
    /// Plot time against error as SVG
    #[arg(help_heading = "Output", long, value_name = "FILE.svg", value_parser = svg)]
    pub plot: Option<PathBuf>,
    /// Output format
    #[arg(help_heading = "Output", short, long, value_name = "FORMAT", default_value = "human")]
    pub format: BenchFormat,
    /// Time limit of a run on a backend, in seconds
    #[arg(
        help_heading = "Backends", long, value_name = "SECONDS", default_value = "120",
        value_parser = seconds
    )]
    pub limit: Duration,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BenchFormat {
    /// A table per backend
    Human,
    /// JSON, described by `landfall schema bench`
    Json,
    /// A row per variant
    Csv,
}

/// Parses the path of a plot, which must end in `.svg`.
fn svg(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let known = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("svg"));
    if known { Ok(path) } else { Err("a plot is an .svg file".to_string()) }
}

/// Parses the calls of a run, 1 to 2^22.
fn samples(text: &str) -> Result<NonZeroUsize, String> {
    const MOST: usize = 1 << 22;
    let number = text.parse().ok().filter(|n: &NonZeroUsize| n.get() <= MOST);
    number.ok_or_else(|| format!("a run has 1 to {MOST} calls"))
}
