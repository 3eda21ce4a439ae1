//! Guarded calls of naga's front ends: only bounded texts are parsed, and a panic yields `None`.

mod code;
mod limits;

pub use limits::excess;

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

pub use naga::Module;
use naga::{ArraySize, TypeInner};

use crate::diagnostic::{Code, Diagnostic};
use crate::source::{ExecutableStage, Language, Span, Stage};

/// Returns the number of elements of the named array type in a WGSL text, if naga accepts the text.
pub fn array_length(text: &str, name: &str) -> Option<u32> {
    let module = wgsl_module(text)?;
    let mut types = module.types.iter().map(|(_, ty)| ty);
    match types.find(|ty| ty.name.as_deref() == Some(name))?.inner {
        TypeInner::Array { size: ArraySize::Constant(length), .. } => Some(length.get()),
        _ => None,
    }
}

/// Parses a WGSL text; `None` if naga rejects it.
pub(crate) fn wgsl_module(text: &str) -> Option<Module> {
    guarded(text, Language::Wgsl, || naga::front::wgsl::parse_str(text).ok())
}

/// Parses a WGSL text; `None` where naga only lacks something that the language or a proposal for
/// it has, or is not given the text.
///
/// # Errors
/// The error for which naga refuses the text.
pub fn checked_wgsl(text: &str) -> Result<Option<Module>, Diagnostic> {
    if excess(text, Language::Wgsl).is_some() {
        return Ok(None);
    }
    let error = match caught(|| naga::front::wgsl::parse_str(text)) {
        Some(Ok(module)) => return Ok(Some(module)),
        Some(Err(error)) => error,
        None => return Ok(None),
    };
    let message = error.message();
    // What naga does not implement may be valid.
    if LACKS.iter().any(|part| message.contains(part)) {
        return Ok(None);
    }
    let (span, label) = match error.labels().next() {
        Some((span, label)) => (span.to_range().unwrap_or(0..0), label),
        None => (0..0, ""),
    };
    let span = Span { file: 0, start: span.start as u32, end: span.end as u32 };
    let found = Diagnostic::error(Code::InvalidShader, span, message);
    let found = if label.is_empty() { found } else { found.with_note(label) };
    Err(found.with_note("naga, the compiler of wgpu, refuses it"))
}

/// Parts of naga's messages about what it does not implement.
const LACKS: &[&str] = &[
    "not yet implemented",
    "not implemented",
    "not supported",
    "not yet supported",
    "unsupported",
    "unimplemented",
    "enable extension",
    "enable-extension",
    "language extension",
    "is not enabled",
    // What Tint has besides.
    "`color`",
    "`input_attachment_index`",
    "`subgroup_size`",
    "`barycentric_coord`",
    "`global_invocation_index`",
    "`workgroup_index`",
    "subgroup_matrix",
    "input_attachment",
    "unknown storage format",
    "unknown address space",
    "internal",
];

/// Parses a GLSL text; `None` if naga rejects it.
pub fn glsl_module(text: &str, stage: Option<Stage>) -> Option<Module> {
    glsl_whole(text, stage, &[])
}

/// Parses a GLSL text with defines; `None` if naga rejects it.
pub(crate) fn glsl_whole(
    text: &str,
    stage: Option<Stage>,
    defines: &[(String, String)],
) -> Option<Module> {
    let stage = match stage.map_or(Some(ExecutableStage::Vertex), ExecutableStage::from_stage)? {
        ExecutableStage::Vertex => naga::ShaderStage::Vertex,
        ExecutableStage::Fragment => naga::ShaderStage::Fragment,
        ExecutableStage::Compute => naga::ShaderStage::Compute,
    };
    let mut options = naga::front::glsl::Options::from(stage);
    options.defines.extend(defines.iter().cloned());
    guarded(text, Language::Glsl, || {
        naga::front::glsl::Frontend::default().parse(&options, text).ok()
    })
}

/// Runs a front end on a text within the limits; a panic yields `None`.
fn guarded(
    text: &str,
    language: Language,
    parse: impl FnOnce() -> Option<Module>,
) -> Option<Module> {
    if excess(text, language).is_some() {
        return None;
    }
    // naga 30.0.1 panics on GLSL's `float a[1000000000][8]`.
    caught(parse).flatten()
}

/// Runs the validator; a panic yields `None`.
pub(crate) fn guarded_validation<T>(validate: impl FnOnce() -> Option<T>) -> Option<T> {
    caught(validate).flatten()
}

/// The messages of an error of naga and of its causes, joined by `: `.
pub fn causes(error: &dyn std::error::Error) -> String {
    match error.source() {
        Some(cause) => format!("{error}: {}", causes(cause)),
        None => error.to_string(),
    }
}

thread_local! {
    /// The number of calls of naga on this thread, one inside the other.
    static CALLS: Cell<u32> = const { Cell::new(0) };
}

/// Calls naga; `None` if it panics, of which nothing is printed.
pub fn caught<T>(call: impl FnOnce() -> T) -> Option<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let print = panic::take_hook();
        // The hook of the program stays in use for all panics but those of naga, which are caught.
        panic::set_hook(Box::new(move |info| {
            // A panic that ends the process is printed.
            if CALLS.get() == 0 || cfg!(panic = "abort") {
                print(info);
            }
        }));
    });
    // Counted, as one guarded call may be within another.
    CALLS.set(CALLS.get() + 1);
    let result = panic::catch_unwind(AssertUnwindSafe(call));
    CALLS.set(CALLS.get() - 1);
    result.ok()
}
