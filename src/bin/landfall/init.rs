//! `landfall init`: writes a commented `landfall.toml` for the shaders of a directory.

use landfall_check::files;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use landfall_layout::format::phrases::counted;
use landfall_layout::other_language::content;
use landfall_layout::source::{is_searched, kind_of_path};
use landfall_layout::{Error, Language};

use crate::args::InitArgs;
use crate::git::included;
use crate::output::{CommandFailure, Outcome, Streams};
use landfall_check::walk::{FilteredWalk, joined, slashes};

/// Names of directories whose files are usually somebody else's, or generated.
const FOREIGN: [&str; 10] = [
    "3rdparty",
    "build",
    "deps",
    "extern",
    "external",
    "node_modules",
    "target",
    "third-party",
    "third_party",
    "vendor",
];

/// Maximum bytes of a shader that is searched for `#include` and `#version`.
const MAX_BYTES: u64 = 1 << 20;

pub fn run(args: &InitArgs, streams: &Streams) -> Result<Outcome, CommandFailure> {
    let dir = if args.dir == Path::new(".") { Path::new("") } else { &args.dir };
    let file = dir.join("landfall.toml");
    if !args.print {
        // Either name is read, so either would hide or be hidden by the new file.
        for name in ["landfall.toml", ".landfall.toml"] {
            let there = dir.join(name);
            if there.symlink_metadata().is_ok() {
                let error = Error::new(slashes(&there), "exists and is not overwritten");
                return Err(error.with_help("print a new one with `landfall init --print`").into());
            }
        }
    }
    let found = DirectoryContents::below(&args.dir)?;
    let text = found.text();
    if args.print {
        streams.product(&text)?;
        return Ok(Outcome::Clean);
    }
    files::writer().inside(&args.dir).write(&file, text)?;
    let shaders = counted(found.shaders, "shader");
    streams.notes(&format!("wrote {} for {shaders}\n", slashes(&file)));
    Ok(Outcome::Clean)
}

/// The shaders of a directory; paths are relative to it.
#[derive(Default)]
struct DirectoryContents {
    shaders: usize,
    /// Directories with shaders, none below another.
    paths: Vec<String>,
    /// Names of directories of other projects that contain shaders.
    foreign: BTreeSet<&'static str>,
    /// Directories of files that `#include` names from elsewhere.
    include: BTreeSet<String>,
    /// Number of shaders of OpenGL ES 3, and in WGSL.
    es: usize,
    wgsl: usize,
    has_locks: bool,
}

impl DirectoryContents {
    fn below(dir: &Path) -> Result<DirectoryContents, Error> {
        if !dir.is_dir() {
            let what = if dir.exists() { "is not a directory" } else { "does not exist" };
            return Err(Error::new(slashes(dir), what));
        }
        let mut found = DirectoryContents::default();
        let mut files: Vec<PathBuf> = Vec::new();
        let mut shaders: Vec<PathBuf> = Vec::new();
        // One walk, with the rules of ignore files: shaders, and all files that an include may
        // mean.
        for entry in FilteredWalk::new(dir) {
            let entry = entry?;
            if !entry.file_type().is_file() {
                continue;
            }
            let path = entry.path().strip_prefix(dir).unwrap_or(entry.path()).to_path_buf();
            // Files of other extensions are shaders if their content is.
            let kind = kind_of_path(&path)
                .filter(|_| is_searched(&path) && content::holds_shader(entry.path()));
            if let Some(foreign) = foreign(&path) {
                found.foreign.extend(kind.is_some().then_some(foreign));
                continue;
            }
            found.wgsl += usize::from(matches!(kind, Some((Language::Wgsl, _))));
            if kind.is_some() {
                shaders.push(path.clone());
            }
            files.push(path);
        }
        if shaders.is_empty() {
            return Err(Error::new(slashes(dir), "contains no shader file")
                .with_help("landfall reads GLSL and WGSL, in files such as `.frag` and `.wgsl`"));
        }
        found.shaders = shaders.len();
        found.paths = paths(&shaders);
        found.has_locks = dir.join("layouts").is_dir();
        for shader in &shaders {
            let path = dir.join(shader);
            let is_small = path.metadata().is_ok_and(|data| data.len() <= MAX_BYTES);
            let bytes = is_small.then(|| files::file(&path)).flatten().unwrap_or_default();
            let text = String::from_utf8_lossy(&bytes);
            let first = text.lines().find(|line| line.trim_start().starts_with("#version"));
            found.es += usize::from(first.is_some_and(|line| line.contains("300 es")));
            let folder = shader.parent().unwrap_or(Path::new(""));
            for name in text.lines().filter_map(included) {
                // Found beside the shader: it needs no directory.
                if !files.iter().any(|file| *file == joined(folder, Path::new(name))) {
                    found.include.extend(include_dir(&files, Path::new(name)));
                }
            }
        }
        Ok(found)
    }

