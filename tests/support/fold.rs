//! Folds OpenGL's one-by-one listing of active variables back into patterns.
//! `driver` feeds it; it yields rows of `leaf`.
//!
//! OpenGL lists each element of an array of structures, and each inner array
//! of an array of arrays, under its own name. Every element must lie where
//! the pattern says, or the fold is refused.

use std::collections::HashMap;

use super::leaf::OracleLeaf;

/// One active variable as the driver lists it.
#[derive(Clone, Debug)]
pub struct Active {
    /// `data[1].w[0]`, without the block's name.
    pub name: String,
    pub ty: String,
    pub offset: u64,
    /// Length of an innermost array; `None` when runtime-sized, 1 for others.
    pub array_size: Option<u64>,
    /// Zero for what is no array.
    pub array_stride: u64,
    pub matrix_stride: Option<u64>,
    pub row_major: bool,
    /// For a buffer variable whose top-level member is an array of aggregates:
    /// that array's length and stride. OpenGL lists only its first element.
    pub top_level: Option<(Option<u64>, u64)>,
}

/// An active variable and its indices, outermost first.
type Element<'a> = (Vec<u64>, &'a Active);

/// The patterns in order of their first element.
pub fn fold(actives: &[Active]) -> Result<Vec<OracleLeaf>, String> {
    let mut patterns: Vec<(String, Vec<Element<'_>>)> = Vec::new();
    let mut places = HashMap::new();
    for active in actives {
        let (pattern, indices) = pattern(active)?;
        let place = *places.entry(pattern.clone()).or_insert_with(|| {
            patterns.push((pattern, Vec::new()));
            patterns.len() - 1
        });
        patterns[place].1.push((indices, active));
    }
    let mut leaves: Vec<OracleLeaf> = Vec::with_capacity(patterns.len());
    for (path, elements) in &patterns {
        leaves.push(leaf(path, elements)?);
    }
    Ok(leaves)
}

/// `data[1].w[0]` is `data[].w[]` at [1]; the last index of an array that is
/// listed as a whole is not part of the indices.
fn pattern(active: &Active) -> Result<(String, Vec<u64>), String> {
    let whole = active.array_stride > 0;
    let name = if whole {
        active
            .name
            .strip_suffix("[0]")
            .ok_or_else(|| format!("an array listed as `{}`, without its [0]", active.name))?
    } else {
        active.name.as_str()
    };
    let mut path = String::new();
    let mut indices = Vec::new();
    let mut rest = name;
    while let Some((head, tail)) = rest.split_once('[') {
        let (index, tail) =
            tail.split_once(']').ok_or_else(|| format!("no closing bracket in `{name}`"))?;
        indices.push(index.parse().map_err(|_| format!("no index in `{name}`"))?);
        path.push_str(head);
        path.push_str("[]");
        rest = tail;
    }
    path.push_str(rest);
    if whole {
        path.push_str("[]");
    }
    Ok((path, indices))
}

fn leaf(path: &str, elements: &[Element<'_>]) -> Result<OracleLeaf, String> {
    let (zero, first) = elements
        .iter()
        .find(|(indices, _)| indices.iter().all(|&i| i == 0))
        .ok_or_else(|| format!("`{path}` has no element zero"))?;
    let mut lengths = vec![1u64; zero.len()];
    for (indices, _) in elements {
        for (length, &index) in lengths.iter_mut().zip(indices) {
            *length = (*length).max(index + 1);
        }
    }
    if lengths.iter().product::<u64>() != elements.len() as u64 {
        return Err(format!("`{path}` is {lengths:?} but {} elements are listed", elements.len()));
    }
    let mut strides = Vec::with_capacity(lengths.len() + 1);
    for dim in 0..lengths.len() {
        let second = elements.iter().find(|(indices, _)| {
            indices.iter().enumerate().all(|(at, &index)| index == u64::from(at == dim))
        });
        let stride = second.map(|(_, active)| {
            active
                .offset
                .checked_sub(first.offset)
                .ok_or_else(|| format!("`{path}`: element 1 lies before element 0"))
        });
        strides.push(stride.transpose()?);
    }
    for (indices, active) in elements {
        let along: u64 =
            indices.iter().zip(&strides).map(|(index, stride)| index * stride.unwrap_or(0)).sum();
        let same = active.offset == first.offset + along
            && active.array_stride == first.array_stride
            && active.array_size == first.array_size
            && active.matrix_stride == first.matrix_stride
            && active.row_major == first.row_major
            && active.ty == first.ty;
        if !same {
            return Err(format!("`{}` is not laid out as `{path}` says: {active:?}", active.name));
        }
    }
    let mut dims: Vec<Option<u64>> = lengths.into_iter().map(Some).collect();
    if let (Some((length, stride)), Some(dim)) = (first.top_level, dims.first_mut()) {
        *dim = length;
        strides[0] = Some(stride);
    }
    if first.array_stride > 0 {
        dims.push(first.array_size);
        strides.push(Some(first.array_stride));
    }
    Ok(OracleLeaf {
        path: path.to_owned(),
        ty: first.ty.clone(),
        offset: first.offset,
        dims,
        strides,
        matrix_stride: first.matrix_stride,
        row_major: first.row_major,
    })
}
