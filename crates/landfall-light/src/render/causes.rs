//! The pixels of a picture that are NaN or infinite, by the operation and the members of blocks that
//! made them so; and the members that led to undefined operations.
//!
//! Runs such fragments again on the interpreter, one by one. Used by the report of
//! `landfall render`.

use std::cmp::{Reverse, min_by_key};

use super::{Draw, Prepared, RenderError, Renderer, Work};
use crate::Chosen;
use crate::bind::FragmentLights;
use crate::culling::LightSet;
use crate::picture::Picture;
use landfall_exec::harness::fragments::FragmentCause;
use landfall_exec::harness::origins::ReadValue;
use landfall_interp::Undefined;

/// The most pixels that are run again.
const MOST: usize = 256;

/// The pixels of a picture that are NaN or infinite.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NonFinitePixels {
    /// The pixels that were run again: all of them, or some spread evenly over them.
    pub examined: usize,
    /// By cause, the most frequent first.
    pub causes: Vec<PixelsByCause>,
}

/// The pixels with one cause.
#[derive(Clone, Debug, PartialEq)]
pub struct PixelsByCause {
    /// The cause; `None` if the interpreter, with all lights, finds them finite.
    pub cause: Option<FragmentCause>,
    /// The number of pixels among those examined.
    pub pixels: usize,
    /// Column and row of the first of them, from the top left.
    pub first: [u32; 2],
}

impl Renderer {
    /// Returns why pixels of a picture of all fragments are NaN or infinite.
    ///
    /// # Errors
    /// More lights than slots, or a failure of the interpreter.
    pub fn non_finite(
        &self,
        work: &Work<'_>,
        picture: &Picture,
    ) -> Result<NonFinitePixels, RenderError> {
        let fragments = &work.frame.fragments;
        let is_odd = |pixel: u32| {
            let pixel = picture.pixels.get(pixel as usize);
            pixel.is_some_and(|channels| channels.iter().any(|c| !c.is_finite()))
        };
        let odd = fragments.iter().zip(0..).filter(|(fragment, _)| is_odd(fragment.pixel));
        let some = spread(odd.map(|(_, number)| number).collect());
        let mut found = NonFinitePixels { examined: some.len(), causes: Vec::new() };
        self.again(work, &some, |prepared, numbers| {
            let causes = self.shader.causes(&prepared.batch(work.limit))?;
            for (cause, number) in causes.into_iter().zip(numbers) {
                let pixel = fragments[*number as usize].pixel;
                let first = [pixel % work.frame.width, pixel / work.frame.width];
                let same = |known: &&mut PixelsByCause| known.cause == cause;
                match found.causes.iter_mut().find(same) {
                    Some(known) => {
                        known.pixels += 1;
                        known.first = min_by_key(known.first, first, |[x, y]| [*y, *x]);
                    }
                    None => found.causes.push(PixelsByCause { cause, pixels: 1, first }),
                }
            }
            Ok(())
        })?;
        found.causes.sort_by_key(|known| (Reverse(known.pixels), known.first[1]));
        Ok(found)
    }

    /// Returns the members of blocks that led to undefined operations of a picture, as far as some of
    /// its fragments meet them.
    ///
    /// # Errors
    /// More lights than slots, or a failure of the interpreter.
    pub fn undefined_origins(
        &self,
        work: &Work<'_>,
        undefined: &[Undefined],
    ) -> Result<Vec<Vec<ReadValue>>, RenderError> {
        let mut origins = vec![Vec::new(); undefined.len()];
        let all = (0..work.frame.fragments.len() as u32).collect();
        if !undefined.is_empty() {
            self.again(work, &spread(all), |prepared, _| {
                let batch = prepared.batch(work.limit);
                Ok(self.shader.add_origins(&batch, undefined, &mut origins)?)
            })?;
        }
        Ok(origins)
    }

    /// Prepares fragments with all lights, those of each material at once.
    fn again(
        &self,
        work: &Work<'_>,
        some: &[u32],
        mut run: impl FnMut(&Prepared, &[u32]) -> Result<(), RenderError>,
    ) -> Result<(), RenderError> {
        let lights = LightSet::all(&work.upload.lights);
        let [directional, point, spot] = [&lights.directional, &lights.point, &lights.spot];
        let lights = FragmentLights { ambient: true, directional, point, spot };
        let chosen = Chosen { all: &work.frame.fragments, numbers: some };
        for numbers in chosen.by_material(work.upload.materials.len()) {
            if !numbers.is_empty() {
                let draw = Draw { fragments: &numbers, lights, tiles: None };
                let same = Chosen { numbers: &numbers, ..chosen };
                run(&self.prepare(work, same, &draw)?, &numbers)?;
            }
        }
        Ok(())
    }
}

/// Returns at most [`MOST`] of some numbers, spread evenly, both ends among them.
fn spread(all: Vec<u32>) -> Vec<u32> {
    let some = all.len().min(MOST);
    (0..some).map(|nth| all[nth * (all.len() - 1) / (some - 1).max(1)]).collect()
}
