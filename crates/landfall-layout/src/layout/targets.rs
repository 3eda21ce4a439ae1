//! Blocks of a text for OpenGL and Vulkan that are laid out otherwise for the other API.

use crate::diagnostic::Code;
use crate::layout::BlockLayout;
use crate::source::Target;
use crate::{Diagnostic, Span};

/// The code of a block whose layout depends on the target; a lint goes by that name.
pub const CODE: &str = Code::TargetChangesLayout.name();

/// The name of an API in prose.
pub fn name(target: Target) -> &'static str {
    match target {
        Target::OpenGl => "OpenGL",
        Target::Vulkan => "Vulkan",
    }
}

/// The name of an API on the command line and in JSON.
pub fn key(target: Target) -> &'static str {
    match target {
        Target::OpenGl => "opengl",
        Target::Vulkan => "vulkan",
    }
}

/// The API of that [`key`].
pub fn from_key(text: &str) -> Option<Target> {
    [Target::OpenGl, Target::Vulkan].into_iter().find(|target| key(*target) == text)
}

/// The API that a text was not read for.
pub fn other(target: Target) -> Target {
    match target {
        Target::OpenGl => Target::Vulkan,
        Target::Vulkan => Target::OpenGl,
    }
}

/// `read as OpenGL's; for Vulkan its blocks differ`, for a shader that had a target assumed.
pub fn note(assumed: Option<Target>) -> Option<String> {
    let target = assumed?;
    let (this, that) = (name(target), name(other(target)));
    Some(format!("read as {this}'s, which the text does not say; for {that} its blocks differ"))
}

/// The diagnostics of blocks that are laid out otherwise for the other API, `there`; `None` where
/// all are alike.
pub(crate) fn compare(
    here: &[BlockLayout],
    there: &[BlockLayout],
    target: Target,
) -> Option<Vec<Diagnostic>> {
    let mut differs = here.len() != there.len();
    let mut found = Vec::new();
    for block in here {
        let same = |b: &&BlockLayout| b.name == block.name && b.space == block.space;
        match there.iter().find(same) {
            Some(copy) => found.extend(
                change(block, copy).map(|(text, span)| diagnostic(block, &text, span, target)),
            ),
            None => differs = true,
        }
    }
    (differs || !found.is_empty()).then_some(found)
}

/// The first leaf that is elsewhere, gone or new, or a block of another size.
fn change(block: &BlockLayout, copy: &BlockLayout) -> Option<(String, Option<Span>)> {
    // Loose uniforms are set one by one: they have no layout.
    let (here, there) = (block.size?, copy.size?);
    let by_path: rustc_hash::FxHashMap<&str, _> =
        copy.leaves.iter().map(|leaf| (leaf.path.as_str(), leaf)).collect();
    for leaf in &block.leaves {
        let path = &leaf.path;
        let Some(other) = by_path.get(path.as_str()) else {
            return Some((format!("`{path}` is not there"), Some(leaf.span)));
        };
        if let (Some(here), Some(there), true) =
            (leaf.offset, other.offset, leaf.offset != other.offset)
        {
            return Some((format!("`{path}` is at {there} instead of {here}"), Some(leaf.span)));
        }
        let same = leaf.ty == other.ty
            && leaf.strides == other.strides
            && leaf.dims == other.dims
            && leaf.row_major == other.row_major
            && leaf.matrix_stride == other.matrix_stride;
        if !same {
            return Some((format!("`{path}` has another type or stride"), Some(leaf.span)));
        }
    }
    if let Some(new) = copy.leaves.get(block.leaves.len()..).and_then(|rest| rest.first()) {
        return Some((format!("`{}` is added", new.path), None));
    }
    (here != there).then(|| (format!("it is {there} bytes instead of {here}"), None))
}

fn diagnostic(block: &BlockLayout, text: &str, span: Option<Span>, target: Target) -> Diagnostic {
    let (this, that) = (name(target), name(other(target)));
    let message = format!("block `{}` is laid out otherwise for {that}: {text}", block.name);
    Diagnostic::warning(Code::TargetChangesLayout, span.unwrap_or(block.span), message)
        .with_note(format!("read as {this}'s: the text asks for `VULKAN` and would do for both"))
        .with_help(format!(
            "say which with `--target {}` or `--target {}`",
            key(target),
            key(other(target))
        ))
}
