//! Infers the layout that a backend used when it reads other bytes than expected.
//!
//! Fits offset and strides to the bytes a leaf was read from, and compares the fit with other
//! layout rules, other matrix orders and naga's layout.

use rustc_hash::FxHashMap;

use super::results::{ProbeResult, ProbedLocation};
use landfall_layout::layout::{BlockLayout, Leaf, lay_out};
use landfall_layout::shape::{Block, MatrixLayout, Member, OffsetOrder, Rules};

/// The linear placement of a leaf.
#[derive(Clone, Debug, PartialEq, Eq)]
struct LinearPlacement {
    offset: i64,
    /// The stride of each dimension; `None` if only one element was read.
    strides: Vec<Option<i64>>,
    column: Option<i64>,
    row: Option<i64>,
}

/// The leaves of a block under the rules it does not have, by path.
pub struct OtherRules {
    layouts: Vec<(Rules, FxHashMap<String, Leaf>)>,
}

impl OtherRules {
    /// Lays out the block's members by each of the other rules.
    pub fn from_block(block: &BlockLayout) -> OtherRules {
        let others = [Rules::Std140, Rules::Std430, Rules::Scalar];
        let others = others.into_iter().filter(|rules| *rules != block.rules);
        let by_path = |layout: BlockLayout| {
            layout.leaves.into_iter().map(|leaf| (leaf.path.clone(), leaf)).collect()
        };
        let layouts = others.filter_map(|rules| Some((rules, by_path(under(block, rules)?))));
        OtherRules { layouts: layouts.collect() }
    }
}

/// Returns the likely cause of one leaf's deviations; `None` if nothing fits.
pub fn cause(
    others: &OtherRules,
    expected: &Leaf,
    probe_results: &[&ProbeResult],
) -> Option<String> {
    let place = fit(expected, probe_results)?;
    let meant = of_leaf(expected, &place);
    if place == meant {
        return None;
    }
    let mut parts = Vec::new();
    if let Some(words) = known_cause(others, expected, &place) {
        parts.push(words);
    }
    if place.offset != meant.offset {
        parts.push(format!("it starts at {} instead of {}", place.offset, meant.offset));
    }
    for (nth, (got, want)) in place.strides.iter().zip(&meant.strides).enumerate() {
        if got == want {
            continue;
        }
        let (Some(got), Some(want)) = (got, want) else { continue };
        let which = match (meant.strides.len(), nth) {
            (1, _) => String::new(),
            (_, 0) => " of the outer dimension".to_string(),
            (count, nth) if nth + 1 == count => " of the inner dimension".to_string(),
            (_, nth) => format!(" of dimension {}", nth + 1),
        };
        parts.push(format!("the array stride{which} is {got} instead of {want}"));
    }
    // Swapped strides are one cause, not two.
    if (place.column, place.row) == (meant.row, meant.column) && place.column != place.row {
        parts.push("rows and columns are swapped".to_string());
    } else {
        for (what, got, want) in
            [("columns", place.column, meant.column), ("components", place.row, meant.row)]
        {
            if let (Some(got), Some(want), true) = (got, want, got != want) {
                parts.push(format!("{what} are {got} bytes apart instead of {want}"));
            }
        }
    }
    Some(parts.join("; "))
}

/// Returns the leaf's expected placement, with the strides that `like` has.
fn of_leaf(leaf: &Leaf, like: &LinearPlacement) -> LinearPlacement {
    let width = leaf.size.map_or(4, |_| component_width(leaf));
    let matrix = leaf.matrix_stride.map(|stride| stride as i64);
    let (column, row) = match (matrix, leaf.row_major) {
        (Some(stride), false) => (Some(stride), Some(width)),
        (Some(stride), true) => (Some(width), Some(stride)),
        (None, _) => (None, Some(width)),
    };
    let strides = leaf.strides.iter().map(|stride| *stride as i64);
    LinearPlacement {
        offset: leaf.offset.unwrap_or(0) as i64,
        strides: strides.zip(&like.strides).map(|(stride, known)| known.map(|_| stride)).collect(),
        column: like.column.and(column),
        row: like.row.and(row),
    }
}

