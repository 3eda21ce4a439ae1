//! One shader: read, laid out, asked about, held against its lock; or found unchanged.

use landfall_layout::diagnostic::Code;
use std::collections::HashMap;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use landfall_layout::finding::{Finding, Level, Place};
use landfall_layout::lock::Lock;
use landfall_layout::source;
use landfall_layout::source::Files;
use landfall_layout::{Diagnostic, Error, Language, Options, Severity, ShaderLayout, Source, lock};
use landfall_lint::allow::{Allow, allows, suppress};
use landfall_lint::digest::{BlockDigest, digest};
use landfall_lint::{Subject, levels, run};
use serde::{Deserialize, Serialize};

use super::basis::Basis;
use super::hash::Hash;
use crate::config::Root;
use crate::given;
use crate::inputs::Input;
use crate::work::Weighed;

/// Errors reported of one shader.
const MOST_ERRORS: usize = 100;

/// What a check knows of one shader: all that is needed once its layout is forgotten.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Checked {
    /// The path as messages print it.
    pub path: String,
    /// The hash of its bytes.
    pub hash: Hash,
    /// Its includes with the hashes of their bytes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub includes: Vec<(String, Hash)>,
    /// Files that would be included instead if they were there.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub absent: Vec<String>,
    /// The hash of its lock's bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lock: Option<Hash>,
    /// The values of `-O` that it has constants for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub constants: Vec<String>,
    /// Whether no lint could be asked.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub failed: bool,
    /// What was found in it, without what its comments allow.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub findings: Vec<Finding>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub blocks: Vec<BlockDigest>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub allows: Vec<Allow>,
}

impl Checked {
    /// The shader and its includes.
    pub fn files(&self) -> impl Iterator<Item = &String> {
        std::iter::once(&self.path).chain(self.includes.iter().map(|(path, _)| path))
    }
}

/// What is the same for all shaders of a pass.
pub struct Job<'a> {
    pub basis: &'a Basis,
    /// How texts are laid out: those of GLSL, those of WGSL.
    pub options: [Options; 2],
    pub root: &'a Root,
    /// What is known from before, by path.
    pub known: &'a HashMap<String, Checked>,
    /// Texts that stand for the files of these paths.
    pub texts: &'a HashMap<String, String>,
    /// Whether locks are to be written where layouts have drifted.
    pub accept: bool,
    /// Hashes of files that several shaders include.
    pub hashes: Mutex<HashMap<String, Option<Hash>>>,
}

/// What became of one input.
pub enum Done {
    /// Nothing has changed since it was last looked at.
    Same(String),
    Fresh(Box<Fresh>),
    /// It is no file, or a folder that cannot be searched.
    NoInput(Box<Finding>),
}

/// A shader that was looked at.
pub struct Fresh {
    pub checked: Checked,
    /// Its layout, for lints that look at all shaders.
    pub laid_out: Option<(Source, ShaderLayout)>,
    /// Its lock as it should be, where that is to be written.
    pub lock: Option<(PathBuf, String)>,
}

/// The lock of a shader: where it is, and its bytes if it is there.
struct LockFile {
    path: PathBuf,
    bytes: Result<Option<Vec<u8>>, Error>,
}

impl Weighed for Done {
    fn bytes(&self) -> usize {
        match self {
            Done::Same(path) => path.len(),
            Done::NoInput(_) => 256,
            Done::Fresh(fresh) => fresh.weight(),
        }
    }
}

impl Fresh {
    /// Bytes of memory, roughly: a layout takes several times its text.
    pub fn weight(&self) -> usize {
        let text = self.laid_out.as_ref().map_or(0, |(source, _)| source.text.len());
        4096 + 6 * text + 512 * self.checked.findings.len()
    }
}

