//! Conversion of one component between its bits and JSON.
//!
//! Numbers are JSON numbers and bools are `true` and `false`. Values JSON cannot represent are
//! strings: `"inf"`, `"-inf"`, `"nan"` for the quiet NaN without a payload, `"nan:0x7fc00001"` for
//! the bits of any other. A bool whose 4 bytes are neither 0 nor 1 is their number.

use std::fmt;

use serde::{Serialize, Serializer};
use serde_json::Value;

use super::float::{narrow, quiet_nan, widen};
use crate::shape::{Scalar, ScalarKind};

/// The bits of one component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ComponentBits {
    /// The component type.
    pub scalar: Scalar,
    /// The bits; those above the width are 0.
    pub bits: u64,
}

/// The value of a component as a Rust number.
enum ComponentValue {
    Bool(bool),
    Int(i64),
    Uint(u64),
    Float(f64),
}

impl ComponentBits {
    /// Whether it is a NaN.
    pub fn is_nan(self) -> bool {
        matches!(self.meaning(), ComponentValue::Float(number) if number.is_nan())
    }

    /// Whether it is an infinite float.
    pub fn is_infinite(self) -> bool {
        matches!(self.meaning(), ComponentValue::Float(number) if number.is_infinite())
    }

    /// Whether it is a bool that is neither 0 nor 1.
    pub(crate) fn is_odd_bool(self) -> bool {
        self.scalar.kind == ScalarKind::Bool && self.bits > 1
    }

    fn meaning(self) -> ComponentValue {
        // Sign extension: the sign bit is moved to bit 63 and back.
        let unused = 64 - 8 * u32::from(self.scalar.width);
        match self.scalar.kind {
            ScalarKind::Bool if self.bits > 1 => ComponentValue::Uint(self.bits),
            ScalarKind::Bool => ComponentValue::Bool(self.bits == 1),
            ScalarKind::Sint => ComponentValue::Int((self.bits << unused) as i64 >> unused),
            ScalarKind::Uint => ComponentValue::Uint(self.bits),
            ScalarKind::Float
            | ScalarKind::Bfloat
            | ScalarKind::FloatE5m2
            | ScalarKind::FloatE4m3 => ComponentValue::Float(widen(self.scalar, self.bits)),
        }
    }

    /// Returns the string for a float that JSON has no number for.
    fn word(self, number: f64) -> Option<String> {
        if number.is_nan() {
            let digits = usize::from(self.scalar.width) * 2;
            return Some(match quiet_nan(self.scalar) == Some(self.bits) {
                true => "nan".to_string(),
                false => format!("nan:0x{:0digits$x}", self.bits),
            });
        }
        let sign = if number < 0.0 { "-" } else { "" };
        number.is_infinite().then(|| format!("{sign}inf"))
    }

    /// Returns the shortest number that reads back as this one through an `f64`, as JSON parsers
    /// do; `None` if only the exact one does.
    fn short(self, number: f64) -> Option<f32> {
        let short = number as f32;
        let read: f64 = format!("{short:e}").parse().ok()?;
        // Parsers read an `f64` and round it again, which may differ from rounding the text once.
        (self.scalar.width < 8 && narrow(self.scalar, read) == self.bits).then_some(short)
    }
}

impl fmt::Display for ComponentBits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.meaning() {
            ComponentValue::Bool(value) => write!(f, "{value}"),
            ComponentValue::Int(number) => write!(f, "{number}"),
            ComponentValue::Uint(number) => write!(f, "{number}"),
            ComponentValue::Float(number) => match (self.word(number), self.short(number)) {
                (Some(word), _) => f.write_str(&word),
                (None, Some(short)) => write!(f, "{short:?}"),
                (None, None) => write!(f, "{number:?}"),
            },
        }
    }
}

