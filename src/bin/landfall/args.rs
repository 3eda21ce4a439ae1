//! The command-line arguments, as clap parses them.

#[cfg(feature = "exec")]
mod bench;
mod budget;
mod check;
#[cfg(any(feature = "exec", feature = "port"))]
mod code;
mod codec;
#[cfg(feature = "completions")]
mod completions;
mod emit;
mod examples;
#[cfg(feature = "exec")]
mod floats;
#[cfg(feature = "exec")]
mod function;
mod help;
mod init;
mod levels;
#[cfg(feature = "analysis")]
mod lights;
mod lock;
#[cfg(feature = "lsp")]
mod lsp;
#[cfg(not(all(
    feature = "exec",
    feature = "completions",
    feature = "lsp",
    feature = "port",
    feature = "serve"
)))]
mod missing;
#[cfg(feature = "port")]
mod port;
#[cfg(feature = "exec")]
mod prove;
mod read;
#[cfg(feature = "exec")]
mod render;
mod report;
#[cfg(feature = "exec")]
mod run;
#[cfg(feature = "serve")]
mod serve;
#[cfg(feature = "exec")]
mod stress;
#[cfg(feature = "exec")]
mod verify;
#[cfg(feature = "exec")]
mod words;

use std::path::PathBuf;

use clap::{Parser, Subcommand, ValueEnum};
use landfall_layout::format;

#[cfg(feature = "exec")]
pub use bench::{BenchArgs, BenchFormat};
pub use budget::BudgetArgs;
pub use check::{CheckArgs, ConfigArgs, Form, Report, RuleArgs, RuleFormat};
#[cfg(any(feature = "exec", feature = "port"))]
pub use code::CodeArgs;
pub use codec::{DecodeArgs, DecodeFormat, EncodeArgs, HexLine, byte};
#[cfg(feature = "completions")]
pub use completions::{CompletionsArgs, ManArgs};
pub use emit::EmitArgs;
#[cfg(feature = "exec")]
pub use floats::FloatsArgs;
#[cfg(feature = "exec")]
pub use function::FunctionArgs;
#[cfg(feature = "completions")]
pub use help::command;
pub use help::parse;
pub use init::InitArgs;
pub use landfall_check::config::{define, setting};
#[cfg(feature = "analysis")]
pub use lights::{LightsArgs, LightsFormat};
pub use lock::{DiffArgs, DiffFormat, LockArgs};
#[cfg(feature = "lsp")]
pub use lsp::LspArgs;
#[cfg(not(feature = "analysis"))]
pub use missing::LightsArgs;
#[cfg(not(feature = "lsp"))]
pub use missing::LspArgs;
#[cfg(not(feature = "port"))]
pub use missing::PortArgs;
#[cfg(not(feature = "serve"))]
pub use missing::ServeArgs;
#[cfg(not(feature = "exec"))]
pub use missing::{BenchArgs, DevicesArgs, ProveArgs, RenderArgs, RunArgs, StressArgs, VerifyArgs};
#[cfg(not(feature = "completions"))]
pub use missing::{CompletionsArgs, ManArgs};
#[cfg(feature = "port")]
pub use port::{PortArgs, PortTo};
#[cfg(feature = "exec")]
pub use prove::{ProveArgs, ProveFormat};
pub use read::{ReadArgs, RulesArgs, StructArgs, TextArgs};
#[cfg(feature = "exec")]
pub use render::{RenderArgs, RenderFormat, TransferName};
pub use report::ReportArgs;
#[cfg(feature = "exec")]
pub use run::{RunArgs, RunFormat};
#[cfg(feature = "serve")]
pub use serve::ServeArgs;
#[cfg(feature = "exec")]
pub use stress::{StressArgs, StressFormat};
#[cfg(feature = "exec")]
pub use verify::{BackendName, VerifierName, VerifyArgs, VerifyFormat};

/// Computes byte layouts of GLSL and WGSL blocks, generates mirrors, and checks them on drivers.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 100)]
pub struct Args {
    #[command(subcommand)]
    pub command: Command,
    #[command(flatten)]
    pub global: GlobalArgs,
}

