//! Arguments of `landfall completions` and `landfall man`.

use std::path::PathBuf;

use clap_complete::Shell;

#[derive(Debug, clap::Args)]
pub struct CompletionsArgs {
    /// The shell that reads the script
    pub shell: Shell,
}

#[derive(Debug, clap::Args)]
pub struct ManArgs {
    /// Directory of the pages: landfall.1, landfall-check.1 and so on
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
}
