//! The member offsets of SPIR-V by a third-party compiler, from the module's decorations.
//!
//! Parses names, types and decorations only (SPIR-V 1.6 §2.3, §3.20); [`verify`](super::verify)
//! compares them with the layout.

use rustc_hash::FxHashMap;

use crate::backend::Failure;
use crate::backend::reflection::{ReflectedBlock, ReflectedMember, Reflection};

const MAGIC: u32 = 0x0723_0203;

/// Maximum nesting of structures and arrays, and maximum number of members of a block.
const DEEPEST: u32 = 128;
const MAX_MEMBERS: usize = 100_000;

/// A type with the properties that matter for layout.
#[derive(Clone, Debug)]
enum SpirvType {
    Leaf,
    Matrix,
    Array { element: u32, length: Option<u32> },
    Struct(Vec<u32>),
    Pointer(u32),
}

/// The declarations of a module, by id.
#[derive(Default)]
struct SpirvModule {
    names: FxHashMap<u32, String>,
    member_names: FxHashMap<(u32, u32), String>,
    types: FxHashMap<u32, SpirvType>,
    constants: FxHashMap<u32, u32>,
    strides: FxHashMap<u32, u32>,
    offsets: FxHashMap<(u32, u32), u32>,
    matrix_strides: FxHashMap<(u32, u32), u32>,
    row_major: FxHashMap<(u32, u32), bool>,
    /// The decoration `BufferBlock`, which marked storage blocks before SPIR-V 1.3.
    buffer_blocks: FxHashMap<u32, bool>,
    bindings: FxHashMap<u32, u32>,
    /// Variables: id, pointer type, storage class.
    variables: Vec<(u32, u32, u32)>,
}

/// Returns the words of a SPIR-V file.
///
/// # Errors
/// Fails if the file is no SPIR-V.
pub fn words(bytes: &[u8]) -> Result<Vec<u32>, Failure> {
    let words = bytes.chunks_exact(4);
    // The header has five words.
    if bytes.len() < 20 || !words.remainder().is_empty() {
        return Err(Failure::refused(
            "is not SPIR-V: it is too short, or its size is not a multiple of 4 bytes",
            "",
        ));
    }
    let words: Vec<u32> =
        words.map(|b| u32::from_le_bytes(b.try_into().expect("chunks of four"))).collect();
    match words[0] {
        MAGIC => Ok(words),
        // The magic number tells the byte order.
        swapped if swapped.swap_bytes() == MAGIC => {
            Ok(words.into_iter().map(u32::swap_bytes).collect())
        }
        other => Err(Failure::refused(
            format!("is not SPIR-V: it begins with 0x{other:08x}, not 0x{MAGIC:08x}"),
            "",
        )),
    }
}

/// Returns every uniform and storage block of a module, its members down to scalars, vectors and
/// matrices.
///
/// # Errors
/// Fails if the words are no SPIR-V, or end within an instruction.
pub fn reflect(words: &[u32]) -> Result<Reflection, Failure> {
    let module = read(words)?;
    let mut reflection =
        Reflection { uniform_blocks: Vec::new(), storage_blocks: Vec::new(), uniforms: Vec::new() };
    for &(id, pointer, class) in &module.variables {
        // Uniform, PushConstant and StorageBuffer (§3.7).
        if ![2, 9, 12].contains(&class) {
            continue;
        }
        let Some(SpirvType::Pointer(mut ty)) = module.types.get(&pointer).cloned() else {
            continue;
        };
        // An array of blocks.
        while let Some(SpirvType::Array { element, .. }) = module.types.get(&ty) {
            ty = *element;
        }
        let Some(SpirvType::Struct(_)) = module.types.get(&ty) else { continue };
        let mut block = ReflectedBlock {
            name: module.names.get(&ty).cloned().unwrap_or_default(),
            binding: module.bindings.get(&id).copied().unwrap_or(0),
            size: 0,
            members: Vec::new(),
        };
        let place = BlockPosition { path: String::new(), offset: 0, matrix: (0, false) };
        module.walk(ty, place, 0, &mut block.members)?;
        let storage = class == 12 || module.buffer_blocks.contains_key(&ty);
        if storage { &mut reflection.storage_blocks } else { &mut reflection.uniform_blocks }
            .push(block);
    }
    Ok(reflection)
}

/// A position within a block: path, byte, and how a matrix there is stored.
struct BlockPosition {
    path: String,
    offset: u64,
    matrix: (u32, bool),
}

