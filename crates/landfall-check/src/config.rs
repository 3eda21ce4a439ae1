//! The configuration file `landfall.toml`.
//!
//! It is searched for upwards from the checked paths. Paths in it are relative to its own
//! directory; without a configuration, paths are relative to the directory of `layouts`. Flags
//! override it, in [`Config::options`] and in the commands. `example.toml` beside this file has
//! every key.

mod assertions;
mod bindings;
mod figure;
mod find;
mod flags;
mod lints;
mod root;
#[cfg(feature = "schema")]
mod schema;
mod toml;
mod unused;
mod values;

use landfall_layout::diagnostic::Code;
use landfall_layout::diff::Policy;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use landfall_codegen::rust::BindingOptions;
use landfall_layout::file::FileWriter;
use landfall_layout::finding::Level;
use landfall_layout::source::{Files, OpenFiles};
use landfall_layout::text::edit_distance::suggestion;
use landfall_layout::text::glob::{self, Glob};
use landfall_layout::{Diagnostic, Error, Options, ReadOptions, Rules, Severity, Target, lock};
use landfall_lint::settings::Target as Limits;
use landfall_lint::{LINTS, Settings, lint};

use crate::files;
use crate::inputs::Input;
use crate::walk::slashes;
use find::ProjectBase;
pub use flags::{Flags, GivenTargets, define, dialect, feature, setting};
use toml::{Document, Keys, Text};
use values::{pairs, strings, target};

pub use assertions::AssertionFile;
pub use find::NAMES;
pub use root::{Root, absolute, current, relative_path, repository};
#[cfg(feature = "schema")]
pub use schema::schema;

/// The default directory of locks.
const LOCKS: &str = "layouts";

/// The configuration of a project.
#[derive(Debug, Default)]
pub struct Config {
    /// Its file.
    pub file: Option<PathBuf>,
    /// The directory that paths are relative to.
    pub root: Root,
    /// The paths to check if none are named.
    pub paths: Vec<PathBuf>,
    /// The excluded paths.
    pub exclude: Exclude,
    /// The directory of locks, if set.
    pub locks: Option<PathBuf>,
    /// The directory of the cache, if set.
    pub cache_dir: Option<PathBuf>,
    /// The baseline of findings, if set.
    pub baseline: Option<PathBuf>,
    /// The options for reading shaders.
    pub read: ReadOptions,
    /// The layout rules for all blocks, if set.
    pub rules: Option<Rules>,
    /// Whether loose uniforms are gathered in a block.
    pub gather: bool,
    /// Whether `api` is set, which takes precedence over targets for the GLSL dialect.
    has_api: bool,
    /// New names for mirrors, of `[rename]`.
    pub rename: Vec<(String, String)>,
    /// Types of the program for mirrors in Rust, of `[types]`.
    pub types: Vec<(String, String)>,
    /// The same in C and C++, of `[c-types]`.
    pub c_types: Vec<(String, String)>,
    /// Traits that mirrors in Rust derive, of `derive`.
    pub derives: Vec<String>,
    /// Bindings of Rust mirrors, of `[bindings]`.
    pub bindings: BindingOptions,
    /// Files of assertions, of `[[assert]]`.
    pub assertions: Vec<AssertionFile>,
    /// The policy for changes of layouts, if set.
    policy: Option<Policy>,
    /// Policies for some files, as globs; a later one takes precedence.
    path_policies: Vec<(String, Policy)>,
    /// The settings of lints.
    pub settings: Settings,
}

/// Which configuration a run uses.
#[derive(Clone, Debug)]
pub enum ConfigChoice {
    /// The nearest one above the checked paths, or none.
    Nearest,
    File(PathBuf),
    None,
}

/// Why there is no configuration.
#[derive(Debug)]
pub enum ConfigError {
    /// The file cannot be found or read.
    Unreadable(Error),
    /// The file has errors.
    Wrong(Vec<Diagnostic>, Files),
}

impl From<Error> for ConfigError {
    fn from(error: Error) -> ConfigError {
        ConfigError::Unreadable(error)
    }
}

/// Reads the configuration for these paths.
///
/// # Errors
///
/// There are two, it cannot be read, or it has errors.
pub fn load(choice: &ConfigChoice, paths: &[PathBuf]) -> Result<Config, ConfigError> {
    load_open(choice, paths, &OpenFiles::default())
}

