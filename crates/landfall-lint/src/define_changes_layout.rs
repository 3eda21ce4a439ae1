//! `define-changes-layout`: a block whose layout changes with macros.
//!
//! Looks at the variants of a shader: its layouts under each permutation in the settings that names a
//! macro occurring in its files.

use rustc_hash::{FxHashMap, FxHashSet};

use super::definition::{Check, Lint, Subject};
use super::settings::Settings;
use super::show::full_listing;
use landfall_layout::finding::{Finding, Level, Place};
pub use landfall_layout::layout::measure::fixed;
use landfall_layout::layout::{BlockLayout, Leaf};
use landfall_layout::source::Language;
use landfall_layout::{Severity, ShaderLayout};

pub(super) const LINT: Lint = Lint {
    code: "define-changes-layout",
    // Silent until permutations are configured.
    level: Level::Warn,
    what: "a block whose layout changes under the macros of a permutation",
    why: "One shader is compiled with several sets of macros, but one buffer is filled for all of \
          them: if an `#ifdef` adds a member or changes an array's length, every variant but one \
          reads from the wrong byte. A block that only one variant declares is not reported: it \
          has its own buffer.",
    example: "\
#version 330 core
layout(std140) uniform Light {
    vec3 color;
#ifdef SHADOWS
    mat4 shadow_matrix;
#endif
    float intensity; // 12, or 80 with SHADOWS
};
void main() {}
",
    fix: "Declare the member in every variant, or move the members that only some variants declare \
          to the end or into a block of their own.",
    check: Check::Shader(check),
};

fn check(subject: &Subject<'_>, settings: &Settings) -> Vec<Finding> {
    // WGSL has no preprocessor.
    if subject.shader.language == Language::Wgsl {
        return Vec::new();
    }
    let mut findings: Vec<Finding> = Vec::new();
    let laid_out;
    let variants = match subject.shader.variants.as_slice() {
        [] => {
            let (source, sets) = (subject.source, &settings.permutations);
            laid_out = landfall_layout::variants(source, subject.options, subject.shader, sets);
            &laid_out
        }
        known => known,
    };
    for variant in variants {
        let Some(other) = &variant.layout else { continue };
        let name = variant.name();
        if other.has_errors() {
            findings.push(refused(subject, other, &name));
            continue;
        }
        // Loose uniforms are set one by one: they have no layout.
        for block in subject.shader.blocks.iter().filter(|block| block.size.is_some()) {
            let copy = other.blocks.iter().find(|o| o.name == block.name && o.space == block.space);
            let known = findings.iter_mut().find(|finding| finding.about == *block.name);
            let Some(change) = copy.and_then(|copy| change(subject, block, copy, other)) else {
                continue;
            };
            match known {
                Some(known) => known.notes.push(format!("under `{name}` too")),
                None => findings.push(changed(subject, block, &change, &name)),
            }
        }
    }
    findings
}

/// The first difference of two layouts of one block.
struct Change {
    /// The difference, with both numbers.
    text: String,
    /// The place of the member that differs; `None` if only the size does.
    place: Option<Place>,
    /// The first member that only the other layout has, if another one is the first to differ.
    added: Option<(Place, String)>,
    /// The listing of the other layout.
    listing: Option<String>,
}

fn change(
    subject: &Subject<'_>,
    block: &BlockLayout,
    other: &BlockLayout,
    shader: &ShaderLayout,
) -> Option<Change> {
    let (text, place) = first_difference(subject, block, other, shader)?;
    let known: FxHashSet<&str> = block.leaves.iter().map(|leaf| &*leaf.path).collect();
    let added = other.leaves.iter().find(|leaf| !known.contains(&*leaf.path));
    let added = added.map(|leaf| (Place::of(&shader.files, leaf.span), leaf.path.clone()));
    let added = added.filter(|(at, _)| Some(at) != place.as_ref());
    Some(Change { text, place, added, listing: full_listing(shader, other) })
}

