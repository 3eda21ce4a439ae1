//! A shader as naga IR with Landfall's offsets, array strides and sizes.
//!
//! `lower` makes it from GLSL of any version and from WGSL; the interpreter and the drivers run it.

use landfall_layout::diagnostic::Code;
use landfall_layout::naga_front;

use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{GlobalVariable, Handle};
use std::collections::BTreeSet;

use rustc_hash::{FxHashMap, FxHashSet};

mod describe;

use describe::{functions, handles};
use landfall_layout::Diagnostic;
use landfall_layout::layout::BlockLayout;
use landfall_layout::source::{Files, Span, Stage};

/// A shader lowered to naga IR.
#[derive(Clone, Debug)]
pub struct Module {
    pub ir: naga::Module,
    /// The results of naga's validator.
    pub info: ModuleInfo,
    /// The blocks, each a variable of the module.
    pub blocks: Vec<ModuleBlock>,
    /// The files of the shader: its own, then its includes.
    pub files: Files,
    /// The first position of each file in naga's spans.
    pub bases: Vec<u32>,
    pub(crate) handles: Vec<ModuleHandle>,
    pub(crate) functions: Vec<FunctionInfo>,
    pub(crate) inputs: Vec<EntryInterface>,
    pub(crate) outputs: Vec<EntryInterface>,
    pub(crate) left_out: Vec<SkippedFunction>,
    pub locals: Locals,
    /// The spans, in naga's positions, of the expressions that need no more than `mediump`.
    pub reduced: BTreeSet<(u32, u32)>,
}

/// The value of a local variable without an initialiser.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Locals {
    /// Zero: WGSL §7.4.
    Zeros,
    /// Undefined: GLSL 4.60 §4.3.
    Anything,
}

/// A block of a runnable shader.
#[derive(Clone, Debug)]
pub struct ModuleBlock {
    pub layout: BlockLayout,
    /// The group (descriptor set) in the module, assigned if the text has none.
    pub group: u32,
    /// The binding in the module, assigned if the text has none.
    pub binding: u32,
    /// The flat index in an array of blocks; `None` for a single block.
    pub element: Option<u32>,
    #[allow(dead_code, reason = "readers of the IR find the block's memory by it")]
    pub variable: Handle<GlobalVariable>,
}

/// A texture, sampler or image of a runnable shader.
#[derive(Clone, Debug)]
pub struct ModuleHandle {
    /// The path in the text: `shadow_map`, `materials[2].diffuse`.
    pub path: String,
    /// Its group (descriptor set) in the module.
    pub group: u32,
    /// Its binding in the module.
    pub binding: u32,
    /// The kind; a `sampler2D` of GLSL becomes a texture and a sampler with the same path.
    pub kind: HandleKind,
    #[allow(dead_code, reason = "readers of the IR find the handle by it")]
    pub variable: Handle<GlobalVariable>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HandleKind {
    Texture,
    Sampler,
    Image,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EntryPoint {
    /// Its name; GLSL's is `main`.
    pub name: String,
    pub stage: Stage,
    pub workgroup_size: [u32; 3],
}

/// An input or output of the entry point that has a location.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EntryInterface {
    /// The path in the text: `light.color`, `basis[1]`.
    pub name: String,
    /// Its location in the module.
    pub location: u32,
    /// The variable that contains it.
    pub variable: Handle<GlobalVariable>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Inputs {
    /// The inputs that `main` or its callees read.
    #[default]
    OfMain,
    /// The inputs that any function reads.
    OfAny,
}

/// A function that could not be lowered and is not in the module.
#[derive(Clone, Debug)]
pub struct SkippedFunction {
    pub function: String,
    pub why: Diagnostic,
}

#[derive(Clone, Debug)]
pub struct FunctionInfo {
    pub name: String,
    pub parameters: Vec<Parameter>,
    /// The return type in the shader's language; `None` for `void`.
    pub returns: Option<String>,
    /// Its name in the text.
    pub span: Span,
    #[allow(dead_code, reason = "readers of the IR find the function by it")]
    pub handle: Handle<naga::Function>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// The name; empty if there is none.
    pub name: String,
    /// The type in the shader's language.
    pub ty: String,
    pub direction: Direction,
}

/// The direction in which a parameter's value is copied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// `in`: copied in.
    In,
    /// `out`: copied back.
    Out,
    /// `inout` in GLSL, a pointer in WGSL.
    InOut,
}

impl Module {
    /// Returns the module as SPIR-V for Vulkan, with names, and with overrides replaced by their
    /// values.
    ///
    /// # Errors
    /// naga's error if it cannot write the module.
    #[cfg(feature = "spirv")]
    pub fn spirv(&self) -> Result<Vec<u32>, String> {
        use naga::back::{pipeline_constants::process_overrides, spv};
        // Not `ADJUST_COORDINATE_SPACE`: positions stay as the shader writes them.
        let flags = spv::WriterFlags::DEBUG | spv::WriterFlags::LABEL_VARYINGS;
        let options = spv::Options { flags, ..spv::Options::default() };
        let write = || {
            let (ir, info) = process_overrides(&self.ir, &self.info, None, &Default::default())
                .map_err(|error| naga_front::causes(&error))?;
            spv::write_vec(&ir, &info, &options, None).map_err(|error| naga_front::causes(&error))
        };
        naga_front::caught(write)
            .unwrap_or_else(|| Err("naga panicked while writing this module".to_string()))
    }

