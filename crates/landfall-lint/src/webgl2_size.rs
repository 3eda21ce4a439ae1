//! `webgl2-size`: uniform blocks whose size is not a multiple of 16, as WebGL 2 requires.

use super::definition::{Check, Lint, Subject};
use super::settings::Settings;
use super::settings::Target;
use super::show::{bytes, is_called, listing, place};
use landfall_layout::finding::{Finding, Level};
use landfall_layout::layout::BlockLayout;
use landfall_layout::shape::{AddressSpace, Rules};
use landfall_layout::text::glob;

pub(super) const LINT: Lint = Lint {
    code: "webgl2-size",
    level: Level::Warn,
    what: "a uniform block whose members end off a multiple of 16 bytes, while `webgl2` is a \
           target",
    why: "WebGL 2 requires a buffer as long as std140 makes the block, rounded up to 16 bytes. A \
          buffer made for the members alone, such as the `sizeof` of a host structure, is too \
          small: browsers refuse the draw, and wgpu refuses the WGSL binding on WebGL. Only \
          reported with the target `webgl2`, because elsewhere a WGSL block of 12 bytes is fine, \
          and only as a warning, because the buffer may be large enough; a table in the \
          configuration with a sufficient size silences it. Said once a file, at the first such \
          block; the others are named with it.",
    example: "#version 300 es\n\
              // Checked with `--target webgl2`.\n\
              precision highp float;\n\
              layout(std140) uniform Fog { vec4 color; float start; float end; } u_fog;\n\
              out vec4 shade;\n\
              void main() { shade = u_fog.color * u_fog.end; }\n",
    fix: "Add members that fill the block up, or make the buffer as large as the layout and record \
          its size in a table of the configuration.",
    check: Check::Shader(check),
};

fn check(subject: &Subject<'_>, settings: &Settings) -> Vec<Finding> {
    if !settings.targets.contains(&Target::WebGl2) {
        return Vec::new();
    }
    let blocks = subject.shader.blocks.iter();
    blocks
        .filter(|block| block.space == AddressSpace::Uniform)
        .filter(|block| !block.gathered)
        .filter(|block| !is_made_large_enough(subject, block, settings))
        .filter_map(|block| short(subject, block))
        .fold(Vec::new(), once_a_file)
}

/// Adds a finding; a second one in the same file becomes a label of the first.
fn once_a_file(mut found: Vec<Finding>, next: Finding) -> Vec<Finding> {
    match found.iter().position(|known| known.place().path == next.place().path) {
        None => found.push(next),
        Some(at) => {
            let (label, text) = (next.place().clone(), format!("{} too", next.message));
            let known = found.swap_remove(at);
            found.push(known.with_label(label, text));
        }
    }
    found
}

fn short(subject: &Subject<'_>, block: &BlockLayout) -> Option<Finding> {
    // std140 rounds the size itself up; the size of a host structure is the end of its members.
    let is_std140 = block.rules == Rules::Std140;
    let end = if is_std140 { block.data_size? } else { block.size? };
    let whole = end.next_multiple_of(16);
    if end == whole {
        return None;
    }
    let missing = whole - end;
    let message = match is_std140 {
        true => format!(
            "the members of block `{}` end at byte {end}, but WebGL 2 requires a buffer of {}",
            block.name,
            bytes(whole)
        ),
        false => format!(
            "block `{}` is {}, but WebGL 2 requires a multiple of 16: {}",
            block.name,
            bytes(end),
            bytes(whole)
        ),
    };
    let at = place(subject, block.span);
    let mut finding = Finding::at(LINT.code, block.name.as_ref(), at, message)
        .with_text(format!("{} short", bytes(missing)))
        .with_help(format!(
            "make the buffer {}, or end the block with {} of padding",
            bytes(whole),
            bytes(missing)
        ));
    finding.listing = listing(subject.shader, block);
    Some(finding)
}

fn is_made_large_enough(subject: &Subject<'_>, block: &BlockLayout, settings: &Settings) -> bool {
    let whole = block.size.map(|size| size.next_multiple_of(16));
    settings.tables.iter().any(|table| {
        is_called(block, &table.block)
            && glob::matches(&table.file, &subject.source.path)
            && table.size.as_ref().map(|size| size.bytes) >= whole
    })
}
