//! Renders a diagnostic with its source lines; the only module that uses annotate-snippets.
//!
//! Called by [`diagnostics`](super) and by `landfall_lint::render`.

use annotate_snippets::{
    AnnotationKind, Element, Group, Level, Origin, Padding, Renderer, Snippet,
};

use super::excerpt;
use super::excerpt::Excerpt;
use crate::diagnostic::{Diagnostic, Severity};
use crate::format::paint::{CAUTION, Paint, STRONG};
use crate::format::place::Places;
use crate::source::{Files, Location, Span};
use crate::text::escape::{name, visible};

/// The width at which annotate-snippets trims excerpts: more than any line passed to it.
const WIDTH: usize = 240;

/// Renders diagnostics about a set of files.
pub struct DiagnosticRenderer<'a> {
    files: &'a Files,
    places: Places<'a>,
    renderer: Renderer,
}

impl<'a> DiagnosticRenderer<'a> {
    /// Creates a renderer for findings about `files`.
    pub fn new(files: &'a Files, paint: Paint) -> DiagnosticRenderer<'a> {
        let renderer = match paint {
            Paint::Plain => Renderer::plain(),
            Paint::Ansi => Renderer::styled().warning(CAUTION.bold()).emphasis(STRONG),
        };
        DiagnosticRenderer {
            files,
            places: Places::new(files),
            renderer: renderer.term_width(WIDTH),
        }
    }

    /// The diagnostic as text, followed by an empty line.
    ///
    /// `origin` is the main place where the text of that place cannot be shown; line 0 stands for
    /// the file as a whole. Without it the first label is the main place.
    pub fn draw<C: AsRef<str>>(
        &mut self,
        diagnostic: &Diagnostic<Span, C>,
        origin: Option<&Location>,
    ) -> String {
        let level = match diagnostic.severity {
            Severity::Error => Level::ERROR,
            Severity::Warning => Level::WARNING,
        };
        let mut elements: Vec<Element<'_>> = Vec::new();
        let mut notes: Vec<String> = diagnostic.notes.iter().map(|note| visible(note)).collect();
        // With an origin no label is the main place: that one cannot be shown.
        let main = if origin.is_some() { None } else { Some(0) };
        let mut excerpts =
            excerpt::excerpts(&diagnostic.labels, main, self.files, &mut self.places);
        for excerpt in &mut excerpts {
            excerpt.path = name(&excerpt.path).into_owned();
            notes.extend(excerpt.elsewhere.iter().map(|note| visible(note)));
        }
        let listing = diagnostic.listing.as_deref();
        let listing = listing.map(|text| format!("the layout\n{}", visible(text.trim_end())));
        notes.extend(listing);
        let help = diagnostic.help.as_deref().map(visible);
        if let Some(at) = origin {
            let origin = Origin::path(name(&at.path).into_owned());
            elements.push(match at.line {
                0 => origin.into(),
                line => origin.line(line as usize).char_column(at.column as usize).into(),
            });
            // An excerpt begins with a bar below the origin, notes and help do not.
            if excerpts.is_empty() && (help.is_some() || !notes.is_empty()) {
                elements.push(Padding.into());
            }
        }
        elements.extend(excerpts.iter().map(|excerpt| snippet(excerpt).into()));
        elements.extend(notes.iter().map(|note| Level::NOTE.message(note.as_str()).into()));
        elements.extend(help.iter().map(|help| Level::HELP.message(help.as_str()).into()));
        let message = visible(&diagnostic.message);
        let title = level.primary_title(message.as_str()).id(diagnostic.code.as_ref());
        let group: Group<'_> = title.elements(elements);
        let mut text = self.renderer.render(&[group]);
        // annotate-snippets counts columns in the truncated line; restore the real ones.
        for cut in excerpts.iter().flat_map(|excerpt| &excerpt.cuts) {
            let Location { path, line, column } = &cut.at;
            let path = name(path);
            let shown = format!("{path}:{line}:{}", cut.shown_column);
            text = text.replacen(&shown, &format!("{path}:{line}:{column}"), 1);
        }
        // annotate-snippets leaves blanks at the ends of some lines.
        let mut trimmed: String = text.lines().flat_map(|line| [line.trim_end(), "\n"]).collect();
        trimmed.push('\n');
        trimmed
    }
}

fn snippet(excerpt: &Excerpt) -> Snippet<'_, annotate_snippets::Annotation<'_>> {
    let annotations = excerpt.marks.iter().map(|mark| {
        let kind = if mark.primary { AnnotationKind::Primary } else { AnnotationKind::Context };
        let label = (!mark.text.is_empty()).then_some(mark.text.as_str());
        kind.span(mark.range.clone()).label(label)
    });
    Snippet::source(excerpt.text.as_str())
        .path(excerpt.path.as_str())
        .line_start(excerpt.first_line as usize)
        .fold(true)
        .annotations(annotations)
}
