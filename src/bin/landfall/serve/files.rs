//! The named files of `serve`, read again when they change.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use landfall_layout::{Error, Options, ReadOptions, layout, source};
use landfall_layout::{Source, other_language};
use serde::Serialize;

use crate::args::ServeArgs;

/// The named files.
pub struct Files {
    options: Options,
    /// Raised by every change.
    version: u64,
    files: Vec<Opened>,
}

/// A named file.
#[derive(Serialize)]
struct Opened {
    path: String,
    text: String,
    /// Its includes: paths and texts.
    includes: Vec<(String, String)>,
    /// Why it could not be read.
    error: Option<String>,
    #[serde(skip)]
    stamps: Vec<Stamp>,
}

/// A file as it was when it was read.
#[derive(PartialEq)]
struct Stamp {
    path: PathBuf,
    state: Option<(SystemTime, u64)>,
}

impl Stamp {
    fn of(path: &Path) -> Stamp {
        let found = std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file);
        let state = found.and_then(|found| Some((found.modified().ok()?, found.len())));
        Stamp { path: path.to_path_buf(), state }
    }
}

impl Files {
    /// Reads the named files.
    ///
    /// # Errors
    ///
    /// One cannot be read.
    pub fn open(args: &ServeArgs) -> Result<Files, Error> {
        let mut read = ReadOptions::default();
        read.defines.clone_from(&args.defines);
        read.include_dirs.clone_from(&args.include_dirs);
        let options = Options::default().with_read(read);
        let open = |path: &PathBuf| {
            other_language::refuse(path)?;
            read_file(path, &options)
        };
        let files = args.files.iter().map(open).collect::<Result<_, Error>>()?;
        Ok(Files { options, version: 1, files })
    }

    /// The paths of the named files.
    pub fn paths(&self) -> Vec<String> {
        self.files.iter().map(|file| file.path.clone()).collect()
    }

    /// The files as JSON; without them if `since=VERSION` names this state.
    pub fn json(&mut self, query: Option<&str>) -> String {
        self.read_again();
        let known = query.and_then(|query| query.strip_prefix("since=")?.parse().ok());
        let files = match known == Some(self.version) {
            true => "[]".to_string(),
            false => serde_json::to_string(&self.files).expect("keys are strings"),
        };
        format!("{{\"version\":{},\"files\":{files}}}", self.version)
    }

    /// Reads the files that have changed.
    fn read_again(&mut self) {
        for file in &mut self.files {
            if file.stamps.iter().all(|stamp| Stamp::of(&stamp.path) == *stamp) {
                continue;
            }
            self.version += 1;
            match read_file(Path::new(&file.path), &self.options) {
                Ok(read) => *file = read,
                Err(error) => {
                    // The page keeps the text it has.
                    file.error = Some(format!("{} {}", error.path, error.message));
                    file.stamps = vec![Stamp::of(Path::new(&file.path))];
                }
            }
        }
    }
}

fn read_file(path: &Path, options: &Options) -> Result<Opened, Error> {
    // Before it is read: a change in between is seen at the next look.
    let mut stamps = vec![Stamp::of(path)];
    let shown = path.display().to_string();
    let read = Source::from_bytes(shown.as_str(), source::read_bytes(path, None)?)?;
    let shader = layout(&read, options);
    let included = shader.files.iter().skip(1).filter(|file| !file.path.starts_with("-D "));
    let mut includes = Vec::new();
    for file in included {
        stamps.push(Stamp::of(Path::new(&file.path)));
        includes.push((file.path.clone(), file.text.to_string()));
    }
    Ok(Opened { path: shown, text: read.text.to_string(), includes, error: None, stamps })
}