/// The same, where texts of an editor replace files.
///
/// # Errors
///
/// There are two, it cannot be read, or it has errors.
pub fn load_open(
    choice: &ConfigChoice,
    paths: &[PathBuf],
    open: &OpenFiles,
) -> Result<Config, ConfigError> {
    let found = match choice {
        ConfigChoice::None => ProjectBase::Root(PathBuf::new()),
        ConfigChoice::File(file) => ProjectBase::File(file.clone()),
        ConfigChoice::Nearest => find::find(paths)?,
    };
    let file = match found {
        ProjectBase::File(file) => file,
        ProjectBase::Root(folder) => {
            return Ok(Config { root: Root::new(&folder)?, ..Config::default() });
        }
    };
    let text = match open.text(&file) {
        Some(text) => text.to_string(),
        None => files::text(&file)?,
    };
    let folder = file.parent().unwrap_or(Path::new(""));
    let root = Root::new(folder)?;
    let document = Document::new(&files::display_path(&file), text);
    let config = document.read(|keys| self::read(keys, root));
    let config = config.map_err(|(found, files)| ConfigError::Wrong(found, files))?;
    Ok(Config { file: Some(file), ..config })
}

fn read(keys: &Keys<'_>, root: Root) -> Config {
    let folder = |text: Option<Text>| text.map(|text| root.path(&text.value));
    let list = |key| keys.texts(key).unwrap_or_default();
    let targets: Vec<Limits> =
        list("targets").iter().filter_map(|text| target(keys, text)).collect();
    let api = keys.choice("api", &["opengl", "vulkan"]).map(|name| match name {
        "opengl" => Target::OpenGl,
        _ => Target::Vulkan,
    });
    let rules = keys.choice("rules", &Rules::OF_TEXT.map(Rules::name));
    let settings = Settings { targets: targets.clone(), ..lints::read(keys, &root) };
    Config {
        file: None,
        paths: list("paths").iter().map(|text| root.path(&text.value)).collect(),
        exclude: exclude(keys),
        locks: folder(keys.text("locks")),
        cache_dir: folder(keys.text("cache-dir")),
        baseline: folder(keys.text("baseline")),
        read: {
            let mut read = ReadOptions::default();
            read.defines = pairs(keys, "define", define);
            read.defines.extend(pairs(keys, "features", feature));
            read.preludes = list("prelude").iter().map(|text| root.path(&text.value)).collect();
            read.include_dirs = list("include").iter().map(|text| root.path(&text.value)).collect();
            read.overrides = pairs(keys, "override", setting);
            read.target = api.or_else(|| dialect(targets.iter().filter_map(|one| one.dialect())));
            read
        },
        rules: rules.and_then(Rules::from_name),
        gather: keys.bool("gather").unwrap_or(false),
        has_api: api.is_some(),
        rename: strings(keys, "rename", "{ Light = \"GpuLight\" }", "new name"),
        types: strings(keys, "types", "{ vec3 = \"crate::Vec3\" }", "type"),
        c_types: strings(keys, "c-types", "{ vec3 = \"Vec3\" }", "type"),
        derives: list("derive").into_iter().map(|text| text.value).collect(),
        bindings: bindings::read(keys),
        assertions: keys.tables("assert", "[[assert]]", |keys| assertions::read(keys, &root)),
        policy: keys.choice("policy", &Policy::ALL.map(Policy::name)).and_then(Policy::from_name),
        path_policies: keys.tables("path-policy", "[[path-policy]]", |keys| {
            let (file, policy) = (keys.needed("file"), keys.needed("policy"));
            let known = keys.choice("policy", &Policy::ALL.map(Policy::name));
            // Read again for its errors.
            lints::glob(keys, "file", &root);
            policy.and(known).and_then(Policy::from_name).zip(file).map(|(p, file)| (file.value, p))
        }),
        settings,
        root,
    }
}

fn exclude(keys: &Keys<'_>) -> Exclude {
    let mut exclude = Exclude::default();
    let texts = keys.texts("exclude").unwrap_or_default();
    for text in &texts {
        if let Err(cause) = exclude.add(&text.value, true) {
            keys.bad_glob(text, &cause);
        }
    }
    exclude
}

impl Config {
    /// The input paths: the named ones, else those of the configuration, else its directory.
    pub fn paths(&self, named: &[PathBuf]) -> Vec<PathBuf> {
        match (named, self.paths.as_slice()) {
            ([], []) => vec![self.root.path("")],
            ([], configured) => configured.to_vec(),
            (named, _) => named.to_vec(),
        }
    }

    /// Whether a command reads an input that it was told of by these arguments: named files always,
    /// those found in directories and by globs unless they are excluded.
    pub fn takes(&self, input: &Result<Input, Error>, named: &[PathBuf]) -> bool {
        let Ok(input) = input else { return true };
        named.contains(&input.path) || !self.excludes(&input.path)
    }

    /// Whether an input is not excluded, though it was named; one that is counts.
    pub fn takes_or_counts(&self, input: &Result<Input, Error>, excluded: &AtomicUsize) -> bool {
        let is_excluded = input.as_ref().is_ok_and(|input| self.excludes(&input.path));
        excluded.fetch_add(usize::from(is_excluded), Ordering::Relaxed);
        !is_excluded
    }

