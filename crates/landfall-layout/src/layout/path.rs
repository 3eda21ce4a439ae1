//! Paths such as `data[3].color.x`: parsing, and the errors of resolving them.
//!
//! Feeds [`explain`](super::explain).

use crate::diagnostic::Code;
use std::fmt;
use std::sync::Arc;

/// A segment of a path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Segment {
    /// A member: `color`, `.color`.
    Name(String),
    /// An index: `[3]`; `[]` means every element.
    Index(Option<u64>),
}

/// An error in a path, and how much of it was resolved.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct PathError {
    /// The error.
    pub kind: PathErrorKind,
    /// Number of segments resolved before the error.
    pub resolved: usize,
}

/// The ways a path can be wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PathErrorKind {
    /// Malformed path.
    Syntax {
        /// The whole path.
        path: String,
        /// Column of the error in characters, from 1.
        column: usize,
        /// The expected token.
        expected: &'static str,
    },
    /// No member of that name in the block or structure.
    UnknownMember {
        /// The block or structure, such as "block `B`".
        owner: String,
        /// The unknown name.
        name: String,
        /// The member with the nearest name.
        nearest: Option<Arc<str>>,
        /// The members there are.
        members: Vec<Arc<str>>,
    },
    /// The member is a sampler or image and occupies no bytes.
    Opaque {
        /// The member's name.
        name: String,
    },
    /// `.name` on a value that is not a structure.
    NotAStructure {
        /// The path before `.name`.
        path: String,
        /// The type there.
        ty: String,
        /// The unknown name.
        name: String,
    },
    /// `[n]` on a value that is not an array, vector or matrix.
    NotAnArray {
        /// The path before `[n]`.
        path: String,
        /// The type there.
        ty: String,
    },
    /// An index at or past the length.
    OutOfRange {
        /// The path before the index.
        path: String,
        /// The index.
        index: u64,
        /// Number of elements, columns or components.
        len: u64,
        /// The noun for what `len` counts: `elements`.
        what: &'static str,
    },
    /// The block holds loose uniforms, which have no offsets.
    Loose {
        /// The path of the uniform.
        path: String,
    },
}

impl PathErrorKind {
    /// Returns the diagnostic code.
    pub fn code(&self) -> Code {
        match self {
            PathErrorKind::Syntax { .. } => Code::MalformedPath,
            PathErrorKind::UnknownMember { .. } => Code::UnknownMember,
            PathErrorKind::Opaque { .. } => Code::OpaqueMember,
            PathErrorKind::NotAStructure { .. } => Code::NotAStructure,
            PathErrorKind::NotAnArray { .. } => Code::NotAnArray,
            PathErrorKind::OutOfRange { .. } => Code::IndexOutOfRange,
            PathErrorKind::Loose { .. } => Code::LooseUniform,
        }
    }

    /// Returns a suggested remedy.
    pub fn help(&self) -> Option<String> {
        match self {
            PathErrorKind::Syntax { .. } => {
                Some("a path is written as in the shader: `data[3].color`".to_string())
            }
            PathErrorKind::UnknownMember { nearest: Some(nearest), .. } => {
                Some(format!("there is a member `{nearest}`"))
            }
            PathErrorKind::UnknownMember { members, .. } if members.is_empty() => None,
            PathErrorKind::UnknownMember { members, .. } => {
                Some(format!("its members are {}", name_list(members)))
            }
            PathErrorKind::OutOfRange { path, len, .. } if *len > 0 => {
                Some(format!("the last one is `{path}[{}]`", len - 1))
            }
            PathErrorKind::Loose { .. } => {
                Some("`--gather` lays out loose uniforms as a std140 block".to_string())
            }
            // An array as GLSL or as WGSL spells it.
            PathErrorKind::NotAStructure { path, ty, name }
                if ty.ends_with(']') || ty.starts_with("array<") =>
            {
                Some(format!("it is an array: write `{path}[0].{name}`"))
            }
            PathErrorKind::Opaque { .. }
            | PathErrorKind::NotAStructure { .. }
            | PathErrorKind::NotAnArray { .. }
            | PathErrorKind::OutOfRange { .. } => None,
        }
    }
}

