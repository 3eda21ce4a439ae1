//! What may be written on the command line. Nothing here acts.

#[cfg(feature = "exec")]
mod bench;
mod check;
mod codec;
#[cfg(feature = "exec")]
mod floats;
mod levels;
mod lights;
mod lock;
#[cfg(not(feature = "exec"))]
mod missing;
mod read;
#[cfg(feature = "exec")]
mod render;
#[cfg(feature = "exec")]
mod run;
#[cfg(feature = "exec")]
mod stress;
#[cfg(feature = "exec")]
mod verify;

use std::path::PathBuf;

use clap::{Parser, Subcommand, ValueEnum};
use landfall_layout::codegen::rust::Vectors;
use landfall_layout::format as emit;
use landfall_layout::shape::DEFAULT_BLOCK;

#[cfg(feature = "exec")]
pub use bench::{BenchArgs, BenchFormat};
pub use check::{CheckArgs, ConfigArgs, MergeArgs, Report, RuleArgs, RuleFormat, Shard};
pub use codec::{DecodeArgs, DecodeFormat, EncodeArgs, byte};
#[cfg(feature = "exec")]
pub use floats::FloatsArgs;
pub use lights::{LightsArgs, LightsFormat};
pub use lock::{DiffArgs, DiffFormat, LockArgs};
#[cfg(not(feature = "exec"))]
pub use missing::{BenchArgs, DevicesArgs, RenderArgs, RunArgs, StressArgs, VerifyArgs};
pub use read::{Api, ReadArgs, TextArgs, define, setting};
#[cfg(feature = "exec")]
pub use render::{RenderArgs, RenderFormat, TransferName};
#[cfg(feature = "exec")]
pub use run::{RunArgs, RunFormat};
#[cfg(feature = "exec")]
pub use stress::{StressArgs, StressFormat};
#[cfg(feature = "exec")]
pub use verify::{ReaderName, VerifyArgs, VerifyFormat};

