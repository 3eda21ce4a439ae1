//! The input files of a run: named files, shaders in directories, and matches of globs, as an
//! iterator.

use std::collections::{BTreeSet, HashSet};
use std::path::{Component, Path, PathBuf};

use landfall_layout::other_language::content;
use landfall_layout::text::glob::Glob;
use landfall_layout::{Error, other_language, source};
use walkdir::DirEntry;

use crate::files::is_stdin;
use crate::stop::StopFlag;
use crate::walk::{self, FilteredWalk, Listing, slashes, without_dot};

/// One shader to read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Input {
    /// Its path; `-` for stdin.
    pub path: PathBuf,
    /// The path of its output below `--out`, without the format's extension.
    pub relative: PathBuf,
    /// Whether it was found in a directory or by a glob, not named.
    pub is_searched: bool,
}

impl Input {
    fn named(path: PathBuf, relative: PathBuf) -> Input {
        Input { path, relative, is_searched: false }
    }
}

/// The files of the arguments in order, those of a directory sorted by name, without duplicates.
pub struct Inputs {
    arguments: std::vec::IntoIter<PathBuf>,
    walk: Option<DirectorySearch>,
    seen: Option<HashSet<PathBuf>>,
    /// What an earlier walk has found.
    listing: Listing,
    stop: StopFlag,
}

/// A directory being searched.
struct DirectorySearch {
    root: PathBuf,
    /// The argument on the command line.
    argument: PathBuf,
    /// The files below the root.
    files: Box<dyn Iterator<Item = Result<PathBuf, Error>> + Send>,
    glob: Option<Glob>,
    found: bool,
    /// The unsupported shading languages of skipped files.
    others: BTreeSet<&'static str>,
}

impl Inputs {
    pub fn new(arguments: Vec<PathBuf>, stop: StopFlag) -> Inputs {
        Inputs::listed(arguments, Listing::default(), stop)
    }

    /// Inputs of which those in listed directories are known.
    pub fn listed(arguments: Vec<PathBuf>, listing: Listing, stop: StopFlag) -> Inputs {
        // A single argument yields no duplicates.
        let seen = (arguments.len() > 1).then(HashSet::new);
        Inputs { arguments: arguments.into_iter(), walk: None, seen, listing, stop }
    }

    fn is_new(&mut self, path: &Path) -> bool {
        let Some(seen) = &mut self.seen else { return true };
        seen.insert(path.components().filter(|c| *c != Component::CurDir).collect())
    }

    fn named(&mut self, argument: PathBuf) -> Option<Result<Input, Error>> {
        if is_stdin(&argument) {
            return Some(Ok(Input::named(argument, PathBuf::from("stdin"))));
        }
        if argument.is_dir() {
            let listed = self.listing.below(&argument);
            self.walk = Some(DirectorySearch::directory(argument, listed));
            return None;
        }
        let is_glob = argument.to_str().is_some_and(|text| text.contains(['*', '?', '[', '{']));
        // A file may have such a name.
        if is_glob && !argument.exists() {
            return match DirectorySearch::glob(&argument) {
                Ok(search) => {
                    self.walk = Some(search);
                    None
                }
                Err(error) => Some(Err(error)),
            };
        }
        let relative = inside(&argument);
        self.is_new(&argument).then_some(Ok(Input::named(argument, relative)))
    }
}

