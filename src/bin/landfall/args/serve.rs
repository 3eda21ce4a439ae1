//! Arguments of `serve`.

use std::path::PathBuf;

use super::define;

#[derive(Debug, clap::Args)]
pub struct ServeArgs {
    /// Shaders and scenes (.json) to open and to watch, with what they include or name; no other file
    /// is served [default: an example]
    #[arg(value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Port on the loopback interface; 0 takes a free one
    #[arg(short, long, value_name = "N", default_value_t = 0)]
    pub port: u16,
    /// Search DIR for #include files
    #[arg(short = 'I', long = "include", value_name = "DIR")]
    pub include_dirs: Vec<PathBuf>,
    /// Define a macro, which the page can change [default value: 1]
    #[arg(short = 'D', long = "define", value_name = "NAME[=TEXT]", value_parser = define)]
    pub defines: Vec<(String, String)>,
}