    /// Whether a file is excluded.
    pub fn excludes(&self, path: &Path) -> bool {
        self.root.below(path).is_some_and(|below| self.exclude.takes(&below))
    }

    /// The directory of locks, if named or configured.
    pub fn explicit_locks(&self, named: Option<&Path>) -> Option<PathBuf> {
        named.map(Path::to_path_buf).or_else(|| self.locks.clone())
    }

    /// The directory of locks.
    pub fn locks(&self, named: Option<&Path>) -> PathBuf {
        self.explicit_locks(named).unwrap_or_else(|| self.root.path(LOCKS))
    }

    /// The policy for changes of a shader's layout, by its path from the configuration's directory.
    pub fn policy_of(&self, shader: &str) -> Option<Policy> {
        // A later row takes precedence.
        let mut rows = self.path_policies.iter().rev();
        let row = rows.find(|(file, _)| glob::matches(file, shader));
        row.map(|(_, policy)| *policy).or(self.policy)
    }

    /// A writer for a directory. It follows no link out of the project, or out of the directory if
    /// that is outside the project or was named on the command line.
    pub fn writer(&self, folder: &Path, named: bool) -> FileWriter {
        match named {
            true => files::writer().inside(folder),
            false => self.root.writer(folder),
        }
    }

    /// The path of a shader's lock, for `lock`, `verify --record` and `check`.
    ///
    /// # Errors
    ///
    /// The shader is not below the configuration's directory.
    pub fn lock_of(&self, locks: &Path, shader: &Path) -> Result<PathBuf, Error> {
        match self.root.below(shader) {
            Some(below) => Ok(lock::path_of(locks, Path::new(&below))),
            None => {
                let root = slashes(&self.root.shown);
                let directory =
                    if root.is_empty() { "the current directory" } else { root.as_str() };
                let message =
                    format!("is not below {directory}, to which the paths of locks are relative");
                let help = "run it in a directory above the shader, or put a `landfall.toml` there";
                Err(Error::new(shader.display().to_string(), message).with_help(help))
            }
        }
    }

    /// The layout options of the configuration, overridden by flags.
    pub fn options(&self, flags: &Flags) -> Options {
        // A flag replaces the value of its name alone.
        let over = |ours: &[(String, String)], theirs: &[(String, String)]| {
            let kept = ours.iter().filter(|(name, _)| theirs.iter().all(|(n, _)| n != name));
            kept.chain(theirs).cloned().collect()
        };
        // Directories of flags are searched before those of the configuration.
        let dirs = flags.include_dirs.iter().chain(&self.read.include_dirs);
        let target = if self.has_api { self.read.target } else { None };
        let mut read = ReadOptions::default();
        read.defines = over(&self.read.defines, &flags.defines);
        read.preludes = match flags.preludes.is_empty() {
            true => self.read.preludes.clone(),
            false => flags.preludes.clone(),
        };
        read.include_dirs = dirs.cloned().collect();
        read.overrides = over(&self.read.overrides, &flags.overrides);
        read.target = match &flags.targets {
            None => self.read.target,
            // `--target webgpu` replaces the limits, not the GLSL dialect.
            Some(given) => given.dialect.or(target),
        };
        Options::default()
            .with_read(read)
            .with_rules(flags.rules.or(self.rules))
            .with_gather(flags.gather || self.gather)
    }

    /// The lint settings of the configuration, overridden by flags.
    pub fn settings(
        &self,
        levels: &[(String, Level)],
        targets: Option<&GivenTargets>,
    ) -> Result<Settings, Diagnostic> {
        let mut settings = self.settings.clone();
        for (code, level) in levels {
            if !is_code(code) {
                let found = unknown_code(code);
                // Other commands define macros by `-D`, which denies a lint here.
                return Err(match *level == Level::Deny && define(code).is_ok() {
                    true if code.contains('=') => Diagnostic {
                        help: Some(format!("define a macro with `--define {code}`")),
                        ..found
                    },
                    true => found.with_note("macros are defined with `--define NAME[=TEXT]`"),
                    false => found,
                });
            }
            if let Some(missing) = missing(code, *level) {
                return Err(missing);
            }
            settings.flag_levels.push((code.clone(), *level));
        }
        if let Some(given) = targets {
            settings.targets.clone_from(&given.limits);
        }
        Ok(settings)
    }
}

/// Whether a level can be set for this code.
pub fn is_code(code: &str) -> bool {
    code == "warnings"
        || code == "all"
        || lint(code).is_some()
        // A finding that is no lint's: a warning of the layout.
        || Code::from_name(code).is_some()
}

