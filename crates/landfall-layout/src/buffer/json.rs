//! Parsing of the JSON values of a block, and the errors of encoding them.

use crate::diagnostic::Code;
use std::fmt;
use std::ops::Range;

use serde_json::Value;

use super::error::BufferError;
use crate::text::json::{self, Fault, Node};
use crate::text::locate::locate;

/// An error of encoding JSON. `at` is the place in it, spelled like a path; `start` the offset of a byte.
#[derive(Clone, PartialEq, Eq)]
#[allow(missing_docs)]
#[non_exhaustive]
pub enum EncodeError {
    /// The block has no known size.
    Block(BufferError),
    /// Not JSON, or an object with a duplicate key.
    Syntax { start: usize, line: usize, column: usize, message: String },
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
            EncodeError::Syntax { start, .. } => Some(*start..(start + 1).min(text.len())),
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
            EncodeError::Syntax { line, column, message, .. } => {
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
    json::parse(text).map(plain).map_err(|fault| {
        let (start, message) = match fault {
            Fault::Truncated => {
                (text.trim_end().len(), "the text ends before the value is complete".to_string())
            }
            Fault::Expected { at, wanted } => (at, format!("expected {wanted}")),
            Fault::Twice { at, key } => (at, format!("`{key}` is given twice")),
            Fault::Deep { at } => (at, "is nested too deeply".to_string()),
        };
        let before = &text[..start];
        let line_start = before.rfind('\n').map_or(0, |end| end + 1);
        let line = before.matches('\n').count() + 1;
        let column = before[line_start..].chars().count() + 1;
        EncodeError::Syntax { start, line, column, message }
    })
}

/// Returns a value without its places.
fn plain(node: Node) -> Value {
    match node.value {
        json::Value::Null => Value::Null,
        json::Value::Bool(value) => Value::Bool(value),
        json::Value::Number(written) => serde_json::from_str(&written).unwrap_or(Value::Null),
        json::Value::Text(text) => Value::String(text),
        json::Value::List(items) => items.into_iter().map(plain).collect(),
        json::Value::Object(entries) => {
            entries.into_iter().map(|(key, _, node)| (key, plain(node))).collect()
        }
    }
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
