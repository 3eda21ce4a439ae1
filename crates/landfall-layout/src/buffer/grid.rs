//! The positions of a leaf's components, and the byte extent of a block.
//!
//! Reads the [model](crate::layout()); used by the rest of this module.

use super::error::BufferError;
use crate::layout::measure::fixed;
use crate::layout::{BlockLayout, LARGEST_BLOCK, MemberLayout};
use crate::shape::{ArrayLen, Rules, Scalar, Type};
use crate::source::Language;

/// The component positions of a scalar, vector or matrix: component (column c, row r) starts at `c
/// * column_step + r * row_step`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ComponentGrid {
    pub scalar: Scalar,
    pub columns: u8,
    pub rows: u8,
    pub column_step: usize,
    pub row_step: usize,
}

impl ComponentGrid {
    /// Returns the grid of a leaf type; `None` for structures and arrays.
    pub fn new(ty: &Type, matrix_stride: Option<u64>, row_major: bool) -> Option<ComponentGrid> {
        let vector = |scalar: Scalar, rows| ComponentGrid {
            scalar,
            columns: 1,
            rows,
            column_step: 0,
            row_step: scalar.width.into(),
        };
        match ty {
            Type::Scalar(scalar) | Type::Atomic(scalar) => Some(vector(*scalar, 1)),
            Type::Address(_) => Some(vector(Scalar::U64, 1)),
            Type::Vector { scalar, rows } => Some(vector(*scalar, *rows)),
            Type::Matrix { scalar, columns, rows } => {
                let stride = usize::try_from(matrix_stride.unwrap_or(0)).ok()?;
                let width = usize::from(scalar.width);
                // A row-major matrix stores one row after the other: its columns are one component
                // apart.
                let (column_step, row_step) =
                    if row_major { (width, stride) } else { (stride, width) };
                let (columns, rows) = (*columns, *rows);
                Some(ComponentGrid { scalar: *scalar, columns, rows, column_step, row_step })
            }
            Type::Struct(_) | Type::Array { .. } => None,
        }
    }

    /// Returns the grid of a member's leaves; `None` if it is a structure.
    pub fn of_member(member: &MemberLayout) -> Option<ComponentGrid> {
        ComponentGrid::new(member.ty.innermost(), member.matrix_stride, member.row_major)
    }

    /// Returns the offset of a component.
    pub fn component(&self, column: usize, row: usize) -> usize {
        column * self.column_step + row * self.row_step
    }

    /// Bytes from the start of the first component to the end of the last.
    pub fn span(&self) -> usize {
        let last = self.component(usize::from(self.columns) - 1, usize::from(self.rows) - 1);
        last + usize::from(self.scalar.width)
    }

    /// Iterates over (column, row), columns outermost.
    pub fn cells(self) -> impl Iterator<Item = (usize, usize)> {
        (0..usize::from(self.columns))
            .flat_map(move |c| (0..usize::from(self.rows)).map(move |r| (c, r)))
    }

    /// Whether the components follow each other without gaps, column by column, as in Rust's `[[T;
    /// rows]; columns]`: such a leaf is copied at once.
    pub fn is_plain(&self) -> bool {
        let width = usize::from(self.scalar.width);
        let rows = usize::from(self.rows);
        (rows == 1 || self.row_step == width)
            && (self.columns == 1 || self.column_step == width * rows)
    }

    /// The grid of one column, a vector.
    pub fn column(self) -> ComponentGrid {
        ComponentGrid { columns: 1, column_step: 0, ..self }
    }

    /// The grid of one component, a scalar.
    pub fn cell(self) -> ComponentGrid {
        ComponentGrid { rows: 1, row_step: 0, ..self.column() }
    }

    /// Returns the type in a language's spelling.
    pub fn spelled(&self, language: Language) -> String {
        let (scalar, columns, rows) = (self.scalar, self.columns, self.rows);
        let ty = match (columns, rows) {
            (1, 1) => Type::Scalar(scalar),
            (1, _) => Type::Vector { scalar, rows },
            _ => Type::Matrix { scalar, columns, rows },
        };
        ty.spelled(language).to_string()
    }
}

