//! Values of constants, which array lengths refer to: by the defaults of specialisation constants, and
//! by the values set by `-O`.

use std::sync::Arc;

use rustc_hash::{FxHashMap, FxHashSet};

use super::names;
use super::words::{Id, Instruction, op};
use crate::shape::{ArrayLen, Override};

/// The limit on the constants that one length depends on.
const MAX_OPERANDS: usize = 1_000;

/// A constant of an integer type or bool.
#[derive(Clone, Copy, Debug)]
struct ModuleConstant<'w> {
    /// The bits by the defaults; `None` if landfall cannot tell.
    default: Option<SpirvWord>,
    /// The bits by the values set by `-O`.
    given: Option<SpirvWord>,
    /// The constants that it is computed from.
    operands: &'w [u32],
    /// Its index in [`ConstantTable::overrides`], if it is specialised itself.
    specialised: Option<usize>,
}

/// The bits of an integer, zero above its width.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct SpirvWord {
    bits: u64,
    format: NumberFormat,
}

/// An integer type; a bool is one of 1 bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct NumberFormat {
    width: u32,
    signed: bool,
}

pub(super) struct ConstantTable<'w> {
    all: FxHashMap<Id, ModuleConstant<'w>>,
    /// The specialisation constants in declaration order.
    overrides: Vec<Override>,
    /// The values set by `-O`, by name or number.
    given: Vec<(String, String)>,
    /// The settings that are no value of their constant: its name and the text.
    pub wrong: Vec<(Arc<str>, String)>,
}

pub(super) struct ArrayLength {
    /// By the defaults.
    pub value: u64,
    /// By the values set by `-O`, if they change it.
    pub given: Option<u64>,
    /// The indices of the specialisation constants it depends on, in declaration order.
    pub depends_on: Vec<usize>,
}

impl ArrayLength {
    /// The length by the defaults, in the model.
    pub(super) fn in_model(&self) -> Result<ArrayLen, String> {
        let len = u32::try_from(self.value).map(ArrayLen::Fixed);
        len.map_err(|_| {
            format!("is {}, but an array has at most {} elements", self.value, u32::MAX)
        })
    }
}

