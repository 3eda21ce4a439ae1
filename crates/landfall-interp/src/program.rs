//! A compiled shader: instructions, constants, and its resources.
//!
//! Made by [`compile`](super::compile), run by [`machine`](super::machine).

use super::body::Argument;
use super::code::{Access, Class, Inst, Op, Origin, Reg, Values};
use super::counts::InstructionCost;
use super::interface::{Port, StageInterface};
use super::value::ValueType;
use landfall_layout::source::{Files, Language};
use naga::{GlobalVariable, Handle};

/// A shader compiled for the interpreter: every function and every entry point of a module.
#[derive(Clone, Debug)]
pub struct Program {
    pub(super) code: Vec<Inst>,
    pub(super) origins: Vec<Origin>,
    pub(super) costs: Vec<InstructionCost>,
    /// By function: the index of its first instruction.
    pub(super) starts: Vec<u32>,
    /// The operands of the instructions.
    pub(super) pool: Vec<u32>,
    pub(super) accesses: Vec<Access>,
    pub(super) values: Vec<Values>,
    /// The values of each class's constant registers, which are the first of their file.
    pub(super) constants: [Vec<u64>; 3],
    /// The number of registers of each class.
    pub(super) registers: [u32; 3],
    pub(super) buffers: Vec<BufferInfo>,
    pub(super) images: Vec<ImageInfo>,
    pub(super) functions: Vec<FunctionCode>,
    /// The code that fills private variables.
    pub(super) start: Result<FunctionCode, String>,
    pub(super) files: Files,
    pub(super) bases: Vec<u32>,
    pub(super) language: Language,
}

/// The precision to which a shader's `f32` are rounded. The `f64` beside them, or alone, are not
/// rounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Floats {
    /// As declared.
    #[default]
    AsWritten,
    /// `f16` for each operation and every value read: arguments, inputs, buffers, textures.
    Half,
    /// `f16` for `mediump` and `lowp` of OpenGL ES shaders: GLSL ES 3.20 §4.7, which also allows
    /// `lowp` to be fixed point of 10 bits in ±2; that is not modelled. Other shaders are as
    /// declared.
    Mediump,
}

impl Floats {
    /// The note on what is rounded, and on what is not modelled.
    pub fn note(self) -> Option<&'static str> {
        match self {
            Floats::AsWritten => None,
            Floats::Half => Some("every operation is rounded to f16"),
            Floats::Mediump => Some(
                "mediump and lowp are rounded to f16; a device may round lowp more coarsely, in \
                 fixed point between -2 and 2",
            ),
        }
    }
}

/// A buffer of the shader.
#[derive(Clone, Debug)]
pub(super) struct BufferInfo {
    pub name: String,
    /// The variable in the naga module.
    pub variable: Handle<GlobalVariable>,
    pub bound: (u32, u32),
    pub space: BufferSpace,
    /// The size in bytes without a runtime-sized array.
    pub size: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BufferSpace {
    Uniform,
    PushConstant,
    Storage { writable: bool },
    Workgroup,
}

/// An image that the shader samples.
#[derive(Clone, Debug)]
pub(super) struct ImageInfo {
    pub name: String,
    pub bound: (u32, u32),
}

/// A function's start and the registers of its interface.
#[derive(Clone, Debug)]
pub(super) struct FunctionCode {
    pub name: String,
    /// The first instruction, or the unsupported feature.
    pub state: Result<u32, String>,
    pub arguments: Vec<Argument>,
    pub result: Vec<Reg>,
    pub result_type: Option<ValueType>,
    /// The interface of an entry point.
    pub interface: Option<StageInterface>,
}

/// The signature of a function.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FunctionSignature {
    /// The name in the module.
    pub name: String,
    pub parameters: Vec<Parameter>,
    /// The type of the return value; `None` if there is none.
    pub result: Option<ValueType>,
}

/// A parameter of a function.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parameter {
    pub name: String,
    /// The type; the pointee's for a pointer.
    pub ty: ValueType,
    /// Whether its value is returned: `out`, `inout`, `ptr<function, …>`.
    pub returned: bool,
}

