//! Mirror groups: copies of a block or structure under other names, declared in the configuration.

use super::compare::{CopyDifference, NamedLeaf, View, differences};
use super::{LINT, first, with_differences};
use crate::definition::Subject;
use crate::settings::Settings;
use crate::settings::{MirrorCopy, MirrorGroup};
use crate::show::{is_called, listing, place};
use crate::walk::dimensions;
use landfall_layout::finding::Finding;
pub use landfall_layout::layout::path::{Segment, segments};
use landfall_layout::layout::{BlockLayout, MemberLayout};
use landfall_layout::shape::Type;
use landfall_layout::source::Span;
use landfall_layout::text::edit_distance::nearest;
use landfall_layout::text::glob;

pub(super) fn check(subjects: &[Subject<'_>], settings: &Settings) -> Vec<Finding> {
    settings.mirror_groups.iter().flat_map(|group| in_group(group, subjects)).collect()
}

/// The block or structure that a copy in the configuration refers to in one shader.
pub struct MirrorTarget<'a> {
    subject: &'a Subject<'a>,
    block: &'a BlockLayout,
    view: View<'a>,
    /// Its name in the shader, and its span.
    name: String,
    span: Span,
}

fn in_group(group: &MirrorGroup, subjects: &[Subject<'_>]) -> Vec<Finding> {
    let mut findings = Vec::new();
    let mut reference: Option<MirrorTarget<'_>> = None;
    // The first copy found is the one that all others are compared with.
    for copy in &group.copies {
        let files = || subjects.iter().filter(|s| glob::matches(&copy.file, &s.source.path));
        let mut found = files().flat_map(|subject| resolve(copy, subject)).peekable();
        if found.peek().is_none() {
            findings.push(missing(group, copy, files()));
        }
        for here in found {
            match &reference {
                Some(there) => findings.extend(compared(group, copy, &here, there)),
                None => reference = Some(here),
            }
        }
    }
    findings
}

fn compared(
    group: &MirrorGroup,
    copy: &MirrorCopy,
    here: &MirrorTarget<'_>,
    there: &MirrorTarget<'_>,
) -> Option<Finding> {
    let mut all = differences(&here.view, &there.view);
    // Leaves that agree say nothing about the padding at the end.
    if let (true, Some(a), Some(b)) = (all.is_empty(), here.view.size, there.view.size) {
        if a != b {
            let text = format!("it takes {a} bytes here and {b} there");
            all.push(CopyDifference { text, here: None, there: None, cosmetic: false });
        }
    }
    if all.is_empty() {
        return None;
    }
    let message = format!(
        "`{}` differs from `{}` in {}: {}",
        here.name,
        there.name,
        there.subject.source.path,
        first(&all)
    );
    let at = all.first().and_then(|d| d.here).unwrap_or(here.span);
    let other = all.first().and_then(|d| d.there).unwrap_or(there.span);
    let mut finding = Finding::at(LINT.code, here.name.as_str(), place(here.subject, at), message)
        .with_label(place(there.subject, other), "the other copy");
    let places = [&copy.place, &group.place];
    if let Some(place) = places.into_iter().find(|place| !place.path.is_empty()) {
        finding = finding.with_label(place.clone(), format!("mirror group `{}`", group.name));
    }
    finding = with_differences(finding, &all);
    finding.listing = listing(here.subject.shader, here.block);
    Some(finding.with_help(format!(
        "declare both alike, or give the copy a prefix or aliases in mirror group `{}`",
        group.name
    )))
}

fn missing<'a>(
    group: &MirrorGroup,
    copy: &MirrorCopy,
    files: impl Iterator<Item = &'a Subject<'a>>,
) -> Finding {
    let mut count = 0;
    let mut names: Vec<&str> = Vec::new();
    for subject in files {
        count += 1;
        for block in &subject.shader.blocks {
            names.push(&block.name);
            names.extend(block.instance.as_deref());
            names.extend(block.members.iter().map(|member| &*member.name));
        }
    }
    let message = match (count, copy.file.is_empty()) {
        (0, false) => format!("mirror group `{}`: no shader matches `{}`", group.name, copy.file),
        (_, true) => format!("mirror group `{}`: no shader has `{}`", group.name, copy.block),
        (_, false) => format!(
            "mirror group `{}`: no shader that matches `{}` has `{}`",
            group.name, copy.file, copy.block
        ),
    };
    let place = if copy.place.path.is_empty() { &group.place } else { &copy.place };
    let about = format!("{}: {}", group.name, copy.block);
    let finding = Finding::at(LINT.code, about, place.clone(), message);
    if count == 0 && !copy.file.is_empty() {
        return finding.with_help("`file` is a glob relative to the configuration");
    }
    let wanted = copy.block.split(['.', '[']).next().unwrap_or("");
    match nearest(wanted, names.into_iter()) {
        Some(name) if name != wanted => finding.with_help(format!("did you mean `{name}`?")),
        Some(_) | None => finding.with_help("name a block, its instance, or a path to a structure"),
    }
}

