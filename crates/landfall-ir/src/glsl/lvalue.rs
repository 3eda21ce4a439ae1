//! Places: variables and memory that can be read and written, and access to their parts.
//!
//! A place in a block has a [`block_types`](super::block_types) memory type; loads and stores
//! convert it to and from values.

use std::rc::Rc;

use naga::{BinaryOperator, Expression, Handle};

use super::block_types::{BlockType, BlockTypeKind, member_named};
use super::body::{Body, TypedValue};
use super::types::{Kind, Structure, Ty, vector_size};
use super::{Lowerer, Lowering};

/// Why a member that holds values has an index among those that do.
const CARRIED: &str = "a field that holds values is carried";

#[derive(Clone, Debug)]
pub enum LvalueMemory {
    /// A pointer to a value type.
    Own(Handle<Expression>),
    /// Memory with an explicit layout.
    BlockType(Address, Rc<BlockType>),
    /// A column of a matrix stored by rows.
    Column(Address, Rc<BlockType>, Index),
    /// No storage: a structure of handles.
    Nothing,
}

#[derive(Clone, Debug)]
pub enum Address {
    Pointer(Handle<Expression>),
    /// A byte offset in a block of words: `fixed` plus `dynamic`.
    Words {
        block: Handle<Expression>,
        /// Whether the words are stored as vectors of four.
        fours: bool,
        fixed: u32,
        dynamic: Option<Handle<Expression>>,
    },
}

#[derive(Clone, Copy, Debug)]
pub enum Index {
    Fixed(u32),
    Dynamic(Handle<Expression>),
}

/// A place that can be read, and written if `writable`.
#[derive(Clone, Debug)]
pub struct Lvalue {
    pub mem: LvalueMemory,
    /// The type of its value, after the swizzle.
    pub ty: Ty,
    pub swizzle: Option<(u8, Vec<u8>)>,
    /// The path, if it contains handles.
    pub path: Option<HandlePath>,
    pub writable: bool,
}

/// The path of a handle: `materials[2].diffuse`.
#[derive(Clone, Debug)]
pub struct HandlePath {
    /// The path; `[?]` stands for the element that `dynamic` selects.
    pub text: String,
    /// The variable index, and the number of elements.
    pub dynamic: Option<(Handle<Expression>, u32)>,
}

impl Lvalue {
    pub fn new(mem: LvalueMemory, ty: Ty) -> Lvalue {
        Lvalue { mem, ty, swizzle: None, path: None, writable: true }
    }

    fn part(&self, mem: LvalueMemory, ty: Ty) -> Lvalue {
        Lvalue { mem, ty, swizzle: None, path: None, writable: self.writable }
    }
}

/// Returns the components of a swizzle: `xyzw`, `rgba` or `stpq`, below `size`.
pub fn selection(name: &str, size: usize) -> Option<Vec<u8>> {
    // swizzle = up to four letters of one of the sets xyzw, rgba, stpq (GLSL 4.60 §5.5).
    let first = name.chars().next()?;
    let set = ["xyzw", "rgba", "stpq"].into_iter().find(|set| set.contains(first))?;
    if name.len() > 4 {
        return None;
    }
    name.chars().map(|c| set.find(c).filter(|&i| i < size).map(|i| i as u8)).collect()
}

impl Address {
    /// Returns the address so many bytes further on; a pointer stays the same.
    pub fn offset_by(&self, bytes: u32) -> Address {
        // Pointers are moved by member and element indices instead.
        match self {
            Address::Words { block, fours, fixed, dynamic } => Address::Words {
                block: *block,
                fours: *fours,
                fixed: fixed.saturating_add(bytes),
                dynamic: *dynamic,
            },
            Address::Pointer(pointer) => Address::Pointer(*pointer),
        }
    }
}

