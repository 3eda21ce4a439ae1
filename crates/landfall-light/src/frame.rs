//! The fragments of a scene's picture, as a rasteriser passes them to a fragment shader.
//!
//! Computed in `f64` from a [`Scene`] and rounded once, so that every backend and the reference
//! start from the same bits and every picture has the same edges. `vertices` transforms corners to
//! view and lighting space, `raster` finds the triangle at each pixel.

mod raster;
mod vertices;

use std::borrow::Cow;
use std::convert::Infallible;

use super::Scene;
use landfall_ir::threads;
use vertices::Corners;

/// The fragments that a thread lights at a time.
pub const AT_A_TIME: usize = 2048;

/// The indices that a thread writes at a time.
const NUMBERS: usize = 1 << 16;

#[derive(Clone, Debug, PartialEq, Default)]
pub struct Frame {
    /// The width in pixels.
    pub width: u32,
    /// The height in pixels.
    pub height: u32,
    /// The fragments, in pixel order from the top; other pixels show the background.
    pub fragments: Vec<Fragment>,
}

/// The surface point at one pixel, in lighting space.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Zeroable)]
pub struct Fragment {
    /// The pixel: `row * width + column`.
    pub pixel: u32,
    pub material: u32,
    pub object: u32,
    pub position: [f32; 3],
    /// The interpolated normal, of any length.
    pub normal: [f32; 3],
    pub uv: [f32; 2],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct FrameOptions {
    pub normals: VertexNormals,
}

/// The treatment of a mesh's normals by a vertex shader, before interpolation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum VertexNormals {
    /// Times the inverse transpose of the upper 3 by 3 of the transform: correct, of any length.
    #[default]
    Transformed,
    /// The same, then normalised.
    Unit,
    /// `normalize(transpose(inverse(m)) * vec4(normal, 0)).xyz`: a published bug. The fourth
    /// component is meaningless but counts in the length, so corners get different weights and the
    /// interpolated normal bends.
    UnitOfFour,
}

/// Some fragments of a frame, in an order of their own.
#[derive(Clone, Copy, Debug)]
pub struct Chosen<'a> {
    pub all: &'a [Fragment],
    /// The indices of those chosen, which exist.
    pub numbers: &'a [u32],
}

impl<'a> Chosen<'a> {
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &'a Fragment> + use<'a> {
        let all = self.all;
        self.numbers.iter().map(|number| &all[*number as usize])
    }

    /// Returns the indices of those chosen for each material in use, in their order.
    pub(crate) fn by_material(&self, materials: usize) -> Vec<Cow<'a, [u32]>> {
        let exist = |number: &u32| (*number as usize) < self.all.len();
        // Most scenes have one material: nothing is copied.
        if materials == 1 && self.numbers.iter().all(exist) {
            return vec![Cow::Borrowed(self.numbers)];
        }
        let mut each = vec![Vec::new(); materials];
        for number in self.numbers.iter().filter(|number| exist(number)) {
            each[self.all[*number as usize].material as usize].push(*number);
        }
        each.into_iter().map(Cow::Owned).collect()
    }
}

impl Frame {
    pub fn numbers(&self) -> Vec<u32> {
        let mut numbers = bytemuck::zeroed_vec(self.fragments.len());
        // Millions of numbers are written by all threads, each into its own pages.
        threads::each(numbers.chunks_mut(NUMBERS).zip(0..), |(part, nth)| {
            part.iter_mut().zip(nth * NUMBERS as u32..).for_each(|(to, number)| *to = number);
        });
        numbers
    }

    /// Rasterises a scene.
    ///
    /// A pixel shows the nearest triangle at its centre, front or back, between the near and the
    /// far plane; the first drawn of two equally near; of two triangles sharing an edge, the one to
    /// its right or below it has the centres on it. Attributes are interpolated with perspective.
    /// All of it is in `f64` and the same on any number of threads.
    pub fn new(scene: &Scene, options: &FrameOptions) -> Frame {
        let Ok((frame, ())) = Frame::beside(scene, options, || Ok::<(), Infallible>(()));
        frame
    }

    /// The same, and the result of `other`, which the calling thread runs while others rasterise.
    ///
    /// # Errors
    /// That of `other`; rasterising ends early.
    pub fn beside<O, E>(
        scene: &Scene,
        options: &FrameOptions,
        other: impl FnOnce() -> Result<O, E>,
    ) -> Result<(Frame, O), E> {
        let [width, height] = scene.size;
        let corners = Corners::new(scene, options.normals);
        let (fragments, other) = raster::fragments(scene, &corners, other)?;
        Ok((Frame { width, height, fragments }, other))
    }
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;

    #[test]
    fn fragments_are_grouped_by_material_in_their_order() {
        let of = |material| Fragment { material, ..Fragment::zeroed() };
        let all = [of(1), of(0), of(1), of(2)];
        // The last one does not exist.
        let chosen = Chosen { all: &all, numbers: &[3, 2, 1, 0, 4] };
        assert_eq!(chosen.by_material(4), [vec![1], vec![2, 0], vec![3], vec![]]);
        let one = Chosen { all: &all[1..2], ..chosen };
        assert_eq!(Chosen { numbers: &[0, 0], ..one }.by_material(1), [vec![0, 0]]);
        assert_eq!(Chosen { numbers: &[0, 1], ..one }.by_material(1), [vec![0]]);
    }
}
