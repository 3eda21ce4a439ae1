//! `landfall check`: checks shaders for lint findings and for changes from their locks.
//!
//! The engine is `landfall-check`; this reads the arguments, runs it, and prints: [`reports`] of
//! the findings, a [`page`], and [`notes`] on what else was done.

pub mod notes;
pub mod page;
mod report_root;
pub mod reports;
mod watched;

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

use landfall::report::unified;
use landfall_check::add_allow;
use landfall_check::against::Against;
use landfall_check::baseline::{JudgedFindings, Permitted};
use landfall_check::basis::{Basis, CheckScope};
use landfall_check::cache::Cache;
use landfall_check::check_shader::{Checked, Known};
use landfall_check::config::Config;
use landfall_check::fix::{self, AppliedFixes};
use landfall_check::pass::{CheckRun, Pass};
use landfall_check::texts::Texts;
use landfall_check::{asserted, compiled, config as configured, files, rust, tree, verified};
use landfall_layout::diagnostic::Code;
use landfall_layout::file::FileWriter;
use landfall_layout::finding::Finding;
use landfall_layout::format::Paint;
use landfall_layout::format::phrases::counted;
use landfall_layout::source::{Files, kind_of_path};
use landfall_layout::{Diagnostic, Error, Severity};
use landfall_lint::Settings;
use landfall_lint::render::ReportFormat;

use crate::args::{CheckArgs, Form, ReadArgs, Report};
use crate::output::{CommandFailure, FindingForm, Outcome, Streams};
use crate::without_effect::{self, NAMES};
use crate::{config, git, read, watch};
use watched::Watched;

pub fn run(args: &CheckArgs, streams: &Streams) -> Result<Outcome, CommandFailure> {
    reports::refuse_twice(&args.formats)?;
    match args.watch {
        true => watched::run(args, streams, |watched| once(args, streams, watched)),
        false => once(args, streams, &mut Watched::default()),
    }
}

// The stages: configuration, Rust files beside the cache, one pass over the shaders, fixes with a
// pass over the result, findings over all shaders, reports.
fn once(
    args: &CheckArgs,
    streams: &Streams,
    watched: &mut Watched,
) -> Result<Outcome, CommandFailure> {
    let began = SystemTime::now();
    let (config, settings) = configuration(args, streams)?;
    let options = config.options(&args.rules.flags(&args.text, &args.levels.defines));
    let paths = config.paths(&args.paths);
    // What was read so far is watched, even if the check fails below.
    watched.paths.clone_from(&paths);
    let scope = CheckScope::new(&config, &args.paths, args.locks.as_deref(), args.against.as_ref());
    let language = args.text.language.map(|language| language.language());
    let mut basis = Basis::new(scope, options, args.text.stage, language, settings);
    let (rust, opened) = read_rust_and_cache(args, &config, &basis);
    let human = streams.style(FindingForm::Human);
    let bad_rust = |error: Error| human.refused(Diagnostic { code: Code::BadRust, ..error.into() });
    let rust::Search { files, listing } = rust.map_err(bad_rust)?;
    basis.settings.rust_files = files;
    // Removed when the check is done.
    let tree = args.against.as_ref().map(|rev| at_revision(rev, &config)).transpose()?;
    let against = args.against.as_ref().zip(tree.as_ref());
    let against = against.map(|(rev, tree)| Against::new(rev, tree.as_deref().cloned(), &basis));
    // The baseline and results of `verify` are inputs, too.
    watched
        .files
        .extend(args.baseline.iter().chain(&config.baseline).chain(&args.verified).cloned());
    let permitted = Permitted::open(args.baseline.as_ref(), args.write_baseline, &config)?;
    let (paths, stdin) = stdin(paths, args)?;
    let locks = config.writer(&config.locks(args.locks.as_deref()), args.locks.is_some());
    let progress =
        |checked: usize| streams.progress(&format!("{} checked", counted(checked, "shader")));
    let check = CheckRun {
        listing: Mutex::new(listing),
        jobs: args.jobs,
        stdin,
        against: against.as_ref(),
        stop: watch::stop(),
        progress: streams.shows_progress().then_some(&progress),
        locks,
        began,
        ..CheckRun::new(&basis, &config, paths, &NAMES) // The known results move into the pass, which takes out what is up to date.
    };
    let mut cache = opened.unwrap_or_default();
    let mut pass = first_pass(args, &check, std::mem::take(&mut cache.known), streams);
    if args.watch {
        watched.files.extend(files_of(&check, &pass));
    }
    let stopped = watch::is_stopped();
    let left_out = left_out(args, &check, &pass, streams).filter(|_| !stopped);
    if !stopped {
        without_effect::warn_of_patterns(&config, args.paths.is_empty(), streams);
        if args.paths.is_empty() && args.exclude.is_empty() {
            without_effect::warn_of_rows(&config, || files_of(&check, &pass), streams);
        }
        // Before the reports, which end with the summary.
        without_effect::finish(streams);
    }
    // `--diff` writes nothing.
    if args.diff {
        let outcome = diff(&check, pass, &mut cache, streams)?;
        return Ok(left_out.unwrap_or(outcome));
    }
    let mut applied = AppliedFixes::default();
    // After Ctrl-C the files stay as they are.
    if !stopped {
        (pass, applied) = edit(args, &check, pass, &mut cache, &permitted);
    }
    let outcome = finish(args, &check, &mut pass, &mut cache, &permitted, streams)?;
    notes::closing(&check, &pass, args, &applied, streams);
    if !args.watch {
        // The process ends: to free thousands of results takes 3 % of a check from the cache.
        std::mem::forget((pass, cache));
    }
    Ok(left_out.unwrap_or(outcome))
}

