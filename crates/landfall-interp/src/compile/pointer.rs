//! Pointers: a variable or buffer, and an access path, some of whose indices are computed at run
//! time.

use std::rc::Rc;

use naga::proc::TypeResolution;
use naga::{Expression, Handle, TypeInner};

use super::super::code::{Access, Class, Dynamic, ElementCount, Op, Reg, WriteRegion};
use super::super::flatten::{class, stored};
use super::function::Function;
use super::value::{Pointer, PointerRoot, Value};

impl Function<'_, '_> {
    pub fn pointer(&mut self, handle: Handle<Expression>) -> Result<Rc<Pointer>, String> {
        match self.value(handle)? {
            Value::Pointer(pointer) | Value::View(pointer) => Ok(pointer),
            Value::Regs(_) => Err("a value used as a pointer".into()),
        }
    }

    /// Returns a pointer to a whole variable.
    pub fn whole(&self, root: PointerRoot, ty: TypeResolution) -> Value {
        let pointer = Pointer { root, ty, leaves: 0, bytes: 0, indices: Vec::new() };
        Value::Pointer(Rc::new(pointer))
    }

    /// Appends a constant index to the path.
    pub fn step(&self, from: &Pointer, index: u32) -> Result<Pointer, String> {
        let step = self.b.types.step(from.ty.inner_with(&self.b.ir.types), index)?;
        let bytes = from.bytes.checked_add(step.bytes);
        Ok(Pointer {
            root: from.root.clone(),
            ty: step.ty,
            leaves: from.leaves.saturating_add(step.leaves),
            bytes: bytes.ok_or("a member beyond byte 4294967295")?,
            indices: from.indices.clone(),
        })
    }

    /// Appends a computed index to the path.
    pub fn index(&mut self, from: &Pointer, index: Reg) -> Result<Pointer, String> {
        let inner = from.ty.inner_with(&self.b.ir.types);
        let known = self.b.known(index);
        let bound = self.b.types.bound(inner);
        // The machine clamps an index past the end and notes it, even one that is constant.
        if let Some(known) = known.filter(|&i| bound.is_some_and(|bound| i < u64::from(bound))) {
            return self.step(from, known as u32);
        }
        let element = self.b.types.element(inner)?;
        // A variable is counted in registers of each class, a buffer in bytes.
        let strides = match &from.root {
            PointerRoot::Variable(_) => {
                let counts = self.b.types.counts(element.ty.inner_with(&self.b.ir.types))?;
                counts.map(|n| n as u32)
            }
            PointerRoot::Buffer { .. } => [element.bytes; 3],
        };
        let bound = match bound {
            Some(len) => ElementCount::Known(len),
            None => ElementCount::Runtime { offset: from.bytes, stride: element.bytes },
        };
        let mut indices = from.indices.clone();
        indices.push((index, Dynamic { strides, bound }));
        Ok(Pointer { ty: element.ty, indices, ..from.clone() })
    }

    /// Compiles a load: returns the scalars, or a view of a read-only buffer.
    pub fn load(&mut self, pointer: &Rc<Pointer>) -> Result<Value, String> {
        let inner = pointer.ty.inner_with(&self.b.ir.types);
        // `lights[i].color` reads three floats, not the array: what holds it is loaded when it is
        // used whole.
        let composite = matches!(inner, TypeInner::Struct { .. } | TypeInner::Array { .. });
        if composite && matches!(pointer.root, PointerRoot::Buffer { read_only: true, .. }) {
            return Ok(Value::View(pointer.clone()));
        }
        Ok(Value::Regs(self.load_all(pointer)?))
    }

    pub fn load_all(&mut self, pointer: &Pointer) -> Result<Rc<[Reg]>, String> {
        let inner = pointer.ty.inner_with(&self.b.ir.types);
        let leaves = self.b.types.leaves(inner)?;
        let head: Vec<Reg> = pointer.indices.iter().map(|i| i.0).collect();
        let mut to = Vec::with_capacity(leaves.len());
        for leaf in &leaves {
            let class = class(leaf.scalar)?;
            to.push(self.b.temporary(class));
        }
        match &pointer.root {
            PointerRoot::Buffer { number, .. } => {
                let mut operands = Vec::with_capacity(3 * to.len());
                for (to, leaf) in to.iter().zip(&leaves) {
                    let at = pointer.bytes.checked_add(leaf.offset);
                    let at = at.ok_or("a member beyond byte 4294967295")?;
                    operands.extend([to.0, at, stored(leaf.scalar) as u32]);
                }
                let access = self.access(*number, pointer);
                self.b.push(Op::Load(access), &head, &operands);
            }
            PointerRoot::Variable(regs) => {
                let at = pointer.leaves as usize;
                let from = &regs[at..at + to.len()];
                if head.is_empty() {
                    self.copy(Op::Move, &to, from);
                } else {
                    let access = self.access(0, pointer);
                    // A scalar is found from its register in element 0: those of a class are in a
                    // row, its stride apart.
                    self.groups(|class| Op::Gather(class, access), &head, &to, from);
                }
            }
        }
        Ok(to.into())
    }

    pub fn store(&mut self, pointer: &Pointer, from: &[Reg]) -> Result<(), String> {
        let head: Vec<Reg> = pointer.indices.iter().map(|i| i.0).collect();
        match &pointer.root {
            PointerRoot::Buffer { number, .. } => {
                let leaves = self.b.types.leaves(pointer.ty.inner_with(&self.b.ir.types))?;
                let mut operands = Vec::with_capacity(3 * from.len());
                for (from, leaf) in from.iter().zip(&leaves) {
                    let at = pointer.bytes.checked_add(leaf.offset);
                    let at = at.ok_or("a member beyond byte 4294967295")?;
                    operands.extend([from.0, at, stored(leaf.scalar) as u32]);
                }
                let access = self.access(*number, pointer);
                self.b.push(Op::StoreMemory(access), &head, &operands);
            }
            PointerRoot::Variable(regs) => {
                let at = pointer.leaves as usize;
                let to: Vec<Reg> = regs[at..at + from.len()].to_vec();
                // Without a computed index, the registers are known.
                if head.is_empty() {
                    self.copy(Op::Store, &to, from);
                } else {
                    let access = self.access(0, pointer);
                    self.groups(|class| Op::Scatter(class, access), &head, from, &to);
                }
            }
        }
        Ok(())
    }

    pub fn access(&mut self, buffer: u32, pointer: &Pointer) -> u32 {
        let dynamics = pointer.indices.iter().map(|i| i.1).collect();
        self.b.access(Access { buffer, dynamics, change: None })
    }

    /// Compiles an element of a value at a computed index.
    pub fn element(
        &mut self,
        base: Handle<Expression>,
        regs: Rc<[Reg]>,
        index: Reg,
    ) -> Result<Value, String> {
        // The registers of a value are anywhere; an index needs them in a row. Those of constants
        // are laid out once for the program.
        let constant = regs.iter().all(|reg| reg.region() == WriteRegion::Constant);
        let beside: Rc<[Reg]> = if constant {
            self.b.table(&regs).into()
        } else {
            let classes: Vec<Class> = regs.iter().map(|reg| reg.class()).collect();
            let copy = self.b.variables_of(&classes)?;
            self.copy(Op::Move, &copy, &regs);
            copy
        };
        let ty = self.resolution(base).clone();
        let whole = Pointer {
            root: PointerRoot::Variable(beside),
            ty,
            leaves: 0,
            bytes: 0,
            indices: Vec::new(),
        };
        let element = self.index(&whole, index)?;
        Ok(Value::Regs(self.load_all(&element)?))
    }
}
