//! Arguments of `landfall render`.

use std::path::PathBuf;
use std::time::Duration;

use clap::ValueEnum;

use super::budget::seconds;
use super::{BackendName, CodeArgs};

/// The rows of a comparison, as the help states them.
const ROWS: &str = "\
Rows of a comparison:
  linear      difference of the linear values, in steps of 1/255
  8-bit       difference of the values from 0 to 255, after --transfer
  flips       share of the 8-bit values that differ
  psnr        peak signal-to-noise ratio of the 8-bit values
  FLIP        difference as seen by a viewer, from 0 to 1 (Andersson et al. 2020)
  non-finite  pixels with NaN or infinity, which are not compared";

#[derive(Debug, clap::Args)]
#[command(after_help = ROWS)]
pub struct RenderArgs {
    /// The scene, described by `landfall schema scene`
    #[arg(value_name = "SCENE.json", required_unless_present = "skip")]
    pub scene: Option<PathBuf>,
    /// Shader whose fragment stage lights the scene [default: the scene's]
    #[arg(help_heading = "Shader and scene", long, value_name = "FILE")]
    pub shader: Option<PathBuf>,
    /// Fragment entry point, if WGSL has several
    #[arg(help_heading = "Shader and scene", long, value_name = "NAME")]
    pub entry: Option<String>,
    /// Backend to run the shader on
    #[arg(help_heading = "Backend", long, value_name = "BACKEND", default_value = "cpu")]
    pub backend: BackendName,
    /// GPU adapter, by a part of its name
    #[arg(help_heading = "Backend", long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Render the f64 reference instead of the shader
    #[arg(help_heading = "Picture", long, conflicts_with_all = ["backend", "print_bind"])]
    pub reference: bool,
    /// Width and height in pixels [default: the scene's]
    #[arg(help_heading = "Picture", long, value_name = "WxH", value_parser = size)]
    pub size: Option<[u32; 2]>,
    /// Write the picture to FILE: .png with 8 bits, .exr or .pfm with floats
    #[arg(help_heading = "Picture", short, long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Transfer function from linear to 8-bit values, in PNG and in comparisons
    #[arg(help_heading = "Picture", long, value_name = "CURVE", default_value = "linear")]
    pub transfer: TransferName,
    /// Compare with `reference`, another backend or a picture FILE; with --out, also write pictures
    /// of the difference
    #[arg(help_heading = "Comparison", long, value_name = "PICTURE", value_delimiter = ',')]
    pub compare: Vec<String>,
    /// Exit with 1 if an 8-bit value differs by more than STEPS
    #[arg(help_heading = "Comparison", long, value_name = "STEPS", requires = "compare")]
    pub max_step: Option<u8>,
    /// Lighting model of the reference: multi, array, view_space, casters or a JSON object
    /// [default: the scene's, or inferred from the shader]
    #[arg(help_heading = "Shader and scene", long, value_name = "MODEL")]
    pub model: Option<String>,
    /// Properties of the scene, or numbers, for members, textures and inputs of the shader, as a JSON
    /// file or object such as {"eye": "camera.position"}
    #[arg(help_heading = "Shader and scene", long, value_name = "FILE|JSON")]
    pub bind: Vec<String>,
    /// Print the source of every member, texture and input instead of rendering
    #[arg(help_heading = "Output", long)]
    pub print_bind: bool,
    /// Skip lights that the shader's code gives zero for, where that saves time; or what comma-separated
    /// parts such as `used,gates,tiles=8,budget=0.5` name; `--skip help` explains each
    #[arg(
        help_heading = "Skipped work", long, value_name = "PARTS", num_args = 0..=1,
        default_missing_value = "",
        conflicts_with_all = ["reference", "print_bind"]
    )]
    pub skip: Option<String>,
    /// Write the shader to FILE with its loops over lights reading lists, which `--skip` fills, and
    /// render with it
    #[arg(help_heading = "Skipped work", long, value_name = "FILE", requires = "skip")]
    pub emit_shader: Option<PathBuf>,
    /// Drop lights that exceed the shader's slots, instead of failing
    #[arg(help_heading = "Shader and scene", long)]
    pub leave_out: bool,
    /// Report operations with undefined results; backend cpu only, several times slower
    #[arg(help_heading = "Backend", long)]
    pub watch: bool,
    /// Print the counts of what was executed, what --skip leaves out, its time and its error, and every
    /// measure of a comparison, too
    #[arg(help_heading = "Output", long)]
    pub details: bool,
    /// Report format
    #[arg(help_heading = "Output", short, long, value_name = "FORMAT", default_value = "human")]
    pub format: RenderFormat,
    /// Time limit of a part of the picture, in seconds
    #[arg(
        help_heading = "Backend", long, value_name = "SECONDS", default_value = "120",
        value_parser = seconds
    )]
    pub limit: Duration,
    #[command(flatten)]
    pub read: CodeArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RenderFormat {
    /// Text
    Human,
    /// JSON, described by `landfall schema render`
    Json,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TransferName {
    /// 255 times the value, as a render target without sRGB stores it
    Linear,
    /// The sRGB curve
    Srgb,
}

/// Parses `WxH`.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let side = |text: &str| text.parse::<u32>().ok().filter(|n| (1..=1 << 15).contains(n));
    let sides = text.split_once(['x', 'X']).map(|(w, h)| (side(w), side(h)));
    match sides {
        Some((Some(width), Some(height))) => Ok([width, height]),
        _ => Err("a size is WxH, each side from 1 to 32768".to_string()),
    }
}
