//! `--baseline` and `--write-baseline`: the findings that are permitted until somebody fixes them.
//!
//! An entry names the code, file, subject and source line of a finding, but no line number, so that
//! it still matches after lines above it have moved.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use landfall_layout::file::FileWriter;
use landfall_layout::finding::{Finding, Level, Place};
use landfall_layout::text::json::{self, Value};
use landfall_layout::{Error, Severity};
use landfall_lint::{levels, lint};
use serde::{Deserialize, Serialize};

use crate::check_shader::Checked;
use crate::config::Config;
use crate::files;
use crate::pass::{CheckRun, Pass};
use crate::texts::Texts;
use crate::tree;

/// The code of findings about entries of a baseline that match nothing.
pub const STALE_BASELINE: &str = "stale-baseline";

/// The file that `--write-baseline` writes if none is named, in the configuration's directory.
pub const FILE: &str = "landfall-baseline.json";

/// The version of the format of baselines.
const VERSION: u32 = 1;

/// A permitted finding.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct PermittedFinding {
    /// The file, from the configuration's directory.
    path: String,
    /// The code of the lint.
    code: String,
    /// The subject: a member, a block, or a function.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    about: String,
    /// The source line with single spaces; empty for a finding about a whole file.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    text: String,
    /// The message of `layout-drift`: a different change is a new finding.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    message: String,
    /// How many findings it permits.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    count: u32,
}

fn one() -> u32 {
    1
}

fn is_one(count: &u32) -> bool {
    *count == 1
}

/// What `landfall check --write-baseline` writes.
#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct BaselineDocument {
    #[cfg_attr(feature = "schema", schemars(extend("const" = VERSION)))]
    schema_version: u32,
    findings: Vec<PermittedFinding>,
}

/// The schema of the files that `check --write-baseline` writes.
#[cfg(feature = "schema")]
#[doc(hidden)]
pub fn schema() -> String {
    landfall_layout::schema::text::<BaselineDocument>("Findings that landfall check permits")
}

/// A baseline in a file.
struct Baseline {
    shown: String,
    /// The entries with their lines.
    entries: Vec<(PermittedFinding, u32)>,
}

/// The inputs from which the entries of findings are computed.
struct BaselineScope<'a> {
    check: &'a CheckRun<'a>,
    pass: &'a Pass,
    texts: &'a Texts,
}

impl Baseline {
    /// Reads a baseline.
    ///
    /// # Errors
    ///
    /// The file cannot be read, is no baseline, or is one of a newer landfall.
    fn read(path: &Path) -> Result<Baseline, Error> {
        let shown = files::display_path(path);
        let text = files::text(path).map_err(|error| match path.exists() {
            true => error,
            false => error.with_help("write it with `landfall check --write-baseline`"),
        })?;
        Baseline::parse(&shown, &text)
    }

    fn parse(shown: &str, text: &str) -> Result<Baseline, Error> {
        let refuse = |what: String| {
            let help =
                "name another file, or move it away and run `landfall check --write-baseline`";
            Error::new(shown, format!("is not a baseline: {what}")).with_help(help)
        };
        let document: BaselineDocument =
            serde_json::from_str(text).map_err(|e| refuse(e.to_string()))?;
        // Another version may mean other things by the same keys.
        if document.schema_version != VERSION {
            let message = format!(
                "has schema version {}, but this landfall reads version {VERSION}",
                document.schema_version
            );
            return Err(Error::new(shown, message));
        }
        let entries = document.findings.into_iter().zip(lines(text)).collect();
        Ok(Baseline { shown: shown.to_string(), entries })
    }

    /// Removes the findings that the baseline permits, and adds one for each entry that permits
    /// more than there is. Also returns the number of findings that it permits.
    fn divide(&self, findings: Vec<Finding>, scope: &BaselineScope<'_>) -> (Vec<Finding>, usize) {
        let mut left: Vec<u32> = self.entries.iter().map(|(entry, _)| entry.count).collect();
        let mut rest: Vec<(Finding, Option<PermittedFinding>)> = findings
            .into_iter()
            .map(|finding| {
                let entry = scope.entry(&finding);
                (finding, entry)
            })
            .collect();
        let before = rest.len();
        // The same line, then the same subject in another line, then the same line of another name.
        // Each round takes what the one before left, so that no entry is spent on a finding that is
        // merely like it.
        for alike in
            [PermittedFinding::same, PermittedFinding::same_subject, PermittedFinding::same_line]
        {
            // By file and code, as a baseline may have thousands of entries.
            let mut known: HashMap<(&str, &str), Vec<usize>> = HashMap::new();
            for (number, (entry, _)) in self.entries.iter().enumerate() {
                known.entry((&entry.path, &entry.code)).or_default().push(number);
            }
            rest.retain(|(_, entry)| {
                let Some(entry) = entry else { return true };
                let numbers = known.get(&(entry.path.as_str(), entry.code.as_str()));
                let mut numbers = numbers.into_iter().flatten();
                let found = numbers.find(|n| left[**n] > 0 && alike(&self.entries[**n].0, entry));
                found.inspect(|number| left[**number] -= 1).is_none()
            });
        }
        let permitted = before - rest.len();
        let mut findings: Vec<Finding> = rest.into_iter().map(|(finding, _)| finding).collect();
        for ((entry, line), left) in self.entries.iter().zip(left) {
            if left > 0 && scope.judges(entry) {
                findings.push(self.stale(entry, *line, left));
            }
        }
        (tree::sorted(findings), permitted)
    }

