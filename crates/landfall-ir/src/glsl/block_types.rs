//! The naga types of blocks in memory, with Landfall's offsets and strides.
//!
//! Built from a `BlockLayout`. A type that naga lacks is represented by another of the same
//! bytes: a bool by a `u32`, a matrix with a stride or order other than naga's by an array of its
//! columns or rows. A block that naga would still reject is an array of words, addressed by byte.
//! Loads and stores, in [`lvalue`](super::lvalue), convert between the two.

use std::num::NonZeroU32;
use std::rc::Rc;

use naga::{ArraySize, Handle, StructMember, TypeInner};

use super::Lowerer;
use super::types::{Kind, Structure, Ty};
use super::value_types::value_type;
use landfall_layout::layout::MemberLayout;
use landfall_layout::shape::{ArrayLen, Type};

#[derive(Debug)]
pub struct BlockType {
    pub ty: Ty,
    pub kind: BlockTypeKind,
    /// The naga type; `None` in a block of words.
    pub naga: Option<Handle<naga::Type>>,
}

#[derive(Debug)]
pub enum BlockTypeKind {
    /// A scalar or vector; bools are stored as `u32`.
    Leaf,
    /// A scalar that atomic functions change.
    Atomic,
    /// A matrix; `plain` if it is stored as naga's own matrix type.
    Matrix {
        stride: u32,
        row_major: bool,
        plain: bool,
    },
    Array {
        element: Rc<BlockType>,
        stride: u32,
        len: Option<u32>,
    },
    Struct(Vec<BlockTypeMember>),
}

#[derive(Debug)]
pub struct BlockTypeMember {
    pub name: String,
    pub index: u32,
    pub offset: u32,
    pub block_type: Rc<BlockType>,
}

/// Returns the member of that name, which is the `likely` one unless the orders differ.
pub fn member_named<'m>(
    members: &'m [BlockTypeMember],
    likely: Option<u32>,
    name: &str,
) -> Option<&'m BlockTypeMember> {
    let likely = likely.and_then(|at| members.get(at as usize)).filter(|m| m.name == name);
    likely.or_else(|| members.iter().find(|member| member.name == name))
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    Uniform,
    Storage,
    Immediate,
}

/// Whether a structure is the block itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum BlockPart {
    Whole,
    Member,
}

/// A type and naga's requirements on its alignment.
struct Built {
    block_type: Rc<BlockType>,
    align: u32,
    /// The alignment that naga requires in the `uniform` address space.
    uniform: u32,
    size: u32,
}

/// The reason why naga rejects a type, so that the block becomes words.
#[derive(Clone, Copy, Debug)]
pub enum NagaConflict {
    /// An offset or stride is not a multiple of naga's alignment.
    Alignment,
    /// A component without a naga type.
    Foreign,
}

