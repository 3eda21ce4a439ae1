//! Leaves as sets of elements: which of them another leaf has too, where each is, which bytes it
//! takes.
//!
//! Feeds [`super::leaves`].

use crate::layout::{Leaf, occupied};
use crate::shape::{ArrayLen, Type};

/// Elements that are looked at one by one before only patterns are compared.
pub(super) const MOST_ELEMENTS: u64 = 1 << 16;

/// Whether an array of that length has every element that one of the other length has.
pub(super) fn covers(new: &ArrayLen, old: &ArrayLen) -> bool {
    match (old, new) {
        (_, ArrayLen::Runtime) => true,
        (ArrayLen::Fixed(a), ArrayLen::Fixed(b)) => a <= b,
        (ArrayLen::Override(a), ArrayLen::Override(b)) => a == b,
        (ArrayLen::Runtime | ArrayLen::Override(_), ArrayLen::Fixed(_))
        | (ArrayLen::Fixed(_) | ArrayLen::Runtime, ArrayLen::Override(_)) => false,
    }
}

/// Elements that arrays of both lengths have; `None` for more than can be counted.
pub(super) fn common(a: &ArrayLen, b: &ArrayLen) -> Option<u64> {
    match (a, b) {
        (ArrayLen::Fixed(a), ArrayLen::Fixed(b)) => Some(u64::from(*a.min(b))),
        (ArrayLen::Fixed(n), ArrayLen::Runtime | ArrayLen::Override(_))
        | (ArrayLen::Runtime | ArrayLen::Override(_), ArrayLen::Fixed(n)) => Some(u64::from(*n)),
        (ArrayLen::Runtime | ArrayLen::Override(_), ArrayLen::Runtime | ArrayLen::Override(_)) => {
            None
        }
    }
}

/// Number of elements; `None` when the text does not say, or more than [`MOST_ELEMENTS`].
pub(super) fn count(leaf: &Leaf) -> Option<u64> {
    let product = leaf.dims.iter().try_fold(1u64, |product, len| match len {
        ArrayLen::Fixed(n) => product.checked_mul(u64::from(*n)),
        ArrayLen::Runtime | ArrayLen::Override(_) => None,
    });
    product.filter(|count| *count <= MOST_ELEMENTS)
}

/// Where each element is that is not also one of an array with those lengths; all of them
/// without. Only for leaves that [`count`] counts.
pub(super) fn places(leaf: &Leaf, beyond: Option<&[ArrayLen]>) -> Vec<u64> {
    let mut places = vec![(leaf.offset.unwrap_or(0), beyond.is_none())];
    for (i, (len, stride)) in leaf.dims.iter().zip(&leaf.strides).enumerate() {
        let ArrayLen::Fixed(n) = len else { continue };
        let inside = match beyond.and_then(|dims| dims.get(i)) {
            Some(ArrayLen::Fixed(n)) => u64::from(*n),
            Some(ArrayLen::Runtime | ArrayLen::Override(_)) | None => u64::MAX,
        };
        let each = |(at, out): (u64, bool)| {
            (0..u64::from(*n)).map(move |k| (at + k * stride, out || k >= inside))
        };
        places = places.into_iter().flat_map(each).collect();
    }
    places.into_iter().filter(|(_, out)| *out).map(|(at, _)| at).collect()
}

/// Whether one element of the one holds what one of the other holds.
pub(super) fn same_kind(a: &Leaf, b: &Leaf) -> bool {
    a.ty == b.ty && a.matrix_stride == b.matrix_stride && a.row_major == b.row_major
}

/// Whether every element of the old leaf is one of the new one, at its place and of its kind.
pub(super) fn contains(new: &Leaf, old: &Leaf) -> bool {
    if new.offset != old.offset || !same_kind(new, old) {
        return false;
    }
    let (a, b) = (plain(old), plain(new));
    a.is_empty()
        || a.len() == b.len() && a.iter().zip(&b).all(|((n, s), (m, t))| s == t && covers(m, n))
}

/// Whether both have the same elements, at the same places and of one kind.
pub(super) fn same(new: &Leaf, old: &Leaf) -> bool {
    new.offset == old.offset && same_kind(new, old) && plain(old) == plain(new)
}

/// Dimensions and strides with what makes no difference taken out: a dimension of one element,
/// and two that are as good as one (`[2][3]` with strides 48 and 16 is `[6]` with 16).
fn plain(leaf: &Leaf) -> Vec<(ArrayLen, u64)> {
    let mut dims: Vec<(ArrayLen, u64)> = Vec::new();
    for (len, stride) in leaf.dims.iter().zip(&leaf.strides) {
        if *len == ArrayLen::Fixed(1) {
            continue;
        }
        if let (Some((outer, outer_stride)), ArrayLen::Fixed(n)) = (dims.last_mut(), len) {
            if *outer_stride == stride.saturating_mul(u64::from(*n)) {
                let merged = match outer {
                    ArrayLen::Fixed(m) => m.checked_mul(*n).map(ArrayLen::Fixed),
                    ArrayLen::Runtime => Some(ArrayLen::Runtime),
                    ArrayLen::Override(_) => None,
                };
                if let Some(merged) = merged {
                    (*outer, *outer_stride) = (merged, *stride);
                    continue;
                }
            }
        }
        dims.push((len.clone(), *stride));
    }
    dims
}

/// The bytes that hold components of the element at that place: first byte and number.
pub(super) fn bytes(leaf: &Leaf, at: u64) -> Vec<(u64, u64)> {
    match (&leaf.ty, leaf.matrix_stride) {
        (Type::Matrix { scalar, columns, rows }, Some(stride)) => {
            let (vectors, parts) = if leaf.row_major { (rows, columns) } else { (columns, rows) };
            let each = u64::from(*parts) * u64::from(scalar.width);
            (0..u64::from(*vectors)).map(|v| (at + v * stride, each)).collect()
        }
        _ => vec![(at, occupied(&leaf.ty))],
    }
}
