//! `naga-disagrees`: leaves that naga, and so wgpu, reads from another byte.
//!
//! Reads the comparison that [`layout`](mod@landfall_layout::layout) records on each leaf with
//! `Options::naga`; reports nothing without it, or where naga rejects the text.

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
    // WGSL is written for WebGPU, and naga is one of its implementations. GLSL is reported only
    // where the settings say that it goes through naga; for the target `webgpu` the level is
    // `deny`, because there the wrong byte is certain: see `Lint::level_under`.
    level: Level::Warn,
    what: "members that naga, and so wgpu, reads from another byte than the language specifies",
    why: "naga 30 accepts some declarations and lays them out incorrectly, without a diagnostic: \
          `@align` on a member of a nested structure, arrays of arrays in GLSL, small structures \
          in std140, push constants, `bool`. The same upload is right in a browser and in OpenGL \
          and wrong in wgpu. Always reported for WGSL; for GLSL only when `webgpu` is among the \
          targets or the lint is enabled by name, because most GLSL never passes through naga. The \
          level is `deny` for the target `webgpu` and `warn` otherwise.",
    example: "\
struct Inner { @align(16) value: u32 }
struct Outer { first: u32, inner: Inner } // inner at 16; naga reads 4
@group(0) @binding(0) var<storage> outer: Outer;
",
    fix: "Write the padding out: pad members instead of `@align`, one dimension instead of two, \
          `vec4` instead of small structures.",
    check: Check::Naga(check),
};

/// Returns whether the lint applies to texts of that language, so that naga has to parse them.
pub fn applies_to(language: Language, settings: &Settings) -> bool {
    match language {
        Language::Wgsl => true,
        Language::SpirV => false,
        Language::Glsl => {
            settings.targets.contains(&super::settings::Target::WebGpu)
                || settings
                    .all_levels()
                    .any(|(code, level)| code == LINT.code && *level != Level::Allow)
        }
    }
}

fn check(subject: &Subject<'_>, settings: &Settings) -> Vec<Finding> {
    if !applies_to(subject.shader.language, settings) {
        return Vec::new();
    }
    subject.shader.blocks.iter().filter_map(|block| of_block(subject, block)).collect()
}

fn of_block(subject: &Subject<'_>, block: &BlockLayout) -> Option<Finding> {
    let differing: Vec<(&Leaf, &NagaPlace)> =
        block.leaves.iter().filter_map(|leaf| Some((leaf, leaf.naga.as_ref()?))).collect();
    // What moves a leaf moves those behind it, so the first one tells the cause.
    let (leaf, naga) = *differing.first()?;
    let files = &subject.shader.files;
    let cause = cause::find_cause(block, leaf, naga);
    let more = match differing.len() - 1 {
        0 => String::new(),
        1 => ", and 1 more member".to_string(),
        n => format!(", and {n} more members"),
    };
    let message = format!(
        "naga, so wgpu, reads `{}` of block `{}` {}{more}",
        leaf.path,
        block.name,
        numbers(leaf, naga),
    );
    let mut finding = Finding::at(LINT.code, &*block.name, Place::new(files, leaf.span), message)
        .with_text(short(leaf, naga));
    finding.listing = full_listing(subject.shader, block);
    if let Some(span) = cause.span.filter(|span| *span != leaf.span) {
        finding = finding.with_label(Place::new(files, span), cause.word);
    }
    finding = finding.with_note(cause.text);
    for (leaf, naga) in differing.iter().skip(1).take(MAX_LEAVES) {
        finding = finding.with_note(format!("it reads `{}` {}", leaf.path, numbers(leaf, naga)));
    }
    if differing.len() - 1 > MAX_LEAVES {
        finding = finding.with_note(format!("and {} more", differing.len() - 1 - MAX_LEAVES));
    }
    Some(finding.with_help(cause.help))
}

/// The number of leaves listed after the first; the rest are counted.
const MAX_LEAVES: usize = 4;

/// Returns `from byte 4 instead of 16`, or the strides where only they differ.
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
