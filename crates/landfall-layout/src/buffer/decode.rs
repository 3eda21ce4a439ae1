//! Decodes the bytes of a block to named values: JSON, or rows of a table.
//!
//! Values are read from the bytes as they are written out; nothing is copied.

use std::convert::Infallible;
use std::fmt::Write;
use std::ops::Range;

use serde::ser::{SerializeMap, SerializeSeq};
use serde::{Serialize, Serializer};

use super::error::BufferError;
use super::grid::{ByteExtent, ComponentGrid, language};
use super::number::ComponentBits;
use super::padding::{Finding, Findings, finding, name_at};
use super::resolve::{PlaceKind, ResolvedPlace, resolve, size};
use super::value::take_bits;
use crate::layout::measure::fixed;
use crate::layout::{BlockLayout, MemberLayout};
use crate::text::counts;

/// The values in a block's bytes. Serializes as the JSON that [`encode`](super::encode()) accepts,
/// with members in declaration order.
#[derive(Clone, Debug)]
pub struct Decoded<'a> {
    pub(crate) block: &'a BlockLayout,
    pub(crate) bytes: &'a [u8],
    /// Elements of the runtime-sized array.
    pub(crate) tail: usize,
    /// The selected part; the whole block unless [`only`](Decoded::only) was called.
    root: ResolvedPlace<'a>,
    path: String,
    /// Suspicious bytes and values, by offset.
    pub findings: Findings,
    /// Remarks on the number of bytes.
    pub notes: Vec<String>,
}

/// One element of a leaf with its components.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Element<'r> {
    /// The path: `data[3].color`.
    pub path: &'r str,
    /// Offset from the start of the block.
    pub offset: u64,
    /// The type in the shader's spelling.
    pub ty: &'r str,
    /// Components per column: all of a vector's, one for a scalar.
    pub rows: usize,
    /// The components, column by column.
    pub cells: &'r [ComponentBits],
    pub(crate) grid: ComponentGrid,
}

/// Decodes the bytes of a block.
///
/// Missing padding at the end and bytes past the end are noted.
///
/// # Errors
/// A block of unknown size, or fewer bytes than its members need.
pub fn decode<'a>(block: &'a BlockLayout, bytes: &'a [u8]) -> Result<Decoded<'a>, BufferError> {
    let extent = ByteExtent::from_block(block)?;
    // Padding at the end may be missing; bytes of members may not. The first of these is named.
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
        let more = counts::bytes((given - whole) as u64);
        notes.push(format!("{more} follow the {} of `{name}`", counts::number(whole as u64)));
    } else if given < extent.size {
        notes.push(format!(
            "{} hold every member of `{name}`, but a buffer for it must hold {}",
            counts::bytes(given as u64),
            counts::number(extent.size as u64)
        ));
    }
    // A rest is noted only for a buffer that holds more than the least, which counts one element
    // and may end in padding that is no whole element.
    if let Some(tail) = &extent.tail {
        let rest = given.saturating_sub(tail.offset) % tail.stride.max(1);
        if rest > 0 && given > extent.size {
            let array = &tail.name;
            notes.push(format!("bytes past the last whole element of `{array}`: {rest}"));
        }
    }
    // A runtime-sized array has elements up to the last byte; otherwise all later bytes are
    // ignored.
    let bytes = if extent.tail.is_none() { &bytes[..given.min(whole)] } else { bytes };
    let (root, path, findings) = (ResolvedPlace::BLOCK, String::new(), Findings::default());
    let mut decoded = Decoded { block, bytes, tail, root, path, findings, notes };
    decoded.findings = find(&decoded);
    Ok(decoded)
}

/// Finds suspicious values in the selected part of a block's bytes.
fn find(decoded: &Decoded<'_>) -> Findings {
    // One bit for each byte of the block: set where a component is. Of the whole block, since
    // padding of the selected part is what no member uses, not what no selected member uses.
    let mut used = vec![0u64; decoded.bytes.len() / 64 + 1];
    let mut found = Findings::default();
    decoded.for_each_of_block(|element| {
        for (column, row) in element.grid.cells() {
            let offset = element.offset as usize + element.grid.component(column, row);
            for byte in offset..offset + usize::from(element.grid.scalar.width) {
                used[byte / 64] |= 1 << (byte % 64);
            }
        }
    });
    decoded.for_each(|element| {
        let grid = element.grid;
        for (datum, (column, row)) in element.cells.iter().zip(grid.cells()) {
            let offset = element.offset + grid.component(column, row) as u64;
            if let Some(finding) = finding(*datum, element.path, &grid, (column, row), offset) {
                found.push(finding);
            }
        }
    });
    // Runs of unused bytes, of which those that are not zero were likely meant for a member.
    let is_used = |byte: usize| used[byte / 64] & 1 << (byte % 64) != 0;
    let range = decoded.range();
    let mut at = range.start;
    while at < range.end {
        if is_used(at) {
            at += 1;
            continue;
        }
        let end = (at..range.end).find(|&byte| is_used(byte)).unwrap_or(range.end);
        let hole = &decoded.bytes[at..end];
        if let Some(first) = hole.iter().position(|&byte| byte != 0) {
            let last = hole.iter().rposition(|&byte| byte != 0).unwrap_or(first);
            let name = |byte: Option<usize>| name_at(decoded.block, byte? as u64);
            found.push(Finding::Padding {
                offset: (at + first) as u64,
                bytes: hole[first..=last].to_vec(),
                after: name(at.checked_sub(1)),
                before: name(Some(end).filter(|&end| end < decoded.bytes.len())),
            });
        }
        at = end;
    }
    found.list.sort_by_key(Finding::offset);
    found
}

