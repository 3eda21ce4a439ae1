//! `specialised-length`: members behind an array whose length is specialised.

use super::definition::{Check, Lint, Subject};
use super::settings::Settings;
use super::show::{bytes, place};
use landfall_layout::finding::{Finding, Level};
use landfall_layout::layout::{BlockLayout, MemberLayout};
use landfall_layout::shape::{ArrayLen, SpecialisedLength};

pub(super) const LINT: Lint = Lint {
    code: "specialised-length",
    level: Level::Warn,
    what: "a member behind an array whose length is a specialisation constant",
    why: "A block is laid out once, by the defaults of its specialisation constants: \"Changing the \
          specialized size will not re-layout the block\" (GL_KHR_vulkan_glsl). A pipeline that \
          specialises the constant with a larger value has an array whose last elements lie on the \
          members behind it; one with a smaller value leaves the members where they are. Code that \
          computes offsets from the constant uploads them to other bytes.",
    example: "\
#version 450
layout(constant_id = 3) const int BINS = 6;
layout(set = 0, binding = 0, std430) buffer Histogram {
    uint tally[BINS];
    float scale; // at 24, whatever value BINS has
};
layout(local_size_x = 1) in;
void main() { tally[0] += uint(scale); }
",
    fix: "Move the array to the end of the block, give it the largest length as a plain constant, or \
          give the members behind it an explicit `offset` past the largest length.",
    check: Check::Shader(check),
};

fn check(subject: &Subject<'_>, _settings: &Settings) -> Vec<Finding> {
    let lengths = &subject.shader.specialised;
    if lengths.is_empty() {
        return Vec::new();
    }
    let mut found = Vec::new();
    for block in subject.shader.blocks.iter().filter(|block| block.size.is_some()) {
        let mut walk = LengthWalk { subject, block, lengths, found: &mut found };
        walk.members(&block.members, "", 0, None);
    }
    found
}

/// What begins behind a member: its path and its first byte in the block.
#[derive(Clone)]
struct Next {
    path: String,
    offset: u64,
    align: u64,
}

struct LengthWalk<'a> {
    subject: &'a Subject<'a>,
    block: &'a BlockLayout,
    lengths: &'a [SpecialisedLength],
    found: &'a mut Vec<Finding>,
}

impl LengthWalk<'_> {
    fn members(&mut self, all: &[MemberLayout], prefix: &str, base: u64, behind: Option<&Next>) {
        for (index, member) in all.iter().enumerate() {
            let Some(offset) = member.offset else { continue };
            let path = format!("{prefix}{}", member.name);
            let sibling = all.get(index + 1).and_then(|next| {
                Some(Next {
                    path: format!("{prefix}{}", next.name),
                    offset: base + next.offset?,
                    align: next.align?,
                })
            });
            let behind = sibling.as_ref().or(behind);
            let is_here = |length: &&SpecialisedLength| length.member == member.span;
            if let Some(length) = self.lengths.iter().find(is_here) {
                self.found.extend(self.finding(member, &path, base + offset, length, behind));
            }
            let mut inner = behind.cloned();
            let mut below = format!("{path}.");
            if let (Some(first), Some(stride)) = (member.dims.first(), member.strides.first()) {
                below = format!("{path}[0].");
                // Behind the last member of an element begins the next element.
                if *first != ArrayLen::Fixed(1) {
                    let (offset, align) = (base + offset + stride, 1);
                    inner = Some(Next { path: format!("{path}[1]"), offset, align });
                }
            }
            self.members(&member.members, &below, base + offset, inner.as_ref());
        }
    }

    fn finding(
        &self,
        member: &MemberLayout,
        path: &str,
        start: u64,
        length: &SpecialisedLength,
        behind: Option<&Next>,
    ) -> Option<Finding> {
        let end = start + member.size?;
        let given = length.given.and_then(|given| {
            let stride = member.strides.first()?;
            Some((given, start + stride * u64::from(given)))
        });
        let past = given.filter(|(_, past)| *past > end);
        let constants: Vec<String> =
            length.constants.iter().map(|name| format!("`{name}`")).collect();
        let constants = constants.join(" and ");
        let about = format!("{}.{path}", self.block.name);
        let at = place(self.subject, member.span);
        // An explicit offset leaves room for more elements.
        let is_last = behind.is_none();
        let close = behind.filter(|next| {
            next.offset < end.next_multiple_of(next.align.max(1)) + next.align.max(1)
                || past.is_some_and(|(_, past)| past > next.offset)
        });
        let (message, help) = match (close, past) {
            (Some(next), _) => (
                format!(
                    "`{}` stays at byte {} behind `{path}`, whose length depends on the \
                     specialisation of {constants}",
                    next.path, next.offset
                ),
                format!("move `{path}` to the end of the block"),
            ),
            (None, Some((given, past))) if is_last => (
                format!(
                    "`{path}` ends at byte {past} with the {given} elements of `-O`, but its block \
                     is laid out for those up to byte {end}"
                ),
                format!("give the default of {constants} the largest value that pipelines use"),
            ),
            (None, _) => return None,
        };
        let mut finding = Finding::at(LINT.code, about, at, message).with_note(
            "the defaults of specialisation constants lay a block out; specialisation does not lay \
             it out anew (GL_KHR_vulkan_glsl)",
        );
        if let (Some(next), Some((given, past))) = (close, past) {
            finding = finding.with_note(format!(
                "with the {given} elements of `-O`, `{path}` takes {} and lies on `{}`",
                bytes(past - start),
                next.path
            ));
        }
        Some(finding.with_help(help))
    }
}
