//! `landfall.toml`: what a project says once instead of on every command line.
//!
//! Found upwards from what is checked, read with the places of its values, made absolute in
//! meaning: whatever path it names is relative to its own folder. Flags are laid over it by
//! [`Config::options`] and by the commands. `example.toml` beside this file has every key.

mod figure;
mod find;
mod lints;
mod root;
mod toml;

use landfall_layout::diagnostic::Code;
use std::path::{Path, PathBuf};

use globset::{GlobBuilder, GlobSet, GlobSetBuilder};
use landfall_layout::file::FileWriter;
use landfall_layout::text::edit_distance::nearest;
use landfall_layout::{Diagnostic, Error, Options, ReadOptions, Rules, Severity, Target, lock};
use landfall_lint::settings::Target as Limits;
use landfall_lint::{LINTS, Settings, lint, renamed};

use crate::args::{self, Api, ConfigArgs, TextArgs};
use crate::output::{Failure, FindingForm, Streams};
use crate::read;
use toml::{Document, Keys, Text};

pub use root::{Root, slashes};

/// Where locks are unless somebody says otherwise.
const LOCKS: &str = "layouts";

const RULES: [Rules; 4] = [Rules::Std140, Rules::Std430, Rules::Scalar, Rules::Wgsl];

/// What a project says.
#[derive(Debug, Default)]
pub struct Config {
    /// The file that says it.
    pub file: Option<PathBuf>,
    /// The folder that paths are relative to.
    pub root: Root,
    /// What is checked when nothing is named.
    pub paths: Vec<PathBuf>,
    /// What is left out.
    pub exclude: Exclude,
    /// Where locks are, when it says so.
    pub locks: Option<PathBuf>,
    /// Where findings are remembered, if anywhere.
    pub cache_dir: Option<PathBuf>,
    /// How shaders are read.
    pub read: ReadOptions,
    /// The rules all blocks are laid out by.
    pub rules: Option<Rules>,
    /// Whether loose uniforms are gathered.
    pub gather: bool,
    /// Whether `api` says what GLSL is read as, so that targets do not.
    said_api: bool,
    /// What lints are told.
    pub settings: Settings,
}

/// Reads the configuration of a run about these paths; `None` when it is refused, which is
/// reported by then.
pub fn load(
    args: &ConfigArgs,
    paths: &[PathBuf],
    streams: &Streams,
) -> Result<Option<Config>, Failure> {
    let file = match &args.config {
        _ if args.no_config => None,
        Some(file) => Some(file.clone()),
        None => find::find(paths)?,
    };
    let Some(file) = file else {
        return Ok(Some(Config { root: Root::new(Path::new(""))?, ..Config::default() }));
    };
    let text = read::text(&file)?;
    let folder = file.parent().unwrap_or(Path::new(""));
    let root = Root::new(folder)?;
    let document = Document::new(&read::shown(&file), text);
    let config = document.read(|keys| self::read(keys, root));
    match config {
        Ok(config) => Ok(Some(Config { file: Some(file), ..config })),
        Err((found, files)) => {
            streams.report(&streams.style(FindingForm::Human).text(&found, &files));
            Ok(None)
        }
    }
}

fn read(keys: &Keys<'_>, root: Root) -> Config {
    let folder = |said: Option<Text>| said.map(|text| root.path(&text.value));
    let list = |key| keys.texts(key).unwrap_or_default();
    let targets: Vec<Api> = list("targets").iter().filter_map(|text| target(keys, text)).collect();
    let api = keys.choice("api", &["opengl", "vulkan"]).map(|name| match name {
        "opengl" => Target::OpenGl,
        _ => Target::Vulkan,
    });
    let rules = keys.choice("rules", &RULES.map(Rules::name));
    let settings = Settings {
        targets: targets.iter().filter_map(|api| api.limits()).collect(),
        ..lints::read(keys, &root)
    };
    Config {
        file: None,
        paths: list("paths").iter().map(|text| root.path(&text.value)).collect(),
        exclude: exclude(keys),
        locks: folder(keys.text("locks")),
        cache_dir: folder(keys.text("cache-dir")),
        read: ReadOptions {
            defines: pairs(keys, "define", args::define),
            include_dirs: list("include").iter().map(|text| root.path(&text.value)).collect(),
            overrides: pairs(keys, "override", args::setting),
            target: api.or_else(|| Api::reading(&targets)),
            max_bytes: None,
        },
        rules: rules.and_then(Rules::from_name),
        gather: keys.bool("gather").unwrap_or(false),
        said_api: api.is_some(),
        settings,
        root,
    }
}

