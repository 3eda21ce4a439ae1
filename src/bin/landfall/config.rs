//! Reads the configuration for a command, and prints what is wrong with it.

use std::path::PathBuf;

use landfall_check::config::{self, Config, ConfigChoice, ConfigError};
use landfall_check::files::display_path;

use crate::args::ConfigArgs;
use crate::output::{CommandFailure, FindingForm, Streams};
use crate::without_effect;

/// Reads the configuration for these paths.
pub fn load(
    args: &ConfigArgs,
    paths: &[PathBuf],
    streams: &Streams,
) -> Result<Config, CommandFailure> {
    // `--no-config` wins over `--config`.
    let choice = match &args.config {
        _ if args.no_config => ConfigChoice::None,
        Some(file) => ConfigChoice::File(file.clone()),
        None => ConfigChoice::Nearest,
    };
    let config = config::load(&choice, paths).map_err(|error| match error {
        ConfigError::Unreadable(error) => CommandFailure::Error(error),
        ConfigError::Wrong(found, files) => {
            streams.style(FindingForm::Human).failure(&found, &files)
        }
    })?;
    if let Some(file) = &config.file {
        let help = format!("`include` in `{}` names directories", display_path(file));
        without_effect::include_dirs(&config.read.include_dirs, &help, streams);
    }
    Ok(config)
}
