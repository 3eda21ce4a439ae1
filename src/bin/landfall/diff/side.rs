//! One side of a comparison: shaders, locks, or directories of either, here or at a revision.

use std::path::{Path, PathBuf};

use landfall_layout::source::Files;
use landfall_layout::{Error, Options, ShaderLayout, lock};

use super::git;
use crate::args::ReadArgs;
use crate::config::{Config, slashes};
use crate::inputs::Inputs;
use crate::lock::locks_below;
use crate::output::{FindingStyle, Streams};
use crate::{given, read};

/// The shaders of one side.
pub struct Side {
    pub entries: Vec<Entry>,
    /// It was named as a file: whatever stands on the other side is its partner.
    pub single: bool,
    /// The directory of locks, if it is one of the work tree.
    pub locks: Option<PathBuf>,
    /// Some shader could not be read.
    pub failed: bool,
}

/// One shader, or one lock.
pub struct Entry {
    /// Its path in its directory.
    pub key: String,
    /// The shader's path from the configuration's folder, where that can be told.
    pub shader: Option<String>,
    pub layout: ShaderLayout,
    /// The lock, and where it is in the work tree.
    pub lock: Option<(Option<PathBuf>, lock::Lock)>,
}

/// How one side is read.
pub struct Reading<'a> {
    pub args: &'a ReadArgs,
    pub config: &'a Config,
    /// As the configuration and the flags say.
    pub options: Options,
    pub streams: &'a Streams,
    pub style: FindingStyle,
}

impl Reading<'_> {
    /// Reads what an argument names.
    pub fn side(&self, argument: &Path) -> Result<Side, Error> {
        match argument.to_str().and_then(git::Revision::parse) {
            Some(revision) => self.revision(&revision),
            None => self.here(argument, None),
        }
    }

    /// Reads a path as it was at a revision.
    pub fn revision(&self, revision: &git::Revision) -> Result<Side, Error> {
        let tree = git::take_out(revision)?;
        let mut side = self.here(&tree.path, Some(&tree)).map_err(|error| Error {
            path: tree.shown(&error.path),
            message: tree.shown(&error.message),
            ..error
        })?;
        side.locks = None;
        for entry in &mut side.entries {
            entry.layout.path = tree.shown(&entry.layout.path);
            if let Some((place, _)) = &mut entry.lock {
                *place = None;
            }
        }
        Ok(side)
    }

    fn here(&self, path: &Path, tree: Option<&git::Tree>) -> Result<Side, Error> {
        let mut side = Side { entries: vec![], single: true, locks: None, failed: false };
        if path.extension().is_some_and(|e| e == "json") && !path.is_dir() {
            let locks = self.locks(path, "", tree)?;
            side.single = locks.len() == 1;
            side.entries = locks;
            return Ok(side);
        }
        if !path.is_dir() {
            if !read::is_stdin(path) && !path.exists() {
                let error = Error::new(path.display().to_string(), "is not there");
                return Err(error.with_help(
                    "name a shader, a lock, a directory, or REVISION:PATH as git spells it",
                ));
            }
            let entry = self.shader(path, String::new(), tree, &mut side.failed)?;
            side.entries.extend(entry);
            return Ok(side);
        }
        side.single = false;
        let mut shaders = Inputs::new(vec![path.to_path_buf()]).peekable();
        // A directory without shaders is one of locks.
        if matches!(shaders.peek(), Some(Ok(_))) {
            for input in shaders {
                let input = input?;
                let key = input.relative.to_string_lossy().replace('\\', "/");
                side.entries.extend(self.shader(&input.path, key, tree, &mut side.failed)?);
            }
            return Ok(side);
        }
        let locks = locks_below(path);
        if locks.is_empty() {
            return Err(Error::new(path.display().to_string(), "holds no shader and no lock"));
        }
        for file in locks {
            let relative = file.strip_prefix(path).unwrap_or(&file).with_extension("");
            let key = relative.to_string_lossy().replace('\\', "/");
            side.entries.extend(self.locks(&file, &key, tree)?);
        }
        side.locks = Some(path.to_path_buf());
        Ok(side)
    }

    /// The shader of a file; `None` when it cannot be laid out, which has been said.
    fn shader(
        &self,
        path: &Path,
        key: String,
        tree: Option<&git::Tree>,
        failed: &mut bool,
    ) -> Result<Option<Entry>, Error> {
        let source = read::source(path, self.args)?;
        let mut options = self.options.clone();
        if let Some(tree) = tree {
            let dirs = &mut options.read.include_dirs;
            *dirs = dirs.iter().map(|dir| tree.directory(dir)).collect();
        }
        let layout = landfall_layout::layout(&source, &options);
        given::saw(&layout.files);
        let findings = self.style.text(&layout.diagnostics, &layout.files);
        self.streams.report(&tree.map_or(findings.clone(), |tree| tree.shown(&findings)));
        if layout.has_errors() {
            *failed = true;
            return Ok(None);
        }
        let path = tree.map_or_else(|| path.to_path_buf(), |tree| tree.in_work_tree(path));
        Ok(Some(Entry { key, shader: self.config.root.below(&path), layout, lock: None }))
    }

    /// The lock of a file, or each shader of an output of `layout`.
    fn locks(&self, path: &Path, key: &str, tree: Option<&git::Tree>) -> Result<Vec<Entry>, Error> {
        let real = tree.map_or_else(|| path.to_path_buf(), |tree| tree.in_work_tree(path));
        let shader = self.config.root.below(&real.with_extension("")).map(PathBuf::from);
        let locks = self.config.root.below(&self.config.locks(None));
        let shader = shader.zip(locks);
        let shader = shader.and_then(|(path, locks)| path.strip_prefix(locks).ok().map(slashes));
        let text = read::text(path)?;
        let locks = lock::read_all(&read::shown(path), &text)?;
        let alone = locks.len() == 1;
        let entry = |lock: lock::Lock| Entry {
            key: match (&lock.shader, alone) {
                (Some(shader), false) => shader.clone(),
                (Some(_) | None, _) => key.to_string(),
            },
            // A directory of locks that nobody has named holds the tree from the root, too.
            shader: shader.clone().or_else(|| (!key.is_empty()).then(|| key.to_string())),
            layout: ShaderLayout { path: path.display().to_string(), ..lock.layout() },
            // Only a lock proper is renewed.
            lock: lock.shader.is_none().then(|| (Some(path.to_path_buf()), lock)),
        };
        Ok(locks.into_iter().map(entry).collect())
    }
}

/// A shader that one side does not have.
pub fn nothing(like: &ShaderLayout) -> ShaderLayout {
    ShaderLayout {
        path: like.path.clone(),
        language: like.language,
        stage: like.stage,
        blocks: Vec::new(),
        overrides: Vec::new(),
        files: Files::default(),
        diagnostics: Vec::new(),
        assumed_target: None,
    }
}
