//! `landfall lock`: writes one lock per shader, only if it changes.

use landfall_check::files;
use landfall_layout::diagnostic::Code;
use std::collections::HashSet;
use std::convert::Infallible;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use landfall_layout::diff::diff_variants;
use landfall_layout::file::{FileWriter, Written};
use landfall_layout::finding::Level;
use landfall_layout::format::phrases::{counted, number};
use landfall_layout::{Diagnostic, Error, Options, Severity, ShaderLayout, lock, unreached_blocks};
use landfall_lint::allow::{allows, suppress};
use landfall_lint::{levels, unreached_block};

use crate::args::LockArgs;
use crate::config;
use crate::output::{CommandFailure, FindingForm, FindingStyle, Outcome, Streams};
use crate::{read, templates, watch, without_effect};
use landfall_check::caught::caught;
use landfall_check::config::Config;
use landfall_check::inputs::{Input, Inputs};
use landfall_check::locks::{holds_lock, locks_below};
use landfall_check::policies::forbidden;
use landfall_check::templates::Templates;
use landfall_check::walk::{is_below, slashes};
use landfall_ir::threads;

pub fn run(args: &LockArgs, streams: &Streams) -> Result<Outcome, CommandFailure> {
    let config = config::load(&args.config, &args.paths, streams)?;
    let paths = config.paths(&args.paths);
    let searched: Vec<String> = paths
        .iter()
        .filter(|path| path.is_dir())
        .filter_map(|path| config.root.below(path))
        .collect();
    let job = LockJob {
        args,
        config: &config,
        locks: config.locks(args.locks.as_deref()),
        options: config.options(&args.read.flags()),
        style: streams.style(FindingForm::Human),
        writer: config.writer(&config.locks(args.locks.as_deref()), args.locks.is_some()),
        excluded: AtomicUsize::new(0),
        templates: Templates::default(),
    };
    // A constant or macro that no shader has can only be told of a run over all of them.
    if args.paths.is_empty() {
        config.give_names(&without_effect::NAMES);
    }
    let mut tally = LockTally::default();
    let Ok(()) = threads::ordered(
        Inputs::new(paths, watch::stop())
            .filter(|input| config.takes_or_counts(input, &job.excluded)),
        args.jobs,
        |input| job.one(input),
        |done| {
            tally.take(&done, &job, streams);
            Ok::<_, Infallible>(done)
        },
    );
    tally.failed |= templates::report(&job.templates, tally.is_empty(), job.style, streams);
    let excluded = job.excluded.load(Ordering::Relaxed);
    if tally.is_empty() && excluded > 0 && !watch::is_stopped() {
        // Named shaders that are all excluded are no mistake, as in a list of changed files from
        // git.
        let found = landfall_check::config::all_excluded(excluded, &[]);
        let (found, outcome) = match args.paths.is_empty() {
            true => (found, Outcome::CouldNot),
            false => (Diagnostic { severity: Severity::Warning, ..found }, Outcome::Clean),
        };
        streams.finding(found);
        return Ok(outcome);
    }
    if !watch::is_stopped() {
        without_effect::warn_of_patterns(&config, args.paths.is_empty(), streams);
    }
    tally.orphans(&job, &searched, streams);
    Ok(tally.finish(args, streams))
}

struct LockJob<'a> {
    args: &'a LockArgs,
    config: &'a Config,
    locks: PathBuf,
    options: Options,
    style: FindingStyle,
    writer: FileWriter,
    /// Number of shaders excluded by the configuration.
    excluded: AtomicUsize,
    templates: Templates,
}

#[derive(Default)]
struct LockedShader {
    /// Whether it is a template that a search found.
    is_template: bool,
    /// The path of its lock; `None` if it has none.
    target: Option<PathBuf>,
    /// The up-to-date lock; `None` if the shader could not be laid out.
    text: Option<String>,
    findings: String,
    /// Whether a policy forbids its changes.
    forbidden: bool,
}

impl threads::Weighed for LockedShader {
    fn bytes(&self) -> usize {
        self.findings.len() + self.text.as_ref().map_or(0, String::len)
    }
}

