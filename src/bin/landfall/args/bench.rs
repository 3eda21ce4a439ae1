//! Arguments of `landfall bench`.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::time::Duration;

use clap::ValueEnum;

use super::budget::seconds;
use super::render::size;
use super::words::words;
use super::{BackendName, CodeArgs, setting};

/// The columns of the report and the exit codes, as the help states them.
const NOTES: &str = concat!(
    words!(),
    "

Columns (* marks variants that no other dominates):
  ns/light         time for one light of one fragment, with quartiles
  net              less the time of a trivial shader or function
  max, 99.9 %      largest error, and the error that 99.9 % stay below
  median           error that half of the results stay below
  ends             largest error with inputs at an end of their range, beside it,
                   at 0, 1 or -1, and results there that are NaN or infinite
  step             error in steps of 1/255 of full scale
  permitted        largest error of any device that conforms to WGSL and Vulkan;
                   `any` where these set no bound
  unsure           samples in which another device may take another branch
  flips            channels with another 8-bit value than the reference
  differing        calls with another integer or boolean result
  non-finite       results that are NaN or infinite, but not in the reference
  undefined        results left out because the reference is undefined there
  lights, slots    lights evaluated and slots looped over, per fragment
  powers           calls of `pow` per fragment
  dominated by     variants that are better in a column, worse in none, and whose
                   quartiles of time do not lie above

Exit codes: 0: measured; 2: wrong arguments, nothing could be measured, or a
backend named by --backend is missing (results of the others are printed)."
);

/// The forms of a variant.
const VARIANTS: &str = "\
A variant to measure, and its name in the report; repeatable [default: the
scene's shader and the compiled kernels; with --fn, the function]

Variants of a scene:
  FILE               the fragment shader in FILE
  FILE+plan:PARTS    the same, without the lights that `render --skip PARTS` skips
  plan:PARTS         the scene's shader, likewise
  rust:seed          compiled into landfall: the formulas as published
  rust:ungated       compiled: robust formulas, every term evaluated
  rust:robust        compiled: robust formulas, skipping terms that are exactly zero
  rust:robust=POWER  compiled: the same, skipping also highlights below POWER

Variants of a function (--fn):
  FILE               the function of the same name in FILE
  FILE#NAME          the function NAME in FILE
  #NAME              the function NAME in the same file

At the end of any that runs a shader, on backend cpu only:
  :half              rounds every float to f16
  :mediump           rounds floats that OpenGL ES declares mediump or lowp to f16";

/// Options that need `--fn`. clap drops `requires` beside an option that conflicts with `--fn`, so
/// those options conflict with these too.
const OF_FUNCTIONS: [&str; 6] = ["domain", "data", "textures", "truth", "samples", "seed"];

#[derive(Debug, clap::Args)]
#[command(after_help = NOTES)]
pub struct BenchArgs {
    /// The scene to light, or with --fn a shader
    #[arg(value_name = "SCENE.json|FILE")]
    pub subject: PathBuf,
    /// Measure calls of a function, with inputs drawn from its domain: NAME, or an overload such as
    /// 'NAME(vec3, float)'
    #[arg(
        help_heading = "Variants", long = "fn", value_name = "NAME",
        conflicts_with_all = ["size", "model", "model_of", "bind", "most"]
    )]
    pub function: Option<String>,
    /// A variant to measure, and its name in the report; repeatable [default: the scene's shader and
    /// the compiled kernels; with --fn, the function]
    #[arg(
        help_heading = "Variants", long = "variant", value_name = "NAME=VARIANT",
        value_parser = setting, long_help = VARIANTS
    )]
    pub variants: Vec<(String, String)>,
    /// Backends to run shaders on [default: all available]
    #[arg(help_heading = "Backends", long, value_name = "BACKEND", value_delimiter = ',')]
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
    /// Properties of the scene, or numbers, for members, textures and inputs of the shader, as a JSON
    /// file or object such as {"eye": "camera.position"}
    #[arg(
        help_heading = "Scenes", long, value_name = "FILE|JSON", conflicts_with_all = OF_FUNCTIONS
    )]
    pub bind: Vec<String>,
    /// Ranges and distributions of the function's inputs, as for `stress`: a JSON file or an object
    /// such as {"normal": "unit", "d": {"log": [0.1, 100]}} [default: from comments beside them,
    /// else as in scenes, by their names]
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
    /// Variant whose f64 results errors are measured against; the function is `as it is` [default:
    /// the most accurate of the variants that compute the same in f64]
    #[arg(help_heading = "Functions (--fn)", long, value_name = "NAME", requires = "function")]
    pub truth: Option<String>,
    /// Calls whose errors are measured, and a sixteenth more with inputs at ends of their ranges;
    /// times are measured on the first 16384 [default: 1048576, fewer for long functions and many
    /// inputs]
    #[arg(
        help_heading = "Functions (--fn)", long, value_name = "N", value_parser = samples,
        requires = "function"
    )]
    pub samples: Option<NonZeroUsize>,
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
    /// Print every column, how inputs were drawn, the machine, and the worst inputs, too
    #[arg(help_heading = "Output", long)]
    pub details: bool,
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
    pub read: CodeArgs,
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

/// Parses the calls whose errors are measured, 1 to 2^22.
fn samples(text: &str) -> Result<NonZeroUsize, String> {
    const LIMIT: usize = 1 << 22;
    let number = text.parse().ok().filter(|n: &NonZeroUsize| n.get() <= LIMIT);
    number.ok_or_else(|| format!("a run has 1 to {LIMIT} calls"))
}
