//! Lowers loads from places and stores to them.
//!
//! The [`block_types`](super::block_types) memory of a block may have other types than its values,
//! or be words: loads and stores convert between them.

use std::rc::Rc;

use naga::{BinaryOperator, Expression, Handle, Statement};

use super::Lowering;
use super::block_types::{BlockType, BlockTypeKind, member_named, stored_vector, transposed};
use super::body::{Body, TypedValue};
use super::lvalue::{Address, Index, Lvalue, LvalueMemory};
use super::types::{Kind, Ty, carried};

/// The longest array that is copied without a loop.
/// A loop needs a local variable, but unrolled code grows with the length.
const LONGEST_UNROLLED: u32 = 8;

/// The most values copied one by one.
/// A bound for hostile texts; what a loop copies counts once.
const MAX_COPIED: u64 = 4096;

impl Body<'_, '_> {
    pub fn load(&mut self, place: &Lvalue) -> Lowering<TypedValue> {
        // The whole vector, then its components.
        if let Some((size, picks)) = &place.swizzle {
            let kind = place.ty.kind().unwrap_or(Kind::Float);
            let whole = Lvalue { ty: Ty::new(kind, *size), swizzle: None, ..place.clone() };
            let vector = self.load(&whole)?;
            return self.select(&vector, picks);
        }
        match &place.mem {
            LvalueMemory::Own(pointer) => {
                if place.ty.has_opaque() && !super::types::holds_values(&place.ty) {
                    return self.refuse(format!("a `{}` cannot be used as a value", place.ty));
                }
                let expr = self.add(Expression::Load { pointer: *pointer });
                Ok(TypedValue { expr, ty: place.ty.clone() })
            }
            LvalueMemory::BlockType(at, block_type) => {
                self.check_copied(&place.ty)?;
                self.load_host(at, block_type)
            }
            LvalueMemory::Column(at, block_type, column) => {
                // A column of row-major memory: one component from each row.
                let (_, rows) = stored_vector(&block_type.ty, true);
                let mut components = Vec::new();
                for row in 0..u32::from(rows) {
                    let column = Lvalue::new(
                        LvalueMemory::Column(at.clone(), block_type.clone(), *column),
                        place.ty.clone(),
                    );
                    let part = self.element_of(&column, Index::Fixed(row))?;
                    components.push(self.load(&part)?.expr);
                }
                self.compose(&place.ty, components)
            }
            LvalueMemory::Nothing => {
                self.refuse(format!("a `{}` cannot be used as a value", place.ty))
            }
        }
    }

    fn check_copied(&self, ty: &Ty) -> Lowering<()> {
        if copied(ty) > MAX_COPIED {
            return self.refuse(format!("values of `{ty}` are too large to copy"));
        }
        Ok(())
    }

