//! Buffers for blocks: bytes set and read by member name.
//!
//! Reads the [model](crate::layout()). A [`Buffer`] owns the bytes of a uniform or storage buffer,
//! resolves member names to offsets, and tracks the bytes written since the last upload; [`encode`]
//! and [`decode`] convert between JSON and such bytes.
//!
//! A **path** is a leaf's name as OpenGL spells it, without the block: `data[3].color`. A column
//! (`view[2]`) or component (`color.x`, `.r`, `.s`, `color[0]`, `view[2].y`) may follow. The
//! instance's name (`u_lights.data[3].color`, as in the shader) or the block's
//! (`LightBlock.data[3].color`, as in OpenGL's queries) may precede it, unless a member has that
//! name. Full paths of leaves resolve fastest.
//!
//! ```
//! # extern crate landfall_layout as landfall;
//! use landfall::{Buffer, Options, Source, layout};
//!
//! let text = "struct Light { vec3 pos; vec3 color; float intensity; };
//!     layout(std140) uniform Lights { Light data[128]; int count; } u_lights;";
//! let lights = &layout(&Source::new("lights.frag", text), &Options::default()).blocks[0];
//! let mut buffer = Buffer::new(lights)?;
//! buffer.set("count", 1)?;
//! let color = buffer.handle::<[f32; 3]>("data[].color")?;
//! buffer.set_at(&color, [0], [1.0, 0.5, 0.25])?;
//! for range in buffer.dirty(64) {
//!     let _upload = (range.start, &buffer.bytes()[range]);
//! }
//! buffer.clear_dirty();
//! # Ok::<(), landfall::BufferError>(())
//! ```

mod components;
mod decode;
mod dirty;
mod encode;
mod error;
pub mod float;
mod grid;
mod handle;
mod index;
mod json;
mod number;
#[cfg(feature = "glam")]
mod of_glam;
mod padding;
mod pod;
mod resolve;
mod value;

use std::hash::BuildHasher;
use std::sync::Arc;

use rustc_hash::FxBuildHasher;

use crate::layout::BlockLayout;
use dirty::Tracked;
use grid::{ByteExtent, ComponentGrid, language};
use index::LeafIndex;
use resolve::resolve_leaf;
use value::ScalarMatch;

pub use components::Components;
pub use decode::{Decoded, Element, decode};
pub use dirty::{Ranges, Upload};
pub use encode::{Missing, encode};
pub use error::BufferError;
pub use handle::Handle;
#[doc(hidden)]
pub use json::kind;
pub use json::{EncodeError, read_json};
pub use number::ComponentBits;
#[doc(hidden)]
pub use number::{ComponentError, bits};
pub use padding::{Finding, Findings};
pub use value::{Component, Value};

/// The bytes of one block, with a record of the bytes written.
///
/// All bytes start as zero, padding included; setting by name never writes padding. A clone copies
/// the bytes and shares the compiled block, so cloning a buffer is cheaper than creating another.
#[derive(Clone, Debug)]
pub struct Buffer {
    compiled: Arc<IndexedBlock>,
    /// A hash of the block's fingerprint, the tail's length and the number of bytes, with
    /// [`FREE_BITS`] clear; handles for this buffer have the same and use these bits.
    key: u64,
    data: Tracked,
    /// Elements of the runtime-sized array at the end.
    tail: usize,
}

/// The bits of a [`Buffer::key`] that are left to handles.
const FREE_BITS: u64 = 0xff;

/// A block with its index of paths, shared by clones of a buffer.
#[derive(Debug)]
struct IndexedBlock {
    block: BlockLayout,
    extent: ByteExtent,
    index: LeafIndex,
}

impl Buffer {
    /// Creates a zeroed buffer for a block of fixed size: [`BlockLayout::size`] bytes.
    ///
    /// # Errors
    /// Loose uniforms; a size that depends on an override without a value; a runtime-sized array at
    /// the end (use [`with_tail`](Buffer::with_tail)).
    pub fn new(block: &BlockLayout) -> Result<Buffer, BufferError> {
        let extent = ByteExtent::from_block(block)?;
        match extent.tail {
            Some(tail) => {
                let (block, path) = (block.name.to_string(), format!("{}[]", tail.name));
                Err(BufferError::NeedsTail { block, path })
            }
            None => Buffer::sized(block, extent, 0),
        }
    }

    /// Creates a zeroed buffer for a block that ends in a runtime-sized array of that many
    /// elements.
    ///
    /// Its length is what the elements need, but at least [`BlockLayout::size`], which counts one:
    /// shaders derive the array's length from the bytes bound.
    ///
    /// # Errors
    /// Those of [`new`](Buffer::new), and a block without such an array.
    pub fn with_tail(block: &BlockLayout, elements: usize) -> Result<Buffer, BufferError> {
        let extent = ByteExtent::from_block(block)?;
        if extent.tail.is_none() {
            return Err(BufferError::NoTail { block: block.name.to_string() });
        }
        Buffer::sized(block, extent, elements)
    }

