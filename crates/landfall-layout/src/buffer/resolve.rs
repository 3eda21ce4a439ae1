//! Resolution of paths member by member: structures and arrays, columns and components, the
//! optional name of the block, and the errors in a path.
//!
//! Full paths of leaves, the common case, are resolved by [`index`](super::index) instead.

use super::error::BufferError;
use super::grid::{ComponentGrid, Dim, language};
use crate::layout::measure::fixed;
use crate::layout::{BlockLayout, MemberLayout};
use crate::shape::{Rules, Type};
use crate::text::edit_distance::nearest;

/// A named place in a block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ResolvedPlace<'b> {
    /// Offset from the start of the block.
    pub offset: u64,
    pub what: PlaceKind<'b>,
    /// The last index of the path; 0 if there is none.
    pub index: u64,
}

impl<'b> ResolvedPlace<'b> {
    /// The whole block.
    pub const BLOCK: ResolvedPlace<'static> =
        ResolvedPlace { offset: 0, what: PlaceKind::Block, index: 0 };

    /// Returns the place of a member of this structure.
    pub fn member(self, member: &'b MemberLayout) -> ResolvedPlace<'b> {
        let offset = self.offset + member.offset.unwrap_or(0);
        ResolvedPlace { offset, what: element(member, 0), index: 0 }
    }

    /// Returns the place of an element of this array: a member from dimension `dim` inwards.
    pub fn element(self, member: &'b MemberLayout, dim: usize, index: u64) -> ResolvedPlace<'b> {
        let offset = self.offset + index * member.strides[dim];
        ResolvedPlace { offset, what: element(member, dim + 1), index }
    }
}

/// The kind of a place.
#[derive(Clone, Copy, Debug)]
pub(crate) enum PlaceKind<'b> {
    /// The whole block.
    Block,
    /// A member's array from that dimension inwards.
    Array(&'b MemberLayout, usize),
    /// One element of a member that is a structure.
    Struct(&'b MemberLayout),
    /// A scalar, vector or matrix, or a column or component of one.
    Leaf(ComponentGrid),
}

/// A path being resolved.
struct PathReader<'p, 'b> {
    block: &'b BlockLayout,
    path: &'p str,
    at: usize,
    /// Elements of the runtime-sized tail.
    tail: usize,
}

/// Resolves a path. `[]` goes to `open`, or is an error if that is `None`.
///
/// Member names take precedence; a path that does not start with one may start with the block's
/// instance name (as in the shader) or its own name (as in OpenGL's queries).
pub(crate) fn resolve<'b>(
    block: &'b BlockLayout,
    tail: usize,
    path: &str,
    open: Option<&mut dyn FnMut(Dim)>,
) -> Result<ResolvedPlace<'b>, BufferError> {
    // path = name { "." name | "[" [ digits ] "]" } without spaces; the last step may be a letter
    // of a component. Offsets add up on the way, and errors name the part read so far.
    let mut reader = PathReader { block, path, at: 0, tail };
    if path.is_empty() {
        return Ok(ResolvedPlace::BLOCK);
    }
    let first = reader.peek_name();
    if !block.members.iter().any(|m| &*m.name == first) {
        let names = [block.instance.as_deref(), Some(&*block.name)];
        if names.into_iter().flatten().any(|name| name == first && !name.is_empty()) {
            match path.as_bytes().get(first.len()) {
                None => return Ok(ResolvedPlace::BLOCK),
                Some(b'.') => reader.at = first.len() + 1,
                // An index after the name, as of an array of blocks: the name is reported as
                // unknown.
                Some(_) => {}
            }
        }
    }
    reader.member(&reader.block.members, ResolvedPlace::BLOCK, open)
}

/// Resolves a path to a leaf: its offset, and the places of its components.
pub(crate) fn resolve_leaf(
    block: &BlockLayout,
    tail: usize,
    path: &str,
    open: Option<&mut dyn FnMut(Dim)>,
) -> Result<(usize, ComponentGrid), BufferError> {
    let place = resolve(block, tail, path, open)?;
    match place.what {
        PlaceKind::Leaf(grid) => Ok((place.offset as usize, grid)),
        what => Err(not_a_leaf(block, path, what)),
    }
}

/// Resolves a path from one element of a structure, or from the block for `What::Block`.
pub(crate) fn resolve_in<'b>(
    block: &'b BlockLayout,
    tail: usize,
    path: &str,
    from: ResolvedPlace<'b>,
) -> Result<ResolvedPlace<'b>, BufferError> {
    let mut reader = PathReader { block, path, at: 0, tail };
    match from.what {
        PlaceKind::Struct(member) => reader.member(&member.members, from, None),
        PlaceKind::Block | PlaceKind::Array(..) | PlaceKind::Leaf(_) => {
            resolve(block, tail, path, None)
        }
    }
}