impl<'w> ConstantTable<'w> {
    pub(super) fn new(given: &[(String, String)]) -> ConstantTable<'w> {
        ConstantTable {
            all: FxHashMap::default(),
            overrides: Vec::new(),
            given: given.to_vec(),
            wrong: Vec::new(),
        }
    }

    /// Adds an instruction that makes a constant; `None` if it lacks operands.
    pub(super) fn add(
        &mut self,
        types: &FxHashMap<Id, Instruction<'w>>,
        instruction: Instruction<'w>,
        name: Option<String>,
        spec_id: Option<u32>,
    ) -> Option<()> {
        let [ty, id, operands @ ..] = instruction.operands else { return None };
        // Constants of other types are no lengths.
        let Some(format) = types.get(ty).and_then(format_of) else { return Some(()) };
        let mut constant =
            ModuleConstant { default: None, given: None, operands: &[], specialised: None };
        match instruction.opcode {
            op::CONSTANT_TRUE | op::SPEC_CONSTANT_TRUE => constant.default = Some(format.word(1)),
            op::CONSTANT_FALSE | op::SPEC_CONSTANT_FALSE | op::CONSTANT_NULL => {
                constant.default = Some(format.word(0));
            }
            // §2.2.1: the low-order word first.
            op::CONSTANT | op::SPEC_CONSTANT => {
                let low = u64::from(*operands.first()?);
                let high = if format.width > 32 { u64::from(*operands.get(1)?) } else { 0 };
                constant.default = Some(format.word(low | high << 32));
            }
            op::SPEC_CONSTANT_OP => {
                let [operation, operands @ ..] = operands else { return None };
                constant.operands = operands;
                // Evaluated once by the defaults, once by the values set. Operands precede their
                // use (§2.4), and those that have no value make the result have none.
                let value = |of: fn(&ModuleConstant<'w>) -> Option<SpirvWord>| {
                    let operand = |id: &u32| self.all.get(id).and_then(of);
                    let mut values = operands.iter().take(3).map(operand);
                    let first = values.next()??;
                    computed(
                        *operation,
                        format,
                        first,
                        values.next().flatten(),
                        values.next().flatten(),
                    )
                };
                constant.default = value(|operand| operand.default);
                constant.given = value(|operand| operand.given);
            }
            _ => return Some(()),
        }
        if instruction.opcode != op::SPEC_CONSTANT_OP {
            constant.given = constant.default;
        }
        let is_specialised = op::SPEC_CONSTANT_TRUE..=op::SPEC_CONSTANT;
        if is_specialised.contains(&instruction.opcode) {
            let default = constant.default.map(SpirvWord::integer);
            (constant.specialised, constant.given) =
                (Some(self.overrides.len()), self.specialise(name, *id, spec_id, constant.default));
            self.overrides.last_mut()?.value = default.and_then(|value| i64::try_from(value).ok());
        }
        self.all.insert(*id, constant);
        Some(())
    }

    /// Records a specialisation constant; returns the value set by `-O`, or its default.
    fn specialise(
        &mut self,
        name: Option<String>,
        id: Id,
        spec_id: Option<u32>,
        default: Option<SpirvWord>,
    ) -> Option<SpirvWord> {
        // A name is what a program sets the constant by: its own, otherwise by SpecId, otherwise by
        // result id.
        let name = name.and_then(|name| names::identifier(&name)).unwrap_or_else(|| {
            spec_id.map_or_else(|| format!("value_{id}"), |id| format!("constant_{id}")).into()
        });
        let number = spec_id.map(|id| id.to_string());
        let is_meant = |key: &String| **key == *name || Some(key) == number.as_ref();
        let text = self.given.iter().rev().find(|(key, _)| is_meant(key)).map(|(_, text)| text);
        let given = match (text, default) {
            (Some(text), Some(default)) => match default.format.parse(text) {
                Some(word) => Some(word),
                None => {
                    self.wrong.push((Arc::clone(&name), text.clone()));
                    Some(default)
                }
            },
            (None, default) | (_, default @ None) => default,
        };
        self.overrides.push(Override { name, id: spec_id, value: None });
        given
    }

    /// The specialisation constants in declaration order.
    pub(super) fn overrides(&self) -> &[Override] {
        &self.overrides
    }

    /// Returns the length that a constant gives.
    ///
    /// # Errors
    /// It is no constant whose value landfall computes, or depends on more than 1,000 others.
    pub(super) fn length(&self, id: Id) -> Result<ArrayLength, String> {
        let constant = self.all.get(&id).ok_or_else(|| format!("is %{id}, which is no integer"))?;
        let value = constant.default.map(SpirvWord::integer).ok_or_else(|| {
            format!("is %{id}, which is computed by an operation that landfall does not know")
        })?;
        let of_length = |value: i128| {
            u64::try_from(value)
                .ok()
                .filter(|value| *value > 0)
                .ok_or_else(|| format!("is {value}, but an array has at least 1 element"))
        };
        // All constants that the length is computed from, each entered once; the operation itself
        // has at most three operands (OpSelect).
        let (mut seen, mut left) = (FxHashSet::default(), vec![id]);
        let mut depends_on = Vec::new();
        while let Some(id) = left.pop() {
            let Some(constant) = self.all.get(&id).filter(|_| seen.insert(id)) else { continue };
            if seen.len() > MAX_OPERANDS {
                return Err(format!("depends on more than {MAX_OPERANDS} constants"));
            }
            depends_on.extend(constant.specialised);
            left.extend(constant.operands.iter().take(3));
        }
        depends_on.sort_unstable();
        let given = constant.given.map(SpirvWord::integer).filter(|given| *given != value);
        Ok(ArrayLength {
            value: of_length(value)?,
            given: given.and_then(|given| u64::try_from(given).ok()),
            depends_on,
        })
    }
}

/// The format of an integer type or bool.
fn format_of(ty: &Instruction<'_>) -> Option<NumberFormat> {
    match (ty.opcode, ty.operands) {
        (op::TYPE_BOOL, _) => Some(NumberFormat { width: 1, signed: false }),
        (op::TYPE_INT, [_, width @ (8 | 16 | 32 | 64), sign, ..]) => {
            Some(NumberFormat { width: *width, signed: *sign == 1 })
        }
        _ => None,
    }
}

