//! Reads SPIR-V modules, versions 1.0 to 1.6: blocks from storage classes, their numbers from
//! decorations.
//!
//! A reader of its own instead of the crate `rspirv`: it needs forty of some 800 instructions, passes
//! over code without decoding it, and stays within bounds on modules that no validator has seen.
//! Numbers of sections are those of the SPIR-V specification, version 1.6.
//!
//! `words` are split into instructions, `module` has the tables of these, `constants` the lengths of
//! arrays, `types` the types with their decorations; the blocks are made here. Offsets and strides go
//! into [`MemberPlace`](crate::shape::MemberPlace); which rules they follow, the layout finds.

mod constants;
mod module;
mod names;
mod types;
mod words;

use std::cmp::Ordering;
use std::collections::HashSet;
use std::sync::Arc;

use self::module::{Decorations, Module, ModuleVariable};
use self::types::{NoLayout, Types};
use self::words::{Id, class, op};
use super::Parsed;
use crate::diagnostic::{Code, Diagnostic};
use crate::shape::{
    AddressSpace, ArrayLen, Block, DEEPEST_NESTING, OffsetOrder, Packing, Rules, Shape,
};
use crate::source::{ReadOptions, Source, Span};

// The magic number is not checked again: by it the source found that the bytes are a module, and
// the order of the bytes in a word.
pub(super) fn read(source: &Source, options: &ReadOptions) -> Parsed {
    let mut parsed = Parsed::default();
    parsed.files.add(source.path.as_str(), Arc::from(""));
    let Some(words) = &source.words else {
        let help = "read it with `Source::read` or `Source::from_bytes`";
        let error = whole_module("a module is bytes, but this is a text".to_string());
        parsed.diagnostics.push(error.with_help(help));
        return parsed;
    };
    match module::read(words, options) {
        Ok(module) => read_blocks(&module, options, &mut parsed),
        Err(problem) => {
            let help = "compile it again, or let `spirv-val` say what is wrong with it";
            parsed.diagnostics.push(whole_module(problem).with_help(help));
        }
    }
    parsed
}

fn whole_module(message: String) -> Diagnostic {
    Diagnostic::error(Code::InvalidSpirv, Span::default(), message)
}

// With `structure` set, structures of that name are laid out whether or not a variable has them.
fn read_blocks(module: &Module<'_>, options: &ReadOptions, parsed: &mut Parsed) {
    parsed.stage = module.stage();
    let mut reader = BlockCollector {
        types: Types::new(module),
        blocks: Vec::new(),
        diagnostics: Vec::new(),
        tree: 0,
        keys: HashSet::new(),
        pointees: HashSet::new(),
        refused: HashSet::new(),
    };
    match &options.structure {
        Some(name) => reader.structures(name),
        None => {
            module.variables.iter().for_each(|variable| reader.variable(*variable));
            module.pointees.iter().for_each(|pointee| reader.pointee(*pointee));
        }
    }
    for (name, text) in &module.constants.wrong {
        let message = format!("`{name}` is set to `{text}`, which is not a value of its type");
        reader.diagnostics.push(Diagnostic::error(Code::OverrideValue, Span::default(), message));
    }
    let overrides = module.constants.overrides().iter().zip(&reader.types.used);
    let overrides = overrides.filter(|(_, used)| **used).map(|(one, _)| one.clone()).collect();
    let Types { specialised, .. } = reader.types;
    parsed.shape = Shape { blocks: reader.blocks, overrides, specialised, ..Shape::default() };
    parsed.diagnostics.append(&mut reader.diagnostics);
}

struct BlockCollector<'m, 'w> {
    types: Types<'m, 'w>,
    blocks: Vec<Block>,
    diagnostics: Vec<Diagnostic>,
    /// What the members of all blocks take.
    tree: u64,
    /// Each block, so that none is there twice.
    keys: HashSet<BlockKey>,
    pointees: HashSet<Id>,
    refused: HashSet<Id>,
}

/// The limit on blocks without a layout that are reported one by one.
const MAX_REFUSED: usize = 50;

