//! `naga-disagrees`: leaves that naga, so wgpu, would read from another byte.
//!
//! Reads what [`layout`](mod@landfall_layout::layout) noted on each leaf when it was asked
//! with `Options::naga`; says nothing where naga was not asked or refuses the text.

mod cause;

use super::definition::{Check, Lint, Subject};
use super::settings::Settings;
use super::show::full_listing;
use landfall_layout::finding::{Finding, Level, Place};
use landfall_layout::layout::{BlockLayout, Leaf, NagaPlace};
use landfall_layout::source::Language;

pub(super) const CODE: &str = "naga-disagrees";

pub(super) const LINT: Lint = Lint {
    code: CODE,
    // WGSL is written for WebGPU, and of its two implementations one reads wrong. GLSL is
    // reported only where somebody says that it goes through naga; for the target `webgpu` the
    // level is `deny`, because there the wrong byte is certain: see `Lint::level_under`.
    level: Level::Warn,
    what: "leaves that naga, and so wgpu, reads from another byte than the language says",
    why: "naga 30 takes some declarations and lays them out wrong, without a word: `@align` on a \
          member of a nested structure, arrays of arrays in GLSL, small structures in std140, \
          push constants, `bool`. The same upload is right in a browser and in OpenGL and wrong \
          in wgpu. Of WGSL it is always reported; of GLSL when `webgpu` is among the targets or \
          the lint is asked for by name, because most GLSL never meets naga. A failure for the \
          target `webgpu`, a warning otherwise.",
    example: "\
struct Inner { @align(16) value: u32 }
struct Outer { first: u32, inner: Inner } // inner at 16; naga reads 4
@group(0) @binding(0) var<storage> outer: Outer;
",
    fix: "spell the padding out, so that there is nothing left to get wrong: pad members instead \
          of `@align`, one dimension instead of two, `vec4` instead of small structures",
    check: Check::Shader(check),
};

/// Whether it has anything to say about texts of that language: asking naga takes time.
pub fn wanted(language: Language, settings: &Settings) -> bool {
    match language {
        Language::Wgsl => true,
        Language::Glsl => {
            settings.targets.contains(&super::settings::Target::WebGpu)
                || settings
                    .levels
                    .iter()
                    .any(|(code, level)| code == LINT.code && *level != Level::Allow)
        }
    }
}

fn check(subject: &Subject<'_>, settings: &Settings) -> Vec<Finding> {
    if !wanted(subject.shader.language, settings) {
        return Vec::new();
    }
    subject.shader.blocks.iter().filter_map(|block| of_block(subject, block)).collect()
}

fn of_block(subject: &Subject<'_>, block: &BlockLayout) -> Option<Finding> {
    let differing: Vec<(&Leaf, &NagaPlace)> =
        block.leaves.iter().filter_map(|leaf| Some((leaf, leaf.naga.as_ref()?))).collect();
    let (leaf, naga) = *differing.first()?;
    let files = &subject.shader.files;
    let cause = cause::of(block, leaf, naga);
    let more = match differing.len() - 1 {
        0 => String::new(),
        1 => ", and 1 more leaf".to_string(),
        n => format!(", and {n} more leaves"),
    };
    let message = format!(
        "naga, so wgpu, reads `{}` of block `{}` {}{more}",
        leaf.path,
        block.name,
        numbers(leaf, naga),
    );
    let mut finding = Finding::new(LINT.code, &*block.name, Place::of(files, leaf.span), message)
        .with_text(short(leaf, naga));
    finding.listing = full_listing(subject.shader, block);
    if let Some(span) = cause.span.filter(|span| *span != leaf.span) {
        finding = finding.with_related(Place::of(files, span), cause.word);
    }
    finding = finding.with_note(cause.text);
    for (leaf, naga) in differing.iter().skip(1).take(MOST_LEAVES) {
        finding = finding.with_note(format!("it reads `{}` {}", leaf.path, numbers(leaf, naga)));
    }
    if differing.len() - 1 > MOST_LEAVES {
        finding = finding.with_note(format!("and {} more", differing.len() - 1 - MOST_LEAVES));
    }
    Some(finding.with_help(cause.help))
}

/// Leaves spelled out after the first; the rest are counted.
const MOST_LEAVES: usize = 4;

/// `from byte 4 instead of 16`; where only the distance differs, that.
fn numbers(leaf: &Leaf, naga: &NagaPlace) -> String {
    let here = leaf.offset.unwrap_or(0);
    let strides = match naga.strides != leaf.strides {
        true => Some(format!(
            "with array stride {} instead of {}",
            spaced(&naga.strides),
            spaced(&leaf.strides)
        )),
        false => None,
    };
    match (naga.offset != here, strides) {
        (true, None) => format!("from byte {} instead of {here}", naga.offset),
        (true, Some(strides)) => {
            format!("from byte {} instead of {here}, {strides}", naga.offset)
        }
        (false, Some(strides)) => strides,
        (false, None) => "with other array dimensions".to_string(),
    }
}

fn short(leaf: &Leaf, naga: &NagaPlace) -> String {
    let here = leaf.offset.unwrap_or(0);
    if naga.offset != here {
        format!("at {here}, naga reads {}", naga.offset)
    } else {
        format!("stride {}, naga takes {}", spaced(&leaf.strides), spaced(&naga.strides))
    }
}

/// Strides outermost first: `48, 16`.
fn spaced(numbers: &[u64]) -> String {
    numbers.iter().map(u64::to_string).collect::<Vec<_>>().join(", ")
}
