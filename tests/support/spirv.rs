//! Reads the layout of every block out of a SPIR-V binary: the decorations
//! themselves, not a tool's rendering of them. Fed by `glslang`.
//!
//! Only what a layout needs is kept: types, names, decorations, constants
//! used as array lengths and block variables. Numbers in comments are
//! sections of the SPIR-V specification.

use std::collections::{HashMap, HashSet};

use super::leaf::{OracleBlock, OracleLeaf};

type Id = u32;

#[derive(Clone, Debug)]
enum Type {
    Bool,
    Int { width: u32, signed: bool },
    Float { width: u32 },
    Vector { component: Id, count: u32 },
    Matrix { column: Id, columns: u32 },
    Array { element: Id, length: Id },
    RuntimeArray { element: Id },
    Struct { members: Vec<Id> },
    Pointer { pointee: Id },
}

#[derive(Default)]
struct Module {
    names: HashMap<Id, String>,
    member_names: HashMap<(Id, u32), String>,
    types: HashMap<Id, Type>,
    constants: HashMap<Id, u64>,
    blocks: HashSet<Id>,
    array_strides: HashMap<Id, u64>,
    offsets: HashMap<(Id, u32), u64>,
    matrix_strides: HashMap<(Id, u32), u64>,
    row_major: HashSet<(Id, u32)>,
    /// Pointer types of block variables, in order of declaration.
    variables: Vec<Id>,
    /// Pointees of physical storage buffer pointers (buffer references).
    references: Vec<Id>,
}

/// Every block of a module in order of declaration; blocks reached only
/// through a buffer reference come last.
pub fn blocks(words: &[u32]) -> Result<Vec<OracleBlock>, String> {
    let module = read(words)?;
    let mut found = Vec::new();
    let mut listed = HashSet::new();
    for pointer in &module.variables {
        let Some(Type::Pointer { pointee }) = module.types.get(pointer) else {
            return Err(format!("variable of type %{pointer}, which is no pointer"));
        };
        let mut count = Vec::new();
        let mut ty = *pointee;
        while let Some((element, length)) = module.element(ty)? {
            count.push(length);
            ty = element;
        }
        if module.blocks.contains(&ty) {
            listed.insert(ty);
            found.push(module.block(ty, count)?);
        }
    }
    for &ty in &module.references {
        if module.blocks.contains(&ty) && listed.insert(ty) {
            found.push(module.block(ty, Vec::new())?);
        }
    }
    Ok(found)
}

impl Module {
    fn block(&self, ty: Id, count: Vec<Option<u64>>) -> Result<OracleBlock, String> {
        let mut leaves = Vec::new();
        let ty = self.unwrapped(ty);
        self.members(ty, "", 0, &[], &[], &mut leaves)?;
        Ok(OracleBlock {
            name: self.names.get(&ty).cloned().unwrap_or_default(),
            count,
            size: None,
            data_size: None,
            leaves,
        })
    }

    /// naga puts a block inside a structure of one member without a name.
    fn unwrapped(&self, ty: Id) -> Id {
        match self.types.get(&ty) {
            Some(Type::Struct { members }) if members.len() == 1 => {
                let named = self.member_names.contains_key(&(ty, 0));
                let inner = matches!(self.types.get(&members[0]), Some(Type::Struct { .. }));
                if !named && inner { members[0] } else { ty }
            }
            _ => ty,
        }
    }