impl NumberFormat {
    // Arithmetic is done on 64 bits and cut to the width: the low bits of sums, differences and
    // products do not depend on the bits above.
    fn word(self, bits: u64) -> SpirvWord {
        let mask = u64::MAX >> (64 - self.width);
        SpirvWord { bits: bits & mask, format: self }
    }

    /// Parses a value from the command line.
    fn parse(self, text: &str) -> Option<SpirvWord> {
        let value: i128 = match text {
            "true" => 1,
            "false" => 0,
            _ => text.parse().ok()?,
        };
        // A value that does not survive the cut is out of range.
        let word = self.word(value as u64);
        (word.integer() == value).then_some(word)
    }
}

impl SpirvWord {
    fn integer(self) -> i128 {
        if self.format.signed { self.signed().into() } else { self.bits.into() }
    }

    /// The bits as a two's complement integer.
    fn signed(self) -> i64 {
        let shift = 64 - self.format.width;
        ((self.bits << shift) as i64) >> shift
    }
}

/// Returns the result of an operation of `OpSpecConstantOp`; `None` for those on other types than
/// integers, and for a division by zero.
// `sx` and `sy` are the operands as signed integers, whatever their declared type: the operation
// decides (OpSDiv, OpUDiv).
fn computed(
    operation: u32,
    format: NumberFormat,
    a: SpirvWord,
    second: Option<SpirvWord>,
    third: Option<SpirvWord>,
) -> Option<SpirvWord> {
    let (x, sx) = (a.bits, a.signed());
    let truth = |value: bool| Some(format.word(value.into()));
    let word = |bits: u64| Some(format.word(bits));
    // OpUConvert, OpSConvert, OpSNegate, OpNot, OpLogicalNot
    match operation {
        113 => return word(x),
        114 => return word(sx as u64),
        126 => return word(sx.wrapping_neg() as u64),
        200 => return word(!x),
        168 => return truth(x == 0),
        _ => {}
    }
    let b = second?;
    let (y, sy) = (b.bits, b.signed());
    // A shift by the width or more has an undefined result (OpShiftRightLogical).
    let shift = u32::try_from(y).ok().filter(|by| *by < a.format.width);
    match operation {
        // OpIAdd, OpISub, OpIMul
        128 => word(x.wrapping_add(y)),
        130 => word(x.wrapping_sub(y)),
        132 => word(x.wrapping_mul(y)),
        // OpUDiv, OpSDiv, OpUMod, OpSRem, OpSMod
        134 => word(x.checked_div(y)?),
        135 => word(sx.checked_div(sy)? as u64),
        137 => word(x.checked_rem(y)?),
        138 => word(sx.checked_rem(sy)? as u64),
        // The sign is that of the divisor.
        139 => {
            let rest = sx.checked_rem(sy)?;
            let wraps = rest != 0 && (rest < 0) != (sy < 0);
            word(if wraps { rest.wrapping_add(sy) } else { rest } as u64)
        }
        // OpLogicalEqual, OpLogicalNotEqual, OpLogicalOr, OpLogicalAnd, OpSelect
        164 | 170 => truth(x == y),
        165 | 171 => truth(x != y),
        166 => truth(x | y != 0),
        167 => truth(x & y != 0),
        169 => word(if x != 0 { y } else { third?.bits }),
        // OpUGreaterThan, OpSGreaterThan, … OpULessThanEqual, OpSLessThanEqual
        172 => truth(x > y),
        173 => truth(sx > sy),
        174 => truth(x >= y),
        175 => truth(sx >= sy),
        176 => truth(x < y),
        177 => truth(sx < sy),
        178 => truth(x <= y),
        179 => truth(sx <= sy),
        // OpShiftRightLogical, OpShiftRightArithmetic, OpShiftLeftLogical
        194 => word(x >> shift?),
        195 => word((sx >> shift?) as u64),
        196 => word(x << shift?),
        // OpBitwiseOr, OpBitwiseXor, OpBitwiseAnd
        197 => word(x | y),
        198 => word(x ^ y),
        199 => word(x & y),
        _ => None,
    }
}
