//! Arguments of `landfall verify`.

use landfall_exec::backend::BackendKind;
use std::path::PathBuf;
use std::time::Duration;

use clap::ValueEnum;
use landfall_layout::Stage;

use super::read::stage;
use super::{ConfigArgs, ReadArgs};

#[derive(Debug, clap::Args)]
pub struct VerifyArgs {
    /// Files, directories and globs; - reads stdin
    #[arg(value_name = "FILE", default_value = ".")]
    pub files: Vec<PathBuf>,
    /// Who reads [default: all that are here]
    #[arg(long = "reader", value_name = "READER", value_delimiter = ',')]
    pub readers: Vec<ReaderName>,
    /// Fail when that reader is not to be had
    #[arg(long, value_name = "READER", value_delimiter = ',')]
    pub require: Vec<ReaderName>,
    /// Form of the output
    #[arg(short, long, value_name = "FORMAT", default_value = "human")]
    pub format: VerifyFormat,
    /// Only the block of that name, by its own or its instance's
    #[arg(short, long, value_name = "NAME")]
    pub block: Option<String>,
    /// Prove the layout in FILE, a lock or the output of layout --format json, not the computed one
    #[arg(long, value_name = "FILE")]
    pub layout: Option<PathBuf>,
    /// SPIR-V your own compiler made of the shader: its decorations are held against the layout,
    /// and reader gpu runs it beside landfall's module
    #[arg(long, value_name = "FILE")]
    pub spirv: Option<PathBuf>,
    /// Stages that read [default: the shader's own]
    #[arg(long = "in-stage", value_name = "STAGE", value_delimiter = ',', value_parser = stage)]
    pub stages: Vec<Stage>,
    /// Say too which bytes of each block the shader's own code never reads
    #[arg(long)]
    pub coverage: bool,
    /// What blocks hold when --coverage runs the shader, by name: a file, or an object
    /// [default: zeros, then small numbers]
    #[arg(long, value_name = "FILE|JSON", requires = "coverage")]
    pub data: Option<String>,
    /// Run the module naga makes of the text, to see what a wgpu program reads
    #[arg(long)]
    pub naga: bool,
    /// Part of the name of the GPU adapter to take
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Note in the locks who confirmed them
    #[arg(long)]
    pub record: bool,
    /// Directory of the locks that --record writes to [default: `locks` of the configuration, or
    /// layouts]
    #[arg(long, value_name = "DIR")]
    pub locks: Option<PathBuf>,
    /// Seconds after which a reader has failed at a probe
    #[arg(long, value_name = "SECONDS", default_value = "20", value_parser = seconds)]
    pub limit: Duration,
    #[command(flatten)]
    pub config: ConfigArgs,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ReaderName {
    /// Landfall's own evaluator
    Cpu,
    /// The OpenGL driver, with the text as it is
    Gl,
    /// wgpu: Vulkan, Metal or DX12
    Gpu,
}

impl ReaderName {
    pub const ALL: [ReaderName; 3] = [ReaderName::Cpu, ReaderName::Gl, ReaderName::Gpu];

    pub fn kind(self) -> BackendKind {
        match self {
            ReaderName::Cpu => BackendKind::Cpu,
            ReaderName::Gl => BackendKind::Gl,
            ReaderName::Gpu => BackendKind::Gpu,
        }
    }

    pub fn name(self) -> &'static str {
        self.kind().name()
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum VerifyFormat {
    /// A line a block, details where a reader disagrees
    Human,
    /// JSON as `landfall schema verify` describes it
    Json,
}

/// Seconds of thirty years: nobody waits longer, and clocks can add them up.
const LONGEST: Duration = Duration::from_secs(1_000_000_000);

/// A number of seconds.
pub fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text.parse().map_err(|_| "a limit is a number of seconds".to_string())?;
    match Duration::try_from_secs_f64(seconds) {
        Ok(limit) if !limit.is_zero() && limit <= LONGEST => Ok(limit),
        Ok(_) | Err(_) => Err(format!("a limit is above 0 and up to {} s", LONGEST.as_secs())),
    }
}