fn target(keys: &Keys<'_>, text: &Text) -> Option<Api> {
    let found = Limits::from_name(&text.value);
    if found.is_none() {
        keys.unknown(Code::UnknownTarget, "target", text, &Limits::ALL.map(Limits::name));
    }
    found.map(|limits| match limits {
        Limits::Gl33 => Api::Gl33,
        Limits::Gles30 => Api::Gles30,
        Limits::WebGl2 => Api::Webgl2,
        Limits::WebGpu => Api::Webgpu,
        Limits::Vulkan => Api::Vulkan,
    })
}

/// Texts that are read like a flag's value.
fn pairs(
    keys: &Keys<'_>,
    key: &'static str,
    parse: impl Fn(&str) -> Result<(String, String), String>,
) -> Vec<(String, String)> {
    let texts = keys.texts(key).unwrap_or_default();
    texts.iter().filter_map(|text| keys.parsed(Code::WrongValue, text, &parse)).collect()
}

fn exclude(keys: &Keys<'_>) -> Exclude {
    let mut exclude = Exclude::default();
    for text in keys.texts("exclude").unwrap_or_default() {
        if let Err(cause) = exclude.add(&text.value) {
            keys.bad_glob(&text, &cause);
        }
    }
    exclude.ready();
    exclude
}

impl Config {
    /// What a run is about: what was named, what the configuration says, or all there is.
    pub fn paths(&self, named: &[PathBuf]) -> Vec<PathBuf> {
        match (named, self.paths.as_slice()) {
            ([], []) => vec![self.root.path("")],
            ([], said) => said.to_vec(),
            (named, _) => named.to_vec(),
        }
    }

    /// Where locks are, if somebody says so.
    pub fn said_locks(&self, named: Option<&Path>) -> Option<PathBuf> {
        named.map(Path::to_path_buf).or_else(|| self.locks.clone())
    }

    /// Where locks are.
    pub fn locks(&self, named: Option<&Path>) -> PathBuf {
        self.said_locks(named).unwrap_or_else(|| self.root.path(LOCKS))
    }

    /// What writes below a folder: through no link out of the project, or out of the folder
    /// where that is not in the project or was named on the command line.
    pub fn writer(&self, folder: &Path, named: bool) -> FileWriter {
        match named {
            true => FileWriter::default().inside(folder),
            false => self.root.writer(folder),
        }
    }

    /// The lock of a shader: `lock` and `verify --record` write it where `check` looks.
    ///
    /// # Errors
    /// The shader is not below the configuration's folder.
    pub fn lock_of(&self, locks: &Path, shader: &Path) -> Result<PathBuf, Error> {
        match self.root.below(shader) {
            Some(below) => Ok(lock::path_of(locks, Path::new(&below))),
            None => {
                let root = slashes(&self.root.shown);
                let folder = if root.is_empty() { "the current folder" } else { root.as_str() };
                let message = format!("is not below {folder}, so that its lock has no place");
                let help = "run it in a folder above the shader, or put a `landfall.toml` there";
                Err(Error::new(shader.display().to_string(), message).with_help(help))
            }
        }
    }

    /// How shaders are laid out: as the configuration says, but what flags say holds.
    pub fn options(&self, args: &TextArgs, defines: &[(String, String)]) -> Options {
        let over = |ours: &[(String, String)], theirs: &[(String, String)]| {
            let kept = ours.iter().filter(|(name, _)| theirs.iter().all(|(n, _)| n != name));
            kept.chain(theirs).cloned().collect()
        };
        let dirs = args.include_dirs.iter().chain(&self.read.include_dirs);
        let told = Api::reading(&args.targets);
        let target = if self.said_api { self.read.target } else { None };
        Options {
            read: ReadOptions {
                defines: over(&self.read.defines, defines),
                include_dirs: dirs.cloned().collect(),
                overrides: over(&self.read.overrides, &args.overrides),
                target: match args.targets.is_empty() {
                    true => self.read.target,
                    // `--target webgpu` replaces the limits, not what GLSL is read as.
                    false => told.or(target),
                },
                max_bytes: args.max_bytes,
            },
            rules: args.rules.as_deref().and_then(Rules::from_name).or(self.rules),
            gather: args.gather || self.gather,
            naga: false,
        }
    }

