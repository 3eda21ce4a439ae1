//! Rust values that represent a scalar, vector or matrix of a shader.
//!
//! A component is a Rust number; `[T; N]` is a vector, `[[T; R]; C]` a `matCxR` as its C columns.
//! Nothing is converted, except that 16-bit and 8-bit floats are set from and read as `f32`,
//! because Rust has no such types. With the feature `glam`, vectors and matrices of glam are values,
//! too, of whichever version from 0.30 to 0.34 the program has. Those of other libraries are passed
//! as arrays, or written whole, as [`bytemuck::Pod`], with
//! [`Buffer::write_pod`](super::Buffer::write_pod).

use super::float::{narrow, widen};
use super::grid::ComponentGrid;
use crate::shape::{Scalar, ScalarKind, wgsl_scalar};

/// A Rust number that represents a component of a shader's type.
pub trait Component: Copy + Sealed {
    /// The name of the Rust type.
    const NAME: &'static str;
    /// Size in a buffer, in bytes.
    const WIDTH: usize;
    /// The component type it represents.
    #[doc(hidden)]
    const SCALAR: Scalar;
    /// Returns how this type represents a component type.
    #[doc(hidden)]
    fn is(scalar: Scalar) -> ScalarMatch {
        if scalar == Self::SCALAR { ScalarMatch::Same } else { ScalarMatch::No }
    }
    /// Writes [`WIDTH`](Self::WIDTH) bytes in native order.
    #[doc(hidden)]
    fn put(self, out: &mut [u8]);
    /// Reads [`WIDTH`](Self::WIDTH) bytes in native order.
    #[doc(hidden)]
    fn take(from: &[u8]) -> Self;
    /// Writes it in a smaller format: only for [`ScalarMatch::Narrowed`].
    #[doc(hidden)]
    fn put_as(self, scalar: Scalar, out: &mut [u8]);
    /// Reads it from a smaller format: only for [`ScalarMatch::Narrowed`].
    #[doc(hidden)]
    fn take_as(scalar: Scalar, from: &[u8]) -> Self;
}

/// The relation of a Rust number to a shader's component.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScalarMatch {
    /// Same bytes.
    Same,
    /// Rounded to the nearest number of a smaller format.
    Narrowed,
    /// Not representable.
    No,
}

/// A Rust value that represents a scalar, vector or matrix.
pub trait Value: Copy + Sealed {
    /// The component type.
    #[doc(hidden)]
    type Component: Component;
    /// Number of columns; 1 unless a matrix.
    const COLUMNS: usize;
    /// Number of components of a vector or column.
    const ROWS: usize;
    /// Size in bytes without gaps.
    #[doc(hidden)]
    const BYTES: usize = Self::COLUMNS * Self::ROWS * Self::Component::WIDTH;
    /// The [`code`] of the type.
    #[doc(hidden)]
    // Compared with the code of a leaf as one number: kind, width, columns and rows.
    const CODE: u32 = match Self::COLUMNS <= 4 && Self::ROWS <= 4 {
        true => code(Self::Component::SCALAR, Self::COLUMNS as u8, Self::ROWS as u8),
        // No shader has such a type.
        false => NO_TYPE,
    };
    /// Returns one component.
    #[doc(hidden)]
    fn component(&self, column: usize, row: usize) -> Self::Component;
    /// Builds a value from its components.
    #[doc(hidden)]
    fn build(cell: impl FnMut(usize, usize) -> Self::Component) -> Self;
    /// Writes the value without gaps; `out` has [`BYTES`](Self::BYTES) bytes.
    #[doc(hidden)]
    #[inline]
    fn store(&self, out: &mut [u8]) {
        let width = Self::Component::WIDTH;
        for column in 0..Self::COLUMNS {
            for row in 0..Self::ROWS {
                let at = (column * Self::ROWS + row) * width;
                self.component(column, row).put(&mut out[at..at + width]);
            }
        }
    }
    /// Reads the value without gaps; `from` has [`BYTES`](Self::BYTES) bytes.
    #[doc(hidden)]
    #[inline]
    fn fetch(from: &[u8]) -> Self {
        let width = Self::Component::WIDTH;
        Self::build(|column, row| {
            let at = (column * Self::ROWS + row) * width;
            Self::Component::take(&from[at..at + width])
        })
    }
}

