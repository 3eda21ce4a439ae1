//! One line per finding, as compilers write and editors parse them.

use super::severity;
use landfall_layout::finding::{Finding, Place};
pub use landfall_layout::text::escape::in_one_line;

pub(super) fn report(findings: &[&Finding]) -> String {
    findings.iter().map(|finding| line(finding) + "\n").collect()
}

/// `path:line:col: warning[code] message`.
pub(super) fn line(finding: &Finding) -> String {
    let at = at(finding.place());
    in_one_line(&format!(
        "{at}: {}[{}] {}",
        severity(finding.level()),
        finding.code,
        finding.message
    ))
}

/// `path:line:col`, or the path alone for a file as a whole.
pub(super) fn at(place: &Place) -> String {
    match place.line {
        0 => place.path.clone(),
        line => format!("{}:{line}:{}", place.path, place.column),
    }
}
