//! Writers that leave the inputs of a command alone.

use std::path::{Path, PathBuf};

use landfall_layout::file::FileWriter;
use landfall_layout::source::Files;
#[cfg(feature = "exec")]
use landfall_layout::{Options, Source, layout};

/// A writer that leaves these files alone, and those that shaders are made of.
pub fn protecting<'a>(
    named: impl IntoIterator<Item = &'a Path>,
    shaders: impl IntoIterator<Item = &'a Files>,
) -> FileWriter {
    let mut writer = FileWriter::new(named);
    for files in shaders {
        protect(&mut writer, files);
    }
    writer
}

/// Leaves the files that a shader is made of alone, too.
pub fn protect(writer: &mut FileWriter, files: &Files) {
    writer.protect(files.iter().map(|file| PathBuf::from(&file.path)));
}

/// The files that a shader is made of: itself, then what it includes.
#[cfg(feature = "exec")]
pub fn files_of(source: &Source, options: &Options) -> Files {
    layout(source, options).files
}
