//! Types of the module as types of the model, with the places that decorations give to members.
//!
//! A type is read on demand and once. It may be refused: for a type without a size, a decoration
//! that is missing, a cycle, or more members than can be listed.

use std::fmt;
use std::sync::Arc;

use rustc_hash::{FxHashMap, FxHashSet};

use super::constants::ArrayLength;
use super::module::{Decorations, Module};
use super::names;
use super::words::{Id, Instruction, class, op};
use crate::shape::{
    ArrayLen, DEEPEST_NESTING, Member, MemberPlace, Scalar, ScalarKind, SpecialisedLength, Struct,
    Type,
};
use crate::source::Span;

/// The limit on what the members of all blocks take, in bytes of paths and of numbers: modules of a few
/// kilobytes can have structures in structures without end.
const LARGEST_TREE: u64 = 64 << 20;

/// What a member takes beside its path, about.
const MEMBER_BYTES: u64 = 64;

/// The types of a module that have been read.
pub(super) struct Types<'m, 'w> {
    pub module: &'m Module<'w>,
    known: FxHashMap<Id, KnownType>,
    /// The lengths that depend on specialisation constants.
    pub specialised: Vec<SpecialisedLength>,
    /// Whether a length depends on each specialisation constant.
    pub used: Vec<bool>,
    /// The structures whose lengths have been recorded.
    noted: FxHashSet<Id>,
}

/// Why a type or a block has no layout.
#[derive(Clone, Debug)]
pub(super) struct NoLayout {
    /// The path of the member: `lights.color`; empty for the block.
    path: String,
    /// The reason, read after the path: `has no Offset`.
    reason: String,
    /// Whether it is nested too deep, which it may be in one block and not in another.
    is_deep: bool,
}

impl<T: Into<String>> From<T> for NoLayout {
    fn from(reason: T) -> NoLayout {
        NoLayout { path: String::new(), reason: reason.into(), is_deep: false }
    }
}

impl NoLayout {
    fn within(mut self, member: &str) -> NoLayout {
        let dot = if self.path.is_empty() { "" } else { "." };
        self.path = format!("{member}{dot}{}", self.path);
        self
    }
}

impl fmt::Display for NoLayout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &*self.path {
            "" => f.write_str("it ")?,
            path => write!(f, "`{path}` ")?,
        }
        f.write_str(&self.reason)
    }
}

/// The reading of a type.
// Each type is read once, whatever the number of its uses: modules share them. `Open` marks those
// on the path from the block, so meeting one is a cycle.
#[derive(Clone)]
enum KnownType {
    /// It is being read: a type that contains itself meets it.
    Open,
    /// `None` for a structure without members, which takes no bytes.
    Done(Option<TypedMember>),
    /// With the depth from which on it is refused: what is too deep in one block may not be in another.
    Broken(NoLayout, u32),
}

/// A type, and what its members take altogether.
#[derive(Clone)]
pub(super) struct TypedMember {
    pub ty: Type,
    pub tree: u64,
}

impl<'m, 'w> Types<'m, 'w> {
    pub(super) fn new(module: &'m Module<'w>) -> Types<'m, 'w> {
        Types {
            module,
            known: FxHashMap::default(),
            specialised: Vec::new(),
            used: vec![false; module.constants.overrides().len()],
            noted: FxHashSet::default(),
        }
    }

    /// Returns a type; `None` if it is a structure without members.
    ///
    /// # Errors
    /// It has no layout, contains itself, or is nested deeper than 128.
    pub(super) fn read(&mut self, id: Id, depth: u32) -> Result<Option<TypedMember>, NoLayout> {
        let known = self.known.get(&id);
        let below = match known {
            Some(KnownType::Done(Some(typed))) => typed.ty.depth(),
            _ => 0,
        };
        if depth + below > DEEPEST_NESTING {
            let reason = format!("is nested deeper than {DEEPEST_NESTING}");
            return Err(NoLayout { is_deep: true, ..reason.into() });
        }
        match known {
            Some(KnownType::Open) => {
                return Err(format!("has the type %{id}, which contains itself").into());
            }
            Some(KnownType::Done(typed)) => return Ok(typed.clone()),
            Some(KnownType::Broken(problem, from)) if depth >= *from => return Err(problem.clone()),
            Some(KnownType::Broken(..)) | None => {}
        }
        self.known.insert(id, KnownType::Open);
        let read = self.read_new(id, depth);
        let known = match &read {
            Ok(typed) => KnownType::Done(typed.clone()),
            Err(problem) => {
                KnownType::Broken(problem.clone(), if problem.is_deep { depth } else { 0 })
            }
        };
        self.known.insert(id, known);
        read
    }