/// Adds the findings over all shaders, and writes the cache, the baseline and the reports.
fn finish(
    args: &CheckArgs,
    check: &CheckRun<'_>,
    pass: &mut Pass,
    cache: &mut Cache,
    permitted: &Permitted,
    streams: &Streams,
) -> Result<Outcome, CommandFailure> {
    let stopped = watch::is_stopped();
    let findings = match stopped {
        // Of an interrupted run, the findings of lints over all shaders are not all known.
        true => tree::sorted(tree::findings_in_shaders(pass)),
        false => findings(args, check, pass, cache, streams)?,
    };
    // Written once something was laid out anew; an unwritable cache slows the next check and fails
    // none.
    if !stopped && cache.is_stale(pass, args.fix || args.add_allow) {
        let unused = |error| streams.notes(&format!("the cache is not used: {error}\n"));
        cache.write(pass).unwrap_or_else(unused);
    }
    let texts = Texts::new(check.stdin.clone());
    let writer = inputs(args, check, pass);
    let judged = match stopped {
        true => JudgedFindings { findings, ..JudgedFindings::default() },
        false => permitted.judge(findings, pass, check, &texts, &writer)?,
    };
    notes::of_baseline(&judged, args, check.config, streams);
    let result = reports::Result {
        findings: &judged.findings,
        shaders: pass.checked.len(),
        failures: pass.failures(),
        texts: &texts,
        permitted: judged.permitted,
        page: Some(&|| {
            let title = if args.is_report { "Landfall report" } else { "Landfall check" };
            page::page(title, check, pass, &judged.findings, &texts, None)
        }),
    };
    Ok(reports::write(&result, &args.formats, args.statistics, writer, streams)?)
}

/// The configuration with the flags, and the settings of lints.
fn configuration(
    args: &CheckArgs,
    streams: &Streams,
) -> Result<(Config, Settings), CommandFailure> {
    let mut config = config::load(&args.config, &args.paths, streams)?;
    for pattern in &args.exclude {
        config
            .exclude
            // Patterns of the command line add to those of the file.
            .add(pattern, false)
            .map_err(|cause| configured::bad_glob(pattern, &cause))?;
    }
    let targets = args.text.given_targets();
    let settings = config
        .settings(&args.levels.levels, targets.as_ref())
        .map_err(|found| streams.style(FindingForm::Human).refused(found))?;
    if args.paths.is_empty() {
        // Only a run over everything tells which names of the configuration no shader has.
        config.give_names(&NAMES);
    }
    Ok((config, settings))
}

/// Searches for Rust files with mirrors while the cache is read, which takes as long.
fn read_rust_and_cache(
    args: &CheckArgs,
    config: &Config,
    basis: &Basis,
) -> (Result<rust::Search, Error>, Option<Cache>) {
    std::thread::scope(|scope| {
        let rust = scope.spawn(|| rust::files(config, &basis.settings, &args.paths, None));
        let cache = cache_dir(args, config).map(|folder| {
            Cache::open(folder, basis, config.writer(folder, args.cache_dir.is_some()))
        });
        (rust.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)), cache)
    })
}

/// The directory of caches, if one is used.
fn cache_dir<'a>(args: &'a CheckArgs, config: &'a Config) -> Option<&'a Path> {
    let folder = args.cache_dir.as_deref().or(config.cache_dir.as_deref());
    folder.filter(|_| !args.no_cache)
}

