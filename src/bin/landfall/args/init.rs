//! Arguments of `init`.

use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct InitArgs {
    /// Directory of the project
    #[arg(value_name = "DIR", default_value = ".")]
    pub dir: PathBuf,
    /// Print the configuration instead of writing it
    #[arg(long)]
    pub print: bool,
}