    /// What lints are told: as the configuration says, then as flags do.
    pub fn settings(
        &self,
        levels: &[(String, landfall_layout::finding::Level)],
        targets: &[Api],
    ) -> Result<Settings, Diagnostic> {
        let mut settings = self.settings.clone();
        for (code, level) in levels {
            if !is_code(code) {
                let found = unknown_code(code);
                let define = "a macro is defined with `--define NAME` or `-D NAME=TEXT`";
                return Err(match args::define(code).is_ok() {
                    true => found.with_note(define),
                    false => found,
                });
            }
            settings.levels.push((code.clone(), *level));
        }
        if !targets.is_empty() {
            settings.targets = targets.iter().filter_map(|api| api.limits()).collect();
        }
        Ok(settings)
    }
}

/// Whether levels may be set for it.
pub fn is_code(code: &str) -> bool {
    code == "warnings" || code == "all" || lint(code).is_some() || renamed(code).is_some()
}

/// A code on the command line that no lint has.
pub fn unknown_code(code: &str) -> Diagnostic {
    let near = nearest(code, LINTS.iter().map(|lint| lint.code));
    Diagnostic {
        code: Code::UnknownLint,
        severity: Severity::Error,
        message: format!("there is no lint `{code}`"),
        path: None,
        labels: vec![],
        notes: vec![],
        help: Some(match near {
            Some(near) => format!("did you mean `{near}`?"),
            None => "`landfall rule` lists the lints".to_string(),
        }),
    }
}

/// What is left out of a run, by its path below the configuration's folder.
#[derive(Debug, Default)]
pub struct Exclude {
    globs: Vec<globset::Glob>,
    set: GlobSet,
}

impl Exclude {
    /// A pattern with a `/` is a path from the configuration's folder; one without is any file
    /// or folder of that name. What is in a folder that is left out is left out.
    pub fn add(&mut self, pattern: &str) -> Result<(), String> {
        if let Some(cause) = crate::inputs::too_deep(pattern) {
            return Err(cause);
        }
        let bare = pattern.trim_end_matches('/');
        let (from, anchored) = match bare.strip_prefix("./").or(bare.strip_prefix('/')) {
            Some(rest) => (rest, true),
            None => (bare, bare.contains('/')),
        };
        let from = if anchored { from.to_string() } else { format!("**/{from}") };
        for pattern in [from.clone(), format!("{from}/**")] {
            let glob = GlobBuilder::new(&pattern).literal_separator(true).build();
            self.globs.push(glob.map_err(|cause| cause.kind().to_string())?);
        }
        Ok(())
    }

    /// Makes the set from the patterns.
    pub fn ready(&mut self) {
        let mut builder = GlobSetBuilder::new();
        for glob in &self.globs {
            builder.add(glob.clone());
        }
        self.set = builder.build().expect("each glob was built by itself");
    }

    /// Whether a path from the configuration's folder is left out.
    pub fn takes(&self, path: &str) -> bool {
        !self.globs.is_empty() && self.set.is_match(path)
    }
}

/// Every shader of a run was left out.
pub fn all_excluded(count: usize, flags: &[String]) -> Diagnostic {
    let what = if count == 1 {
        "the only shader is".to_string()
    } else {
        format!("all {count} shaders are")
    };
    let message = format!("{what} left out, and nothing is looked at");
    let help = match flags {
        [] => "`exclude` of the configuration says so".to_string(),
        flags => format!("`--exclude {}` says so", flags.join("`, `--exclude ")),
    };
    let found = Diagnostic::about(Code::NoInput, message, Some(help), "");
    Diagnostic { path: None, ..found }
}

/// A bad glob on the command line.
pub fn bad_glob(pattern: &str, cause: &str) -> Error {
    Error::new(pattern, format!("is no glob: {cause}"))
        .with_help("escape `[`, `{`, `*` and `?` with `\\`")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exclusion_is_by_path_or_by_any_part_of_it() {
        let mut exclude = Exclude::default();
        for pattern in ["vendor", "gen/*.frag", "*.wgsl", "./top/"] {
            exclude.add(pattern).unwrap();
        }
        exclude.ready();
        for out in ["vendor/a.frag", "x/vendor/b/c.frag", "gen/a.frag", "deep/a.wgsl", "top/a.vert"]
        {
            assert!(exclude.takes(out), "{out}");
        }
        for kept in ["vendored/a.frag", "x/gen/a.frag", "gen/deep/a.frag", "x/top/a.vert"] {
            assert!(!exclude.takes(kept), "{kept}");
        }
        assert!(Exclude::default().add("a[").is_err());
    }
}
