//! Reads the configuration for a command, and prints what is wrong with it.

use std::path::PathBuf;

use landfall_check::config::{self, Config, ConfigChoice, ConfigError};
use landfall_check::files::display_path;

use crate::args::ConfigArgs;
use crate::output::{Failure, FindingForm, Streams};
use crate::without_effect;

/// Reads the configuration for these paths; `None` if it has errors, which are reported.
pub fn load(
    args: &ConfigArgs,
    paths: &[PathBuf],
    streams: &Streams,
) -> Result<Option<Config>, Failure> {
    // `--no-config` wins over `--config`.
    let choice = match &args.config {
        _ if args.no_config => ConfigChoice::None,
        Some(file) => ConfigChoice::File(file.clone()),
        None => ConfigChoice::Nearest,
    };
    match config::load(&choice, paths) {
        Ok(config) => {
            if let Some(file) = &config.file {
                let help = format!("`include` in `{}` names directories", display_path(file));
                without_effect::include_dirs(&config.read.include_dirs, &help, streams);
            }
            Ok(Some(config))
        }
        Err(ConfigError::Unreadable(error)) => Err(error),
        Err(ConfigError::Wrong(found, files)) => {
            streams.report(&streams.style(FindingForm::Human).text(&found, &files));
            Ok(None)
        }
    }
}
