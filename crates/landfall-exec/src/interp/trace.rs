//! Every operation of one invocation, as a graph: what was computed of what, in `f32` and in
//! `f64`.
//!
//! Made by the machine for [`Program::call`] where [`Settings::trace`](super::Settings) asks;
//! what `stress` finds the guilty operation by.

use super::code::Origin;
use super::program::Program;
use super::undefined::Place;

/// The operations of one invocation, in the order they ran.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    /// Each operation; copies, branches and stores are none.
    pub steps: Vec<Step>,
    /// Where each scalar of the result came from.
    pub results: Vec<Source>,
    /// Where what is left in each parameter came from.
    pub returned: Vec<Vec<Source>>,
    /// Whether there were more steps than are kept.
    pub cut: bool,
}

/// One operation.
#[derive(Clone, Debug)]
pub struct Step {
    /// What it does.
    pub operation: Operation,
    /// What it did it with: of a dot product, all of one vector, then all of the other.
    pub operands: Vec<Operand>,
    /// What it gave.
    pub results: Vec<Number>,
    pub(super) origin: Origin,
}

/// An operand.
#[derive(Clone, Copy, Debug)]
pub struct Operand {
    /// What it was.
    pub number: Number,
    /// Where it came from.
    pub source: Source,
}

/// A number in both precisions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Number {
    /// As the shader has it.
    pub single: f32,
    /// As it should be.
    pub double: f64,
}

/// Where a number came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub enum Source {
    Constant,
    /// A scalar of a parameter.
    Input {
        parameter: u32,
        scalar: u32,
    },
    /// Loaded from a buffer.
    Buffer,
    /// Result `part` of a step.
    Step {
        step: u32,
        part: u32,
    },
    /// Not followed.
    Unknown,
}

/// What an operation does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub enum Operation {
    Add,
    Sub,
    Mul,
    Div,
    Rem,
    Neg,
    Abs,
    Min,
    Max,
    Edge,
    Clamp,
    Mix,
    SmoothStep,
    Fma,
    Root,
    InverseRoot,
    Pow,
    Exp,
    Log,
    Trigonometric,
    Dot,
    Length,
    Distance,
    Normalize,
    Cross,
    Compare,
    Convert,
    Integer,
    Texture,
    Other,
}

impl Program {
    /// Where an operation of one of its traces stands.
    pub fn place_of(&self, step: &Step) -> Place {
        self.place(step.origin)
    }
}
