//! Members as JSON for the page: their numbers, and why each has them, from which the script
//! answers what `landfall explain` does for any element.

use landfall_layout::format::explain::reason;
use landfall_layout::layout::explain::StepKind;
use landfall_layout::layout::measure::{element_size, fixed};
use landfall_layout::shape::ScalarKind;
use landfall_layout::source::{Files, Language};
use landfall_layout::{MemberLayout, Rules, Type};
use serde::Serialize;

use super::texts::Texts;

/// What members of one block share.
pub(super) struct Context<'a, 't> {
    pub rules: Rules,
    pub language: Language,
    pub files: &'a Files,
    pub texts: &'t mut Texts,
}

#[derive(Serialize)]
pub(super) struct Member<'a> {
    name: &'a str,
    #[serde(rename = "type")]
    ty: String,
    /// Offset from the start of the block or structure.
    offset: Option<u64>,
    size: Option<u64>,
    align: Option<u64>,
    line: u32,
    /// Size of one element below all dimensions.
    element: u64,
    /// Size without `@size`, where that raises it.
    #[serde(skip_serializing_if = "Option::is_none")]
    own_size: Option<u64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    dims: Vec<Option<u64>>,
    /// The type below each dimension.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    below: Vec<String>,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    strides: &'a [u64],
    #[serde(skip_serializing_if = "Option::is_none")]
    matrix_stride: Option<u64>,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    row_major: bool,
    /// What a leaf consists of; `None` for structures.
    #[serde(skip_serializing_if = "Option::is_none")]
    leaf: Option<LeafComponents>,
    /// Why it is where it is; `None` for loose uniforms.
    why: Option<Why>,
    /// Why the elements of each dimension are where they are.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    why_elements: Vec<Why>,
    /// Why the columns of a matrix are where they are.
    #[serde(skip_serializing_if = "Option::is_none")]
    why_columns: Option<usize>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    members: Vec<Member<'a>>,
}

/// The components of a leaf.
#[derive(Serialize)]
struct LeafComponents {
    kind: &'static str,
    width: u8,
    columns: u8,
    rows: u8,
    /// The type of a column and of a component.
    column: String,
    scalar: String,
}

/// A rule and what follows from it, as indices of texts.
#[derive(Serialize)]
struct Why {
    rule: Vec<usize>,
    lines: Vec<usize>,
}

pub(super) fn members<'a>(
    all: &'a [MemberLayout],
    context: &mut Context<'a, '_>,
) -> Vec<Member<'a>> {
    (0..all.len()).map(|at| member(all, at, context)).collect()
}

fn member<'a>(all: &'a [MemberLayout], at: usize, context: &mut Context<'a, '_>) -> Member<'a> {
    let (member, rules) = (&all[at], context.rules);
    let placed = member.offset.is_some();
    let kind = placed.then(|| StepKind::of_member(all, at, rules));
    let own_size = match &kind {
        Some(StepKind::Member { own_size, .. }) => *own_size,
        _ => None,
    };
    let dims = if placed { 0..member.dims.len() } else { 0..0 };
    let mut elements = Vec::with_capacity(dims.len());
    for dim in dims {
        // The second line is about one index: the script writes it.
        let kind = StepKind::of_element(member, dim, None, rules);
        let mut why = why(&kind, 0, context);
        why.lines.truncate(1);
        elements.push(why);
    }
    let leaf = leaf(&member.ty, context.language);
    let why_columns = leaf.as_ref().filter(|leaf| placed && leaf.columns > 1).map(|leaf| {
        let kind = StepKind::of_column(member, 0, leaf.width.into());
        context.texts.index(reason(&kind, 0, rules).0.swap_remove(0))
    });
    Member {
        name: &member.name,
        ty: member.ty.spelled(context.language).to_string(),
        offset: member.offset,
        size: member.size,
        align: member.align,
        line: context.files.locate(member.span).line,
        element: if placed { element_size(member, rules) } else { 0 },
        own_size,
        dims: member.dims.iter().map(fixed).collect(),
        below: below(&member.ty, context.language),
        strides: &member.strides,
        matrix_stride: member.matrix_stride,
        row_major: member.row_major,
        why: kind.map(|kind| why(&kind, member.offset.unwrap_or(0), context)),
        why_elements: elements,
        why_columns,
        leaf,
        members: members(&member.members, context),
    }
}

fn why(kind: &StepKind, adds: u64, context: &mut Context<'_, '_>) -> Why {
    let (lines, rule) = reason(kind, adds, context.rules);
    let mut indices =
        |texts: Vec<String>| texts.into_iter().map(|text| context.texts.index(text)).collect();
    Why { rule: indices(rule), lines: indices(lines) }
}

/// The types below each dimension of an array.
fn below(ty: &Type, language: Language) -> Vec<String> {
    let mut types = Vec::new();
    let mut ty = ty;
    while let Type::Array { element, .. } = ty {
        ty = element;
        types.push(ty.spelled(language).to_string());
    }
    types
}

fn leaf(ty: &Type, language: Language) -> Option<LeafComponents> {
    let (scalar, columns, rows) = match ty.innermost() {
        Type::Scalar(scalar) | Type::Atomic(scalar) => (*scalar, 1, 1),
        Type::Vector { scalar, rows } => (*scalar, 1, *rows),
        Type::Matrix { scalar, columns, rows } => (*scalar, *columns, *rows),
        Type::Address(name) => {
            let (column, scalar) = (name.to_string(), name.to_string());
            let kind = ScalarKind::Uint.name();
            return Some(LeafComponents { kind, width: 8, columns: 1, rows: 1, column, scalar });
        }
        Type::Struct(_) | Type::Array { .. } => return None,
    };
    let spelled = |ty: Type| ty.spelled(language).to_string();
    let column = match rows {
        1 => spelled(Type::Scalar(scalar)),
        _ => spelled(Type::Vector { scalar, rows }),
    };
    let scalar_type = spelled(Type::Scalar(scalar));
    Some(LeafComponents {
        kind: scalar.kind.name(),
        width: scalar.width,
        columns,
        rows,
        column,
        scalar: scalar_type,
    })
}