impl Job<'_> {
    pub fn one(&self, input: Result<Input, Error>) -> Done {
        let path = match input {
            Ok(input) => input.path,
            Err(error) => {
                let found = Diagnostic { code: Code::NoInput, ..error.into() };
                return Done::NoInput(Box::new(of_diagnostic(&found, &Files::default())));
            }
        };
        let shown = self.shown(&path);
        let bytes = match self.texts.get(&shown) {
            Some(text) => Ok(text.clone().into_bytes()),
            None => source::read_bytes(&path, self.basis.max_bytes()),
        };
        let bytes = match bytes {
            Ok(bytes) => bytes,
            Err(error) => {
                return Done::Fresh(Box::new(failed(&shown, Hash::default(), error.into())));
            }
        };
        let hash = Hash::of(&bytes);
        let lock = self.lock(&shown);
        if let Some(known) = self.known.get(&shown) {
            if known.hash == hash && self.is_same(known, lock.as_ref()) {
                given::saw_names(&known.constants);
                return Done::Same(shown);
            }
        }
        let source = match self.basis.source(&shown, bytes) {
            Ok(source) => source,
            Err(error) => return Done::Fresh(Box::new(failed(&shown, hash, error.into()))),
        };
        let work = || self.look(source, hash, lock);
        Done::Fresh(Box::new(catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| {
            let error = Error::new(&*shown, "made landfall panic: this is its fault")
                .with_help("please report it with the file; the other files are not affected");
            failed(
                &shown,
                Hash::default(),
                Diagnostic { code: Code::InternalError, ..error.into() },
            )
        })))
    }

    fn shown(&self, path: &Path) -> String {
        let given = path.display().to_string();
        // Stdin goes by the name that its text is kept under.
        if self.texts.contains_key(&given) { given } else { self.root.show(path) }
    }

    /// The lock of a shader, where locks count.
    fn lock(&self, shown: &str) -> Option<LockFile> {
        let locks = self.basis.locks.as_ref()?;
        let quiet = |code| levels::level(code, &self.basis.settings) == Level::Allow;
        if quiet("layout-drift") && quiet("lock-missing") {
            return None;
        }
        let below = self.root.below(Path::new(shown))?;
        let path = lock::path_of(Path::new(locks), Path::new(&below));
        // A pipe would be waited for.
        let is_other = |found: fs::Metadata| !found.is_file() && !found.is_dir();
        if fs::metadata(&path).is_ok_and(is_other) {
            let bytes = Err(Error::new(path.display().to_string(), "is no file"));
            return Some(LockFile { path, bytes });
        }
        let bytes = match fs::read(&path) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(cause) if cause.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(cause) => {
                let message = format!("cannot be read: {}", landfall_layout::file::reason(&cause));
                Err(Error::new(path.display().to_string(), message))
            }
        };
        Some(LockFile { path, bytes })
    }

    /// Whether a shader whose own bytes are the same has the same includes and lock.
    fn is_same(&self, known: &Checked, lock: Option<&LockFile>) -> bool {
        let lock = match lock.map(|lock| &lock.bytes) {
            None => None,
            Some(Ok(bytes)) => bytes.as_deref().map(Hash::of),
            Some(Err(_)) => return false,
        };
        let to_accept = self.accept && known.findings.iter().any(is_drift);
        !known.failed
            && !to_accept
            && known.lock == lock
            && known.includes.iter().all(|(path, hash)| self.hash(path).as_ref() == Some(hash))
            && !known.absent.iter().any(|path| Path::new(path).exists())
    }

    /// The hash of a file that may be included by many.
    fn hash(&self, path: &str) -> Option<Hash> {
        let mut hashes = self.hashes.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(hash) = hashes.get(path) {
            return hash.clone();
        }
        let bytes = source::read_bytes(Path::new(path), self.basis.max_bytes());
        let hash = bytes.ok().map(|bytes| Hash::of(&bytes));
        hashes.insert(path.to_string(), hash.clone());
        hash
    }

    fn look(&self, source: Source, hash: Hash, lock: Option<LockFile>) -> Fresh {
        let options = match source.language {
            Language::Glsl => &self.options[0],
            Language::Wgsl => &self.options[1],
        };
        let shader = landfall_layout::layout(&source, options);
        let constants = given::known(&shader.files);
        given::saw_names(&constants);
        let settings = &self.basis.settings;
        let (errors, warnings): (Vec<&Diagnostic>, Vec<&Diagnostic>) =
            shader.diagnostics.iter().partition(|d| d.severity == Severity::Error);
        let mut findings: Vec<Finding> =
            warnings.into_iter().map(|d| of_diagnostic(d, &shader.files)).collect();
        let mut failed: Vec<Finding> = Vec::new();
        let mut new_lock = None;
        let mut lock_hash = None;
        let mut allowed = allows(&shader.files, shader.language);
        if errors.is_empty() {
            let subject = Subject { source: &source, options, shader: &shader };
            if let Some(LockFile { path, bytes }) = lock {
                match bytes.and_then(|bytes| drift(&shader, &path, bytes)) {
                    Ok(Against { hash, lock: old, found }) => {
                        let mut drifted = levels::at_levels(found, settings);
                        suppress(&mut drifted, &mut allowed);
                        lock_hash = hash;
                        if self.accept && drifted.iter().any(is_drift) {
                            let text = lock::renew(&shader, old.as_ref());
                            lock_hash = Some(Hash::of(text.as_bytes()));
                            new_lock = Some((path, text));
                        } else {
                            findings.extend(drifted);
                        }
                    }
                    Err(error) => failed.push(of_diagnostic(
                        &Diagnostic { code: Code::UnreadableLock, ..error.into() },
                        &Files::default(),
                    )),
                }
            }
            findings = levels::at_levels(findings, settings);
            findings.extend(run::ask_shader(&subject, settings));
        } else {
            findings = levels::at_levels(findings, settings);
            failed.extend(errors.iter().take(MOST_ERRORS).map(|d| of_diagnostic(d, &shader.files)));
            if let (Some(last), true) = (failed.last_mut(), errors.len() > MOST_ERRORS) {
                last.notes.push(format!("and {} more errors", errors.len() - MOST_ERRORS));
            }
        }
        suppress(&mut findings, &mut allowed);
        let is_failed = !failed.is_empty();
        findings.extend(failed);
        let includes: Vec<(String, Hash)> = shader
            .files
            .iter()
            .skip(1)
            // Macros of the command line have a text too, by this name.
            .filter(|file| !file.path.starts_with("-D "))
            // A file that is gone by now has no hash, and makes the shader new next time.
            .map(|file| (file.path.clone(), self.hash(&file.path).unwrap_or_default()))
            .collect();
        let checked = Checked {
            path: source.path.clone(),
            hash,
            absent: self.absent(&source.path, &includes),
            includes,
            lock: lock_hash,
            constants,
            failed: is_failed,
            findings,
            blocks: if is_failed { Vec::new() } else { digest(&shader) },
            allows: allowed,
        };
        Fresh { checked, laid_out: (!is_failed).then_some((source, shader)), lock: new_lock }
    }

    /// Files that are not there, but would be included if they were: the same names beside every
    /// file of the shader and in every include directory.
    fn absent(&self, shader: &str, includes: &[(String, Hash)]) -> Vec<String> {
        if includes.is_empty() {
            return Vec::new();
        }
        let files = std::iter::once(shader).chain(includes.iter().map(|(path, _)| path.as_str()));
        let beside = files.filter_map(|path| Path::new(path).parent());
        let mut dirs: Vec<&Path> = beside.chain(self.basis.include_dirs()).collect();
        dirs.sort_unstable();
        dirs.dedup();
        let mut absent = Vec::new();
        for (include, _) in includes {
            for name in dirs.iter().filter_map(|dir| Path::new(include).strip_prefix(dir).ok()) {
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

fn is_drift(finding: &Finding) -> bool {
    finding.code == "layout-drift" || finding.code == "lock-missing"
}

/// A shader against its lock: the hash of the lock's bytes, the lock, and what has drifted.
struct Against {
    hash: Option<Hash>,
    lock: Option<Lock>,
    found: Vec<Finding>,
}

/// Holds a shader against its lock. One that cannot be read, a
/// newer landfall's among them, is an error, so that nothing is written over it.
fn drift(shader: &ShaderLayout, path: &Path, bytes: Option<Vec<u8>>) -> Result<Against, Error> {
    let shown = crate::config::slashes(path);
    let Some(bytes) = bytes else {
        let found = landfall_lint::drift::drift(shader, &shown, None);
        return Ok(Against { hash: None, lock: None, found });
    };
    let hash = Hash::of(&bytes);
    let text = source::decode(&shown, bytes)?;
    let lock = lock::read(&shown, &text)?;
    let found = landfall_lint::drift::drift(shader, &shown, Some(&lock));
    Ok(Against { hash: Some(hash), lock: Some(lock), found })
}

/// A shader of which nothing can be told.
fn failed(path: &str, hash: Hash, found: Diagnostic) -> Fresh {
    let checked = Checked {
        path: path.to_string(),
        hash,
        includes: Vec::new(),
        absent: Vec::new(),
        lock: None,
        constants: Vec::new(),
        failed: true,
        findings: vec![of_diagnostic(&found, &Files::default())],
        blocks: Vec::new(),
        allows: Vec::new(),
    };
    Fresh { checked, laid_out: None, lock: None }
}

/// What reading and laying out has to say, as lints say it.
pub fn of_diagnostic(diagnostic: &Diagnostic, files: &Files) -> Finding {
    let mut labels = diagnostic.labels.iter().filter(|label| files.get(label.span.file).is_some());
    let path = diagnostic.path.clone().or_else(|| files.get(0).map(|file| file.path.clone()));
    let path = path.unwrap_or_default();
    let main = labels.next();
    let place = main.map_or_else(|| Place::file(path), |l| Place::of(files, l.span));
    // Whichever shader includes a file, what is said about it is the same.
    let about = place.path.clone();
    let mut finding =
        Finding::new(diagnostic.code.name(), about, place, diagnostic.message.clone());
    finding.level = match diagnostic.severity {
        Severity::Warning => Level::Warn,
        Severity::Error => Level::Deny,
    };
    finding.text = main.map(|label| label.text.clone()).unwrap_or_default();
    for label in labels {
        finding = finding.with_related(Place::of(files, label.span), label.text.clone());
    }
    finding.notes = diagnostic.notes.clone();
    finding.help = diagnostic.help.clone();
    finding
}
