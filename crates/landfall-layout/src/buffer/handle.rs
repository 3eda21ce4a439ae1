//! Handles: paths of leaves resolved once, to set and read many times.

use std::marker::PhantomData;

use super::dirty::{DirtyPlace, WORD};
use super::error::BufferError;
use super::grid::{ComponentGrid, Dim};
use super::resolve::resolve_leaf;
use super::value;
use super::value::{Component, ScalarMatch, Value};
use super::{Buffer, wrong_type};

/// A resolved leaf of a block, with the Rust type it is set from and read as.
///
/// Created by [`Buffer::handle`]; works with every buffer of a block with the same layout.
#[derive(Clone, Debug)]
pub struct Handle<T> {
    /// The buffer's key combined with the number of open dimensions, or with [`NOT_PLAIN`] where the
    /// components cannot be copied as they are or an element ends past the buffer.
    key: u64,
    /// The first element.
    place: DirtyPlace,
    /// Length of the first open dimension; 1 if there is none.
    len: usize,
    stride: usize,
    /// The open dimensions, outermost first.
    dims: Box<[Dim]>,
    fingerprint: u64,
    grid: ComponentGrid,
    path: Box<str>,
    value: PhantomData<fn() -> T>,
}

/// Exceeds the number of dimensions of a path that is copied as it is.
const NOT_PLAIN: u64 = super::FREE_BITS;

impl<T> Handle<T> {
    /// The path the handle was created from.
    pub fn path(&self) -> &str {
        &self.path
    }
}

impl<T: Value> Handle<T> {
    pub(super) fn new(buffer: &Buffer, path: &str) -> Result<Handle<T>, BufferError> {
        let block = buffer.block();
        let mut dims = Vec::new();
        let mut open = |dim| dims.push(dim);
        let (offset, grid) = resolve_leaf(block, buffer.tail, path, Some(&mut open))?;
        let fit = value::fit::<T>(&grid);
        if fit == ScalarMatch::No {
            return Err(wrong_type::<T>(block, path, &grid));
        }
        // Where the last element of all open dimensions ends: if that is in the buffer, so is every
        // element whose indices are in range, and `locate` needs no check and cannot overflow.
        let end = dims.iter().fold(offset.saturating_add(grid.span()), |end, dim| {
            let last = dim.len.unwrap_or(buffer.tail).saturating_sub(1);
            end.saturating_add(last.saturating_mul(dim.stride))
        });
        let is_plain = fit == ScalarMatch::Same
            && grid.is_plain()
            && end <= buffer.bytes().len()
            && buffer.data.has_places()
            && (dims.len() as u64) < NOT_PLAIN;
        let first = dims.first().copied().unwrap_or(Dim { len: Some(1), stride: 0 });
        Ok(Handle {
            key: buffer.key | if is_plain { dims.len() as u64 } else { NOT_PLAIN },
            place: buffer.data.place(offset, grid.span()),
            len: first.len.unwrap_or(buffer.tail),
            stride: first.stride,
            dims: dims.into(),
            fingerprint: buffer.compiled.index.fingerprint,
            grid,
            path: path.into(),
            value: PhantomData,
        })
    }
}

impl Buffer {
    /// Resolves a path to a handle; `[]` leaves an index open: `data[].color`, `w[2][]`.
    ///
    /// # Errors
    /// Those of [`set`](Buffer::set) about the path and the type.
    pub fn handle<T: Value>(&self, path: &str) -> Result<Handle<T>, BufferError> {
        Handle::new(self, path)
    }

    /// Sets the element of a handle at `at`, one index per open dimension.
    ///
    /// # Errors
    /// An index out of range, or a handle of another block.
    #[inline]
    pub fn set_at<T: Value, const N: usize>(
        &mut self,
        handle: &Handle<T>,
        at: [usize; N],
        value: T,
    ) -> Result<(), BufferError> {
        let stored = match self.locate(handle, &at) {
            Some(_) if N == 0 && T::Component::WIDTH % WORD == 0 => {
                self.data.store_at(handle.place, value)
            }
            Some(offset) => self.store(offset, value),
            None => false,
        };
        if stored {
            return Ok(());
        }
        // Copies, so that the fast path need not keep them in memory.
        let (at, value) = (at.map(|index| index), T::build(|c, r| value.component(c, r)));
        self.set_slowly(handle, &at, value)
    }