impl SpirvModule {
    fn walk(
        &self,
        ty: u32,
        at: BlockPosition,
        depth: u32,
        members: &mut Vec<ReflectedMember>,
    ) -> Result<(), Failure> {
        // In a file that is not valid, types may contain each other.
        if depth > DEEPEST || members.len() > MAX_MEMBERS {
            return Err(Failure::refused("the module's types nest too deeply or are too many", ""));
        }
        match self.types.get(&ty) {
            Some(SpirvType::Struct(parts)) => {
                for (nth, part) in parts.iter().enumerate() {
                    let key = (ty, nth as u32);
                    let name = self.member_names.get(&key).cloned().unwrap_or_default();
                    let dot = if at.path.is_empty() { "" } else { "." };
                    let own = self.offsets.get(&key).copied().unwrap_or(0);
                    let place = BlockPosition {
                        path: format!("{}{dot}{name}", at.path),
                        offset: at.offset + u64::from(own),
                        // These decorate the member, also where it is an array of matrices: SPIR-V
                        // §3.20.
                        matrix: (
                            self.matrix_strides.get(&key).copied().unwrap_or(0),
                            self.row_major.contains_key(&key),
                        ),
                    };
                    self.walk(*part, place, depth + 1, members)?;
                }
            }
            Some(SpirvType::Array { element, length }) => {
                let stride = self.strides.get(&ty).copied().unwrap_or(0);
                let inner = self.types.get(element);
                let place = |index: u32| BlockPosition {
                    path: format!("{}[{index}]", at.path),
                    offset: at.offset + u64::from(index) * u64::from(stride),
                    matrix: at.matrix,
                };
                let before = members.len();
                self.walk(*element, place(0), depth + 1, members)?;
                let is_leaf = matches!(inner, Some(SpirvType::Leaf | SpirvType::Matrix));
                if is_leaf {
                    for member in &mut members[before..] {
                        member.array_stride = stride.into();
                        member.array_size = length.map(u64::from);
                    }
                } else if *length != Some(1) {
                    // The second element reveals the stride.
                    self.walk(*element, place(1), depth + 1, members)?;
                }
            }
            Some(SpirvType::Leaf | SpirvType::Matrix) => members.push(ReflectedMember {
                name: at.path,
                ty: String::new(),
                offset: at.offset,
                array_size: Some(1),
                array_stride: 0,
                matrix_stride: at.matrix.0.into(),
                row_major: at.matrix.1,
                top_level: None,
            }),
            Some(SpirvType::Pointer(_)) | None => {}
        }
        Ok(())
    }
}

fn read(words: &[u32]) -> Result<SpirvModule, Failure> {
    if words.len() < 5 || words[0] != MAGIC {
        return Err(Failure::refused("the data is not SPIR-V", ""));
    }
    let mut module = SpirvModule::default();
    let mut rest = &words[5..];
    while let Some(&first) = rest.first() {
        let (opcode, length) = (first & 0xffff, (first >> 16) as usize);
        if length == 0 || length > rest.len() {
            return Err(Failure::refused("the module ends within an instruction", ""));
        }
        module.instruction(opcode, &rest[1..length]);
        rest = &rest[length..];
    }
    Ok(module)
}

impl SpirvModule {
    /// Parses an instruction; opcodes and decorations are numbered in §3.20 and §3.52.
    fn instruction(&mut self, opcode: u32, operands: &[u32]) {
        match (opcode, operands) {
            // OpName, OpMemberName.
            (5, [id, name @ ..]) => {
                self.names.insert(*id, text(name));
            }
            (6, [id, member, name @ ..]) => {
                self.member_names.insert((*id, *member), text(name));
            }
            // OpTypeBool, OpTypeInt, OpTypeFloat, OpTypeVector.
            (20..=23, [id, ..]) => {
                self.types.insert(*id, SpirvType::Leaf);
            }
            // OpTypeMatrix, OpTypeArray, OpTypeRuntimeArray, OpTypeStruct, OpTypePointer.
            (24, [id, ..]) => {
                self.types.insert(*id, SpirvType::Matrix);
            }
            (28, [id, element, length]) => {
                let length = self.constants.get(length).copied();
                self.types.insert(*id, SpirvType::Array { element: *element, length });
            }
            (29, [id, element]) => {
                self.types.insert(*id, SpirvType::Array { element: *element, length: None });
            }
            (30, [id, parts @ ..]) => {
                self.types.insert(*id, SpirvType::Struct(parts.to_vec()));
            }
            (32, [id, _class, ty]) => {
                self.types.insert(*id, SpirvType::Pointer(*ty));
            }
            // OpConstant, OpSpecConstant.
            (43 | 50, [_ty, id, value, ..]) => {
                self.constants.insert(*id, *value);
            }
            // OpVariable.
            (59, [ty, id, class, ..]) => self.variables.push((*id, *ty, *class)),
            // OpDecorate: BufferBlock, ArrayStride, Binding.
            (71, [id, 3]) => {
                self.buffer_blocks.insert(*id, true);
            }
            (71, [id, 6, stride]) => {
                self.strides.insert(*id, *stride);
            }
            (71, [id, 33, binding]) => {
                self.bindings.insert(*id, *binding);
            }
            // OpMemberDecorate: RowMajor, MatrixStride, Offset.
            (72, [id, member, 4]) => {
                self.row_major.insert((*id, *member), true);
            }
            (72, [id, member, 7, stride]) => {
                self.matrix_strides.insert((*id, *member), *stride);
            }
            (72, [id, member, 35, offset]) => {
                self.offsets.insert((*id, *member), *offset);
            }
            _ => {}
        }
    }
}

/// Returns a SPIR-V string: UTF-8 in words, the low byte first, zero-terminated.
fn text(words: &[u32]) -> String {
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}
