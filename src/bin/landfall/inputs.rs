//! The input files of a run: named files, shaders in directories, and matches of globs, as an
//! iterator.

use std::collections::{BTreeSet, HashSet};
use std::path::{Component, Path, PathBuf};

use globset::{GlobBuilder, GlobMatcher};
use ignore::{DirEntry, WalkBuilder};
use landfall_layout::{Error, other_language, source};

use crate::read::is_stdin;
use crate::walk::FilteredWalk;
use crate::watch;

/// One shader to read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Input {
    /// Its path; `-` for stdin.
    pub path: PathBuf,
    /// The path of its output below `--out`, without the format's extension.
    pub relative: PathBuf,
}

/// The files of the arguments in order, those of a directory sorted by name, without duplicates.
pub struct Inputs {
    arguments: std::vec::IntoIter<PathBuf>,
    walk: Option<Search>,
    seen: Option<HashSet<PathBuf>>,
}

/// A directory being searched.
struct Search {
    root: PathBuf,
    /// The argument on the command line.
    argument: PathBuf,
    walk: Box<dyn Iterator<Item = Result<DirEntry, Error>> + Send>,
    glob: Option<GlobMatcher>,
    found: bool,
    /// The unsupported shading languages of skipped files.
    others: BTreeSet<&'static str>,
}

impl Inputs {
    pub fn new(arguments: Vec<PathBuf>) -> Inputs {
        // A single argument yields no duplicates.
        let seen = (arguments.len() > 1).then(HashSet::new);
        Inputs { arguments: arguments.into_iter(), walk: None, seen }
    }

    fn is_new(&mut self, path: &Path) -> bool {
        let Some(seen) = &mut self.seen else { return true };
        seen.insert(path.components().filter(|c| *c != Component::CurDir).collect())
    }

    fn named(&mut self, argument: PathBuf) -> Option<Result<Input, Error>> {
        if is_stdin(&argument) {
            return Some(Ok(Input { path: argument, relative: PathBuf::from("stdin") }));
        }
        if argument.is_dir() {
            self.walk = Some(Search::directory(argument));
            return None;
        }
        let is_glob = argument.to_str().is_some_and(|text| text.contains(['*', '?', '[', '{']));
        if is_glob && !argument.exists() {
            return match Search::glob(&argument) {
                Ok(search) => {
                    self.walk = Some(search);
                    None
                }
                Err(error) => Some(Err(error)),
            };
        }
        let relative = inside(&argument);
        self.is_new(&argument).then_some(Ok(Input { path: argument, relative }))
    }
}

impl Iterator for Inputs {
    type Item = Result<Input, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        // After Ctrl-C there are no further inputs.
        while !watch::is_stopped() {
            if let Some(search) = &mut self.walk {
                match search.next() {
                    Some(Ok(input)) if !self.is_new(&input.path) => continue,
                    Some(found) => return Some(found),
                    None => {
                        let nothing = self.walk.take().and_then(Search::found_nothing);
                        if nothing.is_some() {
                            return nothing.map(Err);
                        }
                    }
                }
            }
            let argument = self.arguments.next()?;
            if let Some(input) = self.named(argument) {
                return Some(input);
            }
        }
        None
    }
}

impl Search {
    fn directory(root: PathBuf) -> Search {
        let walk = Box::new(FilteredWalk::new(&root));
        Search {
            argument: root.clone(),
            root,
            walk,
            glob: None,
            found: false,
            others: BTreeSet::new(),
        }
    }

