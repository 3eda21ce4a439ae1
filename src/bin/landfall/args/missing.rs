//! Arguments of the commands that run shaders, in a build without them: taken, so that the
//! command can say which feature brings it.

use std::ffi::OsString;

/// Whatever follows the command.
#[derive(Debug, clap::Args)]
#[command(after_help = "Not in this build: cargo install landfall --features full")]
pub struct MissingArgs {
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    pub rest: Vec<OsString>,
}

pub type BenchArgs = MissingArgs;
pub type DevicesArgs = MissingArgs;
pub type RenderArgs = MissingArgs;
pub type RunArgs = MissingArgs;
pub type StressArgs = MissingArgs;
pub type VerifyArgs = MissingArgs;
