//! Checks one shader: reads it, lays it out, runs lints, compares its lock; or reuses the cache.

use landfall_ir::threads::Weighed;
use landfall_layout::diagnostic::Code;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

use landfall_layout::finding::{Finding, Level};
use landfall_layout::source;
use landfall_layout::source::{Files, OpenFiles};
use landfall_layout::{Diagnostic, Error, Language, Options, Severity, ShaderLayout, Source, lock};
use landfall_lint::allow::{Allow, allows, suppress};
use landfall_lint::digest::digest;
use landfall_lint::run::MAX_ERRORS;
use landfall_lint::{Subject, levels, run};
use serde::{Deserialize, Serialize};

use crate::against::Against;
use crate::basis::Basis;
use crate::caught::caught;
use crate::config::Config;
use crate::digests::Digests;
use crate::given_names::GivenNames;
use crate::hash::Hash;
use crate::inputs::Input;
use crate::lock_file::{LockComparison, LockFile, drift};
use crate::policies;
use crate::stamp::Stamp;
use crate::templates::Templates;

/// Sorts results by the paths of their shaders.
pub fn sort_by_path(results: &mut [&Checked]) {
    results.sort_by(|a, b| a.path.cmp(&b.path));
}

/// The results for one shader, without its layout.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Checked {
    /// The path in messages.
    pub path: String,
    /// The hash of its bytes.
    pub hash: Hash,
    /// Its includes with the hashes of their bytes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub includes: Vec<(String, Hash)>,
    /// Missing files that would take precedence over includes if they existed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub absent: Vec<String>,
    /// The hash of its lock's bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lock: Option<Hash>,
    /// The stamps of the shader, its includes and its lock; none if one of them is not settled.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stamps: Vec<Stamp>,
    /// The names of the command line that it has.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub constants: Vec<String>,
    /// Whether errors prevented the lints.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub failed: bool,
    /// The findings, except those its comments allow.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub findings: Vec<Finding>,
    #[serde(default, skip_serializing_if = "Digests::is_empty")]
    pub blocks: Digests,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub allows: Vec<Allow>,
}

/// Earlier results by path. Boxed: tables of thousands of results would be moved while they grow.
pub type Known = HashMap<String, Box<Checked>>;

impl Checked {
    /// The shader and its includes.
    pub fn files(&self) -> impl Iterator<Item = &String> + Clone {
        std::iter::once(&self.path).chain(self.includes.iter().map(|(path, _)| path))
    }
}

/// The settings shared by all shaders of a pass.
pub struct ShaderCheck<'a> {
    pub basis: &'a Basis,
    /// The layout options of GLSL and of WGSL.
    pub options: [Options; 2],
    pub config: &'a Config,
    /// The names whose effect is recorded.
    pub names: &'a GivenNames,
    /// The revision that layouts are compared with instead of locks.
    pub against: Option<&'a Against>,
    pub known: &'a Known,
    /// Texts that replace the files of these paths.
    pub texts: &'a HashMap<String, String>,
    /// Texts that replace all files of these paths, as those of an editor.
    pub open: Option<&'a OpenFiles>,
    /// Whether to write locks for changed layouts.
    pub accept: bool,
    /// Hashes of files included by several shaders.
    pub hashes: Mutex<HashMap<String, Option<Hash>>>,
    /// When the check began.
    pub began: SystemTime,
    pub templates: Templates,
}

/// The result for one input.
pub enum InputResult {
    /// Unchanged since the earlier result, with new stamps if those were not.
    Same(String, Option<Vec<Stamp>>),
    Fresh(Box<FreshResult>),
    /// Not a file, or a directory that cannot be searched.
    NoInput(Box<Finding>),
    /// A template that a search found.
    Template,
}

/// A newly checked shader.
pub struct FreshResult {
    pub checked: Checked,
    /// Its layout, for lints over all shaders.
    pub laid_out: Option<(Source, ShaderLayout)>,
    /// The path and text of the lock to write, if any.
    pub lock: Option<(PathBuf, String)>,
    /// Whether a policy forbids to write it.
    pub is_kept: bool,
}

impl Weighed for InputResult {
    fn bytes(&self) -> usize {
        match self {
            InputResult::Same(path, _) => path.len(),
            InputResult::NoInput(_) | InputResult::Template => 256,
            InputResult::Fresh(fresh) => fresh.weight(),
        }
    }
}

impl FreshResult {
    /// Approximate bytes of memory: a layout takes several times its text.
    pub fn weight(&self) -> usize {
        let text = self.laid_out.as_ref().map_or(0, |(source, _)| source.text.len());
        4096 + 6 * text + 512 * self.checked.findings.len()
    }
}

