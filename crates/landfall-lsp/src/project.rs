//! A project: a configuration, or a folder without one, and what the last pass over its shaders found.

use std::collections::{BTreeMap, HashMap};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use landfall_check::baseline::Permitted;
use landfall_check::basis::{Basis, CheckScope};
use landfall_check::caught::caught;
use landfall_check::check_shader::{Checked, Known};
use landfall_check::config::{self, Config, ConfigChoice, ConfigError, Flags};
use landfall_check::given_names::GivenNames;
use landfall_check::pass::CheckRun;
use landfall_check::stop::StopFlag;
use landfall_check::texts::Texts;
use landfall_check::tree::{self, Remembered};
use landfall_check::{asserted, compiled, rust};
use landfall_layout::diagnostic::{Code, Label};
use landfall_layout::finding::{Finding, Place};
use landfall_layout::source::{Files, OpenFiles};
use landfall_layout::{Diagnostic, Options, ShaderLayout, Source, lock};
use landfall_lint::rust_mirror::{MirroredStructure, mirrored};

use crate::command_texts::CommandTexts;
use crate::paths::plain;

/// What a check of a project depends on, besides its files.
pub struct CheckSetup {
    pub config: Config,
    pub basis: Basis,
    permitted: Permitted,
    names: GivenNames,
    /// The paths to check; empty where only open documents are checked.
    pub paths: Vec<PathBuf>,
}

/// What a pass over all shaders found.
#[derive(Default)]
pub struct ProjectFindings {
    /// By shader, those of its own.
    pub shaders: BTreeMap<String, ShaderFindings>,
    pub over_all: Vec<Finding>,
    /// The blocks of each shader: name and place.
    pub blocks: HashMap<String, Vec<(String, Place)>>,
    pub mirrors: Vec<MirroredStructure>,
}

/// What a check of one shader found.
#[derive(Clone, Default)]
pub struct ShaderFindings {
    pub findings: Vec<Finding>,
    /// Its includes and imports.
    pub includes: Vec<String>,
}

impl ShaderFindings {
    fn from_checked(checked: &Checked) -> ShaderFindings {
        ShaderFindings {
            findings: checked.findings.clone(),
            includes: checked.includes.iter().map(|(path, _)| plain(path)).collect(),
        }
    }
}

/// What a pass takes from the one before it.
#[derive(Default)]
pub struct PassMemory {
    known: Known,
    over_all: Option<Remembered>,
    blocks: HashMap<String, Vec<(String, Place)>>,
}

impl CheckSetup {
    /// Reads the configuration nearest to a path. Without one, `folder` is checked.
    ///
    /// # Errors
    ///
    /// What is wrong with the configuration.
    pub fn read(
        path: &Path,
        folder: Option<&Path>,
        flags: &Flags,
        open: &OpenFiles,
    ) -> Result<CheckSetup, Vec<Finding>> {
        let located = |found: Diagnostic| vec![found.located(&Files::default())];
        let nearest = [path.to_path_buf()];
        let config = match config::load_open(&ConfigChoice::Nearest, &nearest, open) {
            Ok(config) => config,
            Err(ConfigError::Unreadable(error)) => return Err(located(error.into())),
            Err(ConfigError::Wrong(found, files)) => {
                return Err(found.iter().map(|found| found.located(&files)).collect());
            }
        };
        let named: Vec<PathBuf> = match config.file {
            Some(_) => Vec::new(),
            None => folder.into_iter().map(Path::to_path_buf).collect(),
        };
        let settings = config.settings(&[], flags.targets.as_ref()).map_err(located)?;
        let scope = CheckScope {
            whole: config.file.is_some() || folder.is_some(),
            ..CheckScope::new(&config, &named, None, None)
        };
        let basis = Basis::new(scope, config.options(flags), None, None, settings);
        let permitted = Permitted::open(None, false, &config)
            .map_err(|error| located(Diagnostic { code: Code::NoInput, ..error.into() }))?;
        let paths = match (&config.file, folder) {
            (None, None) => Vec::new(),
            _ => config.paths(&named),
        };
        Ok(CheckSetup { config, basis, permitted, names: GivenNames::new(), paths })
    }

    /// The path of a file as findings have it.
    pub fn shown(&self, path: &Path) -> String {
        self.config.root.show(path)
    }

