//! Templates that a search finds, in commands that read one shader after another.

use landfall_check::inputs::Input;
use landfall_check::templates::Templates;
use landfall_layout::source::Files;
use landfall_layout::{Error, Severity, Source};

use crate::args::ReadArgs;
use crate::output::{FindingStyle, Streams};
use crate::read;

/// Reads an input; `None` for a template that is passed over.
pub fn source(
    templates: &Templates,
    input: &Input,
    args: &ReadArgs,
) -> Result<Option<Source>, Error> {
    match read::source(&input.path, args) {
        Err(error) if templates.passes_over(input, &error) => Ok(None),
        read => read.map(Some),
    }
}

/// As [`source`], of which the text is needed.
pub fn shader_text(
    templates: &Templates,
    input: &Input,
    args: &ReadArgs,
) -> Result<Option<Source>, Error> {
    let source = source(templates, input, args)?;
    source.map(|source| source.without_text().map_or(Ok(source), Err)).transpose()
}

/// Prints what was passed over, and returns whether that is an error: `is_all` that was found.
pub fn report(templates: &Templates, is_all: bool, style: FindingStyle, streams: &Streams) -> bool {
    let found = templates.findings(is_all);
    streams.report(&style.text(&found, &Files::default()));
    found.iter().any(|found| found.severity == Severity::Error)
}
