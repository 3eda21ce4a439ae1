//! A function's instructions during compilation, and its interface for callers.

use std::rc::Rc;

use super::code::{Inst, Origin, Reg};
use super::value::ValueType;

/// The instructions of one function; jump targets are relative to its first.
#[derive(Default)]
pub(super) struct Body {
    pub code: Vec<Inst>,
    pub origins: Vec<Origin>,
    pub pool: Vec<u32>,
    /// The number of temporaries of each class.
    pub temporaries: [u32; 3],
    /// The registers of local variables.
    pub locals: Vec<Reg>,
    pub origin: Option<Origin>,
    /// The reason why the function is too large to run.
    pub overflow: bool,
}

/// The interface of a compiled function for its callers.
pub(super) struct Compiled {
    pub arguments: Vec<Argument>,
    pub result: Rc<[Reg]>,
    pub result_type: Option<ValueType>,
}

/// An argument of a function.
#[derive(Clone, Debug)]
pub(super) struct Argument {
    pub name: String,
    pub regs: Vec<Reg>,
    /// Whether it is a pointer whose contents go back to the caller.
    pub pointer: bool,
    /// The type of the value, or of the pointee; `None` for a type without plain values.
    pub ty: Option<ValueType>,
}