    pub fn load_host(&mut self, at: &Address, block_type: &Rc<BlockType>) -> Lowering<TypedValue> {
        // Where naga's value type is the memory's type, one load does.
        if let (Address::Pointer(pointer), Some(naga)) = (at, block_type.naga) {
            let runtime = matches!(block_type.ty, Ty::Array(_, None));
            if !runtime
                && !block_type.ty.has_opaque()
                && self.cx.value_type(&block_type.ty, self.span)? == naga
            {
                let expr = self.add(Expression::Load { pointer: *pointer });
                return Ok(TypedValue { expr, ty: block_type.ty.clone() });
            }
        }
        match &block_type.kind {
            BlockTypeKind::Leaf | BlockTypeKind::Atomic => self.load_leaf(at, &block_type.ty),
            BlockTypeKind::Matrix { stride, row_major, plain } => {
                if let (Address::Pointer(pointer), true) = (at, plain) {
                    let expr = self.add(Expression::Load { pointer: *pointer });
                    return Ok(TypedValue { expr, ty: block_type.ty.clone() });
                }
                let (vector, count) = stored_vector(&block_type.ty, *row_major);
                let mut vectors = Vec::new();
                for i in 0..u32::from(count) {
                    let at = self.step(at, Index::Fixed(i), *stride);
                    vectors.push(self.load_leaf(&at, &vector)?.expr);
                }
                if !row_major {
                    // Stored by rows, it is loaded as the transposed matrix.
                    return self.compose(&block_type.ty, vectors);
                }
                let rows = self.compose(&transposed(&block_type.ty), vectors)?;
                Ok(TypedValue { expr: self.transpose(rows.expr), ty: block_type.ty.clone() })
            }
            BlockTypeKind::Array { element, stride, len } => {
                let Some(len) = *len else {
                    return self.refuse("a runtime-sized array cannot be used as a value");
                };
                // Element by element, through a local variable.
                if len > LONGEST_UNROLLED {
                    let local = self.local("", &block_type.ty)?;
                    let pointer = self.local_pointer(local);
                    let count = self.u32(len);
                    self.repeat(count, |this, index| {
                        let at = this.step(at, Index::Dynamic(index), *stride);
                        let value = this.load_host(&at, element)?.expr;
                        let pointer = this.at(pointer, Index::Dynamic(index));
                        this.statement(Statement::Store { pointer, value });
                        Ok(())
                    })?;
                    let expr = self.add(Expression::Load { pointer });
                    return Ok(TypedValue { expr, ty: block_type.ty.clone() });
                }
                let mut components = Vec::new();
                for i in 0..len {
                    let at = self.step(at, Index::Fixed(i), *stride);
                    components.push(self.load_host(&at, element)?.expr);
                }
                self.compose(&block_type.ty, components)
            }
            BlockTypeKind::Struct(members) => {
                let Ty::Struct(structure) = &block_type.ty else {
                    return self.refuse("expected a structure in the block");
                };
                let mut components = Vec::new();
                // Members that hold values; their order in memory may differ from that of the
                // structure.
                for (i, field) in (0u32..).zip(carried(structure)) {
                    let Some(member) = member_named(members, Some(i), &field.name) else {
                        return self.refuse(format!("`{}` has no offset in its block", field.name));
                    };
                    let at = match at {
                        Address::Pointer(p) => Address::Pointer(self.part(*p, member.index)),
                        words @ Address::Words { .. } => words.offset_by(member.offset),
                    };
                    components.push(self.load_host(&at, &member.block_type)?.expr);
                }
                self.compose(&block_type.ty, components)
            }
        }
    }

    fn load_leaf(&mut self, at: &Address, ty: &Ty) -> Lowering<TypedValue> {
        let Some((kind, size)) = ty.components() else {
            let Address::Pointer(pointer) = at else {
                return self.refuse(format!("`{ty}` is not a 32-bit type"));
            };
            let expr = self.add(Expression::Load { pointer: *pointer });
            return Ok(TypedValue { expr, ty: ty.clone() });
        };
        let expr = match at {
            Address::Pointer(pointer) => self.add(Expression::Load { pointer: *pointer }),
            // Eight bytes are two words, the low one first (little endian).
            Address::Words { .. } if kind.scalar().width == 8 => {
                let mut parts = Vec::new();
                for i in 0..u32::from(size) {
                    parts.push(self.load_wide(&at.offset_by(8 * i), kind));
                }
                match &parts[..] {
                    [part] => *part,
                    _ => self.compose(ty, parts)?.expr,
                }
            }
            // Words are loaded one by one and reinterpreted.
            Address::Words { .. } => {
                let mut words = Vec::new();
                for i in 0..u32::from(size) {
                    let pointer = self.word(&at.offset_by(4 * i));
                    words.push(self.add(Expression::Load { pointer }));
                }
                let words = match &words[..] {
                    [word] => *word,
                    _ => self.compose(&ty.with_kind(Kind::Uint), words)?.expr,
                };
                match kind {
                    Kind::Bool | Kind::Uint => words,
                    _ => {
                        let kind = kind.scalar().kind;
                        self.add(Expression::As { expr: words, kind, convert: None })
                    }
                }
            }
        };
        if kind != Kind::Bool {
            return Ok(TypedValue { expr, ty: ty.clone() });
        }
        // Any bits but 0 are true.
        let zero = self.number(Kind::Uint, 0.0);
        let zero = self.splat(&zero, size)?;
        let expr = self.binary(BinaryOperator::NotEqual, expr, zero.expr);
        Ok(TypedValue { expr, ty: ty.clone() })
    }

    /// Loads a scalar of 8 bytes from two words.
    fn load_wide(&mut self, at: &Address, kind: Kind) -> Handle<Expression> {
        let uint = naga::ScalarKind::Uint;
        let mut halves = Vec::new();
        for i in 0..2 {
            let pointer = self.word(&at.offset_by(4 * i));
            let expr = self.add(Expression::Load { pointer });
            halves.push(self.add(Expression::As { expr, kind: uint, convert: Some(8) }));
        }
        let by = self.u32(32);
        let high = self.binary(BinaryOperator::ShiftLeft, halves[1], by);
        let expr = self.binary(BinaryOperator::InclusiveOr, halves[0], high);
        match kind {
            Kind::Ulong => expr,
            _ => self.add(Expression::As { expr, kind: kind.scalar().kind, convert: None }),
        }
    }

