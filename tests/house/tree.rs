//! The modules of each crate, and which module a path leads to.

use std::collections::{BTreeMap, BTreeSet};

use crate::imports::{Import, imports};
use crate::token::{tokens, without_tests};

/// A file by its path from the root of the repository.
#[derive(Clone, Debug)]
pub struct File {
    pub path: String,
    pub text: String,
}

/// A path inside a crate: `["harness", "probe"]`.
pub type Path = Vec<String>;

/// All crates. The command, `src/bin/landfall/`, counts as one of its own, named `command`.
#[derive(Debug, Default)]
pub struct Tree {
    pub units: BTreeMap<String, Unit>,
    /// For each manifest, the crates of the workspace it depends on.
    pub manifests: BTreeMap<String, BTreeSet<String>>,
}

/// A crate.
#[derive(Debug, Default)]
pub struct Unit {
    pub modules: BTreeMap<Path, Module>,
}

/// A module with a file of its own.
#[derive(Debug, Default)]
pub struct Module {
    pub file: String,
    imports: Vec<Import>,
    /// Names that its `use` declarations bring in, by the paths they stand for.
    names: BTreeMap<String, Path>,
    /// Modules whose names are all brought in.
    globs: Vec<Path>,
    /// Names of the items it defines.
    items: BTreeSet<String>,
}

/// An import of one module by another of the same crate.
#[derive(Debug)]
pub struct Use {
    pub from: Path,
    pub to: Path,
    /// File and line.
    pub place: String,
}

impl Tree {
    pub fn new(files: &[File]) -> Tree {
        let mut tree = Tree::default();
        let mut tests: Vec<(String, Path)> = Vec::new();
        for file in files {
            if let Some(package) = package_of_manifest(&file.path) {
                tree.manifests.insert(package, dependencies(&file.text));
            } else if let Some((unit, path)) = module_path(&file.path) {
                let (module, under_test) = module(file, &path);
                let below = under_test.into_iter().map(|name| {
                    let mut path = path.clone();
                    path.push(name);
                    (unit.clone(), path)
                });
                tests.extend(below);
                tree.units.entry(unit).or_default().modules.insert(path, module);
            }
        }
        for (unit, test) in tests {
            if let Some(unit) = tree.units.get_mut(&unit) {
                unit.modules.retain(|path, _| !path.starts_with(&test));
            }
        }
        tree
    }
}

impl Unit {
    /// The other crates of the workspace that it names, each with a place.
    pub fn crates(&self) -> BTreeMap<String, String> {
        let mut found = BTreeMap::new();
        for module in self.modules.values() {
            for import in &module.imports {
                let first = &import.path[0];
                if first == "landfall" || first.starts_with("landfall_") {
                    let place = format!("{}:{}", module.file, import.line);
                    found.entry(first.replace('_', "-")).or_insert(place);
                }
            }
        }
        found
    }

    /// The imports between its modules.
    pub fn uses(&self) -> Vec<Use> {
        let mut found = Vec::new();
        for (from, module) in &self.modules {
            for import in &module.imports {
                let is_rooted = matches!(import.path[0].as_str(), "crate" | "super" | "self");
                if !is_rooted {
                    continue;
                }
                let Some(path) = absolute(from, &import.path) else { continue };
                let to = self.resolve(&path, 0);
                let place = format!("{}:{}", module.file, import.line);
                found.push(Use { from: from.clone(), to, place });
            }
        }
        found
    }

