//! Vectors and matrices of glam as values.

use super::value::{Sealed, Value};

// Of one component type and that many components, read one by one: a `Vec3A` has padding.
macro_rules! vectors {
    ($($ty:ident $component:ident $rows:literal)*) => {$(
        impl Sealed for glam::$ty {}

        impl Value for glam::$ty {
            type Component = $component;
            const COLUMNS: usize = 1;
            const ROWS: usize = $rows;

            #[inline]
            fn component(&self, _: usize, row: usize) -> $component {
                self[row]
            }

            #[inline]
            fn build(mut cell: impl FnMut(usize, usize) -> $component) -> glam::$ty {
                glam::$ty::from_array(std::array::from_fn(|row| cell(0, row)))
            }
        }
    )*};
}

// Square matrices, all that glam has.
macro_rules! matrices {
    ($($ty:ident $component:ident $size:literal)*) => {$(
        impl Sealed for glam::$ty {}

        impl Value for glam::$ty {
            type Component = $component;
            const COLUMNS: usize = $size;
            const ROWS: usize = $size;

            #[inline]
            fn component(&self, column: usize, row: usize) -> $component {
                self.col(column)[row]
            }

            #[inline]
            fn build(mut cell: impl FnMut(usize, usize) -> $component) -> glam::$ty {
                let columns =
                    std::array::from_fn(|column| std::array::from_fn(|row| cell(column, row)));
                glam::$ty::from_cols_array_2d(&columns)
            }
        }
    )*};
}

vectors! {
    Vec2 f32 2 Vec3 f32 3 Vec3A f32 3 Vec4 f32 4
    DVec2 f64 2 DVec3 f64 3 DVec4 f64 4
    IVec2 i32 2 IVec3 i32 3 IVec4 i32 4
    UVec2 u32 2 UVec3 u32 3 UVec4 u32 4
}

matrices! {
    Mat2 f32 2 Mat3 f32 3 Mat3A f32 3 Mat4 f32 4
    DMat2 f64 2 DMat3 f64 3 DMat4 f64 4
}
