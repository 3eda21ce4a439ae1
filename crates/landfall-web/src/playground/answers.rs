//! What `layout` and `emit` print for a shader, and its maps.

use landfall_codegen::{CodeOptions, languages};
use landfall_layout::diagnostic::Code;
use landfall_layout::finding::Finding;
use landfall_layout::format as emit;
use landfall_layout::format::{EmitOptions, Format, Paint, diagnostics};
use landfall_layout::source::Files;
use landfall_layout::text::escape;
use landfall_layout::{Diagnostic, Error, Options, Severity, ShaderLayout, Source};
use serde::Serialize;

use super::{Request, unknown};
use crate::html::{Page, Part, RULES};

/// What a command prints, without its notes on how often it did what, and its exit code.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Output {
    /// Standard output.
    pub stdout: String,
    /// The findings on standard error.
    pub stderr: String,
    /// The exit code.
    pub code: u8,
}

/// The maps of a shader's blocks and its findings, in the form of the page of `report`.
pub(super) fn map(
    request: &Request,
    source: &Source,
    options: &Options,
    findings: &[Finding],
) -> String {
    let shader = landfall_layout::layout(source, options);
    let mut by_rules = Vec::new();
    if !shader.blocks.is_empty() {
        let under = |rules| {
            (rules, landfall_layout::layout(source, &options.clone().with_rules(Some(rules))))
        };
        by_rules.extend(RULES.into_iter().map(under));
    }
    let findings: Vec<&Finding> = findings.iter().collect();
    let mut page = Page::default();
    page.add(&Part {
        path: &shader.path,
        shader: &shader,
        by_rules: &by_rules,
        findings: &findings,
        text: &|path| request.text_of(source, path),
        compared: None,
    });
    page.data("Playground")
}

/// What `landfall layout` prints.
pub(super) fn layout_of(shader: &mut ShaderLayout, format: Format) -> Output {
    let options = EmitOptions::new(format);
    let refused = emit::refused(shader, &options);
    shader.diagnostics.extend(refused);
    let failed = shader.has_errors();
    let unread = failed && shader.diagnostics.iter().any(|found| found.code.ends_parsing());
    let is_written = !unread && (format.is_data() || !shader.blocks.is_empty());
    let mut stdout = emit::opening(&options);
    if is_written {
        let text = emit::shader(shader, &options);
        stdout.push_str(&if format == Format::Json { escape::json(&text) } else { text.into() });
    }
    stdout.push_str(emit::closing(&options, usize::from(is_written)));
    let text = |found: &[Diagnostic], files: &Files| match format {
        Format::Json => diagnostics::json(found, files),
        _ => diagnostics::human(found, files, Paint::Plain),
    };
    let mut stderr = text(&shader.diagnostics, &shader.files);
    if !is_written && !failed {
        let message = format!("no blocks and no loose uniforms in `{}`", shader.path);
        let found = Diagnostic::without_place(Code::NoBlocks, Severity::Warning, message);
        stderr.push_str(&text(&[found], &Files::default()));
    }
    Output { stdout, stderr, code: if failed { 2 } else { 0 } }
}

/// What `landfall layout --format FORMAT` prints.
pub(super) fn layout(source: &Source, options: &Options, name: &str) -> Result<Output, Error> {
    let format = match name {
        "table" => Format::Table,
        "listing" => Format::Listing,
        "json" => Format::Json,
        "csv" => Format::Csv,
        "md" => Format::Markdown,
        other => return Err(unknown("--format", other)),
    };
    let options = options.clone().with_naga(format == Format::Json);
    Ok(layout_of(&mut landfall_layout::layout(source, &options), format))
}

/// What `landfall emit --lang LANG` prints.
pub(super) fn emit(source: &Source, options: &Options, lang: &str) -> Result<Output, Error> {
    let Some(lang) = languages::from_name(lang) else { return Err(unknown("--lang", lang)) };
    let text = |found: &[Diagnostic], files: &Files| diagnostics::human(found, files, Paint::Plain);
    let shader = landfall_layout::layout(source, options);
    let mut stderr = text(&shader.diagnostics, &shader.files);
    if shader.has_errors() {
        return Ok(Output { stderr, code: 2, ..Output::default() });
    }
    let code = lang.generate(&[&shader], &CodeOptions::default());
    let mut failed = false;
    for found in &code.diagnostics {
        let is_own = found.path.as_ref() == Some(&shader.path);
        let no_files = Files::default();
        let files = if is_own { &shader.files } else { &no_files };
        stderr.push_str(&text(std::slice::from_ref(found), files));
        failed |= found.severity == Severity::Error;
    }
    let refused = code.diagnostics.iter().any(|found| found.code == Code::BadName);
    let stdout = if refused { String::new() } else { code.text };
    Ok(Output { stdout, stderr, code: if failed { 2 } else { 0 } })
}
