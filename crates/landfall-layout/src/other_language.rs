//! Detection of shading languages other than GLSL and WGSL, by a file's extension or by tokens of
//! its text.

pub mod content;
mod template;

use std::path::Path;

use crate::error::{Error, ErrorKind};
use crate::text::word_filter::WordFilter;

/// Extensions of files in other shading languages.
const EXTENSIONS: &[(&str, &[&str])] = &[
    ("HLSL", &["hlsl", "hlsli", "fx", "fxh", "usf", "ush", "cginc"]),
    ("Slang", &["slangh"]),
    ("Godot's own language", &["gdshader", "gdshaderinc"]),
    ("Metal", &["metal"]),
];

/// Returns the language of a file by its extension, if it is not GLSL or WGSL.
pub fn of_path(path: &Path) -> Option<&'static str> {
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    EXTENSIONS.iter().find(|row| row.1.contains(&extension.as_str())).map(|row| row.0)
}

/// Rejects a file whose extension belongs to another shading language.
///
/// # Errors
/// The extension is one of HLSL, Slang, Metal or Godot's own language.
pub fn refuse(path: &Path) -> Result<(), Error> {
    let Some(language) = of_path(path) else { return Ok(()) };
    let help = "landfall reads GLSL and WGSL; if it is GLSL, pass `--language glsl`";
    let message = format!("is {language} by its extension, which landfall does not read");
    Err(Error::new(path.display().to_string(), message).with_help(help).unreadable())
}

/// Rejects a text that is no shader: Slang in a file with the extension that RetroArch's GLSL has as
/// well, and a template.
///
/// # Errors
/// The extension is `.slang`, and the text does not begin with `#version`, as RetroArch's do; or the
/// text has placeholders of a template outside comments.
pub(crate) fn refuse_text(path: &Path, text: &str) -> Result<(), Error> {
    let refused = |message: String| Error::new(path.display().to_string(), message);
    if content::is_slang(path) && !content::begins_with_version(text) {
        let help = "landfall reads GLSL and WGSL; RetroArch's `.slang` begins with `#version`";
        let error = refused("is Slang, which landfall does not read".to_string());
        return Err(error.with_help(help).unreadable());
    }
    let Some(found) = template::placeholder(text) else { return Ok(()) };
    // The placeholder's own line, for the message.
    let line = text[..found.start].matches('\n').count() + 1;
    let message = format!("is a template: line {line} has `{}`", &text[found]);
    let help = "landfall reads GLSL and WGSL; fill the template in as the program does, and pass the \
                result (in a build script, `Build::source(name, text)` takes it)";
    Err(Error { kind: ErrorKind::Template, ..refused(message) }.with_help(help))
}

/// Words that begin a declaration in another language and are not keywords of GLSL.
const WORDS: &[(&str, &[&str])] = &[
    (
        "HLSL",
        &[
            "cbuffer",
            "tbuffer",
            "ConstantBuffer",
            "StructuredBuffer",
            "RWStructuredBuffer",
            "ByteAddressBuffer",
            "RWByteAddressBuffer",
            "Texture2D",
            "Texture3D",
            "TextureCube",
            "Texture2DArray",
            "RWTexture2D",
            "SamplerState",
            "SamplerComparisonState",
            "groupshared",
            "float2",
            "float3",
            "float4",
            "float3x3",
            "float4x4",
        ],
    ),
    ("Slang", &["import", "ParameterBlock", "interface", "extension", "__include", "module"]),
    ("Metal", &["using", "kernel", "constant", "fragment", "vertex"]),
    (
        "WGSL",
        &[
            "fn",
            "var",
            "@",
            "override",
            "requires",
            "enable",
            "alias",
            "diagnostic",
            "const_assert",
        ],
    ),
    ("ShaderLab", &["Shader"]),
];

/// Words that begin a declaration in GLSL and none in WGSL.
const GLSL_WORDS: &[&str] = &[
    "attribute",
    "buffer",
    "flat",
    "in",
    "inout",
    "layout",
    "out",
    "precision",
    "uniform",
    "varying",
    "void",
];

/// Returns the language in which a declaration of a WGSL text may begin with the tokens `first` and
/// `next`, if it is not WGSL.
pub(crate) fn of_words_in_wgsl(first: &str, next: &str) -> Option<&'static str> {
    let name = next.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    match of_words(first, next) {
        Some("WGSL") | None => {}
        other => return other,
    }
    let is_glsl = GLSL_WORDS.contains(&first) && (name || first == "layout" && next == "(");
    is_glsl.then_some("GLSL")
}

/// Whether a word may begin a declaration of another language.
pub(crate) fn may_begin(first: &str) -> bool {
    const FILTER: WordFilter = {
        let mut filter = WordFilter::NONE;
        let mut at = 0;
        while at < WORDS.len() {
            filter = filter.with(WORDS[at].1);
            at += 1;
        }
        filter
    };
    FILTER.may_contain(first) && WORDS.iter().any(|row| row.1.contains(&first))
}

/// Returns the language of a declaration that begins with `struct` or `const`, if the tokens after it
/// do not occur in GLSL: `const N: u32`, `struct S { a: f32`, `struct S { float4 a : POSITION`.
pub(crate) fn of_members(first: &str, after: [&str; 5]) -> Option<&'static str> {
    match (first, after) {
        // `name :` begins a member in WGSL, where HLSL has a semantic after the name.
        ("const", [_, ":", ..]) | ("struct", [_, "{", "@", ..] | [_, "{", _, ":", _]) => {
            Some("WGSL")
        }
        ("struct", [_, "{", _, _, ":"]) => Some("HLSL"),
        _ => None,
    }
}

/// Returns the language in which a declaration may begin with the tokens `first` and `next`.
///
/// Most of these words are valid names in GLSL, so the next token must fit as well.
pub(crate) fn of_words(first: &str, next: &str) -> Option<&'static str> {
    let row = WORDS.iter().find(|row| row.1.contains(&first))?;
    let name = next.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    let fits = match (row.0, first) {
        ("ShaderLab", _) => next.starts_with('"'),
        ("WGSL", "var") => next == "<" || name,
        ("WGSL", "diagnostic") => next == "(",
        ("Metal", "using") => next == "namespace",
        ("HLSL", "ConstantBuffer" | "StructuredBuffer" | "RWStructuredBuffer")
        | ("Slang", "ParameterBlock") => next == "<",
        ("HLSL", "Texture2D" | "Texture3D" | "TextureCube" | "Texture2DArray" | "RWTexture2D") => {
            next == "<" || name
        }
        _ => name,
    };
    fits.then_some(row.0)
}
