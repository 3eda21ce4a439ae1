//! A pass over all shaders of a check: unchanged ones from the cache, the others anew.

use std::collections::HashMap;
use std::convert::Infallible;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicUsize;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

use landfall_ir::threads;
use landfall_layout::Diagnostic;
use landfall_layout::file::FileWriter;
use landfall_layout::finding::Finding;
use landfall_layout::source::{Files, OpenFiles};
use landfall_layout::{Error, Language, Options, ShaderLayout, Source};

use crate::against::Against;
use crate::basis::Basis;
use crate::check_shader::{Checked, FreshResult, InputResult, Known, ShaderCheck};
use crate::config::Config;
use crate::given_names::GivenNames;
use crate::inputs::Inputs;
use crate::stop::StopFlag;
use crate::templates::Templates;
use crate::walk::Listing;

/// Maximum bytes of layouts kept for lints over all shaders; beyond, layouts are recomputed.
const MAX_KEPT: usize = 256 << 20;

/// The settings shared by all passes of a check.
pub struct CheckRun<'a> {
    pub basis: &'a Basis,
    pub config: &'a Config,
    pub paths: Vec<PathBuf>,
    /// The shaders that the search for Rust files has found, for the first pass.
    pub listing: Mutex<Listing>,
    pub jobs: Option<NonZeroUsize>,
    /// The text of stdin by its substitute path.
    pub stdin: HashMap<String, String>,
    /// Texts that replace all files of these paths, as those of an editor.
    pub open: Option<Arc<OpenFiles>>,
    /// The revision that layouts are compared with instead of locks.
    pub against: Option<&'a Against>,
    /// The names whose effect is recorded.
    pub names: &'a GivenNames,
    pub stop: StopFlag,
    /// Called with the number of shaders checked so far.
    pub progress: Option<&'a (dyn Fn(usize) + Sync)>,
    /// The writer of locks.
    pub locks: FileWriter,
    /// Number of excluded shaders.
    pub excluded: AtomicUsize,
    /// When the check began, before it read any file.
    pub began: SystemTime,
    /// The findings so far of an unfinished pass.
    pub so_far: Arc<Mutex<PartialFindings>>,
}

/// The findings of an unfinished pass.
#[derive(Default)]
pub struct PartialFindings {
    pub findings: Vec<Finding>,
    pub shaders: usize,
    /// Number of shaders and inputs that could not be checked.
    pub failures: usize,
}

impl PartialFindings {
    fn add(&mut self, done: &InputResult, known: &Known) {
        let checked = match done {
            InputResult::NoInput(found) => {
                self.findings.push((**found).clone());
                self.failures += 1;
                return;
            }
            InputResult::Template => return,
            InputResult::Same(path, _) => known.get(path).map(Box::as_ref),
            InputResult::Fresh(fresh) => Some(&fresh.checked),
        };
        self.shaders += 1;
        if let Some(checked) = checked {
            self.failures += usize::from(checked.failed);
            self.findings.extend(checked.findings.iter().cloned());
        }
    }
}

/// The results of a pass.
#[derive(Default)]
pub struct Pass {
    pub checked: Vec<Checked>,
    /// Findings about inputs that are not files or cannot be searched.
    pub no_input: Vec<Finding>,
    /// Findings about templates, which were passed over.
    pub templates: Vec<Finding>,
    /// Layouts by the index of their shader.
    pub laid_out: HashMap<usize, (Source, ShaderLayout)>,
    /// Cached shaders that are not inputs of this pass.
    pub left: Known,
    /// Number of shaders laid out.
    pub fresh: usize,
    /// Number of unchanged shaders with new stamps.
    pub restamped: usize,
    /// Number of locks written.
    pub accepted: usize,
    /// Number of locks that a policy forbids to write.
    pub kept_locks: usize,
    kept: usize,
}

