//! Findings as diagnostics of the protocol.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use gen_lsp_types::{
    CodeDescription, Diagnostic, DiagnosticRelatedInformation, DiagnosticSeverity, DiagnosticTag,
    Location, PublishDiagnosticsParams, Range, Uri,
};
use landfall_layout::Severity;
use landfall_layout::finding::{Finding, Place};
use landfall_layout::format::phrases::counted;

use crate::positions::LineText;
use crate::server::EditorServer;

/// Lines of both maps that the finding about a lock has.
const MAX_LINES: usize = 32;

impl EditorServer {
    /// Sends the findings of all files that have changed.
    pub fn publish_all(&mut self) {
        let mut files: HashSet<PathBuf> = self.published.keys().cloned().collect();
        let places = self.projects.iter().flat_map(|project| project.findings());
        let places: HashSet<&str> = places.map(|finding| finding.place().path.as_str()).collect();
        files.extend(places.into_iter().map(|place| self.absolute(place)));
        self.publish(&files);
    }

    /// Sends the findings of these files, if they have changed.
    pub fn publish(&mut self, files: &HashSet<PathBuf>) {
        let mut by_file: HashMap<PathBuf, Vec<&Finding>> =
            files.iter().map(|file| (file.clone(), Vec::new())).collect();
        for finding in self.projects.iter().flat_map(|project| project.findings()) {
            if let Some(found) = by_file.get_mut(&self.absolute(&finding.place().path)) {
                // An include has the same finding in each shader.
                if !found.contains(&finding) {
                    found.push(finding);
                }
            }
        }
        let mut texts = HashMap::new();
        let mut sent = Vec::new();
        for (file, mut findings) in by_file {
            if file.is_dir() {
                continue;
            }
            findings.sort_by_key(|finding| finding.place().start);
            let diagnostics: Vec<Diagnostic> =
                findings.iter().map(|finding| self.diagnostic(finding, &mut texts)).collect();
            let known = self.published.get(&file);
            if known.map_or(diagnostics.is_empty(), |known| *known == diagnostics) {
                continue;
            }
            sent.push((file, diagnostics));
        }
        for (file, diagnostics) in sent {
            let version = self.documents.get(&file).map(|document| document.version);
            let uri = self.documents.uri(&file);
            let params =
                PublishDiagnosticsParams { uri, version, diagnostics: diagnostics.clone() };
            self.client.notify("textDocument/publishDiagnostics", params);
            match diagnostics.is_empty() {
                true => self.published.remove(&file),
                false => self.published.insert(file, diagnostics),
            };
        }
    }

    fn diagnostic(&self, finding: &Finding, texts: &mut TextCache) -> Diagnostic {
        let related = finding.related().iter().map(|label| DiagnosticRelatedInformation {
            location: self.location(&label.at, texts),
            message: match label.text.as_str() {
                "" => "here".to_string(),
                text => text.to_string(),
            },
        });
        let related: Vec<DiagnosticRelatedInformation> = related.collect();
        let pages = self.settings.rule_pages.as_ref();
        let page = pages.map(|pages| pages.replace("{code}", &finding.code));
        Diagnostic {
            range: self.location(finding.place(), texts).range,
            severity: Some(match finding.severity {
                Severity::Error => DiagnosticSeverity::Error,
                Severity::Warning => DiagnosticSeverity::Warning,
            }),
            code: Some(finding.code.clone().into()),
            code_description: page.map(|page| CodeDescription { href: Uri(page) }),
            source: Some("landfall".to_string()),
            message: message(finding).into(),
            tags: finding.code.starts_with("unused-").then(|| vec![DiagnosticTag::Unnecessary]),
            related_information: (!related.is_empty()).then_some(related),
            data: None,
        }
    }

    /// The place of a finding; the start of a file as a whole.
    pub fn location(&self, place: &Place, texts: &mut TextCache) -> Location {
        let path = self.absolute(&place.path);
        let uri = self.documents.uri(&path);
        let text = texts.entry(path).or_insert_with_key(|path| self.documents.text(path));
        let range = match text {
            Some(text) if place.line > 0 => text.range(place.start..place.end),
            Some(_) | None => Range::default(),
        };
        Location { uri, range }
    }

    /// The place of a name in one of a shader's files.
    pub fn location_of(&self, shown: &str, span: std::ops::Range<u32>) -> Option<Location> {
        let path = self.absolute(shown);
        let text = self.documents.text(&path)?;
        Some(Location { uri: self.documents.uri(&path), range: text.range(span) })
    }

    /// The address of a line of a file.
    pub fn link(&self, path: &Path, line: u32) -> String {
        let path = self.absolute(&path.to_string_lossy());
        format!("{}#L{line}", self.documents.uri(&path).0)
    }
}

/// The texts of files that findings are in, each read once.
pub type TextCache = HashMap<PathBuf, Option<Arc<LineText>>>;

/// The message of a finding, with what the terminal prints around the source.
fn message(finding: &Finding) -> String {
    let mut message = finding.message.clone();
    if !finding.text().is_empty() {
        message.push_str(&format!("\n{}", finding.text()));
    }
    for note in &finding.notes {
        message.push_str(&format!("\nnote: {note}"));
    }
    if let Some(maps) = finding.listing.as_deref().filter(|_| finding.code == "layout-drift") {
        let lines: Vec<&str> = maps.trim_end().lines().collect();
        for line in lines.iter().take(MAX_LINES) {
            message.push_str(&format!("\n{}", line.trim_end()));
        }
        if let Some(more @ 1..) = lines.len().checked_sub(MAX_LINES) {
            message.push_str(&format!("\n… and {}", counted(more, "more line")));
        }
    }
    if let Some(help) = &finding.help {
        message.push_str(&format!("\nhelp: {help}"));
    }
    message
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_maps_of_a_large_block_are_cut() {
        let listing: String = (0..40).map(|line| format!("was {line} | is {line}  \n")).collect();
        let found = Finding::at("layout-drift", "B", Place::file("a.frag"), "`B` differs");
        let message = message(&found.with_listing(listing).with_help("undo it"));
        let lines: Vec<&str> = message.lines().collect();
        assert_eq!(lines.len(), 1 + MAX_LINES + 2, "{message}");
        assert_eq!(lines[MAX_LINES..], ["was 31 | is 31", "… and 8 more lines", "help: undo it"]);
    }
}
