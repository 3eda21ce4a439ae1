//! Phrases shared by the formats: block names, byte counts, differences from naga.

use std::fmt;

use crate::ShaderLayout;
use crate::layout::measure::{fixed, fixed_elements};
use crate::layout::padding::{PaddingKind, PaddingOwner};
use crate::layout::{BlockLayout, Leaf, MemberLayout};
use crate::shape::{AddressSpace, ArrayLen, Type};
use crate::source::Language;
pub use crate::text::counts::{bytes, counted, number, numbered};

/// Formats a measurement briefly: `0.0120`, `156`, `3,026`, `6.4e-4`.
pub fn figure(value: f64) -> String {
    let size = value.abs();
    match size {
        0.0 => "0".to_string(),
        size if (1e-2..1e6).contains(&size) => {
            let digits = (2 - size.log10().floor() as i32).max(0) as usize;
            match digits {
                0 if value >= 1e3 => number(value.round_ties_even() as u64),
                _ => format!("{value:.digits$}"),
            }
        }
        _ => format!("{value:.1e}"),
    }
}

/// A block's address space, name and instance: `uniform PointLightBlock u_lights`.
pub(super) fn block_name(block: &BlockLayout) -> String {
    if block.space == AddressSpace::Default {
        return "loose uniforms".to_string();
    }
    let mut text = block.space.name().to_string();
    for part in [Some(&block.name), block.instance.as_ref()].into_iter().flatten() {
        if !part.is_empty() {
            text.push(' ');
            text.push_str(part);
        }
    }
    text
}

/// A block's set and binding: `set 0, binding 3` in GLSL, `@group(0) @binding(3)` in WGSL, empty
/// without either.
pub fn slot(block: &BlockLayout, language: Language) -> String {
    let (group, binding, join) = match language {
        Language::Glsl | Language::SpirV => (
            block.group.map(|n| format!("set {n}")),
            block.binding.map(|n| format!("binding {n}")),
            ", ",
        ),
        Language::Wgsl => (
            block.group.map(|n| format!("@group({n})")),
            block.binding.map(|n| format!("@binding({n})")),
            " ",
        ),
    };
    [group, binding].into_iter().flatten().collect::<Vec<_>>().join(join)
}

/// The most samplers and images of a block that are listed, to bound memory.
const MAX_OPAQUE: usize = 10_000;

/// The paths of a block's samplers and images, also in structures: `lights[].shadow`. After
/// 10,000 paths the last one is `…`.
pub fn opaque(block: &BlockLayout) -> Vec<String> {
    let mut paths: Vec<String> = block.opaque.iter().map(|name| name.to_string()).collect();
    block.members.iter().for_each(|member| opaque_in(member, "", &mut paths));
    if paths.len() > MAX_OPAQUE {
        paths.truncate(MAX_OPAQUE);
        paths.push("…".to_string());
    }
    paths
}

fn opaque_in(member: &MemberLayout, parent: &str, paths: &mut Vec<String>) {
    let Type::Struct(s) = member.ty.innermost() else { return };
    if paths.len() > MAX_OPAQUE {
        return;
    }
    let path = format!("{parent}{}{}.", member.name, "[]".repeat(member.dims.len()));
    paths.extend(s.opaque.iter().map(|name| format!("{path}{name}")));
    member.members.iter().for_each(|inner| opaque_in(inner, &path, paths));
}

/// The number of buffers of an array of blocks; `None` if it is not fixed.
pub fn buffers(block: &BlockLayout) -> Option<u64> {
    fixed_elements(&block.count)
}

/// Array dimensions as a suffix: `[2][]`.
pub(super) fn dims(dims: &[ArrayLen]) -> String {
    dims.iter().map(ArrayLen::to_string).collect()
}

/// Displays numbers separated by spaces.
pub(super) struct Spaced<'a>(pub(super) &'a [u64]);

impl fmt::Display for Spaced<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (nth, number) in self.0.iter().enumerate() {
            f.write_str(if nth == 0 { "" } else { " " })?;
            number.fmt(f)?;
        }
        Ok(())
    }
}

/// A type's name, or `struct` for a nameless structure.
pub(super) fn type_name(ty: &Type, language: Language) -> String {
    ty.innermost().spelled(language).to_string()
}

/// A description of padding: `hole`, `tail padding of Light`, `tail padding of each column`.
pub(super) fn padding(kind: PaddingKind, owner: PaddingOwner, structure: Option<&str>) -> String {
    match (kind, owner, structure) {
        (PaddingKind::Hole, _, _) => "hole".to_string(),
        (PaddingKind::Tail, PaddingOwner::Structure, Some(name)) => {
            format!("tail padding of {name}")
        }
        (PaddingKind::Tail, PaddingOwner::Structure, None) => {
            "tail padding of the structure".to_string()
        }
        (PaddingKind::Tail, PaddingOwner::Block | PaddingOwner::Member, _) => {
            "tail padding".to_string()
        }
        (
            PaddingKind::Tail,
            PaddingOwner::Element | PaddingOwner::Column | PaddingOwner::Row,
            _,
        ) => format!("tail padding of each {}", owner.noun()),
    }
}

/// A structure's name, if it has one.
pub(super) fn structure_name(ty: &Type) -> Option<&str> {
    match ty.innermost() {
        Type::Struct(s) if !s.name.is_empty() => Some(&s.name),
        _ => None,
    }
}

/// The offset and strides at which naga reads a leaf, if they differ.
pub(super) fn naga(leaf: &Leaf) -> Option<String> {
    let naga = leaf.naga.as_ref()?;
    let mut text = format!("naga reads {}", naga.offset);
    if naga.strides != leaf.strides && !naga.strides.is_empty() {
        text.push_str(&format!(" stride {}", Spaced(&naga.strides)));
    }
    Some(text)
}

/// A one-line summary of a block's bytes; empty for loose uniforms.
pub(super) fn summary(block: &BlockLayout) -> String {
    let Some(summary) = crate::layout::padding::summary(block) else { return String::new() };
    let mut text = bytes(summary.size);
    if let Some((name, stride)) = endless(block) {
        text.push_str(&format!(" with one `{name}`, {} for each more", number(stride)));
    }
    text.push_str(&format!(
        ": {} used, {} padding ({:.1} %)",
        number(summary.used),
        number(summary.padding),
        summary.percent()
    ));
    text
}

/// The note on a size that is rounded up, where an implementation may report another.
pub(super) fn reported_size(shader: &ShaderLayout, block: &BlockLayout) -> Option<&'static str> {
    let rounded = block.space == AddressSpace::Uniform && block.size > block.data_size;
    (shader.opengl_es && rounded)
        .then_some("size as desktop drivers report; OpenGL ES leaves it to the implementation")
}

/// A block's last member if its number of elements is not specified, and its stride.
pub(super) fn endless(block: &BlockLayout) -> Option<(&str, u64)> {
    let member =
        block.members.last().filter(|m| m.dims.first().is_some_and(|n| fixed(n).is_none()));
    member.and_then(|member| Some((&*member.name, *member.strides.first()?)))
}
