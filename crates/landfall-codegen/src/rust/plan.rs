//! The plan of the output: all its types, from one walk over the layouts of the blocks.
//!
//! Types are interned by content, so a structure that two blocks, rules or shaders lay out alike
//! is one mirror. [`super::naming`] names them.

use std::collections::hash_map::Entry;

use rustc_hash::FxHashMap;

use landfall_layout::ShaderLayout;
use landfall_layout::layout::measure::StructureEnd;
use landfall_layout::layout::{BlockLayout, MemberLayout, measure};
use landfall_layout::shape::{LengthConstant, Rules, Struct};

use super::Vectors;
use super::array::{divisor, member_type, padded};
use super::docs::{MirrorDoc, Origin};
use super::names::{Scope, camel, snake};
use super::rename::Renames;
use super::types::{
    Field, GeneratedType, GeneratedTypeId, Mirror, Module, RuntimeTail, RustType, Sized,
};
use crate::runtime_tail::{buffer_size, tail_size};
use crate::user_types::UserTypes;

/// All types and tables of the output.
pub(super) struct Plan<'a> {
    pub(super) vectors: Vectors,
    /// The types, each after those it contains.
    pub(super) made: Vec<GeneratedType>,
    ids: FxHashMap<GeneratedType, GeneratedTypeId>,
    /// The documentation of each mirror.
    pub(super) docs: FxHashMap<GeneratedTypeId, MirrorDoc>,
    /// The blocks that get a table.
    pub(super) blocks: Vec<PlannedBlock<'a>>,
    planned: FxHashMap<BlockKey, usize>,
    origin: Option<Origin<'a>>,
    /// The shaders' modules that use each type, in ascending order.
    users: Vec<Vec<usize>>,
    /// The types of each shader's module, each after those it contains.
    used: Vec<Vec<GeneratedTypeId>>,
    /// The rules that each module lays a mirror out by.
    rules: FxHashMap<(usize, GeneratedTypeId), Vec<Rules>>,
    /// The constants of each shader's module.
    constants: Vec<Vec<&'a LengthConstant>>,
    /// The module of the shader at hand.
    module: usize,
    renames: &'a Renames,
    pub(super) user_types: &'a UserTypes,
    flat: bool,
}

/// Blocks with the same mirror, group and binding share a table.
type BlockKey = (GeneratedTypeId, Option<u32>, Option<u32>);

/// A block and its mirror.
pub(super) struct PlannedBlock<'a> {
    pub(super) layout: &'a BlockLayout,
    pub(super) shader: &'a ShaderLayout,
    pub(super) input: &'a str,
    /// Its name, as renamed.
    pub(super) name: String,
    /// The shaders' modules that declare it, in ascending order.
    modules: Vec<usize>,
}

/// The space available for a member.
#[derive(Clone, Copy)]
pub(super) struct MemberRoom<'n> {
    /// The name in the shader of the structure or block that the member is of.
    pub(super) owner: &'n str,
    /// Bytes up to the next member.
    pub(super) room: u64,
    /// The guaranteed alignment of its start, at most 16.
    pub(super) align: u64,
    pub(super) rules: Rules,
}

