//! Arguments of `landfall render`.

use std::path::PathBuf;
use std::time::Duration;

use clap::ValueEnum;

use super::verify::seconds;
use super::{ReadArgs, ReaderName};

#[derive(Debug, clap::Args)]
pub struct RenderArgs {
    /// The scene
    #[arg(value_name = "SCENE.json")]
    pub scene: PathBuf,
    /// The shader whose fragment stage lights it [default: the scene's]
    #[arg(long, value_name = "FILE")]
    pub shader: Option<PathBuf>,
    /// Its fragment entry point, where WGSL has several
    #[arg(long, value_name = "NAME")]
    pub entry: Option<String>,
    /// Who runs it
    #[arg(long, value_name = "READER", default_value = "cpu")]
    pub reader: ReaderName,
    /// Part of the name of the GPU adapter to take
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// The picture of the reference instead: f64, no shader
    #[arg(long, conflicts_with_all = ["reader", "print_bind"])]
    pub reference: bool,
    /// Pixels of the picture [default: the scene's]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<[u32; 2]>,
    /// Write the picture: .png of 8 bits, .exr or .pfm of floats; whole or not at all
    #[arg(short, long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// How 8-bit codes are made of linear values, in PNG and in comparisons
    #[arg(long, value_name = "HOW", default_value = "linear")]
    pub transfer: TransferName,
    /// Compare it with the picture of the reference, of another reader, or in a file; with --out
    /// also writes pictures of the difference
    #[arg(long, value_name = "WHAT", value_delimiter = ',')]
    pub compare: Vec<String>,
    /// Exit with 1 if a code differs by more steps than this from what it is compared with
    #[arg(long, value_name = "STEPS", requires = "compare")]
    pub max_step: Option<u8>,
    /// The lighting model of the reference: multi, array, view_space or casters, or an object
    /// [default: the scene's, or the one the shader looks like]
    #[arg(long, value_name = "MODEL")]
    pub model: Option<String>,
    /// Which number of the scene goes to which member: a file of JSON, or an object
    #[arg(long, value_name = "FILE|JSON")]
    pub bind: Vec<String>,
    /// Print what every member, texture and input is given, and render nothing
    #[arg(long)]
    pub print_bind: bool,
    /// Skip what the scene does not need: parts with commas between them, as
    /// `used,gates,tiles=8,budget=0.5`; `--skip help` lists them
    #[arg(long, value_name = "PARTS", conflicts_with_all = ["reference", "print_bind"])]
    pub skip: Option<String>,
    /// Print what the plan skips, saves and risks; a report in JSON always says it
    #[arg(long, requires = "skip")]
    pub plan: bool,
    /// Leave out lights that the shader has no slots for, instead of refusing
    #[arg(long)]
    pub leave_out: bool,
    /// Note operations without a defined value, on the reader cpu: several times slower
    #[arg(long)]
    pub watch: bool,
    /// Form of the report
    #[arg(short, long, value_name = "FORMAT", default_value = "human")]
    pub format: RenderFormat,
    /// Seconds after which the reader has failed at a part of the picture
    #[arg(long, value_name = "SECONDS", default_value = "120", value_parser = seconds)]
    pub limit: Duration,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RenderFormat {
    /// Lines for the eye
    Human,
    /// JSON as `landfall schema render` describes it
    Json,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TransferName {
    /// 255 times the value, as a target without sRGB stores it
    Linear,
    /// By the curve of sRGB
    Srgb,
}

/// `WxH`.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let side = |text: &str| text.parse::<u32>().ok().filter(|n| (1..=1 << 15).contains(n));
    let sides = text.split_once(['x', 'X']).map(|(w, h)| (side(w), side(h)));
    match sides {
        Some((Some(width), Some(height))) => Ok([width, height]),
        _ => Err("a size is WxH, each from 1 to 32768".to_string()),
    }
}