    fn store_wide(&mut self, at: &Address, kind: Kind, value: Handle<Expression>) {
        let uint = naga::ScalarKind::Uint;
        let bits = match kind {
            Kind::Ulong => value,
            _ => self.add(Expression::As { expr: value, kind: uint, convert: None }),
        };
        let by = self.u32(32);
        let high = self.binary(BinaryOperator::ShiftRight, bits, by);
        for (i, half) in [(0, bits), (1, high)] {
            let value = self.add(Expression::As { expr: half, kind: uint, convert: Some(4) });
            let pointer = self.word(&at.offset_by(4 * i));
            self.statement(Statement::Store { pointer, value });
        }
    }

    /// Returns a pointer to the word at an address.
    pub fn word(&mut self, at: &Address) -> Handle<Expression> {
        let Address::Words { block, fours, fixed, dynamic } = at else {
            unreachable!("only blocks of words have words");
        };
        let array = self.part(*block, 0);
        // A constant address: word `fixed / 4`, in vectors of four the component `fixed / 4 % 4`.
        let Some(dynamic) = dynamic else {
            if *fours {
                let four = self.part(array, fixed / 16);
                return self.part(four, fixed / 4 % 4);
            }
            return self.part(array, fixed / 4);
        };
        // At run time the same by shifts and masks.
        let fixed = self.u32(*fixed);
        let bytes = self.binary(BinaryOperator::Add, *dynamic, fixed);
        let two = self.u32(2);
        let word = self.binary(BinaryOperator::ShiftRight, bytes, two);
        if !*fours {
            return self.add(Expression::Access { base: array, index: word });
        }
        let (four, three) = (self.u32(2), self.u32(3));
        let four = self.binary(BinaryOperator::ShiftRight, word, four);
        let base = self.add(Expression::Access { base: array, index: four });
        let index = self.binary(BinaryOperator::And, word, three);
        self.add(Expression::Access { base, index })
    }

    pub fn store(&mut self, place: &Lvalue, value: &TypedValue) -> Lowering<()> {
        if !place.writable {
            return self.refuse("the left side of the assignment is not writable");
        }
        if let Some((size, picks)) = &place.swizzle {
            let kind = place.ty.kind().unwrap_or(Kind::Float);
            let whole = Lvalue { ty: Ty::new(kind, *size), swizzle: None, ..place.clone() };
            // Component by component, so that the others keep their values, even if another
            // invocation writes to them.
            for (i, &pick) in picks.iter().enumerate() {
                let part = self.element_of(&whole, Index::Fixed(pick.into()))?;
                let component = self.select(value, &[i as u8])?;
                self.store(&part, &component)?;
            }
            return Ok(());
        }
        match &place.mem {
            LvalueMemory::Own(pointer) => {
                self.statement(Statement::Store { pointer: *pointer, value: value.expr });
                Ok(())
            }
            LvalueMemory::BlockType(at, block_type) => {
                self.check_copied(&place.ty)?;
                self.store_host(at, block_type, value.expr)
            }
            LvalueMemory::Column(at, block_type, column) => {
                let (_, rows) = stored_vector(&block_type.ty, true);
                for row in 0..rows {
                    let mem = LvalueMemory::Column(at.clone(), block_type.clone(), *column);
                    let column = Lvalue::new(mem, place.ty.clone());
                    let part = self.element_of(&column, Index::Fixed(row.into()))?;
                    let component = self.select(value, &[row])?;
                    self.store(&part, &component)?;
                }
                Ok(())
            }
            LvalueMemory::Nothing => self.refuse(format!("a `{}` is not writable", place.ty)),
        }
    }

