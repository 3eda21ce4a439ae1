//! Renames identifiers with another meaning, or none, in GLSL 4.50 for Vulkan, also in macros and
//! inactive branches.

use rustc_hash::FxHashSet;

use super::edits::Edits;
use super::later_functions::is_later;
use super::shader::{Shader, refusal};
use landfall_layout::Diagnostic;
use landfall_layout::source::Target;
use landfall_layout::syntax::glsl::lexer::Kind;
use landfall_layout::syntax::glsl::types::builtin;
use landfall_layout::text::word_list::WordList;

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

/// Functions that used to return a `vec4` (GLSL 1.20 §8.7) and now return a `float`.
const SHADOWS: &[(&str, &str)] = &[
    ("shadow1D", "texture"),
    ("shadow2D", "texture"),
    ("shadow1DProj", "textureProj"),
    ("shadow2DProj", "textureProj"),
    ("shadow1DLod", "textureLod"),
    ("shadow2DLod", "textureLod"),
];

/// Renamed built-in variables.
// GL_KHR_vulkan_glsl: these count from the first vertex and instance of the draw.
const VARIABLES: &[(&str, &str)] = &[
    ("gl_VertexID", "gl_VertexIndex"),
    ("gl_InstanceID", "gl_InstanceIndex"),
    ("gl_FragDepthEXT", "gl_FragDepth"),
];

/// The state of the fixed-function pipeline, which Vulkan lacks.
const FIXED: WordList = WordList(
    "gl_Vertex gl_Normal gl_Color gl_SecondaryColor gl_FogCoord gl_FrontColor gl_BackColor \
     gl_FrontSecondaryColor gl_BackSecondaryColor gl_TexCoord gl_FogFragCoord gl_ClipVertex \
     gl_ModelViewMatrix gl_ProjectionMatrix gl_ModelViewProjectionMatrix gl_NormalMatrix \
     gl_TextureMatrix gl_LightSource gl_LightModel gl_FrontMaterial gl_BackMaterial \
     gl_FrontLightModelProduct gl_FrontLightProduct gl_Fog gl_DepthRange ftransform",
);

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

/// Renames of the shader's own names: old and new names.
#[derive(Debug, Default)]
pub(super) struct Renamed {
    pub names: Vec<(String, String)>,
    /// Functions only: a member of the same name keeps it.
    pub functions: Vec<(String, String)>,
}

/// Renames identifiers; returns the renamed names of the shader itself.
pub(super) fn rename(shader: &Shader<'_>, edits: &mut Edits) -> Renamed {
    let defined = own_functions(shader);
    let own = own_names(shader);
    let version = shader.language_version();
    let later = |name: &&&str| is_later(name, version, shader.raw.es);
    // A shader's own function that a later version has built in is another one there.
    let clashing: FxHashSet<&str> = defined.iter().filter(later).copied().collect();
    let redefined = Redefined::new(shader, &clashing);
    let mut renamed = Renamed::default();
    let words: Vec<usize> = shader.words().collect();
    for &at in &words {
        let token = &shader.raw.tokens[at];
        let word = shader.word(at);
        let range = shader.raw_bytes(at);
        let called = shader.word(at + 1) == "(";
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
            // The call is wrapped: `shadow2D(s, p).r` stays valid on a `vec4`.
            if let Some(close) = closing(shader, at + 1).filter(|_| called) {
                edits.replace(range, format!("vec4({new}"));
                edits.insert(close, ")");
            }
        // A variable `texture` would hide the function that `texture2D` becomes; a call of `texture`
        // means that function already.
        } else if own.contains(word) && !(called && word == "texture") && !shader.in_layout(at) {
            edits.replace(range, new_name(shader, word, &mut renamed.names));
        } else if (clashing.contains(word) || redefined.is_own(shader, at))
            && (called || token.directive.is_some())
            // A member of that name is no function.
            && !(at > 0 && shader.word(at - 1) == ".")
        {
            edits.replace(range, new_name(shader, word, &mut renamed.functions));
        }
    }
    renamed
}

