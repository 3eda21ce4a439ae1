//! `block-mismatch`: copies of one block that differ between stages or files of one run.

mod compare;
mod mirrors;
mod program;
mod push_constants;

use std::collections::BTreeMap;

use super::definition::{Check, Lint, Subject};
use super::settings::Settings;
use super::show::{counted, listing, may_be_vulkan, place};
use compare::{CopyDifference, View, alike, collide, differences, is_head, shared, view};
use landfall_layout::ShaderLayout;
use landfall_layout::finding::{Finding, Level};
use landfall_layout::layout::BlockLayout;
use landfall_layout::shape::AddressSpace;
use landfall_layout::source::Language;
use program::{Program, base_name, program};

pub(super) const LINT: Lint = Lint {
    code: "block-mismatch",
    level: Level::Deny,
    what: "a block declared differently in two stages or files",
    why: "Both declarations read one buffer, so that one of them reads other members' bytes, or \
          the program does not link. Two declarations count as copies of one block in three cases. \
          Stages of one program (same directory, same file name except for the stage, also \
           `sky.vert.wgsl` and `skyFrag.glsl`): blocks of one name, uniform blocks of one group \
           and binding that read a byte differently, and push constants (WGSL: immediate data) that \
           do, whatever their names: stages share one range. \
          Files that belong together (same directory and base name, or both include one file that \
          declares a block, or one includes the other): blocks of one name, slot and layout rules \
          that share at least three members and two thirds of all members, by name and type, or \
          half of them if both declare that slot; with fewer in common they are two blocks that \
          happen to be called `Params`. Mirror groups of \
          the configuration: the blocks they name, in any file. A copy that declares only the \
          first members of another is accepted between programs, and in Vulkan, but does not link \
          in OpenGL. Blocks of one name in other files are not compared, not even in one \
          directory: collections of samples are full of them.",
    example: "#version 330 core\n\
              // The vertex shader next to it declares `color` before `position`.\n\
              layout(std140) uniform Light { vec3 position; vec3 color; } u_light;\n\
              out vec4 shade;\n\
              void main() { shade = vec4(u_light.color, 1.0); }\n",
    fix: "Declare the block once, in a file that every stage includes, or copy the declaration \
          that the uploading code was written for. If two blocks only share a name, change one's \
          name or binding.",
    check: Check::Tree(check),
};

/// The number of differences listed; the rest are counted.
const MAX_NAMED: usize = 4;

/// The number of further copies listed; the rest are counted.
const MAX_COPIES: usize = 3;

/// One declaration of a block.
#[derive(Clone, Copy)]
struct Copy<'a> {
    subject: &'a Subject<'a>,
    block: &'a BlockLayout,
}

impl Copy<'_> {
    /// The file and the byte of the declaration.
    fn declared_at(&self) -> (&str, u32) {
        let span = self.block.span;
        let file = self.subject.shader.files.get(span.file);
        (file.map_or("", |file| &*file.path), span.start)
    }

    fn view(&self) -> View<'_> {
        view(self.block, self.subject.shader.language)
    }
}

