//! Every member of a shader's blocks with its path.
//!
//! Used by the lints that check one member at a time.

use std::sync::Arc;

use rustc_hash::FxHashSet;

use super::Subject;
use landfall_layout::ShaderLayout;
use landfall_layout::finding::{Finding, Place};
use landfall_layout::layout::{BlockLayout, MemberLayout};
use landfall_layout::shape::{ArrayLen, Type};
use landfall_layout::source::{Language, Span};

/// A member and its position in a block.
pub(super) struct Visit<'a> {
    pub block: &'a BlockLayout,
    /// The structure it is declared in; `None` for a member of the block itself.
    pub structure: Option<&'a Arc<str>>,
    /// The path, without the member's own dimensions: `lights[].color`.
    pub path: String,
    /// The member and its neighbours, and its index among them.
    pub siblings: &'a [MemberLayout],
    pub index: usize,
}

impl Visit<'_> {
    pub fn member(&self) -> &MemberLayout {
        &self.siblings[self.index]
    }

    /// Returns a name that does not change when lines move: `Light.color`, `LightBlock.count`.
    pub fn about(&self) -> String {
        match self.structure {
            Some(name) if !name.is_empty() => format!("{name}.{}", self.member().name),
            Some(_) | None => format!("{}.{}", self.block.name, self.path),
        }
    }

    /// Returns a finding of that lint at the member.
    pub fn finding(&self, subject: &Subject<'_>, code: &str, message: String) -> Finding {
        let place = Place::new(&subject.shader.files, self.member().span);
        Finding::at(code, self.about(), place, message)
    }
}

/// Returns the findings that a lint has for single members.
pub(super) fn per_member(
    subject: &Subject<'_>,
    check: fn(&Subject<'_>, &Visit<'_>) -> Option<Finding>,
) -> Vec<Finding> {
    members(subject.shader).iter().filter_map(|visit| check(subject, visit)).collect()
}

/// Returns the members of all blocks that have bytes, each declaration once for every layout rule.
pub(super) fn members(shader: &ShaderLayout) -> Vec<Visit<'_>> {
    let mut found = Vec::new();
    let mut seen = FxHashSet::default();
    for block in shader.blocks.iter().filter(|block| block.size.is_some()) {
        descend(block, None, &block.members, "", &mut seen, &mut found);
    }
    found
}

type Visited<'a> = FxHashSet<(Span, &'a str, &'static str, bool)>;

fn descend<'a>(
    block: &'a BlockLayout,
    structure: Option<&'a Arc<str>>,
    siblings: &'a [MemberLayout],
    parent: &str,
    seen: &mut Visited<'a>,
    found: &mut Vec<Visit<'a>>,
) {
    for (index, member) in siblings.iter().enumerate() {
        // A macro may expand to several members, which share one place.
        if !seen.insert((member.span, &*member.name, block.rules.name(), member.row_major)) {
            continue;
        }
        let path = format!("{parent}{}", member.name);
        if let Type::Struct(inner) = member.ty.innermost() {
            let below = format!("{path}{}.", "[]".repeat(member.dims.len()));
            descend(block, Some(&inner.name), &member.members, &below, seen, found);
        }
        found.push(Visit { block, structure, path, siblings, index });
    }
}

/// Returns the array that each dimension of a path belongs to: `lights` for `lights[].color`.
pub(super) fn dimensions(members: &[MemberLayout], path: &str) -> Vec<Span> {
    let (mut found, mut members) = (Vec::new(), members);
    for step in path.split('.') {
        let name = step.split('[').next().unwrap_or(step);
        let Some(member) = members.iter().find(|member| &*member.name == name) else { break };
        found.extend(member.dims.iter().map(|_| member.span));
        members = &member.members;
    }
    found
}

/// Returns a declaration: `vec4 w[16]`, `w: array<vec4<f32>, 16>`.
pub(super) fn declared(name: &str, ty: &Type, language: Language) -> String {
    match language {
        Language::Glsl | Language::SpirV => {
            let dims: String = ty
                .dims()
                .iter()
                .map(|len| match len {
                    ArrayLen::Fixed(n) => format!("[{n}]"),
                    ArrayLen::Runtime => "[]".to_string(),
                    ArrayLen::Override(name) => format!("[{name}]"),
                })
                .collect();
            format!("{} {name}{dims}", ty.innermost().spelled(language))
        }
        Language::Wgsl => format!("{name}: {}", ty.spelled(language)),
    }
}

/// Returns the first few names of a list, and the number of the others.
pub(super) fn first_few(names: &[String]) -> String {
    const SHOWN: usize = 6;
    let mut text = names.iter().take(SHOWN).cloned().collect::<Vec<_>>().join(", ");
    if names.len() > SHOWN {
        text.push_str(&format!(" and {} more", names.len() - SHOWN));
    }
    text
}
