//! Encodes JSON values to the bytes of a block.
//!
//! Objects are structures; arrays are arrays, vectors, and matrices as lists of columns; components
//! are as [`ComponentBits`](super::ComponentBits) writes them. A key may also be a path: `"data[3].color"`.

use std::collections::HashSet;

use serde_json::{Map, Value};

use super::error::BufferError;
use super::grid::{ByteExtent, ComponentGrid, Tail, language};
use super::json::{EncodeError, kind};
use super::number::{ComponentError, bits};
use super::resolve::{PlaceKind, ResolvedPlace, resolve_in, spelled};
use super::value::put_bits;
use super::zeroes;
use crate::layout::measure::fixed;
use crate::layout::{BlockLayout, MemberLayout};
use crate::shape::Scalar;

/// The treatment of members, and elements at the end of arrays, without a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Missing {
    /// Missing values are zero.
    Zero,
    /// Missing values are an error.
    Error,
}

/// Encodes JSON to the bytes of a block; padding is zero.
///
/// A runtime-sized array at the end has as many elements as the JSON.
///
/// # Errors
/// A block of unknown size; keys that are not members; values that do not fit the shader's type;
/// missing members, if `missing` is [`Missing::Error`].
pub fn encode(
    block: &BlockLayout,
    values: &Value,
    missing: Missing,
) -> Result<Vec<u8>, EncodeError> {
    let extent = ByteExtent::from_block(block).map_err(EncodeError::Block)?;
    let tail = match (&extent.tail, values) {
        (Some(tail), Value::Object(map)) => elements(block, tail, map),
        _ => 0,
    };
    let bytes = zeroes(block, &extent, tail).map_err(EncodeError::Block)?;
    // A bit for each byte: 64 of them in a word.
    let given = vec![0; bytes.len() / 64 + 1];
    let mut encoder = Encoder { block, tail, bytes, given, path: String::new() };
    encoder.value(ResolvedPlace::BLOCK, values)?;
    // Second pass, for the error alone: values may be given by several spellings, so that only the
    // bytes tell what is missing.
    match missing {
        Missing::Zero => Ok(encoder.bytes),
        Missing::Error => {
            encoder.path.clear();
            match encoder.is_complete(ResolvedPlace::BLOCK) {
                true => Ok(encoder.bytes),
                false => Err(EncodeError::Missing { path: encoder.path }),
            }
        }
    }
}

/// Returns the number of tail elements an object gives, in any spelling.
// Before the bytes can be allocated: a runtime-sized array is as long as the longest that any key
// gives. Keys are `tail`, `tail[3].x`, `Block.tail`, or `Block` with an object below it.
fn elements(block: &BlockLayout, tail: &Tail, map: &Map<String, Value>) -> usize {
    let own = [block.instance.as_deref(), Some(&*block.name)];
    let of_entry = |(key, value): (&String, &Value)| {
        let prefix = own.iter().flatten().find_map(|name| key.strip_prefix(name));
        let within = prefix.and_then(|rest| rest.strip_prefix('.')).unwrap_or(key);
        match (prefix, within.strip_prefix(tail.name.as_str()), value) {
            // The block's name alone, unless the array itself is called so.
            (Some(""), _, Value::Object(inner)) if *key != tail.name => {
                elements(block, tail, inner)
            }
            (_, Some(""), Value::Array(items)) => items.len(),
            (_, Some(rest), _) => {
                let digits = rest.strip_prefix('[').and_then(|rest| rest.split(']').next());
                let index = digits.and_then(|digits| digits.parse::<usize>().ok());
                // The index of an element, so that one more is needed.
                index.map_or(0, |index| index.saturating_add(1))
            }
            _ => 0,
        }
    };
    map.iter().map(of_entry).max().unwrap_or(0)
}

struct Encoder<'b> {
    block: &'b BlockLayout,
    /// Elements of the runtime-sized array.
    tail: usize,
    bytes: Vec<u8>,
    /// A bit for each byte where a component that was written starts.
    given: Vec<u64>,
    /// The current path in the JSON.
    path: String,
}