    pub fn entry_points(&self) -> Vec<EntryPoint> {
        let entries = self.ir.entry_points.iter();
        let named = entries.filter_map(|entry| {
            let stage = match entry.stage {
                naga::ShaderStage::Vertex => Stage::Vertex,
                naga::ShaderStage::Fragment => Stage::Fragment,
                naga::ShaderStage::Compute => Stage::Compute,
                _ => return None,
            };
            let workgroup_size = entry.workgroup_size;
            Some(EntryPoint { name: entry.name.clone(), stage, workgroup_size })
        });
        named.collect()
    }

    /// Returns the shader's functions that were lowered, in the order of the text.
    pub fn functions(&self) -> &[FunctionInfo] {
        &self.functions
    }

    /// Returns the blocks, one for each element of an array of blocks.
    pub fn blocks(&self) -> &[ModuleBlock] {
        &self.blocks
    }

    /// Returns the textures, samplers and images.
    pub fn handles(&self) -> &[ModuleHandle] {
        &self.handles
    }

    /// Returns the inputs of the entry point that have locations; empty for WGSL.
    pub fn inputs(&self) -> &[EntryInterface] {
        &self.inputs
    }

    /// Returns the outputs of the entry point that have locations; empty for WGSL.
    pub fn outputs(&self) -> &[EntryInterface] {
        &self.outputs
    }

    /// Returns the functions that could not be lowered; the entry point does not need them.
    pub fn left_out(&self) -> &[SkippedFunction] {
        &self.left_out
    }

    /// The files of the shader: its own, then its includes.
    pub fn files(&self) -> &Files {
        &self.files
    }

    /// Returns the span in the source text of an expression, statement or function.
    pub(crate) fn locate(&self, span: naga::Span) -> Option<Span> {
        // The last file that begins at or before the position; each is one byte longer than its
        // text.
        let range = span.to_range()?;
        let (start, end) = (u32::try_from(range.start).ok()?, u32::try_from(range.end).ok()?);
        let file = self.bases.partition_point(|&base| base <= start).checked_sub(1)?;
        let base = self.bases[file];
        Some(Span {
            file: u32::try_from(file).ok()?,
            start: start - base,
            end: end.max(start) - base,
        })
    }

