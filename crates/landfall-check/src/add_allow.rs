//! `--add-allow`: inserts comments that allow the findings of a check.
//!
//! First above the lines of findings; then, for what that does not reach, for whole files.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use landfall_layout::Language;
use landfall_layout::finding::Finding;
use landfall_layout::format::phrases::counted;
use landfall_layout::source::kind_of_path;
use landfall_lint::fix::{Fixed, apply};
use landfall_lint::{add_allow, lint};

use crate::check_shader::Checked;
use crate::fix::{self, AppliedFixes};
use crate::pass::{CheckRun, Pass};
use crate::texts::Texts;
use crate::tree::{self, Remembered};

/// Inserts comments for the findings that `chosen` returns; returns the pass over the final state.
pub fn add(
    check: &CheckRun<'_>,
    mut pass: Pass,
    memory: &mut Option<Remembered>,
    chosen: &dyn Fn(Vec<Finding>, &Pass) -> Vec<Finding>,
) -> (Pass, AppliedFixes) {
    let mut applied = AppliedFixes::default();
    let mut refused: HashSet<String> = HashSet::new();
    // Above single lines first: a comment for a whole file allows more.
    for whole_file in [false, true] {
        let before = tree::findings(check, &mut pass, memory, &[]);
        let files: HashSet<&String> = pass.checked.iter().flat_map(Checked::files).collect();
        let wanted: Vec<Finding> = chosen(before.clone(), &pass)
            .into_iter()
            // Only lints can be allowed, and only in files that were read.
            .filter(|f| lint(&f.code).is_some() && files.contains(&f.place().path))
            .filter(|f| !refused.contains(&f.place().path))
            .collect();
        let texts = Texts::new(HashMap::new());
        let insertions = insertions(&wanted, &texts, whole_file);
        let mut written: Vec<Fixed> = Vec::new();
        for file in apply(&insertions, &|path| texts.of(path)) {
            match fix::write(&file, check) {
                Ok(()) => written.push(file),
                Err(error) => {
                    refused.insert(file.path.clone());
                    applied.refused.push(error);
                }
            }
        }
        if written.is_empty() {
            continue;
        }
        let failures = pass.failures();
        pass = check.pass(pass.into_known(), &HashMap::new(), false);
        let after = tree::findings(check, &mut pass, memory, &[]);
        // By subject, as comments move the lines below them.
        let known: HashSet<_> = before.iter().map(key).collect();
        let odd: HashSet<&str> = after
            .iter()
            .filter(|finding| !known.contains(&key(finding)))
            .map(|finding| finding.place().path.as_str())
            .collect();
        // A comment that has no effect is reported, too.
        let (bad, good): (Vec<&Fixed>, Vec<&Fixed>) = written
            .iter()
            .partition(|file| pass.failures() > failures || odd.contains(file.path.as_str()));
        if !bad.is_empty() {
            fix::revert(&bad, check, &mut applied, &mut refused);
            pass = check.pass(pass.into_known(), &HashMap::new(), false);
        }
        applied.edits += good.iter().map(|file| file.edits).sum::<usize>();
        applied.files.extend(good.iter().map(|file| file.path.clone()));
    }
    (pass, applied)
}

fn key(finding: &Finding) -> (String, String, String) {
    (finding.code.clone(), finding.place().path.clone(), finding.about.clone())
}

/// The comments for these findings as edits, one finding for each comment.
fn insertions(wanted: &[Finding], texts: &Texts, whole_file: bool) -> Vec<Finding> {
    // By file and line: one comment names all codes of a line.
    let mut by_file: BTreeMap<&str, BTreeMap<u32, BTreeSet<&str>>> = BTreeMap::new();
    for finding in wanted {
        let place = finding.place();
        let lines = by_file.entry(&place.path).or_default();
        lines.entry(place.line).or_default().insert(&finding.code);
    }
    let mut found = Vec::new();
    for (path, lines) in by_file {
        let Some(text) = texts.of(path) else { continue };
        let language = kind_of_path(path.as_ref()).map_or(Language::Glsl, |(language, _)| language);
        let edits = match whole_file {
            false => add_allow::above_lines(path, &text, language, &lines),
            true => {
                let codes = lines.into_values().flatten().collect();
                vec![add_allow::in_file(path, &text, &codes)]
            }
        };
        found.extend(
            edits.into_iter().map(|edit| {
                Finding::at("", path, edit.at.clone(), "").with_edit(edit.at, &*edit.new)
            }),
        );
    }
    found
}

/// The summary line: `added 2 comments in 1 file`.
pub fn summary(applied: &AppliedFixes) -> String {
    let (edits, files) = (counted(applied.edits, "comment"), counted(applied.files.len(), "file"));
    format!("added {edits} in {files}\n")
}
