//! WGSL's predeclared type names (§6.9), as far as naga 30 supports them.

use crate::shape::{Scalar, ScalarKind};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Predeclared {
    Scalar(Scalar),
    /// `vec3`, `vec3f`: the component is `None` until a template provides it.
    Vector {
        rows: u8,
        scalar: Option<Scalar>,
    },
    Matrix {
        columns: u8,
        rows: u8,
        scalar: Option<Scalar>,
    },
    Array,
    Atomic,
    BindingArray,
    /// naga's `RayDesc`, a structure allowed in a buffer.
    RayDesc,
    /// Textures, samplers, pointers and other types without a byte layout.
    Opaque,
}

const I16: Scalar = Scalar { kind: ScalarKind::Sint, width: 2 };
const U16: Scalar = Scalar { kind: ScalarKind::Uint, width: 2 };
const I64: Scalar = Scalar { kind: ScalarKind::Sint, width: 8 };

/// Suggestions for misspelt names.
pub(super) const NAMES: [&str; 32] = [
    "bool",
    "i32",
    "u32",
    "f32",
    "f16",
    "i64",
    "u64",
    "f64",
    "vec2",
    "vec3",
    "vec4",
    "vec2f",
    "vec3f",
    "vec4f",
    "vec2i",
    "vec3i",
    "vec4i",
    "vec2u",
    "vec3u",
    "vec4u",
    "mat2x2",
    "mat3x3",
    "mat4x4",
    "mat2x2f",
    "mat3x3f",
    "mat4x4f",
    "mat3x4",
    "mat4x3",
    "array",
    "atomic",
    "sampler",
    "texture_2d",
];

// vecN, vecNf, vecNh, vecNi, vecNu; matCxR, matCxRf, matCxRh with N, C, R of 2 to 4
pub(super) fn lookup(name: &str) -> Option<Predeclared> {
    let bytes = name.as_bytes();
    Some(match name {
        "f32" => Predeclared::Scalar(Scalar::F32),
        "u32" => Predeclared::Scalar(Scalar::U32),
        "i32" => Predeclared::Scalar(Scalar::I32),
        "f16" => Predeclared::Scalar(Scalar::F16),
        "bool" => Predeclared::Scalar(Scalar::BOOL),
        "array" => Predeclared::Array,
        "atomic" => Predeclared::Atomic,
        "i64" => Predeclared::Scalar(I64),
        "u64" => Predeclared::Scalar(Scalar::U64),
        "f64" => Predeclared::Scalar(Scalar::F64),
        "i16" => Predeclared::Scalar(I16),
        "u16" => Predeclared::Scalar(U16),
        "binding_array" => Predeclared::BindingArray,
        "RayDesc" => Predeclared::RayDesc,
        "ptr"
        | "sampler"
        | "sampler_comparison"
        | "acceleration_structure"
        | "ray_query"
        | "RayIntersection" => Predeclared::Opaque,
        _ if name.starts_with("texture_") || name.starts_with("coop_mat") => Predeclared::Opaque,
        _ => match bytes {
            [b'v', b'e', b'c', rows, suffix @ ..] => {
                Predeclared::Vector { rows: extent(*rows)?, scalar: component(suffix)? }
            }
            [b'm', b'a', b't', columns, b'x', rows, suffix @ ..] => {
                if !matches!(suffix, [] | [b'f' | b'h']) {
                    return None;
                }
                Predeclared::Matrix {
                    columns: extent(*columns)?,
                    rows: extent(*rows)?,
                    scalar: component(suffix)?,
                }
            }
            _ => return None,
        },
    })
}

fn extent(digit: u8) -> Option<u8> {
    matches!(digit, b'2'..=b'4').then(|| digit - b'0')
}

/// Returns the component for a suffix: `Some(None)` without one, `None` for an unknown one.
fn component(suffix: &[u8]) -> Option<Option<Scalar>> {
    match suffix {
        [] => Some(None),
        [b'f'] => Some(Some(Scalar::F32)),
        [b'h'] => Some(Some(Scalar::F16)),
        [b'i'] => Some(Some(Scalar::I32)),
        [b'u'] => Some(Some(Scalar::U32)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_short_vector_and_matrix_name_is_known() {
        for rows in 2..=4u8 {
            for (suffix, scalar) in
                [("f", Scalar::F32), ("h", Scalar::F16), ("i", Scalar::I32), ("u", Scalar::U32)]
            {
                let vector = Predeclared::Vector { rows, scalar: Some(scalar) };
                assert_eq!(lookup(&format!("vec{rows}{suffix}")), Some(vector));
                for columns in 2..=4u8 {
                    let matrix = Predeclared::Matrix { columns, rows, scalar: Some(scalar) };
                    let known = matches!(suffix, "f" | "h").then_some(matrix);
                    assert_eq!(lookup(&format!("mat{columns}x{rows}{suffix}")), known);
                }
            }
        }
        for name in ["vec5", "vec1f", "mat4", "mat4x5", "vec3d", "mat4x4u", "vec", "float4"] {
            assert_eq!(lookup(name), None, "{name}");
        }
    }
}
