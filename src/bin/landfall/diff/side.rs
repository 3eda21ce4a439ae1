//! One side of a comparison: shaders, locks, or directories of either, here or at a revision.

use landfall_check::files;
use std::path::{Path, PathBuf};

use landfall_layout::{Error, Options, ShaderLayout, Variant, lock};

use crate::args::ReadArgs;
use crate::output::{FindingStyle, Streams};
use crate::{git, read, watch, without_effect};
use landfall_check::config::Config;
use landfall_check::inputs::{Input, Inputs};
use landfall_check::locks::locks_below;
use landfall_check::templates::Templates;
use landfall_check::walk::slashes;

pub struct DiffedSide {
    pub entries: Vec<SideEntry>,
    /// Whether it was named as a file, which is compared with the other side whatever its name.
    pub single: bool,
    /// The directory of locks, if it is in the work tree.
    pub locks: Option<PathBuf>,
    pub failed: bool,
}

/// One shader, or one lock.
pub struct SideEntry {
    /// Its path below its directory.
    pub key: String,
    /// The shader's path from the configuration's directory, if known.
    pub shader: Option<String>,
    pub layout: ShaderLayout,
    /// The lock, and its path in the work tree.
    pub lock: Option<(Option<PathBuf>, lock::Lock)>,
    /// Whether it is output of `layout`, which has no variants.
    pub is_output: bool,
}

pub struct SideReading<'a> {
    pub args: &'a ReadArgs,
    pub config: &'a Config,
    /// The layout options of the configuration and the flags.
    pub options: Options,
    pub streams: &'a Streams,
    pub style: FindingStyle,
    pub templates: Templates,
}