impl<'a> Decoded<'a> {
    /// Elements of the runtime-sized array at the end; 0 if there is none.
    pub fn tail_len(&self) -> usize {
        self.tail
    }

    /// The block.
    pub fn block(&self) -> &'a BlockLayout {
        self.block
    }

    /// Number of bytes decoded.
    pub fn len(&self) -> usize {
        self.bytes.len()
    }

    /// Whether there are no bytes.
    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// Restricts the values and findings to one path: `data[3]`, `data[3].color`, `view`.
    ///
    /// Serializes as an object with that path as its key, which [`encode`](super::encode()) accepts
    /// too.
    ///
    /// # Errors
    /// A path that does not exist, or an index out of range.
    pub fn only(self, path: &str) -> Result<Decoded<'a>, BufferError> {
        let root = resolve(self.block, self.tail, path, None)?;
        let path = match root.what {
            PlaceKind::Block => String::new(),
            PlaceKind::Struct(_) | PlaceKind::Array(..) | PlaceKind::Leaf(_) => path.to_string(),
        };
        let mut part = Decoded { root, path, ..self };
        part.findings = find(&part);
        Ok(part)
    }

    /// The bytes of the selected part, its padding included.
    pub(crate) fn range(&self) -> Range<usize> {
        let len = self.bytes.len();
        let start = self.root.offset as usize;
        let end = match self.root.what {
            PlaceKind::Block => len,
            PlaceKind::Struct(_) | PlaceKind::Array(..) | PlaceKind::Leaf(_) => {
                match size(self.block, self.root.what) {
                    Some(size) => len.min(start.saturating_add(size as usize)),
                    None => len,
                }
            }
        };
        start..end
    }

    /// Calls `then` with every element of every leaf, in declaration order.
    pub fn for_each(&self, mut then: impl FnMut(Element<'_>)) {
        let done: Result<(), Infallible> = self.try_for_each(|element| {
            then(element);
            Ok(())
        });
        let Ok(()) = done;
    }

    /// Calls `then` with every element of every leaf, in declaration order, until it fails.
    ///
    /// # Errors
    /// The error of `then`.
    pub fn try_for_each<E>(
        &self,
        mut then: impl FnMut(Element<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.walk(self.root, &mut self.path.clone(), &mut then)
    }

    /// Calls `then` with every element of the block, ignoring the selection.
    pub(crate) fn for_each_of_block(&self, mut then: impl FnMut(Element<'_>)) {
        let mut then = |element: Element<'_>| {
            then(element);
            Ok(())
        };
        let done: Result<(), Infallible> =
            self.walk(ResolvedPlace::BLOCK, &mut String::new(), &mut then);
        let Ok(()) = done;
    }

    fn walk<E>(
        &self,
        place: ResolvedPlace<'a>,
        path: &mut String,
        then: &mut dyn FnMut(Element<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let before = path.len();
        match place.what {
            PlaceKind::Block | PlaceKind::Struct(_) => {
                for member in self.members(place.what) {
                    if before > 0 {
                        path.push('.');
                    }
                    path.push_str(&member.name);
                    self.walk(place.member(member), path, then)?;
                    path.truncate(before);
                }
            }
            PlaceKind::Array(member, dim) => {
                for index in 0..self.count(member, dim) {
                    let _ = write!(path, "[{index}]");
                    self.walk(place.element(member, dim, index), path, then)?;
                    path.truncate(before);
                }
            }
            PlaceKind::Leaf(grid) => {
                // A `mat4` has the most components: 16.
                let mut cells = [ComponentBits { scalar: grid.scalar, bits: 0 }; 16];
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
                })?;
            }
        }
        Ok(())
    }

    fn members(&self, what: PlaceKind<'a>) -> &'a [MemberLayout] {
        match what {
            PlaceKind::Block => &self.block.members,
            PlaceKind::Struct(member) => &member.members,
            PlaceKind::Array(..) | PlaceKind::Leaf(_) => &[],
        }
    }

    fn count(&self, member: &MemberLayout, dim: usize) -> u64 {
        fixed(&member.dims[dim]).unwrap_or(self.tail as u64)
    }

    fn datum(&self, offset: u64, grid: &ComponentGrid, column: usize, row: usize) -> ComponentBits {
        let at = offset as usize + grid.component(column, row);
        let bits = take_bits(&self.bytes[at..at + usize::from(grid.scalar.width)]);
        ComponentBits { scalar: grid.scalar, bits }
    }
}

impl Serialize for Decoded<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let at = DecodedPlace { decoded: self, place: self.root };
        match self.path.as_str() {
            "" => at.serialize(serializer),
            path => serializer.collect_map([(path, at)]),
        }
    }
}

/// A place with its value, for serialization.
struct DecodedPlace<'d, 'a> {
    decoded: &'d Decoded<'a>,
    place: ResolvedPlace<'a>,
}

impl Serialize for DecodedPlace<'_, '_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let DecodedPlace { decoded, place } = *self;
        match place.what {
            PlaceKind::Block | PlaceKind::Struct(_) => {
                let members = decoded.members(place.what);
                let mut map = serializer.serialize_map(Some(members.len()))?;
                for member in members {
                    map.serialize_entry(
                        &*member.name,
                        &DecodedPlace { decoded, place: place.member(member) },
                    )?;
                }
                map.end()
            }
            PlaceKind::Array(member, dim) => {
                let len = decoded.count(member, dim);
                let mut seq = serializer.serialize_seq(Some(len as usize))?;
                for index in 0..len {
                    let place = place.element(member, dim, index);
                    seq.serialize_element(&DecodedPlace { decoded, place })?;
                }
                seq.end()
            }
            PlaceKind::Leaf(grid) => {
                // A scalar is a number, a vector an array, a matrix an array of its columns in
                // either majorness.
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