impl Body<'_, '_> {
    pub fn at(&mut self, base: Handle<Expression>, index: Index) -> Handle<Expression> {
        match index {
            Index::Fixed(index) => self.add(Expression::AccessIndex { base, index }),
            Index::Dynamic(index) => self.add(Expression::Access { base, index }),
        }
    }

    /// Returns the address of an element at a stride; a pointer is indexed instead.
    pub fn step(&mut self, at: &Address, index: Index, stride: u32) -> Address {
        // In words the byte offset is `fixed` plus what variable indices add; constant parts are
        // summed here.
        match (at, index) {
            (Address::Pointer(pointer), index) => Address::Pointer(self.at(*pointer, index)),
            (Address::Words { .. }, Index::Fixed(i)) => at.offset_by(i.saturating_mul(stride)),
            (Address::Words { block, fours, fixed, dynamic }, Index::Dynamic(index)) => {
                let index = self.unsigned_index(index);
                let stride = self.u32(stride);
                let mut bytes = self.binary(BinaryOperator::Multiply, index, stride);
                if let Some(dynamic) = dynamic {
                    bytes = self.binary(BinaryOperator::Add, *dynamic, bytes);
                }
                let dynamic = Some(bytes);
                Address::Words { block: *block, fours: *fours, fixed: *fixed, dynamic }
            }
        }
    }

    /// Returns an `i32` or `u32` index as `u32`, with the same bits.
    pub fn unsigned_index(&mut self, index: Handle<Expression>) -> Handle<Expression> {
        let kind = naga::ScalarKind::Uint;
        self.add(Expression::As { expr: index, kind, convert: Some(4) })
    }

    pub fn member_of(
        &mut self,
        place: &Lvalue,
        structure: &Structure,
        name: &str,
    ) -> Lowering<Lvalue> {
        let Some(field) = structure.member(name) else {
            return self.refuse(format!("`{}` has no member `{name}`", Ty::name_of(structure)));
        };
        let ty = field.ty.clone();
        let path = place
            .path
            .as_ref()
            .map(|way| HandlePath { text: format!("{}.{name}", way.text), dynamic: way.dynamic });
        // A member of handles alone has no storage.
        let mem = if !super::types::holds_values(&ty) {
            LvalueMemory::Nothing
        } else {
            match &place.mem {
                LvalueMemory::Own(pointer) => {
                    let index = structure.carried_index(name).expect(CARRIED);
                    LvalueMemory::Own(self.part(*pointer, index))
                }
                LvalueMemory::BlockType(at, block_type) => {
                    let BlockTypeKind::Struct(members) = &block_type.kind else {
                        // A structure that naga lays out itself, behind a shared variable.
                        let Address::Pointer(pointer) = at else {
                            return self.refuse("expected a structure in the block");
                        };
                        let index = structure.carried_index(name).expect(CARRIED);
                        let mem = LvalueMemory::Own(self.part(*pointer, index));
                        return Ok(Lvalue { path, ..place.part(mem, ty) });
                    };
                    let likely = structure.carried_index(name);
                    let Some(member) = member_named(members, likely, name) else {
                        return self.refuse(format!("`{name}` has no offset in its block"));
                    };
                    let at = match at {
                        Address::Pointer(pointer) => {
                            Address::Pointer(self.part(*pointer, member.index))
                        }
                        words @ Address::Words { .. } => words.offset_by(member.offset),
                    };
                    LvalueMemory::BlockType(at, member.block_type.clone())
                }
                LvalueMemory::Column(..) | LvalueMemory::Nothing => LvalueMemory::Nothing,
            }
        };
        Ok(Lvalue { path, ..place.part(mem, ty) })
    }

