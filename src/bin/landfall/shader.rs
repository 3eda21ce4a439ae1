//! Reads and lays out the single shader of a command, and selects a block.

use std::path::Path;

#[cfg(feature = "exec")]
use landfall_layout::Severity;
use landfall_layout::diagnostic::Code;
use landfall_layout::{BlockLayout, Diagnostic, ShaderLayout};
#[cfg(any(feature = "exec", feature = "port"))]
use landfall_layout::{Options, Source, Target};

use crate::args::ReadArgs;
use crate::layout::{is_named, is_syntax};
use crate::output::{CommandFailure, FindingStyle, Streams};
use crate::{read, without_effect};

/// Maximum number of names in a message.
const NAMES: usize = 8;

/// Reads a shader, lays it out and reports findings; fails if it cannot be parsed.
pub fn laid_out(
    path: &Path,
    args: &ReadArgs,
    structure: Option<&str>,
    streams: &Streams,
    style: FindingStyle,
) -> Result<ShaderLayout, CommandFailure> {
    let source = read::source(path, args).map_err(|error| style.refused(error.into()))?;
    let options = read::options(args).with_structure(structure.map(str::to_string));
    let shader = landfall_layout::layout(&source, &options);
    without_effect::record_of(&shader);
    let found = style.text(&shader.diagnostics, &shader.files);
    // After an error of syntax, what follows would be wrong; other errors leave the rest of the
    // layout.
    if shader.diagnostics.iter().any(is_syntax) {
        return Err(CommandFailure::Findings(found));
    }
    streams.report(&found);
    Ok(shader)
}

/// Records the names of a shader that is executed or ported, and warns of blocks whose layout
/// depends on the API that was assumed, which it returns.
#[cfg(any(feature = "exec", feature = "port"))]
pub fn record(
    source: &Source,
    options: &Options,
    streams: &Streams,
    style: FindingStyle,
) -> Option<Target> {
    record_with(source, options, Vec::new(), streams, style)
}

/// The same, with what was found before.
#[cfg(any(feature = "exec", feature = "port"))]
fn record_with(
    source: &Source,
    options: &Options,
    mut found: Vec<Diagnostic>,
    streams: &Streams,
    style: FindingStyle,
) -> Option<Target> {
    let shader = landfall_layout::layout(source, options);
    without_effect::record_of(&shader);
    let target = |found: &Diagnostic| found.code == Code::TargetChangesLayout;
    found.extend(shader.diagnostics.into_iter().filter(target));
    streams.report(&style.text(&found, &shader.files));
    shader.assumed_target
}

/// Records a shader of which one function is called, and warns of what no compiler takes in the
/// others.
#[cfg(feature = "exec")]
pub fn record_function(
    source: &Source,
    options: &Options,
    streams: &Streams,
    style: FindingStyle,
) -> Option<Target> {
    let mut found = landfall_lint::function_errors(source, options);
    // The called function may be right although others are not.
    for error in &mut found {
        (error.code, error.severity) = (Code::InvalidShader, Severity::Warning);
    }
    record_with(source, options, found, streams, style)
}

/// The block with this name, or the only block that has bytes.
pub fn block<'a>(
    shader: &'a ShaderLayout,
    name: Option<&str>,
) -> Result<&'a BlockLayout, Diagnostic> {
    let meant: Vec<&BlockLayout> = match name {
        Some(name) => shader.blocks.iter().filter(|block| is_named(block, name)).collect(),
        // Loose uniforms have no bytes unless they are gathered into a block.
        None => shader.blocks.iter().filter(|block| block.size.is_some()).collect(),
    };
    match (meant.as_slice(), name) {
        ([block], _) if block.size.is_some() => Ok(block),
        ([], Some(_)) => Err(no_block(shader, name)),
        ([], None) if shader.blocks.is_empty() => Err(no_block(shader, name)),
        ([] | [_], _) => {
            let message = format!("no block of `{}` has any bytes", shader.path);
            let help =
                "loose uniforms are uploaded one by one; `--gather` lays them out as a block";
            Err(finding(&shader.path, Code::NoBytes, message, Some(help.to_string())))
        }
        (blocks, Some(name)) => {
            let message =
                format!("{} blocks of `{}` are named `{name}`", blocks.len(), shader.path);
            let instances = blocks.iter().filter_map(|block| block.instance.as_deref());
            let help = format!("name one by its instance: {}", names(instances));
            Err(finding(&shader.path, Code::AmbiguousBlock, message, Some(help)))
        }
        (blocks, None) => {
            let message = format!("`{}` has {} blocks", shader.path, blocks.len());
            let all = names(blocks.iter().map(|block| own_name(block)));
            let help = format!("select one with `--block`: {all}");
            Err(finding(&shader.path, Code::WhichBlock, message, Some(help)))
        }
    }
}

/// The finding for a shader without blocks, or without a block of this name.
pub fn no_block(shader: &ShaderLayout, name: Option<&str>) -> Diagnostic {
    let all = names(shader.blocks.iter().map(own_name));
    let help = (!shader.blocks.is_empty()).then(|| format!("available: {all}"));
    let path = &shader.path;
    let (code, message) = match name {
        Some(name) => (Code::UnknownBlock, format!("no block named `{name}` in `{path}`")),
        None => (Code::NoBlocks, format!("no blocks and no loose uniforms in `{path}`")),
    };
    finding(path, code, message, help)
}

/// The name of a block, or its instance name if it has none.
fn own_name(block: &BlockLayout) -> &str {
    match &*block.name {
        "" => block.instance.as_deref().unwrap_or_default(),
        name => name,
    }
}

/// Formats the first few names: `` `A`, `B`, … ``.
fn names<'n>(names: impl Iterator<Item = &'n str>) -> String {
    // One more is taken, to see whether there are more.
    let mut quoted: Vec<String> = names.take(NAMES + 1).map(|name| format!("`{name}`")).collect();
    if quoted.len() > NAMES {
        quoted[NAMES] = "…".to_string();
    }
    quoted.join(", ")
}

/// A finding about a request for a file.
pub fn finding(path: &str, code: Code, message: String, help: Option<String>) -> Diagnostic {
    Diagnostic::about(code, message, help, path)
}
