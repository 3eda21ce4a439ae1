//! Includes that are not found for one reason: told once, with the one fix.

use std::collections::{BTreeSet, HashMap};

use landfall_layout::Diagnostic;
use landfall_layout::diagnostic::Code;
use landfall_layout::finding::Finding;
use landfall_layout::format::phrases::counted;

/// The fix of an include whose directory is not known.
const ANY_DIRECTORY: &str = "pass its directory with `-I DIR`";

/// The most includes that are told apart although their directory is not known.
const MAX_APART: usize = 3;

/// The most names that a finding lists.
const MAX_NAMES: usize = 4;

/// Includes that one fix may resolve, beside the first of them.
#[derive(Default)]
struct MoreIncludes {
    count: usize,
    files: BTreeSet<String>,
    names: Vec<String>,
}

impl MoreIncludes {
    fn add(&mut self, file: &str, message: &str) {
        self.count += 1;
        self.files.insert(file.to_string());
        // The name is the first that the message quotes.
        let name = message.split('`').nth(1).unwrap_or_default();
        if self.names.len() < MAX_NAMES && self.names.iter().all(|known| known != name) {
            self.names.push(name.to_string());
        }
    }

    /// What is said of them.
    fn note(&self) -> String {
        let (count, files) =
            (counted(self.count, "more include"), counted(self.files.len(), "file"));
        let names = self.names.join("`, `");
        let more = if self.names.len() == MAX_NAMES { ", …" } else { "" };
        let are = if self.count == 1 { "is" } else { "are" };
        format!("{count} in {files} {are} not found either: `{names}`{more}")
    }
}

/// Joins the findings about missing includes that one fix may resolve into the first of them.
pub fn joined(findings: Vec<Finding>) -> Vec<Finding> {
    let fix = |finding: &Finding| {
        let is_missing = finding.code == Code::MissingInclude.name();
        finding.help.clone().filter(|_| is_missing)
    };
    let mut counts: HashMap<String, usize> = HashMap::new();
    for fix in findings.iter().filter_map(fix) {
        *counts.entry(fix).or_default() += 1;
    }
    let mut joined: Vec<Finding> = Vec::with_capacity(findings.len());
    let mut more: HashMap<String, (usize, MoreIncludes)> = HashMap::new();
    for finding in findings {
        // A few includes whose directory is not known are told one by one; many lack the same
        // directory.
        let fix = fix(&finding).filter(|fix| fix != ANY_DIRECTORY || counts[fix] > MAX_APART);
        let Some(fix) = fix else {
            joined.push(finding);
            continue;
        };
        match more.get_mut(&fix) {
            Some((_, more)) => more.add(&finding.place().path, &finding.message),
            None => {
                more.insert(fix, (joined.len(), MoreIncludes::default()));
                joined.push(finding);
            }
        }
    }
    for (at, more) in more.into_values().filter(|(_, more)| more.count > 0) {
        joined[at].notes.push(more.note());
    }
    joined
}

/// The missing includes of a run that prints its findings one by one.
#[derive(Default)]
pub struct MissingIncludes(Vec<(String, usize, MoreIncludes)>);

impl MissingIncludes {
    /// Whether an include that is not found in a shader is to be printed: the first of its fix is.
    pub fn is_new(&mut self, shader: &str, found: &Diagnostic) -> bool {
        let fix = found.help.as_deref().unwrap_or_default();
        let Some((_, count, more)) = self.0.iter_mut().find(|(known, ..)| known == fix) else {
            self.0.push((fix.to_string(), 1, MoreIncludes::default()));
            return true;
        };
        *count += 1;
        if fix == ANY_DIRECTORY && *count <= MAX_APART {
            return true;
        }
        more.add(shader, &found.message);
        false
    }

    /// What is said of those that were not printed, each a line.
    pub fn notes(&self) -> String {
        let more = self.0.iter().filter(|(.., more)| more.count > 0);
        more.map(|(fix, _, more)| format!("{}; {fix}\n", more.note())).collect()
    }
}
