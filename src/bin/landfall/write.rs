//! File writers that do not overwrite the inputs of a command.

use std::path::{Path, PathBuf};

use landfall_check::files;
use landfall_layout::Error;
use landfall_layout::file::FileWriter;
use landfall_layout::source::Files;
#[cfg(feature = "exec")]
use landfall_layout::{Options, Source, layout};

use crate::output::Streams;

/// A writer that does not overwrite these files, shaders or their includes.
pub fn protecting<'a>(
    named: impl IntoIterator<Item = &'a Path>,
    shaders: impl IntoIterator<Item = &'a Files>,
) -> FileWriter {
    let mut writer = files::writer();
    writer.protect(named);
    for files in shaders {
        protect(&mut writer, files);
    }
    writer
}

/// Writes the file of `--out`, and says which directory it made for it.
pub fn to(
    path: &Path,
    bytes: impl AsRef<[u8]>,
    writer: &FileWriter,
    streams: &Streams,
) -> Result<(), Error> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    // Told, because a mistyped path would make a directory without a word.
    let is_new = folder.is_some_and(|folder| folder.symlink_metadata().is_err());
    writer.write(path, bytes)?;
    if let Some(folder) = folder.filter(|_| is_new) {
        streams.notes(&format!("made the directory {}\n", folder.display()));
    }
    Ok(())
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