/// An array dimension along a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Dim {
    /// The length; `None` if runtime-sized, then it is that of the buffer's tail.
    pub len: Option<usize>,
    pub stride: usize,
}

impl Dim {
    pub fn new(len: &ArrayLen, stride: u64) -> Dim {
        // A stride is less than the block's size, which fits.
        Dim { len: fixed(len).map(|len| len as usize), stride: stride as usize }
    }
}

/// Returns the language whose spelling messages about a block use.
pub(crate) fn language(block: &BlockLayout) -> Language {
    match block.rules {
        Rules::Wgsl => Language::Wgsl,
        Rules::Std140 | Rules::Std430 | Rules::Scalar | Rules::Explicit(_) => Language::Glsl,
    }
}

/// The bytes of a block that a buffer can hold.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ByteExtent {
    /// Bytes a buffer must hold; a runtime-sized tail counts as one element.
    pub size: usize,
    /// End of the last member, without a runtime-sized one.
    pub fixed_end: usize,
    /// The runtime-sized array at the end.
    pub tail: Option<Tail>,
}

/// A runtime-sized array at the end of a block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Tail {
    pub name: String,
    pub offset: usize,
    pub stride: usize,
}

impl ByteExtent {
    /// Returns the bytes for that many elements of the tail; `None` on overflow.
    ///
    /// Exactly the larger of [`size`](Self::size) and what the elements need: a shader derives the
    /// length of a runtime-sized array from the bytes bound.
    pub fn bytes(&self, elements: usize) -> Option<usize> {
        let Some(tail) = &self.tail else { return Some(self.size) };
        let end = tail.stride.checked_mul(elements)?.checked_add(tail.offset)?;
        let bytes = end.max(self.size);
        (bytes as u64 <= LARGEST_BLOCK).then_some(bytes)
    }

    /// Returns the number of tail elements a shader finds in that many bytes.
    pub fn elements(&self, bytes: usize) -> usize {
        match &self.tail {
            Some(tail) => bytes.saturating_sub(tail.offset) / tail.stride.max(1),
            None => 0,
        }
    }

    /// Returns the extent of a block.
    ///
    /// # Errors
    /// [`BufferError::NoBytes`], [`BufferError::Unsized`], [`BufferError::TooLarge`].
    pub fn from_block(block: &BlockLayout) -> Result<ByteExtent, BufferError> {
        let name = || block.name.to_string();
        let Some((size, data_size)) = block.size.zip(block.data_size) else {
            return Err(BufferError::NoBytes { block: name() });
        };
        let too_large = |bytes| BufferError::TooLarge { block: name(), bytes };
        let whole = |bytes: u64| usize::try_from(bytes).map_err(|_| too_large(bytes));
        // Only the outermost dimension of a block's last member can be left open.
        for leaf in &block.leaves {
            for (at, len) in leaf.dims.iter().enumerate() {
                let unsized_by = match len {
                    ArrayLen::Override(by) => by.to_string(),
                    ArrayLen::Runtime if at > 0 => "[]".to_string(),
                    ArrayLen::Runtime | ArrayLen::Fixed(_) => continue,
                };
                let path = leaf.path.clone();
                return Err(BufferError::Unsized { block: name(), path, name: unsized_by });
            }
        }
        let mut fixed_end = 0;
        let mut tail = None;
        // `data_size` counts one element of a tail: the end of the members before it is found here.
        for member in &block.members {
            let offset = whole(member.offset.unwrap_or(0))?;
            match (member.dims.first(), member.strides.first()) {
                (Some(ArrayLen::Runtime), Some(&stride)) => {
                    let (name, stride) = (member.name.to_string(), whole(stride)?);
                    tail = Some(Tail { name, offset, stride });
                }
                _ => fixed_end = fixed_end.max(offset + whole(member.size.unwrap_or(0))?),
            }
        }
        if tail.is_none() {
            fixed_end = whole(data_size)?;
        }
        Ok(ByteExtent { size: whole(size)?, fixed_end, tail })
    }
}