    pub fn store_host(
        &mut self,
        at: &Address,
        block_type: &Rc<BlockType>,
        value: Handle<Expression>,
    ) -> Lowering<()> {
        if let (Address::Pointer(pointer), Some(naga)) = (at, block_type.naga) {
            let runtime = matches!(block_type.ty, Ty::Array(_, None));
            if !runtime && self.cx.value_type(&block_type.ty, self.span)? == naga {
                self.statement(Statement::Store { pointer: *pointer, value });
                return Ok(());
            }
        }
        match &block_type.kind {
            BlockTypeKind::Leaf | BlockTypeKind::Atomic => {
                self.store_leaf(at, &block_type.ty, value)
            }
            BlockTypeKind::Matrix { stride, row_major, plain } => {
                if let (Address::Pointer(pointer), true) = (at, plain) {
                    self.statement(Statement::Store { pointer: *pointer, value });
                    return Ok(());
                }
                let vectors = if *row_major { self.transpose(value) } else { value };
                let (vector, count) = stored_vector(&block_type.ty, *row_major);
                for i in 0..u32::from(count) {
                    let at = self.step(at, Index::Fixed(i), *stride);
                    let part = self.part(vectors, i);
                    self.store_leaf(&at, &vector, part)?;
                }
                Ok(())
            }
            BlockTypeKind::Array { element, stride, len } => {
                let Some(len) = *len else {
                    return self.refuse("a runtime-sized array cannot be assigned as a whole");
                };
                if len > LONGEST_UNROLLED {
                    // naga does not index a value with a variable, so it is stored to a local
                    // first.
                    let from =
                        self.spill(&TypedValue { expr: value, ty: block_type.ty.clone() })?;
                    let count = self.u32(len);
                    return self.repeat(count, |this, index| {
                        let from = this.element_of(&from, Index::Dynamic(index))?;
                        let value = this.load(&from)?;
                        let at = this.step(at, Index::Dynamic(index), *stride);
                        this.store_host(&at, element, value.expr)
                    });
                }
                for i in 0..len {
                    let at = self.step(at, Index::Fixed(i), *stride);
                    let part = self.part(value, i);
                    self.store_host(&at, element, part)?;
                }
                Ok(())
            }
            BlockTypeKind::Struct(members) => {
                let Ty::Struct(structure) = &block_type.ty else {
                    return self.refuse("expected a structure in the block");
                };
                for (i, field) in (0u32..).zip(carried(structure)) {
                    let Some(member) = member_named(members, Some(i), &field.name) else {
                        return self.refuse(format!("`{}` has no offset in its block", field.name));
                    };
                    let at = match at {
                        Address::Pointer(p) => Address::Pointer(self.part(*p, member.index)),
                        words @ Address::Words { .. } => words.offset_by(member.offset),
                    };
                    let part = self.part(value, i);
                    self.store_host(&at, &member.block_type, part)?;
                }
                Ok(())
            }
        }
    }

    fn store_leaf(&mut self, at: &Address, ty: &Ty, value: Handle<Expression>) -> Lowering<()> {
        let Some((kind, size)) = ty.components() else {
            let Address::Pointer(pointer) = at else {
                return self.refuse(format!("`{ty}` is not a 32-bit type"));
            };
            self.statement(Statement::Store { pointer: *pointer, value });
            return Ok(());
        };
        let mut value = value;
        // True is stored as 1.
        if kind == Kind::Bool {
            let (one, zero) = (self.number(Kind::Uint, 1.0), self.number(Kind::Uint, 0.0));
            let (one, zero) = (self.splat(&one, size)?, self.splat(&zero, size)?);
            value = self.selected(value, one.expr, zero.expr);
        }
        match at {
            Address::Pointer(pointer) => {
                self.statement(Statement::Store { pointer: *pointer, value });
            }
            Address::Words { .. } if kind.scalar().width == 8 => {
                for i in 0..size {
                    let part = if size == 1 { value } else { self.part(value, i.into()) };
                    self.store_wide(&at.offset_by(8 * u32::from(i)), kind, part);
                }
            }
            Address::Words { .. } => {
                if !matches!(kind, Kind::Bool | Kind::Uint) {
                    let kind = naga::ScalarKind::Uint;
                    value = self.add(Expression::As { expr: value, kind, convert: None });
                }
                for i in 0..size {
                    let word = if size == 1 { value } else { self.part(value, i.into()) };
                    let pointer = self.word(&at.offset_by(4 * u32::from(i)));
                    self.statement(Statement::Store { pointer, value: word });
                }
            }
        }
        Ok(())
    }
}

/// Returns the number of values copied one by one for a type; a loop's are counted once.
fn copied(ty: &Ty) -> u64 {
    match ty {
        Ty::Array(element, len) => {
            let unrolled = len.filter(|&len| len <= LONGEST_UNROLLED).unwrap_or(1);
            copied(element).saturating_mul(unrolled.into())
        }
        Ty::Struct(s) => s.members.iter().fold(0u64, |sum, m| sum.saturating_add(copied(&m.ty))),
        Ty::Void | Ty::Scalar(_) | Ty::Vector(..) | Ty::Matrix(..) | Ty::Opaque(_) => 1,
    }
}