impl<'b> PathReader<'_, 'b> {
    /// Resolves a member of a structure and the rest of the path.
    fn member(
        &mut self,
        mut members: &'b [MemberLayout],
        mut place: ResolvedPlace<'b>,
        mut open: Option<&mut dyn FnMut(Dim)>,
    ) -> Result<ResolvedPlace<'b>, BufferError> {
        // One member in each round: its name, then the indices and components after it.
        loop {
            let start = self.at;
            let name = self.peek_name();
            if name.is_empty() {
                return Err(self.malformed("a name"));
            }
            let Some(member) = members.iter().find(|m| &*m.name == name) else {
                return Err(self.unknown(start, name, members));
            };
            self.at += name.len();
            place = place.member(member);
            // `place` moves inwards with each step: from an array to its element, from a matrix to
            // a column, from a vector to a component.
            while let Some(step) = self.step()? {
                match (place.what, step) {
                    (PlaceKind::Array(member, dim), PathStep::Index(index)) => {
                        let shape = self.dim(member, dim);
                        match (index, &mut open) {
                            (Some(index), _) => {
                                self.check(index, shape.len.unwrap_or(self.tail), shape)?;
                            }
                            (None, Some(open)) => open(shape),
                            (None, None) => return Err(self.missing_index(shape)),
                        }
                        place = place.element(member, dim, index.unwrap_or(0));
                    }
                    (PlaceKind::Leaf(grid), step) => {
                        let inner = self.inside(grid, step)?;
                        place.offset += inner.0 as u64;
                        place.what = PlaceKind::Leaf(inner.1);
                    }
                    // The name of the next member follows; the dot is passed.
                    (PlaceKind::Struct(_), PathStep::Dot) => break,
                    (PlaceKind::Array(member, dim), PathStep::Dot) => {
                        return Err(self.missing_index(self.dim(member, dim)));
                    }
                    (PlaceKind::Struct(_) | PlaceKind::Block, _) => {
                        let ty = self.spelled(place.what);
                        return Err(BufferError::NotAnArray { path: self.before(), ty });
                    }
                }
            }
            match place.what {
                // A path that ends at a structure has no dot, and is the place of the whole
                // structure.
                PlaceKind::Struct(member) if self.path[..self.at].ends_with('.') => {
                    members = &member.members;
                }
                _ => return Ok(place),
            }
        }
    }

    /// Returns the name at the cursor, up to `.` or `[`; may be empty.
    fn peek_name(&self) -> &str {
        let rest = &self.path[self.at..];
        &rest[..rest.find(['.', '[']).unwrap_or(rest.len())]
    }

    /// Reads the next `[index]`, `[]` or `.`; `None` at the end.
    fn step(&mut self) -> Result<Option<PathStep>, BufferError> {
        let rest = &self.path[self.at..];
        match rest.as_bytes().first() {
            None => Ok(None),
            Some(b'.') => {
                self.at += 1;
                Ok(Some(PathStep::Dot))
            }
            Some(b'[') => {
                self.at += 1;
                let digits = rest[1..].bytes().take_while(u8::is_ascii_digit).count();
                let number = &rest[1..1 + digits];
                self.at += digits;
                if !self.path[self.at..].starts_with(']') {
                    return Err(self.malformed(if digits == 0 { "a number" } else { "`]`" }));
                }
                self.at += 1;
                // Too many digits for 64 bits: past the end of any array.
                let index = number.parse().ok().or((digits > 0).then_some(u64::MAX));
                Ok(Some(PathStep::Index(index)))
            }
            Some(_) => Err(self.malformed("`.` or `[`")),
        }
    }

    /// Resolves a column or component of a leaf to its offset in the leaf and its grid.
    fn inside(
        &mut self,
        grid: ComponentGrid,
        step: PathStep,
    ) -> Result<(usize, ComponentGrid), BufferError> {
        let (columns, rows) = (u64::from(grid.columns), u64::from(grid.rows));
        let shape = |len: u64| Dim { len: Some(len as usize), stride: 0 };
        // A matrix of one column or a vector of one row does not exist in shaders: more than one
        // column is a matrix, one column of several rows a vector (or a column already chosen).
        match step {
            PathStep::Index(None) => {
                let len = if columns > 1 { columns } else { rows };
                Err(self.missing_index(shape(len)))
            }
            PathStep::Index(Some(index)) if columns > 1 => {
                self.check(index, columns as usize, shape(columns))?;
                Ok((grid.component(index as usize, 0), grid.column()))
            }
            PathStep::Index(Some(index)) if rows > 1 => {
                self.check(index, rows as usize, shape(rows))?;
                Ok((grid.component(0, index as usize), grid.cell()))
            }
            PathStep::Dot if columns == 1 && rows > 1 => {
                let name = self.peek_name();
                // GLSL 4.60 §5.5; `rgba` and `stpq` are other letters for `xyzw`.
                let row = ["xyzw", "rgba", "stpq"]
                    .iter()
                    .find_map(|set| set.find(name).filter(|_| name.len() == 1));
                match row {
                    Some(row) if row < usize::from(grid.rows) => {
                        self.at += 1;
                        Ok((grid.component(0, row), grid.cell()))
                    }
                    _ => Err(BufferError::UnknownPath {
                        path: self.path.to_string(),
                        name: name.to_string(),
                        inside: self.path[..self.at - 1].to_string(),
                        nearest: None,
                    }),
                }
            }
            PathStep::Index(Some(_)) | PathStep::Dot => {
                let ty = self.spelled(PlaceKind::Leaf(grid));
                Err(BufferError::NotAnArray { path: self.before(), ty })
            }
        }
    }

    fn dim(&self, member: &MemberLayout, dim: usize) -> Dim {
        Dim::new(&member.dims[dim], member.strides[dim])
    }

    fn check(&self, index: u64, len: usize, dim: Dim) -> Result<(), BufferError> {
        let len = len as u64;
        if index < len {
            return Ok(());
        }
        Err(out_of_range(self.path, index, len, dim))
    }

    fn malformed(&self, expected: &'static str) -> BufferError {
        BufferError::Malformed { path: self.path.to_string(), at: self.at, expected }
    }

    fn unknown(&self, start: usize, name: &str, members: &[MemberLayout]) -> BufferError {
        // The name is replaced in place, so that the suggestion is a whole path.
        let inside = self.path[..start].trim_end_matches('.').to_string();
        let nearest = nearest(name, members.iter().map(|m| &*m.name)).map(|near| {
            format!("{}{near}{}", &self.path[..start], &self.path[start + name.len()..])
        });
        let (path, name) = (self.path.to_string(), name.to_string());
        BufferError::UnknownPath { path, name, inside, nearest }
    }

    fn missing_index(&self, dim: Dim) -> BufferError {
        let len = dim.len.unwrap_or(self.tail) as u64;
        BufferError::MissingIndex { path: self.path.to_string(), len }
    }

    /// Returns the path before the last step.
    fn before(&self) -> String {
        let read = &self.path[..self.at];
        let end = read.rfind(['.', '[']).unwrap_or(read.len());
        read[..end].to_string()
    }

    fn spelled(&self, what: PlaceKind<'_>) -> String {
        spelled(self.block, what)
    }
}

