//! Makes a [`Module`] of a shader's text: calls the front end of its language.

use landfall_layout::source::{Language, Source};
use landfall_layout::{Diagnostic, Options};
use naga::valid::ModuleInfo;

use super::module::{Inputs, Locals, Module};
use super::stack::on_a_large_stack;
use super::{glsl, wgsl};

impl Module {
    /// Makes a shader runnable. Loose uniforms are one std140 block named `DefaultBlock`.
    ///
    /// # Errors
    /// What is wrong with the shader, or what in it cannot run, with its place.
    pub fn new(source: &Source, options: &Options) -> Result<Module, Vec<Diagnostic>> {
        on_a_large_stack(|| Module::made(source, options, Inputs::OfMain)?.validated())
    }

    /// The same for calls: its functions are called by themselves, with the inputs any of them
    /// reads.
    pub fn for_calls(source: &Source, options: &Options) -> Result<Module, Vec<Diagnostic>> {
        on_a_large_stack(|| Module::made(source, options, Inputs::OfAny)?.validated())
    }

    /// The same without asking naga's validator: for who only reads it.
    pub(super) fn unchecked(source: &Source, options: &Options) -> Result<Module, Vec<Diagnostic>> {
        on_a_large_stack(|| Module::made(source, options, Inputs::OfMain))
    }

    fn made(source: &Source, options: &Options, inputs: Inputs) -> Result<Module, Vec<Diagnostic>> {
        match source.language {
            Language::Glsl => {
                let lowered = glsl::lower(source, options, inputs)?;
                Ok(Module {
                    info: ModuleInfo::default(),
                    ir: lowered.ir,
                    blocks: lowered.blocks,
                    bases: lowered.bases.starts,
                    files: lowered.files,
                    handles: lowered.handles,
                    functions: lowered.functions,
                    inputs: lowered.inputs,
                    outputs: lowered.outputs,
                    left_out: lowered.left_out,
                    reduced: lowered.reduced,
                    locals: Locals::Anything,
                })
            }
            Language::Wgsl => wgsl::patched(source, options),
        }
    }

    /// The module as naga's own front end makes it, its offsets as naga has them: what a program
    /// that hands the text to wgpu gets. For proving naga wrong.
    ///
    /// # Errors
    /// What naga, or its validator, says of the text.
    pub fn by_naga(source: &Source, options: &Options) -> Result<Module, Vec<Diagnostic>> {
        on_a_large_stack(|| wgsl::by_naga(source, options)?.validated())
    }
}
