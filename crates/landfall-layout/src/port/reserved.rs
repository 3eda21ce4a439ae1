//! Renames identifiers with another meaning, or none, in GLSL 4.50 for Vulkan, also in macros and
//! inactive branches.

use crate::diagnostic::Code;
use rustc_hash::FxHashSet;

use super::edits::Edits;
use super::shader::Shader;
use crate::Diagnostic;
use crate::source::{Span, Target};
use crate::syntax::glsl::lexer::Kind;

/// Function names before GLSL 1.30 and ES 3.00, with their names since.
const FUNCTIONS: &[(&str, &str)] = &[
    ("texture1D", "texture"),
    ("texture2D", "texture"),
    ("texture3D", "texture"),
    ("textureCube", "texture"),
    ("texture2DRect", "texture"),
    ("texture1DProj", "textureProj"),
    ("texture2DProj", "textureProj"),
    ("texture3DProj", "textureProj"),
    ("texture2DRectProj", "textureProj"),
    ("texture1DLod", "textureLod"),
    ("texture2DLod", "textureLod"),
    ("texture3DLod", "textureLod"),
    ("textureCubeLod", "textureLod"),
    ("texture2DLodEXT", "textureLod"),
    ("textureCubeLodEXT", "textureLod"),
    ("texture2DLodARB", "textureLod"),
    ("texture1DProjLod", "textureProjLod"),
    ("texture2DProjLod", "textureProjLod"),
    ("texture3DProjLod", "textureProjLod"),
    ("texture2DProjLodEXT", "textureProjLod"),
    ("texture2DGradEXT", "textureGrad"),
    ("texture2DGradARB", "textureGrad"),
    ("textureCubeGradEXT", "textureGrad"),
    ("texture2DProjGradEXT", "textureProjGrad"),
];

/// Functions that used to return a `vec4` and now return a `float`.
const SHADOWS: &[(&str, &str)] = &[
    ("shadow1D", "texture"),
    ("shadow2D", "texture"),
    ("shadow1DProj", "textureProj"),
    ("shadow2DProj", "textureProj"),
    ("shadow1DLod", "textureLod"),
    ("shadow2DLod", "textureLod"),
];

/// Renamed built-in variables.
const VARIABLES: &[(&str, &str)] = &[
    ("gl_VertexID", "gl_VertexIndex"),
    ("gl_InstanceID", "gl_InstanceIndex"),
    ("gl_FragDepthEXT", "gl_FragDepth"),
];

/// The state of the fixed-function pipeline, which Vulkan lacks.
const FIXED: &[&str] = &[
    "gl_Vertex",
    "gl_Normal",
    "gl_Color",
    "gl_SecondaryColor",
    "gl_FogCoord",
    "gl_FrontColor",
    "gl_BackColor",
    "gl_FrontSecondaryColor",
    "gl_BackSecondaryColor",
    "gl_TexCoord",
    "gl_FogFragCoord",
    "gl_ClipVertex",
    "gl_ModelViewMatrix",
    "gl_ProjectionMatrix",
    "gl_ModelViewProjectionMatrix",
    "gl_NormalMatrix",
    "gl_TextureMatrix",
    "gl_LightSource",
    "gl_LightModel",
    "gl_FrontMaterial",
    "gl_BackMaterial",
    "gl_FrontLightModelProduct",
    "gl_FrontLightProduct",
    "gl_Fog",
    "gl_DepthRange",
    "ftransform",
];

/// The version of keywords of Vulkan's GLSL only.
const NEVER: u32 = u32::MAX;

/// Former identifiers that became keywords, with the desktop and the ES version that added them.
const KEYWORDS: &[(&str, u32, u32)] = &[
    ("flat", 130, 300),
    ("smooth", 130, 300),
    ("noperspective", 130, 300),
    ("centroid", 120, 300),
    ("layout", 140, 300),
    ("uint", 130, 300),
    ("uvec2", 130, 300),
    ("uvec3", 130, 300),
    ("uvec4", 130, 300),
    ("switch", 130, 300),
    ("case", 130, 300),
    ("patch", 400, 320),
    ("sample", 400, 320),
    ("subroutine", 400, NEVER),
    ("precise", 400, 320),
    ("coherent", 420, 310),
    ("volatile", 420, 310),
    ("restrict", 420, 310),
    ("readonly", 420, 310),
    ("writeonly", 420, 310),
    ("shared", 430, 310),
    ("buffer", 430, 310),
    ("sampler", NEVER, NEVER),
    ("samplerShadow", NEVER, NEVER),
    ("subpassInput", NEVER, NEVER),
];

