//! What a change does to bytes, worked out from an oracle's offsets and nothing else: every
//! element of every array, each with its bytes, before and after.
//!
//! Written from the definition of the classes, without a look at `src/diff`.

use std::collections::BTreeMap;

use crate::support::leaf::{OracleBlock, OracleLeaf};

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Naive {
    /// Every element is where it was, under its old name.
    Same,
    /// Every element is where it was, some under another name.
    Renamed,
    /// Every old element is read as it was written; there are new ones besides.
    Added,
    /// Some old element is not read, or not from where it was written, or as something else; or a
    /// new one reads its bytes.
    Misread,
}

/// One element: where it is, and what the shader takes its bytes for.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Element {
    offset: u64,
    ty: String,
    /// Matrix stride and whether by rows.
    matrix: Option<(u64, bool)>,
}

/// Elements of a runtime-sized array that are looked at.
const RUNTIME: u64 = 3;

pub fn classify(old: &OracleBlock, new: &OracleBlock) -> Naive {
    let (before, after) = (elements(old), elements(new));
    let mut written: BTreeMap<u64, &str> = BTreeMap::new();
    for (path, element) in &before {
        for byte in bytes(element) {
            let taken = written.insert(byte, path);
            assert!(taken.is_none(), "byte {byte} of `{path}` is also of {taken:?}");
        }
    }
    let mut worst = Naive::Same;
    let mut heirs: Vec<&String> = Vec::new();
    for (path, element) in &before {
        let found = match after.get(path) {
            Some(now) if now == element => Naive::Same,
            Some(_) => Naive::Misread,
            None => match after.iter().find(|(_, other)| *other == element) {
                Some((heir, _)) if !before.contains_key(heir) => {
                    heirs.push(heir);
                    Naive::Renamed
                }
                Some(_) | None => Naive::Misread,
            },
        };
        worst = worst.max(found);
    }
    for (path, element) in &after {
        if before.contains_key(path) || heirs.contains(&path) {
            continue;
        }
        let reads_old = bytes(element).iter().any(|byte| written.contains_key(byte));
        worst = worst.max(if reads_old { Naive::Misread } else { Naive::Added });
    }
    worst
}

fn elements(block: &OracleBlock) -> BTreeMap<String, Element> {
    block.leaves.iter().flat_map(of_leaf).collect()
}

fn of_leaf(leaf: &OracleLeaf) -> Vec<(String, Element)> {
    let mut found = vec![(leaf.path.clone(), leaf.offset)];
    for (length, stride) in leaf.dims.iter().zip(&leaf.strides) {
        let stride = stride.expect("SPIR-V has a stride for every array");
        let each = |(path, offset): &(String, u64)| {
            let (path, offset) = (path.clone(), *offset);
            (0..length.unwrap_or(RUNTIME))
                .map(move |i| (path.replacen("[]", &format!("[{i}]"), 1), offset + i * stride))
        };
        found = found.iter().flat_map(each).collect();
    }
    let element = |offset| Element {
        offset,
        ty: leaf.ty.clone(),
        matrix: leaf.matrix_stride.map(|stride| (stride, leaf.row_major)),
    };
    found.into_iter().map(|(path, offset)| (path, element(offset))).collect()
}

/// The bytes an element's components are in: `dmat2x3` is two columns of three doubles, or by rows
/// three rows of two.
fn bytes(element: &Element) -> Vec<u64> {
    let (width, rest) = component(&element.ty);
    let (columns, rows): (u64, u64) = if let Some(vector) = rest.strip_prefix("vec") {
        (1, vector.parse().expect("vec2 to vec4"))
    } else if let Some(matrix) = rest.strip_prefix("mat") {
        let (columns, rows) = matrix.split_once('x').unwrap_or((matrix, matrix));
        (columns.parse().expect("mat2 to mat4"), rows.parse().expect("mat2 to mat4"))
    } else {
        (1, 1)
    };
    let at = |column: u64, row: u64| match element.matrix {
        None => element.offset + row * width,
        Some((stride, false)) => element.offset + column * stride + row * width,
        Some((stride, true)) => element.offset + row * stride + column * width,
    };
    let places = (0..columns).flat_map(|c| (0..rows).map(move |r| (c, r)));
    places.flat_map(|(c, r)| (0..width).map(move |b| at(c, r) + b)).collect()
}

/// Bytes of a component, and the type's word without its prefix.
fn component(ty: &str) -> (u64, &str) {
    let scalars = [
        ("float", 4),
        ("int", 4),
        ("uint", 4),
        ("double", 8),
        ("int64_t", 8),
        ("uint64_t", 8),
        ("float16_t", 2),
        ("int16_t", 2),
        ("uint16_t", 2),
        ("int8_t", 1),
        ("uint8_t", 1),
    ];
    if let Some((_, width)) = scalars.iter().find(|(name, _)| *name == ty) {
        return (*width, "");
    }
    let prefixes = [
        ("i64", 8),
        ("u64", 8),
        ("f16", 2),
        ("i16", 2),
        ("u16", 2),
        ("i8", 1),
        ("u8", 1),
        ("d", 8),
        ("i", 4),
        ("u", 4),
        ("", 4),
    ];
    let found = prefixes.iter().find_map(|(prefix, width)| {
        let rest = ty.strip_prefix(prefix)?;
        (rest.starts_with("vec") || rest.starts_with("mat")).then_some((*width, rest))
    });
    found.unwrap_or_else(|| panic!("{ty} is no type of these blocks"))
}
