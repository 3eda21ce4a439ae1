//! The files that a build script writes.

use std::path::PathBuf;

use super::BuildError;
use crate::{CodeOptions, CodeOutput, OutputLanguage};
use landfall_layout::ShaderLayout;
use landfall_layout::error::Error;

#[derive(Clone, Debug)]
pub(super) struct OutputFile {
    pub language: OutputLanguage,
    pub place: OutputBase,
    pub file: PathBuf,
    /// What is written: mirrors or assertions.
    pub generate: fn(&OutputLanguage, &[&ShaderLayout], &CodeOptions) -> CodeOutput,
}

impl OutputFile {
    pub fn mirrors(
        language: OutputLanguage,
        place: OutputBase,
        file: impl Into<PathBuf>,
    ) -> OutputFile {
        OutputFile { language, place, file: file.into(), generate: OutputLanguage::generate }
    }

    /// Its path, if the directory is known.
    pub fn path(&self) -> Result<PathBuf, BuildError> {
        let variable = match self.place {
            OutputBase::OutDir => "OUT_DIR",
            OutputBase::Package => "CARGO_MANIFEST_DIR",
        };
        match std::env::var_os(variable) {
            Some(dir) => Ok(PathBuf::from(dir).join(&self.file)),
            None => {
                let message = format!("has no directory to be written to: `{variable}` is not set");
                let error = Error::new(self.file.display().to_string(), message);
                Err(error
                    .with_help("call `run` from a build script, or use `generate_string`")
                    .into())
            }
        }
    }
}

/// The directory that an output path is relative to.
#[derive(Clone, Copy, Debug)]
pub(super) enum OutputBase {
    /// Cargo's `OUT_DIR`.
    OutDir,
    /// The package directory, for files that are checked in.
    Package,
}
