//! `stale-comment`: comments whose numbers about the layout are wrong.

mod checks;
mod claims;
mod columns;
mod inferred;
mod owners;
mod tables;
mod tokens;

use super::definition::{Check, Lint, Subject};
use super::settings::Settings;
use super::show::{listing, place};
use checks::{CorrectNumber, counted_from, may_be_content, other_unit};
use claims::{LayoutClaim, claims, is_about_padding, is_code};
use columns::Row;
use landfall_layout::finding::{Finding, Level};
use landfall_layout::layout::MemberLayout;
use landfall_layout::source::{Files, Span};
use owners::{Owner, owners};
use tokens::Kind;

pub(super) const LINT: Lint = Lint {
    code: "stale-comment",
    level: Level::Warn,
    what: "a comment that states a wrong offset, alignment, size, stride or total",
    why: "Host code is written from comments like `// offset:16`, and nothing checks them when a \
          member is inserted above. Only a number that is wrong in every reading is reported: an \
          offset may count from the structure or from the block; a size may include the padding \
          after the member, be one element's or column's, or be the sum of the members so far; a \
          range may end at its last byte or one past it; a total may be with or without tail \
          padding. Words are read in English, German and Chinese. In any language, numbers that \
          stand in the same place of at least three members' comments are read as columns \
          (`16`, `+0x10`, `[16, 28)`, `16..28`, `12 + 4 = 16`, a running total, `floats 4..6`): \
          where a line above names them, or where most of the numbers or of the steps between them \
          fit the layout. A comment in a structure that blocks of different rules use is \
          reported when it is wrong in all of them and one number is right in all. Blocks without \
          declared rules, members behind an `#if`, and comments about other rules, padding, the host or \
          the past are skipped, and so are commented-out members and listings.",
    example: "#version 330 core\n\
              struct PointLight {\n    \
              vec3 pos;        // alignment:16 offset:0\n    \
              vec3 color;      // alignment:12 offset:16\n    \
              float intensity; // alignment:4 offset:28\n\
              };\n\
              layout(std140) uniform PointLightBlock { PointLight data[4]; } u_lights;\n\
              out vec4 shade;\n\
              void main() { shade = vec4(u_lights.data[0].color, 1.0); }\n",
    fix: "Write the number from the layout; `--fix` does, and changes only the digits.",
    check: Check::Shader(check),
};

fn check(subject: &Subject<'_>, _settings: &Settings) -> Vec<Finding> {
    // Under `--rules` the layout is not the one the comments are about.
    if subject.options.rules.is_some() {
        return Vec::new();
    }
    let blocks = subject.shader.blocks.iter();
    let blocks = blocks.filter(|b| b.rules_declared && !b.gathered);
    let mut found = Vec::new();
    for owner in owners(subject.shader, blocks) {
        in_owner(subject, &owner, &mut found);
        if found.len() >= MAX_FOUND {
            break;
        }
    }
    found.sort_by(|a, b| {
        (&a.place().path, a.place().start).cmp(&(&b.place().path, b.place().start))
    });
    found.dedup_by(|a, b| a.place() == b.place());
    found
}

/// The most findings of one shader; with more, its comments describe another layout.
const MAX_FOUND: usize = 500;

/// A claim, and the comment it is made in.
struct CommentClaim {
    index: usize,
    comment: Span,
    claim: LayoutClaim,
}

