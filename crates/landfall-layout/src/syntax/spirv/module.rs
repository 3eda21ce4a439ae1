//! The tables of a module that a layout needs: types, constants, names, decorations, variables.

use rustc_hash::FxHashMap;

use super::constants::ConstantTable;
use super::words::{HEADER_WORDS, Id, Instruction, class, instructions, op, text};
use crate::shape::MatrixLayout;
use crate::source::{ReadOptions, Stage};

/// The limit on ids, SPIR-V 1.6 §2.17.
const LARGEST_BOUND: u32 = 0x3f_ffff;

/// The decorations of §3.20 on an id or a member that a layout needs.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Decorations {
    pub block: bool,
    pub buffer_block: bool,
    pub matrix_layout: Option<MatrixLayout>,
    pub array_stride: Option<u32>,
    pub matrix_stride: Option<u32>,
    pub offset: Option<u32>,
    pub binding: Option<u32>,
    pub group: Option<u32>,
    pub spec_id: Option<u32>,
    /// The group whose decorations it has as well.
    decorated_by: Option<Id>,
}

/// A variable outside functions.
#[derive(Clone, Copy, Debug)]
pub(super) struct ModuleVariable {
    pub id: Id,
    /// The id of its type, a pointer.
    pub pointer: Id,
    pub storage: u32,
}

pub(super) struct Module<'w> {
    /// The instruction of each type.
    pub types: FxHashMap<Id, Instruction<'w>>,
    pub constants: ConstantTable<'w>,
    pub variables: Vec<ModuleVariable>,
    /// The types that pointers into physical storage point to, in order.
    pub pointees: Vec<Id>,
    names: FxHashMap<Id, &'w [u32]>,
    member_names: FxHashMap<(Id, u32), &'w [u32]>,
    decorations: FxHashMap<Id, Decorations>,
    member_decorations: FxHashMap<(Id, u32), Decorations>,
    /// The execution models of the entry points, §3.3.
    models: Vec<u32>,
}

/// Reads the tables of a module.
///
/// # Errors
/// A header or an instruction that is not whole, an id past the bound, a kernel of OpenCL.
pub(super) fn read<'w>(words: &'w [u32], options: &ReadOptions) -> Result<Module<'w>, String> {
    let [_, version, _, bound, _] = words.first_chunk::<HEADER_WORDS>().ok_or_else(|| {
        format!("the module is {} words long, but its header has {HEADER_WORDS}", words.len())
    })?;
    // §2.3: 0 | major | minor | 0.
    let (major, minor) = (version >> 16, version >> 8 & 0xff);
    if major != 1 {
        return Err(format!("the module is of SPIR-V {major}.{minor}, but landfall reads 1.x"));
    }
    if *bound == 0 || *bound > LARGEST_BOUND {
        return Err(format!("the bound of ids is {bound}, but it is 1 to {LARGEST_BOUND}"));
    }
    let mut module = Module {
        types: FxHashMap::default(),
        constants: ConstantTable::new(&options.overrides),
        variables: Vec::new(),
        pointees: Vec::new(),
        names: FxHashMap::default(),
        member_names: FxHashMap::default(),
        decorations: FxHashMap::default(),
        member_decorations: FxHashMap::default(),
        models: Vec::new(),
    };
    // §2.4 fixes the order: memory model, entry points, names, decorations, then types, constants
    // and variables as they need each other, functions last. So one pass suffices, and the name and
    // SpecId of a constant are known when it comes. Types may refer forward by pointers only; they
    // are looked up when all are known.
    for instruction in instructions(words) {
        let instruction = instruction?;
        // What follows is code: no type, constant or variable of a block is declared there.
        if instruction.opcode == op::FUNCTION {
            break;
        }
        let whole = module.add(instruction, *bound);
        whole.ok_or_else(|| {
            let Instruction { opcode, at, .. } = instruction;
            format!("the instruction at word {at}, of opcode {opcode}, lacks operands or has an id past the bound")
        })??;
    }
    // The rest has to be whole as well: a module that is cut off is not the one that runs.
    match instructions(words).find_map(Result::err) {
        Some(broken) => Err(broken),
        None => Ok(module),
    }
}