/// Renames identifiers; returns the renamed names of the shader itself.
pub(super) fn rename(shader: &Shader<'_>, edits: &mut Edits) -> Vec<(String, String)> {
    let defined = own_functions(shader);
    let own = own_names(shader);
    let mut renamed: Vec<(String, String)> = Vec::new();
    let words: Vec<usize> = shader.words().collect();
    for &at in &words {
        let token = &shader.raw.tokens[at];
        let word = shader.word(at);
        let range = token.start..token.end;
        let called =
            shader.raw.tokens.get(at + 1).is_some_and(|t| &shader.text[t.start..t.end] == "(");
        if let Some((_, new)) = VARIABLES.iter().find(|row| row.0 == word) {
            edits.replace(range, *new);
        } else if word == "__VERSION__" {
            edits.replace(range, shader.raw.version.to_string());
        } else if let Some(new) = function(FUNCTIONS, word).filter(|_| !defined.contains(word)) {
            // Without a call it is a macro's body, or a name of the shader itself.
            if called || token.directive.is_some() && !own.contains(word) {
                edits.replace(range, new);
            }
        } else if let Some(new) = function(SHADOWS, word).filter(|_| !defined.contains(word)) {
            if let Some(close) = closing(shader, at + 1).filter(|_| called) {
                edits.replace(range, format!("vec4({new}"));
                edits.insert(close, ")");
            }
        } else if own.contains(word) && !(called && word == "texture") && !shader.in_layout(at) {
            let known = renamed.iter().find(|(old, _)| old == word);
            let new = known.map_or_else(|| shader.unused(&format!("{word}_")), |row| row.1.clone());
            if known.is_none() {
                renamed.push((word.to_string(), new.clone()));
            }
            edits.replace(range, new);
        }
    }
    renamed
}

fn function(table: &[(&str, &'static str)], word: &str) -> Option<&'static str> {
    table.iter().find(|row| row.0 == word).map(|row| row.1)
}

/// The names of the shader's own functions, which may hide old built-in ones.
fn own_functions<'a>(shader: &Shader<'a>) -> FxHashSet<&'a str> {
    shader.functions().map(|function| function.name.text).collect()
}

/// Names of the shader itself that are keywords in the new language.
fn own_names<'a>(shader: &Shader<'a>) -> FxHashSet<&'a str> {
    let old_language = shader.raw.version < if shader.raw.es { 300 } else { 130 };
    // Two names never follow each other: such a word is a keyword, enabled by an extension.
    let meant = |at: usize| {
        let next = shader.raw.tokens.get(at + 1);
        next.is_some_and(|t| t.kind == Kind::Name && shader.raw.tokens[at].directive == t.directive)
    };
    let keywords: FxHashSet<&str> =
        shader.words().filter(|&at| meant(at)).map(|at| shader.word(at)).collect();
    let words = shader.words().filter(|&at| !shader.in_layout(at)).map(|at| shader.word(at));
    let words = words.filter(|word| !keywords.contains(word));
    words
        .filter(|word| {
            let since = KEYWORDS.iter().find(|row| row.0 == *word);
            let keyword = since.is_some_and(|row| {
                let since = if shader.raw.es { row.2 } else { row.1 };
                let vulkan = since == NEVER && shader.raw.target == Some(Target::Vulkan);
                shader.raw.version < since && !vulkan
            });
            // `texture2D` and the like are types of Vulkan's GLSL.
            let ty = old_language && *word == "texture";
            keyword || ty
        })
        .collect()
}

/// The byte after the `)` that matches the `(` of a raw token.
fn closing(shader: &Shader<'_>, open: usize) -> Option<usize> {
    let mut depth = 0usize;
    for token in shader.raw.tokens.get(open..)? {
        match &shader.text[token.start..token.end] {
            "(" => depth += 1,
            ")" if depth == 1 => return Some(token.end),
            ")" => depth = depth.checked_sub(1)?,
            _ => {}
        }
    }
    None
}

/// Rejects names without a counterpart.
pub(super) fn refuse(shader: &Shader<'_>, problems: &mut Vec<Diagnostic>) {
    let mut reported = FxHashSet::default();
    for token in shader.code.iter().filter(|token| token.kind == Kind::Name) {
        if FIXED.contains(&token.text) && reported.insert(token.text) {
            let span = Span { file: 0, start: token.start as u32, end: token.end as u32 };
            let message = format!(
                "`{}` is state of the fixed-function pipeline, which Vulkan lacks",
                token.text
            );
            let problem = Diagnostic::error(Code::NotPortable, span, message)
                .with_help("replace it with an attribute, a varying or a uniform");
            problems.push(problem);
        }
    }
}
