//! The plan of the output: all its types, from one walk over the layouts of the blocks.
//!
//! Types are interned by content, so a structure that two blocks, rules or shaders lay out alike
//! is one mirror. [`super::naming`] names them.

use rustc_hash::FxHashMap;

use crate::ShaderLayout;
use crate::layout::{BlockLayout, MemberLayout};
use crate::shape::{ArrayLen, Rules, Struct};

use super::Vectors;
use super::array::{divisor, member_type, padded, reach};
use super::docs::{MirrorDoc, Origin};
use super::names::{Scope, camel, snake};
use super::types::{Field, GeneratedType, GeneratedTypeId, Mirror, RuntimeTail, RustType, Sized};

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
}

/// Blocks with the same mirror, group and binding share a table.
type BlockKey = (GeneratedTypeId, Option<u32>, Option<u32>);

/// A block and its mirror.
pub(super) struct PlannedBlock<'a> {
    pub(super) layout: &'a BlockLayout,
    pub(super) shader: &'a ShaderLayout,
    pub(super) input: &'a str,
}

/// The space available for a member.
#[derive(Clone, Copy)]
pub(super) struct MemberRoom {
    /// Bytes up to the next member.
    pub(super) room: u64,
    /// The guaranteed alignment of its start, at most 16.
    pub(super) align: u64,
    pub(super) rules: Rules,
}

impl<'a> Plan<'a> {
    pub(super) fn new(vectors: Vectors) -> Plan<'a> {
        Plan {
            vectors,
            made: Vec::new(),
            ids: FxHashMap::default(),
            docs: FxHashMap::default(),
            blocks: Vec::new(),
            planned: FxHashMap::default(),
            origin: None,
        }
    }

    /// Adds a block that [`super::refuse`] accepts.
    pub(super) fn add(
        &mut self,
        layout: &'a BlockLayout,
        shader: &'a ShaderLayout,
        input: &'a str,
    ) {
        let origin = Origin { files: &shader.files, language: shader.language, input };
        self.origin = Some(origin);
        let whole = layout.size.expect("blocks without offsets are refused");
        let (fixed, last) = split_tail(layout);
        let end = last.and_then(|tail| tail.offset).unwrap_or(whole);
        let align = divisor(end).min(divisor(layout.align.unwrap_or(1)));
        let place = MemberRoom { room: end, align, rules: layout.rules };
        let fields = self.fields(fixed, end, &place);
        let tail = last.map(|tail| self.tail(tail, whole, layout));
        let name = camel(&layout.name);
        let mirror = Mirror {
            name: if tail.is_some() { camel(&format!("{}_header", layout.name)) } else { name },
            fields,
            size: end,
            tail,
        };
        let id = self.mirror(mirror, layout.rules, || MirrorDoc::of_block(layout, fixed, &origin));
        if self.planned.insert((id, layout.group, layout.binding), self.blocks.len()).is_none() {
            self.blocks.push(PlannedBlock { layout, shader, input });
        }
    }

    /// Adds the mirror of a structure, the type of a member or of its elements.
    pub(super) fn structure(
        &mut self,
        s: &Struct,
        member: &MemberLayout,
        at: &MemberRoom,
    ) -> Sized {
        let members = &member.members;
        let reach = reach(members);
        let align = structure_align(members, at.rules);
        // Scalar rules let the next member begin in the padding of a structure.
        let padded = reach.next_multiple_of(align);
        let size = if padded <= at.room { padded } else { reach };
        let align = at.align.min(divisor(align)).min(divisor(size));
        let fields = self.fields(members, size, &MemberRoom { align, ..*at });
        let name = camel(if s.name.is_empty() { &member.name } else { &s.name });
        let origin = self.origin.expect("structures are met in blocks");
        let id = self.mirror(Mirror { name, fields, size, tail: None }, at.rules, || {
            MirrorDoc::of_structure(s, members, size, at.rules, &origin)
        });
        Sized { ty: RustType::GeneratedType(id), size }
    }

    /// The fields of a structure or block that ends at `end`.
    fn fields(&mut self, members: &[MemberLayout], end: u64, place: &MemberRoom) -> Vec<Field> {
        let mut names = Scope::default();
        let names: Vec<String> = members.iter().map(|m| names.take(&snake(&m.name))).collect();
        // Vulkan takes explicit offsets in any order; a mirror has them in ascending order.
        let starts = by_offset(members);
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

    fn tail(&mut self, member: &MemberLayout, whole: u64, block: &BlockLayout) -> RuntimeTail {
        let stride = member.strides[0];
        let align = divisor(stride).min(divisor(member.align.unwrap_or(1)));
        let place = MemberRoom { room: stride, align, rules: block.rules };
        let element = member_type(self, member, 1, &place);
        RuntimeTail {
            member: member.name.to_string(),
            name: camel(&format!("{}_element", block.name)),
            element: padded(self, element, stride).ty,
            stride,
            least: whole,
        }
    }

    fn mirror(
        &mut self,
        mirror: Mirror,
        rules: Rules,
        doc: impl FnOnce() -> MirrorDoc,
    ) -> GeneratedTypeId {
        let made = GeneratedType::Mirror(mirror);
        if let Some(id) = self.ids.get(&made) {
            if let Some(doc) = self.docs.get_mut(id) {
                doc.also_by(rules);
            }
            return *id;
        }
        let id = self.push(made);
        self.docs.insert(id, doc());
        id
    }

    /// Interns a type.
    pub(super) fn intern(&mut self, made: GeneratedType) -> RustType {
        RustType::GeneratedType(match self.ids.get(&made) {
            Some(id) => *id,
            None => self.push(made),
        })
    }

    fn push(&mut self, made: GeneratedType) -> GeneratedTypeId {
        let id = GeneratedTypeId(self.made.len());
        self.made.push(made.clone());
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

    /// The mirrors, each after those it contains.
    pub(super) fn mirrors(&self) -> impl Iterator<Item = (GeneratedTypeId, &Mirror)> {
        self.made.iter().enumerate().filter_map(|(i, made)| match made {
            GeneratedType::Mirror(mirror) => Some((GeneratedTypeId(i), mirror)),
            GeneratedType::Bits(_)
            | GeneratedType::Leaf(_)
            | GeneratedType::Padded(_)
            | GeneratedType::Tight(_) => None,
        })
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

/// Splits off the runtime-sized tail of a block, if it has one.
fn split_tail(block: &BlockLayout) -> (&[MemberLayout], Option<&MemberLayout>) {
    match block.members.split_last() {
        Some((last, rest)) if last.dims.first() == Some(&ArrayLen::Runtime) => (rest, Some(last)),
        _ => (&block.members, None),
    }
}

/// A structure's alignment, which std140 rounds up to 16 (OpenGL 4.6 §7.6.2.2, rule 9).
pub(super) fn structure_align(members: &[MemberLayout], rules: Rules) -> u64 {
    let own = members.iter().filter_map(|m| m.align).max().unwrap_or(1);
    match rules {
        Rules::Std140 => own.max(16),
        Rules::Std430 | Rules::Scalar | Rules::Wgsl => own,
    }
}
