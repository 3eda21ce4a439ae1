//! Where the file of a module stands: beside the importing file, in its package, in another package
//! of the tree, or in a dependency of Cargo.

use std::path::{Path, PathBuf};

use rustc_hash::FxHashMap;

use crate::source::ReadOptions;
use crate::source::file_cache::FoundFile;
use crate::syntax::{above, listed};

/// The limit on files that are searched for the paths of naga_oil.
const MAX_INDEXED: usize = 20_000;

/// The limit on crates of a family that are searched for a path of naga_oil.
const MAX_RELATIVES: usize = 64;

const EXTENSIONS: [&str; 2] = ["wesl", "wgsl"];

// Compilers of WESL and engines each look elsewhere for modules, and no file says which is in use.
// So the likely places are tried in order, and the first that has the file counts.
pub(super) struct Packages<'o> {
    options: &'o ReadOptions,
    /// The files of a folder and those below by their `#define_import_path`.
    indexed: FxHashMap<PathBuf, FxHashMap<String, Vec<PathBuf>>>,
}

impl<'o> Packages<'o> {
    pub(super) fn new(options: &'o ReadOptions) -> Packages<'o> {
        Packages { options, indexed: FxHashMap::default() }
    }

    /// Returns the file that is included as text by a name, and where it was looked for.
    pub(super) fn text(&self, from: &Path, name: &str) -> FoundFile {
        self.options.found("text", from, name, || self.sought_text(from, name))
    }

    fn sought_text(&self, from: &Path, name: &str) -> FoundFile {
        let beside = from.parent().unwrap_or(Path::new("")).to_path_buf();
        let relative = name.trim_start_matches('/');
        let with_extension = |folder: &Path| {
            let place = folder.join(relative);
            match place.extension() {
                Some(_) => place,
                None => folder.join(format!("{relative}.wgsl")),
            }
        };
        let folders = std::iter::once(&beside).chain(&self.options.include_dirs);
        let mut places: Vec<PathBuf> = folders.map(|folder| with_extension(folder)).collect();
        // A name without a folder may be in one beside, as `shared/config.wgsl`; a path may start at
        // any folder above.
        if relative.contains('/') {
            places.extend(above(&beside).skip(1).map(|folder| with_extension(&folder)));
        } else if self.options.files.is_none() {
            let parent = beside.parent().map(Path::to_path_buf);
            for folder in std::iter::once(beside).chain(parent) {
                places.extend(folders_in(&folder).iter().map(|folder| with_extension(folder)));
            }
        }
        let found = places.iter().find(|place| self.options.is_file(place)).cloned();
        (places, found)
    }

    /// Returns the file of a module of WESL in the first of these folders that has it, and where it
    /// was looked for.
    // root / a / b / c .wesl, then .wgsl, for the path a::b::c
    pub(super) fn module(
        &self,
        roots: &[PathBuf],
        path: &[String],
    ) -> (Vec<PathBuf>, Option<PathBuf>) {
        let stems = roots.iter().flat_map(|root| match path {
            // The root module of the package.
            [] => vec![root.join("package"), root.clone()],
            _ => vec![path.iter().fold(root.clone(), |folder, part| folder.join(part))],
        });
        let places: Vec<PathBuf> = stems
            .flat_map(|stem| EXTENSIONS.map(|extension| stem.with_extension(extension)))
            .collect();
        let found = places.iter().find(|place| self.options.is_file(place)).cloned();
        (places, found)
    }

    /// Returns the files that state the path of a module of naga_oil; those of one package.
    pub(super) fn named(&mut self, from: &Path, path: &str) -> Vec<PathBuf> {
        let options = self.options;
        options.found("path", from, path, || (self.sought_path(from, path), None)).0
    }

    // naga_oil's paths are stated in the files (`#define_import_path`), not given by folders: the
    // files of the project, of `-I`, of the named package and at last of its relatives are indexed,
    // each root once.
    fn sought_path(&mut self, from: &Path, path: &str) -> Vec<PathBuf> {
        let package = path.split("::").next().unwrap_or("").to_string();
        let mut roots = vec![project(from)];
        roots.extend(self.options.include_dirs.iter().cloned());
        roots.extend(self.packages(from, &package));
        let found = roots.iter().find_map(|root| self.index(root).get(path).cloned());
        found.unwrap_or_else(|| {
            let roots = self.relatives(from, &package);
            roots.iter().find_map(|root| self.index(root).get(path).cloned()).unwrap_or_default()
        })
    }

    /// Returns the crates of a family, those whose names begin with the same word: a path may be
    /// stated in another one than the one it names.
    fn relatives(&self, from: &Path, package: &str) -> Vec<PathBuf> {
        if self.options.files.is_some() {
            return Vec::new();
        }
        let family = package.split(['_', '-']).next().unwrap_or(package);
        let is_relative = |name: &str| {
            let rest = name.strip_prefix(family);
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['_', '-']))
        };
        let name_of = |path: &PathBuf| Some(path.file_name()?.to_str()?.to_string());
        let mut roots = Vec::new();
        for folder in above(from) {
            if name_of(&folder).is_some_and(|name| version_of(&name).is_some()) {
                let beside = folder.parent().map(folders_in).unwrap_or_default().into_iter();
                let beside = beside.filter(|path| name_of(path).is_some_and(|n| is_relative(&n)));
                // The newest first.
                roots.extend(beside.rev());
            }
            let relatives = locked(&folder).into_iter().filter(|(name, _)| is_relative(name));
            roots.extend(relatives.flat_map(in_registries).filter(|root| root.is_dir()));
        }
        roots.truncate(MAX_RELATIVES);
        roots
    }

    // Every file of a root is read once, for all paths that are looked for in it.
    fn index(&mut self, root: &Path) -> &FxHashMap<String, Vec<PathBuf>> {
        let options = self.options;
        self.indexed.entry(root.to_path_buf()).or_insert_with(|| {
            let mut found: FxHashMap<String, Vec<PathBuf>> = FxHashMap::default();
            let mut add = |path: PathBuf, text: &str| {
                let define = |line: &str| {
                    let name = line.trim_start().strip_prefix("#define_import_path")?;
                    Some(name.trim().trim_end_matches(';').to_string())
                };
                if let Some(name) = text.lines().find_map(define) {
                    found.entry(name).or_default().push(path);
                }
            };
            match &options.files {
                Some(files) => {
                    files.iter().for_each(|(path, text)| add(PathBuf::from(path), text));
                }
                None => {
                    for path in wgsl_files(root) {
                        if let Ok(text) = std::fs::read_to_string(&path) {
                            add(path, &text);
                        }
                    }
                }
            }
            found
        })
    }

    /// Returns the folders that `package::` of a file may stand for, the likeliest first.
    pub(super) fn own(&self, from: &Path) -> Vec<PathBuf> {
        let mut roots = Vec::new();
        for folder in above(from.parent().unwrap_or(Path::new(""))) {
            if let Some(root) = root_of_wesl(&folder) {
                roots.push(root);
            }
            let sources = folder.join("src");
            if from.starts_with(&sources) && folder.join("Cargo.toml").is_file() {
                roots.push(sources);
            }
        }
        // Where nothing says so, any folder above the file.
        roots.extend(above(from.parent().unwrap_or(Path::new(""))));
        roots
    }

    /// Returns the folders that another package's modules may be in.
    // A folder of the package's name in `-I`, in any folder above, in their `crates` and
    // `node_modules`; then the registry of Cargo, by the version that `Cargo.lock` has.
    pub(super) fn packages(&self, from: &Path, name: &str) -> Vec<PathBuf> {
        let names = [name.to_string(), name.replace('_', "-")];
        let mut roots = Vec::new();
        let in_memory = self.options.files.is_some();
        let mut add = |folder: PathBuf| {
            for root in [root_of_wesl(&folder), Some(folder.join("src")), Some(folder)] {
                roots.extend(root.filter(|root| in_memory || root.is_dir()));
            }
        };
        let folders = self.options.include_dirs.iter().cloned();
        let folders: Vec<PathBuf> = folders.chain(above(from)).collect();
        for name in &names {
            for folder in &folders {
                add(folder.join(name));
                add(folder.join("crates").join(name));
                add(folder.join("node_modules").join(name));
            }
        }
        for folder in &folders {
            let locked = locked(folder);
            for name in &names {
                // A crate of the registry beside those that depend on it.
                let package = folder.file_name().and_then(|name| name.to_str());
                if package.is_some_and(|package| version_of(package).is_some()) {
                    let beside = folder.parent().map(folders_in).unwrap_or_default();
                    newest(beside, name).into_iter().for_each(&mut add);
                }
                let known = locked.iter().find(|(other, _)| other == name);
                known.cloned().map(in_registries).into_iter().flatten().for_each(&mut add);
            }
        }
        roots
    }
}