    /// The finding for an entry that permits more than there is.
    fn stale(&self, entry: &PermittedFinding, line: u32, left: u32) -> Finding {
        let place =
            Place { line, column: 1, end_line: line, end_column: 1, ..Place::file(&self.shown) };
        let what = match (entry.text.as_str(), entry.about.as_str()) {
            ("", "") => String::new(),
            ("", about) => format!(" about `{about}`"),
            (text, _) => format!(" in the line `{text}`"),
        };
        let number = match (left, entry.count) {
            (1, 1) => "it has no".to_string(),
            (left, count) => format!("{left} of {count} are gone: it has less"),
        };
        let message = format!("`{}`: {number} `{}`{what}", entry.path, entry.code);
        Finding::at(STALE_BASELINE, &*entry.path, place, message)
            .with_help("renew the baseline with `landfall check --write-baseline`")
    }

    /// The text of a baseline with the findings of a check. Entries that the check did not judge
    /// are kept.
    fn text(
        old: Option<&Baseline>,
        findings: &[Finding],
        scope: &BaselineScope<'_>,
    ) -> (String, usize) {
        let mut entries: Vec<PermittedFinding> =
            findings.iter().filter_map(|f| scope.entry(f)).collect();
        let kept = old.iter().flat_map(|old| &old.entries).map(|(entry, _)| entry);
        // What this check could not find again is not known to be gone.
        entries.extend(kept.filter(|entry| !scope.judges(entry)).cloned());
        entries.sort();
        entries.dedup_by(|next, before| {
            let is_same = PermittedFinding { count: before.count, ..next.clone() } == *before;
            before.count += if is_same { next.count } else { 0 };
            is_same
        });
        let rows: Vec<String> = entries
            .iter()
            .map(|entry| serde_json::to_string(entry).expect("an entry is strings and a number"))
            .collect();
        let list = match rows.is_empty() {
            true => "[]".to_string(),
            false => format!("[\n    {}\n  ]", rows.join(",\n    ")),
        };
        let count = entries.iter().map(|entry| entry.count as usize).sum();
        (format!("{{\n  \"schema_version\": {VERSION},\n  \"findings\": {list}\n}}\n"), count)
    }
}

/// Writes a baseline; returns the number of its findings.
///
/// # Errors
///
/// The file exists and is not a baseline, or cannot be written.
fn write(
    path: &Path,
    findings: &[Finding],
    scope: &BaselineScope<'_>,
    writer: &FileWriter,
) -> Result<usize, Error> {
    // An empty file, as `mktemp` makes one, is no baseline yet.
    let is_there = path.symlink_metadata().is_ok_and(|there| there.len() > 0);
    let old = is_there.then(|| Baseline::read(path)).transpose()?;
    let (text, count) = Baseline::text(old.as_ref(), findings, scope);
    writer.write(path, text)?;
    Ok(count)
}

impl PermittedFinding {
    fn same(&self, other: &PermittedFinding) -> bool {
        self.about == other.about && self.text == other.text && self.message == other.message
    }

    fn same_subject(&self, other: &PermittedFinding) -> bool {
        !self.about.is_empty() && self.about == other.about && self.message == other.message
    }

    fn same_line(&self, other: &PermittedFinding) -> bool {
        !self.text.is_empty() && self.text == other.text && self.message == other.message
    }
}

