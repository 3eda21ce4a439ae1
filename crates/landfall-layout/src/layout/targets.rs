//! Comparison of block layouts under OpenGL and Vulkan, for shaders written for both.

use crate::diagnostic::Code;
use crate::layout::BlockLayout;
use crate::source::Target;
use crate::text::counts::{bytes, number};
use crate::{Diagnostic, Span};

/// The diagnostic code of a block whose layout depends on the target; the lint has the same name.
pub const CODE: &str = Code::TargetChangesLayout.name();

/// Returns the name of an API in prose.
pub fn name(target: Target) -> &'static str {
    match target {
        Target::OpenGl => "OpenGL",
        Target::Vulkan => "Vulkan",
    }
}

/// Returns the name of an API on the command line and in JSON.
pub fn key(target: Target) -> &'static str {
    match target {
        Target::OpenGl => "opengl",
        Target::Vulkan => "vulkan",
    }
}

/// Returns the other API.
pub fn other(target: Target) -> Target {
    match target {
        Target::OpenGl => Target::Vulkan,
        Target::Vulkan => Target::OpenGl,
    }
}

/// Returns a note for a shader whose target was assumed; `None` if it was not.
pub fn note(assumed: Option<Target>) -> Option<String> {
    let target = assumed?;
    let (this, that) = (name(target), name(other(target)));
    Some(format!("read for {this}, as the shader names no API; its blocks differ for {that}"))
}

/// Returns diagnostics for the blocks laid out differently under the other API, `there`; `None` if
/// all are laid out alike. With `of_loose`, loose uniforms say that `target` is OpenGL.
pub(crate) fn compare(
    here: &[BlockLayout],
    there: &[BlockLayout],
    target: Target,
    of_loose: bool,
) -> Option<Vec<Diagnostic>> {
    let why = match of_loose {
        // Loose uniforms are errors in Vulkan (GL_KHR_vulkan_glsl), unless its relaxed rules are
        // on.
        true => "uniforms outside blocks are valid for Vulkan with relaxed rules only",
        false => "the shader tests `VULKAN` and is valid for both APIs",
    };
    let mut differs = here.len() != there.len();
    let mut found = Vec::new();
    // By name and address space, the same in both APIs; sets and bindings may differ.
    for block in here {
        let same = |b: &&BlockLayout| b.name == block.name && b.space == block.space;
        match there.iter().find(same) {
            Some(copy) => found.extend(
                change(block, copy).map(|(text, span)| diagnostic(block, &text, span, target, why)),
            ),
            None => differs = true,
        }
    }
    // Otherwise nothing shows that the shader has blocks.
    if here.is_empty() {
        let that = name(other(target));
        found.extend(there.iter().filter(|block| block.size.is_some()).map(|block| {
            // Files that are included may have other numbers there.
            let span = if block.span.file == 0 { block.span } else { Span::default() };
            let message = format!("block `{}` exists only for {that}", block.name);
            explained(Diagnostic::warning(Code::TargetChangesLayout, span, message), target, why)
        }));
    }
    (differs || !found.is_empty()).then_some(found)
}

/// Describes the first leaf that is moved, removed or added, or a change of the block's size.
fn change(block: &BlockLayout, copy: &BlockLayout) -> Option<(String, Option<Span>)> {
    // Loose uniforms are set individually: they have no layout.
    let (here, there) = (block.size?, copy.size?);
    let by_path: rustc_hash::FxHashMap<&str, _> =
        copy.leaves.iter().map(|leaf| (leaf.path.as_str(), leaf)).collect();
    for leaf in &block.leaves {
        let path = &leaf.path;
        let Some(other) = by_path.get(path.as_str()) else {
            return Some((format!("`{path}` is removed"), Some(leaf.span)));
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
            return Some((format!("`{path}` has a different type or stride"), Some(leaf.span)));
        }
    }
    // Each leaf of this side is on the other one. A leaf that is new between them has moved a later
    // one, which is reported already, so that the new ones left are the last.
    if let Some(new) = copy.leaves.get(block.leaves.len()..).and_then(|rest| rest.first()) {
        return Some((format!("`{}` is added", new.path), None));
    }
    (here != there).then(|| (format!("it is {} instead of {}", bytes(there), number(here)), None))
}

fn diagnostic(
    block: &BlockLayout,
    text: &str,
    span: Option<Span>,
    target: Target,
    why: &str,
) -> Diagnostic {
    let that = name(other(target));
    let message = format!("block `{}` is laid out differently for {that}: {text}", block.name);
    let span = span.unwrap_or(block.span);
    explained(Diagnostic::warning(Code::TargetChangesLayout, span, message), target, why)
}

fn explained(found: Diagnostic, target: Target, why: &str) -> Diagnostic {
    found.with_note(format!("read for {}: {why}", name(target))).with_help(format!(
        "pass `--target {}` or `--target {}`",
        key(target),
        key(other(target))
    ))
}