/// The files of the project at a revision; `None` inside if it had no shader then.
fn at_revision(rev: &str, config: &Config) -> Result<Option<git::Tree>, Error> {
    let folder = match config.root.shown.as_os_str().is_empty() {
        true => Path::new("."),
        // The directory of the configuration, since all of its shaders may be compared.
        false => &config.root.shown,
    };
    Ok(git::extract_any(&git::in_repository(rev, folder)?)?.ok())
}

/// Applies `--fix` or `--add-allow`; returns the pass over the final state.
fn edit(
    args: &CheckArgs,
    check: &CheckRun<'_>,
    mut pass: Pass,
    cache: &mut Cache,
    permitted: &Permitted,
) -> (Pass, AppliedFixes) {
    let mut applied = AppliedFixes::default();
    if args.fix {
        (pass, applied) = fix::fix(check, pass, &mut cache.tree);
        // Accepted after the fixes, which change layouts.
        if args.accept {
            pass = check.pass(pass.into_known(), &HashMap::new(), true);
        }
    }
    if args.add_allow {
        let chosen = |found, pass: &Pass| permitted.new_of(found, pass, check);
        (pass, applied) = add_allow::add(check, pass, &mut cache.tree, &chosen);
    }
    for error in &applied.refused {
        let found = Diagnostic { code: Code::CannotWrite, ..error.clone().into() };
        pass.no_input.push(found.located(&Files::default()));
    }
    (pass, applied)
}

/// All findings, with those of lints over all shaders.
fn findings(
    args: &CheckArgs,
    check: &CheckRun<'_>,
    pass: &mut Pass,
    cache: &mut Cache,
    streams: &Streams,
) -> Result<Vec<Finding>, CommandFailure> {
    // Findings that no single shader has.
    let mut outside = verified::findings(&args.verified, pass, check)?;
    outside.extend(asserted::findings(pass, check));
    outside.extend(compiled::findings(pass, check));
    outside.extend(proofs(args, check, pass, streams));
    Ok(tree::findings(check, pass, &mut cache.tree, &outside))
}

/// The findings for `[[prove]]`.
#[cfg(feature = "exec")]
fn proofs(args: &CheckArgs, check: &CheckRun<'_>, pass: &Pass, streams: &Streams) -> Vec<Finding> {
    // After `--fix`, the findings of the first pass are not those of the files.
    if args.fix || check.basis.settings.proofs.is_empty() {
        return landfall_check::proved::findings(pass, check);
    }
    report_on_end(args, check, streams);
    let found = landfall_check::proved::findings(pass, check);
    watch::end_of_work();
    found
}

/// The configuration refuses `[[prove]]` in this build.
#[cfg(not(feature = "exec"))]
fn proofs(_: &CheckArgs, _: &CheckRun<'_>, _: &Pass, _: &Streams) -> Vec<Finding> {
    Vec::new()
}

fn first_pass(args: &CheckArgs, check: &CheckRun<'_>, known: Known, streams: &Streams) -> Pass {
    // Locks are written after all fixes.
    let accept = args.accept && !args.fix;
    if args.diff {
        return check.pass(known, &HashMap::new(), accept);
    }
    report_on_end(args, check, streams);
    let pass = check.pass(known, &HashMap::new(), accept);
    watch::end_of_work();
    pass
}

/// Prints the findings so far if the process is ended in the middle of a shader. Reports to files
/// are not written then.
fn report_on_end(args: &CheckArgs, check: &CheckRun<'_>, streams: &Streams) {
    let (so_far, stdin) = (Arc::clone(&check.so_far), check.stdin.clone());
    let (statistics, streams) = (args.statistics, streams.for_thread());
    let to_stdout = |report: &&Report| report.file.is_none() && report.format != Form::Html;
    // A report to a file is complete or absent.
    let formats: Vec<_> = args.formats.iter().filter(to_stdout).cloned().collect();
    if formats.is_empty() && !args.formats.is_empty() {
        return watch::on_end(|| ());
    }
    watch::on_end(move || {
        let mut so_far = so_far.lock().unwrap_or_else(PoisonError::into_inner);
        let findings = tree::sorted(std::mem::take(&mut so_far.findings));
        let texts = Texts::new(stdin);
        let result = reports::Result {
            findings: &findings,
            shaders: so_far.shaders,
            failures: so_far.failures,
            texts: &texts,
            permitted: None,
            page: None,
        };
        let _ = reports::write(&result, &formats, statistics, FileWriter::default(), &streams);
    });
}

