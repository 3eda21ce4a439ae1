//! One line a finding, as compilers write them and editors read them.

use super::severity;
use crate::lint::{Finding, Place};

pub(super) fn report(findings: &[&Finding]) -> String {
    findings.iter().map(|finding| line(finding) + "\n").collect()
}

/// `path:line:col: warning[code] message`.
pub(super) fn line(finding: &Finding) -> String {
    let at = at(&finding.place);
    flat(&format!("{at}: {}[{}] {}", severity(finding.level), finding.code, finding.message))
}

/// `path:line:col`, or the path alone for a file as a whole.
pub(super) fn at(place: &Place) -> String {
    match place.line {
        0 => place.path.clone(),
        line => format!("{}:{line}:{}", place.path, place.column),
    }
}

/// The text in one line; what would move the cursor is spelled out.
fn flat(text: &str) -> String {
    let mut result = String::with_capacity(text.len());
    for (i, line) in text.lines().enumerate() {
        if i > 0 {
            result.push(' ');
        }
        for c in if i > 0 { line.trim_start() } else { line }.chars() {
            match c {
                '\t' => result.push(' '),
                c if c.is_control() => result.extend(c.escape_default()),
                c => result.push(c),
            }
        }
    }
    result
}
