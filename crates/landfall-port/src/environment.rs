//! Version, extensions and conditions: the ported text declares another version, but keeps the
//! active branches of the original.

use super::edits::Edits;
use super::shader::Shader;
use landfall_layout::source::Target;
use landfall_layout::text::word_list::WordList;

/// Extensions that are part of GLSL 4.50, or have no effect in it.
const ABSORBED: WordList = WordList(
    "GL_OES_standard_derivatives GL_OES_texture_3D GL_OES_EGL_image_external \
     GL_EXT_shader_texture_lod GL_EXT_frag_depth GL_EXT_draw_buffers GL_EXT_gpu_shader4 \
     GL_EXT_texture_array GL_ARB_draw_buffers GL_ARB_draw_instanced GL_ARB_shader_texture_lod \
     GL_ARB_texture_rectangle GL_ARB_explicit_attrib_location GL_ARB_explicit_uniform_location \
     GL_ARB_uniform_buffer_object GL_ARB_shader_storage_buffer_object \
     GL_ARB_shading_language_420pack GL_ARB_separate_shader_objects GL_ARB_enhanced_layouts \
     GL_ARB_gpu_shader5 GL_ARB_texture_gather GL_ARB_texture_query_lod \
     GL_ARB_fragment_coord_conventions GL_ARB_conservative_depth",
);

/// Rewrites `#version`, `#extension` and conditions.
pub(super) fn adapt(shader: &Shader<'_>, edits: &mut Edits) {
    let mut version = false;
    // Extensions enabled so far: a condition sees those before it.
    let mut enabled: Vec<&str> = Vec::new();
    for directive in shader.directives() {
        let words: Vec<&str> = directive.clone().skip(1).map(|at| shader.word(at)).collect();
        let first = &shader.raw.tokens[directive.start];
        let last = &shader.raw.tokens[directive.end - 1];
        let bytes = first.start..last.end;
        match words.as_slice() {
            ["version", ..] if first.active => {
                version = true;
                if needs_version(shader) {
                    edits.replace(bytes, "#version 450");
                }
            }
            ["extension", name, ":", behaviour, ..] => {
                if first.active && matches!(*behaviour, "enable" | "require" | "warn") {
                    enabled.push(name);
                }
                if ABSORBED.contains(name) {
                    // Comment the line out, so that line numbers stay.
                    edits.insert(bytes.start, "// ");
                }
            }
            ["if" | "elif", ..] => {
                // The condition alone, without `#` and its name.
                condition(shader, directive.start + 2..directive.end, &enabled, edits)
            }
            [word @ ("ifdef" | "ifndef"), name, ..] => {
                if let Some(value) = old_definition(shader, name, &enabled) {
                    let holds = value.is_some() == (*word == "ifdef");
                    edits.replace(bytes, format!("#if {}", u8::from(holds)));
                }
            }
            _ => {}
        }
    }
    // Without `#version` a text is GLSL 1.10 (GLSL 4.60 §3.3).
    if !version {
        edits.insert(0, "#version 450\n");
    }
}

fn needs_version(shader: &Shader<'_>) -> bool {
    shader.raw.es || shader.raw.version < 450
}

/// Replaces macros of the original's compiler, which the new one lacks, in a condition.
fn condition(
    shader: &Shader<'_>,
    tokens: std::ops::Range<usize>,
    enabled: &[&str],
    edits: &mut Edits,
) {
    let mut at = tokens.start;
    while at < tokens.end {
        let start = at;
        let mut defined = false;
        // `defined NAME` or `defined(NAME)`, replaced as a whole by 1 or 0.
        if shader.word(at) == "defined" {
            defined = true;
            at += 1;
            let bracket = at < tokens.end && shader.word(at) == "(";
            at += usize::from(bracket);
            if at >= tokens.end {
                return;
            }
            let name = shader.word(at);
            at += usize::from(bracket);
            if at >= tokens.end {
                return;
            }
            replace(shader, start..at + 1, name, defined, enabled, edits);
        } else {
            replace(shader, start..at + 1, shader.word(at), defined, enabled, edits);
        }
        at += 1;
    }
}

fn replace(
    shader: &Shader<'_>,
    tokens: std::ops::Range<usize>,
    name: &str,
    defined: bool,
    enabled: &[&str],
    edits: &mut Edits,
) {
    let Some(value) = old_definition(shader, name, enabled) else { return };
    let text = if defined { u32::from(value.is_some()) } else { value.unwrap_or(0) };
    let raw = &shader.raw.tokens;
    edits.replace(raw[tokens.start].start..raw[tokens.end - 1].end, text.to_string());
}

/// The original compiler's definition of a macro, if the new compiler's differs: `Some(None)` if
/// it was not defined.
fn old_definition(shader: &Shader<'_>, name: &str, enabled: &[&str]) -> Option<Option<u32>> {
    let (version, es) = (shader.raw.version, shader.raw.es);
    match name {
        // `reserved` replaces `__VERSION__`.
        "GL_ES" => es.then_some(Some(1)),
        "GL_es_profile" => (es && version >= 300).then_some(Some(1)),
        // OpenGL ES 2 defines it where fragment shaders have `highp`; desktop versions leave it
        // undefined.
        "GL_FRAGMENT_PRECISION_HIGH" => Some(es.then_some(1)),
        "GL_core_profile" => (es || version < 150).then_some(None),
        "GL_compatibility_profile" => None,
        "VULKAN" => (shader.raw.target != Some(Target::Vulkan)).then_some(None),
        _ => {
            // The macro of an extension, `GL_EXT_name`: the original is read as by a compiler that
            // has the extensions which it enables.
            let vendor = name.strip_prefix("GL_")?.split('_').next()?;
            let extension = !vendor.is_empty() && vendor.chars().all(|c| c.is_ascii_uppercase());
            extension.then(|| enabled.contains(&name).then_some(1))
        }
    }
}
