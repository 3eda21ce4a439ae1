//! The Rust types of mirrors.
//!
//! [`super::plan`] makes them, the printers read them. A generated type is a [`GeneratedType`], referred
//! to by its [`GeneratedTypeId`].

use std::sync::Arc;

use crate::runtime_tail::TailSize;
use crate::scalar_names::ScalarNames;
use landfall_layout::named;
use landfall_layout::shape::{Scalar, ScalarKind};

/// The Rust type of a field.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum RustType {
    /// A type of Rust or glam: `f32`, `glam::Vec3`.
    Named(&'static str),
    /// `[T; N]`.
    Array(Box<RustType>, u64),
    GeneratedType(GeneratedTypeId),
    /// A type of the program.
    User(UserType),
}

/// A type of the program, and what the shader asks of it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct UserType {
    /// Its path in Rust.
    pub(super) path: Arc<str>,
    /// Its size in bytes.
    pub(super) size: u64,
    /// The most that its alignment may be.
    pub(super) align: u64,
}

/// Index of a [`GeneratedType`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct GeneratedTypeId(pub(super) usize);

/// A module of the output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Module {
    /// Types and functions that depend on no shader's structure: `Bool`, `Mat3Stride16`, `Leaf`.
    Support,
    /// The items that several shaders have in common.
    Common,
    /// The items of this shader alone, or all items of a file without modules.
    Shader(usize),
}

#[derive(Clone, Debug)]
pub(super) struct Sized {
    pub(super) ty: RustType,
    pub(super) size: u64,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum GeneratedType {
    /// A scalar without a Rust type.
    Bits(Bits),
    /// A scalar, vector or matrix that no glam type or plain array fits.
    Leaf(LeafType),
    /// An element with padding up to the next one.
    Padded(Padded),
    /// An array without padding after its last element.
    Tight(Tight),
    /// A structure or block.
    Mirror(Mirror),
}

named! {
    /// A scalar without a Rust type, or without one that is valid for any bits.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub(super) enum Bits {
        /// 4 bytes, 0 or 1.
        Bool = "Bool",
        F16 = "F16",
        Bf16 = "Bf16",
        F8E5m2 = "F8E5m2",
        F8E4m3 = "F8E4m3",
    }
}

/// A scalar, vector or matrix stored as an array of components.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct LeafType {
    pub(super) scalar: Scalar,
    pub(super) shape: Shape,
    /// Whether components are stored as bytes, for an alignment of 1.
    pub(super) unaligned: bool,
}

/// The number of a leaf's components and their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Shape {
    Scalar,
    Vector { rows: u8 },
    Matrix { columns: u8, rows: u8, stride: u64, row_major: bool },
}

/// An element and the padding after it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Padded {
    pub(super) inner: RustType,
    /// Bytes of the element without padding.
    pub(super) size: u64,
    /// Bytes with the padding.
    pub(super) stride: u64,
}

/// `len` elements, without padding after the last.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Tight {
    pub(super) element: RustType,
    /// The element with its padding, if any.
    pub(super) head: RustType,
    pub(super) len: u64,
    /// Bytes of the whole.
    pub(super) size: u64,
}

/// A structure or block, or the part of a block before its runtime-sized tail.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Mirror {
    /// Its preferred name.
    pub(super) name: String,
    /// In ascending order of offset.
    pub(super) fields: Vec<Field>,
    /// Bytes, tail padding included.
    pub(super) size: u64,
    /// The runtime-sized array after it.
    pub(super) tail: Option<RuntimeTail>,
}

/// A runtime-sized array at the end of a block; starts at the end of the mirror of the rest.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct RuntimeTail {
    /// The array's name in the shader.
    pub(super) member: String,
    /// The preferred name of the element type.
    pub(super) name: String,
    /// One element, padding included.
    pub(super) element: RustType,
    pub(super) stride: u64,
    /// The sizes that a buffer may have.
    pub(super) sizes: TailSize,
}

/// A field of a mirror.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Field {
    pub(super) name: String,
    pub(super) ty: RustType,
    pub(super) offset: u64,
    /// Bytes of `ty`.
    pub(super) size: u64,
    /// Its index among the members in source order.
    pub(super) order: usize,
}

/// Bytes between fields or after the last one.
pub(super) struct Gap {
    pub(super) offset: u64,
    pub(super) size: u64,
}

impl GeneratedType {
    /// Whether it is the part of a block before a runtime-sized tail.
    pub(super) fn has_tail(&self) -> bool {
        match self {
            GeneratedType::Mirror(mirror) => mirror.tail.is_some(),
            GeneratedType::Bits(_)
            | GeneratedType::Leaf(_)
            | GeneratedType::Padded(_)
            | GeneratedType::Tight(_) => false,
        }
    }
}

impl Mirror {
    /// The padding before each field, and after the last one.
    pub(super) fn gaps(&self) -> Vec<Option<Gap>> {
        // Fields are in ascending order: each gap ends where the next field starts, the last one
        // where the mirror does.
        let mut end = 0;
        let starts = self.fields.iter().map(|f| (f.offset, f.offset + f.size));
        starts
            .chain([(self.size, self.size)])
            .map(|(start, next)| {
                let gap = (start > end).then(|| Gap { offset: end, size: start - end });
                end = next;
                gap
            })
            .collect()
    }

    /// Its fields in source order.
    pub(super) fn in_text_order(&self) -> Vec<&Field> {
        let mut fields: Vec<&Field> = self.fields.iter().collect();
        fields.sort_by_key(|field| field.order);
        fields
    }
}

impl LeafType {
    /// Bytes, including the padding after each column (row).
    pub(super) fn size(self) -> u64 {
        let (vectors, components) = self.shape.stored();
        match self.shape {
            Shape::Matrix { stride, .. } => stride * u64::from(vectors),
            Shape::Scalar | Shape::Vector { .. } => {
                u64::from(self.scalar.width) * u64::from(components)
            }
        }
    }
}

impl Shape {
    /// The number of stored vectors (columns of a column-major matrix, rows of a row-major one) and
    /// of components in each.
    pub(super) fn stored(self) -> (u8, u8) {
        match self {
            Shape::Scalar => (1, 1),
            Shape::Vector { rows } => (1, rows),
            Shape::Matrix { columns, rows, row_major: false, .. } => (columns, rows),
            Shape::Matrix { columns, rows, row_major: true, .. } => (rows, columns),
        }
    }
}

/// The Rust representation of a component.
pub(super) enum Component {
    Plain(&'static str),
    Bits(Bits),
}

/// The Rust type of a component.
pub(super) fn component(scalar: Scalar) -> Component {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Bool, _) => Component::Bits(Bits::Bool),
        (ScalarKind::Float, 2) => Component::Bits(Bits::F16),
        (ScalarKind::Bfloat, _) => Component::Bits(Bits::Bf16),
        (ScalarKind::FloatE5m2, _) => Component::Bits(Bits::F8E5m2),
        (ScalarKind::FloatE4m3, _) => Component::Bits(Bits::F8E4m3),
        (ScalarKind::Sint | ScalarKind::Uint | ScalarKind::Float, _) => {
            Component::Plain(ScalarNames::NUMBERED.of(scalar))
        }
    }
}
