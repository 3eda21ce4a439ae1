//! Parsing of the JSON values of a block, and the errors of encoding them.

use crate::diagnostic::Code;
use std::fmt;
use std::ops::Range;

use serde::de::{Deserialize, Deserializer, Error as _, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Number, Value};

use super::error::BufferError;
use crate::text::locate::{at_line, locate};

/// An error of encoding JSON. `at` is the place in it, spelled like a path.
#[derive(Clone, PartialEq, Eq)]
#[allow(missing_docs)]
#[non_exhaustive]
pub enum EncodeError {
    /// The block has no known size.
    Block(BufferError),
    /// Not JSON, or an object with a duplicate key.
    Syntax { line: usize, column: usize, message: String },
    /// A key that is neither a member nor a path.
    Key { at: String, error: BufferError },
    /// A value of the wrong JSON type.
    Kind { at: String, ty: String, wanted: String, found: String },
    /// A number out of the type's range.
    Range { at: String, ty: String, found: String },
    /// Too many or too few values.
    Length { at: String, ty: String, wanted: u64, found: u64 },
    /// A second value for the same bytes, in another spelling.
    Twice { at: String },
    /// A member without a value.
    Missing { path: String },
}

impl EncodeError {
    /// Returns the diagnostic code.
    pub fn code(&self) -> Code {
        match self {
            EncodeError::Block(error) | EncodeError::Key { error, .. } => error.code(),
            EncodeError::Syntax { .. } => Code::JsonSyntax,
            EncodeError::Kind { .. } => Code::WrongValue,
            EncodeError::Range { .. } => Code::ValueOutOfRange,
            EncodeError::Length { .. } => Code::WrongCount,
            EncodeError::Twice { .. } => Code::GivenTwice,
            EncodeError::Missing { .. } => Code::MissingMember,
        }
    }
}

impl EncodeError {
    /// Returns the bytes of the text that the error is about: the unknown key, the value that does
    /// not fit, the invalid JSON. `None` if it is about something missing.
    pub fn locate(&self, text: &str) -> Option<Range<usize>> {
        match self {
            EncodeError::Block(_) | EncodeError::Missing { .. } => None,
            EncodeError::Syntax { line, column, .. } => Some(at_line(text, *line, *column)),
            EncodeError::Key { at, error } => {
                let key = error.path()?;
                // The path of the error starts at the object that has the key.
                let path = if at.is_empty() { key.to_string() } else { format!("{at}.{key}") };
                let found = locate(text, &path)?;
                Some(found.key.unwrap_or(found.value))
            }
            EncodeError::Kind { at, .. }
            | EncodeError::Range { at, .. }
            | EncodeError::Length { at, .. }
            | EncodeError::Twice { at } => Some(locate(text, at)?.value),
        }
    }
}

impl fmt::Display for EncodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            EncodeError::Block(error) => error.fmt(f),
            EncodeError::Syntax { line, column, message } => {
                write!(f, "line {line}, column {column}: {message}")
            }
            EncodeError::Key { at, error } => match at.as_str() {
                "" => error.fmt(f),
                at => write!(f, "in `{at}`: {error}"),
            },
            EncodeError::Kind { at, ty, wanted, found } => {
                write!(f, "{}: expected {wanted} for `{ty}`, found {found}", place(at))
            }
            EncodeError::Range { at, ty, found } => {
                write!(f, "{}: {found} does not fit `{ty}`", place(at))
            }
            EncodeError::Length { at, ty, wanted, found } => {
                write!(f, "{}: `{ty}` has {wanted} elements, not {found}", place(at))
            }
            EncodeError::Twice { at } => write!(f, "{}: its value is given twice", place(at)),
            EncodeError::Missing { path } => {
                write!(f, "`{path}` is missing\nhelp: add it, or allow missing members to be zero")
            }
        }
    }
}

/// Prints like `Display`, since `main` prints errors through `Debug`.
impl fmt::Debug for EncodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl std::error::Error for EncodeError {}

fn place(at: &str) -> String {
    if at.is_empty() { "the block".to_string() } else { format!("`{at}`") }
}

/// Parses JSON for [`encode`](super::encode()). A duplicate key is an error.
///
/// # Errors
/// [`EncodeError::Syntax`] with line and column, both from 1.
pub fn read_json(text: &str) -> Result<Value, EncodeError> {
    let read: Result<Once, serde_json::Error> = serde_json::from_str(text);
    read.map(|once| once.0).map_err(|error| {
        let (line, column) = (error.line(), error.column());
        // serde_json ends its message with the place, which is printed before it here.
        let full = error.to_string();
        let message = full.strip_suffix(&format!(" at line {line} column {column}"));
        EncodeError::Syntax { line, column, message: message.unwrap_or(&full).to_string() }
    })
}

/// Describes the JSON type of a value, with its text if short.
pub fn kind(value: &Value) -> String {
    match value {
        Value::Null => "null".to_string(),
        Value::Bool(value) => value.to_string(),
        Value::Number(number) => number.to_string(),
        // A message repeats at most 40 characters.
        Value::String(text) if text.chars().count() > 40 => "a string".to_string(),
        Value::String(text) => format!("{text:?}"),
        Value::Array(items) => match items.len() {
            1 => "an array of 1 value".to_string(),
            len => format!("an array of {len} values"),
        },
        Value::Object(_) => "an object".to_string(),
    }
}

/// A JSON value in which duplicate keys are an error.
struct Once(Value);

impl<'de> Deserialize<'de> for Once {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Once, D::Error> {
        deserializer.deserialize_any(OnceVisitor).map(Once)
    }
}

struct OnceVisitor;

impl<'de> Visitor<'de> for OnceVisitor {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a JSON value")
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
        Ok(Value::Bool(value))
    }

    fn visit_i64<E>(self, number: i64) -> Result<Value, E> {
        Ok(Value::Number(number.into()))
    }

    fn visit_u64<E>(self, number: u64) -> Result<Value, E> {
        Ok(Value::Number(number.into()))
    }

    fn visit_f64<E>(self, number: f64) -> Result<Value, E> {
        // JSON has no infinity and no NaN, so that none is parsed.
        Ok(Number::from_f64(number).map_or(Value::Null, Value::Number))
    }

    fn visit_str<E>(self, text: &str) -> Result<Value, E> {
        Ok(Value::String(text.to_string()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Value, A::Error> {
        let mut read = Vec::new();
        while let Some(Once(item)) = items.next_element()? {
            read.push(item);
        }
        Ok(Value::Array(read))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Value, A::Error> {
        let mut read = Map::new();
        while let Some(key) = entries.next_key::<String>()? {
            // `serde_json::Value` keeps the last of two, and the other value would be lost.
            if read.contains_key(&key) {
                return Err(A::Error::custom(format!("`{key}` is given twice")));
            }
            let Once(value) = entries.next_value()?;
            read.insert(key, value);
        }
        Ok(Value::Object(read))
    }
}
