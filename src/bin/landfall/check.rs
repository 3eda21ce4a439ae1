//! `landfall check`: checks shaders for lint findings and for changes from their locks.
//!
//! configuration and flags → [`basis`] → a [`pass`] over all shaders, each by [`check_shader`]
//! or from the [`cache`] → [`tree`] over all shaders → [`fix`] → [`reports`].

mod add_allow;
mod against;
pub mod baseline;
mod basis;
mod cache;
pub mod check_shader;
mod compiled;
mod digests;
mod fix;
mod hash;
pub mod notes;
mod page;
mod pass;
mod policies;
#[cfg(feature = "exec")]
mod proved;
mod report_root;
pub mod reports;
mod rust;
mod stamp;
pub mod tree;
mod verified;
mod watched;

use landfall_layout::diagnostic::Code;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

use landfall_layout::file::FileWriter;
use landfall_layout::finding::Finding;
use landfall_layout::format::phrases::counted;
use landfall_layout::source::{Files, kind_of_path};
use landfall_layout::{Diagnostic, Error, Severity, lock};
use landfall_lint::Settings;

use crate::args::{CheckArgs, Form, ReadArgs, Report};
use crate::config::{self, Config};
use crate::output::{Failure, FindingForm, Outcome, Streams};
use crate::walk::slashes;
use crate::{read, watch, write};
use against::Against;
use baseline::Permitted;
use basis::{Basis, Scope};
use cache::Cache;
use check_shader::{Checked, Known};
use fix::AppliedFixes;
use landfall_lint::render::ReportFormat;
use pass::{Pass, Run};
use policies::Policies;
use watched::Watched;

pub fn run(args: &CheckArgs, streams: &Streams) -> Result<Outcome, Failure> {
    refuse(args)?;
    match args.watch {
        true => watched::run(args, streams, |watched| once(args, streams, watched)),
        false => once(args, streams, &mut Watched::default()),
    }
}

fn once(args: &CheckArgs, streams: &Streams, watched: &mut Watched) -> Result<Outcome, Failure> {
    let began = SystemTime::now();
    let Some((config, settings)) = configuration(args, streams)? else {
        return Ok(Outcome::CouldNot);
    };
    let options = config.options(&args.text, &args.levels.defines);
    let paths = config.paths(&args.paths);
    watched.paths.clone_from(&paths);
    let scope = scope(args, &config, &paths);
    let language = args.text.language.map(|language| language.language());
    let mut basis = Basis::new(scope, &options, args.text.stage, language, settings);
    let (rust, opened) = read_rust_and_cache(args, &config, &basis);
    let listing = match rust {
        Ok(found) => {
            basis.set_rust_files(found.files);
            found.listing
        }
        Err(error) => {
            return Ok(could_not(Diagnostic { code: Code::BadRust, ..error.into() }, streams));
        }
    };
    let against =
        args.against.as_ref().map(|rev| Against::open(rev, &config, &basis)).transpose()?;
    watched
        .files
        .extend(args.baseline.iter().chain(&config.baseline).chain(&args.verified).cloned());
    let permitted = Permitted::open(args, &config)?;
    let (paths, stdin) = stdin(paths, args)?;
    let locks = config.writer(&config.locks(args.locks.as_deref()), args.locks.is_some());
    let run = Run {
        basis: &basis,
        root: &config.root,
        paths,
        listing: Mutex::new(listing),
        exclude: &config.exclude,
        jobs: args.jobs,
        stdin,
        against: against.as_ref(),
        policies: Policies::open(&config, args)?,
        locks,
        excluded: AtomicUsize::new(0),
        began,
        so_far: Arc::default(),
    };
    let has_cache = opened.is_some();
    let mut cache = opened.unwrap_or_default();
    let before = cache.tree.as_ref().map(|tree| tree.depends_on.clone());
    let mut pass = first_pass(args, &run, std::mem::take(&mut cache.known), streams)?;
    if args.watch {
        watched.files.extend(files_of(&run, &pass));
    }
    let stopped = watch::is_stopped();
    let left_out = left_out(args, &run, &pass, streams).filter(|_| !stopped);
    if !stopped {
        config.warn_of_unused_patterns(args.paths.is_empty(), streams);
    }
    if args.diff {
        let outcome = diff(&run, pass, &mut cache, streams)?;
        return Ok(left_out.unwrap_or(outcome));
    }
    let applied;
    (pass, applied) = match stopped {
        true => (pass, AppliedFixes::default()),
        false => edit(args, &run, pass, &mut cache, &permitted, streams)?,
    };
    let findings = match stopped {
        // Of an interrupted run, the findings of lints over all shaders are not all known.
        true => tree::sorted(tree::findings_in_shaders(&pass)),
        false => findings(args, &run, &mut pass, &mut cache, streams)?,
    };
    if has_cache && !stopped && cache::is_new(args, &pass, &cache, before.as_deref()) {
        cache.write(&pass).unwrap_or_else(|error| cache::unused(&error, streams));
    }
    let texts = reports::Texts::new(run.stdin.clone());
    let writer = inputs(args, &config, &run, &pass);
    let (findings, permitted) = match stopped {
        true => (findings, None),
        false => permitted.judge(findings, &pass, &run, &texts, (&writer, streams))?,
    };
    let result = reports::Result {
        findings: &findings,
        shaders: pass.checked.len(),
        failures: pass.failures(),
        texts: &texts,
        permitted,
        page: Some(&|| page::page(args, &run, &pass, &findings)),
    };
    let outcome = reports::write(&result, &args.formats, args.statistics, writer, streams)?;
    notes::closing(&run, &pass, (args, &config), &applied, streams);
    if !args.watch {
        // The process ends: to free thousands of results takes 3 % of a check from the cache.
        std::mem::forget((pass, cache));
    }
    Ok(left_out.unwrap_or(outcome))
}

