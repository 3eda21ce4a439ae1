//! A shader as naga IR whose offsets, array strides and sizes are landfall's, validated.
//!
//! Made by `lower` from GLSL of any version and from WGSL. Feeds the interpreter
//! and the drivers.

use landfall_layout::diagnostic::Code;
use std::panic::{self, AssertUnwindSafe};

use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{GlobalVariable, Handle};
use rustc_hash::FxHashSet;

mod describe;

use describe::{functions, handles};
use landfall_layout::Diagnostic;
use landfall_layout::layout::BlockLayout;
use landfall_layout::source::{Files, Span, Stage};

/// A runnable shader.
#[derive(Clone, Debug)]
pub struct Module {
    /// The naga module.
    pub ir: naga::Module,
    /// What naga's validator found out about it.
    pub info: ModuleInfo,
    /// The blocks that are variables of the module.
    pub blocks: Vec<ModuleBlock>,
    /// The files it is made of: itself, then its includes.
    pub files: Files,
    /// Where each file begins in the numbering of naga's spans.
    pub bases: Vec<u32>,
    pub(crate) handles: Vec<ModuleHandle>,
    pub(crate) functions: Vec<FunctionInfo>,
    pub(crate) inputs: Vec<EntryInterface>,
    pub(crate) outputs: Vec<EntryInterface>,
    pub(crate) left_out: Vec<LeftOut>,
    /// Names of local variables by expression.
    pub locals: Locals,
    /// The expressions that need no more than `mediump`, by their spans in naga's numbering.
    pub reduced: FxHashSet<(u32, u32)>,
}

/// What a local variable holds before anything is put into it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Locals {
    /// Zeros: WGSL §7.4.
    Zeros,
    /// Anything: GLSL 4.60 §4.3.
    Anything,
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
    /// Which element of an array of blocks it is, counted through all dimensions.
    pub element: Option<u32>,
    /// The variable in the naga module.
    #[allow(dead_code, reason = "readers of the IR find the block's memory by it")]
    pub variable: Handle<GlobalVariable>,
}

/// A texture, sampler or image of a runnable shader.
#[derive(Clone, Debug)]
pub struct ModuleHandle {
    /// The way to it in the text: `shadow_map`, `materials[2].diffuse`.
    pub path: String,
    /// Its group (descriptor set) in the module.
    pub group: u32,
    /// Its binding in the module.
    pub binding: u32,
    /// What it is. A `sampler2D` of GLSL is a texture and a sampler of one path.
    pub kind: HandleKind,
    /// The variable in the naga module.
    #[allow(dead_code, reason = "readers of the IR find the handle by it")]
    pub variable: Handle<GlobalVariable>,
}

/// What a handle is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum HandleKind {
    Texture,
    Sampler,
    Image,
}

/// An entry point.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EntryPoint {
    /// Its name; GLSL's is `main`.
    pub name: String,
    /// Vertex, fragment or compute.
    pub stage: Stage,
    /// Invocations in a workgroup of a compute shader.
    pub workgroup_size: [u32; 3],
}

/// An input or output of the entry point that has a location.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EntryInterface {
    /// Its name in the text, with the part of it: `light.color`, `basis[1]`.
    pub name: String,
    /// Its location in the module.
    pub location: u32,
    /// The variable it is a part of.
    pub variable: Handle<GlobalVariable>,
}

/// Which inputs of the stage a module has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Inputs {
    /// Those that `main` reaches.
    OfMain,
    /// Those that any function reaches.
    OfAny,
}

/// A function that is not in a module, as it does not run.
#[derive(Clone, Debug)]
pub struct LeftOut {
    /// Its name.
    pub function: String,
    /// Why.
    pub why: Diagnostic,
}

/// A function of the shader's own.
#[derive(Clone, Debug)]
pub struct FunctionInfo {
    /// Its name.
    pub name: String,
    /// Its parameters in order.
    pub parameters: Vec<Parameter>,
    /// What it returns, as its language spells it; `None` for nothing.
    pub returns: Option<String>,
    /// Its name in the text.
    pub span: Span,
    /// The function in the naga module.
    #[allow(dead_code, reason = "readers of the IR find the function by it")]
    pub handle: Handle<naga::Function>,
}

/// A parameter of a function.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// Its name; empty where there is none.
    pub name: String,
    /// Its type, as its language spells it.
    pub ty: String,
    /// Which way values go.
    pub direction: Direction,
}

/// Which way the values of a parameter go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// `in`: a copy.
    In,
    /// `out`: back only.
    Out,
    /// `inout`, or WGSL's pointer.
    InOut,
}

