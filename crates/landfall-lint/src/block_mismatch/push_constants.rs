//! Push constants and immediates of the stages of one program: one range of bytes, which every stage
//! declares for itself.

use std::collections::BTreeMap;

use super::program::{base_name, program};
use super::{Copy, LINT, MAX_NAMED};
use crate::definition::Subject;
use crate::show::{counted, listing, place};
use landfall_layout::ShaderLayout;
use landfall_layout::finding::Finding;
use landfall_layout::interface::ResourceKind;
use landfall_layout::layout::{BlockLayout, Leaf};
use landfall_layout::shape::{AddressSpace, ArrayLen, Type};
use landfall_layout::source::{Language, Stage};
use landfall_layout::syntax::interface;

/// The most elements of a block that are compared: ranges of push constants are short.
const MAX_ELEMENTS: usize = 4096;

/// Returns the name of the program that shares one range of push constants. WGSL files whose names
/// say a stage are stages of one.
pub(super) fn range(shader: &ShaderLayout) -> Option<String> {
    if shader.language == Language::Glsl {
        return Some(format!("{:?}", program(shader)?));
    }
    let (directory, name) = base_name(&shader.path);
    let file = shader.path.replace('\\', "/");
    let file = file.rsplit('/').next().unwrap_or("");
    // The base name lacks the stage that the file's name has.
    let of_a_stage = file.strip_suffix(".wgsl").is_some_and(|stem| stem != name);
    of_a_stage.then(|| format!("{directory}/{name}.wgsl"))
}

pub(super) fn check(subjects: &[Subject<'_>]) -> Vec<Finding> {
    let mut ranges: BTreeMap<String, Vec<Copy<'_>>> = BTreeMap::new();
    let mut found = Vec::new();
    for subject in subjects {
        let blocks: Vec<Copy<'_>> =
            pushed(subject.shader).map(|block| Copy { subject, block }).collect();
        // The entry points of one module may be stages of one pipeline.
        if blocks.len() > 1 && subject.shader.language == Language::Wgsl {
            found.extend(between_entry_points(subject, &blocks));
        }
        if let (Some(range), false) = (range(subject.shader), blocks.is_empty()) {
            ranges.entry(range).or_default().extend(blocks);
        }
    }
    for copies in ranges.values() {
        // Each copy is compared with those of other files before it, up to the first that differs.
        for (at, copy) in copies.iter().enumerate() {
            let earlier = copies[..at].iter();
            let mut others = earlier.filter(|other| !std::ptr::eq(other.subject, copy.subject));
            found.extend(others.find_map(|other| compare(copy, other)));
        }
    }
    found
}

fn pushed(shader: &ShaderLayout) -> impl Iterator<Item = &BlockLayout> {
    let blocks = shader.blocks.iter();
    blocks.filter(|block| block.space == AddressSpace::PushConstant && block.size.is_some())
}

/// Compares the immediates of a module's vertex and fragment stages: a variable that no fragment
/// stage uses with one that no vertex stage uses.
fn between_entry_points(subject: &Subject<'_>, blocks: &[Copy<'_>]) -> Vec<Finding> {
    let interface = interface(subject.source, &subject.options.read);
    let uses = |block: &BlockLayout, stage: Stage| {
        interface.entry_points.iter().filter(|entry| entry.stage == Some(stage)).any(|entry| {
            entry.uses.iter().any(|&at| {
                let resource = &interface.resources[at];
                let name = block.instance.as_ref().unwrap_or(&block.name);
                matches!(resource.kind, ResourceKind::Buffer(AddressSpace::PushConstant, _))
                    && resource.name == *name
            })
        })
    };
    let alone =
        |block: &BlockLayout, here: Stage, there: Stage| uses(block, here) && !uses(block, there);
    let mut found = Vec::new();
    for one in blocks.iter().filter(|copy| alone(copy.block, Stage::Vertex, Stage::Fragment)) {
        let other = blocks.iter().filter(|copy| alone(copy.block, Stage::Fragment, Stage::Vertex));
        found.extend(other.filter_map(|other| compare(other, one)));
    }
    found
}

struct LeafElement<'a> {
    path: String,
    start: u64,
    end: u64,
    leaf: &'a Leaf,
}

