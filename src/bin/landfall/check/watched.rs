//! `check --watch`: checks again when a file that the last check read has changed.
//!
//! Modification times and sizes are polled: no dependency, and the same on every system and file
//! system. Directories are searched again at each poll, so that new shaders are found.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant, SystemTime};

use landfall_layout::Error;

use landfall_check::config;
use landfall_check::files::is_stdin;
use landfall_check::inputs::Inputs;

use crate::args::CheckArgs;
use crate::output::{CommandFailure, Outcome, Streams};
use crate::{watch, without_effect};

/// The least time between two polls.
const INTERVAL: Duration = Duration::from_millis(250);

/// Polling takes at most one part in this many of the time.
const SHARE: u32 = 10;

/// Time in which the files of one change are written, as by an editor or `git checkout`.
const SETTLE: Duration = Duration::from_millis(50);

/// The files and directories that a check read.
#[derive(Default)]
pub struct Watched {
    /// The inputs that are searched for shaders.
    pub paths: Vec<PathBuf>,
    /// Other files: includes, those that would precede them, locks, Rust sources, the baseline.
    pub files: BTreeSet<PathBuf>,
}

/// Modification time and length; `None` if there is no such file.
type Stamp = Option<(SystemTime, u64)>;

pub fn run(
    args: &CheckArgs,
    streams: &Streams,
    check: impl Fn(&mut Watched) -> Result<Outcome, CommandFailure>,
) -> Result<Outcome, CommandFailure> {
    if args.paths.iter().any(|path| is_stdin(path)) {
        return Err(Error::new("--watch", "cannot watch stdin").with_help("name files").into());
    }
    let configurations = configurations(args)?;
    let mut watched = Watched::default();
    loop {
        let began = SystemTime::now();
        // Stamps are taken before the check, so that a change during it is seen afterwards.
        let known = current_stamps(&watched, &configurations);
        watched = Watched::default();
        let outcome = check(&mut watched).unwrap_or_else(|error| {
            streams.failure(error);
            Outcome::CouldNot
        });
        if watch::is_stopped() {
            return Ok(outcome);
        }
        without_effect::finish(streams);
        streams.finish()?;
        watch::end_with(outcome);
        if streams.is_unread() {
            return Ok(outcome);
        }
        let mut now = current_stamps(&watched, &configurations);
        // A file that changed while it was checked.
        // What the check has read is known only after it.
        let missed = changed(&known, &now, began);
        streams.notes(&format!("watching {} files; Ctrl-C ends\n", now.len()));
        let path = match missed.map_or_else(|| wait(&watched, &configurations, &mut now), Some) {
            Some(path) => path,
            None => return Ok(outcome),
        };
        streams.clear();
        streams.notes(&format!("{} changed: checking again\n", path.display()));
    }
}

/// Waits for a change, and until files no longer change; `None` after Ctrl-C.
fn wait(
    watched: &Watched,
    configurations: &[PathBuf],
    now: &mut BTreeMap<PathBuf, Stamp>,
) -> Option<PathBuf> {
    let mut pause = INTERVAL;
    let mut found = None;
    loop {
        thread::sleep(pause);
        if watch::is_stopped() {
            return None;
        }
        let began = Instant::now();
        let next = current_stamps(watched, configurations);
        let difference = different(now, &next);
        *now = next;
        // Waits until a poll sees no further change: editors write a file in several steps, and
        // `git checkout` many files.
        match (difference, found) {
            (Some(path), earlier) => {
                found = earlier.or(Some(path));
                pause = SETTLE;
            }
            (None, Some(path)) => return Some(path),
            (None, None) => {
                found = None;
                // Ten times as long as a poll takes, on large trees.
                pause = INTERVAL.max(began.elapsed() * SHARE);
            }
        }
    }
}

/// The stamps of all files that a check reads.
fn current_stamps(watched: &Watched, configurations: &[PathBuf]) -> BTreeMap<PathBuf, Stamp> {
    let inputs = Inputs::new(watched.paths.clone(), watch::stop())
        .filter_map(Result::ok)
        .map(|input| input.path);
    let files = watched.files.iter().chain(configurations).cloned();
    inputs.chain(files).map(|path| (path.clone(), stamp(&path))).collect()
}

fn stamp(path: &Path) -> Stamp {
    let found = path.metadata().ok()?;
    Some((found.modified().ok()?, found.len()))
}

/// A file with another stamp, or that only one of them has.
fn different(old: &BTreeMap<PathBuf, Stamp>, new: &BTreeMap<PathBuf, Stamp>) -> Option<PathBuf> {
    let mut changed = new.iter().filter(|(path, stamp)| old.get(*path) != Some(*stamp));
    let mut gone = old.keys().filter(|path| !new.contains_key(*path));
    changed.next().map(|(path, _)| path).or_else(|| gone.next()).cloned()
}

/// A file that changed since a check began: one that was known before has another stamp, any other
/// was written since.
fn changed(
    old: &BTreeMap<PathBuf, Stamp>,
    new: &BTreeMap<PathBuf, Stamp>,
    began: SystemTime,
) -> Option<PathBuf> {
    let is_changed = |(path, stamp): &(&PathBuf, &Stamp)| match old.get(*path) {
        Some(before) => before != *stamp,
        None => stamp.is_some_and(|(modified, _)| modified > began),
    };
    new.iter().find(is_changed).map(|(path, _)| path.clone())
}

/// The configuration, or the places where one would be found.
fn configurations(args: &CheckArgs) -> Result<Vec<PathBuf>, Error> {
    if args.config.no_config {
        return Ok(Vec::new());
    }
    if let Some(file) = &args.config.config {
        return Ok(vec![file.clone()]);
    }
    let current = config::current()?;
    // Every directory above a path may get a configuration.
    let start = args.paths.iter().map(|path| current.join(path)).chain([current.clone()]);
    let folders: BTreeSet<PathBuf> = start
        .flat_map(|path| path.ancestors().map(Path::to_path_buf).collect::<Vec<_>>())
        .collect();
    let names = |folder: PathBuf| config::NAMES.map(|name| folder.join(name));
    Ok(folders.into_iter().flat_map(names).collect())
}