/// Name, instance, address space, set and binding of a block, by which a lock tells blocks apart.
type BlockKey = (Arc<str>, Option<Arc<str>>, AddressSpace, Option<u32>, Option<u32>);

struct DeclaredBlock {
    /// The variable, or the structure without one.
    id: Id,
    space: AddressSpace,
    instance: Option<Arc<str>>,
    group: Option<u32>,
    binding: Option<u32>,
    count: Vec<ArrayLen>,
}

impl DeclaredBlock {
    /// A block without a variable.
    fn type_of(id: Id, space: AddressSpace) -> DeclaredBlock {
        DeclaredBlock { id, space, instance: None, group: None, binding: None, count: Vec::new() }
    }
}

impl BlockCollector<'_, '_> {
    /// Adds the block of a variable, if it is one of a block.
    fn variable(&mut self, variable: ModuleVariable) {
        let Some((structure, count)) = self.structure_of(variable) else { return };
        let module = self.types.module;
        // §3.7, Storage Class, with the decorations Block and BufferBlock of §3.20.
        let space = match variable.storage {
            // Before 1.3 a storage buffer is in the class Uniform, and a BufferBlock.
            class::UNIFORM if module.decorations(structure).buffer_block => AddressSpace::Storage,
            class::UNIFORM => AddressSpace::Uniform,
            class::STORAGE_BUFFER => AddressSpace::Storage,
            class::PUSH_CONSTANT => AddressSpace::PushConstant,
            class::SHADER_RECORD_BUFFER => AddressSpace::ShaderRecord,
            // Only a payload with offsets has a layout that anybody may rely on.
            class::TASK_PAYLOAD_WORKGROUP if self.has_offsets(structure) => {
                AddressSpace::TaskPayload
            }
            _ => return,
        };
        let instance = module.name(variable.id).and_then(|name| names::identifier(&name));
        let Decorations { group, binding, .. } = module.decorations(variable.id);
        match count {
            Ok(count) => {
                let id = variable.id;
                self.block(structure, DeclaredBlock { id, space, instance, group, binding, count });
            }
            Err(reason) => self.refuse(structure, &reason.into()),
        }
    }

    /// The structure that the variable of a block points to, and the dimensions of an array of blocks.
    // variable -> OpTypePointer -> { OpTypeArray | OpTypeRuntimeArray } -> OpTypeStruct
    // The outermost dimension comes first, as in `count` of a block.
    fn structure_of(
        &self,
        variable: ModuleVariable,
    ) -> Option<(Id, Result<Vec<ArrayLen>, String>)> {
        let Module { types, constants, .. } = self.types.module;
        let pointer = types.get(&variable.pointer).filter(|ty| ty.opcode == op::TYPE_POINTER)?;
        let mut id = *pointer.operands.get(2)?;
        let mut count = Ok(Vec::new());
        // An array that contains itself ends here as well.
        for _ in 0..DEEPEST_NESTING {
            let ty = types.get(&id)?;
            let (element, len) = match (ty.opcode, ty.operands) {
                (op::TYPE_STRUCT, _) => return Some((id, count)),
                (op::TYPE_RUNTIME_ARRAY, [_, element, ..]) => (*element, Ok(ArrayLen::Runtime)),
                (op::TYPE_ARRAY, [_, element, length, ..]) => {
                    let len = constants.length(*length).and_then(|length| length.in_model());
                    (*element, len)
                }
                _ => return None,
            };
            count = match (count, len) {
                (Ok(dims), Ok(len)) => Ok([dims, vec![len]].concat()),
                (Err(reason), _) => Err(reason),
                (_, Err(reason)) => Err(format!("is an array whose length {reason}")),
            };
            id = element;
        }
        None
    }

    fn has_offsets(&self, structure: Id) -> bool {
        self.types.module.member_decorations(structure, 0).offset.is_some()
    }

