//! The pixels of a picture that are NaN or infinite, by the operation and the members of blocks
//! that made them so; and those in which undefined operations are met.
//!
//! Runs such fragments again on the interpreter, one by one. Used by the report of
//! `landfall render`.

use std::cmp::{Reverse, min_by_key};

use super::{Draw, Prepared, RenderError, Renderer, Work};
use crate::Chosen;
use crate::culling::LightSet;
use crate::picture::Picture;
use landfall_exec::harness::fragments::{FragmentCause, UndefinedInFragment};
use landfall_exec::harness::origins::ReadValue;
use landfall_interp::Undefined;

/// The most pixels that are run again.
const LIMIT: usize = 256;

/// The pixels of a picture that are NaN or infinite.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NonFinitePixels {
    /// The pixels that were run again: all of them, or some spread evenly over them.
    pub examined: usize,
    /// By cause, the most frequent first.
    pub causes: Vec<PixelsByCause>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct PixelsByCause {
    /// The cause; `None` if the interpreter, with all lights, finds them finite.
    pub cause: Option<FragmentCause>,
    /// The number of pixels among those examined.
    pub pixels: usize,
    /// Column and row of the first of them, from the top left.
    pub first: [u32; 2],
}

/// The pixels of a picture in which an undefined operation is met.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UndefinedPixels {
    /// The pixels that were run again: all of them, or some spread evenly.
    pub examined: usize,
    /// Their number among those.
    pub pixels: usize,
    /// Column and row of the first of them, from the top left; `None` if none of those examined is.
    pub first: Option<[u32; 2]>,
    /// The members of blocks that led there, in the first that was examined.
    pub from: Vec<ReadValue>,
}

impl UndefinedPixels {
    /// Returns their share of those that were run again.
    pub fn share(&self) -> f64 {
        self.pixels as f64 / self.examined.max(1) as f64
    }
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
                let first = place(work, *number);
                let same = |known: &&mut PixelsByCause| known.cause == cause;
                match found.causes.iter_mut().find(same) {
                    Some(known) => {
                        known.pixels += 1;
                        // The groups of materials are not in the order of pixels.
                        known.first = earlier(known.first, first);
                    }
                    None => found.causes.push(PixelsByCause { cause, pixels: 1, first }),
                }
            }
            Ok(())
        })?;
        // The most frequent first; of equal ones that which is higher in the picture.
        found.causes.sort_by_key(|known| (Reverse(known.pixels), known.first[1]));
        Ok(found)
    }

    /// Returns the pixels in which undefined operations of a picture are met.
    ///
    /// # Errors
    /// More lights than slots, or a failure of the interpreter.
    pub fn undefined(
        &self,
        work: &Work<'_>,
        undefined: &[Undefined],
    ) -> Result<Vec<UndefinedPixels>, RenderError> {
        if undefined.is_empty() {
            return Ok(Vec::new());
        }
        let some = spread((0..work.frame.fragments.len() as u32).collect());
        let none = UndefinedPixels { examined: some.len(), ..UndefinedPixels::default() };
        let mut found = vec![none; undefined.len()];
        self.again(work, &some, |prepared, numbers| {
            let met = self.shader.undefined(&prepared.batch(work.limit), undefined)?;
            for UndefinedInFragment { fragment, operation, from } in met {
                let at = place(work, numbers[fragment]);
                let known = &mut found[operation];
                known.pixels += 1;
                known.first = Some(known.first.map_or(at, |first| earlier(first, at)));
                if known.from.is_empty() {
                    known.from = from;
                }
            }
            Ok(())
        })?;
        Ok(found)
    }

    /// Prepares fragments with all lights, those of each material at once.
    fn again(
        &self,
        work: &Work<'_>,
        some: &[u32],
        mut run: impl FnMut(&Prepared, &[u32]) -> Result<(), RenderError>,
    ) -> Result<(), RenderError> {
        let lights = &LightSet::all(&work.upload.lights);
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

/// Returns the column and row of a fragment.
fn place(work: &Work<'_>, number: u32) -> [u32; 2] {
    let pixel = work.frame.fragments[number as usize].pixel;
    [pixel % work.frame.width, pixel / work.frame.width]
}

/// Returns the pixel that comes first by rows.
fn earlier(a: [u32; 2], b: [u32; 2]) -> [u32; 2] {
    min_by_key(a, b, |[x, y]| [*y, *x])
}

/// Returns at most [`LIMIT`] of some numbers, spread evenly, both ends among them.
fn spread(all: Vec<u32>) -> Vec<u32> {
    let some = all.len().min(LIMIT);
    (0..some).map(|nth| all[nth * (all.len() - 1) / (some - 1).max(1)]).collect()
}
