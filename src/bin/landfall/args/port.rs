//! Arguments of `landfall port`.

use std::path::PathBuf;
use std::time::Duration;

use clap::ValueEnum;
use landfall_layout::shape::DEFAULT_BLOCK;

use super::budget::seconds;
use super::{CodeArgs, setting};

#[derive(Debug, clap::Args)]
pub struct PortArgs {
    /// The shader; - reads stdin
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Target of the rewrite
    #[arg(long, value_name = "TARGET", default_value = "vulkan")]
    pub to: PortTo,
    /// Write to FILE instead of stdout; a failure leaves FILE unchanged
    #[arg(short, long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Do not compile the result with glslangValidator, which happens where it is installed
    #[arg(long)]
    pub no_compiler: bool,
    /// Processor time limit of glslangValidator, in seconds; past it the result is written with a
    /// warning
    #[arg(long, value_name = "SECONDS", default_value = "20", value_parser = seconds)]
    pub limit: Duration,
    /// Shader of the stage before or after; locations are matched, and what both share has one
    /// binding
    #[arg(help_heading = "Locations and bindings", long, value_name = "FILE")]
    pub partner: Option<PathBuf>,
    /// Location of an input or output
    #[arg(
        help_heading = "Locations and bindings", long = "location", value_name = "NAME=N",
        value_parser = location
    )]
    pub locations: Vec<(String, u32)>,
    /// Name of the block that gathers loose uniforms
    #[arg(
        help_heading = "Locations and bindings", long, value_name = "NAME",
        default_value = DEFAULT_BLOCK
    )]
    pub block: String,
    /// Descriptor set of resources without one
    #[arg(help_heading = "Locations and bindings", long, value_name = "N", default_value_t = 0)]
    pub set: u32,
    /// First binding to assign
    #[arg(help_heading = "Locations and bindings", long, value_name = "N", default_value_t = 0)]
    pub first_binding: u32,
    #[command(flatten)]
    pub read: CodeArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PortTo {
    /// Vulkan GLSL 4.50
    Vulkan,
    /// GLSL 4.50 for naga and wgpu, with textures and samplers separated
    Naga,
    /// WGSL, if its layout rules keep every offset
    Wgsl,
}

/// Parses `NAME=N`.
fn location(text: &str) -> Result<(String, u32), String> {
    let (name, number) = setting(text)?;
    let number = number.parse().map_err(|_| "a location is a whole number".to_string())?;
    Ok((name, number))
}
