//! `unreached-block`: a block that no configured variant has.

use super::definition::{Check, Lint, Subject};
use super::settings::Settings;
use landfall_layout::diagnostic::Code;
use landfall_layout::finding::{Finding, Level};
use landfall_layout::{Diagnostic, ShaderLayout, UnreachedBlock, unreached_blocks};

pub(super) const LINT: Lint = Lint {
    code: "unreached-block",
    // Silent until permutations are configured.
    level: Level::Warn,
    what: "a block that the shader has only under macros that no permutation defines",
    why: "Locks and lints see the blocks that `define` and `permutations` give. The block of a variant \
          that is not among them is in no lock: whoever moves one of its members hears nothing. \
          Blocks under `#if 0`, and those that depend only on the language's own macros or on the \
          text's, are not reported.",
    example: "\
#version 330 core
#ifdef FOG
layout(std140) uniform Fog { // FOG is in no permutation
    vec3 color;
    float density;
};
#endif
void main() {}
",
    fix: "Add the set of macros with which the program compiles the shader to `permutations` in \
          landfall.toml, or remove the block.",
    check: Check::Shader(check),
};

fn check(subject: &Subject<'_>, settings: &Settings) -> Vec<Finding> {
    if settings.permutations.is_empty() {
        return Vec::new();
    }
    let laid_out;
    let shader = match subject.shader.variants.as_slice() {
        [] => {
            let (source, options) = (subject.source, subject.options);
            let shader = subject.shader.clone();
            laid_out = shader.with_variants(source, options, &settings.permutations);
            &laid_out
        }
        _ => subject.shader,
    };
    findings(shader)
}

fn findings(shader: &ShaderLayout) -> Vec<Finding> {
    let found = unreached_blocks(shader).into_iter().map(|block| Finding {
        about: block.name.to_string(),
        ..diagnostic(&block).located(block.files)
    });
    found.collect()
}

/// Returns the warning about a block.
pub fn diagnostic(block: &UnreachedBlock<'_>) -> Diagnostic {
    let (name, macros) = (block.name, block.macros.join("`, `"));
    let message = format!("no variant has block `{name}`: no lock guards it");
    let many = if block.macros.len() > 1 { "macros" } else { "macro" };
    Diagnostic::warning(Code::UnreachedBlock, block.span, message)
        .with_note(format!("it depends on the {many} `{macros}`"))
        .with_help("add a set of macros that gives it to `permutations` in landfall.toml")
}
