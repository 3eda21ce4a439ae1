//! `--fix` and `--diff`: applies the edits of findings to files, or prints them.
//!
//! Rounds repeat until nothing changes: overlapping edits need several rounds, and a fix may reveal
//! another finding.

use std::collections::{HashMap, HashSet};
use std::fs;
use std::path::Path;
use std::sync::Arc;

use landfall_layout::Error;
use landfall_layout::finding::Finding;
use landfall_layout::format::phrases::counted;
use landfall_lint::fix::{Fixed, apply};

use crate::pass::{CheckRun, Pass};
use crate::texts::Texts;
use crate::tree::{self, Remembered};

/// Maximum number of rounds, in case two lints undo each other's edits.
const MAX_ROUNDS: usize = 16;

const BOM: &str = "\u{feff}";

/// The applied fixes.
#[derive(Default)]
pub struct AppliedFixes {
    pub edits: usize,
    pub files: HashSet<String>,
    /// Errors of files that could not be fixed.
    pub refused: Vec<Error>,
}

/// Applies edits until none is left; returns the pass over the final state.
pub fn fix(
    check: &CheckRun<'_>,
    mut pass: Pass,
    memory: &mut Option<Remembered>,
) -> (Pass, AppliedFixes) {
    let mut applied = AppliedFixes::default();
    let mut refused: HashSet<String> = HashSet::new();
    for _ in 0..MAX_ROUNDS {
        let mut findings = tree::findings(check, &mut pass, memory, &[]);
        findings.retain(|f| f.fix.iter().all(|edit| !refused.contains(&edit.at.path)));
        let texts = Texts::new(HashMap::new());
        let fixed = changed(apply(&findings, &|path| texts.of(path)));
        let mut written: Vec<&Fixed> = Vec::new();
        for file in &fixed {
            match write(file, check) {
                Ok(()) => written.push(file),
                Err(error) => {
                    refused.insert(file.path.clone());
                    applied.refused.push(error);
                }
            }
        }
        if fixed.is_empty() {
            break;
        }
        let failures = pass.failures();
        pass = check.pass(pass.into_known(), &HashMap::new(), false);
        // A fix that breaks a shader is taken back.
        if pass.failures() > failures {
            revert(&written, check, &mut applied, &mut refused);
            pass = check.pass(pass.into_known(), &HashMap::new(), false);
            continue;
        }
        applied.edits += written.iter().map(|file| file.edits).sum::<usize>();
        applied.files.extend(written.iter().map(|file| file.path.clone()));
    }
    (pass, applied)
}

/// Reverts edits after which a shader no longer parses.
pub fn revert(
    written: &[&Fixed],
    check: &CheckRun<'_>,
    applied: &mut AppliedFixes,
    refused: &mut HashSet<String>,
) {
    for file in written {
        let back =
            Fixed { new: file.old.to_string(), old: Arc::from(&*file.new), ..(*file).clone() };
        refused.insert(file.path.clone());
        applied.refused.push(match write(&back, check) {
            Ok(()) => Error::new(&*file.path, "had an error after its fixes, which were reverted")
                .with_help("please report it with the file"),
            Err(error) => error,
        });
    }
}

/// The files that `--fix` would change: path, old text, new text.
pub fn preview(
    check: &CheckRun<'_>,
    mut pass: Pass,
    memory: &mut Option<Remembered>,
) -> Vec<(String, Arc<str>, String)> {
    let mut before: HashMap<String, Arc<str>> = HashMap::new();
    let mut after: HashMap<String, String> = HashMap::new();
    for _ in 0..MAX_ROUNDS {
        let mut findings = tree::findings(check, &mut pass, memory, &[]);
        let inputs: HashSet<&str> = pass.checked.iter().map(|c| c.path.as_str()).collect();
        // Includes are read from disk, unfixed: their spans are valid for one round only.
        findings.retain(|f: &Finding| {
            let path = |edit: &landfall_layout::finding::Edit| edit.at.path.clone();
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
        pass = check.pass(pass.into_known(), &after, false);
    }
    let mut files: Vec<_> = before
        .into_iter()
        .filter_map(|(path, old)| Some((after.remove(&path)?, path, old)))
        .map(|(new, path, old)| (path, old, new))
        .filter(|(_, old, new)| **old != **new)
        .collect();
    files.sort();
    files
}

/// The summary line: `fixed 2 edits in 1 file`.
pub fn summary(applied: &AppliedFixes) -> String {
    let (edits, files) = (counted(applied.edits, "edit"), counted(applied.files.len(), "file"));
    format!("fixed {edits} in {files}\n")
}

fn changed(mut fixed: Vec<Fixed>) -> Vec<Fixed> {
    fixed.retain(|file| *file.old != *file.new);
    fixed
}

/// Writes a fixed file, if it has not changed since it was read.
pub fn write(file: &Fixed, check: &CheckRun<'_>) -> Result<(), Error> {
    let path = Path::new(&file.path);
    let failed = |cause: std::io::Error| {
        let reason = landfall_layout::file::reason(&cause);
        Error::new(&*file.path, format!("cannot be fixed: {reason}"))
    };
    let permissions = fs::metadata(path).map_err(failed)?.permissions();
    if permissions.readonly() {
        return Err(Error::new(&*file.path, "cannot be fixed: it is read-only")
            .with_help("make it writable, or exclude it with `--exclude`"));
    }
    // The text may have changed since it was checked.
    let now = fs::read_to_string(path).map_err(failed)?;
    let (mark, now) = match now.strip_prefix(BOM) {
        Some(rest) => (BOM, rest),
        None => ("", now.as_str()),
    };
    if *now != *file.old {
        return Err(Error::new(&*file.path, "cannot be fixed: it changed during the check")
            .with_help("run it again"));
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let text = format!("{mark}{}", file.new);
    check.config.root.writer(folder.unwrap_or(Path::new("."))).write(path, text).map(|_| ())
}
