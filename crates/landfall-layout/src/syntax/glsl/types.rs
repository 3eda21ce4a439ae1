//! GLSL's built-in type names (GLSL 4.60 §4.1 and the extensions that add types).

use crate::shape::{SCALARS, Scalar, ScalarKind, Type};

#[derive(Clone, Debug, PartialEq)]
pub enum Builtin {
    Data(Type),
    /// A sampler, image or other handle, which has no bytes.
    Opaque,
    Void,
}

/// Returns the meaning of a built-in type name; `None` for other names.
// scalar: float, int, uint, bool, double, and TYPE WIDTH _t of the extensions
// vector: [PREFIX] vec (2 | 3 | 4)    matrix: [PREFIX] mat COLUMNS [x ROWS]     (§4.1)
// Called for every type name, so the frequent kinds come first and nothing is allocated.
pub fn builtin(name: &str) -> Option<Builtin> {
    if let Some(scalar) = scalar(name) {
        return Some(Builtin::Data(Type::Scalar(scalar)));
    }
    if name == "void" {
        return Some(Builtin::Void);
    }
    // Most names are not those of types: a vector's and a matrix's end with a size.
    if name.ends_with(['2', '3', '4']) {
        if let Some((prefix, size)) = name.split_once("vec") {
            let (scalar, rows) = (component(prefix)?, size_of(size)?);
            return Some(Builtin::Data(Type::Vector { scalar, rows }));
        }
        if let Some(matrix) = name.split_once("mat").and_then(|(prefix, size)| matrix(prefix, size))
        {
            return Some(Builtin::Data(matrix));
        }
    }
    is_opaque(name).then_some(Builtin::Opaque)
}

fn scalar(name: &str) -> Option<Scalar> {
    let name = match name {
        "float32_t" => "float",
        "int32_t" => "int",
        "uint32_t" => "uint",
        "float64_t" => "double",
        name => name,
    };
    SCALARS.iter().find(|names| names.glsl == name).map(|names| names.scalar)
}

/// Returns the component type of a vector prefix.
fn component(prefix: &str) -> Option<Scalar> {
    let prefix = match prefix {
        "f32" => "",
        "i32" => "i",
        "u32" => "u",
        "f64" => "d",
        prefix => prefix,
    };
    SCALARS.iter().find(|names| names.glsl_prefix == prefix).map(|names| names.scalar)
}

fn size_of(text: &str) -> Option<u8> {
    match text {
        "2" => Some(2),
        "3" => Some(3),
        "4" => Some(4),
        _ => None,
    }
}

/// Parses `matC` or `matCxR`: C columns of R rows.
fn matrix(prefix: &str, size: &str) -> Option<Type> {
    let scalar = component(prefix).filter(|scalar| scalar.kind == ScalarKind::Float)?;
    let (columns, rows) = size.split_once('x').unwrap_or((size, size));
    Some(Type::Matrix { scalar, columns: size_of(columns)?, rows: size_of(rows)? })
}

/// Dimensions in the names of samplers, images and textures.
const DIMENSIONS: &[&str] = &[
    "",
    "1D",
    "2D",
    "3D",
    "Cube",
    "2DRect",
    "1DArray",
    "2DArray",
    "CubeArray",
    "Buffer",
    "2DMS",
    "2DMSArray",
    "ExternalOES",
    "External2DY2YEXT",
    "VideoIMG",
];

/// Handles whose names follow no pattern.
const OTHERS: &[&str] = &[
    "atomic_uint",
    "accelerationStructureEXT",
    "accelerationStructureNV",
    "rayQueryEXT",
    "hitObjectNV",
    "hitObjectEXT",
    "hitObjectAttributeEXT",
    "hitObjectAttributeNV",
    "coopmat",
    "coopvecNV",
    "fcoopmatNV",
    "icoopmatNV",
    "ucoopmatNV",
    "samplerRenderbuffer",
    "isamplerRenderbuffer",
    "usamplerRenderbuffer",
    "tensorARM",
    "tensorLayoutNV",
    "tensorViewNV",
    "attachmentEXT",
    "iattachmentEXT",
    "uattachmentEXT",
];

// [i | u | f16 | i64 | u64] (sampler | image | texture) DIMENSION [Shadow]
// Only whole names: `textureInfo` may be a structure.
fn is_opaque(name: &str) -> bool {
    if OTHERS.contains(&name) {
        return true;
    }
    let prefixes = ["", "i", "u", "f16", "i64", "u64"];
    let bare = prefixes.iter().filter_map(|prefix| name.strip_prefix(prefix));
    bare.into_iter().any(|bare| {
        if matches!(bare, "subpassInput" | "subpassInputMS") {
            return true;
        }
        let dimension = ["sampler", "image", "texture"].iter().find_map(|f| bare.strip_prefix(f));
        dimension.is_some_and(|dimension| {
            let plain = dimension.strip_suffix("Shadow").unwrap_or(dimension);
            DIMENSIONS.contains(&plain) && !matches!(bare, "image" | "texture")
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_matrix_shape_has_columns_before_rows() {
        for columns in 2..=4u8 {
            for rows in 2..=4u8 {
                let ty = Type::Matrix { scalar: Scalar::F32, columns, rows };
                assert_eq!(builtin(&format!("mat{columns}x{rows}")), Some(Builtin::Data(ty)));
            }
        }
        let square = Type::Matrix { scalar: Scalar::F64, columns: 3, rows: 3 };
        assert_eq!(builtin("dmat3"), Some(Builtin::Data(square)));
    }

    #[test]
    fn handles_are_told_from_structures_that_sound_like_them() {
        let handles =
            ["sampler2D", "usamplerBuffer", "samplerCubeArrayShadow", "image2DMS", "sampler"];
        for name in handles.into_iter().chain(["samplerShadow", "f16texture2D", "isubpassInput"]) {
            assert_eq!(builtin(name), Some(Builtin::Opaque), "{name}");
        }
        for name in
            ["texture", "image", "samplerFoo", "textureInfo", "Material", "format", "vector"]
        {
            assert_eq!(builtin(name), None, "{name}");
        }
    }
}
