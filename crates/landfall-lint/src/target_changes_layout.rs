//! `target-changes-layout`: a block whose layout depends on the target API. Found while the shader
//! is laid out, by `landfall_layout::layout::targets`.

use super::definition::{Check, Lint};
use landfall_layout::finding::Level;
use landfall_layout::layout::targets::CODE;

pub(super) const LINT: Lint = Lint {
    code: CODE,
    level: Level::Warn,
    what: "a block whose layout depends on whether the shader is compiled for OpenGL or Vulkan",
    why: "A shader that tests `#ifdef VULKAN`, and contains nothing else that only one of the two \
          APIs accepts, is compiled for both. If a block has other members in the two branches, a \
          buffer filled for one API is read at the wrong bytes by the other. Landfall reads such a \
          shader as Vulkan's from version 4.40 and ES 3.10 on, and as OpenGL's below; `--target` \
          chooses explicitly.",
    example: "\
#version 330 core
#ifdef VULKAN
layout(set = 0, binding = 0, std140) uniform Light { vec4 color; } light;
#else
layout(std140) uniform Light { float scale; vec4 color; } light; // color at 16, not 0
#endif
void main() {}
",
    fix: "Declare the same members in both branches, or name the API of the shaders with \
          `--target` or with `targets` in landfall.toml.",
    check: Check::Elsewhere,
};
