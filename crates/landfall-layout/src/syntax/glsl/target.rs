//! Which API a GLSL text is written for, as far as it shows.

use crate::source::Target;

/// Words that only Vulkan's GLSL has.
const VULKAN_WORDS: &[&str] = &[
    "push_constant",
    "constant_id",
    "subpassInput",
    "input_attachment_index",
    "gl_VertexIndex",
    "gl_InstanceIndex",
    "buffer_reference",
    "shaderRecordEXT",
    "rayPayload",
    "texture2D ",
    "textureCube ",
    "GL_EXT_ray_tracing",
    "GL_EXT_mesh_shader",
];

/// The API a text is written for, by what only Vulkan's GLSL has: `set = N` and [`VULKAN_WORDS`];
/// or because it asks for `VULKAN` in a version that Vulkan's tools take. Without any of it the
/// text may still be either's.
pub fn target_of(text: &str) -> Option<Target> {
    let bytes = text.as_bytes();
    let word = VULKAN_WORDS.iter().any(|w| memchr::memmem::find(bytes, w.as_bytes()).is_some());
    let set = || {
        memchr::memmem::find_iter(bytes, b"set").any(|at| {
            let starts = at > 0 && matches!(bytes[at - 1], b' ' | b'(' | b',' | b'\t');
            starts
                && text[at + 3..].trim_start().strip_prefix('=').is_some_and(|rest| {
                    rest.trim_start().starts_with(|c: char| c.is_ascii_alphanumeric())
                        && text[..at].rfind("layout").is_some_and(|l| !text[l..at].contains(')'))
                })
        })
    };
    let asks = || memchr::memmem::find(bytes, b"VULKAN").is_some() && is_recent(text);
    (word || set() || asks()).then_some(Target::Vulkan)
}

/// Whether the text declares version 4.40 or ES 3.10 at least.
fn is_recent(text: &str) -> bool {
    let declared = text.split_once("#version").map_or("", |(_, rest)| rest.trim_start());
    let line = declared.lines().next().unwrap_or("");
    let number: u32 = line.split_whitespace().next().and_then(|n| n.parse().ok()).unwrap_or(0);
    number >= if line.ends_with("es") { 310 } else { 440 }
}