    fn members(
        &self,
        structure: Id,
        prefix: &str,
        base: u64,
        dims: &[Option<u64>],
        strides: &[Option<u64>],
        leaves: &mut Vec<OracleLeaf>,
    ) -> Result<(), String> {
        let Some(Type::Struct { members }) = self.types.get(&structure) else {
            return Err(format!("%{structure} is no structure"));
        };
        for (index, &member) in (0u32..).zip(members) {
            let key = (structure, index);
            let name = self
                .member_names
                .get(&key)
                .ok_or_else(|| format!("member {index} of %{structure} has no name"))?;
            let offset =
                self.offsets.get(&key).ok_or_else(|| format!("`{prefix}{name}` has no Offset"))?;
            let mut path = format!("{prefix}{name}");
            let (mut dims, mut strides) = (dims.to_vec(), strides.to_vec());
            let mut ty = member;
            while let Some((element, length)) = self.element(ty)? {
                let stride = self
                    .array_strides
                    .get(&ty)
                    .ok_or_else(|| format!("`{path}` has no ArrayStride"))?;
                path.push_str("[]");
                dims.push(length);
                strides.push(Some(*stride));
                ty = element;
            }
            if let Some(Type::Struct { .. }) = self.types.get(&ty) {
                let prefix = format!("{path}.");
                self.members(ty, &prefix, base + offset, &dims, &strides, leaves)?;
                continue;
            }
            leaves.push(OracleLeaf {
                ty: self.word(ty)?,
                offset: base + offset,
                dims,
                strides,
                matrix_stride: self.matrix_strides.get(&key).copied(),
                row_major: self.row_major.contains(&key),
                path,
            });
        }
        Ok(())
    }

    /// The element type and length of an array; `None` for anything else.
    fn element(&self, ty: Id) -> Result<Option<(Id, Option<u64>)>, String> {
        match self.types.get(&ty) {
            Some(Type::Array { element, length }) => {
                let length = self
                    .constants
                    .get(length)
                    .ok_or_else(|| format!("array length %{length} is no constant read here"))?;
                Ok(Some((*element, Some(*length))))
            }
            Some(Type::RuntimeArray { element }) => Ok(Some((*element, None))),
            Some(_) => Ok(None),
            None => Err(format!("%{ty} is no type read here")),
        }
    }

    /// GLSL's word for a leaf's type.
    fn word(&self, ty: Id) -> Result<String, String> {
        let known = self.types.get(&ty).ok_or_else(|| format!("%{ty} is no type read here"))?;
        Ok(match known {
            Type::Bool => "bool".to_owned(),
            Type::Int { width: 32, signed: true } => "int".to_owned(),
            Type::Int { width: 32, signed: false } => "uint".to_owned(),
            Type::Int { width, signed: true } => format!("int{width}_t"),
            Type::Int { width, signed: false } => format!("uint{width}_t"),
            Type::Float { width: 32 } => "float".to_owned(),
            Type::Float { width: 64 } => "double".to_owned(),
            Type::Float { width } => format!("float{width}_t"),
            Type::Vector { component, count } => {
                format!("{}vec{count}", prefix(&self.word(*component)?)?)
            }
            Type::Matrix { column, columns } => {
                let Some(Type::Vector { component, count }) = self.types.get(column) else {
                    return Err(format!("%{column} is no column vector"));
                };
                let prefix = prefix(&self.word(*component)?)?;
                if columns == count {
                    format!("{prefix}mat{columns}")
                } else {
                    format!("{prefix}mat{columns}x{count}")
                }
            }
            Type::Pointer { .. } => "reference".to_owned(),
            Type::Array { .. } | Type::RuntimeArray { .. } | Type::Struct { .. } => {
                return Err(format!("%{ty} is no leaf"));
            }
        })
    }
}

/// The letter before `vec` and `mat` for a component type.
fn prefix(component: &str) -> Result<&'static str, String> {
    Ok(match component {
        "float" => "",
        "double" => "d",
        "int" => "i",
        "uint" => "u",
        "bool" => "b",
        "float16_t" => "f16",
        "int8_t" => "i8",
        "uint8_t" => "u8",
        "int16_t" => "i16",
        "uint16_t" => "u16",
        "int64_t" => "i64",
        "uint64_t" => "u64",
        other => return Err(format!("no vector of `{other}`")),
    })
}

// 3.7 Storage Class
const UNIFORM: u32 = 2;
const PUSH_CONSTANT: u32 = 9;
const STORAGE_BUFFER: u32 = 12;
const PHYSICAL_STORAGE_BUFFER: u32 = 5349;