/// The folder whose modules are searched by name: the package's, or the file's own.
// The outermost folder with `Cargo.toml` or `.git`: a workspace rather than one of its crates.
fn project(from: &Path) -> PathBuf {
    let folder = from.parent().unwrap_or(Path::new("")).to_path_buf();
    let is_project =
        |folder: &PathBuf| folder.join("Cargo.toml").is_file() || folder.join(".git").exists();
    above(&folder).filter(is_project).last().unwrap_or(folder)
}

/// The folders in a folder, in the order of their names.
fn folders_in(folder: &Path) -> Vec<PathBuf> {
    listed(folder).into_iter().filter(|path| path.is_dir()).collect()
}

/// The WGSL files in a folder and below, without those that tools write.
fn wgsl_files(root: &Path) -> Vec<PathBuf> {
    let (mut files, mut open) = (Vec::new(), vec![root.to_path_buf()]);
    while let Some(folder) = open.pop() {
        let here = if folder.as_os_str().is_empty() { Path::new(".") } else { &folder };
        let entries = std::fs::read_dir(here).into_iter().flatten().flatten();
        for entry in entries {
            let (name, path) = (entry.file_name(), folder.join(entry.file_name()));
            let is_hidden = name.to_str().is_none_or(|name| name.starts_with('.'));
            let Ok(kind) = entry.file_type() else { continue };
            if kind.is_dir() && !is_hidden && name != "target" && name != "node_modules" {
                open.push(path);
            } else if kind.is_file() && path.extension().is_some_and(|e| e == "wgsl") {
                files.push(path);
            }
        }
        // Where no folder of a project is found, the root may be any folder, as large as the disk.
        if files.len() + open.len() > MAX_INDEXED {
            break;
        }
    }
    files.sort();
    files
}

