//! `landfall explain`: explains the offset of a path, or finds the member at a byte.

use landfall_check::files;
use landfall_layout::diagnostic::Code;
use landfall_layout::format::explain::{Answer, json, text};
use landfall_layout::format::phrases::bytes;
use landfall_layout::layout::byte::{ByteOwner, owner_of_byte};
use landfall_layout::layout::explain::explain;
use landfall_layout::layout::path::{PathError, PathErrorKind};
use landfall_layout::{BlockLayout, Diagnostic, Error, ShaderLayout};

use crate::args::{self, ExplainArgs, ExplainFormat};
use crate::layout::is_named;
use crate::output::{CommandFailure, FindingForm, Outcome, Streams};
use crate::read;
use crate::shader::{self, finding};

pub fn run(args: &ExplainArgs, streams: &Streams) -> Result<Outcome, CommandFailure> {
    let style = streams.style(FindingForm::json_if(args.format == ExplainFormat::Json));
    // `explain shader.frag lights data[0]`: a space in place of a dot.
    if let Some(rest) = &args.rest {
        let path = args.file.display().to_string();
        let message = format!("`{}` and `{rest}` are two paths: one is explained", args.place);
        let help = format!("write `{}.{rest}`", args.place);
        return Err(style.refused(finding(&path, Code::MalformedPath, message, Some(help))));
    }
    // The arguments in the other order.
    if args.file.extension().is_none() && args.file.symlink_metadata().is_err() {
        let (name, path) = (args.file.display(), &args.place);
        let help = format!("the shader comes first: `landfall explain SHADER '{name}.{path}'`");
        let error = Error::new(name.to_string(), "cannot be read: no such file or directory");
        return Err(style.refused(error.with_help(help).unreadable().into()));
    }
    let only = args.only.structure.as_deref();
    let mut shader = shader::laid_out(&args.file, &args.read, only, streams, style)?;
    if only.is_some() && shader.blocks.is_empty() {
        return Ok(Outcome::CouldNot); // reported
    }
    let mut place = args.place.as_str();
    // A path that no block has may begin with a structure: `Light.color` is explained by the
    // structure alone.
    if let (Err(_), Some((structure, rest))) = (answers(&shader, args, place), of_structure(args)) {
        (shader, place) = (structure, rest);
    }
    let answers = answers(&shader, args, place);
    let answers = answers.map_err(|found| style.failure(&[found], &shader.files))?;
    match args.format {
        ExplainFormat::Human => streams.product(&human(&shader, &answers, streams))?,
        ExplainFormat::Json => streams.json(&json(&shader, &answers))?,
    }
    Ok(if shader.has_errors() { Outcome::CouldNot } else { Outcome::Clean })
}

/// The structure that a path begins with, without errors, and the rest of the path. Stdin cannot be
/// read again.
fn of_structure(args: &ExplainArgs) -> Option<(ShaderLayout, &str)> {
    let (name, rest) = args.place.split_once('.')?;
    if args.only.structure.is_some() || args.block.is_some() || files::is_stdin(&args.file) {
        return None;
    }
    let source = read::source(&args.file, &args.read).ok()?;
    let options = read::options(&args.read).with_structure(Some(name.to_string()));
    let shader = landfall_layout::layout(&source, &options);
    (!shader.has_errors()).then_some((shader, rest))
}

fn human(shader: &ShaderLayout, answers: &[(&BlockLayout, Answer)], streams: &Streams) -> String {
    let texts =
        answers.iter().map(|(block, answer)| text(block, shader.language, answer, streams.paint));
    texts.collect::<Vec<_>>().join("\n")
}

/// The explanations of all blocks that have the path or byte.
fn answers<'a>(
    shader: &'a ShaderLayout,
    args: &ExplainArgs,
    place: &str,
) -> Result<Vec<(&'a BlockLayout, Answer)>, Diagnostic> {
    let named = |block: &&BlockLayout| args.block.as_ref().is_none_or(|name| is_named(block, name));
    let blocks: Vec<&BlockLayout> = shader.blocks.iter().filter(named).collect();
    if blocks.is_empty() {
        return Err(shader::no_block(shader, args.block.as_deref()));
    }
    match place.strip_prefix('@') {
        Some(byte) => of_byte(shader, &blocks, byte),
        None => of_path(shader, &blocks, place),
    }
}