/// The configuration with the flags, and the settings of lints; `None` after a report of errors.
fn configuration(
    args: &CheckArgs,
    streams: &Streams,
) -> Result<Option<(Config, Settings)>, Failure> {
    let Some(mut config) = config::load(&args.config, &args.paths, streams)? else {
        return Ok(None);
    };
    for pattern in &args.exclude {
        config.exclude.add(pattern, false).map_err(|cause| config::bad_glob(pattern, &cause))?;
    }
    let settings = match config.settings(&args.levels.levels, &args.text.targets) {
        Ok(settings) => renamed(settings, streams),
        Err(found) => {
            could_not(found, streams);
            return Ok(None);
        }
    };
    if args.paths.is_empty() {
        config.record_names();
    }
    Ok(Some((config, settings)))
}

/// Searches for Rust files with mirrors while the cache is read, which takes as long.
fn read_rust_and_cache(
    args: &CheckArgs,
    config: &Config,
    basis: &Basis,
) -> (Result<rust::Search, Error>, Option<Cache>) {
    std::thread::scope(|scope| {
        let rust = scope.spawn(|| rust::files(config, &basis.settings, &args.paths));
        let cache = cache::open(args, config, basis);
        (rust.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)), cache)
    })
}

/// Applies `--fix` or `--add-allow`; returns the pass over the final state.
fn edit(
    args: &CheckArgs,
    run: &Run<'_>,
    mut pass: Pass,
    cache: &mut Cache,
    permitted: &Permitted,
    streams: &Streams,
) -> Result<(Pass, AppliedFixes), Failure> {
    let mut applied = AppliedFixes::default();
    if args.fix {
        (pass, applied) = fix::fix(run, pass, &mut cache.tree, streams)?;
        if args.accept {
            pass = run.pass(pass.into_known(), &HashMap::new(), true, streams)?;
        }
    }
    if args.add_allow {
        let chosen = |found, pass: &Pass| permitted.new_of(found, pass, run);
        (pass, applied) = add_allow::add(run, pass, &mut cache.tree, &chosen, streams)?;
    }
    for error in &applied.refused {
        let found = Diagnostic { code: Code::Output, ..error.clone().into() };
        pass.no_input.push(found.located(&Files::default()));
    }
    Ok((pass, applied))
}

