//! The settings of a check: options for reading shaders and settings of lints.
//!
//! Plain data, stored in caches, which must agree in it.

use std::path::{Path, PathBuf};

use landfall_layout::finding::Level;
use landfall_layout::layout::targets;
use landfall_layout::other_language;
use landfall_layout::{Error, Language, Options, ReadOptions, Rules, Source, Stage, Target};
use landfall_lint::settings::RustFile;
use landfall_lint::{Settings, levels, naga_disagrees};
use serde::{Deserialize, Serialize};

use crate::config::Config;
use crate::hash::Hash;
use crate::walk::slashes;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Basis {
    pub version: String,
    /// The configuration's directory, from the current one.
    pub root: String,
    /// The directory of locks, if locks are checked.
    pub locks: Option<String>,
    /// The revision that layouts are compared with instead of locks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub against: Option<String>,
    /// The searched paths, relative to the root; `None` when only some files were named.
    pub searched: Vec<String>,
    /// Whether no path was named, so that all shaders are checked.
    pub whole: bool,
    defines: Vec<(String, String)>,
    include_dirs: Vec<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    preludes: Vec<String>,
    overrides: Vec<(String, String)>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    max_bytes: Option<u64>,
    target: Option<String>,
    rules: Option<String>,
    gather: bool,
    stage: Option<String>,
    language: Option<String>,
    pub settings: Settings,
    /// Rust files with mirrors, and the hashes of their texts.
    rust_files: Vec<(String, Hash)>,
}

/// The version of landfall, and whether the build lacks the lints that follow code.
pub const VERSION: &str = match cfg!(feature = "analysis") {
    true => env!("CARGO_PKG_VERSION"),
    false => concat!(env!("CARGO_PKG_VERSION"), " without analysis"),
};

/// The scope of a check.
#[derive(Clone, Debug, Default)]
pub struct CheckScope {
    pub root: String,
    pub locks: Option<String>,
    pub against: Option<String>,
    pub searched: Vec<String>,
    pub whole: bool,
}

impl CheckScope {
    /// The scope of a check of these paths, of all shaders if there are none. Locks are optional, unless
    /// their directory is named or configured; a revision takes their place.
    pub fn new(
        config: &Config,
        named: &[PathBuf],
        locks: Option<&Path>,
        against: Option<&String>,
    ) -> CheckScope {
        let usual = config.locks(locks);
        // The usual directory counts only if it is there.
        let locks = config.explicit_locks(locks).or_else(|| usual.is_dir().then_some(usual));
        let paths = config.paths(named);
        let searched = paths.iter().filter(|path| path.is_dir());
        CheckScope {
            root: slashes(&config.root.shown),
            locks: locks.as_deref().map(slashes).filter(|_| against.is_none()),
            against: against.cloned(),
            searched: searched.filter_map(|path| config.root.below(path)).collect(),
            whole: named.is_empty(),
        }
    }
}

impl Basis {
    pub fn new(
        scope: CheckScope,
        options: &Options,
        stage: Option<Stage>,
        language: Option<Language>,
        settings: Settings,
    ) -> Basis {
        let dirs = options.read.include_dirs.iter();
        Basis {
            version: VERSION.to_string(),
            root: scope.root,
            locks: scope.locks,
            against: scope.against,
            searched: scope.searched,
            whole: scope.whole,
            defines: options.read.defines.clone(),
            include_dirs: dirs.map(|dir| dir.display().to_string()).collect(),
            preludes: options.read.preludes.iter().map(|file| file.display().to_string()).collect(),
            overrides: options.read.overrides.clone(),
            max_bytes: options.read.max_bytes,
            target: options.read.target.map(|target| targets::key(target).to_string()),
            rules: options.rules.map(|rules| rules.name().to_string()),
            gather: options.gather,
            stage: stage.map(|stage| stage.name().to_string()),
            language: language.map(|language| language.name().to_string()),
            settings,
            rust_files: Vec::new(),
        }
    }

    /// Adds the Rust files with mirrors.
    pub fn set_rust_files(&mut self, files: Vec<RustFile>) {
        let hashed = |file: &RustFile| (file.path.clone(), Hash::from_bytes(file.text.as_bytes()));
        self.rust_files = files.iter().map(hashed).collect();
        self.settings.rust_files = files;
    }

    /// A text that changes with the findings of lints over all shaders.
    pub fn over_all(&self) -> String {
        format!("{:?}", self.rust_files)
    }

    /// Whether a lint of Rust mirrors is enabled.
    pub fn wants_rust(settings: &Settings) -> bool {
        let is_enabled = |code| levels::level(code, settings) > Level::Allow;
        is_enabled("rust-mirror") || is_enabled("rust-mirror-unknown")
    }

    /// The layout options for a language, with naga's layout if a lint needs it.
    pub fn options_for(&self, language: Language) -> Options {
        self.options().with_naga(naga_disagrees::applies_to(language, &self.settings))
    }

    pub fn options(&self) -> Options {
        let mut read = ReadOptions::default();
        read.defines = self.defines.clone();
        read.include_dirs = self.include_dirs.iter().map(PathBuf::from).collect();
        read.preludes = self.preludes.iter().map(PathBuf::from).collect();
        read.overrides = self.overrides.clone();
        read.max_bytes = self.max_bytes;
        read.target = self.target.as_deref().map(|name| match name {
            "vulkan" => Target::Vulkan,
            _ => Target::OpenGl,
        });
        Options::default()
            .with_read(read)
            .with_rules(self.rules.as_deref().and_then(Rules::from_name))
            .with_gather(self.gather)
    }

    /// The maximum size of a file in bytes, if set.
    pub fn max_bytes(&self) -> Option<u64> {
        self.max_bytes
    }

    /// The directories searched for includes.
    pub fn include_dirs(&self) -> impl Iterator<Item = &Path> {
        self.include_dirs.iter().map(Path::new)
    }

    /// Creates a shader from its bytes.
    pub fn source(&self, path: &str, bytes: Vec<u8>) -> Result<Source, Error> {
        // A language that is named is believed.
        if self.language.is_none() {
            other_language::refuse(Path::new(path))?;
        }
        let mut source = Source::from_bytes(path, bytes)?;
        match self.language.as_deref() {
            // Bytes that are a module are no text, whatever its language.
            Some(_) if source.words.is_some() => {}
            Some("wgsl") => source.language = Language::Wgsl,
            Some(_) => source.language = Language::Glsl,
            None => {}
        }
        source.stage = match source.language {
            Language::Glsl => self.stage.as_deref().and_then(Stage::from_name).or(source.stage),
            Language::Wgsl | Language::SpirV => None,
        };
        Ok(source)
    }

    /// The hash of all settings that findings of a single shader depend on.
    pub fn fingerprint(&self) -> Hash {
        // The scope does not affect findings of a single shader.
        let alone = Basis { searched: vec![], whole: false, rust_files: vec![], ..self.clone() };
        Hash::from_bytes(serde_json::to_string(&alone).expect("keys are strings").as_bytes())
    }
}