    // The type-declaration instructions; `operands[0]` is the result id of each.
    fn read_new(&mut self, id: Id, depth: u32) -> Result<Option<TypedMember>, NoLayout> {
        let instruction = self.instruction(id)?;
        let leaf = |ty: Type| Ok(Some(TypedMember { ty, tree: 0 }));
        match (instruction.opcode, &instruction.operands[1..]) {
            (op::TYPE_INT | op::TYPE_FLOAT, _) => leaf(Type::Scalar(scalar(instruction)?)),
            (op::TYPE_VECTOR, [component, count @ 2..=4, ..]) => {
                let scalar = scalar(self.instruction(*component)?)?;
                leaf(Type::Vector { scalar, rows: *count as u8 })
            }
            (op::TYPE_MATRIX, [column, count @ 2..=4, ..]) => {
                match self.read(*column, depth + 1)?.map(|typed| typed.ty) {
                    Some(Type::Vector { scalar, rows }) => {
                        leaf(Type::Matrix { scalar, columns: *count as u8, rows })
                    }
                    _ => Err(format!("has a matrix whose columns %{column} are no vectors").into()),
                }
            }
            (op::TYPE_ARRAY, [element, length, ..]) => {
                let len = self.length(*length)?.in_model();
                let len = len.map_err(|reason| format!("has an array whose length {reason}"))?;
                self.array(*element, len, depth)
            }
            (op::TYPE_RUNTIME_ARRAY, [element, ..]) => {
                self.array(*element, ArrayLen::Runtime, depth)
            }
            (op::TYPE_STRUCT, _) => self.structure(id, instruction, depth),
            // §3.4, PhysicalStorageBuffer64: an address of 64 bits.
            (op::TYPE_POINTER, [class::PHYSICAL_STORAGE_BUFFER, pointee, ..]) => {
                leaf(Type::Address(self.pointee_name(*pointee)))
            }
            (op::TYPE_BOOL, _) => Err("is a bool, which has no size in SPIR-V".into()),
            (opcode, _) => {
                Err(format!("has a type without a layout, %{id} of opcode {opcode}").into())
            }
        }
    }

    pub(super) fn instruction(&self, id: Id) -> Result<Instruction<'w>, String> {
        let found = self.module.types.get(&id).copied();
        found.ok_or_else(|| format!("has the type %{id}, which the module does not declare"))
    }

    // An array of structures without members takes no bytes, as they do.
    fn array(
        &mut self,
        element: Id,
        len: ArrayLen,
        depth: u32,
    ) -> Result<Option<TypedMember>, NoLayout> {
        let Some(TypedMember { ty, tree }) = self.read(element, depth + 1)? else {
            return Ok(None);
        };
        let ty = Type::Array { element: Arc::new(ty), len };
        Ok(Some(TypedMember { ty, tree }))
    }

    fn length(&mut self, id: Id) -> Result<ArrayLength, String> {
        let length = self.module.constants.length(id);
        let length = length.map_err(|problem| format!("has an array whose length {problem}"))?;
        length.depends_on.iter().for_each(|index| self.used[*index] = true);
        Ok(length)
    }

    /// The name of a structure: `struct_12` where it has none.
    pub(super) fn structure_name(&self, id: Id, kind: &str) -> Arc<str> {
        let name = self.module.name(id);
        let name = name.and_then(|name| names::identifier(names::without_kind(&name)));
        name.unwrap_or_else(|| format!("{kind}_{id}").into())
    }

    // The pointee is named, not read: a node of a linked list points to its own type. One that is
    // no structure has no block.
    fn pointee_name(&self, pointee: Id) -> Arc<str> {
        match self.module.types.get(&pointee).map(|found| found.opcode) {
            Some(op::TYPE_STRUCT) | None => self.structure_name(pointee, "block"),
            Some(_) => "uint64_t".into(),
        }
    }

    fn structure(
        &mut self,
        id: Id,
        instruction: Instruction<'w>,
        depth: u32,
    ) -> Result<Option<TypedMember>, NoLayout> {
        let (members, tree) = self.members(id, instruction, depth)?;
        if members.is_empty() {
            return Ok(None);
        }
        let span = span_of(instruction, 0);
        let structure = Struct::new(self.structure_name(id, "struct"), members, Vec::new(), span);
        Ok(Some(TypedMember { ty: Type::Struct(Arc::new(structure)), tree }))
    }

    /// Returns the members of a structure, without those that take no bytes, and what they take
    /// altogether.
    pub(super) fn members(
        &mut self,
        structure: Id,
        instruction: Instruction<'w>,
        depth: u32,
    ) -> Result<(Vec<Member>, u64), NoLayout> {
        let types = &instruction.operands[1..];
        let of_module = |index: u32| {
            let name = self.module.member_name(structure, index);
            let name = name.and_then(|name| names::identifier(&name));
            name.unwrap_or_else(|| format!("member_{index}").into())
        };
        let names = names::distinct((0..types.len() as u32).map(of_module).collect());
        let (mut members, mut tree) = (Vec::with_capacity(types.len()), 0u64);
        // A structure in several blocks is read through `members` for each; its lengths are
        // recorded once.
        let is_new = self.noted.insert(structure);
        for ((index, &ty), name) in (0u32..).zip(types).zip(names) {
            let typed = self.read(ty, depth + 1).map_err(|fault| fault.within(&name))?;
            let Some(typed) = typed else { continue };
            let span = span_of(instruction, index as usize + 1);
            let decorations = self.module.member_decorations(structure, index);
            let place = self.place(ty, &typed.ty, decorations, is_new.then_some(span));
            let place = place.map_err(|reason| NoLayout::from(reason).within(&name))?;
            // 3 for a `[0]` or a dot. The sum grows with the leaves, of which structures in
            // structures have exponentially many: they are refused before anybody lists them.
            let path = name.len() as u64 + 3;
            tree = tree
                .saturating_add(typed.tree)
                .saturating_add(typed.ty.leaves().saturating_mul(path))
                .saturating_add(MEMBER_BYTES);
            check_tree(tree)?;
            members.push(Member {
                matrix_layout: decorations.matrix_layout,
                place: Some(place),
                ..Member::unqualified(name, typed.ty, span)
            });
        }
        Ok((members, tree))
    }

    /// Returns the numbers that the module gives a member, and records the specialisation constants of
    /// its lengths for a span.
    // Offset, ArrayStride of each dimension from the outermost, MatrixStride (§3.20). Strides
    // decorate the array types, MatrixStride and the order of a matrix the member.
    fn place(
        &mut self,
        mut id: Id,
        ty: &Type,
        decorations: Decorations,
        span: Option<Span>,
    ) -> Result<MemberPlace, String> {
        let offset = decorations.offset.ok_or("has no Offset")?;
        let mut strides = Vec::new();
        loop {
            let instruction = self.instruction(id)?;
            match (instruction.opcode, &instruction.operands[1..]) {
                (op::TYPE_ARRAY, [element, length, ..]) => {
                    let length = self.length(*length)?;
                    if let Some(span) = span {
                        self.note_specialised(&length, span);
                    }
                    strides.push(self.array_stride(id)?);
                    id = *element;
                }
                (op::TYPE_RUNTIME_ARRAY, [element, ..]) => {
                    strides.push(self.array_stride(id)?);
                    id = *element;
                }
                _ => break,
            }
        }
        let is_matrix = matches!(ty.innermost(), Type::Matrix { .. });
        let matrix_stride = match decorations.matrix_stride {
            Some(stride) if is_matrix => Some(u64::from(stride)),
            None if is_matrix => return Err("is a matrix without a MatrixStride".to_string()),
            Some(_) | None => None,
        };
        Ok(MemberPlace { offset: offset.into(), strides, matrix_stride })
    }

    fn array_stride(&self, id: Id) -> Result<u64, String> {
        let stride = self.module.decorations(id).array_stride;
        Ok(stride.ok_or("is an array without an ArrayStride")?.into())
    }

    fn note_specialised(&mut self, length: &ArrayLength, member: Span) {
        if length.depends_on.is_empty() {
            return;
        }
        let overrides = self.module.constants.overrides();
        let constants =
            length.depends_on.iter().map(|index| Arc::clone(&overrides[*index].name)).collect();
        let given = length.given.and_then(|given| u32::try_from(given).ok());
        self.specialised.push(SpecialisedLength { member, constants, given });
    }
}

