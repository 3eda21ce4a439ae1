//! The light lists of the tiles of a divided frame.

use super::bound::Bounded;
use super::region::DividedFrame;
use crate::Frame;
use crate::plan::TileLists;

pub(super) fn tile_lists(
    frame: &Frame,
    divided: &DividedFrame,
    lights: &[Bounded],
    lists: &[Vec<u32>],
    size: u32,
) -> TileLists {
    // Tiles without a fragment keep empty lists: they have no cell, and a shader finds no light
    // there.
    let (columns, rows) = (frame.width.div_ceil(size), frame.height.div_ceil(size));
    let tiles = columns as usize * rows as usize;
    let mut all = TileLists::empty(size, columns, frame.height, tiles);
    for (cell, list) in divided.cells.iter().zip(lists) {
        let [column, row] = cell.key;
        let of = |kind| {
            let lights = list.iter().map(|&place| &lights[place as usize]);
            lights.filter(move |light| light.kind == kind).map(|light| light.number)
        };
        let tile = row as usize * columns as usize + column as usize;
        all.set(tile, of);
    }
    all.close();
    all
}
