//! The request for a probe's code, the code, and what its forms share.

use std::borrow::Cow;
use std::sync::Arc;

use super::VerifyOptions;
use crate::backend::{BackendKind, Failure, FailureKind, LooseUniform, Resource, StageCode};
use crate::harness::probe::plan::Plan;
use landfall_layout::Diagnostic;
use landfall_layout::layout::BlockLayout;
use landfall_layout::source::{ExecutableStage, Language, ReadOptions, Source};
use landfall_layout::syntax::glsl::raw;

/// The probe for which code is made.
pub(super) struct ProbeRequest<'a> {
    pub backend: BackendKind,
    pub source: &'a Source,
    pub block: &'a BlockLayout,
    /// The indices of the buffer in an array of blocks.
    pub element: &'a [u32],
    pub plan: &'a Plan,
    pub stage: ExecutableStage,
    /// Whether the shader may write the block.
    pub writable: bool,
    pub options: &'a VerifyOptions,
}

/// A probe's code and the bindings of its buffers.
pub(super) struct ProbeCode {
    /// The stages in pipeline order.
    pub stages: Vec<StageCode>,
    pub block: BoundBuffer,
    pub results: ResultsPlace,
    /// What else the probe's module reaches: what initialisers of global variables read.
    pub others: Vec<Resource>,
    /// Whether the shader may write the block.
    pub writable: bool,
}

/// The place of a probe's results.
pub(super) enum ResultsPlace {
    /// A buffer, which starts with the plan's indices.
    Buffer(BoundBuffer),
    /// Pixels, a word in each; the indices are these uniforms.
    Pixels(Vec<LooseUniform>),
}

/// A buffer's name and its binding in the module.
#[derive(Clone, Debug, Default)]
pub(super) struct BoundBuffer {
    pub name: String,
    pub group: u32,
    pub binding: u32,
}

/// Returns OpenGL's name of a block, or of one buffer of an array of blocks: `B[0]`.
pub(crate) fn gl_name(block: &str, element: &[u32]) -> String {
    element.iter().fold(block.to_string(), |name, index| format!("{name}[{index}]"))
}

/// Returns whether the block holds the loose uniforms of a GLSL shader.
pub(crate) fn is_loose(source: &Source, block: &BlockLayout) -> bool {
    source.language == Language::Glsl && block.gathered
}

/// Returns the shader with its includes inlined, since drivers open no files.
pub(crate) fn opened<'a>(source: &'a Source, options: &ReadOptions) -> Cow<'a, Source> {
    if !source.text.contains("#include") {
        return Cow::Borrowed(source);
    }
    let text = raw::flattened(source, options);
    Cow::Owned(Source { text: Arc::from(text), ..source.clone() })
}

pub(super) fn failure(message: String) -> Failure {
    Failure { kind: FailureKind::Refused, message, log: String::new() }
}

pub(super) fn unfit(message: &str) -> Failure {
    Failure { kind: FailureKind::Unfit, ..failure(message.to_string()) }
}

pub(super) fn refused(what: &str, found: &[Diagnostic]) -> Failure {
    let first = found.first().map_or("no reason given", |first| first.message.as_str());
    Failure { kind: FailureKind::Unfit, ..failure(format!("it cannot be {what}: {first}")) }
}

/// Removes `WORD = N` from layout qualifiers; OpenGL has no descriptor sets.
pub(crate) fn without_qualifier(text: &str, word: &str) -> String {
    let mut result = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find(word) {
        let (step, after) = rest.split_at(at);
        result.push_str(step);
        // In the list of `layout(…)` only: anything else may have such a name.
        let list = result.rfind(['(', ')']).map(|at| result.split_at(at));
        // A whole word, not the end of `offset`.
        let opens = result.trim_end().ends_with(['(', ','])
            && list.is_some_and(|(head, list)| {
                list.starts_with('(') && head.trim_end().ends_with("layout")
            });
        let value = after[word.len()..].trim_start().strip_prefix('=').map(str::trim_start);
        let end = value.and_then(|value| {
            let digits = value.find(|c: char| !c.is_ascii_digit())?;
            (digits > 0).then(|| after.len() - value.len() + digits)
        });
        let Some(end) = end.filter(|_| opens) else {
            result.push_str(word);
            rest = &after[word.len()..];
            continue;
        };
        rest = &after[end..];
        // A comma beside it goes with it.
        if let Some(more) = rest.trim_start().strip_prefix(',') {
            rest = more;
        } else if result.trim_end().ends_with(',') {
            result.truncate(result.trim_end().len() - 1);
        } else if let (Some(more), Some(head)) =
            (rest.trim_start().strip_prefix(')'), result.trim_end().strip_suffix('('))
        {
            // An empty `layout()` is invalid.
            rest = more;
            let head = head.trim_end();
            let head = head.strip_suffix("layout").unwrap_or(head).len();
            result.truncate(head);
        }
    }
    result.push_str(rest);
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_qualifier_goes_and_nothing_else() {
        for (before, after) in [
            ("layout(set = 0, binding = 1) uniform", "layout( binding = 1) uniform"),
            ("layout(std140, set=12,binding=1)", "layout(std140, binding=1)"),
            ("layout(binding = 1, set = 2) uniform", "layout(binding = 1) uniform"),
            ("layout(set = 2) uniform", " uniform"),
            ("int offset = 3; f(set = 4);", "int offset = 3; f(set = 4);"),
            ("int reset; layout(offset = 16) float x;", "int reset; layout(offset = 16) float x;"),
        ] {
            assert_eq!(without_qualifier(before, "set"), after, "{before}");
        }
    }
}
