//! Structures and blocks as they are declared, each with every place it is laid out in, and the
//! comments around it.
//!
//! Reads the [model](landfall_layout::layout) and the text. Feeds [`checks`](super::checks).

use std::sync::Arc;

use rustc_hash::FxHashMap;

use landfall_layout::ShaderLayout;
pub use landfall_layout::layout::measure::{element_size, reach, structure};
use landfall_layout::layout::{BlockLayout, MemberLayout};
use landfall_layout::shape::{Rules, Type};
use landfall_layout::source::Span;

/// The most places of one structure that are examined.
const MAX_PLACES: usize = 64;

/// A structure or block as declared.
pub(super) struct Owner<'a> {
    pub name: Arc<str>,
    pub span: Span,
    /// The places where it is laid out: one for a block, one per use for a structure.
    pub places: Vec<PlacedComment<'a>>,
    pub comments: SurroundingComments,
}

/// A structure or block where it is laid out.
pub(super) struct PlacedComment<'a> {
    pub members: &'a [MemberLayout],
    pub block: &'a BlockLayout,
    pub rules: Rules,
    /// The offset of its first byte, from the start of the block.
    pub base: u64,
    /// The size in bytes with padding, and the end of its last member.
    pub size: u64,
    pub data_size: u64,
    /// The array stride, for an element of an array.
    pub stride: Option<u64>,
}

impl PlacedComment<'_> {
    /// The offset of the next member, or the end of the structure or block.
    pub fn next(&self, index: usize) -> u64 {
        self.members.get(index + 1).and_then(|next| next.offset).unwrap_or(self.size)
    }
}

/// Comments that are about a structure or block as a whole.
#[derive(Default)]
pub(super) struct SurroundingComments {
    /// Comments on the lines before it, on the line of its `{`, and after its `}`.
    pub spans: Vec<Span>,
    /// Comments on lines of their own after the last member.
    pub last: Vec<Span>,
    /// The first `#if` or `#else` between its braces: members after it may have another layout.
    pub condition: Option<u32>,
}

/// The declarations of a shader, in the order in which blocks use them.
pub(super) fn owners<'a>(
    shader: &'a ShaderLayout,
    blocks: impl Iterator<Item = &'a BlockLayout>,
) -> Vec<Owner<'a>> {
    let mut found: Vec<Owner<'a>> = Vec::new();
    let mut known: FxHashMap<(Span, Arc<str>), usize> = FxHashMap::default();
    let mut add = |name: &Arc<str>, span: Span, placed: PlacedComment<'a>| {
        let at = *known.entry((span, name.clone())).or_insert_with(|| {
            let comments = around(shader, name, span, placed.members);
            found.push(Owner { name: name.clone(), span, places: Vec::new(), comments });
            found.len() - 1
        });
        if found[at].places.len() < MAX_PLACES {
            found[at].places.push(placed);
        }
    };
    for block in blocks {
        let (Some(size), Some(data_size)) = (block.size, block.data_size) else { continue };
        // A WGSL variable of a structure is laid out as the structure it names.
        let placed = |members| PlacedComment {
            members,
            block,
            rules: block.rules,
            base: 0,
            size,
            data_size,
            stride: None,
        };
        add(&block.name, block_span(shader, block), placed(&block.members));
        // The structures in it at any depth.
        let mut steps: Vec<(&'a [MemberLayout], u64)> = vec![(&block.members, 0)];
        while let Some((members, base)) = steps.pop() {
            for member in members {
                let (Type::Struct(s), Some(offset)) = (member.ty.innermost(), member.offset) else {
                    continue;
                };
                let base = base + offset;
                let placed = PlacedComment {
                    members: &member.members,
                    block,
                    rules: block.rules,
                    base,
                    size: element_size(member, block.rules),
                    data_size: structure(&member.members, block.rules).data_size,
                    stride: member.strides.last().copied(),
                };
                add(&s.name, s.span, placed);
                steps.push((&member.members, base));
            }
        }
    }
    found
}

/// The range in which a block's members are declared: in WGSL the structure, not the variable.
fn block_span(shader: &ShaderLayout, block: &BlockLayout) -> Span {
    let first = block.members.first().map_or(block.span, |member| member.span);
    // A WGSL variable whose type is not a structure declares its only member itself.
    if first == block.span {
        return first;
    }
    let text = shader.files.get(first.file).map_or("", |file| &file.text);
    let head = text.get(..first.start as usize).unwrap_or("");
    // The name that stands before the brace that opens around the first member.
    let Some(open) = head.rfind('{') else { return block.span };
    let before = head[..open].trim_end();
    match before.ends_with(&*block.name) {
        true => Span {
            start: (before.len() - block.name.len()) as u32,
            end: before.len() as u32,
            ..first
        },
        false => block.span,
    }
}

