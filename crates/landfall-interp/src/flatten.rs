//! Flattens a type into its scalars, in order: matrices by column, members and elements one after
//! the other.
//!
//! Reads naga's types with Landfall's offsets and strides; used by [`compile`](super::compile).

use std::cell::RefCell;
use std::rc::Rc;

use naga::proc::TypeResolution;
use naga::{ArraySize, Handle, ScalarKind, StructMember, Type, TypeInner, UniqueArena};
use rustc_hash::FxHashMap;

use super::code::{Class, Stored};

/// Maximum number of scalars of a value: each register of a variable takes 256 bytes.
pub(super) const MAX_LEAVES: u64 = 1 << 18;

/// A scalar of a type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Leaf {
    pub scalar: naga::Scalar,
    /// The offset in memory in bytes.
    pub offset: u32,
}

/// Returns the register class of a scalar, or the name of the unsupported type.
pub(super) fn class(scalar: naga::Scalar) -> Result<Class, String> {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 2 | 4) => Ok(Class::Real),
        (ScalarKind::Sint | ScalarKind::Uint, 2 | 4) | (ScalarKind::Bool, _) => Ok(Class::Word),
        (ScalarKind::Float | ScalarKind::Sint | ScalarKind::Uint, 8) => Ok(Class::Wide),
        (kind, width) => Err(format!("scalars of kind {kind:?} and {width} bytes")),
    }
}

/// Returns the format of a scalar in memory.
pub(super) fn stored(scalar: naga::Scalar) -> Stored {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 2) => Stored::F16,
        (ScalarKind::Float, 4) => Stored::F32,
        (ScalarKind::Sint, 2) => Stored::I16,
        (ScalarKind::Uint, 2) => Stored::U16,
        (ScalarKind::Bool, 1) => Stored::Bool,
        (_, 8) => Stored::B64,
        _ => Stored::B32,
    }
}

/// Returns the stride of a matrix's columns in bytes.
pub(super) fn column_stride(rows: naga::VectorSize, scalar: naga::Scalar) -> u32 {
    // A column of three is aligned like one of four: WGSL §14.4.1.
    let rows = if rows == naga::VectorSize::Bi { 2 } else { 4 };
    rows * u32::from(scalar.width)
}

/// The number of scalars of each class, or the name of an unsupported type.
type Counted = Result<[u64; 3], String>;

/// The types of a module, flattened.
pub(super) struct Types<'a> {
    pub arena: &'a UniqueArena<Type>,
    /// Returns the lengths given by override expressions.
    pub pending: &'a dyn Fn(Handle<naga::Override>) -> Option<u32>,
    /// Memoised counts: a structure may contain another several times, at any depth.
    pub counted: RefCell<FxHashMap<Handle<Type>, Counted>>,
    /// Memoised numbers of scalars before each member, by the address of a structure's first
    /// member: code that reads every member looks each of them up.
    pub before: RefCell<FxHashMap<*const StructMember, Rc<[u32]>>>,
}

impl<'a> Types<'a> {
    /// Returns the number of scalars of each class in a type.
    pub fn counts(&self, inner: &TypeInner) -> Result<[u64; 3], String> {
        let one = |scalar: naga::Scalar, n: u64| {
            let mut counts = [0; 3];
            counts[class(scalar)? as usize] = n;
            Ok(counts)
        };
        match inner {
            TypeInner::Scalar(s) | TypeInner::Atomic(s) => one(*s, 1),
            TypeInner::Vector { size, scalar } => one(*scalar, *size as u64),
            TypeInner::Matrix { columns, rows, scalar } => {
                one(*scalar, *columns as u64 * *rows as u64)
            }
            TypeInner::Array { base, size, .. } => {
                let len = u64::from(self.len(*size).ok_or("a runtime-sized array as a value")?);
                let counts = self.counts_of(*base)?;
                // Counts saturate: `leaf_count` refuses what is too large.
                Ok(counts.map(|n| n.saturating_mul(len)))
            }
            TypeInner::Struct { members, .. } => {
                let mut sum = [0u64; 3];
                for member in members {
                    let counts = self.counts_of(member.ty)?;
                    for (sum, n) in sum.iter_mut().zip(counts) {
                        *sum = sum.saturating_add(n);
                    }
                }
                Ok(sum)
            }
            // The number of a binding, in a word.
            TypeInner::Image { .. } | TypeInner::Sampler { .. } => Ok([0, 1, 0]),
            other => Err(format!("values of type {}", kind_name(other))),
        }
    }

