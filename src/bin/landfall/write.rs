//! File writers that do not overwrite the inputs of a command.

use std::path::{Path, PathBuf};

use landfall_layout::file::FileWriter;
use landfall_layout::source::Files;
#[cfg(feature = "exec")]
use landfall_layout::{Options, Source, layout};

/// A writer that does not overwrite these files, shaders or their includes.
pub fn protecting<'a>(
    named: impl IntoIterator<Item = &'a Path>,
    shaders: impl IntoIterator<Item = &'a Files>,
) -> FileWriter {
    let mut writer = writer();
    writer.protect(named);
    for files in shaders {
        protect(&mut writer, files);
    }
    writer
}

/// A writer that does not overwrite the file that standard input is redirected from.
pub fn writer() -> FileWriter {
    FileWriter::new(["/dev/stdin"])
}

/// Also protects a shader and its includes.
pub fn protect(writer: &mut FileWriter, files: &Files) {
    writer.protect(files.iter().map(|file| PathBuf::from(&file.path)));
}

/// The files of a shader: itself, then its includes.
#[cfg(feature = "exec")]
pub fn files_of(source: &Source, options: &Options) -> Files {
    layout(source, options).files
}