/// The folder of a package's modules by its `wesl.toml`.
fn root_of_wesl(folder: &Path) -> Option<PathBuf> {
    let text = std::fs::read_to_string(folder.join("wesl.toml")).ok()?;
    let root = text.lines().find_map(|line| {
        let (key, value) = line.split_once('=')?;
        (key.trim() == "root").then(|| value.trim().trim_matches(['"', '\'']).to_string())
    });
    Some(folder.join(root.as_deref().unwrap_or("shaders").trim_start_matches("./")))
}

/// The version in the name of a crate's folder: `name-1.2.3`.
fn version_of(folder: &str) -> Option<&str> {
    let (_, version) = folder.rsplit_once('-')?;
    version.starts_with(|c: char| c.is_ascii_digit()).then_some(version)
}

/// The crate of the highest version among folders.
fn newest(folders: Vec<PathBuf>, name: &str) -> Option<PathBuf> {
    let version = |path: &PathBuf| {
        let folder = path.file_name()?.to_str()?;
        let version = folder.strip_prefix(name)?.strip_prefix('-')?;
        let parts: Vec<u64> =
            version.split(['.', '-']).map_while(|part| part.parse().ok()).collect();
        version.starts_with(|c: char| c.is_ascii_digit()).then_some(parts)
    };
    folders.into_iter().filter_map(|path| Some((version(&path)?, path))).max().map(|(_, path)| path)
}

/// The packages that Cargo has locked in a folder, with their versions.
// Read as lines: `name` and `version` follow each other in each package of the file.
fn locked(folder: &Path) -> Vec<(String, String)> {
    let text = std::fs::read_to_string(folder.join("Cargo.lock")).unwrap_or_default();
    let package = |(name, version)| Some((quoted(name, "name")?, quoted(version, "version")?));
    text.lines().zip(text.lines().skip(1)).filter_map(package).collect()
}

/// Where the registries of Cargo have a package.
fn in_registries((name, version): (String, String)) -> impl Iterator<Item = PathBuf> {
    let registries = folders_in(&cargo_home().join("registry/src")).into_iter();
    registries.map(move |registry| registry.join(format!("{name}-{version}")))
}

/// The text of a line `key = "text"`.
fn quoted(line: &str, key: &str) -> Option<String> {
    let value = line.strip_prefix(key)?.trim_start().strip_prefix('=')?;
    Some(value.trim().trim_matches('"').to_string())
}

fn cargo_home() -> PathBuf {
    let home = || std::env::var_os("HOME").map(|home| Path::new(&home).join(".cargo"));
    std::env::var_os("CARGO_HOME").map(PathBuf::from).or_else(home).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_compared_by_their_numbers() {
        let folders = ["bevy_pbr-0.9.1", "bevy_pbr-0.19.0", "bevy_pbr_macros-1.0.0", "bevy_pbr"];
        let folders = folders.map(PathBuf::from).to_vec();
        assert_eq!(newest(folders, "bevy_pbr"), Some(PathBuf::from("bevy_pbr-0.19.0")));
    }
}
