//! `--fix` and `--diff`: edits of findings applied to files, or shown.
//!
//! Round after round until nothing changes, since two edits that touch wait for one another and
//! one mended fault may uncover the next.

use std::collections::{HashMap, HashSet};
use std::fs;
use std::path::Path;
use std::sync::Arc;

use landfall::report::unified::diff;
use landfall_layout::Error;
use landfall_layout::finding::Finding;
use landfall_layout::format::Paint;
use landfall_layout::format::words::counted;
use landfall_lint::fix::{Fixed, apply};

use super::pass::{Pass, Run};
use super::reports::Texts;
use super::tree::{self, Remembered};
use crate::output::{Failure, Streams};

/// Rounds, in case two lints undo one another's edits.
const MOST_ROUNDS: usize = 16;

const BOM: &str = "\u{feff}";

/// What mending did.
#[derive(Default)]
pub struct Mended {
    pub edits: usize,
    pub files: HashSet<String>,
    /// Why a file could not be mended.
    pub refused: Vec<Error>,
}

/// Applies edits until none is left; the pass that saw the last state comes back.
pub fn fix(
    run: &Run<'_>,
    mut pass: Pass,
    remembered: &mut Option<Remembered>,
    streams: &Streams,
) -> Result<(Pass, Mended), Failure> {
    let mut mended = Mended::default();
    let mut refused: HashSet<String> = HashSet::new();
    for _ in 0..MOST_ROUNDS {
        let mut findings = tree::findings(&mut pass, run.basis, run.root, remembered, &[]);
        findings.retain(|f| f.fix.iter().all(|edit| !refused.contains(&edit.place.path)));
        let texts = Texts::new(HashMap::new());
        let fixed = changed(apply(&findings, &|path| texts.of(path)));
        let mut written: Vec<&Fixed> = Vec::new();
        for file in &fixed {
            match write(file, run) {
                Ok(()) => written.push(file),
                Err(error) => {
                    refused.insert(file.path.clone());
                    mended.refused.push(error);
                }
            }
        }
        if fixed.is_empty() {
            break;
        }
        let failures = pass.failures();
        pass = run.pass(pass.into_known(), &HashMap::new(), false, streams)?;
        if pass.failures() > failures {
            take_back(&written, run, &mut mended, &mut refused);
            pass = run.pass(pass.into_known(), &HashMap::new(), false, streams)?;
            continue;
        }
        mended.edits += written.iter().map(|file| file.edits).sum::<usize>();
        mended.files.extend(written.iter().map(|file| file.path.clone()));
    }
    Ok((pass, mended))
}

/// Edits after which a shader no longer lays out are none of ours to leave there.
fn take_back(
    written: &[&Fixed],
    run: &Run<'_>,
    mended: &mut Mended,
    refused: &mut HashSet<String>,
) {
    for file in written {
        let back =
            Fixed { new: file.old.to_string(), old: Arc::from(&*file.new), ..(*file).clone() };
        refused.insert(file.path.clone());
        mended.refused.push(match write(&back, run) {
            Ok(()) => {
                Error::new(&*file.path, "would not lay out any more: its edits were taken back")
                    .with_help("please report it with the file")
            }
            Err(error) => error,
        });
    }
}

/// The texts of files as `--fix` would leave them, with those before.
pub fn preview(
    run: &Run<'_>,
    mut pass: Pass,
    remembered: &mut Option<Remembered>,
    streams: &Streams,
) -> Result<Vec<(String, Arc<str>, String)>, Failure> {
    let mut before: HashMap<String, Arc<str>> = HashMap::new();
    let mut after: HashMap<String, String> = HashMap::new();
    for _ in 0..MOST_ROUNDS {
        let mut findings = tree::findings(&mut pass, run.basis, run.root, remembered, &[]);
        let inputs: HashSet<&str> = pass.checked.iter().map(|c| c.path.as_str()).collect();
        // An include is read from disk, where it is not mended: its places hold for one round.
        findings.retain(|f: &Finding| {
            let path = |edit: &landfall_layout::finding::Edit| edit.place.path.clone();
            f.fix.iter().map(path).all(|p| inputs.contains(&*p) || !after.contains_key(&p))
        });
        let texts = Texts::new(after.clone());
        let fixed = changed(apply(&findings, &|path| texts.of(path)));
        if fixed.is_empty() {
            break;
        }
        for file in fixed {
            before.entry(file.path.clone()).or_insert(file.old);
            after.insert(file.path, file.new);
        }
        pass = run.pass(pass.into_known(), &after, false, streams)?;
    }
    let mut files: Vec<_> = before
        .into_iter()
        .filter_map(|(path, old)| Some((after.remove(&path)?, path, old)))
        .map(|(new, path, old)| (path, old, new))
        .filter(|(_, old, new)| **old != **new)
        .collect();
    files.sort();
    Ok(files)
}

/// Files as a patch.
pub fn patch(files: &[(String, Arc<str>, String)]) -> String {
    files.iter().map(|(path, old, new)| diff(path, old, new, Paint::Plain)).collect()
}

/// `2 edits in 1 file`.
pub fn told(mended: &Mended) -> String {
    let (edits, files) = (counted(mended.edits, "edit"), counted(mended.files.len(), "file"));
    format!("mended {edits} in {files}\n")
}

fn changed(mut fixed: Vec<Fixed>) -> Vec<Fixed> {
    fixed.retain(|file| *file.old != *file.new);
    fixed
}

/// Writes a mended file whole, if it still is what was mended.
fn write(file: &Fixed, run: &Run<'_>) -> Result<(), Error> {
    let path = Path::new(&file.path);
    let failed = |cause: std::io::Error| {
        let reason = landfall_layout::file::reason(&cause);
        Error::new(&*file.path, format!("cannot be mended: {reason}"))
    };
    let permissions = fs::metadata(path).map_err(failed)?.permissions();
    if permissions.readonly() {
        return Err(Error::new(&*file.path, "cannot be mended: it is read-only")
            .with_help("make it writable, or leave it out with `--exclude`"));
    }
    let now = fs::read_to_string(path).map_err(failed)?;
    let (mark, now) = match now.strip_prefix(BOM) {
        Some(rest) => (BOM, rest),
        None => ("", now.as_str()),
    };
    if *now != *file.old {
        return Err(Error::new(&*file.path, "cannot be mended: it was changed meanwhile")
            .with_help("run it again"));
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let text = format!("{mark}{}", file.new);
    run.root.writer(folder.unwrap_or(Path::new("."))).write(path, text).map(|_| ())
}
