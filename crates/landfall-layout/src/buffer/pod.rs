//! Mirrors read and written as a whole: structures, arrays and blocks as `bytemuck` types.

use bytemuck::Pod;

use super::Buffer;
use super::error::BufferError;
use super::resolve::{PlaceKind, data_size, resolve, size, spelled};
use crate::layout::measure::fixed;

/// The sizes a mirror of a place may have.
struct Sizes {
    offset: usize,
    /// Size including the padding at the end.
    size: usize,
    /// Size without it.
    data_size: usize,
    /// The type in the shader's spelling.
    what: String,
}

impl Buffer {
    /// Writes a mirror at a path: that of an element of an array of structures, a structure, an
    /// array, a leaf, or with `""` the block (the part before a runtime-sized array at its end).
    ///
    /// The bytes are copied as they are, so the mirror's own padding must be zeroed where that
    /// matters; padding at the end is omitted.
    ///
    /// # Errors
    /// A path that does not exist, or a mirror whose size is neither that of the place with the
    /// padding at its end nor without.
    pub fn write_pod<T: Pod>(&mut self, path: &str, mirror: &T) -> Result<(), BufferError> {
        let place = self.sizes(path)?;
        check_size::<T>(path, &place)?;
        let bytes = bytemuck::bytes_of(mirror);
        // The mirror's tail padding stays out: another member may lie in that of a scalar
        // structure.
        let held = bytes.len().min(place.data_size);
        self.write_bytes(place.offset, &bytes[..held])
    }

    /// Writes mirrors to consecutive elements of an array: `data` starts at the first, `data[5]` at
    /// the sixth.
    ///
    /// A path that is not an array or an element of one, mirrors whose size is not the array
    /// stride, or more mirrors than remaining elements.
    pub fn write_slice<T: Pod>(&mut self, path: &str, mirrors: &[T]) -> Result<(), BufferError> {
        let place = resolve(self.block(), self.tail, path, None)?;
        let (member, first) = match place.what {
            PlaceKind::Array(member, dim) if dim + 1 == member.dims.len() => (member, 0),
            PlaceKind::Struct(member) if path.ends_with(']') => (member, place.index),
            what => {
                let (path, ty) = (path.to_string(), spelled(self.block(), what));
                return Err(BufferError::NotAnArray { path, ty });
            }
        };
        let last = member.dims.len() - 1;
        let stride = member.strides[last];
        let given = size_of::<T>() as u64;
        if given != stride {
            let shader = spelled(self.block(), PlaceKind::Struct(member));
            let path = format!("{path}[]");
            return Err(BufferError::WrongSize { path, shader, wanted: stride, given });
        }
        let len = fixed(&member.dims[last]).unwrap_or(self.tail as u64);
        let end = first + mirrors.len() as u64;
        if end > len {
            let path = path.to_string();
            return Err(BufferError::OutOfRange { path, index: end - 1, len });
        }
        let bytes: &[u8] = bytemuck::cast_slice(mirrors);
        let element = super::resolve::element(member, member.dims.len());
        let data = data_size(self.block(), element).unwrap_or(stride);
        // The padding after the last element may belong to another member in scalar layout.
        let held = bytes.len().saturating_sub((stride - data.min(stride)) as usize);
        self.write_bytes(place.offset as usize, &bytes[..held])
    }

    /// Reads a mirror from a path; padding that the buffer does not hold is zero.
    ///
    /// # Errors
    /// Those of [`write_pod`](Buffer::write_pod).
    pub fn read_pod<T: Pod>(&self, path: &str) -> Result<T, BufferError> {
        let place = self.sizes(path)?;
        check_size::<T>(path, &place)?;
        let mut mirror = T::zeroed();
        let bytes = bytemuck::bytes_of_mut(&mut mirror);
        let held = bytes.len().min(place.data_size);
        let from = self.bytes().get(place.offset..place.offset + held);
        bytes[..held].copy_from_slice(from.ok_or_else(|| self.out_of_bounds(place.offset, held))?);
        Ok(mirror)
    }

    /// Writes bytes at an offset, regardless of members.
    ///
    /// # Errors
    /// Bytes that would end past the buffer.
    pub fn write_bytes(&mut self, offset: usize, bytes: &[u8]) -> Result<(), BufferError> {
        match self.data.write(offset, bytes.len()) {
            Some(to) => {
                to.copy_from_slice(bytes);
                Ok(())
            }
            None => Err(self.out_of_bounds(offset, bytes.len())),
        }
    }

    // Size and data size of the place, which differ by the padding at its end.
    fn sizes(&self, path: &str) -> Result<Sizes, BufferError> {
        let block = self.block();
        let place = resolve(block, self.tail, path, None)?;
        let extent = &self.compiled.extent;
        let (whole, data) = match (place.what, &extent.tail) {
            // The members before the array, which has no Rust type of known size.
            (PlaceKind::Block, Some(tail)) => (tail.offset as u64, extent.fixed_end as u64),
            // The runtime-sized array itself: as many elements as this buffer has.
            (what, Some(tail)) if size(block, what).is_none() => {
                let bytes = (tail.stride * self.tail) as u64;
                (bytes, bytes)
            }
            (what, _) => {
                let whole = size(block, what).unwrap_or(0);
                (whole, data_size(block, what).unwrap_or(whole).min(whole))
            }
        };
        Ok(Sizes {
            offset: place.offset as usize,
            size: whole as usize,
            data_size: data as usize,
            what: spelled(block, place.what),
        })
    }
}

fn check_size<T>(path: &str, place: &Sizes) -> Result<(), BufferError> {
    let given = size_of::<T>();
    if given == place.size || given == place.data_size {
        return Ok(());
    }
    Err(BufferError::WrongSize {
        path: path.to_string(),
        shader: place.what.clone(),
        wanted: place.size as u64,
        given: given as u64,
    })
}