/// One step of a path after a name.
#[derive(Clone, Copy)]
enum PathStep {
    Index(Option<u64>),
    Dot,
}

/// Returns the kind of a member below its first `dim` dimensions.
pub(crate) fn element(member: &MemberLayout, dim: usize) -> PlaceKind<'_> {
    if dim < member.dims.len() {
        return PlaceKind::Array(member, dim);
    }
    match ComponentGrid::of_member(member) {
        Some(grid) => PlaceKind::Leaf(grid),
        None => PlaceKind::Struct(member),
    }
}

/// Returns the error for an index past the end of a dimension.
pub(crate) fn out_of_range(path: &str, index: u64, len: u64, dim: Dim) -> BufferError {
    let path = path.to_string();
    match dim.len {
        Some(_) => BufferError::OutOfRange { path, index, len },
        None => BufferError::TailTooShort { path, index, len },
    }
}

/// Returns the error for a path to a structure or array where a leaf is required.
fn not_a_leaf(block: &BlockLayout, path: &str, what: PlaceKind<'_>) -> BufferError {
    let names = |members: &[MemberLayout]| {
        let mut names: Vec<String> = members.iter().map(|m| format!("`.{}`", m.name)).collect();
        // Seven names and an ellipsis, as long as eight names.
        if names.len() > 8 {
            names.truncate(7);
            names.push("…".to_string());
        }
        names.join(", ")
    };
    let next = match what {
        PlaceKind::Block => names(&block.members).replace("`.", "`"),
        PlaceKind::Struct(member) => names(&member.members),
        PlaceKind::Array(..) | PlaceKind::Leaf(_) => "an index".to_string(),
    };
    BufferError::NotALeaf { path: path.to_string(), ty: spelled(block, what), next }
}

