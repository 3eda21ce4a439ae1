//! Errors of setting, reading and creating buffers by name.

use crate::diagnostic::Code;
use crate::text::counts;
use std::fmt;

/// An error of a [`Buffer`](super::Buffer); nothing was written.
#[derive(Clone, PartialEq, Eq)]
#[allow(missing_docs)]
#[non_exhaustive]
pub enum BufferError {
    /// Loose uniforms have no bytes; they are set individually.
    NoBytes { block: String },
    /// A size depends on a specialisation constant or override without a value.
    Unsized { block: String, path: String, name: String },
    /// The block ends in a runtime-sized array whose length is required.
    NeedsTail { block: String, path: String },
    /// The block does not end in a runtime-sized array.
    NoTail { block: String },
    /// The size exceeds the limit of a block or the memory of this machine.
    TooLarge { block: String, bytes: u64 },
    /// Malformed path: byte `at` is not what is expected.
    Malformed { path: String, at: usize, expected: &'static str },
    /// No such member; `inside` is the part of the path that was resolved.
    UnknownPath { path: String, name: String, inside: String, nearest: Option<String> },
    /// The path ends at a structure or array; `next` lists possible continuations.
    NotALeaf { path: String, ty: String, next: String },
    /// An index on a value that is not an array.
    NotAnArray { path: String, ty: String },
    /// `[]` where a number is required, or a missing index.
    MissingIndex { path: String, len: u64 },
    /// An index at or past the end.
    OutOfRange { path: String, index: u64, len: u64 },
    /// An index past the end of this buffer's runtime-sized array.
    TailTooShort { path: String, index: u64, len: u64 },
    /// The value's type is not the shader's.
    WrongType { path: String, shader: String, given: String, wanted: String },
    /// The mirror's size is not the shader's.
    WrongSize { path: String, shader: String, wanted: u64, given: u64 },
    /// Bytes past the end of the buffer.
    OutOfBounds { offset: u64, size: u64, len: u64 },
    /// Bytes of the wrong length for the block; `cut` is the member where they end.
    WrongLength { block: String, wanted: u64, given: u64, cut: Option<String> },
    /// A handle created for a block with a different layout.
    OtherBlock { block: String },
    /// The number of indices is not the number of open dimensions of the handle.
    WrongIndices { path: String, wanted: usize, given: usize },
}

impl BufferError {
    /// The path the error is about, if any.
    pub fn path(&self) -> Option<&str> {
        match self {
            BufferError::Unsized { path, .. }
            | BufferError::NeedsTail { path, .. }
            | BufferError::Malformed { path, .. }
            | BufferError::UnknownPath { path, .. }
            | BufferError::NotALeaf { path, .. }
            | BufferError::NotAnArray { path, .. }
            | BufferError::MissingIndex { path, .. }
            | BufferError::OutOfRange { path, .. }
            | BufferError::TailTooShort { path, .. }
            | BufferError::WrongType { path, .. }
            | BufferError::WrongSize { path, .. }
            | BufferError::WrongIndices { path, .. } => Some(path),
            BufferError::NoBytes { .. }
            | BufferError::NoTail { .. }
            | BufferError::TooLarge { .. }
            | BufferError::OutOfBounds { .. }
            | BufferError::WrongLength { .. }
            | BufferError::OtherBlock { .. } => None,
        }
    }