/// The finding for a lint that a level enables, but that this build cannot find.
pub fn missing(code: &str, level: Level) -> Option<Diagnostic> {
    let lint = lint(code)?;
    let is_missing = level > Level::Allow && !lint.is_built();
    is_missing.then(|| {
        let message =
            format!("the lint `{code}` is not in this build: it needs the feature `analysis`");
        Diagnostic::without_place(Code::UnknownLint, Severity::Error, message)
            .with_help("cargo install landfall --features analysis")
    })
}

/// The finding for an unknown lint code on the command line.
pub fn unknown_code(code: &str) -> Diagnostic {
    let help = suggestion(code, LINTS.iter().map(|lint| lint.code))
        .unwrap_or_else(|| "`landfall rule` lists the lints".to_string());
    let message = format!("there is no lint `{code}`");
    Diagnostic::without_place(Code::UnknownLint, Severity::Error, message).with_help(help)
}

/// Excluded paths, relative to the configuration's directory.
#[derive(Debug, Default)]
pub struct Exclude {
    patterns: Vec<ExcludePattern>,
    /// The characters of all patterns, with what their braces stand for.
    size: usize,
}

#[derive(Debug)]
struct ExcludePattern {
    text: String,
    glob: Glob,
    is_configured: bool,
    /// Whether a path matched it.
    is_used: AtomicBool,
}

/// The largest size.
const LARGEST: usize = 1 << 20;

impl Exclude {
    /// Adds a pattern. With a `/` it is relative to the configuration's directory; without, it
    /// matches a file or directory of that name anywhere. A match of a directory excludes its
    /// contents.
    pub fn add(&mut self, pattern: &str, is_configured: bool) -> Result<(), String> {
        let text = slashes(Path::new(pattern));
        // `vendor/` and `vendor` are the same directory.
        let bare = text.trim_end_matches('/');
        let (from, anchored) = match bare.strip_prefix("./").or(bare.strip_prefix('/')) {
            Some(rest) => (rest, true),
            None => (bare, bare.contains('/')),
        };
        let glob = Glob::new(from).map_err(|cause| cause.to_string())?;
        // Braces multiply: what they stand for is limited over all patterns.
        self.size += glob.size();
        if self.size > LARGEST {
            return Err("with those before it, it is too large".to_string());
        }
        self.patterns.push(ExcludePattern {
            text: pattern.to_string(),
            glob: if anchored { glob } else { glob.anywhere() },
            is_configured,
            is_used: AtomicBool::new(false),
        });
        Ok(())
    }

    /// Whether a path relative to the configuration's directory is excluded.
    pub fn takes(&self, path: &str) -> bool {
        let mut is_taken = false;
        // Every pattern is tried, so that each that matches counts as used.
        for pattern in self.patterns.iter().filter(|pattern| pattern.glob.contains(path)) {
            pattern.is_used.store(true, Ordering::Relaxed);
            is_taken = true;
        }
        is_taken
    }

    /// The patterns that no path matched, and whether each is of the configuration.
    pub fn unused(&self) -> impl Iterator<Item = (&str, bool)> {
        let unused = self.patterns.iter().filter(|p| !p.is_used.load(Ordering::Relaxed));
        unused.map(|pattern| (pattern.text.as_str(), pattern.is_configured))
    }
}

/// The finding that every shader of a run was excluded.
pub fn all_excluded(count: usize, flags: &[String]) -> Diagnostic {
    let what = if count == 1 {
        "the only shader is".to_string()
    } else {
        format!("all {count} shaders are")
    };
    let message = format!("{what} excluded: nothing to do");
    let help = match flags {
        [] => "excluded by `exclude` of the configuration".to_string(),
        flags => format!("excluded by `--exclude {}`", flags.join("`, `--exclude ")),
    };
    let found = Diagnostic::about(Code::NoInput, message, Some(help), "");
    Diagnostic { path: None, ..found }
}

/// The error for an invalid glob on the command line.
pub fn bad_glob(pattern: &str, cause: &str) -> Error {
    Error::new(pattern, format!("is not a glob: {cause}"))
        .with_help("escape `[`, `{`, `*` and `?` with `\\`")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exclusion_is_by_path_or_by_any_part_of_it() {
        let mut exclude = Exclude::default();
        for pattern in ["vendor", "gen/*.frag", "*.wgsl", "./top/"] {
            exclude.add(pattern, true).unwrap();
        }
        for out in ["vendor/a.frag", "x/vendor/b/c.frag", "gen/a.frag", "deep/a.wgsl", "top/a.vert"]
        {
            assert!(exclude.takes(out), "{out}");
        }
        for kept in ["vendored/a.frag", "x/gen/a.frag", "gen/deep/a.frag", "x/top/a.vert"] {
            assert!(!exclude.takes(kept), "{kept}");
        }
        assert!(Exclude::default().add("a[", true).is_err());
    }
}