/// Returns the blocks or structures that a copy refers to in a shader: blocks of that name, or the
/// structure at the end of that path.
fn resolve<'a>(copy: &MirrorCopy, subject: &'a Subject<'a>) -> Vec<MirrorTarget<'a>> {
    let path = segments(copy.block.trim()).unwrap_or_default();
    let names: Vec<&str> = path
        .iter()
        .filter_map(|segment| match segment {
            Segment::Name(name) => Some(name.as_str()),
            Segment::Index(_) => None,
        })
        .collect();
    let Some((first, rest)) = names.split_first() else { return Vec::new() };
    let blocks = || subject.shader.blocks.iter();
    // A block of that name, else a path from some block's members, else a structure's type.
    let mut found: Vec<MirrorTarget<'a>> = Vec::new();
    for block in blocks().filter(|block| is_called(block, first)) {
        match rest {
            [] => found.push(whole(copy, subject, block)),
            rest => found.extend(part(copy, subject, block, rest)),
        }
    }
    if found.is_empty() {
        found.extend(blocks().filter_map(|block| part(copy, subject, block, &names)));
    }
    if let (true, []) = (found.is_empty(), rest) {
        found.extend(blocks().filter_map(|block| structure(copy, subject, block, first)));
    }
    found
}

fn whole<'a>(
    copy: &MirrorCopy,
    subject: &'a Subject<'a>,
    block: &'a BlockLayout,
) -> MirrorTarget<'a> {
    let mut view = super::view(block, subject.shader.language);
    for leaf in &mut view.leaves {
        leaf.name = canonical(copy, &leaf.name);
    }
    MirrorTarget { subject, block, view, name: block.name.to_string(), span: block.span }
}

/// Returns the structure at the end of a path of members.
fn part<'a>(
    copy: &MirrorCopy,
    subject: &'a Subject<'a>,
    block: &'a BlockLayout,
    names: &[&str],
) -> Option<MirrorTarget<'a>> {
    let mut members = &block.members;
    let mut steps = Vec::new();
    for name in names {
        let member = members.iter().find(|member| &*member.name == *name)?;
        steps.push(member);
        members = &member.members;
    }
    element(copy, subject, block, &steps)
}

/// Returns the first member, at any depth, whose type is a structure of that name.
fn structure<'a>(
    copy: &MirrorCopy,
    subject: &'a Subject<'a>,
    block: &'a BlockLayout,
    name: &str,
) -> Option<MirrorTarget<'a>> {
    fn find<'a>(
        members: &'a [MemberLayout],
        name: &str,
        steps: &mut Vec<&'a MemberLayout>,
    ) -> bool {
        members.iter().any(|member| {
            steps.push(member);
            let is = matches!(member.ty.innermost(), Type::Struct(s) if *s.name == *name);
            let found = is || find(&member.members, name, steps);
            if !found {
                steps.pop();
            }
            found
        })
    }
    let mut steps = Vec::new();
    find(&block.members, name, &mut steps).then_some(())?;
    element(copy, subject, block, &steps)
}

/// Returns one element of the structure at the end of those members.
fn element<'a>(
    copy: &MirrorCopy,
    subject: &'a Subject<'a>,
    block: &'a BlockLayout,
    steps: &[&'a MemberLayout],
) -> Option<MirrorTarget<'a>> {
    let last = *steps.last()?;
    let Type::Struct(s) = last.ty.innermost() else { return None };
    let step =
        |member: &&MemberLayout| format!("{}{}", member.name, "[]".repeat(member.dims.len()));
    let name = steps.iter().map(step).collect::<Vec<_>>().join(".");
    let prefix = format!("{name}.");
    // Leaves have offsets in the block, copies of a structure have offsets in that.
    let base = steps.iter().try_fold(0u64, |sum, member| sum.checked_add(member.offset?));
    let dims: usize = steps.iter().map(|member| member.dims.len()).sum();
    let leaves = block.leaves.iter().filter_map(|leaf| {
        let inner = leaf.path.strip_prefix(&prefix)?;
        Some(NamedLeaf {
            name: canonical(copy, inner),
            offset: leaf.offset.zip(base).map(|(offset, base)| offset - base),
            dims: leaf.dims.get(dims..).unwrap_or_default(),
            strides: leaf.strides.get(dims..).unwrap_or_default(),
            arrays: dimensions(&last.members, inner),
            leaf,
        })
    });
    let view = View {
        leaves: leaves.collect(),
        // Where it is no array, the padding behind it is not part of a copy.
        size: last.strides.last().copied(),
        language: subject.shader.language,
    };
    Some(MirrorTarget {
        subject,
        block,
        view,
        name,
        // A structure without a name is declared with its member.
        span: if s.name.is_empty() { last.span } else { s.span },
    })
}

/// Returns a member's name in the group, without aliases and the prefix.
fn canonical(copy: &MirrorCopy, path: &str) -> String {
    let plain = path.replace("[]", "");
    // An alias of a whole path goes before aliases of its parts.
    if let Some((name, _)) = copy.aliases.iter().find(|(_, here)| *here == plain) {
        return name.clone();
    }
    let step = |step: &str| {
        let (name, dims) = step.split_at(step.find('[').unwrap_or(step.len()));
        let alias = copy.aliases.iter().find(|(_, here)| here == name).map(|(name, _)| &**name);
        let name = alias.unwrap_or_else(|| name.strip_prefix(&*copy.prefix).unwrap_or(name));
        format!("{name}{dims}")
    };
    path.split('.').map(step).collect::<Vec<_>>().join(".")
}
