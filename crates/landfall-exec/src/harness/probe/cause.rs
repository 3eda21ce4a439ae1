//! What a reader must have taken for the layout, when it reads other bytes than expected.
//!
//! Fits offset and strides to the bytes a leaf was read from, and compares the fit with
//! what other rules, other orders and naga would give.

use super::judge::{Got, Sighting};
use landfall_layout::layout::{BlockLayout, Leaf, lay_out};
use landfall_layout::shape::{Block, Majorness, Member, OffsetOrder, Rules};

/// Where a reader takes a leaf to be.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Place {
    offset: i64,
    /// Distance of elements for each dimension; `None` where only one element was read.
    strides: Vec<Option<i64>>,
    column: Option<i64>,
    row: Option<i64>,
}

/// The likely cause of what one leaf's sightings say, in words; `None` when nothing fits.
pub fn cause(block: &BlockLayout, expected: &Leaf, sightings: &[&Sighting]) -> Option<String> {
    let place = fit(expected, sightings)?;
    let meant = of_leaf(expected, &place);
    if place == meant {
        return None;
    }
    let mut parts = Vec::new();
    if let Some(words) = known(block, expected, &place) {
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
        parts.push(format!("the array stride{which} is taken as {got} instead of {want}"));
    }
    if (place.column, place.row) == (meant.row, meant.column) && place.column != place.row {
        parts.push("rows and columns are taken for one another".to_string());
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

/// A leaf's own place, with as many steps known as in the other.
fn of_leaf(leaf: &Leaf, like: &Place) -> Place {
    let width = leaf.size.map_or(4, |_| component_width(leaf));
    let matrix = leaf.matrix_stride.map(|stride| stride as i64);
    let (column, row) = match (matrix, leaf.row_major) {
        (Some(stride), false) => (Some(stride), Some(width)),
        (Some(stride), true) => (Some(width), Some(stride)),
        (None, _) => (None, Some(width)),
    };
    let strides = leaf.strides.iter().map(|stride| *stride as i64);
    Place {
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

/// The linear place that all sightings agree with.
fn fit(leaf: &Leaf, sightings: &[&Sighting]) -> Option<Place> {
    let seen: Vec<(&Sighting, i64)> = sightings
        .iter()
        .filter_map(|sighting| match sighting.got {
            Got::Byte(byte) => Some((*sighting, byte as i64)),
            Got::Other(_) => None,
        })
        .collect();
    let steps = |sighting: &Sighting| -> Vec<i64> {
        let element = sighting.read.element.iter().map(|index| i64::from(*index));
        let inner = [sighting.read.column, sighting.read.row];
        element.chain(inner.into_iter().map(|step| i64::from(step.unwrap_or(0)))).collect()
    };
    let origin = seen.iter().find(|(sighting, _)| steps(sighting).iter().all(|step| *step == 0));
    let offset = origin?.1;
    let count = leaf.dims.len() + 2;
    let mut distances: Vec<Option<i64>> = vec![None; count];
    for (at, distance) in distances.iter_mut().enumerate() {
        let alone = seen.iter().find(|(sighting, _)| {
            let steps = steps(sighting);
            steps.iter().enumerate().all(|(other, step)| (other == at) == (*step != 0))
        });
        if let Some((sighting, byte)) = alone {
            let step = steps(sighting)[at];
            if (byte - offset) % step != 0 {
                return None;
            }
            *distance = Some((byte - offset) / step);
        }
    }
    let holds = seen.iter().all(|(sighting, byte)| {
        let steps = steps(sighting);
        let away: Option<i64> = steps
            .iter()
            .zip(&distances)
            .map(|(step, distance)| if *step == 0 { Some(0) } else { distance.map(|d| d * step) })
            .sum();
        away.is_some_and(|away| offset + away == *byte)
    });
    holds.then(|| Place {
        offset,
        strides: distances[..count - 2].to_vec(),
        column: distances[count - 2],
        row: distances[count - 1],
    })
}

/// A known way to get it wrong that gives just this place.
fn known(block: &BlockLayout, leaf: &Leaf, place: &Place) -> Option<String> {
    if let Some(naga) = &leaf.naga {
        let strides: Vec<i64> = naga.strides.iter().map(|stride| *stride as i64).collect();
        let known: Vec<i64> = place.strides.iter().copied().flatten().collect();
        if naga.offset as i64 == place.offset && strides == known {
            return Some("this is where naga puts it".to_string());
        }
    }
    for rules in [Rules::Std140, Rules::Std430, Rules::Scalar] {
        if rules == block.rules {
            continue;
        }
        let Some(other) = under(block, rules) else { continue };
        let same = other.leaves.iter().find(|other| other.path == leaf.path);
        if same.is_some_and(|same| of_leaf(same, place) == *place) {
            return Some(format!("this is its place in {}", rules.name()));
        }
    }
    None
}

/// The block's members laid out by other rules.
fn under(block: &BlockLayout, rules: Rules) -> Option<BlockLayout> {
    let members = block.members.iter().map(|member| Member {
        majorness: member.row_major.then_some(Majorness::Row),
        ..Member::plain(member.name.clone(), member.ty.clone(), member.span)
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
        majorness: Majorness::Column,
        members: members.collect(),
        opaque: Vec::new(),
        offset_order: OffsetOrder::Any,
        span: block.span,
        comment: Vec::new(),
    })
    .ok()
}