    fn counts_of(&self, ty: Handle<Type>) -> Result<[u64; 3], String> {
        if let Some(known) = self.counted.borrow().get(&ty) {
            return known.clone();
        }
        let counts = self.counts(&self.arena[ty].inner);
        self.counted.borrow_mut().insert(ty, counts.clone());
        counts
    }

    /// Returns the number of scalars of a type.
    pub fn leaf_count(&self, inner: &TypeInner) -> Result<u32, String> {
        let sum = self.counts(inner)?.iter().fold(0u64, |a, b| a.saturating_add(*b));
        if sum > MAX_LEAVES {
            return Err(format!("a value of {sum} scalars; at most {MAX_LEAVES}"));
        }
        Ok(sum as u32)
    }

    /// Returns the number of scalars of a type, for the distance between elements; meaningful for
    /// variables only, whose types were counted.
    fn total(&self, inner: &TypeInner) -> u32 {
        let sum = |counts: [u64; 3]| counts.iter().fold(0u64, |a, b| a.saturating_add(*b));
        self.counts(inner).map_or(0, |counts| u32::try_from(sum(counts)).unwrap_or(u32::MAX))
    }

    /// Returns the scalars of a type with their offsets.
    pub fn leaves(&self, inner: &TypeInner) -> Result<Vec<Leaf>, String> {
        let mut leaves = Vec::with_capacity(self.leaf_count(inner)? as usize);
        self.push_leaves(inner, 0, &mut leaves)?;
        Ok(leaves)
    }

    fn push_leaves(&self, inner: &TypeInner, at: u32, to: &mut Vec<Leaf>) -> Result<(), String> {
        let past = || "a member beyond byte 4294967295".to_string();
        match inner {
            TypeInner::Scalar(scalar) | TypeInner::Atomic(scalar) => {
                to.push(Leaf { scalar: *scalar, offset: at });
            }
            TypeInner::Vector { size, scalar } => {
                for i in 0..*size as u32 {
                    to.push(Leaf { scalar: *scalar, offset: at + i * u32::from(scalar.width) });
                }
            }
            TypeInner::Matrix { columns, rows, scalar } => {
                for column in 0..*columns as u32 {
                    let at = at + column * column_stride(*rows, *scalar);
                    for row in 0..*rows as u32 {
                        let offset = at + row * u32::from(scalar.width);
                        to.push(Leaf { scalar: *scalar, offset });
                    }
                }
            }
            TypeInner::Array { base, size, stride } => {
                let len = self.len(*size).ok_or("a runtime-sized array as a value")?;
                for i in 0..len {
                    let at = i.checked_mul(*stride).and_then(|o| at.checked_add(o));
                    self.push_leaves(&self.arena[*base].inner, at.ok_or_else(past)?, to)?;
                }
            }
            TypeInner::Struct { members, .. } => {
                for member in members {
                    let at = at.checked_add(member.offset).ok_or_else(past)?;
                    self.push_leaves(&self.arena[member.ty].inner, at, to)?;
                }
            }
            TypeInner::Image { .. } | TypeInner::Sampler { .. } => {
                to.push(Leaf { scalar: naga::Scalar::U32, offset: at });
            }
            other => return Err(format!("values of type {}", kind_name(other))),
        }
        Ok(())
    }

    /// Returns the number of elements of an array; `None` if it is runtime-sized.
    pub fn len(&self, size: ArraySize) -> Option<u32> {
        match size {
            ArraySize::Constant(len) => Some(len.get()),
            ArraySize::Pending(given) => (self.pending)(given),
            ArraySize::Dynamic => None,
        }
    }

