//! Every operation of one invocation, as a graph of values in `f32` and in `f64`.
//!
//! Made by the machine for [`Program::call`] if [`Settings::trace`](super::Settings) is set;
//! `stress` finds the cause of an error with it.

use super::code::Origin;
use super::program::Program;
use super::undefined::{SourceLocation, UndefinedKind};

/// The operations of one invocation, in execution order.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    /// The operations, without copies, branches and stores.
    pub steps: Vec<TracedOperation>,
    /// The source of each scalar of the result.
    pub results: Vec<Source>,
    /// The source of each scalar left in each parameter.
    pub returned: Vec<Vec<Source>>,
    /// Whether steps were dropped beyond the maximum.
    pub cut: bool,
}

/// One operation.
#[derive(Clone, Debug)]
pub struct TracedOperation {
    /// The kind of operation.
    pub operation: Operation,
    /// The operands; for a dot product all of one vector, then all of the other.
    pub operands: Vec<Operand>,
    /// The results.
    pub results: Vec<Number>,
    /// Why it has no defined value at these operands.
    pub undefined: Option<UndefinedKind>,
    pub(super) origin: Origin,
}

/// An operand.
#[derive(Clone, Copy, Debug)]
pub struct Operand {
    /// The value.
    pub number: Number,
    /// The source.
    pub source: Source,
}

/// A number in both precisions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Number {
    /// The shader's `f32`.
    pub single: f32,
    /// The reference.
    pub double: f64,
}

/// The source of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub enum Source {
    Constant,
    /// A scalar of a parameter.
    Input {
        parameter: u32,
        scalar: u32,
    },
    /// A load from a buffer.
    Buffer,
    /// Result `part` of a step.
    Step {
        step: u32,
        part: u32,
    },
    /// A source that is not followed.
    Unknown,
}

/// A comparison of two floats, or a test of one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub enum Comparison {
    Equal,
    NotEqual,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    IsNan,
    IsInf,
}

/// The kind of an operation.
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
    Compare(Comparison),
    Convert,
    Integer,
    /// An index into an array: the index and the array's length.
    Index,
    Texture,
    /// A function by its name.
    Function(&'static str),
    Other,
}

impl Program {
    /// Returns the place of an operation in one of the program's traces.
    pub fn place_of(&self, step: &TracedOperation) -> SourceLocation {
        self.place(step.origin)
    }
}