/// Every byte you upload lands where the shader reads it: byte layouts of GLSL and WGSL blocks.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 100)]
pub struct Args {
    #[command(subcommand)]
    pub command: Command,
    /// Colours and styles
    #[arg(long, global = true, value_name = "WHEN", default_value = "auto")]
    pub color: Color,
    /// No warnings and no progress, only errors
    #[arg(short, long, global = true)]
    pub quiet: bool,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Print the layout of every block
    Layout(LayoutArgs),
    /// Say why a path lands where it does, or who owns a byte
    Explain(ExplainArgs),
    /// Write mirrors of all blocks, and tables from names to offsets, as Rust or C
    Emit(EmitArgs),
    /// Rewrite legacy GLSL for Vulkan, its loose uniforms in one std140 block
    Port(PortArgs),
    /// Turn values in JSON into the bytes of a block
    Encode(EncodeArgs),
    /// Turn the bytes of a block into a table or JSON, and flag what looks wrong
    Decode(DecodeArgs),
    /// Upload a buffer, let the shader read it, and say which byte every member was read from
    Verify(VerifyArgs),
    /// Call one function of a shader with arguments in JSON, in f32 beside f64
    Run(RunArgs),
    /// Look for inputs at which a function of a shader breaks, and say which operation does it
    Stress(StressArgs),
    /// Light a scene in JSON by a shader and make a picture of it
    Render(Box<RenderArgs>),
    /// Measure variants of lighting, or of a function: time against error
    Bench(Box<BenchArgs>),
    /// Say what the lights of shaders cost, and where their code may leave the numbers
    Lights(LightsArgs),
    /// List what can run a shader here, and how much it takes
    Devices(DevicesArgs),
    /// Write the lock of every shader: its layout, to be committed and compared with
    Lock(LockArgs),
    /// Say what changed between two layouts, and whether old uploads still land
    Diff(DiffArgs),
    /// Hold every shader against the lints, and against its lock
    Check(CheckArgs),
    /// Make one report of those of all shards of a check
    Merge(MergeArgs),
    /// List the lints and hazards, or explain one
    Rule(RuleArgs),
    /// Print the JSON Schema of an output or a scene
    Schema(SchemaArgs),
    /// Run jobs for the process at the other end of stdin and stdout
    #[cfg(any(feature = "gl", feature = "gpu"))]
    #[command(hide = true)]
    Reader(ReaderArgs),
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Color {
    Auto,
    Always,
    Never,
}

#[derive(Debug, clap::Args)]
pub struct LayoutArgs {
    /// Files, directories (searched for shaders, .gitignore respected) and globs; - reads stdin
    #[arg(value_name = "FILE", default_value = ".")]
    pub files: Vec<PathBuf>,
    /// Form of the output
    #[arg(short, long, value_name = "FORMAT", default_value = "table")]
    pub format: LayoutFormat,
    /// Only the block of that name, by its own or its instance's
    #[arg(short, long, value_name = "NAME")]
    pub block: Option<String>,
    /// Every element of every array, instead of one pattern for all
    #[arg(long)]
    pub expand: bool,
    /// Mark where naga, and so wgpu, reads another place (always in JSON)
    #[arg(long)]
    pub naga: bool,
    /// Write one file a shader into DIR, the tree kept, instead of stdout
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Write over files in DIR that no `layout --out` has written
    #[arg(long, requires = "out")]
    pub force: bool,
    /// Files laid out at a time [default: one a core]
    #[arg(short, long, value_name = "N")]
    pub jobs: Option<std::num::NonZeroUsize>,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum LayoutFormat {
    /// Columns for the eye
    Table,
    /// The structures in their own language, holes spelled out
    Listing,
    /// JSON as `landfall schema layout` describes it
    Json,
    /// One row a leaf
    Csv,
    /// Markdown tables
    Md,
}

impl LayoutFormat {
    pub fn form(self) -> emit::Format {
        match self {
            LayoutFormat::Table => emit::Format::Table,
            LayoutFormat::Listing => emit::Format::Listing,
            LayoutFormat::Json => emit::Format::Json,
            LayoutFormat::Csv => emit::Format::Csv,
            LayoutFormat::Md => emit::Format::Markdown,
        }
    }
}

#[derive(Debug, clap::Args)]
pub struct ExplainArgs {
    /// The shader; - reads stdin
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// A path as the shader spells it, data[3].color; or a byte from the start of the block, @172
    #[arg(value_name = "PATH|@BYTE")]
    pub place: String,
    /// Only in the block of that name, by its own or its instance's
    #[arg(short, long, value_name = "NAME")]
    pub block: Option<String>,
    /// Form of the output
    #[arg(short, long, value_name = "FORMAT", default_value = "human")]
    pub format: ExplainFormat,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ExplainFormat {
    Human,
    /// JSON as `landfall schema explain` describes it
    Json,
}

#[derive(Debug, clap::Args)]
pub struct EmitArgs {
    /// Files, directories and globs; the blocks of all of them go into one file
    #[arg(value_name = "FILE", required = true)]
    pub files: Vec<PathBuf>,
    /// Language of the output
    #[arg(short, long, value_name = "LANG")]
    pub lang: EmitLang,
    /// Write to FILE instead of stdout, whole or not at all
    #[arg(short, long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Write nothing; exit with 1 if FILE is not what would be written
    #[arg(long, requires = "out")]
    pub check: bool,
    /// Rust: vectors and matrices as glam's types or as arrays [default: glam]
    #[arg(long, value_name = "AS", value_parser = [Vectors::Glam.name(), Vectors::Array.name()])]
    pub vectors: Option<String>,
    /// Rust: items visible in their crate only
    #[arg(long)]
    pub crate_visible: bool,
    /// Rust: mirrors only, without tables from names to offsets
    #[arg(long)]
    pub no_tables: bool,
    /// C: put before every type, macro and function
    #[arg(long, value_name = "TEXT", default_value = "")]
    pub prefix: String,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EmitLang {
    /// `#[repr(C)]` structures for bytemuck, offsets checked when compiled
    Rust,
    /// A header for C11 and C++17, offsets checked when compiled
    C,
}

#[derive(Debug, clap::Args)]
pub struct PortArgs {
    /// The shader; - reads stdin
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// What is to read the result
    #[arg(long, value_name = "WHAT", default_value = "vulkan")]
    pub to: PortTo,
    /// Write to OUT instead of stdout, whole or not at all
    #[arg(short, long, value_name = "OUT")]
    pub out: Option<PathBuf>,
    /// The stage before or after it, to agree with on locations
    #[arg(long, value_name = "FILE")]
    pub partner: Option<PathBuf>,
    /// Give an input or output this location
    #[arg(long = "location", value_name = "NAME=N", value_parser = location)]
    pub locations: Vec<(String, u32)>,
    /// Name of the block that loose uniforms become
    #[arg(long, value_name = "NAME", default_value = DEFAULT_BLOCK)]
    pub block: String,
    /// Descriptor set of everything that has none
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub set: u32,
    /// First binding to give out
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub first_binding: u32,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PortTo {
    /// Vulkan's GLSL 4.50
    Vulkan,
    /// GLSL 4.50 as naga and wgpu take it, textures and samplers apart
    Naga,
    /// WGSL, where its rules keep every member's place
    Wgsl,
}

#[cfg(feature = "exec")]
#[derive(Debug, clap::Args)]
pub struct DevicesArgs {
    /// Form of the output
    #[arg(short, long, value_name = "FORMAT", default_value = "table")]
    pub format: DevicesFormat,
}

#[cfg(feature = "exec")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DevicesFormat {
    /// Columns for the eye
    Table,
    /// JSON as `landfall schema devices` describes it
    Json,
}

#[cfg(any(feature = "gl", feature = "gpu"))]
#[derive(Debug, clap::Args)]
pub struct ReaderArgs {
    /// The driver to load
    pub driver: ReaderDriver,
    /// Part of the name of the adapter, or of its backend
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
}

#[cfg(any(feature = "gl", feature = "gpu"))]
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ReaderDriver {
    Gl,
    Gpu,
}

#[derive(Debug, clap::Args)]
pub struct SchemaArgs {
    /// Of what
    pub of: Schema,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Schema {
    /// layout --format json
    Layout,
    /// explain --format json
    Explain,
    /// check --format json
    Check,
    /// verify --format json
    Verify,
    /// run --format json
    Run,
    /// stress --format json
    Stress,
    /// render --format json
    Render,
    /// bench --format json
    Bench,
    /// lights --format json
    Lights,
    /// The plan in render --skip PARTS --format json
    Plan,
    /// devices --format json
    Devices,
    /// Findings on stderr with --format json, one a line
    Diagnostic,
    /// The files that lock writes
    Lock,
    /// diff --format json
    Diff,
    /// A scene of lights, as render reads it
    Scene,
}

/// `NAME=N`.
fn location(text: &str) -> Result<(String, u32), String> {
    let (name, number) = setting(text)?;
    let number = number.parse().map_err(|_| "a location is a whole number".to_string())?;
    Ok((name, number))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Args::command().debug_assert();
    }

    #[test]
    fn defines_are_one_unless_they_say() {
        assert_eq!(define("LIGHTS"), Ok(("LIGHTS".to_string(), "1".to_string())));
        assert_eq!(define("N=a=b"), Ok(("N".to_string(), "a=b".to_string())));
        assert_eq!(define("N="), Ok(("N".to_string(), String::new())));
        assert!(define("3D").is_err());
        assert!(setting("N").is_err());
    }
}