/// Finds the brace that opens right after a name; comments may stand between.
fn brace_after(text: &str, name_end: usize) -> Option<usize> {
    let mut rest = text[name_end..].trim_start();
    loop {
        rest = if rest.starts_with("//") {
            &rest[rest.find('\n')?..]
        } else if rest.starts_with("/*") {
            &rest[rest.find("*/")? + 2..]
        } else {
            break;
        };
        rest = rest.trim_start();
    }
    rest.starts_with('{').then(|| text.len() - rest.len())
}

/// Finds the comments around a declaration of that name; none if the declaration is unusual.
fn around(
    shader: &ShaderLayout,
    name: &str,
    span: Span,
    members: &[MemberLayout],
) -> SurroundingComments {
    let mut found = SurroundingComments::default();
    let text = shader.files.get(span.file).map_or("", |file| &*file.text);
    if shader.files.text(span) != name || name.is_empty() {
        return found;
    }
    let at = |start: usize, end: usize| Span { start: start as u32, end: end as u32, ..span };
    found.spans.extend(above(text, span.start as usize).map(|(start, end)| at(start, end)));
    let Some(open) = brace_after(text, span.end as usize) else { return found };
    let first = members.first().map_or(open, |member| member.span.start as usize);
    let last = members.iter().map(|member| member.span.end as usize).max().unwrap_or(open);
    // Of open braces; comments inside of inner ones are not about this declaration.
    let mut depth = 0usize;
    let mut scan = open;
    while let Some(sign) = text[scan..].chars().next() {
        let rest = &text[scan..];
        let comment = match rest {
            _ if rest.starts_with("//") => Some(rest.find('\n').unwrap_or(rest.len())),
            _ if rest.starts_with("/*") => Some(rest.find("*/").map_or(rest.len(), |at| at + 2)),
            _ => None,
        };
        if let Some(length) = comment {
            let own_line = text[..scan].rsplit('\n').next().unwrap_or("").trim().is_empty();
            let opening = depth == 1 && scan < first && !text[open..scan].contains('\n');
            if opening {
                found.spans.push(at(scan, scan + length));
            } else if depth == 1 && scan > last && own_line {
                found.last.push(at(scan, scan + length));
            }
            scan += length;
            continue;
        }
        match sign {
            '{' => depth += 1,
            '}' => {
                depth -= 1;
                if depth == 0 {
                    break;
                }
            }
            '#' if found.condition.is_none() => {
                let word = rest[1..].trim_start();
                if word.starts_with("if") || word.starts_with("el") {
                    found.condition = Some(scan as u32);
                }
            }
            _ => {}
        }
        scan += sign.len_utf8();
    }
    let line = text[scan..].split('\n').next().unwrap_or("");
    if let Some(comment) = line.find("//").or_else(|| line.find("/*")) {
        // `}; // 48 bytes`, `} u_light; // …`; not behind another declaration.
        let between = &line[..comment];
        if between.matches(['{', '(']).count() == 0 && between.matches(';').count() <= 1 {
            found.spans.push(at(scan + comment, scan + line.trim_end().len()));
        }
    }
    found
}

/// Returns the lines of `//` directly above the line on which a declaration starts.
fn above(text: &str, start: usize) -> impl Iterator<Item = (usize, usize)> {
    let mut end = text[..start].rfind('\n').unwrap_or(0);
    let mut found = Vec::new();
    while end > 0 {
        let line_start = text[..end].rfind('\n').map_or(0, |at| at + 1);
        let line = &text[line_start..end];
        let indent = line.len() - line.trim_start().len();
        if !line.trim_start().starts_with("//") {
            break;
        }
        found.push((line_start + indent, line_start + line.trim_end().len()));
        end = line_start.saturating_sub(1);
    }
    found.into_iter().rev()
}

/// Bytes from a member's start to its end, a runtime-sized one counted with one element.
pub(super) fn end_of(member: &MemberLayout) -> u64 {
    member.offset.unwrap_or(0) + reach(member)
}
