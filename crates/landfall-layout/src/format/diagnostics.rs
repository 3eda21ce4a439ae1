//! Findings as text with source excerpts, and as JSON, one object per line.

mod excerpt;
pub mod render;

use super::escape_controls;
use super::paint::Paint;
use super::place::Places;
use crate::diagnostic::{Diagnostic, Label, Severity};
use crate::source::{Files, Location, Span};
use crate::text::counts::number;
use crate::text::escape;
use render::DiagnosticRenderer;

/// The most findings of one shader shown as text; the rest are counted.
pub const MAX_SHOWN: usize = 100;

/// Renders the findings of one shader as text: at most [`MAX_SHOWN`], then the number left out.
pub fn human(diagnostics: &[Diagnostic], files: &Files, paint: Paint) -> String {
    let mut pen = DiagnosticRenderer::new(files, paint);
    let mut text = String::new();
    for diagnostic in diagnostics.iter().take(MAX_SHOWN) {
        text.push_str(&pen.draw(diagnostic, origin(diagnostic).as_ref()));
    }
    if diagnostics.len() > MAX_SHOWN {
        let more = diagnostics.len() - MAX_SHOWN;
        let path = files.get(0).map_or("the shader", |file| file.path.as_str());
        let more = number(more as u64);
        text.push_str(&format!("… and {more} more in {}\n\n", escape::name(path)));
    }
    escape_controls(text, paint)
}

/// The file of a diagnostic without labels, unless the message already begins with its path.
fn origin(diagnostic: &Diagnostic) -> Option<Location> {
    let path = diagnostic
        .path
        .as_ref()
        .filter(|path| diagnostic.labels.is_empty() && !diagnostic.message.contains(path.as_str()));
    path.map(|path| Location { path: path.clone(), line: 0, column: 0 })
}

/// The schema of [`DIAGNOSTIC_SCHEMA`](super::DIAGNOSTIC_SCHEMA).
#[cfg(feature = "schema")]
#[doc(hidden)]
pub fn schema() -> String {
    crate::schema::text::<DiagnosticObject<'_>>("A landfall finding")
}

/// Renders all findings of one shader as JSON, one object per line.
pub fn json(diagnostics: &[Diagnostic], files: &Files) -> String {
    let mut places = Places::new(files);
    let mut text = String::new();
    for diagnostic in diagnostics {
        let object = DiagnosticObject::new(diagnostic, files, &mut places);
        let line = serde_json::to_string(&object).expect("keys are strings");
        text.push_str(&escape::json(&line));
        text.push('\n');
    }
    text
}

/// One line of stderr with --format json. Lines and columns count from 1, columns in characters;
/// end_column is one past the last.
#[derive(serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct DiagnosticObject<'a> {
    severity: Severity,
    /// The kebab-case code of the finding.
    #[cfg_attr(feature = "schema", schemars(regex(pattern = r"^[a-z0-9]+(-[a-z0-9]+)*$")))]
    code: &'a str,
    message: &'a str,
    /// The file that the finding is about.
    path: Option<String>,
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    line: Option<u32>,
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    column: Option<u32>,
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    end_line: Option<u32>,
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    end_column: Option<u32>,
    /// Places in the source, the main one first.
    labels: Vec<LabelObject<'a>>,
    notes: &'a [String],
    /// The smallest edit that fixes the problem.
    help: Option<&'a str>,
}

#[derive(serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct LabelObject<'a> {
    path: String,
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    line: u32,
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    column: u32,
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    end_line: u32,
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    end_column: u32,
    /// The label's text; may be empty.
    text: &'a str,
}

impl<'a> DiagnosticObject<'a> {
    fn new(
        diagnostic: &'a Diagnostic,
        files: &Files,
        places: &mut Places<'_>,
    ) -> DiagnosticObject<'a> {
        let labels: Vec<LabelObject<'a>> = diagnostic
            .labels
            .iter()
            .filter(|label| files.get(label.at.file).is_some())
            .map(|label| label_object(label, files.resolve(label.at), places))
            .collect();
        let main = labels.first();
        let shader = files.get(0).map(|file| file.path.clone());
        DiagnosticObject {
            severity: diagnostic.severity,
            code: diagnostic.code.name(),
            message: &diagnostic.message,
            path: main.map(|l| l.path.clone()).or_else(|| diagnostic.path.clone()).or(shader),
            line: main.map(|l| l.line),
            column: main.map(|l| l.column),
            end_line: main.map(|l| l.end_line),
            end_column: main.map(|l| l.end_column),
            labels,
            notes: &diagnostic.notes,
            help: diagnostic.help.as_deref(),
        }
    }
}