impl LockJob<'_> {
    fn one(&self, input: Result<Input, Error>) -> LockedShader {
        let found = |error: Error, code| Diagnostic { code, ..error.into() };
        let failed = |target, found: Diagnostic| LockedShader {
            target,
            findings: self.style.one(found),
            ..LockedShader::default()
        };
        let input = match input {
            Ok(input) => input,
            Err(error) => return failed(None, found(error, Code::NoInput)),
        };
        let target = match self
            .config
            .lock_of(&self.locks, &read::message_path(&input.path, &self.args.read))
        {
            Ok(target) => target,
            Err(error) => return failed(None, found(error, Code::NoInput)),
        };
        let source = match templates::source(&self.templates, &input, &self.args.read) {
            Ok(Some(source)) => source,
            Ok(None) => return LockedShader { is_template: true, ..LockedShader::default() },
            Err(error) => return failed(Some(target), error.into()),
        };
        let laid_out = || self.config.settings.layout(&source, &self.options);
        let shader = match caught(&input.path.display().to_string(), laid_out) {
            Ok(shader) => shader,
            Err(found) => return failed(Some(target), found),
        };
        without_effect::record_of(&shader);
        let mut findings = self.style.text(&shader.diagnostics, &shader.files);
        findings.push_str(&self.unlocked(&shader));
        // The policy is checked against the lock on disk, before it is replaced.
        let mut forbidden = String::new();
        let text = if shader.has_errors() {
            None
        } else {
            match old(&target, self.args.force) {
                Ok(old) => {
                    forbidden = self.forbidden(&input.path, old.as_ref(), &shader);
                    findings.push_str(&forbidden);
                    Some(lock::renew(&shader, old.as_ref()))
                }
                Err(error) => {
                    findings.push_str(&self.style.one(error.into()));
                    None
                }
            }
        };
        let (target, forbidden) = (Some(target), !forbidden.is_empty());
        LockedShader { target, text, findings, forbidden, ..LockedShader::default() }
    }

    /// Warnings about variants and blocks of a shader that its lock cannot have.
    fn unlocked(&self, shader: &ShaderLayout) -> String {
        let is_quiet = |code| levels::level(code, &self.config.settings) == Level::Allow;
        let mut text = String::new();
        for variant in &shader.variants {
            let Some(layout) = &variant.layout else { continue };
            let mut errors = layout.diagnostics.iter().filter(|d| d.severity == Severity::Error);
            // Only the first error of a variant is told: the rest are often its consequences.
            let Some(error) = errors.next().filter(|_| !is_quiet("define-changes-layout")) else {
                continue;
            };
            let (name, why) = (variant.name(), &error.message);
            let message =
                format!("the lock lacks the variant `{name}`, which cannot be laid out: {why}");
            // A warning: the lock is written without this variant, and the others are still
            // compared.
            let found = Diagnostic { severity: Severity::Warning, message, ..error.clone() };
            text.push_str(&self.style.text(&[found], &layout.files));
        }
        if shader.has_errors() || is_quiet("unreached-block") {
            return text;
        }
        let blocks = unreached_blocks(shader);
        for of_layout in blocks.chunk_by(|a, b| std::ptr::eq(a.files, b.files)) {
            let files = of_layout[0].files;
            let mut allowed = allows(files, shader.language);
            for block in of_layout {
                // A comment in the shader that allows the lint silences the warning, as in `check`.
                let found = unreached_block::diagnostic(block);
                let mut asked = vec![found.clone().located(files)];
                suppress(&mut asked, &mut allowed);
                if !asked.is_empty() {
                    text.push_str(&self.style.text(&[found], files));
                }
            }
        }
        text
    }

    /// The errors about changes since a shader's lock that the policy for it forbids.
    fn forbidden(&self, path: &Path, old: Option<&lock::Lock>, shader: &ShaderLayout) -> String {
        let mut findings = String::new();
        let path = read::message_path(path, &self.args.read);
        let key = self.config.root.below(&path).unwrap_or_else(|| slashes(&path));
        let policy = self.args.policy.or_else(|| self.config.policy_of(&key));
        // With `--check` nothing is written, so there is no change to forbid.
        let (Some(policy), Some(old), false) = (policy, old, self.args.check) else {
            return findings;
        };
        let old = old.layout();
        for one in diff_variants(&old, shader) {
            for found in forbidden(&path.display().to_string(), policy, &one) {
                findings.push_str(&self.style.one(found));
            }
        }
        findings
    }
}

