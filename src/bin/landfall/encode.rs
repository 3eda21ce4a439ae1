//! `landfall encode`: converts JSON values to the bytes of a block.

use landfall_check::files;
use landfall_layout::diagnostic::Code;
use std::ops::Range;
use std::path::Path;

use landfall_layout::buffer::{EncodeError, Finding, decode, encode, read_json};
use landfall_layout::file::FileWriter;
use landfall_layout::format::{Paint, hex};
use landfall_layout::source::Files;
use landfall_layout::{BlockLayout, Diagnostic, Error, Label, Severity, Span};

use crate::args::{EncodeArgs, HexLine};
use crate::output::{CommandFailure, FindingForm, Outcome, Streams};
use crate::{read, shader, write};

pub fn run(args: &EncodeArgs, streams: &Streams) -> Result<Outcome, CommandFailure> {
    let out = args.out.as_deref().filter(|path| !files::is_stdin(path));
    read::only_one_stdin(&args.file, &args.values)?;
    if out.is_none() && args.hex.is_none() {
        // Bytes are not printed on a terminal.
        streams.takes_bytes()?;
    }
    let style = streams.style(FindingForm::Human);
    let shader = shader::laid_out(&args.file, &args.read, None, streams, style)?;
    if shader.has_errors() {
        return Ok(Outcome::CouldNot);
    }
    let block = shader::block(&shader, args.block.as_deref());
    let block = block.map_err(|found| style.refused(found))?;
    let bytes = bytes(block, args).map_err(|(found, files)| style.failure(&[found], &files))?;
    streams.report(&style.text(&odd_bools(block, &bytes, args), &Files::default()));
    let writer = write::protecting([args.file.as_path(), &args.values], [&shader.files]);
    write(block, &bytes, args, out.map(|path| (path, writer)), streams)?;
    Ok(Outcome::Clean)
}

fn write(
    block: &BlockLayout,
    bytes: &[u8],
    args: &EncodeArgs,
    out: Option<(&Path, FileWriter)>,
    streams: &Streams,
) -> Result<(), Error> {
    match (out, args.hex) {
        (Some((path, writer)), None) => write::to(path, bytes, &writer, streams),
        // Without colours: it goes to a file.
        (Some((path, writer)), Some(HexLine(line))) => {
            let mut text = Vec::new();
            hex::dump(block, bytes, line, Paint::Plain, &mut text).map_err(|cause| {
                let reason = landfall_layout::file::reason(&cause);
                Error::unwritten(path.display().to_string(), format!("cannot be written: {reason}"))
            })?;
            write::to(path, text, &writer, streams)
        }
        (None, None) => streams.bytes(bytes),
        (None, Some(HexLine(line))) => {
            streams.product_of(|out| hex::dump(block, bytes, line, streams.paint, out))
        }
    }
}

/// Warns about bools that are neither 0 nor 1, which drivers interpret differently.
fn odd_bools(block: &BlockLayout, bytes: &[u8], args: &EncodeArgs) -> Vec<Diagnostic> {
    let found = decode(block, bytes).map(|decoded| decoded.findings.list).unwrap_or_default();
    let odd_bools = found.iter().filter(|found| matches!(found, Finding::OddBool { .. }));
    let path = files::display_path(&args.values);
    let warning = |found: &Finding| Diagnostic {
        severity: Severity::Warning,
        ..shader::finding(&path, found.code(), found.to_string(), None)
    };
    odd_bools.map(warning).collect()
}

/// Returns the encoded bytes, or the findings in the values.
fn bytes(block: &BlockLayout, args: &EncodeArgs) -> Result<Vec<u8>, (Diagnostic, Files)> {
    let path = files::display_path(&args.values);
    let text = match files::text(&args.values) {
        Ok(text) => text,
        Err(error) => {
            let is_json = args.values.to_str().is_some_and(|text| text.starts_with('{'));
            let error = match is_json {
                true => error.with_help("write the values to a file, or to standard input"),
                false => error,
            };
            return Err((error.into(), Files::default()));
        }
    };
    // An empty file is more likely a mistake than a block of zeros.
    if text.trim().is_empty() {
        let help = "write an object of the block's members; `{}` sets all of them to zero";
        let found = shader::finding(
            &path,
            Code::EmptyInput,
            format!("`{path}` is empty"),
            Some(help.to_string()),
        );
        return Err((found, Files::default()));
    }
    let made = read_json(&text).and_then(|values| encode(block, &values, args.missing.missing()));
    made.map_err(|error| explained(&error, path, text))
}

/// Converts an error in the values to a finding with its span.
fn explained(error: &EncodeError, path: String, text: String) -> (Diagnostic, Files) {
    let (message, mut help) = read::message_and_help(&error.to_string());
    let message = match error {
        EncodeError::Syntax { message, .. } => format!("malformed JSON: {message}"),
        EncodeError::Missing { .. } => {
            let words = "add it, or set missing members to zero with `--missing zero`";
            help = Some(words.to_string());
            message
        }
        _ => message,
    };
    let mut found = shader::finding(&path, error.code(), message, help);
    let mut files = Files::default();
    if let Some(span) = error.locate(&text).and_then(|range| span(&text, range)) {
        found.labels.push(Label { at: span, text: String::new() });
        files.add(path, text.into());
    }
    (found, files)
}

/// A range of bytes as a span of whole characters on one line; `None` past the limits of a span.
fn span(text: &str, range: Range<usize>) -> Option<Span> {
    let (mut start, mut end) = (range.start, range.end);
    // A span of bytes may begin within a character.
    while !text.is_char_boundary(start) {
        start -= 1;
    }
    while !text.is_char_boundary(end) {
        end += 1;
    }
    // Labels are of one line.
    if let Some(line) = text[start..end].find('\n').filter(|line| *line > 0) {
        end = start + line;
    }
    Some(Span { file: 0, start: start.try_into().ok()?, end: end.try_into().ok()? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_whole_characters_on_one_line() {
        let text = "{\n \"ä\": ü\n}";
        let shown = |range| {
            let span = span(text, range).expect("a short text");
            &text[span.start as usize..span.end as usize]
        };
        assert_eq!((shown(4..6), shown(5..7)), ("ä", "ä\""));
        assert_eq!((shown(0..13), shown(9..10)), ("{", "ü"));
        assert_eq!(shown(13..13), "");
    }
}
