//! The summary of a step: all findings in a Markdown table.

use crate::render::{severity, short};
use landfall_layout::finding::{Finding, Level};
use landfall_layout::text::escape::{markdown as plain, markdown_code as code};

/// The most bytes of rows; GitHub rejects a summary of more than 1 MiB.
const MAX_BYTES: usize = 900 << 10;

pub(in crate::render) fn markdown(findings: &[&Finding], totals: &str) -> String {
    let mut text = format!("### Landfall\n\n{totals}\n");
    if findings.is_empty() {
        return text;
    }
    text.push_str("\n| | place | lint | what |\n|---|---|---|---|\n");
    let mut rows = 0;
    for level in [Level::Deny, Level::Warn, Level::Allow] {
        for finding in findings.iter().filter(|finding| finding.level() == level) {
            let row = row(finding);
            if text.len() + row.len() > MAX_BYTES {
                text.push_str(&format!("\n… and {} more\n", findings.len() - rows));
                return text;
            }
            text.push_str(&row);
            rows += 1;
        }
    }
    text
}

fn row(finding: &Finding) -> String {
    let mut what = cell(&finding.message);
    if let Some(help) = &finding.help {
        what.push_str(&format!("<br>help: {}", cell(help)));
    }
    format!(
        "| {} | {} | {} | {what} |\n",
        severity(finding.level()),
        code(&short::at(finding.place())),
        code(&finding.code),
    )
}

/// Escapes a message for a table cell; text in backticks becomes code.
fn cell(text: &str) -> String {
    let parts: Vec<&str> = text.split('`').collect();
    if parts.len().is_multiple_of(2) {
        return plain(text);
    }
    let part = |(i, part): (usize, &&str)| if i % 2 == 0 { plain(part) } else { code(part) };
    parts.iter().enumerate().map(part).collect()
}