fn in_owner(subject: &Subject<'_>, owner: &Owner<'_>, found: &mut Vec<Finding>) {
    let Some(members) = owner.places.first().map(|placed| placed.members) else {
        return;
    };
    let read = read(subject, owner, members);
    // The offsets that comments state show where they count from, and in which unit.
    let offsets: Vec<(usize, u64)> = read
        .made
        .iter()
        .filter(|made| made.claim.kind == Kind::Offset)
        .map(|made| (made.index, made.claim.number.value))
        .collect();
    let other_unit = other_unit(owner, &offsets);
    let from = counted_from(owner, &offsets);
    for made in &read.made {
        if found.len() >= MAX_FOUND {
            return;
        }
        let member = &members[made.index];
        let alone = read.made.len() == 1;
        if (made.claim.kind == Kind::Offset && other_unit)
            || is_conditional(owner, member, made.claim.kind)
            || is_content(member, &made.claim, alone)
        {
            continue;
        }
        if let Some(right) = checks::member(owner, made.index, &made.claim, from) {
            found.push(finding(subject, owner, Some(member), made.comment, &made.claim, &right));
        }
    }
    // Then the comments that are only numbers, in columns.
    let kinds = columns::kinds(owner, read.header.clone(), &read.rows);
    for row in &read.rows {
        let member = &members[row.index];
        for (cell, kind) in row.cells.iter().zip(&kinds) {
            let Some(kind) = kind.filter(|&kind| !is_conditional(owner, member, kind)) else {
                continue;
            };
            let claim = columns::claim(kind, cell);
            let right = match row.step {
                0 => checks::member(owner, row.index, &claim, from),
                step => checks::column(owner, row.index, &claim, step),
            };
            if let Some(right) = right {
                found.push(finding(subject, owner, Some(member), row.comment, &claim, &right));
            }
        }
    }
    // Last, the numbers whose meaning only the layout shows.
    inferred::in_tables(subject, owner, &read, found);
    found.extend(totals(subject, owner));
}

/// What the comments of a structure's or block's members say.
#[derive(Default)]
struct ReadComments {
    made: Vec<CommentClaim>,
    header: Option<Vec<Kind>>,
    rows: Vec<Row>,
    /// The comments on the members' own lines.
    lines: Vec<(usize, Span)>,
}

fn read(subject: &Subject<'_>, owner: &Owner<'_>, members: &[MemberLayout]) -> ReadComments {
    let files = &subject.shader.files;
    let mut read = ReadComments::default();
    // The last comment after a member, and the number of lines that continue it.
    let mut tail: Option<Tail> = None;
    for (index, member) in members.iter().enumerate() {
        // `float a, b; // offset 16` does not show which of the two it is about.
        let neighbours = [index.checked_sub(1), Some(index + 1)].into_iter().flatten();
        let neighbours: Vec<_> = neighbours.filter_map(|at| members.get(at)).collect();
        for &comment in &member.comment {
            let shared = |other: &&MemberLayout| other.comment.contains(&comment);
            if comment.file != member.span.file || neighbours.iter().any(shared) {
                continue;
            }
            let text = files.text(comment);
            let behind = comment.start > member.span.start;
            let between = Span { start: comment.end, end: member.span.start, ..comment };
            if behind || !files.text(between).contains('\n') {
                if behind {
                    tail = Some(Tail { index, comment, step: 0 });
                }
                add(&mut read, owner, member, index, comment, text);
                continue;
            }
            // A row about the padding before this member.
            if is_about_padding(line(files, comment)) {
                continue;
            }
            // A comment alone on its line, right below another at the same column, continues that one.
            if let Some(tail) = tail.as_mut().filter(|tail| goes_on(files, tail.comment, comment)) {
                tail.comment = comment;
                tail.step += 1;
                if let Some(cells) = columns::cells(text) {
                    let (index, step) = (tail.index, tail.step);
                    read.rows.push(Row { index, step, comment, cells });
                }
                continue;
            }
            if index == 0 && read.header.is_none() {
                read.header = columns::header(text);
            }
            // Above a member, only numbers that a word names are about it.
            let own = claims(text, &member.name, rules(owner));
            let keyword = own.into_iter().filter(|claim| claim.keyword);
            read.made.extend(keyword.map(|claim| CommentClaim { index, comment, claim }));
        }
    }
    read
}