impl fmt::Display for PathErrorKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PathErrorKind::Syntax { path, column, expected } => {
                write!(f, "`{path}` is not a path: expected {expected} at character {column}")
            }
            PathErrorKind::UnknownMember { owner, name, .. } => {
                write!(f, "{owner} has no member `{name}`")
            }
            PathErrorKind::Opaque { name } => {
                write!(f, "`{name}` is opaque (a sampler or image): it occupies no bytes")
            }
            PathErrorKind::NotAStructure { path, ty, name } => {
                write!(f, "`{path}` has type `{ty}`, which has no member or component `{name}`")
            }
            PathErrorKind::NotAnArray { path, ty } => {
                write!(f, "`{path}` has type `{ty}`, which cannot be indexed")
            }
            PathErrorKind::OutOfRange { path, index, len, what } => {
                write!(f, "`{path}[{index}]` is out of range: `{path}` has {len} {what}")
            }
            PathErrorKind::Loose { path } => {
                write!(f, "`{path}` is a loose uniform, which is set on its own and has no offset")
            }
        }
    }
}

/// Lists names in backticks, at most `SHOWN` of them.
fn name_list(names: &[Arc<str>]) -> String {
    const SHOWN: usize = 8;
    let mut text =
        names.iter().take(SHOWN).map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ");
    if names.len() > SHOWN {
        text.push_str(&format!(" and {} more", names.len() - SHOWN));
    }
    text
}

/// Parses a path into segments.
pub fn segments(path: &str) -> Result<Vec<Segment>, PathError> {
    // path = name { "." name | "[" [ digits | "*" ] "]" }, with spaces allowed around names and
    // digits. What characters a name has is not checked: it is compared with those of members.
    let fault = |at: usize, expected| PathError {
        kind: PathErrorKind::Syntax {
            path: path.to_string(),
            column: path[..at].chars().count() + 1,
            expected,
        },
        resolved: 0,
    };
    // `at` is the byte where the next segment begins, the dot before a name included.
    let mut segments = Vec::new();
    let mut at = 0;
    while at < path.len() {
        let rest = &path[at..];
        if let Some(inside) = rest.strip_prefix('[') {
            if segments.is_empty() {
                return Err(fault(at, "a member's name"));
            }
            let Some(close) = inside.find(']') else {
                return Err(fault(path.len(), "`]`"));
            };
            let digits = inside[..close].trim();
            let index = match digits {
                "" | "*" => None,
                _ => Some(digits.parse().map_err(|_| fault(at + 1, "a number"))?),
            };
            segments.push(Segment::Index(index));
            // The brackets and what is between them.
            at += close + 2;
            continue;
        }
        if !segments.is_empty() {
            if !rest.starts_with('.') {
                return Err(fault(at, "`.` or `[`"));
            }
            at += 1;
        }
        let rest = &path[at..];
        let name: &str = rest.split(['.', '[', ']']).next().unwrap_or("");
        if name.trim().is_empty() {
            return Err(fault(at, "a member's name"));
        }
        segments.push(Segment::Name(name.trim().to_string()));
        at += name.len();
    }
    if segments.is_empty() {
        return Err(fault(0, "a member's name"));
    }
    Ok(segments)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_falls_apart_into_names_and_indices() {
        let name = |s: &str| Segment::Name(s.to_string());
        assert_eq!(
            segments("data[3].pos[].x").unwrap(),
            [name("data"), Segment::Index(Some(3)), name("pos"), Segment::Index(None), name("x")]
        );
    }

    #[test]
    fn what_is_no_path_is_refused_with_the_place() {
        for (path, column) in
            [("", 1), (".a", 1), ("a.", 3), ("a[3", 4), ("a[x]", 3), ("a]", 2), ("[3]", 1)]
        {
            match segments(path).unwrap_err().kind {
                PathErrorKind::Syntax { column: found, .. } => assert_eq!(found, column, "{path}"),
                other => panic!("{path}: {other:?}"),
            }
        }
    }
}