impl<'a> Plan<'a> {
    /// An empty plan; `flat` puts all shaders into one module.
    pub(super) fn new(
        vectors: Vectors,
        renames: &'a Renames,
        user_types: &'a UserTypes,
        flat: bool,
    ) -> Plan<'a> {
        Plan {
            vectors,
            made: Vec::new(),
            ids: FxHashMap::default(),
            docs: FxHashMap::default(),
            blocks: Vec::new(),
            planned: FxHashMap::default(),
            origin: None,
            users: Vec::new(),
            used: Vec::new(),
            rules: FxHashMap::default(),
            constants: Vec::new(),
            module: 0,
            renames,
            user_types,
            flat,
        }
    }

    /// Adds a block that [`super::refuse`] accepts, of the shader of that index.
    pub(super) fn add(
        &mut self,
        layout: &'a BlockLayout,
        shader: &'a ShaderLayout,
        input: &'a str,
        shader_index: usize,
    ) {
        let module = if self.flat { 0 } else { shader_index };
        self.module = module;
        self.used.resize(self.used.len().max(module + 1), Vec::new());
        self.constants.resize(self.used.len(), Vec::new());
        for constant in &shader.constants {
            if !self.constants[module].contains(&constant) {
                self.constants[module].push(constant);
            }
        }
        let origin = Origin { files: &shader.files, language: shader.language, input };
        self.origin = Some(origin);
        // A runtime-sized tail is no part of the mirror: the mirror of the members before it is a
        // header.
        let whole = buffer_size(layout).expect("blocks without offsets are refused");
        let (fixed, last) = layout.split_tail();
        let end = last.and_then(|tail| tail.offset).unwrap_or(whole);
        // The size of a Rust type is a multiple of its alignment: no more than what divides the
        // size can be promised.
        let align = divisor(end).min(divisor(layout.align.unwrap_or(1)));
        let place = MemberRoom { owner: &layout.name, room: end, align, rules: layout.rules };
        let fields = self.fields(fixed, end, &place);
        let name = self.renamed(&layout.name, camel);
        let tail = last.map(|tail| self.tail(tail, end, layout, &name));
        let mirror = Mirror {
            name: if tail.is_some() {
                format!("{}Header", name.trim_end_matches('_'))
            } else {
                name
            },
            fields,
            size: end,
            tail,
        };
        let id = self.mirror(mirror, layout.rules, || MirrorDoc::of_block(layout, fixed, &origin));
        // Another shader with the same block shares its mirror and its table.
        match self.planned.entry((id, layout.group, layout.binding)) {
            Entry::Occupied(at) => {
                use_in(&mut self.blocks[*at.get()].modules, module);
            }
            Entry::Vacant(free) => {
                free.insert(self.blocks.len());
                let name =
                    self.renames.new_name(input, &layout.name).unwrap_or(&layout.name).to_string();
                let modules = vec![module];
                self.blocks.push(PlannedBlock { layout, shader, input, name, modules });
            }
        }
    }

    /// The name that the configuration gives a structure or block of the shader at hand, or `usual`.
    fn renamed(&self, name: &str, usual: impl Fn(&str) -> String) -> String {
        let input = self.origin.map_or("", |origin| origin.input);
        self.renames.new_name(input, name).map_or_else(|| usual(name), str::to_string)
    }

    /// Whether all shaders are in one module.
    pub(super) fn is_flat(&self) -> bool {
        self.flat
    }

    /// The module that a type is written in.
    pub(super) fn module_of(&self, id: GeneratedTypeId) -> Module {
        // Helpers that hold no mirror are the same for all shaders.
        match &self.made[id.0] {
            made if !self.holds_mirror(made) => Module::Support,
            _ => common(&self.users[id.0]),
        }
    }

    /// The module that the table of a block is written in.
    pub(super) fn module_of_table(&self, at: usize) -> Module {
        common(&self.blocks[at].modules)
    }

    /// The types that a module holds or imports, helpers included, each after those it contains.
    pub(super) fn types_in(&self, module: Module) -> Vec<GeneratedTypeId> {
        match module {
            Module::Shader(at) => self.used.get(at).cloned().unwrap_or_default(),
            Module::Support | Module::Common => {
                let all = (0..self.made.len()).map(GeneratedTypeId);
                all.filter(|id| self.module_of(*id) == module).collect()
            }
        }
    }

    /// The mirrors among [`Self::types_in`].
    pub(super) fn mirrors_in(&self, module: Module) -> Vec<(GeneratedTypeId, &Mirror)> {
        let types = self.types_in(module).into_iter();
        types.filter_map(|id| self.mirror_of(id).map(|mirror| (id, mirror))).collect()
    }

    fn mirror_of(&self, id: GeneratedTypeId) -> Option<&Mirror> {
        match self.get(id) {
            GeneratedType::Mirror(mirror) => Some(mirror),
            GeneratedType::Bits(_)
            | GeneratedType::Leaf(_)
            | GeneratedType::Padded(_)
            | GeneratedType::Tight(_) => None,
        }
    }

    fn note_use(&mut self, id: GeneratedTypeId) {
        if use_in(&mut self.users[id.0], self.module) {
            self.used[self.module].push(id);
        }
    }

    /// Whether a block has a table in a module, or one that it imports.
    pub(super) fn has_table(&self, at: usize, module: Module) -> bool {
        match module {
            Module::Support => false,
            Module::Common => self.module_of_table(at) == Module::Common,
            Module::Shader(shader) => self.blocks[at].modules.contains(&shader),
        }
    }

    /// The constants of the shaders in a module that lengths are written with.
    pub(super) fn constants_in(&self, module: Module) -> &[&'a LengthConstant] {
        match module {
            Module::Shader(at) => self.constants.get(at).map_or(&[], Vec::as_slice),
            Module::Support | Module::Common => &[],
        }
    }

    /// The rules that lay a mirror out in a module.
    pub(super) fn rules_in(&self, id: GeneratedTypeId, module: Module) -> &[Rules] {
        match module {
            Module::Shader(at) => self.rules.get(&(at, id)).map_or(&[], Vec::as_slice),
            Module::Support | Module::Common => self.docs[&id].rules(),
        }
    }

    fn holds_mirror(&self, made: &GeneratedType) -> bool {
        let inside = |ty: &RustType| {
            let mut ty = ty;
            while let RustType::Array(element, _) = ty {
                ty = element;
            }
            matches!(ty, RustType::GeneratedType(id) if self.holds_mirror(self.get(*id)))
        };
        match made {
            GeneratedType::Mirror(_) => true,
            GeneratedType::Padded(padded) => inside(&padded.inner),
            GeneratedType::Tight(tight) => inside(&tight.element),
            GeneratedType::Bits(_) | GeneratedType::Leaf(_) => false,
        }
    }

    /// Adds the mirror of a structure, the type of a member or of its elements.
    pub(super) fn structure(
        &mut self,
        s: &Struct,
        member: &MemberLayout,
        at: &MemberRoom<'_>,
    ) -> Sized {
        let members = &member.members;
        let StructureEnd { align, data_size } = measure::structure(members, at.rules);
        // Scalar rules let the next member begin in the padding of a structure.
        let padded = data_size.next_multiple_of(align);
        let size = if padded <= at.room { padded } else { data_size };
        // As for blocks: an alignment is promised only if the place, the structure and the size
        // have it.
        let align = at.align.min(divisor(align)).min(divisor(size));
        let name = if s.name.is_empty() { &member.name } else { &s.name };
        let fields = self.fields(members, size, &MemberRoom { owner: name, align, ..*at });
        let name = self.renamed(name, camel);
        let origin = self.origin.expect("structures are met in blocks");
        let id = self.mirror(Mirror { name, fields, size, tail: None }, at.rules, || {
            MirrorDoc::of_structure(s, members, size, at.rules, &origin)
        });
        Sized { ty: RustType::GeneratedType(id), size }
    }

    /// The fields of a structure or block that ends at `end`.
    fn fields(&mut self, members: &[MemberLayout], end: u64, place: &MemberRoom<'_>) -> Vec<Field> {
        let mut names = Scope::default();
        let names: Vec<String> = members.iter().map(|m| names.take(&snake(&m.name))).collect();
        // Vulkan takes explicit offsets in any order; a mirror has them in ascending order.
        let starts = by_offset(members);
        // A field has the room up to the next one.
        let ends = starts.iter().skip(1).map(|next| next.0).chain([end]);
        let mut fields = Vec::with_capacity(members.len());
        for (&(offset, order), next) in starts.iter().zip(ends) {
            let member = &members[order];
            let align = place.align.min(divisor(member.align.unwrap_or(1)));
            let here = MemberRoom { room: next - offset, align, ..*place };
            let Sized { ty, size } = member_type(self, member, 0, &here);
            fields.push(Field { name: names[order].clone(), ty, offset, size, order });
        }
        fields
    }

    fn tail(
        &mut self,
        member: &MemberLayout,
        offset: u64,
        block: &BlockLayout,
        name: &str,
    ) -> RuntimeTail {
        let stride = member.strides[0];
        // Each element begins a stride after the one before: an alignment that does not divide the
        // stride would not hold for all.
        let align = divisor(stride).min(divisor(member.align.unwrap_or(1)));
        let place = MemberRoom { owner: &block.name, room: stride, align, rules: block.rules };
        let element = member_type(self, member, 1, &place);
        RuntimeTail {
            member: member.name.to_string(),
            name: format!("{}Element", name.trim_end_matches('_')),
            element: padded(self, element, stride).ty,
            stride,
            sizes: tail_size(block, offset, stride),
        }
    }

    fn mirror(
        &mut self,
        mirror: Mirror,
        rules: Rules,
        doc: impl FnOnce() -> MirrorDoc,
    ) -> GeneratedTypeId {
        let made = GeneratedType::Mirror(mirror);
        let id = match self.ids.get(&made) {
            Some(id) => {
                // Two rules may lay it out alike: the documentation names both.
                if let Some(doc) = self.docs.get_mut(id) {
                    doc.also_by(rules);
                }
                *id
            }
            None => {
                let id = self.push(made);
                self.docs.insert(id, doc());
                id
            }
        };
        self.note_use(id);
        let here = self.rules.entry((self.module, id)).or_default();
        if !here.contains(&rules) {
            here.push(rules);
        }
        id
    }

    /// Interns a type.
    pub(super) fn intern(&mut self, made: GeneratedType) -> RustType {
        let id = match self.ids.get(&made) {
            Some(id) => *id,
            None => self.push(made),
        };
        self.note_use(id);
        RustType::GeneratedType(id)
    }

    fn push(&mut self, made: GeneratedType) -> GeneratedTypeId {
        let id = GeneratedTypeId(self.made.len());
        self.made.push(made.clone());
        self.users.push(Vec::new());
        self.ids.insert(made, id);
        id
    }

    /// The id of a type in the plan.
    pub(super) fn id(&self, made: &GeneratedType) -> Option<GeneratedTypeId> {
        self.ids.get(made).copied()
    }

    pub(super) fn get(&self, id: GeneratedTypeId) -> &GeneratedType {
        &self.made[id.0]
    }
}

/// Adds a module to the users of a type or table, and returns whether it is new; modules are added
/// in order.
fn use_in(users: &mut Vec<usize>, module: usize) -> bool {
    // Modules are added in ascending order: the last one suffices.
    let new = users.last() != Some(&module);
    if new {
        users.push(module);
    }
    new
}

/// The module of what these shaders' modules use.
fn common(users: &[usize]) -> Module {
    match users {
        [one] => Module::Shader(*one),
        [] | [_, ..] => Module::Common,
    }
}

/// The offset and index of each member, by ascending offset.
pub(super) fn by_offset(members: &[MemberLayout]) -> Vec<(u64, usize)> {
    let offset = |m: &MemberLayout| m.offset.expect("blocks without offsets are refused");
    let mut starts: Vec<(u64, usize)> =
        members.iter().enumerate().map(|(order, m)| (offset(m), order)).collect();
    starts.sort_unstable();
    starts
}
