//! A Rust type with its layout: what [`types`](super::types) and [`known`](super::known) return.

use std::rc::Rc;

use super::library::MirrorWriter;
use landfall_layout::shape::ScalarKind;

#[derive(Clone)]
pub(super) struct RustType {
    pub size: u64,
    pub align: u64,
    pub shape: Shape,
    /// Whether it is an array or a structure in the text, not a vector or matrix.
    pub composite: bool,
}

#[derive(Clone)]
pub(super) enum Shape {
    Scalar {
        kind: ScalarKind,
        name: &'static str,
    },
    /// An array, a vector, or a matrix as an array of its columns.
    Array {
        element: Rc<RustType>,
        len: u64,
    },
    Struct(Rc<StructureLayout>),
}

pub(super) struct StructureLayout {
    pub name: String,
    pub fields: Vec<LaidField>,
    /// The index in `Declarations::structures`.
    pub index: usize,
    /// The least alignment of the whole: `repr(align(16))`, or that of a library's structures.
    pub least_align: u64,
    pub writer: MirrorWriter,
}

pub(super) struct LaidField {
    pub name: String,
    pub offset: u64,
    /// The alignment in this structure: of the type, unless an attribute says otherwise.
    pub align: u64,
    /// The bytes that it takes: of the type, or those of `#[shader(size(N))]`.
    pub size: u64,
    pub ty: RustType,
}

/// The reason why a layout is unknown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct UnknownLayout(pub String);

impl RustType {
    pub(super) fn scalar(kind: ScalarKind, name: &'static str, width: u64) -> RustType {
        RustType {
            size: width,
            align: width,
            shape: Shape::Scalar { kind, name },
            composite: false,
        }
    }

    pub(super) fn array(element: RustType, len: u64) -> Option<RustType> {
        Some(RustType {
            size: element.size.checked_mul(len)?,
            align: element.align,
            shape: Shape::Array { element: Rc::new(element), len },
            composite: false,
        })
    }

    /// A SIMD vector: larger and aligned.
    pub(super) fn aligned(self, align: u64) -> RustType {
        RustType { size: self.size.next_multiple_of(align), align, ..self }
    }
}

pub(super) enum TypeArgument {
    Type(RustType),
    Number(u64),
}
