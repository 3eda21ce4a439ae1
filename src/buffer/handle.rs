//! A leaf resolved once, to be set and read many times without its name.

use std::marker::PhantomData;

use super::error::BufferError;
use super::grid::{Dim, Grid};
use super::resolve::{What, not_a_leaf, resolve};
use super::value::{self, Fit, Value};
use super::{Buffer, wrong_type};

/// A leaf of a block, with the Rust type that it is set from and read as.
///
/// Made by [`Buffer::handle`]; works with every buffer of a block that is laid out alike.
#[derive(Clone, Debug)]
pub struct Handle<T> {
    fingerprint: u64,
    /// Of the first element.
    offset: usize,
    /// The dimensions left open, outermost first.
    dims: Box<[Dim]>,
    plain: bool,
    grid: Grid,
    path: Box<str>,
    value: PhantomData<fn() -> T>,
}

impl<T> Handle<T> {
    /// The path it was made of.
    pub fn path(&self) -> &str {
        &self.path
    }
}

impl<T: Value> Handle<T> {
    pub(super) fn new(buffer: &Buffer, path: &str) -> Result<Handle<T>, BufferError> {
        let block = buffer.block();
        let mut dims = Vec::new();
        let place = resolve(block, buffer.tail, path, Some(&mut |dim| dims.push(dim)))?;
        let What::Leaf(grid) = place.what else {
            return Err(not_a_leaf(block, path, place.what));
        };
        let fit = value::fit::<T>(&grid);
        if fit == Fit::No {
            return Err(wrong_type::<T>(block, path, &grid));
        }
        Ok(Handle {
            fingerprint: buffer.compiled.index.fingerprint,
            offset: place.offset as usize,
            dims: dims.into(),
            plain: fit == Fit::Same && grid.is_plain(),
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
    /// What [`set`](Buffer::set) says of a path and a type.
    pub fn handle<T: Value>(&self, path: &str) -> Result<Handle<T>, BufferError> {
        Handle::new(self, path)
    }

    /// Sets the element of a handle at those indices, as many as it left open.
    ///
    /// # Errors
    /// An index out of range, or the handle of another block.
    #[inline]
    pub fn set_at<T: Value, const N: usize>(
        &mut self,
        handle: &Handle<T>,
        at: [usize; N],
        value: T,
    ) -> Result<(), BufferError> {
        let Some(offset) = self.locate(handle, &at) else {
            return Err(self.cannot_locate(handle, &at));
        };
        let stored = match handle.plain {
            true => self.store(offset, value),
            false => self.store_cells(offset, &handle.grid, value),
        };
        if stored { Ok(()) } else { Err(self.cannot_locate(handle, &at)) }
    }

    /// Reads the element of a handle at those indices, as many as it left open.
    ///
    /// # Errors
    /// An index out of range, or the handle of another block.
    #[inline]
    pub fn get_at<T: Value, const N: usize>(
        &self,
        handle: &Handle<T>,
        at: [usize; N],
    ) -> Result<T, BufferError> {
        let offset = self.locate(handle, &at);
        match offset.and_then(|offset| self.load(offset, &handle.grid)) {
            Some(value) => Ok(value),
            None => Err(self.cannot_locate(handle, &at)),
        }
    }

    /// The offset of an element, if handle and indices are those of this buffer.
    #[inline]
    fn locate<T>(&self, handle: &Handle<T>, at: &[usize]) -> Option<usize> {
        if handle.fingerprint != self.fingerprint || handle.dims.len() != at.len() {
            return None;
        }
        let mut offset = handle.offset;
        for (dim, &index) in handle.dims.iter().zip(at) {
            if index >= dim.len.unwrap_or(self.tail) {
                return None;
            }
            offset += index * dim.stride;
        }
        Some(offset)
    }

    #[cold]
    fn cannot_locate<T>(&self, handle: &Handle<T>, at: &[usize]) -> BufferError {
        let path = handle.path.to_string();
        if handle.fingerprint != self.fingerprint {
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
        // The handle itself names an element that this buffer's tail does not have.
        let (offset, size) = (handle.offset as u64, handle.grid.span() as u64);
        BufferError::OutOfBounds { offset, size, len: self.bytes.len() as u64 }
    }
}
