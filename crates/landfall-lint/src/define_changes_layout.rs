//! `define-changes-layout`: a block whose layout changes with macros.
//!
//! Looks at the variants of a shader: its layouts under each permutation in the settings that names a
//! macro occurring in its files.

use rustc_hash::{FxHashMap, FxHashSet};

use super::definition::{Check, Lint, Subject};
use super::settings::Settings;
use super::show::full_listing;
use super::walk::dimensions;
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
          reads from the wrong byte. Variants are compared with the first that declares the block: \
          the text without their macros, else the first permutation. A block that only one variant \
          declares is not reported: it has its own buffer.",
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
    let mut findings: Vec<Finding> = Vec::new();
    let laid_out;
    // Variants that were laid out with the shader are taken as they are.
    let variants = match subject.shader.variants.as_slice() {
        [] => {
            let (source, sets) = (subject.source, &settings.permutations);
            laid_out = landfall_layout::variants(source, subject.options, subject.shader, sets);
            &laid_out
        }
        known => known,
    };
    let mut others: Vec<(String, &ShaderLayout)> = Vec::new();
    for variant in variants {
        let Some(other) = variant.layout.as_deref() else { continue };
        match other.has_errors() {
            true => findings.push(refused(subject, other, &variant.name())),
            false => others.push((variant.name(), other)),
        }
    }
    let own = settings.own_set(subject.source);
    let own = (!own.is_empty()).then(|| landfall_layout::variant_name(own));
    // A block is compared with the first variant that declares it: the one without macros, if any.
    for (at, (name, other)) in others.iter().enumerate() {
        // Loose uniforms are set one by one: they have no layout.
        for copy in other.blocks.iter().filter(|block| block.size.is_some()) {
            let variants = others[..at].iter().map(|(name, other)| (Some(name.as_str()), *other));
            let first = std::iter::once((own.as_deref(), subject.shader)).chain(variants).find_map(
                |(name, shader)| Some(Variant { name, shader, block: twin(shader, copy)? }),
            );
            let Some(first) = first else { continue };
            let Some(change) = change(&first, copy, other) else { continue };
            // One finding for a block: what other variants change is told in its notes.
            let about = |finding: &&mut Finding| finding.about == *copy.name;
            match findings.iter_mut().find(about) {
                Some(known) if known.message.ends_with(&change.text) => {
                    known.notes.push(format!("under `{name}` too"));
                }
                Some(known) => known.notes.push(format!("under `{name}`: {}", change.text)),
                None => findings.push(changed(&first, &change, name)),
            }
        }
    }
    findings
}

/// The variant of a block that others are compared with.
struct Variant<'s> {
    /// Its macros; `None` for the text without any.
    name: Option<&'s str>,
    shader: &'s ShaderLayout,
    block: &'s BlockLayout,
}

/// Returns the block of that name in another variant.
fn twin<'s>(shader: &'s ShaderLayout, block: &BlockLayout) -> Option<&'s BlockLayout> {
    let same = |other: &&BlockLayout| other.name == block.name && other.space == block.space;
    shader.blocks.iter().filter(|other| other.size.is_some()).find(same)
}

/// The first difference of two layouts of one block.
struct LayoutChange {
    /// The difference, with both numbers.
    text: String,
    /// The place of the member that differs; `None` if only the size does.
    place: Option<Place>,
    /// The first member that only the other layout has, if another one is the first to differ.
    added: Option<(Place, String)>,
    /// The listing of the other layout.
    listing: Option<String>,
}

fn change(first: &Variant<'_>, other: &BlockLayout, shader: &ShaderLayout) -> Option<LayoutChange> {
    let block = first.block;
    let (text, place) = first_difference(first, other, shader)?;
    let known: FxHashSet<&str> = block.leaves.iter().map(|leaf| &*leaf.path).collect();
    // A new member moves others, so the first that differs is often not the new one.
    let added = other.leaves.iter().find(|leaf| !known.contains(&*leaf.path));
    let added = added.map(|leaf| (Place::new(&shader.files, leaf.span), leaf.path.clone()));
    let added = added.filter(|(at, _)| Some(at) != place.as_ref());
    Some(LayoutChange { text, place, added, listing: full_listing(shader, other) })
}