impl<'b> Encoder<'b> {
    fn value(&mut self, place: ResolvedPlace<'b>, value: &Value) -> Result<(), EncodeError> {
        match place.what {
            PlaceKind::Block => self.object(&self.block.members, place, value),
            PlaceKind::Struct(member) => self.object(&member.members, place, value),
            PlaceKind::Array(member, dim) => self.array(place, member, dim, value),
            PlaceKind::Leaf(grid) => self.leaf(place.offset as usize, grid, value),
        }
    }

    fn object(
        &mut self,
        members: &'b [MemberLayout],
        place: ResolvedPlace<'b>,
        value: &Value,
    ) -> Result<(), EncodeError> {
        let Value::Object(map) = value else {
            return Err(self.wrong(place.what, "an object of members", value));
        };
        // Members are looked up in the object, in the order of the block; a key that is none of
        // them is a path such as `data[3].color`, resolved from here.
        let mut found = 0;
        for member in members {
            // All keys were members: those that follow are missing.
            if found == map.len() {
                return Ok(());
            }
            if let Some(value) = map.get(&*member.name) {
                found += 1;
                self.at(&member.name, |encoder| encoder.value(place.member(member), value))?;
            }
        }
        if found == map.len() {
            return Ok(());
        }
        // Only now, as objects whose keys are all members never come here.
        let names: HashSet<&str> = members.iter().map(|m| &*m.name).collect();
        for (key, value) in map.iter().filter(|(key, _)| !names.contains(key.as_str())) {
            let named = resolve_in(self.block, self.tail, key, place)
                .map_err(|error| self.no_key(error))?;
            self.at(key, |encoder| encoder.value(named, value))?;
        }
        Ok(())
    }

    fn array(
        &mut self,
        place: ResolvedPlace<'b>,
        member: &'b MemberLayout,
        dim: usize,
        value: &Value,
    ) -> Result<(), EncodeError> {
        let Value::Array(items) = value else {
            return Err(self.wrong(place.what, "an array", value));
        };
        let len = self.len(member, dim);
        if items.len() as u64 > len {
            return Err(self.length(spelled(self.block, place.what), len, items));
        }
        for (index, item) in items.iter().enumerate() {
            let element = place.element(member, dim, index as u64);
            self.index(index, |encoder| encoder.value(element, item))?;
        }
        Ok(())
    }

    fn leaf(
        &mut self,
        offset: usize,
        grid: ComponentGrid,
        value: &Value,
    ) -> Result<(), EncodeError> {
        let (columns, rows) = (usize::from(grid.columns), usize::from(grid.rows));
        let (len, wanted) = match (columns, rows) {
            (1, 1) => return self.cell(offset, grid.scalar, value),
            (1, rows) => (rows, format!("an array of {rows} numbers")),
            (columns, rows) => (columns, format!("an array of {columns} columns of {rows}")),
        };
        let Value::Array(items) = value else {
            return Err(self.wrong(PlaceKind::Leaf(grid), &wanted, value));
        };
        if items.len() != len {
            let ty = grid.spelled(language(self.block));
            return Err(self.length(ty, len as u64, items));
        }
        for (index, item) in items.iter().enumerate() {
            // An item is a component of a vector or a column of a matrix, whichever the majorness.
            let (at, inner) = match columns {
                1 => (grid.component(0, index), grid.cell()),
                _ => (grid.component(index, 0), grid.column()),
            };
            self.index(index, |encoder| encoder.leaf(offset + at, inner, item))?;
        }
        Ok(())
    }

