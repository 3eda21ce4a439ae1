//! Lints whose findings are those of other code: warnings of the layout, and of what could not be
//! looked at. Here are their explanations and levels.

use super::definition::{Check, Lint};
use landfall_layout::finding::Level;

pub(super) const NOT_ANALYSED: Lint = Lint {
    code: "not-analysed",
    level: Level::Warn,
    what: "a shader with lights whose functions cannot be followed, with the place and the reason",
    why: "The lints that follow code find nothing in it, so that their silence says nothing. The \
          construct is one that Landfall or naga does not support; it may be right.",
    example: "#version 450\n\
              struct Light { vec3 position; vec3 color; };\n\
              layout(std140, binding = 0) uniform Lights { Light light; };\n\
              subroutine float Falloff(float d);\n\
              subroutine uniform Falloff falloff;\n\
              layout(location = 0) in vec3 to;\n\
              layout(location = 1) in vec3 normal;\n\
              layout(location = 0) out vec4 color;\n\
              void main() { color = vec4(light.color * pow(dot(normal, to), 8.0) * falloff(2.0), 1.0); }\n",
    fix: "Write it another way, or allow the lint for the file.",
    check: Check::Elsewhere,
};

pub(super) const UNDEFINED_MACRO: Lint = Lint {
    code: "undefined-macro",
    level: Level::Warn,
    what: "a condition of `#if` with a name that is not a macro, which counts as 0",
    why: "A misspelt macro, or one that the program was to define, switches the other branch on \
          without a word. GLSL ES refuses such a condition, as do some drivers of OpenGL.",
    example: "#version 450\n\
              #if SHADOWS\n\
              layout(std140, binding = 0) uniform Light { vec4 color; mat4 shadow; };\n\
              #else\n\
              layout(std140, binding = 0) uniform Light { vec4 color; };\n\
              #endif\n\
              layout(location = 0) out vec4 o;\n\
              void main() { o = color; }\n",
    fix: "Write `#ifdef`, or define the macro with `-D NAME=VALUE` or in the configuration.",
    check: Check::Elsewhere,
};

pub(super) const UNIFORM_CONSTRAINTS: Lint = Lint {
    code: "uniform-constraints",
    level: Level::Deny,
    what: "a WGSL block whose layout the uniform address space does not allow: an array stride or \
           the offset of a structure or array that is no multiple of 16",
    why: "WGSL §14.4.1: without the language feature `uniform_buffer_standard_layout` a compiler \
          refuses the shader, and naga 30, so wgpu, always does. The level is `deny`; it is `warn` \
          where targets are configured and `webgpu` is none of them.",
    example: "struct Weights { first: f32, others: array<f32, 3> }\n\
              @group(0) @binding(0) var<uniform> weights: Weights;\n",
    fix: "Give the member `@align(16)`, or the elements a size that is a multiple of 16.",
    check: Check::Elsewhere,
};

pub(super) const UNKNOWN_BLOCK: Lint = Lint {
    code: "unknown-block",
    level: Level::Deny,
    what: "a table of the configuration for a block that no shader has",
    why: "The numbers of the table are compared with nothing, as if they were right.",
    example: "layout(std140) uniform Lights { vec4 color; int count; };\n",
    fix: "Correct the name of the block, or the pattern of the files.",
    check: Check::Elsewhere,
};