fn component_width(leaf: &Leaf) -> i64 {
    use landfall_layout::shape::Type;
    match &leaf.ty {
        Type::Scalar(scalar)
        | Type::Atomic(scalar)
        | Type::Vector { scalar, .. }
        | Type::Matrix { scalar, .. } => i64::from(scalar.width),
        Type::Address(_) | Type::Struct(_) | Type::Array { .. } => 8,
    }
}

/// Fits a linear placement to all results of a leaf.
fn fit(leaf: &Leaf, probe_results: &[&ProbeResult]) -> Option<LinearPlacement> {
    let seen: Vec<(&ProbeResult, i64)> = probe_results
        .iter()
        .filter_map(|probe_result| match probe_result.got {
            ProbedLocation::Byte(byte) => Some((*probe_result, byte as i64)),
            ProbedLocation::Other(_) => None,
        })
        .collect();
    // The steps from the leaf's first component to what is read: in each dimension, in columns, in
    // rows.
    let steps = |probe_result: &ProbeResult| -> Vec<i64> {
        let element = probe_result.read.element.iter().map(|index| i64::from(*index));
        let inner = [probe_result.read.column, probe_result.read.row];
        element.chain(inner.into_iter().map(|step| i64::from(step.unwrap_or(0)))).collect()
    };
    let origin =
        seen.iter().find(|(probe_result, _)| steps(probe_result).iter().all(|step| *step == 0));
    // Without the first component, nothing tells the offset.
    let offset = origin?.1;
    // The dimensions, then columns and rows.
    let count = leaf.dims.len() + 2;
    let mut distances: Vec<Option<i64>> = vec![None; count];
    // A distance follows from a read that is away from the first component in that direction alone.
    for (at, distance) in distances.iter_mut().enumerate() {
        let alone = seen.iter().find(|(probe_result, _)| {
            let steps = steps(probe_result);
            steps.iter().enumerate().all(|(other, step)| (other == at) == (*step != 0))
        });
        if let Some((probe_result, byte)) = alone {
            let step = steps(probe_result)[at];
            if (byte - offset) % step != 0 {
                return None;
            }
            *distance = Some((byte - offset) / step);
        }
    }
    // All other reads have to lie where these distances put them.
    let holds = seen.iter().all(|(probe_result, byte)| {
        let steps = steps(probe_result);
        let away: Option<i64> = steps
            .iter()
            .zip(&distances)
            .map(|(step, distance)| if *step == 0 { Some(0) } else { distance.map(|d| d * step) })
            .sum();
        away.is_some_and(|away| offset + away == *byte)
    });
    holds.then(|| LinearPlacement {
        offset,
        strides: distances[..count - 2].to_vec(),
        column: distances[count - 2],
        row: distances[count - 1],
    })
}

/// Names a known error that gives exactly this placement.
fn known_cause(others: &OtherRules, leaf: &Leaf, place: &LinearPlacement) -> Option<String> {
    if let Some(naga) = &leaf.naga {
        let strides: Vec<i64> = naga.strides.iter().map(|stride| *stride as i64).collect();
        let known: Vec<i64> = place.strides.iter().copied().flatten().collect();
        if naga.offset as i64 == place.offset && strides == known {
            return Some("this is its offset in naga's layout".to_string());
        }
    }
    for (rules, leaves) in &others.layouts {
        if leaves.get(&leaf.path).is_some_and(|same| of_leaf(same, place) == *place) {
            return Some(format!("this is its offset in {}", rules.name()));
        }
    }
    None
}

/// Returns the block's members laid out by other rules.
fn under(block: &BlockLayout, rules: Rules) -> Option<BlockLayout> {
    // Without offsets of their own: the rules alone place the members.
    let members = block.members.iter().map(|member| Member {
        matrix_layout: member.row_major.then_some(MatrixLayout::Row),
        ..Member::unqualified(member.name.clone(), member.ty.clone(), member.span)
    });
    lay_out(&Block {
        name: block.name.clone(),
        instance: block.instance.clone(),
        space: block.space,
        rules,
        rules_declared: true,
        gathered: false,
        group: block.group,
        binding: block.binding,
        count: Vec::new(),
        matrix_layout: MatrixLayout::Column,
        members: members.collect(),
        opaque: Vec::new(),
        offset_order: OffsetOrder::Any,
        span: block.span,
        comment: Vec::new(),
    })
    .ok()
}
