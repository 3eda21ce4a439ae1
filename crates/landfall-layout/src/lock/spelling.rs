//! Parses spelled types: `PointLight[128]`, `array<vec3<f32>, 4>`.
//!
//! The inverse of [`Type::spelled`], for [`super::read`].

use std::sync::{Arc, OnceLock};

use rustc_hash::FxHashMap;

use crate::shape::{ArrayLen, DEEPEST_NESTING, SCALARS, Type};
use crate::source::Language;

/// An array's element type and its dimensions, outermost first.
pub(super) struct TypeSpelling {
    pub base: String,
    pub dims: Vec<ArrayLen>,
}

/// Splits a spelled type into element and dimensions; `None` if it is malformed.
pub(super) fn take_apart(text: &str, language: Language) -> Option<TypeSpelling> {
    let (base, dims) = match language {
        Language::Glsl | Language::SpirV => glsl_dims(text)?,
        Language::Wgsl => wgsl_dims(text)?,
    };
    // Names, and the brackets and commas of WGSL's `vec3<f32>`. Whether there is such a type is up
    // to the caller.
    let sound = !base.is_empty() && base.chars().all(|c| is_word(c) || "<>, ".contains(c));
    // An array of arrays is as deep as it has dimensions, and types are visited recursively.
    (sound && dims.len() < DEEPEST_NESTING as usize)
        .then(|| TypeSpelling { base: base.to_string(), dims })
}

/// Builds an array type from its element and dimensions, outermost first.
pub(super) fn array_of(element: Type, dims: &[ArrayLen]) -> Type {
    dims.iter()
        .rev()
        .fold(element, |element, len| Type::Array { element: Arc::new(element), len: len.clone() })
}

/// The scalar, vector or matrix spelled `name`.
pub(super) fn leaf_type(name: &str, language: Language) -> Option<Type> {
    static GLSL: OnceLock<FxHashMap<String, Type>> = OnceLock::new();
    static WGSL: OnceLock<FxHashMap<String, Type>> = OnceLock::new();
    let table = match language {
        Language::Glsl | Language::SpirV => GLSL.get_or_init(|| table(Language::Glsl)),
        Language::Wgsl => WGSL.get_or_init(|| table(language)),
    };
    table.get(name).cloned()
}

/// Every scalar, vector and matrix type by its spelling.
fn table(language: Language) -> FxHashMap<String, Type> {
    let mut types = Vec::new();
    for scalar in SCALARS.iter().map(|names| names.scalar) {
        types.push(Type::Scalar(scalar));
        for rows in 2..=4 {
            types.push(Type::Vector { scalar, rows });
            types.extend((2..=4).map(|columns| Type::Matrix { scalar, columns, rows }));
        }
        if language == Language::Wgsl {
            types.push(Type::Atomic(scalar));
        }
    }
    types.into_iter().map(|ty| (ty.spelled(language).to_string(), ty)).collect()
}

fn is_word(letter: char) -> bool {
    letter == '_' || letter.is_alphanumeric()
}

/// Parses an array length: a number, the name of a constant, or nothing.
fn len(text: &str) -> Option<ArrayLen> {
    if text.is_empty() {
        return Some(ArrayLen::Runtime);
    }
    if text.bytes().all(|b| b.is_ascii_digit()) {
        return text.parse().ok().map(ArrayLen::Fixed);
    }
    text.chars().all(is_word).then(|| ArrayLen::Override(Arc::from(text)))
}

// type = base { "[" [ length ] "]" }
fn glsl_dims(text: &str) -> Option<(&str, Vec<ArrayLen>)> {
    let (base, mut rest) = text.split_at(text.find('[').unwrap_or(text.len()));
    let mut dims = Vec::new();
    while !rest.is_empty() {
        let (inside, after) = rest.strip_prefix('[')?.split_once(']')?;
        dims.push(len(inside)?);
        rest = after;
    }
    Some((base, dims))
}

// type = "array<" type [ ", " length ] ">" | base
fn wgsl_dims(text: &str) -> Option<(&str, Vec<ArrayLen>)> {
    let mut base = text;
    let mut dims = Vec::new();
    while let Some(inside) = base.strip_prefix("array<") {
        let inside = inside.strip_suffix('>')?;
        // The length follows the last comma outside the element's own brackets.
        let (element, last) = match inside.rsplit_once(", ") {
            Some((element, last)) if last.chars().all(is_word) => (element, len(last)?),
            Some(_) | None => (inside, ArrayLen::Runtime),
        };
        dims.push(last);
        base = element;
    }
    Some((base, dims))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn again(text: &str, language: Language) -> Option<String> {
        let spelling = take_apart(text, language)?;
        let base = leaf_type(&spelling.base, language)
            .unwrap_or_else(|| Type::Address(Arc::from(spelling.base.as_str())));
        Some(array_of(base, &spelling.dims).spelled(language).to_string())
    }

    #[test]
    fn a_type_is_spelled_as_it_was_read() {
        for text in ["float", "dmat2x3[4]", "PointLight[128][2]", "vec3[]", "uint8_t[COUNT]"] {
            assert_eq!(again(text, Language::Glsl).as_deref(), Some(text));
        }
        for text in [
            "f32",
            "array<vec3<f32>>",
            "array<array<atomic<u32>, 4>, COUNT>",
            "array<mat4x3<f16>, 2>",
            "array<Light>",
        ] {
            assert_eq!(again(text, Language::Wgsl).as_deref(), Some(text));
        }
    }

    #[test]
    fn what_is_no_type_is_refused() {
        for text in ["", "float[", "float[4", "float]4[", "float[4]x", "[4]", "float[-1]", "a.b"] {
            assert!(take_apart(text, Language::Glsl).is_none(), "{text}");
        }
        for text in ["array<f32", "array<f32, 4>>x", "array<>", "f32[4]"] {
            assert!(take_apart(text, Language::Wgsl).is_none(), "{text}");
        }
        assert!(leaf_type("vec5", Language::Glsl).is_none());
        assert!(leaf_type("vec3", Language::Wgsl).is_none());
    }
}