/// The existing lock. One that cannot be parsed is replaced; one of a newer landfall and a file
/// that is not a lock are errors.
fn old(target: &Path, force: bool) -> Result<Option<lock::Lock>, Error> {
    let Some(bytes) = files::file(target) else { return Ok(None) };
    let shown = target.display().to_string();
    let text = String::from_utf8_lossy(&bytes);
    match lock::read(&shown, &text) {
        Ok(lock) => Ok(Some(lock)),
        Err(error) if lock::is_newer(&text) => Err(error),
        Err(_) if force || bytes.is_empty() || lock::is_lock(&text) => Ok(None),
        Err(_) => Err(Error::new(shown, "has the name of a lock but is not a landfall lock")
            .with_help(
                "move it away, keep locks elsewhere with `--locks DIR`, or overwrite it \
                        with `--force`",
            )),
    }
}

#[derive(Default)]
struct LockTally {
    /// Locks of the processed shaders.
    targets: HashSet<PathBuf>,
    unchanged: usize,
    changed: usize,
    pruned: usize,
    /// Locks that were kept because a policy forbids the change.
    kept: usize,
    failed: bool,
}

impl LockTally {
    fn is_empty(&self) -> bool {
        self.targets.is_empty() && !self.failed
    }

    fn take(&mut self, done: &LockedShader, job: &LockJob<'_>, streams: &Streams) {
        // Templates are told of once, at the end.
        if done.is_template {
            return;
        }
        streams.report(&done.findings);
        if let Some(target) = &done.target {
            self.targets.insert(target.clone());
        }
        let (Some(target), Some(text)) = (&done.target, &done.text) else {
            self.failed = true;
            return;
        };
        if done.forbidden {
            self.kept += 1;
        } else if job.args.check {
            let stale = match files::file(target) {
                Some(there) if there == text.as_bytes() => {
                    self.unchanged += 1;
                    return;
                }
                Some(_) => "is out of date",
                None => "does not exist",
            };
            self.changed += 1;
            let error = Error::new(target.display().to_string(), stale)
                .with_help("run the same command without `--check`, and commit what it writes");
            streams.finding(Diagnostic { code: Code::StaleLock, ..error.into() });
        } else {
            match job.writer.write(target, text) {
                Ok(Written::Changed) => self.changed += 1,
                Ok(Written::Unchanged) => self.unchanged += 1,
                Err(error) => {
                    self.failed = true;
                    streams.finding(Diagnostic { code: Code::CannotWrite, ..error.into() });
                }
            }
        }
    }

    /// Reports or removes locks without a shader in the directories that were searched.
    fn orphans(&mut self, job: &LockJob<'_>, searched: &[String], streams: &Streams) {
        // Of an interrupted or failed run the shaders are not all known.
        if self.failed || watch::is_stopped() {
            return;
        }
        let args = job.args;
        for path in locks_below(&job.locks) {
            let below = path.strip_prefix(&job.locks).map(slashes).unwrap_or_default();
            // Locks outside the searched directories may have shaders.
            let is_searched = searched.iter().any(|folder| is_below(&below, folder));
            if !is_searched || self.targets.contains(&path) || !holds_lock(&path) {
                continue;
            }
            let shown = path.display().to_string();
            // With `--check --prune` the orphan is an error, since the same command without
            // `--check` would remove it.
            if !args.prune || args.check {
                let error = Error::new(shown, "is a lock without a shader")
                    .with_help("remove it with `landfall lock --prune`");
                let severity = if args.prune { Severity::Error } else { Severity::Warning };
                self.pruned += usize::from(args.prune);
                streams.finding(Diagnostic { code: Code::LockOrphan, severity, ..error.into() });
                continue;
            }
            match job.writer.remove(&path) {
                Ok(()) => self.pruned += 1,
                Err(error) => {
                    self.failed = true;
                    streams.finding(Diagnostic { code: Code::CannotWrite, ..error.into() });
                }
            }
        }
    }

    fn finish(self, args: &LockArgs, streams: &Streams) -> Outcome {
        let (did, removed) = match args.check {
            true => ("would change", "to be removed"),
            false => ("written", "removed"),
        };
        let changed = counted(self.changed, "lock");
        let mut text = format!("{changed} {did}, {} unchanged", number(self.unchanged as u64));
        if self.kept > 0 {
            text.push_str(&format!(", {} kept by policy", number(self.kept as u64)));
        }
        if self.pruned > 0 {
            text.push_str(&format!(", {} {removed}", number(self.pruned as u64)));
        }
        streams.notes(&(text + "\n"));
        if self.failed {
            Outcome::CouldNot
        } else if self.kept > 0 || args.check && self.changed + self.pruned > 0 {
            Outcome::Findings
        } else {
            Outcome::Clean
        }
    }
}
