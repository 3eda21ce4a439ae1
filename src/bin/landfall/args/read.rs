//! How shaders are read: macros, includes, values, rules, stage, language and target.

use std::path::PathBuf;

use clap::ValueEnum;
use landfall_layout::{Language, Rules, Stage, Target};
use landfall_lint::settings::Target as Limits;

/// How shaders are read.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "How shaders are read")]
pub struct ReadArgs {
    #[command(flatten)]
    pub text: TextArgs,
    /// Define a macro, as 1 unless a value is given
    #[arg(short = 'D', long = "define", value_name = "NAME[=TEXT]", value_parser = define)]
    pub defines: Vec<(String, String)>,
}

/// The same without macros, for commands where `-D` has a further meaning.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "How shaders are read")]
pub struct TextArgs {
    /// Search DIR for #include
    #[arg(short = 'I', long = "include", value_name = "DIR")]
    pub include_dirs: Vec<PathBuf>,
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
    /// What shaders are for: the API GLSL is read as where its text does not say, and for `check`
    /// whose limits hold; may be given several times
    #[arg(long = "target", value_name = "API")]
    pub targets: Vec<Api>,
    /// Language, where the file's name does not say
    #[arg(long, value_name = "LANGUAGE")]
    pub language: Option<Text>,
    /// Refuse shaders and includes of more bytes [default: 67108864, 64 MiB]
    #[arg(long, value_name = "N")]
    pub max_bytes: Option<u64>,
    /// The name stdin goes by: for messages, the language, the stage and includes
    #[arg(long, value_name = "PATH")]
    pub stdin_filename: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Api {
    /// GLSL is read as OpenGL's; no limits
    Opengl,
    /// GLSL is read as Vulkan's; the limits of Vulkan 1.0
    Vulkan,
    /// OpenGL 3.3
    Gl33,
    /// OpenGL ES 3.0
    Gles30,
    /// WebGL 2
    Webgl2,
    /// WebGPU
    Webgpu,
}

impl Api {
    /// What GLSL is read as for these targets; left to the text where they disagree or say nothing.
    pub fn reading(targets: &[Api]) -> Option<Target> {
        let mut told = targets.iter().filter_map(|api| match api {
            Api::Opengl | Api::Gl33 | Api::Gles30 | Api::Webgl2 => Some(Target::OpenGl),
            Api::Vulkan => Some(Target::Vulkan),
            Api::Webgpu => None,
        });
        let first = told.next()?;
        told.all(|other| other == first).then_some(first)
    }

    /// Whose limits hold.
    pub fn limits(self) -> Option<Limits> {
        match self {
            Api::Opengl => None,
            Api::Vulkan => Some(Limits::Vulkan),
            Api::Gl33 => Some(Limits::Gl33),
            Api::Gles30 => Some(Limits::Gles30),
            Api::Webgl2 => Some(Limits::WebGl2),
            Api::Webgpu => Some(Limits::WebGpu),
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

pub fn stage(name: &str) -> Result<Stage, String> {
    Stage::from_name(name)
        .ok_or_else(|| format!("stages are {}", Stage::names().collect::<Vec<_>>().join(", ")))
}

/// `NAME`, `NAME=TEXT`.
pub fn define(text: &str) -> Result<(String, String), String> {
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
pub fn setting(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() && !value.trim().is_empty() => {
            Ok((name.trim().to_string(), value.trim().to_string()))
        }
        _ => Err("a value is set as NAME=VALUE".to_string()),
    }
}
