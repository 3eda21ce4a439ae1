//! Leaves as sets of elements: common elements, their offsets, and their bytes.
//!
//! Used by [`super::leaves`].

use crate::layout::measure::{fixed, fixed_elements};
use crate::layout::{Leaf, occupied};
use crate::shape::{ArrayLen, Type};

/// The most elements compared one by one; of larger leaves only the patterns are compared.
pub(super) const MAX_ELEMENTS: u64 = 1 << 16;

/// Whether an array of length `new` has every element of one of length `old`.
pub(super) fn covers(new: &ArrayLen, old: &ArrayLen) -> bool {
    match (old, new) {
        // A length by an override is unknown: it is only known to cover itself and no more than
        // itself.
        (_, ArrayLen::Runtime) => true,
        (ArrayLen::Fixed(a), ArrayLen::Fixed(b)) => a <= b,
        (ArrayLen::Override(a), ArrayLen::Override(b)) => a == b,
        (ArrayLen::Runtime | ArrayLen::Override(_), ArrayLen::Fixed(_))
        | (ArrayLen::Fixed(_) | ArrayLen::Runtime, ArrayLen::Override(_)) => false,
    }
}

/// The number of elements common to arrays of both lengths; `None` if it is unbounded.
pub(super) fn common(a: &ArrayLen, b: &ArrayLen) -> Option<u64> {
    match (fixed(a), fixed(b)) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (a, b) => a.or(b),
    }
}

/// The number of elements; `None` if unspecified or more than [`MAX_ELEMENTS`].
pub(super) fn count(leaf: &Leaf) -> Option<u64> {
    fixed_elements(&leaf.dims).filter(|count| *count <= MAX_ELEMENTS)
}

/// The offsets of a leaf's elements, without those inside the lengths `beyond` if given. Only for
/// leaves that [`count`] counts.
pub(super) fn places(leaf: &Leaf, beyond: Option<&[ArrayLen]>) -> Vec<u64> {
    // An offset, and whether some index on the way to it is past `beyond`.
    let mut places = vec![(leaf.offset.unwrap_or(0), beyond.is_none())];
    for (i, (len, stride)) in leaf.dims.iter().zip(&leaf.strides).enumerate() {
        let Some(n) = fixed(len) else { continue };
        let inside = beyond.and_then(|dims| fixed(dims.get(i)?)).unwrap_or(u64::MAX);
        let each =
            |(at, out): (u64, bool)| (0..n).map(move |k| (at + k * stride, out || k >= inside));
        // Each dimension multiplies the elements; `count` limits them to 65,536.
        places = places.into_iter().flat_map(each).collect();
    }
    places.into_iter().filter(|(_, out)| *out).map(|(at, _)| at).collect()
}

/// Whether elements of both leaves have the same type.
pub(super) fn same_kind(a: &Leaf, b: &Leaf) -> bool {
    a.ty == b.ty && a.matrix_stride == b.matrix_stride && a.row_major == b.row_major
}

/// Whether the new leaf has every element of the old one, at the same offset with the same type.
pub(super) fn contains(new: &Leaf, old: &Leaf) -> bool {
    if new.offset != old.offset || !same_kind(new, old) {
        return false;
    }
    let (a, b) = (normalised(old), normalised(new));
    // A single element, or an equal number of dimensions with equal strides, none of them shorter.
    a.is_empty()
        || a.len() == b.len() && a.iter().zip(&b).all(|((n, s), (m, t))| s == t && covers(m, n))
}

/// Whether both leaves have the same elements, at the same offsets with the same type.
pub(super) fn same(new: &Leaf, old: &Leaf) -> bool {
    new.offset == old.offset && same_kind(new, old) && normalised(old) == normalised(new)
}

/// Normalises dimensions and strides: drops dimensions of one element, and merges contiguous ones
/// (`[2][3]` with strides 48 and 16 is `[6]` with 16).
fn normalised(leaf: &Leaf) -> Vec<(ArrayLen, u64)> {
    let mut dims: Vec<(ArrayLen, u64)> = Vec::new();
    for (len, stride) in leaf.dims.iter().zip(&leaf.strides) {
        if *len == ArrayLen::Fixed(1) {
            continue;
        }
        if let (Some((outer, outer_stride)), ArrayLen::Fixed(n)) = (dims.last_mut(), len) {
            // The outer stride is that of as many inner elements: no gap between the rows.
            if *outer_stride == stride.saturating_mul(u64::from(*n)) {
                let merged = match outer {
                    ArrayLen::Fixed(m) => m.checked_mul(*n).map(ArrayLen::Fixed),
                    ArrayLen::Runtime => Some(ArrayLen::Runtime),
                    // A product of a name and a number has no name.
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

/// The byte ranges of an element's components, as offset and length.
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
