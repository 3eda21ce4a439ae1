//! `--against`: the layouts of a git revision, in the place of locks.

use std::path::{Path, PathBuf};

use landfall_layout::finding::Finding;
use landfall_layout::{Options, ReadOptions, ShaderLayout};
use landfall_lint::drift;

use crate::basis::Basis;
use crate::config::Root;

/// Files of a git revision in a directory.
#[derive(Clone, Debug)]
pub struct ExtractedTree {
    /// The directory that corresponds to the root of the repository.
    pub root: PathBuf,
    /// The requested path below it.
    pub path: PathBuf,
    pub rev: String,
    /// The root of the repository.
    pub top: PathBuf,
}

impl ExtractedTree {
    /// Replaces the paths of extracted files in a text by `REV:path`.
    pub fn shown(&self, text: &str) -> String {
        let root = self.root.display().to_string();
        let rev = format!("{}:", self.rev);
        text.replace(&format!("{root}{}", std::path::MAIN_SEPARATOR), &rev).replace(&root, &rev)
    }

    /// The path of an extracted file in the work tree.
    pub fn in_work_tree(&self, path: &Path) -> PathBuf {
        path.strip_prefix(&self.root)
            .map_or_else(|_| path.to_path_buf(), |in_it| self.top.join(in_it))
    }

    /// The options with the include directories and preludes of the revision.
    pub fn options(&self, mut options: Options) -> Options {
        let ReadOptions { include_dirs, preludes, .. } = &mut options.read;
        include_dirs.iter_mut().chain(preludes).for_each(|path| *path = self.at_revision(path));
        options
    }

    /// Maps a path of the work tree to its extracted form; one outside stays unchanged.
    fn at_revision(&self, dir: &Path) -> PathBuf {
        let real = std::fs::canonicalize(dir).unwrap_or_else(|_| {
            std::env::current_dir().map(|here| here.join(dir)).unwrap_or_else(|_| dir.to_path_buf())
        });
        match real.strip_prefix(&self.top) {
            Ok(inside) => self.root.join(inside),
            Err(_) => dir.to_path_buf(),
        }
    }
}

/// The shaders of a revision.
pub struct Against {
    /// The revision as named.
    pub rev: String,
    /// Its files; `None` if it has no shader.
    tree: Option<ExtractedTree>,
    /// The layout options, with the include directories of the revision.
    options: Options,
}

impl Against {
    /// The shaders of a revision, extracted to a directory.
    pub fn new(rev: &str, tree: Option<ExtractedTree>, basis: &Basis) -> Against {
        let options = basis.options.clone();
        let options = tree.iter().fold(options, |options, tree| tree.options(options));
        Against { rev: rev.to_string(), tree, options }
    }

    /// The layout of a shader at the revision; `None` if it was not there, or had errors.
    pub fn layout(&self, shown: &str, root: &Root, basis: &Basis) -> Option<ShaderLayout> {
        let path = self.tree.as_ref()?.path.join(root.below(Path::new(shown))?);
        let source = basis.read(&path, None).ok()?;
        let shader = basis.settings.layout_as(shown, &source, &self.options);
        (!shader.has_errors()).then_some(shader)
    }

    /// The findings about a shader and its layout at the revision.
    pub fn findings(&self, shader: &ShaderLayout, old: &ShaderLayout) -> Vec<Finding> {
        let mut found = drift::since(shader, &self.rev, old);
        for finding in &mut found {
            // Places in files that will be removed are notes.
            // The first label is in the work tree, the others at the revision.
            let old = finding.labels.split_off(1);
            finding.notes.extend(old.into_iter().filter_map(|label| {
                let shown = self.tree.as_ref()?.shown(&label.at.path);
                Some(format!("{}: {shown}:{}:{}", label.text, label.at.line, label.at.column))
            }));
        }
        found
    }
}
