//! Words the differences of one structure, with helps that add up.
//!
//! [`MirrorWalk`] follows the fields in order and keeps the bytes that they take once the helps so far are
//! followed. A help is what is still missing then, so that following all of them puts every field
//! where the shader reads it. Fed by [`compare`](super::compare).

use super::compare::{Difference, says_padding};
use super::fit::{FieldMismatch, MemberView};
use super::reach::{Before, PaddingField, Reach};
use super::rust_type::StructureLayout;
use super::suggest::{Suggestion, suggested};
use crate::show::bytes;
use crate::walk::first_few;
use landfall_layout::layout::measure::reach;

/// The size that a structure needs, in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MirrorEnd {
    /// That of an element of an array.
    Exactly(u64),
    /// That of a block; a longer one is read in part.
    AtLeast(u64),
    Free,
}

impl MirrorEnd {
    fn exactly(self) -> Option<u64> {
        match self {
            MirrorEnd::Exactly(size) => Some(size),
            MirrorEnd::AtLeast(_) | MirrorEnd::Free => None,
        }
    }
}

/// A member, and the field that mirrors it.
pub(super) struct MirrorStep<'a> {
    pub view: MemberView<'a>,
    /// `None` if the structure lacks it.
    pub field: Option<usize>,
    misfit: Option<FieldMismatch>,
    /// The field's size and alignment once its type is mended.
    becomes: Option<(u64, u64)>,
    /// Whether the field has another name.
    renamed: bool,
}

impl<'a> MirrorStep<'a> {
    pub fn missing(view: MemberView<'a>) -> MirrorStep<'a> {
        MirrorStep { view, field: None, misfit: None, becomes: None, renamed: false }
    }

    pub fn matched(
        view: MemberView<'a>,
        field: usize,
        misfit: Option<FieldMismatch>,
        becomes: Option<(u64, u64)>,
        renamed: bool,
    ) -> MirrorStep<'a> {
        MirrorStep { view, field: Some(field), misfit, becomes, renamed }
    }

    fn offset(&self) -> u64 {
        self.view.member.offset.unwrap_or(0)
    }

    /// The field's name once the help about it is followed.
    fn name(&self, laid: &StructureLayout) -> String {
        match self.field {
            Some(index) if !self.renamed => laid.fields[index].name.clone(),
            _ => self.view.member.name.to_string(),
        }
    }

    /// The size and alignment once the help about its type is followed.
    fn mended(&self, laid: &StructureLayout) -> (u64, u64) {
        let own = self.field.map(|index| (laid.fields[index].size, laid.fields[index].align));
        self.becomes.or(own).unwrap_or((reach(self.view.member), 1))
    }
}

pub(super) struct Plan {
    pub differences: Vec<Difference>,
    /// Its size and alignment once they are mended.
    pub size: u64,
    pub align: u64,
    /// How its size is mended, where nothing else differs.
    pub tail: Option<String>,
}

/// Returns the differences of a structure from the members of those steps.
pub(super) fn plan(laid: &StructureLayout, steps: &[MirrorStep<'_>], end: MirrorEnd) -> Plan {
    let fields = steps.iter().filter_map(|step| step.field);
    // Edits of single fields cannot mend another order.
    let in_order = fields.clone().zip(fields.skip(1)).all(|(before, after)| before < after);
    let mut walk = MirrorWalk {
        laid,
        found: Vec::new(),
        cause: None,
        followers: Vec::new(),
        by: 0,
        reach: Reach::new(laid.writer, laid.least_align),
    };
    match in_order {
        true => walk.in_order(steps),
        false => walk.out_of_order(steps, end),
    }
    walk.finish(end, in_order)
}

struct MirrorWalk<'l> {
    laid: &'l StructureLayout,
    found: Vec<Difference>,
    /// The last finding whose help moves what is behind it.
    cause: Option<usize>,
    /// The fields that are right once the cause is mended, and how far they are off.
    followers: Vec<String>,
    by: i128,
    reach: Reach,
}

