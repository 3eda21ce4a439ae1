//! Finds the bytes of its blocks that a shader could read: the targets of every load in the
//! functions its entry points reach. A computed index targets every element.
//!
//! Reads a [`Module`]'s IR; bytes not found are certain to be never read.

use naga::{
    AddressSpace, Expression, Function, GlobalVariable, Handle, Statement, TypeInner, VectorSize,
};
use rustc_hash::FxHashMap;

use landfall_ir::{Module, call_graph};

/// Returns, by block of the module, whether some instruction could read each byte of a buffer of
/// that size.
pub(super) fn loadable(module: &Module, sizes: &[usize]) -> Vec<Vec<bool>> {
    let mut blocks: Vec<Vec<bool>> = sizes.iter().map(|size| vec![false; *size]).collect();
    let numbers: FxHashMap<Handle<GlobalVariable>, usize> =
        module.blocks().iter().enumerate().map(|(at, block)| (block.variable, at)).collect();
    let mut walk = LoadWalk { module, numbers, blocks: &mut blocks };
    let ir = &module.ir;
    if ir.entry_points.is_empty() {
        // An include: any of its functions may be called.
        ir.functions.iter().for_each(|(_, function)| walk.function(function));
    }
    for entry in &ir.entry_points {
        let reached = call_graph::functions(ir, &entry.function);
        reached.into_iter().for_each(|function| walk.function(function));
    }
    blocks
}

struct LoadWalk<'m, 'b> {
    module: &'m Module,
    numbers: FxHashMap<Handle<GlobalVariable>, usize>,
    blocks: &'b mut [Vec<bool>],
}

/// A part of a variable: its offset, its repetitions, and its type.
struct LoadedPart {
    variable: Handle<GlobalVariable>,
    offset: u64,
    /// Count and stride; the count of a runtime-sized array follows from the buffer.
    repeats: Vec<(Option<u64>, u64)>,
    inner: TypeInner,
}

impl LoadWalk<'_, '_> {
    fn function(&mut self, function: &Function) {
        for (_, expression) in function.expressions.iter() {
            if let Expression::Load { pointer } = expression {
                self.mark(function, *pointer);
            }
        }
        for statement in call_graph::statements(&function.body) {
            match statement {
                // Reads by a callee through a pointer are not followed.
                Statement::Call { arguments, .. } => {
                    arguments.iter().for_each(|argument| self.mark(function, *argument));
                }
                Statement::Atomic { pointer, .. }
                | Statement::WorkGroupUniformLoad { pointer, .. } => self.mark(function, *pointer),
                _ => {}
            }
        }
    }

    /// Marks the target of a pointer, if it is in a block.
    fn mark(&mut self, function: &Function, pointer: Handle<Expression>) {
        let Some(part) = self.part(function, pointer) else { return };
        let Some(&number) = self.numbers.get(&part.variable) else { return };
        let ir = &self.module.ir;
        let bytes = &mut self.blocks[number];
        let len = bytes.len() as u64;
        // The buffer determines the length of a runtime-sized tail.
        let runs_on = match &part.inner {
            TypeInner::Array { size, .. } => matches!(size, naga::ArraySize::Dynamic),
            TypeInner::Struct { members, .. } => members.last().is_some_and(|last| {
                matches!(
                    ir.types[last.ty].inner,
                    TypeInner::Array { size: naga::ArraySize::Dynamic, .. }
                )
            }),
            _ => false,
        };
        let size = if runs_on { len } else { u64::from(part.inner.size(ir.to_ctx())) };
        let mut starts = vec![part.offset];
        for (count, stride) in &part.repeats {
            let within = |start: u64| len.saturating_sub(start).div_ceil((*stride).max(1));
            starts = starts
                .into_iter()
                .flat_map(|start| {
                    let count = count.unwrap_or(u64::MAX).min(within(start));
                    (0..count).map(move |index| start + index * stride)
                })
                .collect();
        }
        for start in starts {
            let range = start.min(len) as usize..start.saturating_add(size).min(len) as usize;
            bytes[range].fill(true);
        }
    }

    fn part(&self, function: &Function, pointer: Handle<Expression>) -> Option<LoadedPart> {
        let ir = &self.module.ir;
        // The path to the variable, from its end; followed in reverse below.
        let mut way = Vec::new();
        let mut at = pointer;
        let variable = loop {
            match function.expressions[at] {
                Expression::GlobalVariable(variable) => break variable,
                Expression::AccessIndex { base, index } => {
                    way.push(Some(u64::from(index)));
                    at = base;
                }
                Expression::Access { base, .. } => {
                    way.push(None);
                    at = base;
                }
                _ => return None,
            }
        };
        let global = &ir.global_variables[variable];
        if !matches!(
            global.space,
            AddressSpace::Uniform | AddressSpace::Storage { .. } | AddressSpace::Immediate
        ) {
            return None;
        }
        let inner = ir.types[global.ty].inner.clone();
        let mut part = LoadedPart { variable, offset: 0, repeats: Vec::new(), inner };
        for index in way.into_iter().rev() {
            let (stride, count, inner) = match &part.inner {
                TypeInner::Struct { members, .. } => {
                    let member = members.get(usize::try_from(index?).ok()?)?;
                    part.offset += u64::from(member.offset);
                    part.inner = ir.types[member.ty].inner.clone();
                    continue;
                }
                TypeInner::Array { base, size, stride } => {
                    let count = match size {
                        naga::ArraySize::Constant(count) => Some(u64::from(count.get())),
                        naga::ArraySize::Pending(_) | naga::ArraySize::Dynamic => None,
                    };
                    (u64::from(*stride), count, ir.types[*base].inner.clone())
                }
                TypeInner::Matrix { columns, rows, scalar } => {
                    // A column of three is aligned like one of four: WGSL §14.4.1.
                    let padded = if *rows == VectorSize::Bi { 2 } else { 4 };
                    let stride = padded * u64::from(scalar.width);
                    let column = TypeInner::Vector { size: *rows, scalar: *scalar };
                    (stride, Some(*columns as u64), column)
                }
                TypeInner::Vector { size, scalar } => {
                    let (width, count) = (u64::from(scalar.width), *size as u64);
                    (width, Some(count), TypeInner::Scalar(*scalar))
                }
                _ => return None,
            };
            match index {
                Some(index) => part.offset += index * stride,
                None => part.repeats.push((count, stride)),
            }
            part.inner = inner;
        }
        Some(part)
    }
}