    /// The layout options, with the texts that stand for files.
    pub fn options(&self, open: &Arc<OpenFiles>) -> Options {
        let mut options = self.basis.options.clone();
        options.read.open_files = Some(Arc::clone(open));
        options
    }

    /// The layout of a shader, with what it reads.
    pub fn layout(&self, shown: &str, open: &Arc<OpenFiles>) -> Option<(Source, ShaderLayout)> {
        let source = self.basis.read(Path::new(shown), Some(open)).ok()?;
        let options = self.options(open).with_interface(true);
        let shader = caught(shown, || self.basis.settings.layout(&source, &options)).ok()?;
        Some((source, shader))
    }

    /// The layout in the lock of a shader.
    pub fn locked(&self, shown: &str) -> Option<ShaderLayout> {
        let path = self.config.lock_of(&self.config.locks(None), Path::new(shown)).ok()?;
        let text = std::fs::read_to_string(path).ok()?;
        lock::read_all(shown, &text).ok()?.first().map(|lock| lock.layout())
    }

    /// Checks one shader; accepts its layout, if asked for. Returns the number of locks written.
    pub fn check_one(
        &self,
        path: &Path,
        open: &Arc<OpenFiles>,
        accept: bool,
    ) -> (Option<ShaderFindings>, usize) {
        let check = self.run_of(path, open);
        let pass = check.pass(Known::new(), &HashMap::new(), accept);
        let found = pass.checked.first().map(ShaderFindings::from_checked);
        let found = found.map(|found| self.at_blocks(&self.shown(path), found, open));
        let found = found.map(|found| ShaderFindings {
            findings: self.permitted.new_of(found.findings, &pass, &check),
            ..found
        });
        (found, pass.accepted)
    }

    fn run_of(&self, path: &Path, open: &Arc<OpenFiles>) -> CheckRun<'_> {
        CheckRun {
            jobs: NonZeroUsize::new(1),
            locks: self.config.writer(&self.config.locks(None), false),
            open: Some(Arc::clone(open)),
            ..CheckRun::new(&self.basis, &self.config, vec![self.shown(path).into()], &self.names)
        }
    }

    /// The page of `report` for one shader, opened at a block.
    pub fn page(
        &self,
        path: &Path,
        open: &Arc<OpenFiles>,
        texts: &CommandTexts,
        block: Option<&str>,
    ) -> String {
        let check = self.run_of(path, open);
        let pass = check.pass(Known::new(), &HashMap::new(), false);
        let findings = pass.checked.iter().flat_map(|checked| checked.findings.clone()).collect();
        let findings = self.permitted.new_of(findings, &pass, &check);
        let places =
            findings.iter().flat_map(|finding| &finding.labels).map(|label| &label.at.path);
        let given = places.filter_map(|path| {
            let text = open.text(Path::new(path))?;
            Some((path.clone(), text.to_string()))
        });
        (texts.page)(&check, &pass, &findings, &Texts::new(given.collect()), block)
    }

    /// The findings, with that about a lock that cannot be read at the first block of its shader.
    fn at_blocks(
        &self,
        shown: &str,
        mut found: ShaderFindings,
        open: &Arc<OpenFiles>,
    ) -> ShaderFindings {
        let is_of_lock = |one: &&mut Finding| one.code == Code::UnreadableLock.name();
        for finding in found.findings.iter_mut().filter(is_of_lock) {
            let Some((_, shader)) = self.layout(shown, open) else { continue };
            let Some(block) = shader.blocks.first() else { continue };
            let at = Place::new(&shader.files, block.span);
            let lock = std::mem::replace(&mut finding.labels[0].at, at);
            finding.labels.push(Label { at: lock, text: "the lock".to_string() });
        }
        found
    }

    /// Checks all shaders, on a thread of its own; `None` if it was stopped.
    pub fn check_all(
        &self,
        open: &Arc<OpenFiles>,
        memory: &mut PassMemory,
        stop: &StopFlag,
    ) -> Option<ProjectFindings> {
        let mut basis = self.basis.clone();
        let mut over_all = Vec::new();
        let mut mirrors = Vec::new();
        let mut listing = Default::default();
        match rust::files(&self.config, &basis.settings, &[], Some(open)) {
            Ok(found) => {
                basis.settings.rust_files = found.files;
                listing = found.listing;
                mirrors = mirrored(&basis.settings);
            }
            Err(error) => {
                let found = Diagnostic { code: Code::BadRust, ..error.into() };
                over_all.push(found.located(&Files::default()));
            }
        }
        let check = CheckRun {
            open: Some(Arc::clone(open)),
            listing: Mutex::new(listing),
            stop: stop.clone(),
            ..CheckRun::new(&basis, &self.config, self.paths.clone(), &self.names)
        };
        let mut pass = check.pass(std::mem::take(&mut memory.known), &HashMap::new(), false);
        if stop.is_set() {
            memory.known = pass.into_known();
            return None;
        }
        for (_, shader) in pass.laid_out.values() {
            let blocks = shader.blocks.iter();
            let places =
                blocks.map(|one| (one.name.to_string(), Place::new(&shader.files, one.span)));
            memory.blocks.insert(shader.path.clone(), places.collect());
        }
        let mut elsewhere = asserted::findings(&pass, &check);
        elsewhere.extend(compiled::findings(&pass, &check));
        over_all.extend(tree::findings_over_all(
            &check,
            &mut pass,
            &mut memory.over_all,
            &elsewhere,
        ));
        over_all.extend(pass.templates.iter().cloned());
        let over_all = self.permitted.new_of(over_all, &pass, &check);
        let shaders = pass.checked.iter().map(|checked| {
            let found = self.at_blocks(&checked.path, ShaderFindings::from_checked(checked), open);
            let findings = self.permitted.new_of(found.findings, &pass, &check);
            (checked.path.clone(), ShaderFindings { findings, ..found })
        });
        let shaders: BTreeMap<String, ShaderFindings> = shaders.collect();
        memory.blocks.retain(|path, _| shaders.contains_key(path));
        memory.known = pass.into_known();
        Some(ProjectFindings { shaders, over_all, blocks: memory.blocks.clone(), mirrors })
    }
}

