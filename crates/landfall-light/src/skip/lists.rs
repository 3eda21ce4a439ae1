//! The lists of tiles as buffers: for shaders that find their lights themselves.

use super::bound::{Bounded, Kind};
use super::options::Division;
use super::region::Divided;
use crate::Frame;

/// Which point lights each tile of a frame has.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TileLists {
    /// Pixels along a tile's side.
    pub size: u32,
    /// Tiles in a row: tile `row * columns + column` holds the pixels from
    /// `(column * size, row * size)`, rows counted from the top.
    pub columns: u32,
    /// Rows of tiles.
    pub rows: u32,
    /// Of each tile, the first of its entries in `indices`, and how many they are.
    pub tiles: Vec<[u32; 2]>,
    /// Numbers of point lights, ascending in each tile. Never empty: no shader language knows
    /// an empty buffer.
    pub indices: Vec<u32>,
}

pub(super) fn tile_lists(
    frame: &Frame,
    divided: &Divided,
    lights: &[Bounded],
    lists: &[Vec<u32>],
    division: Division,
) -> Option<TileLists> {
    let size = match division {
        Division::Tiles { size } => size.max(1),
        Division::Whole | Division::Clusters { .. } => return None,
    };
    let (columns, rows) = (frame.width.div_ceil(size), frame.height.div_ceil(size));
    let mut tiles = vec![[0, 0]; columns as usize * rows as usize];
    let mut indices = Vec::new();
    for (cell, list) in divided.cells.iter().zip(lists) {
        let [column, row, _] = cell.key;
        let first = indices.len();
        let points = list.iter().map(|&place| &lights[place as usize]);
        indices.extend(points.filter(|l| l.kind == Kind::Point).map(|l| l.number));
        if let Some(tile) = tiles.get_mut(row as usize * columns as usize + column as usize) {
            *tile = [first as u32, (indices.len() - first) as u32];
        }
    }
    if indices.is_empty() {
        indices.push(0);
    }
    Some(TileLists { size, columns, rows, tiles, indices })
}
