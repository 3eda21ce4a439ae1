//! From text to [`Shape`]: the declarations of a shader, function bodies passed over.

pub mod constant;
pub mod glsl;
pub(crate) mod wgsl;

use crate::diagnostic::Diagnostic;
use crate::shape::Shape;
use crate::source::{Files, Language, ReadOptions, Source, Span, Target};

/// What was read of a shader.
#[derive(Clone, Debug, Default)]
pub struct Parsed {
    /// Its blocks and the types in them.
    pub shape: Shape,
    /// The files it is made of: itself, then its includes.
    pub files: Files,
    /// What is wrong with it.
    pub diagnostics: Vec<Diagnostic>,
    /// Function bodies in the shader's own file: from after `{` to before `}`.
    pub bodies: Vec<Span>,
    /// The API a GLSL text that asks for `VULKAN` was read for, where nothing says which.
    pub assumed: Option<Target>,
    /// Whether a WGSL text requires `uniform_buffer_standard_layout`.
    pub standard_uniforms: bool,
}

/// Reads the declarations of a shader. With `gather`, loose uniforms become one std140 block.
pub fn parse(source: &Source, options: &ReadOptions, gather: bool) -> Parsed {
    match source.language {
        Language::Glsl => glsl::read(source, options, gather),
        Language::Wgsl => wgsl::read(source, options),
    }
}