/// Returns the elements of a block in the order of their bytes.
fn elements(block: &BlockLayout) -> Vec<LeafElement<'_>> {
    let mut all = Vec::new();
    for leaf in &block.leaves {
        let (Some(offset), Some(size)) = (leaf.offset, leaf.size) else { continue };
        let mut starts = vec![(leaf.path.clone(), offset)];
        for (len, stride) in leaf.dims.iter().zip(&leaf.strides) {
            let ArrayLen::Fixed(length) = len else { continue };
            // The limit is of the elements over all dimensions.
            let count = (MAX_ELEMENTS / starts.len().max(1)).min(*length as usize) as u64;
            let each = |(path, start): &(String, u64)| -> Vec<(String, u64)> {
                let indexed = |at: u64| path.replacen("[]", &format!("[{at}]"), 1);
                (0..count).map(|at| (indexed(at), start + at * stride)).collect()
            };
            starts = starts.iter().flat_map(each).collect();
        }
        let elements = starts.into_iter();
        all.extend(elements.map(|(path, start)| LeafElement {
            path,
            start,
            end: start + size,
            leaf,
        }));
        if all.len() > MAX_ELEMENTS {
            break;
        }
    }
    all.sort_by_key(|element| element.start);
    all
}

/// Returns a finding if two stages read a byte as parts of different types.
fn compare(here: &Copy<'_>, there: &Copy<'_>) -> Option<Finding> {
    let (ours, theirs) = (elements(here.block), elements(there.block));
    let mut differing: Vec<(&LeafElement<'_>, &LeafElement<'_>)> = Vec::new();
    // Both lists are in the order of their bytes, so that one pass finds every overlap.
    let mut first = 0;
    for element in &ours {
        while theirs.get(first).is_some_and(|other| other.end <= element.start) {
            first += 1;
        }
        let mut overlapping = theirs[first..].iter().take_while(|other| other.start < element.end);
        let other = overlapping.find(|other| other.end > element.start && !same(element, other));
        differing.extend(other.map(|other| (element, other)));
    }
    let (element, other) = differing.first()?;
    let (ours, theirs) = (here.subject.shader.language, there.subject.shader.language);
    let word = match ours {
        Language::Glsl | Language::SpirV => "push constants",
        Language::Wgsl => "immediate data",
    };
    let shown = |element: &LeafElement<'_>, language| {
        format!("`{}` (`{}` at {})", element.path, element.leaf.ty.spelled(language), element.start)
    };
    let elsewhere = match std::ptr::eq(here.subject, there.subject) {
        true => format!("`{}`", there.block.name),
        false => there.subject.source.path.clone(),
    };
    let message = format!(
        "{word} `{}` read bytes as {} that {elsewhere} reads as {}",
        here.block.name,
        shown(element, ours),
        shown(other, theirs),
    );
    let at = place(here.subject, element.leaf.span);
    let mut finding = Finding::at(LINT.code, here.block.name.as_ref(), at, message)
        .with_label(place(there.subject, other.leaf.span), "the same bytes")
        .with_note(
            "the stages of a pipeline share one range of bytes, whatever their blocks' names",
        );
    for (element, other) in differing.iter().skip(1).take(MAX_NAMED) {
        finding =
            finding.with_note(format!("{} and {}", shown(element, ours), shown(other, theirs)));
    }
    if differing.len() > 1 + MAX_NAMED {
        finding = finding.with_note(counted(differing.len() - 1 - MAX_NAMED, "more overlap"));
    }
    finding.listing = listing(here.subject.shader, here.block);
    Some(finding.with_help(match ours {
        Language::Glsl | Language::SpirV => {
            "declare one block in a file that both stages include, or place the members of one stage \
             behind the other's with `layout(offset = N)`"
        }
        Language::Wgsl => "declare one structure with the members of both stages",
    }))
}

/// Whether two elements are the same bytes of the same type.
fn same(a: &LeafElement<'_>, b: &LeafElement<'_>) -> bool {
    let component = |ty: &Type| match ty {
        // An atomic has the bytes of its component.
        Type::Atomic(scalar) => Type::Scalar(*scalar),
        other => other.clone(),
    };
    a.start == b.start
        && component(&a.leaf.ty) == component(&b.leaf.ty)
        && a.leaf.matrix_stride == b.leaf.matrix_stride
        && a.leaf.row_major == b.leaf.row_major
}
