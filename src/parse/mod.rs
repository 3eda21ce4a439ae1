//! From text to [`Shape`]: the declarations of a shader, function bodies passed over.

pub(crate) mod constant;
pub(crate) mod naga;
pub(crate) mod wgsl;

use crate::diagnostic::Diagnostic;
use crate::shape::Shape;
use crate::source::{Files, Language, ReadOptions, Source, Span};

/// What was read of a shader.
#[derive(Clone, Debug, Default)]
pub struct Parsed {
    /// Its blocks and the types in them.
    pub shape: Shape,
    /// The files it is made of: itself, then its includes.
    pub files: Files,
    /// What is wrong with it.
    pub diagnostics: Vec<Diagnostic>,
    /// Insides of functions, without their braces, in the order of the text.
    pub bodies: Vec<Span>,
}

/// Reads the declarations of a shader. With `gather`, loose uniforms become one std140 block.
pub fn parse(source: &Source, options: &ReadOptions, gather: bool) -> Parsed {
    match source.language {
        Language::Glsl => todo!(),
        Language::Wgsl => wgsl::read(source, options),
    }
}
