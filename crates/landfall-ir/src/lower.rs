//! Lowers a shader's text to a [`Module`] with the front end of its language.

use landfall_layout::source::{Language, Source};
use landfall_layout::{Diagnostic, Options, ShaderLayout, linked};

use super::module::{Inputs, Module};
use super::stack::over_shader;
use super::{glsl, wgsl};

impl Module {
    /// Lowers and validates a shader. Loose uniforms become one std140 block named `DefaultBlock`.
    ///
    /// # Errors
    /// The errors in the shader, or the constructs that are not supported, with their
    /// spans.
    pub fn new(source: &Source, options: &Options) -> Result<Module, Vec<Diagnostic>> {
        over_shader(|| Module::made(source, options, Inputs::OfMain)?.validated())
    }

    /// Lowers a shader whose functions are called individually, with the inputs that any of them
    /// reads.
    pub fn for_calls(source: &Source, options: &Options) -> Result<Module, Vec<Diagnostic>> {
        over_shader(|| Module::made(source, options, Inputs::OfAny)?.validated())
    }

    /// Lowers a shader without running naga's validator, for analyses that only read the module.
    ///
    /// # Errors
    /// Those of [`new`](Module::new), but for the validator's.
    pub fn unchecked(source: &Source, options: &Options) -> Result<Module, Vec<Diagnostic>> {
        over_shader(|| Module::made(source, options, Inputs::OfMain))
    }

    /// Returns the same of a WGSL text that naga and the layout have read already.
    pub fn of_wgsl(parsed: naga::Module, shader: &ShaderLayout, options: &Options) -> Module {
        wgsl::with_layout(parsed, shader.clone(), options)
    }

    fn made(source: &Source, options: &Options, inputs: Inputs) -> Result<Module, Vec<Diagnostic>> {
        if let Some(error) = source.without_text() {
            return Err(vec![error.into()]);
        }
        match source.language {
            Language::Glsl | Language::SpirV => glsl::lower(source, options, inputs),
            Language::Wgsl => wgsl::patched(&linked(source, &options.read), options),
        }
    }

    /// Lowers a shader with naga's own front end and naga's offsets, as wgpu does, to compare naga
    /// with the specifications.
    ///
    /// # Errors
    /// The errors of naga's front end or validator.
    pub fn by_naga(source: &Source, options: &Options) -> Result<Module, Vec<Diagnostic>> {
        over_shader(|| wgsl::by_naga(&linked(source, &options.read), options)?.validated())
    }
}