/// Refuses members that take more than 64 MiB altogether.
pub(super) fn check_tree(tree: u64) -> Result<(), NoLayout> {
    if tree > LARGEST_TREE {
        return Err("has more members than landfall lays out".into());
    }
    Ok(())
}

/// The bytes of an operand of an instruction in the module: its place, as there is no text.
// The first word of an instruction is its opcode, hence one more than the operand's index.
fn span_of(instruction: Instruction<'_>, operand: usize) -> Span {
    let at = |words: usize| u32::try_from((instruction.at + words) * 4).unwrap_or(u32::MAX);
    Span { file: 0, start: at(operand + 1), end: at(operand + 2) }
}

fn scalar(instruction: Instruction<'_>) -> Result<Scalar, String> {
    let of = |kind, width: u32| Ok(Scalar { kind, width: (width / 8) as u8 });
    match (instruction.opcode, &instruction.operands[1..]) {
        (op::TYPE_INT, [width @ (8 | 16 | 32 | 64), sign, ..]) => {
            of(if *sign == 1 { ScalarKind::Sint } else { ScalarKind::Uint }, *width)
        }
        (op::TYPE_FLOAT, [width @ (16 | 32 | 64)]) => of(ScalarKind::Float, *width),
        // FP Encoding: SPV_KHR_bfloat16, SPV_EXT_float8.
        (op::TYPE_FLOAT, [16, 0]) => of(ScalarKind::Bfloat, 16),
        (op::TYPE_FLOAT, [8, 4214]) => of(ScalarKind::FloatE4m3, 8),
        (op::TYPE_FLOAT, [8, 4215]) => of(ScalarKind::FloatE5m2, 8),
        (opcode, operands) => Err(format!(
            "has a component that landfall does not know: opcode {opcode} {operands:?}"
        )),
    }
}
