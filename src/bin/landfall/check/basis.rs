//! What a check rests on besides the shaders: how they are read, and what lints are told.
//!
//! Plain data, so that a cache and the report of a shard can carry it, and refuse to be mixed
//! with another.

use std::path::{Path, PathBuf};

use landfall_layout::finding::Level;
use landfall_layout::other_language;
use landfall_layout::{Error, Language, Options, ReadOptions, Rules, Source, Stage, Target};
use landfall_lint::settings::RustFile;
use landfall_lint::{Settings, levels, naga_disagrees};
use serde::{Deserialize, Serialize};

use super::hash::Hash;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Basis {
    pub version: String,
    /// The configuration's folder from the current one.
    pub root: String,
    /// Where locks are, when they count.
    pub locks: Option<String>,
    /// What is searched, relative to the root; `None` when only some files were named.
    pub searched: Vec<String>,
    /// Whether nothing was named, so that all there is is checked.
    pub whole: bool,
    defines: Vec<(String, String)>,
    include_dirs: Vec<String>,
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

/// What is checked, and where.
#[derive(Clone, Debug, Default)]
pub struct Scope {
    pub root: String,
    pub locks: Option<String>,
    pub searched: Vec<String>,
    pub whole: bool,
}

impl Basis {
    pub fn new(
        scope: Scope,
        options: &Options,
        stage: Option<Stage>,
        language: Option<Language>,
        settings: Settings,
    ) -> Basis {
        let dirs = options.read.include_dirs.iter();
        let rust_files = settings.rust_files.iter();
        let rust_files =
            rust_files.map(|file| (file.path.clone(), Hash::of(file.text.as_bytes()))).collect();
        Basis {
            version: env!("CARGO_PKG_VERSION").to_string(),
            root: scope.root,
            locks: scope.locks,
            searched: scope.searched,
            whole: scope.whole,
            defines: options.read.defines.clone(),
            include_dirs: dirs.map(|dir| dir.display().to_string()).collect(),
            overrides: options.read.overrides.clone(),
            max_bytes: options.read.max_bytes,
            target: options.read.target.map(|target| match target {
                Target::OpenGl => "opengl".to_string(),
                Target::Vulkan => "vulkan".to_string(),
            }),
            rules: options.rules.map(|rules| rules.name().to_string()),
            gather: options.gather,
            stage: stage.map(|stage| stage.name().to_string()),
            language: language.map(|language| language.name().to_string()),
            settings,
            rust_files,
        }
    }

    /// A text that is another when lints over all shaders may find something else.
    pub fn over_all(&self) -> String {
        format!("{:?}", self.rust_files)
    }

    /// The Rust files read again, as a report of a shard names them.
    ///
    /// # Errors
    /// One is not the file that was checked.
    pub fn read_rust_files(&mut self) -> Result<(), Error> {
        for (path, hash) in &self.rust_files {
            let text = crate::read::text(Path::new(path))?;
            if Hash::of(text.as_bytes()) != *hash {
                return Err(Error::new(path, "is not the file that was checked")
                    .with_help("merge in a checkout of the commit that the shards checked"));
            }
            self.settings.rust_files.push(RustFile { path: path.clone(), text: text.into() });
        }
        Ok(())
    }

    /// Whether anybody asks about mirrors in Rust files.
    pub fn wants_rust(settings: &Settings) -> bool {
        let asked = |code| levels::level(code, settings) > Level::Allow;
        asked("rust-mirror") || asked("rust-mirror-unknown")
    }

    /// How shaders of a language are laid out; naga is asked where a lint looks at what it says.
    pub fn options_for(&self, language: Language) -> Options {
        Options { naga: naga_disagrees::wanted(language, &self.settings), ..self.options() }
    }

    /// How shaders are laid out.
    pub fn options(&self) -> Options {
        Options {
            read: ReadOptions {
                defines: self.defines.clone(),
                include_dirs: self.include_dirs.iter().map(PathBuf::from).collect(),
                overrides: self.overrides.clone(),
                max_bytes: self.max_bytes,
                target: self.target.as_deref().map(|name| match name {
                    "vulkan" => Target::Vulkan,
                    _ => Target::OpenGl,
                }),
            },
            rules: self.rules.as_deref().and_then(Rules::from_name),
            gather: self.gather,
            naga: false,
        }
    }

    /// Bytes of the largest file that is read, where somebody says so.
    pub fn max_bytes(&self) -> Option<u64> {
        self.max_bytes
    }

    /// The directories searched for includes.
    pub fn include_dirs(&self) -> impl Iterator<Item = &Path> {
        self.include_dirs.iter().map(Path::new)
    }

    /// A shader from its text.
    pub fn source(&self, path: &str, bytes: Vec<u8>) -> Result<Source, Error> {
        if self.language.is_none() {
            other_language::refuse(Path::new(path))?;
        }
        let mut source = Source::from_bytes(path, bytes)?;
        match self.language.as_deref() {
            Some("wgsl") => source.language = Language::Wgsl,
            Some(_) => source.language = Language::Glsl,
            None => {}
        }
        source.stage = match source.language {
            Language::Glsl => self.stage.as_deref().and_then(Stage::from_name).or(source.stage),
            Language::Wgsl => None,
        };
        Ok(source)
    }

    /// A hash that is another when anything is that findings of one shader depend on.
    pub fn fingerprint(&self) -> Hash {
        // What else is checked changes nothing about one shader.
        let alone = Basis { searched: vec![], whole: false, rust_files: vec![], ..self.clone() };
        Hash::of(serde_json::to_string(&alone).expect("keys are strings").as_bytes())
    }
}