impl BaselineScope<'_> {
    /// The entry of a finding; `None` for errors that no baseline permits.
    fn entry(&self, finding: &Finding) -> Option<PermittedFinding> {
        // While some shader cannot be checked, an error is no permitted finding: it hides others.
        let is_error = lint(&finding.code).is_none() && finding.severity == Severity::Error;
        if is_error && self.pass.failures() > 0 {
            return None;
        }
        let place = finding.place();
        let line = (place.line > 0).then(|| self.texts.line(&place.path, place.line)).flatten();
        // Single spaces, so that another indentation is the same line.
        let words: Vec<&str> = line.iter().flat_map(|line| line.split_whitespace()).collect();
        let is_drift = finding.code == "layout-drift";
        Some(PermittedFinding {
            path: self.below(&place.path),
            code: finding.code.clone(),
            about: finding.about.clone(),
            text: words.join(" "),
            message: if is_drift { finding.message.clone() } else { String::new() },
            count: 1,
        })
    }

    fn below(&self, path: &str) -> String {
        self.check.config.root.below(Path::new(path)).unwrap_or_else(|| path.to_string())
    }

    /// Whether this check would find what an entry permits.
    fn judges(&self, entry: &PermittedFinding) -> bool {
        let shown = self.check.config.root.show(&self.check.config.root.shown.join(&entry.path));
        if levels::level_in(&entry.code, &shown, &self.check.basis.settings) == Level::Allow {
            return false;
        }
        let has_run = lint(&entry.code).is_none() || tree::has_run(&entry.code, self.check.basis);
        let scope = &self.check.basis.scope;
        let is_checked = || {
            scope.is_searched(&entry.path)
                || self.pass.checked.iter().flat_map(Checked::files).any(|path| *path == shown)
        };
        has_run && (scope.whole || is_checked())
    }
}

/// The lines of the entries in a text that was parsed.
fn lines(text: &str) -> Vec<u32> {
    // serde gives no positions, so the text is read once more for them.
    let Ok(Value::Object(keys)) = json::parse(text).map(|node| node.value) else { return vec![] };
    let list = keys.into_iter().find_map(|(key, _, node)| match node.value {
        Value::List(list) if key == "findings" => Some(list),
        _ => None,
    });
    let (mut line, mut at) = (1, 0);
    let of = |node: json::Node| {
        line += text[at..node.start].matches('\n').count() as u32;
        at = node.start;
        line
    };
    list.unwrap_or_default().into_iter().map(of).collect()
}

/// The baseline of a check.
pub struct Permitted {
    /// Its path, if the check has one.
    path: Option<PathBuf>,
    /// `None` if it is to be written.
    baseline: Option<Baseline>,
}

/// The findings of a check, judged by its baseline.
#[derive(Default)]
pub struct JudgedFindings {
    /// The findings to report.
    pub findings: Vec<Finding>,
    /// Number of findings that the baseline permits; `None` without a baseline.
    pub permitted: Option<usize>,
    /// What became of the baseline that was to be written: its path, and the number of its findings, or
    /// `None` as not every shader could be checked.
    pub written: Option<(String, Option<usize>)>,
}

impl Permitted {
    /// Reads the baseline that the caller or the configuration names, unless it is to be written.
    pub fn open(
        named: Option<&PathBuf>,
        is_to_write: bool,
        config: &Config,
    ) -> Result<Permitted, Error> {
        let named = named.or(config.baseline.as_ref());
        let path = match is_to_write {
            true => Some(named.cloned().unwrap_or_else(|| config.root.path(FILE))),
            false => named.cloned(),
        };
        let read = path.as_deref().filter(|_| !is_to_write);
        let baseline = read.map(Baseline::read).transpose()?;
        Ok(Permitted { path, baseline })
    }

    /// The findings that the baseline lacks.
    pub fn new_of(&self, found: Vec<Finding>, pass: &Pass, check: &CheckRun<'_>) -> Vec<Finding> {
        let texts = &Texts::new(HashMap::new());
        match &self.baseline {
            Some(baseline) => baseline.divide(found, &BaselineScope { check, pass, texts }).0,
            None => found,
        }
    }

    /// Divides the findings; writes the baseline if that was asked for, which then permits all.
    pub fn judge(
        &self,
        findings: Vec<Finding>,
        pass: &Pass,
        check: &CheckRun<'_>,
        texts: &Texts,
        writer: &FileWriter,
    ) -> Result<JudgedFindings, Error> {
        let scope = BaselineScope { check, pass, texts };
        let (mut written, read) = (None, &self.baseline);
        let new;
        let baseline = match (read, &self.path) {
            (Some(baseline), _) => baseline,
            (None, None) => return Ok(JudgedFindings { findings, ..JudgedFindings::default() }),
            (None, Some(path)) => {
                let shown = files::display_path(path);
                // A baseline of an unfinished check would lack what could not be found.
                if pass.failures() > 0 {
                    let written = Some((shown, None));
                    return Ok(JudgedFindings { findings, written, permitted: None });
                }
                written = Some((shown, Some(write(path, &findings, &scope, writer)?)));
                // Read back, so that the findings are judged as by the next check.
                new = Baseline::read(path)?;
                &new
            }
        };
        let (findings, permitted) = baseline.divide(findings, &scope);
        Ok(JudgedFindings { findings, permitted: Some(permitted), written })
    }
}