    fn text(&self) -> String {
        let mut text = String::from(
            "# Settings of landfall. `landfall schema config` prints their JSON Schema.\n\n",
        );
        let mut add = |lines: String| text.push_str(&lines);
        let shaders = counted(self.shaders, "shader");
        add(format!("# What `landfall check` and `landfall lock` read: {shaders}.\n"));
        add(format!("paths = {}\n", list(self.paths.iter().map(String::as_str))));
        if !self.foreign.is_empty() {
            add("\n# Not checked: a path, or a file or directory name anywhere.\n".to_string());
            add(format!("exclude = {}\n", list(self.foreign.iter().copied())));
        }
        if !self.include.is_empty() {
            add("\n# Directories of files that `#include` names.\n".to_string());
            add(format!("include = {}\n", list(self.include.iter().map(String::as_str))));
        }
        let locks = match self.has_locks {
            true => "# The layouts that `landfall check` compares with are in `layouts`.\n",
            false => {
                "# `landfall lock` records layouts in `layouts`; then check reports changes.\n"
            }
        };
        add(format!("\n{locks}# locks = \"layouts\"\n"));
        let targets = [(self.es > 0, "webgl2"), (self.wgsl > 0, "webgpu")];
        let named = targets.iter().filter(|(is, _)| *is).map(|(_, name)| *name);
        let targets = match list(named).as_str() {
            "[]" => "[\"gl33\"]".to_string(),
            named => named.to_string(),
        };
        add("\n# APIs whose limits hold: gl33, gles30, webgl2, webgpu, vulkan.\n".to_string());
        add(format!("# targets = {targets}\n"));
        add("\n# Findings of today that are permitted, as `landfall check --write-baseline`\n\
             # records them.\n# baseline = \"landfall-baseline.json\"\n"
            .to_string());
        add("\n# Changes of layouts that are refused: superset, bytes, names or code.\n\
             # policy = \"bytes\"\n"
            .to_string());
        add("\n# Levels of lints, which `landfall rule` lists: allow, warn or deny.\n\
             # [levels]\n# warnings = \"deny\"\n# mat3-padding = \"allow\"\n"
            .to_string());
        add("\n# Levels in some files.\n# [[path-levels]]\n# file = \"old/**\"\n\
             # levels = { all = \"allow\" }\n"
            .to_string());
        text
    }
}

/// The name of the directory of another project that a file is in.
fn foreign(path: &Path) -> Option<&'static str> {
    let folder = path.parent()?;
    let parts = folder.iter().filter_map(|part| part.to_str());
    parts.filter_map(|part| FOREIGN.into_iter().find(|name| *name == part)).next()
}

/// For each directory at the top, the deepest one with all of its shaders.
fn paths(shaders: &[PathBuf]) -> Vec<String> {
    // Listing each directory would be long, listing the top one would read other files.
    let folder = |path: &PathBuf| path.parent().map(Path::to_path_buf).unwrap_or_default();
    let folders: BTreeSet<PathBuf> = shaders.iter().map(folder).collect();
    if folders.contains(Path::new("")) {
        return vec![".".to_string()];
    }
    let mut common: Vec<PathBuf> = Vec::new();
    for folder in folders {
        match common.last_mut().filter(|last| last.iter().next() == folder.iter().next()) {
            Some(last) => {
                let parts = last.iter().zip(folder.iter()).take_while(|(a, b)| a == b);
                *last = parts.map(|(a, _)| a).collect();
            }
            None => common.push(folder),
        }
    }
    common.iter().map(|path| slashes(path)).collect()
}

/// The directory from which an include is found, if only one of these files can be meant.
fn include_dir(files: &[PathBuf], name: &Path) -> Option<String> {
    // `#include "common/light.glsl"` is found by the path's end; two such files leave it open.
    let mut meant = files.iter().filter(|file| file.ends_with(name));
    let (only, other) = (meant.next()?, meant.next());
    let depth = name.components().count();
    let folder = only.ancestors().nth(depth)?;
    let shown = if folder.as_os_str().is_empty() { ".".to_string() } else { slashes(folder) };
    other.is_none().then_some(shown)
}

/// A TOML array of strings.
fn list<'a>(items: impl Iterator<Item = &'a str>) -> String {
    // The escapes of JSON are those of TOML, which also forbids U+007F.
    let quoted = |item| serde_json::Value::from(item).to_string().replace('\u{7f}', "\\u007f");
    let items: Vec<String> = items.map(quoted).collect();
    format!("[{}]", items.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_the_deepest_directories_with_all_shaders() {
        let of = |shaders: &[&str]| paths(&shaders.iter().map(PathBuf::from).collect::<Vec<_>>());
        assert_eq!(of(&["a/s/x.frag", "a/s/deep/y.frag", "b/z.wgsl"]), ["a/s", "b"]);
        assert_eq!(of(&["a/s/x.frag", "a/t/y.frag"]), ["a"]);
        assert_eq!(of(&["a/x.frag", "y.frag"]), ["."]);
    }

    #[test]
    fn an_include_names_its_directory() {
        let files = ["s/common/light.glsl", "s/a.frag", "t/x.glsl", "u/x.glsl"].map(PathBuf::from);
        let of = |name: &str| include_dir(&files, Path::new(name));
        assert_eq!(of("light.glsl").as_deref(), Some("s/common"));
        assert_eq!(of("common/light.glsl").as_deref(), Some("s"));
        assert_eq!(of("s/common/light.glsl").as_deref(), Some("."));
        assert_eq!(of("x.glsl"), None, "either could be meant");
        assert_eq!(of("gone.glsl"), None);
        assert_eq!(included("  # include <a/b.glsl> // c"), Some("a/b.glsl"));
    }

    #[test]
    fn names_are_quoted_for_toml() {
        assert_eq!(list(["a\"\u{7f}\n", "b"].into_iter()), r#"["a\"\u007f\n", "b"]"#);
    }
}