    /// Expands a glob as a shell does, regardless of ignore files.
    fn glob(argument: &Path) -> Result<Search, Error> {
        let text = argument.to_string_lossy();
        let refused = |cause: globset::Error| {
            Error::new(text.to_string(), format!("is not a glob: {}", cause.kind()))
        };
        let pattern = text.strip_prefix("./").unwrap_or(&text);
        if let Some(cause) = too_deep(pattern) {
            return Err(Error::new(text.to_string(), format!("is not a glob: {cause}")));
        }
        let glob = GlobBuilder::new(pattern).literal_separator(true).build().map_err(refused)?;
        let matcher = glob.compile_matcher();
        let fixed = argument
            .components()
            .take_while(|part| !part.as_os_str().to_string_lossy().contains(['*', '?', '[', '{']));
        let mut root: PathBuf = fixed.collect();
        if root.as_os_str().is_empty() {
            root.push(".");
        }
        let walk = WalkBuilder::new(&root)
            .standard_filters(false)
            .hidden(true)
            .sort_by_file_name(|a, b| a.cmp(b))
            .build();
        let shown = root.display().to_string();
        let walk = Box::new(walk.map(move |entry| {
            entry.map_err(|cause| Error::new(&shown, format!("cannot be searched: {cause}")))
        }));
        Ok(Search {
            root,
            argument: argument.to_path_buf(),
            walk,
            glob: Some(matcher),
            found: false,
            others: BTreeSet::new(),
        })
    }

    fn next(&mut self) -> Option<Result<Input, Error>> {
        while let Some(entry) = self.walk.next() {
            let entry = match entry {
                Ok(entry) => entry,
                Err(error) => {
                    // Reported for the directory of the argument.
                    self.found = true;
                    return Some(Err(error));
                }
            };
            if entry.file_type().is_none_or(|kind| kind.is_dir()) {
                continue;
            }
            let path = entry.into_path();
            let path = path.strip_prefix("./").map(Path::to_path_buf).unwrap_or(path);
            if !self.takes(&path) {
                self.others.extend(other_language::of_path(&path));
                continue;
            }
            self.found = true;
            let relative = match &self.glob {
                Some(_) => inside(&path),
                None => inside(path.strip_prefix(&self.root).unwrap_or(&path)),
            };
            return Some(Ok(Input { path, relative }));
        }
        None
    }

    /// Whether a file is an input: a shader, or any match of a glob that names the extension.
    fn takes(&self, path: &Path) -> bool {
        let known = source::kind_of_path(path).is_some();
        match &self.glob {
            Some(glob) => glob.is_match(path) && (known || !ends_with_star(&self.argument)),
            None => known,
        }
    }

    fn found_nothing(self) -> Option<Error> {
        if self.found {
            return None;
        }
        let path = self.argument.display().to_string();
        Some(match self.glob {
            Some(_) => Error::new(path, "matches no shader file"),
            None if !self.others.is_empty() => {
                let languages: Vec<&str> = self.others.into_iter().collect();
                let message =
                    format!("contains no GLSL or WGSL shader, only {}", languages.join(", "));
                Error::new(path, message).with_help("landfall reads GLSL and WGSL")
            }
            None => Error::new(path, "contains no shader file").with_help(
                "shaders are recognised by their extension, such as .frag, .glsl or .wgsl; \
                 a file that is named itself is read with any extension",
            ),
        })
    }
}

/// Maximum nesting of braces in a glob.
const DEEPEST_BRACES: usize = 16;

/// Maximum length of a glob in bytes.
const LONGEST_GLOB: usize = 4096;

/// The reason to refuse a glob that would exhaust the compiler of globs.
pub fn too_deep(glob: &str) -> Option<String> {
    if glob.len() > LONGEST_GLOB {
        return Some(format!("it has more than {LONGEST_GLOB} bytes"));
    }
    let mut depth = 0usize;
    for byte in glob.bytes() {
        match byte {
            b'{' => depth += 1,
            b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth > DEEPEST_BRACES {
            return Some(format!("its braces nest more than {DEEPEST_BRACES} deep"));
        }
    }
    None
}

fn ends_with_star(glob: &Path) -> bool {
    glob.as_os_str().to_string_lossy().ends_with('*')
}

/// Converts a path to one that stays below the directory it is joined to.
fn inside(path: &Path) -> PathBuf {
    path.components().filter(|part| matches!(part, Component::Normal(_))).collect()
}