fn read(words: &[u32]) -> Result<Module, String> {
    if words.first() != Some(&0x0723_0203) {
        return Err("not a SPIR-V module".to_owned());
    }
    let mut module = Module::default();
    let mut rest = words.get(5..).ok_or("a SPIR-V header is five words")?;
    while let Some(&first) = rest.first() {
        let (count, opcode) = ((first >> 16) as usize, first & 0xffff);
        if count == 0 || count > rest.len() {
            return Err(format!("instruction {opcode} runs past the end"));
        }
        let (instruction, tail) = rest.split_at(count);
        instruction_of(opcode, &instruction[1..], &mut module)?;
        rest = tail;
    }
    Ok(module)
}

/// 3.42 Instructions; `w` are the operands.
fn instruction_of(opcode: u32, w: &[u32], module: &mut Module) -> Result<(), String> {
    match opcode {
        // OpName, OpMemberName
        5 => drop(module.names.insert(w[0], text(&w[1..]))),
        6 => drop(module.member_names.insert((w[0], w[1]), text(&w[2..]))),
        // OpTypeBool, OpTypeInt, OpTypeFloat, OpTypeVector, OpTypeMatrix
        20 => drop(module.types.insert(w[0], Type::Bool)),
        21 => drop(module.types.insert(w[0], Type::Int { width: w[1], signed: w[2] == 1 })),
        22 => drop(module.types.insert(w[0], Type::Float { width: w[1] })),
        23 => drop(module.types.insert(w[0], Type::Vector { component: w[1], count: w[2] })),
        24 => drop(module.types.insert(w[0], Type::Matrix { column: w[1], columns: w[2] })),
        // OpTypeArray, OpTypeRuntimeArray, OpTypeStruct, OpTypePointer
        28 => drop(module.types.insert(w[0], Type::Array { element: w[1], length: w[2] })),
        29 => drop(module.types.insert(w[0], Type::RuntimeArray { element: w[1] })),
        30 => drop(module.types.insert(w[0], Type::Struct { members: w[1..].to_vec() })),
        32 => {
            if w[1] == PHYSICAL_STORAGE_BUFFER {
                module.references.push(w[2]);
            }
            module.types.insert(w[0], Type::Pointer { pointee: w[2] });
        }
        // OpConstant, OpSpecConstant: low word first
        43 | 50 => {
            let high = w.get(3).copied().unwrap_or(0);
            module.constants.insert(w[1], u64::from(w[2]) | u64::from(high) << 32);
        }
        // OpSpecConstantOp: the arithmetic that array lengths are written with
        52 => {
            let operand = |at: usize| module.constants.get(w.get(at)?).copied();
            if let (Some(a), Some(b)) = (operand(3), operand(4)) {
                let value = match w[2] {
                    128 => a.checked_add(b),
                    130 => a.checked_sub(b),
                    132 => a.checked_mul(b),
                    134 | 135 => a.checked_div(b),
                    _ => None,
                };
                if let Some(value) = value {
                    module.constants.insert(w[1], value);
                }
            }
        }
        // OpVariable
        59 if [UNIFORM, PUSH_CONSTANT, STORAGE_BUFFER].contains(&w[2]) => {
            module.variables.push(w[0]);
        }
        // OpDecorate: Block, BufferBlock, ArrayStride (3.20)
        71 => match w[1] {
            2 | 3 => drop(module.blocks.insert(w[0])),
            6 => drop(module.array_strides.insert(w[0], u64::from(w[2]))),
            _ => {}
        },
        // OpMemberDecorate: RowMajor, MatrixStride, Offset
        72 => match w[2] {
            4 => drop(module.row_major.insert((w[0], w[1]))),
            7 => drop(module.matrix_strides.insert((w[0], w[1]), u64::from(w[3]))),
            35 => drop(module.offsets.insert((w[0], w[1]), u64::from(w[3]))),
            _ => {}
        },
        _ => {}
    }
    Ok(())
}

/// 2.2.1: UTF-8, little-endian in each word, ended by a zero byte.
fn text(words: &[u32]) -> String {
    let bytes: Vec<u8> =
        words.iter().flat_map(|w| w.to_le_bytes()).take_while(|&b| b != 0).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}
