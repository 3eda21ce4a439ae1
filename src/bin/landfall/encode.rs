//! `landfall encode`: values in JSON to the bytes of a block.

use std::path::Path;

use landfall::buffer::{EncodeError, encode, read_json};
use landfall::emit::{Paint, hex};
use landfall::file::write_whole;
use landfall::source::Files;
use landfall::{BlockLayout, Diagnostic, Error, Span};

use crate::args::EncodeArgs;
use crate::output::{Failure, FindingForm, Outcome, Streams};
use crate::{read, shader};

pub fn run(args: &EncodeArgs, streams: &Streams) -> Result<Outcome, Failure> {
    let out = args.out.as_deref().filter(|path| !read::is_stdin(path));
    read::only_one_stdin(&args.file, &args.values)?;
    if out.is_none() && !args.hex {
        streams.takes_bytes()?;
    }
    let style = streams.style(FindingForm::Human);
    let Some(shader) = shader::laid_out(&args.file, &args.read, streams, style) else {
        return Ok(Outcome::CouldNot);
    };
    if shader.has_errors() {
        return Ok(Outcome::CouldNot);
    }
    let made = shader::block(&shader, args.block.as_deref())
        .map_err(|found| (found, Files::default()))
        .and_then(|block| Ok((block, bytes(block, args)?)));
    match made {
        Ok((block, bytes)) => {
            write(block, &bytes, args, out, streams)?;
            Ok(Outcome::Clean)
        }
        Err((found, files)) => {
            streams.report(&style.text(&[found], &files));
            Ok(Outcome::CouldNot)
        }
    }
}

fn write(
    block: &BlockLayout,
    bytes: &[u8],
    args: &EncodeArgs,
    out: Option<&Path>,
    streams: &Streams,
) -> Result<(), Failure> {
    match (out, args.hex) {
        (Some(path), false) => Ok(write_whole(path, bytes)?),
        (Some(path), true) => {
            let mut text = Vec::new();
            hex::dump(block, bytes, Paint::Plain, &mut text).map_err(|cause| {
                let reason = landfall::file::reason(&cause);
                Error::new(path.display().to_string(), format!("cannot be written: {reason}"))
            })?;
            Ok(write_whole(path, text)?)
        }
        (None, false) => streams.bytes(bytes),
        (None, true) => streams.product_of(|out| hex::dump(block, bytes, streams.paint, out)),
    }
}

/// The bytes that the values make, or what is wrong with those.
fn bytes(block: &BlockLayout, args: &EncodeArgs) -> Result<Vec<u8>, (Diagnostic, Files)> {
    let path = read::shown(&args.values);
    let text = match read::text(&args.values) {
        Ok(text) => text,
        Err(error) => return Err((error.into(), Files::default())),
    };
    if text.trim().is_empty() {
        let help = "it takes an object of the block's members; `{}` makes all of them zero";
        let found = shader::finding(
            &path,
            "empty-input",
            format!("`{path}` is empty"),
            Some(help.to_string()),
        );
        return Err((found, Files::default()));
    }
    let made = read_json(&text).and_then(|values| encode(block, &values, args.missing.becomes()));
    made.map_err(|error| explained(&error, path, text))
}

/// An error in the values with its place in them.
fn explained(error: &EncodeError, path: String, text: String) -> (Diagnostic, Files) {
    let mut files = Files::default();
    let found = match error {
        EncodeError::Syntax { line, column, message } => {
            let span = span(&text, *line, *column);
            let message = format!("malformed JSON: {message}");
            if let (Ok(start), Ok(end)) = (span.start.try_into(), span.end.try_into()) {
                let file = files.add(path, text.into());
                Diagnostic::error(error.code(), Span { file, start, end }, message)
            } else {
                shader::finding(&path, error.code(), error.to_string(), None)
            }
        }
        EncodeError::Missing { path: member } => {
            let help = "give it, or let what is missing be zero with `--missing zero`";
            let message = format!("`{member}` is not given");
            shader::finding(&path, error.code(), message, Some(help.to_string()))
        }
        EncodeError::Block(_)
        | EncodeError::Key { .. }
        | EncodeError::Kind { .. }
        | EncodeError::Range { .. }
        | EncodeError::Length { .. }
        | EncodeError::Twice { .. } => {
            let (message, help) = read::message_and_help(&error.to_string());
            shader::finding(&path, error.code(), message, help)
        }
    };
    (found, files)
}

/// The character at a line and a column, the column counted in bytes; empty at the end.
fn span(text: &str, line: usize, column: usize) -> std::ops::Range<usize> {
    let line_start = text.split_inclusive('\n').take(line - 1).map(str::len).sum::<usize>();
    let mut start = (line_start + column.saturating_sub(1)).min(text.len());
    while !text.is_char_boundary(start) {
        start -= 1;
    }
    let len = text[start..].chars().next().map_or(0, char::len_utf8);
    start..start + len
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_whole_characters() {
        let text = "{\n \"ä\": ü\n}";
        assert_eq!(&text[span(text, 1, 1)], "{");
        assert_eq!(&text[span(text, 2, 8)], "ü");
        assert_eq!(&text[span(text, 2, 9)], "ü");
        assert_eq!(&text[span(text, 3, 1)], "}");
        assert_eq!(span(text, 9, 9), text.len()..text.len());
        assert_eq!(span("", 1, 0), 0..0);
    }
}
