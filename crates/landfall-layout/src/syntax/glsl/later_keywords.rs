//! Keywords and reserved words that only some versions of GLSL have (GLSL 1.10 to 4.60 §3.6, GLSL ES
//! 1.00 to 3.20 §3.6) as names: no layout depends on them, but compilers refuse them.

use std::sync::LazyLock;

use rustc_hash::FxHashMap;

use super::ast::{Declaration, Item, Name, TypeBase, TypeSpec};
use super::parser::Parser;
use super::preprocess::Version;
use super::report::diagnostic_at;
use super::walk::{self, Part};
use crate::Diagnostic;
use crate::diagnostic::Code;

/// Returns an error for each name that the shader's version reserves.
pub(super) fn errors<'a>(items: &[Item<'a>], parser: &mut Parser<'a>) -> Vec<Diagnostic> {
    let preprocessor = parser.preprocessor();
    let (version, is_declared) = (preprocessor.version, preprocessor.version_declared);
    // Without a line `#version` whoever compiles the text may set one before it.
    if !is_declared {
        return Vec::new();
    }
    let mut names = Vec::new();
    for item in items {
        match item {
            Item::Variables(declaration) => declared(declaration, &mut names),
            Item::Block(block) | Item::Interface(block) => {
                names.extend(block.instance);
                block.members.iter().for_each(|member| declared(member, &mut names));
            }
            Item::Function(function) => {
                names.push(function.name);
                names.extend(function.parameters.iter().map(|parameter| parameter.name));
                if let Some(body) = &function.body {
                    walk::scope(body, &mut |part| {
                        if let Part::Declaration(declaration) = part {
                            declared(declaration, &mut names);
                        }
                    });
                }
            }
            Item::Requalified(..) | Item::Other(_) | Item::Defaults(_) | Item::Precision(_) => {}
        }
    }
    let reserved = names.iter().filter(|name| is_reserved(name.text, version));
    let refused = |name: &Name<'a>| {
        let message = format!("`{}` is reserved in this version of GLSL, so no name", name.text);
        diagnostic_at(&parser.token_of(name), Code::InvalidShader, message)
            .with_note("GLSL §3.6")
            .with_help("rename it")
    };
    reserved.map(refused).collect()
}

fn declared<'a>(declaration: &Declaration<'a>, names: &mut Vec<Name<'a>>) {
    in_type(&declaration.ty, names);
    names.extend(declaration.names.iter().map(|declarator| declarator.name));
}

fn in_type<'a>(ty: &TypeSpec<'a>, names: &mut Vec<Name<'a>>) {
    if let TypeBase::Struct(structure) = &ty.base {
        names.push(structure.name);
        structure.members.iter().for_each(|member| declared(member, names));
    }
}

fn is_reserved(word: &str, version: Version) -> bool {
    // Built once: every name of every shader is looked up.
    static VERSIONS: LazyLock<FxHashMap<&str, (u32, u32)>> = LazyLock::new(|| {
        let words = |&(desktop, es, words): &(u32, u32, &'static str)| {
            words.split(' ').map(move |word| (word, (desktop, es)))
        };
        SINCE.iter().flat_map(words).collect()
    });
    let since = VERSIONS.get(word);
    since.is_some_and(|&(desktop, es)| version.number >= if version.es { es } else { desktop })
}

/// The first version of desktop GLSL and of GLSL ES that has the words, as glslang 12 reads them.
// Keywords that later versions add, and words that a version reserves for them: both are refused as
// names.
const SINCE: &[(u32, u32, &str)] = &[
    (
        110,
        100,
        "active asm cast class common double dvec2 dvec3 dvec4 enum extern external filter \
         fixed fvec2 fvec3 fvec4 half hvec2 hvec3 hvec4 inline input interface \
         isamplerCubeArray long namespace noinline output partition public sampler1D \
         sampler1DShadow sampler2DRect sampler2DRectShadow sampler2DShadow sampler3D \
         sampler3DRect samplerCubeArray samplerCubeArrayShadow short sizeof static template \
         this typedef union unsigned usamplerCubeArray using volatile",
    ),
    (120, 100, "invariant"),
    (120, 300, "centroid mat2x2 mat2x3 mat2x4 mat3x2 mat3x3 mat3x4 mat4x2 mat4x3 mat4x4"),
    (130, 100, "flat highp lowp mediump precision superp"),
    (
        130,
        300,
        "iimage1D iimage1DArray iimage2D iimage2DArray iimage2DRect iimage3D iimageBuffer \
         iimageCube image1D image1DArray image2D image2DArray image2DRect image3D imageBuffer \
         imageCube isampler1D isampler1DArray isampler2D isampler2DArray isampler3D \
         isamplerCube noperspective sampler1DArray sampler1DArrayShadow sampler2DArray \
         sampler2DArrayShadow samplerBuffer samplerCubeShadow smooth uimage1D uimage2D \
         uimage2DArray uimage3D uimageBuffer uimageCube uint usampler1D usampler1DArray \
         usampler2D usampler2DArray usampler3D usamplerCube uvec2 uvec3 uvec4",
    ),
    (140, 300, "isampler2DRect isamplerBuffer layout shared usampler2DRect usamplerBuffer"),
    (
        150,
        300,
        "isampler2DMS isampler2DMSArray sampler2DMS sampler2DMSArray usampler2DMS \
         usampler2DMSArray",
    ),
    (
        400,
        300,
        "dmat2 dmat2x2 dmat2x3 dmat2x4 dmat3 dmat3x2 dmat3x3 dmat3x4 dmat4 dmat4x2 dmat4x3 \
         dmat4x4 patch sample subroutine",
    ),
    (400, 310, "precise"),
    (420, 300, "atomic_uint coherent readonly resource restrict writeonly"),
    (
        420,
        310,
        "iimage2DMS iimage2DMSArray iimageCubeArray image2DMS image2DMSArray imageCubeArray \
         uimageCubeArray",
    ),
    (430, 310, "buffer"),
];