fn check(subjects: &[Subject<'_>], settings: &Settings) -> Vec<Finding> {
    let mut found = by_program(subjects);
    found.extend(by_family(subjects));
    found.extend(push_constants::check(subjects));
    found.extend(mirrors::check(subjects, settings));
    let mut kept: Vec<Finding> = Vec::new();
    for finding in found {
        // Two stages of one program may also be in one directory and in one mirror group.
        let told = kept.iter().any(|k| k.place() == finding.place() && k.about == finding.about);
        if !told {
            kept.push(finding);
        }
    }
    kept
}

/// Returns the declarations that are compared: those of buffers that several shaders may read.
fn copies<'a>(subjects: &'a [Subject<'a>]) -> impl Iterator<Item = Copy<'a>> {
    subjects.iter().flat_map(|subject| {
        let blocks = subject.shader.blocks.iter();
        // `push_constants` compares those; the others are not bound buffers.
        let bound = |block: &&BlockLayout| {
            matches!(block.space, AddressSpace::Uniform | AddressSpace::Storage) && !block.gathered
        };
        blocks.filter(bound).map(move |block| Copy { subject, block })
    })
}

/// Returns the keys that a block shares with every block it may be compared with.
pub(super) fn keys<'a>(
    shader: &'a ShaderLayout,
    block: &'a BlockLayout,
) -> impl Iterator<Item = String> {
    let bound = matches!(block.space, AddressSpace::Uniform | AddressSpace::Storage);
    let (space, slot) = (block.space.name(), (block.group, block.binding));
    let (language, rules) = (shader.language.name(), block.rules.name());
    // One key for each reason to compare: a family, a name in a program, a slot, a range.
    let related = families(shader).into_iter().map(move |family| {
        format!("{family:?} {language} {} {space} {rules} {slot:?}", block.name)
    });
    let program = program(shader);
    let linked = program.as_ref().map(|program| format!("{program:?} {} {space}", block.name));
    let shared = program.zip(block.binding).filter(|_| block.space == AddressSpace::Uniform);
    let shared = shared
        .map(|(program, binding)| format!("{program:?} {} {binding}", block.group.unwrap_or(0)));
    let pushed = block.space == AddressSpace::PushConstant;
    // A shader that belongs to no program has a range of its own.
    let range =
        pushed.then(|| push_constants::range(shader).unwrap_or_else(|| shader.path.clone()));
    let range = range.map(|range| format!("push constants {range}"));
    related.chain(linked).chain(shared).filter(move |_| bound).chain(range)
}

fn by_program(subjects: &[Subject<'_>]) -> Vec<Finding> {
    // By name, as OpenGL links blocks, and by slot, as Vulkan and WebGPU bind them.
    let mut named: BTreeMap<(Program, &str, &str), Vec<Copy<'_>>> = BTreeMap::new();
    let mut slots: BTreeMap<(Program, u32, u32), Vec<Copy<'_>>> = BTreeMap::new();
    for copy in copies(subjects) {
        let Some(program) = program(copy.subject.shader) else { continue };
        let block = copy.block;
        let key = (program.clone(), &*block.name, block.space.name());
        named.entry(key).or_default().push(copy);
        if let (AddressSpace::Uniform, Some(binding)) = (block.space, block.binding) {
            let key = (program, block.group.unwrap_or(0), binding);
            slots.entry(key).or_default().push(copy);
        }
    }
    let links = |a: &Copy<'_>, b: &Copy<'_>| {
        let (here, there) = (a.view(), b.view());
        let found = differences(&here, &there);
        let slot = |copy: &Copy<'_>| (copy.block.group.unwrap_or(0), copy.block.binding);
        // Vulkan matches blocks by slot, not by name, and a stage may declare fewer members.
        // So does WebGPU.
        let by_slot = |copy: &Copy<'_>| {
            copy.subject.shader.language == Language::Wgsl || may_be_vulkan(copy.subject)
        };
        let vulkan = by_slot(a) && by_slot(b);
        // A shorter copy or another name leaves every byte where it is.
        let fine = is_head(&here, &there) || found.iter().all(|d| d.cosmetic);
        match vulkan {
            true if slot(a) != slot(b) => Relation::None,
            true if fine => Relation::Same,
            false if found.is_empty() => Relation::Same,
            true | false => Relation::Differs,
        }
    };
    let mut found: Vec<Finding> =
        named.values().flat_map(|copies| odd_ones_out(copies, links)).collect();
    let reads = |a: &Copy<'_>, b: &Copy<'_>| {
        // Within one stage two blocks of one slot are two views of a buffer, which is intended.
        let one_stage = std::ptr::eq(a.subject, b.subject);
        match one_stage || a.block.name == b.block.name || !collide(&a.view(), &b.view()) {
            true => Relation::Same,
            false => Relation::Differs,
        }
    };
    found.extend(slots.values().flat_map(|copies| odd_ones_out(copies, reads)));
    found
}

/// The reason to compare the blocks of several files: they belong together by name or include.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Family {
    /// A directory, and a file name without the stage.
    BaseName(String, String),
    /// The file itself, or one that it includes and that declares one of its blocks.
    File(String),
}

fn families(shader: &ShaderLayout) -> Vec<Family> {
    let (directory, name) = base_name(&shader.path);
    let files = &shader.files;
    let declares = |file: u32| shader.blocks.iter().any(|block| block.span.file == file);
    // File 0 is the shader; the others are those that it includes.
    let included = (1u32..).zip(files.iter().skip(1)).filter(|(at, _)| declares(*at));
    let mut found = vec![Family::BaseName(directory, name)];
    found.push(Family::File(shader.path.replace('\\', "/")));
    found.extend(included.map(|(_, file)| Family::File(file.path.replace('\\', "/"))));
    found
}

