//! The bytes of a block to values by name: JSON, or rows of a table.
//!
//! Nothing is copied: values are read from the bytes as they are written out.

use std::fmt::Write;

use serde::ser::{SerializeMap, SerializeSeq};
use serde::{Serialize, Serializer};

use super::error::BufferError;
use super::grid::{Extent, Grid, language};
use super::number::Datum;
use super::padding::{Findings, find, name_at};
use super::resolve::{Place, What};
use super::value::take_bits;
use crate::layout::{BlockLayout, MemberLayout};
use crate::shape::ArrayLen;

/// The values in a block's bytes. Serializes as the JSON that [`encode`](super::encode()) takes,
/// members in the order of the shader.
#[derive(Clone, Debug)]
pub struct Decoded<'a> {
    pub(crate) block: &'a BlockLayout,
    pub(crate) bytes: &'a [u8],
    /// Elements of the runtime-sized array.
    pub(crate) tail: usize,
    /// Bytes and values that look wrong, in order of their offsets.
    pub findings: Findings,
    /// What is odd about the length.
    pub notes: Vec<String>,
}

/// One element of a leaf with its components.
#[derive(Clone, Copy, Debug)]
pub struct Element<'r> {
    /// `data[3].color`.
    pub path: &'r str,
    /// From the start of the block.
    pub offset: u64,
    /// The type, in the shader's spelling.
    pub ty: &'r str,
    /// Components of a column: a vector's all, a scalar's one.
    pub rows: usize,
    /// Its components, column by column.
    pub cells: &'r [Datum],
    pub(crate) grid: Grid,
}

/// Reads the bytes of a block.
///
/// Bytes that lack nothing but padding at the end, and bytes past the end, are noted.
///
/// # Errors
/// A block whose length is not known, and fewer bytes than its members take.
pub fn decode<'a>(block: &'a BlockLayout, bytes: &'a [u8]) -> Result<Decoded<'a>, BufferError> {
    let extent = Extent::of(block)?;
    if bytes.len() < extent.fixed_end {
        let cut = (bytes.len()..extent.fixed_end).find_map(|byte| name_at(block, byte as u64));
        let (wanted, given) = (extent.size as u64, bytes.len() as u64);
        let block = block.name.to_string();
        return Err(BufferError::WrongLength { block, wanted, given, cut });
    }
    let tail = extent.elements(bytes.len());
    let mut notes = Vec::new();
    let whole = extent.bytes(tail).unwrap_or(extent.size);
    let (given, name) = (bytes.len(), &block.name);
    if given > whole && extent.tail.is_none() {
        notes.push(format!("{} bytes follow the {whole} of `{name}`", given - whole));
    } else if given < extent.size {
        notes.push(format!(
            "{given} bytes hold every member of `{name}`, but a buffer for it must hold {}",
            extent.size
        ));
    }
    if let Some(tail) = &extent.tail {
        let rest = given.saturating_sub(tail.offset) % tail.stride.max(1);
        if rest > 0 && given > extent.size {
            let array = &tail.name;
            notes.push(format!("{rest} bytes follow the last whole element of `{array}`"));
        }
    }
    let bytes = if extent.tail.is_none() { &bytes[..given.min(whole)] } else { bytes };
    let mut decoded = Decoded { block, bytes, tail, findings: Findings::default(), notes };
    decoded.findings = find(&decoded);
    Ok(decoded)
}

impl<'a> Decoded<'a> {
    /// The elements of the runtime-sized array at the end; 0 where there is none.
    pub fn tail_len(&self) -> usize {
        self.tail
    }

    /// Gives every element of every leaf, in the order of the shader.
    pub fn for_each(&self, mut then: impl FnMut(Element<'_>)) {
        let mut path = String::new();
        self.walk(Place::BLOCK, &mut path, &mut then);
    }

    fn walk(&self, place: Place<'a>, path: &mut String, then: &mut dyn FnMut(Element<'_>)) {
        let before = path.len();
        match place.what {
            What::Block | What::Struct(_) => {
                for member in self.members(place.what) {
                    if before > 0 {
                        path.push('.');
                    }
                    path.push_str(&member.name);
                    self.walk(place.member(member), path, then);
                    path.truncate(before);
                }
            }
            What::Array(member, dim) => {
                for index in 0..self.len(member, dim) {
                    let _ = write!(path, "[{index}]");
                    self.walk(place.element(member, dim, index), path, then);
                    path.truncate(before);
                }
            }
            What::Leaf(grid) => {
                let mut cells = [Datum { scalar: grid.scalar, bits: 0 }; 16];
                let mut count = 0;
                for (cell, (column, row)) in cells.iter_mut().zip(grid.cells()) {
                    *cell = self.datum(place.offset, &grid, column, row);
                    count += 1;
                }
                let ty = grid.spelled(language(self.block));
                then(Element {
                    path,
                    offset: place.offset,
                    ty: &ty,
                    rows: grid.rows.into(),
                    cells: &cells[..count],
                    grid,
                });
            }
        }
    }

    fn members(&self, what: What<'a>) -> &'a [MemberLayout] {
        match what {
            What::Block => &self.block.members,
            What::Struct(member) => &member.members,
            What::Array(..) | What::Leaf(_) => &[],
        }
    }

    fn len(&self, member: &MemberLayout, dim: usize) -> u64 {
        match member.dims[dim] {
            ArrayLen::Fixed(len) => len.into(),
            ArrayLen::Runtime | ArrayLen::Override(_) => self.tail as u64,
        }
    }

    fn datum(&self, offset: u64, grid: &Grid, column: usize, row: usize) -> Datum {
        let at = offset as usize + grid.component(column, row);
        let bits = take_bits(&self.bytes[at..at + usize::from(grid.scalar.width)]);
        Datum { scalar: grid.scalar, bits }
    }
}

impl Serialize for Decoded<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        At { decoded: self, place: Place::BLOCK }.serialize(serializer)
    }
}

/// What stands at a place, to be serialized.
struct At<'d, 'a> {
    decoded: &'d Decoded<'a>,
    place: Place<'a>,
}

impl Serialize for At<'_, '_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let At { decoded, place } = *self;
        match place.what {
            What::Block | What::Struct(_) => {
                let members = decoded.members(place.what);
                let mut map = serializer.serialize_map(Some(members.len()))?;
                for member in members {
                    map.serialize_entry(
                        &*member.name,
                        &At { decoded, place: place.member(member) },
                    )?;
                }
                map.end()
            }
            What::Array(member, dim) => {
                let len = decoded.len(member, dim);
                let mut seq = serializer.serialize_seq(Some(len as usize))?;
                for index in 0..len {
                    let place = place.element(member, dim, index);
                    seq.serialize_element(&At { decoded, place })?;
                }
                seq.end()
            }
            What::Leaf(grid) => {
                let (columns, rows) = (usize::from(grid.columns), usize::from(grid.rows));
                let cell = |column, row| decoded.datum(place.offset, &grid, column, row);
                let column = |column| (0..rows).map(|row| cell(column, row)).collect::<Vec<_>>();
                match (columns, rows) {
                    (1, 1) => cell(0, 0).serialize(serializer),
                    (1, _) => column(0).serialize(serializer),
                    _ => serializer.collect_seq((0..columns).map(column)),
                }
            }
        }
    }
}
