//! A finding with its lines of text, drawn by annotate-snippets: the one place that names it.
//!
//! Fed by [`diagnostics`](super) and by `landfall_lint::render`.

use annotate_snippets::{
    AnnotationKind, Element, Group, Level, Origin, Padding, Renderer, Snippet,
};

use super::excerpt;
use super::excerpt::Excerpt;
use crate::diagnostic::{Label, Severity};
use crate::format::paint::Paint;
use crate::format::place::Places;
use crate::source::{Files, Location};
use crate::text::escape::{name, visible};

/// Columns an excerpt may take before annotate-snippets trims it: more than any line we hand over.
const WIDTH: usize = 240;

/// A finding as it is drawn.
pub struct Drawing<'a> {
    /// How serious it is.
    pub severity: Severity,
    /// The kebab-case code.
    pub code: &'a str,
    /// One sentence.
    pub message: &'a str,
    /// The main place when its text cannot be shown; line 0 stands for the file as a whole.
    pub origin: Option<Location>,
    /// The main place first if it can be shown, then the others.
    pub labels: &'a [Label],
    /// Facts that explain the message.
    pub notes: Vec<String>,
    /// Lines whose columns are aligned.
    pub listing: Option<&'a str>,
    /// The smallest edit that fixes it.
    pub help: Option<&'a str>,
}

/// What draws findings about some files.
pub struct Pen<'a> {
    files: &'a Files,
    places: Places<'a>,
    renderer: Renderer,
}

impl<'a> Pen<'a> {
    /// A pen for texts of these files.
    pub fn new(files: &'a Files, paint: Paint) -> Pen<'a> {
        let renderer = match paint {
            Paint::Plain => Renderer::plain(),
            Paint::Ansi => Renderer::styled(),
        };
        Pen { files, places: Places::new(files), renderer: renderer.term_width(WIDTH) }
    }

    /// The text of a finding and an empty line.
    pub fn draw(&mut self, drawing: Drawing<'_>) -> String {
        let level = match drawing.severity {
            Severity::Error => Level::ERROR,
            Severity::Warning => Level::WARNING,
        };
        let mut elements: Vec<Element<'_>> = Vec::new();
        let mut notes: Vec<String> = drawing.notes.iter().map(|note| visible(note)).collect();
        let main = if drawing.origin.is_some() { None } else { Some(0) };
        let mut excerpts = excerpt::excerpts(drawing.labels, main, self.files, &mut self.places);
        for excerpt in &mut excerpts {
            excerpt.path = name(&excerpt.path).into_owned();
            notes.extend(excerpt.elsewhere.iter().map(|note| visible(note)));
        }
        let listing =
            drawing.listing.map(|text| format!("the layout\n{}", visible(text.trim_end())));
        notes.extend(listing);
        let help = drawing.help.map(visible);
        if let Some(at) = &drawing.origin {
            let origin = Origin::path(name(&at.path).into_owned());
            elements.push(match at.line {
                0 => origin.into(),
                line => origin.line(line as usize).char_column(at.column as usize).into(),
            });
            if excerpts.is_empty() && (help.is_some() || !notes.is_empty()) {
                elements.push(Padding.into());
            }
        }
        elements.extend(excerpts.iter().map(|excerpt| snippet(excerpt).into()));
        elements.extend(notes.iter().map(|note| Level::NOTE.message(note.as_str()).into()));
        elements.extend(help.iter().map(|help| Level::HELP.message(help.as_str()).into()));
        let message = visible(drawing.message);
        let title = level.primary_title(message.as_str()).id(drawing.code);
        let group: Group<'_> = title.elements(elements);
        let mut text = self.renderer.render(&[group]);
        // The column of a place in a line that was cut is counted in what was left of it.
        for cut in excerpts.iter().flat_map(|excerpt| &excerpt.cuts) {
            let Location { path, line, column } = &cut.at;
            let path = name(path);
            let shown = format!("{path}:{line}:{}", cut.shown_column);
            text = text.replacen(&shown, &format!("{path}:{line}:{column}"), 1);
        }
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
