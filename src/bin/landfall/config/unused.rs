//! Warnings about names and patterns of a configuration that have no effect.

use super::Config;
use crate::output::Streams;
use crate::without_effect::{self, ConfiguredKey};

impl Config {
    /// Records the names that the file gives to all its shaders.
    pub fn record_names(&self) {
        let Some(file) = &self.file else { return };
        let names = |key, names: &[(String, String)]| {
            names.iter().for_each(|(name, _)| without_effect::configured(key, name, file));
        };
        names(ConfiguredKey::Override, &self.read.overrides);
        names(ConfiguredKey::Define, &self.read.defines);
        let variants = self.settings.variants.iter().flat_map(|row| &row.sets);
        let permutations = self.settings.permutations.iter().chain(variants);
        permutations.for_each(|macros| names(ConfiguredKey::Permutations, macros));
    }

    /// Warns about patterns that exclude nothing; `whole` if all shaders were searched.
    pub fn warn_of_unused_patterns(&self, whole: bool, streams: &Streams) {
        for (pattern, is_configured) in self.exclude.unused() {
            let at = pattern.trim_end_matches('/').trim_start_matches("./").trim_start_matches('/');
            // A directory without a shader, or that is ignored, may have one elsewhere.
            let is_there = || self.root.path(at).exists();
            let option = match (&self.file, is_configured) {
                (Some(_), true) if !whole || is_there() => continue,
                (Some(file), true) => format!("{pattern}` in `exclude` of `{}", file.display()),
                (None, _) | (_, false) => format!("--exclude {pattern}"),
            };
            without_effect::excludes_nothing(option, streams);
        }
    }
}