impl ShaderCheck<'_> {
    pub fn check(&self, input: Result<Input, Error>) -> InputResult {
        let input = match input {
            Ok(input) => input,
            Err(error) => {
                let found = Diagnostic { code: Code::NoInput, ..error.into() };
                return InputResult::NoInput(Box::new(found.located(&Files::default())));
            }
        };
        let path = input.path.clone();
        let shown = self.shown(&path);
        let lock_path = self.lock_path(&shown);
        // From the cheapest to the dearest: stamps, hashes, a new layout.
        let known = self.known.get(&shown);
        if let Some(known) = known.filter(|known| self.is_untouched(known, lock_path.as_deref())) {
            // The shader is not read, so that its names are taken from the earlier result.
            self.names.found(&known.constants);
            return InputResult::Same(shown, None);
        }
        let bytes = match (self.texts.get(&shown), self.open_text(&path)) {
            (Some(text), _) => Ok(text.clone().into_bytes()),
            (None, Some(text)) => Ok(text.as_bytes().to_vec()),
            (None, None) => source::read_bytes(&path, self.basis.max_bytes()),
        };
        let bytes = match bytes {
            Ok(bytes) => bytes,
            Err(error) => {
                return InputResult::Fresh(Box::new(failed(&shown, Hash::default(), error.into())));
            }
        };
        let hash = Hash::from_bytes(&bytes);
        // A revision takes the place of locks.
        let lock = self.at_revision(&shown).or_else(|| lock_path.map(LockFile::read));
        if let Some(known) = known {
            if known.hash == hash && self.is_same(known, lock.as_ref()) {
                self.names.found(&known.constants);
                let lock = lock.as_ref().map(|lock| lock.path.as_path());
                let stamps = self.stamps(known.files(), lock.filter(|_| known.lock.is_some()));
                let is_new = !stamps.is_empty() && stamps != known.stamps;
                return InputResult::Same(shown, is_new.then_some(stamps));
            }
        }
        let source = match self.basis.source(&shown, bytes) {
            Ok(source) => source,
            Err(error) if self.templates.passes_over(&input, &error) => {
                return InputResult::Template;
            }
            Err(error) => return InputResult::Fresh(Box::new(failed(&shown, hash, error.into()))),
        };
        let work = || self.look(source, hash, lock);
        // A panic in one shader must not end the check of the others.
        let done = caught(&shown, work);
        InputResult::Fresh(Box::new(
            done.unwrap_or_else(|found| failed(&shown, Hash::default(), found)),
        ))
    }

    fn open_text(&self, path: &Path) -> Option<&Arc<str>> {
        self.open.and_then(|open| open.text(path))
    }

    fn is_open<'a>(&self, mut files: impl Iterator<Item = &'a String>) -> bool {
        files.any(|file| self.open_text(Path::new(file)).is_some())
    }

    fn shown(&self, path: &Path) -> String {
        let given = path.display().to_string();
        // Stdin is found by its substitute path.
        if self.texts.contains_key(&given) { given } else { self.config.root.show(path) }
    }

    /// The lock that a shader would have had at the revision to compare with.
    fn at_revision(&self, shown: &str) -> Option<LockFile> {
        let old = self.against?.layout(shown, &self.config.root, self.basis);
        let bytes = old.as_ref().map(|old| lock::renew(old, None).into_bytes());
        Some(LockFile { path: PathBuf::new(), bytes: Ok(bytes), old })
    }

    /// The path of a shader's lock, if locks are checked.
    fn lock_path(&self, shown: &str) -> Option<PathBuf> {
        // Without those lints, locks need not be read.
        let quiet = |code| levels::level(code, &self.basis.settings) == Level::Allow;
        if quiet("layout-drift") && quiet("lock-missing") {
            return None;
        }
        self.basis.scope.lock_of(shown, &self.config.root)
    }

    /// The stamps of a shader with its includes, and of its lock if it has one; none if one of them
    /// is not settled.
    fn stamps<'a>(
        &self,
        files: impl Iterator<Item = &'a String> + Clone,
        lock: Option<&'a Path>,
    ) -> Vec<Stamp> {
        let settled = |path: &Path| Stamp::settled(path, self.began);
        if self.is_open(files.clone()) {
            // What was checked is not, or not yet, what the files hold.
            return Vec::new();
        }
        let stamps = files.map(Path::new).chain(lock).map(settled);
        stamps.collect::<Option<Vec<Stamp>>>().unwrap_or_default()
    }

    /// Whether no file that a result depends on was touched since.
    fn is_untouched(&self, known: &Checked, lock: Option<&Path>) -> bool {
        // A lock that was missing must be missing still, and no other takes its place.
        let lock_is_there = match lock {
            None => known.lock.is_none(),
            Some(lock) => known.lock.is_some() || is_missing(lock),
        };
        let lock = lock.filter(|_| known.lock.is_some());
        let files = known.files().map(Path::new).chain(lock);
        // What a revision names may change without any file.
        self.against.is_none()
            && !known.stamps.is_empty()
            && lock_is_there
            && !self.texts.contains_key(&known.path)
            && !self.is_open(known.files())
            && self.is_reusable(known)
            && known.stamps.len() == files.clone().count()
            && files
                .zip(&known.stamps)
                .all(|(path, stamp)| Stamp::from_path(path).as_ref() == Some(stamp))
    }

    /// Whether the includes and lock of a shader with unchanged bytes are unchanged.
    fn is_same(&self, known: &Checked, lock: Option<&LockFile>) -> bool {
        let lock = match lock.map(|lock| &lock.bytes) {
            None => None,
            Some(Ok(bytes)) => bytes.as_deref().map(Hash::from_bytes),
            Some(Err(_)) => return false,
        };
        self.is_reusable(known)
            && known.lock == lock
            && known.includes.iter().all(|(path, hash)| self.hash(path).as_ref() == Some(hash))
    }

    /// Whether a result may be reused at all, if its files are unchanged.
    fn is_reusable(&self, known: &Checked) -> bool {
        let to_accept = self.accept && known.findings.iter().any(is_drift);
        !known.failed && !to_accept && !known.absent.iter().any(|path| Path::new(path).exists())
    }

    /// The hash of a file, cached for other shaders that include it.
    fn hash(&self, path: &str) -> Option<Hash> {
        let mut hashes = self.hashes.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(hash) = hashes.get(path) {
            return hash.clone();
        }
        let hash = match self.open_text(Path::new(path)) {
            Some(text) => Some(Hash::from_bytes(text.as_bytes())),
            None => {
                let bytes = source::read_bytes(Path::new(path), self.basis.max_bytes());
                bytes.ok().map(|bytes| Hash::from_bytes(&bytes))
            }
        };
        hashes.insert(path.to_string(), hash.clone());
        hash
    }

    fn look(&self, source: Source, hash: Hash, lock: Option<LockFile>) -> FreshResult {
        let options = match source.language {
            Language::Glsl | Language::SpirV => &self.options[0],
            Language::Wgsl => &self.options[1],
        };
        let mut shader = self.basis.settings.layout(&source, options);
        let options = &self.basis.settings.own_options(&source, options);
        let constants = self.names.in_shader(&shader);
        self.names.found(&constants);
        let settings = &self.basis.settings;
        let (errors, warnings): (Vec<&Diagnostic>, Vec<&Diagnostic>) =
            shader.diagnostics.iter().partition(|d| d.severity == Severity::Error);
        let mut findings: Vec<Finding> =
            warnings.into_iter().map(|d| d.located(&shader.files)).collect();
        let mut failed: Vec<Finding> = Vec::new();
        let (mut new_lock, mut is_kept) = (None, false);
        let mut lock_hash = None;
        let lock_path = lock.as_ref().map(|lock| lock.path.clone());
        let mut allowed = allows(&shader.files, shader.language);
        if errors.is_empty() {
            let subject = Subject { source: &source, options, shader: &shader };
            if let Some(lock) = lock {
                let path = lock.path.clone();
                match self.drift(&shader, lock) {
                    Ok(LockComparison { hash, lock: old, found }) => {
                        // Allowed changes are no reason to write a lock.
                        let mut drifted = levels::at_levels(found, settings);
                        suppress(&mut drifted, &mut allowed);
                        lock_hash = hash;
                        let to_accept = self.accept && drifted.iter().any(is_drift);
                        is_kept = to_accept
                            && old
                                .as_ref()
                                .is_some_and(|old| policies::forbids(self.config, &shader, old));
                        if to_accept && !is_kept {
                            // The renewed lock keeps what the old one says besides the layout.
                            let text = lock::renew(&shader, old.as_ref());
                            lock_hash = Some(Hash::from_bytes(text.as_bytes()));
                            new_lock = Some((path, text));
                        } else {
                            findings.extend(drifted);
                        }
                    }
                    Err(error) => {
                        let found = Diagnostic { code: Code::UnreadableLock, ..error.into() };
                        failed.push(found.located(&Files::default()));
                    }
                }
            }
            findings = levels::at_levels(findings, settings);
            findings.extend(run::shader_unsuppressed(&subject, settings));
        } else {
            findings = levels::at_levels(findings, settings);
            failed.extend(errors.iter().take(MAX_ERRORS).map(|d| d.located(&shader.files)));
            // The number of the rest is told, as a broken include may give thousands.
            if let (Some(last), true) = (failed.last_mut(), errors.len() > MAX_ERRORS) {
                last.notes.push(format!("and {} more errors", errors.len() - MAX_ERRORS));
            }
        }
        suppress(&mut findings, &mut allowed);
        let is_failed = !failed.is_empty();
        findings.extend(failed);
        let includes = self.includes(&shader);
        let files = std::iter::once(&source.path).chain(includes.iter().map(|(path, _)| path));
        let stamps = match self.texts.contains_key(&source.path) || new_lock.is_some() {
            // What was checked is not, or not yet, what the files hold.
            true => Vec::new(),
            false => self.stamps(files, lock_path.as_deref().filter(|_| lock_hash.is_some())),
        };
        // Lints over all shaders need no variants.
        shader.variants = Vec::new();
        let checked = Checked {
            path: source.path.clone(),
            hash,
            absent: self.absent(&source.path, &includes),
            includes,
            lock: lock_hash,
            stamps,
            constants,
            failed: is_failed,
            findings,
            // A shader with errors has no blocks to compare.
            blocks: if is_failed { Digests::default() } else { digest(&shader).into() },
            allows: allowed,
        };
        FreshResult {
            checked,
            laid_out: (!is_failed).then_some((source, shader)),
            lock: new_lock,
            is_kept,
        }
    }

    /// The includes of a shader and its variants, with the hashes of their bytes.
    fn includes(&self, shader: &ShaderLayout) -> Vec<(String, Hash)> {
        let mut includes: Vec<(String, Hash)> = Vec::new();
        // Macros of the command line are files of this name.
        let files = shader.all_files().skip(1).filter(|file| !file.path.starts_with("-D "));
        for file in files {
            if includes.iter().all(|(path, _)| *path != file.path) {
                // A file that has vanished has no hash, so the shader is checked again next time.
                includes.push((file.path.clone(), self.hash(&file.path).unwrap_or_default()));
            }
        }
        includes
    }

    /// Compares a shader with its lock, or with its layout at a revision.
    fn drift(&self, shader: &ShaderLayout, lock: LockFile) -> Result<LockComparison, Error> {
        let bytes = lock.bytes?;
        let Some(against) = self.against else { return drift(shader, &lock.path, bytes) };
        let found = lock.old.map(|old| against.findings(shader, &old)).unwrap_or_default();
        Ok(LockComparison { hash: bytes.as_deref().map(Hash::from_bytes), lock: None, found })
    }

    /// Missing files that would take precedence if they existed: the names of the includes beside
    /// every file of the shader and in every include directory.
    fn absent(&self, shader: &str, includes: &[(String, Hash)]) -> Vec<String> {
        if includes.is_empty() {
            return Vec::new();
        }
        let files = std::iter::once(shader).chain(includes.iter().map(|(path, _)| path.as_str()));
        let beside = files.filter_map(|path| Path::new(path).parent());
        let include_dirs = self.basis.options.read.include_dirs.iter().map(PathBuf::as_path);
        let mut dirs: Vec<&Path> = beside.chain(include_dirs).collect();
        dirs.sort_unstable();
        dirs.dedup();
        let mut absent = Vec::new();
        for (include, _) in includes {
            for name in dirs.iter().filter_map(|dir| Path::new(include).strip_prefix(dir).ok()) {
                // Where the include would be found instead, or too.
                let others = dirs.iter().map(|dir| dir.join(name));
                absent.extend(
                    others.filter(|path| !path.exists()).map(|path| path.display().to_string()),
                );
            }
        }
        absent.sort_unstable();
        absent.dedup();
        absent
    }
}

fn is_missing(path: &Path) -> bool {
    path.symlink_metadata().is_err_and(|cause| cause.kind() == std::io::ErrorKind::NotFound)
}

fn is_drift(finding: &Finding) -> bool {
    finding.code == "layout-drift" || finding.code == "lock-missing"
}

/// The result for a shader that cannot be read.
fn failed(path: &str, hash: Hash, found: Diagnostic) -> FreshResult {
    let checked = Checked {
        path: path.to_string(),
        hash,
        failed: true,
        findings: vec![found.located(&Files::default())],
        ..Checked::default()
    };
    FreshResult { checked, laid_out: None, lock: None, is_kept: false }
}
