//! Arguments of `landfall verify`.

use landfall_exec::backend::BackendKind;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::time::Duration;

use clap::ValueEnum;
use landfall_layout::Stage;

use super::budget::seconds;
use super::read::stage;
use super::{ConfigArgs, ReadArgs};

#[derive(Debug, clap::Args)]
pub struct VerifyArgs {
    /// Files, directories and globs; - reads stdin
    #[arg(value_name = "FILE", default_value = ".")]
    pub files: Vec<PathBuf>,
    /// Backends that run the probes, generated shaders that read one member each [default: cpu, gl
    /// and gpu as far as available]
    #[arg(
        help_heading = "Backends",
        long = "backend",
        value_name = "BACKEND",
        value_delimiter = ','
    )]
    pub backends: Vec<VerifierName>,
    /// Fail if this backend is not available; web is where the browser has one of its APIs
    #[arg(help_heading = "Backends", long, value_name = "BACKEND", value_delimiter = ',')]
    pub require: Vec<VerifierName>,
    /// Output format
    #[arg(short, long, value_name = "FORMAT", default_value = "human")]
    pub format: VerifyFormat,
    /// Only the block with this name or instance name
    #[arg(help_heading = "Subject", short, long, value_name = "NAME")]
    pub block: Option<String>,
    /// Verify the layout in FILE, a lock or output of `layout --format json`, not the computed one
    #[arg(help_heading = "Subject", long, value_name = "FILE")]
    pub layout: Option<PathBuf>,
    /// SPIR-V of the shader from another compiler: its decorations are compared with the layout,
    /// and backend gpu runs it beside landfall's module
    #[arg(help_heading = "Subject", long, value_name = "FILE")]
    pub spirv: Option<PathBuf>,
    /// Stages to run the probes in [default: the shader's own]
    #[arg(
        help_heading = "Subject", long = "in-stage", value_name = "STAGE", value_delimiter = ',',
        value_parser = stage
    )]
    pub stages: Vec<Stage>,
    /// Also report bytes of each block that the shader's code never reads
    #[arg(help_heading = "Coverage", long)]
    pub coverage: bool,
    /// Contents of blocks by name for --coverage, as a JSON file or object [default: zeros, then
    /// small numbers]
    #[arg(help_heading = "Coverage", long, value_name = "FILE|JSON", requires = "coverage")]
    pub data: Option<String>,
    /// Run the module that naga compiles from the source, as a wgpu program does
    #[arg(help_heading = "Subject", long)]
    pub naga: bool,
    /// GPU adapter, by a part of its name
    #[arg(help_heading = "Backends", long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Record in the locks which backends confirmed them
    #[arg(help_heading = "Locks", long)]
    pub record: bool,
    /// Directory of locks for --record [default: `locks` of the configuration, or layouts]
    #[arg(help_heading = "Locks", long, value_name = "DIR")]
    pub locks: Option<PathBuf>,
    /// Time limit of a probe on a backend, in seconds
    #[arg(
        help_heading = "Backends", long, value_name = "SECONDS", default_value = "20",
        value_parser = seconds
    )]
    pub limit: Duration,
    /// Shaders verified in parallel, each with its own driver processes; one with a browser
    /// [default: one per core]
    #[arg(help_heading = "Backends", short, long, value_name = "N")]
    pub jobs: Option<NonZeroUsize>,
    #[command(flatten)]
    pub config: ConfigArgs,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BackendName {
    /// Landfall's interpreter
    Cpu,
    /// The OpenGL driver, with the source unchanged
    Gl,
    /// wgpu: Vulkan, Metal or DX12
    Gpu,
}

impl BackendName {
    pub const ALL: [BackendName; 3] = [BackendName::Cpu, BackendName::Gl, BackendName::Gpu];

    pub fn kind(self) -> BackendKind {
        match self {
            BackendName::Cpu => BackendKind::Cpu,
            BackendName::Gl => BackendKind::Gl,
            BackendName::Gpu => BackendKind::Gpu,
        }
    }

    pub fn name(self) -> &'static str {
        self.kind().name()
    }
}

/// The backends of `verify`: those of other commands, and a browser.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum VerifierName {
    /// Landfall's interpreter
    Cpu,
    /// The OpenGL driver, with the source unchanged
    Gl,
    /// wgpu: Vulkan, Metal or DX12
    Gpu,
    /// Chromium without a window: WebGL 2, and WebGPU where it has it
    Web,
}

impl VerifierName {
    /// The backends that it names, in the order of reports.
    pub fn kinds(self) -> &'static [BackendKind] {
        match self {
            VerifierName::Cpu => &[BackendKind::Cpu],
            VerifierName::Gl => &[BackendKind::Gl],
            VerifierName::Gpu => &[BackendKind::Gpu],
            VerifierName::Web => &[BackendKind::WebGl, BackendKind::WebGpu],
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            VerifierName::Web => "web",
            VerifierName::Cpu | VerifierName::Gl | VerifierName::Gpu => self.kinds()[0].name(),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum VerifyFormat {
    /// A line per block, details where a backend disagrees
    Human,
    /// JSON, described by `landfall schema verify`
    Json,
}
