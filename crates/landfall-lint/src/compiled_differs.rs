//! `compiled-differs`: SPIR-V modules whose members lie elsewhere than in the text that they were
//! compiled from, by `[[compiled]]` in `landfall.toml`.
//!
//! The command reads both files and gives their layouts to [`findings`].

use super::definition::{Check, Lint};
use super::settings::CompiledShader;
use landfall_layout::ShaderLayout;
use landfall_layout::diagnostic::Label;
use landfall_layout::diff::{Change, Kind, Side, diff};
use landfall_layout::finding::{Finding, Level, Place};

pub const LINT: Lint = Lint {
    code: "compiled-differs",
    // The configuration names both files.
    level: Level::Deny,
    what: "a compiled shader whose members lie elsewhere than in its text",
    why: "The driver reads a buffer by the offsets and strides in the SPIR-V module. They differ from those \
          of the text where the module is older than it, or where its compiler was told to lay blocks out by \
          other rules (scalar, relaxed, Direct3D's). Uploads by the text then land in the wrong members.",
    example: "\
#version 450
// [[compiled]] with source = \"shaders/a.frag\", spirv = \"shaders/a.frag.spv\"
layout(std140, binding = 0) uniform Light {
    vec4 color;
    float range; // at 16; the module has it at 20
};
layout(location = 0) out vec4 pixel;
void main() { pixel = color * range; }
",
    fix: "Compile the text again, with the rules that it declares; or generate what is uploaded from the \
          module, with `landfall emit a.frag.spv`.",
    check: Check::Elsewhere,
};

/// The most members of a block that are named.
const MAX_NAMED: usize = 8;

/// A finding for each block of a text whose members lie elsewhere in its module. Blocks that the
/// module lacks, as unused ones may be, are left out.
pub fn findings(row: &CompiledShader, text: &ShaderLayout, module: &ShaderLayout) -> Vec<Finding> {
    let mut found = Vec::new();
    // The text is the old side, so that a change tells where the module has a member.
    for block in diff(Side::from_shader(text), Side::from_shader(module)) {
        let (Some(own), Some(_)) = (block.old, block.new) else { continue };
        // Only places are compared: compilers drop names, and write a `bool` as a `uint`.
        let is_place = |change: &&Change| {
            use Kind::{ArrayStride, MatrixLayout, MatrixStride, Moved};
            matches!(change.kind, Moved | ArrayStride | MatrixStride | MatrixLayout)
        };
        let changes: Vec<&Change> = block.changes.iter().filter(is_place).collect();
        let Some((first, more)) = changes.split_first() else { continue };
        let own = &text.blocks[own];
        let message = format!("in `{}`, {}", row.spirv, first.message);
        let place = Place::new(&text.files, own.span);
        let mut finding = Finding::at(LINT.code, &*own.name, place, message);
        finding.labels.push(Label { at: row.place.clone(), text: "compared here".to_string() });
        for change in more.iter().take(MAX_NAMED) {
            finding = finding.with_note(change.message.clone());
        }
        if more.len() > MAX_NAMED {
            finding = finding.with_note(format!("and {} more", more.len() - MAX_NAMED));
        }
        found.push(finding.with_help(format!(
            "compile `{}` again, or generate what is uploaded from the module: `landfall emit {}`",
            row.source, row.spirv
        )));
    }
    found
}

/// The finding that the two files cannot be compared.
pub fn not_compared(row: &CompiledShader, path: &str, why: &str) -> Finding {
    let message = format!("`{path}` cannot be compared: {why}");
    Finding::at(LINT.code, path, row.place.clone(), message)
        .with_help("`source` and `spirv` are files relative to the configuration")
}