    /// Returns the target of an index: its type, and the scalars and bytes before it.
    pub fn step(&self, inner: &TypeInner, index: u32) -> Result<IndexTarget, String> {
        match inner {
            TypeInner::Struct { members, .. } => {
                let member = &members[index as usize];
                let leaves = self.before(members)[index as usize];
                Ok(IndexTarget {
                    ty: TypeResolution::Handle(member.ty),
                    leaves,
                    bytes: member.offset,
                })
            }
            _ => {
                let element = self.element(inner)?;
                let leaves = element.leaves.saturating_mul(index);
                match element.bytes.checked_mul(index) {
                    Some(bytes) => Ok(IndexTarget { ty: element.ty, leaves, bytes }),
                    None => Err("a member beyond byte 4294967295".into()),
                }
            }
        }
    }

    /// Returns the number of scalars before each member of a structure.
    fn before(&self, members: &[StructMember]) -> Rc<[u32]> {
        if let Some(known) = self.before.borrow().get(&members.as_ptr()) {
            return known.clone();
        }
        let before = members.iter().scan(0u32, |sum, member| {
            let here = *sum;
            *sum = sum.saturating_add(self.total(&self.arena[member.ty].inner));
            Some(here)
        });
        let before: Rc<[u32]> = before.collect();
        self.before.borrow_mut().insert(members.as_ptr(), before.clone());
        before
    }

    /// Returns the type and strides of the elements of an array, matrix or vector.
    pub fn element(&self, inner: &TypeInner) -> Result<IndexTarget, String> {
        match inner {
            TypeInner::Array { base, stride, .. } => Ok(IndexTarget {
                ty: TypeResolution::Handle(*base),
                leaves: self.total(&self.arena[*base].inner),
                bytes: *stride,
            }),
            TypeInner::Matrix { rows, scalar, .. } => Ok(IndexTarget {
                ty: TypeResolution::Value(TypeInner::Vector { size: *rows, scalar: *scalar }),
                leaves: *rows as u32,
                bytes: column_stride(*rows, *scalar),
            }),
            TypeInner::Vector { scalar, .. } => Ok(IndexTarget {
                ty: TypeResolution::Value(TypeInner::Scalar(*scalar)),
                leaves: 1,
                bytes: u32::from(scalar.width),
            }),
            other => Err(format!("an index into {}", kind_name(other))),
        }
    }

    /// Returns the number of elements that an index is limited to; `None` if the buffer determines
    /// it.
    pub fn bound(&self, inner: &TypeInner) -> Option<u32> {
        match inner {
            TypeInner::Array { size, .. } => self.len(*size),
            TypeInner::Matrix { columns, .. } => Some(*columns as u32),
            TypeInner::Vector { size, .. } => Some(*size as u32),
            _ => Some(1),
        }
    }
}

/// The target of an index.
pub(super) struct IndexTarget {
    pub ty: TypeResolution,
    pub leaves: u32,
    pub bytes: u32,
}

/// Returns the name of a type in error messages.
pub(super) fn kind_name(inner: &TypeInner) -> &'static str {
    match inner {
        TypeInner::Scalar(_) => "a scalar",
        TypeInner::Vector { .. } => "a vector",
        TypeInner::Matrix { .. } => "a matrix",
        TypeInner::CooperativeMatrix { .. } => "a cooperative matrix",
        TypeInner::Atomic(_) => "an atomic",
        TypeInner::Pointer { .. } | TypeInner::ValuePointer { .. } => "a pointer",
        TypeInner::Array { .. } => "an array",
        TypeInner::Struct { .. } => "a structure",
        TypeInner::Image { .. } => "an image",
        TypeInner::Sampler { .. } => "a sampler",
        TypeInner::AccelerationStructure { .. } => "an acceleration structure",
        TypeInner::RayQuery { .. } => "a ray query",
        TypeInner::BindingArray { .. } => "an array of bindings",
    }
}