impl MirrorWalk<'_> {
    fn in_order(&mut self, steps: &[MirrorStep<'_>]) {
        let mut next = 0;
        for step in steps {
            match step.field {
                Some(index) => {
                    (next..index).for_each(|index| self.between(index, steps));
                    next = index + 1;
                    self.place(step, index);
                }
                None => self.insert(step),
            }
        }
        (next..self.laid.fields.len()).for_each(|index| self.between(index, steps));
    }

    /// A field that mirrors no member.
    fn between(&mut self, index: usize, steps: &[MirrorStep<'_>]) {
        let field = &self.laid.fields[index];
        let offset = self.reach.cursor().next_multiple_of(field.align);
        self.reach.align = self.reach.align.max(field.align);
        let mut finding = None;
        if !says_padding(&field.name) && field.ty.size > 0 {
            finding = Some(self.found.len());
            self.found.push(Difference {
                structure: self.laid.index,
                field: Some(index),
                member: steps.last().map(|step| step.view.member.span),
                member_text: "the shader's last member".to_string(),
                message: format!(
                    "`{}` of `{}`, {} at {}, is not a member in the shader",
                    field.name,
                    self.laid.name,
                    bytes(field.ty.size),
                    field.offset,
                ),
                notes: Vec::new(),
                help: Some(format!(
                    "remove it, or name it `_{}` if it is padding",
                    field.name.trim_start_matches('_')
                )),
            });
        }
        let padding = PaddingField { name: field.name.clone(), offset, size: field.size, finding };
        self.reach.pads.push(padding);
    }

    fn place(&mut self, step: &MirrorStep<'_>, index: usize) {
        let field = &self.laid.fields[index];
        let wanted = step.offset();
        let (size, mut align) = step.mended(self.laid);
        let mut parts = Vec::new();
        // No padding puts it there: its type is aligned to more.
        if !wanted.is_multiple_of(align) {
            parts.push(aligned(step, &field.name, align));
            align = 1;
        }
        let removed = self.reach.to(wanted, align, &field.name, &mut parts);
        for finding in removed {
            self.found[finding].help = Some("remove it".to_string());
            self.follow_behind(Some(finding));
        }
        let edit = (!parts.is_empty()).then(|| parts.join(" and "));
        let wrong = field.offset != wanted && !step.renamed;
        match (wrong, edit) {
            (true, None) if self.cause.is_some() => self.follow(&field.name, field.offset, wanted),
            (true, edit) => {
                self.follow_behind(Some(self.found.len()));
                self.by = i128::from(field.offset) - i128::from(wanted);
                self.found.push(misplaced(self.laid, step, index, edit));
            }
            // It is where it belongs, and would not stay there.
            (false, Some(edit)) => self.also(&edit),
            (false, None) => {}
        }
        self.reach.end = wanted.saturating_add(size);
        // A field that is larger than its member can be made smaller.
        let smaller = suggested(step.view).filter(|fit| fit.size < size);
        let (name, from) = (step.name(self.laid), self.reach.from);
        self.reach.before = Some(Before { name, offset: wanted, align, from, smaller });
        self.misfit(step, index);
    }

    /// Reports a field's name and type.
    fn misfit(&mut self, step: &MirrorStep<'_>, index: usize) {
        if let Some(difference) = misnamed(self.laid, step, index).or_else(|| {
            let misfit = step.misfit.as_ref()?;
            Some(Difference {
                structure: self.laid.index,
                field: Some(index),
                member: Some(step.view.member.span),
                member_text: format!("`{}`", step.view.member.ty.spelled(step.view.language)),
                message: format!(
                    "`{}` of `{}` {}",
                    self.laid.fields[index].name, self.laid.name, misfit.text
                ),
                notes: Vec::new(),
                help: Some(misfit.help.clone()),
            })
        }) {
            let moves = step.becomes.is_some_and(|(size, _)| size != self.laid.fields[index].size);
            if moves || self.cause.is_none() {
                self.follow_behind(Some(self.found.len()));
            }
            self.found.push(difference);
        }
    }

    /// The field of that name or, if it is to be removed, the last one in front of it that stays.
    fn last_kept(&self, name: &str) -> Option<String> {
        let is_removed = |at: usize| {
            let at_field = |found: &&Difference| found.field == Some(at);
            let found = self.found.iter().filter(at_field);
            found
                .into_iter()
                .any(|found| found.help.as_deref().is_some_and(|it| it.starts_with("remove it")))
        };
        let Some(at) = self.laid.fields.iter().position(|field| *field.name == *name) else {
            // It is added by an earlier help.
            return Some(name.to_string());
        };
        let kept = (0..=at).rev().find(|&at| !is_removed(at))?;
        Some(self.laid.fields[kept].name.to_string())
    }

    /// A member that has no field.
    fn insert(&mut self, step: &MirrorStep<'_>) {
        let member = step.view.member;
        let wanted = step.offset();
        let fit = suggested(step.view);
        let (size, align) = fit.as_ref().map_or((reach(member), 1), |fit| (fit.size, fit.align));
        let mut parts = Vec::new();
        let before = self.reach.before.as_ref().map(|before| before.name.clone());
        let removed = self.reach.to(wanted, align, &member.name, &mut parts);
        for finding in removed {
            self.found[finding].help = Some("remove it".to_string());
        }
        let last = self.reach.kept.take().or(before).and_then(|name| self.last_kept(&name));
        let at = last.map_or("first".to_string(), |name| format!("after `{name}`"));
        // Padding right before it is added with it.
        let behind = format!(" before `{}`", member.name);
        let mut padding = None;
        if let Some(part) =
            parts.pop_if(|part| part.starts_with("put `_") && part.ends_with(&behind))
        {
            padding = part
                .strip_prefix("put ")
                .and_then(|part| part.strip_suffix(&behind))
                .map(str::to_string);
        }
        parts.push(added(&member.name, fit, size, padding, &at));
        self.follow_behind(Some(self.found.len()));
        self.by = 0;
        self.found.push(Difference {
            structure: self.laid.index,
            field: None,
            member: Some(member.span),
            member_text: format!("read at byte {wanted}"),
            message: format!(
                "`{}` has no field `{}`, which the shader reads at {wanted}",
                self.laid.name, member.name
            ),
            notes: Vec::new(),
            help: Some(parts.join(" and ")),
        });
        self.reach.end = wanted.saturating_add(size);
        let name = member.name.to_string();
        let from = self.reach.from;
        self.reach.before = Some(Before { name, offset: wanted, align, from, smaller: None });
    }

    /// Makes that finding the cause of what is shifted behind it.
    fn follow_behind(&mut self, finding: Option<usize>) {
        self.cause = finding;
        self.followers.clear();
        self.by = 0;
    }

    /// Notes that a field is right once the cause is mended.
    fn follow(&mut self, name: &str, offset: u64, wanted: u64) {
        let Some(finding) = self.cause.and_then(|cause| self.found.get_mut(cause)) else { return };
        let by = i128::from(offset) - i128::from(wanted);
        self.followers.push(format!("`{name}`"));
        let names = first_few(&self.followers);
        let (are, land, shift) = match self.followers.len() {
            1 => ("is", "it", "is shifted with it"),
            _ => ("are", "them", "are shifted with it"),
        };
        let note = match by == self.by {
            true => format!(
                "{names} {are} shifted by the same {}: fixing this field fixes {land}",
                bytes(by.unsigned_abs() as u64),
            ),
            false => format!("{names} {shift}: fixing this field fixes {land}"),
        };
        finding.notes = vec![note];
    }

    /// Adds an edit to the help that makes it necessary.
    fn also(&mut self, edit: &str) {
        let Some(finding) = self.cause.and_then(|cause| self.found.get_mut(cause)) else { return };
        match &mut finding.help {
            Some(help) => help.push_str(&format!(", and {edit}")),
            None => finding.help = Some(edit.to_string()),
        }
    }

    /// The fields stand in another order than the members: one help gives the order.
    fn out_of_order(&mut self, steps: &[MirrorStep<'_>], end: MirrorEnd) {
        let mut shift = None;
        for step in steps {
            let Some(index) = step.field else {
                self.insert(step);
                continue;
            };
            let field = &self.laid.fields[index];
            let by = i128::from(field.offset) - i128::from(step.offset());
            if by != 0 && !step.renamed {
                match shift == Some(by) {
                    true => self.follow(&field.name, field.offset, step.offset()),
                    false => {
                        self.follow_behind(Some(self.found.len()));
                        self.by = by;
                        self.found.push(misplaced(self.laid, step, index, None));
                    }
                }
            }
            shift = Some(by);
            self.misfit(step, index);
        }
        // One help places all; what is said of types stays.
        let order = self.order(steps, end);
        let spelled = |step: &&MirrorStep<'_>| step.renamed && suggested(step.view).is_some();
        let spelled: Vec<usize> =
            steps.iter().filter(spelled).filter_map(|step| step.field).collect();
        for finding in &mut self.found {
            if finding.field.is_none_or(|field| spelled.contains(&field)) {
                finding.help = None;
            }
        }
        if let Some(first) = self.found.iter_mut().find(|found| found.help.is_none()) {
            first.help = Some(order);
        }
    }

    /// The fields in the shader's order, with the padding between them.
    fn order(&mut self, steps: &[MirrorStep<'_>], end: MirrorEnd) -> String {
        let mut reach = Reach::new(self.laid.writer, self.laid.least_align);
        let mut names = Vec::new();
        let after = steps.iter().skip(1).map(|next| Some(next.offset())).chain([end.exactly()]);
        for (step, after) in steps.iter().zip(after) {
            let (mut size, mut align) = step.mended(self.laid);
            let mut name = step.name(self.laid);
            // Where a field stands now, a longer type may end in padding.
            let stays = step.offset().is_multiple_of(align)
                && after.is_none_or(|after| step.offset().saturating_add(size) <= after);
            let is_spelled = step.field.is_none() || step.renamed || !stays;
            let fit = suggested(step.view).filter(|_| is_spelled);
            if let Some(fit) = fit {
                name = format!("{name}: {}", fit.text);
                (size, align) = (fit.size, fit.align);
            }
            let gap = reach.gap(step.offset(), align);
            names.extend(gap.map(|(at, gap)| self.laid.writer.padding(at, gap)));
            names.push(format!("`{name}`"));
            reach.end = step.offset().saturating_add(size);
            reach.align = reach.align.max(align);
        }
        self.reach = reach;
        let edit = self.reach.tail(end);
        names.extend(
            edit.as_deref().and_then(|edit| edit.strip_prefix("end it with ")).map(str::to_string),
        );
        match names.len() <= MAX_NAMES {
            true => {
                format!(
                    "declare its fields in the order {}, without other padding",
                    names.join(", ")
                )
            }
            false => "declare its fields in the shader's order".to_string(),
        }
    }

    fn finish(mut self, end: MirrorEnd, in_order: bool) -> Plan {
        let tail = self.reach.tail(end);
        let mut own = None;
        match (&tail, self.found.is_empty()) {
            (Some(_), true) => own = tail,
            (Some(edit), false) if in_order => {
                let last = self.found.len() - 1;
                self.cause = Some(self.cause.unwrap_or(last));
                let edit = edit.replace("end it with", "end the structure with");
                self.also(&edit);
            }
            (Some(_) | None, _) => {}
        }
        let end = self.reach.cursor();
        let align = self.reach.largest_align();
        let size = end.checked_next_multiple_of(align).unwrap_or(end);
        Plan { differences: self.found, size, align, tail: own }
    }
}

/// The most names that a help lists.
const MAX_NAMES: usize = 24;

fn misplaced(
    laid: &StructureLayout,
    step: &MirrorStep<'_>,
    index: usize,
    help: Option<String>,
) -> Difference {
    let field = &laid.fields[index];
    let wanted = step.offset();
    Difference {
        structure: laid.index,
        field: Some(index),
        member: Some(step.view.member.span),
        member_text: format!("read at byte {wanted}"),
        message: format!(
            "`{}` is at byte {} of `{}`, the shader reads it at {wanted}",
            field.name, field.offset, laid.name,
        ),
        notes: Vec::new(),
        help,
    }
}

/// The finding of a field that stands at a member's byte under another name.
fn misnamed(laid: &StructureLayout, step: &MirrorStep<'_>, index: usize) -> Option<Difference> {
    let (field, member) = (&laid.fields[index], step.view.member);
    if !step.renamed {
        return None;
    }
    let offset = step.offset();
    let help = match (&step.misfit, suggested(step.view)) {
        (None, _) => format!("rename it to `{}`, or declare an alias for it", member.name),
        (Some(_), Some(fit)) => format!("make it `{}: {}`", member.name, fit.text),
        (Some(misfit), None) => format!("rename it to `{}` and {}", member.name, misfit.help),
    };
    Some(Difference {
        structure: laid.index,
        field: Some(index),
        member: Some(member.span),
        member_text: format!("read at byte {offset}"),
        message: format!(
            "`{}` has no field `{}`; at its byte {offset} is `{}`",
            laid.name, member.name, field.name,
        ),
        notes: Vec::new(),
        help: Some(help),
    })
}

fn added(
    name: &str,
    fit: Option<Suggestion>,
    size: u64,
    padding: Option<String>,
    at: &str,
) -> String {
    let padding = padding.map_or(String::new(), |padding| format!("{padding}, "));
    match fit {
        Some(fit) => format!("add {padding}`{name}: {}` {at}", fit.text),
        None => format!("add {padding}`{name}`, {} of data, {at}", bytes(size)),
    }
}

/// Returns the help for a field that its type's alignment moves.
fn aligned(step: &MirrorStep<'_>, name: &str, align: u64) -> String {
    let instead = suggested(step.view).filter(|fit| step.offset().is_multiple_of(fit.align));
    match instead {
        Some(fit) => format!("make `{name}` `{}`, which is not aligned to {align}", fit.text),
        None => format!("use a type for `{name}` that is not aligned to {align}"),
    }
}
