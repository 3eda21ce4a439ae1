//! Inference of the API a GLSL text is written for.
//!
//! A text is Vulkan's if, read as OpenGL's with conditions evaluated, it contains anything that
//! only Vulkan GLSL has. A text without such signs that tests for `VULKAN` is written for both
//! APIs, unless what it declares for Vulkan is something that only OpenGL has.

use super::declarations::DeclarationReader;
use super::lexer::{Kind, Lexer, Token};
use super::parser::{Bodies, Parser};
use super::preprocess::{Preprocessor, Profile, Version};
use super::texts::Texts;
use crate::source::{ReadOptions, Target};
use std::sync::Arc;

/// Variables that only Vulkan GLSL has.
const VULKAN_NAMES: &[&str] = &["gl_VertexIndex", "gl_InstanceIndex"];

/// Layout qualifiers that only Vulkan GLSL has.
const VULKAN_LAYOUTS: &[&str] = &[
    "push_constant",
    "input_attachment_index",
    "buffer_reference",
    "shaderRecordEXT",
    "shaderRecordNV",
];

/// The layout qualifier of Vulkan GLSL that `GL_ARB_gl_spirv` takes over to OpenGL.
const CONSTANT_ID: &str = "constant_id";

/// Types and storage qualifiers that only Vulkan GLSL has; a name follows them.
const VULKAN_TYPES: &[&str] = &[
    "subpassInput",
    "subpassInputMS",
    "isubpassInput",
    "isubpassInputMS",
    "usubpassInput",
    "usubpassInputMS",
    "rayPayloadEXT",
    "rayPayloadInEXT",
    "rayPayloadNV",
    "rayPayloadInNV",
];

/// Types of Vulkan GLSL that are functions of old OpenGL GLSL: as types they are followed by a
/// name.
const SEPARATE_TYPES: &[&str] = &["texture2D", "textureCube"];

/// Extensions that only Vulkan GLSL has.
const VULKAN_EXTENSIONS: &[&str] = &["GL_EXT_ray_tracing", "GL_EXT_mesh_shader"];

/// The API a text is read for, and how it was determined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TargetDecision {
    /// Named by the caller or the text.
    Known(Target),
    /// Assumed: the text tests for `VULKAN` and is valid for both.
    Assumed(Target),
    /// OpenGL, although the text tests for `VULKAN`: what Vulkan's compilers would read has loose
    /// uniforms, which they take only with relaxed rules.
    Loose,
    /// The text is the same for both.
    Either,
}

/// Signs in the OpenGL reading of a text.
#[derive(Clone, Copy, Debug, Default)]
struct Signs {
    /// Whether it has anything that only Vulkan GLSL has.
    vulkan: bool,
    /// Whether it has specialisation constants.
    specialised: bool,
    /// Whether it tests for `VULKAN`.
    asks: bool,
}

/// Whether Vulkan's compilers accept that version: GLSL 1.40, GLSL ES 3.10 and later
/// (GL_KHR_vulkan_glsl; glslang's own bound for desktop). They have no compatibility profile.
fn is_vulkans(version: Version) -> bool {
    let oldest = if version.es { 310 } else { 140 };
    version.number >= oldest && version.profile != Profile::Compatibility
}

/// Whether a text of that version that tests for `VULKAN` is read for Vulkan.
fn prefers_vulkan(version: Version) -> bool {
    version.number >= if version.es { 310 } else { 440 }
}

/// Infers the API of a text without an explicit target; `version` is the declared one, if any.
pub fn decide(
    path: &str,
    text: &Arc<str>,
    options: &ReadOptions,
    version: Option<Version>,
) -> TargetDecision {
    // The cheap answers come first: by the version, then by a search for the bytes of any sign.
    // Only then is the text preprocessed.
    if version.is_some_and(|version| !is_vulkans(version)) {
        return TargetDecision::Known(Target::OpenGl);
    }
    if !may_show(text, options) {
        return TargetDecision::Either;
    }
    let signs = signs(path, text, options);
    match version {
        _ if signs.vulkan => TargetDecision::Known(Target::Vulkan),
        _ if signs.specialised && !signs.asks => TargetDecision::Known(Target::Vulkan),
        _ if signs.specialised => TargetDecision::Assumed(Target::Vulkan),
        _ if !signs.asks => TargetDecision::Either,
        _ if has_loose_uniforms(path, text, options) => TargetDecision::Loose,
        Some(version) if prefers_vulkan(version) => TargetDecision::Assumed(Target::Vulkan),
        Some(_) | None => TargetDecision::Assumed(Target::OpenGl),
    }
}

/// Whether the text, read for Vulkan, declares a uniform outside blocks that is no opaque handle.
// GL_KHR_vulkan_glsl takes only handles outside blocks.
fn has_loose_uniforms(path: &str, text: &Arc<str>, options: &ReadOptions) -> bool {
    let given = options.defines.iter().any(|(_, given)| has(given, "uniform"));
    if !given && !has(text, "uniform") && !has(text, "include") {
        return false;
    }
    let options = ReadOptions { target: Some(Target::Vulkan), ..options.clone() };
    let texts = Texts::new();
    let preprocessor = Preprocessor::new(path, text, None, &texts, &options);
    let mut reader = DeclarationReader::new(Parser::new(preprocessor, Bodies::Skip));
    reader.read(|parser, _| parser.forget());
    !reader.loose.is_empty()
}