    /// Adds what a pointer into physical storage points to, if it is a block.
    // Pointers of several types may have one pointee: it is a block once.
    fn pointee(&mut self, pointee: Id) {
        let module = self.types.module;
        let is_block = module.decorations(pointee).block
            && module.types.get(&pointee).is_some_and(|ty| ty.opcode == op::TYPE_STRUCT);
        if is_block && self.pointees.insert(pointee) {
            self.block(pointee, DeclaredBlock::type_of(pointee, AddressSpace::BufferReference));
        }
    }

    fn structures(&mut self, name: &str) {
        let types = self.types.module.types.iter();
        let mut ids: Vec<Id> =
            types.filter(|(_, ty)| ty.opcode == op::TYPE_STRUCT).map(|(id, _)| *id).collect();
        // A hash map has no order of its own.
        ids.sort_unstable();
        let names: Vec<Arc<str>> =
            ids.iter().map(|id| self.types.structure_name(*id, "struct")).collect();
        if names.iter().all(|known| **known != *name) {
            let error = super::no_structure(name, names.iter().map(|known| &**known));
            return self.diagnostics.push(error);
        }
        for (id, _) in ids.into_iter().zip(names).filter(|(_, known)| **known == *name) {
            self.block(id, DeclaredBlock::type_of(id, AddressSpace::Structure));
        }
    }

    fn block(&mut self, structure: Id, declared: DeclaredBlock) {
        let structure = self.unwrapped(structure);
        // Each reading takes its time, and those before may have reached the limit.
        if self.refused.contains(&structure) || types::check_tree(self.tree).is_err() {
            return;
        }
        let Ok(instruction) = self.types.instruction(structure) else { return };
        let read = self.types.members(structure, instruction, 1);
        let read = read.and_then(|(members, tree)| {
            self.tree = self.tree.saturating_add(tree);
            types::check_tree(self.tree).map(|()| members)
        });
        let members = match read {
            Ok(members) => members,
            Err(reason) => return self.refuse(structure, &reason),
        };
        let Some(span) = members.first().map(|member| member.span) else { return };
        let DeclaredBlock { id, space, mut instance, group, binding, count } = declared;
        let name = self.types.structure_name(structure, "block");
        // Two variables may have all of these in common (aliases of one binding, names that were
        // stripped).
        let mut key = (name, instance.clone(), space, group, binding);
        while !self.keys.insert(key.clone()) {
            let own = instance.as_deref().unwrap_or("variable");
            instance = Some(format!("{own}_{id}").into());
            key.1.clone_from(&instance);
        }
        let rules = Rules::Explicit(Packing::Free);
        let block = Block::unqualified(key.0, space, rules, members, span);
        let offset_order = OffsetOrder::Any;
        self.blocks.push(Block { instance, group, binding, count, offset_order, ..block });
    }

    /// naga puts a block into a structure of one member without a name.
    // Left in place, each block of a naga module would have one member `member_0`, and its lock
    // would differ from that of the same shader compiled by others.
    fn unwrapped(&self, structure: Id) -> Id {
        let module = self.types.module;
        let only = match module.types.get(&structure).map(|ty| ty.operands) {
            Some([_, only]) if module.member_name(structure, 0).is_none() => *only,
            _ => return structure,
        };
        let is_structure = module.types.get(&only).is_some_and(|ty| ty.opcode == op::TYPE_STRUCT);
        let is_wrapper = module.name(structure).is_none() && module.name(only).is_some();
        let at_start = module.member_decorations(structure, 0).offset == Some(0);
        if is_structure && is_wrapper && at_start { only } else { structure }
    }

    fn refuse(&mut self, structure: Id, reason: &NoLayout) {
        if !self.refused.insert(structure) {
            return;
        }
        let name = self.types.structure_name(structure, "block");
        match self.refused.len().cmp(&MAX_REFUSED) {
            Ordering::Less => {
                let message = format!("block `{name}` has no layout: {reason}");
                self.diagnostics.push(whole_module(message));
            }
            Ordering::Equal => {
                let message = format!("more than {MAX_REFUSED} blocks have no layout");
                self.diagnostics.push(whole_module(message));
            }
            Ordering::Greater => {}
        }
    }
}