impl Serialize for ComponentBits {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.meaning() {
            ComponentValue::Bool(value) => serializer.serialize_bool(value),
            ComponentValue::Int(number) => serializer.serialize_i64(number),
            ComponentValue::Uint(number) => serializer.serialize_u64(number),
            ComponentValue::Float(number) => match (self.word(number), self.short(number)) {
                (Some(word), _) => serializer.serialize_str(&word),
                (None, Some(short)) => serializer.serialize_f32(short),
                (None, None) => serializer.serialize_f64(number),
            },
        }
    }
}

/// An error of converting a JSON value to a component.
pub enum ComponentError {
    /// The wrong JSON type; the text names the right one.
    Kind(&'static str),
    /// The right JSON type, but out of range or malformed.
    Range,
}

/// Returns the bits of a component from JSON.
pub fn bits(scalar: Scalar, value: &Value) -> Result<u64, ComponentError> {
    let width = u32::from(scalar.width);
    let mask = u64::MAX >> (64 - 8 * width);
    match scalar.kind {
        ScalarKind::Bool => match value {
            Value::Bool(value) => Ok(u64::from(*value)),
            Value::Number(number) => match number.as_u64() {
                Some(bits) if bits <= mask => Ok(bits),
                _ => Err(ComponentError::Range),
            },
            _ => Err(ComponentError::Kind("true or false")),
        },
        ScalarKind::Sint => match value {
            Value::Number(number) if number.is_i64() || number.is_u64() => {
                let number = number.as_i64().ok_or(ComponentError::Range)?;
                let unused = 64 - 8 * width;
                // Sign extension gives the number back only if the bits cut off were all sign.
                let fits = (number << unused) >> unused == number;
                if fits { Ok(number as u64 & mask) } else { Err(ComponentError::Range) }
            }
            _ => Err(ComponentError::Kind("an integer")),
        },
        ScalarKind::Uint => match value {
            Value::Number(number) if number.is_i64() || number.is_u64() => {
                number.as_u64().filter(|&number| number <= mask).ok_or(ComponentError::Range)
            }
            _ => Err(ComponentError::Kind("an integer")),
        },
        ScalarKind::Float | ScalarKind::Bfloat | ScalarKind::FloatE5m2 | ScalarKind::FloatE4m3 => {
            match value {
                Value::Number(number) => {
                    let bits = narrow(scalar, number.as_f64().ok_or(ComponentError::Range)?);
                    // An infinity has to be asked for by `"inf"`: a number that overflows is an
                    // error.
                    if widen(scalar, bits).is_finite() {
                        Ok(bits)
                    } else {
                        Err(ComponentError::Range)
                    }
                }
                Value::String(word) => word_bits(scalar, word),
                _ => Err(ComponentError::Kind("a number")),
            }
        }
    }
}

/// Returns the bits of `inf`, `-inf`, `nan` or `nan:0x…`.
fn word_bits(scalar: Scalar, word: &str) -> Result<u64, ComponentError> {
    let kind = ComponentError::Kind(
        "a number, \"inf\", \"-inf\", \"nan\" or \"nan:0x…\" (a NaN by its bits)",
    );
    let infinite = |number: f64| {
        let bits = narrow(scalar, number);
        // E4M3 has no infinity, and the NaN that `narrow` gives for it is not what was asked for.
        if widen(scalar, bits).is_infinite() { Ok(bits) } else { Err(ComponentError::Range) }
    };
    match word {
        "inf" => infinite(f64::INFINITY),
        "-inf" => infinite(f64::NEG_INFINITY),
        "nan" => quiet_nan(scalar).ok_or(kind),
        _ => {
            // `from_str_radix` takes a sign, which bits do not have.
            let digits = word.strip_prefix("nan:0x").filter(|digits| !digits.starts_with('+'));
            let bits = digits.and_then(|d| u64::from_str_radix(d, 16).ok()).ok_or(kind)?;
            let mask = u64::MAX >> (64 - 8 * u32::from(scalar.width));
            let is_nan = bits <= mask && widen(scalar, bits).is_nan();
            if is_nan { Ok(bits) } else { Err(ComponentError::Range) }
        }
    }
}