impl Iterator for Inputs {
    type Item = Result<Input, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        while !self.stop.is_set() {
            // A search in progress ends before the next argument is taken.
            if let Some(search) = &mut self.walk {
                match search.next(&self.stop) {
                    Some(Ok(input)) if !self.is_new(&input.path) => continue,
                    Some(found) => return Some(found),
                    None => {
                        let nothing = self.walk.take().and_then(DirectorySearch::found_nothing);
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

impl DirectorySearch {
    fn directory(root: PathBuf, listed: Option<Vec<PathBuf>>) -> DirectorySearch {
        DirectorySearch {
            argument: root.clone(),
            files: match listed {
                Some(files) => Box::new(files.into_iter().map(Ok)),
                None => Box::new(files(FilteredWalk::new(&root))),
            },
            root,
            glob: None,
            found: false,
            others: BTreeSet::new(),
        }
    }

    /// Finds the files that a glob matches, regardless of ignore files.
    fn glob(argument: &Path) -> Result<DirectorySearch, Error> {
        let text = slashes(argument);
        let pattern = text.strip_prefix("./").unwrap_or(&text);
        let refused = |cause| Error::new(text.to_string(), format!("is not a glob: {cause}"));
        let glob = Glob::new(pattern).map_err(refused)?;
        let fixed = argument
            .components()
            // The part before the first wildcard is the directory to walk.
            .take_while(|part| !part.as_os_str().to_string_lossy().contains(['*', '?', '[', '{']));
        let mut root: PathBuf = fixed.collect();
        if root.as_os_str().is_empty() {
            root.push(".");
        }
        let shown = root.clone();
        let walk = walk::sorted(&root).into_iter().filter_entry(|entry| !walk::is_hidden(entry));
        let walk = walk.map(move |entry| entry.map_err(|cause| walk::unsearchable(&shown, &cause)));
        Ok(DirectorySearch {
            root,
            argument: argument.to_path_buf(),
            files: Box::new(files(walk)),
            glob: Some(glob),
            found: false,
            others: BTreeSet::new(),
        })
    }

    fn next(&mut self, stop: &StopFlag) -> Option<Result<Input, Error>> {
        while let Some(path) = self.files.next() {
            if stop.is_set() {
                // An interrupted search has not found that there is nothing.
                self.found = true;
                return None;
            }
            let path = match path {
                Ok(path) => path,
                Err(error) => {
                    // Reported for the directory of the argument.
                    self.found = true;
                    return Some(Err(error));
                }
            };
            if !self.takes(&path) {
                self.others.extend(other_language::of_path(&path));
                self.others.extend(content::usual_language(&path));
                continue;
            }
            self.found = true;
            let relative = match &self.glob {
                Some(_) => inside(&path),
                None => inside(path.strip_prefix(&self.root).unwrap_or(&path)),
            };
            return Some(Ok(Input { path, relative, is_searched: true }));
        }
        None
    }

    /// Whether a file is an input: a shader, or any match of a glob that names the extension.
    fn takes(&self, path: &Path) -> bool {
        let is_shader = || source::is_searched(path) && content::holds_shader(path);
        match &self.glob {
            Some(glob) => {
                glob.matches(&slashes(path)) && (!ends_with_star(&self.argument) || is_shader())
            }
            None => is_shader(),
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
                Error::new(path, message).with_help(
                    "landfall reads GLSL and WGSL; to read a file as one of them, name it and pass \
                     `--language`",
                )
            }
            None => Error::new(path, "contains no shader file").with_help(
                "shaders are recognised by their extension, such as .frag, .glsl or .wgsl; \
                 a file that is named itself is read with any extension",
            ),
        })
    }
}

/// The files of a walk, without `./` at their start.
fn files<W>(walk: W) -> impl Iterator<Item = Result<PathBuf, Error>>
where
    W: Iterator<Item = Result<DirEntry, Error>>,
{
    walk.filter_map(|entry| match entry {
        Ok(entry) if entry.file_type().is_dir() => None,
        Ok(entry) => Some(Ok(without_dot(entry.path()).to_path_buf())),
        Err(error) => Some(Err(error)),
    })
}

fn ends_with_star(glob: &Path) -> bool {
    glob.as_os_str().to_string_lossy().ends_with('*')
}

/// Converts a path to one that stays below the directory it is joined to.
fn inside(path: &Path) -> PathBuf {
    path.components().filter(|part| matches!(part, Component::Normal(_))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Files and ignore files below a directory of its own.
    fn tree(name: &str) -> PathBuf {
        let root =
            std::env::temp_dir().join(format!("landfall-inputs-{}-{name}", std::process::id()));
        for (path, text) in [
            (".ignore", "gone.frag\n/a/b/only-from-root.frag\n"),
            ("a/.ignore", "*.vert\n!kept.vert\n"),
            ("a/b/light.frag", ""),
            ("a/b/only-from-root.frag", ""),
            ("a/b/kept.vert", ""),
            ("a/b/gone.frag", ""),
            ("a/b-2/main.wgsl", ""),
            ("a/b.frag", ""),
            ("a/dropped.vert", ""),
            ("a/effect.hlsl", ""),
            ("a/.hidden/light.frag", ""),
            ("ab/light.frag", ""),
            ("main.rs", ""),
        ] {
            let path = root.join(path);
            std::fs::create_dir_all(path.parent().expect("below the root")).expect("created");
            std::fs::write(path, text).expect("written");
        }
        root
    }

    #[test]
    fn listed_inputs_are_those_of_a_search() {
        let root = tree("listed");
        let listing = || {
            let mut listing = Listing::default();
            FilteredWalk::new(&root).for_each(|entry| listing.add(&entry.expect("readable")));
            listing
        };
        let mut found = Vec::new();
        for folder in ["", "a", "a/b", "a/b-2", "a/.hidden", "ab"] {
            let folder = root.join(folder);
            let searched: Vec<_> = Inputs::new(vec![folder.clone()], StopFlag::default()).collect();
            let listed: Vec<_> =
                Inputs::listed(vec![folder], listing(), StopFlag::default()).collect();
            assert_eq!(listed, searched);
            found.push(searched.len());
        }
        assert_eq!(found, [5, 4, 2, 1, 1, 1]);
        assert_eq!(listing().below(&root.join("a/.hidden")), None, "no walk passed through it");
        std::fs::remove_dir_all(root).expect("removed");
    }
}
