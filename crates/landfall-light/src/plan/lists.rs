//! The light lists of tiles as buffers, for shaders that look up their lights.

use super::{Plan, TileLists};

impl TileLists {
    pub(crate) fn resize(&mut self, tiles: usize) {
        self.tiles.resize(tiles, [0; 2]);
        self.spots.resize(tiles, [0; 2]);
        self.directional.resize(tiles, 0);
    }

    pub(crate) fn set(
        &mut self,
        tile: usize,
        directional: impl Iterator<Item = u32>,
        point: impl Iterator<Item = u32>,
        spot: impl Iterator<Item = u32>,
    ) {
        if tile >= self.tiles.len() {
            return;
        }
        // A bit mask, since most scenes have few directional lights. A number past 31 has no bit:
        // every tile keeps it.
        self.directional[tile] = directional.filter(|n| *n < 32).fold(0, |mask, n| mask | 1 << n);
        self.tiles[tile] = self.listed(point);
        self.spots[tile] = self.listed(spot);
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
    /// that [`listed`](crate::listed::listed) wrote, for a picture of that height.
    pub fn bytes(&self, height: u32) -> [Vec<u8>; 2] {
        // The header has the size, the columns and the height in pixels; then five numbers a tile.
        // A shader turns gl_FragCoord.y, which counts from below, by the height.
        let mut tiles = vec![self.size, self.columns, height];
        for (tile, [first, count]) in self.tiles.iter().enumerate() {
            let [spot, spots] = self.spots[tile];
            tiles.extend([*first, *count, spot, spots, self.directional[tile]]);
        }
        let bytes = |numbers: &[u32]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
        [bytes(&tiles), bytes(&self.indices)]
    }
}

impl Plan {
    /// Returns the light lists of its tiles; without tiles, those of a single one.
    ///
    /// # Errors
    /// The reason why lists of tiles do not say which lights each fragment has.
    pub fn tile_lists(&self) -> Result<TileLists, String> {
        match (&self.tiles, &self.draws[..]) {
            (Some(lists), _) => Ok(lists.clone()),
            (None, []) => Ok(TileLists::default().whole([].iter(), [].iter(), [].iter())),
            (None, [draw]) => {
                let lights = &draw.lights;
                let [directional, point, spot] = [&lights.directional, &lights.point, &lights.spot];
                Ok(TileLists::default().whole(directional.iter(), point.iter(), spot.iter()))
            }
            (None, _) => Err("draws without tiles have no lists".to_string()),
        }
    }
}

impl TileLists {
    fn whole<'l>(
        mut self,
        directional: impl Iterator<Item = &'l u32>,
        point: impl Iterator<Item = &'l u32>,
        spot: impl Iterator<Item = &'l u32>,
    ) -> TileLists {
        // One tile that covers every picture.
        (self.size, self.columns, self.rows) = (u32::MAX, 1, 1);
        self.resize(1);
        self.set(0, directional.copied(), point.copied(), spot.copied());
        self.close();
        self
    }
}