/// The options of every command.
#[derive(Debug, clap::Args)]
pub struct GlobalArgs {
    /// When to colour the output
    #[arg(long, global = true, value_name = "WHEN", default_value = "auto")]
    pub color: Color,
    /// Print errors only: no warnings, notes or progress
    #[arg(short, long, global = true)]
    pub quiet: bool,
    #[command(flatten)]
    pub budget: BudgetArgs,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Print the byte layout of every block
    Layout(LayoutArgs),
    /// Explain the offset of a member, or find the member at a byte
    Explain(ExplainArgs),
    /// Draw memory maps of all blocks, with the findings, as one HTML file
    Report(ReportArgs),
    /// Serve the playground: layouts, maps and findings as you type
    Serve(ServeArgs),
    /// Serve an editor: offsets, findings and fixes where you type
    Lsp(LspArgs),
    /// Generate mirrors of blocks in Rust, C and other languages
    Emit(Box<EmitArgs>),
    /// Rewrite legacy GLSL as Vulkan GLSL, naga's GLSL or WGSL
    Port(PortArgs),
    /// Convert JSON values to the bytes of a block
    Encode(EncodeArgs),
    /// Convert the bytes of a block to a table or JSON, and flag bad values
    Decode(DecodeArgs),
    /// Run shaders to prove that every member is read at its offset
    Verify(VerifyArgs),
    /// Call a function of a shader in f32 and f64
    Run(RunArgs),
    /// Search for inputs at which a function is inaccurate
    Stress(StressArgs),
    /// Prove that a function has no undefined results, NaN or infinities
    Prove(ProveArgs),
    /// Render a JSON scene of lights with a shader
    Render(Box<RenderArgs>),
    /// Measure the run time and error of shader variants
    Bench(Box<BenchArgs>),
    /// List light structures, their cost and numerical hazards
    Lights(LightsArgs),
    /// List the backends and adapters of this machine, with their limits
    Devices(DevicesArgs),
    /// Record the layout of every shader in a lock file
    Lock(LockArgs),
    /// Compare two layouts and classify each change
    Diff(DiffArgs),
    /// Check shaders for lint findings and layout changes
    Check(CheckArgs),
    /// Write a commented landfall.toml for the shaders of a directory
    Init(InitArgs),
    /// List the lints and hazards, or explain one of them
    Rule(RuleArgs),
    /// Print the JSON Schema of an output format, landfall.toml or scenes
    Schema(SchemaArgs),
    /// Print a script that completes the arguments of landfall in a shell
    #[command(hide = true)]
    Completions(CompletionsArgs),
    /// Write the manual pages of landfall and its commands
    #[command(hide = true)]
    Man(ManArgs),
    /// Serve a driver to another process over stdin and stdout
    #[cfg(any(feature = "gl", feature = "gpu"))]
    // A name that is like none that people type: hidden commands are suggested, too.
    #[command(hide = true, name = "__reader")]
    Reader(ServeBackendArgs),
}