/// Returns the type at a place in the shader's spelling.
pub(crate) fn spelled(block: &BlockLayout, what: PlaceKind<'_>) -> String {
    let language = language(block);
    match what {
        PlaceKind::Block => block.name.to_string(),
        PlaceKind::Leaf(grid) => grid.spelled(language),
        PlaceKind::Struct(member) => member.ty.innermost().spelled(language).to_string(),
        PlaceKind::Array(member, dim) => {
            let mut ty = &member.ty;
            for _ in 0..dim {
                if let Type::Array { element, .. } = ty {
                    ty = element;
                }
            }
            ty.spelled(language).to_string()
        }
    }
}

/// Returns the size of a place, padding at its end included; `None` if runtime-sized.
pub(crate) fn size(block: &BlockLayout, what: PlaceKind<'_>) -> Option<u64> {
    match what {
        PlaceKind::Block => block.size,
        PlaceKind::Leaf(grid) => Some(grid.span() as u64),
        PlaceKind::Array(member, dim) => Some(member.strides[dim] * fixed(&member.dims[dim])?),
        // An element of an array takes the stride, up to the start of the next one.
        PlaceKind::Struct(member) => match member.strides.last() {
            Some(&stride) => Some(stride),
            None => member.size,
        },
    }
}

/// Returns the bytes of a place up to the end of its last member.
pub(crate) fn data_size(block: &BlockLayout, what: PlaceKind<'_>) -> Option<u64> {
    match what {
        PlaceKind::Block => block.data_size,
        PlaceKind::Struct(member) => {
            let end = |m: &MemberLayout| Some(m.offset? + m.size?);
            member.members.iter().map(end).try_fold(0, |most, end| Some(most.max(end?)))
        }
        PlaceKind::Array(member, dim) => match block.rules {
            Rules::Std140 | Rules::Std430 | Rules::Wgsl => size(block, what),
            // GL_EXT_scalar_block_layout: the padding after the last element is not part of the
            // array.
            Rules::Scalar | Rules::Explicit(_) => {
                // Only the outermost dimension: within it, the next inner array begins after the
                // padding.
                if dim == 0 { member.size } else { size(block, what) }
            }
        },
        PlaceKind::Leaf(_) => size(block, what),
    }
}