fn of_byte<'a>(
    shader: &ShaderLayout,
    blocks: &[&'a BlockLayout],
    text: &str,
) -> Result<Vec<(&'a BlockLayout, Answer)>, Diagnostic> {
    let Ok(byte) = args::byte(text) else {
        let help = "write a byte offset as `@172` or `@0xac`".to_string();
        let message = format!("`@{text}` is not a byte offset");
        return Err(finding(&shader.path, Code::MalformedPath, message, Some(help)));
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
    // A byte is in every block that is long enough.
    let inside = owners.into_iter().filter(|(_, owner)| inside(owner));
    Ok(inside.map(|(block, owner)| (block, Answer::Byte(byte, owner))).collect())
}

fn outside(shader: &ShaderLayout, byte: u64, owners: &[(&BlockLayout, ByteOwner)]) -> Diagnostic {
    let mut notes = Vec::new();
    let mut help = None;
    for (block, owner) in owners {
        match owner {
            ByteOwner::Beyond { size } => {
                notes.push(format!("block `{}` has {}", block.name, bytes(*size)));
            }
            ByteOwner::Loose => {
                help = Some("`--gather` collects loose uniforms in a block".to_string());
            }
            ByteOwner::Component { .. } | ByteOwner::Padding { .. } => {}
        }
    }
    let message = format!("byte {byte} lies in no block");
    Diagnostic { notes, ..finding(&shader.path, Code::ByteOutOfRange, message, help) }
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
            // Report the block in which the most of the path resolves.
            Err(error) if furthest.as_ref().is_none_or(|f| rank(f) < rank(&error)) => {
                furthest = Some(error);
            }
            Err(_) => {}
        }
    }
    match furthest {
        Some(error) if found.is_empty() => {
            let meant = meant(blocks, path);
            let message = match &error.kind {
                // What is meant may be in another block than that of the error.
                PathErrorKind::UnknownMember { name, .. }
                    if meant.is_some() && error.resolved == 0 && blocks.len() > 1 =>
                {
                    format!("no block has a member `{name}`")
                }
                kind => kind.to_string(),
            };
            let help = meant.or_else(|| error.kind.help());
            Err(finding(&shader.path, error.kind.code(), message, help))
        }
        _ => Ok(found),
    }
}

/// What a path may stand for that is none: a byte, or the end of a longer path.
fn meant(blocks: &[&BlockLayout], path: &str) -> Option<String> {
    // A number without `@`, or a path without the block's first members.
    if args::byte(path).is_ok() {
        return Some(format!("a byte is written `@{path}`"));
    }
    let end = format!(".{}", without_indices(path));
    let leaves = blocks.iter().flat_map(|block| &block.leaves);
    let mut whole = leaves.filter(|leaf| without_indices(&leaf.path).ends_with(&end));
    let whole = whole.next()?.path.replace("[]", "[0]");
    Some(format!("there is a path `{whole}`"))
}

/// A path without what stands in its brackets, and without those.
fn without_indices(path: &str) -> String {
    let mut depth = 0u32;
    let keep = |c: &char| {
        depth += u32::from(*c == '[');
        let is_outside = depth == 0;
        depth = depth.saturating_sub(u32::from(*c == ']'));
        is_outside
    };
    path.chars().filter(keep).collect()
}

/// The length of the path that was resolved before an error.
fn rank(error: &PathError) -> (usize, bool) {
    // The further a path resolves, the likelier it is the one that was meant.
    let suggests = match &error.kind {
        PathErrorKind::UnknownMember { nearest, .. } => nearest.is_some(),
        PathErrorKind::Opaque { .. } => true,
        _ => false,
    };
    (error.resolved, suggests)
}
