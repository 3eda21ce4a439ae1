//! Arguments of `landfall bench`.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::time::Duration;

use clap::ValueEnum;

use super::render::size;
use super::verify::seconds;
use super::{ReadArgs, ReaderName, setting};

/// What exit codes say.
const EXITS: &str = "Exit codes: 0, measured; 2, wrong arguments, nothing could be measured, or a \
                     reader that --reader names is not here, after what there is was printed.";

/// Options of `--fn`. clap forgets that they require it beside an option that conflicts with it,
/// so those conflict with them too.
const OF_FUNCTIONS: [&str; 6] = ["domain", "data", "textures", "truth", "samples", "seed"];

#[derive(Debug, clap::Args)]
#[command(after_help = EXITS)]
pub struct BenchArgs {
    /// The scene that variants light; or a shader, with --fn
    #[arg(value_name = "SCENE.json|FILE")]
    pub subject: PathBuf,
    /// Call this function of the shader instead, with values like those of scenes: NAME, or
    /// 'NAME(vec3, float)' where several have the name. What it reads is given as to `stress`
    #[arg(long = "fn", value_name = "NAME", conflicts_with_all = ["size", "model", "model_of", "bind", "most"])]
    pub function: Option<String>,
    /// A variant, once for each: a shader's FILE; rust:seed, rust:ungated or rust:robust, which are
    /// compiled into landfall, the last without what adds nothing, and as rust:robust=POWER
    /// without powers below POWER; plan:OPTIONS, which skips lights as `render --skip` does, or
    /// FILE+plan:OPTIONS, a shader that does. With --fn FILE, FILE#NAME, or #NAME of the same
    /// file. Behind a shader or function, :half rounds every float to f16, and :mediump those that
    /// OpenGL ES says are, on the evaluator alone [default: the scene's shader and what is
    /// compiled; the function as it is]
    #[arg(long = "variant", value_name = "NAME=WHAT", value_parser = setting)]
    pub variants: Vec<(String, String)>,
    /// Who runs the shaders [default: all there are]
    #[arg(long, value_name = "READER", value_delimiter = ',')]
    pub reader: Vec<ReaderName>,
    /// Part of the name of the GPU adapter to take
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Rounds that count, 3 to 10000; one more goes before. Of fewer than 8, no time is said to be
    /// better than another
    #[arg(long, value_name = "N", default_value = "15", value_parser = clap::value_parser!(u32).range(3..=10_000))]
    pub rounds: u32,
    /// Fragments times lights of a run at most: of a larger picture every so many fragments are
    /// lit. Plans need all of them and have no such limit
    #[arg(long, value_name = "N", default_value = "2000000", conflicts_with_all = OF_FUNCTIONS)]
    pub most: u64,
    /// Pixels of the picture [default: the scene's]
    #[arg(long, value_name = "WxH", value_parser = size, conflicts_with_all = OF_FUNCTIONS)]
    pub size: Option<[u32; 2]>,
    /// The lighting model of the reference [default: the scene's, or what the shader looks like]
    #[arg(long, value_name = "MODEL", conflicts_with_all = OF_FUNCTIONS)]
    pub model: Option<String>,
    /// The model of one variant, which is then held against a reference of its own: for shaders
    /// that compute something else on purpose. Once for each
    #[arg(long, value_name = "NAME=MODEL", value_parser = setting, conflicts_with_all = OF_FUNCTIONS)]
    pub model_of: Vec<(String, String)>,
    /// Which number of the scene goes to which member: a file of JSON, or an object
    #[arg(long, value_name = "FILE|JSON", conflicts_with_all = OF_FUNCTIONS)]
    pub bind: Vec<String>,
    /// What inputs of --fn may be, as `stress` takes it: {"normal": "unit", "d": [0, 100]}, a file
    /// or an object [default: what comments beside them say, else what scenes have by their names]
    #[arg(long, value_name = "FILE|JSON", requires = "function")]
    pub domain: Option<String>,
    /// What blocks hold for --fn, by name: a file, or an object [default: their members are inputs]
    #[arg(long, value_name = "FILE|JSON", requires = "function")]
    pub data: Option<String>,
    /// The colour a texture has everywhere for --fn [default: white]
    #[arg(long = "texture", value_name = "NAME=[R,G,B,A]", value_parser = setting, requires = "function")]
    pub textures: Vec<(String, String)>,
    /// The variant of --fn whose f64 is the truth [default: the function itself, `as it is`]
    #[arg(long, value_name = "NAME", requires = "function")]
    pub truth: Option<String>,
    /// Calls of --fn in a run
    #[arg(long, value_name = "N", default_value = "16384", value_parser = samples, requires = "function")]
    pub samples: NonZeroUsize,
    /// Where the random inputs of --fn start
    #[arg(long, value_name = "N", default_value = "1", requires = "function")]
    pub seed: u64,
    /// Draw time against error: an SVG, whole or not at all
    #[arg(long, value_name = "FILE.svg", value_parser = svg)]
    pub plot: Option<PathBuf>,
    /// Form of the output
    #[arg(short, long, value_name = "FORMAT", default_value = "human")]
    pub format: BenchFormat,
    /// Seconds after which a reader has failed at a run
    #[arg(long, value_name = "SECONDS", default_value = "120", value_parser = seconds)]
    pub limit: Duration,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BenchFormat {
    /// A table for each reader
    Human,
    /// JSON as `landfall schema bench` describes it
    Json,
    /// A line a variant
    Csv,
}

/// A file for the plot.
fn svg(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let known = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("svg"));
    if known { Ok(path) } else { Err("a plot is .svg".to_string()) }
}

/// Calls of a run: some, and no more than memory holds.
fn samples(text: &str) -> Result<NonZeroUsize, String> {
    const MOST: usize = 1 << 22;
    let number = text.parse().ok().filter(|n: &NonZeroUsize| n.get() <= MOST);
    number.ok_or_else(|| format!("a run is 1 to {MOST} calls"))
}