impl Lowerer<'_> {
    /// Returns the memory of a block of those members, with naga types, or as words if naga rejects
    /// them.
    pub fn host_of_block(
        &mut self,
        structure: &Rc<Structure>,
        members: &[MemberLayout],
        size: u64,
        purpose: Purpose,
    ) -> Result<BlockType, NagaConflict> {
        let whole = BlockPart::Whole;
        let typed = self.members(structure, members, size, purpose, true, whole);
        // First with naga types, which backends can write as they are. Only an alignment makes
        // words of the block; a component that naga lacks cannot be read from words either.
        match typed {
            Ok(built) => Ok(Rc::try_unwrap(built.block_type).expect("it was just made")),
            Err(NagaConflict::Foreign) => Err(NagaConflict::Foreign),
            Err(NagaConflict::Alignment) => {
                let built = self.members(structure, members, size, purpose, false, whole)?;
                Ok(Rc::try_unwrap(built.block_type).expect("it was just made"))
            }
        }
    }

    fn members(
        &mut self,
        structure: &Rc<Structure>,
        layouts: &[MemberLayout],
        size: u64,
        purpose: Purpose,
        typed: bool,
        part: BlockPart,
    ) -> Result<Built, NagaConflict> {
        let uniform = purpose == Purpose::Uniform;
        let mut members = Vec::with_capacity(layouts.len());
        let mut naga_members = Vec::with_capacity(layouts.len());
        let mut order: Vec<usize> = (0..layouts.len()).collect();
        // naga wants members by offset; GLSL's `offset` qualifiers permit any order (GLSL 4.60
        // §4.4.5).
        order.sort_by_key(|&i| layouts[i].offset);
        let (mut align, mut uniform_align) = (1, 16);
        let mut after_struct = 0;
        for (index, &i) in order.iter().enumerate() {
            let layout = &layouts[i];
            let offset =
                layout.offset.and_then(|o| u32::try_from(o).ok()).ok_or(NagaConflict::Foreign)?;
            let built = self.member(&layout.ty, layout, 0, purpose, typed)?;
            let wants = if uniform { built.uniform } else { built.align };
            // naga's validator refuses a uniform member that begins within the 16-byte tail of a
            // structure before it.
            if typed && (!offset.is_multiple_of(wants) || (uniform && offset < after_struct)) {
                return Err(NagaConflict::Alignment);
            }
            after_struct = match built.block_type.kind {
                BlockTypeKind::Struct(_) => offset + built.size.next_multiple_of(16),
                _ => 0,
            };
            align = align.max(built.align);
            uniform_align = uniform_align.max(built.uniform);
            if let Some(ty) = built.block_type.naga {
                let name = Some(layout.name.to_string());
                naga_members.push(StructMember { name, ty, binding: None, offset });
            }
            let name = layout.name.to_string();
            members.push(BlockTypeMember {
                name,
                index: index as u32,
                offset,
                block_type: built.block_type,
            });
        }
        let mut span = u32::try_from(size).map_err(|_| NagaConflict::Foreign)?;
        // Only the block itself may be padded; a structure inside of it has the size that its
        // layout says.
        if part == BlockPart::Whole {
            // A block with dvec3 is padded to 32 by naga, to 16 by std140: nothing follows it.
            span = span.checked_next_multiple_of(align).ok_or(NagaConflict::Foreign)?;
        }
        let naga = if typed {
            if !span.is_multiple_of(align) {
                return Err(NagaConflict::Alignment);
            }
            let inner = TypeInner::Struct { members: naga_members, span };
            let name = (!structure.name.is_empty()).then(|| structure.name.clone());
            Some(self.ir.types.insert(naga::Type { name, inner }, naga::Span::UNDEFINED))
        } else {
            None
        };
        let kind = BlockTypeKind::Struct(members);
        let block_type = Rc::new(BlockType { ty: Ty::Struct(structure.clone()), kind, naga });
        Ok(Built { block_type, align, uniform: uniform_align, size: span })
    }

    fn member(
        &mut self,
        ty: &Type,
        layout: &MemberLayout,
        dim: usize,
        purpose: Purpose,
        typed: bool,
    ) -> Result<Built, NagaConflict> {
        match ty {
            Type::Scalar(scalar) => {
                let kind = Kind::from_scalar(*scalar).ok_or(NagaConflict::Foreign)?;
                // naga has atomics of 32 bits, in storage memory.
                let atomic = purpose == Purpose::Storage
                    && matches!(kind, Kind::Int | Kind::Uint)
                    && self.atomics.contains(&*layout.name);
                self.leaf(Ty::Scalar(kind), typed, atomic)
            }
            Type::Vector { scalar, rows } => {
                let kind = Kind::from_scalar(*scalar).ok_or(NagaConflict::Foreign)?;
                self.leaf(Ty::Vector(kind, *rows), typed, false)
            }
            Type::Matrix { scalar, columns, rows } => {
                let kind = Kind::from_scalar(*scalar).ok_or(NagaConflict::Foreign)?;
                self.matrix(kind, *columns, *rows, layout, typed)
            }
            Type::Array { element, len } => {
                let built = self.member(element, layout, dim + 1, purpose, typed)?;
                let stride = layout.strides.get(dim).and_then(|s| u32::try_from(*s).ok());
                let stride = stride.ok_or(NagaConflict::Foreign)?;
                let len = match len {
                    ArrayLen::Fixed(len) => Some(*len),
                    ArrayLen::Runtime => None,
                    ArrayLen::Override(_) => return Err(NagaConflict::Foreign),
                };
                self.array(built, stride, len, purpose, typed)
            }
            Type::Struct(s) => {
                let structure = self.structure_of(s).ok_or(NagaConflict::Foreign)?;
                // In an array the stride is the size that the next element leaves room for.
                let size = match (layout.strides.last(), layout.size) {
                    (Some(stride), _) => Some(*stride),
                    (None, size) => size,
                };
                let size = size.ok_or(NagaConflict::Foreign)?;
                self.members(&structure, &layout.members, size, purpose, typed, BlockPart::Member)
            }
            Type::Atomic(_) | Type::Address(_) => Err(NagaConflict::Foreign),
        }
    }

    fn leaf(&mut self, ty: Ty, typed: bool, atomic: bool) -> Result<Built, NagaConflict> {
        let (kind, _) = ty.components().expect("a leaf is a scalar or vector");
        // Words have 32 bits: halves and shorts cannot be addressed in them, nor can atomics.
        if !typed && (atomic || (kind != Kind::Bool && kind.scalar().width < 4)) {
            return Err(NagaConflict::Foreign);
        }
        // A bool in memory is a word that is not 0 (GLSL 4.60 §4.1.2 leaves its bits open; drivers
        // use uint).
        let held = if kind == Kind::Bool { ty.with_kind(Kind::Uint) } else { ty.clone() };
        let carried = value_type(&mut self.ir.types, &mut self.value_types, &held)
            .ok_or(NagaConflict::Foreign)?;
        let mut naga = carried.handle;
        if atomic {
            let inner = TypeInner::Atomic(kind.scalar());
            naga = self.nameless(inner);
        }
        let kind = if atomic { BlockTypeKind::Atomic } else { BlockTypeKind::Leaf };
        Ok(Built {
            block_type: Rc::new(BlockType { ty, kind, naga: typed.then_some(naga) }),
            align: carried.align,
            uniform: carried.align,
            size: carried.size,
        })
    }

    fn matrix(
        &mut self,
        kind: Kind,
        columns: u8,
        rows: u8,
        layout: &MemberLayout,
        typed: bool,
    ) -> Result<Built, NagaConflict> {
        let ty = Ty::Matrix(kind, columns, rows);
        let stride = layout.matrix_stride.and_then(|s| u32::try_from(s).ok());
        let stride = stride.ok_or(NagaConflict::Foreign)?;
        let row_major = layout.row_major;
        // Row-major memory holds one vector per row.
        let (count, length) = if row_major { (rows, columns) } else { (columns, rows) };
        let vector =
            value_type(&mut self.ir.types, &mut self.value_types, &Ty::Vector(kind, length))
                .ok_or(NagaConflict::Foreign)?;
        if !typed && kind == Kind::Half {
            return Err(NagaConflict::Foreign);
        }
        if typed && !stride.is_multiple_of(vector.align) {
            return Err(NagaConflict::Alignment);
        }
        // naga 30.0.1 panics when it writes a load of such a matrix from uniform memory.
        let unwritten = kind == Kind::Double && rows == 2;
        // naga's own matrix type has columns at the alignment of a column vector and no other
        // stride.
        let plain = !row_major && stride == vector.align && !unwritten;
        let naga = if plain {
            value_type(&mut self.ir.types, &mut self.value_types, &ty)
                .ok_or(NagaConflict::Foreign)?
                .handle
        } else {
            let len = NonZeroU32::new(count.into()).expect("a matrix has columns and rows");
            let size = ArraySize::Constant(len);
            let inner = TypeInner::Array { base: vector.handle, size, stride };
            self.nameless(inner)
        };
        // An array in uniform memory needs a stride of 16; `u32::MAX` refuses any other.
        let uniform = if plain { vector.align } else { vector.align.max(16) };
        Ok(Built {
            block_type: Rc::new(BlockType {
                ty,
                kind: BlockTypeKind::Matrix { stride, row_major, plain },
                naga: typed.then_some(naga),
            }),
            align: vector.align,
            uniform: if !plain && !stride.is_multiple_of(16) { u32::MAX } else { uniform },
            size: stride * u32::from(count),
        })
    }

    fn array(
        &mut self,
        element: Built,
        stride: u32,
        len: Option<u32>,
        purpose: Purpose,
        typed: bool,
    ) -> Result<Built, NagaConflict> {
        // Elements of arrays are aligned to 16 in uniform memory (std140, rule 4).
        let uniform = element.uniform.max(element.align).max(16);
        if typed {
            let wants = if purpose == Purpose::Uniform { uniform } else { element.align };
            if !stride.is_multiple_of(wants) {
                return Err(NagaConflict::Alignment);
            }
        }
        let size = match len {
            Some(len) => ArraySize::Constant(NonZeroU32::new(len).ok_or(NagaConflict::Foreign)?),
            None => ArraySize::Dynamic,
        };
        let naga = element
            .block_type
            .naga
            .map(|base| self.nameless(TypeInner::Array { base, size, stride }));
        let size = stride.checked_mul(len.unwrap_or(1)).ok_or(NagaConflict::Foreign)?;
        let ty = Ty::Array(Rc::new(element.block_type.ty.clone()), len);
        let align = element.align;
        let kind = BlockTypeKind::Array { element: element.block_type, stride, len };
        Ok(Built { block_type: Rc::new(BlockType { ty, kind, naga }), align, uniform, size })
    }

    /// Returns the memory of a `shared` variable that atomic functions change, with naga's offsets.
    pub fn host_of_shared(&mut self, ty: &Ty) -> Option<Rc<BlockType>> {
        let carried = value_type(&mut self.ir.types, &mut self.value_types, ty)?;
        let (kind, naga) = match ty {
            Ty::Scalar(kind @ (Kind::Int | Kind::Uint)) => {
                (BlockTypeKind::Atomic, self.nameless(TypeInner::Atomic(kind.scalar())))
            }
            Ty::Array(element, Some(len)) => {
                let element = self.host_of_shared(element)?;
                let TypeInner::Array { size, stride, .. } = self.ir.types[carried.handle].inner
                else {
                    return None;
                };
                let naga = self.nameless(TypeInner::Array { base: element.naga?, size, stride });
                (BlockTypeKind::Array { element, stride, len: Some(*len) }, naga)
            }
            Ty::Struct(s) => {
                let TypeInner::Struct { members, span } =
                    self.ir.types[carried.handle].inner.clone()
                // Members that no atomic function names stay plain values.
                else {
                    return None;
                };
                let mut hosts = Vec::new();
                let mut naga_members = Vec::new();
                for (index, (field, member)) in s.members.iter().zip(members).enumerate() {
                    let atomic = self.atomics.contains(&*field.name);
                    let block_type = if atomic {
                        self.host_of_shared(&field.ty)?
                    } else {
                        let naga = Some(member.ty);
                        Rc::new(BlockType { ty: field.ty.clone(), kind: BlockTypeKind::Leaf, naga })
                    };
                    let offset = member.offset;
                    naga_members.push(StructMember { ty: block_type.naga?, ..member });
                    let name = field.name.clone();
                    hosts.push(BlockTypeMember { name, index: index as u32, offset, block_type });
                }
                let inner = TypeInner::Struct { members: naga_members, span };
                let ty = naga::Type { name: Some(s.name.clone()), inner };
                (BlockTypeKind::Struct(hosts), self.ir.types.insert(ty, naga::Span::UNDEFINED))
            }
            _ => return None,
        };
        Some(Rc::new(BlockType { ty: ty.clone(), kind, naga: Some(naga) }))
    }

    /// Returns the type of a block of words: its only member is an array of words.
    pub fn words(&mut self, size: u32, runtime: bool, purpose: Purpose) -> Handle<naga::Type> {
        let uniform = purpose == Purpose::Uniform;
        // The stride of an array in uniform memory is 16: four words to an element.
        let unit = if uniform { Ty::Vector(Kind::Uint, 4) } else { Ty::UINT };
        let unit = value_type(&mut self.ir.types, &mut self.value_types, &unit)
            .expect("a plain type is carried");
        let count = size.div_ceil(unit.size).max(1);
        let len = NonZeroU32::new(count).expect("at least one");
        let array = TypeInner::Array {
            base: unit.handle,
            size: if runtime { ArraySize::Dynamic } else { ArraySize::Constant(len) },
            stride: unit.size,
        };
        let ty = self.nameless(array);
        let name = Some("words".to_string());
        let member = StructMember { name, ty, binding: None, offset: 0 };
        let span = if runtime { unit.size } else { count * unit.size };
        let inner = TypeInner::Struct { members: vec![member], span };
        self.nameless(inner)
    }

    /// Returns the memory of a column or component, whose naga type is not needed.
    pub fn host_part(ty: Ty) -> Rc<BlockType> {
        Rc::new(BlockType { ty, kind: BlockTypeKind::Leaf, naga: None })
    }
}

/// Returns the vector type that a matrix is stored as, and the number of vectors.
pub fn stored_vector(ty: &Ty, row_major: bool) -> (Ty, u8) {
    match ty {
        Ty::Matrix(kind, columns, rows) if row_major => (Ty::Vector(*kind, *columns), *rows),
        Ty::Matrix(kind, columns, rows) => (Ty::Vector(*kind, *rows), *columns),
        other => (other.clone(), 1),
    }
}

/// Returns the matrix type whose columns are the rows of a matrix.
pub fn transposed(ty: &Ty) -> Ty {
    match ty {
        Ty::Matrix(kind, columns, rows) => Ty::Matrix(*kind, *rows, *columns),
        other => other.clone(),
    }
}
