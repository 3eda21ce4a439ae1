//! A compiled shader: instructions, constants, and what it reads and writes.
//!
//! Made by [`compile`](super::compile), run by [`machine`](super::machine).

use super::code::{Access, Class, Inst, Op, Origin, Reg, Values};
use super::counts::Price;
use super::interface::{Interface, Port};
use super::value::ValueType;
use landfall_layout::source::{Files, Language};

/// A shader compiled for the evaluator: every function and every entry point of a module.
#[derive(Clone, Debug)]
pub struct Program {
    pub(super) code: Vec<Inst>,
    pub(super) origins: Vec<Origin>,
    pub(super) costs: Vec<Price>,
    /// By function: its first instruction.
    pub(super) starts: Vec<u32>,
    /// Operands of the instructions.
    pub(super) pool: Vec<u32>,
    pub(super) accesses: Vec<Access>,
    pub(super) values: Vec<Values>,
    /// What the constant registers of each class hold; they come first in each file.
    pub(super) constants: [Vec<u64>; 3],
    /// Registers of each class.
    pub(super) registers: [u32; 3],
    pub(super) buffers: Vec<BufferInfo>,
    pub(super) images: Vec<ImageInfo>,
    pub(super) functions: Vec<FunctionCode>,
    /// Fills private variables.
    pub(super) start: Result<FunctionCode, String>,
    pub(super) files: Files,
    pub(super) bases: Vec<u32>,
    /// What it is written in.
    pub(super) language: Language,
}

/// What a shader's `f32` are rounded to. The `f64` beside them, or alone, are not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Floats {
    /// What they are.
    #[default]
    AsWritten,
    /// `f16`, each operation and everything that is read: arguments, inputs, buffers, textures.
    Half,
    /// `f16` where a shader of OpenGL ES says `mediump` or `lowp`: GLSL ES 3.20 §4.7, which lets
    /// `lowp` be fixed point of 10 bits in ±2, too; that is not modelled. Others
    /// are as written.
    Mediump,
}

/// A buffer the shader has.
#[derive(Clone, Debug)]
pub(super) struct BufferInfo {
    pub name: String,
    pub bound: (u32, u32),
    pub space: BufferSpace,
    /// Bytes it has without a runtime-sized array.
    pub size: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BufferSpace {
    Uniform,
    PushConstant,
    Storage { writable: bool },
    Workgroup,
}

/// An image the shader samples.
#[derive(Clone, Debug)]
pub(super) struct ImageInfo {
    pub name: String,
    pub bound: (u32, u32),
}

/// A function: where it starts and where its arguments go.
#[derive(Clone, Debug)]
pub(super) struct FunctionCode {
    pub name: String,
    /// Its first instruction, or what in it is not supported.
    pub state: Result<u32, String>,
    pub arguments: Vec<Argument>,
    pub result: Vec<Reg>,
    pub result_type: Option<ValueType>,
    /// If it is an entry point.
    pub interface: Option<Interface>,
}

/// An argument of a function.
#[derive(Clone, Debug)]
pub(super) struct Argument {
    pub name: String,
    pub regs: Vec<Reg>,
    /// Whether it is a pointer: what is left in it goes back to the caller.
    pub pointer: bool,
    /// Of the value, or behind the pointer; none where a type has no plain value.
    pub ty: Option<ValueType>,
}

/// A function as its caller sees it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FunctionSignature {
    /// Its name in the module.
    pub name: String,
    /// Its parameters.
    pub parameters: Vec<Parameter>,
    /// What it returns.
    pub result: Option<ValueType>,
}

/// A parameter of a function.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its type; of a pointer, what it points at.
    pub ty: ValueType,
    /// `out`, `inout`, `ptr<function, …>`: what is left in it comes back.
    pub returned: bool,
}

/// What a function reads and writes besides its arguments.
#[derive(Clone, Debug, Default)]
pub(super) struct Uses {
    pub buffers: Vec<bool>,
    pub images: bool,
    pub derivatives: bool,
}

impl Program {
    /// The functions that can be called by themselves; not those that take textures.
    pub fn functions(&self) -> Vec<FunctionSignature> {
        let plain = self.functions.iter().filter(|f| f.state.is_ok() && f.interface.is_none());
        plain.filter_map(signature).collect()
    }

    /// What a function of the module takes and gives, by its number there; none where a
    /// parameter has no plain value.
    ///
    /// # Errors
    /// What it uses that is not supported.
    pub(crate) fn signature(&self, function: usize) -> Result<Option<FunctionSignature>, String> {
        let function = &self.functions[function];
        function.state.clone()?;
        Ok(signature(function))
    }

    /// Names of its entry points.
    pub fn entry_points(&self) -> impl Iterator<Item = &str> {
        self.functions.iter().filter(|f| f.interface.is_some()).map(|f| f.name.as_str())
    }

    /// The inputs of an entry point, each scalar a float or not.
    pub(crate) fn inputs(&self, entry: &str) -> Vec<(Port, Vec<bool>)> {
        let found = self.functions.iter().find(|f| f.name == entry && f.interface.is_some());
        let interface = found.and_then(|function| function.interface.as_ref());
        let plugs = interface.map_or(&[][..], |interface| &interface.inputs);
        let floats = |regs: &[Reg]| regs.iter().map(|reg| reg.class() == Class::Real).collect();
        plugs.iter().map(|plug| (plug.port, floats(&plug.regs))).collect()
    }

    pub(super) fn uses(&self, function: u32) -> Uses {
        let mut uses = Uses { buffers: vec![false; self.buffers.len()], ..Uses::default() };
        let mut seen = vec![false; self.functions.len()];
        let mut open = vec![function];
        while let Some(function) = open.pop() {
            if std::mem::replace(&mut seen[function as usize], true) {
                continue;
            }
            let from = self.starts[function as usize] as usize;
            for inst in self.code[from..].iter() {
                match inst.op {
                    Op::Load(access)
                    | Op::Save(access)
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
