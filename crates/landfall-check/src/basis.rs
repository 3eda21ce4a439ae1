//! The settings of a check: options for reading shaders and settings of lints.

use std::path::{Path, PathBuf};

use landfall_layout::finding::Level;
use landfall_layout::source::{self, OpenFiles};
use landfall_layout::{Error, Language, Options, Source, Stage, lock, other_language};
use landfall_lint::{Settings, levels, naga_disagrees};

use crate::config::{Config, Root};
use crate::hash::Hash;
use crate::walk::{is_below, slashes};

#[derive(Clone, Debug)]
pub struct Basis {
    pub scope: CheckScope,
    pub options: Options,
    /// The stage and language of each shader, if given.
    stage: Option<Stage>,
    language: Option<Language>,
    pub settings: Settings,
}

/// The version of landfall, and whether the build lacks the lints that follow code.
const VERSION: &str = match cfg!(feature = "analysis") {
    true => env!("CARGO_PKG_VERSION"),
    false => concat!(env!("CARGO_PKG_VERSION"), " without analysis"),
};

/// The scope of a check.
#[derive(Clone, Debug, Default)]
pub struct CheckScope {
    /// The configuration's directory, from the current one.
    pub root: String,
    /// The directory of locks, if locks are checked.
    pub locks: Option<String>,
    /// The revision that layouts are compared with instead of locks.
    pub against: Option<String>,
    /// The searched directories, relative to the root.
    pub searched: Vec<String>,
    /// Whether no path was named, so that all shaders are checked.
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

    /// The path of a shader's lock, if locks are checked: below their directory as the shader is
    /// below the root.
    pub fn lock_of(&self, shader: &str, root: &Root) -> Option<PathBuf> {
        let below = root.below(Path::new(shader))?;
        Some(lock::path_of(Path::new(self.locks.as_ref()?), Path::new(&below)))
    }

    /// Whether a path from the root is below a directory that was searched.
    pub fn is_searched(&self, below: &str) -> bool {
        self.searched.iter().any(|folder| is_below(below, folder))
    }
}

impl Basis {
    pub fn new(
        scope: CheckScope,
        options: Options,
        stage: Option<Stage>,
        language: Option<Language>,
        settings: Settings,
    ) -> Basis {
        Basis { scope, options, stage, language, settings }
    }

    /// A text that changes with the findings of lints over all shaders.
    pub fn over_all(&self) -> String {
        let files = self.settings.rust_files.iter();
        let hash = |text: &str| Hash::from_bytes(text.as_bytes());
        files.map(|file| format!("{}\0{}\n", file.path, hash(&file.text).as_str())).collect()
    }

    /// Whether a lint of Rust mirrors is enabled.
    pub fn wants_rust(settings: &Settings) -> bool {
        let is_enabled = |code| levels::level(code, settings) > Level::Allow;
        is_enabled("rust-mirror") || is_enabled("rust-mirror-unknown")
    }

    /// The layout options for a language, with naga's layout if a lint needs it.
    pub fn options_for(&self, language: Language) -> Options {
        self.options.clone().with_naga(naga_disagrees::applies_to(language, &self.settings))
    }

    /// The maximum size of a file in bytes, if set.
    pub fn max_bytes(&self) -> Option<u64> {
        self.options.read.max_bytes
    }

    /// Reads a shader from its file, or from the text that stands for it.
    pub fn read(&self, path: &Path, open: Option<&OpenFiles>) -> Result<Source, Error> {
        let bytes = match open.and_then(|open| open.text(path)) {
            Some(text) => text.as_bytes().to_vec(),
            None => source::read_bytes(path, self.max_bytes())?,
        };
        self.source(&path.display().to_string(), bytes)
    }

    /// Creates a shader from its bytes.
    pub fn source(&self, path: &str, bytes: Vec<u8>) -> Result<Source, Error> {
        // A language that is named is believed.
        if self.language.is_none() {
            other_language::refuse(Path::new(path))?;
        }
        let mut source = Source::from_bytes(path, bytes)?;
        // Bytes that are a module are no text, whatever its language.
        if let Some(language) = self.language.filter(|_| source.words.is_none()) {
            source.language = language;
        }
        source.stage = match source.language {
            Language::Glsl => self.stage.or(source.stage),
            Language::Wgsl | Language::SpirV => None,
        };
        Ok(source)
    }

    /// The hash of all settings that findings of a single shader depend on.
    pub fn fingerprint(&self) -> Hash {
        // What is searched beside the shader does not affect them.
        let scope = CheckScope { searched: vec![], whole: false, ..self.scope.clone() };
        let settings = Settings { rust_files: vec![], ..self.settings.clone() };
        let alone = Basis { scope, settings, ..self.clone() };
        Hash::from_bytes(format!("{VERSION} {alone:?}").as_bytes())
    }
}
