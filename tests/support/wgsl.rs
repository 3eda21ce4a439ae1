//! WGSL structures with the layout encase gives them. Text and type come from
//! one source, the list at the end: Rust's names for the types are WGSL's.
//!
//! encase implements WGSL §14.4 on its own, from the Rust type.

#![allow(non_camel_case_types, reason = "the types are spelled as in WGSL")]

use std::sync::atomic::{AtomicI32, AtomicU32};

use encase::ShaderType;
use encase::private::{ArrayMetadata, MatrixMetadata, Metadata};

use super::leaf::{OracleBlock, OracleLeaf};

/// One structure, which a storage variable `v_Name` of the text has as type.
pub struct Case {
    /// Types in WGSL's long spelling: `vec3<f32>`, `atomic<u32>`.
    pub block: OracleBlock,
    /// Panics with encase's reason where the structure breaks the constraints
    /// of the uniform address space (WGSL §14.4.3).
    pub assert_fit_for_uniform: fn(),
}

/// Every structure, and for each a storage variable.
pub fn text() -> String {
    let mut text = String::new();
    for (_, declaration, _) in STRUCTS {
        text.push_str(declaration);
        text.push('\n');
    }
    for (binding, (name, _, _)) in STRUCTS.iter().enumerate() {
        text.push_str(&format!(
            "@group(0) @binding({binding}) var<storage, read_write> v_{name}: {name};\n"
        ));
    }
    // WGSL has `array` for both kinds.
    text.replace("runtime", "array")
}

/// In the order of the text.
pub fn cases() -> Vec<Case> {
    STRUCTS.iter().map(|(_, _, case)| case()).collect()
}

type Entry = (&'static str, &'static str, fn() -> Case);

#[derive(Clone, Copy, Debug)]
pub struct Vector<T, const N: usize>([T; N]);

#[derive(Clone, Copy, Debug)]
pub struct Matrix<const C: usize, const R: usize>([[f32; R]; C]);

type vec2<T> = Vector<T, 2>;
type vec3<T> = Vector<T, 3>;
type vec4<T> = Vector<T, 4>;
type vec2f = vec2<f32>;
type vec3f = vec3<f32>;
type vec4f = vec4<f32>;
type vec3i = vec3<i32>;
type vec4u = vec4<u32>;
type mat2x2f = Matrix<2, 2>;
type mat2x3f = Matrix<2, 3>;
type mat2x4f = Matrix<2, 4>;
type mat3x2f = Matrix<3, 2>;
type mat3x3f = Matrix<3, 3>;
type mat3x4f = Matrix<3, 4>;
type mat4x2f = Matrix<4, 2>;
type mat4x3f = Matrix<4, 3>;
type mat4x4f = Matrix<4, 4>;
type array<T, const N: usize> = [T; N];
type runtime<T> = Vec<T>;
type atomic<T> = <T as Atom>::Atomic;

pub trait Atom {
    type Atomic;
}
impl Atom for u32 {
    type Atomic = AtomicU32;
}
impl Atom for i32 {
    type Atomic = AtomicI32;
}

impl<T, const N: usize> AsRef<[T; N]> for Vector<T, N> {
    fn as_ref(&self) -> &[T; N] {
        &self.0
    }
}
impl<T, const N: usize> AsMut<[T; N]> for Vector<T, N> {
    fn as_mut(&mut self) -> &mut [T; N] {
        &mut self.0
    }
}
impl<T, const N: usize> From<[T; N]> for Vector<T, N> {
    fn from(parts: [T; N]) -> Self {
        Self(parts)
    }
}
impl<const C: usize, const R: usize> AsRef<[[f32; R]; C]> for Matrix<C, R> {
    fn as_ref(&self) -> &[[f32; R]; C] {
        &self.0
    }
}
impl<const C: usize, const R: usize> AsMut<[[f32; R]; C]> for Matrix<C, R> {
    fn as_mut(&mut self) -> &mut [[f32; R]; C] {
        &mut self.0
    }
}
impl<const C: usize, const R: usize> From<[[f32; R]; C]> for Matrix<C, R> {
    fn from(parts: [[f32; R]; C]) -> Self {
        Self(parts)
    }
}

