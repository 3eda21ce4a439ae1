//! `landfall explain`: the way to a path, or the owner of a byte, in every block that has it.

use landfall::emit::explain::{Answer, json, text};
use landfall::layout::byte::{ByteOwner, owner_of_byte};
use landfall::layout::explain::explain;
use landfall::layout::path::{PathError, PathErrorKind};
use landfall::source::Files;
use landfall::{BlockLayout, Diagnostic, Severity, ShaderLayout};

use crate::args::{ExplainArgs, ExplainFormat};
use crate::layout::{is_named, is_syntax};
use crate::output::{Failure, FindingForm, Outcome, Streams};
use crate::read;

pub fn run(args: &ExplainArgs, streams: &Streams) -> Result<Outcome, Failure> {
    let form = match args.format {
        ExplainFormat::Human => FindingForm::Human,
        ExplainFormat::Json => FindingForm::Json,
    };
    let report = |found: &[Diagnostic], files: &Files| {
        streams.report(&streams.style(form).text(found, files));
    };
    let source = match read::source(&args.file, &args.read) {
        Ok(source) => source,
        Err(error) => {
            report(&[error.into()], &Files::default());
            return Ok(Outcome::CouldNot);
        }
    };
    let shader = landfall::layout(&source, &read::options(&args.read));
    report(&shader.diagnostics, &shader.files);
    if shader.diagnostics.iter().any(is_syntax) {
        return Ok(Outcome::CouldNot);
    }
    match answers(&shader, args) {
        Ok(answers) => {
            streams.product(&match args.format {
                ExplainFormat::Human => human(&shader, &answers, streams),
                ExplainFormat::Json => json(&shader.path, shader.language, &answers),
            })?;
            Ok(if shader.has_errors() { Outcome::CouldNot } else { Outcome::Clean })
        }
        Err(found) => {
            report(&[found], &shader.files);
            Ok(Outcome::CouldNot)
        }
    }
}

fn human(shader: &ShaderLayout, answers: &[(&BlockLayout, Answer)], streams: &Streams) -> String {
    let texts =
        answers.iter().map(|(block, answer)| text(block, shader.language, answer, streams.paint));
    texts.collect::<Vec<_>>().join("\n")
}

/// The answers of all blocks that have one.
fn answers<'a>(
    shader: &'a ShaderLayout,
    args: &ExplainArgs,
) -> Result<Vec<(&'a BlockLayout, Answer)>, Diagnostic> {
    let named = |block: &&BlockLayout| args.block.as_ref().is_none_or(|name| is_named(block, name));
    let blocks: Vec<&BlockLayout> = shader.blocks.iter().filter(named).collect();
    if blocks.is_empty() {
        return Err(no_block(shader, args));
    }
    match args.place.strip_prefix('@') {
        Some(byte) => of_byte(shader, &blocks, byte),
        None => of_path(shader, &blocks, &args.place),
    }
}

fn of_byte<'a>(
    shader: &ShaderLayout,
    blocks: &[&'a BlockLayout],
    text: &str,
) -> Result<Vec<(&'a BlockLayout, Answer)>, Diagnostic> {
    let parsed = match text.strip_prefix("0x") {
        Some(digits) => u64::from_str_radix(digits, 16),
        None => text.parse(),
    };
    let Ok(byte) = parsed else {
        let help = "a byte is written `@172` or `@0xac`".to_string();
        let message = format!("`@{text}` is no byte");
        return Err(finding(shader, "malformed-path", message, Some(help)));
    };
    let owners: Vec<(&BlockLayout, ByteOwner)> =
        blocks.iter().map(|block| (*block, owner_of_byte(block, byte))).collect();
    let inside = |owner: &ByteOwner| match owner {
        ByteOwner::Component { .. } | ByteOwner::Padding { .. } => true,
        ByteOwner::Beyond { .. } | ByteOwner::Loose => false,
    };
    if !owners.iter().any(|(_, owner)| inside(owner)) {
        return Err(outside(shader, byte, &owners));
    }
    let inside = owners.into_iter().filter(|(_, owner)| inside(owner));
    Ok(inside.map(|(block, owner)| (block, Answer::Byte(byte, owner))).collect())
}

fn outside(shader: &ShaderLayout, byte: u64, owners: &[(&BlockLayout, ByteOwner)]) -> Diagnostic {
    let mut notes = Vec::new();
    let mut help = None;
    for (block, owner) in owners {
        match owner {
            ByteOwner::Beyond { size } => {
                notes.push(format!("block `{}` has {size} bytes", block.name));
            }
            ByteOwner::Loose => {
                help = Some("`--gather` lays loose uniforms out as a block".to_string());
            }
            ByteOwner::Component { .. } | ByteOwner::Padding { .. } => {}
        }
    }
    let message = format!("byte {byte} lies in no block");
    Diagnostic { notes, ..finding(shader, "byte-out-of-range", message, help) }
}

fn of_path<'a>(
    shader: &ShaderLayout,
    blocks: &[&'a BlockLayout],
    path: &str,
) -> Result<Vec<(&'a BlockLayout, Answer)>, Diagnostic> {
    let mut found = Vec::new();
    let mut furthest: Option<PathError> = None;
    for &block in blocks {
        match explain(block, path, shader.language) {
            Ok(explanation) => found.push((block, Answer::Path(explanation))),
            // The block that the path leads furthest into is the one that was meant.
            Err(error) if furthest.as_ref().is_none_or(|f| rank(f) < rank(&error)) => {
                furthest = Some(error);
            }
            Err(_) => {}
        }
    }
    match furthest {
        Some(error) if found.is_empty() => {
            let (code, message) = (error.kind.code(), error.kind.to_string());
            Err(finding(shader, code, message, error.kind.help()))
        }
        _ => Ok(found),
    }
}

/// How near an error is to what was meant.
fn rank(error: &PathError) -> (usize, bool) {
    let suggests = match &error.kind {
        PathErrorKind::UnknownMember { nearest, .. } => nearest.is_some(),
        PathErrorKind::Opaque { .. } => true,
        PathErrorKind::Syntax { .. }
        | PathErrorKind::NotAStructure { .. }
        | PathErrorKind::NotAnArray { .. }
        | PathErrorKind::OutOfRange { .. }
        | PathErrorKind::Loose { .. } => false,
    };
    (error.resolved, suggests)
}

fn no_block(shader: &ShaderLayout, args: &ExplainArgs) -> Diagnostic {
    let names: Vec<String> = shader.blocks.iter().map(|b| format!("`{}`", b.name)).collect();
    let help = (!names.is_empty()).then(|| format!("there is {}", names.join(", ")));
    let (code, message) = match &args.block {
        Some(name) => ("unknown-block", format!("no block named `{name}` in `{}`", shader.path)),
        None => ("no-blocks", format!("no blocks and no loose uniforms in `{}`", shader.path)),
    };
    finding(shader, code, message, help)
}

/// A finding about what was asked of a shader.
fn finding(
    shader: &ShaderLayout,
    code: &'static str,
    message: String,
    help: Option<String>,
) -> Diagnostic {
    Diagnostic {
        code,
        severity: Severity::Error,
        message,
        path: Some(shader.path.clone()),
        labels: vec![],
        notes: vec![],
        help,
    }
}