    fn cell(&mut self, offset: usize, scalar: Scalar, value: &Value) -> Result<(), EncodeError> {
        let at = || self.path.clone();
        let ty = || {
            let ty = crate::shape::Type::Scalar(scalar);
            ty.spelled(language(self.block)).to_string()
        };
        let bits = bits(scalar, value).map_err(|unfit| match unfit {
            ComponentError::Kind(wanted) => {
                let (wanted, found) = (wanted.to_string(), kind(value));
                EncodeError::Kind { at: at(), ty: ty(), wanted, found }
            }
            ComponentError::Range => EncodeError::Range { at: at(), ty: ty(), found: kind(value) },
        })?;
        // The start of each component is in one place, however the key spells it.
        let bit = 1 << (offset % 64);
        if self.given[offset / 64] & bit != 0 {
            return Err(EncodeError::Twice { at: at() });
        }
        self.given[offset / 64] |= bit;
        put_bits(bits, &mut self.bytes[offset..offset + usize::from(scalar.width)]);
        Ok(())
    }

    /// Whether every component from a place on was written; if not, `path` names the first missing
    /// one.
    fn is_complete(&mut self, place: ResolvedPlace<'b>) -> bool {
        match place.what {
            PlaceKind::Block => self.are_complete(&self.block.members, place),
            PlaceKind::Struct(member) => self.are_complete(&member.members, place),
            PlaceKind::Array(member, dim) => (0..self.len(member, dim)).all(|index| {
                let element = place.element(member, dim, index);
                let before = self.path.len();
                // Shortened only where nothing is missing, so that the path remains that of the
                // first missing component.
                self.path.push_str(&format!("[{index}]"));
                self.is_complete(element) && {
                    self.path.truncate(before);
                    true
                }
            }),
            PlaceKind::Leaf(grid) => grid.cells().all(|(column, row)| {
                let at = place.offset as usize + grid.component(column, row);
                self.given[at / 64] & 1 << (at % 64) != 0
            }),
        }
    }

    fn are_complete(&mut self, members: &'b [MemberLayout], place: ResolvedPlace<'b>) -> bool {
        members.iter().all(|member| {
            let before = self.path.len();
            let dot = if before > 0 { "." } else { "" };
            self.path.push_str(&format!("{dot}{}", member.name));
            self.is_complete(place.member(member)) && {
                self.path.truncate(before);
                true
            }
        })
    }

    fn len(&self, member: &MemberLayout, dim: usize) -> u64 {
        fixed(&member.dims[dim]).unwrap_or(self.tail as u64)
    }

    /// Does something below a key.
    fn at<R>(&mut self, key: &str, then: impl FnOnce(&mut Self) -> R) -> R {
        let before = self.path.len();
        if before > 0 {
            self.path.push('.');
        }
        self.path.push_str(key);
        let result = then(self);
        self.path.truncate(before);
        result
    }

    /// Calls `then` with an index appended to the current path.
    fn index<R>(&mut self, index: usize, then: impl FnOnce(&mut Self) -> R) -> R {
        let before = self.path.len();
        self.path.push_str(&format!("[{index}]"));
        let result = then(self);
        self.path.truncate(before);
        result
    }

    /// Returns the error for a key that the enclosing object does not have.
    fn no_key(&self, error: BufferError) -> EncodeError {
        let at = self.path.clone();
        let below = |path: String| if at.is_empty() { path } else { format!("{at}.{path}") };
        let error = match error {
            // A path in the error begins at the object that was read; the user's begins at the
            // root.
            BufferError::UnknownPath { path, name, inside, nearest } => BufferError::UnknownPath {
                path: below(path),
                name,
                inside: if inside.is_empty() { at.clone() } else { below(inside) },
                nearest: nearest.map(below),
            },
            error => return EncodeError::Key { at, error },
        };
        EncodeError::Key { at: String::new(), error }
    }

    fn wrong(&self, what: PlaceKind<'_>, wanted: &str, found: &Value) -> EncodeError {
        EncodeError::Kind {
            at: self.path.clone(),
            ty: spelled(self.block, what),
            wanted: wanted.to_string(),
            found: kind(found),
        }
    }

    fn length(&self, ty: String, wanted: u64, items: &[Value]) -> EncodeError {
        EncodeError::Length { at: self.path.clone(), ty, wanted, found: items.len() as u64 }
    }
}

impl From<BufferError> for EncodeError {
    fn from(error: BufferError) -> EncodeError {
        EncodeError::Block(error)
    }
}
