//! The light lists of tiles as buffers, for shaders that look up their lights.

use super::{LightSet, Plan, TileLists};
use crate::scene::Kind;

impl TileLists {
    /// Lists for that many tiles, each without lights.
    pub(crate) fn empty(size: u32, columns: u32, height: u32, tiles: usize) -> TileLists {
        TileLists {
            size,
            columns,
            height,
            tiles: vec![[0; 2]; tiles],
            spots: vec![[0; 2]; tiles],
            directional: vec![0; tiles],
            indices: Vec::new(),
        }
    }

    /// One tile that covers every picture, with all of some lights.
    pub(crate) fn whole(lights: &LightSet, height: u32) -> TileLists {
        let mut lists = TileLists::empty(u32::MAX, 1, height, 1);
        lists.set(0, |kind| lights.of(kind).iter().copied());
        lists.close();
        lists
    }

    pub(crate) fn set<I: Iterator<Item = u32>>(&mut self, tile: usize, of: impl Fn(Kind) -> I) {
        if tile >= self.tiles.len() {
            return;
        }
        // A bit mask, since most scenes have few directional lights. A number past 31 has no bit:
        // every tile keeps it.
        let bits = of(Kind::Directional).filter(|n| *n < 32);
        self.directional[tile] = bits.fold(0, |mask, n| mask | 1 << n);
        self.tiles[tile] = self.listed(of(Kind::Point));
        self.spots[tile] = self.listed(of(Kind::Spot));
    }

    fn listed(&mut self, lights: impl Iterator<Item = u32>) -> [u32; 2] {
        let first = self.indices.len();
        self.indices.extend(lights);
        [first as u32, (self.indices.len() - first) as u32]
    }

    pub(crate) fn close(&mut self) {
        if self.indices.is_empty() {
            // An empty buffer cannot be bound.
            self.indices.push(0);
        }
    }

    /// Returns the bytes of the blocks `LandfallTileBlock` and `LandfallIndexBlock` of a shader
    /// that [`listed`](crate::listed::listed) wrote.
    pub fn bytes(&self) -> [Vec<u8>; 2] {
        // The header has the size, the columns and the height in pixels; then five numbers a tile.
        // A shader turns gl_FragCoord.y, which counts from below, by the height.
        let mut tiles = vec![self.size, self.columns, self.height];
        for (tile, [first, count]) in self.tiles.iter().enumerate() {
            let [spot, spots] = self.spots[tile];
            tiles.extend([*first, *count, spot, spots, self.directional[tile]]);
        }
        let bytes = |numbers: &[u32]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
        [bytes(&tiles), bytes(&self.indices)]
    }
}

impl Plan {
    /// Returns the light lists of its tiles; without tiles, those of a single one, for a picture
    /// of that height.
    ///
    /// # Errors
    /// The reason why lists of tiles do not say which lights each fragment has.
    pub fn tile_lists(&self, height: u32) -> Result<TileLists, String> {
        match (&self.tiles, &self.draws[..]) {
            (Some(lists), _) => Ok(lists.clone()),
            (None, []) => Ok(TileLists::whole(&LightSet::default(), height)),
            (None, [draw]) => Ok(TileLists::whole(&draw.lights, height)),
            (None, _) => Err("draws without tiles have no lists".to_string()),
        }
    }
}
