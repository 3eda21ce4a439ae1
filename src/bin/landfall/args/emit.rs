//! Arguments of `emit`.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use landfall_codegen::OutputLanguage;
use landfall_codegen::c::CVectors;
use landfall_codegen::languages::{self, LANGUAGES};
use landfall_codegen::rust::{Api, Modules, Vectors};

use super::{ConfigArgs, ReadArgs, setting};

#[derive(Debug, clap::Args)]
pub struct EmitArgs {
    /// Files, directories and globs; their blocks go into one output file [default: the files of
    /// `[[assert]]` in the configuration are written]
    #[arg(value_name = "FILE", requires = "lang")]
    pub files: Vec<PathBuf>,
    /// Language of the generated code
    #[arg(short, long, value_name = "LANG", value_parser = output_languages(), requires = "files")]
    pub lang: Option<OutputLanguage>,
    /// List the languages, with what each is for
    #[arg(long, conflicts_with_all = ["files", "check"])]
    pub list: bool,
    /// Only this structure, which needs no binding, under each rules or those of --rules
    #[arg(long = "struct", value_name = "NAME")]
    pub structure: Option<String>,
    /// Write to FILE instead of stdout; a failure leaves FILE unchanged
    #[arg(short, long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Write nothing; exit with 1 if FILE is out of date
    #[arg(long)]
    pub check: bool,
    /// Types of vectors and matrices [default: glam in Rust, array in C]
    #[arg(
        long, value_name = "TYPES",
        value_parser = [Vectors::Glam.name(), CVectors::Glm.name(), CVectors::Array.name()]
    )]
    pub vectors: Option<String>,
    /// Rust, C: use a type of the program for a type (`vec3`) or a member (`Light.pos`)
    #[arg(long = "type", value_name = "OF=TYPE", value_parser = setting)]
    pub types: Vec<(String, String)>,
    /// Assertions instead of mirrors: the program's structure HOST lies in memory as the structure,
    /// block or `Block.member` SHADER is read
    #[arg(
        help_heading = "Assertions", long = "assert", value_name = "HOST=SHADER",
        value_parser = setting
    )]
    pub assertions: Vec<(String, String)>,
    /// The program's name of a member (`Light.position=pos`), or none where it has none (`Light.pad=`)
    #[arg(
        help_heading = "Assertions", long = "field", value_name = "MEMBER=NAME",
        value_parser = field, requires = "assertions"
    )]
    pub fields: Vec<(String, String)>,
    /// What the program's names of members begin with, such as `m_`
    #[arg(
        help_heading = "Assertions",
        long,
        value_name = "TEXT",
        default_value = "",
        requires = "assertions"
    )]
    pub field_prefix: String,
    /// Rust: a module for each shader, none, or one each where there are several [default: auto]
    #[arg(
        help_heading = "Rust", long, value_name = "WHICH",
        value_parser = [Modules::Auto.name(), Modules::Each.name(), Modules::Flat.name()]
    )]
    pub modules: Option<String>,
    /// Rust: name a structure or block (`Light`, `a.frag:Light`) or a module (`a.frag`)
    #[arg(
        help_heading = "Rust", long, value_name = "OLD=NEW",
        value_parser = setting
    )]
    pub rename: Vec<(String, String)>,
    /// Rust: derive a trait for all types, such as `serde::Serialize`
    #[arg(help_heading = "Rust", long = "derive", value_name = "TRAIT")]
    pub derives: Vec<String>,
    /// Rust: make items `pub(crate)`
    #[arg(help_heading = "Rust", long)]
    pub crate_visible: bool,
    /// Rust: omit the tables of offsets by name
    #[arg(help_heading = "Rust", long)]
    pub no_tables: bool,
    /// Rust: add bindings for an API: layouts, vertices, entry points, constants
    #[arg(
        help_heading = "Bindings", long, value_name = "API", value_delimiter = ',',
        value_parser = Api::NAMES.iter().map(|(name, _)| *name).collect::<Vec<_>>()
    )]
    pub bindings: Vec<String>,
    /// Make shaders one program [default: `a.vert` with `a.frag`, others alone]
    #[arg(
        help_heading = "Bindings", long, value_name = "NAME=FILES",
        value_parser = setting, requires = "bindings"
    )]
    pub program: Vec<(String, String)>,
    /// Bind this buffer with a dynamic offset
    #[arg(help_heading = "Bindings", long, value_name = "NAME", requires = "bindings")]
    pub dynamic_offset: Vec<String>,
    /// wgpu: this texture of floats is not filtered, or this sampler does not filter
    #[arg(help_heading = "Bindings", long, value_name = "NAME", requires = "bindings")]
    pub unfilterable: Vec<String>,
    /// Give the number of elements of an array of resources that is declared without
    #[arg(
        help_heading = "Bindings", long = "count", value_name = "NAME=N",
        value_parser = count, requires = "bindings"
    )]
    pub counts: Vec<(String, u32)>,
    /// Add the shaders' text, by `include_str!` or, with their includes, as literals
    #[arg(help_heading = "Bindings", long, requires_all = ["bindings", "out"])]
    pub embed_sources: bool,
    /// C: put types and functions into a namespace in C++, such as `engine::gpu`
    #[arg(help_heading = "C", long, value_name = "NAME", default_value = "")]
    pub namespace: String,
    /// C: include a header; assertions in Zig: import a file; such as `engine/math.h` or `<cglm/cglm.h>`
    #[arg(help_heading = "C", long, value_name = "HEADER")]
    pub include_header: Vec<String>,
    /// All but Rust: prefix of every name outside of a type
    #[arg(help_heading = "Other languages", long, value_name = "TEXT", default_value = "")]
    pub prefix: String,
    #[command(flatten)]
    pub config: ConfigArgs,
    #[command(flatten)]
    pub read: ReadArgs,
}

/// `MEMBER=NAME`, with or without a name.
fn field(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((member, name)) if !member.trim().is_empty() => {
            Ok((member.trim().to_string(), name.trim().to_string()))
        }
        Some(_) | None => Err("expected MEMBER=NAME".to_string()),
    }
}

/// `NAME=N`, with a number from 1.
fn count(text: &str) -> Result<(String, u32), String> {
    let (name, count) = setting(text)?;
    match count.parse() {
        Ok(count) if count > 0 => Ok((name, count)),
        _ => Err(format!("`{count}` is no number from 1")),
    }
}

fn output_languages() -> impl TypedValueParser<Value = OutputLanguage> {
    let names = LANGUAGES.iter().map(|l| PossibleValue::new(l.name).help(l.about));
    PossibleValuesParser::new(names)
        .try_map(|name| languages::from_name(&name).ok_or("no such language"))
}
