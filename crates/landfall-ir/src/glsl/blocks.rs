//! Lowers uniform, buffer and push-constant blocks, the block of loose uniforms, and the interface
//! blocks between stages.
//!
//! The other half of [`globals`](super::globals).

use std::rc::Rc;

use naga::StorageAccess;

use super::ast::*;
use super::block_types::{NagaConflict, Purpose};
use super::globals::{Global, Memory};
use super::io::StageVariable;
use super::types::{Field, Kind, Structure, Ty};
use super::{Help, Lowerer, Lowering, refuse};
use crate::module::ModuleBlock;
use landfall_layout::shape::{AddressSpace, DEFAULT_BLOCK, Type};

/// The most elements of an array of blocks; each is a separate buffer.
/// OpenGL implementations have fewer binding points; without a bound a text could declare
/// millions.
const MAX_BLOCKS: u32 = 256;

impl<'a> Lowerer<'a> {
    /// Returns the GLSL type of a member with a layout.
    pub fn glsl_type(&self, ty: &Type) -> Option<Ty> {
        Some(match ty {
            Type::Scalar(scalar) => Ty::Scalar(Kind::from_scalar(*scalar)?),
            Type::Vector { scalar, rows } => Ty::Vector(Kind::from_scalar(*scalar)?, *rows),
            Type::Matrix { scalar, columns, rows } => {
                Ty::Matrix(Kind::from_scalar(*scalar)?, *columns, *rows)
            }
            Type::Struct(s) => Ty::Struct(self.structure_of(s)?),
            Type::Array { element, len } => {
                let len = match len {
                    landfall_layout::ArrayLen::Fixed(len) => Some(*len),
                    landfall_layout::ArrayLen::Runtime => None,
                    landfall_layout::ArrayLen::Override(_) => return None,
                };
                Ty::Array(Rc::new(self.glsl_type(element)?), len)
            }
            Type::Atomic(_) | Type::Address(_) => return None,
        })
    }

    pub fn default_block(&mut self, name: Name<'a>) -> Lowering<usize> {
        // All loose uniforms share the block that the layout gathered them in (OpenGL's default
        // uniform block, GLSL 4.60 §4.3.5).
        if let Some(index) = self.blocks.iter().position(|b| b.layout.gathered) {
            return Ok(self.block_memory[index]);
        }
        let found = self.layouts.iter().find(|layout| layout.gathered);
        let Some(layout) = found.cloned() else {
            return Err(refuse(name.span, format!("`{}` has no layout", name.text)));
        };
        let mut members = Vec::new();
        for member in &layout.members {
            let Some(ty) = self.glsl_type(&member.ty) else {
                return Err(refuse(
                    member.span,
                    format!("`{}` cannot be a loose uniform", member.name),
                ));
            };
            members.push(Field { name: member.name.to_string(), ty });
        }
        let structure = self.new_structure(DEFAULT_BLOCK, members);
        self.make_memory(layout, structure, None, true)
    }

    pub fn block(&mut self, block: &BlockDecl<'a>) -> Lowering<()> {
        let qualifiers = &block.qualifiers;
        let span = block.name.span;
        // Blocks of inputs and outputs have locations, not offsets.
        if matches!(qualifiers.storage, Storage::In | Storage::Out) {
            return self.interface_block(block);
        }
        if qualifiers.storage == Storage::Foreign {
            let message = format!("block `{}` belongs to an unsupported stage", block.name.text);
            return Err(refuse(span, message));
        }
        let found = self.layout_at.get(&span).map(|&index| &self.layouts[index]);
        let Some(layout) = found.cloned() else {
            return Err(refuse(span, format!("block `{}` has no layout", block.name.text)));
        };
        let mut members = Vec::new();
        for member in &layout.members {
            let Some(ty) = self.glsl_type(&member.ty) else {
                let message = format!(
                    "`{}` is a `{}`, which naga does not support",
                    member.name,
                    member.ty.spelled(landfall_layout::Language::Glsl)
                );
                return Err(refuse(member.span, message));
            };
            members.push(Field { name: member.name.to_string(), ty });
        }
        let structure = self.new_structure(block.name.text, members);
        let readonly =
            // A block is read-only if it says so or all of its members do (GLSL 4.60 §4.10).
            qualifiers.readonly || block.members.iter().all(|member| member.qualifiers.readonly);
        let memory = self.make_memory(layout, structure.clone(), Some(block), !readonly)?;
        match &block.instance {
            Some(instance) => self.declare_global(instance.text, Global::Block(memory)),
            None => {
                // Without an instance name its members are in the global scope (GLSL 4.60 §4.3.9).
                let names = block.members.iter().flat_map(|m| &m.names).map(|n| n.name.text);
                let names: Vec<&'a str> = names.collect();
                for (name, field) in names.into_iter().zip(&structure.members) {
                    let ty = field.ty.clone();
                    self.declare_global(name, Global::Member { memory: Some(memory), ty });
                }
            }
        }
        Ok(())
    }