impl<'a> CheckRun<'a> {
    /// A check of these paths on all cores, with locks where the settings name them.
    pub fn new(
        basis: &'a Basis,
        config: &'a Config,
        paths: Vec<PathBuf>,
        names: &'a GivenNames,
    ) -> CheckRun<'a> {
        CheckRun {
            basis,
            config,
            paths,
            listing: Mutex::default(),
            jobs: None,
            stdin: HashMap::new(),
            open: None,
            against: None,
            names,
            stop: StopFlag::default(),
            progress: None,
            locks: FileWriter::default(),
            excluded: AtomicUsize::new(0),
            began: SystemTime::now(),
            so_far: Arc::default(),
        }
    }

    /// Checks all shaders; `texts` replace the files of their paths.
    pub fn pass(&self, mut known: Known, texts: &HashMap<String, String>, accept: bool) -> Pass {
        let mut pass = Pass { checked: Vec::with_capacity(known.len()), ..Pass::default() };
        *self.so_far.lock().unwrap_or_else(PoisonError::into_inner) = PartialFindings::default();
        let mut all = self.stdin.clone();
        all.extend(texts.iter().map(|(path, text)| (path.clone(), text.clone())));
        let mut same = Vec::new();
        let job = ShaderCheck {
            basis: self.basis,
            options: [Language::Glsl, Language::Wgsl]
                .map(|l| self.opened(self.basis.options_for(l))),
            config: self.config,
            names: self.names,
            against: self.against,
            known: &known,
            texts: &all,
            open: self.open.as_deref(),
            accept,
            hashes: Mutex::default(),
            began: self.began,
            templates: Templates::default(),
        };
        let listing =
            std::mem::take(&mut *self.listing.lock().unwrap_or_else(PoisonError::into_inner));
        // In parallel; the results are taken in the order of the inputs.
        let Ok(()) = threads::ordered(
            Inputs::listed(self.paths.clone(), listing, self.stop.clone())
                .filter(|input| self.config.takes_or_counts(input, &self.excluded)),
            self.jobs,
            |input| {
                let done = job.check(input);
                self.so_far.lock().unwrap_or_else(PoisonError::into_inner).add(&done, &known);
                done
            },
            |done| {
                let mut to_drop = None;
                match done {
                    // Moved out of `known` once the threads no longer use it.
                    InputResult::Same(path, stamps) => {
                        pass.restamped += usize::from(stamps.is_some());
                        same.push((pass.checked.len(), path, stamps));
                        pass.checked.push(Checked::default());
                    }
                    InputResult::NoInput(found) => pass.no_input.push(*found),
                    InputResult::Template => {}
                    InputResult::Fresh(mut fresh) => {
                        pass.take(&mut fresh, &self.locks);
                        to_drop = Some(fresh);
                    }
                }
                if let Some(progress) = self.progress {
                    progress(pass.checked.len());
                }
                Ok::<_, Infallible>(to_drop)
            },
        );
        // Where nothing but templates was found, that is the finding.
        let is_all = pass.checked.is_empty() && pass.no_input.is_empty();
        let found = job.templates.findings(is_all);
        let found = found.iter().map(|found| found.located(&Files::default()));
        if is_all { &mut pass.no_input } else { &mut pass.templates }.extend(found);
        for (number, path, stamps) in same {
            if let Some(known) = known.remove(&path) {
                let stamps = stamps.unwrap_or_else(|| known.stamps.clone());
                pass.checked[number] = Checked { stamps, ..*known };
            }
        }
        pass.left = known;
        pass
    }

    /// The layout options, with the texts that replace files.
    pub fn options(&self) -> Options {
        self.opened(self.basis.options.clone())
    }

    fn opened(&self, mut options: Options) -> Options {
        options.read.open_files.clone_from(&self.open);
        options
    }

    /// Reads a shader again.
    pub fn source(&self, path: &str) -> Option<Source> {
        let read = match self.stdin.get(path) {
            Some(text) => self.basis.source(path, text.clone().into_bytes()),
            None => self.basis.read(Path::new(path), self.open.as_deref()),
        };
        read.ok()
    }
}

impl Pass {
    fn take(&mut self, fresh: &mut FreshResult, locks: &FileWriter) {
        let weight = fresh.weight();
        let number = self.checked.len();
        self.fresh += 1;
        self.kept_locks += usize::from(fresh.is_kept);
        self.checked.push(std::mem::take(&mut fresh.checked));
        // Over the limit, layouts are dropped and computed again.
        if fresh.laid_out.is_some() {
            self.kept += weight;
            if self.kept <= MAX_KEPT {
                self.laid_out.extend(fresh.laid_out.take().map(|laid_out| (number, laid_out)));
            }
        }
        if let Some((path, text)) = &fresh.lock {
            match locks.write(path, text) {
                Ok(_) => self.accepted += 1,
                Err(error) => self.fail(number, error),
            }
        }
    }

    fn fail(&mut self, number: usize, error: Error) {
        let checked = &mut self.checked[number];
        let found = Diagnostic::from(error).located(&Default::default());
        checked.failed = true;
        checked.findings.push(found);
    }

    /// Number of shaders and inputs that could not be checked.
    pub fn failures(&self) -> usize {
        self.no_input.len() + self.checked.iter().filter(|checked| checked.failed).count()
    }

    /// The results per shader, for the next pass.
    pub fn into_known(self) -> Known {
        let mut known = self.left;
        known.extend(self.checked.into_iter().map(|c| (c.path.clone(), Box::new(c))));
        known
    }
}