/// The line that a comment begins on.
fn line(files: &Files, comment: Span) -> &str {
    let text = files.get(comment.file).map_or("", |file| &*file.text);
    let start = comment.start as usize;
    let from = text[..start].rfind('\n').map_or(0, |at| at + 1);
    text[from..].lines().next().unwrap_or("")
}

struct Tail {
    index: usize,
    comment: Span,
    step: u64,
}

/// Returns whether a comment is on the line below another, at the same column.
fn goes_on(files: &Files, above: Span, below: Span) -> bool {
    let between = files.text(Span { start: above.end, end: below.start, ..below });
    above.file == below.file
        && between.trim().is_empty()
        && between.matches('\n').count() == 1
        && column(files, above).is_some_and(|at| Some(at) == column(files, below))
}

/// Returns the column of a comment in characters; `None` on a line too long to be aligned.
fn column(files: &Files, comment: Span) -> Option<usize> {
    const WIDEST: usize = 1000;
    let text = &files.get(comment.file)?.text;
    let before = text.get(..comment.start as usize)?;
    let line = before.bytes().rev().take(WIDEST).position(|byte| byte == b'\n')?;
    Some(before[before.len() - line..].chars().count())
}

/// Records the claims of a comment on a member's own line.
fn add(
    read: &mut ReadComments,
    owner: &Owner<'_>,
    member: &MemberLayout,
    index: usize,
    comment: Span,
    text: &str,
) {
    read.lines.push((index, comment));
    if let Some(cells) = columns::cells(text) {
        read.rows.push(Row { index, step: 0, comment, cells });
        return;
    }
    let said = claims(text, &member.name, rules(owner));
    // A total next to a member may include any members before it.
    let own = said.into_iter().filter(|claim| claim.kind != Kind::Total);
    read.made.extend(own.map(|claim| CommentClaim { index, comment, claim }));
}

