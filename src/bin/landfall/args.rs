//! What may be written on the command line. Nothing here acts.

use std::path::PathBuf;

use clap::{Parser, Subcommand, ValueEnum};
use landfall::buffer::Missing;
use landfall::{Language, Rules, Stage, Target, emit};

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
    /// Turn values in JSON into the bytes of a block
    Encode(EncodeArgs),
    /// Turn the bytes of a block into a table or JSON, and flag what looks wrong
    Decode(DecodeArgs),
    /// Print the JSON Schema of an output
    Schema(SchemaArgs),
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
pub struct EncodeArgs {
    /// The shader; - reads stdin
    #[arg(value_name = "SHADER")]
    pub file: PathBuf,
    /// An object of the block's members, keys may be paths such as "data[3].color"; - reads stdin
    #[arg(value_name = "VALUES", default_value = "-")]
    pub values: PathBuf,
    /// The block, by its own name or its instance's [default: the only one]
    #[arg(short, long, value_name = "NAME")]
    pub block: Option<String>,
    /// What becomes of members that are not given
    #[arg(long, value_name = "WHAT", default_value = "zero")]
    pub missing: Absent,
    /// A hex dump with the component that each word is, instead of the bytes
    #[arg(long)]
    pub hex: bool,
    /// Write FILE, whole or not at all, instead of stdout
    #[arg(short, long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Absent {
    Zero,
    Error,
}

impl Absent {
    pub fn becomes(self) -> Missing {
        match self {
            Absent::Zero => Missing::Zero,
            Absent::Error => Missing::Error,
        }
    }
}

#[derive(Debug, clap::Args)]
pub struct DecodeArgs {
    /// The shader; - reads stdin
    #[arg(value_name = "SHADER")]
    pub file: PathBuf,
    /// The bytes; - reads stdin
    #[arg(value_name = "BYTES")]
    pub bytes: PathBuf,
    /// The block, by its own name or its instance's [default: the only one]
    #[arg(short, long, value_name = "NAME")]
    pub block: Option<String>,
    /// Form of the output
    #[arg(short, long, value_name = "FORMAT", default_value = "table")]
    pub format: DecodeFormat,
    /// Start at that byte of a longer dump: 256, 0x100
    #[arg(long, value_name = "BYTE", value_parser = byte)]
    pub offset: Option<u64>,
    /// Only what a path names: data[3], data[3].color
    #[arg(long, value_name = "PATH")]
    pub only: Option<String>,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum DecodeFormat {
    /// A row for each scalar, vector and matrix
    Table,
    /// JSON that `landfall encode` takes
    Json,
}

#[derive(Debug, clap::Args)]
pub struct SchemaArgs {
    /// Of which output
    pub of: Schema,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Schema {
    /// layout --format json
    Layout,
    /// explain --format json
    Explain,
    /// Findings on stderr with --format json, one a line
    Diagnostic,
}

/// How shaders are read.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "How shaders are read")]
pub struct ReadArgs {
    /// Search DIR for #include
    #[arg(short = 'I', long = "include", value_name = "DIR")]
    pub include_dirs: Vec<PathBuf>,
    /// Define a macro, as 1 unless a value is given
    #[arg(short = 'D', long = "define", value_name = "NAME[=TEXT]", value_parser = define)]
    pub defines: Vec<(String, String)>,
    /// Set a specialisation constant or override, by name or number
    #[arg(short = 'O', long = "override", value_name = "NAME=VALUE", value_parser = setting)]
    pub overrides: Vec<(String, String)>,
    /// Lay every block out by these rules instead of its own
    #[arg(long, value_name = "RULES", value_parser = rules_parser())]
    pub rules: Option<String>,
    /// Gather loose uniforms into one std140 block named DefaultBlock
    #[arg(long)]
    pub gather: bool,
    /// Stage of GLSL, where the file's name does not say
    #[arg(long, value_name = "STAGE", value_parser = stage)]
    pub stage: Option<Stage>,
    /// API GLSL is meant for, where its text does not say
    #[arg(long, value_name = "API")]
    pub target: Option<Api>,
    /// Language, where the file's name does not say
    #[arg(long, value_name = "LANGUAGE")]
    pub language: Option<Text>,
    /// The name stdin goes by: for messages, the language, the stage and includes
    #[arg(long, value_name = "PATH")]
    pub stdin_filename: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Api {
    Opengl,
    Vulkan,
}

impl Api {
    pub fn target(self) -> Target {
        match self {
            Api::Opengl => Target::OpenGl,
            Api::Vulkan => Target::Vulkan,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Text {
    Glsl,
    Wgsl,
}

impl Text {
    pub fn language(self) -> Language {
        match self {
            Text::Glsl => Language::Glsl,
            Text::Wgsl => Language::Wgsl,
        }
    }
}

fn rules_parser() -> clap::builder::PossibleValuesParser {
    [Rules::Std140, Rules::Std430, Rules::Scalar, Rules::Wgsl].map(Rules::name).into()
}

fn stage(name: &str) -> Result<Stage, String> {
    Stage::from_name(name)
        .ok_or_else(|| format!("stages are {}", Stage::names().collect::<Vec<_>>().join(", ")))
}

/// `NAME`, `NAME=TEXT`.
fn define(text: &str) -> Result<(String, String), String> {
    let (name, value) = text.split_once('=').unwrap_or((text, "1"));
    let mut letters = name.chars();
    let starts = letters.next().is_some_and(|c| c == '_' || c.is_ascii_alphabetic());
    if starts && letters.all(|c| c == '_' || c.is_ascii_alphanumeric()) {
        Ok((name.to_string(), value.to_string()))
    } else {
        Err("a macro is NAME or NAME=TEXT, its name letters, digits and _".to_string())
    }
}

/// `NAME=VALUE`.
fn setting(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() && !value.trim().is_empty() => {
            Ok((name.trim().to_string(), value.trim().to_string()))
        }
        _ => Err("a value is set as NAME=VALUE".to_string()),
    }
}

/// `256`, `0x100`.
pub fn byte(text: &str) -> Result<u64, String> {
    let parsed = match text.strip_prefix("0x") {
        // A sign is no digit.
        Some(digits) if !digits.starts_with('+') => u64::from_str_radix(digits, 16),
        Some(_) | None => text.parse(),
    };
    parsed.map_err(|_| "a byte is a number such as 256 or 0x100".to_string())
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

    #[test]
    fn bytes_are_decimal_or_hexadecimal() {
        assert_eq!((byte("256"), byte("0x1f")), (Ok(256), Ok(31)));
        for text in ["", "-1", "0x", "0x+1", "0xg", "18446744073709551616"] {
            assert!(byte(text).is_err(), "{text}");
        }
    }
}