    /// Returns `N` unused bindings in a group that is already used, because adapters support few
    /// groups.
    pub fn free_places<const N: usize>(&self) -> [(u32, u32); N] {
        let taken = || self.ir.global_variables.iter().filter_map(|(_, global)| global.binding);
        let group = taken().map(|at| at.group).min().unwrap_or(0);
        let mine = taken().filter(|at| at.group == group).map(|at| at.binding);
        let mine: FxHashSet<u32> = mine.collect();
        let mut free = (0..u32::MAX).filter(|binding| !mine.contains(binding));
        std::array::from_fn(|_| {
            (group, free.next().expect("a shader has fewer than 2^32 bindings"))
        })
    }

    /// Validates the module.
    ///
    /// # Errors
    /// The errors of naga's validator, with their spans in the text.
    pub fn validated(mut self) -> Result<Module, Vec<Diagnostic>> {
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::all());
        let ir = &self.ir;
        // naga's validator asserts what its own front ends promise.
        let result = naga_front::caught(|| validator.validate(ir));
        match result {
            Some(Ok(info)) => {
                self.info = info;
                Ok(self)
            }
            Some(Err(error)) => {
                // The last label of naga's is the innermost place.
                let spans = error.spans().filter_map(|(span, _)| self.locate(*span));
                let span = spans.last().unwrap_or_default();
                let causes = naga_front::causes(error.as_inner());
                let message = format!("naga's validator rejects the module: {causes}");
                Err(vec![Diagnostic::error(Code::CannotRun, span, message)])
            }
            None => {
                let message = "naga's validator panicked on this shader";
                Err(vec![Diagnostic::error(Code::CannotRun, Span::default(), message)])
            }
        }
    }

    /// Creates a module that naga has not validated yet.
    pub fn unvalidated(ir: naga::Module, files: Files, blocks: Vec<ModuleBlock>) -> Module {
        Module {
            info: ModuleInfo::default(),
            bases: Bases::new(&files).starts,
            functions: functions(&ir),
            handles: handles(&ir),
            ir,
            blocks,
            files,
            inputs: Vec::new(),
            outputs: Vec::new(),
            left_out: Vec::new(),
            reduced: BTreeSet::new(),
            locals: Locals::Zeros,
        }
    }
}

/// The first position of each file in naga's spans.
#[derive(Clone, Debug, Default)]
pub(super) struct Bases {
    pub starts: Vec<u32>,
}

impl Bases {
    pub fn new(files: &Files) -> Bases {
        let mut starts = Vec::new();
        let mut next = 0u32;
        for file in files.iter() {
            starts.push(next);
            // One past the end, so that no two files share a number.
            next = next.saturating_add(file.text.len() as u32).saturating_add(1);
        }
        Bases { starts }
    }

    pub fn to_naga(&self, span: Span) -> naga::Span {
        let base = self.starts.get(span.file as usize).copied().unwrap_or(0);
        naga::Span::new(base.saturating_add(span.start), base.saturating_add(span.end))
    }
}

/// Assigns groups and bindings, each once.
#[derive(Debug, Default)]
pub(super) struct Binder {
    reserved: FxHashSet<(u32, u32)>,
    taken: FxHashSet<(u32, u32)>,
    /// The lowest binding of each group that may be free; bindings are never released.
    lowest: FxHashMap<u32, u32>,
}

impl Binder {
    pub fn reserve(&mut self, group: u32, binding: u32) {
        self.reserved.insert((group, binding));
    }

    /// Returns the wanted binding if it is free, else one that is neither taken nor reserved.
    pub fn claim(&mut self, group: u32, wanted: Option<u32>) -> (u32, u32) {
        // A binding that two blocks state goes to the first.
        if let Some(binding) = wanted {
            if self.taken.insert((group, binding)) {
                return (group, binding);
            }
        }
        let lowest = self.lowest.entry(group).or_default();
        let free = (*lowest..u32::MAX)
            .map(|binding| (group, binding))
            .find(|at| !self.reserved.contains(at) && !self.taken.contains(at))
            .expect("a shader has fewer than 2^32 bindings");
        *lowest = free.1;
        self.taken.insert(free);
        free
    }
}