/// Seals the traits: only this crate implements them.
mod sealed {
    pub trait Sealed {}
}
pub(crate) use sealed::Sealed;

/// The code of no scalar, vector or matrix.
const NO_TYPE: u32 = u32::MAX - 1;

/// Encodes a scalar, vector or matrix type as a number, distinct for distinct types.
pub(crate) const fn code(scalar: Scalar, columns: u8, rows: u8) -> u32 {
    u32::from_be_bytes([scalar.kind as u8, scalar.width, columns, rows])
}

/// Returns how a value of that type represents a leaf.
pub(crate) fn fit<T: Value>(grid: &ComponentGrid) -> ScalarMatch {
    let same = T::COLUMNS == usize::from(grid.columns) && T::ROWS == usize::from(grid.rows);
    if same { T::Component::is(grid.scalar) } else { ScalarMatch::No }
}

/// Returns the Rust type as written in source: `[f32; 3]`.
pub(crate) fn spelled<T: Value>() -> String {
    shape_of(T::Component::NAME, T::COLUMNS, T::ROWS)
}

/// Returns the Rust type that represents a leaf.
pub(crate) fn rust_type(grid: &ComponentGrid) -> String {
    let narrow = match grid.scalar.kind {
        ScalarKind::Float => grid.scalar.width != 8,
        ScalarKind::Bfloat | ScalarKind::FloatE5m2 | ScalarKind::FloatE4m3 => true,
        ScalarKind::Bool | ScalarKind::Sint | ScalarKind::Uint => false,
    };
    // Rust names the other numbers as WGSL does.
    let name = if narrow { "f32" } else { wgsl_scalar(grid.scalar) };
    shape_of(name, grid.columns.into(), grid.rows.into())
}

fn shape_of(name: &str, columns: usize, rows: usize) -> String {
    match (columns, rows) {
        (1, 1) => name.to_string(),
        (1, _) => format!("[{name}; {rows}]"),
        _ => format!("[[{name}; {rows}]; {columns}]"),
    }
}

macro_rules! scalar {
    ($($ty:ident $kind:ident)*) => {$(
        impl Sealed for $ty {}

        impl Component for $ty {
            const NAME: &'static str = stringify!($ty);
            const WIDTH: usize = size_of::<$ty>();
            const SCALAR: Scalar =
                Scalar { kind: ScalarKind::$kind, width: size_of::<$ty>() as u8 };

            #[inline]
            fn put(self, out: &mut [u8]) {
                out.copy_from_slice(&self.to_ne_bytes());
            }

            #[inline]
            fn take(from: &[u8]) -> $ty {
                let mut bytes = [0; size_of::<$ty>()];
                bytes.copy_from_slice(from);
                <$ty>::from_ne_bytes(bytes)
            }

            fn put_as(self, _: Scalar, out: &mut [u8]) {
                self.put(out);
            }

            fn take_as(_: Scalar, from: &[u8]) -> $ty {
                Self::take(from)
            }
        }
    )*};
}

scalar!(i8 Sint i16 Sint i32 Sint i64 Sint u8 Uint u16 Uint u32 Uint u64 Uint f64 Float);

impl Sealed for f32 {}

impl Component for f32 {
    const NAME: &'static str = "f32";
    const WIDTH: usize = 4;
    const SCALAR: Scalar = Scalar::F32;