impl SideReading<'_> {
    /// Reads the side that an argument names.
    pub fn side(&self, argument: &Path) -> Result<DiffedSide, Error> {
        match argument.to_str().and_then(git::Revision::parse) {
            Some(revision) => self.revision(&revision),
            None => self.here(argument, None),
        }
    }

    pub fn revision(&self, revision: &git::Revision) -> Result<DiffedSide, Error> {
        let tree = git::extract(revision)?;
        // Errors name the temporary directory of the extracted files; a reader knows `REV:path`.
        let mut side = self.here(&tree.path, Some(&tree)).map_err(|mut error| {
            error.path = tree.shown(&error.path);
            error.message = tree.shown(&error.message);
            error
        })?;
        side.locks = None;
        for entry in &mut side.entries {
            entry.layout.path = tree.shown(&entry.layout.path);
            // A lock of a revision is not updated.
            if let Some((place, _)) = &mut entry.lock {
                *place = None;
            }
        }
        Ok(side)
    }

    fn here(&self, path: &Path, tree: Option<&git::Tree>) -> Result<DiffedSide, Error> {
        let mut side = DiffedSide { entries: vec![], single: true, locks: None, failed: false };
        // A `.json` file is a lock or output of `layout`.
        if path.extension().is_some_and(|e| e == "json") && !path.is_dir() {
            let locks = self.locks(path, "", tree)?;
            side.single = locks.len() == 1;
            side.entries = locks;
            return Ok(side);
        }
        if !path.is_dir() {
            if !files::is_stdin(path) && !path.exists() {
                let error = Error::new(path.display().to_string(), "does not exist");
                return Err(
                    error.with_help("name a shader, a lock, a directory or a git REVISION:PATH")
                );
            }
            let entry = self.shader(path, String::new(), tree, &mut side.failed)?;
            side.entries.extend(entry);
            return Ok(side);
        }
        side.single = false;
        let mut shaders = Inputs::new(vec![path.to_path_buf()], watch::stop()).peekable();
        // A directory without shaders contains locks.
        if matches!(shaders.peek(), Some(Ok(_))) {
            for input in shaders {
                let input = input?;
                // Exclusions are about paths of the work tree.
                let work = tree.map_or_else(|| input.path.clone(), |t| t.in_work_tree(&input.path));
                if self.config.excludes(&work) {
                    continue;
                }
                let key = input.relative.to_string_lossy().replace('\\', "/");
                let entry = match self.shader(&input.path, key, tree, &mut side.failed) {
                    // A file that is no shader by itself, such as a template that a build fills
                    // in.
                    Err(error) if self.passes_over(&input, &error, tree) => continue,
                    entry => entry?,
                };
                side.entries.extend(entry);
            }
            return Ok(side);
        }
        let locks = locks_below(path);
        if locks.is_empty() {
            return Err(Error::new(path.display().to_string(), "contains no shader or lock"));
        }
        for file in locks {
            let relative = file.strip_prefix(path).unwrap_or(&file).with_extension("");
            let key = relative.to_string_lossy().replace('\\', "/");
            side.entries.extend(self.locks(&file, &key, tree)?);
        }
        side.locks = Some(path.to_path_buf());
        Ok(side)
    }

    /// Passes over a template, whose names are those of the revision.
    fn passes_over(&self, input: &Input, error: &Error, tree: Option<&git::Tree>) -> bool {
        let Some(tree) = tree else { return self.templates.passes_over(input, error) };
        let path = PathBuf::from(tree.shown(&input.path.display().to_string()));
        let mut error = error.clone();
        error.path = tree.shown(&error.path);
        self.templates.passes_over(&Input { path, ..input.clone() }, &error)
    }

    /// The layout of a shader file; `None` after reported errors.
    fn shader(
        &self,
        path: &Path,
        key: String,
        tree: Option<&git::Tree>,
        failed: &mut bool,
    ) -> Result<Option<SideEntry>, Error> {
        let source = read::source(path, self.args)?;
        // Includes are read from the revision as well; the globs of variants are those of the work
        // tree.
        let options = tree.iter().fold(self.options.clone(), |all, tree| tree.options(all));
        let path = tree.map_or_else(|| path.to_path_buf(), |tree| tree.in_work_tree(path));
        let shown = path.display().to_string();
        let layout = self.config.settings.layout_as(&shown, &source, &options);
        without_effect::record_of(&layout);
        let findings = self.style.text(&layout.diagnostics, &layout.files);
        self.streams.report(&tree.map_or(findings.clone(), |tree| tree.shown(&findings)));
        if layout.has_errors() {
            *failed = true;
            return Ok(None);
        }
        Ok(Some(SideEntry {
            key,
            shader: self.config.root.below(&path),
            layout,
            lock: None,
            is_output: false,
        }))
    }

    /// The lock in a file, or the shaders in output of `layout`.
    fn locks(
        &self,
        path: &Path,
        key: &str,
        // The path of the shader that a lock is of follows from the lock's own path, below the
        // directory of locks.
        tree: Option<&git::Tree>,
    ) -> Result<Vec<SideEntry>, Error> {
        let real = tree.map_or_else(|| path.to_path_buf(), |tree| tree.in_work_tree(path));
        let below = self.config.root.below(&real.with_extension("")).map(PathBuf::from);
        let folder = self.config.root.below(&self.config.locks(None));
        let shader = below.zip(folder);
        let shader = shader.and_then(|(path, locks)| path.strip_prefix(locks).ok().map(slashes));
        let text = files::text(path)?;
        let locks = lock::read_all(&files::display_path(path), &text)?;
        let alone = locks.len() == 1;
        let layout = |lock: &lock::Lock| {
            let mut layout = lock.layout();
            layout.path = path.display().to_string();
            layout
        };
        let entry = |lock: lock::Lock| SideEntry {
            key: match (&lock.shader, alone) {
                (Some(shader), false) => shader.clone(),
                (Some(_) | None, _) => key.to_string(),
            },
            // An unnamed directory of locks also contains the tree from the root.
            shader: shader.clone().or_else(|| (!key.is_empty()).then(|| key.to_string())),
            layout: layout(&lock),
            is_output: lock.shader.is_some(),
            // Only locks are updated, not output of `layout`.
            lock: lock.shader.is_none().then(|| (Some(path.to_path_buf()), lock)),
        };
        Ok(locks.into_iter().map(entry).collect())
    }
}

/// The empty layout of a shader that one side lacks.
pub fn nothing(like: &ShaderLayout) -> ShaderLayout {
    let mut nothing = ShaderLayout::empty(like.path.clone(), like.language, like.stage);
    with_variants_of(&mut nothing, like);
    nothing
}

/// Adds the variants of another layout that a layout lacks, which are then as without their macros.
pub fn with_variants_of(layout: &mut ShaderLayout, other: &ShaderLayout) {
    for Variant { macros, .. } in &other.variants {
        if layout.variants.iter().all(|known| known.macros != *macros) {
            layout.variants.push(Variant::unchanged(macros.clone()));
        }
    }
}