/// The global variables that a function reads and writes.
#[derive(Clone, Debug, Default)]
pub(super) struct ResourceUses {
    pub buffers: Vec<bool>,
    pub images: bool,
    pub derivatives: bool,
}

impl Program {
    /// Returns the registers that an instruction reads once, and those of its groups.
    pub(super) fn operands(&self, pc: usize) -> [&[u32]; 2] {
        let (inst, cost) = (&self.code[pc], &self.costs[pc]);
        let from = inst.at as usize;
        self.pool[from..from + cost.operands as usize].split_at(usize::from(inst.head)).into()
    }

    /// Returns the functions that can be called directly; not those that take textures.
    pub fn functions(&self) -> Vec<FunctionSignature> {
        let plain = self.functions.iter().filter(|f| f.state.is_ok() && f.interface.is_none());
        plain.filter_map(signature).collect()
    }

    /// Returns the signature of a function by its index in the module; `None` if a parameter has no
    /// plain value.
    ///
    /// # Errors
    /// Fails with the unsupported feature it uses.
    pub fn signature(&self, function: usize) -> Result<Option<FunctionSignature>, String> {
        let function = &self.functions[function];
        function.state.clone()?;
        Ok(signature(function))
    }

    /// Returns the variable of a buffer in the module, by the buffer's number in a trace.
    pub fn variable_of(&self, buffer: u32) -> Option<Handle<GlobalVariable>> {
        self.buffers.get(buffer as usize).map(|info| info.variable)
    }

    /// Returns the names of the entry points.
    pub fn entry_points(&self) -> impl Iterator<Item = &str> {
        self.functions.iter().filter(|f| f.interface.is_some()).map(|f| f.name.as_str())
    }

    /// Returns the inputs of an entry point, and for each scalar whether it is a float.
    pub fn inputs(&self, entry: &str) -> Vec<(Port, Vec<bool>)> {
        let found = self.functions.iter().find(|f| f.name == entry && f.interface.is_some());
        let interface = found.and_then(|function| function.interface.as_ref());
        let plugs = interface.map_or(&[][..], |interface| &interface.inputs);
        let floats = |regs: &[Reg]| regs.iter().map(|reg| reg.class() == Class::Real).collect();
        plugs.iter().map(|plug| (plug.port, floats(&plug.regs))).collect()
    }

    pub(super) fn uses(&self, function: u32) -> ResourceUses {
        let mut uses =
            ResourceUses { buffers: vec![false; self.buffers.len()], ..ResourceUses::default() };
        let mut seen = vec![false; self.functions.len()];
        // Over the call graph; the code of a function reaches to its `End`.
        let mut open = vec![function];
        while let Some(function) = open.pop() {
            if std::mem::replace(&mut seen[function as usize], true) {
                continue;
            }
            let from = self.starts[function as usize] as usize;
            for inst in self.code[from..].iter() {
                match inst.op {
                    Op::Load(access)
                    | Op::StoreMemory(access)
                    | Op::Atomic(access)
                    | Op::ArrayLength(access) => {
                        let buffer = self.accesses[access as usize].buffer;
                        uses.buffers[buffer as usize] = true;
                    }
                    Op::Sample | Op::Texel | Op::ImageSize => uses.images = true,
                    Op::DerivativeFine(_) | Op::DerivativeCoarse(_) => uses.derivatives = true,
                    Op::Call(callee) => open.push(callee),
                    Op::End => break,
                    _ => {}
                }
            }
        }
        uses
    }
}

fn signature(function: &FunctionCode) -> Option<FunctionSignature> {
    let parameters: Option<Vec<Parameter>> = function
        .arguments
        .iter()
        .map(|a| Some(Parameter { name: a.name.clone(), ty: a.ty.clone()?, returned: a.pointer }))
        .collect();
    Some(FunctionSignature {
        name: function.name.clone(),
        parameters: parameters?,
        result: function.result_type.clone(),
    })
}
