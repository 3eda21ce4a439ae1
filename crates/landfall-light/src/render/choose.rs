//! Times a plan on a sample of the fragments of a picture, beside all lights.
//!
//! The sample is whole tiles of the picture, spread over it, so that it costs what the picture
//! does, scaled.

use std::time::Duration;

use super::{RenderError, Renderer, Work};
use crate::Frame;
use crate::culling::{LightSet, Options, Plan, Whole};
use crate::picture::Picture;
use crate::shading_f32::Model;
use crate::splitmix64::SplitMix64;
use landfall_exec::backend::Backend;

/// The fewest fragments of a sample, and its part of a larger picture.
const FEWEST: usize = 512;
const PART: usize = 256;

/// The fragments that a shader is compiled with.
const WARM: usize = 64;

/// Runs work on a backend and returns its time.
pub type Timer<'t> = dyn FnMut(
        &mut dyn Backend,
        &mut dyn FnMut(&mut dyn Backend) -> Result<(), RenderError>,
    ) -> Result<((), Duration), RenderError>
    + 't;

/// Returns some fragments of a frame, which are in the order of its pixels: all of those in some
/// of its tiles of that side, each as likely as it has fragments.
fn sample(frame: &Frame, size: u32) -> Frame {
    let Frame { width, height, ref fragments } = *frame;
    let wanted = (fragments.len() / PART).max(FEWEST).min(fragments.len());
    let mut random = SplitMix64(0);
    let mut tiles: Vec<[u32; 2]> = Vec::new();
    let mut numbers: Vec<u32> = Vec::new();
    // A picture whose fragments are all in one tile has no other.
    for _ in 0..2 * wanted {
        if numbers.len() >= wanted {
            break;
        }
        let pixel = fragments[random.next_u64() as usize % fragments.len()].pixel;
        let tile = [pixel % width / size, pixel / width / size];
        if tiles.contains(&tile) {
            continue;
        }
        tiles.push(tile);
        let [left, top] = tile.map(|at| at * size);
        for row in top..(top + size).min(height) {
            // Fragments are sorted by pixel, so those of a row of the tile are neighbours.
            let before = |end: u32| fragments.partition_point(|f| f.pixel < row * width + end);
            let (from, to) = (before(left), before((left + size).min(width)));
            numbers.extend(from as u32..to as u32);
        }
    }
    numbers.sort_unstable();
    numbers.dedup();
    let fragments = numbers.iter().map(|number| fragments[*number as usize]).collect();
    Frame { width, height, fragments }
}

pub struct Trial<'t> {
    whole: &'t Renderer,
    work: &'t Work<'t>,
    frame: Frame,
}

impl<'t> Trial<'t> {
    /// Takes a sample of a picture in tiles of that side, for a shader with all lights.
    pub fn new(whole: &'t Renderer, work: &'t Work<'t>, size: u32) -> Trial<'t> {
        Trial { whole, work, frame: sample(work.frame, size) }
    }

    /// Returns the time of the whole picture with all lights.
    ///
    /// # Errors
    /// More lights than slots, or a failure of the backend.
    pub fn whole(
        &self,
        backend: &mut dyn Backend,
        time: &mut Timer<'_>,
    ) -> Result<Whole, RenderError> {
        let all = LightSet::all(&self.work.upload.lights);
        let lit = |frame: &Frame, backend: &mut dyn Backend| {
            let plan = Plan::all_lights(frame.fragments.len(), all.clone());
            render(self.whole, backend, &Work { frame, ..*self.work }, &plan)
        };
        // The first run compiles the shader, which is not to be timed.
        lit(&self.few(), backend)?;
        let ((), took) = time(backend, &mut |backend| lit(&self.frame, backend))?;
        let fragments = self.frame.fragments.len() as u64;
        Ok(Whole { time: self.scaled(took), fragments, measured: false })
    }

    pub fn plan(&self, model: &Model, options: &Options) -> Plan {
        let work = Work { frame: &self.frame, ..*self.work };
        self.whole.plan_only(&work, model, options)
    }

    /// Returns a plan of the sample, and the time of the whole picture by such a plan, its making
    /// included; it is not lit by a plan that leaves out too little.
    ///
    /// # Errors
    /// More lights than slots, or a failure of the backend.
    pub fn planned(
        &self,
        backend: &mut dyn Backend,
        (model, options): (&Model, &Options),
        time: &mut Timer<'_>,
    ) -> Result<(Plan, Duration), RenderError> {
        let mut plan = Plan::default();
        let work = Work { frame: &self.frame, ..*self.work };
        let ((), took) = time(backend, &mut |backend| {
            plan = self.plan(model, options);
            match plan.leaves_out_enough() {
                true => render(self.whole, backend, &work, &plan),
                false => Ok(()),
            }
        })?;
        Ok((plan, self.scaled(took)))
    }

    /// Returns the fragments that a shader is compiled with.
    fn few(&self) -> Frame {
        let few = self.frame.fragments.iter().take(WARM).copied();
        Frame { fragments: few.collect(), ..self.frame }
    }

    fn scaled(&self, took: Duration) -> Duration {
        let fragments = self.frame.fragments.len().max(1) as f64;
        took.mul_f64(self.work.frame.fragments.len() as f64 / fragments)
    }
}

/// Renders by a plan, without a picture: one of the size of the whole takes longer than its sample.
fn render(
    renderer: &Renderer,
    backend: &mut dyn Backend,
    work: &Work<'_>,
    plan: &Plan,
) -> Result<(), RenderError> {
    let none = Picture::default();
    renderer.render_plan_onto(none, backend, work, plan, &mut |_, _| {}).map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Fragment;

    #[test]
    fn a_sample_is_whole_tiles_and_a_part_of_the_picture() {
        let (width, height) = (640, 360);
        let pixels = (0..width * height).filter(|pixel| pixel % 3 > 0);
        let zero: Fragment = bytemuck::Zeroable::zeroed();
        let fragment = |pixel| Fragment { pixel, ..zero };
        let frame = Frame { width, height, fragments: pixels.map(fragment).collect() };
        let sample = sample(&frame, 8);
        let tile = |fragment: &Fragment| [fragment.pixel % width / 8, fragment.pixel / width / 8];
        let wanted = frame.fragments.len() / PART;
        let taken = sample.fragments.len();
        assert!((wanted..wanted + 64).contains(&taken), "{taken}");
        let mut tiles: Vec<[u32; 2]> = sample.fragments.iter().map(tile).collect();
        tiles.sort_unstable();
        tiles.dedup();
        let whole = frame.fragments.iter().filter(|f| tiles.binary_search(&tile(f)).is_ok());
        assert!(whole.eq(&sample.fragments));
        for frame in [Frame { fragments: Vec::new(), ..frame.clone() }, frame] {
            assert!(super::sample(&frame, 4096).fragments == frame.fragments);
        }
    }
}
