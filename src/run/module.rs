//! A shader as naga IR whose offsets, array strides and sizes are landfall's, validated.
//!
//! Fed by [`glsl`](super::glsl) for GLSL of any version and by naga's own front
//! end for WGSL. Feeds the evaluator and wgpu.

use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{GlobalVariable, Handle};

use crate::layout::BlockLayout;
use crate::source::{Files, Source, Span};
use crate::{Diagnostic, Options};

/// A runnable shader.
#[derive(Clone, Debug)]
pub struct Module {
    pub(crate) ir: naga::Module,
    pub(crate) info: ModuleInfo,
    /// The blocks that are variables of the module.
    pub(crate) blocks: Vec<ModuleBlock>,
    /// The files it is made of: itself, then its includes.
    pub(crate) files: Files,
    /// Where each file begins in the numbering of naga's spans.
    pub(crate) bases: Vec<u32>,
}

/// A block of a runnable shader.
#[derive(Clone, Debug)]
pub struct ModuleBlock {
    /// Where its members land.
    pub layout: BlockLayout,
    /// Its group (descriptor set) in the module; given out where the text has none.
    pub group: u32,
    /// Its binding in the module; given out where the text has none.
    pub binding: u32,
    /// Which buffer it is, of an array of blocks.
    pub element: Vec<u32>,
    pub(crate) variable: Handle<GlobalVariable>,
}

impl Module {
    pub fn new(_source: &Source, _options: &Options) -> Result<Module, Vec<Diagnostic>> {
        todo!()
    }
    pub fn by_naga(_source: &Source, _options: &Options) -> Result<Module, Vec<Diagnostic>> {
        todo!()
    }
    pub fn blocks(&self) -> &[ModuleBlock] {
        &self.blocks
    }
}
