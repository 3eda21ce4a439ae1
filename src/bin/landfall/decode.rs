//! `landfall decode`: prints the bytes of a block as a table or JSON, and flags suspicious values.

use landfall_check::files;
use landfall_layout::buffer::{BufferError, Decoded, decode};
use landfall_layout::diagnostic::Code;
use landfall_layout::format::diagnostics::MAX_SHOWN;
use landfall_layout::format::phrases::{bytes as bytes_of, number};
use landfall_layout::format::values;
use landfall_layout::source::Files;
use landfall_layout::{ArrayLen, BlockLayout, Diagnostic, Severity};

use crate::args::{DecodeArgs, DecodeFormat};
use crate::output::{CommandFailure, FindingForm, Outcome, Streams};
use crate::{read, shader};

pub fn run(args: &DecodeArgs, streams: &Streams) -> Result<Outcome, CommandFailure> {
    read::only_one_stdin(&args.file, &args.bytes)?;
    let form = FindingForm::json_if(args.format == DecodeFormat::Json);
    let style = streams.style(form);
    let refused = |found: Diagnostic| style.refused(found);
    let shader = shader::laid_out(&args.file, &args.read, None, streams, style)?;
    let block = shader::block(&shader, args.block.as_deref()).map_err(refused)?;
    let bytes = files::bytes(&args.bytes).map_err(|error| refused(error.into()))?;
    let decoded = decoded(block, &bytes, args).map_err(refused)?;
    streams.report(&style.text(&warnings(&decoded, args, form), &Files::default()));
    streams.product_of(|out| match args.format {
        DecodeFormat::Table => values::table(&decoded, shader.language, streams.paint, out),
        DecodeFormat::Json => values::json(&decoded, out),
    })?;
    // What could be decoded of an erroneous shader is printed, but is no success.
    Ok(if shader.has_errors() {
        Outcome::CouldNot
    } else if decoded.findings.list.is_empty() && decoded.notes.is_empty() {
        Outcome::Clean
    } else {
        Outcome::Findings
    })
}

/// Decodes the part of the bytes that belongs to the block.
fn decoded<'a>(
    block: &'a BlockLayout,
    bytes: &'a [u8],
    args: &DecodeArgs,
) -> Result<Decoded<'a>, Diagnostic> {
    let path = files::display_path(&args.bytes);
    let given = bytes.len();
    // `None` for a block that ends in a runtime array.
    // A block with a runtime-sized array takes any length that has whole elements.
    let whole = match block.leaves.iter().any(|leaf| leaf.dims.first() == Some(&ArrayLen::Runtime))
    {
        true => None,
        false => block.size.and_then(|size| usize::try_from(size).ok()),
    };
    let refused = |error: BufferError| {
        let (message, help) = read::message_and_help(&error.to_string());
        shader::finding(&path, error.code(), message, help)
    };
    let part = match args.offset {
        // Without `--offset` a longer dump is an error rather than cut: its start may be another
        // block.
        None => {
            if let Some(whole) = whole.filter(|whole| given > *whole) {
                let help = format!(
                    "`--offset N` decodes the {} from byte N of a longer dump",
                    bytes_of(whole as u64)
                );
                let block = block.name.to_string();
                let (wanted, given) = (whole as u64, given as u64);
                let found = refused(BufferError::WrongLength { block, wanted, given, cut: None });
                return Err(found.with_help(help));
            }
            bytes
        }
        Some(offset) => {
            let rest = usize::try_from(offset).ok().and_then(|offset| bytes.get(offset..));
            let Some(rest) = rest else {
                let message =
                    format!("`{path}` has {}, none at offset {offset}", bytes_of(given as u64));
                return Err(shader::finding(&path, Code::OffsetOutOfRange, message, None));
            };
            // From the offset on, at most as long as the block.
            &rest[..whole.map_or(rest.len(), |whole| whole.min(rest.len()))]
        }
    };
    let decoded = decode(block, part).map_err(|error| {
        let found = refused(error);
        match args.offset {
            Some(offset) => found.with_note(format!(
                "`{path}` has {}, {} of them from byte {offset} on",
                bytes_of(given as u64),
                number(part.len() as u64)
            )),
            None => found,
        }
    })?;
    match &args.only {
        Some(path) => decoded.only(path).map_err(refused),
        None => Ok(decoded),
    }
}

/// Findings in the bytes; the first few only, in text form.
fn warnings(decoded: &Decoded<'_>, args: &DecodeArgs, form: FindingForm) -> Vec<Diagnostic> {
    let path = files::display_path(&args.bytes);
    let warning = |code, message| Diagnostic {
        severity: Severity::Warning,
        ..shader::finding(&path, code, message, None)
    };
    let notes = decoded.notes.iter().map(|note| warning(Code::OddLength, note.clone()));
    let findings = &decoded.findings;
    let all = findings.list.iter().map(|found| warning(found.code(), found.to_string()));
    let mut warnings: Vec<Diagnostic> = notes.chain(all).collect();
    let most = match form {
        FindingForm::Human => MAX_SHOWN,
        FindingForm::Json => usize::MAX,
    };
    let total = warnings.len() + findings.more;
    // One line of the most is for the count of the others.
    if total > most || findings.more > 0 {
        warnings.truncate(most - 1);
        let message = {
            let more = number((total - warnings.len()) as u64);
            format!("{more} more findings in `{path}`")
        };
        warnings.push(warning(Code::MoreFindings, message));
    }
    warnings
}
