//! `unused-block`: a block that no function accesses.

use rustc_hash::FxHashSet;

use super::definition::{Check, Lint, Subject};
use super::settings::Settings;
use super::show::bytes;
use landfall_layout::finding::{Finding, Level, Place};
use landfall_layout::shape::AddressSpace;
use landfall_layout::source::Language;

pub(super) const LINT: Lint = Lint {
    code: "unused-block",
    // Shared headers declare more than each shader uses, and the analysis takes naga's time.
    level: Level::Allow,
    what: "a block that no function of the shader reads or writes",
    why: "Drivers remove an unused block: `glGetUniformBlockIndex` does not find it, and a bind \
          group layout that wgpu derives from the shader lacks its binding. Only detected in \
          shaders that naga accepts unchanged, with an entry point: WGSL, and Vulkan GLSL without \
          `#if`. Blocks of included files are ignored. Allowed by default, because shared \
          declarations are often wanted.",
    example: "\
#version 450
layout(std140, set = 0, binding = 0) uniform Camera { mat4 view; } camera;
layout(std140, set = 0, binding = 1) uniform Fog { vec4 color; } fog;
void main() { gl_Position = camera.view[0]; }
",
    fix: "Remove the block, or use it.",
    check: Check::Naga(check),
};

fn check(subject: &Subject<'_>, _settings: &Settings) -> Vec<Finding> {
    let Some(touched) = accessed_parts(subject) else { return Vec::new() };
    let shader = subject.shader;
    let mut findings = Vec::new();
    for (block, touched) in shader.blocks.iter().zip(touched) {
        let placed = matches!(
            block.space,
            AddressSpace::Uniform | AddressSpace::Storage | AddressSpace::PushConstant
        );
        // An included file declares blocks for other shaders, too.
        if !placed || block.span.file != 0 || touched.is_none_or(|touched| !touched.is_empty()) {
            continue;
        }
        // As the API names it: a WGSL variable by its own name, a GLSL block by the block's.
        let name = match (&block.instance, shader.language) {
            (Some(instance), Language::Wgsl) => instance,
            (Some(_) | None, Language::Glsl | Language::SpirV) | (None, Language::Wgsl) => {
                &block.name
            }
        };
        let size = block.size.map(|size| format!(", {}", bytes(size))).unwrap_or_default();
        let message = format!("no function reads or writes block `{name}`{size}");
        findings.push(
            Finding::at(LINT.code, &**name, Place::new(&shader.files, block.span), message)
                .with_help("remove the block, and the code that fills its buffer"),
        );
    }
    findings
}

/// The paths of a block that functions access.
pub(super) type Used = FxHashSet<String>;

/// Returns the parts of each block that functions access, where that is known.
pub(super) fn accessed_parts(subject: &Subject<'_>) -> Option<Vec<Option<Used>>> {
    let shader = subject.shader;
    // Another variant of the text may use what this one does not.
    let conditional = shader.language == Language::Glsl
        && shader.files.iter().any(|file| {
            file.text.lines().any(|line| {
                line.trim_start()
                    .strip_prefix('#')
                    .is_some_and(|directive| directive.trim_start().starts_with("if"))
            })
        });
    if conditional || shader.blocks.is_empty() {
        return None;
    }
    #[cfg(feature = "analysis")]
    return landfall_layout::naga_compare::used::used(
        subject.source,
        &subject.options.read,
        &shader.blocks,
    );
    #[cfg(not(feature = "analysis"))]
    None
}