/// Reports that all shaders were excluded; returns the outcome if that is an error.
fn left_out(
    args: &CheckArgs,
    check: &CheckRun<'_>,
    pass: &Pass,
    streams: &Streams,
) -> Option<Outcome> {
    let excluded = check.excluded.load(Ordering::Relaxed);
    let none = pass.checked.is_empty() && pass.no_input.is_empty();
    if !none || excluded == 0 {
        return None;
    }
    let found = configured::all_excluded(excluded, &args.exclude);
    // Named files, as from hooks, may be excluded by the configuration.
    let is_meant = !args.paths.is_empty() && args.exclude.is_empty();
    let severity = if is_meant { Severity::Warning } else { Severity::Error };
    let found = Diagnostic { severity, ..found };
    streams.finding(found);
    (!is_meant).then_some(Outcome::CouldNot)
}

/// The files that a pass read, and those that it would have read if they existed.
fn files_of(check: &CheckRun<'_>, pass: &Pass) -> Vec<PathBuf> {
    let checked = pass.checked.iter();
    let shaders = checked.flat_map(|checked| checked.files().chain(&checked.absent));
    let rust = check.basis.settings.rust_files.iter().map(|file| &file.path);
    let locks = pass.checked.iter().filter_map(|checked| lock_of(check, checked));
    shaders.chain(rust).map(PathBuf::from).chain(locks).collect()
}

fn lock_of(check: &CheckRun<'_>, checked: &Checked) -> Option<PathBuf> {
    check.basis.scope.lock_of(&checked.path, &check.config.root)
}

/// A writer that does not overwrite inputs of the check.
fn inputs(args: &CheckArgs, check: &CheckRun<'_>, pass: &Pass) -> FileWriter {
    // The summary of a step is a file, too.
    let github = Form::Findings(ReportFormat::Github);
    let writes = |report: &Report| report.file.is_some() || report.format == github;
    if !args.formats.iter().any(writes) && !args.write_baseline {
        return FileWriter::default();
    }
    let mut writer = files::writer();
    for checked in &pass.checked {
        // Known files by their device and number, which the pass has read: no further system call.
        let lock = lock_of(check, checked);
        let mut stamps = checked.stamps.iter();
        for file in checked.files().map(Path::new).chain(lock.as_deref()) {
            match stamps.next() {
                Some(stamp) => writer.protect_node(file, stamp.node()),
                None => writer.protect([file]),
            }
        }
    }
    writer.protect(check.basis.settings.rust_files.iter().map(|file| &file.path));
    writer.protect(&args.verified);
    writer.protect(check.config.file.as_deref());
    // Shaders that were not reached before Ctrl-C.
    // A shader may be named as a report by mistake: `--format sarif=shader.frag`.
    let reports = args.formats.iter().filter_map(|report| report.file.as_deref());
    let real = |path: &Path| std::fs::canonicalize(path).unwrap_or_default();
    writer.protect(reports.filter(|path| kind_of_path(&real(path)).is_some()));
    writer.protect(&check.paths);
    writer
}

/// Reads stdin if named, and replaces `-` by its substitute path.
fn stdin(
    paths: Vec<PathBuf>,
    args: &CheckArgs,
) -> Result<(Vec<PathBuf>, HashMap<String, String>), Error> {
    let mut texts = HashMap::new();
    if !paths.iter().any(|path| files::is_stdin(path)) {
        return Ok((paths, texts));
    }
    // A text on stdin has a path like a file, for messages and for the globs of the configuration.
    let read_args = ReadArgs { text: args.text.clone(), ..ReadArgs::default() };
    let name = read::stdin_path(&read_args);
    texts.insert(name.display().to_string(), files::text(Path::new("-"))?);
    let named = |path: PathBuf| if files::is_stdin(&path) { name.clone() } else { path };
    Ok((paths.into_iter().map(named).collect(), texts))
}

/// `--diff`: prints the patch of `--fix`.
fn diff(
    check: &CheckRun<'_>,
    pass: Pass,
    cache: &mut Cache,
    streams: &Streams,
) -> Result<Outcome, CommandFailure> {
    let failures = notes::of_failures(check, &pass);
    let files = fix::preview(check, pass, &mut cache.tree);
    let patch = files.iter().map(|(path, old, new)| unified::diff(path, old, new, Paint::Plain));
    streams.source(&patch.collect::<String>())?;
    streams.finish()?;
    if let Some(text) = failures {
        streams.report(&text);
        return Ok(Outcome::CouldNot);
    }
    streams.notes(&format!("{} would be fixed\n", counted(files.len(), "file")));
    Ok(if files.is_empty() { Outcome::Clean } else { Outcome::Findings })
}
