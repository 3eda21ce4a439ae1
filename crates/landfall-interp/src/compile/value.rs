//! The compiled form of expressions: registers, or pointers.

use std::rc::Rc;

use naga::proc::TypeResolution;

use super::super::code::{Dynamic, Reg};

/// The compiled form of an expression.
#[derive(Clone)]
pub(super) enum Value {
    /// The registers of its scalars.
    Regs(Rc<[Reg]>),
    Pointer(Rc<Pointer>),
    /// A place in a read-only buffer, loaded where it is used.
    View(Rc<Pointer>),
}

/// The memory a pointer points into.
#[derive(Clone)]
pub(super) enum PointerRoot {
    /// Registers of all scalars of a variable.
    Variable(Rc<[Reg]>),
    Buffer {
        number: u32,
        read_only: bool,
    },
}

/// An access path into a variable or buffer.
#[derive(Clone)]
pub(super) struct Pointer {
    pub root: PointerRoot,
    /// The pointee's type.
    pub ty: TypeResolution,
    /// Number of scalars before it in a variable.
    pub leaves: u32,
    /// Number of bytes before it in a buffer.
    pub bytes: u32,
    /// Computed indices of the path.
    pub indices: Vec<(Reg, Dynamic)>,
}
