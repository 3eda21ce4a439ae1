//! Findings as text: source excerpts, listings and suggested edits.

use super::ReportOptions;
use super::texts::Texts;
use landfall_layout::diagnostic::{Diagnostic, Label};
use landfall_layout::finding::{Finding, Place};
use landfall_layout::format::diagnostics::render::DiagnosticRenderer;
use landfall_layout::source::Location;

pub(super) fn report(findings: &[&Finding], options: &ReportOptions<'_>) -> String {
    let texts = Texts::new(findings, options);
    let mut pen = DiagnosticRenderer::new(&texts.files, options.paint);
    let mut text = String::new();
    for finding in findings {
        text.push_str(&rendered(finding, &texts, &mut pen));
    }
    // An empty line divides findings.
    text.truncate(text.trim_end_matches('\n').len() + usize::from(!text.is_empty()));
    text
}

fn rendered(finding: &Finding, texts: &Texts<'_>, pen: &mut DiagnosticRenderer<'_>) -> String {
    let mut labels = Vec::new();
    let mut notes = Vec::new();
    let main = texts.span(finding.place());
    labels.extend(main.map(|at| Label { at, text: finding.text().to_string() }));
    for related in finding.related() {
        // A place whose text is not there is told in words.
        match texts.span(&related.at) {
            Some(at) => labels.push(Label { at, text: related.text.clone() }),
            None => notes.push(elsewhere(&related.text, &related.at)),
        }
    }
    notes.extend(finding.notes.iter().cloned());
    let shown = Diagnostic {
        code: finding.code.as_str(),
        severity: finding.severity,
        message: finding.message.clone(),
        path: None,
        about: String::new(),
        labels,
        notes,
        listing: finding.listing.clone(),
        help: finding.help.clone(),
        fix: Vec::new(),
    };
    // Without an excerpt, the place is named in the header.
    let Place { path, line, column, .. } = finding.place().clone();
    pen.draw(&shown, main.is_none().then_some(Location { path, line, column }).as_ref())
}

/// Formats a further place whose text is not available.
fn elsewhere(text: &str, place: &Place) -> String {
    let text = if text.is_empty() { "see" } else { text };
    match place.line {
        0 => format!("{text}: {}", place.path),
        line => format!("{text}: {}:{line}:{}", place.path, place.column),
    }
}