impl Module {
    /// The module as SPIR-V for Vulkan, names included, overrides with their values in force.
    ///
    /// # Errors
    /// What naga cannot write, in its words.
    #[cfg(feature = "spirv")]
    pub fn spirv(&self) -> Result<Vec<u32>, String> {
        use naga::back::{pipeline_constants::process_overrides, spv};
        // Not `ADJUST_COORDINATE_SPACE`: positions stay as the shader writes them.
        let flags = spv::WriterFlags::DEBUG | spv::WriterFlags::LABEL_VARYINGS;
        let options = spv::Options { flags, ..spv::Options::default() };
        let write = || {
            let (ir, info) = process_overrides(&self.ir, &self.info, None, &Default::default())
                .map_err(|error| chain(&error))?;
            spv::write_vec(&ir, &info, &options, None).map_err(|error| chain(&error))
        };
        match panic::catch_unwind(AssertUnwindSafe(write)) {
            Ok(words) => words,
            Err(_) => Err("naga panics when it writes this module".to_string()),
        }
    }

    /// Its entry points.
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

    /// The functions of the shader's own that can run, in the order of the text.
    pub fn functions(&self) -> &[FunctionInfo] {
        &self.functions
    }

    /// Its blocks; an array of blocks is one an element.
    pub fn blocks(&self) -> &[ModuleBlock] {
        &self.blocks
    }

    /// Its textures, samplers and images.
    pub fn handles(&self) -> &[ModuleHandle] {
        &self.handles
    }

    /// Inputs of the entry point that have locations; of GLSL only.
    pub fn inputs(&self) -> &[EntryInterface] {
        &self.inputs
    }

    /// Outputs of the entry point that have locations; of GLSL only.
    pub fn outputs(&self) -> &[EntryInterface] {
        &self.outputs
    }

    /// Functions that are not in the module, as nothing its entry point needs.
    pub fn left_out(&self) -> &[LeftOut] {
        &self.left_out
    }

    /// The files it is made of: itself, then its includes.
    pub fn files(&self) -> &Files {
        &self.files
    }

    /// The place in the user's text that an expression, statement or function came from.
    pub(crate) fn locate(&self, span: naga::Span) -> Option<Span> {
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

    /// Bindings nobody has, in a group that somebody has: adapters have few groups.
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
    /// What naga refuses, with places in the text.
    pub fn validated(mut self) -> Result<Module, Vec<Diagnostic>> {
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::all());
        let ir = &self.ir;
        // naga's validator asserts what its own front ends promise.
        let result = panic::catch_unwind(AssertUnwindSafe(|| validator.validate(ir)));
        match result {
            Ok(Ok(info)) => {
                self.info = info;
                Ok(self)
            }
            Ok(Err(error)) => {
                let spans = error.spans().filter_map(|(span, _)| self.locate(*span));
                let span = spans.last().unwrap_or_default();
                let message = format!("naga's validator refuses it: {}", chain(error.as_inner()));
                Err(vec![Diagnostic::error(Code::CannotRun, span, message)])
            }
            Err(_) => {
                let message = "naga's validator gives up on this shader";
                Err(vec![Diagnostic::error(Code::CannotRun, Span::default(), message)])
            }
        }
    }

    /// A module that naga has not validated yet.
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
            reduced: FxHashSet::default(),
            locals: Locals::Zeros,
        }
    }
}

/// What an error says, and what caused it.
fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text.push_str(": ");
        text.push_str(&error.to_string());
        cause = error.source();
    }
    text
}

/// Where each file begins in the numbering of naga's spans.
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

/// Gives out groups and bindings, each once.
#[derive(Debug, Default)]
pub(super) struct Binder {
    /// Those the text gives to somebody.
    reserved: FxHashSet<(u32, u32)>,
    taken: FxHashSet<(u32, u32)>,
}

impl Binder {
    pub fn reserve(&mut self, group: u32, binding: u32) {
        self.reserved.insert((group, binding));
    }

    /// The one that is wanted if nobody has it, else one that nobody has or wants.
    pub fn claim(&mut self, group: u32, wanted: Option<u32>) -> (u32, u32) {
        if let Some(binding) = wanted {
            if self.taken.insert((group, binding)) {
                return (group, binding);
            }
        }
        let free = (0..u32::MAX)
            .map(|binding| (group, binding))
            .find(|at| !self.reserved.contains(at) && !self.taken.contains(at))
            .expect("a shader has fewer than 2^32 bindings");
        self.taken.insert(free);
        free
    }
}