fn first_difference(
    subject: &Subject<'_>,
    block: &BlockLayout,
    other: &BlockLayout,
    shader: &ShaderLayout,
) -> Option<(String, Option<Place>)> {
    let language = subject.shader.language;
    let at = |leaf: &Leaf| Some(Place::of(&subject.shader.files, leaf.span));
    let by_path = |block: &'_ BlockLayout| -> FxHashMap<String, usize> {
        let paths = block.leaves.iter().enumerate();
        paths.map(|(index, leaf)| (leaf.path.clone(), index)).collect()
    };
    let there = by_path(other);
    for leaf in &block.leaves {
        let Some(there) = there.get(&leaf.path).map(|&index| &other.leaves[index]) else {
            return Some((format!("`{}` is gone", leaf.path), at(leaf)));
        };
        if let Some(text) = differs(leaf, there, language) {
            return Some((format!("`{}` {text}", leaf.path), at(leaf)));
        }
    }
    let here = by_path(block);
    if let Some(new) = other.leaves.iter().find(|new| !here.contains_key(&new.path)) {
        let offset = new.offset.map(|offset| format!(" at {offset}")).unwrap_or_default();
        let place = Place::of(&shader.files, new.span);
        return Some((format!("`{}` is added{offset}", new.path), Some(place)));
    }
    let (old, new) = (block.size?, other.size?);
    (old != new).then(|| (format!("it is {new} bytes instead of {old}"), None))
}

fn differs(leaf: &Leaf, there: &Leaf, language: Language) -> Option<String> {
    if let (Some(here), Some(there)) = (leaf.offset, there.offset) {
        if here != there {
            return Some(format!("is at {there} instead of {here}"));
        }
    }
    if leaf.ty != there.ty {
        let (here, there) = (leaf.ty.spelled(language), there.ty.spelled(language));
        return Some(format!("is a `{there}` instead of a `{here}`"));
    }
    if leaf.strides != there.strides {
        let pair = leaf.strides.iter().zip(&there.strides).find(|(a, b)| a != b);
        return Some(match pair {
            Some((here, there)) => format!("has stride {there} instead of {here}"),
            None => "has other array dimensions".to_string(),
        });
    }
    if leaf.dims != there.dims {
        let lengths = leaf.dims.iter().zip(&there.dims).find(|(a, b)| a != b)?;
        let count = |len| fixed(len).map_or("any number of".to_string(), |n| n.to_string());
        return Some(format!("has {} elements instead of {}", count(lengths.1), count(lengths.0)));
    }
    if leaf.row_major != there.row_major {
        let name = if there.row_major { "rows" } else { "columns" };
        return Some(format!("is stored by {name}"));
    }
    (leaf.matrix_stride != there.matrix_stride).then(|| "has another matrix stride".to_string())
}

fn changed(subject: &Subject<'_>, block: &BlockLayout, change: &Change, name: &str) -> Finding {
    let files = &subject.shader.files;
    let message =
        format!("the layout of block `{}` changes under `{name}`: {}", block.name, change.text);
    let place = change.place.clone().unwrap_or_else(|| Place::of(files, block.span));
    let mut finding = Finding::of(LINT.code, &*block.name, place, message)
        .with_text(change.text.clone())
        .with_note(sizes(block, name))
        .with_help(
            "declare the same members in every variant, or move those that only some have into \
             a block of their own",
        );
    finding.listing = change.listing.clone();
    if let Some((place, path)) = &change.added {
        finding =
            finding.with_label(place.clone(), format!("`{path}` is there only with `{name}`"));
    }
    if change.place.is_some() {
        finding = finding.with_label(Place::of(files, block.span), "the block");
    }
    finding
}

fn sizes(block: &BlockLayout, name: &str) -> String {
    match block.size {
        Some(size) => format!("without `{name}` the block is {size} bytes; the listing is with it"),
        None => format!("the listing is with `{name}`"),
    }
}

/// Returns the finding of a permutation under which the shader has no layout.
fn refused(subject: &Subject<'_>, other: &ShaderLayout, name: &str) -> Finding {
    let fault = other.diagnostics.iter().find(|found| found.severity == Severity::Error);
    let place = match fault.and_then(|fault| fault.labels.first()) {
        Some(label) => Place::of(&other.files, label.at),
        None => Place::file(&subject.shader.path),
    };
    let why = fault.map_or("", |fault| fault.message.as_str());
    let message = format!("under `{name}` the shader cannot be laid out: {why}");
    let finding = Finding::of(LINT.code, format!("under {name}"), place, message);
    match fault.and_then(|fault| fault.help.clone()) {
        Some(help) => finding.with_help(help),
        None => finding,
    }
}
