//! Paths such as `data[3].color.x`: taking them apart, and why one leads nowhere.
//!
//! Feeds [`explain`](super::explain).

use crate::diagnostic::Code;
use std::fmt;
use std::sync::Arc;

/// One step of a path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Segment {
    /// `color`, `.color`.
    Name(String),
    /// `[3]`; `[]` stands for every element.
    Index(Option<u64>),
}

/// Why a path leads nowhere.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PathError {
    /// What is wrong.
    pub kind: PathErrorKind,
    /// Segments that did lead somewhere.
    pub resolved: usize,
}

/// What is wrong with a path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PathErrorKind {
    /// Not a path at all.
    Syntax {
        /// The whole path.
        path: String,
        /// Character from 1.
        column: usize,
        /// What should stand there.
        expected: &'static str,
    },
    /// A block or structure has no member of that name.
    UnknownMember {
        /// The block or structure, such as "block `B`".
        owner: String,
        /// The name asked for.
        name: String,
        /// The member whose name is nearest.
        nearest: Option<Arc<str>>,
        /// Its members.
        members: Vec<Arc<str>>,
    },
    /// The member is a sampler or image and occupies no bytes.
    Opaque {
        /// Its name.
        name: String,
    },
    /// `.name` of something that has no members.
    NotAStructure {
        /// The path up to there.
        path: String,
        /// Its type.
        ty: String,
        /// The name asked for.
        name: String,
    },
    /// `[n]` of something that is no array, vector or matrix.
    NotAnArray {
        /// The path up to there.
        path: String,
        /// Its type.
        ty: String,
    },
    /// An index at or past the length.
    OutOfRange {
        /// The path up to there.
        path: String,
        /// The index asked for.
        index: u64,
        /// Number of elements, columns or components.
        len: u64,
        /// What it has that many of: `elements`.
        what: &'static str,
    },
    /// The whole block is loose uniforms, which have no offsets.
    Loose {
        /// The uniform asked for.
        path: String,
    },
}

impl PathErrorKind {
    /// Kebab-case name of the fault.
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

    /// What to do about it.
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
            PathErrorKind::Loose { .. } => Some(
                "`--gather` lays loose uniforms out as the std140 block they would make"
                    .to_string(),
            ),
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
                write!(f, "`{path}` is no path: expected {expected} at character {column}")
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
                write!(f, "`{path}` is a loose uniform: it is set by itself and has no offset")
            }
        }
    }
}

/// The first names of a list, in backticks.
fn name_list(names: &[Arc<str>]) -> String {
    const SHOWN: usize = 8;
    let mut text =
        names.iter().take(SHOWN).map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ");
    if names.len() > SHOWN {
        text.push_str(&format!(" and {} more", names.len() - SHOWN));
    }
    text
}

/// Takes a path apart.
pub fn segments(path: &str) -> Result<Vec<Segment>, PathError> {
    let fault = |at: usize, expected| PathError {
        kind: PathErrorKind::Syntax {
            path: path.to_string(),
            column: path[..at].chars().count() + 1,
            expected,
        },
        resolved: 0,
    };
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