/// All findings, with those of lints over all shaders.
fn findings(
    args: &CheckArgs,
    run: &Run<'_>,
    pass: &mut Pass,
    cache: &mut Cache,
    streams: &Streams,
) -> Result<Vec<Finding>, Failure> {
    let basis = run.basis;
    let mut outside = verified::findings(&args.verified, pass, basis, run.root)?;
    outside.extend(compiled::findings(pass, basis));
    outside.extend(proofs(args, run, pass, streams));
    Ok(tree::findings(pass, basis, run.root, &mut cache.tree, &outside))
}

/// The findings for `[[prove]]`.
#[cfg(feature = "exec")]
fn proofs(args: &CheckArgs, run: &Run<'_>, pass: &Pass, streams: &Streams) -> Vec<Finding> {
    // After `--fix`, the findings of the first pass are not those of the files.
    if args.fix || run.basis.settings.proofs.is_empty() {
        return proved::findings(pass, run.basis, args.jobs);
    }
    report_on_end(args, run, streams);
    let found = proved::findings(pass, run.basis, args.jobs);
    watch::end_of_work();
    found
}

/// The configuration refuses `[[prove]]` in this build.
#[cfg(not(feature = "exec"))]
fn proofs(_: &CheckArgs, _: &Run<'_>, _: &Pass, _: &Streams) -> Vec<Finding> {
    Vec::new()
}

fn first_pass(
    args: &CheckArgs,
    run: &Run<'_>,
    known: Known,
    streams: &Streams,
) -> Result<Pass, Failure> {
    // Locks are written after all fixes.
    let accept = args.accept && !args.fix;
    if args.diff {
        return run.pass(known, &HashMap::new(), accept, streams);
    }
    report_on_end(args, run, streams);
    let pass = run.pass(known, &HashMap::new(), accept, streams);
    watch::end_of_work();
    pass
}