fn by_family(subjects: &[Subject<'_>]) -> Vec<Finding> {
    type Key<'a> = (Family, &'a str, &'a str, &'a str, &'a str, Option<u32>, Option<u32>);
    let mut groups: BTreeMap<Key<'_>, Vec<Copy<'_>>> = BTreeMap::new();
    for subject in subjects {
        let families = families(subject.shader);
        for copy in copies(std::slice::from_ref(subject)) {
            let block = copy.block;
            let (language, space) = (subject.shader.language.name(), block.space.name());
            for family in &families {
                let (rules, name) = (block.rules.name(), &*block.name);
                let key =
                    (family.clone(), language, name, space, rules, block.group, block.binding);
                groups.entry(key).or_default().push(copy);
            }
        }
    }
    let relation = |a: &Copy<'_>, b: &Copy<'_>| {
        // One declaration that two programs compile with other macros is no copy.
        if a.declared_at() == b.declared_at() {
            return Relation::Same;
        }
        let (here, there) = (a.view(), b.view());
        let shared = shared(&here, &there);
        let most = here.leaves.len().max(there.leaves.len());
        // One slot of a name that is not given by chance: fewer members in common are enough.
        let slot = a.block.binding.is_some() && a.block.binding == b.block.binding;
        let related = match slot {
            true => shared >= 1 && shared * 2 >= most,
            false => shared >= 3 && shared * 3 >= most * 2,
        };
        if !related {
            return Relation::None;
        }
        match is_head(&here, &there) || differences(&here, &there).iter().all(|d| d.cosmetic) {
            true => Relation::Same,
            false => Relation::Differs,
        }
    };
    groups.values().flat_map(|copies| odd_ones_out(copies, relation)).collect()
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Relation {
    /// Copies that agree.
    Same,
    /// Copies that do not.
    Differs,
    /// Two blocks that share a name.
    None,
}

/// The most ways of declaring one block; a name with more is not one block's name.
const MAX_WAYS: usize = 8;

/// The most unrelated blocks of one name in one place.
const MAX_FAMILIES: usize = 8;

/// Returns a finding for each way of declaring a block that differs from the most common one.
fn odd_ones_out<'a>(
    copies: &[Copy<'a>],
    relation: impl Fn(&Copy<'a>, &Copy<'a>) -> Relation,
) -> Vec<Finding> {
    let relation = |a: &Copy<'a>, b: &Copy<'a>| match alike(a.block, b.block) {
        true => Relation::Same,
        false => relation(a, b),
    };
    // A family is a list of ways to declare one block, each with the copies declared so.
    let mut families: Vec<Vec<Vec<Copy<'a>>>> = Vec::new();
    for copy in copies {
        // Families and ways are bounded, as a copy is compared with the first of each way.
        let room = families.len() < MAX_FAMILIES;
        let of = families.iter_mut().find_map(|ways| {
            let same = ways.iter().position(|way| relation(copy, &way[0]) == Relation::Same);
            let known = same.is_some() || relation(copy, &ways[0][0]) == Relation::Differs;
            known.then_some((ways, same))
        });
        match of {
            Some((ways, Some(same))) => ways[same].push(*copy),
            // One way past the limit marks a family that is dropped below.
            Some((ways, None)) if ways.len() <= MAX_WAYS => ways.push(vec![*copy]),
            Some((_, None)) => {}
            None if room => families.push(vec![vec![*copy]]),
            None => {}
        }
    }
    families.retain(|ways| ways.len() <= MAX_WAYS);
    families.iter().flat_map(|ways| odd_ways(ways)).collect()
}

fn odd_ways(ways: &[Vec<Copy<'_>>]) -> Vec<Finding> {
    let sizes = ways.iter().enumerate();
    // The most common way; of equally common ones the first.
    let Some((usual, there)) = sizes.max_by_key(|(at, way)| (way.len(), ways.len() - at)) else {
        return Vec::new();
    };
    let odd = ways.iter().enumerate().filter(|(at, _)| *at != usual);
    odd.map(|(_, way)| finding(way, &there[0])).collect()
}

fn finding(way: &[Copy<'_>], there: &Copy<'_>) -> Finding {
    let here = &way[0];
    let all = differences(&here.view(), &there.view());
    let (block, other) = (here.block, there.block);
    let path = &there.subject.source.path;
    let message = match block.name == other.name {
        true => {
            format!("block `{}` is declared differently in {path}: {}", block.name, first(&all))
        }
        false => format!(
            "block `{}` has the same binding as `{}` in {path} but another layout: {}",
            block.name,
            other.name,
            first(&all)
        ),
    };
    let at = all.first().and_then(|d| d.here).unwrap_or(block.span);
    let mut finding = Finding::at(LINT.code, block.name.as_ref(), place(here.subject, at), message);
    let other_at = all.first().and_then(|d| d.there).unwrap_or(other.span);
    finding = finding.with_label(place(there.subject, other_at), "the other copy");
    finding = with_differences(finding, &all);
    for copy in way.iter().skip(1).take(MAX_COPIES) {
        let text = "declared the same way as here";
        finding = finding.with_label(place(copy.subject, copy.block.span), text);
    }
    if way.len() > 1 + MAX_COPIES {
        let more = way.len() - 1 - MAX_COPIES;
        finding = finding.with_note(format!("{more} more are declared the same way as here"));
    }
    finding.listing = listing(here.subject.shader, block);
    finding.with_help(format!(
        "declare `{}` as in {}, or in one file that both include",
        block.name, there.subject.source.path
    ))
}

/// Returns the first difference for the message, and the number of others.
fn first(all: &[CopyDifference]) -> String {
    match all {
        [] => "they are laid out differently".to_string(),
        [only] => only.text.clone(),
        [first, rest @ ..] => {
            format!("{}, and {}", first.text, counted(rest.len(), "more difference"))
        }
    }
}

/// Adds the differences after the first as notes.
fn with_differences(mut finding: Finding, all: &[CopyDifference]) -> Finding {
    for difference in all.iter().skip(1).take(MAX_NAMED) {
        finding = finding.with_note(difference.text.clone());
    }
    if all.len() > 1 + MAX_NAMED {
        finding = finding.with_note(counted(all.len() - 1 - MAX_NAMED, "more difference"));
    }
    finding
}