/// Whether the text or a macro given with it may contain a sign, so that the text must be read: one
/// has some of the bytes of a sign, or the text includes other files.
// `include` and continued lines may hide a sign from the search, and macros given with `-D` may
// hold one.
fn may_show(text: &str, options: &ReadOptions) -> bool {
    let given = options.defines.iter().map(|(_, given)| given.as_str());
    let macros = !options.defines.is_empty() || has(text, "define");
    std::iter::once(text).chain(given).any(|text| {
        let words =
            [VULKAN_NAMES, VULKAN_LAYOUTS, &[CONSTANT_ID], VULKAN_EXTENSIONS, SEPARATE_TYPES];
        let parts = ["VULKAN", "subpassInput", "rayPayload", "include", "\\\n", "\\\r"];
        words.into_iter().flatten().any(|word| has(text, word))
            || parts.into_iter().any(|part| has(text, part))
            || may_qualify_by_set(text, macros)
    })
}

/// Whether a text without line continuations may have the layout qualifier `set = N`: outside
/// comments, `set` stands before `=`, or anywhere in a text with macros, which may join the two.
fn may_qualify_by_set(text: &str, macros: bool) -> bool {
    let mut lexer = Lexer::new(text, 0);
    while lexer.skip_past("set") {
        if macros || lexer.clone().next(&mut Vec::new()).is("=") {
            return true;
        }
    }
    false
}

fn has(text: &str, part: &str) -> bool {
    memchr::memmem::find(text.as_bytes(), part.as_bytes()).is_some()
}

// Read as OpenGL's: a text whose Vulkan parts are in `#ifdef VULKAN` has no signs outside them, so
// it is for both; one with signs outside can only be Vulkan's.
fn signs(path: &str, text: &Arc<str>, options: &ReadOptions) -> Signs {
    let options = ReadOptions { target: Some(Target::OpenGl), ..options.clone() };
    let texts = Texts::new();
    let mut preprocessor = Preprocessor::new(path, text, None, &texts, &options);
    let mut layout = LayoutParentheses::None;
    let mut signs = Signs::default();
    // Structures with the names of types of Vulkan GLSL.
    let mut own = Vec::new();
    let mut before = preprocessor.next();
    while before.kind != Kind::End {
        let token = preprocessor.next();
        layout = layout.after(&before);
        if before.is("struct") && is_type(token.text) && !own.contains(&token.text) {
            own.push(token.text);
        }
        // Two tokens decide each sign, so the scan is one behind the preprocessor.
        if !own.contains(&before.text) && is_vulkan(&before, &token, layout) {
            return Signs { vulkan: true, ..signs };
        }
        signs.specialised |=
            before.is(CONSTANT_ID) && matches!(layout, LayoutParentheses::Inside(_));
        before = token;
    }
    let extension = |name: &&str| VULKAN_EXTENSIONS.contains(name);
    Signs {
        vulkan: preprocessor.extensions.iter().any(extension),
        asks: preprocessor.tests_vulkan.get(),
        ..signs
    }
}

/// Whether the scan is inside `layout(…)`, and how many brackets deep.
#[derive(Clone, Copy)]
enum LayoutParentheses {
    None,
    Begun,
    Inside(u32),
}

impl LayoutParentheses {
    fn after(self, token: &Token<'_>) -> LayoutParentheses {
        match (self, token.text) {
            (LayoutParentheses::None | LayoutParentheses::Begun, "layout") => {
                LayoutParentheses::Begun
            }
            (LayoutParentheses::Begun, "(") => LayoutParentheses::Inside(1),
            (LayoutParentheses::Inside(depth), "(") => LayoutParentheses::Inside(depth + 1),
            (LayoutParentheses::Inside(1), ")") => LayoutParentheses::None,
            (LayoutParentheses::Inside(depth), ")") => LayoutParentheses::Inside(depth - 1),
            (LayoutParentheses::Inside(depth), _) => LayoutParentheses::Inside(depth),
            (LayoutParentheses::None | LayoutParentheses::Begun, _) => LayoutParentheses::None,
        }
    }
}

fn is_vulkan(token: &Token<'_>, next: &Token<'_>, layout: LayoutParentheses) -> bool {
    if token.kind != Kind::Name {
        return false;
    }
    let text = token.text;
    let inside = matches!(layout, LayoutParentheses::Inside(_));
    VULKAN_NAMES.contains(&text)
        || inside && VULKAN_LAYOUTS.contains(&text)
        || inside && text == "set" && next.is("=")
        || next.kind == Kind::Name && is_type(text)
}

fn is_type(name: &str) -> bool {
    VULKAN_TYPES.contains(&name) || SEPARATE_TYPES.contains(&name)
}