    /// Reads the element of a handle at `at`, one index per open dimension.
    ///
    /// # Errors
    /// An index out of range, or a handle of another block.
    #[inline]
    pub fn get_at<T: Value, const N: usize>(
        &self,
        handle: &Handle<T>,
        at: [usize; N],
    ) -> Result<T, BufferError> {
        let from = self.locate(handle, &at).and_then(|offset| self.bytes().get(offset as usize..));
        match from.and_then(|from| from.get(..T::BYTES)) {
            Some(from) => Ok(T::fetch(from)),
            None => self.get_slowly(handle, &at),
        }
    }

    /// Returns the offset of an element, if the handle fits this buffer, its components have no
    /// gaps, and the indices are in range.
    #[inline]
    fn locate<T, const N: usize>(&self, handle: &Handle<T>, at: &[usize; N]) -> Option<u32> {
        // One comparison for the layout, the tail, the length, the number of indices, and whether
        // the components have no gaps.
        if handle.key != self.key.wrapping_add(N as u64) {
            return None;
        }
        let mut offset = handle.place.offset();
        if let Some((&index, rest)) = at.split_first() {
            if index >= handle.len {
                return None;
            }
            // No overflow for indices in range: their product is less than the buffer's length.
            offset = offset.wrapping_add((index as u32).wrapping_mul(handle.stride as u32));
            for (dim, &index) in handle.dims.iter().skip(1).zip(rest) {
                // Only the first dimension of a block's array may be runtime-sized.
                if index >= dim.len? {
                    return None;
                }
                offset = offset.wrapping_add((index as u32).wrapping_mul(dim.stride as u32));
            }
        }
        Some(offset)
    }

    /// Returns the offset of an element, if the handle fits this buffer and the indices are in
    /// range.
    fn locate_slowly<T>(&self, handle: &Handle<T>, at: &[usize]) -> Option<usize> {
        // A buffer with another tail, or of another length, has another key but the same
        // fingerprint.
        if handle.fingerprint != self.compiled.index.fingerprint || handle.dims.len() != at.len() {
            return None;
        }
        handle.dims.iter().zip(at).try_fold(
            handle.place.offset() as usize,
            |offset, (dim, &index)| {
                (index < dim.len.unwrap_or(self.tail)).then(|| offset + index * dim.stride)
            },
        )
    }

    #[inline(never)]
    fn set_slowly<T: Value>(
        &mut self,
        handle: &Handle<T>,
        at: &[usize],
        value: T,
    ) -> Result<(), BufferError> {
        match self.locate_slowly(handle, at) {
            Some(offset) if self.store_cells(offset, &handle.grid, value) => Ok(()),
            _ => Err(self.cannot_locate(handle, at)),
        }
    }

    #[inline(never)]
    fn get_slowly<T: Value>(&self, handle: &Handle<T>, at: &[usize]) -> Result<T, BufferError> {
        let offset = self.locate_slowly(handle, at);
        let read = offset.and_then(|offset| self.load(offset, &handle.grid));
        read.ok_or_else(|| self.cannot_locate(handle, at))
    }

    #[cold]
    fn cannot_locate<T>(&self, handle: &Handle<T>, at: &[usize]) -> BufferError {
        let path = handle.path.to_string();
        if handle.fingerprint != self.compiled.index.fingerprint {
            return BufferError::OtherBlock { block: self.block().name.to_string() };
        }
        if handle.dims.len() != at.len() {
            let (wanted, given) = (handle.dims.len(), at.len());
            return BufferError::WrongIndices { path, wanted, given };
        }
        for (dim, &index) in handle.dims.iter().zip(at) {
            let len = dim.len.unwrap_or(self.tail);
            if index >= len {
                return super::resolve::out_of_range(&path, index as u64, len as u64, *dim);
            }
        }
        // The element lies past this buffer's tail, or past the size of a wrong layout.
        let offset = self.locate_slowly(handle, at).unwrap_or(handle.place.offset() as usize);
        self.out_of_bounds(offset, handle.grid.span())
    }
}