/// Prints the findings so far if the process is ended in the middle of a shader. Reports to files
/// are not written then.
fn report_on_end(args: &CheckArgs, run: &Run<'_>, streams: &Streams) {
    let (so_far, stdin) = (Arc::clone(&run.so_far), run.stdin.clone());
    let (statistics, streams) = (args.statistics, streams.for_thread());
    let to_stdout = |report: &&Report| report.file.is_none() && report.format != Form::Html;
    let formats: Vec<_> = args.formats.iter().filter(to_stdout).cloned().collect();
    if formats.is_empty() && !args.formats.is_empty() {
        return watch::on_end(|| ());
    }
    watch::on_end(move || {
        let mut so_far = so_far.lock().unwrap_or_else(PoisonError::into_inner);
        let findings = tree::sorted(std::mem::take(&mut so_far.findings));
        let texts = reports::Texts::new(stdin);
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
fn left_out(args: &CheckArgs, run: &Run<'_>, pass: &Pass, streams: &Streams) -> Option<Outcome> {
    let excluded = run.excluded.load(Ordering::Relaxed);
    let none = pass.checked.is_empty() && pass.no_input.is_empty();
    if !none || excluded == 0 {
        return None;
    }
    let found = config::all_excluded(excluded, &args.exclude);
    // Named files, as from hooks, may be excluded by the configuration.
    let is_meant = !args.paths.is_empty() && args.exclude.is_empty();
    let severity = if is_meant { Severity::Warning } else { Severity::Error };
    let found = Diagnostic { severity, ..found };
    streams.report(&streams.style(FindingForm::Human).text(&[found], &Files::default()));
    (!is_meant).then_some(Outcome::CouldNot)
}

/// The files that a pass read, and those that it would have read if they existed.
fn files_of(run: &Run<'_>, pass: &Pass) -> Vec<PathBuf> {
    let checked = pass.checked.iter();
    let shaders = checked.flat_map(|checked| checked.files().chain(&checked.absent));
    let rust = run.basis.settings.rust_files.iter().map(|file| &file.path);
    let locks = pass.checked.iter().filter_map(|checked| lock_of(run, checked));
    shaders.chain(rust).map(PathBuf::from).chain(locks).collect()
}

fn lock_of(run: &Run<'_>, checked: &Checked) -> Option<PathBuf> {
    let locks = run.basis.locks.as_ref()?;
    let below = run.root.below(Path::new(&checked.path))?;
    Some(lock::path_of(Path::new(locks), Path::new(&below)))
}

/// A writer that does not overwrite inputs of the check.
fn inputs(args: &CheckArgs, config: &Config, run: &Run<'_>, pass: &Pass) -> FileWriter {
    // The summary of a step is a file, too.
    let github = Form::Findings(ReportFormat::Github);
    let writes = |report: &Report| report.file.is_some() || report.format == github;
    if !args.formats.iter().any(writes) && !args.write_baseline {
        return FileWriter::default();
    }
    let mut writer = write::writer();
    for checked in &pass.checked {
        let lock = lock_of(run, checked);
        let mut stamps = checked.stamps.iter();
        for file in checked.files().map(Path::new).chain(lock.as_deref()) {
            match stamps.next() {
                Some(stamp) => writer.protect_node(file, stamp.node()),
                None => writer.protect([file]),
            }
        }
    }
    writer.protect(run.basis.settings.rust_files.iter().map(|file| &file.path));
    writer.protect(&args.verified);
    writer.protect(config.file.as_deref());
    // Shaders that were not reached before Ctrl-C.
    let reports = args.formats.iter().filter_map(|report| report.file.as_deref());
    let real = |path: &Path| std::fs::canonicalize(path).unwrap_or_default();
    writer.protect(reports.filter(|path| kind_of_path(&real(path)).is_some()));
    writer.protect(&run.paths);
    writer
}

/// Fails on options that cannot be combined.
fn refuse(args: &CheckArgs) -> Result<(), Error> {
    if let Some(error) = reports::refused(&args.formats) {
        return Err(error);
    }
    Ok(())
}

fn could_not(found: Diagnostic, streams: &Streams) -> Outcome {
    streams.report(&streams.style(FindingForm::Human).text(&[found], &Files::default()));
    Outcome::CouldNot
}

fn scope(args: &CheckArgs, config: &Config, paths: &[PathBuf]) -> Scope {
    let named = args.locks.as_deref();
    let usual = config.locks(named);
    // Locks are optional, unless their directory is named.
    let locks = config.explicit_locks(named).or_else(|| usual.is_dir().then_some(usual));
    let searched = paths.iter().filter(|path| path.is_dir());
    Scope {
        root: slashes(&config.root.shown),
        locks: locks.as_deref().map(slashes).filter(|_| args.against.is_none()),
        against: args.against.clone(),
        searched: searched.filter_map(|path| config.root.below(path)).collect(),
        whole: args.paths.is_empty(),
    }
}

/// Reads stdin if named, and replaces `-` by its substitute path.
fn stdin(
    paths: Vec<PathBuf>,
    args: &CheckArgs,
) -> Result<(Vec<PathBuf>, HashMap<String, String>), Error> {
    let mut texts = HashMap::new();
    if !paths.iter().any(|path| read::is_stdin(path)) {
        return Ok((paths, texts));
    }
    let read_args = ReadArgs { text: args.text.clone(), defines: Vec::new() };
    let name = read::stdin_path(&read_args);
    texts.insert(name.display().to_string(), read::text(Path::new("-"))?);
    let named = |path: PathBuf| if read::is_stdin(&path) { name.clone() } else { path };
    Ok((paths.into_iter().map(named).collect(), texts))
}

/// `--diff`: prints the patch of `--fix`.
fn diff(
    run: &Run<'_>,
    pass: Pass,
    cache: &mut Cache,
    streams: &Streams,
) -> Result<Outcome, Failure> {
    let failures = notes::of_failures(run, &pass);
    let files = fix::preview(run, pass, &mut cache.tree, streams)?;
    streams.source(&fix::patch(&files))?;
    streams.finish()?;
    if let Some(text) = failures {
        streams.report(&text);
        return Ok(Outcome::CouldNot);
    }
    streams.notes(&format!("{} would be fixed\n", counted(files.len(), "file")));
    Ok(if files.is_empty() { Outcome::Clean } else { Outcome::Findings })
}

/// Replaces former lint codes by the current ones, with a note for each.
fn renamed(mut settings: Settings, streams: &Streams) -> Settings {
    for (was, now) in landfall_lint::resolve_renamed(&mut settings) {
        streams.notes(&format!("note: the lint `{was}` is called `{now}`\n"));
    }
    settings
}