    /// Returns the diagnostic code.
    pub fn code(&self) -> Code {
        match self {
            BufferError::NoBytes { .. } => Code::NoBytes,
            BufferError::Unsized { .. } => Code::UnsizedBlock,
            BufferError::NeedsTail { .. } => Code::NeedsTail,
            BufferError::NoTail { .. } => Code::NoTail,
            BufferError::TooLarge { .. } => Code::TooLarge,
            BufferError::Malformed { .. } => Code::MalformedPath,
            BufferError::UnknownPath { .. } => Code::UnknownMember,
            BufferError::NotALeaf { .. } => Code::NotALeaf,
            BufferError::NotAnArray { .. } => Code::NotAnArray,
            BufferError::MissingIndex { .. } => Code::MissingIndex,
            BufferError::OutOfRange { .. } | BufferError::TailTooShort { .. } => {
                Code::IndexOutOfRange
            }
            BufferError::WrongType { .. } => Code::WrongType,
            BufferError::WrongSize { .. } => Code::WrongSize,
            BufferError::OutOfBounds { .. } => Code::OutOfBounds,
            BufferError::WrongLength { .. } => Code::WrongLength,
            BufferError::OtherBlock { .. } => Code::OtherBlock,
            BufferError::WrongIndices { .. } => Code::WrongIndices,
        }
    }
}

impl fmt::Display for BufferError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BufferError::NoBytes { block } => write!(
                f,
                "`{block}` has no bytes: loose uniforms are set one by one\n\
                 help: lay them out as one block with `gather`"
            ),
            BufferError::Unsized { block, path, name } => write!(
                f,
                "`{block}` has no fixed size: the length of `{path}` is `{name}`, \
                 which has no value\nhelp: give it one with `-O {name}=…`"
            ),
            BufferError::NeedsTail { block, path } => write!(
                f,
                "`{block}` ends in the runtime-sized array `{path}`\n\
                 help: say how many elements it has with `Buffer::with_tail`"
            ),
            BufferError::NoTail { block } => write!(
                f,
                "`{block}` does not end in a runtime-sized array\nhelp: use `Buffer::new`"
            ),
            BufferError::TooLarge { block, bytes } => {
                write!(
                    f,
                    "`{block}` would be {}, more than can be allocated",
                    counts::bytes(*bytes)
                )
            }
            BufferError::Malformed { path, at, expected } => {
                write!(f, "`{path}` is not a path: expected {expected} at byte {at}")
            }
            BufferError::UnknownPath { path, name, inside, nearest } => {
                match inside.as_str() {
                    "" => write!(f, "no member `{name}` in the block (path `{path}`)")?,
                    inside => write!(f, "no member `{name}` in `{inside}` (path `{path}`)")?,
                }
                match nearest {
                    Some(nearest) => write!(f, "\nhelp: did you mean `{nearest}`?"),
                    None => Ok(()),
                }
            }
            BufferError::NotALeaf { path, ty, next } => {
                write!(
                    f,
                    "`{path}` is `{ty}`, not a single value\nhelp: continue the path with {next}"
                )
            }
            BufferError::NotAnArray { path, ty } => {
                write!(f, "`{path}` is `{ty}` and takes no further index or component")
            }
            BufferError::MissingIndex { path, len } => {
                let elements = counts::numbered(*len, "element");
                write!(f, "`{path}` lacks the index of an array of {elements}")
            }
            BufferError::OutOfRange { path, index, len } => {
                write!(f, "index {index} in `{path}` is out of range: the length is {len}")
            }
            BufferError::TailTooShort { path, index, len } => write!(
                f,
                "index {index} in `{path}` is out of range: the runtime-sized array of this \
                 buffer was made with {}",
                counts::numbered(*len, "element")
            ),
            BufferError::WrongType { path, shader, given, wanted } => {
                write!(f, "`{path}` is `{shader}`, not `{given}`\nhelp: use `{wanted}`")
            }
            BufferError::WrongSize { path, shader, wanted, given } => write!(
                f,
                "`{path}` is `{shader}` of {}, but the mirror has {}",
                counts::bytes(*wanted),
                counts::bytes(*given)
            ),
            BufferError::OutOfBounds { offset, size, len } => {
                let (size, len) = (counts::bytes(*size), counts::bytes(*len));
                write!(f, "{size} at offset {offset} end past the buffer's {len}")
            }
            BufferError::WrongLength { block, wanted, given, cut } => {
                let were = if *given == 1 { "was" } else { "were" };
                let (wanted, given) = (counts::bytes(*wanted), counts::bytes(*given));
                write!(f, "`{block}` has {wanted}, but {given} {were} given")?;
                match cut {
                    Some(path) => write!(f, ": they end before or in `{path}`"),
                    None => Ok(()),
                }
            }
            BufferError::OtherBlock { block } => {
                write!(f, "the handle was created for another block than `{block}`")
            }
            BufferError::WrongIndices { path, wanted, given } => {
                write!(f, "`{path}` takes {wanted} indices, but {given} were given")
            }
        }
    }
}

/// Prints like `Display`, since `main` prints errors through `Debug`.
impl fmt::Debug for BufferError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl std::error::Error for BufferError {}