    /// The module that an absolute path ends in, through names that other modules bring in.
    fn resolve(&self, path: &[String], depth: usize) -> Path {
        let mut at: Path = Vec::new();
        for (i, segment) in path.iter().enumerate() {
            at.push(segment.clone());
            if self.modules.contains_key(&at) {
                continue;
            }
            at.pop();
            let Some(module) = self.modules.get(&at) else { return at };
            if depth > 8 {
                return at;
            }
            let named = module.names.get(segment).cloned();
            if named.is_none() && module.items.contains(segment) {
                return at;
            }
            let target = named.or_else(|| {
                let is_there = |glob: &&Path| {
                    let other = self.resolve(glob, depth + 1);
                    self.modules.get(&other).is_some_and(|other| other.items.contains(segment))
                };
                let mut target = module.globs.iter().find(is_there)?.clone();
                target.push(segment.clone());
                Some(target)
            });
            return match target {
                Some(mut target) if target != path => {
                    target.extend_from_slice(&path[i + 1..]);
                    self.resolve(&target, depth + 1)
                }
                _ => at,
            };
        }
        at
    }
}

/// A path from the root of the crate; `None` for one that leads out of it.
fn absolute(module: &[String], path: &[String]) -> Option<Path> {
    let mut at = module.to_vec();
    let mut rest = path;
    match path.first()?.as_str() {
        "crate" => (at, rest) = (Vec::new(), &path[1..]),
        "self" => rest = &path[1..],
        _ => {}
    }
    while let Some("super") = rest.first().map(String::as_str) {
        at.pop()?;
        rest = &rest[1..];
    }
    at.extend(rest.iter().filter(|segment| *segment != "*").cloned());
    Some(at)
}

/// A file as a module, and the modules below it that are tests.
fn module(file: &File, path: &[String]) -> (Module, Vec<String>) {
    let all = tokens(&file.text);
    let (code, tests) = without_tests(&all);
    let mut module = Module { file: file.path.clone(), ..Module::default() };
    for pair in code.windows(2) {
        let defines = ["fn", "struct", "enum", "trait", "type", "const", "static", "union"];
        if defines.contains(&pair[0].text) {
            module.items.insert(pair[1].text.to_string());
        }
    }
    for import in imports(&code) {
        let is_out = import.path[0].starts_with("landfall");
        if let (true, false, Some(whole)) = (import.declared, is_out, absolute(path, &import.path))
        {
            match import.name.as_str() {
                "*" => module.globs.push(whole),
                name => drop(module.names.insert(name.to_string(), whole)),
            }
        }
        module.imports.push(import);
    }
    (module, tests.into_iter().map(str::to_string).collect())
}

/// The crate of a source file and its module in it.
fn module_path(path: &str) -> Option<(String, Path)> {
    let path = path.strip_suffix(".rs")?;
    let (unit, inside) = if let Some(rest) = path.strip_prefix("crates/") {
        let (unit, rest) = rest.split_once('/')?;
        (unit, rest.strip_prefix("src/")?)
    } else if let Some(rest) = path.strip_prefix("src/bin/landfall/") {
        ("command", rest)
    } else {
        ("landfall", path.strip_prefix("src/")?)
    };
    let mut parts: Path = inside.split('/').map(str::to_string).collect();
    let is_root = parts.len() == 1 && matches!(inside, "lib" | "main");
    if is_root || parts.last().is_some_and(|part| part == "mod") {
        parts.pop();
    }
    Some((unit.to_string(), parts))
}

fn package_of_manifest(path: &str) -> Option<String> {
    let folder = path.strip_suffix("Cargo.toml")?;
    match folder.strip_prefix("crates/") {
        Some(name) => Some(name.trim_end_matches('/').to_string()),
        None => folder.is_empty().then(|| "landfall".to_string()),
    }
}

/// The crates of the workspace under `[dependencies]` of a manifest.
fn dependencies(manifest: &str) -> BTreeSet<String> {
    let mut section = "";
    let mut found = BTreeSet::new();
    for line in manifest.lines().map(str::trim) {
        if line.starts_with('[') {
            section = line;
        } else if section == "[dependencies]" {
            let name = &line[..line.find(['.', ' ', '=']).unwrap_or(line.len())];
            if name == "landfall" || name.starts_with("landfall-") {
                found.insert(name.to_string());
            }
        }
    }
    found
}
