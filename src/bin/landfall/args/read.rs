//! Options for reading shaders: macros, includes, constants, layout rules, stage, language, target.

use std::path::PathBuf;

use clap::ValueEnum;
use landfall_check::config::{self, Flags, GivenTargets, define, setting};
use landfall_layout::{Language, Rules, Stage, Target};
use landfall_lint::settings::Target as Limits;

/// Options for reading shaders whose blocks are laid out.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "Reading shaders")]
pub struct ReadArgs {
    #[command(flatten)]
    pub text: TextArgs,
    #[command(flatten)]
    pub rules: RulesArgs,
    /// Define a macro [default value: 1]; in WESL, set a feature, which `NAME=false` clears
    #[arg(short = 'D', long = "define", value_name = "NAME[=TEXT]", value_parser = define)]
    pub defines: Vec<(String, String)>,
}

impl ReadArgs {
    /// The settings for the configuration.
    pub fn flags(&self) -> Flags {
        self.rules.flags(&self.text, &self.defines)
    }
}

/// The layout that a caller asks for.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "Reading shaders")]
pub struct RulesArgs {
    /// Lay out every block by these rules
    #[arg(long, value_name = "RULES", value_parser = rules_parser())]
    pub rules: Option<String>,
    /// Gather loose uniforms into a std140 block named DefaultBlock
    #[arg(long)]
    pub gather: bool,
}

/// What reading the text of a shader takes, but for macros: `-D` of `check` denies a lint.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "Reading shaders")]
pub struct TextArgs {
    /// Search DIR for #include files
    #[arg(short = 'I', long = "include", value_name = "DIR")]
    pub include_dirs: Vec<PathBuf>,
    /// Put the text of FILE before that of each shader of its language
    #[arg(long = "prelude", value_name = "FILE")]
    pub preludes: Vec<PathBuf>,
    /// Set a specialization constant or override, by name or number
    #[arg(short = 'O', long = "override", value_name = "NAME=VALUE", value_parser = setting)]
    pub overrides: Vec<(String, String)>,
    /// GLSL stage, if the file name does not tell
    #[arg(long, value_name = "STAGE", value_parser = stage)]
    pub stage: Option<Stage>,
    /// Target API; repeatable. Selects OpenGL or Vulkan rules for GLSL that states neither, and the
    /// limits that `check` enforces
    #[arg(long = "target", value_name = "API")]
    pub targets: Vec<Api>,
    /// Shading language, if the file name does not tell
    #[arg(long, value_name = "LANGUAGE")]
    pub language: Option<Text>,
    /// Path that stands for stdin in messages, and gives its language, stage and include directory
    #[arg(long, value_name = "PATH")]
    pub stdin_filename: Option<PathBuf>,
}

impl TextArgs {
    /// The target APIs, if any is given.
    pub fn given_targets(&self) -> Option<GivenTargets> {
        let targets = GivenTargets {
            dialect: config::dialect(self.targets.iter().filter_map(|api| api.dialect())),
            limits: self.targets.iter().filter_map(|api| api.limits()).collect(),
        };
        (!self.targets.is_empty()).then_some(targets)
    }
}

impl RulesArgs {
    /// The settings for the configuration, with macros.
    pub fn flags(&self, text: &TextArgs, defines: &[(String, String)]) -> Flags {
        Flags {
            defines: defines.to_vec(),
            preludes: text.preludes.clone(),
            include_dirs: text.include_dirs.clone(),
            overrides: text.overrides.clone(),
            targets: text.given_targets(),
            rules: self.rules.as_deref().and_then(Rules::from_name),
            gather: self.gather,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Api {
    /// OpenGL GLSL, no limits
    Opengl,
    /// Vulkan GLSL, limits of Vulkan 1.0
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

/// The structure to lay out instead of the blocks.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct StructArgs {
    /// Lay out this structure, which needs no binding, instead of the blocks
    #[arg(long = "struct", value_name = "NAME", conflicts_with = "block")]
    pub structure: Option<String>,
}

impl Api {
    /// The GLSL dialect that it implies.
    fn dialect(self) -> Option<Target> {
        match self {
            Api::Opengl => Some(Target::OpenGl),
            Api::Vulkan | Api::Gl33 | Api::Gles30 | Api::Webgl2 | Api::Webgpu => {
                self.limits().and_then(Limits::dialect)
            }
        }
    }

    /// The API whose limits apply.
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
    /// GLSL
    Glsl,
    /// WGSL
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
    Rules::OF_TEXT.map(Rules::name).into()
}

/// Parses the name of a stage.
pub fn stage(name: &str) -> Result<Stage, String> {
    Stage::from_name(name)
        .ok_or_else(|| format!("the stages are {}", Stage::names().collect::<Vec<_>>().join(", ")))
}
