//! `unused-member`: a member that no function accesses, of a block that is in use.

use rustc_hash::FxHashMap;

use super::definition::{Check, Lint, Subject};
use super::settings::Settings;
use super::show::bytes;
use super::unused_block::Used;
use landfall_layout::finding::{Finding, Level, Place};
use landfall_layout::layout::{BlockLayout, MemberLayout};
use landfall_layout::shape::Type;
use landfall_layout::source::Span;

pub(super) const LINT: Lint = Lint {
    code: "unused-member",
    // A block shared by several shaders has members for each of them.
    level: Level::Allow,
    what: "a member of a block that no function of the shader reads or writes",
    why: "It costs bytes and an upload, and is often a leftover, or a typo that makes the shader \
          read another member. Only detected in shaders that naga accepts unchanged, with an entry \
          point: WGSL, and Vulkan GLSL without `#if`. A structure that is copied as a whole uses \
          all its members; names that mean padding (`_pad`, `reserved`) are ignored. Allowed by \
          default, because blocks are shared.",
    example: "\
#version 450
layout(std140, set = 0, binding = 0) uniform Camera {
    mat4 view;
    mat4 projection; // never read
} camera;
void main() { gl_Position = camera.view[0]; }
",
    fix: "Remove the member from the block and from every copy, or use it.",
    check: Check::Naga(check),
};

fn check(subject: &Subject<'_>, _settings: &Settings) -> Vec<Finding> {
    let Some(touched) = super::unused_block::accessed_parts(subject) else { return Vec::new() };
    let mut members = DeclaredMembers::default();
    for (block, used) in subject.shader.blocks.iter().zip(&touched) {
        match used {
            // `unused-block` reports a block that nothing accesses.
            Some(used) if used.is_empty() => {}
            Some(_) | None => members.add(block, used.as_ref()),
        }
    }
    let unused = members.order.iter().filter(|known| !members.touched[&(known.span, known.name)]);
    unused.map(|known| finding(subject, known)).collect()
}

/// Every declaration of a member, and whether any block's copy of it is accessed.
#[derive(Default)]
struct DeclaredMembers<'a> {
    touched: FxHashMap<(Span, &'a str), bool>,
    order: Vec<KnownMember<'a>>,
}

struct KnownMember<'a> {
    span: Span,
    name: &'a str,
    /// The structure it is declared in, or the block.
    owner: &'a str,
    member: &'a MemberLayout,
}

impl<'a> DeclaredMembers<'a> {
    fn add(&mut self, block: &'a BlockLayout, used: Option<&Used>) {
        self.descend(&block.members, &block.name, "", used);
    }

    fn descend(
        &mut self,
        members: &'a [MemberLayout],
        owner: &'a str,
        parent: &str,
        used: Option<&Used>,
    ) {
        for member in members {
            let path = format!("{parent}{}{}", member.name, "[]".repeat(member.dims.len()));
            let touched = used.is_none_or(|used| touches(used, &path));
            let key = (member.span, &*member.name);
            if !self.touched.contains_key(&key) {
                let name = &*member.name;
                self.order.push(KnownMember { span: member.span, name, owner, member });
            }
            // An access through one block is enough for all that have the structure.
            *self.touched.entry(key).or_default() |= touched || says_padding(&member.name);
            // A structure that nothing accesses is reported as a whole, not member by member.
            if touched {
                if let Type::Struct(inner) = member.ty.innermost() {
                    self.descend(&member.members, &inner.name, &format!("{path}."), used);
                }
            }
        }
    }
}

/// Returns whether an accessed path is that path, around it, or below it.
fn touches(used: &Used, path: &str) -> bool {
    let below = |outer: &str, inner: &str| {
        outer.is_empty()
            || inner.strip_prefix(outer).is_some_and(|rest| {
                rest.is_empty() || rest.starts_with('.') || rest.starts_with('[')
            })
    };
    // An array may be accessed as a whole.
    let bare = path.trim_end_matches("[]");
    used.iter().any(|used| below(used, path) || below(bare, used))
}

/// Returns whether the name marks padding.
fn says_padding(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    name.starts_with('_')
        || ["pad", "reserved", "unused", "dummy", "spare"].iter().any(|word| name.contains(word))
}

fn finding(subject: &Subject<'_>, known: &KnownMember<'_>) -> Finding {
    let KnownMember { span, name, owner, member } = known;
    let size = member.size.map(|size| format!(", {}", bytes(size))).unwrap_or_default();
    let message = format!("no function reads or writes `{name}` of `{owner}`{size}");
    Finding::at(
        LINT.code,
        format!("{owner}.{name}"),
        Place::new(&subject.shader.files, *span),
        message,
    )
    .with_help("remove it here and in every copy, or name it `_pad…` if its bytes are wanted")
}