    pub fn make_memory(
        &mut self,
        layout: landfall_layout::BlockLayout,
        structure: Rc<Structure>,
        // Each element of an array of blocks is a variable of its own, with a binding of its own;
        // naga has no arrays of uniform buffers without extensions.
        block: Option<&BlockDecl<'a>>,
        writable: bool,
    ) -> Lowering<usize> {
        let span = layout.span;
        let access =
            if writable { StorageAccess::LOAD | StorageAccess::STORE } else { StorageAccess::LOAD };
        let (space, purpose) = match layout.space {
            AddressSpace::Uniform | AddressSpace::Default => {
                (naga::AddressSpace::Uniform, Purpose::Uniform)
            }
            AddressSpace::Storage => (naga::AddressSpace::Storage { access }, Purpose::Storage),
            AddressSpace::PushConstant => (naga::AddressSpace::Immediate, Purpose::Immediate),
            AddressSpace::BufferReference
            | AddressSpace::ShaderRecord
            | AddressSpace::TaskPayload => {
                let message = format!("buffer references are not supported: `{}`", layout.name);
                return Err(refuse(span, message));
            }
            space => {
                let message =
                    format!("`{}` blocks are not supported: `{}`", space.name(), layout.name);
                return Err(refuse(span, message));
            }
        };
        let size = layout.size.unwrap_or(0);
        let block_type = self.host_of_block(&structure, &layout.members, size, purpose);
        let block_type = match block_type {
            Ok(block_type) => Rc::new(block_type),
            Err(NagaConflict::Alignment | NagaConflict::Foreign) => {
                let message =
                    format!("naga cannot represent the layout of block `{}`", layout.name);
                return Err(refuse(span, message).help(
                    "naga gets this block as an array of 32-bit words, which cannot hold 16-bit \
                     numbers or atomics",
                ));
            }
        };
        let runtime = structure.members.last().is_some_and(|m| matches!(m.ty, Ty::Array(_, None)));
        let ty = match block_type.naga {
            Some(ty) => ty,
            None => {
                let size = u32::try_from(size).unwrap_or(u32::MAX);
                self.words(size, runtime, purpose)
            }
        };
        let mut dims = Vec::new();
        for len in &layout.count {
            match len {
                landfall_layout::ArrayLen::Fixed(len) => dims.push(*len),
                landfall_layout::ArrayLen::Runtime | landfall_layout::ArrayLen::Override(_) => {
                    return Err(refuse(span, "arrays of blocks without a size are not supported"));
                }
            }
        }
        // Dimensions multiply, and hostile ones overflow.
        let count = dims.iter().try_fold(1u32, |all, len| all.checked_mul(*len));
        let Some(count) = count.filter(|&count| count <= MAX_BLOCKS) else {
            let message = format!("arrays of more than {MAX_BLOCKS} blocks are not supported");
            return Err(refuse(span, message));
        };
        let group = layout.group.unwrap_or(0);
        let mut wanted = layout.binding;
        let name = layout.instance.clone().unwrap_or_else(|| layout.name.clone());
        let mut variables = Vec::new();
        let memory = self.memories.len();
        for element in 0..count {
            let at = if purpose == Purpose::Immediate {
                None
            } else {
                Some(self.bindings.claim(group, wanted))
            };
            // OpenGL gives the elements of an array of blocks bindings in a row.
            wanted = wanted.and_then(|binding| binding.checked_add(1));
            let variable = self.variable_in(space, &name, ty, at, span);
            variables.push(variable);
            let (group, binding) = at.unwrap_or((0, 0));
            let element = block.is_some_and(|_| !dims.is_empty()).then_some(element);
            let layout = layout.clone();
            self.blocks.push(ModuleBlock { layout, group, binding, element, variable });
            self.block_memory.push(memory);
        }
        let fours = purpose == Purpose::Uniform;
        let writable = writable && purpose == Purpose::Storage;
        self.memories.push(Memory { variables, dims, block_type, structure, writable, fours });
        Ok(memory)
    }

    /// `in NAME { … } instance;`
    pub fn interface_block(&mut self, block: &BlockDecl<'a>) -> Lowering<()> {
        // The built-in block is known from `gl_Position` and the like.
        if block.name.text == "gl_PerVertex" {
            return Ok(());
        }
        let qualifiers = &block.qualifiers;
        if !block.dims.is_empty() {
            let message = "arrays of interface blocks are not supported";
            return Err(refuse(block.name.span, message));
        }
        let output = qualifiers.storage == Storage::Out;
        // Locations count up from the block's own, unless a member states another (GLSL 4.60
        // §4.4.1).
        let mut next = self.layout_number(qualifiers, "location");
        let mut fields = Vec::new();
        for member in &block.members {
            for declarator in &member.names {
                let ty = self.global_type(&member.ty, &declarator.dims)?;
                let own = self.layout_number(&member.qualifiers, "location");
                let location = own.or(next);
                next = location.map(|l| l + super::io::locations(&ty));
                let name = declarator.name;
                fields.push((Field { name: name.text.into(), ty }, name, location, member));
            }
        }
        // Without an instance name each member is a variable; with one the block is a structure.
        let Some(instance) = &block.instance else {
            for (field, name, location, member) in fields {
                let handle = self.private(name.text, &field.ty, name.span)?;
                let path = format!("{}.{}", block.name.text, name.text);
                let io =
                    StageVariable::new(&path, handle, field.ty.clone(), &member.qualifiers, output)
                        .with_block_qualifiers(qualifiers)
                        .at(location, None, name.span);
                self.io.push(io);
                let ty = field.ty;
                self.declare_global(name.text, Global::Variable { handle, ty, writable: output });
            }
            return Ok(());
        };
        let members: Vec<Field> = fields.iter().map(|f| f.0.clone()).collect();
        let structure = self.new_structure(block.name.text, members);
        let ty = Ty::Struct(structure);
        let handle = self.private(instance.text, &ty, block.name.span)?;
        for (index, (field, name, location, member)) in fields.into_iter().enumerate() {
            let path = format!("{}.{}", block.name.text, name.text);
            let io = StageVariable::new(&path, handle, field.ty, &member.qualifiers, output)
                .with_block_qualifiers(qualifiers)
                .member(index as u32)
                .at(location, None, name.span);
            self.io.push(io);
        }
        self.declare_global(instance.text, Global::Variable { handle, ty, writable: output });
        Ok(())
    }
}