    /// Creates a buffer from existing bytes; nothing in it is dirty.
    ///
    /// # Errors
    /// Those of [`new`](Buffer::new), and bytes whose length is not the block's; a runtime-sized
    /// array has as many elements as fit.
    pub fn from_bytes(block: &BlockLayout, bytes: &[u8]) -> Result<Buffer, BufferError> {
        let extent = ByteExtent::from_block(block)?;
        let elements = extent.elements(bytes.len());
        if extent.bytes(elements) != Some(bytes.len()) {
            let (wanted, given) = (extent.size as u64, bytes.len() as u64);
            let block = block.name.to_string();
            return Err(BufferError::WrongLength { block, wanted, given, cut: None });
        }
        let mut buffer = Buffer::sized(block, extent, elements)?;
        buffer.data.bytes_mut().copy_from_slice(bytes);
        Ok(buffer)
    }

    fn sized(block: &BlockLayout, extent: ByteExtent, tail: usize) -> Result<Buffer, BufferError> {
        let len = len(block, &extent, tail)?;
        let data = Tracked::zeroed(len).ok_or_else(|| too_large(block, len))?;
        let index = LeafIndex::from_block(block);
        // Layout, tail and length in one word, so that `set_at` compares once.
        let key = FxBuildHasher.hash_one((index.fingerprint, tail, len)) & !FREE_BITS;
        let compiled = Arc::new(IndexedBlock { block: block.clone(), extent, index });
        Ok(Buffer { compiled, key, data, tail })
    }

    /// The block of the buffer.
    pub fn block(&self) -> &BlockLayout {
        &self.compiled.block
    }

    /// Elements of the runtime-sized array at the end; 0 if there is none.
    pub fn tail_len(&self) -> usize {
        self.tail
    }

    /// All bytes, ready for upload.
    #[inline]
    pub fn bytes(&self) -> &[u8] {
        self.data.bytes()
    }

    /// Returns all bytes, consuming the buffer.
    pub fn into_bytes(self) -> Vec<u8> {
        self.data.into_bytes()
    }

    /// Sets a scalar, vector or matrix by its path.
    ///
    /// # Errors
    /// A path that does not exist or names more than one value; an index out of range; a value
    /// whose type is not the shader's. Nothing is converted, except `f32` to a smaller float.
    #[inline]
    pub fn set<T: Value>(&mut self, path: &str, value: T) -> Result<(), BufferError> {
        // A row's code tells the type and that its components have no gaps. Everything else, errors
        // included, is found again by `set_resolved`, so that this path is short.
        match self.compiled.index.find(path, self.tail) {
            Some(row) if row.code == T::CODE && row.offset + T::BYTES <= self.bytes().len() => {
                self.store(row.offset as u32, value);
                Ok(())
            }
            _ => self.set_resolved(path, value),
        }
    }

    /// Sets a path that [`LeafIndex::find`] did not resolve: another spelling, components with gaps, or
    /// an error.
    #[inline(never)]
    fn set_resolved<T: Value>(&mut self, path: &str, value: T) -> Result<(), BufferError> {
        let (offset, grid) = self.leaf::<T>(path)?;
        if self.store_cells(offset, &grid, value) {
            return Ok(());
        }
        Err(self.out_of_bounds(offset, grid.span()))
    }

    fn out_of_bounds(&self, offset: usize, size: usize) -> BufferError {
        let (offset, size, len) = (offset as u64, size as u64, self.bytes().len() as u64);
        BufferError::OutOfBounds { offset, size, len }
    }

    /// Reads a scalar, vector or matrix by its path.
    ///
    /// # Errors
    /// Those of [`set`](Buffer::set).
    #[inline]
    pub fn get<T: Value>(&self, path: &str) -> Result<T, BufferError> {
        if let Some(row) = self.compiled.index.find(path, self.tail) {
            let from = self.bytes().get(row.offset..).and_then(|bytes| bytes.get(..T::BYTES));
            if let Some(from) = from.filter(|_| row.code == T::CODE) {
                return Ok(T::fetch(from));
            }
        }
        let (offset, grid) = self.leaf::<T>(path)?;
        self.load(offset, &grid).ok_or_else(|| self.out_of_bounds(offset, grid.span()))
    }