encase::impl_vector!(2, Vector<T, 2>; using AsRef AsMut From);
encase::impl_vector!(3, Vector<T, 3>; using AsRef AsMut From);
encase::impl_vector!(4, Vector<T, 4>; using AsRef AsMut From);
encase::impl_matrix!(2, 2, Matrix<2, 2>, f32; using AsRef AsMut From);
encase::impl_matrix!(2, 3, Matrix<2, 3>, f32; using AsRef AsMut From);
encase::impl_matrix!(2, 4, Matrix<2, 4>, f32; using AsRef AsMut From);
encase::impl_matrix!(3, 2, Matrix<3, 2>, f32; using AsRef AsMut From);
encase::impl_matrix!(3, 3, Matrix<3, 3>, f32; using AsRef AsMut From);
encase::impl_matrix!(3, 4, Matrix<3, 4>, f32; using AsRef AsMut From);
encase::impl_matrix!(4, 2, Matrix<4, 2>, f32; using AsRef AsMut From);
encase::impl_matrix!(4, 3, Matrix<4, 3>, f32; using AsRef AsMut From);
encase::impl_matrix!(4, 4, Matrix<4, 4>, f32; using AsRef AsMut From);

/// Where the walk down a type stands.
#[derive(Clone, Debug, Default)]
pub struct Place {
    path: String,
    offset: u64,
    dims: Vec<Option<u64>>,
    strides: Vec<Option<u64>>,
}

impl Place {
    fn member(&self, name: &str, offset: u64) -> Self {
        let dot = if self.path.is_empty() { "" } else { "." };
        Self {
            path: format!("{}{dot}{name}", self.path),
            offset: self.offset + offset,
            ..self.clone()
        }
    }

    fn element(&self, length: Option<u64>, stride: u64) -> Self {
        let mut place = self.clone();
        place.path.push_str("[]");
        place.dims.push(length);
        place.strides.push(Some(stride));
        place
    }

    fn leaf(&self, ty: String, matrix_stride: Option<u64>) -> OracleLeaf {
        OracleLeaf {
            path: self.path.clone(),
            ty,
            offset: self.offset,
            dims: self.dims.clone(),
            strides: self.strides.clone(),
            matrix_stride,
            row_major: false,
        }
    }
}

/// The leaves below a type, by encase's own metadata.
pub trait Leaves {
    fn leaves(place: &Place, found: &mut Vec<OracleLeaf>);
}

macro_rules! scalars {
    ($($ty:ty: $word:literal)*) => {$(
        impl Leaves for $ty {
            fn leaves(place: &Place, found: &mut Vec<OracleLeaf>) {
                found.push(place.leaf($word.to_owned(), None));
            }
        }
    )*};
}
scalars! {
    f32: "f32" i32: "i32" u32: "u32" AtomicI32: "atomic<i32>" AtomicU32: "atomic<u32>"
}

impl<T, const N: usize> Leaves for Vector<T, N> {
    fn leaves(place: &Place, found: &mut Vec<OracleLeaf>) {
        found.push(place.leaf(format!("vec{N}<{}>", std::any::type_name::<T>()), None));
    }
}

impl<const C: usize, const R: usize> Leaves for Matrix<C, R>
where
    Self: ShaderType<ExtraMetadata = MatrixMetadata>,
{
    fn leaves(place: &Place, found: &mut Vec<OracleLeaf>) {
        let metadata: Metadata<MatrixMetadata> = <Self as ShaderType>::METADATA;
        let stride = 4 * R as u64 + metadata.col_padding();
        found.push(place.leaf(format!("mat{C}x{R}<f32>"), Some(stride)));
    }
}

impl<T: Leaves, const N: usize> Leaves for [T; N]
where
    Self: ShaderType<ExtraMetadata = ArrayMetadata>,
{
    fn leaves(place: &Place, found: &mut Vec<OracleLeaf>) {
        let metadata: Metadata<ArrayMetadata> = <Self as ShaderType>::METADATA;
        T::leaves(&place.element(Some(N as u64), metadata.stride().get()), found);
    }
}

impl<T: Leaves> Leaves for Vec<T>
where
    Self: ShaderType<ExtraMetadata = ArrayMetadata>,
{
    fn leaves(place: &Place, found: &mut Vec<OracleLeaf>) {
        let metadata: Metadata<ArrayMetadata> = <Self as ShaderType>::METADATA;
        T::leaves(&place.element(None, metadata.stride().get()), found);
    }
}

