//! A function's instructions while it is compiled, and what its callers know of it.

use std::rc::Rc;

use super::code::{Inst, Origin, Reg};
use super::value::ValueType;

/// Instructions of one function; jumps count from its first.
#[derive(Default)]
pub(super) struct Body {
    pub code: Vec<Inst>,
    pub origins: Vec<Origin>,
    pub pool: Vec<u32>,
    /// Temporaries of each class.
    pub temporaries: [u32; 3],
    pub origin: Option<Origin>,
    /// Why it has grown past what can be run.
    pub overflow: bool,
}

/// A compiled function as its callers see it.
pub(super) struct Compiled {
    pub arguments: Vec<CompiledArgument>,
    pub result: Rc<[Reg]>,
    pub result_type: Option<ValueType>,
}

pub(super) struct CompiledArgument {
    pub name: String,
    pub regs: Rc<[Reg]>,
    pub pointer: bool,
    pub ty: Option<ValueType>,
}
