//! Findings of lints as text.

use std::fmt::Write as _;
use std::sync::Arc;

use super::paint::Paint;
use crate::error::Error;
use crate::lint::Finding;

/// A form findings are reported in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub enum ReportFormat {
    Human,
    Short,
    Json,
    Github,
    Sarif,
    Junit,
}

/// What a report needs besides the findings.
#[derive(Clone, Copy)]
pub struct ReportOptions<'a> {
    /// Colours.
    pub paint: Paint,
    /// The text of a file by its path as findings spell it, for excerpts.
    pub text: &'a dyn Fn(&str) -> Option<Arc<str>>,
    /// Shaders that were checked.
    pub shaders: usize,
}

/// The findings in that format.
pub fn report(findings: &[Finding], format: ReportFormat, options: &ReportOptions<'_>) -> String {
    let mut text = String::new();
    if format == ReportFormat::Json {
        let list = serde_json::to_string(findings).expect("keys are strings");
        let shaders = options.shaders;
        return format!("{{\"schema_version\":1,\"shaders\":{shaders},\"findings\":{list}}}\n");
    }
    for finding in findings {
        let (place, level) = (&finding.place, finding.level.name());
        let excerpt = (options.text)(&place.path)
            .and_then(|text| text.lines().nth(place.line.max(1) as usize - 1).map(str::to_string))
            .filter(|_| format == ReportFormat::Human)
            .unwrap_or_default();
        let _ = writeln!(
            text,
            "{}:{}:{}: {level}[{}] {} {excerpt}",
            place.path, place.line, place.column, finding.code, finding.message
        );
    }
    text
}

/// The findings as Markdown.
pub fn github_summary(findings: &[Finding], options: &ReportOptions<'_>) -> String {
    format!("## landfall\n{} findings in {} shaders\n", findings.len(), options.shaders)
}

/// The findings of a JSON report.
///
/// # Errors
/// It is no report.
pub fn read_json(path: &str, text: &str) -> Result<Vec<Finding>, Error> {
    #[derive(serde::Deserialize)]
    struct Report {
        findings: Vec<Finding>,
    }
    serde_json::from_str::<Report>(text)
        .map(|report| report.findings)
        .map_err(|cause| Error::new(path, format!("is no report: {cause}")))
}
