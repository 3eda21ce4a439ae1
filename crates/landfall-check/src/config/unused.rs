//! Names and patterns of a configuration that have no effect.

use std::path::{Path, PathBuf};

use landfall_layout::text::glob;

use super::Config;
use crate::given_names::{ConfiguredKey, GivenNames};

impl Config {
    /// Gives the names that the file has for all its shaders.
    pub fn give_names(&self, given: &GivenNames) {
        let Some(file) = &self.file else { return };
        let names = |key, names: &[(String, String)]| {
            names.iter().for_each(|(name, _)| given.give_configured(key, name, file));
        };
        names(ConfiguredKey::Override, &self.read.overrides);
        names(ConfiguredKey::Define, &self.read.defines);
        let variants = self.settings.variants.iter().flat_map(|row| &row.sets);
        let permutations = self.settings.permutations.iter().chain(variants);
        permutations.for_each(|macros| names(ConfiguredKey::Permutations, macros));
    }

    /// The patterns that exclude nothing, as options; `whole` if all shaders were searched.
    pub fn unused_patterns(&self, whole: bool) -> Vec<String> {
        let unused = self.exclude.unused().filter_map(|(pattern, is_configured)| {
            let at = pattern.trim_end_matches('/').trim_start_matches("./").trim_start_matches('/');
            // A directory without a shader, or that is ignored, may have one elsewhere.
            let is_there = || self.root.path(at).exists();
            match (&self.file, is_configured) {
                (Some(_), true) if !whole || is_there() => None,
                (Some(file), true) => {
                    Some(format!("{pattern}` in `exclude` of `{}", file.display()))
                }
                (None, _) | (_, false) => Some(format!("--exclude {pattern}")),
            }
        });
        unused.collect()
    }

    /// The rows for files of which there are none among those that a check of all shaders read, as
    /// options.
    pub fn unused_rows(&self, read: impl FnOnce() -> Vec<PathBuf>) -> Vec<String> {
        let levels = self.settings.path_levels.iter().map(|row| ("path-levels", row.file.clone()));
        let variants = self.settings.variants.iter().map(|row| ("variants", row.file.clone()));
        let policies = self.path_policies.iter();
        let policies = policies.map(|(file, _)| ("path-policy", self.root.glob(file)));
        let rows: Vec<(&str, String)> = levels.chain(policies).chain(variants).collect();
        let Some(file) = self.file.as_ref().filter(|_| !rows.is_empty()) else { return Vec::new() };
        let read: Vec<String> = read().iter().map(|path| path.display().to_string()).collect();
        let is_unused = |pattern: &String| {
            // As of `exclude`: a directory without a shader, or that is ignored, may have one
            // elsewhere.
            let folder = pattern.trim_end_matches("**").trim_end_matches('/');
            !Path::new(folder).exists() && !read.iter().any(|path| glob::matches(pattern, path))
        };
        let unused = rows.into_iter().filter(|(_, pattern)| is_unused(pattern));
        unused
            .map(|(key, pattern)| format!("{pattern}` in `[[{key}]]` of `{}", file.display()))
            .collect()
    }
}
