//! The findings of numbers whose meaning the layout shows, not a word: columns of any language, and
//! counts of floats.

use super::checks;
use super::claims::{LayoutClaim, is_elsewhere};
use super::owners::{Owner, PlacedComment};
use super::tables::{self, ColumnQuantity};
use super::tokens::{CommentNumber, Kind};
use super::{CommentClaim, LINT, ReadComments, is_conditional, rules, spelled};
use crate::definition::Subject;
use crate::show::{listing, place};
use landfall_layout::finding::{Finding, Place};
use landfall_layout::layout::MemberLayout;
use landfall_layout::source::Span;

/// Adds the findings of numbers whose meaning the layout shows, in comments that are not read
/// otherwise.
pub(super) fn in_tables(
    subject: &Subject<'_>,
    owner: &Owner<'_>,
    read: &ReadComments,
    found: &mut Vec<Finding>,
) {
    let Some(members) = owner.places.first().map(|placed| placed.members) else { return };
    let files = &subject.shader.files;
    let lines = read.lines.iter().map(|&(index, comment)| tables::Line {
        index,
        comment,
        text: files.text(comment),
    });
    let lines: Vec<_> = lines.collect();
    let mut told: Option<Span> = None;
    for wrong in tables::wrong(owner, &lines) {
        let member = &members[wrong.index];
        let same = |made: &CommentClaim| {
            made.comment == wrong.comment && made.claim.number.range == wrong.number.range
        };
        let is_read =
            read.made.iter().any(same) || is_elsewhere(files.text(wrong.comment), rules(owner));
        let at = place(subject, wrong.comment);
        // A line with another finding is left to that.
        let known = found.iter().any(|finding| {
            let place = finding.place();
            place.path == at.path && place.line == at.line
        });
        if is_read || (known && told != Some(wrong.comment)) {
            continue;
        }
        if is_conditional(owner, member, wrong.quantity.kind()) {
            continue;
        }
        // One finding a comment; the other numbers are edits of it.
        match found.pop_if(|_| told == Some(wrong.comment)) {
            Some(finding) => {
                let (at, text) = edit(subject, wrong.comment, &wrong.number, wrong.right);
                found.push(finding.with_edit(at, text));
            }
            None => {
                told = Some(wrong.comment);
                found.push(in_table(subject, owner, member, &wrong));
            }
        }
    }
}

/// Returns the finding of a number of a column.
fn in_table(
    subject: &Subject<'_>,
    owner: &Owner<'_>,
    member: &MemberLayout,
    wrong: &tables::Wrong,
) -> Finding {
    let placed = &owner.places[0];
    let (said, is) = (wrong.number.value, wrong.right);
    let unit = if wrong.unit == 1 { "byte" } else { "float" };
    let (name, noun, what) = match wrong.quantity {
        ColumnQuantity::Offset => (&member.name, "offset", format!("puts `{}` at", member.name)),
        ColumnQuantity::Size => {
            (&member.name, "size", format!("gives `{}` a size of", member.name))
        }
        ColumnQuantity::Align => {
            (&member.name, "alignment", format!("gives `{}` an alignment of", member.name))
        }
        ColumnQuantity::End
        | ColumnQuantity::PaddedEnd
        | ColumnQuantity::Last
        | ColumnQuantity::PaddedLast => (&member.name, "end", format!("ends `{}` at", member.name)),
    };
    let message = match wrong.quantity.kind() {
        Kind::Offset => format!("comment {what} {unit} {said}, but it is {is}"),
        _ => format!("comment {what} {said}, but it is {is}"),
    };
    let (at, text) = edit(subject, wrong.comment, &wrong.number, is);
    let mut finding =
        Finding::at(LINT.code, format!("{}.{name} {noun}", owner.name), at.clone(), message)
            .with_text(format!("{noun} {is} by {}", placed.rules.name()))
            .with_note("the other numbers in this place of the comments fit the layout")
            .with_help(format!("write {is} instead of {said}"))
            .with_edit(at, text);
    finding.listing = listing(subject.shader, placed.block);
    finding
}

fn edit(
    subject: &Subject<'_>,
    comment: Span,
    number: &CommentNumber,
    value: u64,
) -> (Place, String) {
    let part = Span {
        start: comment.start + number.range.start as u32,
        end: comment.start + number.range.end as u32,
        ..comment
    };
    let old = subject.shader.files.text(part);
    (place(subject, part), spelled(old, value))
}

/// Returns the finding of a comment that counts the floats or vectors of a structure: `12 floats`.
pub(super) fn counted(subject: &Subject<'_>, owner: &Owner<'_>, span: Span) -> Option<Finding> {
    let comment = subject.shader.files.text(span);
    let (number, unit) = tables::count(comment)?;
    let value = number.value.checked_mul(unit)?;
    let total = CommentNumber { value, ..number.clone() };
    let claim =
        LayoutClaim { kind: Kind::Total, number: total, to: None, unit: true, keyword: true };
    let right = checks::whole(owner, &claim)?.value;
    // Floats may be counted without the padding between them.
    let sum = |placed: &PlacedComment<'_>| {
        placed.members.iter().map(|member| member.size.unwrap_or(0)).sum::<u64>()
    };
    let unpadded = owner.places.iter().any(|placed| sum(placed) == value);
    if unpadded || !right.is_multiple_of(unit) || is_elsewhere(comment, rules(owner)) {
        return None;
    }
    let what = match unit {
        4 => "floats",
        16 => "vectors of 16 bytes",
        _ => "bytes",
    };
    let (said, is) = (number.value, right / unit);
    let message = format!("comment says `{}` is {said} {what}, but it is {is}", owner.name);
    let (at, text) = edit(subject, span, &number, is);
    let finding = Finding::at(LINT.code, format!("{} size", owner.name), at.clone(), message)
        .with_text(format!("{is} by {}", owner.places[0].rules.name()))
        .with_help(format!("write {is} instead of {said}"))
        .with_edit(at, text);
    Some(Finding { listing: listing(subject.shader, owner.places[0].block), ..finding })
}