/// Returns the rules that a structure is laid out by, if they are the same everywhere.
fn rules(owner: &Owner<'_>) -> &'static str {
    let mut rules = owner.places.iter().map(|placed| placed.rules);
    let first = rules.next();
    match first.filter(|first| rules.all(|other| other == *first)) {
        Some(rules) => rules.name(),
        None => "",
    }
}

/// Returns whether a claim may hold under another branch of an `#if` before the member.
fn is_conditional(owner: &Owner<'_>, member: &MemberLayout, kind: Kind) -> bool {
    match kind {
        Kind::Offset | Kind::Total | Kind::Size => {
            owner.comments.condition.is_some_and(|at| at < member.span.start)
        }
        Kind::Align | Kind::ArrayStride | Kind::MatrixStride | Kind::Stride => false,
    }
}

/// Returns whether a number may be the member's value rather than a number of bytes:
/// `int offset; // offset: 3`, `float radius; // size 10`.
fn is_content(member: &MemberLayout, claim: &LayoutClaim, alone: bool) -> bool {
    if claim.unit || claim.to.is_some() {
        return false;
    }
    let name = member.name.to_lowercase();
    let named = |words: &[&str]| words.iter().any(|word| name.contains(word));
    match claim.kind {
        Kind::Offset => alone && named(&["offset", "start", "first", "base", "index"]),
        Kind::Align => alone && named(&["align"]),
        Kind::Size | Kind::Total => {
            may_be_content(member)
                && (alone || named(&["size", "width", "height", "radius", "count", "num", "len"]))
        }
        Kind::ArrayStride | Kind::MatrixStride | Kind::Stride => {
            member.strides.is_empty() && member.matrix_stride.is_none()
        }
    }
}

/// Returns the findings in the comments around a structure or block about its size.
fn totals(subject: &Subject<'_>, owner: &Owner<'_>) -> Vec<Finding> {
    let comments = &owner.comments;
    if comments.condition.is_some() {
        return Vec::new();
    }
    let mut found = Vec::new();
    // A listing, or commented-out code, above the declaration.
    let files = &subject.shader.files;
    let before = |span: &Span| span.start < owner.span.start;
    let is_listing = comments.spans.iter().any(|span| before(span) && is_code(files.text(*span)));
    let about = comments.spans.iter().filter(|span| !(is_listing && before(span)));
    let around = about.map(|&span| (span, false));
    for (span, last) in around.chain(comments.last.iter().map(|&span| (span, true))) {
        for claim in claims(subject.shader.files.text(span), &owner.name, rules(owner)) {
            // After the last member, `// 4 bytes` may just as well be the padding.
            if last && claim.kind != Kind::Total {
                continue;
            }
            if let Some(right) = checks::whole(owner, &claim) {
                found.push(finding(subject, owner, None, span, &claim, &right));
            }
        }
        if !last && found.is_empty() {
            found.extend(inferred::counted(subject, owner, span));
        }
    }
    found
}

fn finding(
    subject: &Subject<'_>,
    owner: &Owner<'_>,
    member: Option<&MemberLayout>,
    comment: Span,
    claim: &LayoutClaim,
    right: &CorrectNumber,
) -> Finding {
    // The right number is the same in all places of the owner.
    let placed = &owner.places[0];
    let name = member.map_or(&owner.name, |member| &member.name);
    let said = match &claim.to {
        Some(to) => format!("{} to {}", claim.number.value, to.value),
        None => claim.number.value.to_string(),
    };
    let is = match right.to {
        Some(to) => format!("{} to {to}", right.value),
        None => right.value.to_string(),
    };
    let (noun, message) = match claim.kind {
        Kind::Offset => {
            let message = format!("comment puts `{name}` at offset {said}, but it is at {is}");
            ("offset", message)
        }
        Kind::Align => {
            let message =
                format!("comment aligns `{name}` to {said} bytes, but it is aligned to {is}");
            ("alignment", message)
        }
        Kind::Size | Kind::Total => {
            ("size", format!("comment says `{name}` is {said} bytes, but it is {is}"))
        }
        Kind::ArrayStride | Kind::MatrixStride | Kind::Stride => {
            let what = if claim.kind == Kind::MatrixStride { "matrix stride" } else { "stride" };
            (what, format!("comment gives `{name}` a {what} of {said} bytes, but it is {is}"))
        }
    };
    let about = match member {
        Some(member) => format!("{}.{} {noun}", owner.name, member.name),
        None => format!("{} {noun}", owner.name),
    };
    let part = |range: &std::ops::Range<usize>| Span {
        start: comment.start + range.start as u32,
        end: comment.start + range.end as u32,
        ..comment
    };
    let mut finding =
        Finding::at(LINT.code, about, place(subject, part(&claim.number.range)), message)
            .with_text(format!("{noun} {is} by {}", placed.rules.name()))
            .with_help(format!("write {is} instead of {said}"));
    if placed.block.span != owner.span && *placed.block.name != *owner.name {
        let text = format!("`{}` is laid out in this block", owner.name);
        finding = finding.with_label(place(subject, placed.block.span), text);
    }
    let numbers = [Some((&claim.number, right.value)), claim.to.as_ref().zip(right.to)];
    // Of a range, only the end that is wrong is replaced.
    for (number, value) in numbers.into_iter().flatten().filter(|(n, value)| n.value != *value) {
        let old = subject.shader.files.text(part(&number.range));
        finding = finding.with_edit(place(subject, part(&number.range)), spelled(old, value));
    }
    finding.listing = listing(subject.shader, placed.block);
    finding
}

/// Returns a number in the notation of the one it replaces: decimal, or hexadecimal of the same
/// width and case.
fn spelled(old: &str, value: u64) -> String {
    match old.split_at_checked(2) {
        Some((prefix @ ("0x" | "0X"), digits)) => {
            let width = digits.len();
            match digits.contains(|c: char| c.is_ascii_uppercase()) {
                true => format!("{prefix}{value:0width$X}"),
                false => format!("{prefix}{value:0width$x}"),
            }
        }
        Some(_) | None => value.to_string(),
    }
}