fn case<T: Leaves + ShaderType>(name: &str) -> Case {
    let mut leaves = Vec::new();
    T::leaves(&Place::default(), &mut leaves);
    Case {
        block: OracleBlock {
            name: name.to_owned(),
            count: Vec::new(),
            size: Some(T::min_size().get()),
            data_size: None,
            leaves,
        },
        assert_fit_for_uniform: T::assert_uniform_compat,
    }
}

/// One list, two readings: a Rust type for encase, and the text.
macro_rules! structs {
    ($(
        struct $name:ident {
            $($(@$attribute:ident($value:tt))* $field:ident: $ty:ty),* $(,)?
        }
    )*) => {
        $(
            #[derive(ShaderType)]
            struct $name {
                $($(#[shader($attribute($value))])* $field: $ty,)*
            }

            impl Leaves for $name {
                fn leaves(place: &Place, found: &mut Vec<OracleLeaf>) {
                    let mut member = 0;
                    $(
                        let offset = <$name as ShaderType>::METADATA.offset(member);
                        <$ty as Leaves>::leaves(&place.member(stringify!($field), offset), found);
                        member += 1;
                    )*
                    let _ = member;
                }
            }
        )*

        const STRUCTS: &[Entry] = &[$((
            stringify!($name),
            concat!(
                "struct ", stringify!($name), " { ",
                $($(written!($attribute $value),)* stringify!($field), ": ", stringify!($ty), ", ",)*
                "}"
            ),
            || case::<$name>(stringify!($name)),
        )),*];
    };
}

/// encase wants to be told that an array is runtime-sized; WGSL sees it.
macro_rules! written {
    (size runtime) => {
        ""
    };
    ($attribute:ident $value:tt) => {
        concat!("@", stringify!($attribute), "(", stringify!($value), ") ")
    };
}

structs! {
    struct Scalars { a: f32, b: i32, c: u32 }
    struct One { a: f32 }
    struct TwoVectors { a: vec2f, b: vec2<u32> }
    struct ScalarThenVec2 { a: f32, b: vec2f }
    struct ScalarThenVec3 { a: f32, b: vec3f }
    struct ScalarThenVec4 { a: f32, b: vec4f }
    struct Vec3ThenScalar { a: vec3f, b: f32 }
    struct Vec3ThenVec2 { a: vec3f, b: vec2f }
    struct Vec3ThenVec3 { a: vec3f, b: vec3i }
    struct Vec2ThenVec3 { a: vec2<i32>, b: vec3<u32> }
    struct Vec4ThenScalar { a: vec4u, b: f32 }
    struct LoneVec3 { a: vec3f }
    struct ScalarVec3Scalar { a: f32, b: vec3f, c: f32 }

    struct M22 { a: f32, m: mat2x2f, b: f32 }
    struct M23 { a: f32, m: mat2x3f, b: f32 }
    struct M24 { a: f32, m: mat2x4f, b: f32 }
    struct M32 { a: f32, m: mat3x2f, b: f32 }
    struct M33 { a: f32, m: mat3x3f, b: f32 }
    struct M34 { a: f32, m: mat3x4f, b: f32 }
    struct M42 { a: f32, m: mat4x2f, b: f32 }
    struct M43 { a: f32, m: mat4x3f, b: f32 }
    struct M44 { a: f32, m: mat4x4f, b: f32 }
    struct Matrices { a: mat2x2f, b: mat3x3f, c: mat3x2f, d: mat4x4f, e: mat2x3f, f: f32 }

    struct ArrayOfScalars { a: f32, w: array<f32, 7>, b: f32 }
    struct ArrayOfVec2 { a: f32, w: array<vec2f, 3>, b: f32 }
    struct ArrayOfVec3 { a: f32, w: array<vec3f, 3>, b: f32 }
    struct ArrayOfVec4 { a: f32, w: array<vec4f, 3>, b: f32 }
    struct ArrayOfOne { a: f32, w: array<vec3f, 1>, b: f32 }
    struct ArrayOfM22 { a: f32, m: array<mat2x2f, 2>, b: f32 }
    struct ArrayOfM23 { a: f32, m: array<mat2x3f, 2>, b: f32 }
    struct ArrayOfM32 { a: f32, m: array<mat3x2f, 3>, b: f32 }
    struct ArrayOfM33 { a: f32, m: array<mat3x3f, 2>, b: f32 }
    struct ArrayOfM43 { a: f32, m: array<mat4x3f, 2>, b: f32 }
    struct ArrayOfArrays { a: f32, w: array<array<f32, 3>, 2>, b: f32 }
    struct ArrayOfArraysOfVec3 { a: f32, w: array<array<vec3f, 2>, 3>, b: f32 }
    struct ThreeDimensions { w: array<array<array<vec2f, 2>, 3>, 4>, b: u32 }

    struct InnerOne { a: f32, s: One, b: f32 }
    struct InnerVec3 { a: f32, s: LoneVec3, b: f32 }
    struct InnerPair { a: f32, s: ScalarThenVec2, b: f32 }
    struct InnerMatrix { a: f32, s: M22, b: vec2f }
    struct InnerArray { a: f32, s: ArrayOfScalars, b: f32 }
    struct ArrayOfOnes { a: f32, s: array<One, 5>, b: f32 }
    struct ArrayOfLoneVec3 { a: f32, s: array<LoneVec3, 2>, b: f32 }
    struct ArrayOfPairs { a: u32, s: array<ScalarThenVec2, 3>, b: u32 }
    struct ArrayOfTails { a: u32, s: array<Vec3ThenScalar, 3>, b: u32 }
    struct Deep { a: f32, s: InnerPair, b: f32, t: array<InnerVec3, 2> }
    struct Deeper { a: vec2f, s: array<Deep, 2>, b: f32 }
    struct Light { pos: vec3f, range: f32, color: vec3f, intensity: f32, cone: vec2f }
    struct Lights { count: u32, ambient: vec3f, data: array<Light, 16> }

    struct AlignScalar { a: f32, @align(16) b: f32, c: f32 }
    struct AlignFirst { @align(32) a: f32, b: f32 }
    struct AlignLarge { a: vec3f, @align(64) b: vec2f, c: f32 }
    struct AlignArray { a: f32, @align(16) w: array<f32, 3>, c: f32 }
    struct AlignMatrix { a: f32, @align(16) m: mat2x2f, c: f32 }
    struct AlignStruct { a: f32, @align(16) s: One, c: f32 }
    struct SizeScalar { @size(16) a: f32, b: f32 }
    struct SizeVector { a: f32, @size(32) b: vec3f, c: f32 }
    struct SizeArray { @size(64) w: array<f32, 3>, b: f32 }
    struct SizeLast { a: vec3f, @size(24) b: f32 }
    struct SizeStruct { @size(16) s: One, b: f32 }
    struct SizeAndAlign { a: f32, @size(20) @align(16) b: vec2f, c: f32 }
    struct AlignAndSize { a: f32, @align(8) @size(12) b: u32, c: u32 }
    struct UniformReady { a: f32, @align(16) s: One, @align(16) b: f32 }
    struct InnerAligned { a: f32, s: AlignScalar, b: f32 }
    struct InnerAlignedFirst { a: f32, s: AlignFirst, b: f32 }
    struct InnerSized { a: f32, s: SizeLast, b: f32 }
    struct ArrayOfAligned { a: f32, s: array<AlignScalar, 2>, b: f32 }
    struct ArrayOfSized { a: f32, s: array<SizeLast, 2>, b: f32 }

    struct Atomics { a: atomic<u32>, b: atomic<i32>, c: vec2f }
    struct ArrayOfAtomics { a: f32, w: array<atomic<u32>, 5>, b: vec3f }

    struct TailOfScalars { n: u32, @size(runtime) w: runtime<f32> }
    struct TailOfVec3 { n: u32, @size(runtime) w: runtime<vec3f> }
    struct TailOfM33 { n: u32, @size(runtime) w: runtime<mat3x3f> }
    struct TailOfArrays { n: u32, @size(runtime) w: runtime<array<f32, 3>> }
    struct TailOfStructs { n: u32, m: vec2f, @size(runtime) w: runtime<Light> }
    struct TailOfOnes { n: vec3f, @size(runtime) w: runtime<One> }
    struct TailOfAtomics { @size(runtime) w: runtime<atomic<u32>> }
    struct TailOfAligned { n: u32, @size(runtime) w: runtime<AlignScalar> }
}