    /// Returns an element of an array, a column of a matrix or a component of a vector.
    pub fn element_of(&mut self, place: &Lvalue, index: Index) -> Lowering<Lvalue> {
        let Some((ty, len)) = place.ty.indexed() else {
            return self.refuse(format!("a `{}` cannot be indexed", place.ty));
        };
        if let (Index::Fixed(i), Some(len)) = (index, len) {
            if i >= len {
                return self.refuse(format!("index {i} is past the end of `{}`", place.ty));
            }
        }
        // An element of a swizzle is that component of the vector below it.
        if let Some((size, picks)) = &place.swizzle {
            let Index::Fixed(i) = index else {
                return self.refuse("variable indices into swizzles are not supported");
            };
            let whole = Ty::Vector(place.ty.kind().unwrap_or(Kind::Float), *size);
            let base = Lvalue { swizzle: None, ty: whole, ..place.clone() };
            return self.element_of(&base, Index::Fixed(picks[i as usize].into()));
        }
        let path = match (&place.path, index) {
            (None, _) => None,
            (Some(HandlePath { text, dynamic }), Index::Fixed(i)) => {
                Some(HandlePath { text: format!("{text}[{i}]"), dynamic: *dynamic })
            }
            (Some(HandlePath { text, dynamic: None }), Index::Dynamic(index)) => Some(HandlePath {
                text: format!("{text}[?]"),
                dynamic: Some((index, len.unwrap_or(u32::MAX))),
            }),
            // With two variable indices in the path, the handle cannot be found by it.
            (Some(HandlePath { dynamic: Some(_), .. }), Index::Dynamic(_)) => None,
        };
        let mem = match &place.mem {
            LvalueMemory::Own(pointer) => LvalueMemory::Own(self.at(*pointer, index)),
            LvalueMemory::BlockType(at, block_type) => match &block_type.kind {
                BlockTypeKind::Array { element, stride, .. } => {
                    LvalueMemory::BlockType(self.step(at, index, *stride), element.clone())
                }
                // A column of a row-major matrix is spread over its rows: it is read and written
                // component by component.
                BlockTypeKind::Matrix { row_major: true, .. } => {
                    LvalueMemory::Column(at.clone(), block_type.clone(), index)
                }
                BlockTypeKind::Matrix { stride, .. } => {
                    let at = self.step(at, index, *stride);
                    LvalueMemory::BlockType(at, Lowerer::host_part(ty.clone()))
                }
                BlockTypeKind::Leaf | BlockTypeKind::Atomic | BlockTypeKind::Struct(_) => {
                    if let (Address::Pointer(pointer), false) =
                        (at, place.ty.components().is_some())
                    {
                        LvalueMemory::Own(self.at(*pointer, index))
                    } else {
                        // Components in words are at least 4 bytes wide: shorter ones are not in
                        // words.
                        let width =
                            place.ty.kind().map_or(4, |k| u32::from(k.scalar().width.max(4)));
                        let at = self.step(at, index, width);
                        LvalueMemory::BlockType(at, Lowerer::host_part(ty.clone()))
                    }
                }
            },
            LvalueMemory::Column(at, block_type, column) => {
                let BlockTypeKind::Matrix { stride, .. } = block_type.kind else {
                    return self.refuse("only a matrix has columns");
                };
                let row = self.step(at, index, stride);
                let width = ty.kind().map_or(4, |k| k.scalar().width.into());
                let at = self.step(&row, *column, width);
                LvalueMemory::BlockType(at, Lowerer::host_part(ty.clone()))
            }
            LvalueMemory::Nothing => LvalueMemory::Nothing,
        };
        Ok(Lvalue { path, ..place.part(mem, ty) })
    }