/// Functions on matrices that no conversion of their arguments makes ambiguous.
const OF_MATRICES: &[&str] =
    &["determinant", "inverse", "matrixCompMult", "outerProduct", "transpose"];

/// A shader's own functions that have the name of a built-in one of its version. Which one a call
/// means depends on its first argument.
struct Redefined<'a> {
    /// The type of the first parameter of each of those functions.
    parameters: Vec<(&'a str, &'a str)>,
    /// Names and the types they are declared with anywhere.
    declared: Vec<(&'a str, &'a str)>,
}

impl<'a> Redefined<'a> {
    fn new(shader: &Shader<'a>, later: &FxHashSet<&str>) -> Redefined<'a> {
        let is_own = |name: &str| OF_MATRICES.contains(&name) && !later.contains(name);
        let functions = shader.functions().filter(|function| is_own(function.name.text));
        let parameters: Vec<_> = functions
            .filter_map(|function| {
                let first = function.parameters.first()?;
                Some((function.name.text, shader.type_word(&first.ty)))
            })
            .collect();
        let pairs = shader.code.windows(2).filter(|_| !parameters.is_empty());
        let declared = pairs
            .filter(|pair| pair[1].kind == Kind::Name && builtin(pair[0].text).is_some())
            .map(|pair| (pair[1].text, pair[0].text))
            .collect();
        Redefined { parameters, declared }
    }

    /// Whether a word names one of them: it does unless the argument has another type.
    fn is_own(&self, shader: &Shader<'_>, at: usize) -> bool {
        let word = shader.word(at);
        let own = || self.parameters.iter().filter(|(name, _)| *name == word).map(|(_, ty)| *ty);
        if own().next().is_none() {
            return false;
        }
        // The token after `name(`, and the one after that: an argument of one word, or a
        // constructor.
        let (argument, after) = (shader.word(at + 2), shader.word(at + 3));
        let types: Vec<&str> = match after {
            // A constructor.
            "(" if builtin(argument).is_some() => vec![argument],
            "," | ")" => {
                let of = self.declared.iter().filter(|(name, _)| *name == argument);
                of.map(|(_, ty)| *ty).collect()
            }
            _ => Vec::new(),
        };
        types.is_empty() || types.iter().any(|ty| own().any(|own| own == *ty))
    }
}

/// The new name of a word, added to `renamed` at its first use.
fn new_name(shader: &Shader<'_>, word: &str, renamed: &mut Vec<(String, String)>) -> String {
    if let Some((_, new)) = renamed.iter().find(|(old, _)| old == word) {
        return new.clone();
    }
    let new = shader.unused(&format!("{word}_"));
    renamed.push((word.to_string(), new.clone()));
    new
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
    let version = shader.language_version();
    let old_language = version < if shader.raw.es { 300 } else { 130 };
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
        // What the text says of itself counts: a keyword of its own version is not its name.
        .filter(|word| {
            let since = KEYWORDS.iter().find(|row| row.0 == *word);
            let keyword = since.is_some_and(|row| {
                let since = if shader.raw.es { row.2 } else { row.1 };
                let vulkan = since == NEVER && shader.raw.target == Some(Target::Vulkan);
                version < since && !vulkan
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
    for at in open..shader.raw.tokens.len() {
        match shader.word(at) {
            "(" => depth += 1,
            ")" if depth == 1 => return Some(shader.raw_bytes(at).end),
            ")" => depth = depth.checked_sub(1)?,
            _ => {}
        }
    }
    None
}

/// Rejects names without a counterpart.
pub(super) fn refuse(shader: &Shader<'_>, problems: &mut Vec<Diagnostic>) {
    let mut reported = FxHashSet::default();
    for (at, token) in shader.code.iter().enumerate() {
        let name = token.text;
        if FIXED.contains(name) && reported.insert(name) {
            let message =
                format!("`{name}` is state of the fixed-function pipeline, which Vulkan lacks");
            let problem = refusal(shader.span(at), message);
            problems
                .push(problem.with_help("replace it with an attribute, a varying or a uniform"));
        }
    }
}
