//! `--against`: the layouts of a git revision, in the place of locks.

use std::path::{Path, PathBuf};

use landfall_layout::finding::Finding;
use landfall_layout::{Error, Language, Options, ShaderLayout, Source, source};
use landfall_lint::drift;

use super::basis::Basis;
use crate::config::{Config, Root};
use crate::git;

/// The shaders of a revision.
pub struct Against {
    /// The revision as named.
    pub rev: String,
    /// Its files; `None` if it has no shader.
    tree: Option<git::Tree>,
    /// The layout options of GLSL and of WGSL, with the include directories of the revision.
    options: [Options; 2],
}

impl Against {
    /// Extracts the shaders of a revision.
    ///
    /// # Errors
    ///
    /// There is no such revision, no git repository, or no `git`.
    pub fn open(rev: &str, config: &Config, basis: &Basis) -> Result<Against, Error> {
        let folder = match config.root.shown.as_os_str().is_empty() {
            true => PathBuf::from("."),
            false => config.root.shown.clone(),
        };
        let tree = git::extract_any(&git::in_repository(rev, &folder)?)?.ok();
        let mut options = basis.options();
        if let Some(tree) = &tree {
            let dirs = &mut options.read.include_dirs;
            *dirs = dirs.iter().map(|dir| tree.at_revision(dir)).collect();
            let preludes = &mut options.read.preludes;
            *preludes = preludes.iter().map(|file| tree.at_revision(file)).collect();
        }
        // naga's answer is not part of a lock.
        let options = [options.clone(), options];
        Ok(Against { rev: rev.to_string(), tree, options })
    }

    /// The layout of a shader at the revision; `None` if it was not there, or had errors.
    pub fn layout(&self, shown: &str, root: &Root, basis: &Basis) -> Option<ShaderLayout> {
        let path = self.tree.as_ref()?.path.join(root.below(Path::new(shown))?);
        let bytes = source::read_bytes(&path, basis.max_bytes()).ok()?;
        let source = basis.source(&path.display().to_string(), bytes).ok()?;
        let options = match source.language {
            Language::Glsl | Language::SpirV => &self.options[0],
            Language::Wgsl => &self.options[1],
        };
        // The globs of variants are those of the work tree.
        let named = Source { path: shown.to_string(), ..source.clone() };
        let own = basis.settings.own_options(&named, options);
        let sets = basis.settings.sets(&named);
        let shader = landfall_layout::layout(&source, &own).with_variants(&source, options, &sets);
        (!shader.has_errors()).then_some(shader)
    }

    /// The findings about a shader and its layout at the revision.
    pub fn findings(&self, shader: &ShaderLayout, old: &ShaderLayout) -> Vec<Finding> {
        let mut found = drift::since(shader, &self.rev, old);
        for finding in &mut found {
            // Places in files that will be removed are notes.
            let old = finding.labels.split_off(1);
            finding.notes.extend(old.into_iter().filter_map(|label| {
                let shown = self.tree.as_ref()?.shown(&label.at.path);
                Some(format!("{}: {shown}:{}:{}", label.text, label.at.line, label.at.column))
            }));
        }
        found
    }
}
