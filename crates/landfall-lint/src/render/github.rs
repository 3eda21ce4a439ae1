//! Workflow commands of GitHub Actions: one line per finding, shown at its place in the change.
//!
//! GitHub shows ten errors and ten warnings per step; the others are listed in a notice.

pub(super) mod summary;

use super::{counted, severity, short};
use landfall_layout::finding::{Finding, Level};
use landfall_layout::text::escape::is_bidi;

/// The number of annotations of each type that GitHub shows per step.
const MAX_SHOWN: usize = 10;

/// The most findings that the notice lists; its text must stay below 64 KiB.
const MAX_LISTED: usize = 100;

pub(super) fn report(findings: &[&Finding]) -> String {
    let mut text = String::new();
    let mut more: Vec<&Finding> = Vec::new();
    for level in [Level::Deny, Level::Warn, Level::Allow] {
        let of_level: Vec<&Finding> =
            findings.iter().filter(|finding| finding.level() == level).copied().collect();
        let (shown, rest) = of_level.split_at(of_level.len().min(MAX_SHOWN));
        text.extend(shown.iter().map(|finding| annotation(finding)));
        more.extend(rest);
    }
    if !more.is_empty() {
        text.push_str(&notice(&more));
    }
    text
}

fn annotation(finding: &Finding) -> String {
    let place = finding.place();
    let mut properties = vec![format!("file={}", property(&place.path))];
    if place.line > 0 {
        let end_line = place.end_line.max(place.line);
        properties.push(format!("line={},endLine={end_line}", place.line));
        // GitHub accepts columns only for a range within one line.
        if end_line == place.line {
            let end_column = place.end_column.max(place.column);
            properties.push(format!("col={},endColumn={end_column}", place.column));
        }
    }
    properties.push(format!("title={}", property(&finding.code)));
    let mut message = finding.message.clone();
    for note in &finding.notes {
        message.push_str(&format!("\nnote: {note}"));
    }
    for related in finding.related() {
        let text = if related.text.is_empty() { "see" } else { &related.text };
        message.push_str(&format!("\n{text}: {}", short::at(&related.at)));
    }
    if let Some(help) = &finding.help {
        message.push_str(&format!("\nhelp: {help}"));
    }
    let command = match finding.level() {
        Level::Allow => "notice",
        Level::Warn | Level::Deny => severity(finding.level()),
    };
    format!("::{command} {}::{}\n", properties.join(","), data(&message))
}

/// The notice about findings that GitHub does not show.
fn notice(more: &[&Finding]) -> String {
    let mut lines = vec![format!("{} that GitHub does not show:", counted(more.len(), "finding"))];
    lines.extend(more.iter().take(MAX_LISTED).map(|finding| short::line(finding)));
    if more.len() > MAX_LISTED {
        lines.push(format!("… and {} more", more.len() - MAX_LISTED));
    }
    let title = property(&format!("{} more", counted(more.len(), "finding")));
    format!("::notice title={title}::{}\n", data(&lines.join("\n")))
}

/// The text of a command, escaped as the runner reads it.
fn data(text: &str) -> String {
    let text = text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A");
    // Logs interpret control sequences.
    text.replace(|c: char| c.is_control() && c != '\t' || is_bidi(c), "\u{fffd}")
}

/// A property of a command, escaped as the runner reads it.
fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}