fn first_difference(
    first: &Variant<'_>,
    other: &BlockLayout,
    shader: &ShaderLayout,
) -> Option<(String, Option<Place>)> {
    let Variant { block, shader: own, .. } = first;
    let at = |span| Some(Place::new(&own.files, span));
    let by_path = |block: &'_ BlockLayout| -> FxHashMap<String, usize> {
        let paths = block.leaves.iter().enumerate();
        paths.map(|(index, leaf)| (leaf.path.clone(), index)).collect()
    };
    // By path, as each may have leaves that the other lacks.
    let there = by_path(other);
    for leaf in &block.leaves {
        let Some(there) = there.get(&leaf.path).map(|&index| &other.leaves[index]) else {
            return Some((format!("`{}` is gone", leaf.path), at(leaf.span)));
        };
        if let Some(difference) = differs(leaf, there, own.language) {
            let arrays = dimensions(&block.members, &leaf.path);
            let outer =
                leaf.path.rsplit_once('.').map_or(0, |(outer, _)| outer.matches("[]").count());
            let array = difference.dimension.filter(|dim| *dim < outer);
            // The array around it is what changed, not what is in its elements.
            return Some(match array.and_then(|dim| Some((arrays.get(dim)?, dim))) {
                Some((span, dim)) => {
                    let end = leaf.path.match_indices("[]").nth(dim).map(|(end, _)| end);
                    let path = leaf.path[..end.unwrap_or(leaf.path.len())].trim_end_matches("[]");
                    (format!("`{path}` {}", difference.text), at(*span))
                }
                None => (format!("`{}` {}", leaf.path, difference.text), at(leaf.span)),
            });
        }
    }
    // All own leaves agree: what is left are new ones, and the size.
    let here = by_path(block);
    if let Some(new) = other.leaves.iter().find(|new| !here.contains_key(&new.path)) {
        let offset = new.offset.map(|offset| format!(" at {offset}")).unwrap_or_default();
        let place = Place::new(&shader.files, new.span);
        return Some((format!("`{}` is added{offset}", new.path), Some(place)));
    }
    let (old, new) = (block.size?, other.size?);
    (old != new).then(|| (format!("it is {new} bytes instead of {old}"), None))
}

/// How a leaf differs, and the dimension that does.
struct LeafDifference {
    text: String,
    dimension: Option<usize>,
}

fn differs(leaf: &Leaf, there: &Leaf, language: Language) -> Option<LeafDifference> {
    let of = |text: String, dimension| Some(LeafDifference { text, dimension });
    if let (Some(here), Some(there)) = (leaf.offset, there.offset) {
        if here != there {
            return of(format!("is at {there} instead of {here}"), None);
        }
    }
    if leaf.ty != there.ty {
        let (here, there) = (leaf.ty.spelled(language), there.ty.spelled(language));
        return of(format!("is a `{there}` instead of a `{here}`"), None);
    }
    if leaf.strides != there.strides {
        // An outer stride grows with an inner one.
        let mut strides = leaf.strides.iter().zip(&there.strides).enumerate();
        return match strides.rfind(|(_, (a, b))| a != b) {
            Some((dim, (here, there))) => {
                of(format!("has stride {there} instead of {here}"), Some(dim))
            }
            None => of("has other array dimensions".to_string(), None),
        };
    }
    if leaf.dims != there.dims {
        let lengths = leaf.dims.iter().zip(&there.dims);
        let Some((dim, (here, there))) = lengths.enumerate().find(|(_, (a, b))| a != b) else {
            return of("has other array dimensions".to_string(), None);
        };
        let count = |len| fixed(len).map_or("any number of".to_string(), |n| n.to_string());
        return of(format!("has {} elements instead of {}", count(there), count(here)), Some(dim));
    }
    if leaf.row_major != there.row_major {
        let name = if there.row_major { "rows" } else { "columns" };
        return of(format!("is stored by {name}"), None);
    }
    match leaf.matrix_stride != there.matrix_stride {
        true => of("has another matrix stride".to_string(), None),
        false => None,
    }
}

fn changed(first: &Variant<'_>, change: &LayoutChange, name: &str) -> Finding {
    let (files, block) = (&first.shader.files, first.block);
    let message =
        format!("the layout of block `{}` changes under `{name}`: {}", block.name, change.text);
    let place = change.place.clone().unwrap_or_else(|| Place::new(files, block.span));
    let mut finding = Finding::at(LINT.code, &*block.name, place, message)
        .with_text(change.text.clone())
        .with_note(sizes(first, name))
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
        finding = finding.with_label(Place::new(files, block.span), "the block");
    }
    finding
}

fn sizes(first: &Variant<'_>, name: &str) -> String {
    let under = match first.name {
        Some(first) => format!("under `{first}`"),
        None => format!("without `{name}`"),
    };
    match (first.block.size, first.name) {
        (Some(size), None) => format!("{under} the block is {size} bytes; the listing is with it"),
        (Some(size), Some(_)) => {
            format!("{under} the block is {size} bytes; the listing is with `{name}`")
        }
        (None, _) => format!("the listing is with `{name}`"),
    }
}

/// Returns the finding of a permutation under which the shader has no layout.
fn refused(subject: &Subject<'_>, other: &ShaderLayout, name: &str) -> Finding {
    let fault = other.diagnostics.iter().find(|found| found.severity == Severity::Error);
    let place = match fault.and_then(|fault| fault.labels.first()) {
        Some(label) => Place::new(&other.files, label.at),
        None => Place::file(&subject.shader.path),
    };
    let why = fault.map_or("", |fault| fault.message.as_str());
    let message = format!("under `{name}` the shader cannot be laid out: {why}");
    let finding = Finding::at(LINT.code, format!("under {name}"), place, message);
    Finding { help: fault.and_then(|fault| fault.help.clone()), ..finding }
}