impl Command {
    /// Whether the command follows the code of shaders, which may nest deeply, in this build.
    pub fn lowers(&self) -> bool {
        let follows = matches!(self, Command::Check(_) | Command::Lights(_) | Command::Report(_));
        let runs = matches!(
            self,
            Command::Verify(_)
                | Command::Run(_)
                | Command::Stress(_)
                | Command::Prove(_)
                | Command::Render(_)
                | Command::Bench(_)
        );
        let follows = follows || matches!(self, Command::Lsp(_));
        follows && cfg!(feature = "analysis") || runs && cfg!(feature = "exec")
    }
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
    /// Output format
    #[arg(short, long, value_name = "FORMAT", default_value = "table")]
    pub format: LayoutFormat,
    /// Only the block with this name or instance name
    #[arg(short, long, value_name = "NAME")]
    pub block: Option<String>,
    #[command(flatten)]
    pub only: StructArgs,
    /// List every array element instead of one pattern an array
    #[arg(long)]
    pub expand: bool,
    /// Mark members that naga, and so wgpu, places elsewhere (JSON always does)
    #[arg(long)]
    pub naga: bool,
    /// Write one file per shader below DIR, in the same tree, instead of stdout
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Overwrite files in DIR that `layout --out` did not write
    #[arg(long, requires = "out")]
    pub force: bool,
    /// Files processed in parallel [default: one per core]
    #[arg(short, long, value_name = "N")]
    pub jobs: Option<std::num::NonZeroUsize>,
    #[command(flatten)]
    pub config: ConfigArgs,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum LayoutFormat {
    /// Aligned columns
    Table,
    /// The structures in the shader's language, with explicit padding
    Listing,
    /// JSON, described by `landfall schema layout`
    Json,
    /// One row per scalar, vector and matrix
    Csv,
    /// Markdown tables
    Md,
}

impl LayoutFormat {
    pub fn form(self) -> format::Format {
        match self {
            LayoutFormat::Table => format::Format::Table,
            LayoutFormat::Listing => format::Format::Listing,
            LayoutFormat::Json => format::Format::Json,
            LayoutFormat::Csv => format::Format::Csv,
            LayoutFormat::Md => format::Format::Markdown,
        }
    }
}

#[derive(Debug, clap::Args)]
pub struct ExplainArgs {
    /// The shader; - reads stdin
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// A member as the shader spells it, such as data[3].color, behind the name of its structure
    /// where no block holds it; or a byte of the block: @172
    #[arg(value_name = "PATH|@BYTE")]
    pub place: String,
    /// What is left of a path in two parts, for a message that says so.
    #[arg(hide = true)]
    pub rest: Option<String>,
    /// Search only the block with this name or instance name
    #[arg(short, long, value_name = "NAME")]
    pub block: Option<String>,
    #[command(flatten)]
    pub only: StructArgs,
    /// Output format
    #[arg(short, long, value_name = "FORMAT", default_value = "human")]
    pub format: ExplainFormat,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ExplainFormat {
    /// Text
    Human,
    /// JSON, described by `landfall schema explain`
    Json,
}

#[cfg(feature = "exec")]
#[derive(Debug, clap::Args)]
pub struct DevicesArgs {
    /// Backends to open [default: all]
    #[arg(long = "backend", value_name = "BACKENDS", value_delimiter = ',')]
    pub backends: Vec<VerifierName>,
    /// Output format
    #[arg(short, long, value_name = "FORMAT", default_value = "table")]
    pub format: DevicesFormat,
}

#[cfg(feature = "exec")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DevicesFormat {
    /// Aligned columns
    Table,
    /// JSON, described by `landfall schema devices`
    Json,
}

#[cfg(any(feature = "gl", feature = "gpu"))]
#[derive(Debug, clap::Args)]
pub struct ServeBackendArgs {
    /// The driver to load
    pub driver: ServedDriver,
    /// Part of the name of the adapter or of its backend
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
}

#[cfg(any(feature = "gl", feature = "gpu"))]
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ServedDriver {
    Gl,
    Gpu,
}

#[derive(Debug, clap::Args)]
pub struct SchemaArgs {
    /// The output format, or `config`, `baseline` or `scene`
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
    /// prove --format json
    Prove,
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
    /// Findings on stderr with --format json, one per line
    Diagnostic,
    /// Lock files
    Lock,
    /// diff --format json
    Diff,
    /// Permitted findings, baselines of `check --write-baseline`
    Baseline,
    /// The configuration, landfall.toml
    Config,
    /// Scenes for render and bench
    Scene,
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
    fn defines_without_a_value_are_one() {
        assert_eq!(define("LIGHTS"), Ok(("LIGHTS".to_string(), "1".to_string())));
        assert_eq!(define("N=a=b"), Ok(("N".to_string(), "a=b".to_string())));
        assert_eq!(define("N="), Ok(("N".to_string(), String::new())));
        assert!(define("3D").is_err());
        assert!(setting("N").is_err());
    }
}
