//! Findings for people: the lines in question, the layout, the edit that mends it.

use super::texts::Texts;
use super::{ReportOptions, totals};
use landfall_layout::diagnostic::{Label, Severity};
use landfall_layout::finding::{Finding, Level, Place};
pub use landfall_layout::format::diagnostics::render::{Drawing, Pen};
use landfall_layout::source::Location;

pub(super) fn report(findings: &[&Finding], options: &ReportOptions<'_>) -> String {
    let texts = Texts::of(findings, options);
    let mut pen = Pen::new(&texts.files, options.paint);
    let mut text = String::new();
    for finding in findings {
        text.push_str(&one(finding, &texts, &mut pen));
    }
    text.push_str(&totals(findings, options.shaders));
    text.push('\n');
    text
}

fn one(finding: &Finding, texts: &Texts<'_>, pen: &mut Pen<'_>) -> String {
    let mut labels = Vec::new();
    let mut notes = Vec::new();
    let main = texts.span(&finding.place);
    labels.extend(main.map(|span| Label { span, text: finding.text.clone() }));
    for related in &finding.related {
        match texts.span(&related.place) {
            Some(span) => labels.push(Label { span, text: related.text.clone() }),
            None => notes.push(elsewhere(&related.text, &related.place)),
        }
    }
    notes.extend(finding.notes.iter().cloned());
    pen.draw(Drawing {
        severity: match finding.level {
            Level::Allow | Level::Warn => Severity::Warning,
            Level::Deny => Severity::Error,
        },
        code: &finding.code,
        message: &finding.message,
        origin: main.is_none().then(|| Location {
            path: finding.place.path.clone(),
            line: finding.place.line,
            column: finding.place.column,
        }),
        labels: &labels,
        notes,
        listing: finding.listing.as_deref(),
        help: finding.help.as_deref(),
    })
}

/// A further place whose text is not at hand.
fn elsewhere(text: &str, place: &Place) -> String {
    let text = if text.is_empty() { "see" } else { text };
    match place.line {
        0 => format!("{text}: {}", place.path),
        line => format!("{text}: {}:{line}:{}", place.path, place.column),
    }
}