fn label_object<'a>(label: &'a Label, at: Span, places: &mut Places<'_>) -> LabelObject<'a> {
    let start = places.locate(at);
    let end = places.locate(Span { start: at.end, ..at });
    LabelObject {
        path: start.path,
        line: start.line,
        column: start.column,
        end_line: end.line,
        end_column: end.column,
        text: &label.text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnostic::Code;

    fn files(texts: &[(&str, &str)]) -> Files {
        let mut files = Files::default();
        for (path, text) in texts {
            files.add(*path, (*text).into());
        }
        files
    }

    fn at(files: &Files, file: u32, what: &str) -> Span {
        let text = &files.get(file).unwrap().text;
        let start = text.find(what).unwrap() as u32;
        Span { file, start, end: start + what.len() as u32 }
    }

    fn shown(diagnostic: &Diagnostic, files: &Files) -> String {
        human(std::slice::from_ref(diagnostic), files, Paint::Plain)
    }

    #[test]
    fn a_finding_shows_the_place_the_note_and_the_help() {
        let files = files(&[("a.frag", "#version 330\r\nuniform B {\r\n\tvec33 x;\r\n};\r\n")]);
        let found =
            Diagnostic::error(Code::UnknownType, at(&files, 0, "vec33"), "unknown type `vec33`")
                .with_text("not declared")
                .with_note("types must be declared before use")
                .with_help("write `vec3`");
        assert_eq!(
            shown(&found, &files),
            "\
error[unknown-type]: unknown type `vec33`
 --> a.frag:3:2
  |
3 |     vec33 x;
  |     ^^^^^ not declared
  |
  = note: types must be declared before use
  = help: write `vec3`

"
        );
    }

    #[test]
    fn labels_in_other_files_and_lines_far_away_are_shown() {
        let far = format!("struct A {{ float x; }};\n{}struct A {{ int y; }};\n", "\n".repeat(500));
        let files = files(&[("a.frag", &far), ("b.glsl", "struct A { vec4 z; };\n")]);
        let mut found =
            Diagnostic::error(Code::DuplicateName, at(&files, 0, "A { int"), "`A` twice")
                .with_label(at(&files, 0, "A { float"), "first here")
                .with_label(at(&files, 1, "A"), "and here");
        found.labels[0].at.end = found.labels[0].at.start + 1;
        found.labels[1].at.end = found.labels[1].at.start + 1;
        let text = shown(&found, &files);
        assert!(text.contains(" --> a.frag:502:8\n"), "{text}");
        assert!(text.contains("- first here"), "{text}");
        assert!(text.contains("::: b.glsl:1:8\n"), "{text}");
        assert!(text.lines().count() < 20, "{text}");
    }

    #[test]
    fn a_line_of_two_megabytes_is_shown_around_its_place() {
        let mut line = "float 漢字; ".repeat(100_000);
        line.push_str("vec33 bad; ");
        line.push_str(&"float y; ".repeat(100_000));
        let files = files(&[("a.frag", &line)]);
        let found = Diagnostic::error(Code::UnknownType, at(&files, 0, "vec33"), "unknown type");
        let text = shown(&found, &files);
        assert!(text.contains("vec33 bad;"), "{text}");
        assert!(text.contains(" --> a.frag:1:1000001\n"), "{text}");
        assert!(text.len() < 1500, "{} bytes", text.len());
    }

    #[test]
    fn places_at_the_end_of_the_text_and_empty_texts_are_shown() {
        for text in ["", "a", "a\n", "a\r\n", "\t\t", "漢"] {
            let files = files(&[("a.frag", text)]);
            let end = text.len() as u32;
            for (start, end) in [(end, end), (0, end), (end, end + 5)] {
                let found =
                    Diagnostic::error(Code::Syntax, Span { file: 0, start, end }, "unfinished");
                assert!(
                    shown(&found, &files).starts_with("error[syntax]: unfinished\n --> a.frag:")
                );
            }
        }
    }

    #[test]
    fn spans_over_lines_are_marked_on_their_first() {
        let files = files(&[("a.frag", "uniform B {\n  float a;\n} b;\n")]);
        let span = Span { file: 0, start: 8, end: 28 };
        let text = shown(&Diagnostic::warning(Code::NoBlocks, span, "this block"), &files);
        assert!(text.starts_with("warning[no-blocks]: this block\n --> a.frag:1:9\n"), "{text}");
        assert!(text.contains("1 | uniform B {\n  |         ^^^"), "{text}");
    }

    #[test]
    fn a_hundred_findings_are_shown_and_the_rest_counted() {
        let files = files(&[("a.frag", "float x;\n")]);
        let found: Vec<Diagnostic> =
            (0..140).map(|_| Diagnostic::error(Code::Syntax, Span::default(), "again")).collect();
        let text = human(&found, &files, Paint::Plain);
        assert_eq!(text.matches("error[syntax]").count(), 100);
        assert!(text.ends_with("… and 40 more in a.frag\n\n"));
        assert_eq!(json(&found, &files).lines().count(), 140);
    }

    #[test]
    fn an_unreadable_file_needs_no_excerpt() {
        let error = crate::Error::new("a.frag", "is a directory").with_help("name a file");
        let text = shown(&error.into(), &Files::default());
        assert_eq!(
            text,
            "error[unreadable-file]: `a.frag` is a directory\n  |\n  = help: name a file\n\n"
        );
    }
}
