//! Arguments of the commands that are not in this build: accepted and ignored, so that the error can
//! name the missing feature.

use std::ffi::OsString;

/// All arguments after the command's name.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Not in this build; install it with: cargo install landfall --features full"
)]
pub struct MissingArgs {
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    pub rest: Vec<OsString>,
}

#[cfg(not(feature = "completions"))]
pub type CompletionsArgs = MissingArgs;
#[cfg(not(feature = "completions"))]
pub type ManArgs = MissingArgs;
#[cfg(not(feature = "lsp"))]
pub type LspArgs = MissingArgs;
#[cfg(not(feature = "port"))]
pub type PortArgs = MissingArgs;
#[cfg(not(feature = "serve"))]
pub type ServeArgs = MissingArgs;
#[cfg(not(feature = "analysis"))]
pub type LightsArgs = MissingArgs;

#[cfg(not(feature = "exec"))]
pub use of_exec::*;

#[cfg(not(feature = "exec"))]
mod of_exec {
    use super::MissingArgs;

    pub type BenchArgs = MissingArgs;
    pub type DevicesArgs = MissingArgs;
    pub type ProveArgs = MissingArgs;
    pub type RenderArgs = MissingArgs;
    pub type RunArgs = MissingArgs;
    pub type StressArgs = MissingArgs;
    pub type VerifyArgs = MissingArgs;
}
