//! A module's words as instructions, and the numbers in them.

/// A result id: §2.2.
pub(super) type Id = u32;

/// An instruction: SPIR-V 1.6 §2.3.
#[derive(Clone, Copy, Debug)]
pub(super) struct Instruction<'w> {
    pub opcode: u16,
    /// The words after the first.
    pub operands: &'w [u32],
    /// The index of its first word in the module.
    pub at: usize,
}

/// The instructions after the header. An instruction that does not end in the module, or that has no
/// words, is the last item.
// §2.3: the high half of the first word is the number of words, the low half the opcode.
pub(super) fn instructions(words: &[u32]) -> impl Iterator<Item = Result<Instruction<'_>, String>> {
    let mut at = HEADER_WORDS;
    std::iter::from_fn(move || {
        let first = *words.get(at)?;
        let (count, opcode) = ((first >> 16) as usize, (first & 0xffff) as u16);
        let operands = at.checked_add(count).and_then(|end| words.get(at + 1..end));
        let Some(operands) = operands else {
            let message = match count {
                0 => format!("the instruction at word {at} is 0 words long"),
                _ => format!(
                    "the instruction at word {at} is {count} words long, but the module has {}",
                    words.len()
                ),
            };
            // Where the next instruction begins is unknown, so nothing after a broken one is read.
            at = words.len();
            return Some(Err(message));
        };
        let instruction = Instruction { opcode, operands, at };
        at += count;
        Some(Ok(instruction))
    })
}

/// The words before the first instruction: magic number, version, generator, bound, schema.
pub(super) const HEADER_WORDS: usize = 5;

/// Returns a literal string, SPIR-V 1.6 §2.2.1: UTF-8, four bytes to a word from the low one, ended by
/// a zero byte. What is not UTF-8 becomes U+FFFD.
pub(super) fn text(words: &[u32]) -> String {
    let bytes = words.iter().flat_map(|word| word.to_le_bytes());
    let bytes: Vec<u8> = bytes.take_while(|byte| *byte != 0).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

// Their numbers in the specification's list of instructions; those above 4095 are of extensions.
pub(super) mod op {
    pub const NAME: u16 = 5;
    pub const MEMBER_NAME: u16 = 6;
    pub const MEMORY_MODEL: u16 = 14;
    pub const ENTRY_POINT: u16 = 15;
    pub const TYPE_VOID: u16 = 19;
    pub const TYPE_BOOL: u16 = 20;
    pub const TYPE_INT: u16 = 21;
    pub const TYPE_FLOAT: u16 = 22;
    pub const TYPE_VECTOR: u16 = 23;
    pub const TYPE_MATRIX: u16 = 24;
    pub const TYPE_ARRAY: u16 = 28;
    pub const TYPE_RUNTIME_ARRAY: u16 = 29;
    pub const TYPE_STRUCT: u16 = 30;
    pub const TYPE_POINTER: u16 = 32;
    pub const TYPE_FUNCTION: u16 = 33;
    pub const CONSTANT_TRUE: u16 = 41;
    pub const CONSTANT_FALSE: u16 = 42;
    pub const CONSTANT: u16 = 43;
    pub const CONSTANT_NULL: u16 = 46;
    pub const SPEC_CONSTANT_TRUE: u16 = 48;
    pub const SPEC_CONSTANT_FALSE: u16 = 49;
    pub const SPEC_CONSTANT: u16 = 50;
    pub const SPEC_CONSTANT_OP: u16 = 52;
    pub const FUNCTION: u16 = 54;
    pub const VARIABLE: u16 = 59;
    pub const DECORATE: u16 = 71;
    pub const MEMBER_DECORATE: u16 = 72;
    pub const GROUP_DECORATE: u16 = 74;
    pub const GROUP_MEMBER_DECORATE: u16 = 75;
    pub const UNTYPED_VARIABLE: u16 = 4418;
}

/// Storage classes of §3.7.
pub(super) mod class {
    pub const UNIFORM: u32 = 2;
    pub const PUSH_CONSTANT: u32 = 9;
    pub const STORAGE_BUFFER: u32 = 12;
    pub const SHADER_RECORD_BUFFER: u32 = 5343;
    pub const PHYSICAL_STORAGE_BUFFER: u32 = 5349;
    pub const TASK_PAYLOAD_WORKGROUP: u32 = 5402;
}