    /// Applies a swizzle to a place: `.xyz` of a vector, or `.x` of a scalar.
    pub fn swizzle_of(&mut self, place: &Lvalue, name: &str) -> Lowering<Lvalue> {
        let Some((kind, size)) = place.ty.components() else {
            return self.refuse(format!("a `{}` has no member `{name}`", place.ty));
        };
        let Some(picks) = selection(name, size.into()) else {
            return self.refuse(format!("a `{}` has no components `{name}`", place.ty));
        };
        if size == 1 && picks == [0] {
            return Ok(place.clone());
        }
        // One component is an element, which can be stored to by itself.
        if let ([pick], false) = (&picks[..], size == 1) {
            return self.element_of(place, Index::Fixed((*pick).into()));
        }
        let ty = Ty::new(kind, picks.len() as u8);
        let (whole, picks) = match &place.swizzle {
            Some((whole, before)) => (*whole, picks.iter().map(|&i| before[i as usize]).collect()),
            None => (size, picks),
        };
        // A swizzle with a component twice is not writable (GLSL 4.60 §5.5).
        let distinct = (1..picks.len()).all(|i| !picks[..i].contains(&picks[i]));
        let writable = place.writable && distinct && size > 1;
        Ok(Lvalue { ty, swizzle: Some((whole, picks)), writable, ..place.clone() })
    }

    /// Applies a swizzle to a value; a scalar is repeated.
    pub fn select(&mut self, vector: &TypedValue, picks: &[u8]) -> Lowering<TypedValue> {
        use naga::SwizzleComponent as C;
        let (kind, size) = vector.ty.components().unwrap_or((Kind::Float, 1));
        let ty = Ty::new(kind, picks.len() as u8);
        if size == 1 {
            return self.splat(vector, picks.len() as u8);
        }
        if let [pick] = picks {
            return Ok(TypedValue { expr: self.part(vector.expr, (*pick).into()), ty });
        }
        let mut pattern = [C::X; 4];
        for (to, from) in pattern.iter_mut().zip(picks) {
            *to = [C::X, C::Y, C::Z, C::W][usize::from(*from)];
        }
        let size = vector_size(picks.len() as u8);
        let expr = self.add(Expression::Swizzle { size, vector: vector.expr, pattern });
        Ok(TypedValue { expr, ty })
    }

    pub fn splat(&mut self, scalar: &TypedValue, size: u8) -> Lowering<TypedValue> {
        let kind = scalar.ty.kind().unwrap_or(Kind::Float);
        if size == 1 {
            return Ok(scalar.clone());
        }
        let expr = self.add(Expression::Splat { size: vector_size(size), value: scalar.expr });
        Ok(TypedValue { expr, ty: Ty::Vector(kind, size) })
    }

    pub fn transpose(&mut self, matrix: Handle<Expression>) -> Handle<Expression> {
        let fun = naga::MathFunction::Transpose;
        self.add(Expression::Math { fun, arg: matrix, arg1: None, arg2: None, arg3: None })
    }

    /// Returns the number of elements of a runtime-sized array, as `int`.
    pub fn runtime_length(&mut self, place: &Lvalue) -> Lowering<TypedValue> {
        let LvalueMemory::BlockType(at, block_type) = &place.mem else {
            return self.refuse("`.length()` of an array whose length is unknown here");
        };
        let BlockTypeKind::Array { stride, .. } = block_type.kind else {
            return self.refuse("`.length()` of an array whose length is unknown here");
        };
        let length = match at {
            Address::Pointer(pointer) => self.add(Expression::ArrayLength(*pointer)),
            Address::Words { block, fixed, .. } => {
                let array = self.part(*block, 0);
                let words = self.add(Expression::ArrayLength(array));
                // The length in bytes is that of all words; what precedes the array is subtracted.
                let (four, start, stride) = (self.u32(4), self.u32(*fixed), self.u32(stride));
                let bytes = self.binary(BinaryOperator::Multiply, words, four);
                let bytes = self.binary(BinaryOperator::Subtract, bytes, start);
                self.binary(BinaryOperator::Divide, bytes, stride)
            }
        };
        let kind = naga::ScalarKind::Sint;
        let expr = self.add(Expression::As { expr: length, kind, convert: Some(4) });
        Ok(TypedValue { expr, ty: Ty::INT })
    }
}

impl Ty {
    /// Returns the name of a structure in messages.
    pub fn name_of(structure: &Structure) -> &str {
        if structure.name.is_empty() { "struct" } else { &structure.name }
    }
}