    fn is(scalar: Scalar) -> ScalarMatch {
        match (scalar.kind, scalar.width) {
            (ScalarKind::Float, 4) => ScalarMatch::Same,
            (ScalarKind::Float, 2) => ScalarMatch::Narrowed,
            (ScalarKind::Bfloat | ScalarKind::FloatE5m2 | ScalarKind::FloatE4m3, _) => {
                ScalarMatch::Narrowed
            }
            (ScalarKind::Float | ScalarKind::Bool | ScalarKind::Sint | ScalarKind::Uint, _) => {
                ScalarMatch::No
            }
        }
    }

    #[inline]
    fn put(self, out: &mut [u8]) {
        out.copy_from_slice(&self.to_ne_bytes());
    }

    #[inline]
    fn take(from: &[u8]) -> f32 {
        let mut bytes = [0; 4];
        bytes.copy_from_slice(from);
        f32::from_ne_bytes(bytes)
    }

    fn put_as(self, scalar: Scalar, out: &mut [u8]) {
        put_bits(narrow(scalar, self.into()), out);
    }

    fn take_as(scalar: Scalar, from: &[u8]) -> f32 {
        // Every number of the smaller formats is representable as f32.
        widen(scalar, take_bits(from)) as f32
    }
}

impl Sealed for bool {}

/// 4 bytes, 0 or 1; any other number reads as true, as in shaders.
impl Component for bool {
    const NAME: &'static str = "bool";
    const WIDTH: usize = 4;
    const SCALAR: Scalar = Scalar::BOOL;

    #[inline]
    fn put(self, out: &mut [u8]) {
        u32::from(self).put(out);
    }

    #[inline]
    fn take(from: &[u8]) -> bool {
        u32::take(from) != 0
    }

    fn put_as(self, _: Scalar, out: &mut [u8]) {
        self.put(out);
    }

    fn take_as(_: Scalar, from: &[u8]) -> bool {
        Self::take(from)
    }
}

/// Writes the low bytes of a component's bits in native order; `out` has its width.
pub(crate) fn put_bits(bits: u64, out: &mut [u8]) {
    let width = out.len();
    // The low bytes come first in memory, or last.
    if cfg!(target_endian = "little") {
        out.copy_from_slice(&bits.to_le_bytes()[..width]);
    } else {
        out.copy_from_slice(&bits.to_be_bytes()[8 - width..]);
    }
}

/// Reads the bits of a component as wide as `from`.
pub(crate) fn take_bits(from: &[u8]) -> u64 {
    let mut bytes = [0; 8];
    if cfg!(target_endian = "little") {
        bytes[..from.len()].copy_from_slice(from);
        u64::from_le_bytes(bytes)
    } else {
        bytes[8 - from.len()..].copy_from_slice(from);
        u64::from_be_bytes(bytes)
    }
}

impl<T: Component> Value for T {
    type Component = T;
    const COLUMNS: usize = 1;
    const ROWS: usize = 1;

    #[inline]
    fn component(&self, _: usize, _: usize) -> T {
        *self
    }

    #[inline]
    fn build(mut cell: impl FnMut(usize, usize) -> T) -> T {
        cell(0, 0)
    }
}

impl<T: Sealed, const N: usize> Sealed for [T; N] {}

impl<T: Component, const N: usize> Value for [T; N] {
    type Component = T;
    const COLUMNS: usize = 1;
    const ROWS: usize = N;

    #[inline]
    fn component(&self, _: usize, row: usize) -> T {
        self[row]
    }

    #[inline]
    fn build(mut cell: impl FnMut(usize, usize) -> T) -> [T; N] {
        std::array::from_fn(|row| cell(0, row))
    }
}

impl<T: Component, const C: usize, const R: usize> Value for [[T; R]; C] {
    type Component = T;
    const COLUMNS: usize = C;
    const ROWS: usize = R;

    #[inline]
    fn component(&self, column: usize, row: usize) -> T {
        self[column][row]
    }

    #[inline]
    fn build(mut cell: impl FnMut(usize, usize) -> T) -> [[T; R]; C] {
        std::array::from_fn(|column| std::array::from_fn(|row| cell(column, row)))
    }
}
