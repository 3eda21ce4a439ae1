//! Renders findings in each format, one file per format.
//!
//! Reads only [`Finding`]s, whose places are paths, lines and columns.

mod github;
mod human;
mod json;
mod junit;
mod sarif;
mod short;
mod stable;
mod texts;

/// JSON Schema (draft 2020-12) of the JSON report of `check`.
pub const CHECK_SCHEMA: &str = include_str!("../schema/check.json");

use std::sync::Arc;

use rustc_hash::FxHashSet;

use landfall_layout::finding::{Finding, Level};
use landfall_layout::format::escape_controls;
pub use landfall_layout::format::paint::Paint;
use landfall_layout::format::phrases::counted;
use landfall_layout::named;

pub use json::REPORT_VERSION;
#[cfg(feature = "schema")]
pub use json::schema;

named! {
    /// The format of a report.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub enum ReportFormat {
        /// Text with source excerpts, notes, listings and suggested edits.
        Human = "human",
        /// `path:line:col: level[code] message`, one line per finding.
        Short = "short",
        /// JSON as `landfall schema check` describes it.
        Json = "json",
        /// Workflow commands that GitHub shows as annotations.
        Github = "github",
        /// SARIF 2.1.0.
        Sarif = "sarif",
        /// JUnit's XML as Jenkins and GitLab read it.
        Junit = "junit",
    }

    const ALL;
}

/// The options of a report.
#[derive(Clone, Copy)]
pub struct ReportOptions<'a> {
    /// Colours, in formats that have any.
    pub paint: Paint,
    /// Returns the text of a file by its path in findings, for excerpts.
    pub text: &'a dyn Fn(&str) -> Option<Arc<str>>,
    /// Shaders that were checked.
    pub shaders: usize,
}

/// Renders findings in a format, in their order and without duplicates.
pub fn report(findings: &[Finding], format: ReportFormat, options: &ReportOptions<'_>) -> String {
    let findings = &unique(findings)[..];
    match format {
        // Paths and names are those of the shaders, and could contain control sequences.
        ReportFormat::Human => escape_controls(human::report(findings, options), options.paint),
        ReportFormat::Short => escape_controls(short::report(findings), Paint::Plain),
        ReportFormat::Json => json::report(findings, options.shaders),
        ReportFormat::Github => github::report(findings),
        ReportFormat::Sarif => sarif::report(findings, options.shaders),
        ReportFormat::Junit => junit::report(findings, options.shaders),
    }
}

/// The findings as Markdown for the summary of a step on GitHub.
pub fn github_summary(findings: &[Finding], options: &ReportOptions<'_>) -> String {
    let totals = totals(findings, options.shaders);
    github::summary::markdown(&unique(findings), &totals)
}

/// Removes duplicates: two shaders report the findings of an include that they share.
fn unique(findings: &[Finding]) -> Vec<&Finding> {
    let mut seen = FxHashSet::default();
    // Findings are the same if they are written the same.
    findings.iter().filter(|finding| seen.insert(json::finding(finding))).collect()
}

/// Returns the name that other tools give to a level: `error`, `warning` or `note`.
fn severity(level: Level) -> &'static str {
    match level {
        Level::Allow => "note",
        Level::Warn => "warning",
        Level::Deny => "error",
    }
}

/// `65 shaders: 2 errors, 1 warning`.
pub fn totals(findings: &[Finding], shaders: usize) -> String {
    format!("{}: {}", counted(shaders, "shader"), severities(findings))
}

/// `2 errors, 1 warning`.
pub fn severities(findings: &[Finding]) -> String {
    let findings = unique(findings);
    let count = |level| findings.iter().filter(|finding| finding.level() == level).count();
    let mut parts = Vec::new();
    for level in [Level::Deny, Level::Warn, Level::Allow] {
        if count(level) > 0 {
            parts.push(counted(count(level), severity(level)));
        }
    }
    if parts.is_empty() {
        parts.push("no findings".to_string());
    }
    parts.join(", ")
}
