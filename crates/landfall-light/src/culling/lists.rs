//! The light lists of tiles as buffers, for shaders that look up their lights.

use super::bound::{Bounded, Kind};
use super::options::Division;
use super::region::Divided;
use crate::Frame;
use crate::plan::TileLists;

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