    /// Resolves a path in any spelling to the offset and grid of a leaf.
    fn leaf<T: Value>(&self, path: &str) -> Result<(usize, ComponentGrid), BufferError> {
        let block = self.block();
        let (offset, grid) = resolve_leaf(block, self.tail, path, None)?;
        if value::fit::<T>(&grid) == ScalarMatch::No {
            return Err(wrong_type::<T>(block, path, &grid));
        }
        Ok((offset, grid))
    }

    /// Writes a value without gaps, which lies within the buffer.
    #[inline]
    fn store<T: Value>(&mut self, offset: u32, value: T) -> bool {
        // Components of 4 or 8 bytes fill whole words of the record; smaller ones are marked by
        // bytes.
        match T::Component::WIDTH % dirty::WORD {
            0 => self.data.store(offset, value),
            _ => {
                let to = self.data.write(offset as usize, T::BYTES);
                to.map(|to| value.store(to)).is_some()
            }
        }
    }

    /// Writes a value component by component; `false` if it would end past the buffer.
    fn store_cells<T: Value>(&mut self, offset: usize, grid: &ComponentGrid, value: T) -> bool {
        let span = grid.span();
        // The whole span is checked before anything is written: an error leaves the buffer as it
        // was.
        let to = self.data.bytes_mut().get_mut(offset..).and_then(|bytes| bytes.get_mut(..span));
        let Some(to) = to else { return false };
        let fit = value::fit::<T>(grid);
        let width = usize::from(grid.scalar.width);
        let is_matrix = grid.columns > 1 && grid.rows > 1;
        for (column, row) in grid.cells() {
            let at = grid.component(column, row);
            let cell = &mut to[at..at + width];
            match fit {
                ScalarMatch::Same => value.component(column, row).put(cell),
                ScalarMatch::Narrowed => value.component(column, row).put_as(grid.scalar, cell),
                ScalarMatch::No => return false,
            }
        }
        if is_matrix {
            // The padding between columns is zero, and one range is cheaper than two to four.
            self.data.mark(offset, span);
        } else {
            for (column, row) in grid.cells() {
                self.data.mark(offset + grid.component(column, row), width);
            }
        }
        true
    }

    /// Reads a value; `None` if it would end past the buffer.
    #[inline]
    fn load<T: Value>(&self, offset: usize, grid: &ComponentGrid) -> Option<T> {
        let from = self.bytes().get(offset..)?.get(..grid.span())?;
        let width = usize::from(grid.scalar.width);
        let same = value::fit::<T>(grid) == ScalarMatch::Same;
        Some(T::build(|column, row| {
            let at = grid.component(column, row);
            let cell = &from[at..at + width];
            if same { T::Component::take(cell) } else { T::Component::take_as(grid.scalar, cell) }
        }))
    }

    /// Returns the ranges written since the last [`clear_dirty`](Buffer::clear_dirty), in order;
    /// ranges at most `gap` bytes apart are merged.
    pub fn dirty(&self, gap: usize) -> Ranges<'_> {
        self.data.ranges(gap)
    }

    /// Returns how many bytes in how many ranges an upload with that gap moves; a gap of 0 gives
    /// the fewest bytes.
    pub fn upload(&self, gap: usize) -> Upload {
        let start = Upload { ranges: 0, bytes: 0, whole: self.bytes().len() };
        self.dirty(gap).fold(start, |sum, range| Upload {
            ranges: sum.ranges + 1,
            bytes: sum.bytes + range.len(),
            whole: sum.whole,
        })
    }

    /// Clears the dirty ranges, after an upload.
    pub fn clear_dirty(&mut self) {
        self.data.clear();
    }

    /// Marks every byte as dirty, for a new buffer on the GPU.
    pub fn mark_all(&mut self) {
        self.data.mark(0, self.bytes().len());
    }
}

/// Returns the length of a block with that many elements in its tail.
fn len(block: &BlockLayout, extent: &ByteExtent, tail: usize) -> Result<usize, BufferError> {
    extent.bytes(tail).ok_or_else(|| too_large(block, usize::MAX))
}

/// Returns the zeroed bytes of a block with that many elements in its tail.
fn zeroes(block: &BlockLayout, extent: &ByteExtent, tail: usize) -> Result<Vec<u8>, BufferError> {
    let len = len(block, extent, tail)?;
    dirty::zeroed(len).ok_or_else(|| too_large(block, len))
}

fn too_large(block: &BlockLayout, bytes: usize) -> BufferError {
    BufferError::TooLarge { block: block.name.to_string(), bytes: bytes as u64 }
}

/// Returns the error for a value whose type is not the leaf's.
#[cold]
fn wrong_type<T: Value>(block: &BlockLayout, path: &str, grid: &ComponentGrid) -> BufferError {
    BufferError::WrongType {
        path: path.to_string(),
        shader: grid.spelled(language(block)),
        given: value::spelled::<T>(),
        wanted: value::rust_type(grid),
    }
}