/// A project of the client's folders.
pub struct Project {
    /// The file of the configuration, or the folder that is checked.
    pub base: PathBuf,
    /// The last that could be read.
    pub setup: Option<Arc<CheckSetup>>,
    /// What is wrong with the configuration as it is now.
    pub faults: Vec<Finding>,
    pub found: ProjectFindings,
    /// Of shaders that were checked since, as they are edited.
    pub since: HashMap<String, ShaderFindings>,
    /// What the next pass takes; `None` while one runs.
    pub memory: Option<PassMemory>,
    /// Whether files have changed since the last pass began.
    pub is_stale: bool,
    /// Increased when the configuration is read.
    pub generation: u64,
}

impl Project {
    pub fn new(base: PathBuf) -> Project {
        Project {
            base,
            setup: None,
            faults: Vec::new(),
            found: ProjectFindings::default(),
            since: HashMap::new(),
            memory: Some(PassMemory::default()),
            is_stale: true,
            generation: 0,
        }
    }

    /// Takes what reading the configuration gave; of a broken one the last good one holds.
    pub fn configure(&mut self, read: Result<CheckSetup, Vec<Finding>>) {
        self.generation += 1;
        match read {
            Ok(setup) => {
                self.setup = Some(Arc::new(setup));
                self.faults.clear();
                self.since.clear();
                self.memory = self.memory.take().map(|_| PassMemory::default());
                self.is_stale = true;
            }
            Err(faults) => self.faults = faults,
        }
    }

    /// What is known of a shader.
    pub fn shader(&self, shown: &str) -> Option<&ShaderFindings> {
        self.since.get(shown).or_else(|| self.found.shaders.get(shown))
    }

    /// The shaders that include or import a file.
    pub fn shaders_with(&self, shown: &str) -> Vec<&str> {
        let includes = |found: &ShaderFindings| found.includes.iter().any(|file| file == shown);
        let of_pass = self.found.shaders.iter().filter(|(path, _)| !self.since.contains_key(*path));
        let since = self.since.iter();
        let mut found: Vec<&str> = of_pass
            .chain(since)
            .filter(|(_, found)| includes(found))
            .map(|(path, _)| path.as_str())
            .collect();
        found.sort_unstable();
        found
    }

    /// All findings, those of edited shaders as they were last checked.
    pub fn findings(&self) -> impl Iterator<Item = &Finding> {
        let of_pass = self.found.shaders.iter();
        let of_pass = of_pass.filter(|(path, _)| !self.since.contains_key(*path));
        let since = self.since.values();
        of_pass
            .map(|(_, found)| found)
            .chain(since)
            .flat_map(|found| &found.findings)
            .chain(&self.found.over_all)
            .chain(&self.faults)
    }
}