impl<'w> Module<'w> {
    /// Adds an instruction; `None` if it lacks operands, or has an id past the bound.
    // Operands that are ids are checked against the bound where they become keys of a table; others
    // are looked up in these tables, which do not have what is out of bounds.
    fn add(&mut self, instruction: Instruction<'w>, bound: u32) -> Option<Result<(), String>> {
        let operand = |index: usize| instruction.operands.get(index).copied();
        let id = |index: usize| operand(index).filter(|id| *id > 0 && *id < bound);
        match instruction.opcode {
            op::NAME => drop(self.names.insert(id(0)?, &instruction.operands[1..])),
            op::MEMBER_NAME => {
                let key = (id(0)?, operand(1)?);
                self.member_names.insert(key, &instruction.operands[2..]);
            }
            op::MEMORY_MODEL => return Some(refuse_kernel(operand(0)?, operand(1)?)),
            op::ENTRY_POINT => self.models.push(operand(0)?),
            // A reference to a buffer needs no variable, so its block is found by the pointer type.
            op::TYPE_POINTER => {
                if operand(1)? == class::PHYSICAL_STORAGE_BUFFER {
                    self.pointees.push(id(2)?);
                }
                self.types.insert(id(0)?, instruction);
            }
            op::TYPE_VOID..=op::TYPE_FUNCTION => drop(self.types.insert(id(0)?, instruction)),
            op::CONSTANT_TRUE..=op::SPEC_CONSTANT_OP => {
                id(0)?;
                let constant = id(1)?;
                let spec_id = self.decorations(constant).spec_id;
                let name = self.name(constant);
                self.constants.add(&self.types, instruction, name, spec_id)?;
            }
            op::VARIABLE => {
                let variable = ModuleVariable { pointer: id(0)?, id: id(1)?, storage: operand(2)? };
                self.variables.push(variable);
            }
            op::DECORATE => {
                let target = self.decorations.entry(id(0)?).or_default();
                target.add(&instruction.operands[1..])?;
            }
            op::MEMBER_DECORATE => {
                let target = self.member_decorations.entry((id(0)?, operand(1)?)).or_default();
                target.add(&instruction.operands[2..])?;
            }
            // Deprecated, but in modules of old compilers. The decorations are resolved when they
            // are asked for.
            op::GROUP_DECORATE => {
                let group = id(0)?;
                for target in &instruction.operands[1..] {
                    self.decorations.entry(*target).or_default().decorated_by = Some(group);
                }
            }
            op::GROUP_MEMBER_DECORATE => {
                let group = id(0)?;
                for target in instruction.operands[1..].as_chunks::<2>().0 {
                    let of_member = self.member_decorations.entry((target[0], target[1]));
                    of_member.or_default().decorated_by = Some(group);
                }
            }
            op::UNTYPED_VARIABLE => {
                let message = "the module has untyped pointers (SPV_KHR_untyped_pointers), which \
                               landfall does not read";
                return Some(Err(message.to_string()));
            }
            _ => {}
        }
        Some(Ok(()))
    }

    /// The name of an id; `None` without one, or if it is empty.
    pub(super) fn name(&self, id: Id) -> Option<String> {
        self.names.get(&id).map(|words| text(words)).filter(|name| !name.is_empty())
    }

    /// The name of a member; `None` without one, or if it is empty.
    pub(super) fn member_name(&self, structure: Id, index: u32) -> Option<String> {
        let words = self.member_names.get(&(structure, index));
        words.map(|words| text(words)).filter(|name| !name.is_empty())
    }

    pub(super) fn decorations(&self, id: Id) -> Decorations {
        self.with_group(self.decorations.get(&id).copied().unwrap_or_default())
    }

    pub(super) fn member_decorations(&self, structure: Id, index: u32) -> Decorations {
        let own = self.member_decorations.get(&(structure, index));
        self.with_group(own.copied().unwrap_or_default())
    }

    // One level is enough: a group is not the target of a group (OpGroupDecorate).
    fn with_group(&self, own: Decorations) -> Decorations {
        match own.decorated_by.and_then(|group| self.decorations.get(&group)) {
            None => own,
            Some(group) => Decorations {
                block: own.block || group.block,
                buffer_block: own.buffer_block || group.buffer_block,
                matrix_layout: own.matrix_layout.or(group.matrix_layout),
                array_stride: own.array_stride.or(group.array_stride),
                matrix_stride: own.matrix_stride.or(group.matrix_stride),
                offset: own.offset.or(group.offset),
                binding: own.binding.or(group.binding),
                group: own.group.or(group.group),
                spec_id: own.spec_id.or(group.spec_id),
                decorated_by: None,
            },
        }
    }

    /// The stage of the entry points, if they are of one.
    pub(super) fn stage(&self) -> Option<Stage> {
        let first = *self.models.first()?;
        let is_one = self.models.iter().all(|model| *model == first);
        let known = STAGES.iter().find(|(model, _)| is_one && *model == first);
        known.map(|(_, stage)| *stage)
    }
}

/// The execution models of §3.3 that are stages; those of task and mesh have an earlier form of a
/// vendor each.
const STAGES: &[(u32, Stage)] = &[
    (0, Stage::Vertex),
    (1, Stage::TessellationControl),
    (2, Stage::TessellationEvaluation),
    (3, Stage::Geometry),
    (4, Stage::Fragment),
    (5, Stage::Compute),
    (5267, Stage::Task),
    (5268, Stage::Mesh),
    (5313, Stage::RayGeneration),
    (5314, Stage::Intersection),
    (5315, Stage::AnyHit),
    (5316, Stage::ClosestHit),
    (5317, Stage::Miss),
    (5318, Stage::Callable),
    (5364, Stage::Task),
    (5365, Stage::Mesh),
];

/// Refuses a module whose pointers are plain addresses, §3.4, or whose memory model is OpenCL's, §3.5.
fn refuse_kernel(addressing: u32, memory: u32) -> Result<(), String> {
    match (addressing, memory) {
        (1 | 2, _) | (_, 2) => Err(
            "the module is a kernel of OpenCL, whose buffers have no blocks and no layouts in SPIR-V"
                .to_string(),
        ),
        _ => Ok(()),
    }
}

impl Decorations {
    /// Adds a decoration, given as the words from its number; `None` if it lacks its operand.
    fn add(&mut self, words: &[u32]) -> Option<()> {
        let value = || words.get(1).copied();
        match words.first()? {
            1 => self.spec_id = Some(value()?),
            2 => self.block = true,
            3 => self.buffer_block = true,
            4 => self.matrix_layout = Some(MatrixLayout::Row),
            5 => self.matrix_layout = Some(MatrixLayout::Column),
            6 => self.array_stride = Some(value()?),
            7 => self.matrix_stride = Some(value()?),
            33 => self.binding = Some(value()?),
            34 => self.group = Some(value()?),
            35 => self.offset = Some(value()?),
            _ => {}
        }
        Some(())
    }
}
